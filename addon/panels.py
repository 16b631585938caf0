# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: render settings, the edit on an Empty (with its expression checked as it is typed), lamps, visibility."""
import functools
import textwrap

import bpy

from . import core, operators

ENGINE = 'SLUICE'


class _Panel:
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


def _column(panel):
    panel.layout.use_property_split = True
    panel.layout.use_property_decorate = True
    return panel.layout.column()


def _sentence(layout, region, text, icon):
    """A sentence in as many lines as the region's width asks for."""
    scale = bpy.context.preferences.system.ui_scale
    width = max(14, int(region.width / (7.2 * scale)) - 8)
    box = layout.column(align=True)
    box.scale_y = 0.8
    for number, line in enumerate(textwrap.wrap(text, width)):
        box.label(text=line, icon=icon if number == 0 else 'BLANK1')


# --- render ----------------------------------------------------------------------------------------------------------------


class _RenderPanel(_Panel):
    bl_context = "render"


class SLUICE_PT_sampling(_RenderPanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context):
        settings, column = context.scene.sluice, _column(self)
        try:
            core.load()
        except core.CoreMissing as missing:
            alert = column.column()
            alert.alert = True
            _sentence(alert, context.region, str(missing), 'ERROR')
        column.prop(settings, "passes")
        column.prop(settings, "photons")
        column.separator()
        column.prop(settings, "error_target")
        column.prop(settings, "time_limit")
        column.separator()
        row = column.row(align=True)
        row.prop(settings, "seed")
        row.prop(settings, "use_animated_seed", text="", icon='TIME')


class SLUICE_PT_effects(_RenderPanel, bpy.types.Panel):
    bl_label = "Light"

    def draw(self, context):
        settings, column = context.scene.sluice, _column(self)
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

    def draw(self, context):
        settings, column = context.scene.sluice, _column(self)
        column.prop(settings, "max_depth")
        column.prop(settings, "specular_threshold")


