# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered mode of the 3D view: streams the passes of a session whose camera is the view, coarse pixels first. The core's threads
render; Blender's only copies the last finished image and draws it. Nothing here raises: what went wrong is shown as text."""
import functools
import weakref

import bpy
import numpy as np

from . import core, export, final, status
from .export.camera import export_view
from .export.names import Names
from .export.settings import export_settings

_LEVELS = (8, 2, 1)  # pixel sizes: one pass of each coarse one, so that there is something to see at once
_COARSE_PHOTONS = 50000
_POLL = 0.1  # seconds between two looks at the session
_HALF_MAX = 65000.0  # the texture is half float: above 65520 it would hold Inf, and the view turn black
_IGNORED = {"Brush", "Screen", "Text", "WindowManager", "WorkSpace", "Palette", "Sound"}


class View:
    """One 3D view: the scene as it was last copied, the session that renders it, the last image."""

    def __init__(self):
        self.description = None  # without camera and frame
        self.settings = None
        self.session = None
        self.seen = None  # region's size, projection, matrices that the session renders
        self.level = 0
        self.texture = None
        self.shown_pass = 0
        self.watched = False  # by a timer

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
        view.seen = None
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
        if view is None:
            return
        if view.description is not None:  # else something failed: its message stands over the last image
            _follow_view(view, context)
            _refresh(engine, view, depsgraph.scene)
            _watch(engine, view)
        _draw_image(view, context.region)
    except Exception as error:
        _fail(engine, error)


def _follow_view(view, context):
    region, region_3d = context.region, context.region_data
    seen = ((region.width, region.height), region_3d.is_perspective, tuple(map(tuple, region_3d.view_matrix)),
            tuple(map(tuple, region_3d.window_matrix)))
    if seen != view.seen:
        view.stop()
        view.seen, view.level = seen, 0


def _start(engine, view, scene):
    """The session of the current level."""
    size, is_perspective, view_matrix, window_matrix = view.seen
    scale = _LEVELS[view.level] * max(1, int(engine.get_preview_pixel_size(scene)))
    settings = dict(view.settings)
    if view.level + 1 < len(_LEVELS):
        settings.update(passes=1, photons=min(settings["photons"], _COARSE_PHOTONS))
    coarse = tuple(max(1, side // scale) for side in size)
    camera, frame = export_view(view_matrix, window_matrix, is_perspective, coarse)
    view.shown_pass = 0
    view.session = core.new_session()
    view.session.start({**view.description, "camera": camera, "frame": frame}, settings)


def _refresh(engine, view, scene):
    """Takes a new image if there is one, and goes on to finer pixels when a coarse session is done."""
    if view.session is None:
        _start(engine, view, scene)
    finished = view.session.wait(0)
    progress = view.session.progress()
    if progress["state"] == 'failed':
        raise final.core_failure(progress)
    if progress["pass"] > view.shown_pass:
        images = view.session.snapshot(["Combined"])
        if images is not None:
            view.texture = _make_texture(images["Combined"])
            view.shown_pass = progress["pass"]
    engine.update_stats("Sluice", status.line(progress))
    if finished and view.level + 1 < len(_LEVELS):
        view.level += 1
        _start(engine, view, scene)


def _watch(engine, view):
    """Asks for a redraw when the session has news. Asking in every draw would draw without a pause and starve the render."""
    if not view.watched:
        view.watched = True
        bpy.app.timers.register(functools.partial(_look, weakref.ref(engine), view), first_interval=_POLL / 2)


def _look(engine_reference, view):
    """A timer: seconds until it looks again, None to end."""
    engine = engine_reference()
    if engine is None or view.session is None:
        view.watched = False
        return None
    finished = view.session.wait(0)
    try:
        if finished or view.session.progress()["pass"] > view.shown_pass or view.shown_pass == 0:
            engine.tag_redraw()
    except ReferenceError:  # Blender has freed its half of the engine
        view.stop()
        finished = True
    view.watched = not finished
    return None if finished else _POLL


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
    """Shows the sentence in the view and stops; the next change of the scene tries again, with a copy of its own."""
    failure = final.as_failure(error)
    if engine.view is not None:
        engine.view.stop()
        engine.view.description = None
    engine.update_stats("Sluice", str(failure))
    engine.tag_redraw()


def free(view):
    """The engine goes away, or None: nothing of its view may run on."""
    if view is not None:
        view.stop()
