# SPDX-License-Identifier: GPL-3.0-or-later
"""One click for a picture without noise: the compositor's Denoise node, or the Python package where this Blender's node does nothing."""
from typing import Any

import bpy

from . import compat, denoise_nodes, denoising, registration
from .interface import ENGINE

_NO_NODE = "This Blender is built without OpenImageDenoise, which its Denoise node needs"


class SLUICE_OT_set_up_denoising(bpy.types.Operator):
    """Denoise the picture of this view layer: switches on the passes Albedo and Normal and puts a Denoise node behind Render Layers in the
    compositor. In Blenders without OpenImageDenoise it switches on Denoise, which takes the Python package pyoidn"""

    bl_idname = "sluice.set_up_denoising"
    bl_label = "Set Up Denoising"
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.engine == ENGINE and context.view_layer is not None and context.scene.library is None

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene: Any = context.scene
        view_layer: Any = context.view_layer
        if compat.has_denoise_node():
            if not denoise_nodes.set_up(scene, view_layer):
                self.report({'WARNING'}, "The compositor's output shows other things than this view layer: "
                            "link the Denoise node's Image yourself")
            return {'FINISHED'}
        if not denoising.is_there():
            self.report({'WARNING'}, f"{_NO_NODE}, and {denoising.missing()}")
            return {'CANCELLED'}
        view_layer.sluice.use_denoise = True
        self.report({'INFO'}, f"{_NO_NODE}: final renders of this view layer are denoised at their end by the Python package {denoising.PACKAGE}")
        return {'FINISHED'}


register, unregister = registration.of_classes(SLUICE_OT_set_up_denoising)
