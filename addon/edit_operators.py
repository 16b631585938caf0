# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators on whole edits: making one, deciding what becomes of the light that its entry takes, linking exits to an entry."""
import math
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from mathutils import Matrix

from . import interface, light_kinds, model, placement, quad_geometry, registration, translations

if TYPE_CHECKING:
    _Operator = bpy.types.Operator
else:
    _Operator = object  # Blender wants its own class as a base of registered classes alone.

_ACTION_ITEMS = tuple((name, label, description, icon, number)
                      for number, (name, label, description, icon) in enumerate(light_kinds.ACTIONS))


def _lies_upon(item: bpy.types.Object, entry: bpy.types.Object) -> bool:
    """Is this an exit through which light leaves as it came, wherever the entry goes?"""
    return item.parent == entry and item.matrix_basis == Matrix()


def _add_exit(context: bpy.types.Context, entry: bpy.types.Object, matrix: Matrix) -> bpy.types.Object:
    """Makes an exit whose quad is as large as the entry's where their matrices are equal."""
    return model.new_exit(context, entry, matrix, entry.empty_display_size)


def _add_beside(context: bpy.types.Context, entry: bpy.types.Object) -> bpy.types.Object:
    """Makes an exit beside the entry, to be laid where the light is wanted."""
    return _add_exit(context, entry, Matrix(quad_geometry.beside(entry.matrix_world)))


def _add_upon(context: bpy.types.Context, entry: bpy.types.Object) -> bpy.types.Object:
    """Makes an exit on the entry itself, which goes where the entry goes: the light leaves as it came."""
    item = _add_exit(context, entry, entry.matrix_world)
    item.parent = entry
    item.matrix_parent_inverse.identity()
    item.matrix_basis.identity()
    return item


def _lay_at_cursor(context: bpy.types.Context, item: bpy.types.Object, entry: bpy.types.Object) -> bpy.types.Object:
    """Lays an exit at the 3D cursor, as large as it is. It keeps its parent, unless that is the entry that it lay upon."""
    matrix, _distance = placement.at_cursor(context)
    x, y, z = (abs(side) for side in item.matrix_world.to_scale())
    if _lies_upon(item, entry):
        item.parent = None
    mirrored = -1 if item.matrix_world.is_negative else 1
    item.matrix_world = matrix @ Matrix.Diagonal((mirrored * x, y, z, 1))
    return item


class _ChangesLight(_Operator):
    """What becomes of the light that an entry takes, as a part of two operators: it makes, changes or removes exits."""

    if TYPE_CHECKING:  # Each operator defines this property with a default of its own.
        action: str

    tint: FloatVectorProperty(name="Tint", description="Colour that white light gets, for Recolour", subtype='COLOR', size=3,
                              default=(0.1, 0.4, 1.0), min=0.0, soft_max=1.0)
    hue_shift: FloatProperty(name="Hue Shift", description="Turn on the hue circle before the tint, for Recolour", subtype='ANGLE',
                             default=0.0, soft_min=-math.pi, soft_max=math.pi)
    intensity: FloatProperty(name="Intensity", description="Factor on the energy, for Dim", default=0.5, min=0.0, soft_max=2.0, max=1e4)

    def change(self, context: bpy.types.Context, entry: bpy.types.Object) -> bpy.types.Object:
        """Does the action. Returns the Empty that the artist will want to touch next: an exit, or the entry."""
        if self.action == 'REMOVE':
            for item in model.exits_of(entry):
                bpy.data.objects.remove(item)
            return entry
        exits = model.exits_of(entry)
        if self.action == 'MOVE':
            return self._move(exits[0], entry) if exits else _add_beside(context, entry)
        exits = exits or [_add_upon(context, entry)]
        for item in exits:
            if self.action == 'RECOLOUR':
                item.sluice.tint, item.sluice.hue_shift = self.tint, self.hue_shift
            elif self.action == 'DIM':
                item.sluice.intensity *= self.intensity
        if self.action == 'COPY':
            return _lay_at_cursor(context, _add_exit(context, entry, entry.matrix_world), entry)
        return exits[0]

    def _move(self, item: bpy.types.Object, entry: bpy.types.Object) -> bpy.types.Object:
        """The light has an exit: that is the one to be laid elsewhere, beside the entry if it lies upon it."""
        if _lies_upon(item, entry):
            item.parent = None
            item.matrix_world = Matrix(quad_geometry.beside(entry.matrix_world))
        else:
            self.report({'INFO'}, f"The light of {entry.name} leaves by {item.name}: lay that where you want it")
        return item

    def draw_numbers(self, layout: bpy.types.UILayout) -> None:
        """Draws the numbers that the chosen action asks for."""
        if self.action == 'RECOLOUR':
            layout.prop(self, "tint", text="Tint", text_ctxt=translations.CONTEXT)
            layout.prop(self, "hue_shift")
        elif self.action == 'DIM':
            layout.prop(self, "intensity")


