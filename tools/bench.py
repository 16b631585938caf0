# SPDX-License-Identifier: GPL-3.0-or-later
"""./run bench: speed on cornell.blend, and error against time beside Cycles on the box of tests/bench/. Tables go to out/bench/.

Wall clock moves by some percent from run to run: compare medians of several seeds (--seeds 8) on an idle machine."""

import argparse
import csv
import json
import os
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


def arguments():
    parser = argparse.ArgumentParser(prog="./run bench", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "out/bench")
    parser.add_argument("--seeds", type=int, default=1, help="renders per point (%(default)s)")
    parser.add_argument("--passes", type=int, nargs="+", default=[1, 4, 16, 64, 256])
    parser.add_argument("--samples", type=int, nargs="*", default=[16, 64, 256], help="of Cycles; none: leave it out")
    parser.add_argument("--photons", type=int, default=32768, help="per pass on the box (%(default)s)")
    parser.add_argument("--only", choices=("speed", "large", "small"), help="one part alone")
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
    for row in run(options.out, ROOT / "blend_scenes/cornell.blend", task="speed", scene="cornell", passes=16, photons=131072):
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


def medians(rows: list[dict], renderer: str, column: str) -> list[tuple[float, float]]:
    """(seconds, error) per amount of work: medians over the seeds, in the order of time."""
    by_work = {}
    for row in rows:
        if row["renderer"] == renderer:
            by_work.setdefault(row["work"], []).append(row)
    return sorted((statistics.median(r["seconds"] for r in group), statistics.median(r[column] for r in group)) for group in by_work.values())


def error(options, lamp: str) -> list[dict]:
    """Error against time on the box."""
    rows = run(options.out, None, task="box", scene=f"box_{lamp}", lamp=lamp, seeds=options.seeds, passes=options.passes, samples=options.samples,
               photons=options.photons)  # fmt: skip
    print(f"  {'':7} {'work':>12} {'seed':>4} {'seconds':>8} {'relMSE':>10} {'trimmed':>10} {'mean':>7}")
    for r in rows:
        print(f"  {r['renderer']:7} {r['work']:>12} {r['seed']:>4} {r['seconds']:8.2f} {r['relmse']:10.5f} {r['trimmed']:10.5f} {r['mean']:7.4f}")
    if lamp == "large":
        ours = medians(rows, "Sluice", "relmse")
        for _, seconds, target in box.FLOOR:
            found = box.seconds_to(ours, target)
            cost = f"{found:.2f} s, {seconds / found:.2f} times as fast" if found else "not reached"
            print(f"  relMSE {target:g}: floor {seconds:g} s, Sluice {cost}")
    plot(rows, lamp, options.out / f"box_{lamp}.png")
    return rows


def plot(rows: list[dict], lamp: str, path: Path):
    figure, axes = plt.subplots(figsize=(7, 5), dpi=110)
    for renderer, color in (("Sluice", "#b4407e"), ("Cycles", "#7a8794")):
        for column, style in (("relmse", "-o"), ("trimmed", ":o")):
            points = medians(rows, renderer, column)
            if points:
                label = renderer if column == "relmse" else f"{renderer}, without the worst 0.1 %"
                axes.loglog(*zip(*points, strict=True), style, color=color, markersize=4, label=label)
    if lamp == "large":
        axes.loglog([s for _, s, _ in box.FLOOR], [e for _, _, e in box.FLOOR], "--", color="black", linewidth=1, label="floor")
    axes.set(xlabel=f"seconds ({os.cpu_count()} threads)", ylabel="relMSE", title=f"Box, {lamp} lamp")
    axes.legend(frameon=False)
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)


def main() -> int:
    options = arguments()
    options.out = options.out.resolve()
    options.out.mkdir(parents=True, exist_ok=True)
    made = []
    try:
        if options.only in (None, "speed"):
            write_csv(options.out / "speed.csv", speed(options))
            made.append("speed.csv")
        lamps = [lamp for lamp in box.LAMPS if options.only in (None, lamp)]
        rows = [row for lamp in lamps for row in error(options, lamp)]
        if rows:
            write_csv(options.out / "error.csv", rows)
            made += ["error.csv", *(f"box_{lamp}.png" for lamp in lamps)]
    except RuntimeError as problem:
        print(f"FAILED: {problem}")
        return 1
    print("Kept: " + ", ".join(str(options.out / name) for name in made))
    return 0


if __name__ == "__main__":
    sys.exit(main())
