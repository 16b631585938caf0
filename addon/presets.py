# SPDX-License-Identifier: GPL-3.0-or-later
"""Expressions to choose from: ours by what they take, and the artist's own, kept as Blender presets (scripts/presets/sluice/expression).
And names to choose from instead of typing them."""
import ast
from typing import Any

import bl_operators.presets
import bpy
from bl_ui.utils import PresetPanel
from bpy.props import EnumProperty, StringProperty

from . import compat, expression_names, light_kinds, model, registration
from .export.scene_names import Homes
from .interface import OnOwnEntry

SUBDIR = "sluice/expression"

_items: list[tuple[Any, ...]] = []  # Blender keeps no copies of an enumeration's strings, so they must live on here.


def _homes() -> Homes:
    return Homes(bpy.data.objects, bpy.data.collections, bpy.data.worlds)


def _nouns(_self: object, context: bpy.types.Context) -> list[tuple[Any, ...]]:
    """Items of an enumeration: what can be named, with the event that it makes, as S'Egg' and D'Egg' for a mesh. Blender sorts them."""
    scene, found, homes = context.scene, [], _homes()
    for item in sorted(scene.objects, key=lambda item: item.name_full):
        name = homes.own(item)[0]
        if item.type == 'LIGHT':
            found.append(("L", name, "a lamp", 'LIGHT'))
        elif model.is_entry(item):
            found.append(("F", name, "moved by this edit", 'EMPTY_SINGLE_ARROW'))
        elif item.type in {'MESH', 'CURVE', 'SURFACE', 'META', 'FONT'}:
            found += [("S", name, "mirrored or refracted", 'OBJECT_DATA'), ("D", name, "scattered", 'OBJECT_DATA')]
    found += [("X", homes.own(item)[0], "anything in this collection", 'OUTLINER_COLLECTION') for item in scene.collection.children_recursive]
    if scene.world is not None:
        found.append(("L", homes.own(scene.world)[0], "the world", 'WORLD'))
    labels = {f"{kind}:{name}": (f"{name}, {told}: {kind}{expression_names.quoted([name])}", icon) for kind, name, told, icon in found}
    items: list[tuple[Any, ...]] = [(key, label, "", icon, number) for number, (key, (label, icon)) in enumerate(labels.items())]
    items = items or [("", "Nothing to name", "")]
    if items != _items:  # Equal ones are kept: Blender may still show the strings that it was given.
        _items[:] = items
    return _items


class SLUICE_OT_insert_name(OnOwnEntry, bpy.types.Operator):
    """Put the name of an object, lamp, edit or collection into the expression"""

    bl_idname = "sluice.insert_name"
    bl_label = "Insert Name"
    bl_property = "noun"

    noun: EnumProperty(name="Name", description="What the expression shall name", items=_nouns)

    def execute(self, context: bpy.types.Context) -> set[str]:
        edit = model.entry_of(context.object).sluice
        kind, _colon, name = self.noun.partition(":")
        if name:
            edit.expression = expression_names.with_name(edit.expression, kind, name)
        return {'FINISHED'}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        context.window_manager.invoke_search_popup(self)
        return {'RUNNING_MODAL'}


class SLUICE_OT_set_expression(OnOwnEntry, bpy.types.Operator):
    """Take this kind of light"""

    bl_idname = "sluice.set_expression"
    bl_label = "Set Expression"
    bl_property = "noun"

    expression: StringProperty(name="Expression", description="With {} where a name belongs", maxlen=1024)
    noun: EnumProperty(name="Name", description="What {} stands for", items=_nouns)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        offered = (kind for group in light_kinds.GROUPS for kind in group)
        return next((kind.description for kind in offered if kind.expression == properties.expression), cls.__doc__)

    def execute(self, context: bpy.types.Context) -> set[str]:
        expression = self.expression
        if "{}" in expression:
            name = self._named(context) or self.noun.partition(":")[2]
            if not name:
                self.report({'WARNING'}, "There is no object to name")
                return {'CANCELLED'}
            expression = expression.replace("{}", expression_names.quoted([name]))
        model.entry_of(context.object).sluice.expression = expression
        return {'FINISHED'}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if "{}" not in self.expression or self._named(context):
            return self.execute(context)
        context.window_manager.invoke_search_popup(self)
        return {'RUNNING_MODAL'}

    @staticmethod
    def _named(context: bpy.types.Context) -> str:
        """The name of a thing that is selected beside the edit; empty if there is none."""
        chosen = (item for item in context.selected_objects if item.type != 'CAMERA' and item.sluice.role == 'NONE')
        return next((_homes().own(item)[0] for item in chosen), "")


