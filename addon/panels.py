# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the render settings, of lamps and of what objects show. Those of edits are in edit_panels.py."""
from typing import Any

import bpy

from . import core, denoising, registration
from .interface import Panel, column_of, sentence

# --- render ----------------------------------------------------------------------------------------------------------------


class _RenderPanel(Panel):
    bl_context = "render"


class SLUICE_PT_sampling(_RenderPanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context: bpy.types.Context) -> None:
        settings, column = context.scene.sluice, column_of(self)
        try:
            core.load()
        except core.CoreMissing as missing:
            alert = column.column()
            alert.alert = True
            sentence(alert, context.region, str(missing), 'ERROR')
        column.prop(settings, "passes")
        column.prop(settings, "photons")
        column.prop(settings, "use_adaptive_sampling")
        column.separator()
        column.prop(settings, "error_target")
        column.prop(settings, "time_limit")
        column.separator()
        row = column.row(align=True)
        row.prop(settings, "seed")
        row.prop(settings, "use_animated_seed", text="", icon='TIME')
        column.separator()
        column.prop(settings, "use_preview_denoise")
        if settings.use_preview_denoise and not denoising.is_there():
            sentence(column, context.region, denoising.MISSING, 'ERROR')


class SLUICE_PT_effects(_RenderPanel, bpy.types.Panel):
    bl_label = "Light"

    def draw(self, context: bpy.types.Context) -> None:
        settings, column = context.scene.sluice, column_of(self)
        arrives = column.column(heading="Arriving")
        for name in ("use_direct", "use_caustics", "use_edited", "use_indirect"):
            arrives.prop(settings, name)
        edits = column.column(heading="Light Edits")
        edits.prop(settings, "use_edits", text="Apply")
        sub = column.column()
        sub.active = settings.use_edits
        sub.prop(settings, "max_gates")


class SLUICE_PT_paths(_RenderPanel, bpy.types.Panel):
    bl_label = "Light Paths"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context: bpy.types.Context) -> None:
        settings, column = context.scene.sluice, column_of(self)
        column.prop(settings, "max_depth")
        column.prop(settings, "specular_threshold")


class SLUICE_PT_film(_RenderPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context: bpy.types.Context) -> None:
        render, column = context.scene.render, column_of(self)
        column.prop(render, "filter_size")
        column.prop(render, "film_transparent", text="Transparent")


class SLUICE_PT_performance(_RenderPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context: bpy.types.Context) -> None:
        render, column = context.scene.render, column_of(self)
        column.prop(render, "threads_mode")
        sub = column.column()
        sub.enabled = render.threads_mode == 'FIXED'
        sub.prop(render, "threads", text="Threads")
        column.prop(render, "preview_pixel_size", text="Viewport Pixel Size")


class SLUICE_PT_simplify(_RenderPanel, bpy.types.Panel):
    bl_label = "Simplify"
    bl_options = {'DEFAULT_CLOSED'}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def draw(self, context: bpy.types.Context) -> None:
        render, column = context.scene.render, column_of(self)
        column.active = render.use_simplify
        column.prop(render, "simplify_subdivision", text="Max Subdivision Viewport")
        column.prop(render, "simplify_subdivision_render", text="Render")


# --- lamps and objects -------------------------------------------------------------------------------------------------------


class SLUICE_PT_lamp(Panel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.light is not None

    def draw(self, context: bpy.types.Context) -> None:
        lamp = context.light
        self.layout.row().prop(lamp, "type", expand=True)
        column = column_of(self)
        column.prop(lamp, "color")
        if hasattr(lamp, "use_temperature"):  # since 4.5
            column.prop(lamp, "use_temperature")
            sub = column.column()
            sub.active = lamp.use_temperature
            sub.prop(lamp, "temperature")
        column.prop(lamp, "energy", text="Strength" if lamp.type == 'SUN' else "Power")
        if hasattr(lamp, "exposure"):
            column.prop(lamp, "exposure")
        column.separator()
        if lamp.type == 'SUN':
            column.prop(lamp, "angle")
        elif lamp.type == 'AREA':
            self._draw_area(column, lamp)
        else:
            column.prop(lamp, "shadow_soft_size", text="Radius")
        if lamp.type == 'SPOT':
            column.prop(lamp, "spot_size", text="Spot Size")
            column.prop(lamp, "spot_blend", text="Blend", slider=True)
            column.prop(lamp, "show_cone")
        column.prop(lamp, "use_shadow", text="Cast Shadow")

    @staticmethod
    def _draw_area(column: bpy.types.UILayout, lamp: Any) -> None:
        column.prop(lamp, "shape")
        if lamp.shape in {'SQUARE', 'DISK'}:
            column.prop(lamp, "size")
        else:
            column.prop(lamp, "size", text="Size X")
            column.prop(lamp, "size_y", text="Y")
        if hasattr(lamp, "spread"):
            column.prop(lamp, "spread")


class SLUICE_PT_visibility(Panel, bpy.types.Panel):
    bl_label = "Visibility"
    bl_context = "object"
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and context.object is not None

    def draw(self, context: bpy.types.Context) -> None:
        item, column = context.object, column_of(self)
        column.prop(item, "hide_select", text="Selectable", invert_checkbox=True, toggle=False)
        shown = column.column(heading="Show In")
        shown.prop(item, "hide_viewport", text="Viewports", invert_checkbox=True, toggle=False)
        shown.prop(item, "hide_render", text="Renders", invert_checkbox=True, toggle=False)
        if item.type not in {'EMPTY', 'LIGHT', 'CAMERA'}:
            rays = column.column(heading="Rays")
            rays.prop(item, "visible_camera", text="Camera")
            rays.prop(item, "visible_shadow", text="Shadow")


_classes = (
    SLUICE_PT_sampling, SLUICE_PT_effects, SLUICE_PT_paths, SLUICE_PT_film, SLUICE_PT_simplify,
    SLUICE_PT_performance, SLUICE_PT_lamp, SLUICE_PT_visibility,
)

register, unregister = registration.of_classes(*_classes)
