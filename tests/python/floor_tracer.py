# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lone floor (z = 0) must receive through light edits: an oracle that shares nothing with the core. It sends the light of one
lamp towards a rectangle of the floor along a low-discrepancy sequence, moves it through gates by the rules of design sections 2 and 4,
and adds up where it lands, blurred by the round kernel of the photon density estimate. Its own error is below 1 % of a block of few paths."""

import colorsys

import numpy as np
from scenes import LUMINANCE

LIFT = 1e-5  # how far quads float in front of their plane (the core: 2^-17 of their size)
PATHS = 1 << 21


def sequence(count, dimensions):
    """R_d of Roberts: multiples of the powers of 1 / the root of x^(d+1) = x + 1."""
    root = 2.0
    for _ in range(64):
        root = (1 + root) ** (1 / (dimensions + 1))
    return (0.5 + np.arange(1, count + 1)[:, None] * root ** -np.arange(1.0, dimensions + 1)) % 1.0


def turn_hue(color, angle):
    """H of design section 4: the HSV hexagon turned, the luminance kept."""
    h, s, v = colorsys.rgb_to_hsv(*color)
    turned = np.array(colorsys.hsv_to_rgb((h + angle / (2 * np.pi)) % 1.0, s, v))
    return turned * (LUMINANCE @ color) / (LUMINANCE @ turned)


def tinted(color, tint=(1, 1, 1)):
    """White keeps its luminance."""
    return color * np.array(tint) / (LUMINANCE @ tint)


class Quad:
    def __init__(self, description):
        m, half = description["matrix"], description["half_size"]
        self.edge_u, self.edge_v = 2 * half * m[:3, 0], 2 * half * m[:3, 1]
        across = np.cross(self.edge_u, self.edge_v)
        self.area = np.linalg.norm(across)
        self.t, n = self.edge_u / np.linalg.norm(self.edge_u), across / self.area
        self.n = n if n @ m[:3, 2] > 0 else -n
        mirrored = np.linalg.det(m[:3, :3]) < 0
        self.b = np.cross(self.n, self.t) * (-1 if mirrored else 1)
        self.corner = m[:3, 3] - (self.edge_u + self.edge_v) / 2 + self.n * LIFT
        self.solve = np.linalg.pinv(np.stack([self.edge_u, self.edge_v], 1))

    def cross(self, origin, direction):
        """t (inf: none), u, v."""
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.corner - origin) @ self.n / (direction @ self.n)
            uv = (origin + t[:, None] * direction - self.corner) @ self.solve.T
        return np.where(((uv >= 0) & (uv <= 1)).all(1), t, np.inf), uv

    def to_local(self, d):
        return np.stack([d @ self.t, d @ self.b, d @ self.n], 1)

    def to_world(self, d):
        return d[:, :1] * self.t + d[:, 1:2] * self.b + d[:, 2:] * self.n

    def point(self, uv):
        return self.corner + uv[:, :1] * self.edge_u + uv[:, 1:] * self.edge_v


# --- lamps: (points of origin, irradiance times area per path) for points of the floor -------------------------------------------------


def from_sun(direction, power):
    d = np.array(direction, float) / np.linalg.norm(direction)

    def light(points, _):
        return points - 100 * d, np.full(len(points), power * -d[2])

    return light


def from_point(place, power):
    def light(points, _):
        to = np.array(place, float) - points
        distance2 = (to**2).sum(1)
        return points + to, power / (4 * np.pi) * to[:, 2] / distance2**1.5

    return light


def from_square(place, size, power):
    """A square area lamp that looks down; P / 4 W/sr along its axis."""

    def light(points, samples):
        spot = np.array(place, float) + np.pad((samples - 0.5) * size, ((0, 0), (0, 1)))
        to = spot - points
        distance2 = (to**2).sum(1)
        return spot, power / 4 * to[:, 2] ** 2 / distance2**2

    return light


# --- the walk -------------------------------------------------------------------------------------------------------------------------


def soft_border(x, width):
    s = np.clip((1 - np.abs(2 * x - 1)) / width, 0, 1)
    return s * s * (3 - 2 * s)


class Paths:
    """Light on its way: arrays over paths. `word` has a digit per gate taken, 1 + the edit's number; `left` is the plane that a path starts on,
    as the number of the entry that must not take it there."""

    def __init__(self, origin, direction, flux, word, left):
        self.origin, self.direction, self.flux, self.word, self.left = origin, direction, flux, word, left

    def pick(self, mask):
        return Paths(self.origin[mask], self.direction[mask], self.flux[mask], self.word[mask], self.left[mask])


def land(paths, edits, takes, landed):
    """Moves paths on by one segment: those that meet no entry land; the others are returned, behind their gates."""
    floor = -paths.origin[:, 2] / paths.direction[:, 2]
    floor = np.where(floor > 0, floor, np.inf)
    first, which, where = floor.copy(), np.full(len(floor), -1), np.zeros((len(floor), 2))
    for i, edit in enumerate(edits):
        t, uv = Quad(edit["entry"]).cross(paths.origin, paths.direction)
        # light that left an exit in an entry's plane is at t = 0 of it: taken, unless it is its own
        starts = np.where(paths.left == i, 1e-9, -1e-9)
        better = (t > starts) & (t < first) & takes(i, paths.word)
        first, which = np.where(better, t, first), np.where(better, i, which)
        where[better] = uv[better]
    down = (which < 0) & np.isfinite(floor)
    here = paths.pick(down)
    landed.append((here.origin + floor[down][:, None] * here.direction, here.flux, here.word, down))
    onward = []
    for i, edit in enumerate(edits):
        taken = paths.pick(which == i)
        if not len(taken.word):
            continue
        uv, entry = where[which == i], Quad(edit["entry"])
        feather = edit.get("feather", 0)
        a = edit.get("amount", 1.0) * (soft_border(uv[:, 0], feather) * soft_border(uv[:, 1], feather) if feather else np.ones(len(uv)))
        word = taken.word * 10 + i + 1
        at = taken.origin + first[which == i][:, None] * taken.direction
        onward.append((Paths(at, taken.direction, taken.flux * (1 - a)[:, None], word, np.full(len(uv), i)), which == i))
        for leaves in edit["exits"]:
            quad = Quad(leaves["quad"])
            gain = leaves.get("intensity", 1.0) * (quad.area / entry.area if leaves.get("keep_brightness", True) else 1.0)
            flux = taken.flux * (a * gain)[:, None]
            if leaves.get("hue_shift"):
                color = flux[0] / max(flux[0].max(), 1e-300)
                flux = (flux @ LUMINANCE / (LUMINANCE @ color))[:, None] * turn_hue(color, leaves["hue_shift"])
            flux = tinted(flux, leaves.get("tint", (1, 1, 1)))
            onward.append((Paths(quad.point(uv), quad.to_world(entry.to_local(taken.direction)), flux, word, np.full(len(uv), i)), which == i))
    return onward


def once(edit, word):
    """The expression L on an edit that acts once: no gate before."""
    return word == 0


def expected_edited(scene, light, aim, radius, takes=once, color=(1, 1, 1)):
    """The Edited picture of the default camera (radiance / albedo · π = W/m²). aim: rectangle x0, x1, y0, y1 of the floor that holds
    all that the entries take; radius: of the density estimate, one or several of equal share."""
    u = sequence(PATHS, 6)
    x0, x1, y0, y1 = aim
    points = np.stack([x0 + (x1 - x0) * u[:, 0], y0 + (y1 - y0) * u[:, 1], np.zeros(PATHS)], 1)
    origin, irradiance = light(points, u[:, 2:4])
    direction = points - origin
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    flux = (irradiance * (x1 - x0) * (y1 - y0) / PATHS)[:, None] * np.array(color, float)
    radius = np.atleast_1d(np.asarray(radius, float))
    radii = np.repeat(radius, -(-PATHS // len(radius)))[:PATHS]  # runs: neighbours in a sequence lie in other places
    radii = radii * np.sqrt(1.5 * (1 - np.sqrt(1 - u[:, 4])))  # Epanechnikov's parabola
    blur = np.stack([radii * np.cos(2 * np.pi * u[:, 5]), radii * np.sin(2 * np.pi * u[:, 5])], 1)

    picture = np.zeros((scene.size, scene.size, 3))
    queue = [(Paths(origin, direction, flux, np.zeros(PATHS, int), np.full(PATHS, -1)), blur)]
    while queue:
        paths, blur = queue.pop()
        landed = []
        queue += [(onward, blur[mask]) for onward, mask in land(paths, scene.description["edits"], takes, landed)]
        at, flux, word, mask = landed[0]
        moved = word > 0
        add(picture, scene.view, at[moved, :2] + blur[mask][moved], flux[moved])
    return picture / (2 * scene.view / scene.size) ** 2


def add(picture, view, at, flux):
    size = len(picture)
    pixel = np.floor((at / view + 1) / 2 * size).astype(int)
    inside = ((pixel >= 0) & (pixel < size)).all(1)
    index = pixel[inside, 1] * size + pixel[inside, 0]
    for channel in range(3):
        picture[..., channel] += np.bincount(index, flux[inside, channel], size * size).reshape(size, size)
