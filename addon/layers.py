# SPDX-License-Identifier: GPL-3.0-or-later
"""Light layers in View Layer Properties: a list of render passes, each chosen by an expression over whole paths."""
from typing import Any

import bpy
from bpy.props import EnumProperty

from . import checking, passes, registration
from .interface import Panel, draw_expression


class SLUICE_UL_layers(bpy.types.UIList):
    """Name of each layer; red where its expression is none."""

    def draw_item(self, _context: bpy.types.Context, layout: bpy.types.UILayout,
                  _data: Any, item: Any, _icon: int, _active_data: Any, _active_name: str) -> None:
        wrong = checking.check(item.expression, checking.names_here(), "en", True).error is not None
        row = layout.row()
        row.alert = wrong
        row.prop(item, "name", text="", emboss=False, icon='ERROR' if wrong else 'RENDERLAYERS')


class _LayerOperator:
    """An operator on the list of layers of the view layer."""

    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.view_layer is not None and bool(context.view_layer.sluice.layers)

    def change(self, settings: Any, active: int) -> int:
        """Changes the layers of a view layer's settings, of which row `active` is chosen; returns the row to be chosen then."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = context.view_layer.sluice
        settings.active_layer = self.change(settings, min(settings.active_layer, len(settings.layers) - 1))
        context.view_layer.update_render_passes()  # The compositor gets sockets for them.
        return {'FINISHED'}


class SLUICE_OT_add_layer(_LayerOperator, bpy.types.Operator):
    """Add a render pass that shows the light whose whole path matches an expression"""

    bl_idname = "sluice.add_layer"
    bl_label = "Add Light Layer"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.view_layer is not None

    def change(self, settings: Any, _active: int) -> int:
        name = passes.clean_name("Layer", [item.name for item in settings.layers])
        settings.layers.add().name = name
        return len(settings.layers) - 1


class SLUICE_OT_remove_layer(_LayerOperator, bpy.types.Operator):
    """Remove the light layer"""

    bl_idname = "sluice.remove_layer"
    bl_label = "Remove Light Layer"

    def change(self, settings: Any, active: int) -> int:
        settings.layers.remove(active)
        return max(0, min(active, len(settings.layers) - 1))


class SLUICE_OT_move_layer(_LayerOperator, bpy.types.Operator):
    """Move the light layer in the list"""

    bl_idname = "sluice.move_layer"
    bl_label = "Move Light Layer"

    direction: EnumProperty(name="Direction", description="Where to", items=(('UP', "Up", "To the start"), ('DOWN', "Down", "To the end")))

    def change(self, settings: Any, active: int) -> int:
        target = max(0, min(active + (1 if self.direction == 'DOWN' else -1), len(settings.layers) - 1))
        settings.layers.move(active, target)
        return target


class SLUICE_PT_layers(Panel, bpy.types.Panel):
    bl_label = "Light Layers"
    bl_context = "view_layer"

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.view_layer.sluice
        row = self.layout.row()
        row.template_list("SLUICE_UL_layers", "", settings, "layers", settings, "active_layer", rows=4 if settings.layers else 2)
        buttons = row.column(align=True)
        buttons.operator("sluice.add_layer", text="", icon='ADD')
        buttons.operator("sluice.remove_layer", text="", icon='REMOVE')
        if len(settings.layers) > 1:
            buttons.separator()
            buttons.operator("sluice.move_layer", text="", icon='TRIA_UP').direction = 'UP'
            buttons.operator("sluice.move_layer", text="", icon='TRIA_DOWN').direction = 'DOWN'
        if 0 <= settings.active_layer < len(settings.layers):
            draw_expression(self.layout.column(), context.region, settings.layers[settings.active_layer], is_layer=True)


_classes = (SLUICE_UL_layers, SLUICE_OT_add_layer, SLUICE_OT_remove_layer, SLUICE_OT_move_layer, SLUICE_PT_layers)

register, unregister = registration.of_classes(*_classes)
