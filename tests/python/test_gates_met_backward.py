# SPDX-License-Identifier: GPL-3.0-or-later
"""Hard cases of view segments: more ways through one plane than branches, entries of equal order, surfaces lit from behind."""

import numpy as np
import pytest
from scenes import Scene, both, diffuse, emission, exit_at, looking, quad, render, seeds, shader
from statistics_of_renders import assert_same_mean

HALF = ((0.4, 0, 0), (0, 0.4, 0))


def shown_scene(exits):
    """A lamp's light is taken far off and laid, in `exits` equal parts, between the camera and a view edit that shows what it sees."""
    scene = Scene(size=16)
    scene.floor(diffuse(0.5))
    scene.plane("Panel", [(9, -1, 1), (9, 1, 1), (9, 1, 3), (9, -1, 3)], emission((1, 1, 1), 5.0))
    scene.floor(diffuse(0.5), half=4.0, z=-3.0, name="Ground")
    scene.edit("L", quad((8.5, 0, 2), (0, 0, 1), (0, 1, 0), (1, 0, 0)),
               [exit_at((0, 0, 3), *HALF, intensity=1 / exits) for _ in range(exits)], name="Light")  # fmt: skip
    scene.edit("E", quad((0, 0, 2), *HALF), [exit_at((0, 0, 1.9), *HALF)], name="View")
    return scene


@pytest.mark.parametrize("exits", [15, 16, 17, 33])
def test_more_ways_than_branches(exits):
    one, many = (seeds(shown_scene(n), 8, passes=16, photons=4096) for n in (1, exits))
    assert_same_mean(many.stack("Combined").mean((1, 2, 3)), one.stack("Combined").mean((1, 2, 3)), finest=0.1)


def test_of_equal_orders_the_first_takes_the_light():
    def scene(orders):
        scene = Scene(size=16)
        scene.plane("Panel", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], emission((1, 1, 1), 1.0))
        for side, order in zip((-1, 1), orders, strict=True):
            scene.edit("L", quad((0, 0, 0.5)), [exit_at((0.5 * side, 0, 1), (0.3, 0, 0), (0, 0.3, 0))], name=f"Edit {side}")
            scene.description["edits"][-1]["entry"]["order"] = order
        return scene

    ranked, equal = render(scene((0, 1))), render(scene((0, 0)))
    assert ranked["Emission"][:, :8].mean() > 0 and ranked["Emission"][:, 8:].max() == 0
    assert equal.hash == ranked.hash


@pytest.mark.parametrize("roughness", [0.03, 0.05, 0.3])
def test_diffuse_with_glass_does_not_glow_from_behind(roughness):
    scene = Scene(size=16)
    rough = shader("BsdfGlass", (1, 1, 1), Roughness=roughness, IOR=1.5)
    scene.floor(both(diffuse(0.8), [rough]), half=1.0, name="Plate")
    scene.light("Lamp", "Point", looking((0, 0, -1), (0, 0, 1)), 40.0, radius=0.1)
    scene.layer("Diffuse", "L.*[^SG]E")
    scene.layer("Other", "L.*[SG]E|LE")
    done = render(scene, passes=8)
    assert done["Combined"].mean() > 0
    assert done["Diffuse"].max() <= 1e-6
    np.testing.assert_allclose(done["Diffuse"] + done["Other"], done["Combined"], atol=1e-4 * done["Combined"].mean())
