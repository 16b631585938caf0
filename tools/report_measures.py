# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of a report, from pictures and from what the core tells: the true error by the definition of the estimated one (design §5,
"Error"), what an error costs, whether other settings are cheaper, and where the error is.

Pictures are linear RGB (height, width, 3), row 0 at the bottom. Errors are relative, 0.01 = 1 %."""

import math
import sys
from pathlib import Path

import numpy as np
import progress_log

ROOT = Path(__file__).resolve().parents[1]
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
BIAS_FALLS = -2 / 3  # bias² ~ passes^(-2/3): kernels shrink with α = 2/3 (design §5); noise² ~ 1 / passes


def trimmed_mean(squares: np.ndarray) -> float:
    """Without the worst 0.1 % of the pixels, as the core counts them."""
    flat = np.sort(squares, axis=None)
    return float(flat[: flat.size - flat.size // 1000].mean())


def error_squares(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Per pixel d² / (c² + (m / 10)²), mean over the channels: d the difference, c the reference, m its mean luminance."""
    image, reference = image.astype(np.float64), reference.astype(np.float64)
    dark = (reference @ LUMINANCE).mean() / 10
    return ((image - reference) ** 2 / (reference**2 + dark**2)).mean(-1)


def true_error(image: np.ndarray, reference: np.ndarray) -> float:
    """The error of design §5 with a reference in the place of the limit."""
    return math.sqrt(trimmed_mean(error_squares(image, reference)))


def against(image: np.ndarray, reference: np.ndarray, own_noise: float | None) -> dict:
    """A picture beside the reference. Where the reference knows its own noise, `true` is told a second time without it: both are
    independent, so the squares subtract."""
    squares = error_squares(image, reference)
    told = math.sqrt(trimmed_mean(squares))
    own = None if own_noise is None else math.sqrt(max(0.0, told**2 - own_noise**2))
    return {"true": told, "true_without_reference_noise": own, "relmse": float(squares.mean()), "flip": flip(image, reference)}


# --- what an error costs -----------------------------------------------------------------------------------------------------------


def factor_to(noise: float, bias: float, target: float) -> float | None:
    """By what factor passes must grow (or may fall) for an error: noise² ~ 1 / n, bias² ~ n^(-2/3). None: there is none."""
    if not (target > 0 and noise**2 + bias**2 > 0):
        return None
    low, high = -20.0, 40.0  # by halving, in logarithms: the error falls with each pass
    for _ in range(60):
        middle = (low + high) / 2
        squares = noise**2 * 2**-middle + bias**2 * 2 ** (BIAS_FALLS * middle)
        low, high = (middle, high) if squares > target**2 else (low, middle)
    return 2**high


def cost(curve: list[dict], target: float) -> dict | None:
    """Passes, seconds, rays and photons for an error, of rows with pass, seconds, rays, photons, error, noise and bias: measured where
    the curve reaches it, else extrapolated from its last row. None where nothing is known."""
    known = [row for row in curve if row.get("error") is not None]
    reached = next((row for row in known if row["error"] <= target), None)
    if reached:
        return {"error": target, "measured": True, **{key: reached[key] for key in ("pass", "seconds", "rays", "photons")}}
    factor = factor_to(known[-1]["noise"], known[-1]["bias"], target) if known else None
    if factor is None:
        return None
    last, first = known[-1], known[0]
    more = math.ceil(last["pass"] * factor) - last["pass"]

    def ahead(key):
        """What each pass takes, without what was done before the first."""
        base = first if first is not last else {"pass": 0, key: 0}
        return last[key] + more * (last[key] - base[key]) / (last["pass"] - base["pass"])

    return {"error": target, "measured": False, "pass": last["pass"] + more, "seconds": ahead("seconds"), "rays": round(ahead("rays")),
            "photons": round(ahead("photons"))}  # fmt: skip


def costs(curve: list[dict]) -> list[dict]:
    """Those of 10, 5, 2 and 1 %."""
    return [found for target in progress_log.TARGETS if (found := cost(curve, target))]


