# SPDX-License-Identifier: GPL-3.0-or-later
"""A white sculpture beside a sunlit green wall. What the wall sheds on it turns from green to red; the wall itself stays as it is
(paper, figure 6)."""

import math
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

LEFT, BACK = -0.62, 0.75


def knot():
    """A trefoil, upright on a plinth."""
    points = []
    for t in np.linspace(0, 2 * math.pi, 96, endpoint=False):
        x, z, y = math.sin(t) + 2 * math.sin(2 * t), math.cos(t) - 2 * math.cos(2 * t), -math.sin(3 * t)
        points.append((0.080 * x, 0.075 * y, 0.080 * z))
    props.tube("Sculpture", points, 0.052, (0, 0, 0.625), m.glossy("Marble", (0.80, 0.79, 0.77), 0.4))
    m.box("Plinth", (0.30, 0.26, 0.36), (0, 0, 0.18), m.matte("Plinth", (0.72, 0.71, 0.69)), 0.006)


def room():
    white = m.matte("White", (0.74, 0.73, 0.71))
    m.quad("Floor", [(LEFT, -3, 0), (3, -3, 0), (3, BACK, 0), (LEFT, BACK, 0)], props.boards("Ash", (0.84, 0.76, 0.66), (0.70, 0.60, 0.48), planks=4))
    m.quad("Back wall", [(LEFT, BACK, 0), (3, BACK, 0), (3, BACK, 3), (LEFT, BACK, 3)], white)
    m.quad("Green wall", [(LEFT, -3, 0), (LEFT, BACK, 0), (LEFT, BACK, 3), (LEFT, -3, 3)], m.matte("Green paint", (0.06, 0.46, 0.10)))


def edits():
    """Entry and exit are one upright square between wall and sculpture; it only turns the hue."""
    square = ((-0.35, 0.17, 1.0), (1, 0, 0), (0, 1, 0), (1.16, 2.0))
    light = m.entry("Green on the sculpture", "L.*D'Green wall'", *square, feather=0.3)
    m.exit_of(light, "Red instead", *square, hue_shift=math.radians(-125))


scene = m.start()
room()
knot()
m.world((0.7, 0.78, 0.9), 0.16)
m.light("Sun", "SPOT", (1.5, -1.3, 1.9), 420.0, (1.0, 0.93, 0.82), target=(LEFT, 0.0, 0.6), shadow_soft_size=0.03,
        spot_size=math.radians(32), spot_blend=0.15)  # fmt: skip
m.light("Sky", "AREA", (1.2, -2.2, 2.2), 24.0, (0.84, 0.92, 1.0), target=(0, 0.2, 0.4), shape="RECTANGLE", size=1.6, size_y=1.6)
edits()
m.camera((0.06, -2.25, 0.78), (-0.02, 0.1, 0.50), lens=44)
scene.sluice.passes, scene.sluice.photons = 64, 600000
m.save(__file__)
