# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive sampling: more samples where a pilot finds noise, and the same picture in the mean."""

import numpy as np
import sluice_core
from scenes import LUMINANCE, Scene, diffuse, emission, glass, looking, render, seeds, start
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


def small_glass():
    """A lamp above a wide floor, of which the camera sees a small glass ball's shadow: few of its photons matter."""
    scene = Scene(size=24, view=0.6)
    scene.floor(diffuse(0.7), 20)
    scene.sphere("Ball", (0, 0, 0.3), 0.2, glass(), rings=24)
    scene.point((0, 0, 3), 300, radius=0.05)
    return scene


def test_where_photons_go_changes_noise_alone():
    """With the guide, and as the lamp shines: one mean, and the guide has much less noise of caustics in it."""
    guided, plain = (seeds(small_glass(), 8, passes=4, photons=30000, use_indirect=False, use_guide=use, seed=seed) for use, seed in ((True, 0), (False, 50)))
    assert_same_mean(guided.stack("Caustics").mean((1, 2, 3)), plain.stack("Caustics").mean((1, 2, 3)), finest=0.2)
    noise = [found.stack("Caustics").mean((1, 2, 3)).std(ddof=1) for found in (guided, plain)]
    assert noise[0] < noise[1] / 3, noise


def test_where_samples_go_is_told():
    """Four numbers of each pixel: one sample everywhere without adaptive sampling, more at some places with it; nothing before the first pass."""
    even, adaptive = (render_session(use_adaptive_sampling=on) for on in (False, True))
    assert (even.sample_counts()[..., 0] == 1).all() and even.sample_counts().shape == (48, 48, 4)
    assert adaptive.sample_counts()[..., 0].max() > 1
    assert sluice_core.Session().sample_counts() is None


def render_session(**settings):
    session = start(corner(), **PASSES, **settings)
    assert session.wait(60)
    return session
