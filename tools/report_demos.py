# SPDX-License-Identifier: GPL-3.0-or-later
"""./run report --demos: what accuracy costs in each of blend_scenes/, small, as the table and the plot of docs/accuracy.md.

Pictures are 144 × 81 with 15 % of each scene's photons, 64 passes, and beside them references of 256 passes (report_render.py): about
five minutes on two cores."""

import re
import tempfile
import textwrap
from pathlib import Path

import report_figures
import report_measures as measures
import report_page
import report_plots
from demo import SCENES

WIDTH, PHOTONS_PERCENT, PASSES = 144, 15, 64
SHOWN = (1, 4, 16, 64)
FULL_WIDTH = {"animation": 480}  # of a scene; 960 else
BEGIN, END = "<!-- figures of ./run report --demos -->", "<!-- end of figures -->"


def task_of(root: Path, name: str) -> dict:
    return {"name": name, "scene": str(root / f"blend_scenes/{name}.blend"), "frame": None, "passes": PASSES, "seed": None,
            "percent": 100 * WIDTH / FULL_WIDTH.get(name, 960), "photons_percent": PHOTONS_PERCENT, "reference": "auto", "reference_name": "auto",
            "reference_frame": None, "reference_factor": 4, "neighbours": False}  # fmt: skip


def row_of(report: dict) -> dict:
    """A scene's figures."""
    at = {row["pass"]: row for row in report["checkpoints"]}
    beside = {passes: at[passes]["against"] for passes in SHOWN}
    costs = {target: measures.cost(report["accuracy"], target) for target in (0.05, 0.02)}
    return {"name": report["name"], "true": {passes: told["true_without_reference_noise"] for passes, told in beside.items()},
            "estimated": {passes: at[passes]["error"] for passes in SHOWN}, "bias": at[PASSES]["bias"], "seconds": at[PASSES]["seconds"],
            "rays": at[PASSES]["rays"] / PASSES, "costs": costs, "cause": report["main_cause"], "reference": report["reference"]}  # fmt: skip


def cost_words(found: dict | None) -> str:
    """Passes and seconds; ~ where they are extrapolated."""
    if found is None:
        return "–"
    about = "" if found["measured"] else "~"
    return f"{about}{found['pass']:,} passes, {about}{report_page.seconds(found['seconds'])}"


def percent(value: float | None) -> str:
    return "–" if value is None else f"{100 * value:.1f}"


def table(rows: list[dict]) -> str:
    """True error and, in brackets, the render's own estimate, in percent."""
    heads = ["scene", *(f"{passes} passes" if passes > 1 else "1 pass" for passes in SHOWN)]
    heads += ["rays per pass", "seconds", "to 5 %", "to 2 %", "main cause"]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for row in rows:
        errors = [percent(row["true"][passes]) + (f" ({percent(row['estimated'][passes])})" if row["estimated"][passes] else "") for passes in SHOWN]
        cause = f"{row['cause'][0]}, {100 * row['cause'][1]:.0f} %" if row["cause"] else "–"
        cells = [f"`{row['name']}`", *errors, report_page.number(row["rays"]), f"{row['seconds']:.1f}", cost_words(row["costs"][0.05]),
                 cost_words(row["costs"][0.02]), cause]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def ratios(rows: list[dict]) -> str:
    """What holds of all scenes together."""
    def middle(values):
        return sorted(values)[len(values) // 2]

    falls = [row["true"][SHOWN[i]] / row["true"][SHOWN[i + 1]] for row in rows for i in range(len(SHOWN) - 1) if row["true"][SHOWN[i + 1]]]
    pairs = [(row["estimated"][passes], row["true"][passes]) for row in rows for passes in SHOWN]
    trust = sorted(estimated / true for estimated, true in pairs if estimated and true)
    return (f"Four times the passes divide the error by {min(falls):.1f} to {max(falls):.1f}, {middle(falls):.1f} in the middle. The estimate is "
            f"{trust[0]:.2f} to {trust[-1]:.2f} times the true error, {middle(trust):.2f} in the middle.")  # fmt: skip


def document(text: str, rows: list[dict], processor: str) -> str:
    """docs/accuracy.md with new figures between its marks; lines as wide as its other text."""
    words = [f"Seconds are of one machine ({processor}); passes, rays and ratios are of all.", ratios(rows)]
    wrapped = "\n".join(line for each in words for line in textwrap.wrap(each, 140))
    figures = f"{BEGIN}\n{table(rows)}\n\n{wrapped}\n{END}"
    return re.sub(f"{re.escape(BEGIN)}.*?{re.escape(END)}", lambda _: figures, text, flags=re.DOTALL)


def write(root: Path, render, processor: str) -> Path:
    """Renders all scenes and writes the text and the plot, once all are there."""
    rows = []
    for name in SCENES:
        print(name, flush=True)
        task = task_of(root, name)
        with tempfile.TemporaryDirectory(prefix="sluice_report_") as folder:
            render(task, Path(folder))
            rows.append(row_of(report_figures.figures(Path(folder), task, processor)))
    text = root / "docs/accuracy.md"
    text.write_text(document(text.read_text(), rows, processor))
    report_plots.demo_plot(rows, root / "docs/accuracy.png")
    return text
