# SPDX-License-Identifier: GPL-3.0-or-later
"""A caustic drawn on a wall in front of the eye. A lens with five lobes throws a star low on the wall; two squares that hang in the air
between eye and wall take it up into a frame. The eye looks at the wall through both of them (the limit of the paper's section 6.1)."""

import math
import os
import sys

from mathutils import Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m
import props

WALL_Y = 0.42
LENS, LAMP = Vector((-0.24, -0.08, 0.145)), Vector((-0.62, -0.66, 0.205))
BEAM = (LENS - LAMP).normalized()
FRAME = (0.17, WALL_Y, 0.36)
IN_THE_AIR = 0.30  # y of both squares


def lens():
    """With lobes."""
    radius, lobes = 0.072, 5
    amber = m.glass("Amber", (1.0, 0.80, 0.48))
    glass = props.lens_on_foot(LENS, BEAM, amber, (radius, 0.004, 0.0065, 0.0055), stem=0.072, segments=160, levels=1)
    for vertex in glass.data.vertices:
        x, y, z = vertex.co
        wide, turn = math.hypot(x, y) / radius, math.atan2(y, x) + math.pi / 10  # a tip upwards
        vertex.co.z = z * (1 + 0.22 * wide**3 * math.cos(lobes * turn))


def edits():
    """Both squares face the eye; where the beam meets the first one it leaves the second one as obliquely."""
    here = LENS + BEAM * ((IN_THE_AIR - LENS.y) / BEAM.y)
    slant = BEAM * ((WALL_Y - IN_THE_AIR) / BEAM.y)
    star = m.entry("Before the wall", "L'Lamp'S'Lens'+", here, (0, -1, 0), (1, 0, 0), (0.18, 0.18))
    m.exit_of(star, "Before the frame", Vector(FRAME) - slant, (0, -1, 0), (1, 0, 0), (0.30, 0.30))


scene = m.start()
props.table(props.boards("Walnut", (0.55, 0.38, 0.26), (0.33, 0.21, 0.14), planks=3, roughness=0.6, relief=0.05), wall=WALL_Y, front=-1.0)
props.wall(props.plaster("Plaster", (0.24, 0.27, 0.30)), WALL_Y)
lens()
props.framed("Canvas", FRAME, (0.34, 0.27), m.matte("Linen", (0.34, 0.33, 0.31)), m.glossy("Black wood", (0.03, 0.03, 0.032), 0.35), rail=0.016)
m.world((0.5, 0.56, 0.65), 0.2)
m.light("Lamp", "POINT", LAMP, 16.0, (1.0, 0.90, 0.75), shadow_soft_size=0.005)
m.light("Softbox", "AREA", (0.9, -1.3, 1.5), 14.0, (0.84, 0.92, 1.0), target=(0, 0.2, 0.1), shape="RECTANGLE", size=1.2, size_y=1.2)
edits()
m.camera((0.0, -1.38, 0.40), (0.0, 0.2, 0.235), lens=50, focus=(0, 0.1, 0.2), f_stop=8)
scene.sluice.passes, scene.sluice.photons = 64, 250000
m.save(__file__)
