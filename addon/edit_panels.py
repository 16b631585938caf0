# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of an edit's Empty, in the properties editor and in the 3D view's sidebar: its expression, checked as it is typed and told
back in words; its exits; its numbers."""
from typing import Any

import bpy

from . import checking, edit_statistics, model, registration, translations
from .interface import Explains, OnOwnEntry, Panel, draw_expression, is_narrow, sentence


class SLUICE_OT_explain_figures(Explains, bpy.types.Operator):
    bl_idname = "sluice.explain_figures"
    bl_label = "How This Was Measured"
    bl_description = edit_statistics.METHOD


class SLUICE_OT_take_arrival(OnOwnEntry, bpy.types.Operator):
    """Take this light"""

    bl_idname = "sluice.take_arrival"
    bl_label = "Take This Light"

    expression: bpy.props.StringProperty(name="Expression", description="What takes it", maxlen=1024)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return checking.check(properties.expression, (), checking.language()).told or cls.__doc__

    def execute(self, context: bpy.types.Context) -> set[str]:
        model.entry_of(context.object).sluice.expression = self.expression
        return {'FINISHED'}


def _draw_expression(layout: bpy.types.UILayout, region: bpy.types.Region, edit: bpy.types.PropertyGroup) -> bool:
    header = layout.row(align=True)
    header.label(text="Expression")
    header.operator("sluice.insert_name", text="", icon='ADD')
    header.popover("SLUICE_PT_expressions", text="", icon='PRESET')
    return draw_expression(layout, region, edit)


def _draw_figures(layout: bpy.types.UILayout, region: bpy.types.Region, found: edit_statistics.Found | None) -> None:
    """Draws what the last render found. A tooltip tells how it was measured."""
    row = layout.row()
    column = row.column()
    for text, icon in edit_statistics.lines(found):
        sentence(column, region, text, icon, beside=4)
    if found is not None and edit_statistics.shows(found):
        row.operator("sluice.explain_figures", text="", icon='QUESTION', emboss=False)


def _draw_arrivals(layout: bpy.types.UILayout, found: edit_statistics.Found | None) -> None:
    """Draws which light came here in the last render, the commonest first. A click makes it the expression."""
    if found is None or not found.arrivals:
        return
    layout.label(text="Light that arrived here")
    box = layout.box().column(align=True)
    for expression, share in found.arrivals:
        row = box.row(align=True)
        row.alignment = 'LEFT'
        row.operator("sluice.take_arrival", text=f"{100 * share:.0f} %  {expression}", emboss=False).expression = expression


def _draw_exits(layout: bpy.types.UILayout, region: bpy.types.Region, entry: bpy.types.Object) -> None:
    exits = model.exits_of(entry)
    header = layout.row()
    header.label(text="Exits" if exits else "No exit: the light is absorbed", icon='EXPORT')
    header.menu("SLUICE_MT_change_light", text="", icon='DOWNARROW_HLT')
    header.operator("sluice.add_exit", text="", icon='ADD')
    header.operator("sluice.select_exits", text="", icon='RESTRICT_SELECT_OFF')
    if not exits:
        return
    box = layout.box().column(align=True)
    box.use_property_split = box.use_property_decorate = False
    for item in exits:
        # In a narrow region the numbers go below the name, so that it can be read.
        row = box.column(align=True) if is_narrow(region) else box.split(factor=0.5, align=True)
        name, numbers = row.row(align=True), row.row(align=True)
        name.alignment = 'LEFT'
        name.operator("sluice.select_one", text=item.name, emboss=False).name = item.name
        numbers.prop(item.sluice, "intensity", text="")
        numbers.prop(item.sluice, "hue_shift", text="")
        numbers.prop(item.sluice, "tint", text="")


def _draw_entry(layout: bpy.types.UILayout, region: bpy.types.Region, item: bpy.types.Object) -> None:
    edit = item.sluice
    body = layout.column()
    body.active = edit.enabled
    found = edit_statistics.of(item.name_full) if _draw_expression(body, region, edit) else None
    _draw_figures(body, region, found)
    _draw_arrivals(body, found)
    body.separator()
    body.prop(edit, "amount")
    body.prop(edit, "feather")
    body.prop(edit, "repeat")
    layout.separator()
    _draw_exits(layout, region, item)


def _draw_exit(layout: bpy.types.UILayout, edit: Any) -> None:
    row = layout.row(align=True)
    row.alert = edit.entry is None
    row.prop(edit, "entry")
    if edit.entry is not None:
        row.operator("sluice.select_one", text="", icon='RESTRICT_SELECT_OFF').name = edit.entry.name
        if edit.entry.name not in bpy.context.scene.objects:
            layout.label(text=f"{edit.entry.name} is not in this scene: nothing leaves here", icon='ERROR')
    else:
        layout.label(text="Choose the entry whose light leaves here", icon='ERROR')
    layout.separator()
    for number, image in (("intensity", "intensity_texture"), ("hue_shift", "hue_shift_texture")):
        column = layout.column()
        column.prop(edit, number)
        _draw_image(column, edit, image, "Texture")
        column.separator()
    layout.prop(edit, "tint", text="Tint", text_ctxt=translations.CONTEXT)
    layout.separator()
    _draw_image(layout, edit, "normal_map", "Normal Map")
    layout.prop(edit, "keep_brightness")


def _draw_image(layout: bpy.types.UILayout, edit: Any, name: str, label: str) -> None:
    """Draws where an image is chosen or opened, its label in line with those of numbers."""
    layout.template_ID(edit, name, open="image.open", text=label)


def draw_edit(layout: bpy.types.UILayout, region: bpy.types.Region, item: bpy.types.Object) -> None:
    """Draws the whole panel of an edit's Empty."""
    edit = item.sluice
    roles = layout.row(align=True)
    for role, label in (('NONE', "None"), ('ENTRY', "Entry"), ('EXIT', "Exit")):
        roles.prop_enum(edit, "role", role, text=label, text_ctxt=translations.CONTEXT)
    layout.use_property_split = True
    if edit.role == 'NONE':
        return
    column = layout.column()
    column.separator()
    if edit.role == 'ENTRY':
        _draw_entry(column, region, item)
    else:
        _draw_exit(column, edit)
    place = layout.column()
    place.prop(edit, "order")
    place.prop(edit, "offset")


class _EditPanel(Panel):
    bl_label = "Light Edit"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object is not None and context.object.type == 'EMPTY'

    def draw_header(self, context: bpy.types.Context) -> None:
        if context.object.sluice.role == 'ENTRY':
            self.layout.prop(context.object.sluice, "enabled", text="")

    def draw(self, context: bpy.types.Context) -> None:
        draw_edit(self.layout, context.region, context.object)


class SLUICE_PT_edit(_EditPanel, bpy.types.Panel):
    bl_context = "data"


class SLUICE_PT_edit_sidebar(_EditPanel, bpy.types.Panel):
    bl_space_type = 'VIEW_3D'  # type: ignore[assignment]
    bl_region_type = 'UI'  # type: ignore[assignment]
    bl_category = "Sluice"


_classes = (SLUICE_OT_explain_figures, SLUICE_OT_take_arrival, SLUICE_PT_edit, SLUICE_PT_edit_sidebar)
_register, _unregister = registration.of_classes(*_classes)


def register() -> None:
    _register()


def unregister() -> None:
    _unregister()
    checking.check.cache_clear()
