# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the progress that Sluice writes while it renders, when the environment variable SLUICE_PROGRESS_LOG names a file.

One JSON object per line whenever a pass has ended: frame, view_layer, seconds, pass, passes, photons, error_estimate (relative, 0.05 =
5 %, null while unknown), stop_reason, effects (rows of name, runs, why); on a render's last line also statistics and warnings (rows of
item, message). Renders of one process follow each other."""

import json
import math
from pathlib import Path

TARGETS = (0.10, 0.05, 0.02, 0.01)
FEW = 8  # estimates


def read(path: Path) -> list[dict]:
    """The updates so far; a line that is still being written is left out."""
    updates = []
    if path.exists():
        for line in path.read_text().splitlines():
            try:
                updates.append(json.loads(line))
            except ValueError:
                break
    return updates


def error_curve(updates: list[dict]) -> tuple[list[float], list[float]]:
    """Seconds and error estimates (relative) where a new estimate was made (the engine makes one every few passes)."""
    points = [(u["seconds"], u["error_estimate"]) for u in updates if u.get("error_estimate") and u["seconds"] > 0]
    news = [(s, e) for i, (s, e) in enumerate(points) if math.isfinite(e) and (i == 0 or e != points[i - 1][1])]
    return [s for s, _ in news], [e for _, e in news]


def slope(seconds: list[float], errors: list[float]) -> tuple[float, float] | None:
    """Line through the later half of the curve in log-log: (exponent, log of the error at 1 s). Few estimates tell no exponent: then it
    is that of noise."""
    points = [(math.log(s), math.log(e)) for s, e in zip(seconds, errors, strict=True)]
    tail = points[len(points) // 2 :]
    if not tail:
        return None
    mean_x, mean_y = (sum(values) / len(tail) for values in zip(*tail, strict=True))
    if len(points) < FEW:
        return -0.5, mean_y + 0.5 * mean_x
    spread = sum((x - mean_x) ** 2 for x, _ in tail)
    if spread == 0:
        return None
    exponent = sum((x - mean_x) * (y - mean_y) for x, y in tail) / spread
    return exponent, mean_y - exponent * mean_x


def price(seconds: list[float], errors: list[float], target: float) -> tuple[float, bool] | None:
    """Seconds that an error costs, and whether that was reached (True) or follows from the slope (False). None: no way to tell."""
    reached = [s for s, e in zip(seconds, errors, strict=True) if e <= target]
    if reached:
        return reached[0], True
    line = slope(seconds, errors)
    if line is None or line[0] > -0.1:
        return None
    return math.exp((math.log(target) - line[1]) / line[0]), False


def price_text(seconds: list[float], errors: list[float]) -> str:
    """'10 %: 2 s, 5 %: 8 s, 2 %: ~50 s, 1 %: ~200 s'; ~ marks what was not reached."""
    parts = []
    for target in TARGETS:
        found = price(seconds, errors, target)
        cost = "?" if found is None else f"{'' if found[1] else '~'}{found[0]:.{0 if found[0] >= 100 else 1}f} s"
        parts.append(f"{target * 100:g} %: {cost}")
    return ", ".join(parts)
