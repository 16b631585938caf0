# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels, operators and the overlay share: when they show, the colours of edits, sentences and the field of an expression.

No class is registered here. Modules that register some (SLUICE_…) never import one another; what two of them need stands here or,
if it is no matter of the interface, in model.py or checking.py."""
from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING

import bpy

from . import checking, model

ENGINE = 'SLUICE'
ENTRY_COLOR, EXIT_COLOR = (0.22, 0.52, 1.0), (0.80, 0.45, 0.95)  # blue and mauve, as in the paper's figures

_UNIT = re.compile(r"(?<=\d) (?=%|\w{1,2}\b)")  # the space before a unit: no line ends there


# --- when they show ----------------------------------------------------------------------------------------------------------


if TYPE_CHECKING:
    _Panel = bpy.types.Panel
    _Operator = bpy.types.Operator
else:
    _Panel = _Operator = object  # Blender wants its own class as a base of the last class alone


class Panel(_Panel):
    """A panel that shows for our engine alone."""

    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Is the scene rendered by our engine?"""
        return context.engine in cls.COMPAT_ENGINES


class Explains(_Operator):
    """An operator behind a question mark: what its tooltip says, said where a click is answered."""

    bl_options = {'INTERNAL'}

    def execute(self, _context: bpy.types.Context) -> set[str]:
        self.report({'INFO'}, type(self).bl_description)
        return {'FINISHED'}


class AddsEdit:
    """An operator that makes an edit, in object mode or from the faces that are selected in edit mode."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Is there a scene to add it to, and a mode that allows it?"""
        return context.scene is not None and context.mode in {'OBJECT', 'EDIT_MESH'}


class OnEdit:
    """An operator for the edit that the active Empty belongs to, in object mode."""

    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Does the active object belong to an edit?"""
        return model.entry_of(context.object) is not None and context.mode == 'OBJECT'


class OnOwnEntry:
    """An operator that changes the entry of the active Empty's edit, in any mode."""

    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Does the active object belong to an edit of this file? Those of libraries cannot be changed."""
        entry = model.entry_of(context.object)
        return entry is not None and entry.library is None


# --- drawing -----------------------------------------------------------------------------------------------------------------


def column_of(panel: bpy.types.Panel) -> bpy.types.UILayout:
    """A column of properties as in Blender's own panels: labels at the left, dots for keyframes at the right."""
    panel.layout.use_property_split = True
    panel.layout.use_property_decorate = True
    return panel.layout.column()


def is_narrow(region: bpy.types.Region) -> bool:
    """Does the region lack room for a name beside something else?"""
    return region.width < 330 * bpy.context.preferences.system.ui_scale


def sentence(layout: bpy.types.UILayout, region: bpy.types.Region, text: str, icon: str, beside: int = 0) -> None:
    """Draws a sentence in as many lines as the region's width asks for. `beside`: letters that stand to its right."""
    scale = bpy.context.preferences.system.ui_scale
    width = max(14, int(region.width / (6.4 * scale)) - 8 - beside)
    box = layout.column(align=True)
    box.scale_y = 0.8
    for number, line in enumerate(textwrap.wrap(_UNIT.sub("\u00a0", text), width)):
        box.label(text=line, icon=icon if number == 0 else 'BLANK1')  # type: ignore[arg-type]


def draw_expression(layout: bpy.types.UILayout, region: bpy.types.Region, owner: bpy.types.PropertyGroup, is_layer: bool = False) -> bool:
    """Draws the field `expression` of an edit or of a layer, and below it what is to be said of it. Returns whether it is sound."""
    found = checking.check_in_scene(owner, is_layer)
    row = layout.row()
    row.use_property_split = False  # expressions are long: they get the whole width
    row.alert = found.error is not None or bool(found.warnings)
    row.prop(owner, "expression", text="")
    if found.error is not None:
        alert = layout.column()
        alert.alert = True
        where = "" if found.column is None else f"Column {found.column}, {_near(owner.expression, found.column)}: "
        sentence(alert, region, where + found.error, 'ERROR')
        return False
    sentence(layout, region, found.told, {'light': 'LIGHT', 'view': 'HIDE_OFF'}.get(found.side or "", 'RENDERLAYERS'))
    alert = layout.column()
    alert.alert = True
    for warning in found.warnings:
        sentence(alert, region, warning[0].upper() + warning[1:], 'ERROR')
    return True


def _near(text: str, column: int) -> str:
    """A few characters round a place in an expression, the place marked."""
    place = min(column - 1, len(text))
    before, after = text[:place], text[place:]
    return ("…" + before[-7:] if len(before) > 8 else before) + "▸" + (after[:7] + "…" if len(after) > 8 else after)
