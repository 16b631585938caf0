# SPDX-License-Identifier: GPL-3.0-or-later
"""A Cornell box with a glass and a mirror sphere. The red wall's colour bleeding is dimmed; the amber caustic is copied twice, once in green."""

import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m

WIDE, HIGH = 1.4, 0.8  # half width and half height of the box; its half depth is 1
LAMP = (0.1, 0.0, HIGH)


def box():
    x, z, white = WIDE, HIGH, m.matte("White", (0.74, 0.72, 0.68))
    red, blue = m.matte("Red", (0.70, 0.035, 0.03)), m.matte("Blue", (0.10, 0.22, 0.50))
    m.quad("Floor", [(-x, -1, -z), (x, -1, -z), (x, 1, -z), (-x, 1, -z)], white)
    m.quad("Ceiling", [(-x, 1, z), (x, 1, z), (x, -1, z), (-x, -1, z)], white)
    m.quad("Back wall", [(-x, 1, -z), (x, 1, -z), (x, 1, z), (-x, 1, z)], white)
    m.quad("Red wall", [(-x, -1, -z), (-x, 1, -z), (-x, 1, z), (-x, -1, z)], red)
    m.quad("Blue wall", [(x, 1, -z), (x, -1, -z), (x, -1, z), (x, 1, z)], blue)


def lamp():
    """A square in a short black tube, so that it shines into the box alone."""
    x, y, z = LAMP
    half, drop = 0.12, 0.02
    m.quad("Lamp", [(x - half, y - half, z - drop), (x - half, y + half, z - drop), (x + half, y + half, z - drop), (x + half, y - half, z - drop)],
           m.lamp("Lamp light", (1.0, 0.88, 0.70), 62.0))  # fmt: skip
    m.box("Lamp housing", (2 * half + 0.03, 2 * half + 0.03, drop * 0.9), (x, y, z - drop * 0.45), m.matte("Black", (0.02, 0.02, 0.02)))


def edits():
    """One entry on the floor takes what the red wall sends there and gives back a fifth; another takes the caustic of the glass sphere
    and lays it down three times: where it was, on the back wall, and in green before the mirror sphere."""
    floor, wall = ((-WIDE / 2, 0, -HIGH), (0, 0, 1), (1, 0, 0), (WIDE, 2)), ((-WIDE / 2, 1, 0), (0, -1, 0), (1, 0, 0), (WIDE, 2 * HIGH))
    for where, place in (("floor", floor), ("back wall", wall)):
        bleeding = m.entry(f"Red on the {where}", "L.*D'Red wall'", *place)
        m.exit_of(bleeding, f"Less red on the {where}", *place, intensity=0.15)

    down, size = ((0, 0, 1), (1, 0, 0)), (0.66, 0.66)
    caustic = m.entry("Caustic", "LS'Glass sphere'+", (0.72, -0.25, -HIGH), *down, size)
    m.exit_of(caustic, "Caustic in its place", (0.72, -0.25, -HIGH), *down, size)
    m.exit_of(caustic, "Caustic on the back wall", (0.30, 1, 0.15), (0, -1, 0), (1, 0, 0), size)
    m.exit_of(caustic, "Caustic in green", (-0.08, -0.55, -HIGH), *down, size, hue_shift=math.radians(100))


scene = m.start()
box()
lamp()
m.sphere("Glass sphere", 0.30, (0.62, -0.25, -0.50), m.glass("Amber glass", (1.0, 0.56, 0.20)))
m.sphere("Mirror sphere", 0.36, (-0.62, 0.30, -0.44), m.mirror("Mirror"))
edits()
m.camera((0, -4.2, 0.25), (0, 0, 0.25), lens=41).data.shift_y = -0.085
scene.sluice.passes, scene.sluice.photons = 64, 60000
m.save(__file__)
