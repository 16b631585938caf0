# SPDX-License-Identifier: GPL-3.0-or-later
"""Caustics and edited light that a surface scattered before are soft: wide disks show them with less noise, and as bright."""

import pytest
from scenes import LUMINANCE, Scene, diffuse, glass, matrix, quad, seeds
from statistics_of_renders import interval


def lit_by_a_wall():
    """A floor and a bright panel, with a lamp between them. The camera looks at a patch of the floor, so closely that disks are small."""
    scene = Scene(size=32)
    scene.floor(diffuse(0.8))
    scene.plane("Panel", [(-1, -1, 2), (-1, 1, 2), (1, 1, 2), (1, -1, 2)], diffuse(0.9))
    scene.camera(matrix((0.4, 0, 0.6)), 0.12)
    scene.point((0, 0, 1.6), 100.0)
    return scene


def by_glass():
    """A glass ball beside the patch."""
    scene = lit_by_a_wall()
    scene.sphere("Ball", (0, 0, 1), 0.3, glass(), rings=32)
    scene.layer("Soft", "L.*D.*S+DE")
    return scene


def by_an_exit():
    """A gate over the patch, through which what the panel sheds goes as it came."""
    scene = lit_by_a_wall()
    gate = quad((0.4, 0, 1), (0.5, 0, 0), (0, 0.5, 0))
    scene.edit("LD", gate, [{"quad": gate}])
    scene.layer("Soft", "LDFDE")
    return scene


@pytest.mark.parametrize("scene", [by_glass, by_an_exit])
def test_wide_disks_for_soft_light(scene):
    """The same photons, so that their own noise cancels."""
    narrow, wide = (seeds(scene(), 16, passes=2, photons=131072, use_direct=False, use_indirect=False, soft_range=r).stack("Soft") @ LUMINANCE
                    for r in (1.0, 4.0))  # fmt: skip
    difference, half_width = interval((wide - narrow).mean((1, 2)))
    assert abs(difference) <= half_width < 0.05 * narrow.mean()
    assert wide.var(0, ddof=1).mean() < 0.6 * narrow.var(0, ddof=1).mean()
