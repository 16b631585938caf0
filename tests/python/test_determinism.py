# SPDX-License-Identifier: GPL-3.0-or-later
"""Same bits: for any number of threads, beside other sessions, for a border, and for edits that do nothing."""

import copy

import numpy as np
import pytest
import sluice_core
from scenes import Scene, diffuse, emission, exit_at, glass, looking, mirror, quad, render, start

SETTINGS = {"passes": 5, "photons": 5000, "threads": 2, "use_adaptive_sampling": True, "caustic_radius_range": 2.5}  # no whole block, no whole chunk


def room(edited=True):
    """A corner with glass and mirror, a small lamp, an emissive mesh; a caustic edit, a view edit and a hue."""
    scene = Scene(size=40)
    scene.perspective(looking((0, -3.2, 1.6), (0, 3, -0.9), up=(0, 0, 1)), 0.9)
    scene.floor(diffuse((0.8, 0.5, 0.4)))
    scene.plane("Wall", [(-2, 1, 0), (2, 1, 0), (2, 1, 2), (-2, 1, 2)], diffuse(0.7))
    scene.plane("Mirror", [(-1.5, 0.99, 0.5), (-0.5, 0.99, 0.5), (-0.5, 0.99, 1.5), (-1.5, 0.99, 1.5)], mirror(0.9))
    scene.sphere("Egg", (0.2, 0.1, 0.5), 0.35, glass(), rings=24)
    scene.plane("Panel", [(1.2, -1, 1.8), (1.2, 1, 1.8), (1.6, 1, 1.8), (1.6, -1, 1.8)], emission((1, 0.9, 0.6), 4.0))
    scene.point((0.3, -0.5, 1.9), 30, radius=0.02, color=(1, 0.8, 0.6))
    if edited:
        scene.edit("LS'Egg'+", quad((0.2, 0.3, 0), (0.4, 0, 0), (0, 0.4, 0)), [exit_at((-0.8, 0, 0), (0.4, 0, 0), (0, 0.4, 0), hue_shift=1.0)], name="Caustic")
        scene.edit("S'Mirror'E", quad((-1, 0.99, 1), (0.3, 0, 0), (0, 0, 0.3), (0, -1, 0)), [exit_at((0, -1, 1), (0.3, 0, 0), (0, 0, 0.3), (0, -1, 0))], name="Reflection")
    return scene


@pytest.fixture(scope="module")
def alone():
    return render(room(), **SETTINGS)


def test_the_room_has_every_effect(alone):
    """Else the tests below would say little."""
    for part in ("Direct", "Caustics", "Edited", "Indirect", "Emission"):
        assert alone[part].max() > 0, part
    assert all(edit["matched"] > 0 for edit in alone.statistics["edits"])


@pytest.mark.parametrize("threads", [1, 3])
def test_threads_change_no_bit(alone, threads):
    other = render(room(), **{**SETTINGS, "threads": threads})
    assert other.hash == alone.hash
    np.testing.assert_array_equal(other["Combined"], alone["Combined"])
    assert other.statistics["guide_hash"] == alone.statistics["guide_hash"]
    assert other.statistics["ledger"] == alone.statistics["ledger"]


def test_sessions_at_once_are_as_alone(alone):
    scenes = [room(), room(edited=False), room()]
    want = [alone.hash, render(scenes[1], **SETTINGS).hash, render(scenes[2], **{**SETTINGS, "seed": 7}).hash]
    sessions = [start(scenes[0], **SETTINGS), start(scenes[1], **SETTINGS), start(scenes[2], **{**SETTINGS, "seed": 7})]
    assert all(session.wait(60) for session in sessions)
    assert [session.film_hash() for session in sessions] == want
    assert len(set(want)) == 3


def test_seeds_and_frames_differ():
    hashes = [render(room(), **SETTINGS, **more).hash for more in (
        {"seed": 0}, {"seed": 1}, {"seed": 0, "frame": 2}, {"use_animated_seed": True, "frame": 1}, {"use_animated_seed": True, "frame": 2})]  # fmt: skip
    assert hashes[0] == hashes[2]  # the frame counts only if it is asked to
    assert len(set(hashes)) == 4


