# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender for tools/demo.py: renders the open scene without and with its edits, for the same time a picture.

Leaves in the folder `out`, for NAME_without and NAME_with: .png, a multilayer .exr and the engine's progress (.jsonl); of an animated
scene NAME_without_0001 and so on, without .exr. NAME.json tells the edits and the pictures. Usage: blender -b scene.blend --python
tools/demo_render.py -- OPTIONS, those of tools/demo.py as JSON."""

import json
import math
import os
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/blender"))
from blender_scenes import ask_for_all_passes


FEWEST = 8  # passes of a picture: the error is estimated after every four


def area(quad):
    """Of an entry or exit, up to a factor that all share."""
    x, y, _ = (column.to_3d() for column in quad.matrix_world.transposed()[:3])
    return x.cross(y).length * quad.empty_display_size**2


def what_changes(item, entry):
    """An exit, in numbers and names; `size` is the ratio of lengths."""
    told, images = item.sluice, ("intensity_texture", "hue_shift_texture", "normal_map")
    tint = {"tint": list(told.tint)} if min(told.tint) < max(told.tint) else {}
    return {"name": item.name, "intensity": told.intensity, "hue_shift": math.degrees(told.hue_shift), "keep_brightness": told.keep_brightness,
            "size": math.sqrt(area(item) / area(entry)), **tint, **{key: image.name for key in images if (image := getattr(told, key))}}  # fmt: skip


def edits_of(scene):
    """Each entry with its expression and exits, for captions."""
    found = []
    objects = sorted((o for o in scene.objects if o.sluice.role != "NONE"), key=lambda o: o.sluice.order)
    for entry in (o for o in objects if o.sluice.role == "ENTRY" and o.sluice.enabled):
        exits = [what_changes(o, entry) for o in objects if o.sluice.role == "EXIT" and o.sluice.entry == entry]
        found.append({"name": entry.name, "expression": entry.sluice.expression, "exits": exits})
    return found


def write(scene, path, file_format, **settings):
    """The last render as a file. Multilayer EXR keeps every pass."""
    image = scene.render.image_settings
    if hasattr(image, "media_type"):  # from Blender 5.0 the kind of medium is chosen first
        image.media_type = "MULTI_LAYER_IMAGE" if file_format == "OPEN_EXR_MULTILAYER" else "IMAGE"
    image.file_format = file_format
    for key, value in settings.items():
        setattr(image, key, value)
    bpy.data.images["Render Result"].save_render(path, scene=scene)


def passes_in(log):
    """How many the render had that left this progress log; other engines leave none."""
    if not os.path.exists(log):
        return FEWEST
    with open(log) as file:
        return json.loads(file.readlines()[-1])["pass"]


def render(scene, base, every_pass):
    """Returns the seconds it took. A machine too slow for the fewest passes in the time takes longer: there is an error to plot then."""
    os.environ["SLUICE_PROGRESS_LOG"] = log = base + ".jsonl"
    start = time.monotonic()
    bpy.ops.render.render()  # an error that the engine reports ends the script here
    asked = scene.sluice.time_limit, scene.sluice.passes
    if asked[0] and passes_in(log) < FEWEST:
        os.remove(log)
        scene.sluice.time_limit, scene.sluice.passes = 0, FEWEST
        bpy.ops.render.render()
        scene.sluice.time_limit, scene.sluice.passes = asked
    seconds = time.monotonic() - start
    write(scene, base + ".png", "PNG", color_mode="RGB", color_depth="8", compression=90)
    if every_pass:
        write(scene, base + ".exr", "OPEN_EXR_MULTILAYER", color_depth="16", exr_codec="ZIP")
    return seconds


def frames_of(scene, most):
    """The frames to render, evenly spaced; of a still the one it is at."""
    frames = list(range(scene.frame_start, scene.frame_end + 1))
    return frames[:: -(-len(frames) // most)]


def render_all(scene, options, name):
    """Name (without suffix), frame and seconds of each picture, by label. Six frames of an animation show it without edits."""
    animated = scene.frame_end > scene.frame_start
    made = {}
    for label, most in (("without", min(6, options["frames"])), ("with", options["frames"])):
        scene.sluice.use_edits, made[label] = label == "with", []
        for frame in frames_of(scene, most):
            scene.frame_set(frame)
            picture = f"{name}_{label}_{frame:04d}" if animated else f"{name}_{label}"
            seconds = render(scene, os.path.join(options["out"], picture), every_pass=not animated)
            made[label].append({"name": picture, "frame": frame, "seconds": seconds})
    return made


def main(options):
    scene, engine = bpy.context.scene, options["engine"]
    name = os.path.splitext(os.path.basename(bpy.data.filepath))[0]
    passes, seconds = (options["passes"], 0) if options["passes"] else (1 << 16, options["seconds"])
    if scene.frame_end > scene.frame_start:
        seconds /= 6
    scene.render.engine, scene.render.resolution_percentage = engine, options["percent"]
    scene.sluice.photons = options["photons"] or scene.sluice.photons
    scene.sluice.time_limit, scene.sluice.error_target, scene.sluice.passes, scene.sluice.seed = seconds, 0, passes, options["seed"]
    if engine == "CYCLES":
        scene.cycles.use_denoising, scene.cycles.samples, scene.cycles.time_limit = False, passes, seconds
    if scene.frame_end == scene.frame_start:
        ask_for_all_passes(scene)  # The multilayer EXR is there to look into the light.
    size = [side * options["percent"] // 100 for side in (scene.render.resolution_x, scene.render.resolution_y)]
    told = {"blender": bpy.app.version_string, "engine": engine, "edits": edits_of(scene), "resolution": size}
    told["pictures"] = render_all(scene, options, name)
    with open(os.path.join(options["out"], name + ".json"), "w") as file:
        json.dump(told, file, indent=1)


main(json.loads(sys.argv[sys.argv.index("--") + 1]))
