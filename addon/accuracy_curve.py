# SPDX-License-Identifier: GPL-3.0-or-later
"""The curve of error against time as an image, on logarithmic axes. Drawn with NumPy alone, letters too: what draws text and plots
elsewhere is not in every Blender, or wants a window."""
from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

WIDTH, HEIGHT = 720, 480
_LEFT, _RIGHT, _BOTTOM, _TOP = 80, 20, 50, 40  # margins around the axes
_PAPER, _INK, _GRID = (0.11, 0.11, 0.12), (0.85, 0.85, 0.85), (0.24, 0.24, 0.26)
CURVES = (("error", (1.0, 0.85, 0.35)), ("noise", (0.45, 0.70, 1.0)), ("bias", (0.85, 0.50, 0.85)))
_LABELS = {"error": "ERROR", "noise": "NOISE", "bias": "BLUR"}
_SIZE = 2  # pixels of an image to one of a letter
# Letters of 3 × 5 pixels, row by row from the top.
_GLYPHS = {
    "0": "111 101 101 101 111", "1": "010 110 010 010 111", "2": "111 001 111 100 111", "3": "111 001 111 001 111",
    "4": "101 101 111 001 001", "5": "111 100 111 001 111", "6": "111 100 111 101 111", "7": "111 001 010 010 010",
    "8": "111 101 111 101 111", "9": "111 101 111 001 111", ".": "000 000 000 000 010", "%": "101 001 010 100 101",
    "S": "111 100 111 001 111", "E": "111 100 110 100 111", "R": "110 101 110 101 101", "O": "111 101 101 101 111",
    "N": "111 101 101 101 101", "I": "111 010 010 010 111", "B": "110 101 110 101 110", "L": "100 100 100 100 111",
    "U": "101 101 101 101 111", "T": "111 010 010 010 010", "M": "101 111 111 101 101", " ": "000 000 000 000 000",
}


def draw(rows: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """(HEIGHT, WIDTH, 4) float32, row 0 at the bottom, of rows with "seconds", "error", "noise" and "bias" (relative). Points that are
    not known or not above 0 are left out."""
    pixels = np.ones((HEIGHT, WIDTH, 4), np.float32)
    pixels[..., :3] = _PAPER
    curves = {name: np.array([(row["seconds"], 100 * row[name]) for row in rows if row["seconds"] > 0 and (row[name] or 0) > 0]).reshape(-1, 2)
              for name, _color in CURVES}
    points = np.concatenate(list(curves.values()))
    if not len(points):
        return pixels
    low, high = _range(points[:, 0]), _range(points[:, 1])
    for number, place in _ticks(*low):
        _fill(pixels, _column(place), _column(place) + 1, _BOTTOM, HEIGHT - _TOP, _GRID)
        _write(pixels, number, _column(place), 26, _INK)
    for number, place in _ticks(*high):
        _fill(pixels, _LEFT, WIDTH - _RIGHT, _row(place), _row(place) + 1, _GRID)
        _write(pixels, number + " %", _LEFT // 2 - 4, _row(place) - 5, _INK)
    _write(pixels, "TIME S", WIDTH // 2, 8, _INK)
    for index, (name, color) in enumerate(CURVES):
        _write(pixels, _LABELS[name], _LEFT + 40 + 90 * index, HEIGHT - 25, color)
        _plot(pixels, _within(curves[name][:, 0], low), _within(curves[name][:, 1], high), color, 4 if name == "error" else 2)
    return pixels


def _range(values: np.ndarray) -> tuple[float, float]:
    """Logarithms of what an axis spans: whole steps of 1, 2, 5, 10, so that there are two numbers at least."""
    steps = np.array([decade + step for decade in range(-9, 10) for step in np.log10((1, 2, 5))])
    low, high = np.log10(values.min()), np.log10(values.max())
    return float(steps[steps <= low].max(initial=-9)), float(steps[steps > high + 1e-9].min(initial=9))


def _ticks(low: float, high: float) -> Iterator[tuple[str, float]]:
    """Numbers along an axis and where they stand, 0 to 1. Over many decades only their first ones."""
    steps = (1, 2, 5) if high - low < 2.5 else (1,)
    for decade in range(int(np.floor(low)), int(np.ceil(high)) + 1):
        for step in steps:
            place = (decade + np.log10(step) - low) / (high - low)
            if -1e-6 <= place <= 1 + 1e-6:
                yield f"{step * 10.0 ** decade:.{max(0, -decade)}f}", place


def _within(values: np.ndarray, span: tuple[float, float]) -> np.ndarray:
    return (np.log10(values) - span[0]) / (span[1] - span[0])


def _column(place: Any) -> Any:
    return np.rint(_LEFT + np.asarray(place) * (WIDTH - _LEFT - _RIGHT - 1)).astype(int)


def _row(place: Any) -> Any:
    return np.rint(_BOTTOM + np.asarray(place) * (HEIGHT - _BOTTOM - _TOP - 1)).astype(int)


def _fill(pixels: np.ndarray, x0: int, x1: int, y0: int, y1: int, color: Sequence[float]) -> None:
    pixels[max(y0, 0):y1, max(x0, 0):x1, :3] = color


def _plot(pixels: np.ndarray, x: np.ndarray, y: np.ndarray, color: Sequence[float], thickness: int) -> None:
    """A curve, its points as dots. The error is the thickest: where noise or blur is all of it, both are seen."""
    if not len(x):
        return
    along = np.arange(len(x))
    dense = np.linspace(0, len(x) - 1, 2 * WIDTH * min(len(x), 64))
    columns, rows = _column(np.interp(dense, along, x)), _row(np.interp(dense, along, y))
    for right, up in np.ndindex(thickness, thickness):
        pixels[rows + up - thickness // 2, columns + right - thickness // 2, :3] = color
    for column, row in zip(_column(x), _row(y)):
        _fill(pixels, column - thickness, column + thickness, row - thickness, row + thickness, color)


def _write(pixels: np.ndarray, text: str, x: int, y: int, color: Sequence[float]) -> None:
    """Text around column x, its foot at row y."""
    left = int(x) - 2 * _SIZE * len(text)
    for number, letter in enumerate(text):
        rows = _GLYPHS[letter].split()
        for up, row in enumerate(reversed(rows)):
            for right, dot in enumerate(row):
                if dot == "1":
                    x0, y0 = left + (4 * number + right) * _SIZE, int(y) + up * _SIZE
                    _fill(pixels, x0, x0 + _SIZE, y0, y0 + _SIZE, color)
