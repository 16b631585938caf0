# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes in View Layer Properties: a switch for each that a picture may have beside Combined. Blender's own panel for them shows
options of EEVEE's, so it stays away (native_panels.py)."""
from typing import Any

import bpy

from . import compat, denoising, passes, registration
from .interface import Panel, column_of, sentence

_GROUPS = {"Data": ("Depth", "Normal", "Albedo"), "Light": ("Direct", "Caustics", "Edited", "Indirect", "Emission"),
           "Quality": ("Noise", "Bias")}


class SLUICE_PT_passes(Panel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: bpy.types.Context) -> None:
        scene: Any = context.scene
        view_layer: Any = context.view_layer
        column, links = column_of(self), passes.linked(scene, view_layer.name)
        for heading, names in _GROUPS.items():
            group = column.column(heading="" if heading == "Data" else heading)
            if heading == "Data":
                _draw_combined(group, heading)
            for name in names:
                switch = passes.switch_of(name, view_layer)
                if switch is None:
                    continue
                row = group.row()
                row.prop(*switch, text=name)
                if name in links:
                    row.label(text="", icon='LINKED')
            column.separator()
        if links & {item.name for item in passes.fixed_passes()}:
            column.label(text="The compositor asks for it too", icon='LINKED')
        _draw_denoising(column, context)


def _draw_denoising(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """Draws what removes noise: the operator, and the switch where it can do something or is on."""
    settings: Any = context.view_layer.sluice
    region: Any = context.region
    has_node = compat.has_denoise_node()
    if settings.use_denoise or not has_node:
        layout.column(heading="Denoising").prop(settings, "use_denoise")
    is_missing = settings.use_denoise and not denoising.is_there()
    if is_missing:
        sentence(layout, region, denoising.MISSING, 'ERROR')
    if has_node or is_missing or not settings.use_denoise:
        layout.operator("sluice.set_up_denoising", icon='NODE_COMPOSITING')


def _draw_combined(layout: bpy.types.UILayout, heading: str) -> None:
    """Draws what has no switch, in line with the switches."""
    row = layout.split(factor=0.4)
    left = row.row()
    left.alignment = 'RIGHT'
    left.label(text=heading)
    row.label(text="Combined", icon='CHECKMARK')


_classes = (SLUICE_PT_passes,)

register, unregister = registration.of_classes(*_classes)
