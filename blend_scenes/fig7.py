# SPDX-License-Identifier: GPL-3.0-or-later
"""The caustic of a glass egg, four times round it, each a quarter turn on and in another hue. The egg mirrors them all (paper, figure 7)."""

import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

SIZE = (0.22, 0.20)
EXITS = (("In its place, amber", 0, 1), ("Behind, green", 90, 0.75), ("Left, blue", 180, 0.75), ("In front, rose", -70, 1))  # hue in degrees, scale
FIRST = -40  # degrees: where the lamp throws the caustic


def edits():
    """The exits lie round the egg: one where the entry is, the others a little farther away."""

    def place(turn, away, scale=1):
        a = math.radians(FIRST + turn)
        along = (math.cos(a), math.sin(a), 0)
        return (away * along[0], away * along[1], 0), (0, 0, 1), along, (scale * SIZE[0], scale * SIZE[1])

    caustic = m.entry("Caustic", "L.*S'Egg'S'Egg'", *place(0, 0.13))
    for i, (name, hue, scale) in enumerate(EXITS):
        m.exit_of(caustic, name, *place(90 * i, 0.20 if i else 0.13, scale), hue_shift=math.radians(hue))


scene = m.start()
props.sweep("Table", m.matte("Linen", (0.22, 0.26, 0.29)), wall=1.1, radius=0.4)
props.egg("Egg", (0, 0, 0), 0.075, 0.19, m.glass("Amber glass", (1.0, 0.66, 0.26)), props.gilt())
m.world((0.6, 0.64, 0.7), 0.14)
m.light("Lamp", "POINT", (-0.42, 0.35, 0.52), 16.0, (1.0, 0.92, 0.80), shadow_soft_size=0.006)
m.light("Softbox", "AREA", (0.6, -1.2, 1.5), 14.0, (0.84, 0.92, 1.0), target=(0, 0, 0.1), shape="RECTANGLE", size=1.0, size_y=1.0)
edits()
m.camera((0.0, -0.86, 0.74), (0.0, 0.0, 0.045), lens=50, focus=(0, -0.05, 0.1), f_stop=8)
scene.sluice.passes, scene.sluice.photons = 64, 250000
m.save(__file__)
