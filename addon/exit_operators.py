# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators on the exits of an edit: adding one, selecting them."""
import bpy
from bpy.props import StringProperty
from mathutils import Matrix

from . import interface, model, properties, quad_geometry, registration


class SLUICE_OT_add_exit(interface.OnEdit, bpy.types.Operator):
    """Add another exit to this edit: the captured light leaves by all of them"""

    bl_idname = "sluice.add_exit"
    bl_label = "Add Exit"

    def execute(self, context: bpy.types.Context) -> set[str]:
        source, entry = context.object, model.entry_of(context.object)
        matrix = Matrix(quad_geometry.beside(source.matrix_world))
        item = model.new_exit(context, entry, matrix, source.empty_display_size)
        if source.sluice.role == 'EXIT':
            for name in properties.EXIT_PROPERTIES:
                setattr(item.sluice, name, getattr(source.sluice, name))
        model.select_only(context, [item], item)
        return {'FINISHED'}


class SLUICE_OT_select_exits(interface.OnEdit, bpy.types.Operator):
    """Select the exits of this edit"""

    bl_idname = "sluice.select_exits"
    bl_label = "Select Exits"

    def execute(self, context: bpy.types.Context) -> set[str]:
        found = model.exits_of(model.entry_of(context.object))
        if not found:
            self.report({'INFO'}, "This entry has no exit: the light it takes is absorbed")
            return {'CANCELLED'}
        model.select_only(context, found, found[0])
        return {'FINISHED'}


class SLUICE_OT_select_one(bpy.types.Operator):
    """Select this entry or exit"""

    bl_idname = "sluice.select_one"
    bl_label = "Select"
    bl_options = {'REGISTER', 'UNDO', 'INTERNAL'}

    name: StringProperty(name="Object", description="Name of the Empty to select")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.mode == 'OBJECT'

    def execute(self, context: bpy.types.Context) -> set[str]:
        item: bpy.types.Object | None = context.view_layer.objects.get(self.name)
        if item is None:
            self.report({'WARNING'}, f"{self.name} is not in this view layer")
            return {'CANCELLED'}
        model.select_only(context, [item], item)
        return {'FINISHED'}


_classes = (SLUICE_OT_add_exit, SLUICE_OT_select_exits, SLUICE_OT_select_one)

register, unregister = registration.of_classes(*_classes)
