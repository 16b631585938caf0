# SPDX-License-Identifier: GPL-3.0-or-later
"""The geometry of a new quad: the smallest rectangle round points in a plane, as the matrix of an Empty of display size 1. Needs no bpy."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np

Point: TypeAlias = tuple[float, ...]
Numbers: TypeAlias = Sequence[float] | Sequence[Sequence[float]] | np.ndarray

_MIN_HALF = 1e-4  # In metres: a rectangle round a line or a point has an area, too.


def frame_from_normal(normal: Numbers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A right-handed orthonormal frame (x, y, normal), x as level as it can be."""
    n = np.asarray(normal, np.float64)
    length = np.linalg.norm(n)
    n = n / length if length > 1e-12 else np.array((0.0, 0.0, 1.0))
    level = np.cross((0.0, 0.0, 1.0), n)
    if np.linalg.norm(level) < 1e-6:
        level = np.array((1.0, 0.0, 0.0))
    x = level / np.linalg.norm(level)
    return x, np.cross(n, x), n


def fit_quad(points: Numbers, normal: Numbers) -> np.ndarray:
    """4 × 4 matrix of the smallest rectangle that covers `points` seen along `normal`. It lies in the plane of the point that
    stands out most, so that all of them are behind it; its local Z is the normal (the arrow)."""
    points = np.asarray(points, np.float64).reshape(-1, 3)
    x, y, n = frame_from_normal(normal)
    flat = np.stack((points @ x, points @ y), axis=1)
    angle, low, high = _smallest_rectangle(flat)
    u = np.cos(angle) * x + np.sin(angle) * y
    v = np.cross(n, u)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, _MIN_HALF)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1] = u * half[0], v * half[1]
    matrix[:3, 2] = n * half.mean()
    matrix[:3, 3] = middle[0] * u + middle[1] * v + (points @ n).max() * n
    return matrix


def _smallest_rectangle(flat: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """The smallest rectangle round 2D points: its angle, and its corners (low, high) when turned level. One side lies on an edge of the hull."""
    best: tuple[float, float, np.ndarray, np.ndarray] | None = None
    hull = _hull(flat)
    edges = np.roll(hull, -1, axis=0) - hull
    angles = {0.0} | {float(np.arctan2(dy, dx)) % (np.pi / 2) for dx, dy in edges if abs(dx) + abs(dy) > 1e-12}
    for angle in sorted(angles):
        # Turned by -angle, the edge is level.
        turned = hull @ np.array(((np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))))
        low, high = turned.min(axis=0), turned.max(axis=0)
        area = float(np.prod(high - low))
        if best is None or area < best[0] * (1 - 1e-9):
            best = (area, angle, low, high)
    assert best is not None  # At least angle 0 was tried.
    return best[1:]


def _hull(flat: np.ndarray) -> np.ndarray:
    """Convex hull of 2D points (Andrew's monotone chain)."""
    points = sorted(set(map(tuple, np.round(flat, 9).tolist())))
    if len(points) < 3:
        return np.array(points)

    def half(sequence: Iterable[Point]) -> list[Point]:
        chain: list[Point] = []
        for p in sequence:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return np.array(half(points) + half(reversed(points)))


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def beside(matrix: Numbers, gap: float = 0.15) -> np.ndarray:
    """The matrix moved along its own X by its width and a gap: where the exit of a new pair starts."""
    moved = np.array(matrix, np.float64)
    moved[:3, 3] += moved[:3, 0] * (2 + 2 * gap)
    return moved
