# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered mode of the 3D view: streams the passes of a session whose camera is the view, coarse pixels first. The core's threads
render; Blender's only copies the last finished image and draws it. Nothing here raises: what went wrong is shown as text.

Orbiting, moving an edit and turning a knob start from what the first session has compiled; all else copies the scene anew. A coarse
image is never given up before it is seen, so that the picture follows a hand that does not stop."""
from __future__ import annotations

import functools
import time
import weakref
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from . import changes, core, denoising, edit_statistics, export, final, passes, preview_denoising, render_progress, render_statistics
from .export.camera import export_view
from .export.description import Description
from .export.scene_names import Names
from .export.settings import export_settings

if TYPE_CHECKING:
    from .engine import SluiceRenderEngine

_LEVELS = (8, 2, 1)  # Sizes of pixels. Each coarse one gets a single pass, so that there is something to see at once.
_COARSE = {8: {"photons": 4096, "pilot_paths": 1 << 11}, 2: {"photons": 50000, "pilot_paths": 1 << 15}}
_POLL, _SOON = 0.1, 0.02  # Seconds between two looks at the session, and before its first image.
_AT_ONCE = 0.03  # A redraw waits so many seconds for the coarsest image, so as to show it itself: less than a hand feels.
# Until a session is done, redraws get this fraction of the time: without a graphics card they take it from the render.
_DRAWING = 0.05
_HALF_MAX = 65000.0  # The texture is half float: above 65520 it would hold Inf, and the view would turn black.


class View:
    """One 3D view: the scene as it was last copied, the session that renders it, the last image."""

    def __init__(self) -> None:
        self.description: Description | None = None  # It lacks camera and frame, which each session gets.
        self.settings: dict[str, Any] | None = None
        self.exported: export.Context | None = None  # The context of the last copy.
        self.roll: tuple[list[str], str | None] | None = None
        self.seen: tuple[Any, ...] | None = None  # The region's size, the kind of projection, the matrices.
        self.base: core.Session | None = None  # The session that compiled the description's things; others start from it.
        self.session: core.Session | None = None
        self.stale = False  # The session renders what is no longer so.
        self.level = 0
        self.cleaner: preview_denoising.Cleaner | None = None  # if the session's pictures are to be denoised
        self.told = False  # Have the session's figures been remembered?
        self.texture: Any = None
        self.shown_pass = 0
        self.watched = False  # A timer looks after the session.
        self.drawn = 0.0  # When the view was drawn last (time.monotonic).
        self.redraw = 0.0  # Seconds that the redraw of the whole window took then.

    def stop(self) -> None:
        if self.session is not None:
            core.retire(self.session)
            self.session = None
        if self.cleaner is not None:
            self.cleaner.stop()
            self.cleaner = None

    @property
    def is_cleaning(self) -> bool:
        """Is a picture being denoised that will be shown?"""
        return self.cleaner is not None and self.cleaner.is_busy


def update(engine: SluiceRenderEngine, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
    """The scene changed: copies what is new. The first call comes with no list of updates."""
    try:
        view = engine.view = engine.view or View()
        kind = changes.THINGS if view.description is None else changes.of(depsgraph)
        data = context.blend_data
        names = Names(data.collections, data.objects, data.worlds)
        if kind == changes.THINGS or kind == changes.EDITS and not _copy_edits(view, depsgraph, names):
            _copy_all(view, depsgraph, names)
        if view.session is not None and view.base is not None and _may_start_over(view):
            _start(engine, view, depsgraph.scene, 0)  # It renders while Blender draws the rest of the window.
    except Exception as error:
        _fail(engine, error)


def _copy_all(view: View, depsgraph: bpy.types.Depsgraph, names: Names) -> None:
    """Copies the scene. After an undo Blender lists everything as changed, so it is compared: what is as it was keeps what was compiled."""
    before, settings = view.description, _settings(depsgraph)
    view.exported = export.Context(names)
    view.description = export.export_scene(depsgraph, None, None, view.exported)
    view.roll = changes.roll(depsgraph)
    if before is None or not changes.same(_things(view.description), _things(before)):
        if view.session is not None and view.session.progress()["state"] == 'compiling':
            view.stop()  # What it compiles is no longer so.
        view.base, view.stale = None, True
    view.stale |= settings != view.settings or not changes.same(view.description, before)
    view.settings = settings


def _things(description: Description) -> Description:
    return {key: value for key, value in description.items() if key not in {"edits", "max_gates"}}


def _copy_edits(view: View, depsgraph: bpy.types.Depsgraph, names: Names) -> bool:
    """Copies edits and settings alone. False: more than those is new."""
    if view.roll != changes.roll(depsgraph) or view.description["specular_threshold"] != depsgraph.scene_eval.sluice.specular_threshold:
        return False
    view.exported.names = names
    known = len(view.description["images"])
    edits, settings = export.export_edits(depsgraph, view.exported), _settings(depsgraph)
    if len(view.description["images"]) != known:
        view.base = None  # What was compiled lacks a texture.
    if settings != view.settings or not changes.same(edits, {key: view.description[key] for key in edits}):
        view.settings, view.stale = settings, True
        view.description.update(edits)
    return True


def _settings(depsgraph: bpy.types.Depsgraph) -> dict[str, Any]:
    found = {**export_settings(depsgraph.scene_eval), "time_limit": 0.0, "use_adaptive_sampling": False, "render_passes": []}
    if depsgraph.scene_eval.sluice.use_preview_denoise and denoising.is_there():
        found["render_passes"] = list(passes.GUIDES)
    # With one seed for all frames, those in which nothing moves are one picture: it goes on.
    return found if found["use_animated_seed"] else {**found, "frame": 0}


def draw(engine: SluiceRenderEngine, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
    """Draws the last finished image; starts over when the view moved (orbiting calls draw alone)."""
    try:
        view = engine.view
        if view is None:
            return
        if view.description is not None:  # Otherwise something failed, and its message stands over the last image.
            _follow_view(view, context)
            _refresh(engine, view, depsgraph.scene)
            if not _at_rest(view):
                _watch(engine, view)
        view.drawn = time.monotonic()
        _draw_image(view, context.region)
        # The timer runs when the whole window is drawn.
        bpy.app.timers.register(functools.partial(_time_redraw, view), first_interval=0)
    except Exception as error:
        _fail(engine, error)


def _follow_view(view: View, context: bpy.types.Context) -> None:
    region, region_3d = context.region, context.region_data
    seen = ((region.width, region.height), region_3d.is_perspective, tuple(map(tuple, region_3d.view_matrix)),
            tuple(map(tuple, region_3d.window_matrix)))
    view.stale |= seen != view.seen
    view.seen = seen


def _start(engine: SluiceRenderEngine, view: View, scene: bpy.types.Scene, level: int) -> None:
    """Starts the session of a level, of the scene as it is now."""
    size, is_perspective, view_matrix, window_matrix = view.seen
    scale = _LEVELS[level] * max(1, int(engine.get_preview_pixel_size(scene)))
    coarse = tuple(max(1, side // scale) for side in size)
    camera, frame = export_view(view_matrix, window_matrix, is_perspective, coarse)
    view.stop()
    view.level, view.shown_pass, view.stale, view.told = level, 0, False, False
    view.session = core.new_session()
    settings = _settings_of_level(view.settings, _LEVELS[level])
    view.cleaner = preview_denoising.Cleaner() if settings["render_passes"] else None
    shot = {**{key: view.description[key] for key in ("edits", "max_gates")}, "camera": camera, "frame": frame}
    if view.base is None or not view.session.start_from(view.base, shot, settings):
        view.session.start({**view.description, **shot}, settings)
        view.base = view.session


def _settings_of_level(settings: dict[str, Any], pixel: int) -> dict[str, Any]:
    if pixel not in _COARSE:
        return {**settings, "explain_edits": True}
    coarse = _COARSE[pixel]
    return {**settings, **coarse, "passes": 1, "render_passes": [], "photons": min(settings["photons"], coarse["photons"])}


def _refresh(engine: SluiceRenderEngine, view: View, scene: bpy.types.Scene) -> None:
    """Takes a new image if there is one; starts over, or goes on to finer pixels when a coarse session is done."""
    if view.session is None or _may_start_over(view):
        _start(engine, view, scene, 0)
    is_new = view.level == 0 and view.shown_pass == 0
    finished = _take_image(view)
    if finished and view.stale:
        _start(engine, view, scene, 0)
        is_new, finished = True, _take_image(view)
    is_clean = view.cleaner is not None and view.cleaner.shows
    engine.update_stats("Sluice", render_progress.line(view.session.progress(), view.settings["error_target"], is_clean))
    if finished and view.level > 0 and not view.told:  # The coarsest level misses light, so its figures say nothing.
        edit_statistics.remember(view.session)
        render_statistics.remember_effects(view.session)
        edit_statistics.redraw()
        view.told = True
    if finished and not is_new and view.level + 1 < len(_LEVELS):
        _start(engine, view, scene, view.level + 1)


def _may_start_over(view: View) -> bool:
    """Shall a new session begin? A coarse image is never given up before it is seen."""
    return view.stale and (view.level > 0 or view.shown_pass > 0)


def _take_image(view: View) -> bool:
    """Takes the session's newest image. Returns whether the session is done."""
    finished = view.session.wait(_AT_ONCE if view.level == 0 and view.shown_pass == 0 else 0)
    progress = view.session.progress()
    if progress["state"] == 'failed' and not view.stale:
        raise final.core_failure(progress)
    if progress["pass"] > view.shown_pass:
        images = view.session.snapshot(["Combined"])
        if images is not None:
            if view.cleaner is None or not view.cleaner.shows:
                view.texture = _make_texture(images["Combined"])
            view.shown_pass = progress["pass"]
    if view.cleaner is not None:
        picture = view.cleaner.take()
        if picture is not None:
            view.texture = _make_texture(picture)
        view.cleaner.offer(view.session, finished)
    return finished


