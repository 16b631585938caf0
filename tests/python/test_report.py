# SPDX-License-Identifier: GPL-3.0-or-later
"""./run report: its numbers against cases made by hand, one small report end to end, and that bad input leaves a sentence and no file."""

import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import report as report_tool
import report_demos
import report_measures as measures
import report_page

FULL = bool(os.environ.get("SLUICE_FULL"))
MAKE = """
import bpy
scene = bpy.context.scene
scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "SLUICE", 32, 24
scene.sluice.photons, scene.sluice.passes = 2000, 4
scene.world.use_nodes = False
scene.world.color = (0, 0, 0)
if hasattr(scene.render.image_settings, "media_type"):  # since 5.0
    scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR_MULTILAYER", f"{folder}/lit.exr"
bpy.ops.render.render(write_still=True)
for name in ("lit", "dark"):
    bpy.ops.wm.save_as_mainfile(filepath=f"{folder}/{name}.blend", copy=True)
    for lamp in [item for item in scene.objects if item.type == "LIGHT"]:
        bpy.data.objects.remove(lamp)
"""


# --- measures ----------------------------------------------------------------------------------------------------------------------


def test_true_error_is_that_of_the_design():
    """A picture 10 % too bright where the reference is 1 everywhere: d² / (c² + (m / 10)²) = 0.01 / 1.01."""
    reference = np.ones((40, 50, 3))
    assert measures.true_error(1.1 * reference, reference) == pytest.approx((0.01 / 1.01) ** 0.5, rel=1e-12)


def test_true_error_leaves_out_the_worst_of_a_thousand_pixels():
    """Of 2,000 pixels two; a third one counts."""
    reference = np.ones((40, 50, 3))
    image = reference.copy()
    image[0, :2] += 1000
    assert measures.true_error(image, reference) == 0
    image[0, 2] += 1
    assert measures.true_error(image, reference) == pytest.approx((1 / 1.01 / 1998) ** 0.5, rel=1e-12)
    small = np.ones((9, 9, 3))
    assert measures.true_error(small + 1, small) > 0.9, "of fewer than a thousand pixels none is left out"


def test_true_error_counts_channels_and_the_dark():
    """Luminance tells the mean; each channel is relative to itself, and what is dark counts as a tenth of the mean."""
    reference = np.zeros((10, 10, 3))
    reference[..., 1] = 2
    dark = (2 * 0.7152 / 10) ** 2
    image = reference + np.array([0.1, 0.1, 0.1])
    assert measures.true_error(image, reference) == pytest.approx(((2 * 0.01 / dark + 0.01 / (4 + dark)) / 3) ** 0.5, rel=1e-12)


def test_noise_of_the_reference_is_taken_off_in_squares():
    reference = np.ones((8, 8, 3))
    told = measures.against(1.1 * reference, reference, 0.06)
    assert told["true_without_reference_noise"] == pytest.approx((told["true"] ** 2 - 0.06**2) ** 0.5, rel=1e-12)
    assert measures.against(reference, reference, 0.06)["true_without_reference_noise"] == 0
    assert measures.against(reference, reference, None)["true_without_reference_noise"] is None


def curve_of(noise, bias, passes=(4, 8, 16)):
    """What a render tells whose error follows the laws exactly; each pass takes 0.5 s after 1 s of the guide."""
    rows = []
    for n in passes:
        found = {"noise": noise * n**-0.5, "bias": bias * n ** (-1 / 3)}
        error = (found["noise"] ** 2 + found["bias"] ** 2) ** 0.5
        rows.append({"pass": n, "seconds": 1 + n / 2, "rays": 1000 * n, "photons": 10 * n, "error": error, **found})
    return rows


def test_cost_is_measured_where_it_was_reached():
    found = measures.cost(curve_of(0.2, 0), 0.08)
    assert found["measured"] and (found["pass"], found["seconds"], found["rays"], found["photons"]) == (8, 5, 8000, 80)


