# SPDX-License-Identifier: GPL-3.0-or-later
"""Making and linking edits: Add ▸ Light Edit, what becomes of the light, exits for an entry, selection along the links."""
import math

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from mathutils import Matrix

from . import compat, kinds, placement, places, translations


def new_empty(context, name, matrix, role):
    item = bpy.data.objects.new(name, None)
    item.empty_display_type = 'SINGLE_ARROW'
    item.empty_display_size = 1.0
    item.matrix_world = matrix
    collection = context.collection
    (collection if collection and not collection.library else context.scene.collection).objects.link(item)
    item.sluice.role = role
    return item


def select_only(context, items, active):
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


def _lies_upon(item, entry):
    """Is it an exit through which light leaves as it came, wherever the entry goes?"""
    return item.parent == entry and item.matrix_basis == Matrix()


ACTIONS = (
    ('MOVE', "Move", "The light goes to an exit beside the entry, to be laid where it is wanted", 'CON_LOCLIKE'),
    ('COPY', "Copy", "The light stays, and falls at the 3D cursor too", 'DUPLICATE'),
    ('RECOLOUR', "Recolour", "The light stays, in another colour", 'COLOR'),
    ('DIM', "Dim", "The light stays, weaker", 'LIGHT_SUN'),
    ('REMOVE', "Remove", "The light is gone", 'X'),
)
_ACTION_ITEMS = tuple((name, label, description, icon, number) for number, (name, label, description, icon) in enumerate(ACTIONS))


class _Change:
    """What becomes of the light that an entry takes: the part of two operators. Makes or changes exits."""

    tint: FloatVectorProperty(name="Tint", description="Colour that white light gets, for Recolour", subtype='COLOR', size=3,
                              default=(0.1, 0.4, 1.0), min=0.0, soft_max=1.0)
    hue_shift: FloatProperty(name="Hue Shift", description="Turn on the hue circle before the tint, for Recolour", subtype='ANGLE',
                             default=0.0, soft_min=-math.pi, soft_max=math.pi)
    intensity: FloatProperty(name="Intensity", description="Factor on the energy, for Dim", default=0.5, min=0.0, soft_max=2.0, max=1e4)

    def change(self, context, entry, action):
        """Returns the exit that the artist will want to touch next, or the entry."""
        if action == 'REMOVE':
            for item in exits_of(entry):
                bpy.data.objects.remove(item)
            return entry
        exits = exits_of(entry)
        if action == 'MOVE':
            return self._move(exits[0], entry) if exits else self._add_exit(context, entry, Matrix(placement.beside(entry.matrix_world)))
        exits = exits or [self._stay(context, entry)]
        for item in exits:
            if action == 'RECOLOUR':
                item.sluice.tint, item.sluice.hue_shift = self.tint, self.hue_shift
            elif action == 'DIM':
                item.sluice.intensity *= self.intensity
        if action == 'COPY':
            return self._lay_at_cursor(context, self._add_exit(context, entry, entry.matrix_world), entry)
        return exits[0]

    @staticmethod
    def _lay_at_cursor(context, item, entry):
        """Lays the exit there, as large as it is. It still follows what it follows, but for an entry that it lay upon."""
        matrix, _distance = places.at_cursor(context)
        x, y, z = (abs(side) for side in item.matrix_world.to_scale())
        if _lies_upon(item, entry):
            item.parent = None
        mirrored = -1 if item.matrix_world.is_negative else 1
        item.matrix_world = matrix @ Matrix.Diagonal((mirrored * x, y, z, 1))
        return item

    def _move(self, item, entry):
        """The light has an exit: that is the one to be laid elsewhere, beside the entry if it lies upon it."""
        if _lies_upon(item, entry):
            item.parent = None
            item.matrix_world = Matrix(placement.beside(entry.matrix_world))
        else:
            self.report({'INFO'}, f"The light of {entry.name} leaves by {item.name}: lay that where you want it")
        return item

    def draw_numbers(self, layout):
        if self.action == 'RECOLOUR':
            layout.prop(self, "tint", text="Tint", text_ctxt=translations.CONTEXT)
            layout.prop(self, "hue_shift")
        elif self.action == 'DIM':
            layout.prop(self, "intensity")

    @staticmethod
    def _add_exit(context, entry, matrix):
        item = new_empty(context, f"{entry.name} Exit", matrix, 'EXIT')
        item.empty_display_size = entry.empty_display_size
        item.sluice.entry = entry
        return item

    def _stay(self, context, entry):
        """An exit on the entry itself, which goes where the entry goes: the light leaves as it came."""
        item = self._add_exit(context, entry, entry.matrix_world)
        item.parent = entry
        item.matrix_parent_inverse.identity()
        item.matrix_basis.identity()
        return item


