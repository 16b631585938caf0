# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of an edit's Empty, in the properties editor and in the 3D view's sidebar: its expression, checked as it is typed and told
back in words; its exits; its numbers."""
import functools

import bpy

from . import core, names, operators, present, presets, statistics, translations, words
from .panels import Panel, is_narrow, sentence


class Checked:
    """What is to be said of an expression."""

    def __init__(self, side=None, told="", warnings=(), column=None, error=None):
        self.side, self.told, self.warnings, self.column, self.error = side, told, warnings, column, error


@functools.lru_cache(maxsize=256)
def check(text, here, language, is_layer=False, elsewhere=frozenset()):
    """Of an edit or of a layer. `here`: names of the scene; `elsewhere`: of what is in the file alone. Kept, since panels are drawn
    many times a second."""
    absent = sorted(elsewhere & names.names_in(text))
    try:
        module = core.load()
        found = (module.check_layer_expression if is_layer else module.check_expression)(text, [*here, *absent])
        told = words.tell(core.load().parse(text), language)
    except ValueError as error:
        return Checked(column=getattr(error, "column", None), error=str(error))
    except core.CoreMissing as missing:
        return Checked(error=str(missing))
    not_here = (f"'{name}' is in this file, but not in this scene" for name in absent)
    return Checked(found.get("side"), told[0].upper() + told[1:], (*found["warnings"], *not_here))


class SLUICE_OT_explain_figures(bpy.types.Operator):
    bl_idname = "sluice.explain_figures"
    bl_label = "How This Was Measured"
    bl_description = statistics.METHOD
    bl_options = {'INTERNAL'}

    def execute(self, _context):
        self.report({'INFO'}, statistics.METHOD)
        return {'FINISHED'}


class SLUICE_OT_take_arrival(presets.OnEntry, bpy.types.Operator):
    """Take this light"""

    bl_idname = "sluice.take_arrival"
    bl_label = "Take This Light"

    expression: bpy.props.StringProperty(name="Expression", description="What takes it", maxlen=1024)

    @classmethod
    def description(cls, _context, properties):
        return check(properties.expression, (), language()).told or cls.__doc__

    def execute(self, context):
        operators.entry_of(context.object).sluice.expression = self.expression
        return {'FINISHED'}


def known_names():
    """Every name an expression may use in this scene."""
    return present.known(bpy.context).here


def language():
    """Of the interface: 'fr' for French, where Blender translates what it shows."""
    view = bpy.context.preferences.view
    return bpy.app.translations.locale[:2] if view.use_translate_interface else "en"


def _near(text, column):
    """A few characters round a place in an expression, the place marked."""
    place = min(column - 1, len(text))
    before, after = text[:place], text[place:]
    return ("…" + before[-7:] if len(before) > 8 else before) + "▸" + (after[:7] + "…" if len(after) > 8 else after)


def _draw_expression(layout, region, edit):
    header = layout.row(align=True)
    header.label(text="Expression")
    header.operator("sluice.insert_name", text="", icon='ADD')
    header.popover("SLUICE_PT_expressions", text="", icon='PRESET')
    return draw_checked(layout, region, edit)


def draw_checked(layout, region, edit, is_layer=False):
    """The field `expression` of an edit or of a layer, and what is to be said of it. False: it is none."""
    known = present.known(bpy.context)
    found = check(known.homes.read(edit.expression, edit.id_data.library), known.here, language(), is_layer, known.elsewhere)
    row = layout.row()
    row.use_property_split = False  # expressions are long: the whole width
    row.alert = found.error is not None or bool(found.warnings)
    row.prop(edit, "expression", text="")
    if found.error is not None:
        alert = layout.column()
        alert.alert = True
        where = "" if found.column is None else f"Column {found.column}, {_near(edit.expression, found.column)}: "
        sentence(alert, region, where + found.error, 'ERROR')
        return False
    sentence(layout, region, found.told, {'light': 'LIGHT', 'view': 'HIDE_OFF'}.get(found.side, 'RENDERLAYERS'))
    alert = layout.column()
    alert.alert = True
    for warning in found.warnings:
        sentence(alert, region, warning[0].upper() + warning[1:], 'ERROR')
    return True


def _draw_figures(layout, region, found):
    """What the last render found; how it was measured stands in a tooltip."""
    row = layout.row()
    column = row.column()
    for text, icon in statistics.lines(found):
        sentence(column, region, text, icon, beside=4)
    if found is not None and statistics.shows(found):
        row.operator("sluice.explain_figures", text="", icon='QUESTION', emboss=False)


def _draw_arrivals(layout, found):
    """What light came here in the last render, commonest first; a click makes it the expression."""
    if found is None or not found.arrivals:
        return
    layout.label(text="Light that arrived here")
    box = layout.box().column(align=True)
    for expression, share in found.arrivals:
        row = box.row(align=True)
        row.alignment = 'LEFT'
        row.operator("sluice.take_arrival", text=f"{100 * share:.0f} %  {expression}", emboss=False).expression = expression


def _draw_exits(layout, region, entry):
    exits = operators.exits_of(entry)
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
        row = box.column(align=True) if is_narrow(region) else box.split(factor=0.5, align=True)  # names are to be read
        name, numbers = row.row(align=True), row.row(align=True)
        name.alignment = 'LEFT'
        name.operator("sluice.select_one", text=item.name, emboss=False).name = item.name
        numbers.prop(item.sluice, "intensity", text="")
        numbers.prop(item.sluice, "hue_shift", text="")
        numbers.prop(item.sluice, "tint", text="")


def _draw_entry(layout, region, item):
    edit = item.sluice
    body = layout.column()
    body.active = edit.enabled
    found = statistics.of(item.name_full) if _draw_expression(body, region, edit) else None
    _draw_figures(body, region, found)
    _draw_arrivals(body, found)
    body.separator()
    body.prop(edit, "amount")
    body.prop(edit, "feather")
    body.prop(edit, "repeat")
    layout.separator()
    _draw_exits(layout, region, item)


def _draw_exit(layout, edit):
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


def _draw_image(layout, edit, name, label):
    """Choose or open an image; a label in line with those of numbers."""
    layout.template_ID(edit, name, open="image.open", text=label)


def draw_edit(layout, region, item):
    """The whole panel of an edit's Empty."""
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
    def poll(cls, context):
        return super().poll(context) and context.object is not None and context.object.type == 'EMPTY'

    def draw_header(self, context):
        if context.object.sluice.role == 'ENTRY':
            self.layout.prop(context.object.sluice, "enabled", text="")

    def draw(self, context):
        draw_edit(self.layout, context.region, context.object)


class SLUICE_PT_edit(_EditPanel, bpy.types.Panel):
    bl_context = "data"


class SLUICE_PT_edit_sidebar(_EditPanel, bpy.types.Panel):
    bl_space_type = 'VIEW_3D'
    bl_region_type = 'UI'
    bl_category = "Sluice"


_classes = (SLUICE_OT_explain_figures, SLUICE_OT_take_arrival, SLUICE_PT_edit, SLUICE_PT_edit_sidebar)
_register, _unregister = bpy.utils.register_classes_factory(_classes)


def register():
    _register()


def unregister():
    _unregister()
    check.cache_clear()