@pytest.mark.parametrize("noise, bias, passes", [(0.2, 0, 1600), (0, 0.05, 1000), (0.1, 0.05, None)])
def test_cost_beyond_follows_the_laws(noise, bias, passes):
    """Noise alone: (0.2 / 0.005)² passes. Bias alone: (0.05 / 0.005)³."""
    found = measures.cost(curve_of(noise, bias), 0.005)
    n = found["pass"]
    assert not found["measured"] and (passes is None or abs(n - passes) <= 1)
    assert curve_of(noise, bias, [n])[0]["error"] <= 0.005 < curve_of(noise, bias, [n - 2])[0]["error"]
    assert found["seconds"] == pytest.approx(1 + n / 2) and found["rays"] == 1000 * n and found["photons"] == 10 * n


def test_cost_of_what_is_not_known():
    assert measures.cost([], 0.01) is None
    assert measures.cost([{"pass": 2, "error": None}], 0.01) is None
    one = measures.cost(curve_of(0.2, 0, [4]), 0.05)
    assert one["pass"] == 16 and one["seconds"] == pytest.approx(12), "one estimate: each pass as long as those before"


def test_settings_are_compared_at_the_same_error():
    """Half the work for 1.2 times the noise is cheaper (0.72), for 1.6 times it is not (1.28), though error × work says so."""
    now = {"name": "now", "seconds": 10.0, "work": 1000, "error": 0.1, "noise": 0.1, "bias": 0.0}
    good, bad = ({**now, "name": str(f), "seconds": 5.0, "work": 500, "error": 0.1 * f, "noise": 0.1 * f} for f in (1.2, 1.6))
    unknown = {**now, "error": None}
    rows = {row["name"]: row for row in measures.compare_settings([now, good, bad, unknown])}
    assert rows["1.2"]["same_error_seconds"] == pytest.approx(7.2) and rows["1.6"]["same_error_work"] == pytest.approx(1280)
    assert rows["1.6"]["error_seconds"] < rows["now"]["error_seconds"]
    assert [name for name, row in rows.items() if row["best"]] == ["1.2"]


def test_estimates_are_those_of_the_last_pass():
    """Measured after 4 passes of 16: noise is half of that then, bias 4^(-1/3)."""
    accuracy = [{"pass": 4, "error": 0.5, "noise": 0.4, "bias": 0.3}]
    found = report_tool.report_figures.estimate({"passes": 16, "statistics": {"accuracy": accuracy}})
    assert (found["noise"], found["bias"]) == pytest.approx((0.2, 0.3 * 4 ** (-1 / 3)))
    assert report_tool.report_figures.estimate({"passes": 2, "statistics": {"accuracy": []}})["error"] is None


def test_slope_of_a_power():
    assert measures.slope([{"seconds": s, "error": 0.3 * s**-0.4} for s in (1, 2, 5, 9)], "error") == pytest.approx(-0.4)
    assert measures.slope([{"seconds": 1, "error": 0.3}], "error") is None


def test_error_map_of_even_noise():
    """A picture of one value with 5 % noise: about 5 % everywhere, also at the border; bias adds in squares."""
    grey = np.full((6, 9, 3), 0.3)
    assert measures.error_map(grey, np.full((6, 9), 0.05), np.zeros((6, 9))) == pytest.approx(0.05 / 1.01**0.5)
    assert measures.error_map(grey, np.full((6, 9), 0.03), np.full((6, 9), 0.04)) == pytest.approx(0.05 / 1.01**0.5)


# --- a report ----------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    """A small lit scene and the same without its lamp."""
    folder = tmp_path_factory.mktemp("scenes")
    script = f"folder = {str(folder)!r}\n{MAKE}"
    command = ["blender", "--addons", "sluice", "-b", "--factory-startup", "--python-exit-code", "1", "--python-expr", script]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    (folder / "broken.blend").write_text("no scene of Blender's")
    np.save(folder / "small.npy", np.ones((12, 16, 3), np.float32))
    np.save(folder / "holes.npy", np.full((24, 32, 3), np.nan, np.float32))
    (folder / "words.npy").write_text("no picture")
    (folder / "words.exr").write_text("no picture")
    return folder


def run(*words):
    return subprocess.run([sys.executable, ROOT / "tools/report.py", *map(str, words)], capture_output=True, text=True)


