# SPDX-License-Identifier: GPL-3.0-or-later
"""A glass egg on a table by a wall, a small lamp beside it; the edit moves its caustic from the table to the wall (paper, figure 1)."""

import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

WALL_Y = 0.40
EGG = (-0.14, 0.02, 0)


def room():
    props.table(props.boards("Oak", (0.80, 0.64, 0.46), (0.60, 0.43, 0.27)), half_width=1.3, wall=WALL_Y)
    props.wall(props.plaster("Plaster", (0.62, 0.60, 0.56)), WALL_Y)


def still_life():
    props.egg("Egg", EGG, 0.078, 0.200, m.glass("Egg glass", (1.0, 0.88, 0.68)), props.gilt())
    pages = m.matte("Pages", (0.76, 0.71, 0.60))
    props.book("Blue book", (0.27, 0.19, 0.034), (0.30, 0.22, 0), 8, m.glossy("Blue cloth", (0.045, 0.10, 0.13), 0.6), pages)
    props.book("Red book", (0.24, 0.17, 0.028), (0.30, 0.22, 0.034), -6, m.glossy("Red cloth", (0.36, 0.055, 0.04), 0.6), pages)

    cup = [(0, 0), (0.022, 0), (0.025, 0.003), (0.036, 0.03), (0.040, 0.062), (0.0415, 0.066), (0.039, 0.066), (0.036, 0.055),
           (0.031, 0.03), (0.02, 0.008), (0, 0.006)]  # fmt: skip
    m.lathe("Cup", cup, (0.285, 0.21, 0.062), m.glossy("Glaze", (0.70, 0.72, 0.70), 0.15), levels=2)
    lemon = [(0, 0), (0.006, 0.002), (0.012, 0.009), (0.025, 0.022), (0.0285, 0.042), (0.025, 0.062), (0.012, 0.075), (0.006, 0.081), (0, 0.083)]
    fruit = m.lathe("Lemon", lemon, (0.165, 0.015, 0.0275), m.glossy("Peel", (0.86, 0.60, 0.04), 0.35), segments=32)
    fruit.rotation_euler = (math.radians(90), 0, math.radians(62))


def lights():
    m.world((0.45, 0.52, 0.62), 0.14)
    m.light("Lamp", "POINT", (-0.56, -0.14, 0.46), 14.0, (1.0, 0.80, 0.54), shadow_soft_size=0.006)
    m.light("Window", "AREA", (-0.9, -1.5, 1.3), 18.0, (0.66, 0.80, 1.0), target=(0, 0.1, 0.1), shape="RECTANGLE", size=0.8, size_y=1.1)


def edits():
    """Light that came to the table from the lamp through glass alone goes to the wall, where it keeps its brightness."""
    caustic = m.entry("Caustic", "LS+", (0.03, 0.09, 0), (0, 0, 1), (1, 0, 0), (0.34, 0.27), feather=0.4)
    m.exit_of(caustic, "Caustic on the wall", (0.10, WALL_Y, 0.235), (0, -1, 0), (1, 0, 0), (0.44, 0.35))


scene = m.start()
room()
still_life()
lights()
edits()
m.camera((0.07, -1.22, 0.42), (0.05, 0.12, 0.125), lens=50, focus=(EGG[0], EGG[1] - 0.05, 0.09), f_stop=5.6)
scene.sluice.passes, scene.sluice.photons = 64, 250000
m.save(__file__)
