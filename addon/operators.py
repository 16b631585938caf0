# SPDX-License-Identifier: GPL-3.0-or-later
"""Making and linking edits: Add ▸ Light Edit, exits for an entry, selection along the links."""
import bmesh
import bpy
import numpy as np
from bpy.props import FloatProperty, StringProperty
from mathutils import Matrix, Vector

from . import compat, kinds, placement

def _new_empty(context, name, matrix, role):
    item = bpy.data.objects.new(name, None)
    item.empty_display_type = 'SINGLE_ARROW'
    item.empty_display_size = 1.0
    item.matrix_world = matrix
    collection = context.collection
    (collection if collection and not collection.library else context.scene.collection).objects.link(item)
    item.sluice.role = role
    return item


def _select_only(context, items, active):
    for item in context.selected_objects:
        item.select_set(False)
    for item in items:
        if item.name in context.view_layer.objects:
            item.select_set(True)
    if active.name in context.view_layer.objects:
        context.view_layer.objects.active = active


def exits_of(entry):
    """The exits that name an entry, in the order of their names."""
    return sorted((item for item in bpy.data.objects if item.sluice.role == 'EXIT' and item.sluice.entry == entry),
                  key=lambda item: item.name)


def entry_of(item):
    """The entry of the edit that an Empty belongs to, or None."""
    if item is None or item.type != 'EMPTY':
        return None
    if item.sluice.role == 'EXIT':
        return item.sluice.entry
    return item if item.sluice.role == 'ENTRY' else None


def _selected_faces(context):
    """(points, normal) in world space of the faces selected in edit mode (else the active one), or None."""
    points, normal = [], Vector()
    for item in context.objects_in_mode_unique_data if context.mode == 'EDIT_MESH' else ():
        mesh = bmesh.from_edit_mesh(item.data)
        faces = [face for face in mesh.faces if face.select] or [face for face in (mesh.faces.active,) if face]
        turn = item.matrix_world.to_3x3().inverted_safe().transposed()
        for face in faces:
            points += [item.matrix_world @ vertex.co for vertex in face.verts]
            normal += (turn @ face.normal).normalized() * face.calc_area()
    return (np.array(points), np.array(normal)) if points else None


class SLUICE_OT_add_edit(bpy.types.Operator):
    """Add an entry that captures light and an exit that sends it out again: on the selected faces, or at the 3D cursor"""

    bl_idname = "sluice.add_edit"
    bl_label = "Add Light Edit"
    bl_options = {'REGISTER', 'UNDO'}

    expression: StringProperty(name="Expression", description="Which light the entry captures", default="LS+", maxlen=1024)
    size: FloatProperty(name="Size", description="Side of the entry where no faces are selected", subtype='DISTANCE', default=1.0,
                        min=1e-4, soft_max=10.0)

    @classmethod
    def poll(cls, context):
        return context.scene is not None and context.mode in {'OBJECT', 'EDIT_MESH'}

    def execute(self, context):
        faces = _selected_faces(context)
        if context.mode != 'OBJECT':
            bpy.ops.object.mode_set(mode='OBJECT')
        if faces is not None:
            matrix = Matrix(placement.fit_quad(*faces))
        else:
            matrix = context.scene.cursor.matrix @ Matrix.Scale(self.size / 2, 4)
        entry = _new_empty(context, "Light Edit", matrix, 'ENTRY')
        entry.sluice.expression = self.expression
        exit_ = _new_empty(context, f"{entry.name} Exit", Matrix(placement.beside(matrix)), 'EXIT')
        exit_.sluice.entry = entry
        _select_only(context, [exit_], exit_)  # the exit lies on the entry's plane: the artist moves it next
        return {'FINISHED'}


