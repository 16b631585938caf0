# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own panels that hold for Sluice too: our name is added to their COMPAT_ENGINES, and taken away again on unregister. No panel
is among them whose options Sluice ignores; panels.py has our own for lamps and visibility. Also the shader nodes in the Add menu."""
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from .interface import ENGINE

_EXCLUDED = {
    # Our own ones are in panels.py.
    "DATA_PT_light", "NODE_DATA_PT_light", "DATA_PT_area", "DATA_PT_spot", "OBJECT_PT_visibility", "RENDER_PT_simplify",
    "RENDER_PT_simplify_viewport", "RENDER_PT_simplify_render",
    # Their options have no effect here.
    "DATA_PT_falloff_curve", "DATA_PT_camera_stereoscopy", "RENDER_PT_stereoscopy", "RENDER_PT_output_views",
    "DATA_PT_volume_render", "WORLD_PT_mist",
}
_EXCLUDED_WORDS = ("freestyle", "lightprobe", "hair", "gpencil", "grease")
# These panels for nodes and depth of field are meant for EEVEE or Cycles by name.
_NAMED = (
    "EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface", "MATERIAL_PT_preview", "EEVEE_WORLD_PT_surface",
    "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture",
)
# The Add menu shows these nodes for Cycles and EEVEE only.
_SHADERS = (
    "ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfGlass",
    "ShaderNodeBsdfRefraction", "ShaderNodeBsdfTranslucent", "ShaderNodeBsdfTransparent", "ShaderNodeEmission",
    "ShaderNodeBackground", "ShaderNodeMixShader", "ShaderNodeAddShader", "ShaderNodeOutputMaterial", "ShaderNodeOutputWorld",
)
_adopted: list[Any] = []  # The panels that carry our name because we put it there.


def compatible_panels() -> Iterator[Any]:
    """The native panels that shall show when Sluice is the engine."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines is None or panel.__name__ in _EXCLUDED:
            continue
        if any(word in panel.__name__.lower() for word in _EXCLUDED_WORDS):
            continue
        if 'BLENDER_RENDER' in engines or panel.__name__ in _NAMED:
            yield panel


class SLUICE_MT_add_shader(bpy.types.Menu):
    bl_idname = "SLUICE_MT_add_shader"
    bl_label = "Sluice Shader"

    def draw(self, context: bpy.types.Context) -> None:
        world = context.space_data.shader_type == 'WORLD'
        for name in _SHADERS:
            node = getattr(bpy.types, name, None)
            if node is None or (name.endswith(("World", "Background")) != world and "Emission" not in name and "Shader" != name[-6:]):
                continue
            entry = self.layout.operator("node.add_node", text=node.bl_rna.name)
            entry.type, entry.use_transform = name, True


def draw_add_shader(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The entry Sluice Shader in the node editor's Add menu."""
    if context.engine == ENGINE and context.space_data.tree_type == 'ShaderNodeTree':
        self.layout.menu("SLUICE_MT_add_shader", icon='NODE_MATERIAL')


def register() -> None:
    for panel in compatible_panels():
        if ENGINE not in panel.COMPAT_ENGINES:
            panel.COMPAT_ENGINES.add(ENGINE)
            _adopted.append(panel)
    bpy.utils.register_class(SLUICE_MT_add_shader)
    bpy.types.NODE_MT_add.append(draw_add_shader)


def unregister() -> None:
    bpy.types.NODE_MT_add.remove(draw_add_shader)
    bpy.utils.unregister_class(SLUICE_MT_add_shader)
    for panel in _adopted:
        panel.COMPAT_ENGINES.discard(ENGINE)
    _adopted.clear()
