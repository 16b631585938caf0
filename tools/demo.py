# SPDX-License-Identifier: GPL-3.0-or-later
"""./run demo: renders blend_scenes/ without and with edits and lays out a contact sheet, plots and a report.

Each picture gets the same time, each frame of an animated scene a sixth of it; progress is printed as it comes. Exit code 1 if a scene
failed."""

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import progress_log
import sheet

ROOT = Path(__file__).resolve().parents[1]
SCENES = {
    "fig1": "Figure 1. The wine's caustics leave the table for the wall; the mirror looks elsewhere",
    "fig3": "Figure 3. A caustic laid larger on the wall: with the light it had, and as bright as it was",
    "fig4": "Figure 4. A beam on three canvases: cut, coloured and rippled by textures",
    "fig5": "Figure 5. A caustic removed, one moved, one copied",
    "fig6": "Figure 6. What the green wall sheds turns red; the wall stays green",
    "fig7": "Figure 7. A caustic four times round its egg, which mirrors them",
    "fig8": "Figure 8. One square takes what comes through the ball, on its way to the table and to the eye",
    "rosette": "A caustic drawn on the wall in front of the eye, which looks through both squares",
    "glass_egg": "A first edit: a caustic moved to the wall",
    "cornell": "The red wall's bleeding dimmed; a caustic copied twice, once in green",
    "window": "Direct light: the sun's patch moved along the floor",
    "animation": "24 frames: the glass turns, its caustic travels along the wall and through the hues",
}
LABELS = {"without": "Without edits", "with": "With edits"}


def arguments():
    parser = argparse.ArgumentParser(prog="./run demo", description=__doc__)
    parser.add_argument("scenes", nargs="*", help=f"of {', '.join(SCENES)}; all if none is named")
    parser.add_argument("--out", type=Path, default=ROOT / "out/demo")
    parser.add_argument("--seconds", type=float, default=22, help="of rendering per picture (%(default)s)")
    parser.add_argument("--passes", type=int, default=0, help="per picture instead of a time: the same picture on any machine")
    parser.add_argument("--photons", type=int, default=0, help="per pass, instead of what each scene asks for")
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers (%(default)s)")
    parser.add_argument("--percent", type=int, default=100, help="of the scenes' resolution (%(default)s)")
    parser.add_argument("--frames", type=int, default=24, help="of an animated scene (%(default)s)")
    parser.add_argument("--engine", default="SLUICE", help="CYCLES shows the unedited scenes for comparison")
    parsed = parser.parse_args()
    unknown = sorted(set(parsed.scenes) - set(SCENES))
    if unknown:
        parser.error(f"no scene {', '.join(unknown)} in blend_scenes/")
    return parsed


def show_progress(out: Path, name: str, shown: dict):
    """Prints the updates of the render that is running: a line at most every five seconds of a picture."""
    for log in sorted(out.glob(f"{name}_with*.jsonl")):
        updates = progress_log.read(log)
        if not updates or updates[-1]["seconds"] - shown.get(log.stem, -5) < 5:
            continue
        last = updates[-1]
        shown[log.stem] = last["seconds"]
        error = f", error {100 * last['error_estimate']:.2f} %" if last.get("error_estimate") else ""
        photons = last.get("photons", 0) / 1e6
        print(f"  {log.stem}: {last['seconds']:5.1f} s, pass {last['pass']}{error}, {photons:.1f} M photons", flush=True)


def render(name: str, options) -> str | None:
    """Renders a scene in a Blender of its own; returns what went wrong, if something did."""
    log = options.out / f"{name}.log"
    for old in (options.out / f"{name}.json", *options.out.glob(f"{name}_with*.jsonl")):
        old.unlink(missing_ok=True)
    command = ["blender", "--addons", "sluice", "-b", ROOT / f"blend_scenes/{name}.blend", "--python-exit-code", "1",
               "--python", ROOT / "tools/demo_render.py", "--", json.dumps({**vars(options), "out": str(options.out)})]  # fmt: skip
    with open(log, "w") as file:
        process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT, env={**os.environ, "SLUICE_PROGRESS_LOG": ""})
        shown = {}
        while process.poll() is None:
            time.sleep(0.5)
            show_progress(options.out, name, shown)
    if process.returncode == 0 and (options.out / f"{name}.json").exists():
        return None
    lines = log.read_text(errors="replace").splitlines()
    tail = [line for line in lines if line.startswith("sluice: error")] or [line for line in lines if "rror" in line][-3:]
    return f"Blender ended with {process.returncode}; {' | '.join(tail) or 'see its log'} ({log})"


