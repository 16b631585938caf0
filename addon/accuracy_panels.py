# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render simulates and how accurate it is, in Render Properties: what will run and why, the last render's error by effect and
edit, its curve as an image."""
from collections.abc import Mapping
from typing import Any

import bpy

from . import accuracy_curve, edit_statistics, registration, render_progress, render_statistics, simulated
from .interface import Explains, Panel, sentence

IMAGE = "Sluice Accuracy"


class _RenderPanel(Panel):
    bl_context = "render"
    bl_options = {'DEFAULT_CLOSED'}


class SLUICE_PT_simulated(_RenderPanel, bpy.types.Panel):
    bl_label = "What Will Be Simulated"
    bl_parent_id = "SLUICE_PT_effects"

    def draw(self, context: bpy.types.Context) -> None:
        scene, view_layer = context.scene, context.view_layer
        region: Any = context.region
        groups = (("Effects", simulated.effects(scene)), ("Light Edits", simulated.edits(scene)),
                  ("Light Layers", simulated.layers(view_layer)), ("Passes", simulated.render_passes(scene, view_layer)))
        for heading, told in groups:
            if not told:
                continue
            self.layout.label(text=heading)
            box = self.layout.box().column(align=True)
            for text, icon in told:
                sentence(box, region, text, icon)


class SLUICE_OT_explain_error(Explains, bpy.types.Operator):
    bl_idname = "sluice.explain_error"
    bl_label = "What This Number Is"
    bl_description = render_progress.ERROR


class SLUICE_OT_show_curve(bpy.types.Operator):
    """Draw how the error of the last render fell with time, into the image Sluice Accuracy, and show it in an image editor if there is one"""

    bl_idname = "sluice.show_curve"
    bl_label = "Show Curve"
    bl_options = {'REGISTER'}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return bool(render_statistics.last().accuracy)

    def execute(self, context: bpy.types.Context) -> set[str]:
        image = _image_of(accuracy_curve.draw(render_statistics.last().accuracy))
        editors = [area for area in (context.screen.areas if context.screen else ()) if area.type == 'IMAGE_EDITOR']
        if editors:
            min(editors, key=lambda area: area.ui_type != 'IMAGE_EDITOR').spaces.active.image = image
        else:
            self.report({'INFO'}, f"The curve is in the image {IMAGE}: open it in an image editor")
        return {'FINISHED'}


def _image_of(pixels: Any) -> bpy.types.Image:
    """The image of this name with these pixels; it is packed, so that Blender asks for no file when it ends."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(IMAGE)
    if image is not None and tuple(image.size) != (width, height):
        bpy.data.images.remove(image)
        image = None
    image = image or bpy.data.images.new(IMAGE, width, height)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


class SLUICE_PT_accuracy(_RenderPanel, bpy.types.Panel):
    bl_label = "Accuracy"

    def draw(self, context: bpy.types.Context) -> None:
        found = render_statistics.last()
        layout: Any = self.layout
        region: Any = context.region
        if not found.accuracy:
            what = "This takes 4 passes" if found.progress else "There was no render yet"
            sentence(layout, region, f"The error of the last render is not known. {what}", 'INFO')
            _draw_operators(layout)
            return
        _draw_error(layout, region, found)
        parts, edits = render_statistics.shares(found.accuracy[-1])
        _draw_table(layout, "Effect", parts, True)
        _draw_table(layout, "Light Edit", edits, False)
        layout.operator("sluice.show_curve", icon='GRAPH')
        _draw_operators(layout)


def _draw_operators(layout: bpy.types.UILayout) -> None:
    """Draws what makes pictures better or tells more of them."""
    layout.operator("sluice.set_up_denoising", icon='NODE_COMPOSITING')
    layout.operator("sluice.make_report", icon='TEXT')


def _draw_error(layout: bpy.types.UILayout, region: bpy.types.Region, found: render_statistics.Found) -> None:
    """Draws the error, what makes most of it, and time. A tooltip tells what the number is."""
    row = layout.row()
    column = row.column()
    sentence(column, region, f"Error{' before denoising' if found.denoised else ''} {render_progress.error(dict(found.progress))}", 'INFO', beside=4)
    if found.progress["main_cause"]:
        cause = render_progress.main_cause(found.progress["main_cause"])
        sentence(column, region, cause[0].upper() + cause[1:], 'BLANK1', beside=4)
    sentence(column, region, _time(found.progress, found.seconds), 'TIME', beside=4)
    row.operator("sluice.explain_error", text="", icon='QUESTION', emboss=False)


def _time(progress: Mapping[str, Any], seconds: Mapping[str, float]) -> str:
    """Time per pass, told apart as far as it is known."""
    passes = max(1, progress["pass"])
    kinds = [f"{name} {seconds[name] / passes:.2g} s" for name in ("photons", "view") if seconds.get(name)]
    whole = sum(seconds.get(name, 0) for name in ("photons", "view")) or progress["seconds"]
    return f"{whole / passes:.2g} s a pass" + (f" ({', '.join(kinds)})" if kinds else "") + f", {progress['pass']} passes"


def _draw_table(layout: bpy.types.UILayout, heading: str, rows: list[tuple[str, float, float, float]], has_bias: bool) -> None:
    """Draws what each makes of the error: its share of the square, its noise and its blur."""
    if not rows:
        return
    box = layout.box().column(align=True)
    _draw_row(box, heading, ("Share", "Noise", "Blur" if has_bias else ""))
    for name, share, noise, bias in rows:
        _draw_row(box, name, (edit_statistics.percent(share), render_progress.percent(noise), render_progress.percent(bias) if has_bias else ""))


def _draw_row(layout: bpy.types.UILayout, name: str, cells: tuple[str, str, str]) -> None:
    split = layout.split(factor=0.31)
    split.label(text=name)
    numbers = split.row()
    for cell in cells:
        numbers.label(text=cell)


_classes = (SLUICE_PT_simulated, SLUICE_OT_explain_error, SLUICE_OT_show_curve, SLUICE_PT_accuracy)

register, unregister = registration.of_classes(*_classes)
