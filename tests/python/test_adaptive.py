# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive sampling: more samples where a pilot finds noise, and the same picture in the mean."""

import numpy as np
from scenes import LUMINANCE, Scene, diffuse, emission, glass, looking, render, seeds
from statistics_of_renders import assert_same_mean, blocks

PASSES = {"passes": 4, "photons": 8192}


def corner():
    """A bright panel over a floor of which half is black: noise lies in the other half, at the panel's edges and in the ball."""
    scene = Scene(size=48)
    scene.perspective(looking((0, -3.2, 1.6), (0, 3, -0.9), up=(0, 0, 1)), 0.9)
    scene.floor(diffuse(0.8))
    scene.plane("Wall", [(-2, 1, 0), (2, 1, 0), (2, 1, 2), (-2, 1, 2)], diffuse(0.6))
    scene.plane("Panel", [(0.6, -1, 1.6), (0.6, 1, 1.6), (1.2, 1, 1.6), (1.2, -1, 1.6)], emission((1, 0.9, 0.6), 6.0))
    scene.sphere("Ball", (-0.3, 0.1, 0.5), 0.4, glass(), rings=24)
    return scene


def test_the_mean_stays():
    plain = seeds(corner(), 16, **PASSES)
    adaptive = seeds(corner(), 16, use_adaptive_sampling=True, seed=100, **PASSES)
    a, b = (blocks(r.stack() @ LUMINANCE, 12).reshape(16, -1) for r in (plain, adaptive))
    for block in range(a.shape[1]):
        assert_same_mean(a[:, block], b[:, block], finest=0.2)
    assert_same_mean(a.mean(1), b.mean(1), finest=0.03)


def test_more_samples_leave_less_error():
    """Of the kind that Film::relative_error() estimates. Photons, of which a pass has as many as before, have their share in it."""
    plain, adaptive = (seeds(corner(), 8, use_adaptive_sampling=on, **PASSES) for on in (False, True))
    work = adaptive.renders[0].statistics["view_paths"] / plain.renders[0].statistics["view_paths"]
    assert 1.2 < work < 2
    mean = plain.stack().mean(0)
    error = [(r.stack().var(0, ddof=1) / (mean**2 + (mean.mean() / 10) ** 2)).mean() for r in (plain, adaptive)]
    assert error[1] < 0.8 * error[0]


def test_pictures_without_noise_are_sampled_evenly():
    black, grey = Scene(size=16), Scene(size=16)
    black.floor(diffuse(0.8))
    grey.floor(emission((1, 1, 1), 0.5))
    for scene, level in ((black, 0.0), (grey, 0.5)):
        even = render(scene, use_adaptive_sampling=True, **PASSES)
        assert even.statistics["view_paths"] == 4 * 16 * 16
        np.testing.assert_allclose(even["Combined"][..., :3], level, rtol=1e-6)
