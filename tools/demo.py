# SPDX-License-Identifier: GPL-3.0-or-later
"""./run demo: renders blend_scenes/ without and with edits and lays out sheets, plots and a report.

Each picture gets the same time; progress is printed as it comes. Exit code 1 if a scene failed."""

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
SCENES = {"glass_egg": "The caustic of a glass egg, moved to the wall", "cornell": "Less red from the wall; a caustic copied twice, once in green",
          "window": "The sun's patch moved along the floor"}  # fmt: skip


def arguments():
    parser = argparse.ArgumentParser(prog="./run demo", description=__doc__)
    parser.add_argument("scenes", nargs="*", help=f"of {', '.join(SCENES)}; all if none is named")
    parser.add_argument("--out", type=Path, default=ROOT / "out/demo")
    parser.add_argument("--seconds", type=float, default=45, help="of rendering per picture (%(default)s)")
    parser.add_argument("--passes", type=int, default=0, help="per picture instead of a time: the same picture on any machine")
    parser.add_argument("--percent", type=int, default=100, help="of the scenes' resolution (%(default)s)")
    parser.add_argument("--engine", default="SLUICE", help="CYCLES shows the unedited scenes for comparison")
    parsed = parser.parse_args()
    unknown = sorted(set(parsed.scenes) - set(SCENES))
    if unknown:
        parser.error(f"no scene {', '.join(unknown)} in blend_scenes/")
    return parsed


def show_progress(out: Path, name: str, shown: dict):
    """Prints an update of the render that is running, at most every five seconds."""
    for label in ("without", "with"):
        updates = progress_log.read(out / f"{name}_{label}.jsonl")
        if not updates or updates[-1]["seconds"] - shown.get(label, -5) < 5:
            continue
        last = updates[-1]
        shown[label] = last["seconds"]
        error = f", error {100 * last['error_estimate']:.2f} %" if last.get("error_estimate") else ""
        photons = last.get("photons", 0) / 1e6
        print(f"  {name} {label} edits: {last['seconds']:5.1f} s, pass {last['pass']}{error}, {photons:.1f} M photons", flush=True)


def render(name: str, options) -> str | None:
    """Renders a scene in a Blender of its own; returns what went wrong, if something did."""
    log = options.out / f"{name}.log"
    for label in ("without", "with"):
        (options.out / f"{name}_{label}.jsonl").unlink(missing_ok=True)
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


def account(name: str, out: Path) -> list[str]:
    """What ran, what was skipped and why, for the report."""
    told = json.loads((out / f"{name}.json").read_text())
    lines = [f"{name}: {SCENES[name]}", f"  Blender {told['blender']}, {told['engine']}, {told['resolution'][0]} x {told['resolution'][1]}"]
    lines += [f"  edit {sheet.caption(edit)}" for edit in told["edits"]]
    for label in ("without", "with"):
        updates = progress_log.read(out / f"{name}_{label}.jsonl")
        lines.append(f"  {label} edits: {told[label + '_seconds']:.1f} s in Blender")
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


def lay_out(name: str, out: Path) -> list[Path]:
    """The sheet and the plot of a scene that was rendered."""
    told = json.loads((out / f"{name}.json").read_text())
    curves = {f"{label} edits": progress_log.read(out / f"{name}_{label}.jsonl") for label in ("without", "with")}
    made = [out / f"{name}_sheet.png"]
    sheet.side_by_side(SCENES[name], [("Without edits", out / f"{name}_without.png"), ("With edits", out / f"{name}_with.png")],
                       [sheet.caption(edit) for edit in told["edits"]], made[0])  # fmt: skip
    if sheet.error_plot(f"{name}: error against time", curves, out / f"{name}_error.png"):
        made.append(out / f"{name}_error.png")
    return made


def main() -> int:
    options = arguments()
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    pictures, report, failures = [], [], []
    for name in options.scenes or SCENES:
        amount = f"{options.passes} passes" if options.passes else f"{options.seconds:g} s"
        print(f"{name}: two pictures, {amount} each", flush=True)
        problem = render(name, options)
        if problem:
            failures.append(name)
            report += [f"{name}: FAILED: {problem}", ""]
            print(f"  {problem}", flush=True)
            continue
        pictures += lay_out(name, options.out)
        report += [*account(name, options.out), ""]
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
