# SPDX-License-Identifier: GPL-3.0-or-later
"""What limits cut off is counted and said: depth, gates, alpha layers, memory for the states of paths. Branches beyond the split budget
are stood for by others."""

import re

import numpy as np
import pytest
from scenes import Scene, diffuse, emission, exit_at, mirror, quad, render, seeds, shader
from statistics_of_renders import assert_mean, assert_same_mean

PASSES = {"passes": 2, "photons": 4096, "pilot_paths": 4096}


def said(done):
    """The counters of the report's own line."""
    line = next(line for line in done.statistics["report"].splitlines() if line.startswith("dropped:"))
    return {f"{name}_capped": int(re.search(rf"(\d+) by {name}", line)[1]) for name in ("depth", "gates", "alpha", "states")}


def capped(scene, **settings):
    done = render(scene, **{**PASSES, **settings})
    counters = done.statistics["dropped"]
    assert said(done) == {name: counters[name] for name in said(done)}
    return {name for name, count in said(done).items() if count}, done


def lit(size=16):
    scene = Scene(size=size)
    scene.floor(diffuse(0.5))
    scene.point((0, 0, 2), 100)
    return scene


def test_nothing_is_capped_in_a_plain_scene():
    found, done = capped(lit())
    assert found == set() and done.warnings == []


def test_view_paths_beyond_the_depth():
    """The eye sees a ceiling in a mirror; no photon is emitted."""
    scene = lit()
    scene.floor(mirror(1.0), z=0.5, name="Mirror")
    scene.floor(diffuse(0.5), half=4.0, z=6.0, name="Ceiling")
    for depth, want in ((1, {"depth_capped"}), (2, set())):
        assert capped(scene, max_depth=depth, use_indirect=False, use_caustics=False)[0] == want


def test_joins_beyond_the_gates():
    """Light that was moved once, seen through a view edit: two gates of one path, one on either side."""
    for gates, want in ((1, {"gates_capped"}), (2, set())):
        scene = lit()
        scene.edit("L", quad((0.5, 0, 0), (0.3, 0, 0), (0, 0.3, 0)), [exit_at((-0.5, 0, 0), (0.3, 0, 0), (0, 0.3, 0))], name="Light")
        scene.edit("F*E", quad((0, 0, 3), (2, 0, 0), (0, 2, 0)), [exit_at((0, 0, 2.5), (2, 0, 0), (0, 2, 0))], name="View")
        scene.description["max_gates"] = gates
        found, done = capped(scene)
        assert found == want
        assert (done["Edited"].max() > 0) == (gates == 2)


def test_exits_met_backward_beyond_the_gates():
    scene = lit()
    scene.edit("L", quad((0.5, 0, 1), (0.3, 0, 0), (0, 0.3, 0)), [exit_at((-0.5, 0, 1), (0.3, 0, 0), (0, 0.3, 0))])
    scene.description["max_gates"] = 0
    assert "gates_capped" in capped(scene)[0]


def veils(count, lowest):
    scene = lit(4)
    scene.description["frame"].update(width=2, height=2)
    for i in range(count):
        z = lowest + i * 1e-3
        scene.plane(f"Veil {i}", [(-3, -3, z), (3, -3, z), (3, 3, z), (-3, 3, z)], [shader("BsdfTransparent", (1, 1, 1))])
    return scene


@pytest.mark.parametrize(("count", "want"), [(250, set()), (300, {"alpha_capped"})])
def test_alpha_layers(count, want):
    """In front of the eye, on photon paths, on gather segments: all of them meet the veils."""
    for lowest in (0.5, 3.0):  # of the lamp, of the eye
        assert capped(veils(count, lowest), photons=64, pilot_paths=1024)[0] == want


# --- what has no limit ------------------------------------------------------------------------------------------------------------------