class SLUICE_OT_add_exit(bpy.types.Operator):
    """Add another exit to this edit: the captured light leaves by all of them"""

    bl_idname = "sluice.add_exit"
    bl_label = "Add Exit"
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return entry_of(context.object) is not None and context.mode == 'OBJECT'

    def execute(self, context):
        source, entry = context.object, entry_of(context.object)
        item = _new_empty(context, f"{entry.name} Exit", Matrix(placement.beside(source.matrix_world)), 'EXIT')
        item.empty_display_size = source.empty_display_size
        item.sluice.entry = entry
        if source.sluice.role == 'EXIT':
            for name in ("offset", "intensity", "hue_shift", "keep_brightness", "intensity_texture", "hue_shift_texture",
                         "normal_map"):
                setattr(item.sluice, name, getattr(source.sluice, name))
        _select_only(context, [item], item)
        return {'FINISHED'}


class SLUICE_OT_select_exits(bpy.types.Operator):
    """Select the exits of this edit"""

    bl_idname = "sluice.select_exits"
    bl_label = "Select Exits"
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return entry_of(context.object) is not None and context.mode == 'OBJECT'

    def execute(self, context):
        found = exits_of(entry_of(context.object))
        if not found:
            self.report({'INFO'}, "This entry has no exit: the light it takes is absorbed")
            return {'CANCELLED'}
        _select_only(context, found, found[0])
        return {'FINISHED'}


class SLUICE_OT_select_one(bpy.types.Operator):
    """Select this entry or exit"""

    bl_idname = "sluice.select_one"
    bl_label = "Select"
    bl_options = {'REGISTER', 'UNDO', 'INTERNAL'}

    name: StringProperty(name="Object", description="Name of the Empty to select")

    @classmethod
    def poll(cls, context):
        return context.mode == 'OBJECT'

    def execute(self, context):
        item = context.view_layer.objects.get(self.name)
        if item is None:
            self.report({'WARNING'}, f"{self.name} is not in this view layer")
            return {'CANCELLED'}
        _select_only(context, [item], item)
        return {'FINISHED'}


class SLUICE_OT_link_exits(bpy.types.Operator):
    """Make the other selected Empties exits of the active entry"""

    bl_idname = "sluice.link_exits"
    bl_label = "Link Exits to Entry"
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        active = context.object
        return active is not None and active.type == 'EMPTY' and active.sluice.role == 'ENTRY' and context.mode == 'OBJECT'

    def execute(self, context):
        entry = context.object
        linked = [item for item in context.selected_objects
                  if item != entry and item.type == 'EMPTY' and item.sluice.role != 'ENTRY' and item.library is None]
        if not linked:
            self.report({'WARNING'}, "Select the Empties that shall be exits, the entry last")
            return {'CANCELLED'}
        for item in linked:
            item.sluice.role = 'EXIT'
            item.sluice.entry = entry
        return {'FINISHED'}


class SLUICE_MT_add_edit(bpy.types.Menu):
    bl_idname = "SLUICE_MT_add_edit"
    bl_label = "Light Edit"

    def draw(self, _context):
        for kind in kinds.ARRIVING:
            self.layout.operator("sluice.add_edit", text=kind.label, icon=compat.icon(kind.icon, 'LIGHT')).expression = kind.expression


def draw_add_menu(self, context):
    if context.engine == 'SLUICE':
        self.layout.menu("SLUICE_MT_add_edit", icon=compat.icon('LIGHTPROBE_PLANAR', 'LIGHT'))


_classes = (SLUICE_OT_add_edit, SLUICE_OT_add_exit, SLUICE_OT_select_exits, SLUICE_OT_select_one, SLUICE_OT_link_exits,
            SLUICE_MT_add_edit)
_menus = ("VIEW3D_MT_add", "VIEW3D_MT_mesh_add", "VIEW3D_MT_edit_mesh_context_menu")


def register():
    for cls in _classes:
        bpy.utils.register_class(cls)
    for name in _menus:
        getattr(bpy.types, name).append(draw_add_menu)


def unregister():
    for name in _menus:
        getattr(bpy.types, name).remove(draw_add_menu)
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