class SLUICE_OT_load_expression(OnOwnEntry, bpy.types.Operator):
    """Take the light that this preset takes"""

    bl_idname = "sluice.load_expression"
    bl_label = "Load Expression"

    filepath: StringProperty(name="File", description="The preset's file", subtype='FILE_PATH', options={'SKIP_SAVE'})

    def execute(self, context: bpy.types.Context) -> set[str]:
        expression = read_preset(self.filepath)
        if expression is None:
            self.report({'WARNING'}, f"{self.filepath} holds no expression")
            return {'CANCELLED'}
        model.entry_of(context.object).sluice.expression = expression
        return {'FINISHED'}


def read_preset(path: str) -> str | None:
    """The expression that a preset's file assigns, or None. The file is read, never run."""
    try:
        with open(path, encoding="utf-8") as file:
            statements = ast.parse(file.read()).body
    except (OSError, SyntaxError, ValueError):
        return None
    for statement in statements:
        if isinstance(statement, ast.Assign) and getattr(statement.targets[0], "attr", "") == "expression":
            value = getattr(statement.value, "value", None)
            return value if isinstance(value, str) else None
    return None


class SLUICE_OT_save_expression(bl_operators.presets.AddPresetBase, bpy.types.Operator):
    """Keep this expression as a preset, or remove one"""

    bl_idname = "sluice.save_expression"
    bl_label = "Save Expression"
    preset_menu = "SLUICE_PT_expressions"
    # There are no preset_defines: Python 3.13 hides what Blender's exec() defines.
    preset_values = ["bpy.context.object.sluice.expression"]
    preset_subdir = SUBDIR


class SLUICE_PT_expressions(PresetPanel, bpy.types.Panel):
    bl_label = "Expressions"
    preset_subdir = SUBDIR
    preset_operator = "sluice.load_expression"
    preset_add_operator = "sluice.save_expression"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.emboss = 'PULLDOWN_MENU'
        layout.operator_context = 'INVOKE_DEFAULT'  # Invoke lets those ask that need a name.
        for group in light_kinds.GROUPS:
            column = layout.column(align=True)
            for kind in group:
                row = column.row()
                row.alignment = 'LEFT'
                icon: Any = compat.icon(kind.icon, 'LIGHT')
                row.operator("sluice.set_expression", text=kind.label, icon=icon).expression = kind.expression
            layout.separator()
        layout.label(text="Own")
        if bpy.utils.preset_paths(SUBDIR):
            bpy.types.Menu.draw_preset(self, context)
        else:
            self._draw_first(layout, context.window_manager)

    def _draw_first(self, layout: bpy.types.UILayout, manager: bpy.types.WindowManager) -> None:
        """Draws the field for a new preset's name as Blender does. Without any preset, Blender's own code would complain of a missing folder."""
        row = layout.row()
        field = row.row()
        field.emboss = 'NORMAL'
        field.prop(manager, "preset_name", text="")
        row.operator(self.preset_add_operator, text="", icon='ADD').name = manager.preset_name


_classes = (SLUICE_OT_insert_name, SLUICE_OT_set_expression, SLUICE_OT_load_expression, SLUICE_OT_save_expression, SLUICE_PT_expressions)

register, unregister = registration.of_classes(*_classes)
