# SPDX-License-Identifier: GPL-3.0-or-later
"""./run bench: speed on cornell.blend, what edits cost, how soon rendered mode follows a hand, and error against time beside Cycles on
the box of tests/bench/. Tables go to out/bench/.

Wall clock moves by some percent from run to run: compare medians of several seeds (--seeds 8) on an idle machine."""

import argparse
import csv
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/bench"))
import box
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

EGG = ROOT / "blend_scenes/glass_egg.blend"
CORNELL = ROOT / "blend_scenes/cornell.blend"
EDITS = ROOT / "tests/bench/edits.py"


def arguments():
    parser = argparse.ArgumentParser(prog="./run bench", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "out/bench")
    parser.add_argument("--seeds", type=int, default=1, help="renders per point (%(default)s)")
    parser.add_argument("--passes", type=int, nargs="+", default=[1, 4, 16, 64, 256])
    parser.add_argument("--samples", type=int, nargs="*", default=[16, 64, 256], help="of Cycles; none: leave it out")
    parser.add_argument("--photons", type=int, default=16384, help="per pass on the box (%(default)s)")
    parser.add_argument("--only", choices=("speed", "edits", "drag", "large", "small", "cornell"), help="one part alone")
    parser.add_argument("--make-reference", type=int, metavar="PASSES", help="render tests/bench/cornell.npy anew (4096: minutes), and nothing else")
    parser.add_argument("--record", action="store_true", help="add rows of error and of edits to tables in tests/bench/, with commit and processor")
    return parser.parse_args()


def run(out: Path, file: Path | None, **task) -> list[dict]:
    """One task in a Blender of its own; its rows. Raises if Blender did."""
    rows = out / f"{task['task']}_{task['scene']}.jsonl"
    rows.unlink(missing_ok=True)
    log = rows.with_suffix(".log")
    command = ["blender", "--addons", "sluice", "-b", *([file] if file else []), "--python-exit-code", "1",
               "--python", ROOT / "tools/bench_render.py", "--", json.dumps({**task, "rows": str(rows)})]  # fmt: skip
    print(f"{task['scene']} …", flush=True)
    with open(log, "w") as output:
        code = subprocess.run(command, stdout=output, stderr=subprocess.STDOUT, env=os.environ).returncode
    if code or not rows.exists():
        raise RuntimeError(f"Blender ended with {code}; see {log}")
    return [json.loads(line) for line in rows.read_text().splitlines()]


def write_csv(path: Path, rows: list[dict]):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)))
        writer.writeheader()
        writer.writerows(rows)


def speed(options) -> list[dict]:
    """Rates of the core on cornell.blend."""
    rows = []
    for row in run(options.out, CORNELL, task="speed", scene="cornell", passes=16, photons=131072):
        counters = row.pop("statistics")
        flat = {"scene": row["scene"], "edits": row["edits"], "passes": row["passes"], "seconds": round(row["seconds"], 3),
                "seconds_per_pass": round(row["seconds"] / row["passes"], 4)}  # fmt: skip
        flat |= {f"{phase}_s": round(seconds, 3) for phase, seconds in counters["seconds"].items()}
        for name in ("rays", "photon_paths", "view_paths", "gathers", "photons_gathered", "edit_queries"):
            flat[f"{name}_per_s"] = round(counters[name] / row["seconds"])
        flat["bytes_per_photon"] = round(counters["bytes_per_photon"], 1)
        flat["core_MiB"], flat["peak_process_MiB"] = round(row["core_memory"] / 2**20), round(row["peak_rss"] / 2**20)
        flat["error_estimate"] = row["estimate"]
        rows.append(flat)
        print("  " + ", ".join(f"{key} {value:,}" if isinstance(value, int) else f"{key} {value}" for key, value in flat.items()))
    return rows


