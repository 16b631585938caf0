# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes that nobody asks for take no memory: the film of a picture in full HD, and what cannot be read from it then."""

import pytest
from scenes import Scene, diffuse, start


def full_hd(**settings):
    scene = Scene()
    scene.floor(diffuse(0.5))
    scene.point((0, 0, 2), 10)
    scene.description["frame"] = {"width": 1920, "height": 1080, "filter_width": 1.0, "filter_box": True}
    session = start(scene, passes=1, photons=1000, threads=2, **settings)
    assert session.wait(120)
    return session


@pytest.mark.parametrize("asked", [[], ["Noise"], ["Combined", "Noise"]], ids=repr)
def test_combined_and_noise_fit_into_350_megabytes(asked):
    session = full_hd(render_passes=asked)
    assert session.progress()["memory"] <= 350e6
    assert session.snapshot(["Combined", "Noise"]) is not None and session.snapshot(["Depth"]) is None


def test_a_pass_more_takes_its_sums_alone():
    """Two double numbers of each channel and pixel."""
    fewest, more = (full_hd(render_passes=asked).progress()["memory"] for asked in (["Noise"], ["Noise", "Depth"]))
    assert more - fewest == pytest.approx(1920 * 1080 * 16, rel=0.05)
