# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input through the module: an error names its item and says what was expected, a warning lets the render go on, and nothing
crashes, hangs, or leaves NaN in a picture. What may crash runs in a process of its own (bad_input.py)."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import sluice_core
from bad_input import CASES, good
from scenes import Scene, diffuse, exit_at, quad, render, start

HERE = Path(__file__).parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(sluice_core.__file__).resolve().parent)}
GROUPS = 10


def run_all(names):
    """name -> what came of it. A process that dies takes the case down that it was in; the others run in the next one."""
    results, left = {}, list(names)
    while left:
        done = subprocess.run([sys.executable, HERE / "bad_input.py", *left], env=ENVIRONMENT, capture_output=True, text=True, timeout=600)
        lines = done.stdout.splitlines()
        results.update(zip(left, map(json.loads, lines), strict=False))
        if done.returncode == 0:
            return results
        results[left[len(lines)]] = {"how": f"crashes ({done.returncode})", "message": done.stderr[-2000:], "warnings": []}
        left = left[len(lines) + 1 :]
    return results


def complaint(case, result):
    """What is wrong with a result; None if nothing is."""
    if result["how"] != case["how"]:
        return f"{result['how']} instead of {case['how']}"
    text = " ".join(result["warnings"]) if case["how"] == "finished" else result["message"]
    missing = [word for word in case["says"] if word not in text]
    if missing:
        return f"does not say {missing}: {text!r}"
    if case["item"] is not None and result["item"] != case["item"]:
        return f"names {result['item']!r}"
    if case["how"] == "finished" and not (result["finite"] and result["least"] >= 0 and result["ledger"] <= 1e-6):
        return "the picture is not finite, is negative, or the ledger is open"
    return None


@pytest.mark.parametrize("group", range(GROUPS))
def test_bad_input(group):
    names = list(CASES)[group::GROUPS]
    results = run_all(names)
    wrong = {name: (complaint(CASES[name], results[name]), results[name]) for name in names if complaint(CASES[name], results[name])}
    assert not wrong, "\n".join(f"{name}: {what}\n    {result}" for name, (what, result) in wrong.items())


def test_bad_quads_leave_the_picture_of_no_edit():
    """An edit that is off for its quad changes no bit."""
    plain = render({**good(), "edits": []})
    for name in ("quad without size", "quad placed at nan", "quad collapsed to a line", "offset inf"):
        d = good()
        CASES[name]["spoil"](d)
        done = render(d)
        assert any("Edit" in f"{item} {message}" for item, message in done.warnings)
        assert done.hash == plain.hash, name


def test_an_exit_without_area_leaves_the_picture_of_no_exit():
    """It sends nothing; its entry takes what it takes."""
    absorbed, collapsed = good(), good()
    absorbed["edits"][0]["exits"] = []
    CASES["exit collapsed to a point"]["spoil"](collapsed)
    pictures = [render(d)["Combined"] for d in (absorbed, collapsed, {**good(), "edits": []})]
    np.testing.assert_allclose(pictures[1], pictures[0], rtol=1e-5)
    assert not np.allclose(pictures[1], pictures[2], rtol=1e-2)


def test_a_black_picture_reaches_no_error_target():
    """It says nothing about what it has not found."""
    scene = Scene(size=8)
    scene.floor(diffuse(0.8))
    scene.point((0, 0, -1), 10.0)
    done = render(scene, passes=12, photons=64, pilot_paths=64, error_target=50.0)
    assert (done.progress["stop_reason"], done.progress["pass"]) == ("passes", 12) and done["Combined"].max() == 0


@pytest.mark.parametrize(("space", "texels", "broken"), [
    ("Linear", [np.nan, 1, 1, 1, -1, 1, 1, 1, 1, np.inf, 1, 1, 1, 1, 1, 1], 3), ("NonColor", [-1, -1, -1, 1, 0, 0, 0, 1, 1, 1, 1, 1, np.nan, 1, 1, 1], 2),
    ("Linear", [0, 1, 2, 1] * 4, 0)])  # fmt: skip
def test_broken_texels_of_exits_are_told(space, texels, broken):
    scene = Scene(size=8)
    scene.floor(diffuse(0.8))
    scene.sun()
    scene.edit("L", quad((0, 0, 0.5)), [exit_at((0.5, 0, 0.5), intensity_texture=0)])
    scene.description["images"] = [{"name": "Stripes", "width": 2, "height": 2, "color_space": space, "rgba": np.array(texels, np.float32)}]
    found = [message for item, message in render(scene, passes=1, photons=64, pilot_paths=64).warnings if item == "Edit exit 0"]
    assert len(found) == (broken > 0) and all(f"{broken} pixels of the image 'Stripes' of intensity_texture" in message for message in found)