@pytest.mark.parametrize("border", [(0, 0, 40, 40), (5, 9, 38, 31), (33, 2, 40, 3)])
def test_a_border_is_a_crop_of_the_frame(alone, border):
    x0, y0, x1, y1 = border
    scene = room()
    scene.description["frame"].update(x0=x0, y0=y0, x1=x1, y1=y1)
    part = render(scene, **SETTINGS)
    for name in alone.pictures:
        np.testing.assert_array_equal(part[name], alone[name][y0:y1, x0:x1], err_msg=name)
    assert part.statistics["guide_hash"] == alone.statistics["guide_hash"]


# --- edits that do nothing --------------------------------------------------------------------------------------------------------------


def with_edit(scene, **more):
    """An edit inside the space of the others, whose expression no path can have: five glass spheres in a row."""
    scene = copy.deepcopy(scene)
    at = {"entry": quad((0.1, 0.2, 0.3), (0.3, 0, 0), (0, 0.2, 0.1)), "exits": [exit_at((-0.5, 0.1, 0.2), (0.2, 0, 0), (0, 0.2, 0))]}
    scene.edit(**{"expression": "LDSSSDSSSDSSSD", "name": "Extra", **at, **more})
    return scene


@pytest.mark.parametrize("edited", [False, True])
@pytest.mark.parametrize("kind", ["unmatched", "disabled", "view"])
def test_an_edit_that_does_nothing_changes_no_bit(alone, kind, edited):
    more = {"unmatched": {}, "disabled": {"expression": "L.*", "enabled": False}, "view": {"expression": "S'Egg'{9}S'Mirror'{3}S'Egg'E"}}[kind]
    plain = alone if edited else render(room(edited=False), **SETTINGS)
    extra = render(with_edit(room(edited), **more), **SETTINGS)
    if kind != "disabled":
        assert extra.edit("Extra")["matched"] == 0
    assert extra.hash == plain.hash


def test_a_disabled_edit_may_be_anywhere(alone):
    far = quad((1e5, 0, 0), (100, 0, 0), (0, 100, 0))
    assert render(with_edit(room(), entry=far, enabled=False), **SETTINGS).hash == alone.hash


def test_edits_all_off_is_no_edit(alone):
    plain = render(room(edited=False), **SETTINGS)
    assert render(room(), **SETTINGS, use_edits=False).hash == plain.hash
    assert plain.hash != alone.hash


# --- another shot of what is compiled -------------------------------------------------------------------------------------------------

SHOT = ("camera", "frame", "edits", "layers", "max_gates")


def changed(what):
    """The room after one of the things that an artist does without touching its things."""
    scene = room()
    d = scene.description
    if what == "orbit":
        scene.perspective(looking((0.5, -3, 1.8), (-0.3, 3, -1), up=(0, 0, 1)), 0.8)
    elif what == "frame":
        d["frame"] = {"width": 24, "height": 30, "x1": 20}
    elif what == "drag":
        d["edits"][0]["exits"][0]["quad"]["matrix"][:3, 3] = (-1, -1.5, 0.4)
    elif what == "knobs":
        d["edits"][0] |= {"amount": 0.5, "feather": 0.3, "expression": "L.*"}
        d["max_gates"] = 1
    elif what == "outside":  # quads reach beyond the things, so bounds grow
        d["edits"][0]["exits"][0]["quad"]["matrix"][:3, 3] = (30, 0, 5)
    elif what == "none":
        d["edits"] = []
    elif what == "layer":
        scene.layer("Moved", "L.*F'Caustic'.*E")
    return scene


@pytest.fixture(scope="module")
def compiled():
    session = start(room(), passes=1, photons=1000)
    assert session.wait(60)
    return session


@pytest.mark.parametrize("what", ["nothing", "orbit", "frame", "drag", "knobs", "outside", "none", "layer"])
def test_a_shot_of_what_is_compiled_is_as_one_of_all(alone, compiled, what):
    scene = changed(what)
    session = sluice_core.Session()
    assert session.start_from(compiled, {key: scene.description[key] for key in SHOT if key in scene.description}, {"seed": 0, **SETTINGS})
    assert session.wait(60) and session.progress()["state"] == "finished"
    whole = render(scene, **SETTINGS)
    assert session.film_hash() == whole.hash and session.warnings() == whole.warnings
    assert session.statistics()["guide_hash"] == whole.statistics["guide_hash"]
    assert (whole.hash == alone.hash) == (what == "nothing")


