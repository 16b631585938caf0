# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered mode of the 3D view: streams the passes of a session whose camera is the view. The core's threads render; Blender's only
copies the last finished image and draws it. Nothing here raises: what went wrong is shown as text in the view."""
import time

import numpy as np

from . import core, export, final, status
from .export.camera import export_view
from .export.names import Names
from .export.settings import export_settings

_HALF_MAX = 65000.0  # the texture is half float: above 65520 it would hold Inf, and the view turn black
_IGNORED = {"Brush", "Screen", "Text", "WindowManager", "WorkSpace", "Palette", "Sound"}


class View:
    """One 3D view: the scene as it was last copied, the session that renders it, the last image."""

    def __init__(self):
        self.description = None  # without camera and frame
        self.settings = None
        self.session = None
        self.seen = None  # matrices and size that the session renders
        self.texture = None
        self.message = ""
        self.shown_pass, self.next_image = 0, 0.0

    def stop(self):
        if self.session is not None:
            self.session.cancel()
            self.session = None


def update(engine, context, depsgraph):
    """The scene changed: copies it anew. The first call comes with no list of updates."""
    try:
        view = engine.view = engine.view or View()
        if view.description is not None and not _concerns_us(depsgraph):
            return
        view.stop()
        view.seen, view.message = None, ""
        scene = depsgraph.scene_eval
        exported = export.Context(Names(context.blend_data.collections))
        view.settings = export_settings(scene)
        view.settings["time_limit"] = 0.0
        view.description = export.export_scene(depsgraph, None, None, exported)
    except Exception as error:
        _fail(engine, error)


def _concerns_us(depsgraph):
    return any(update.id.bl_rna.identifier not in _IGNORED for update in depsgraph.updates)


def draw(engine, context, depsgraph):
    """Draws the last finished image; starts over when the view moved (orbiting calls draw alone)."""
    try:
        view = engine.view
        if view is None or view.description is None:
            return
        _follow_view(engine, view, context, depsgraph)
        _refresh(engine, view)
        _draw_image(view, context.region)
    except Exception as error:
        _fail(engine, error)


def _follow_view(engine, view, context, depsgraph):
    region, region_3d = context.region, context.region_data
    scale = max(1, int(engine.get_preview_pixel_size(depsgraph.scene)))
    size = (max(1, region.width // scale), max(1, region.height // scale))
    seen = (size, region_3d.is_perspective, tuple(map(tuple, region_3d.view_matrix)), tuple(map(tuple, region_3d.window_matrix)))
    if seen == view.seen:
        return
    view.stop()
    view.seen, view.shown_pass, view.next_image = seen, 0, 0.0
    camera, frame = export_view(region_3d.view_matrix, region_3d.window_matrix, region_3d.is_perspective, size)
    view.session = core.new_session()
    view.session.start({**view.description, "camera": camera, "frame": frame}, view.settings)


def _refresh(engine, view):
    """Takes a new image if there is one and it is time (at most 10 a second), and asks to be drawn again while there is more."""
    if view.session is None:
        return
    finished = view.session.wait(0)
    progress = view.session.progress()
    if progress["state"] == 'failed':
        failure = final.core_failure(progress)
        view.stop()
        raise failure
    now = time.monotonic()
    if progress["pass"] > view.shown_pass and (finished or now >= view.next_image):
        images = view.session.snapshot(["Combined"])
        if images is not None:
            view.texture = _make_texture(images["Combined"])
            view.shown_pass, view.next_image = progress["pass"], now + 0.1
    engine.update_stats("Sluice", status.line(progress))
    if not finished:
        engine.tag_redraw()


def _make_texture(pixels):
    import gpu  # not at the top: without a window the module is there but must not be asked
    height, width = pixels.shape[:2]
    clamped = np.ascontiguousarray(np.clip(pixels, 0, _HALF_MAX), np.float32)
    buffer = gpu.types.Buffer('FLOAT', width * height * 4, clamped.reshape(-1))
    return gpu.types.GPUTexture((width, height), format='RGBA16F', data=buffer)


def _draw_image(view, region):
    if view.texture is None:
        return
    import gpu
    from gpu_extras.presets import draw_texture_2d
    gpu.state.blend_set('ALPHA_PREMULT')
    draw_texture_2d(view.texture, (0, 0), region.width, region.height)  # scene-linear: Blender applies the view transform
    gpu.state.blend_set('NONE')


def _fail(engine, error):
    """Shows the sentence in the view and stops; the next change of the scene tries again."""
    failure = final.as_failure(error)
    if engine.view is not None:
        engine.view.stop()
        engine.view.message = str(failure)
    engine.update_stats("Sluice", str(failure))


def free(view):
    """The engine goes away, or None: nothing of its view may run on."""
    if view is not None:
        view.stop()