def test_an_error_keeps_the_warnings():
    scene = Scene(size=8)
    scene.floor(diffuse(0.8))
    scene.sun()
    scene.description["meshes"][0]["positions"][1, 2] = np.nan
    scene.edit("L(", quad((0, 0, 0)))
    session = start(scene)
    assert session.wait(60) and session.progress()["state"] == "failed"
    assert [item for item, _message in session.warnings()] == ["Floor"]


def test_bad_triangles_leave_the_others():
    """One triangle of the floor has a vertex at NaN: its half is gone, the other is as before."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.8), half=1.0)
    scene.sun()
    whole = render(scene)["Combined"]
    scene.description["meshes"][0]["positions"][1, 2] = np.nan  # of the lower right triangle alone
    done = render(scene)
    assert done.warnings[0][0] == "Floor" and "1 of 2" in done.warnings[0][1]
    column, row = np.meshgrid(np.arange(16), np.arange(16))
    np.testing.assert_array_equal(done["Combined"][row > column], whole[row > column])
    assert not done["Combined"][row < column].any()


def test_no_light_is_black_and_said():
    scene = Scene(size=8)
    scene.floor(diffuse(0.8))
    done = render(scene)
    assert not done["Combined"].any() and any("no light" in message for _, message in done.warnings)


# --- expressions ------------------------------------------------------------------------------------------------------------------------------

EXPRESSIONS = [  # text, column (in characters, from 1), words of the message
    ("", 1, "empty"), ("L(", 2, "never closed"), ("L()", 2, "empty"), ("L(S|", 5, "missing"), ("L)", 2, "closes nothing"), ("*L", 1, "repeated"), ("LQ", 2, "'Q' is no event"), ("L'Lamp", 2, "never closed"),
    ("L{3,1}", 5, "second count"), ("L{", 3, "count"), ("L|", 3, "missing"), ("[L", 1, "never closed"), ("L[^]", 4, "empty"), ("L!", 3, "after !"),
    ("L!(S", 5, "!(D|S)"), ("L D é", 5, "'é' is no event"), ("L'Café é' Q", 11, "'Q' is no event"), ("LDE", 3, "one of the two"), ("D", 1, "L first"),
    (".*", 1, "L first"), ("DE", 1, "view paths end"), ("L?D", 3, "L first"), ("L" + "." * 1100, 1025, "1,024"), ("L" + "(" * 70 + "D" + ")" * 70, 66, "64"),
    ("L" + "D" * 300, 1, "256"), ("L.*S" + "." * 16, 1, "4,096 states"), ("LD{99999}", 4, "256")]  # fmt: skip


@pytest.mark.parametrize(("text", "column", "word"), EXPRESSIONS, ids=[repr(e[0][:12]) for e in EXPRESSIONS])
def test_a_bad_expression_stops_the_render(text, column, word):
    """With the edit's name, the column, and a sentence; the check beside the text field says the same."""
    scene = Scene(size=8)
    scene.floor(diffuse(0.8))
    scene.sun()
    scene.edit(text, quad((0, 0, 0)), [exit_at((0.5, 0, 0))], name="Bad one")
    session = start(scene)
    assert session.wait(20)
    progress = session.progress()
    assert progress["state"] == "failed", progress
    error = progress["error"]
    assert error["item"] == "Bad one" and len(error["message"]) > 10 and word in error["message"]
    assert error["column"] == column
    assert session.snapshot(["Combined"]) is None
    if "states" in word:
        return  # the check does not compile
    with pytest.raises(sluice_core.ExpressionError) as caught:
        sluice_core.check_expression(text, [])
    assert isinstance(caught.value, ValueError) and caught.value.column == error["column"]


def test_one_bad_expression_among_good_ones_is_named():
    scene = Scene(size=8)
    scene.floor(diffuse(0.8))
    scene.sun()
    for i, text in enumerate(("L", "LD(", "LS")):
        scene.edit(text, quad((0, 0, 0.1 * i)), [exit_at((0.5, 0, 0))], name=f"Edit {i}")
    session = start(scene)
    assert session.wait(20)
    assert session.progress()["error"]["item"] == "Edit 1"
    scene.description["edits"][1]["enabled"] = False  # an edit that is off is not read
    assert render(scene)


def test_unknown_names_are_warned_of_with_the_nearest():
    scene = Scene(size=8)
    scene.floor(diffuse(0.8))
    scene.sun(name="Sunny")
    scene.edit("L'Suny'", quad((0, 0, 0)), [exit_at((0.5, 0, 0))])
    done = render(scene)
    assert [m for item, m in done.warnings if item == "Edit" and "Suny" in m and "Sunny" in m]


