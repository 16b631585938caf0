# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes whose pictures are wrong in ways of their own: noise of lamps, of gather segments, of photons; blur of caustics, of light that was
moved, of light in corners; nothing but glass. For tests and benchmarks of the error that a render tells of itself."""

import math

import numpy as np
from scenes import Scene, both, diffuse, emission, exit_at, glass, looking, mirror, quad, shader


def _camera(scene, place, at, angle=0.9):
    scene.perspective(looking(place, np.subtract(at, place), up=(0, 0, 1)), angle)


def _world(scene, nodes):
    scene.description["world"] = {"name": "World", "material": scene.material(nodes)}


def _room(size):
    """A box of 2 m with an open front (-y) and walls of three colours, looked into from there."""
    scene = Scene(size)
    white, red, green = diffuse(0.75), diffuse((0.75, 0.25, 0.25)), diffuse((0.25, 0.75, 0.25))
    a, b, c, d = (-1, -1), (1, -1), (1, 1), (-1, 1)
    at = {(p, z): (*p, z) for p in (a, b, c, d) for z in (0, 2)}
    scene.plane("Floor", [at[p, 0] for p in (a, b, c, d)], white)
    scene.plane("Ceiling", [at[p, 2] for p in (d, c, b, a)], white)
    scene.plane("Back", [at[d, 0], at[c, 0], at[c, 2], at[d, 2]], white)
    scene.plane("Left", [at[a, 0], at[d, 0], at[d, 2], at[a, 2]], red)
    scene.plane("Right", [at[c, 0], at[b, 0], at[b, 2], at[c, 2]], green)
    _camera(scene, (0, -3.4, 1), (0, 0, 1), 0.75)
    return scene


def matte_room(size):
    scene = _room(size)
    scene.box("Block", (-0.6, 0.1, 0), (-0.1, 0.6, 0.9), diffuse(0.6))
    scene.area((0, 0, 1.99), (0, 0, -1), 20, size_x=0.5, size_y=0.5, shape="Square")
    return scene


def room_with_spheres(size):
    scene = _room(size)
    scene.sphere("Glass", (0.45, -0.2, 0.4), 0.4, glass(1.5), 48)
    scene.sphere("Mirror", (-0.45, 0.3, 0.4), 0.4, mirror(0.9), 48)
    scene.area((0, 0, 1.99), (0, 0, -1), 20, size_x=0.5, size_y=0.5, shape="Square")
    return scene


def caustic(size):
    """A sharp caustic on a floor, seen from above."""
    scene = Scene(size)
    scene.floor(diffuse(0.7), 3)
    scene.sphere("Glass", (0, 0, 0.5), 0.4, glass(1.5), 48)
    scene.point((0.9, 0.4, 2.5), 60, radius=0.02)
    _camera(scene, (0, -2.5, 2.5), (0, 0, 0.2), 0.8)
    return scene


def moved_caustic(size):
    scene = caustic(size)
    scene.edit("LS+", quad((-0.3, -0.15, 0.001), (0.4, 0, 0), (0, 0.4, 0)),
               [exit_at((0.9, -0.5, 0.001), (0.4, 0, 0), (0, 0.4, 0))])  # fmt: skip
    return scene


def glass_alone(size):
    """Smooth and rough glass before a lit sky: no diffuse surface, no photon counts."""
    scene = Scene(size)
    scene.sphere("Clear", (-0.5, 0, 0.5), 0.45, glass(1.5), 48)
    scene.sphere("Frosted", (0.5, 0, 0.5), 0.45, [shader("BsdfGlass", (1, 1, 1), Roughness=0.3, IOR=1.45)], 48)
    _world(scene, [shader("Background", (0.6, 0.7, 0.9), Strength=1.0)])
    scene.area((0, 1.0, 2.5), (0, -0.3, -1), 60, size_x=0.8, size_y=0.8, shape="Square")
    _camera(scene, (0, -3, 1.2), (0, 0, 0.5), 0.7)
    return scene


def glass_block(size):
    """A lamp seen through a block of rough glass alone."""
    scene = Scene(size)
    scene.box("Block", (-0.8, -0.2, 0), (0.8, 0.2, 1.2), [shader("BsdfGlass", (0.9, 1, 0.9), Roughness=0.2, IOR=1.5)])
    scene.plane("Screen", [(-2, 1.5, -1), (2, 1.5, -1), (2, 1.5, 2.5), (-2, 1.5, 2.5)], emission((0.9, 0.7, 0.4), 0.5))
    _camera(scene, (0, -3, 0.6), (0, 0, 0.6), 0.7)
    return scene


def room_by_a_window(size):
    """A closed room lit by the sky and a sun through a window in its left wall."""
    scene = Scene(size)
    grey = diffuse(0.7)
    a, b, c, d = (-1, -2), (1, -2), (1, 1), (-1, 1)
    at = {(p, z): (*p, z) for p in (a, b, c, d) for z in (0, 2)}
    for name, corners in (("Floor", [at[p, 0] for p in (a, b, c, d)]), ("Ceiling", [at[p, 2] for p in (d, c, b, a)]),
                          ("Back", [at[d, 0], at[c, 0], at[c, 2], at[d, 2]]), ("Right", [at[c, 0], at[b, 0], at[b, 2], at[c, 2]]),
                          ("Front", [at[b, 0], at[a, 0], at[a, 2], at[b, 2]])):  # fmt: skip
        scene.plane(name, corners, grey)
    for name, low, high in (("Below", (-2, 0), (1, 0.8)), ("Above", (-2, 1.6), (1, 2)), ("Near", (-2, 0.8), (-0.5, 1.6)),
                            ("Far", (0.5, 0.8), (1, 1.6))):  # fmt: skip
        scene.plane(name, [(-1, y, z) for y, z in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))], grey)
    _world(scene, [shader("Background", (0.7, 0.8, 1), Strength=3.0)])
    scene.sun((0.8, 0.1, -0.6), 20, angle=0.01)
    _camera(scene, (0, -1.9, 1), (0, 0, 0.9), 1.2)
    return scene


def gloss_on_gloss(size):
    """Things of plastic and brushed metal on a wet floor under a sky with a lamp."""

    def gloss(color, roughness):
        return [{"kind": "BsdfGlossy", "name": "Gloss", "options": {"distribution": "GGX"},
                 "inputs": [{"name": "Color", "value": [*color, 1.0]}, {"name": "Roughness", "value": [roughness] * 4}]}]  # fmt: skip

    scene = Scene(size)
    scene.floor(both(diffuse(0.25), gloss((0.3, 0.3, 0.3), 0.15)), 4)
    scene.sphere("Paint", (-0.5, 0, 0.45), 0.45, both(diffuse((0.5, 0.05, 0.05)), gloss((0.2, 0.2, 0.2), 0.2)), 48)
    scene.sphere("Metal", (0.5, 0, 0.45), 0.45, gloss((0.8, 0.8, 0.75), 0.35), 48)
    _world(scene, [shader("Background", (0.4, 0.5, 0.7), Strength=0.7)])
    scene.area((1, -1, 3), (-0.3, 0.3, -1), 120, size_x=0.6, size_y=0.6, shape="Square")
    _camera(scene, (0, -3, 1.3), (0, 0, 0.4), 0.7)
    return scene


def many_lamps(size):
    scene = Scene(size)
    scene.floor(diffuse(0.6), 4)
    scene.box("Block", (-0.5, -0.5, 0), (0.5, 0.5, 0.8), diffuse(0.5))
    for i in range(60):
        angle, far = 2.4 * i, 0.35 * math.sqrt(i + 4)
        scene.point((far * math.cos(angle), far * math.sin(angle), 1.2), 2 + i % 7, name=f"Lamp {i}", radius=0.02)
    _camera(scene, (0, -4, 3), (0, 0, 0.3), 0.9)
    return scene


SCENES = (matte_room, room_with_spheres, caustic, moved_caustic, glass_alone, glass_block, room_by_a_window, gloss_on_gloss, many_lamps)
