# SPDX-License-Identifier: GPL-3.0-or-later
"""The caustic of a glass drop laid twice on the wall, 1.8 times as large: left with the energy it had, so darker; right with Keep
Brightness (paper, figure 3)."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

WALL_Y = 0.46
DROP = [(0, 0), (0.030, 0.0), (0.055, 0.010), (0.068, 0.035), (0.070, 0.060), (0.060, 0.092), (0.040, 0.128), (0.020, 0.162), (0.008, 0.190),
        (0.003, 0.205), (0, 0.212)]  # fmt: skip


def edits():
    size = (0.30, 0.24)
    caustic = m.entry("Caustic", "LS'Drop'+", (0.16, 0.04, 0), (0, 0, 1), (1, 0, 0), size, feather=0.2)
    large = tuple(1.8 * side for side in size)
    m.exit_of(caustic, "Larger, as much light", (-0.27, WALL_Y, 0.38), (0, -1, 0), (1, 0, 0), large, keep_brightness=False)
    m.exit_of(caustic, "Larger, as bright", (0.27, WALL_Y, 0.38), (0, -1, 0), (1, 0, 0), large)


scene = m.start()
props.sweep("Paper", m.matte("Paper", (0.25, 0.23, 0.215)), wall=WALL_Y, radius=0.08)
m.lathe("Drop", DROP, (-0.02, 0.0, 0.0005), m.glass("Aqua", (0.62, 0.95, 0.93)), segments=40, levels=3)
m.world((0.6, 0.65, 0.7), 0.25)
m.light("Lamp", "POINT", (-0.52, -0.12, 0.28), 16.0, (1.0, 0.93, 0.84), shadow_soft_size=0.005)
m.light("Softbox", "AREA", (0.9, -1.3, 1.4), 22.0, (0.84, 0.92, 1.0), target=(0, 0.2, 0.1), shape="RECTANGLE", size=1.0, size_y=1.0)
edits()
m.camera((0.0, -1.18, 0.40), (0.0, 0.2, 0.215), lens=46, focus=(0, -0.05, 0.1), f_stop=8)
scene.sluice.passes, scene.sluice.photons = 64, 250000
m.save(__file__)
