# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine as Blender sees it. The class only forwards: final.py renders frames, viewport.py the 3D view."""
from typing import Any

import bpy

from . import final, passes, viewport


class SluiceRenderEngine(bpy.types.RenderEngine):
    """Photon mapping in which artists edit light."""

    bl_idname = 'SLUICE'
    bl_label = "Sluice"
    bl_use_preview = True
    bl_use_eevee_viewport = True  # EEVEE goes on to draw Material Preview.
    bl_use_shading_nodes_custom = False
    bl_use_postprocess = True
    bl_use_custom_freestyle = True  # Without this, Blender would have us render the meshes of its strokes.

    def __init__(self, *args: Any, **kwargs: Any) -> None:  # Blender 4.4 wants the arguments passed on.
        super().__init__(*args, **kwargs)
        self.job: final.Job | None = None
        self.view: viewport.View | None = None

    def __del__(self) -> None:
        # Blender may have freed its half of the engine already, so only the Python half is asked.
        viewport.free(object.__getattribute__(self, "__dict__").get("view"))
        parent = getattr(super(), "__del__", None)  # Blender 5.0 has one and wants it called.
        if parent is not None:
            parent()

    def update(self, data: bpy.types.BlendData, depsgraph: bpy.types.Depsgraph) -> None:
        final.update(self, data, depsgraph)

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        final.render(self)

    def update_render_passes(self, scene: bpy.types.Scene | None = None, renderlayer: bpy.types.ViewLayer | None = None) -> None:
        if scene is not None and renderlayer is not None:
            passes.register_passes(self, scene, renderlayer)

    def view_update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        viewport.update(self, context, depsgraph)

    def view_draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        viewport.draw(self, context, depsgraph)


def register() -> None:
    bpy.utils.register_class(SluiceRenderEngine)


def unregister() -> None:
    bpy.utils.unregister_class(SluiceRenderEngine)
