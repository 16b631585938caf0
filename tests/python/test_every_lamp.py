# SPDX-License-Identifier: GPL-3.0-or-later
"""Light is additive: the picture of all lamps is the sum of the pictures of each, in a scene of any extent, whatever shines beside them. And
what cannot come in changes nothing. Block by block the fast form sees no less than starvation; the full one has more of everything."""

import math
import os

import numpy as np
import pytest
from scenes import LUMINANCE, Scene, diffuse, emission, exit_at, glass, grey, looking, quad, seeds, shader
from statistics_of_renders import assert_mean, assert_same_mean, blocks, student_quantile

FULL = bool(os.environ.get("SLUICE_FULL"))
SEEDS = 16 if FULL else 6
SETTINGS = {"passes": 4, "photons": 16384, "threads": 2, "use_adaptive_sampling": True, "caustic_radius_range": 2.5}  # as the product has them
EXTENTS = (10.0, 100.0, 1e3, 1e4, 1e5) if FULL else (10.0, 1e5)


def world(scene, radiance):
    scene.description["materials"].append({"name": "World", "nodes": [shader("Background", grey(radiance), Strength=1.0)], "surface": 0, "surface_output": ""})
    scene.description["world"] = {"name": "World", "material": len(scene.description["materials"]) - 1}


def room(lamp=True, keyhole=0.0):
    """A room of 4 m seen from inside, with a lamp, or with a keyhole in its roof."""
    scene = Scene(size=32)
    wall = diffuse(0.7)
    if keyhole:
        for a, b in ((-2, -keyhole), (keyhole, 2)):
            scene.plane(f"Roof {a}", [(a, -2, 2), (b, -2, 2), (b, 2, 2), (a, 2, 2)], wall)
            scene.plane(f"Roof beside {a}", [(-keyhole, a, 2), (keyhole, a, 2), (keyhole, b, 2), (-keyhole, b, 2)], wall)
        for x in (-2, 2):
            scene.plane(f"Side {x}", [(x, -2, -2), (x, 2, -2), (x, 2, 2), (x, -2, 2)], wall)
            scene.plane(f"Wall {x}", [(-2, x, -2), (2, x, -2), (2, x, 2), (-2, x, 2)], wall)
        scene.floor(wall, half=2.0, z=-2.0)
    else:
        scene.box("Room", (-2, -2, -2), (2, 2, 2), wall)
    scene.perspective(looking((0, -1.8, 0), (0, 1, -0.3), (0, 0, 1)), 1.2)
    if lamp:
        scene.point((0, 0.2, 1.5), 40.0, radius=0.05)
    return scene


