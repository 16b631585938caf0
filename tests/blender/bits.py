# SPDX-License-Identifier: GPL-3.0-or-later
"""What a file comes to, as hashes: its description, and pictures of it by F12. Also a program, so that a test may ask another process:

    blender … --python tests/blender/bits.py -- '[["a.blend", {"exports": 20, "renders": 3, "threads": 2}], …]'

prints one line of JSON per file, after the word BITS."""
import hashlib
import json
import sys

import bpy
import numpy as np


def fingerprint(value):
    """A hash of a description: every number of it, in its order."""
    digest = hashlib.sha256()
    _feed(digest, value)
    return digest.hexdigest()


def _feed(digest, value):
    if isinstance(value, dict):
        for key in value:
            digest.update(key.encode())
            _feed(digest, value[key])
    elif isinstance(value, list | tuple):
        digest.update(f"{len(value)} of".encode())
        for item in value:
            _feed(digest, item)
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode())
        digest.update(value.tobytes())
    else:
        digest.update(repr(value).encode())


def describe():
    """(description, warnings) of the open file as the final render copies it."""
    from sluice import export
    from sluice.export.camera import export_camera, export_frame
    from sluice.export.scene_names import Names
    depsgraph = bpy.context.evaluated_depsgraph_get()
    context = export.Context(Names(bpy.data.collections, bpy.data.objects, bpy.data.worlds))
    camera = bpy.context.scene.camera.evaluated_get(depsgraph)
    frame = export_frame(64, 48, bpy.context.scene.render)
    return export.export_scene(depsgraph, export_camera(camera, camera.matrix_world, context.warn), frame, context), context.warnings


def render(threads=2, seed=0, border=None, photons=5000):
    """F12, small: {"film", "guide": hashes, "picture": Combined, "edited": what edits moved}."""
    from sluice import core
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 40, 30, 100
    scene.render.threads_mode, scene.render.threads = 'FIXED', threads
    scene.render.use_border = border is not None
    if border:
        scene.render.border_min_x, scene.render.border_min_y, scene.render.border_max_x, scene.render.border_max_y = border
    ours = scene.sluice
    ours.passes, ours.photons, ours.seed, ours.error_target, ours.time_limit = 4, photons, seed, 0, 0
    bpy.context.view_layer.sluice.use_pass_edited = True
    made, new_session = [], core.new_session
    core.new_session = lambda: made.append(new_session()) or made[-1]
    try:
        bpy.ops.render.render()
    finally:
        core.new_session = new_session
    session = made[-1]
    pictures = session.snapshot(["Combined", "Edited"])
    return {"film": session.film_hash(), "guide": session.statistics()["guide_hash"], "picture": pictures["Combined"], "edited": pictures["Edited"]}


def hashes(path, exports=1, renders=1, threads=2):
    """{"descriptions", "films", "guides"}: the different ones among so many, the file opened anew for each."""
    found = {"descriptions": set(), "films": set(), "guides": set()}
    for count in range(max(exports, renders)):
        bpy.ops.wm.open_mainfile(filepath=str(path))
        if count < exports:
            found["descriptions"].add(fingerprint(describe()))
        if count < renders:
            made = render(threads)
            found["films"].add(made["film"])
            found["guides"].add(made["guide"])
    return {kind: sorted(values) for kind, values in found.items()}


if __name__ == "__main__":
    for asked, how in json.loads(sys.argv[sys.argv.index("--") + 1]):
        print("BITS", json.dumps([asked, hashes(asked, **how)]), flush=True)
