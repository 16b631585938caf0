# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender for tools/bench.py: measures one task and appends its rows to a file, one JSON object per line.

Sluice runs through its own session, so that the photons of a pass and the time of the core are known; Cycles through Blender's
render operator. Usage: blender -b [FILE] --python tools/bench_render.py -- '{"task": …, "rows": FILE, …}'"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/bench"), str(ROOT / "tests/blender")]
import box
from blender_session import sluice
from windowless import Window


def cycles(scene, samples, seed):
    """One render by Cycles: (image, seconds of the render operator)."""
    scene.render.engine = "CYCLES"
    settings = scene.cycles
    settings.samples, settings.seed, settings.use_denoising, settings.use_adaptive_sampling = samples, seed, False, False
    settings.sample_clamp_indirect, settings.blur_glossy = 0, 0
    settings.pixel_filter_type, settings.filter_width = "BOX", 1.0
    settings.max_bounces = settings.diffuse_bounces = settings.glossy_bounces = settings.transmission_bounces = 48
    image = scene.render.image_settings
    image.file_format, image.color_depth = "OPEN_EXR", "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "image.exr")
        start = time.monotonic()
        bpy.ops.render.render()
        seconds = time.monotonic() - start
        bpy.data.images["Render Result"].save_render(scene.render.filepath, scene=scene)
        loaded = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(len(loaded.pixels), np.float32)
        loaded.pixels.foreach_get(pixels)
        pixels = pixels.reshape(loaded.size[1], loaded.size[0], 4)[..., :3].astype(np.float64)
        bpy.data.images.remove(loaded)
    return pixels, seconds


def prototype(program, passes, seed):
    """The same by the rebuilt prototype (tests/bench/prototype.cpp), which knows the large box alone."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "image.raw")
        done = subprocess.run([program, *map(str, (passes, seed, out, os.cpu_count()))], check=True, capture_output=True, text=True)
        image = np.fromfile(out, np.float32).reshape(256, 256, 3).astype(np.float64)
    setup, seconds = map(float, done.stdout.split()[:2])
    return image, setup + seconds


# Stops by passes alone, and paths as long as the references'
OPEN_ENDED = {"time_limit": 0.0, "error_target": 0.0, "max_depth": 48}


def write(task, **row):
    with open(task["rows"], "a") as file:
        file.write(json.dumps({"scene": task["scene"], **row}) + "\n")


def error_rows(task, truth, scene, box_filter):
    """Error against time of both renderers, for each amount of work and seed."""
    for seed in range(task["seeds"]):
        for passes in task["passes"]:
            settings = {"passes": passes, "photons": task["photons"], "seed": seed, **OPEN_ENDED}
            image, progress, statistics = sluice(scene, box_filter, **settings)
            error, trimmed, mean = box.relmse(image, truth)
            seconds = statistics["seconds"]["compile"] + progress["seconds"]
            write(task, renderer="Sluice", work=f"{passes} passes", seed=seed, seconds=seconds, relmse=error, trimmed=trimmed, mean=mean,
                  estimate=progress["error_estimate"])  # fmt: skip
        for passes in task["prototype_passes"] if task.get("prototype") else ():
            image, seconds = prototype(task["prototype"], passes, seed)
            error, trimmed, mean = box.relmse(image, truth)
            write(task, renderer="Prototype", work=f"{passes} passes", seed=seed, seconds=seconds, relmse=error, trimmed=trimmed, mean=mean)
        for samples in task["samples"]:
            image, seconds = cycles(scene, samples, seed)
            error, trimmed, mean = box.relmse(image, truth)
            write(task, renderer="Cycles", work=f"{samples} spp", seed=seed, seconds=seconds, relmse=error, trimmed=trimmed, mean=mean)


def small_cornell():
    """The open scene without edits (Cycles knows none), at a quarter of its size."""
    scene = bpy.context.scene
    scene.sluice.use_edits = False
    scene.render.resolution_x, scene.render.resolution_y = scene.render.resolution_x // 4, scene.render.resolution_y // 4
    return scene


def speed_rows(task, scene):
    """What a fixed number of passes costs, without and with edits."""
    for use_edits in (False, True):
        _, progress, statistics = sluice(scene, passes=task["passes"], photons=task["photons"], use_edits=use_edits, time_limit=0.0, error_target=0.0)
        write(task, edits=use_edits, passes=progress["pass"], seconds=progress["seconds"], estimate=progress["error_estimate"],
              core_memory=progress["memory"], peak_rss=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024, statistics=statistics)  # fmt: skip


def drag_rows(task, scene):
    """Seconds from a change to the first image of it in rendered mode, Blender's own drawing apart."""
    window = Window(task["width"], task["height"], scene.camera)
    moved = next(item for item in scene.objects if item.sluice.role == "EXIT")
    thing = next(item for item in scene.objects if item.type == "MESH")

    def drag():
        moved.location.x += 0.01
        window.update(moved)

    def orbit():
        lens = window.region_3d.window_matrix = window.region_3d.window_matrix.copy()
        lens[0][2] += 0.01

    def copy():
        thing.location.x += 0.001
        window.update(thing)

    window.update()
    window.follow()
    for what in (drag, orbit, copy):
        for _ in range(task["turns"]):
            start = time.monotonic()
            what()
            window.follow()
            write(task, what=what.__name__, seconds=time.monotonic() - start)


def main(task):
    if task["task"] == "box":
        scene = box.build(task["lamp"])
        error_rows(task, box.reference(task["lamp"]), scene, box_filter=True)
    elif task["task"] == "cornell":
        error_rows(task, np.load(box.CORNELL).astype(np.float64), small_cornell(), box_filter=True)
    elif task["task"] == "cornell_reference":
        image, progress, _ = sluice(small_cornell(), True, passes=task["passes"], photons=65536, seed=4711, **OPEN_ENDED)
        np.save(box.CORNELL, image.astype(np.float16))
        write(task, passes=progress["pass"], seconds=progress["seconds"], estimate=progress["error_estimate"])
    elif task["task"] == "drag":
        drag_rows(task, bpy.context.scene)
    elif task["task"] == "speed":
        speed_rows(task, bpy.context.scene)
    else:
        raise ValueError(f"no task {task['task']}")


main(json.loads(sys.argv[sys.argv.index("--") + 1]))