def _at_rest(view: View) -> bool:
    """Will nothing more come until something changes?"""
    return view.told and not view.stale and not view.is_cleaning and view.level + 1 == len(_LEVELS)


def _watch(engine: SluiceRenderEngine, view: View) -> None:
    """Asks for a redraw when the session has news. Asking in every draw would draw without a pause and starve the render."""
    if not view.watched:
        view.watched = True
        bpy.app.timers.register(functools.partial(_look, weakref.ref(engine), view), first_interval=_SOON)


def _look(engine_reference: weakref.ref[SluiceRenderEngine], view: View) -> float | None:
    """A timer that looks after a session. Returns the seconds until it looks again, None to end."""
    engine = engine_reference()
    if engine is None or view.session is None:
        view.watched = False
        return None
    finished, is_first = view.session.wait(0), view.shown_pass == 0
    has_news = view.session.progress()["pass"] > view.shown_pass
    since, pause = time.monotonic() - view.drawn, view.redraw / _DRAWING
    try:
        if view.is_cleaning and finished and not has_news:
            finished = False  # A last picture is to come.
            if view.cleaner.is_ready:
                engine.tag_redraw()
        # The last case is for the status line.
        elif finished or has_news and (is_first or since > pause) or is_first and since > max(_POLL, pause):
            engine.tag_redraw()
    except ReferenceError:  # Blender has freed its half of the engine.
        view.stop()
        finished = True
    view.watched = not finished
    return None if finished else _POLL if view.shown_pass else _SOON


