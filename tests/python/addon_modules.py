# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads those modules of the add-on that need no Blender and no other module of it, so that tests outside of Blender can call them."""
import importlib.util
from pathlib import Path
from types import ModuleType

ADDON = Path(__file__).resolve().parents[2] / "addon"


def load(name: str) -> ModuleType:
    """The module of this name in addon/."""
    spec = importlib.util.spec_from_file_location(f"addon_{name}", ADDON / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