def instructions(*task) -> int:
    """Of a whole run of tests/bench/edits.py: the same each time, whatever else the machine does."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", sys.executable, EDITS, *map(str, task)]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "PYTHONHASHSEED": "0"})  # Python's own work is the same too
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or not found:
        raise RuntimeError(f"valgrind ended with {done.returncode}: {done.stderr[-500:]}")
    return int(found[1])


def edits(_) -> list[dict]:
    """Instructions and seconds of a pass, with edits that no light can match and with edits that a tenth of all segments ask for, these in
    two sizes of the picture."""
    counts = shutil.which("valgrind")
    if not counts:
        print("  valgrind is missing (apt-get install valgrind): seconds alone")
    rows = []
    tasks = [("none", 0), *((kind, 10**power) for kind in ("none", "tenth") for power in range(4)), *(("fine", count) for count in (0, 10, 1000))]
    for kind, count in tasks:
        command = [sys.executable, EDITS, str(count), kind, "4"]
        runs = [subprocess.run(command, check=True, capture_output=True, text=True).stdout.split() for _ in range(3)]
        seconds = statistics.median(float(run[2]) for run in runs) / 4
        row = {"kind": kind, "edits": count, "asking": float(runs[0][0]), "seconds_per_pass": round(seconds, 4)}
        if counts:
            row["instructions_per_pass"] = instructions(count, kind, 2) - instructions(count, kind, 1)
        first = next((other for other in rows if other["edits"] == 0 and (other["kind"] == "fine") == (kind == "fine")), row)
        row |= {name.replace("per_pass", "ratio"): round(row[name] / first[name], 3) for name in list(row) if name.endswith("per_pass")}
        rows.append(row)
        print("  " + ", ".join(f"{key} {value:,}" if isinstance(value, int) else f"{key} {value}" for key, value in row.items()), flush=True)
    return rows


def drag(options) -> list[dict]:
    """Rendered mode: seconds from a change to the first image of it."""
    rows = run(options.out, EGG, task="drag", scene="glass_egg", width=960, height=540, turns=10)
    for what, said in (("drag", "an exit is dragged"), ("orbit", "the view turns"), ("copy", "a thing moves")):
        seconds = [row["seconds"] for row in rows if row["what"] == what]
        print(f"  {said} → first image: median {statistics.median(seconds):.3f} s, best {min(seconds):.3f} s")
    return rows


def medians(rows: list[dict], renderer: str, column: str) -> list[tuple[float, float]]:
    """(seconds, error) per amount of work: medians over the seeds, in the order of time."""
    by_work = {}
    for row in rows:
        if row["renderer"] == renderer:
            by_work.setdefault(row["work"], []).append(row)
    return sorted((statistics.median(r["seconds"] for r in group), statistics.median(r[column] for r in group)) for group in by_work.values())


def build_prototype() -> str:
    build = Path(os.environ["PYTHONPATH"].split(":")[0])
    subprocess.run(["cmake", "--build", build, "--target", "prototype"], check=True, stdout=subprocess.DEVNULL)
    return str(build / "prototype")


def compare_with_floor(rows: list[dict]):
    """The floor as it was written down, and Sluice's time to that error; the same prototype on this machine in this run, and Sluice's time to
    the error that it reached here. What is measured here holds the scene's set-up."""
    ours = medians(rows, "Sluice", "relmse")
    for (passes, seconds, target), (here, reached) in zip(box.FLOOR, medians(rows, "Prototype", "relmse"), strict=True):
        print(f"  {passes} passes of the prototype:")
        for what, floor, error in (("written", seconds, target), ("here", here, reached)):
            found = box.seconds_to(ours, error)
            said = f"{found:.2f} s, {floor / found:.2f} times as fast" if found else "not reached"
            print(f"    {what}: relMSE {error:.5f} in {floor:.2f} s; Sluice {said}")


