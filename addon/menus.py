# SPDX-License-Identifier: GPL-3.0-or-later
"""The menus of light edits: Add ▸ Light Edit, and what becomes of the light of the active edit."""
from typing import TYPE_CHECKING

import bpy

from . import compat, interface, light_kinds

if TYPE_CHECKING:
    _Menu = bpy.types.Menu
else:
    _Menu = object  # Blender wants its own class as a base of registered classes alone.


class _KindsMenu(_Menu):
    """The kinds of light that one action can be done to."""

    action = 'MOVE'

    def draw(self, _context: bpy.types.Context) -> None:
        for kind in light_kinds.ARRIVING:
            row = self.layout.operator("sluice.add_edit", text=kind.label, icon=compat.icon(kind.icon, 'LIGHT'))  # type: ignore[arg-type]
            row.name, row.expression, row.action = kind.label, kind.expression, self.action


_kinds_menus = [type(f"SLUICE_MT_{name.lower()}_light", (_KindsMenu, bpy.types.Menu), {"bl_label": label, "action": name})
                for name, label, _description, _icon in light_kinds.ACTIONS]


class SLUICE_MT_add_edit(bpy.types.Menu):
    bl_idname = "SLUICE_MT_add_edit"
    bl_label = "Light Edit"

    def draw(self, _context: bpy.types.Context) -> None:
        for menu, (_name, label, _description, icon) in zip(_kinds_menus, light_kinds.ACTIONS):
            self.layout.menu(menu.__name__, text=label, icon=icon)  # type: ignore[arg-type]
        self.layout.separator()
        self.layout.operator_context = 'INVOKE_DEFAULT'
        self.layout.operator("sluice.edit_light_here", icon='VIEWZOOM')


class SLUICE_MT_change_light(bpy.types.Menu):
    """What becomes of the light of the active edit"""

    bl_label = "Change Light"

    def draw(self, _context: bpy.types.Context) -> None:
        for name, label, _description, icon in light_kinds.ACTIONS:
            self.layout.operator("sluice.change_light", text="Copy to Cursor" if name == 'COPY' else label, icon=icon).action = name  # type: ignore[arg-type]
            if name == 'MOVE':
                to_cursor = self.layout.operator("sluice.change_light", text="Move to Cursor", icon='CURSOR')
                to_cursor.action, to_cursor.to_cursor = name, True


def draw_add_menu(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The entry Light Edit in Blender's own menus."""
    if context.engine == interface.ENGINE:
        self.layout.menu("SLUICE_MT_add_edit", icon=compat.icon('LIGHTPROBE_PLANAR', 'LIGHT'))  # type: ignore[arg-type]


_classes = (*_kinds_menus, SLUICE_MT_add_edit, SLUICE_MT_change_light)
_menus = ("VIEW3D_MT_add", "VIEW3D_MT_mesh_add", "VIEW3D_MT_edit_mesh_context_menu")


def register() -> None:
    for cls in _classes:
        bpy.utils.register_class(cls)
    for name in _menus:
        getattr(bpy.types, name).append(draw_add_menu)


def unregister() -> None:
    for name in _menus:
        getattr(bpy.types, name).remove(draw_add_menu)
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
