# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender for tools/report.py: renders the open scene with pictures kept on the way, its reference, and the same under other
settings, each by a session of the core.

Leaves in the folder `folder` raw.json and pictures as .npy, or failure.txt with one sentence. Usage: blender -b scene.blend --python
tools/report_render.py -- TASK, as JSON: scene (file), folder, frame (or null), passes, seed (or null), percent, photons_percent,
reference ("auto", null, or a file), reference_frame (or null), reference_factor, neighbours (bool)."""

import json
import os
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import blender_session

ENDLESS = {"time_limit": 0.0, "error_target": 0.0, "explain_edits": False, "render_passes": ["Noise", "Bias"]}  # whatever the scene asks for
NARROW = 2.0  # caustic_radius_factor of references: half of the default
RADIUS = 4.0  # its default
SWITCHES = {"direct": "use_direct", "caustics": "use_caustics", "edited light": "use_edited", "indirect": "use_indirect"}
FEW = 8  # passes that tell what an effect costs


class Refused(Exception):
    """What is asked cannot be done; says so in one sentence."""


def set_up(task):
    """The scene as it is to be rendered, and its job."""
    if not bpy.data.filepath or os.path.realpath(bpy.data.filepath) != os.path.realpath(task["scene"]):
        raise Refused(f"Blender cannot open {task['scene']}")
    scene, frame = bpy.context.scene, task["frame"]
    if frame is not None:
        scene.frame_set(frame)
    render = scene.render
    percent = render.resolution_percentage * task["percent"] / 100
    render.resolution_x, render.resolution_y = (max(1, round(side * percent / 100)) for side in (render.resolution_x, render.resolution_y))
    render.resolution_percentage = 100
    job = blender_session.describe(scene)
    job.settings["photons"] = max(1, round(job.settings["photons"] * task["photons_percent"] / 100))
    if task["seed"] is not None:
        job.settings["seed"] = task["seed"]
    return scene, job


def load(path):
    """A picture of a file: NumPy's, or a flat EXR."""
    if path.endswith(".npy"):
        try:
            return np.load(path, allow_pickle=False)
        except (OSError, ValueError) as error:
            raise Refused(f"the reference {path} is no picture of NumPy") from error
    image = bpy.data.images.load(path)
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)


def given_reference(task, scene, job):
    """The picture of a file, if it is one of this scene's size and frame."""
    name, frame = task["reference_name"], job.description["frame"]
    image = load(task["reference"])
    size = frame["x1"] - frame["x0"], frame["y1"] - frame["y0"]
    if image.ndim != 3 or image.shape[2] not in (3, 4) or image.dtype.kind != "f":
        raise Refused(f"the reference {name} is no picture of numbers (height, width, 3 or 4)")
    if (image.shape[1], image.shape[0]) != size:
        raise Refused(f"the reference {name} has {image.shape[1]} × {image.shape[0]} pixels, the render {size[0]} × {size[1]}")
    if task["reference_frame"] not in (None, scene.frame_current):
        raise Refused(f"the reference {name} shows frame {task['reference_frame']}, the render frame {scene.frame_current}")
    if not np.isfinite(image).all():
        raise Refused(f"the reference {name} holds what is no number")
    return image[..., :3].astype(np.float32)


def passes_kept(passes):
    """1, 2, 4, … and the last."""
    return sorted({*(1 << i for i in range(passes.bit_length())), passes})


class Recorder:
    """Runs sessions and writes down what they tell."""

    def __init__(self, task, job):
        self.folder, self.job, self.runs = Path(task["folder"]), job, []

    def run(self, name, passes, **changes):
        """One render. Its figures go to the list of runs, its pictures to files."""
        session = blender_session.run(self.job, **{**ENDLESS, "passes": passes, **changes})
        progress, statistics = session.progress(), session.statistics()
        images = session.snapshot(["Combined", "Noise", "Bias"])
        np.save(self.folder / f"{name}.npy", images["Combined"][..., :3])
        self.runs.append({"name": name, "passes": passes, "changes": {k: v for k, v in changes.items() if k != "keep_at"},
                          "progress": progress, "statistics": statistics})  # fmt: skip
        print(f"report: {name}: {passes} passes in {progress['seconds']:.1f} s", flush=True)
        return session, images

    def keep(self, session, images):
        """The pictures on the way of the main render, and where its error is."""
        for kept in session.kept():
            np.save(self.folder / f"kept_{kept['pass']}.npy", kept.pop("image")[..., :3])
            self.runs[-1].setdefault("kept", []).append(kept)
        np.save(self.folder / "samples.npy", session.sample_counts())
        for name in ("Noise", "Bias"):
            np.save(self.folder / f"{name.lower()}.npy", images[name][..., 0] if images[name].ndim == 3 else images[name])


def check_light(run, images):
    """A black picture has no error to speak of."""
    why = {why for _, _, why in run["statistics"]["effects"]}
    if "the scene has no light" in why and not images["Combined"][..., :3].any():
        raise Refused("the scene has no light")
    if not images["Combined"][..., :3].any():
        raise Refused("the picture is black: no light of the scene reaches the camera")


def render_others(recorder, task, main):
    """What neighbouring settings do, and what each effect costs."""
    photons, passes = recorder.job.settings["photons"], task["passes"]
    for name, changes in (("half_photons", {"photons": max(1, photons // 2)}), ("double_photons", {"photons": photons * 2}),
                          ("not_adaptive", {"use_adaptive_sampling": False}), ("narrower", {"caustic_radius_factor": 0.7 * RADIUS}),
                          ("wider", {"caustic_radius_factor": 1.4 * RADIUS})):  # fmt: skip
        recorder.run(name, passes, **changes)
    for effect, runs, _ in main["statistics"]["effects"]:
        if runs and effect in SWITCHES:
            recorder.run("without_" + effect.replace(" ", "_"), min(passes, FEW), **{SWITCHES[effect]: False})


def main(task):
    scene, job = set_up(task)
    recorder, folder = Recorder(task, job), Path(task["folder"])
    reference = given_reference(task, scene, job) if task["reference"] not in (None, "auto") else None
    session, images = recorder.run("main", task["passes"], keep_at=passes_kept(task["passes"]))
    check_light(recorder.runs[0], images)
    recorder.keep(session, images)
    if task["reference"] == "auto":
        recorder.run("reference", task["reference_factor"] * task["passes"], seed=job.settings["seed"] + 4711, caustic_radius_factor=NARROW)
    elif reference is not None:
        np.save(folder / "reference.npy", reference)
    if task["neighbours"]:
        render_others(recorder, task, recorder.runs[0])
    frame = job.description["frame"]
    from sluice import core

    raw = {"blender": bpy.app.version_string, "core": core.load().__version__, "frame": scene.frame_current,
           "size": [frame["x1"] - frame["x0"], frame["y1"] - frame["y0"]], "settings": {**job.settings, **ENDLESS, "passes": task["passes"]},
           "warnings": job.warnings + list(session.warnings()), "runs": recorder.runs}  # fmt: skip
    (folder / "raw.json").write_text(json.dumps(raw))


if __name__ == "__main__":
    asked = json.loads(sys.argv[sys.argv.index("--") + 1])
    try:
        main(asked)
    except Exception as problem:  # Blender would only print it
        Path(asked["folder"], "failure.txt").write_text(" ".join(str(problem).split()))
        raise
