# SPDX-License-Identifier: GPL-3.0-or-later
"""What light arrives at an entry (settings: explain_edits), told for artists whose expression finds none."""

import pytest
from addon_modules import load
from scenes import Scene, diffuse, emission, exit_at, glass, looking, mirror, quad, render, shader

import sluice_core

words = load("expression_words")

SETTINGS = {"passes": 1, "photons": 16384}
HALF = ((0.25, 0, 0), (0, 0.25, 0))
AWAY = [exit_at((1.2, 0, 0), *HALF)]


def slab_scene(expression, place=(-0.5, 0, 0), exits=AWAY):
    """Sun from above; a glass slab covers x < 0, a wall stands at x = 2; an edit on the floor."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.8), half=1.5)
    scene.box("It's a slab", (-1.4, -1.4, 0.2), (-0.05, 1.4, 0.3), glass(1.5))
    scene.camera(looking((0, 0, 0.19), (0, 0, -1)), 1.0)
    scene.sun((0, 0, -1), 2.0)
    scene.edit(expression, quad(place, *HALF), exits)
    return scene


def found(scene, **settings):
    return render(scene, explain_edits=True, **SETTINGS, **settings)


def test_what_arrives_instead():
    """Under the glass an expression for straight light takes nothing; what does arrive is named, and taken by the expression told."""
    edit = found(slab_scene("L")).edit()
    assert edit["matched"] == 0 and 0 < edit["crossed"] < edit["probed"]
    expression, share = edit["arrivals"][0]
    assert expression == "L'Sun'S'It\\'s a slab'+" and share > 0.9
    assert all(a[1] >= b[1] for a, b in zip(edit["arrivals"], edit["arrivals"][1:])) and sum(share for _, share in edit["arrivals"]) <= 1 + 1e-9
    told = words.tell(sluice_core.parse(expression))
    assert told == "light from Sun, then one or more reflections or refractions by It's a slab"
    assert found(slab_scene(expression)).edit()["matched"] > 20
    for other, _share in edit["arrivals"]:  # each is an expression
        sluice_core.check_expression(other, [])
    assert "no light that matches crossed the entry" in found(slab_scene("L")).statistics["report"]


def test_in_the_open_it_comes_straight():
    edit = found(slab_scene("LS+", (0.6, 0, 0))).edit()
    assert edit["arrivals"][0][0] == "L'Sun'" and edit["arrivals"][0][1] > 0.8


def test_an_edit_that_acts_is_a_witness_too():
    """Light that the entry takes has crossed it; light that another edit sent there is F, and none crosses an entry in the void."""
    scene = slab_scene("LS+", exits=[exit_at((0.6, 0, 0.1), *HALF)])
    scene.edit("LDDDD", quad((0.6, 0, 0.05), *HALF), AWAY, name="Second")
    scene.edit("L", quad((0, 0, -3), *HALF), AWAY, name="Void")
    done = found(scene)
    assert done.edit()["matched"] > 0 and done.edit()["arrivals"][0][0] == "L'Sun'S'It\\'s a slab'+"
    kinds = [expression for expression, _share in done.edit("Second")["arrivals"]]
    assert set(kinds[:2]) == {"L'Sun'", "L'Sun'S'It\\'s a slab'+F'Edit'"}  # nearly as much of either
    assert done.edit("Void")["crossed"] == 0 and done.edit("Void")["arrivals"] == []


def test_what_another_edit_lays_down_arrives_in_its_plane_too():
    """A second entry on the first one's exit, in one plane; a third below the second hears who takes it."""
    scene = slab_scene("LS+", exits=[exit_at((0.6, 0, 0), *HALF)])
    scene.edit("LDDDD", quad((0.6, 0, 0), *HALF), AWAY, name="Second")
    scene.edit("LDDDD", quad((0.6, 0, 0), *HALF), AWAY, name="Third")
    second = found(scene).edit("Second")
    moved = "L'Sun'S'It\\'s a slab'+F'Edit'"
    assert moved in dict(second["arrivals"]) and second["taken"] == 0
    scene.description["edits"][1]["expression"] = moved
    done = found(scene)
    assert done.edit("Second")["matched"] > 20 and moved in dict(done.edit("Second")["arrivals"])
    third = done.edit("Third")
    assert moved not in dict(third["arrivals"]) and third["taken"] > 20 and third["taker"] == "Second"


@pytest.mark.parametrize("height", [0.0, 0.1])
def test_light_that_another_edit_takes_before(height):
    """In front of an entry, or in its plane with a lower order: what is left crosses it, the thief is named."""
    scene = slab_scene("L", (0.6, 0, height), exits=[exit_at((0.6, 0.9, 0), *HALF)])
    scene.edit("L", quad((0.6, 0, 0), *HALF), AWAY, name="Second")
    done = found(scene)
    assert done.edit("Second")["matched"] == 0 < done.edit("Second")["taken"] and done.edit("Second")["taker"] == "Edit"
    assert done.edit("Second")["crossed"] < done.edit("Second")["taken"] and done.edit()["taken"] == 0 == len(done.edit()["taker"])
    assert "were taken before, most by Edit" in done.statistics["report"]


@pytest.mark.parametrize("expression", ["L", "LS+"])
def test_asking_changes_no_bit_of_the_picture(expression):
    scene = slab_scene(expression)
    assert found(scene).hash == render(scene, **SETTINGS).hash
    assert "arrivals" not in render(scene, **SETTINGS).edit()


