# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures about pictures: contact sheets with the edits as captions, strips of frames, and error against time."""

import math
import textwrap
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

matplotlib.use("Agg")
import matplotlib.font_manager
import matplotlib.pyplot as plt
import progress_log

INK, PAPER, WITHOUT, WITH = "#22252a", "#ffffff", "#7a8794", "#b4407e"
plt.rcParams.update({"font.family": "DejaVu Sans", "font.size": 11, "text.color": INK, "axes.edgecolor": INK, "axes.labelcolor": INK,
                     "axes.spines.top": False, "axes.spines.right": False})  # fmt: skip


@dataclass
class Row:
    """A scene on a contact sheet."""

    title: str
    file: str
    pictures: list[tuple[str, Path]]  # label and file of each, side by side
    edits: list[dict]  # as tools/demo_render.py tells them


def in_words(edit: dict) -> str:
    """Where an edit takes light and what its exits do with it."""
    exits = []
    for item in edit["exits"]:
        changes = [f"{item['size']:.2g} × the size"] if abs(item["size"] - 1) > 0.01 else []
        changes += ["energy kept"] if not item["keep_brightness"] else []
        changes += [f"{item['intensity']:.2g} × the light"] if item["intensity"] != 1 else []
        if "hue_shift_texture" in item:
            changes.append(f"hue by texture “{item['hue_shift_texture']}”")
        elif abs(item["hue_shift"]) > 0.5:
            changes.append(f"hue {item['hue_shift']:+.0f}°")
        changes += ["tinted"] if "tint" in item else []
        changes += [f"light by texture “{item['intensity_texture']}”"] if "intensity_texture" in item else []
        changes += [f"turned by normal map “{item['normal_map']}”"] if "normal_map" in item else []
        exits.append(item["name"] + (f" ({', '.join(changes)})" if changes else ""))
    return f"{edit['name']} → {'; '.join(exits) or 'nowhere: it is removed'}"


GAP, HEAD, LABEL, LINE, FOOT = 24, 44, 30, 25, 34  # pixels: between pictures, of a row's title, labels, a line of text, the end of a row
DPI, SMALL, CHARACTER = 100, 11.5, 8.6  # of the captions: points, and pixels that a character takes at most on average


def _caption(row: Row, width: int) -> list[tuple[str, str]]:
    """Lines of (expression, words): each edit begins with its expression, the words wrap beside it."""
    lines = []
    for edit in row.edits:
        parts = textwrap.wrap(in_words(edit), int((width - _column(row)) / CHARACTER))
        lines += [(edit["expression"] if i == 0 else "", part) for i, part in enumerate(parts)]
    return lines


def _column(row: Row) -> float:
    """Pixels for the expressions (in a font of fixed width) and a gap behind them."""
    return max((len(edit["expression"]) for edit in row.edits), default=0) * 0.605 * SMALL * DPI / 72 + 30


def contact_sheet(rows: list[Row], path: Path, width: int):
    """Scenes one below the other: title and file, pictures side by side (each `width` pixels wide), expressions and what they do."""
    images = [[_fitted(picture, width) for _, picture in row.pictures] for row in rows]
    total_w = max(len(row) for row in images) * (width + GAP) + GAP
    captions = [_caption(row, total_w - 2 * GAP) for row in rows]
    heights = [HEAD + LABEL + max(i.shape[0] for i in row) + 16 + LINE * len(lines) + FOOT for row, lines in zip(images, captions, strict=True)]
    total_h = sum(heights) + GAP
    figure = plt.figure(figsize=(total_w / DPI, total_h / DPI), dpi=DPI, facecolor=PAPER)

    def text(x, y, words, size, **style):
        figure.text(x / total_w, 1 - y / total_h, words, fontsize=size, va="center", **style)

    top = GAP / 2
    for row, pictures, lines, height in zip(rows, images, captions, heights, strict=True):
        text(GAP, top + 24, row.title, 15, weight="bold")
        text(total_w - GAP, top + 24, row.file, 11, ha="right", color=WITHOUT)
        for i, ((label, _), picture) in enumerate(zip(row.pictures, pictures, strict=True)):
            left = GAP + i * (width + GAP)
            text(left, top + HEAD + 13, label, SMALL, color=WITHOUT)
            figure.figimage(picture, left, total_h - top - HEAD - LABEL - picture.shape[0])
        below = top + HEAD + LABEL + max(picture.shape[0] for picture in pictures) + 16
        for i, (expression, words) in enumerate(lines):
            text(GAP, below + LINE * (i + 0.5), expression, SMALL, family="DejaVu Sans Mono", color=WITH)
            text(GAP + _column(row), below + LINE * (i + 0.5), words, SMALL)
        top += height
    figure.savefig(path, facecolor=PAPER, dpi=DPI)
    plt.close(figure)


def _fitted(path: Path, width: int) -> np.ndarray:
    """A picture, brought to a width."""
    with Image.open(path) as picture:
        size = (width, round(picture.height * width / picture.width))
        return np.asarray(picture.convert("RGB").resize(size, Image.LANCZOS if picture.size != size else Image.NEAREST))


def strip(pictures: list[tuple[str, Path]], path: Path, columns: int = 3, gap: int = 6):
    """Frames of an animation, a few to a line, the label of each in its lower corner."""
    frames = [Image.open(picture).convert("RGB") for _, picture in pictures]
    width, height = frames[0].size
    columns = min(columns, len(frames))
    lines = -(-len(frames) // columns)
    whole = Image.new("RGB", (columns * (width + gap) - gap, lines * (height + gap) - gap), PAPER)
    font = ImageFont.truetype(matplotlib.font_manager.findfont("DejaVu Sans"), max(10, height // 12))
    for i, ((label, _), frame) in enumerate(zip(pictures, frames, strict=True)):
        ImageDraw.Draw(frame).text((height // 20, height - height // 7), label, fill=PAPER, font=font)
        whole.paste(frame, (i % columns * (width + gap), i // columns * (height + gap)))
    whole.save(path)


def pair(row: Row, path: Path, width: int = 440, gap: int = 6):
    """A row's pictures alone, small, side by side: for pages that link to them."""
    images = [Image.fromarray(_fitted(picture, width)) for _, picture in row.pictures]
    whole = Image.new("RGB", (len(images) * (width + gap) - gap, max(image.height for image in images)), PAPER)
    for i, image in enumerate(images):
        whole.paste(image, (i * (width + gap), 0))
    whole.save(path, quality=90, optimize=True)


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
