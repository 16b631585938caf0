# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender for tools that measure: the scene rendered by a session of the core, so that all it counts is at hand."""

from types import SimpleNamespace

import bpy
import numpy as np


def describe(scene):
    """What the add-on would render, ready for sessions: its job. Raises where there is no picture to be had."""
    from sluice import final

    for item in scene.objects:
        for modifier in item.modifiers:
            if modifier.type == "SUBSURF":
                modifier.levels = modifier.render_levels  # the depsgraph here is the viewport's
    engine = SimpleNamespace(update_stats=lambda *_: None, test_break=lambda: False, camera_override=None, is_preview=False,
                             resolution_x=scene.render.resolution_x, resolution_y=scene.render.resolution_y)  # fmt: skip
    final.update(engine, bpy.data, bpy.context.evaluated_depsgraph_get())
    if engine.job.failure:
        raise engine.job.failure
    return engine.job


def run(job, **settings):
    """A session that has rendered a job under other settings to its end."""
    from sluice import core, final

    session = core.new_session()
    session.start(job.description, {**job.settings, **settings})
    while not session.wait(0.05):
        pass
    progress = session.progress()
    if progress["state"] == "failed":
        raise final.core_failure(progress)
    return session


def sluice(scene, box_filter=False, **settings):
    """One render by a session of the core: (image, progress, statistics)."""
    job = describe(scene)
    job.description["frame"]["filter_box"] = box_filter
    session = run(job, **settings)
    image = session.snapshot(["Combined"])["Combined"][..., :3].astype(np.float64)
    return image, session.progress(), session.statistics()
