# SPDX-License-Identifier: GPL-3.0-or-later
"""The final render: one function per verb of Blender's render engine. update copies the scene while Blender holds it still; render
runs a session on the core's threads and polls it. Everything is caught here: a failed render must not write a frame, and for
Blender only report({'ERROR'}) is a failure (an exception, or error_set alone, would write a black frame and exit with 0)."""
from __future__ import annotations

import sys
import traceback
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import core, denoising, edit_statistics, export, passes, render_progress, render_statistics
from .export.camera import export_camera, export_frame
from .export.description import Description
from .export.scene_names import Names
from .export.settings import export_settings, for_preview

if TYPE_CHECKING:
    import bpy
    import numpy as np

    from .engine import SluiceRenderEngine

POLL = 0.1  # Seconds between two looks at the session and at Esc.
_PATIENCE = 1.0  # Seconds that a cancelled session is given to end; it promises to need half.
_MOST_REPORTS = 20  # So many warnings are shown in Blender; stderr gets all of them.


class Failure(Exception):
    """Why there is no image: the thing at fault, where in its expression, and what to do about it."""

    def __init__(self, message: str, item: str = "", column: int | None = None) -> None:
        super().__init__(message)
        self.item, self.column = item, column

    def __str__(self) -> str:
        where = f"{self.item}: " if self.item else ""
        column = f"column {self.column}: " if self.column else ""
        return where + column + super().__str__()


@dataclass
class Job:
    """What update hands to render; no Blender data in it."""

    layer: str
    description: Description = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)
    warnings: list[tuple[str, str]] = field(default_factory=list)
    passes: tuple[passes.Pass, ...] = (passes.COMBINED,)
    asked: dict[str, str] = field(default_factory=dict)  # by the name of a pass: who asks for it
    denoise: bool = False  # shall and can the picture be denoised?
    failure: Failure | None = None
    cancelled: bool = False


def update(engine: SluiceRenderEngine, data: bpy.types.BlendData, depsgraph: bpy.types.Depsgraph) -> None:
    """Deep-copies the scene. Never raises: what went wrong waits in the job for render to report."""
    engine.job = job = Job(depsgraph.view_layer_eval.name)
    try:
        core.load()
        engine.update_stats("", "Copying the scene")
        _copy_scene(engine, data, depsgraph, job)
    except export.Cancelled:
        job.cancelled = True
    except Exception as error:
        job.failure = as_failure(error)


def _copy_scene(engine: SluiceRenderEngine, data: bpy.types.BlendData, depsgraph: bpy.types.Depsgraph, job: Job) -> None:
    scene = depsgraph.scene_eval
    context = export.Context(Names(data.collections, data.objects, data.worlds), cancelled=engine.test_break)
    job.warnings = context.warnings
    camera_object = engine.camera_override or scene.camera
    if camera_object is None:
        raise Failure("the scene has no camera: add one and make it active")
    camera_object = camera_object.evaluated_get(depsgraph)
    camera = export_camera(camera_object, camera_object.matrix_world, context.warn)
    frame = export_frame(engine.resolution_x, engine.resolution_y, scene.render)
    job.settings = {**export_settings(scene), "explain_edits": True}
    job.description = export.export_scene(depsgraph, camera, frame, context)
    if engine.is_preview:
        job.settings = for_preview(job.settings)
        return
    job.description["layers"] = passes.export_layers(depsgraph.view_layer_eval)
    for layer in job.description["layers"]:
        layer["expression"] = context.names.homes.read(layer["expression"], scene.original.library)
    asked = passes.asked(depsgraph.scene, depsgraph.view_layer_eval, job.description["layers"])
    job.passes, job.asked = tuple(asked), {item.name: who for item, who in asked.items()}
    job.denoise = passes.NOISY_IMAGE in asked and denoising.is_there()
    if passes.NOISY_IMAGE in asked and not job.denoise:
        job.warnings.append((denoising.ITEM, denoising.missing()))
    made = {item.name for item in asked} | (set(passes.GUIDES) if job.denoise else set())
    job.settings["render_passes"] = [item.name for item in passes.fixed_passes() if item.name in made]


def render(engine: SluiceRenderEngine) -> None:
    """Renders the job of the last update. Never raises."""
    job, engine.job = engine.job, None
    if job is None or job.cancelled:
        return
    session = None
    try:
        if job.failure is not None:
            raise job.failure
        session = core.new_session()
        _run(engine, job, session)
    except Exception as error:
        _report_failure(engine, as_failure(error))
    finally:
        if session is not None:
            session.cancel()


