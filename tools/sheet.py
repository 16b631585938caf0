# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures about pictures: before/after sheets with the edits as captions, and error against time."""

import math
import textwrap
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import progress_log

INK, PAPER, WITHOUT, WITH = "#22252a", "#ffffff", "#7a8794", "#b4407e"
plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 11, "text.color": INK, "axes.edgecolor": INK, "axes.labelcolor": INK,
                     "axes.spines.top": False, "axes.spines.right": False})  # fmt: skip


def caption(edit: dict) -> str:
    """An edit in one line: name, expression, what its exits do."""
    exits = []
    for item in edit["exits"]:
        changes = [f"×{item['intensity']:g}"] if item["intensity"] != 1 else []
        changes += [f"hue {item['hue_shift']:+.0f}°"] if abs(item["hue_shift"]) > 0.5 else []
        exits.append(item["name"] + (f" ({', '.join(changes)})" if changes else ""))
    return f"{edit['name']}    {edit['expression']}    →  {', '.join(exits) or 'absorbed'}"


def side_by_side(title: str, pictures: list[tuple[str, Path]], lines: list[str], path: Path):
    """Two or more pictures in a row, a label over each and lines of text below, at the pictures' own pixels."""
    images = [plt.imread(picture) for _, picture in pictures]
    height, width = images[0].shape[:2]
    dpi, gap = 100, 12
    total_w = width * len(images) + gap * (len(images) + 1)
    lines = [part for line in lines for part in textwrap.wrap(line, (total_w - 2 * gap) // 10, subsequent_indent="    ", drop_whitespace=False)]
    head, foot = 84, 22 + 24 * len(lines)
    total_h = height + head + foot
    figure = plt.figure(figsize=(total_w / dpi, total_h / dpi), dpi=dpi, facecolor=PAPER)
    figure.text(gap / total_w, 1 - 30 / total_h, title, fontsize=17, weight="bold", va="center")
    for i, ((label, _), picture) in enumerate(zip(pictures, images, strict=True)):
        left = gap + i * (width + gap)
        axes = figure.add_axes((left / total_w, foot / total_h, width / total_w, height / total_h))
        axes.imshow(picture, interpolation="nearest")
        axes.axis("off")
        figure.text(left / total_w, 1 - 66 / total_h, label, fontsize=13, va="center")
    for i, line in enumerate(lines):
        figure.text(gap / total_w, (foot - 20 - 24 * i) / total_h, line, fontsize=12, family="DejaVu Sans Mono", va="center")
    figure.savefig(path, facecolor=PAPER)
    plt.close(figure)


def error_plot(title: str, curves: dict[str, list[dict]], path: Path) -> bool:
    """Error estimate against time, log-log, with the seconds that 10, 5, 2 and 1 % cost. False if there is nothing to draw."""
    lines = {label: progress_log.error_curve(updates) for label, updates in curves.items()}
    lines = {label: (s, e) for label, (s, e) in lines.items() if len(s) >= 2}
    if not lines:
        return False
    figure, axes = plt.subplots(figsize=(8, 5), dpi=120)
    for (label, (seconds, errors)), color in zip(lines.items(), (WITHOUT, WITH, "#3b6fb6", "#c07a20"), strict=False):
        axes.loglog(seconds, [100 * e for e in errors], color=color, linewidth=2, label=f"{label}\n{progress_log.price_text(seconds, errors)}")
        line = progress_log.slope(seconds, errors)
        if line and line[0] < -0.1:
            ahead = [seconds[-1] * 16 ** (i / 8) for i in range(9)]
            axes.loglog(ahead, [100 * math.exp(line[1]) * s ** line[0] for s in ahead], color=color, linewidth=1, linestyle=":")
        for target in progress_log.TARGETS:
            found = progress_log.price(seconds, errors, target)
            if found and found[0] <= seconds[-1] * 16:
                axes.plot(found[0], 100 * target, marker="o", color=color, markerfacecolor=color if found[1] else PAPER)
    for target in progress_log.TARGETS:
        axes.axhline(100 * target, color=INK, linewidth=0.5, alpha=0.3)
    axes.set(xlabel="seconds of rendering", ylabel="estimated error (%)", title=title)
    axes.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.legend(frameon=False, fontsize=9, title="dots: seconds that an error costs (open, ~: by the slope)", title_fontsize=9)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)
    return True
