# SPDX-License-Identifier: GPL-3.0-or-later
"""A lone floor under one lamp, edits on it, and the check of what the core makes of them against an oracle that shares nothing with it
(floor_tracer.py). For the tests of edits' laws and of their colours."""

import math
import os

import numpy as np
from floor_tracer import Quad, expected_edited, from_point, from_square, from_sun
from scenes import LUMINANCE, Scene, diffuse, exit_at, most_range, quad, render, seeds
from statistics_of_renders import assert_blocks, assert_spread, blocks

FULL = bool(os.environ.get("SLUICE_FULL"))
ALBEDO, SIZE, PASSES, BLOCK = 0.8, 32, 4, 4
SEEDS, PHOTONS = (16, 65536) if FULL else (12, 32768)

ENTRY = quad((-0.5, 0.1, 0), (0.3, 0, 0), (0, 0.3, 0))
AIM = (-0.85, -0.15, -0.25, 0.45)  # holds all light that ENTRY takes, whatever the lamp


def add_sun(scene, **more):
    """Adds the lamp; returns how the oracle sees it."""
    scene.sun((0.4, 0.2, -1), 3.0, name="Lamp", **more)
    return from_sun((0.4, 0.2, -1), 3.0)


def add_point(scene, **more):
    """Adds the lamp; returns how the oracle sees it."""
    scene.point((-0.9, 0.3, 0.8), 12.0, **more)
    return from_point((-0.9, 0.3, 0.8), 12.0)


def add_square(scene, **more):
    """Adds the lamp; returns how the oracle sees it."""
    scene.area((-0.3, -0.2, 0.7), (0, 0, -1), 12.0, shape="Square", size_x=0.4, **more)
    return from_square((-0.3, -0.2, 0.7), 0.4, 12.0)


LAMPS = {"sun": add_sun, "point": add_point, "square": add_square}


def floor_scene(lamp, **more):
    """An empty floor under one lamp, and how the oracle sees the lamp. The camera hangs below all lamps and gates in the air."""
    scene = Scene(size=SIZE)
    scene.floor(diffuse(ALBEDO), half=1.6)
    return scene, LAMPS[lamp](scene, **more)


def radii(result):
    """The radii of the density estimate, pass by pass."""
    return result.statistics["radius"][1] * (np.arange(PASSES) + 1.0) ** (-1 / 6)


def shadow(scene, towards_lamp):
    """Pixels of the floor wholly inside and wholly outside the shadows of all entries, for the light of a point or a sun."""
    edge = (np.arange(SIZE * 4 + 1) / (2 * SIZE) - 1) * scene.view
    x, y = np.meshgrid(edge, edge)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)
    hidden = np.zeros(x.size, bool)
    for edit in scene.description["edits"]:
        t, _ = Quad(edit["entry"]).cross(points, towards_lamp(points))
        hidden |= np.isfinite(t) & (t >= 0)
    hidden = hidden.reshape(x.shape)
    corners = np.stack([hidden[i : i + 4 * SIZE : 4, j : j + 4 * SIZE : 4] for i in range(5) for j in range(5)])
    return corners.all(0), ~corners.any(0)


def check(scene, light, aim=AIM, takes=None, color=(1, 1, 1), **settings):
    """Edited light is what the oracle says; direct light is gone inside the entries and untouched outside; nothing else is there. Returns what the
    oracle says, for the least widths."""
    settings = {"passes": PASSES, "photons": PHOTONS, "caustic_radius_factor": 1.0, **settings}
    got = seeds(scene, SEEDS, **settings)
    more = {"takes": takes} if takes else {}
    told = [ALBEDO / math.pi * expected_edited(scene, light, aim, radii(got.renders[0]) * wider, color=color, **more)
            for wider in sorted({1 / most_range(), most_range()})]  # fmt: skip
    assert told[0].max() > 0
    if len(told) == 1:
        assert_blocks(blocks(got.stack("Edited") @ LUMINANCE, BLOCK), blocks(told[0] @ LUMINANCE, BLOCK))
    else:
        assert_spread(got.stack("Edited") @ LUMINANCE, told[0] @ LUMINANCE, told[-1] @ LUMINANCE)
    assert not got.stack("Caustics").any() and not got.stack("Indirect").any() and not got.stack("Emission").any()
    return got, told[0]


def check_direct(scene, got, towards_lamp, **settings):
    """Direct light is gone inside the entries' shadows and as it was outside of all."""
    even = {"passes": PASSES, "photons": PHOTONS, "use_adaptive_sampling": False, **settings}  # the same samples with and without edits
    plain, edited = (render(scene, use_edits=edits, **even)["Direct"] for edits in (False, True))
    inside, outside = shadow(scene, towards_lamp)
    assert inside.sum() >= 9 and outside.sum() > 100
    assert (got.renders[0]["Direct"][inside] == 0).all() and (edited[inside] == 0).all()
    np.testing.assert_allclose(edited[outside], plain[outside], rtol=1e-5)


def upwards(lamp):
    """From points of the floor towards the lamp (to its middle: on the floor's own quads any direction up will do)."""
    if lamp == "sun":
        return lambda p: np.broadcast_to([-0.4, -0.2, 1.0], p.shape)
    return lambda p: np.array((-0.9, 0.3, 0.8) if lamp == "point" else (-0.3, -0.2, 0.7)) - p


def turned(angle, size, place):
    """A square exit on the floor, turned about its normal."""
    c, s = size * math.cos(angle), size * math.sin(angle)
    return exit_at(place, (c, s, 0), (-s, c, 0))


EXITS = {
    "moved": exit_at((0.45, -0.3, 0), (0.3, 0, 0), (0, 0.3, 0)),
    "rotated": turned(0.7, 0.3, (0.4, -0.2, 0)),
    "mirrored": exit_at((0.45, -0.3, 0), (-0.3, 0, 0), (0, 0.3, 0)),
    "skewed": exit_at((0.4, -0.2, 0), (0.35, 0.1, 0), (0.15, 0.3, 0)),
    "larger": exit_at((0.4, -0.2, 0), (0.5, 0, 0), (0, 0.45, 0)),
    "larger, flux kept": exit_at((0.4, -0.2, 0), (0.5, 0, 0), (0, 0.45, 0), keep_brightness=False),
    "smaller": exit_at((0.45, -0.3, 0), (0.2, 0, 0), (0, 0.25, 0)),
    "smaller, flux kept": exit_at((0.45, -0.3, 0), (0.2, 0, 0), (0, 0.25, 0), keep_brightness=False),
    "intensity": exit_at((0.45, -0.3, 0), (0.3, 0, 0), (0, 0.3, 0), intensity=2.5),
    "upside down": exit_at((0.45, -0.3, 0.5), (0.3, 0, 0), (0, 0.3, 0), (0, 0, 1)),
    "in the air, tilted": exit_at((0.2, -0.1, 0.4), (0.24, 0, 0.18), (0, 0.3, 0), (-0.6, 0, 0.8)),
    "in the air, mirrored": exit_at((0.3, -0.2, 0.4), (-0.24, 0, 0.18), (0, 0.3, 0), (0.6, 0, 0.8)),
}
