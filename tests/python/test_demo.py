# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo scenes in Blender, end to end and small: files, passes, and that each edit moves the light it says it moves."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import demo as demo_tool
import progress_log
import sheet

SCENES = tuple(demo_tool.SCENES)
FRAMES = ("_0001", "_0013")  # of the animated scene
EDITS = {"fig1": 2, "fig5": 3, "cornell": 3}  # how many there are where it is not one

# Where an edit takes light away and where it lays it down: boxes (x0, x1, y0, y1) in fractions of the picture, from the top left
TAKEN = {"glass_egg": (0.38, 0.49, 0.68, 0.77), "window": (0.17, 0.37, 0.74, 0.92), "fig1": (0.63, 0.69, 0.84, 0.88),
         "fig3": (0.57, 0.64, 0.905, 0.95), "fig4": (0.46, 0.68, 0.90, 0.955), "fig5": (0.09, 0.16, 0.79, 0.86),
         "fig8": (0.22, 0.32, 0.84, 0.98), "rosette": (0.53, 0.60, 0.61, 0.71)}  # fmt: skip
GIVEN = {"glass_egg": (0.46, 0.54, 0.18, 0.38), "window": (0.60, 0.76, 0.74, 0.92), "fig1": (0.50, 0.57, 0.25, 0.36),
         "fig3": (0.61, 0.66, 0.15, 0.35), "fig4": (0.67, 0.83, 0.12, 0.42), "fig5": (0.75, 0.80, 0.09, 0.19),
         "fig7": (0.28, 0.36, 0.76, 0.86), "fig8": (0.67, 0.77, 0.84, 0.98), "rosette": (0.57, 0.68, 0.22, 0.38)}  # fmt: skip

ANIMATED = (0.12, 0.24, 0.12, 0.35), (0.42, 0.56, 0.15, 0.38)


def pictures(name, label):
    return [f"{name}_{label}{frame}" for frame in (FRAMES if name == "animation" else ("",))]


def colour(picture, box):
    rows, columns, _ = picture.shape
    x0, x1, y0, y1 = box
    return picture[int(y0 * rows) : int(y1 * rows), int(x0 * columns) : int(x1 * columns), :3].mean((0, 1))


def render(name, out):
    """A demo of one scene at a quarter of its resolution and eight passes a picture."""
    command = [sys.executable, ROOT / "tools/demo.py", "--out", out, "--passes", "8", "--percent", "25", "--photons", "60000", "--frames", "2", name]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]


def check_files(name, out):
    for label in ("without", "with"):
        for picture in pictures(name, label):
            assert (out / f"{picture}.png").stat().st_size > 10_000
            last = progress_log.read(out / f"{picture}.jsonl")[-1]
            assert last["pass"] == 8 and last["photons"] > 0 and 0 < last["error_estimate"] < 1
            assert len(last["effects"]) >= 4 and all(why for _, _, why in last["effects"])
            assert last["stop_reason"] == "passes"
        if name != "animation":
            assert b"Caustics" in (out / f"{name}_{label}.exr").read_bytes()[:8192], "the EXR holds the passes by name"
    assert all((out / made).exists() for made in (f"{name}_sheet.png", f"{name}_error.png", f"{name}_pair.jpg", "contact_sheet.png"))


def check_edits(name, out):
    """Each takes light and sends it on; nothing is warned of but the one that is meant to have no exit."""
    for picture in pictures(name, "with"):
        last = progress_log.read(out / f"{picture}.jsonl")[-1]
        edits = last["statistics"]["edits"]
        assert len(edits) == EDITS.get(name, 1)
        assert all(edit["matched"] > 0 for edit in edits)
        without_exit = [edit["name"] for edit in edits if edit["moved"] == 0]
        assert without_exit == (["Blue caustic"] if name == "fig5" else [])
        assert [item for item, _ in last["warnings"]] == without_exit


def check_colours(name, before, after):
    """What the boxes of TAKEN and GIVEN cannot tell."""
    if name == "cornell":
        by_the_wall, on_the_floor = (0.21, 0.28, 0.2, 0.6), (0.455, 0.505, 0.90, 0.95)
        redness = [colour(picture, by_the_wall)[0] / colour(picture, by_the_wall)[2] for picture in (before, after)]
        assert redness[1] < 0.93 * redness[0]
        green = colour(after, on_the_floor) - colour(before, on_the_floor)
        assert green[1] > 0.05 and green[1] > 1.5 * green[0]
    elif name == "fig6":
        sculpture, wall = (0.37, 0.41, 0.2, 0.35), (0.02, 0.20, 0.1, 0.4)
        redness = [colour(picture, sculpture)[0] / colour(picture, sculpture)[1] for picture in (before, after)]
        assert redness[0] < 1 < redness[1]
        np.testing.assert_allclose(colour(after, wall), colour(before, wall), rtol=0.03)
    elif name == "fig4":
        top, bottom = (0.46, 0.54, 0.14, 0.18), (0.46, 0.54, 0.36, 0.40)
        bluer = [colour(after, box)[2] / colour(after, box)[0] for box in (top, bottom)]
        assert bluer[0] > 1.3 * bluer[1]