def told_by(name: str, out: Path) -> dict:
    """What tools/demo_render.py says of a scene that it rendered."""
    return json.loads((out / f"{name}.json").read_text())


def account(name: str, out: Path) -> list[str]:
    """What ran, what was skipped and why, for the report; of an animation the last frame."""
    told = told_by(name, out)
    lines = [f"{name}: {SCENES[name]}", f"  Blender {told['blender']}, {told['engine']}, {told['resolution'][0]} x {told['resolution'][1]}"]
    lines += [f"  edit {edit['expression']}  {sheet.in_words(edit)}" for edit in told["edits"]]
    for label, pictures in told["pictures"].items():
        updates = progress_log.read(out / f"{pictures[-1]['name']}.jsonl")
        frames = f", {len(pictures)} frames, the last of them:" if len(pictures) > 1 else ""
        lines.append(f"  {label} edits: {sum(picture['seconds'] for picture in pictures):.1f} s in Blender{frames}")
        if not updates:
            lines.append("    the engine left no progress log")
            continue
        last = updates[-1]
        error = f"{100 * last['error_estimate']:.2f} %" if last.get("error_estimate") else "unknown"
        lines.append(f"    {last['pass']} passes and {last.get('photons', 0):,} photon paths in {last['seconds']:.1f} s; estimated error {error}")
        lines.append(f"    an error of {progress_log.price_text(*progress_log.error_curve(updates))}   (~: not reached, by the slope)")
        lines.append(f"    stopped by: {last.get('stop_reason') or 'nothing: it ended before its time'}")
        lines += [f"    {line}" for line in last.get("statistics", {}).get("report", "").splitlines()]
        lines += [f"    warning: {item}: {message}" for item, message in last.get("warnings", [])]
    return lines


def row_of(name: str, out: Path) -> sheet.Row:
    """A scene's row of the contact sheet. Of an animation six frames, joined in a picture."""
    told = told_by(name, out)
    pictures = []
    for label, made in told["pictures"].items():
        path = out / f"{name}_{label}.png"
        if len(made) > 1:
            chosen = made[:: -(-len(made) // 6)]
            sheet.strip([(f"frame {picture['frame']}", out / f"{picture['name']}.png") for picture in chosen], path)
        pictures.append((LABELS[label], path if len(made) > 1 else out / f"{made[0]['name']}.png"))
    return sheet.Row(SCENES[name], f"blend_scenes/{name}.blend", pictures, told["edits"])


def lay_out(name: str, row: sheet.Row, out: Path) -> list[Path]:
    """The sheet and the plot of a scene that was rendered."""
    told = told_by(name, out)
    made = [out / f"{name}_sheet.png"]
    sheet.contact_sheet([row], made[0], width=960)
    sheet.pair(row, out / f"{name}_pair.jpg")
    curves = {f"{label} edits": progress_log.read(out / f"{pictures[-1]['name']}.jsonl") for label, pictures in told["pictures"].items()}
    if sheet.error_plot(f"{name}: error against time", curves, out / f"{name}_error.png"):
        made.append(out / f"{name}_error.png")
    return made


def main() -> int:
    options = arguments()
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    rows, pictures, report, failures = [], [], [], []
    for name in options.scenes or SCENES:
        amount = f"{options.passes} passes" if options.passes else f"{options.seconds:g} s"
        print(f"{name}: without and with edits, {amount} each", flush=True)
        problem = render(name, options)
        if problem:
            failures.append(name)
            report += [f"{name}: FAILED: {problem}", ""]
            print(f"  {problem}", flush=True)
            continue
        rows.append(row_of(name, options.out))
        pictures += lay_out(name, rows[-1], options.out)
        report += [*account(name, options.out), ""]
    if rows:
        pictures.append(options.out / "contact_sheet.png")
        sheet.contact_sheet(rows, pictures[-1], width=720)
    (options.out / "report.txt").write_text("\n".join(report))
    print("\n" + "\n".join(report))
    print(f"Pictures (PNG, multilayer EXR) and logs: {options.out}\nSheets and plots:")
    print("\n".join(f"  {path}" for path in pictures))
    print(f"Report: {options.out / 'report.txt'}")
    if failures:
        print(f"FAILED: {', '.join(failures)}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
