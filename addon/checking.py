# SPDX-License-Identifier: GPL-3.0-or-later
"""What the core says of an expression: whether it is one, what it means in words, and what is doubtful about it."""
from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass

import bpy

from . import core, expression_names, expression_words, known_names


@dataclass(frozen=True)
class Checked:
    """The findings about one expression. `error` is None for a sound one; `column` (from 1) is where the error is, if known."""

    side: str | None = None  # 'light' or 'view': at which end of a path the edit works
    told: str = ""  # the expression in words
    warnings: tuple[str, ...] = ()
    column: int | None = None
    error: str | None = None


@functools.lru_cache(maxsize=256)
def check(text: str, here: Iterable[str], language: str, is_layer: bool = False, elsewhere: frozenset[str] = frozenset()) -> Checked:
    """Checks the expression of an edit or of a layer. `here` are the names in the scene, `elsewhere` those that only the file has.
    Answers are kept, since panels are drawn many times a second."""
    absent = sorted(elsewhere & expression_names.names_in(text))
    try:
        module = core.load()
        found = (module.check_layer_expression if is_layer else module.check_expression)(text, [*here, *absent])
        told = expression_words.tell(module.parse(text), language)
    except ValueError as error:
        return Checked(column=getattr(error, "column", None), error=str(error))
    except core.CoreMissing as missing:
        return Checked(error=str(missing))
    not_here = (f"'{name}' is in this file, but not in this scene" for name in absent)
    return Checked(found.get("side"), told[0].upper() + told[1:], (*found["warnings"], *not_here))


def check_in_scene(owner: bpy.types.PropertyGroup, is_layer: bool = False) -> Checked:
    """Checks the expression of an edit or layer against the names of the scene that the artist looks at."""
    known = known_names.known(bpy.context)
    text = known.homes.read(owner.expression, owner.id_data.library)
    return check(text, known.here, language(), is_layer, known.elsewhere)


def names_here() -> tuple[str, ...]:
    """Every name that an expression may use in the scene that the artist looks at."""
    return known_names.known(bpy.context).here


def language() -> str:
    """The language of the interface: 'fr' for French; 'en' where Blender does not translate what it shows."""
    view = bpy.context.preferences.view
    return bpy.app.translations.locale[:2] if view.use_translate_interface else "en"
