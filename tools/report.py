# SPDX-License-Identifier: GPL-3.0-or-later
"""./run report SCENE.blend: what accuracy costs in a scene, as numbers (report.json) and as a page that needs no other file (index.html).

Renders the scene once with pictures kept after 1, 2, 4, … passes, a reference if one is asked for, the same under neighbouring settings,
and a few passes without each effect. --compare lays two reports side by side; --demos writes docs/accuracy.md."""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import report_demos
import report_figures
import report_page
from bench import processor

ROOT = Path(__file__).resolve().parents[1]


class Refused(Exception):
    """Why there is no report, in one sentence."""


def arguments(given=None):
    parser = argparse.ArgumentParser(prog="./run report", description=__doc__)
    parser.add_argument("scene", nargs="?", type=Path, metavar="SCENE.blend")
    parser.add_argument("--frame", type=int, help="the file's own if it is not given")
    parser.add_argument("--passes", type=int, default=64, help="of the render (%(default)s)")
    parser.add_argument("--reference", metavar="FILE|auto",
                        help="a picture of the same size (.exr, or .npy with row 0 at the bottom); auto: an independent render of 4 times the passes")
    parser.add_argument("--seed", type=int, help="the scene's own if it is not given")
    parser.add_argument("--scale", type=float, default=100, metavar="PERCENT", help="of the scene's resolution (%(default)s)")
    parser.add_argument("--out", type=Path, default=ROOT / "out/report", help="a folder NAME comes into it")
    parser.add_argument("--compare", nargs=2, type=Path, metavar="REPORT.json", help="two reports side by side instead")
    parser.add_argument("--demos", action="store_true", help="all of blend_scenes/, small, for docs/accuracy.md instead")
    return parser.parse_args(given)


# --- rendering ---------------------------------------------------------------------------------------------------------------------


def checked_task(options) -> dict:
    """What tools/report_render.py is asked for, but for the folder and the reference's picture."""
    if options.scene is None:
        raise Refused("name a scene, as in ./run report blend_scenes/cornell.blend")
    if not options.scene.is_file():
        raise Refused(f"there is no file {options.scene}")
    if options.passes < 1:
        raise Refused(f"--passes must be at least 1, not {options.passes}")
    if not 0 < options.scale <= 400:
        raise Refused(f"--scale must be above 0 and at most 400 percent, not {options.scale:g}")
    reference = options.reference
    if reference not in (None, "auto") and not Path(reference).is_file():
        raise Refused(f"there is no reference {reference}")
    return {"name": options.scene.stem, "scene": str(options.scene.resolve()), "frame": options.frame, "passes": options.passes,
            "seed": options.seed, "percent": options.scale, "photons_percent": 100, "reference": reference, "reference_name": reference,
            "reference_frame": None, "reference_factor": 4, "neighbours": True}  # fmt: skip


def flat_reference(task: dict, folder: Path) -> dict:
    """Of an EXR the picture alone, which Blender can read, and the frame that its header tells."""
    path = task["reference"]
    if path in (None, "auto"):
        return task
    path = str(Path(path).resolve())
    if path.endswith(".npy"):
        return {**task, "reference": path}
    told = subprocess.run(["oiiotool", "--info", "-v", path], capture_output=True, text=True)
    found = re.search(r"channel list: (.*)", told.stdout)
    names = [name.split(" ")[0] for name in found[1].split(", ")] if found else []
    chosen = next((three for three in channels_of_pictures(names) if set(three) <= set(names)), None)
    if told.returncode or not chosen:
        raise Refused(f"the reference {task['reference_name']} is no picture with red, green and blue")
    flat = folder / "reference.exr"
    # Blender shows no pixels of a file that says it holds layers
    plain = ["--ch", ",".join(chosen), "--chnames", "R,G,B", "--eraseattrib", "BlenderMultiChannel", "-d", "float"]
    done = subprocess.run(["oiiotool", path, *plain, "-o", flat], capture_output=True, text=True)
    if done.returncode:
        raise Refused(f"the reference {task['reference_name']} cannot be read")
    frame = re.search(r'^\s*(?:Sluice frame|Frame): "(\d+)"', told.stdout, re.MULTILINE)
    return {**task, "reference": str(flat), "reference_frame": int(frame[1]) if frame else None}


