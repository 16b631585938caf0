# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers: images of the light whose whole path, L to E, matches an expression (paper Fig. 2). They sum to the picture, each is what the
renderer's own parts or another scene say it is, and they change nothing else."""

import numpy as np
import pytest
import sluice_core
from scenes import PARTS, Scene, both, diffuse, emission, exit_at, glass, looking, mirror, quad, render, seeds, shader, start
from statistics_of_renders import assert_same_mean, interval

SETTINGS = {"passes": 5, "photons": 5000, "threads": 2}  # no whole block, no whole chunk

# [^D] is S or F: D matches G too. So these are the five parts of the picture as words: what the last event before v was.
BY_PART = {"Direct": "L D [^D]* E", "Caustics": "L.*[^DF] D [^D]* E", "Edited": "L.* F D [^D]* E", "Indirect": "L.* D D [^D]* E", "Emission": "L [^D]* E"}
PARTITIONS = {
    "all": ["L.*E"],
    "by edit": ["L!F*E", "L.*F.*E"],
    "by edits": ["L!F*E", "L(!F'Caustic')*F'Reflection'(!F'Caustic')*E", "L.*F'Caustic'.*E"],
    "by lamp": ["L'Lamp'.*E", "L'Panel'.*E"],
    "by length": ["LE", "L.E", "L..E", "L.{3,}E"],
    "by what the eye sees": ["LE", "L.*GE", "L.*[^SF]E", "L.*[^DF]E", "L.*FE"],
    "by object": ["L(!X'Egg')*E", "L.*X'Egg'.*E"],
    "by part": list(BY_PART.values()),
}  # fmt: skip


def room(edits=("light", "view"), hue=0.0):
    """A corner with glass, a mirror, a floor with D and G lobes, a lamp and an emissive panel; an edit of light, one of the view."""
    scene = Scene(size=40)
    scene.perspective(looking((0, -3.2, 1.6), (0, 3, -0.9), up=(0, 0, 1)), 0.9)
    scene.floor(both(diffuse((0.5, 0.3, 0.2)), [shader("BsdfGlossy", (0.4, 0.4, 0.4), Roughness=0.5)]))
    scene.plane("Wall", [(-2, 1, 0), (2, 1, 0), (2, 1, 2), (-2, 1, 2)], diffuse(0.7))
    scene.plane("Mirror", [(-1.5, 0.99, 0.5), (-0.5, 0.99, 0.5), (-0.5, 0.99, 1.5), (-1.5, 0.99, 1.5)], mirror(0.9))
    scene.sphere("Egg", (0.2, 0.1, 0.5), 0.35, glass(), rings=24)
    scene.plane("Panel", [(0.9, 0, 1.2), (0.9, 0.8, 1.2), (1.3, 0.8, 1.2), (1.3, 0, 1.2)], emission((1, 0.9, 0.6), 4.0))
    scene.point((0.3, -0.5, 1.9), 30, radius=0.02, color=(1, 0.8, 0.6))
    if "light" in edits:
        to = exit_at((-0.8, 0, 0), (0.4, 0, 0), (0, 0.4, 0), hue_shift=hue)
        scene.edit("LS'Egg'+", quad((0.2, 0.3, 0), (0.4, 0, 0), (0, 0.4, 0)), [to], name="Caustic")
    if "view" in edits:
        to = exit_at((0, -1, 1), (0.3, 0, 0), (0, 0, 0.3), (0, 1, 0), hue_shift=hue)  # looks into the room
        scene.edit("S'Mirror'E", quad((-1, 0.99, 1), (0.3, 0, 0), (0, 0, 0.3), (0, -1, 0)), [to], name="Reflection")
    return scene


def layered(scene, partitions=PARTITIONS):
    for name, expressions in partitions.items():
        for i, expression in enumerate(expressions):
            scene.layer(f"{name} {i}", expression)
    return scene


ROOMS = {"plain": {"edits": ()}, "light": {"edits": ("light",)}, "view": {"edits": ("view",)}, "both": {}, "hues": {"hue": 1.0}}
_done = {}


def rendered(kind):
    """Each room once, with every layer."""
    if kind not in _done:
        usable = {name: list(words) for name, words in PARTITIONS.items() if name != "by edits" or kind in ("both", "hues")}
        _done[kind] = render(layered(room(**ROOMS[kind]), usable), **SETTINGS)
    return _done[kind]


def test_the_rooms_have_every_part():
    """Else the tests below would say little."""
    done = rendered("hues")
    for name in PARTS:
        assert done[name].max() > 0, name
    assert all(edit["matched"] > 0 for edit in done.statistics["edits"])
    assert not done.warnings
    dark = [layer["name"] for layer in done.statistics["layers"] if layer["share"] == 0]
    assert dark == ["by what the eye sees 4"]  # no gate is the last thing before the eye