@pytest.mark.skipif(not FULL, reason="long")
def test_reference_of_a_file(scenes, tmp_path):
    """The picture that Blender wrote under the same settings and seed is the render itself: no error is left."""
    done = run(scenes / "lit.blend", "--passes", 4, "--reference", scenes / "lit.exr", "--out", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "lit/report.json").read_text())
    assert report["reference"]["passes"] is None
    assert report["checkpoints"][-1]["against"]["true"] < 1e-6 < report["checkpoints"][0]["against"]["true"]


class Page(HTMLParser):
    """What a page has: elements that are open, and what they refer to."""

    VOID = {"meta", "img", "br"}

    def __init__(self, text):
        super().__init__()
        self.open, self.references, self.tables = [], [], 0
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.references += [value for name, value in attributes if name in {"src", "href"}]
        self.tables += tag == "table"
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def check_page(text):
    page = Page(text)
    assert page.open == [] and page.tables >= 2
    assert page.references and all(reference.startswith("data:image/png;base64,") for reference in page.references)
    assert not re.search(r"https?://|@import|url\(", text)


def check_figures(report):
    assert report["size"] == [32, 24] and report["settings"]["passes"] == 4 and report["name"] == "lit" and report["processor"]
    assert [row["pass"] for row in report["checkpoints"]] == [1, 2, 4]
    first, last = report["checkpoints"][0], report["checkpoints"][-1]
    assert first["error"] is None and 0 < last["error"] < 1 and last["rays"] > 0 and 0 < last["photons"] <= 4 * 2000
    assert last["error"] == pytest.approx((last["noise"] ** 2 + last["bias"] ** 2) ** 0.5)
    assert all(row["against"]["true"] > 0 and (row["against"]["flip"] is not None) == (report["flip"] == "measured") for row in report["checkpoints"])
    assert report["reference"]["passes"] == 16 and report["reference"]["seed"] != report["settings"]["seed"]
    assert {part["name"] for part in report["accuracy"][-1]["parts"]} >= {"Direct", "Indirect"}
    assert [row["name"] for row in report["alternatives"]] == list(report_tool.report_figures.NEIGHBOURS.values())
    assert sum(row["best"] for row in report["alternatives"]) == 1
    assert {row["name"]: row["runs"] for row in report["effects"]}.items() >= {"direct": True, "caustics": False, "edited light": False}.items()
    assert [row["error"] for row in report["costs"]] == [0.10, 0.05, 0.02, 0.01]
    assert {"slopes", "versions", "work", "seconds", "memory", "balance", "main_cause", "unmet"} <= set(report)


