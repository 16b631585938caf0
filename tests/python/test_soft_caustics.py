# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics of light that a surface scattered before are soft: wide disks show them with less noise, and as bright."""

from scenes import LUMINANCE, Scene, diffuse, glass, matrix, seeds
from statistics_of_renders import interval


def lit_by_a_wall():
    """A glass ball over a floor, between a lamp and a bright panel. The camera looks at a patch beside the ball, so closely that
    disks are small."""
    scene = Scene(size=32)
    scene.floor(diffuse(0.8))
    scene.sphere("Ball", (0, 0, 1), 0.3, glass(), rings=32)
    scene.plane("Panel", [(-1, -1, 2), (-1, 1, 2), (1, 1, 2), (1, -1, 2)], diffuse(0.9))
    scene.camera(matrix((0.4, 0, 0.6)), 0.12)
    scene.point((0, 0, 1.6), 100.0)
    scene.layer("Soft", "L.*D.*S+DE")
    return scene


def test_wide_disks_for_soft_caustics():
    """The same photons, so that their own noise cancels."""
    narrow, wide = (seeds(lit_by_a_wall(), 16, passes=2, photons=131072, use_direct=False, use_indirect=False, soft_caustic_range=r).stack("Soft") @ LUMINANCE
                    for r in (1.0, 4.0))  # fmt: skip
    difference, half_width = interval((wide - narrow).mean((1, 2)))
    assert abs(difference) <= half_width < 0.05 * narrow.mean()
    assert wide.var(0, ddof=1).mean() < 0.6 * narrow.var(0, ddof=1).mean()