def lamps(count, place, direction, **more):
    """One lamp as `count` of them, each with its share of the light."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.5))
    for i in range(count):
        scene.area(place, direction, 100 / count, name=f"Lamp {i}", **more)
    return scene


def test_no_lamp_of_many_is_left_out():
    """100 at one place: as bright as one to the eye; and on a floor so near that lobe sampling finds them more often than next-event estimation."""
    one, many = (render(lamps(count, (0, 0, 0.5), (0, 0, 1), visible_to_camera=True), passes=1, photons=64) for count in (1, 100))
    np.testing.assert_allclose(many["Emission"], one["Emission"], rtol=1e-4)
    assert one["Emission"].max() > 0
    settings = {"passes": 64, "photons": 64, "pilot_paths": 64, "use_indirect": False, "use_caustics": False}
    one, many = (seeds(lamps(count, (0, 0, 0.1), (0, 0, -1), size_x=3.0), 6, **settings) for count in (1, 100))
    assert_same_mean(many.stack("Direct").mean((1, 2, 3)), one.stack("Direct").mean((1, 2, 3)), finest=0.02)


# --- branches ---------------------------------------------------------------------------------------------------------------------------

BRANCHES = 16  # of one path tree


def add_row(scene, count, amount=0.5, intensity=0.8):
    """Panes, one above the other under the lamp, in one pyramid of its light: each lets it pass in place, some of it dimmed."""
    for i in range(count):
        z = 0.5 + 0.1 * i
        half = 0.4 * (2 - z)
        scene.edit("LF*", quad((0, 0, z), (half, 0, 0), (0, half, 0)), [exit_at((0, 0, z), (half, 0, 0), (0, half, 0), intensity=intensity)],
                   name=f"Pane {i}", amount=amount)  # fmt: skip
    scene.description["max_gates"] = count
    return scene


def test_a_row_of_partial_edits_takes_bounded_time():
    """Twelve in a row, two copies at each: not 2¹² of them."""
    done = render(add_row(lit(), 12), passes=2, photons=1024, pilot_paths=64, use_indirect=False)
    edits = done.statistics["edits"]
    into_the_row = edits[-1]["matched"]  # the uppermost pane is the first
    assert into_the_row > 20
    assert 12 * into_the_row < sum(edit["moved"] for edit in edits) <= 12 * BRANCHES * into_the_row
    assert done.statistics["dropped"]["split_capped"] > 0


def test_a_row_of_partial_edits_keeps_its_light():
    """Each pane leaves 0.5 + 0.5 · 0.8 of it; as much as one pane that takes all and dims it so."""
    settings = {"passes": 4, "photons": 8192, "pilot_paths": 4096, "use_indirect": False}
    row = seeds(add_row(lit(), 12), 12, **settings)
    one = seeds(add_row(lit(), 1, amount=1, intensity=0.9**12), 12, **settings, seed=100)
    assert_same_mean(row.stack("Edited").sum((1, 2, 3)), one.stack("Edited").sum((1, 2, 3)), finest=0.1)


def glowing(count):
    scene = Scene(size=16)
    scene.plane("Panel", [(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)], emission((1, 1, 1), 1.0))
    for i in range(count):
        at = ((0, 0, 0.5 + 0.1 * i), (2, 0, 0), (0, 2, 0))
        scene.edit("LF*", quad(*at), [exit_at(*at, intensity=0.8)], name=f"Pane {i}", amount=0.5)
    scene.description["max_gates"] = count
    return scene


def test_a_row_of_partial_edits_before_the_eye():
    """Three ways at each pane: taken by its exit, by what it leaves, not at all."""
    settings = {"photons": 64, "pilot_paths": 64, "use_indirect": False}
    counters = render(glowing(10), passes=1, **settings).statistics
    assert 2 * BRANCHES < counters["rays"] / counters["view_paths"] <= 11 * BRANCHES
    assert_mean(seeds(glowing(4), 8, passes=16, **settings).stack().mean((1, 2, 3)), 0.9**4, finest=0.1)


# --- memory -----------------------------------------------------------------------------------------------------------------------------


def maze():
    """Six panes that light passes in some order or misses: each combination of used edits is a state."""
    scene = lit(8)
    for i in range(6):
        at = (0.2 * (i % 3 - 1), 0.2 * (i % 4 - 1.5), 0.1 + 0.3 * i)
        scene.edit("L.*", quad(at, (0.5, 0, 0), (0, 0.5, 0)), [exit_at(at, (0.5, 0, 0), (0, 0.5, 0))], name=f"Pane {i}")
    return scene


def test_memory_for_states_is_a_limit_that_is_told():
    found, ample = capped(maze())
    assert "states_capped" not in found and ample.warnings == []
    found, tight = capped(maze(), state_memory=1 << 14)
    assert "states_capped" in found
    assert [item for item, message in tight.warnings if "combinations of edits" in message] == ["edits"]  # once, after two passes
    assert tight.statistics["ledger"]["capped"] > ample.statistics["ledger"]["capped"]  # the light that ended there; the ledger closes all the same
    assert 0 < tight["Combined"].mean() < ample["Combined"].mean()


def test_memory_is_shared_by_the_threads():
    """A total: with more threads each has less of it."""
    lost = [capped(maze(), state_memory=1 << 15, threads=threads)[1].statistics["dropped"]["states_capped"] for threads in (1, 4)]
    assert lost[0] < lost[1]


def test_without_edits_memory_is_no_matter():
    plain, tight = render(lit(), **PASSES), render(lit(), **PASSES, state_memory=0)
    assert plain.hash == tight.hash and tight.statistics["dropped"]["states_capped"] == 0


def test_layers_lose_what_the_picture_keeps():
    """States are no matter to a picture without edits: only its layers miss what finds no memory."""
    scene = lit()
    scene.layer("Floor", "LD'Floor'E")
    plain, tight = render(scene, **PASSES), render(scene, **PASSES, state_memory=0)
    assert (plain["Combined"] == tight["Combined"]).all() and plain["Floor"].mean() > 0 == tight["Floor"].max()
    assert tight.statistics["dropped"]["states_capped"] > 0 and len(tight.warnings) == 1