def _time_redraw(view: View) -> None:
    view.redraw = time.monotonic() - view.drawn


def _make_texture(pixels: np.ndarray) -> Any:
    import gpu  # Not at the top of the file: without a window the module is there but must not be asked.
    height, width = pixels.shape[:2]
    clamped = np.ascontiguousarray(np.clip(pixels, 0, _HALF_MAX), np.float32)
    types: Any = gpu.types  # The stubs of gpu.types know of no arguments.
    buffer = types.Buffer('FLOAT', width * height * 4, clamped.reshape(-1))
    return types.GPUTexture((width, height), format='RGBA16F', data=buffer)


def _draw_image(view: View, region: bpy.types.Region) -> None:
    if view.texture is None:
        return
    import gpu
    from gpu_extras.presets import draw_texture_2d
    gpu.state.blend_set('ALPHA_PREMULT')
    # The image is scene-linear: Blender applies the view transform.
    draw_texture_2d(view.texture, (0, 0), region.width, region.height)
    gpu.state.blend_set('NONE')


def _fail(engine: SluiceRenderEngine, error: Exception) -> None:
    """Shows the sentence in the view and stops; the next change of the scene tries again, with a copy of its own."""
    failure = final.as_failure(error)
    if engine.view is not None:
        engine.view.stop()
        engine.view.description = engine.view.base = None
    engine.update_stats("Sluice", str(failure))
    engine.tag_redraw()


def free(view: View | None) -> None:
    """The engine goes away: nothing of its view may run on. None is an engine that never had one."""
    if view is not None:
        view.stop()
        view.base = None
        core.let_go()
