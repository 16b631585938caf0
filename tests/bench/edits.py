# SPDX-License-Identifier: GPL-3.0-or-later
"""What edits cost: a closed box with a glass and a mirror ball and n quads in it, small enough to count instructions.

    ./run python tests/bench/edits.py EDITS KIND PASSES

EDITS entries of a centimetre, each with one exit that gives the light back in place, lie at random: what is counted is the asking, as few
segments cross any. KIND: `none` (no path of the scene spells their expressions), `tenth` (a tenth of all segments must know: those with
light that comes from the panel, and those from the eye; somewhat fewer ask, where one question answers for many), `fine` (these edits in a larger picture: a photon a pixel and pass instead of
seven, so that segments from the eye weigh more). Prints the share of segments that asked, the paths that were taken, and the
seconds of the passes. ./run bench --only edits makes the table, with instructions counted by valgrind."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
from scenes import Scene, diffuse, exit_at, glass, looking, mirror, quad, render

PHOTONS = 16384
SEAM = 0.35  # height at which the left wall ends and the panel begins: how large it is makes the tenth
EXPRESSIONS = {"none": "LS'Ball'D'Ball'", "tenth": "L.*D'Panel'", "fine": "L.*D'Panel'"}
SIDES = {"none": 48, "tenth": 48, "fine": 128}  # of the picture, pixels


def box(edits: int, kind: str) -> Scene:
    scene = Scene(size=SIDES[kind])
    grey = diffuse(0.6)
    for name, nodes, corners in (
        ("Floor", grey, [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)]), ("Ceiling", grey, [(-1, -1, 1), (-1, 1, 1), (1, 1, 1), (1, -1, 1)]),
        ("Back", grey, [(-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)]), ("Front", grey, [(-1, -1, -1), (-1, -1, 1), (1, -1, 1), (1, -1, -1)]),
        ("Left", diffuse((0.6, 0.2, 0.2)), [(-1, -1, -1), (-1, 1, -1), (-1, 1, SEAM), (-1, -1, SEAM)]),
        ("Panel", diffuse((0.6, 0.2, 0.2)), [(-1, -1, SEAM), (-1, 1, SEAM), (-1, 1, 1), (-1, -1, 1)]),
        ("Right", diffuse((0.2, 0.6, 0.2)), [(1, -1, -1), (1, -1, 1), (1, 1, 1), (1, 1, -1)]),
    ):  # fmt: skip
        scene.plane(name, corners, nodes)
    scene.sphere("Ball", (0.4, 0.2, -0.6), 0.35, glass(1.5), rings=32)
    scene.sphere("Mirror", (-0.45, 0.4, -0.6), 0.35, mirror(0.9), rings=32)
    scene.point((0, 0, 0.8), 40.0, radius=0.1)
    scene.perspective(looking((0, -0.95, 0), (0, 1, 0), (0, 0, 1)), 1.4)
    rng = np.random.default_rng(1)
    for i in range(edits):
        frame = np.linalg.qr(rng.normal(size=(3, 3)))[0] * np.array([[0.005], [0.005], [1.0]])
        place = dict(zip("xyz", frame, strict=True), place=rng.uniform(-0.9, 0.9, 3))
        scene.edit(EXPRESSIONS[kind], quad(**place), [exit_at(**place)], name=f"Edit {i}")
    return scene


if __name__ == "__main__":
    count, kind, passes = sys.argv[1:]
    done = render(box(int(count), kind), passes=int(passes), photons=PHOTONS, pilot_paths=1024, threads=1)
    counters = done.statistics
    print(f"{counters['edit_queries'] / counters['rays']:.4f} {sum(edit['matched'] for edit in counters['edits'])} {counters['seconds']['photons'] + counters['seconds']['view']:.4f}")