def check_animation(out):
    """The light on the wall is at the left in the first frame, in the middle and bluer in the thirteenth."""
    first, later = (sheet.plt.imread(out / f"animation_with{frame}.png") for frame in FRAMES)
    left, middle = ANIMATED
    assert colour(first, left).mean() > 1.03 * colour(later, left).mean()
    assert colour(later, middle)[2] > 1.03 * colour(first, middle)[2]


@pytest.mark.parametrize("name", SCENES)
def test_scene(name, tmp_path):
    render(name, tmp_path)
    check_files(name, tmp_path)
    check_edits(name, tmp_path)
    if name == "animation":
        check_animation(tmp_path)
        return
    before, after = (sheet.plt.imread(tmp_path / f"{name}_{label}.png") for label in ("without", "with"))
    if name in TAKEN:
        assert colour(after, TAKEN[name]).mean() < 0.93 * colour(before, TAKEN[name]).mean()
    if name in GIVEN:
        assert colour(after, GIVEN[name]).mean() > 1.07 * colour(before, GIVEN[name]).mean()
    check_colours(name, before, after)


@pytest.mark.parametrize("name", SCENES)
def test_scene_file_is_small(name):
    assert (ROOT / f"blend_scenes/{name}.blend").stat().st_size <= 1 << 20


def test_every_scene_file_is_shown():
    assert {path.stem for path in (ROOT / "blend_scenes").glob("*.blend")} == set(SCENES)


# --- the demo's own arithmetic ------------------------------------------------------------------------------------------------------


def test_an_edit_in_words():
    plain = {"size": 1.0, "keep_brightness": True, "intensity": 1.0, "hue_shift": 0.0}
    assert sheet.in_words({"name": "In", "exits": []}) == "In → nowhere: it is removed"
    exits = [{**plain, "name": "A"}, {**plain, "name": "B", "size": 1.8, "keep_brightness": False, "intensity": 0.15, "hue_shift": 100.0}]
    exits.append({**plain, "name": "C", "tint": [1.0, 0.4, 0.1]})
    assert sheet.in_words({"name": "In", "exits": exits}) == "In → A; B (1.8 × the size, energy kept, 0.15 × the light, hue +100°); C (tinted)"


def test_price_of_an_error():
    """On error = 0.2 s^-1/2: 10 % cost 4 s and were reached, 1 % cost 400 s by the slope."""
    seconds = [0.5 * i for i in range(1, 41)]
    errors = [0.2 / math.sqrt(s) for s in seconds]
    assert progress_log.price(seconds, errors, 0.10) == (4.0, True)
    cost, reached = progress_log.price(seconds, errors, 0.01)
    assert not reached and abs(cost - 400) < 1e-6
    assert progress_log.price(seconds, [0.3] * 40, 0.01) is None, "an error that does not fall has no price"
    assert progress_log.price([], [], 0.01) is None
    assert abs(progress_log.price([9.0], [0.05], 0.01)[0] - 225) < 1e-6, "of one estimate: as noise falls"
    assert abs(progress_log.price(seconds[:3], errors[:3], 0.01)[0] - 400) < 1e-6


def test_log_that_is_still_being_written(tmp_path):
    log = tmp_path / "log.jsonl"
    log.write_text(json.dumps({"seconds": 1.0, "error_estimate": None}) + "\n" + json.dumps({"seconds": 2.0, "error_estimate": 0.1}) + '\n{"seco')
    assert [u["seconds"] for u in progress_log.read(log)] == [1.0, 2.0]
    assert progress_log.error_curve(progress_log.read(log)) == ([2.0], [0.1])


def test_box_reference_measure():
    """relMSE of an image that is 10 % too bright where the reference is 1: 0.01 / 1.01."""
    sys.path.insert(0, str(ROOT / "tests/bench"))
    import box

    truth = np.ones((4, 4, 3))
    error, trimmed, mean = box.relmse(1.1 * truth, truth)
    assert abs(error - 0.01 / 1.01) < 1e-12 and abs(trimmed - error) < 1e-12 and abs(mean - 1.1) < 1e-12
    assert abs(box.seconds_to([(1, 0.04), (4, 0.01)], 0.02) - 2) < 1e-12
    assert box.reference().shape == (256, 256, 3)