@pytest.mark.parametrize("name", PARTITIONS)
@pytest.mark.parametrize("kind", ROOMS)
def test_disjoint_complete_layers_sum_to_the_picture(kind, name):
    done = rendered(kind)
    layers = [picture for key, picture in done.pictures.items() if key.startswith(name + " ") and key[len(name) + 1 :].isdigit()]
    if not layers:
        return  # this room has not got both edits
    assert len(layers) == len(PARTITIONS[name])
    np.testing.assert_allclose(sum(layers), done["Combined"], rtol=0, atol=1e-4 * done["Combined"].mean())


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("kind", ROOMS)
def test_the_parts_as_words(kind, part):
    """The estimators know how light arrived, the automata read its word: two ways to the same five images."""
    done = rendered(kind)
    found = done[f"by part {list(BY_PART).index(part)}"]
    np.testing.assert_allclose(found, done[part], rtol=0, atol=1e-4 * done["Combined"].mean())


@pytest.mark.parametrize("kind", ROOMS)
def test_layers_change_no_bit_of_the_picture(kind):
    plain = render(room(**ROOMS[kind]), **SETTINGS)
    for name in ("Combined", *PARTS):
        np.testing.assert_array_equal(rendered(kind)[name], plain[name], err_msg=name)


def test_layers_change_no_bit_where_a_pilot_places_samples():
    plain, layered_one = (render(scene, **{**SETTINGS, "use_adaptive_sampling": True}) for scene in (room(hue=1.0), layered(room(hue=1.0))))
    np.testing.assert_array_equal(layered_one["Combined"], plain["Combined"])
    assert layered_one.statistics["guide_hash"] == plain.statistics["guide_hash"]


def test_threads_change_no_bit():
    hashes = {render(layered(room(hue=1.0)), **{**SETTINGS, "threads": threads}).hash for threads in (1, 2, 3)}
    assert hashes == {rendered("hues").hash}


def test_a_border_is_a_crop():
    scene = layered(room(hue=1.0))
    scene.description["frame"].update(x0=5, y0=9, x1=38, y1=31)
    part, whole = render(scene, **SETTINGS), rendered("hues")
    for name in whole.pictures:
        np.testing.assert_array_equal(part[name], whole[name][9:31, 5:38], err_msg=name)


def test_no_layers_cost_nothing():
    """No more gathers, photons or queries than before there were any, and the same film."""
    done, counts = rendered("both"), ("rays", "view_paths", "photons_stored", "edit_queries")
    plain = render(room(), **SETTINGS)
    assert plain.statistics["layers"] == []
    assert [plain.statistics[c] for c in counts] == [done.statistics[c] for c in counts]
    assert plain.statistics["gathers"] <= done.statistics["gathers"]


# --- against other scenes -------------------------------------------------------------------------------------------------------------


def test_a_lamps_layer_is_the_picture_without_the_other_lamps():
    scene = room()
    scene.layer("lamp", "L'Lamp'.*E")
    got = seeds(scene, 10, passes=4, photons=8000)
    alone = room()
    alone.description["materials"][4] = {**alone.description["materials"][4], "nodes": emission(0.0)}
    assert alone.description["instances"][4]["names"] == ["Panel"]
    want = seeds(alone, 10, passes=4, photons=8000, seed=100)
    assert_same_mean(got.stack("lamp").mean((1, 2, 3)), want.stack().mean((1, 2, 3)), finest=0.03)


def test_an_edits_layer_is_what_its_exit_adds():
    """The picture less that of the same entry without exit, which absorbs what it takes. Light goes on behind the exit: two walls."""
    def corner(*exits):
        scene = Scene(size=16)
        scene.floor(diffuse(0.6), half=1.0)
        scene.plane("Wall", [(-1, 1, 0), (1, 1, 0), (1, 1, 2), (-1, 1, 2)], diffuse(0.8))
        scene.point((0, 0, 2), 30)
        scene.edit("L", quad((-0.4, 0, 0), (0.5, 0, 0), (0, 0.8, 0)), exits, name="Sun patch")
        scene.layer("moved", "L.*F'Sun patch'.*E")
        return scene

    got = seeds(corner(exit_at((0.4, 0.1, 0.2), (0.5, 0, 0), (0, 0.8, 0))), 8, passes=16, photons=20000)
    rest = seeds(corner(), 8, passes=16, photons=20000)  # the same view paths: their noise cancels
    moved, difference = got.stack("moved"), got.stack() - rest.stack()
    assert moved.mean() > 1.01 * got.mean("Edited").mean() > 0.2 * got.mean().mean()  # and what it lights in turn
    assert rest.stack("moved").max() == 0
    for side in (slice(0, 8), slice(8, 16)):
        off, half_width = interval((difference - moved)[:, :, side].mean((1, 2, 3)) / moved[:, :, side].mean())
        assert abs(off) <= half_width <= 0.05


@pytest.mark.parametrize("kind", ["light", "view", "both", "hues"])
def test_an_edits_share_is_that_of_its_layer(kind):
    """What the estimators book to edits by their states, and what the automata read from whole words; without layers too."""
    scene = room(**ROOMS[kind])
    for edit in scene.description["edits"]:
        scene.layer(edit["entry"]["name"], f"L.*F'{edit['entry']['name']}'.*E")
    plain, done = render(room(**ROOMS[kind]), **SETTINGS), render(scene, **SETTINGS)
    for layer in done.statistics["layers"]:
        name, share = layer["name"], layer["share"]
        assert share > 1e-3
        assert done.edit(name)["share"] == pytest.approx(share, rel=1e-4) and plain.edit(name)["share"] == pytest.approx(share, rel=1e-4)
        assert 0 < plain.edit(name)["seconds"] < sum(plain.statistics["seconds"].values())