class SLUICE_OT_add_edit(_Change, bpy.types.Operator):
    """Add an entry that captures light, and what becomes of it: on the selected faces, or at the 3D cursor"""

    bl_idname = "sluice.add_edit"
    bl_label = "Add Light Edit"
    bl_options = {'REGISTER', 'UNDO'}

    expression: StringProperty(name="Expression", description="Which light the entry captures", default="LS+", maxlen=1024)
    name: StringProperty(name="Name", description="What the entry is called", default="Light Edit", options={'SKIP_SAVE'})
    action: EnumProperty(name="Action", description="What becomes of the light", items=_ACTION_ITEMS, default='MOVE')
    size: FloatProperty(name="Size", description="Side of the entry where no faces are selected; 0: by its distance from the eye",
                        subtype='DISTANCE', default=0.0, min=0.0, soft_max=10.0)

    @classmethod
    def poll(cls, context):
        return context.scene is not None and context.mode in {'OBJECT', 'EDIT_MESH'}

    def execute(self, context):
        matrix, on_faces = places.find(context, self.size)
        if context.mode != 'OBJECT':
            bpy.ops.object.mode_set(mode='OBJECT')
        entry = new_empty(context, self.name, matrix, 'ENTRY')
        entry.sluice.expression = self.expression
        if self.action == 'COPY' and not on_faces:  # the cursor is where the entry lies
            self._stay(context, entry)
            touched = self._add_exit(context, entry, Matrix(placement.beside(matrix)))
        else:
            touched = self.change(context, entry, self.action)
        select_only(context, [touched], touched)
        return {'FINISHED'}

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "name")
        layout.prop(self, "expression")
        layout.prop(self, "action")
        layout.prop(self, "size")
        self.draw_numbers(layout)


class SLUICE_OT_change_light(_Change, bpy.types.Operator):
    """Decide what becomes of the light that this edit's entry takes"""

    bl_idname = "sluice.change_light"
    bl_label = "Change Light"
    bl_options = {'REGISTER', 'UNDO'}

    action: EnumProperty(name="Action", description="What becomes of the light", items=_ACTION_ITEMS, default='COPY')
    to_cursor: BoolProperty(name="To Cursor", description="Where the light shall go, for Move", default=False, options={'SKIP_SAVE'})

    @classmethod
    def poll(cls, context):
        entry = entry_of(context.object)
        return entry is not None and entry.library is None and context.mode == 'OBJECT'

    @classmethod
    def description(cls, _context, properties):
        if properties.action == 'MOVE' and properties.to_cursor:
            return "The exit goes to the 3D cursor, and lies on the surface there"
        return next(description for name, _label, description, _icon in ACTIONS if name == properties.action)

    def execute(self, context):
        entry = entry_of(context.object)
        if self.action == 'MOVE' and self.to_cursor:
            touched = self._lay_at_cursor(context, self._exit_to_move(context, entry), entry)
        else:
            touched = self.change(context, entry, self.action)
        select_only(context, [touched], touched)
        return {'FINISHED'}

    def _exit_to_move(self, context, entry):
        """The active one, else the first, else a new one."""
        exits = exits_of(entry)
        return context.object if context.object in exits else exits[0] if exits else self._stay(context, entry)

    def draw(self, _context):
        self.layout.use_property_split = True
        self.layout.prop(self, "action")
        if self.action == 'MOVE':
            self.layout.prop(self, "to_cursor")
        self.draw_numbers(self.layout)


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
        item = new_empty(context, f"{entry.name} Exit", Matrix(placement.beside(source.matrix_world)), 'EXIT')
        item.empty_display_size = source.empty_display_size
        item.sluice.entry = entry
        if source.sluice.role == 'EXIT':
            for name in ("offset", "intensity", "hue_shift", "tint", "keep_brightness", "intensity_texture", "hue_shift_texture",
                         "normal_map"):
                setattr(item.sluice, name, getattr(source.sluice, name))
        select_only(context, [item], item)
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
        select_only(context, found, found[0])
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
        select_only(context, [item], item)
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


class _KindsMenu:
    """The kinds of light that one action can be done to."""

    action = 'MOVE'

    def draw(self, _context):
        for kind in kinds.ARRIVING:
            row = self.layout.operator("sluice.add_edit", text=kind.label, icon=compat.icon(kind.icon, 'LIGHT'))
            row.name, row.expression, row.action = kind.label, kind.expression, self.action


_kinds_menus = [type(f"SLUICE_MT_{name.lower()}_light", (_KindsMenu, bpy.types.Menu), {"bl_label": label, "action": name})
                for name, label, _description, _icon in ACTIONS]


class SLUICE_MT_add_edit(bpy.types.Menu):
    bl_idname = "SLUICE_MT_add_edit"
    bl_label = "Light Edit"

    def draw(self, _context):
        for menu, (_name, label, _description, icon) in zip(_kinds_menus, ACTIONS):
            self.layout.menu(menu.__name__, text=label, icon=icon)
        self.layout.separator()
        self.layout.operator_context = 'INVOKE_DEFAULT'
        self.layout.operator("sluice.edit_light_here", icon='VIEWZOOM')


class SLUICE_MT_change_light(bpy.types.Menu):
    """What becomes of the light of the active edit"""

    bl_label = "Change Light"

    def draw(self, _context):
        for name, label, _description, icon in ACTIONS:
            self.layout.operator("sluice.change_light", text="Copy to Cursor" if name == 'COPY' else label, icon=icon).action = name
            if name == 'MOVE':
                to_cursor = self.layout.operator("sluice.change_light", text="Move to Cursor", icon='CURSOR')
                to_cursor.action, to_cursor.to_cursor = name, True


def draw_add_menu(self, context):
    if context.engine == 'SLUICE':
        self.layout.menu("SLUICE_MT_add_edit", icon=compat.icon('LIGHTPROBE_PLANAR', 'LIGHT'))


_classes = (SLUICE_OT_add_edit, SLUICE_OT_change_light, SLUICE_OT_add_exit, SLUICE_OT_select_exits, SLUICE_OT_select_one,
            SLUICE_OT_link_exits, *_kinds_menus, SLUICE_MT_add_edit, SLUICE_MT_change_light)
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
