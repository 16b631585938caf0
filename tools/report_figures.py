# SPDX-License-Identifier: GPL-3.0-or-later
"""From what tools/report_render.py leaves in a folder to the figures of a report: the contents of report.json."""

import json
import math
import platform
from pathlib import Path

import numpy as np
import report_measures as measures

NEIGHBOURS = {"main": "as it is", "half_photons": "photons × ½", "double_photons": "photons × 2", "not_adaptive": "adaptive sampling off",
              "narrower": "caustic radius × 0.7", "wider": "caustic radius × 1.4"}  # fmt: skip
WORK = ("rays", "shadow_rays", "photon_paths", "photons_stored", "view_paths", "gathers", "photons_gathered", "edit_queries")


def pictures(folder: Path, name: str) -> np.ndarray:
    return np.load(folder / f"{name}.npy")


def estimate(run: dict) -> dict:
    """What a render says of itself at its end. The error is measured after every four passes; for those that came later it is taken to have
    fallen by the laws of noise and bias."""
    found = run["statistics"]["accuracy"]
    if not found:
        return {"error": None, "noise": None, "bias": None}
    less = found[-1]["pass"] / run["passes"]
    noise, bias = found[-1]["noise"] * less**0.5, found[-1]["bias"] * less ** (-measures.BIAS_FALLS / 2)
    return {"error": math.hypot(noise, bias), "noise": noise, "bias": bias}


def work_of(run: dict) -> dict:
    told = run["statistics"]
    return {"seconds": told["seconds"]["photons"] + told["seconds"]["view"], "rays": told["rays"], "photons": told["photon_paths"],
            "work": told["rays"] + told["photon_paths"]}  # fmt: skip


def reference_of(raw: dict, folder: Path, task: dict) -> dict | None:
    """Where the reference is from, and what it says of its own error."""
    if task["reference"] is None:
        return None
    run = next((run for run in raw["runs"] if run["name"] == "reference"), None)
    if run is None:
        return {"from": task["reference_name"], "passes": None, "seconds": None, "error": None, "noise": None, "bias": None}
    return {"from": "an independent render: another seed, kernels of caustics half as wide", "passes": run["passes"],
            "seconds": run["progress"]["seconds"], "seed": run["changes"]["seed"], **estimate(run)}  # fmt: skip


def checkpoints_of(main: dict, folder: Path, reference: dict | None) -> list[dict]:
    rows = []
    for kept in main["kept"]:
        beside = None
        if reference:
            beside = measures.against(pictures(folder, f"kept_{kept['pass']}"), pictures(folder, "reference"), reference["noise"])
        rows.append({**kept, "against": beside})
    return rows


def effects_of(raw: dict) -> list[dict]:
    """What each effect costs in one pass: by how much less a pass without it takes. Photons serve several effects, so rows do not add up."""
    runs = {run["name"]: run for run in raw["runs"]}

    def of_a_pass(run):
        done = work_of(run)
        return {"seconds": done["seconds"] / run["passes"], "rays": done["rays"] / run["passes"],
                "photons_stored": run["statistics"]["photons_stored"] / run["passes"], "bytes": run["progress"]["memory"]}  # fmt: skip

    whole, rows = of_a_pass(runs["main"]), []
    for name, ran, why in runs["main"]["statistics"]["effects"]:
        other = runs.get("without_" + name.replace(" ", "_"))
        costs = {key: whole[key] - of_a_pass(other)[key] if other else None for key in whole}
        rows.append({"name": name, "runs": ran, "why": why, **costs})
    return [*rows, {"name": "all together", "runs": True, "why": "", **whole}]


def alternatives_of(raw: dict, folder: Path, reference: dict | None) -> list[dict]:
    """Neighbouring settings after the same number of passes."""
    rows = []
    for run in raw["runs"]:
        if run["name"] in NEIGHBOURS:
            true = measures.true_error(pictures(folder, run["name"]), pictures(folder, "reference")) if reference else None
            rows.append({"name": NEIGHBOURS[run["name"]], "passes": run["passes"], **estimate(run), "true": true, **work_of(run),
                         **shares_of_time(run)})  # fmt: skip
    return measures.compare_settings(rows)


def shares_of_time(run: dict) -> dict:
    """How a render's time was shared between its two halves."""
    seconds = run["statistics"]["seconds"]
    both = seconds["photons"] + seconds["view"]
    return {"photon_seconds": seconds["photons"], "view_seconds": seconds["view"], "photon_share": seconds["photons"] / both if both else None}


def figures(folder: Path, task: dict, processor: str) -> dict:
    """All numbers of a report."""
    raw = json.loads((folder / "raw.json").read_text())
    main = raw["runs"][0]
    told, curve = main["statistics"], main["statistics"]["accuracy"]
    reference = reference_of(raw, folder, task)
    return {
        "name": task["name"], "scene": task["scene"], "frame": raw["frame"], "size": raw["size"], "processor": processor,
        "versions": {"sluice": raw["core"], "blender": raw["blender"], "python": platform.python_version(), "numpy": np.__version__},
        "settings": raw["settings"], "threads": told["threads"], "warnings": raw["warnings"], "unmet": told["unmet"],
        "seconds": {**told["seconds"], "whole": main["progress"]["seconds"]}, "memory": main["progress"]["memory"],
        "work": {key: told[key] for key in WORK}, "bytes_per_photon": told["bytes_per_photon"], "radius": told["radius"],
        "main_cause": main["progress"]["main_cause"], "stop_reason": main["progress"]["stop_reason"], "edits": told["edits"],
        "reference": reference, "flip": "measured" if measures.flip_module() else "flip-evaluator is not in .venv (./run setup puts it there)",
        "checkpoints": checkpoints_of(main, folder, reference), "accuracy": curve,
        "slopes": {key: measures.slope(curve, key) for key in ("error", "noise", "bias")}, "costs": measures.costs(curve),
        "effects": effects_of(raw), "balance": shares_of_time(main), "alternatives": alternatives_of(raw, folder, reference),
    }  # fmt: skip