def test_an_edit_that_repeats_is_booked_once():
    """Light that it takes twice on its way is in its share once."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.6), half=1.0)
    scene.plane("Wall", [(-1, 1, 0), (1, 1, 0), (1, 1, 2), (-1, 1, 2)], diffuse(0.8))
    scene.point((0, 0, 2), 30)
    patch = {"x": (0.7, 0, 0), "y": (0, 0.7, 0)}
    scene.edit("L.*", quad((0, 0.3, 0), **patch), [exit_at((0, 0.3, 0), **patch)], name="Often", repeat=True)
    scene.layer("Often", "L.*F'Often'.*E")
    scene.layer("twice", "L.*F'Often'.*F'Often'.*E")
    done = render(scene, **SETTINGS)
    once, twice = (layer["share"] for layer in done.statistics["layers"])
    assert 0.1 * once < twice < once < 1 and done.edit("Often")["share"] == pytest.approx(once, rel=1e-4)


def test_an_edit_without_exit_shows_nothing():
    """What it took is told as energy: here all that the lamp sends at it."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.6), half=1.0)
    scene.sun((0, 0, -1), 1.0)
    scene.edit("L", quad((0, 0, 0)), [], name="Gone")
    done = render(scene, **SETTINGS)
    gone = done.edit("Gone")
    assert gone["share"] == gone["seconds"] == gone["energy_out"] == 0 and gone["energy_in"] > 0
    assert "% of the lamps' light" in done.statistics["report"] and "of the picture's light" not in done.statistics["report"]


# --- bad input ------------------------------------------------------------------------------------------------------------------------


def failure(*layers):
    scene = room()
    for name, expression in layers:
        scene.layer(name, expression)
    session = start(scene, **SETTINGS)
    assert session.wait(60) and session.progress()["state"] == "failed"
    return session.progress()["error"]


@pytest.mark.parametrize(("expression", "column", "says"), [
    ("LS+", 2, "write E last"), ("D E", 1, "write L first"), ("L(.*E", 2, "this ( is never closed"), ("", 1, "empty"), ("LE|D", 4, "write L first"),
    ("L(.*D.{14}|S.{14}D)E", 1, "4,096 states")])  # fmt: skip
def test_a_bad_expression_names_its_layer(expression, column, says):
    error = failure(("Good", "L.*E"), ("Bad", expression))
    assert error["item"] == "layer 'Bad'" and error["column"] == column and says in error["message"]


@pytest.mark.parametrize(("layers", "item", "says"), [
    ([("A", "LE"), ("A", "L.E")], "layer 'A'", "two layers"), ([("Direct", "LE")], "layer 'Direct'", "choose another"), ([("", "LE")], "layer", "no name"),
    ([(f"A{i}", "LE") for i in range(64)], "layer 'A63'", "at most 63")])  # fmt: skip
def test_names_and_number_of_layers(layers, item, says):
    error = failure(*layers)
    assert error["item"] == item and says in error["message"]


def test_63_layers():
    scene = room()
    for i in range(63):
        scene.layer(f"A{i}", "L.{%d}E" % (i // 2))
    done = render(scene, **SETTINGS)
    np.testing.assert_array_equal(done["A2"], done["A3"])
    np.testing.assert_allclose(sum(done[f"A{i}"] for i in range(0, 63, 2)), done["Combined"], atol=1e-4 * done["Combined"].mean())
    assert done["A62"].max() == 0


def test_an_unknown_name_is_a_warning():
    scene = room()
    scene.layer("Moved", "L.*F'Caustics'.*E")
    done = render(scene, **SETTINGS)
    assert done.warnings == [("layer 'Moved'", "no edit or collection is named 'Caustics'; the nearest name is 'Caustic'")]
    assert done["Moved"].max() == 0 and done.statistics["layers"] == [{"name": "Moved", "expression": "L.*F'Caustics'.*E", "share": 0}]
    assert "layer Moved: L.*F'Caustics'.*E, 0 % of the picture's light" in done.statistics["report"]


def test_edits_that_are_off_keep_their_names():
    scene = room()
    scene.layer("Moved", "L.*F'Caustic'.*E")
    done = render(scene, **SETTINGS, use_edits=False)
    assert not done.warnings and done["Moved"].max() == 0


def test_check_layer_expression():
    assert sluice_core.check_layer_expression("L.*E", []) == {"warnings": []}
    assert "'Egg'" in sluice_core.check_layer_expression("LS'Egs'E", ["Egg"])["warnings"][0]
    with pytest.raises(sluice_core.ExpressionError, match="write E last") as caught:
        sluice_core.check_layer_expression("LS", [])
    assert caught.value.column == 2