def beside(scene, extent, sun=False, sky=0.0, dome=0.0, floods=0):
    """What lies around it, as far as `extent` reaches."""
    half = extent / 2
    scene.plane("Ground", [(-half, -half, -3), (half, -half, -3), (half, half, -3), (-half, half, -3)], diffuse(0.5))
    if sun:
        scene.sun((0.2, 0.1, -1), 3.0)
    if sky:
        world(scene, sky)
    if dome:
        scene.sphere("Dome", (0, 0, 0), extent, emission(1.0, dome), rings=16)
    for i in range(floods):
        scene.point((10 + i % 5, i // 5, 0), 10000.0, name=f"Floodlight {i}", radius=0.1)
    return scene


def rendered(scene, seed=0):
    renders = seeds(scene, SEEDS, seed=seed, **SETTINGS)
    return renders, blocks(renders.stack() @ LUMINANCE, 8).reshape(SEEDS, -1)


def assert_sum(whole, parts, bias=0.01, finest=0.06):
    """Block by block, by the errors of both sides. Variances are taken as proportional to the light (photons are counted), or as a block's own
    where that is more; what radii of other pictures blur otherwise is `bias`."""
    expected = sum(part.mean(0) for part in parts)
    own = whole.var(0, ddof=1) + sum(part.var(0, ddof=1) for part in parts)
    variance = np.maximum(own, (own / expected).mean() * expected) / SEEDS
    half_width = student_quantile(1e-3 / expected.size, expected.size * (SEEDS - 1)) * np.sqrt(variance)
    assert (half_width < finest * expected.mean()).all(), f"too noisy to tell: {(half_width / expected.mean()).max():.1%}"
    off = np.abs(whole.mean(0) - expected) - bias * expected
    assert (off <= half_width).all(), f"{(off / half_width).max():.2f} of its error: {whole.mean(0)} is not {expected}"


AROUND = {"sun": {"sun": True}, "sky": {"sky": 0.5}, "dome": {"dome": 0.5}, "floodlights": {"floods": 20}}


@pytest.mark.parametrize("extent", EXTENTS)
@pytest.mark.parametrize("around", AROUND if FULL else ["all"])
def test_what_cannot_come_in_changes_nothing(around, extent):
    more = AROUND[around] if FULL else {key: value for each in ("sun", "sky", "dome") for key, value in AROUND[each].items()}
    renders, found = rendered(beside(room(), extent, **more))
    _, alone = rendered(room(), seed=100)
    assert_sum(found, [alone], finest=0.1)
    assert_same_mean(found.mean(1), alone.mean(1), finest=0.03)
    unmet = {each["name"] for each in renders.renders[0].statistics["unmet"]}
    assert {"sun": "Sun", "sky": "World", "dome": "Dome", "all": "Sun", "floodlights": "Floodlight 0"}[around] in unmet


@pytest.mark.parametrize("extent", EXTENTS)
def test_a_keyhole_room(extent):
    """Sun, sky and lamp each bring something; the sun and the sky through a hole of 40 cm."""
    lights = {"lamp": ({"lamp": True}, {}), "sun": ({"lamp": False}, {"sun": True}), "sky": ({"lamp": False}, {"sky": 2.0})}
    _, whole = rendered(beside(room(keyhole=0.2), extent, sun=True, sky=2.0))
    parts = [rendered(beside(room(keyhole=0.2, **inside), extent, **outside), seed=100 * i + 100)[1] for i, (inside, outside) in enumerate(lights.values())]
    assert parts[1].mean() > 0.02 * parts[0].mean()  # else it says nothing
    assert_sum(whole, parts, bias=0.02, finest=0.12)


def test_a_thousand_small_lamps_beside_one():
    rng = np.random.default_rng(5)
    places = rng.uniform(-1.9, 1.9, (1000 if FULL else 300, 3))

    def lit(large, small):
        scene = room(lamp=large)
        for i, place in enumerate(places if small else ()):
            scene.point(tuple(place), 0.04, name=f"Small {i}")
        return rendered(scene, seed=10 * large + 100 * small)[1]

    assert_sum(lit(True, True), [lit(True, False), lit(False, True)], finest=0.2)


def caustic(extent, **more):
    """The caustic of a ball on a table in the open, moved by an edit that names its lamp."""
    scene = Scene(size=32, view=0.5)
    scene.camera(looking((0.35, 0, 0.3), (0, 0, -1)), 0.3)
    scene.floor(diffuse(0.8), half=1.0)
    scene.sphere("Ball", (-0.4, 0, 0.35), 0.15, glass(1.5), rings=48)
    scene.point((-0.4, 0.1, 1.2), 5.0, radius=0.02)
    half = {"x": (0.25, 0, 0), "y": (0, 0.25, 0)}
    scene.edit("L'Lamp'S'Ball'+", quad((-0.4, 0, 0), **half), [exit_at((0.35, 0, 0), **half)])
    return beside(scene, extent, **more) if extent else scene


@pytest.fixture(scope="module")
def caustic_alone():
    return seeds(caustic(0), 2 * SEEDS, seed=100, **SETTINGS).stack("Edited").mean((1, 2, 3))


def scaled(scene, factor):
    """The same scene, so many times as large, with lamps as much stronger as keeps the picture: radiance and a sun's irradiance have no size."""
    size = np.diag([factor, factor, factor, 1.0])
    d = scene.description
    for mesh in d["meshes"]:
        mesh["positions"] = np.asarray(mesh["positions"], np.float32) * np.float32(factor)
    for lamp in d["lights"]:
        lamp["matrix"] = np.concatenate([lamp["matrix"][:, :3], size @ lamp["matrix"][:, 3:]], 1)
        lamp["radius"] = lamp.get("radius", 0.0) * factor
        lamp["power"] *= 1 if lamp["kind"] == "Sun" else factor**2
    for place in (q for edit in d["edits"] for q in (edit["entry"], *(exit_["quad"] for exit_ in edit["exits"]))):
        place["matrix"] = size @ place["matrix"]
    camera = d["camera"]
    camera["matrix"] = np.concatenate([camera["matrix"][:, :3], size @ camera["matrix"][:, 3:]], 1)
    camera["ortho_scale"] = camera.get("ortho_scale", 1.0) * factor
    camera["clip_start"] *= factor
    return scene


@pytest.mark.parametrize("factor", [0.1, 1e3])
def test_size_is_no_matter(factor):
    """A keyhole room in the sun with everything in it on a ground of 1 m, or of 10 km; and a moved caustic."""
    def lit():
        return beside(room(keyhole=0.2), 10.0, sun=True, sky=2.0)

    assert_sum(rendered(scaled(lit(), factor))[1], [rendered(lit(), seed=100)[1]], bias=0.02, finest=0.16)
    found, expected = (seeds(scene, 2 * SEEDS, seed=seed, **SETTINGS).stack("Edited").mean((1, 2, 3))
                       for scene, seed in ((scaled(caustic(10.0, sun=True), factor), 0), (caustic(10.0, sun=True), 100)))
    assert_same_mean(found, expected, finest=0.12)


def test_an_edit_on_each_of_many_lamps():
    """Each of 12 lamps, weak and strong ones, has an edit that takes its light alone off one spot of the floor and lays it beside: what the edits
    move together is what some move with the others away, and each takes what its lamp sends there."""
    count, half = 12, {"x": (0.3, 0, 0), "y": (0, 0.3, 0)}
    places = np.random.default_rng(7).uniform(-1, 1, (count, 2))

    def lit(chosen):
        scene = Scene(size=32)
        scene.floor(diffuse(0.8), half=3.0)
        for i in range(count):
            scene.point((*places[i], 1.0), 5.0 * 4 ** (i % 4), name=f"Lamp {i}")
            if i in chosen:
                scene.edit(f"L'Lamp {i}'", quad((-0.5, 0, 0), **half), [exit_at((0.5, 0, 0), **half)], name=f"Edit {i}")
        return scene

    def moved(chosen, seed):
        return seeds(lit(chosen), 2 * SEEDS, seed=seed, **SETTINGS)

    together = moved(range(count), 0)
    groups = [moved(range(first, count, 4), 100 * first + 100) for first in range(4)]  # of like strength: else the strong ones hide the weak
    light = [(renders.stack("Edited") @ LUMINANCE).mean((1, 2)) for renders in (together, *groups)]
    assert_same_mean(light[0], sum(light[1:]), finest=0.05)
    taken = np.array([[edit["energy_in"] / SETTINGS["passes"] for edit in render.statistics["edits"]] for render in together.renders])
    x, y = (grid.ravel() for grid in np.meshgrid(np.arange(-0.295, 0.3, 0.01) - 0.5, np.arange(-0.295, 0.3, 0.01)))
    for i, place in enumerate(places):  # power / 4π and the cosine over the distance squared, over the entry
        distance2 = (x - place[0]) ** 2 + (y - place[1]) ** 2 + 1
        assert_mean(taken[:, i], 5.0 * 4 ** (i % 4) / (4 * math.pi) * 0.36 * (distance2**-1.5).mean(), finest=0.6)


@pytest.mark.parametrize("extent", EXTENTS)
def test_a_moved_caustic_in_the_open(caustic_alone, extent):
    """Of one small lamp, in the sun, under the sky, on grounds of any size."""
    found = seeds(caustic(extent, sun=True, sky=0.3), 2 * SEEDS, **SETTINGS).stack("Edited").mean((1, 2, 3))
    assert_same_mean(found, caustic_alone, finest=0.12)


def test_a_large_dome_makes_a_caustic():
    """A ball under a dome of radius R throws the same light for any R."""
    def of(extent):
        scene = Scene(size=32)
        scene.floor(diffuse(0.8), half=1.0)
        scene.sphere("Ball", (0, 0, 0.45), 0.4, glass(1.5), rings=48)
        scene.sphere("Dome", (0, 0, 0), extent, emission(1.0), rings=16)
        scene.perspective(looking((0, -2, 1.5), (0, 2, -1.4), (0, 0, 1)), 0.6)
        return seeds(scene, SEEDS, seed=int(math.log10(extent)) * 100, **SETTINGS).stack("Caustics").mean((1, 2, 3))

    near = of(10.0)
    for extent in EXTENTS[1:]:
        assert_same_mean(of(extent), near, finest=0.2)


def test_what_lights_the_picture_is_met():
    """A sun over an open floor brings no photon, and a lamp beside one none but the light that it sends straight."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.8))
    scene.sun((0.2, 0, -1), 2.0)
    scene.point((0.3, 0.2, 1.0), 5.0)
    assert not seeds(scene, 1, **SETTINGS).renders[0].statistics["unmet"]


def test_a_lamp_of_a_millimetre_on_a_ground_of_a_thousand_kilometres():
    def lit(extent, seed=0):
        scene = room(lamp=False)
        scene.point((0, 0.2, 1.5), 40.0, radius=0.0005)
        return rendered(beside(scene, extent, sun=True) if extent else scene, seed)[1]

    assert_sum(lit(1e6), [lit(0, seed=100)], finest=0.1)