def test_report(scenes, tmp_path):
    done = run(scenes / "lit.blend", "--passes", 4, "--reference", "auto", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["index.html", "lit", "out", "report.json"]
    made = tmp_path / "out/lit/report.json"
    check_figures(json.loads(made.read_text()))
    check_page((tmp_path / "out/lit/index.html").read_text())
    done = run("--compare", made, made, "--out", tmp_path / "both")
    assert done.returncode == 0, done.stderr
    check_page(next((tmp_path / "both").rglob("index.html")).read_text())


# --- bad input ---------------------------------------------------------------------------------------------------------------------

REFUSED = {
    "no scene": ([], "name a scene"),
    "no file": (["gone.blend"], "there is no file"),
    "no passes": (["lit.blend", "--passes", "0"], "--passes must be at least 1"),
    "no size": (["lit.blend", "--scale", "0"], "--scale must be above 0"),
    "no reference": (["lit.blend", "--reference", "gone.exr"], "there is no reference"),
    "reference of words": (["lit.blend", "--reference", "words.exr"], "is no picture with red, green and blue"),
    "one report": (["--compare", "words.npy", "words.npy"], "is no report.json"),
    "no light": (["dark.blend", "--passes", "1"], "the scene has no light"),
    "no blend file": (["broken.blend"], "broken.blend"),
    "reference of another size": (["lit.blend", "--reference", "small.npy"], "has 16 × 12 pixels, the render 32 × 24"),
    "reference of another frame": (["lit.blend", "--frame", "2", "--reference", "lit.exr"], "shows frame 1, the render frame 2"),
    "reference that is none": (["lit.blend", "--reference", "words.npy"], "is no picture of NumPy"),
    "reference with holes": (["lit.blend", "--reference", "holes.npy"], "holds what is no number"),
}
QUICK = [name for name in REFUSED if name not in {"reference that is none", "reference with holes"}]


@pytest.mark.parametrize("what", REFUSED if FULL else QUICK)
def test_bad_input_leaves_a_sentence_and_no_file(what, scenes, tmp_path):
    words, sentence = REFUSED[what]
    here = [scenes / word if "." in word else word for word in words]
    done = run(*here, "--out", tmp_path / "out")
    assert done.returncode == 1 and list(tmp_path.iterdir()) == []
    assert done.stderr.startswith("report: ") and sentence in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_a_failure_on_the_way_leaves_the_old_report(tmp_path):
    """Files are renamed into their place; one that cannot be written changes none of them."""
    report_tool.publish({"a": "old", "b": "old"}, tmp_path / "place")
    with pytest.raises(TypeError):
        report_tool.publish({"a": "new", "b": None}, tmp_path / "place")
    assert [(tmp_path / "place" / name).read_text() for name in "ab"] == ["old", "old"]
    report_tool.publish({"a": "new"}, tmp_path / "place")
    assert [(tmp_path / "place" / name).read_text() for name in "ab"] == ["new", "old"] and len(list(tmp_path.iterdir())) == 1


def test_channels_of_references():
    assert report_tool.channels_of_pictures(["R", "G", "B", "A"]) == [["R", "G", "B"]]
    assert ["View Layer.Combined.R", "View Layer.Combined.G", "View Layer.Combined.B"] in report_tool.channels_of_pictures(["View Layer.Combined.R"])


# --- the page on accuracy ----------------------------------------------------------------------------------------------------------


def test_figures_go_between_their_marks():
    rows = [{"name": "a", "true": {1: 0.4, 4: 0.2, 16: 0.1, 64: 0.05}, "estimated": {1: None, 4: 0.19, 16: 0.1, 64: 0.05}, "bias": 0.01,
             "seconds": 3.0, "rays": 1e6, "costs": {0.05: None, 0.02: {"measured": False, "pass": 400, "seconds": 19.0}},
             "cause": ("Caustics", 0.7), "reference": None}]  # fmt: skip
    text = report_demos.document(f"before\n{report_demos.BEGIN}\nold\n{report_demos.END}\nafter\n", rows, "a processor")
    assert text.startswith("before\n") and text.endswith("\nafter\n") and "old" not in text
    assert "| `a` | 40.0 | 20.0 (19.0) | 10.0 (10.0) | 5.0 (5.0) | 1 M | 3.0 | – | ~400 passes, ~19 s | Caustics, 70 % |" in text
    assert "divide the error by 2.0 to 2.0" in text and "0.95 to 1.00 times the true error" in text


def test_accuracy_page_is_whole():
    text = (ROOT / "docs/accuracy.md").read_text()
    assert all(f"| `{name}` |" in text for name in report_demos.SCENES)
    assert 10_000 < (ROOT / "docs/accuracy.png").stat().st_size < 300_000
    assert "docs/accuracy.png" in (ROOT / "README.md").read_text()


@pytest.mark.skipif(not FULL, reason="long")
@pytest.mark.parametrize("name", ["cornell", "fig5"])
def test_estimate_is_the_true_error(name, tmp_path):
    """Within a third, on demo scenes after 16 passes, against a reference of its own, whose noise comes on top."""
    done = run(ROOT / f"blend_scenes/{name}.blend", "--passes", 16, "--scale", 10, "--reference", "auto", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / name / "report.json").read_text())
    last = report["checkpoints"][-1]
    expected = (last["error"] ** 2 + report["reference"]["noise"] ** 2) ** 0.5
    assert last["against"]["true"] == pytest.approx(expected, rel=0.33), (last["error"], last["against"])


def test_numbers_are_short():
    assert [report_page.number(value) for value in (None, 0.01234, 5, 12345, 2.5e6)] == ["–", "0.0123", "5", "12.3 k", "2.5 M"]
    assert [report_page.seconds(value) for value in (None, 1.234, 123.4)] == ["–", "1.23 s", "123 s"]
