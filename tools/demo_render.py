# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender for tools/demo.py: renders the open scene without and with its edits, for the same time each.

Leaves in the folder `out`, for NAME_without and NAME_with: .png, a multilayer .exr and the engine's progress (.jsonl); and NAME.json,
which tells the edits. Usage: blender -b scene.blend --python tools/demo_render.py -- OPTIONS, those of tools/demo.py as JSON."""

import json
import math
import os
import sys
import time

import bpy


def edits_of(scene):
    """Each entry with its expression and exits, for captions."""
    found = []
    objects = sorted((o for o in scene.objects if o.sluice.role != "NONE"), key=lambda o: o.sluice.order)
    for entry in (o for o in objects if o.sluice.role == "ENTRY" and o.sluice.enabled):
        exits = [{"name": o.name, "intensity": o.sluice.intensity, "hue_shift": math.degrees(o.sluice.hue_shift)}
                 for o in objects if o.sluice.role == "EXIT" and o.sluice.entry == entry]  # fmt: skip
        found.append({"name": entry.name, "expression": entry.sluice.expression, "exits": exits})
    return found


def write(scene, path, file_format, **settings):
    """The last render as a file. Multilayer EXR keeps every pass."""
    image = scene.render.image_settings
    image.file_format = file_format
    for key, value in settings.items():
        setattr(image, key, value)
    bpy.data.images["Render Result"].save_render(path, scene=scene)


def render(scene, base, use_edits):
    scene.sluice.use_edits = use_edits
    os.environ["SLUICE_PROGRESS_LOG"] = base + ".jsonl"
    start = time.monotonic()
    bpy.ops.render.render()  # an error that the engine reports ends the script here
    seconds = time.monotonic() - start
    write(scene, base + ".png", "PNG", color_mode="RGB", color_depth="8", compression=90)
    write(scene, base + ".exr", "OPEN_EXR_MULTILAYER", color_depth="16", exr_codec="ZIP")
    return seconds


def main(options):
    scene, engine, out = bpy.context.scene, options["engine"], options["out"]
    name = os.path.splitext(os.path.basename(bpy.data.filepath))[0]
    passes, seconds = (options["passes"], 0) if options["passes"] else (1 << 16, options["seconds"])
    scene.render.engine, scene.render.resolution_percentage = engine, options["percent"]
    scene.sluice.time_limit, scene.sluice.error_target, scene.sluice.passes = seconds, 0, passes
    if engine == "CYCLES":
        scene.cycles.use_denoising, scene.cycles.samples, scene.cycles.time_limit = False, passes, seconds
    size = [side * options["percent"] // 100 for side in (scene.render.resolution_x, scene.render.resolution_y)]
    told = {"blender": bpy.app.version_string, "engine": engine, "edits": edits_of(scene), "resolution": size}
    for label, use_edits in (("without", False), ("with", True)):
        told[label + "_seconds"] = render(scene, os.path.join(out, f"{name}_{label}"), use_edits)
    with open(os.path.join(out, name + ".json"), "w") as file:
        json.dump(told, file, indent=1)


main(json.loads(sys.argv[sys.argv.index("--") + 1]))
