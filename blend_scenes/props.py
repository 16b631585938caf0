# SPDX-License-Identifier: GPL-3.0-or-later
"""Things that stand in several scenes: a table before a wall, eggs, goblets, crystals, frames, books. Made of modelling.py alone."""

import math

import modelling as m
import numpy as np
from mathutils import Vector

# --- where things stand -------------------------------------------------------------------------------------------------------------


def sweep(name, material, wall, radius):
    """The paper of a photographer's table: a floor (z = 0) that bends up into a wall (y = wall)."""
    bend = [(wall - radius + radius * math.sin(a), radius - radius * math.cos(a)) for a in np.linspace(0, math.pi / 2, 17)]
    side = [(-3.0, 0.0), *bend, (wall, 2.5)]
    vertices = [(x, y, z) for y, z in side for x in (-3.5, 3.5)]
    faces = [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(side) - 1)]
    return m.mesh(name, vertices, faces, material, smooth=True)


def plaster(name, color, depth=0.003):
    """Matte, with the relief of a trowel."""
    relief = 0.5 + 0.11 * m.noise(np.random.default_rng(8), 256, 256, 6, 6, 5)
    return m.bump(m.matte(name, color), m.image(f"{name} relief", np.repeat(relief[..., None], 3, axis=2)), 0.3, depth)


def boards(name, light, dark, planks=4, roughness=0.45, relief=0.12):
    """Oiled wood; light and dark are display colours."""
    grain = m.wood(f"{name} grain", light, dark, planks, seed=3)
    return m.bump(m.glossy(name, grain, roughness), grain.copy(), relief, 0.0008)


def gilt():
    """Gold paint. Early passes show the highlights of true metals near a small lamp as sparks on the walls; nothing here is about them."""
    return m.glossy("Gilt", (0.42, 0.25, 0.07), 0.35)


def pewter():
    return m.glossy("Pewter", (0.30, 0.30, 0.31), 0.35)


def table(material, front=-0.75, wall=0.40, half_width=1.4, uv_scale=0.62):
    return m.quad("Table top", [(-half_width, front, 0), (half_width, front, 0), (half_width, wall, 0), (-half_width, wall, 0)], material, uv_scale)


def wall(material, y, half_width=1.8, top=1.8, uv_scale=0.7):
    return m.quad("Wall", [(-half_width, y, -0.1), (half_width, y, -0.1), (half_width, y, top), (-half_width, y, top)], material, uv_scale)


# --- glass --------------------------------------------------------------------------------------------------------------------------


def egg_profile(radius, height, count=22):
    """From the broad end (z = 0) to the narrow one: a circle stretched, narrower towards the top."""
    profile = []
    for i in range(count + 1):
        t = math.pi * i / count
        z = height * (1 - math.cos(t)) / 2
        profile.append((radius * math.sin(t) * (1 + 0.16 * math.cos(t)), z))
    profile[0], profile[-1] = (0, 0), (0, height)
    return profile


def egg(name, at, radius, height, glass, stand):
    """An egg that rests in a ring."""
    m.lathe(name, egg_profile(radius, height), (at[0], at[1], at[2] + 0.085 * height), glass, segments=32, levels=3)
    ring = [(radius * (0.385 + 0.10 * math.cos(a)), radius * (0.13 + 0.13 * math.sin(a))) for a in np.linspace(0, 2 * math.pi, 13)]
    m.lathe(f"{name} ring", ring, at, stand, levels=1)


def blossom(name, radius, at, glass, lobes=5, depth=0.13):
    """A ball with lobes round its axis."""
    arc = [math.pi * i / 16 for i in range(17)]
    profile = [(0, -radius), *[(radius * math.sin(t), -radius * math.cos(t)) for t in arc[1:-1]], (0, radius)]
    item = m.lathe(name, profile, at, glass, segments=60, levels=2)
    for vertex in item.data.vertices:
        x, y, z = vertex.co
        wide = math.hypot(x, y) / radius
        vertex.co = Vector((x, y, 0)) * (1 + depth * wide * wide * math.cos(lobes * math.atan2(y, x))) + Vector((0, 0, z))
    return item


BOWL = [(0.004, 0.042), (0.022, 0.046), (0.038, 0.061), (0.046, 0.085), (0.0455, 0.112), (0.041, 0.140), (0.037, 0.160)]


def goblet(name, at, glass, wine, fill=0.110):
    """A wine glass with a short stem, 16 cm high, and what is in it up to the height `fill`. The wine reaches a little into the glass: so rays
    refract at its rim as they do at wine behind glass."""
    inner = [(max(r - 0.0016, 0), z + 0.0016) for r, z in BOWL]
    foot = [(0, 0), (0.033, 0), (0.035, 0.0012), (0.033, 0.003), (0.012, 0.0065), (0.005, 0.013), (0.0042, 0.024), (0.0050, 0.036), (0.014, 0.0405)]
    rim = [(0.0362, 0.1612)]
    body = m.lathe(name, foot + BOWL[2:] + rim + inner[:0:-1] + [(0, inner[0][1])], at, glass, segments=40, levels=2)
    radii, heights = [r - 0.0006 for r, _ in BOWL], [z + 0.0008 for _, z in BOWL]
    zs = np.linspace(heights[0], fill, 9)
    side = [(float(np.interp(z, heights, radii)), float(z)) for z in zs]
    profile = [(0, heights[0] - 0.0002), *side[1:], (side[-1][0] - 0.0004, fill + 0.0004), (0, fill + 0.0004)]
    drink = m.lathe(f"{name} wine", profile, at, wine, segments=40, levels=2)
    return [body, drink]


