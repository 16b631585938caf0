# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of more lamps than are weighed one by one: light is additive, and none of it hides behind a sun on a large ground."""

import numpy as np
import pytest
from scenes import LUMINANCE, Scene, diffuse, render, seeds
from statistics_of_renders import assert_blocks, blocks

DIRECT = {"use_indirect": False, "use_caustics": False, "photons": 1024}


def lamps():
    """24 lamps over a patch of 4 m, of 1 to 30 W, and a sun: functions that add them to a scene."""
    random = np.random.default_rng(1)
    places, powers = random.uniform((-2, -2, 0.5), (2, 2, 2.5), (24, 3)), 10 ** random.uniform(0, 1.5, 24)
    points = [lambda scene, p=p, w=w: scene.point(p, w, radius=0.0) for p, w in zip(places, powers, strict=True)]
    return [*points, lambda scene: scene.sun((0.3, 0.2, -1), 0.2)]


def lit_by(lights, extent):
    """The patch on a ground of `extent`, with blocks that throw shadows."""
    scene = Scene(size=32, view=2.0)
    scene.floor(diffuse(0.8), half=extent / 2)
    for i, (x, y) in enumerate([(-1, -1), (0.5, 0.2), (1, -0.8)]):
        scene.box(f"Block {i}", (x, y, 0), (x + 0.4, y + 0.4, 0.4), diffuse(0.5))
    for light in lights:
        light(scene)
    return scene


@pytest.mark.parametrize("extent", [10, 1e3, 1e5])
def test_light_of_many_lamps_is_the_sum_of_each(extent):
    of_each = sum(render(lit_by([light], extent), passes=32, **DIRECT)["Direct"] @ LUMINANCE for light in lamps())
    of_all = seeds(lit_by(lamps(), extent), 12, passes=32, **DIRECT).stack("Direct") @ LUMINANCE
    assert_blocks(blocks(of_all, 8), blocks(of_each, 8), bias=0.005, finest=0.05, finest_sum=0.01)


def test_noise_does_not_grow_with_the_ground():
    small, large = (seeds(lit_by(lamps(), extent), 4, passes=8, **DIRECT).stack("Direct") @ LUMINANCE for extent in (10, 1e5))
    assert large.var(0, ddof=1).mean() < 1.5 * small.var(0, ddof=1).mean()