class SLUICE_OT_add_edit(_ChangesLight, interface.AddsEdit, bpy.types.Operator):
    """Add an entry that captures light, and what becomes of it: on the selected faces, or at the 3D cursor"""

    bl_idname = "sluice.add_edit"
    bl_label = "Add Light Edit"
    bl_options = {'REGISTER', 'UNDO'}

    expression: StringProperty(name="Expression", description="Which light the entry captures", default="LS+", maxlen=1024)
    name: StringProperty(name="Name", description="What the entry is called", default="Light Edit", options={'SKIP_SAVE'})
    action: EnumProperty(name="Action", description="What becomes of the light", items=_ACTION_ITEMS, default='MOVE')
    size: FloatProperty(name="Size", description="Side of the entry where no faces are selected; 0: by its distance from the eye",
                        subtype='DISTANCE', default=0.0, min=0.0, soft_max=10.0)

    def execute(self, context: bpy.types.Context) -> set[str]:
        matrix, on_faces = placement.find(context, self.size)
        if context.mode != 'OBJECT':
            bpy.ops.object.mode_set(mode='OBJECT')
        entry = model.new_empty(context, self.name, matrix, 'ENTRY')
        entry.sluice.expression = self.expression
        if self.action == 'COPY' and not on_faces:  # The entry itself lies at the cursor, so the copy goes beside it.
            _add_upon(context, entry)
            touched = _add_beside(context, entry)
        else:
            touched = self.change(context, entry)
        model.select_only(context, [touched], touched)
        return {'FINISHED'}

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "name")
        layout.prop(self, "expression")
        layout.prop(self, "action")
        layout.prop(self, "size")
        self.draw_numbers(layout)


class SLUICE_OT_change_light(_ChangesLight, interface.OnEdit, bpy.types.Operator):
    """Decide what becomes of the light that this edit's entry takes"""

    bl_idname = "sluice.change_light"
    bl_label = "Change Light"

    action: EnumProperty(name="Action", description="What becomes of the light", items=_ACTION_ITEMS, default='COPY')
    to_cursor: BoolProperty(name="To Cursor", description="Where the light shall go, for Move", default=False, options={'SKIP_SAVE'})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and model.entry_of(context.object).library is None

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        if properties.action == 'MOVE' and properties.to_cursor:
            return "The exit goes to the 3D cursor, and lies on the surface there"
        return next(description for name, _label, description, _icon in light_kinds.ACTIONS if name == properties.action)

    def execute(self, context: bpy.types.Context) -> set[str]:
        entry = model.entry_of(context.object)
        if self.action == 'MOVE' and self.to_cursor:
            touched = _lay_at_cursor(context, self._exit_to_move(context, entry), entry)
        else:
            touched = self.change(context, entry)
        model.select_only(context, [touched], touched)
        return {'FINISHED'}

    @staticmethod
    def _exit_to_move(context: bpy.types.Context, entry: bpy.types.Object) -> bpy.types.Object:
        """The active exit, else the first one, else a new one."""
        exits = model.exits_of(entry)
        return context.object if context.object in exits else exits[0] if exits else _add_upon(context, entry)

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        self.layout.prop(self, "action")
        if self.action == 'MOVE':
            self.layout.prop(self, "to_cursor")
        self.draw_numbers(self.layout)


class SLUICE_OT_link_exits(bpy.types.Operator):
    """Make the other selected Empties exits of the active entry"""

    bl_idname = "sluice.link_exits"
    bl_label = "Link Exits to Entry"
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and model.is_entry(context.object) and context.mode == 'OBJECT'

    def execute(self, context: bpy.types.Context) -> set[str]:
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


_classes = (SLUICE_OT_add_edit, SLUICE_OT_change_light, SLUICE_OT_link_exits)

register, unregister = registration.of_classes(*_classes)
