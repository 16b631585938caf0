# SPDX-License-Identifier: GPL-3.0-or-later
"""The sun through a window into a room; the edit moves its patch along the floor to the feet of an armchair."""

import math
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import modelling as m

# The room: x from -2.6 (wall with the window) to 2.6, y from -4.5 (behind the camera) to 2.2, z from 0 to 2.7
X, FRONT, BACK, HEIGHT = 2.6, -4.5, 2.2, 2.7
WINDOW = (-0.75, 0.95, 0.75, 2.25)  # y0, y1, z0, z1 in the wall x = -X
WALL = 0.22                       # its thickness


def room():
    floor = m.glossy("Floor boards", m.wood("Boards", (0.78, 0.62, 0.45), (0.58, 0.41, 0.27), planks=6, seed=11), 0.5)
    paint, white = m.matte("Wall paint", (0.62, 0.63, 0.58)), m.matte("White paint", (0.78, 0.77, 0.74))
    m.quad("Floor", [(X, FRONT, 0), (X, BACK, 0), (-X, BACK, 0), (-X, FRONT, 0)], floor, uv_scale=1.1)
    m.quad("Ceiling", [(-X, FRONT, HEIGHT), (-X, BACK, HEIGHT), (X, BACK, HEIGHT), (X, FRONT, HEIGHT)], white)
    m.quad("Back wall", [(-X, BACK, 0), (X, BACK, 0), (X, BACK, HEIGHT), (-X, BACK, HEIGHT)], paint)
    m.quad("Front wall", [(X, FRONT, 0), (-X, FRONT, 0), (-X, FRONT, HEIGHT), (X, FRONT, HEIGHT)], paint)
    m.quad("Right wall", [(X, BACK, 0), (X, FRONT, 0), (X, FRONT, HEIGHT), (X, BACK, HEIGHT)], paint)
    y0, y1, z0, z1 = WINDOW
    x = -X - WALL / 2
    pieces = (("before", FRONT, y0, 0, HEIGHT), ("behind", y1, BACK, 0, HEIGHT), ("below", y0, y1, 0, z0), ("above", y0, y1, z1, HEIGHT))
    for name, a, b, c, d in pieces:
        m.box(f"Window wall {name}", (WALL, b - a, d - c), (x, (a + b) / 2, (c + d) / 2), paint)
    m.box("Skirting behind", (2 * X, 0.018, 0.09), (0, BACK - 0.009, 0.045), white, 0.004)
    for name, side in (("left", -1), ("right", 1)):
        m.box(f"Skirting {name}", (0.018, BACK - FRONT, 0.09), (side * (X - 0.009), (BACK + FRONT) / 2, 0.045), white, 0.004)
    window(white)


def window(white):
    """A frame with two by three open panes, and a sill."""
    y0, y1, z0, z1 = WINDOW
    x, thick = -X - WALL * 0.6, 0.05
    middle_y, middle_z = (y0 + y1) / 2, (z0 + z1) / 2
    for number, y in enumerate((y0 + thick / 2, middle_y, y1 - thick / 2)):
        m.box(f"Window post {number}", (0.06, thick, z1 - z0), (x, y, middle_z), white)
    for number, z in enumerate((z0 + thick / 2, z0 + (z1 - z0) / 3, z0 + 2 * (z1 - z0) / 3, z1 - thick / 2)):
        m.box(f"Window bar {number}", (0.05, y1 - y0, thick * 0.7), (x, middle_y, z), white)
    m.box("Sill", (WALL + 0.08, y1 - y0 + 0.14, 0.03), (-X - WALL / 2 + 0.06, middle_y, z0 - 0.005), white, 0.006)


def armchair(at, turn):
    cloth, legs = m.matte("Velvet", (0.08, 0.26, 0.25)), m.glossy("Walnut", (0.12, 0.06, 0.03), 0.35)
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))

    def part(name, size, place, material, bevel):
        x, y, z = place
        m.box(name, size, (at[0] + c * x - s * y, at[1] + s * x + c * y, z), material, bevel, turn)

    part("Seat base", (0.72, 0.70, 0.16), (0, 0, 0.25), cloth, 0.03)
    part("Seat cushion", (0.54, 0.60, 0.15), (0, -0.05, 0.405), cloth, 0.06)
    part("Back rest", (0.72, 0.17, 0.66), (0, 0.30, 0.52), cloth, 0.07)
    part("Left arm", (0.12, 0.64, 0.30), (-0.33, -0.02, 0.44), cloth, 0.05)
    part("Right arm", (0.12, 0.64, 0.30), (0.33, -0.02, 0.44), cloth, 0.05)
    for i, (x, y) in enumerate(((-0.3, -0.29), (0.3, -0.29), (-0.3, 0.29), (0.3, 0.29))):
        part(f"Leg {i}", (0.04, 0.04, 0.17), (x, y, 0.085), legs, 0.005)


