# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits on caustics: what the entry takes is what the exit gives, and other light stays."""

import math

import numpy as np
import pytest
from scenes import Scene, defaults, diffuse, exit_at, glass, looking, quad, render, seeds  # noqa: F401: each test in both kinds
from statistics_of_renders import assert_mean, assert_same_mean, interval

ALBEDO, SUN = 0.8, 2.0
SIZE, PASSES, PHOTONS, SEEDS = 32, 4, 32768, 8
TRANSMITTED = (1 - ((1.5 - 1) / (1.5 + 1)) ** 2) ** 2  # through two faces


def slab_scene(**sun):
    """Sun from above; a glass slab covers x < 0. The camera hangs below the slab and sees the floor, ±1."""
    scene = Scene(size=SIZE)
    scene.floor(diffuse(ALBEDO), half=1.5)
    scene.box("Slab", (-1.4, -1.4, 0.2), (-0.05, 1.4, 0.3), glass(1.5))
    scene.camera(looking((0, 0, 0.19), (0, 0, -1)), 1.0)
    scene.sun((0, 0, -1), SUN, **sun)
    return scene


ENTRY, EXIT = quad((-0.5, 0, 0), (0.25, 0, 0), (0, 0.25, 0)), exit_at((0.5, 0.25, 0), (0.25, 0, 0), (0, 0.25, 0))
INSIDE_ENTRY = np.s_[:, 14:18, 6:10]  # ±0.125 about its middle
INSIDE_EXIT = np.s_[:, 18:22, 22:26]
SETTINGS = {"passes": PASSES, "photons": PHOTONS, "caustic_radius_factor": 1.5}


@pytest.mark.parametrize("depth", [3, 12])
def test_a_caustic_is_moved_whole(depth):
    scene, unedited = slab_scene(), slab_scene()
    scene.edit("LS'Slab'+", ENTRY, [EXIT])
    for each in (scene, unedited):
        each.layer("Caustic", "LS+F?DE")
    moved = seeds(scene, SEEDS, max_depth=depth, **SETTINGS)
    plain = seeds(unedited, SEEDS, max_depth=depth, seed=50, **SETTINGS)
    # flux in = flux out, in the picture and in the counts. What the slab throws back onto the floor (LDS+D) is left out: there is more of
    # it below the slab than beside it
    assert_same_mean(moved.stack("Caustic").mean((1, 2, 3)), plain.stack("Caustic").mean((1, 2, 3)), finest=0.03)
    for r in moved.renders:
        edit = r.edit()
        assert edit["energy_out"] == pytest.approx(edit["energy_in"], rel=1e-5) and edit["moved"] == edit["matched"] > 0
    # straight through the slab, on paper; with all inner reflections T = (1 − R) / (1 + R)
    level = TRANSMITTED if depth == 3 else math.sqrt(TRANSMITTED) / (2 - math.sqrt(TRANSMITTED))
    assert_mean([r.edit()["energy_in"] / PASSES for r in moved.renders], level * SUN * 0.25, finest=0.04)
    assert_mean(moved.stack("Edited")[INSIDE_EXIT].mean((1, 2, 3)), level * SUN * ALBEDO / math.pi, finest=0.06)
    # at the entry only light remains that came LD…S; on the exit the sun is what it was
    left, there = moved.stack("Caustics")[INSIDE_ENTRY].mean((1, 2, 3)), plain.stack("Caustics")[INSIDE_ENTRY].mean((1, 2, 3))
    assert left.mean() < 0.12 * there.mean()
    np.testing.assert_allclose(moved.stack("Direct")[INSIDE_EXIT], SUN * ALBEDO / math.pi, rtol=1e-5)


def test_other_light_is_not_taken():
    """The entry over the caustic asks for light straight from the lamp: there is none, so nothing changes, not a bit; and the other way
    round an entry in the sun that asks for caustics."""
    plain = render(slab_scene(), **SETTINGS)
    for expression, place in (("L", (-0.5, 0, 0)), ("LS{9}", (-0.5, 0, 0)), ("LS{5,6}S{7}", (0.5, 0, 0))):
        scene = slab_scene()
        scene.edit(expression, quad(place, (0.25, 0, 0), (0, 0.25, 0)), [exit_at((0.5, 0.25, 0), (0.2, 0, 0), (0, 0.2, 0))])
        done = render(scene, **SETTINGS)
        assert done.edit()["matched"] == 0
        assert done.hash == plain.hash, expression


def ball_scene():
    """A glass ball below a lamp; the camera looks down from between it and the floor."""
    scene = Scene(size=64)
    scene.floor(diffuse(ALBEDO), half=1.5)
    scene.sphere("Ball", (-0.4, 0, 0.6), 0.25, glass(1.5), rings=48)
    scene.point((-0.4, 0.1, 1.6), 30.0, radius=0.02)
    scene.camera(looking((0, 0, 0.3), (0, 0, -1)), 1.0)
    return scene


@pytest.mark.parametrize("kind", ["copied", "halved", "removed"])
def test_the_caustic_of_a_ball(kind):
    """All of its light passes one entry: two exits of one half each keep the flux, one of one half halves it, none removes it; the
    light beside it stays."""
    scene = ball_scene()
    half = {"x": (0.3, 0, 0), "y": (0, 0.3, 0)}
    exits = [exit_at((0.5, 0.5, 0), **half, intensity=0.5), exit_at((0.5, -0.4, 0), **half, intensity=0.5)]
    scene.edit("LS'Ball'+", quad((-0.4, 0, 0), **half), exits[: {"copied": 2, "halved": 1, "removed": 0}[kind]])
    settings = {**SETTINGS, "caustic_radius_factor": 4.0}
    edited = seeds(scene, SEEDS, **settings)
    plain = seeds(ball_scene(), SEEDS, seed=50, **settings)
    share = {"copied": 1, "halved": 0.5, "removed": 0}[kind]
    caustic, error = interval(plain.stack("Caustics").mean((1, 2, 3)))
    rest, rest_error = interval(edited.stack("Caustics").mean((1, 2, 3)))
    given, given_error = interval(edited.stack("Edited").mean((1, 2, 3)))
    assert error < 0.05 * caustic and rest < 0.25 * caustic
    assert abs(given - share * (caustic - rest)) <= given_error + share * (error + rest_error)
    for r in edited.renders:
        assert r.edit()["energy_out"] == pytest.approx(share * r.edit()["energy_in"], rel=1e-5)
        # what the picture shows is what the photons carried: both are sums over the same photons
        assert r["Edited"].mean() * 4 * math.pi / ALBEDO == pytest.approx(r.edit()["energy_out"] / PASSES, rel=0.05)
    assert_same_mean(edited.stack("Direct").mean((1, 2, 3)), plain.stack("Direct").mean((1, 2, 3)))
