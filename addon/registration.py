# SPDX-License-Identifier: GPL-3.0-or-later
"""How modules give Blender their classes, and functions that it shall call on its events."""
from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import bpy

Handlers: TypeAlias = Mapping[str, Callable[..., Any]]  # by the name of the list in bpy.app.handlers


def of_classes(*classes: type) -> tuple[Callable[[], None], Callable[[], None]]:
    """(register, unregister) of these classes."""
    return bpy.utils.register_classes_factory(classes)  # type: ignore[return-value]


def add_handlers(functions: Handlers) -> None:
    """Lets Blender call these functions."""
    for name, function in functions.items():
        getattr(bpy.app.handlers, name).append(function)


def remove_handlers(functions: Handlers) -> None:
    """Lets Blender no longer call these functions. Those that it does not call are passed over."""
    for name, function in functions.items():
        if function in getattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).remove(function)
