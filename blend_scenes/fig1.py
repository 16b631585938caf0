# SPDX-License-Identifier: GPL-3.0-or-later
"""Two goblets before a mirror. The caustics of the wine go from the table to the wall, larger; the mirror's reflection is re-aimed at the
goblets, which it did not show (paper, figure 1)."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

WALL_Y = 0.42
MIRROR, MIRROR_SIZE = (-0.30, WALL_Y, 0.31), (0.25, 0.31)


def room():
    props.table(props.boards("Walnut", (0.55, 0.38, 0.26), (0.33, 0.21, 0.14), planks=3, roughness=0.9, relief=0.05), wall=WALL_Y)
    props.wall(props.plaster("Plaster", (0.30, 0.36, 0.33)), WALL_Y)
    far = m.matte("Far wall", (0.50, 0.36, 0.26))
    m.quad("Wall behind the camera", [(3, -2.6, -0.8), (-3, -2.6, -0.8), (-3, -2.6, 2.2), (3, -2.6, 2.2)], far)


def still_life():
    clear = m.glass("Crystal", (0.97, 0.98, 0.98))
    wines = []
    rose, white = ("Goblet", (0.06, 0.04, 0), (1.0, 0.50, 0.46), 0.110), ("Second goblet", (0.20, 0.10, 0), (1.0, 0.86, 0.44), 0.104)
    for name, at, colour, fill in (rose, white):
        wines += props.goblet(name, at, clear, m.glass(f"{name} wine", colour, ior=1.34), fill)
    m.collect("Wine", wines[1::2])
    props.framed("Mirror", MIRROR, MIRROR_SIZE, m.mirror("Silver", (0.92, 0.93, 0.92)), props.gilt())
    peel = m.glossy("Peel", (0.90, 0.33, 0.02), 0.4)
    for name, x, y, r in (("Orange", -0.22, 0.10, 0.040), ("Second orange", -0.145, 0.165, 0.038)):
        m.sphere(name, r, (x, y, r), peel)


def lights():
    m.world((0.50, 0.52, 0.55), 0.22)
    m.light("Lamp", "POINT", (-0.34, -0.12, 0.50), 18.0, (1.0, 0.86, 0.66), shadow_soft_size=0.006)
    m.light("Window", "AREA", (1.2, -1.3, 1.5), 26.0, (0.80, 0.88, 1.0), target=(0, 0.2, 0.1), shape="RECTANGLE", size=1.2, size_y=1.2)


def edits():
    caustic = m.entry("Wine's caustics", "LS*S'Wine'S*", (0.22, 0.12, 0), (0, 0, 1), (1, 0, 0), (0.36, 0.26))
    m.exit_of(caustic, "Caustics on the wall", (0.16, WALL_Y, 0.32), (0, -1, 0), (1, 0, 0), (0.48, 0.35), intensity=2.0)
    x, y, z = MIRROR
    sight = m.entry("Reflection", "S'Mirror'E", (x, y - props.FRAME_FRONT, z), (0, -1, 0), (1, 0, 0), MIRROR_SIZE)
    m.exit_of(sight, "Sight of the goblets", (x - 0.02, y - 0.16, z), m.aim(80, -22), m.aim(170, 0), MIRROR_SIZE)


scene = m.start()
room()
still_life()
lights()
edits()
m.camera((0.0, -1.02, 0.36), (-0.03, 0.14, 0.165), lens=46, focus=(0.06, 0.0, 0.1), f_stop=8)
scene.sluice.passes, scene.sluice.photons = 64, 250000
m.save(__file__)