def rug():
    """Diamonds in a border, woven."""
    rng = np.random.default_rng(5)
    v, u = np.meshgrid(np.linspace(-1, 1, 384), np.linspace(-1, 1, 384), indexing="ij")
    edge = np.maximum(abs(u), abs(v))[..., None]
    weave = 1 + 0.06 * rng.standard_normal((384, 384, 1)) + 0.05 * np.sin(u * 300)[..., None]
    ground, band = np.array((0.80, 0.74, 0.63)), np.array((0.55, 0.24, 0.17))
    diamonds = (np.abs((u * 4) % 2 - 1) + np.abs((v * 4) % 2 - 1) < 0.42)[..., None]
    pattern = np.where((edge > 0.86) & (edge < 0.93), band, np.where(diamonds & (edge < 0.8), band * 1.15, ground)) * weave
    m.box("Rug", (2.0, 1.5, 0.012), (0.95, -0.15, 0.006), m.matte("Rug back", (0.5, 0.45, 0.4)))
    corners = [(-0.05, -0.90, 0.0125), (1.95, -0.90, 0.0125), (1.95, 0.60, 0.0125), (-0.05, 0.60, 0.0125)]
    m.quad("Rug pile", corners, m.matte("Rug wool", m.image("Rug", pattern)), uv_scale=None)


def furniture():
    armchair((1.5, 0.98), -30)
    wood = m.bpy.data.materials["Walnut"]
    m.lathe("Table top", [(0, 0), (0.25, 0), (0.262, 0.008), (0.262, 0.022), (0.25, 0.03), (0, 0.03)], (0.55, 1.55, 0.50), wood, levels=1)
    foot = [(0, 0), (0.16, 0), (0.16, 0.015), (0.03, 0.03), (0.022, 0.25), (0.03, 0.47), (0.09, 0.50), (0, 0.50)]
    m.lathe("Table foot", foot, (0.55, 1.55, 0), wood, levels=1)
    vase = [(0, 0), (0.045, 0), (0.055, 0.01), (0.085, 0.09), (0.075, 0.17), (0.035, 0.23), (0.032, 0.27), (0.045, 0.30), (0.040, 0.298),
            (0.027, 0.265), (0.03, 0.23), (0.07, 0.165), (0.078, 0.09), (0.045, 0.012), (0, 0.01)]  # fmt: skip
    m.lathe("Vase", vase, (0.55, 1.55, 0.53), m.glossy("Vase glaze", (0.70, 0.36, 0.16), 0.18), segments=32)
    m.box("Picture frame", (0.92, 0.035, 0.68), (1.35, BACK - 0.018, 1.62), wood, 0.006)
    y = BACK - 0.037
    m.quad("Picture", [(0.94, y, 1.33), (1.76, y, 1.33), (1.76, y, 1.91), (0.94, y, 1.91)], m.matte("Painting", painting()), uv_scale=None)


def painting():
    """Hills under an evening sky."""
    v, u = np.meshgrid(np.linspace(0, 1, 192), np.linspace(0, 1, 256), indexing="ij")
    picture = np.array((0.95, 0.70, 0.42)) * (1 - v[..., None]) + np.array((0.30, 0.42, 0.60)) * v[..., None]
    picture = np.where((np.hypot((u - 0.68) * 1.35, v - 0.52) < 0.085)[..., None], (0.99, 0.90, 0.68), picture)
    for height, wave, color in ((0.46, 2.1, (0.44, 0.46, 0.52)), (0.34, 3.4, (0.30, 0.38, 0.36)), (0.18, 2.6, (0.16, 0.25, 0.20))):
        hill = height + 0.06 * np.sin(wave * 3 * u + 7 * height) + 0.025 * np.sin(wave * 8 * u)
        picture = np.where((v < hill)[..., None], color, picture)
    return m.image("Evening", picture)


def lights():
    m.world((0.50, 0.66, 0.95), 0.3)
    y0, y1, z0, z1 = WINDOW
    m.light("Sky", "AREA", (-X - WALL - 0.05, (y0 + y1) / 2, (z0 + z1) / 2), 80.0, (0.62, 0.78, 1.0), target=(0, (y0 + y1) / 2, (z0 + z1) / 2),
            shape="RECTANGLE", size=y1 - y0, size_y=z1 - z0)  # fmt: skip  # the sky as it fills the window: no photon misses the room
    m.light("Sun", "SUN", (-6, -0.5, 5), 3.5, (1.0, 0.86, 0.66), target=(-0.9, -0.75, 0), angle=math.radians(0.53))


def edits():
    """Only the sun's own light: the sky's stays where it falls."""
    patch = m.entry("Sun patch", "L'Sun'", (-1.2, 0.02, 0), (0, 0, 1), (1, 0, 0), (2.0, 2.1), feather=0.03)
    m.exit_of(patch, "Sun patch on the rug", (1.0, -0.12, 0.0125), (0, 0, 1), (1, 0, 0), (2.0, 2.1))


scene = m.start()
room()
rug()
furniture()
lights()
edits()
m.camera((0.0, -3.55, 1.42), (0.12, 0.6, 0.80), lens=25)
scene.view_settings.exposure = 0.8
scene.sluice.passes, scene.sluice.photons = 64, 50000
m.save(__file__)