def fit(curve: list[dict], key: str) -> tuple[float, float] | None:
    """(exponent, value at 1 s) of error, noise or bias against seconds: the line through all rows in log-log."""
    points = [(math.log(row["seconds"]), math.log(row[key])) for row in curve if row.get(key) and row["seconds"] > 0]
    if len(points) < 2 or points[0][0] == points[-1][0]:
        return None
    exponent, constant = np.polyfit(*zip(*points, strict=True), 1)
    return float(exponent), math.exp(constant)


def slope(curve: list[dict], key: str) -> float | None:
    """The exponent alone."""
    line = fit(curve, key)
    return line and line[0]


# --- other settings ----------------------------------------------------------------------------------------------------------------


def beside(row: dict, present: dict) -> dict:
    """Error × work of other settings, and what they take to the error of the present ones: rows with passes, seconds, work (rays and photons),
    error, noise, bias. Error × work alone favours whatever does less; at the same error both are compared as an artist would."""
    told = {**row, "error_seconds": row["error"] * row["seconds"], "error_work": row["error"] * row["work"]}
    factor = factor_to(row["noise"], row["bias"], present["error"])
    same = {"same_error_seconds": None, "same_error_work": None}
    if factor is not None:
        same = {"same_error_seconds": row["seconds"] * factor, "same_error_work": row["work"] * factor}
    return {**told, **same}


def compare_settings(rows: list[dict]) -> list[dict]:
    """The first row is the render as it is. `best`: least seconds to its error; `least_work` is the same in rays and photons, which no
    other program on the machine disturbs."""
    told = [beside(row, rows[0]) for row in rows if row["error"] is not None]
    for mark, key in (("best", "same_error_seconds"), ("least_work", "same_error_work")):
        found = [row for row in told if row[key] is not None]
        least = min(found, key=lambda row: row[key], default=None)
        for row in told:
            row[mark] = row is least
    return told


# --- where the error is ------------------------------------------------------------------------------------------------------------


def box_mean(values: np.ndarray, half: int) -> np.ndarray:
    """Mean over the square of 2 · half + 1 pixels around each, as far as it lies in the picture."""
    def sums(array, axis):
        padded = np.insert(np.cumsum(array, axis), 0, 0, axis)
        length = array.shape[axis]
        above, below = np.minimum(np.arange(length) + half + 1, length), np.maximum(np.arange(length) - half, 0)
        return np.take(padded, above, axis) - np.take(padded, below, axis)

    return sums(sums(values, 0), 1) / sums(sums(np.ones_like(values), 0), 1)


def error_map(combined: np.ndarray, noise: np.ndarray, bias: np.ndarray) -> np.ndarray:
    """Error per pixel from the passes Noise and Bias, both relative to the pixel, brought to the definition of the error; told smoothly, as
    four streams say little of one pixel."""
    light = combined.astype(np.float64) @ LUMINANCE
    squares = box_mean((noise * light) ** 2, 1) + box_mean(bias * light, 2) ** 2
    return np.sqrt(squares / (light**2 + (light.mean() / 10) ** 2 + 1e-300))


def encode(image: np.ndarray) -> np.ndarray:
    """Linear light as sRGB shows it, 0 to 1, top row first (Blender's view transform "Standard")."""
    shown = np.clip(image[::-1, :, :3].astype(np.float64), 0, 1)
    return np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)


def flip_module():
    """FLIP, or None. ./run setup puts it into .venv, whose Python is Debian's own."""
    place = f"{ROOT}/.venv/lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
    if place not in sys.path:
        sys.path.append(place)
    try:
        import flip_evaluator

        return flip_evaluator
    except ImportError:
        return None


def flip(image: np.ndarray, reference: np.ndarray) -> float | None:
    """Mean FLIP error of the pictures as they are shown (Andersson et al. 2020): 0 none, 1 the most."""
    module = flip_module()
    if module is None:
        return None
    shown = [np.ascontiguousarray(encode(each), np.float32) for each in (reference, image)]
    return float(module.evaluate(*shown, "LDR", applyMagma=False)[1])
