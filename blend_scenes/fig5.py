# SPDX-License-Identifier: GPL-3.0-or-later
"""Three pieces of coloured glass lit from behind. The caustic of the first is taken away, that of the second moved to the wall, that of
the third is in its place and copied twice (paper, figure 5)."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

WALL_Y = 0.62
PLACES = (-0.30, 0.0, 0.30)


def pieces():
    pewter = props.pewter()
    m.sphere("Globe", 0.066, (PLACES[0], 0, 0.078), m.glass("Blue glass", (0.34, 0.62, 0.98)))
    props.ring("Globe ring", (PLACES[0], 0, 0.008), 0.036, 0.008, pewter)
    props.blossom("Blossom", 0.066, (PLACES[1], 0, 0.078), m.glass("Amber glass", (1.0, 0.62, 0.22)))
    props.ring("Blossom ring", (PLACES[1], 0, 0.008), 0.036, 0.008, pewter)
    m.lathe("Pear", props.egg_profile(0.062, 0.165), (PLACES[2], 0, 0.012), m.glass("Rose glass", (0.98, 0.40, 0.46)), segments=32, levels=3)
    props.ring("Pear ring", (PLACES[2], 0, 0.008), 0.028, 0.008, pewter)


def edits():
    down, size = ((0, 0, 1), (1, 0, 0)), (0.26, 0.30)
    wall = ((0, -1, 0), (1, 0, 0))
    spots = [(x * 1.22, -0.16, 0) for x in PLACES]
    m.entry("Blue caustic", "LS'Globe'+", spots[0], *down, size)
    amber = m.entry("Amber caustic", "LS'Blossom'+", (0, -0.08, 0), *down, (0.22, 0.14))
    m.exit_of(amber, "On the wall", (0, WALL_Y, 0.21), *wall, (0.33, 0.21))
    rose = m.entry("Rose caustic", "LS'Pear'+", spots[2], *down, size)
    m.exit_of(rose, "In its place", spots[2], *down, size)
    m.exit_of(rose, "Larger on the wall", (0.37, WALL_Y, 0.20), *wall, (0.31, 0.36))


scene = m.start()
props.sweep("Paper", m.matte("Paper", (0.30, 0.28, 0.26)), wall=WALL_Y, radius=0.06)
pieces()
m.world((0.6, 0.62, 0.65), 0.22)
m.light("Lamp", "POINT", (0.0, 0.24, 0.42), 10.0, (1.0, 0.94, 0.86), shadow_soft_size=0.006)
m.light("Softbox", "AREA", (-1.0, -1.3, 1.5), 30.0, (0.84, 0.92, 1.0), target=(0, 0.2, 0.1), shape="RECTANGLE", size=1.2, size_y=1.2)
edits()
m.camera((0.0, -1.22, 0.46), (0.0, 0.05, 0.155), lens=46, focus=(0, -0.05, 0.08), f_stop=8)
scene.sluice.passes, scene.sluice.photons = 64, 250000
m.save(__file__)
