# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits: the Empties that are entries, each with the exits that name it."""
from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from .. import compat
from .description import Description

if TYPE_CHECKING:
    import bpy

    from . import Context


def export_edits(objects: Iterable[bpy.types.Object], context: Context, solo: bpy.types.Object | None = None) -> list[Description]:
    """The EditDescriptions of the evaluated objects of a view layer, sorted by order. Copies of an Empty carry the order of the
    original; of equal orders, the core lets the first act first. `solo` is the entry whose edit acts alone, if one does."""
    empties = [item for item in objects if item.type == 'EMPTY' and item.sluice.role != 'NONE']
    empties.sort(key=lambda item: (item.sluice.order, item.original.name_full))
    edits = {item.original.name_full: _export_entry(item, context) for item in empties if item.sluice.role == 'ENTRY'}
    for item in empties:
        if item.sluice.role == 'EXIT':
            _add_exit(item, edits, context)
    if solo is not None and solo.original.name_full in edits:
        for name, edit in edits.items():
            edit["enabled"] &= name == solo.original.name_full
    return list(edits.values())


def _export_entry(item: bpy.types.Object, context: Context) -> Description:
    edit, original, names = item.sluice, item.original, context.names
    return {
        "entry": _export_quad(item), "expression": names.homes.read(edit.expression, original.library), "enabled": edit.enabled,
        "repeat": edit.repeat, "amount": edit.amount, "feather": edit.feather, "exits": [],
        "collections": [name for name in names.of(original) if name != original.name_full],
    }


def _add_exit(item: bpy.types.Object, edits: dict[str, Description], context: Context) -> None:
    name, entry = item.original.name, item.sluice.entry
    if entry is None:
        context.warn(name, "this exit has no entry: it sends out nothing; choose one in its panel")
    elif entry.original.sluice.role != 'ENTRY':
        context.warn(name, f"its entry {entry.name} is no entry: the exit sends out nothing")
    elif entry.original.name_full not in edits:
        context.warn(name, f"its entry {entry.name} is not in this render: the exit sends out nothing")
    else:
        edits[entry.original.name_full]["exits"].append(_export_exit(item, context))


def _export_exit(item: bpy.types.Object, context: Context) -> Description:
    settings = item.sluice
    return {
        "quad": _export_quad(item), "intensity": settings.intensity, "hue_shift": settings.hue_shift, "tint": tuple(settings.tint),
        "keep_brightness": settings.keep_brightness,
        "intensity_texture": context.images.index(settings.intensity_texture),
        "hue_shift_texture": context.images.index(settings.hue_shift_texture),
        # A normal map holds directions, whatever colour space its file was opened in.
        "normal_map": context.images.index(settings.normal_map, color_space='NonColor'),
    }


def _export_quad(item: bpy.types.Object) -> Description:
    return {
        "name": item.original.name_full, "matrix": compat.matrix(item.matrix_world),
        "half_size": item.empty_display_size, "offset": item.sluice.offset, "order": item.sluice.order,
    }
