# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots and pictures of reports, as PNG in data URIs, so that a page needs no other file. Curves are rows as the core tells them: pass,
seconds, rays, photons, error, noise, bias, parts, edits."""

import base64
import io

import matplotlib
import numpy as np
import progress_log
import report_measures as measures
from PIL import Image
from sheet import INK, WITH, WITHOUT, plt

COLOURS = (WITH, "#3b6fb6", "#c07a20", "#3f8f5a", WITHOUT, "#7d5fb2", "#a03030", "#20808a", "#8a8a20", "#555555")


def uri(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode()


def _page(figure) -> str:
    """A figure as it comes into a page."""
    figure.tight_layout()
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    plt.close(figure)
    return uri(buffer.getvalue())


def _axes(title: str, ylabel: str = "error (%)", xlabel: str = "seconds of rendering"):
    figure, axes = plt.subplots(figsize=(7.2, 4.6), dpi=110)
    axes.set(title=title, xlabel=xlabel, ylabel=ylabel, xscale="log", yscale="log")
    return figure, axes


def _finish(axes, legend_below: bool = False):
    """Plain numbers at the axes, a legend."""
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
        axis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        axes.legend(handles, labels, frameon=False, fontsize=8, handlelength=3, ncols=2 if legend_below else 1)


def _line(axes, rows: list[dict], key: str, **style) -> bool:
    """The rows that know a figure, in percent."""
    points = [(row["seconds"], 100 * row[key]) for row in rows if row.get(key)]
    if points:
        axes.plot(*zip(*points, strict=True), **style)
    return bool(points)


def _targets(axes):
    """Lines at 10, 5, 2 and 1 %, where they are in sight."""
    low, high = axes.get_ylim()
    for target in progress_log.TARGETS:
        if low <= 100 * target <= high:
            axes.axhline(100 * target, color=INK, linewidth=0.5, alpha=0.3)


def error_curve(title: str, rows: list[dict], checkpoints: list[dict]) -> str:
    """Error, noise and bias against time with their slopes, and the true error where there is a reference."""
    figure, axes = _axes(title)
    for key, color, width in (("error", WITH, 2.2), ("noise", "#3b6fb6", 1.2), ("bias", "#c07a20", 1.2)):
        line = measures.fit(rows, key)
        line = line if line and line[0] < 0 else None  # What rises is an estimate that has not settled yet, and no law to go by.
        label = f"{key}, estimated" + (f" (dots: seconds^{line[0]:.2f})" if line else "")
        _line(axes, rows, key, color=color, linewidth=width, label=label, marker="." if len(rows) < 3 else "")
        if line:
            ends = [rows[0]["seconds"], 4 * rows[-1]["seconds"]]
            axes.plot(ends, [100 * line[1] * end ** line[0] for end in ends], color=color, linewidth=1, linestyle=":")
    beside = [{"seconds": row["seconds"], **(row.get("against") or {})} for row in checkpoints]
    _line(axes, beside, "true", color=INK, marker="o", markersize=4, linewidth=1, label="error against the reference")
    _line(axes, beside, "true_without_reference_noise", color=INK, marker="o", markersize=4, markerfacecolor="white", linestyle=":",
          label="the same without the reference's own noise")  # fmt: skip
    _targets(axes)
    _finish(axes)
    return _page(figure)


def shares_curve(title: str, rows: list[dict], kind: str) -> str | None:
    """Noise (drawn through) and bias (dotted) of each effect ("parts") or edit ("edits") against time. None: nothing to draw."""
    names = list(dict.fromkeys(item["name"] for row in rows for item in row[kind]))
    figure, axes = _axes(title)
    drawn = False
    for name, color in zip(names, COLOURS, strict=False):
        own = [{"seconds": row["seconds"], **next((item for item in row[kind] if item["name"] == name), {})} for row in rows]
        drawn |= _line(axes, own, "noise", color=color, linewidth=1.8, label=f"{name}: noise", marker=".")
        drawn |= _line(axes, own, "bias", color=color, linewidth=1.4, linestyle=":", label=f"{name}: bias", marker=".")
    if not drawn:
        plt.close(figure)
        return None
    _finish(axes, legend_below=True)
    return _page(figure)


def compared_curves(curves: dict[str, list[dict]]) -> str:
    """Estimated errors of several reports in one plot."""
    figure, axes = _axes("Error against time")
    for (name, rows), color in zip(curves.items(), COLOURS, strict=False):
        _line(axes, rows, "error", color=color, linewidth=2, label=f"{name}: error", marker=".")
        _line(axes, rows, "noise", color=color, linewidth=0.9, linestyle="--", label=f"{name}: noise")
        _line(axes, rows, "bias", color=color, linewidth=0.9, linestyle=":", label=f"{name}: bias")
    _targets(axes)
    _finish(axes)
    return _page(figure)


def heat_map(title: str, values: np.ndarray, high: float, unit: str = "error (%)") -> str:
    """Errors per pixel (or what else has that unit, in hundredths) as colours with a scale; white from `high` on."""
    shape = values.shape
    figure, axes = plt.subplots(figsize=(7.2, max(2.0, min(7.0, 6.0 * shape[0] / shape[1] + 0.8))), dpi=110)
    drawn = axes.imshow(100 * values[::-1], cmap="magma", vmin=0, vmax=100 * high, interpolation="nearest")
    axes.set(title=title, xticks=[], yticks=[])
    figure.colorbar(drawn, ax=axes, label=unit, fraction=0.046 * min(1.0, shape[0] / shape[1]) * 1.2, extend="max")
    return _page(figure)


def picture(image: np.ndarray, width: int = 320) -> str:
    """A picture as Blender shows it with the view transform Standard, small."""
    shown = Image.fromarray((measures.encode(image) * 255 + 0.5).astype(np.uint8))
    if shown.width > width:
        shown = shown.resize((width, max(1, round(shown.height * width / shown.width))), Image.BOX)
    buffer = io.BytesIO()
    shown.save(buffer, "PNG", optimize=True)
    return uri(buffer.getvalue())


def demo_plot(rows: list[dict], path):
    """Error against passes of all demo scenes, for docs/accuracy.md."""
    figure, axes = plt.subplots(figsize=(8, 5), dpi=100)
    for i, row in enumerate(rows):
        points = [(pass_, 100 * error) for pass_, error in row["true"].items()]
        axes.plot(*zip(*points, strict=True), color=COLOURS[i % len(COLOURS)], linestyle="-" if i < len(COLOURS) else "--", linewidth=1.8,
                  marker="o", markersize=3.5, label=row["name"])  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="passes", ylabel="error (%)", title="What accuracy costs")
    _targets(axes)
    _finish(axes)
    axes.set_xticks(list(rows[0]["true"]))
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)
