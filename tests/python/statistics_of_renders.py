# SPDX-License-Identifier: GPL-3.0-or-later
"""Comparing renders with what they must be: error bars from independent seeds, Student's t, blocks of pixels. A comparison that could
not see an error of the size it is meant for fails as such: `finest` bounds the error bar itself."""

import math

import numpy as np

FALSE_ALARM = 1e-3  # of one comparison, over all its blocks


def student_quantile(probability, freedom):
    """The t that a Student variable exceeds, in absolute value, with this probability."""
    x = np.linspace(0.0, 400.0, 800001)
    density = (1 + x * x / freedom) ** (-(freedom + 1) / 2)
    tail = np.cumsum(density[::-1])[::-1]
    return float(x[np.searchsorted(-tail, -probability * tail[0])])


def interval(samples):
    """Mean of independent numbers and the half width of the interval that holds the true mean but for FALSE_ALARM."""
    samples = np.asarray(samples, float)
    return samples.mean(), student_quantile(FALSE_ALARM, len(samples) - 1) * samples.std(ddof=1) / math.sqrt(len(samples))


def assert_mean(samples, expected, bias=0.0, finest=0.02):
    """The mean of independent samples is `expected`, within its own error and a bias known beforehand (both relative to expected)."""
    mean, half_width = interval(samples)
    assert half_width <= finest * abs(expected), f"too noisy to tell: {mean} ± {half_width}"
    assert abs(mean - expected) <= half_width + (bias + 1e-6) * abs(expected), f"{mean} ± {half_width}, expected {expected} within {bias:.2%}"


def assert_between(samples, low, high, bias=0.0, finest=0.02):
    """The same for a mean that is known to lie between two numbers."""
    mean, half_width = interval(samples)
    slack = half_width + (bias + 1e-6) * abs(high)
    assert half_width <= finest * abs(high), f"too noisy to tell: {mean} ± {half_width}"
    assert low - slack <= mean <= high + slack, f"{mean} ± {half_width}, expected {low} … {high} within {bias:.2%}"


def assert_same_mean(a, b, finest=0.02, bias=0.0):
    """Welch: two sets of independent samples have one mean, within a bias known beforehand (relative)."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    va, vb = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)
    error, difference, size = math.sqrt(va + vb), a.mean() - b.mean(), max(abs(a.mean()), abs(b.mean()))
    if error <= 1e-6 * size:
        assert abs(difference) <= 1e-5 * size
        return
    freedom = (va + vb) ** 2 / (va**2 / (len(a) - 1) + vb**2 / (len(b) - 1))
    half_width = student_quantile(FALSE_ALARM, freedom) * error
    assert half_width <= finest * size, f"too noisy to tell: {half_width / size:.2%} of the mean"
    assert abs(difference) <= half_width + bias * size, f"{a.mean()} and {b.mean()} differ by more than {half_width} + {bias:.2%}"


def blocks(picture, width):
    """Means over squares of `width` pixels; the last two or three axes are rows, columns (and colours)."""
    picture = np.asarray(picture)
    axis = picture.ndim - (3 if picture.shape[-1] == 3 else 2)
    shape = picture.shape
    rows, columns = shape[axis] // width, shape[axis + 1] // width
    cut = picture.reshape(*shape[:axis], rows, width, columns, width, *shape[axis + 2 :])
    return cut.mean((axis + 1, axis + 3))


def assert_spread(samples, narrow, wide, bias=0.003, finest=0.06):
    """Pictures of light that each photon spreads evenly around it, some less and some more, between two known pictures where all do the least
    and the most. Whatever they do, the light, its middle and so how far it lies off are kept but for what leaves the picture; squares of
    distances grow with the widths; and where the widest spread brings none there is none."""
    at = np.arange(narrow.shape[0]) + 0.5
    x, y = np.meshgrid(at, at)
    for weight in (np.ones_like(x), x, y, x * x, y * y):
        low, high = sorted(float((picture * weight).sum()) for picture in (narrow, wide))
        assert_between((samples * weight).sum((1, 2)), low, high, bias, finest)
    # The pictures are sums over paths: where they met none they may have missed a few (Poisson's bound for none), each as the weakest that they have
    few = math.log(1 / FALSE_ALARM) * wide[wide > 0].min()
    left = samples.mean(0)[wide == 0].max(initial=0)
    assert left <= few, f"light where there must be none: {left}, at most {few} of {narrow.max()}"


def assert_blocks(samples, expected, bias=0.003, finest=0.06, finest_sum=0.04):
    """Block means of independent renders (seeds first) are `expected`, block by block and in the sum. Their variance is taken as
    proportional to what they expect (photons are counted), so that all blocks tell about it; as their own where that is more (at borders).
    Where nothing is expected there must be nothing (1e-4 of the brightest block: the expectation has a tail as thin as its quadrature);
    blocks of little light take part in the sum alone. `bias`: what the expectation itself may be off, relative."""
    samples, expected = np.asarray(samples, float).reshape(len(samples), -1), np.asarray(expected, float).ravel()
    mean, bright = samples.mean(0), expected > 0.1 * expected.max()
    assert (mean[expected == 0] <= 1e-4 * expected.max()).all(), f"light where there must be none: {mean[expected == 0].max()}"
    count, number = len(samples), int(bright.sum())
    spread = (samples.var(0, ddof=1)[bright] / expected[bright]).mean()
    t = student_quantile(FALSE_ALARM / number, number * (count - 1))
    half_width = t * np.sqrt(np.maximum(spread * expected[bright], samples.var(0, ddof=1)[bright]) / count)
    assert (half_width <= finest * expected[bright].max()).all(), f"too noisy to tell: {(half_width / expected[bright]).max():.2%}"
    off = np.abs(mean[bright] - expected[bright])
    worst = int(np.argmax(off / (half_width + bias * expected[bright])))
    assert (off <= half_width + bias * expected[bright]).all(), (
        f"block {np.flatnonzero(bright)[worst]} of {number}: {mean[bright][worst]}, expected {expected[bright][worst]} ± {half_width[worst]}")  # fmt: skip
    assert_mean(samples.sum(1), expected.sum(), bias, finest_sum)
