# SPDX-License-Identifier: GPL-3.0-or-later
"""A lantern behind a crystal ball. One square before the ball takes all that came through it, on its way to the table and on its way to
the eye alike, and sends it out again at the right, in another hue (paper, figure 8 and the limit its section 6.1 leaves)."""

import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

BALL = (-0.20, 0.0, 0.105)
LANTERN = (-0.20, 0.36, 0.22)


def lantern():
    """A glowing globe on a slender foot."""
    x, y, z = LANTERN
    glow = [(0.022 * math.sin(t), -0.022 * math.cos(t)) for t in (math.pi * i / 12 for i in range(13))]
    m.lathe("Lantern", [(0, -0.022), *glow[1:-1], (0, 0.022)], LANTERN, m.lamp("Glow", (1.0, 0.62, 0.28), 260.0), segments=24, levels=0)
    gilt = props.gilt()
    foot = [(0, 0), (0.04, 0), (0.042, 0.004), (0.012, 0.009), (0.004, 0.02), (0.004, z - 0.03), (0.012, z - 0.021), (0, z - 0.021)]
    m.lathe("Lantern foot", foot, (x, y, 0), gilt, levels=1)
    m.sphere("Ball", 0.09, BALL, m.glass("Crystal", (0.98, 0.98, 0.98)))
    props.ring("Ball ring", (BALL[0], BALL[1], 0.010), 0.040, 0.010, gilt)


def edits():
    place, size = ((BALL[0], -0.105, 0.125), (0, -1, 0), (1, 0, 0)), (0.34, 0.25)
    light = m.entry("Before the ball", "LS'Ball'+", *place, size)
    m.exit_of(light, "To the right, blue", (0.16, -0.105, 0.125), (0, -1, 0), (1, 0, 0), size, hue_shift=math.radians(180))


scene = m.start()
props.table(props.boards("Walnut", (0.55, 0.38, 0.26), (0.33, 0.21, 0.14), planks=3, roughness=0.5), wall=0.62, front=-1.0)
props.wall(props.plaster("Plaster", (0.20, 0.25, 0.31)), 0.62)
lantern()
m.world((0.5, 0.56, 0.65), 0.2)
m.light("Softbox", "AREA", (0.9, -1.3, 1.5), 20.0, (0.84, 0.92, 1.0), target=(0, 0.2, 0.1), shape="RECTANGLE", size=1.2, size_y=1.2)
edits()
m.camera((-0.02, -1.20, 0.42), (-0.02, 0.05, 0.085), lens=48, focus=(BALL[0], -0.06, 0.1), f_stop=8)
scene.sluice.passes, scene.sluice.photons = 64, 250000
m.save(__file__)
