# SPDX-License-Identifier: GPL-3.0-or-later
"""A plugin for mypy: Blender's types bear the properties that the add-on registers at run time (scene.sluice and its like).

The stubs of fake-bpy-module describe Blender alone. What addon/properties.py and addon/edit_list.py add to its classes is declared
here, and what the stubs have wrong. The type is Any, since properties written as annotations (`passes: IntProperty(...)`) mean nothing to mypy."""
from collections.abc import Callable

from mypy.plugin import ClassDefContext, Plugin
from mypy.plugins.common import add_attribute_to_class
from mypy.types import AnyType, TypeOfAny

ATTRIBUTES = {
    # the add-on's own
    "bpy.types.Object": ("sluice", "matrix_world", "data"),
    "bpy.types.Scene": ("sluice",),
    "bpy.types.ViewLayer": ("sluice",),
    "bpy.types.PropertyGroup": ("expression",),
    "bpy.types.WindowManager": ("sluice_edit_row",),
    # what the stubs have wrong, or as a union of many types that the code tells apart by `type`
    "bpy.types.ID": ("original", "bl_rna"),
    "bpy.types.UILayout": ("bl_rna",),
    "bpy.types.Context": ("space_data", "temp_override"),
    "bpy.types.DepsgraphObjectInstance": ("object", "parent"),
    "bpy.types.Depsgraph": ("scene", "scene_eval", "view_layer_eval"),
    "bpy.types.Image": ("pixels",),
    "bpy.types.Modifier": ("node_group",),
    "bpy.types.Node": ("is_active_output", "mode", "node_tree"),
    "bpy.types.RenderPass": ("rect",),
    "bpy.types.Space": ("region_3d",),
    "bpy.types.SpaceView3D": ("draw_handler_add", "draw_handler_remove"),
    "bpy.types.View3DCursor": ("matrix",),
}


def _add(context: ClassDefContext) -> None:
    for name in ATTRIBUTES.get(context.cls.fullname, ()):
        add_attribute_to_class(context.api, context.cls, name, AnyType(TypeOfAny.explicit), overwrite_existing=True)


class BlenderTypes(Plugin):
    """Adds the attributes when mypy reads the stubs' classes."""

    def get_base_class_hook(self, fullname: str) -> Callable[[ClassDefContext], None] | None:
        """mypy asks for each base of each class: every class of Blender has one of these two."""
        return _add if fullname in {"bpy.types.ID", "bpy.types.bpy_struct"} else None


def plugin(_version: str) -> type[Plugin]:
    """The entry point that mypy looks for."""
    return BlenderTypes