# --- furniture of a still life ------------------------------------------------------------------------------------------------------


def ring(name, at, radius, thick, material, tilt=0.0):
    """A torus about Z, tilted about X by degrees."""
    circle = [(radius + thick * math.cos(a), thick * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 13)]
    item = m.lathe(name, circle, at, material, segments=64, levels=1)
    item.rotation_euler = (math.radians(tilt), 0, 0)
    return item


def lens_on_foot(at, towards, material, size, stem, **faces):
    """A biconvex lens in a gilt ring on a foot, turned towards a lamp. `size`: its radius, half the thickness of its rim, how much
    more it has in the middle, and the ring's thickness; `stem`: height of the foot;
    `faces`: of the lathe. Returns the glass."""
    radius, edge, bulge, thick = size
    side = [(radius * t, bulge * (1 - t * t)) for t in np.linspace(0, 1, 25)]
    profile = [(0, -bulge - edge), *[(r, -z - edge) for r, z in side[1:]], *[(r, z + edge) for r, z in side[:0:-1]], (0, bulge + edge)]
    glass, metal = m.lathe("Lens", profile, at, material, **faces), gilt()
    for part in (glass, ring("Lens ring", at, radius + 0.004, thick, metal)):
        part.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    foot = [(0, 0), (0.045, 0), (0.047, 0.003), (0.044, 0.006), (0.008, 0.010), (0.0045, 0.02), (0.0045, stem), (0, stem)]
    m.lathe("Foot", foot, (*at[:2], 0), metal, levels=1)
    return glass


def tube(name, points, thick, at, material):
    """A closed tube along points: its section is carried along without twist and the rest of the turn spread evenly."""
    points = [Vector(p) for p in points]
    count, sides = len(points), 12
    tangents = [(points[(i + 1) % count] - points[i - 1]).normalized() for i in range(count)]
    normal = tangents[0].orthogonal().normalized()
    frames = []
    for t in [*tangents, tangents[0]]:
        normal = (normal - normal.dot(t) * t).normalized()
        frames.append((normal, t.cross(normal)))
    rest = math.atan2(frames[0][1].dot(frames[-1][0]), frames[0][0].dot(frames[-1][0]))
    vertices = []
    for i, (point, (a, b)) in enumerate(zip(points, frames, strict=False)):
        turned = [2 * math.pi * s / sides - rest * i / count for s in range(sides)]
        vertices += [point + thick * (math.cos(s) * a + math.sin(s) * b) for s in turned]
    faces = [(i * sides + s, i * sides + (s + 1) % sides, (i + 1) % count * sides + (s + 1) % sides, (i + 1) % count * sides + s)
             for i in range(count) for s in range(sides)]  # fmt: skip
    item = m.mesh(name, vertices, faces, material, smooth=True)
    item.location = at
    m.subdivide(item, 2)
    return item


def book(name, size, at, turn, cloth, pages):
    """A closed book lying on its back at `at` (the centre of its lower cover), its spine towards -Y."""
    (width, depth, thick), (x, y, z) = size, (at[0], at[1], at[2] + size[2] / 2)
    m.box(f"{name}: pages", (width - 0.012, depth - 0.012, thick - 0.006), (x, y, z), pages, turn=turn)
    for label, side in (("lower cover", -1), ("upper cover", 1)):
        m.box(f"{name}: {label}", (width, depth, 0.0035), (x, y, z + side * (thick / 2 - 0.00175)), cloth, 0.001, turn)
    angle, back = math.radians(turn), 0.002 - depth / 2
    m.box(f"{name}: spine", (width, 0.004, thick), (x - math.sin(angle) * back, y + math.cos(angle) * back, z), cloth, 0.0015, turn)


FRAME_FRONT = 0.0125  # how far a framed surface stands before its wall


def framed(name, centre, size, picture, frame, rail=0.028):
    """A framed surface on a wall that faces -Y; `centre` lies on the wall."""
    (x, y, z), (width, height), depth = centre, size, 0.022
    front = y - FRAME_FRONT
    m.quad(name, [(x - width / 2, front, z - height / 2), (x + width / 2, front, z - height / 2), (x + width / 2, front, z + height / 2),
                  (x - width / 2, front, z + height / 2)], picture, uv_scale=None)  # fmt: skip
    for label, size, dx, dz in (("left", (rail, depth, height + 2 * rail), -1, 0), ("right", (rail, depth, height + 2 * rail), 1, 0),
                                ("below", (width, depth, rail), 0, -1), ("above", (width, depth, rail), 0, 1)):  # fmt: skip
        place = (x + dx * (width + rail) / 2, y - depth / 2, z + dz * (height + rail) / 2)
        m.box(f"{name} frame {label}", size, place, frame, 0.003)
