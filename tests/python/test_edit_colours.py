# SPDX-License-Identifier: GPL-3.0-or-later
"""What an exit does to the colour of light on a lone floor: its hue turns, then its tint colours, and white light stays as bright."""

import math

import numpy as np
import pytest
from edited_floor import ENTRY, EXITS, PASSES, PHOTONS, SEEDS, check, floor_scene
from floor_tracer import tinted, turn_hue
from scenes import LUMINANCE, defaults, diffuse, exit_at, render, seeds  # noqa: F401: each test in both kinds
from statistics_of_renders import assert_same_mean


@pytest.mark.parametrize("angle", [0.5, 2 * math.pi / 3, -2.5])
def test_hue_shift_turns_the_hue_and_keeps_the_luminance(angle):
    color = np.array((1.0, 0.45, 0.2))
    scene, light = floor_scene("point", color=tuple(color))
    scene.edit("L", ENTRY, [{**EXITS["rotated"], "hue_shift": angle}])
    got, _ = check(scene, light, color=color)
    want = turn_hue(color, angle)
    total = got.mean("Edited").sum((0, 1))
    np.testing.assert_allclose(total / (LUMINANCE @ total), want / (LUMINANCE @ want), rtol=2e-4)


def test_hue_shift_leaves_greys_alone():
    """Bit for bit: an angle on grey light is no angle."""
    hashes = []
    for angle in (0.0, 1.0):
        scene, _ = floor_scene("point", color=(0.7, 0.7, 0.7))
        scene.edit("L", ENTRY, [{**EXITS["rotated"], "hue_shift": angle}])
        hashes.append(render(scene).hash)
    assert hashes[0] == hashes[1]


TINT = (0.2, 0.05, 0.6)


def test_a_tint_colours_white_light_and_keeps_its_luminance():
    scene, light = floor_scene("point")
    scene.edit("L", ENTRY, [{**EXITS["larger"], "tint": TINT}])
    got, _ = check(scene, light)
    total = got.mean("Edited").sum((0, 1))
    np.testing.assert_allclose(total / (LUMINANCE @ total), tinted(np.ones(3), TINT), rtol=2e-4)
    edit = got.renders[0].edit()
    assert edit["energy_out"] == pytest.approx(edit["energy_in"] * 0.5 * 0.45 / 0.3**2, rel=1e-4)


def test_a_tint_decides_nothing():
    """Of white light pixels keep their luminance, noise and all: the same paths are traced. (Where photons are aimed, a pilot asks for
    luminance, so rounding may lay a few of them elsewhere.)"""
    pictures = []
    for tint in ((1, 1, 1), TINT, (1, 0, 0)):
        scene, _ = floor_scene("point")
        scene.box("Wall", (-1.0, 0.7, 0), (1.0, 0.8, 0.8), diffuse(0.7))  # for light that goes on
        scene.edit("L.*", ENTRY, [{**exit_at((0.2, 0.1, 0.5), (0.3, 0, 0), (0, 0.3, 0)), "tint": tint}])
        pictures.append(seeds(scene, 5).stack() @ LUMINANCE)  # how many photons rounding moves is a matter of the seed: 0 to 9 % of the pixels
    for picture in pictures[1:]:
        same = np.isclose(picture, pictures[0], rtol=1e-3)
        assert same.mean() > 0.95


def test_a_tint_comes_after_the_hue():
    color = np.array((1.0, 0.45, 0.2))
    scene, light = floor_scene("point", color=tuple(color))
    scene.edit("L", ENTRY, [{**EXITS["rotated"], "hue_shift": 2.0, "tint": TINT}])
    got, _ = check(scene, light, color=color)
    want, total = tinted(turn_hue(color, 2.0), TINT), got.mean("Edited").sum((0, 1))
    np.testing.assert_allclose(total / (LUMINANCE @ total), want / (LUMINANCE @ want), rtol=2e-4)


def test_white_greys_and_black_tint_nothing():
    """Bit for bit."""
    hashes = []
    for tint in ({}, *({"tint": (grey, grey, grey)} for grey in (1.0, 0.3, 0.0))):
        scene, _ = floor_scene("point", color=(1.0, 0.45, 0.2))
        scene.edit("L", ENTRY, [{**EXITS["rotated"], "hue_shift": 1.0, **tint}])
        hashes.append(render(scene).hash)
    assert len(set(hashes)) == 1


def test_light_is_coloured_alike_before_and_behind_a_grey_floor():
    """Photons go forward through the gate of the first, view paths backward through that of the second. Disks blur what photons tell: over
    24 seeds it is 0.26 % less after four passes and 0.13 % after 32, as radii shrink."""
    color = np.array((1.0, 0.45, 0.2))
    means = []
    for expression in ("L", "LD"):
        scene, _ = floor_scene("point", color=tuple(color))
        scene.edit(expression, ENTRY, [{**exit_at((-0.5, 0.1, 0), (0.3, 0, 0), (0, 0.3, 0)), "hue_shift": 2.0, "tint": TINT}])
        got = seeds(scene, SEEDS, passes=PASSES, photons=PHOTONS)
        means.append(got.stack("Combined")[:, 15:20, 5:11])  # inside, away from the border's blur
    want = tinted(turn_hue(color, 2.0), TINT)
    for picture in means:
        total = picture.mean((0, 1, 2))
        np.testing.assert_allclose(total / (LUMINANCE @ total), want / (LUMINANCE @ want), rtol=2e-4)
    assert_same_mean(*(picture.mean((1, 2)) @ LUMINANCE for picture in means), bias=0.003)