def channels_of_pictures(names: list[str]) -> list[list[str]]:
    """Red, green and blue as files name them: alone, or as the picture of a layer."""
    layers = [name.removesuffix(".R") for name in names if name.endswith(".Combined.R")]
    return [["R", "G", "B"], *([f"{layer}.{channel}" for channel in "RGB"] for layer in layers)]


def render(task: dict, folder: Path):
    """Renders in a Blender of its own; raises with what went wrong."""
    task = flat_reference({**task, "folder": str(folder)}, folder)
    command = ["blender", "--addons", "sluice", "-b", task["scene"], "--python-exit-code", "1",
               "--python", ROOT / "tools/report_render.py", "--", json.dumps(task)]  # fmt: skip
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                               env={**os.environ, "SLUICE_PROGRESS_LOG": ""})  # fmt: skip
    lines = []
    for line in process.stdout:
        lines.append(line.strip())
        if line.startswith("report: "):
            print("  " + line[len("report: ") :], end="", flush=True)
    code, failure = process.wait(), folder / "failure.txt"
    if failure.exists():
        raise Refused(failure.read_text() or "Blender failed without a word")
    if code or not (folder / "raw.json").exists():
        told = [line for line in lines if "rror" in line] or lines
        raise Refused(f"Blender ended with {code} on {task['scene']}: {told[-1] if told else 'without a word'}")


# --- files -------------------------------------------------------------------------------------------------------------------------


def publish(files: dict[str, str], place: Path):
    """All files or none: they are written beside their place and renamed into it."""
    place.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{place.name}_", dir=place.parent) as folder:
        ready = Path(folder) / "ready"
        ready.mkdir()
        for name, text in files.items():
            (ready / name).write_text(text)
        if place.exists():
            for name in files:
                os.replace(ready / name, place / name)
        else:
            os.rename(ready, place)


def as_json(report: dict) -> str:
    return json.dumps(report, indent=1, ensure_ascii=False)


def report_scene(options) -> Path:
    """Renders and writes a report; its page."""
    task = checked_task(options)
    place = options.out / task["name"]
    print(f"{task['name']}: {task['passes']} passes, and what belongs to them", flush=True)
    with tempfile.TemporaryDirectory(prefix="sluice_report_") as temporary:
        folder = Path(temporary)
        render(task, folder)
        report = report_figures.figures(folder, task, processor())
        publish({"report.json": as_json(report), "index.html": report_page.page(report, folder)}, place)
    return place / "index.html"


def compare(options) -> Path:
    """Two reports side by side; the page."""
    reports = {}
    for path in options.compare:
        try:
            report = json.loads(path.read_text())
            name = report["name"] if report["name"] not in reports else f"{report['name']} ({path.parent})"
            reports[name] = report
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise Refused(f"{path} is no report.json of ./run report") from error
    try:
        page = report_page.compared(reports)
    except (KeyError, TypeError, IndexError) as error:
        raise Refused(f"{' and '.join(map(str, options.compare))} are not reports of this version of ./run report") from error
    place = options.out / ("compare_" + "_".join(report["name"] for report in reports.values()))
    publish({"index.html": page}, place)
    return place / "index.html"


def main() -> int:
    options = arguments()
    options.out = options.out.resolve()
    try:
        if options.demos:
            made = report_demos.write(ROOT, render, processor())
        else:
            made = compare(options) if options.compare else report_scene(options)
    except (Refused, OSError) as problem:
        print(f"report: {problem}", file=sys.stderr)
        return 1
    print(f"Report: {made}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