def test_nothing_is_asked_of_what_the_eye_sees():
    edit = found(slab_scene("S*E")).edit()
    assert edit["probed"] == edit["crossed"] == 0 and edit["arrivals"] == []


def test_scattered_light_is_told_by_what_it_met_last():
    """A lamp above the slab, a bright wall beside: what the floor gets from the wall, straight and through the glass, from all bounces."""
    scene = slab_scene("LG", (0.6, 0, 0))
    scene.plane("Wall", [(1.5, -1.5, 0), (1.5, 1.5, 0), (1.5, 1.5, 1.5), (1.5, -1.5, 1.5)], diffuse(0.9))
    scene.point((1.0, 0, 0.8), 20.0)
    kinds = dict(found(scene).edit()["arrivals"])
    assert 0.1 < kinds["L.*D'Wall'"] < kinds["L'Lamp'"]
    assert found(retold(scene, "L.*D'Wall'")).edit()["matched"] > 20
    assert all(one.startswith(("L'", "L.*D'", "L.*[DF]S'")) for one in kinds)
    for expression, events, wanted in (
            ("L.*[DF]S'Egg'+", ["L", "D", "S'Egg'", "S'Egg'"], True), ("L.*[DF]S'Egg'+", ["L", "G'Floor'", "S'Egg'"], True),
            ("L.*[DF]S'Mirror'+S'Egg'+", ["L", "D", "S'Mirror'", "S'Egg'"], True), ("L.*[DF]S'Egg'+", ["L", "S'Egg'"], False)):
        assert sluice_core.accepts(expression, events) == wanted


def retold(scene, expression):
    scene.description["edits"][0]["expression"] = expression
    return scene


def test_of_long_words_the_ends_are_told():
    """Slanted sun falls down between two mirrors, from one to the other and back."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.8), half=1.5)
    for name, x in (("Left", -0.2), ("Right", 0.2)):
        scene.plane(name, [(x, -1, 0), (x, 1, 0), (x, 1, 3), (x, -1, 3)], mirror())
    scene.sun((1, 0, -1), 2.0)
    scene.edit("L", quad((0, 0, 0), (0.2, 0, 0), (0, 0.5, 0)), AWAY)
    expression, share = found(scene).edit()["arrivals"][0]
    assert expression in {"L'Sun'.*S'Left'", "L'Sun'.*S'Right'"} and share > 0.3


# --- light that the eye's segments meet and no photon carries ------------------------------------------------------------------------------


def glowing_scene(expression, exits=(), **more):
    """A floor of radiance 2 and an entry before the camera: all light is emission that the eye sees."""
    scene = Scene(size=16)
    scene.floor(emission(2.0))
    scene.edit(expression, quad((0, 0, 1), *HALF), exits, **more)
    return scene


def lamp_scene(expression, **more):
    """A lamp over a floor, seen past an entry between them."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.8))
    scene.point((0, 0, 2), 40.0, radius=0.1)
    scene.edit(expression, quad((0, 0, 1), *HALF), **more)
    return scene


def acts_unmatched(done):
    edit = done.edit()
    return edit["matched"] == 0 and edit["acted"] and "no light that matches" not in done.statistics["report"]


def test_emission_that_the_eye_sees():
    """That the entry darkens, or the exit lights; an edit that finds none is still told so."""
    assert acts_unmatched(found(glowing_scene("L")))
    moved = found(glowing_scene("L", [exit_at((0.5, 0.5, 2), *HALF, intensity=3.0)]))
    assert acts_unmatched(moved) and moved.edit()["share"] > 0.1
    assert "took light on its way to the eye, makes" in moved.statistics["report"]
    none = found(glowing_scene("LD"))
    assert not none.edit()["acted"] and "no light that matches crossed the entry" in none.statistics["report"]


@pytest.mark.parametrize(("expression", "floor"), [("L", None), ("L'World'", None), ("LS", mirror(0.9)), ("LD", diffuse(0.8))])
def test_the_world_a_mirror_and_the_last_bounce(expression, floor):
    """The world seen at once and in a mirror; light that a photon, which ends at max_depth, does not bring so far."""
    scene = Scene(size=16)
    scene.description["world"] = {"name": "World", "material": scene.material([shader("Background", (1, 1, 1), Strength=1.0)])}
    if floor:
        scene.floor(floor)
    scene.edit(expression, quad((0, 0, 1), *HALF))
    assert acts_unmatched(found(scene, max_depth=1))


@pytest.mark.parametrize("height", [0.5, 1.0, 1.5])
def test_a_shadow_segment_is_taken_by_the_entry_next_to_the_lamp(height):
    """Of two entries on it, as light comes; in one plane, by order."""
    scene = lamp_scene("L")
    scene.edit("L", quad((0, 0, height), *HALF), name="Other")
    done = found(scene, use_indirect=False)
    first, last = ("Other", "Edit") if height > 1 else ("Edit", "Other")
    assert done.edit(first)["acted"] and not done.edit(last)["acted"]


def test_no_light_outside_a_spots_cone():
    scene = Scene(size=16)
    scene.floor(diffuse(0.8))
    scene.light("Spot", "Spot", looking((0, 0, 2), (1, 0, 0)), 40.0, spot_angle=0.5)
    scene.edit("L", quad((0, 0, 1), *HALF))
    assert not found(scene, use_indirect=False).edit()["acted"]
