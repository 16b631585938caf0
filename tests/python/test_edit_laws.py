# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits on a lone floor: the picture is that without edits, less the entries' light, plus what the exits lay down; exactly, block by
block, by an oracle that shares nothing with the core (floor_tracer.py)."""

import math

import numpy as np
import pytest
from edited_floor import AIM, ALBEDO, ENTRY, EXITS, FULL, LAMPS, PASSES, PHOTONS, SEEDS, SIZE, check, check_direct, floor_scene, shadow, turned, upwards
from floor_tracer import expected_edited
from scenes import LUMINANCE, Scene, defaults, diffuse, exit_at, most_range, quad, render, seeds  # noqa: F401: each test in both kinds
from statistics_of_renders import assert_mean, assert_same_mean, blocks

# --- one exit on the floor, and in the air ------------------------------------------------------------------------------------------------

FEW = [("moved", "sun"), ("moved", "square"), ("rotated", "point"), ("mirrored", "point"), ("mirrored", "square"), ("skewed", "point"), ("larger", "sun"),
       ("larger, flux kept", "point"), ("smaller", "square"), ("smaller, flux kept", "sun"), ("intensity", "point"), ("upside down", "point"),
       ("in the air, tilted", "sun"), ("in the air, tilted", "square"), ("in the air, mirrored", "sun"), ("in the air, mirrored", "point")]  # fmt: skip


@pytest.mark.parametrize(("way", "lamp"), [(way, lamp) for way in EXITS for lamp in LAMPS] if FULL else FEW)
def test_light_lands_where_the_exit_is(way, lamp):
    scene, light = floor_scene(lamp)
    scene.edit("L", ENTRY, [EXITS[way]])
    got, _ = check(scene, light)
    check_direct(scene, got, upwards(lamp))


def test_an_exit_grows_from_nothing():
    """Light at the exit is its share of the entry's area, from none on; what the entry takes is the sun's light on it, in every frame."""
    scene, _ = floor_scene("sun")
    scene.edit("L", ENTRY, [exit_at((0.45, -0.3, 0), (0.3, 0, 0), (0, 0.3, 0))])
    grown, taken = scene.description["edits"][0]["exits"][0]["quad"], 3.0 / math.sqrt(1.2) * 0.6**2
    matrix, frames, sent = np.array(grown["matrix"]), [], []
    for scale in (0, 1e-12, 1e-4, 0.03, 0.3, 1):
        grown["matrix"] = matrix @ np.diag([scale, scale, scale, 1])
        r = render(scene, passes=PASSES, photons=PHOTONS)
        edit, frames = r.edit(), [*frames, r]
        # By counting photons. An entry that sends nothing on is no target of theirs: fewer come by
        assert edit["energy_in"] / PASSES == pytest.approx(taken, rel=4 / math.sqrt(edit["matched"]))
        if scale > 1e-6:
            sent.append(edit["energy_in"])
            assert sent[-1] == pytest.approx(sent[0], rel=4 / math.sqrt(edit["matched"]))
        assert edit["energy_out"] == pytest.approx(edit["energy_in"] * (scale**2 if scale > 1e-6 else 0), rel=1e-5)
        lit = (r["Edited"] @ LUMINANCE).sum() * (2 * scene.view / SIZE) ** 2 / (ALBEDO / math.pi)
        assert lit == pytest.approx(edit["energy_out"] / PASSES, rel=0.05 if scale >= 0.03 else 0.5)
        np.testing.assert_allclose(r["Direct"], frames[0]["Direct"], rtol=1e-5)
        assert [item for item, _ in r.warnings] == ([grown["name"]] if scale < 1e-6 else [])


@pytest.mark.parametrize("lamp", ["sun", "point"])
def test_direct_light_through_a_gate_in_the_air(lamp):
    """An entry in mid-air: its shadow falls on the floor, and its light comes out of an exit elsewhere."""
    scene, light = floor_scene(lamp)
    scene.edit("L", quad((-0.5, 0, 0.3), (0.3, 0, 0), (0, 0.24, 0.18), (0, -0.6, 0.8)), [exit_at((0.3, -0.2, 0.3), (0, 0.3, 0), (-0.3, 0, 0))])
    got, _ = check(scene, light, aim=(-1.0, 1.1, -1.3, 1.0))
    check_direct(scene, got, upwards(lamp))


@pytest.mark.parametrize(("way", "level", "total"), [("larger", 1, 0.9 / 0.36), ("larger, flux kept", 0.36 / 0.9, 1), ("smaller", 1, 0.2 / 0.36), ("smaller, flux kept", 0.36 / 0.2, 1)])
def test_brightness_kept_and_flux_kept(way, level, total):
    """The two meanings of area_ratio, in numbers: E stays E on an exit of any size; or flux stays flux."""
    irradiance = 3.0 / math.sqrt(1.2)
    scene, _ = floor_scene("sun")
    scene.edit("L", ENTRY, [EXITS[way]])
    got = seeds(scene, SEEDS, passes=PASSES, photons=PHOTONS, caustic_radius_factor=1.5).stack("Edited")
    x, y = EXITS[way]["quad"]["matrix"][:2, 3]
    column, row = int((x + 1) * SIZE / 2), int((y + 1) * SIZE / 2)
    middle = got[:, row - 1 : row + 2, column - 1 : column + 2].mean((1, 2, 3))
    assert_mean(middle, level * irradiance * ALBEDO / math.pi, finest=0.08)
    assert_mean(got.mean((1, 2, 3)) * 4, total * 0.36 * irradiance * ALBEDO / math.pi, finest=0.03)


# --- several exits, none, partial ones ----------------------------------------------------------------------------------------------------

SEVERAL = [EXITS["moved"], {**turned(0.5, 0.25, (0.4, 0.5, 0)), "intensity": 0.5}, exit_at((-0.4, -0.6, 0), (-0.3, 0, 0), (0, 0.25, 0))]


@pytest.mark.parametrize("count", [2, 3])
def test_several_exits_are_the_sum_of_single_ones(count):
    scene, light = floor_scene("point")
    scene.edit("L", ENTRY, SEVERAL[:count])
    _, together = check(scene, light)
    alone = 0
    for single in SEVERAL[:count]:
        scene, light = floor_scene("point")
        scene.edit("L", ENTRY, [single])
        alone = alone + ALBEDO / math.pi * expected_edited(scene, light, AIM, 0.05)
    assert together.sum() == pytest.approx(alone.sum(), rel=2e-3)


@pytest.mark.parametrize("count", [6, 18])
def test_many_exits_are_split_or_chosen_with_the_same_mean(count):
    """18 exits are more than the split budget: one is chosen, with weight."""
    places = [(0.1 + 0.16 * column, -0.4 + 0.2 * row, 0) for row in range(3) for column in range(6)][:count]
    scene, light = floor_scene("point")
    scene.edit("L", ENTRY, [exit_at(p, (0.07, 0, 0), (0, 0.07, 0), intensity=1 + i % 3) for i, p in enumerate(places)])
    got, _ = check(scene, light)
    assert all((r.statistics["dropped"]["split_capped"] > 0) == (count > 16) for r in got.renders)


@pytest.mark.parametrize("lamp", LAMPS)
def test_no_exit_absorbs(lamp):
    scene, _ = floor_scene(lamp)
    scene.edit("L", ENTRY)
    got = seeds(scene, 1, passes=PASSES, photons=PHOTONS)
    check_direct(scene, got, upwards(lamp))
    assert not got.stack("Edited").any()
    assert [m for item, m in got.renders[0].warnings if item == "Edit" and "no exit" in m]


@pytest.mark.parametrize("settings", [{"amount": 0.5}, {"feather": 0.5}, {"amount": 0.7, "feather": 1.0}, {"amount": 0.0}])
def test_amount_and_feather(settings):
    """The exits get a(u, v), what is left goes straight on; all of it carries F, so all of it is edited light."""
    scene, light = floor_scene("point")
    scene.edit("L", ENTRY, [EXITS["rotated"]], **settings)
    got, _ = check(scene, light)
    check_direct(scene, got, upwards("point"))


@pytest.mark.parametrize("feather", [0.25, 1.0])
def test_feather_takes_its_share_of_the_flux(feather):
    """Its border is antisymmetric about its middle: under even light the exits get (1 − feather / 2)² of the flux, and nothing is lost."""
    scene, _ = floor_scene("sun")
    scene.edit("L", ENTRY, [exit_at((0.5, 0.1, 0), (0.3, 0, 0), (0, 0.3, 0))], feather=feather)
    got = seeds(scene, SEEDS, passes=PASSES, photons=PHOTONS, caustic_radius_factor=1.0).stack("Edited")
    flux = 0.36 * 3.0 / math.sqrt(1.2) * ALBEDO / math.pi
    share = (1 - feather / 2) ** 2
    assert_mean(got[:, :, SIZE // 2 :].mean((1, 2, 3)) * 2, flux * share, finest=0.04)
    assert_mean(got[:, :, : SIZE // 2].mean((1, 2, 3)) * 2, flux * (1 - share), finest=0.04)


# --- chains -------------------------------------------------------------------------------------------------------------------------------


def chain(**second):
    """An edit laid on the exit of another: 'LF' moves on what 'L' moved."""
    scene, light = floor_scene("point", color=(1.0, 0.45, 0.2))
    scene.edit("L", ENTRY, [{**EXITS["rotated"], "hue_shift": second.pop("first_hue", 0.0)}], name="First")
    entry = EXITS["rotated"]["quad"]
    scene.edit("LF'First'", quad(entry["matrix"][:3, 3], *entry["matrix"][:3, :2].T), [exit_at((-0.3, -0.6, 0), (0.3, 0, 0), (0, 0.3, 0), **second)], name="Second")
    return scene, light


def in_turn(edit, word):
    return word == (0, 1)[edit]


def test_a_chain_moves_twice():
    scene, light = chain(intensity=0.6)
    got, _ = check(scene, light, takes=in_turn, color=(1.0, 0.45, 0.2))
    first, second = got.renders[0].edit("First"), got.renders[0].edit("Second")
    assert first["matched"] == second["matched"] > 0
    assert second["energy_out"] == pytest.approx(0.6 * second["energy_in"], rel=1e-4)


def test_a_chain_of_eight():
    """As many gates as a path may have: each entry lies on the exit before it."""
    scene, light = floor_scene("point")
    entry = ENTRY
    for k in range(8):
        out = exit_at((0.25 * (k % 4) - 0.5, 0.3 * (k // 4) - 0.4, 0), (0.25, 0, 0), (0, 0.25, 0), intensity=0.9)
        scene.edit("L" + "F" * k, entry, [out], name=f"Edit {k}")
        entry = quad(out["quad"]["matrix"][:3, 3], *out["quad"]["matrix"][:3, :2].T)
    got, _ = check(scene, light, takes=lambda edit, word: word == int("01234567"[: edit + 1]))
    assert got.renders[0].edit("Edit 7")["matched"] == got.renders[0].edit("Edit 0")["matched"] > 0


def test_a_hue_turned_back_is_the_hue():
    scene, light = chain(first_hue=1.3, hue_shift=-1.3)
    got, _ = check(scene, light, takes=in_turn, color=(1.0, 0.45, 0.2))
    total = got.mean("Edited").sum((0, 1))
    np.testing.assert_allclose(total / total[0], [1.0, 0.45, 0.2], rtol=2e-4)


@pytest.mark.parametrize(("repeat", "gates"), [(False, 4), (True, 1), (True, 3)])
def test_once_and_repeat(repeat, gates):
    """An exit above its own entry sends the light back into it. Acting once, a half entry lets all of it land; with repeat, each turn
    lands half of the rest, until max_gates absorbs it: 1 − 2^-gates."""
    scene, _ = floor_scene("sun")
    scene.description["lights"].clear()
    scene.sun((0, 0, -1), 3.0, name="Lamp")
    scene.edit("LF*" if repeat else "L", ENTRY, [exit_at((-0.5, 0.1, 0.5), (0.3, 0, 0), (0, 0.3, 0))], amount=0.5, repeat=repeat)
    scene.description["max_gates"] = gates
    got = seeds(scene, SEEDS, passes=PASSES, photons=2 * PHOTONS, caustic_radius_factor=1.5)
    share = 1 - 0.5**gates if repeat else 1
    assert_mean(got.stack("Edited").mean((1, 2, 3)) * 4, share * 0.36 * 3.0 * ALBEDO / math.pi)
    assert all((r.edit()["capped"] > 0) == repeat for r in got.renders)
    removed = got.ledger("capped")
    assert_mean(removed, 0.5**gates * 0.36 * 3.0, finest=0.05) if repeat else np.testing.assert_array_equal(removed, 0)


# --- nothing changes ------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lamp", LAMPS)
def test_identity_edit_is_no_edit(lamp):
    scene, light = floor_scene(lamp)
    scene.edit("L", ENTRY, [exit_at((-0.5, 0.1, 0), (0.3, 0, 0), (0, 0.3, 0))])
    got, _ = check(scene, light)
    plain = seeds(scene, SEEDS, passes=PASSES, use_edits=False, seed=50)
    assert_same_mean(got.stack().mean((1, 2, 3)), plain.stack().mean((1, 2, 3)), finest=0.03)
    inside, _ = shadow(scene, upwards(lamp))
    for _ in range(math.ceil(most_range())):  # more than a radius, here a pixel's width times the range, from the border
        inside = inside & np.roll(inside, 1, 0) & np.roll(inside, -1, 0) & np.roll(inside, 1, 1) & np.roll(inside, -1, 1)
    assert_same_mean(got.stack()[:, inside].mean((1, 2)), plain.stack()[:, inside].mean((1, 2)), finest=0.05)


def placed(scale=1.0, shift=(0, 0, 0)):
    """A lit, edited floor, scaled and moved as a whole."""
    move = np.diag([scale, scale, scale, 1.0])
    move[:3, 3] = shift
    scene, _ = floor_scene("point")
    scene.edit("L", ENTRY, [EXITS["rotated"], EXITS["in the air, tilted"]])
    d = scene.description
    for item in (*d["instances"], *d["lights"], d["camera"], *(e["entry"] for e in d["edits"]), *(x["quad"] for e in d["edits"] for x in e["exits"])):
        item["matrix"] = move @ item["matrix"]
    d["camera"]["ortho_scale"] *= scale
    d["camera"]["clip_end"] *= scale
    d["lights"][0]["power"] *= scale**2
    return scene


@pytest.mark.parametrize("scale", [2.0**-10, 2.0**10])
def test_a_scale_that_rounds_nothing_changes_no_bit(scale):
    here, there = (render(s, passes=PASSES, photons=PHOTONS) for s in (placed(), placed(scale)))
    for part in ("Direct", "Edited"):
        np.testing.assert_array_equal(there[part], here[part])


@pytest.mark.parametrize(("scale", "shift"), [(1e-3, (0, 0, 0)), (1e3, (0, 0, 0)), (1.0, (1e4, -1e4, 1e4)), (1.0, (0.3, 8191.7, 0.1))])
def test_place_and_size_change_nothing(scale, shift):
    """Direct light is the same pixel by pixel, but for those that the border of the entry crosses (where quads float higher above a far
    floor); photons may be aimed otherwise, so moved light is the same within noise."""
    here, there = (seeds(s, SEEDS, passes=PASSES, photons=PHOTONS // 2, seed=100 * i) for i, s in enumerate((placed(), placed(scale, shift))))
    even = {"passes": PASSES, "photons": PHOTONS // 2, "use_adaptive_sampling": False}  # the same samples
    first, same = (render(s, **even)["Direct"] for s in (placed(), placed(scale, shift)))
    off = np.abs(same - first).max(-1) > 1e-3 * first.max()
    assert off.mean() <= (0.01 if any(shift) else 0)
    assert_same_mean(here.stack("Edited").mean((1, 2, 3)), there.stack("Edited").mean((1, 2, 3)), finest=0.03)
    if most_range() > 1:
        return  # how wide photons are spread near borders depends on how cells of space lie there
    a, b = (blocks(s.stack("Edited") @ LUMINANCE, 4) for s in (here, there))
    for row, column in np.argwhere(a.mean(0) > 0.5 * a.mean(0).max()):
        assert_same_mean(a[:, row, column], b[:, row, column], finest=0.15)


def test_names_are_only_names():
    hashes = []
    for lamp, edit, expression in (("Lamp", "First", "LF'First'"), ("it's, a \\ lamp", "Umzug 'B'", "LF'Umzug \\'B\\''")):
        scene, _ = chain()
        d = scene.description
        d["lights"][0]["names"] = [lamp]
        d["edits"][0]["entry"]["name"] = edit
        d["edits"][0]["expression"] = "L'" + lamp.replace("\\", "\\\\").replace("'", "\\'").replace(",", "\\,") + "'"
        d["edits"][1]["expression"] = expression
        done = render(scene)
        assert not done.warnings and done.edit("Second")["matched"] > 0
        hashes.append(done.hash)
    assert hashes[0] == hashes[1]


def test_one_edit_with_two_expressions_is_two_edits():
    """L'A'|L'B' on one edit, or L'A' and L'B' on two with the same quads: disjoint, so the same light."""
    def build(split):
        scene, _ = floor_scene("point", name="A")
        scene.sun((0.4, 0.2, -1), 3.0, name="B")
        scene.sun((0.4, -0.2, -1), 3.0, name="C")  # stays where it is
        for i, expression in enumerate(("L'A'", "L'B'") if split else ("L'A'|L'B'",)):
            scene.edit(expression, ENTRY, [EXITS["rotated"]], name=f"Edit {i}")
        return seeds(scene, SEEDS, passes=8, photons=PHOTONS, caustic_radius_factor=1.0, seed=100 * split)

    one, two = build(False), build(True)
    for r in two.renders:
        assert all(e["matched"] > 0 for e in r.statistics["edits"])
    for part in ("Direct", "Edited"):
        assert_same_mean(one.stack(part).mean((1, 2, 3)), two.stack(part).mean((1, 2, 3)))
    a, b = (blocks(s.stack("Edited") @ LUMINANCE, 4) for s in (one, two))
    for row, column in np.argwhere(a.mean(0) > 0.5 * a.mean(0).max()):
        assert_same_mean(a[:, row, column], b[:, row, column], finest=0.15)
