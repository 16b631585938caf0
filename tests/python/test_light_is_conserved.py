# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics and edited light in the picture are as bright as the photons that carry them, whatever the widths of their kernels, wherever on the
floor they lie. Pictures and counts are sums over the same photons, so what is left of noise is where view samples fall."""

import math
import os

import numpy as np
import pytest
from scenes import LUMINANCE, Scene, diffuse, exit_at, glass, looking, mirror, quad, render, seeds
from statistics_of_renders import assert_mean, assert_same_mean

FULL = bool(os.environ.get("SLUICE_FULL"))
SHIPPED = {"use_adaptive_sampling": True, "caustic_radius_range": 2.5, "photons": 3000, "use_direct": False, "use_indirect": False, "explain_edits": False}
ALBEDO, HALF = 0.8, 0.3


def ball(scene, s=1.0):
    scene.sphere("Caster", (-0.4 * s, 0, 0.6 * s), 0.25 * s, glass(1.5), rings=48)
    return (-0.4, 0.1, 1.6)


def ring(scene, s=1.0):
    """A mirror standing on the floor: the cardioid in a cup, the thinnest of caustics."""
    angle = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    low = np.stack([0.4 * np.cos(angle), 0.4 * np.sin(angle), np.full(96, 0.0)], 1) * s
    a, b = np.arange(96), (np.arange(96) + 1) % 96
    triangles = np.concatenate([np.stack([a, b, a + 96], 1), np.stack([b, b + 96, a + 96], 1)])
    scene.mesh("Caster", np.concatenate([low, low + np.array([0, 0, 0.15 * s])]), triangles, mirror(0.9))
    return (1.0, 0.2, 0.8)


def torus(scene, s=1.0):
    """Of glass, lying above the floor."""
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0, 2 * np.pi, 64, endpoint=False), np.linspace(0, 2 * np.pi, 32, endpoint=False), indexing="ij"))
    r = 0.3 + 0.1 * np.cos(v)
    positions = np.stack([r * np.cos(u), r * np.sin(u), 0.5 + 0.1 * np.sin(v)], 1) * s
    i, j = (a.ravel() for a in np.meshgrid(np.arange(64), np.arange(32), indexing="ij"))
    corner = lambda i, j: i % 64 * 32 + j % 32  # noqa: E731
    a, b, c, d = corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)
    scene.mesh("Caster", positions, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]), glass(1.5))
    return (0.1, -0.1, 1.6)


def lit_floor(caster, s=1.0, size=64):
    """A floor below it, ±s of which the camera sees from between the two."""
    scene = Scene(size=size)
    scene.floor(diffuse(ALBEDO), half=2.5 * s)
    lamp = caster(scene, s)
    scene.point(np.array(lamp) * s, 30.0 * s * s, radius=0.02 * s)
    scene.camera(looking((0, 0, 0.3 * s), (0, 0, -1)), s)
    return scene


def shown(done, part, s=1.0):
    """Watts that arrive in the picture, by its radiance."""
    return float(done[part].mean((0, 1)) @ LUMINANCE) * math.pi / ALBEDO * (2 * s) ** 2


PLACES = [(0.3 + 0.023 * i, 0.2 + 0.031 * (i * 5 % 12)) for i in range(12)]  # at all parts of the disks' cells and of pixels
SCALES = [1.0, 0.01, 30.0, 1000.0]  # of the scene; the exit's own size differs with it
SIZES = [1.0, 0.5, 1.3, 0.7]
PASSES = [24, 48, 96]


def given_of_taken(place, at, passes, seed):
    s, half = SCALES[at], HALF * SIZES[at]
    scene = lit_floor(ball, s)
    entry = quad((-0.4 * s, 0, 0), (HALF * s, 0, 0), (0, HALF * s, 0))
    scene.edit("LS'Caster'+", entry, [exit_at((place[0] * s, place[1] * s, 0), (half * s, 0, 0), (0, half * s, 0), keep_brightness=False)])
    done = render(scene, seed=seed, passes=passes, **SHIPPED)
    edit = done.edit()
    assert edit["energy_out"] == pytest.approx(edit["energy_in"], rel=1e-5)
    return shown(done, "Edited", s) / (edit["energy_out"] / passes)


@pytest.mark.parametrize("turn", range(12 if FULL else 1))
def test_an_exit_gives_what_its_entry_takes(turn):
    """The ball's caustic, moved to twelve places in scenes of four sizes, with three numbers of passes: each within half a percent, the mean of a
    dozen within its own error. Each place has one size and number in turn, in the full form all of them."""
    ratios = [given_of_taken(place, (i + turn) % 4, PASSES[(i // 4 + turn // 4) % 3], 12 * turn + i) for i, place in enumerate(PLACES)]
    np.testing.assert_allclose(ratios, 1, atol=0.005)
    assert_mean(ratios, 1, finest=0.003)


@pytest.mark.parametrize("caster", [ball, ring, torus])
def test_caustics_show_the_flux_of_their_photons(caster):
    """An entry over all of the caustic that the picture shows, with an exit in its place, counts the photons: shown as edited light they make up
    what was counted."""
    scene = lit_floor(caster)
    gate = {"x": (0.7, 0, 0), "y": (0, 0.7, 0)}  # further from the picture's border than a kernel reaches
    scene.edit("LS'Caster'+", quad((0, 0, 0), **gate), [exit_at((0, 0, 0), **gate)])
    counted = seeds(scene, 6, passes=32, **SHIPPED)
    ratios = [shown(r, "Edited") / (r.edit()["energy_out"] / 32) for r in counted.renders]
    np.testing.assert_allclose(ratios, 1, atol=0.01)
    assert_mean(ratios, 1, finest=0.005)


@pytest.mark.skipif(not FULL, reason="in the full form alone")
@pytest.mark.parametrize("caster", [ball, ring, torus])
def test_a_caustic_is_as_bright_without_the_edit_that_counts_it(caster):
    scene = lit_floor(caster)
    scene.edit("LS'Caster'+", quad((0, 0, 0), (2, 0, 0), (0, 2, 0)), [exit_at((0, 0, 0), (2, 0, 0), (0, 2, 0))])
    scene.layer("Caustic", "LS'Caster'+F?DE")
    settings = {**SHIPPED, "passes": 32, "photons": 32768}
    counted, plain = seeds(scene, 8, **settings), seeds(scene, 8, use_edits=False, seed=50, **settings)
    assert_same_mean([shown(r, "Caustic") for r in plain.renders], [shown(r, "Caustic") for r in counted.renders], finest=0.02)


def test_the_border_of_a_perspective_picture():
    """A caustic moved to the border of a picture: what shows of it is what the middle of a picture twice as wide shows there, as near the
    border as in all. The radii are the same in both."""
    def cut(across, seed):
        scene = Scene(size=20 * across)
        scene.floor(diffuse(ALBEDO), half=4.0)
        scene.sphere("Caster", (-1.5, 0, 0.4), 0.2, glass(1.5), rings=48)
        scene.point((-1.8, 0, 2.0), 30.0, radius=0.02)
        gate = {"x": (HALF, 0, 0), "y": (0, HALF, 0)}
        scene.edit("LS'Caster'+", quad((-1.45, 0, 0), **gate), [exit_at((0, 0, 0), **gate)])
        scene.perspective(looking((-0.55, -0.4, 2.5), (0, 0.16, -1)), 2 * math.atan(0.11 * across))
        settings = {**SHIPPED, "photons": 16384, "passes": 8, "caustic_radius_factor": 2.0}
        margin = 10 * across - 20
        return (seeds(scene, 8, seed=seed, **settings).stack("Edited") @ LUMINANCE)[:, margin : margin + 40, margin : margin + 40]

    narrow, wide = cut(2, 0), cut(4, 100)
    assert (wide[:, :, -4:].mean() > 3 * wide.mean()), "the caustic does not lie at the border"
    for part in (np.s_[:, :, :], np.s_[:, :, -4:]):
        assert_same_mean(narrow[part].mean((1, 2)), wide[part].mean((1, 2)), finest=0.03)


def test_a_ring_on_a_floor_of_a_hundred_kilometres():
    """Widths are footprints of pixels: the size of the scene is no matter (numerics D6)."""
    shown_by = {}
    for half in (0.025, 5e4):
        scene = Scene(size=64)
        scene.floor(diffuse(ALBEDO), half=half)
        lamp = ring(scene, 0.01)
        scene.point(np.array(lamp) * 0.01, 0.003, radius=2e-4)
        scene.perspective(looking((0, -0.012, 0.014), (0, 1, -1), up=(0, 0, 1)), 0.8)
        shown_by[half] = seeds(scene, 12, passes=8, **{**SHIPPED, "photons": 16384}).stack("Caustics")
        assert shown_by[half].mean(0).max() > 20 * shown_by[half].mean()  # as thin
    assert_same_mean(*(shown.mean((1, 2, 3)) for shown in shown_by.values()), finest=0.03)
