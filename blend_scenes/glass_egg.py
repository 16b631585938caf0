# SPDX-License-Identifier: GPL-3.0-or-later
"""A glass egg on a table by a wall, a small lamp beside it; the edit moves its caustic from the table to the wall (paper, figure 1)."""

import math
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m

WALL_Y = 0.40
EGG = (-0.14, 0.02, 0.017)


def egg_profile(radius, height, count=22):
    """From the broad end (z = 0) to the narrow one: a circle stretched, narrower towards the top."""
    profile = []
    for i in range(count + 1):
        t = math.pi * i / count
        z = height * (1 - math.cos(t)) / 2
        profile.append((radius * math.sin(t) * (1 + 0.16 * math.cos(t)), z))
    profile[0], profile[-1] = (0, 0), (0, height)
    return profile


def room():
    oak = m.wood("Oak", (0.80, 0.64, 0.46), (0.60, 0.43, 0.27), planks=4, seed=3)
    table = m.glossy("Table", oak, 0.45)
    m.bump(table, oak.copy(), 0.12, 0.0008)
    m.quad("Table top", [(-1.3, -0.75, 0), (1.3, -0.75, 0), (1.3, WALL_Y, 0), (-1.3, WALL_Y, 0)], table, uv_scale=0.62)
    rng = np.random.default_rng(8)
    relief = 0.5 + 0.11 * m.noise(rng, 256, 256, 6, 6, 5)
    plaster = m.matte("Plaster", (0.62, 0.60, 0.56))
    m.bump(plaster, m.image("Plaster relief", np.repeat(relief[..., None], 3, axis=2)), 0.3, 0.003)
    m.quad("Wall", [(-1.6, WALL_Y, -0.1), (1.6, WALL_Y, -0.1), (1.6, WALL_Y, 1.6), (-1.6, WALL_Y, 1.6)], plaster, uv_scale=0.7)


def book(name, size, height, turn, cloth, pages):
    """A closed book lying on its back at the height, its spine towards the camera."""
    (width, depth, thick), (x, y, z) = size, (0.30, 0.22, height + size[2] / 2)
    m.box(f"{name}: pages", (width - 0.012, depth - 0.012, thick - 0.006), (x, y, z), pages, turn=turn)
    for label, side in (("lower cover", -1), ("upper cover", 1)):
        m.box(f"{name}: {label}", (width, depth, 0.0035), (x, y, z + side * (thick / 2 - 0.00175)), cloth, 0.001, turn)
    angle, back = math.radians(turn), 0.002 - depth / 2
    m.box(f"{name}: spine", (width, 0.004, thick), (x - math.sin(angle) * back, y + math.cos(angle) * back, z), cloth, 0.0015, turn)


def still_life():
    m.lathe("Egg", egg_profile(0.078, 0.200), EGG, m.glass("Egg glass", (1.0, 0.88, 0.68)), segments=32, levels=3)
    ring = [(0.030 + 0.008 * math.cos(a), 0.010 + 0.010 * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 13)]
    m.lathe("Egg ring", ring, (EGG[0], EGG[1], 0.0), m.mirror("Brass", (0.85, 0.60, 0.26), roughness=0.22), levels=1)

    pages = m.matte("Pages", (0.76, 0.71, 0.60))
    book("Blue book", (0.27, 0.19, 0.034), 0.0, 8, m.glossy("Blue cloth", (0.045, 0.10, 0.13), 0.6), pages)
    book("Red book", (0.24, 0.17, 0.028), 0.034, -6, m.glossy("Red cloth", (0.36, 0.055, 0.04), 0.6), pages)

    cup = [(0, 0), (0.022, 0), (0.025, 0.003), (0.036, 0.03), (0.040, 0.062), (0.0415, 0.066), (0.039, 0.066), (0.036, 0.055),
           (0.031, 0.03), (0.02, 0.008), (0, 0.006)]  # fmt: skip
    m.lathe("Cup", cup, (0.285, 0.21, 0.062), m.glossy("Glaze", (0.70, 0.72, 0.70), 0.15), levels=2)
    lemon = [(0, 0), (0.006, 0.002), (0.012, 0.009), (0.025, 0.022), (0.0285, 0.042), (0.025, 0.062), (0.012, 0.075), (0.006, 0.081), (0, 0.083)]
    fruit = m.lathe("Lemon", lemon, (0.165, 0.015, 0.0275), m.glossy("Peel", (0.86, 0.60, 0.04), 0.35), segments=32)
    fruit.rotation_euler = (math.radians(90), 0, math.radians(62))


def lights():
    m.world((0.20, 0.26, 0.36), 0.10)
    m.light("Lamp", "SPOT", (-0.56, -0.14, 0.46), 20.0, (1.0, 0.80, 0.54), target=(-0.10, 0.03, 0.06), shadow_soft_size=0.006,
            spot_size=math.radians(46), spot_blend=0.5)  # fmt: skip
    m.light("Window", "AREA", (-0.9, -1.5, 1.3), 12.0, (0.66, 0.80, 1.0), target=(0, 0.1, 0.1), shape="RECTANGLE", size=0.8, size_y=1.1)


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
scene.sluice.passes, scene.sluice.photons = 64, 60000
m.save(__file__)