class SLUICE_PT_film(_RenderPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        render, column = context.scene.render, _column(self)
        column.prop(render, "filter_size")
        column.prop(render, "film_transparent", text="Transparent")


class SLUICE_PT_performance(_RenderPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        render, column = context.scene.render, _column(self)
        column.prop(render, "threads_mode")
        sub = column.column()
        sub.enabled = render.threads_mode == 'FIXED'
        sub.prop(render, "threads", text="Threads")
        column.prop(render, "preview_pixel_size", text="Viewport Pixel Size")


class SLUICE_PT_simplify(_RenderPanel, bpy.types.Panel):
    bl_label = "Simplify"
    bl_options = {'DEFAULT_CLOSED'}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def draw(self, context):
        render, column = context.scene.render, _column(self)
        column.active = render.use_simplify
        column.prop(render, "simplify_subdivision", text="Max Subdivision Viewport")
        column.prop(render, "simplify_subdivision_render", text="Render")


# --- edits -----------------------------------------------------------------------------------------------------------------


@functools.lru_cache(maxsize=64)
def _check(text, names):
    """(side, warnings, None) or (None, (), error) of an expression; kept, since panels are drawn many times a second."""
    try:
        found = core.load().check_expression(text, list(names))
    except ValueError as error:
        return None, (), (getattr(error, "column", None), str(error))
    except core.CoreMissing as missing:
        return None, (), (None, str(missing))
    return found["side"], tuple(found["warnings"]), None


def _known_names():
    """Every name an expression may use."""
    worlds = (world.name for world in bpy.data.worlds)
    return tuple(sorted({*bpy.data.objects.keys(), *bpy.data.collections.keys(), *worlds}))


def _near(text, column):
    """A few characters round a place in an expression, the place marked."""
    place = min(column - 1, len(text))
    before, after = text[:place], text[place:]
    return ("…" + before[-7:] if len(before) > 8 else before) + "▸" + (after[:7] + "…" if len(after) > 8 else after)


def _draw_expression(layout, region, edit):
    side, warnings, error = _check(edit.expression, _known_names())
    layout.label(text="Expression")
    row = layout.row()
    row.use_property_split = False  # expressions are long: the whole width
    row.alert = error is not None
    row.prop(edit, "expression", text="")
    if error is not None:
        column, message = error
        alert = layout.column()
        alert.alert = True
        _sentence(alert, region, message if column is None else f"Column {column}, {_near(edit.expression, column)}: {message}", 'ERROR')
        return
    layout.label(text="Acts on light paths" if side == 'light' else "Acts on what the eye sees", icon='CHECKMARK')
    for warning in warnings:
        _sentence(layout, region, warning, 'INFO')


def _halves(layout):
    """A row for a name, left, and for numbers, right."""
    split = layout.split(factor=0.5, align=True)
    left = split.row(align=True)
    left.alignment = 'LEFT'
    return left, split.row(align=True)


def _draw_exits(layout, entry):
    exits = operators.exits_of(entry)
    header = layout.row()
    header.label(text="Exits" if exits else "No exit: the light is absorbed", icon='EXPORT')
    header.operator("sluice.add_exit", text="", icon='ADD')
    header.operator("sluice.select_exits", text="", icon='RESTRICT_SELECT_OFF')
    if not exits:
        return
    box = layout.box().column(align=True)
    box.use_property_split = box.use_property_decorate = False
    for item in exits:
        name, numbers = _halves(box)
        name.operator("sluice.select_one", text=item.name, emboss=False).name = item.name
        numbers.prop(item.sluice, "intensity", text="")
        numbers.prop(item.sluice, "hue_shift", text="")


def _draw_entry(layout, region, item):
    edit = item.sluice
    body = layout.column()
    body.active = edit.enabled
    _draw_expression(body, region, edit)
    body.separator()
    body.prop(edit, "amount")
    body.prop(edit, "feather")
    body.prop(edit, "repeat")
    layout.separator()
    _draw_exits(layout, item)


def _draw_exit(layout, edit):
    row = layout.row(align=True)
    row.alert = edit.entry is None
    row.prop(edit, "entry")
    if edit.entry is not None:
        row.operator("sluice.select_one", text="", icon='RESTRICT_SELECT_OFF').name = edit.entry.name
    else:
        layout.label(text="Choose the entry whose light leaves here", icon='ERROR')
    layout.separator()
    layout.prop(edit, "intensity")
    layout.prop(edit, "hue_shift")
    layout.prop(edit, "keep_brightness")


def draw_edit(layout, region, item):
    """The whole panel of an edit's Empty."""
    edit = item.sluice
    layout.row().prop(edit, "role", expand=True)
    layout.use_property_split = True
    if edit.role == 'NONE':
        return
    column = layout.column()
    column.separator()
    if edit.role == 'ENTRY':
        _draw_entry(column, region, item)
    else:
        _draw_exit(column, edit)
    place = layout.column()
    place.prop(edit, "order")
    place.prop(edit, "offset")


class _EditPanel(_Panel):
    bl_label = "Light Edit"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.object is not None and context.object.type == 'EMPTY'

    def draw_header(self, context):
        if context.object.sluice.role == 'ENTRY':
            self.layout.prop(context.object.sluice, "enabled", text="")

    def draw(self, context):
        draw_edit(self.layout, context.region, context.object)


class SLUICE_PT_edit(_EditPanel, bpy.types.Panel):
    bl_context = "data"


class SLUICE_PT_edit_sidebar(_EditPanel, bpy.types.Panel):
    bl_space_type = 'VIEW_3D'
    bl_region_type = 'UI'
    bl_category = "Sluice"


# --- lamps and objects -------------------------------------------------------------------------------------------------------


class SLUICE_PT_lamp(_Panel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light is not None

    def draw(self, context):
        lamp = context.light
        self.layout.row().prop(lamp, "type", expand=True)
        column = _column(self)
        column.prop(lamp, "color")
        if hasattr(lamp, "use_temperature"):  # 4.5
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
    def _draw_area(column, lamp):
        column.prop(lamp, "shape")
        if lamp.shape in {'SQUARE', 'DISK'}:
            column.prop(lamp, "size")
        else:
            column.prop(lamp, "size", text="Size X")
            column.prop(lamp, "size_y", text="Y")
        if hasattr(lamp, "spread"):
            column.prop(lamp, "spread")


class SLUICE_PT_visibility(_Panel, bpy.types.Panel):
    bl_label = "Visibility"
    bl_context = "object"
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.object is not None

    def draw(self, context):
        item, column = context.object, _column(self)
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
    SLUICE_PT_performance,
    SLUICE_PT_edit, SLUICE_PT_edit_sidebar, SLUICE_PT_lamp, SLUICE_PT_visibility,
)


def register():
    for cls in _classes:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
    _check.cache_clear()