def error(options, scene: str) -> list[dict]:
    """Error against time on one scene."""
    work = {"seeds": options.seeds, "passes": options.passes, "samples": options.samples, "photons": options.photons}
    if scene == "cornell":
        rows = run(options.out, CORNELL, task="cornell", scene=scene, **work)
    else:
        if scene == "box_large":
            work |= {"prototype": build_prototype(), "prototype_passes": [passes for passes, _, _ in box.FLOOR]}
        rows = run(options.out, None, task="box", scene=scene, lamp=scene.removeprefix("box_"), **work)
    print(f"  {'':9} {'work':>12} {'seed':>4} {'seconds':>8} {'relMSE':>10} {'trimmed':>10} {'mean':>7}")
    for r in rows:
        print(f"  {r['renderer']:9} {r['work']:>12} {r['seed']:>4} {r['seconds']:8.2f} {r['relmse']:10.5f} {r['trimmed']:10.5f} {r['mean']:7.4f}")
    if scene == "box_large":
        compare_with_floor(rows)
    plot(rows, scene, options.out / f"{scene}.png")
    return rows


def plot(rows: list[dict], scene: str, path: Path):
    figure, axes = plt.subplots(figsize=(7, 5), dpi=110)
    for renderer, color in (("Sluice", "#b4407e"), ("Cycles", "#7a8794"), ("Prototype", "black")):
        for column, style in (("relmse", "-o"), ("trimmed", ":o")):
            points = medians(rows, renderer, column)
            if points:
                label = renderer if column == "relmse" else f"{renderer}, without the worst 0.1 %"
                axes.loglog(*zip(*points, strict=True), style, color=color, markersize=4, label=label)
    if scene == "box_large":
        axes.loglog([s for _, s, _ in box.FLOOR], [e for _, _, e in box.FLOOR], "--", color="black", linewidth=1, label="floor")
    axes.set(xlabel=f"seconds ({os.cpu_count()} threads)", ylabel="relMSE", title=scene)
    axes.legend(frameon=False)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def processor() -> str:
    names = [line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
    return f"{names[0] if names else 'unknown'}, {os.cpu_count()} threads"


def record(rows: list[dict], name: str):
    """Adds rows to a committed table."""
    path = ROOT / "tests/bench" / name
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    old = list(csv.DictReader(path.open())) if path.exists() else []
    write_csv(path, old + [{"commit": commit, "processor": processor(), **row} for row in rows])


def measure(options) -> list[str]:
    """All parts that were asked for; the files they left."""
    made = []
    if options.only in (None, "speed"):
        write_csv(options.out / "speed.csv", speed(options))
        made.append("speed.csv")
    if options.only in (None, "edits"):
        print("edits …", flush=True)
        rows = edits(options)
        write_csv(options.out / "edits.csv", rows)
        made.append("edits.csv")
        if options.record:
            record(rows, "edits.csv")
    if options.only in (None, "drag"):
        write_csv(options.out / "drag.csv", drag(options))
        made.append("drag.csv")
    scenes = [scene for scene in ("box_large", "box_small", "cornell") if options.only is None or scene.endswith(options.only)]
    if "cornell" in scenes and not box.CORNELL.exists():
        print("cornell: skipped, no reference (make one: ./run bench --make-reference 4096)")
        scenes.remove("cornell")
    rows = [row for scene in scenes for row in error(options, scene)]
    if rows:
        write_csv(options.out / "error.csv", rows)
        made += ["error.csv", *(f"{scene}.png" for scene in scenes)]
        if options.record:
            record(rows, "results.csv")
    return made


def main() -> int:
    options = arguments()
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    try:
        if options.make_reference:
            print(run(options.out, CORNELL, task="cornell_reference", scene="cornell", passes=options.make_reference)[0])
            return 0
        made = measure(options)
    except RuntimeError as problem:
        print(f"FAILED: {problem}")
        return 1
    print("Kept: " + ", ".join(str(options.out / name) for name in made))
    return 0


if __name__ == "__main__":
    sys.exit(main())