@pytest.mark.parametrize(("name", "nearest"), [
    ("Redwall", "Red wall"), ("egg", "Egg"), ("Eg", "Egg"), ("Lmap", "Lamp"), ("Wall", None), ("x", None), ("Glass sphere", None), ("", None)])  # fmt: skip
def test_only_a_name_that_is_near_is_offered(name, nearest):
    (warning,) = sluice_core.check_expression(f"L.*D'{name or 'zzzzzz'}'", ["Egg", "Red wall", "Lamp"])["warnings"]
    assert warning.endswith(f"; the nearest name is '{nearest}'" if nearest else "'") and ("nearest" in warning) == (nearest is not None)


# --- sessions -----------------------------------------------------------------------------------------------------------------------------------


def test_a_session_starts_once():
    session = start(good(), passes=2)
    with pytest.raises(RuntimeError):
        session.start(good(), {"passes": 2})
    assert session.wait(20)
    first = session.film_hash()
    with pytest.raises(RuntimeError):
        session.start(good(), {"passes": 5})
    assert session.progress()["state"] == "finished" and session.film_hash() == first


def test_a_session_that_was_not_started_answers():
    session = sluice_core.Session()
    assert session.wait(0.0) and session.progress()["state"] == "idle"
    assert session.snapshot(["Combined"]) is None and session.warnings() == [] and session.statistics()["rays"] == 0
    session.cancel()
    assert int(session.film_hash(), 16) == 0


def test_pictures_of_unknown_passes_are_none():
    session = start(good())
    assert session.wait(20)
    assert session.snapshot(["Combined", "Colour"]) is None and session.snapshot(["Colour"]) is None


def test_a_description_is_copied_whole():
    """What happens to the dict and its arrays after start does not matter."""
    want = render(good()).hash
    d = good()
    session = start(d)
    for mesh in d["meshes"]:
        mesh["positions"][:] = np.nan
        mesh["triangles"][:] = 99
    d.clear()
    assert session.wait(20) and session.film_hash() == want


# --- cancel ---------------------------------------------------------------------------------------------------------------------------------------


def heavy_mesh():
    """A million triangles: compiling takes a while."""
    scene = Scene(size=64)
    scene.sphere("Ball", (0, 0, 0), 1.0, diffuse(0.5), rings=500)
    scene.sun()
    return scene.description


def heavy_world():
    scene = Scene(size=64)
    scene.floor(diffuse(0.5))
    d = scene.description
    sky = [{"kind": "Background", "name": "Sky", "options": {}, "inputs": [{"name": "Color", "node": 1, "output": "Color"}]},
           {"kind": "TexChecker", "name": "Checker", "options": {}, "inputs": []}]  # fmt: skip
    d["materials"].append({"name": "Sky", "nodes": sky, "surface": 0, "surface_output": ""})
    d["world"] = {"name": "World", "material": len(d["materials"]) - 1, "resolution": 8192}
    return d


def endless():
    return good()


CANCELS = [
    ("at once", endless, 0.0, {}), ("in the first pass", endless, 0.8, {"photons": 2**30}), ("between passes", endless, 1.0, {}), ("in a mesh", heavy_mesh, 0.1, {}),
    ("in a mesh, late", heavy_mesh, 0.4, {}), ("in a world", heavy_world, 0.3, {}), ("in the guide", endless, 0.05, {"max_depth": 10**6})]  # fmt: skip


@pytest.mark.parametrize(("when", "build", "after", "settings"), CANCELS, ids=[c[0] for c in CANCELS])
def test_cancel_takes_half_a_second(when, build, after, settings):
    """The best of three, as other programs may hold the processors."""
    took = []
    for _ in range(3):
        session = start(build(), **{"passes": 10**6, "photons": 4096, "threads": 2, **settings})
        time.sleep(after)
        begin = time.monotonic()
        session.cancel()
        assert session.wait(30)
        took.append(time.monotonic() - begin)
        progress = session.progress()
        assert (progress["state"], progress["stop_reason"]) == ("cancelled", "cancelled")
        assert progress["error"] is None
        if took[-1] <= 0.5:
            return
    raise AssertionError(f"{min(took):.2f} s")


def test_a_dropped_session_stops():
    begin = time.monotonic()
    session = start(good(), passes=10**6, photons=2**28)
    time.sleep(0.2)
    del session
    assert time.monotonic() - begin < 5


def test_python_may_end_while_sessions_render():
    code = "from bad_input import good; from scenes import start; import time; s = [start(good(), passes=10**6, threads=2) for _ in range(3)]; time.sleep(0.3)"
    begin = time.monotonic()
    done = subprocess.run([sys.executable, "-c", code], cwd=HERE, env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert time.monotonic() - begin < 20