def _run(engine: SluiceRenderEngine, job: Job, session: core.Session) -> None:
    passes.add_passes(engine, job.layer, job.passes)
    result = passes.begin(engine, job.layer)
    _trust_size(job.description["frame"], result)
    session.start(job.description, job.settings)
    job.description = {}  # The core has a copy of its own now.
    names = [item.name for item in job.passes if item != passes.NOISY_IMAGE]
    target = job.settings["error_target"]
    stream = render_progress.Stream(engine, result, names, not render_progress.in_background(), target)
    log = render_progress.ProgressLog(job.settings["frame"], job.layer)
    stopped = False
    while not session.wait(POLL):
        if engine.test_break():
            session.cancel()
            session.wait(_PATIENCE)
            stopped = True
            break
        stream.refresh(session)
        log.write(session)
    progress = session.progress()
    # Each is told once, also when the render failed: it may say why.
    _report_warnings(engine, dict.fromkeys(job.warnings + list(session.warnings())))
    if progress["state"] == 'failed':
        raise core_failure(progress)
    images = session.snapshot(names + [name for name in job.settings.get("render_passes", ()) if name not in names])
    if images is None:
        if stopped:
            return  # Esc came before the first image: Blender keeps what it showed and writes nothing.
        raise Failure("the render ended without an image")
    images[passes.NOISY_IMAGE.name] = images["Combined"]
    job.denoise = job.denoise and not stopped and _denoise(engine, job, images)
    written = passes.write(result, images)
    if "Combined" not in written:
        raise Failure("the picture does not fit the size that Blender asked for")
    engine.end_result(result)
    log.close(session, job.warnings)
    _finish(engine, session, progress, job)


def _denoise(engine: SluiceRenderEngine, job: Job, images: dict[str, np.ndarray]) -> bool:
    """Denoises Combined, and says whether it could."""
    engine.update_stats("", "Denoising")
    try:
        images["Combined"] = denoising.denoise(images)
    except denoising.Failed as failure:
        job.warnings.append((denoising.ITEM, str(failure)))
        _report_warnings(engine, job.warnings[-1:])
        return False
    return True


def _trust_size(frame: Description, result: bpy.types.RenderResult) -> None:
    """The result's size is Blender's word on how large the border is; the frame's corner is ours."""
    frame["x1"], frame["y1"] = frame["x0"] + result.resolution_x, frame["y0"] + result.resolution_y


def _finish(engine: SluiceRenderEngine, session: core.Session, progress: dict[str, Any], job: Job) -> None:
    """Says why the render stopped, and puts into the file's header what made it."""
    told = render_progress.summary(progress, job.settings["error_target"], job.denoise)
    if job.denoise:
        engine.update_stats("", render_progress.line(progress, job.settings["error_target"], True))
    if not engine.is_preview:
        print(f"sluice: {told}", flush=True)
        print(session.statistics()["report"].rstrip("\n"), flush=True)
        print("render passes: " + ", ".join(f"{name} ({who})" for name, who in job.asked.items()), flush=True)
        edit_statistics.remember(session)
        render_statistics.remember(session, job.denoise)
        if progress["stop_reason"] in {'time', 'error'}:
            engine.report({'INFO'}, f"Sluice: {told}")
    stamps = {
        "version": core.load().__version__, "seed": job.settings["seed"], "frame": job.settings["frame"],
        "passes": progress["pass"], "photons": progress["photons"], "stop": progress["stop_reason"],
        "film hash": session.film_hash(), "warnings": len(job.warnings) + len(session.warnings()), **render_progress.stamps(progress),
        **({"denoised": f"by {denoising.PACKAGE}; error, noise and bias are those of the pass Noisy Image"} if job.denoise else {}),
        **{f"edit {name}": line for name, line in edit_statistics.stamps().items()},
    }
    result = engine.get_result()  # Blender loses the fields of a tile's result; the whole result keeps them.
    if result is not None:
        for name, value in stamps.items():
            result.stamp_data_add_field(f"Sluice {name}", str(value))


def _report_warnings(engine: SluiceRenderEngine, warnings: Collection[tuple[str, str]]) -> None:
    if engine.is_preview:
        return
    for count, (item, message) in enumerate(warnings):
        text = f"{item}: {message}" if item else message
        print(f"sluice: warning: {text}", file=sys.stderr, flush=True)
        if count < _MOST_REPORTS:
            engine.report({'WARNING'}, f"Sluice: {text}")
    if len(warnings) > _MOST_REPORTS:
        engine.report({'WARNING'}, f"Sluice: {len(warnings) - _MOST_REPORTS} more warnings in the console")


def _report_failure(engine: SluiceRenderEngine, failure: Failure) -> None:
    """The one way to fail: Blender raises for an ERROR report, writes no file and exits with a code that is not 0."""
    if engine.is_preview:
        return
    print(f"sluice: error: {failure}", file=sys.stderr, flush=True)
    engine.report({'ERROR'}, f"Sluice: {failure}")
    engine.error_set(f"Sluice: {failure}")


def as_failure(error: Exception) -> Failure:
    """Any exception as a Failure; what is not meant for artists leaves its traceback in the console."""
    if isinstance(error, Failure):
        return error
    if isinstance(error, core.CoreMissing):
        return Failure(str(error))
    if hasattr(error, "item"):  # The core's SceneError and ExpressionError have it.
        item, column, message = core.expression_problem(error)
        return Failure(message, item, column)
    traceback.print_exception(type(error), error, error.__traceback__)
    return Failure(f"internal error: {type(error).__name__}: {error}")


def core_failure(progress: dict[str, Any]) -> Failure:
    """The error a session ended with."""
    error = progress["error"] or {}
    return Failure(error.get("message") or progress["message"], error.get("item") or "", error.get("column"))
