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
import progress_log
import sheet

SCENES = ("glass_egg", "cornell", "window")

# Where an edit takes light away and where it lays it down: boxes (x0, x1, y0, y1) in fractions of the picture, from the top left
TAKEN = {"glass_egg": (0.38, 0.49, 0.68, 0.77), "window": (0.17, 0.37, 0.74, 0.92)}
GIVEN = {"glass_egg": (0.46, 0.54, 0.18, 0.38), "window": (0.60, 0.76, 0.74, 0.92)}


def brightness(picture, box):
    rows, columns, _ = picture.shape
    x0, x1, y0, y1 = box
    return float(picture[int(y0 * rows) : int(y1 * rows), int(x0 * columns) : int(x1 * columns), :3].mean())


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """A demo of a quarter of the resolution and twelve passes a picture."""
    out = tmp_path_factory.mktemp("demo")
    command = [sys.executable, ROOT / "tools/demo.py", "--out", out, "--passes", "12", "--percent", "25"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    return out


@pytest.mark.parametrize("name", SCENES)
def test_files_are_complete(demo, name):
    for label in ("without", "with"):
        assert (demo / f"{name}_{label}.png").stat().st_size > 10_000
        assert b"Caustics" in (demo / f"{name}_{label}.exr").read_bytes()[:8192], "the EXR holds the passes by name"
        last = progress_log.read(demo / f"{name}_{label}.jsonl")[-1]
        assert last["pass"] == 12 and last["photons"] > 0 and 0 < last["error_estimate"] < 1
        assert len(last["effects"]) >= 4 and all(why for _, _, why in last["effects"])
        assert last["stop_reason"] == "passes" and last["warnings"] == []
    assert (demo / f"{name}_sheet.png").exists() and (demo / f"{name}_error.png").exists()


@pytest.mark.parametrize("name", TAKEN)
def test_light_moves(demo, name):
    before, after = (sheet.plt.imread(demo / f"{name}_{label}.png") for label in ("without", "with"))
    assert brightness(after, TAKEN[name]) < 0.93 * brightness(before, TAKEN[name])
    assert brightness(after, GIVEN[name]) > 1.07 * brightness(before, GIVEN[name])


def test_cornell_has_less_red_and_a_green_copy(demo):
    before, after = (sheet.plt.imread(demo / f"cornell_{label}.png") for label in ("without", "with"))

    def colour(picture, box):
        rows, columns, _ = picture.shape
        x0, x1, y0, y1 = box
        return picture[int(y0 * rows) : int(y1 * rows), int(x0 * columns) : int(x1 * columns), :3].mean((0, 1))

    by_the_wall = (0.21, 0.28, 0.2, 0.6)
    redness = [colour(picture, by_the_wall)[0] / colour(picture, by_the_wall)[2] for picture in (before, after)]
    assert redness[1] < 0.93 * redness[0]
    on_the_floor = (0.455, 0.505, 0.90, 0.95)
    green = colour(after, on_the_floor) - colour(before, on_the_floor)
    assert green[1] > 0.05 and green[1] > 1.5 * green[0]


@pytest.mark.parametrize("name", SCENES)
def test_scene_file_is_small(name):
    assert (ROOT / f"blend_scenes/{name}.blend").stat().st_size <= 1 << 20


# --- the demo's own arithmetic ------------------------------------------------------------------------------------------------------


def test_price_of_an_error():
    """On error = 0.2 s^-1/2: 10 % cost 4 s and were reached, 1 % cost 400 s by the slope."""
    seconds = [0.5 * i for i in range(1, 41)]
    errors = [0.2 / math.sqrt(s) for s in seconds]
    assert progress_log.price(seconds, errors, 0.10) == (4.0, True)
    cost, reached = progress_log.price(seconds, errors, 0.01)
    assert not reached and abs(cost - 400) < 1e-6
    assert progress_log.price(seconds, [0.3] * 40, 0.01) is None, "an error that does not fall has no price"


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