def test_edits_off_in_a_shot(compiled):
    session = sluice_core.Session()
    assert session.start_from(compiled, {key: room().description[key] for key in SHOT[:3]}, {"seed": 0, **SETTINGS, "use_edits": False})
    assert session.wait(60) and session.film_hash() == render(room(edited=False), **SETTINGS).hash


def test_what_a_shot_cannot_be_made_of(compiled):
    """Far small quads move the origin, on which all vertices depend; a session without things has none to give."""
    scene = room()
    for part in (scene.description["edits"][0]["entry"], scene.description["edits"][0]["exits"][0]["quad"], *(
            q for e in scene.description["edits"][1:] for q in (e["entry"], e["exits"][0]["quad"]))):
        part["matrix"][:3, 3] += (1e5, 0, 0)
    session = sluice_core.Session()
    assert not session.start_from(compiled, {"edits": scene.description["edits"]}, SETTINGS)
    assert not session.start_from(sluice_core.Session(), {}, SETTINGS)
    assert session.progress()["state"] == "idle"
    session.start(scene.description, SETTINGS)  # it can still do what it was asked for
    assert session.wait(60) and session.progress()["state"] == "finished"


@pytest.mark.parametrize("broken, message", [({"edits": 3}, "'edits' of the description must be a list"), ({"camera": {"lens": "long"}}, "'lens'")])
def test_a_shot_that_is_none(compiled, broken, message):
    with pytest.raises(sluice_core.SceneError, match=message):
        sluice_core.Session().start_from(compiled, broken, SETTINGS)


def test_an_error_in_a_shot_is_the_session_s(compiled):
    shot = {key: room().description[key] for key in SHOT[:3]}
    shot["edits"][0]["expression"] = "LS+("
    session = sluice_core.Session()
    assert session.start_from(compiled, shot, SETTINGS) and session.wait(60)
    error = session.progress()["error"]
    assert error["item"] == "Caustic" and error["column"] == 4
    texture = {key: room().description[key] for key in SHOT[:3]}
    texture["edits"][0]["exits"][0]["intensity_texture"] = 5
    session = sluice_core.Session()
    assert session.start_from(compiled, texture, SETTINGS) and session.wait(60)
    assert "texture: index 5 into a list of 0" in session.progress()["message"]


def test_a_shot_outlives_the_session_it_was_made_from(alone):
    first = start(room(), passes=1, photons=1000)
    assert first.wait(60)
    session = sluice_core.Session()
    assert session.start_from(first, {key: room().description[key] for key in SHOT[:3]}, {"seed": 0, **SETTINGS})
    del first
    assert session.wait(60) and session.film_hash() == alone.hash


# --- passes -----------------------------------------------------------------------------------------------------------------------------


def test_more_passes_begin_with_the_same_passes():
    """What 16 passes sum to, less what the first 4 do, is what passes 4 to 15 bring: no negative light, and the work of 12 passes."""
    few, many = (render(room(), **{**SETTINGS, "passes": n}) for n in (4, 16))
    assert few.statistics["guide_hash"] == many.statistics["guide_hash"]
    rest = 16 * many["Combined"] - 4 * few["Combined"]
    assert rest.min() >= -1e-5 * many["Combined"].max()
    assert many.statistics["view_paths"] == 4 * few.statistics["view_paths"] > 16 * 40 * 40
    assert many.statistics["photon_paths"] == pytest.approx(4 * few.statistics["photon_paths"], rel=0.01)


def test_a_session_stopped_by_time_is_a_prefix():
    """However many passes the clock allows, they are the first ones."""
    session = start(room(), **{**SETTINGS, "passes": 100000}, time_limit=0.4)
    assert session.wait(60)
    progress = session.progress()
    assert progress["state"] == "finished" and progress["stop_reason"] == "time"
    passes = progress["pass"]
    assert 1 <= passes < 100000
    assert render(room(), **{**SETTINGS, "passes": passes}).hash == session.film_hash()
