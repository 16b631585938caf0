# SPDX-License-Identifier: GPL-3.0-or-later
"""Do two machines (Blenders, Debians) make the same pictures? Compares demos rendered on both with the same seeds, block by block:

    for seed in 1 2 3 4 5 6 7 8; do ./run demo --out DIR/$seed --seed $seed --passes 8 --percent 25; done     on each of the two
    ./run python tools/compare_demos.py DIR_A DIR_B

Of every seed the EXRs' block means of Combined are subtracted, and the differences asked whether their mean is 0 (Student's t over the
seeds, Sidak over all blocks of all pictures). Equal seeds make most noise equal too, so this sees far less than the noise; what it sees
counts when it is more than --tolerance of the block or of the picture's mean. Exit code 1 if anything does. Frames of an animation
have no EXR and are compared as PNG."""

import argparse
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/python"))
from statistics_of_renders import blocks, student_quantile


def picture(path: Path) -> np.ndarray:
    """Rows, columns and linear colour of Combined; of a PNG its display values."""
    if path.suffix == ".png":
        return np.asarray(Image.open(path).convert("RGB"), float) / 255
    names = ",".join(f"ViewLayer.Combined.{c}" for c in "RGB")
    told = subprocess.run(["oiiotool", path, "--ch", names, "--dumpdata"], capture_output=True, text=True, check=True).stdout
    lines = [line for line in told.splitlines() if line.lstrip().startswith("Pixel")]
    where = [line.split("(", 1)[1].split(")", 1)[0].split(",") for line in (lines[-1],)]
    columns, rows = (int(n) + 1 for n in where[0])
    return np.array([line.split(":", 1)[1].split()[:3] for line in lines], float).reshape(rows, columns, 3)


def sets(folder: Path) -> dict[str, list[Path]]:
    """Pictures by name, each seed's."""
    seeds = sorted(item for item in folder.iterdir() if item.is_dir())
    exr = sorted(path.name for path in seeds[0].glob("*_with*.exr"))
    frames = sorted(path.name for path in seeds[0].glob("*_with*_0*.png"))
    return {name: [seed / name for seed in seeds] for name in exr + frames}


def compare(name: str, first: list[Path], second: list[Path], width: int):
    """Mean of both, mean difference, its standard error and the noise of one render, by block and colour."""
    a, b = (np.array([blocks(picture(path), width) for path in paths]) for paths in (first, second))
    difference = b - a
    return (a.mean(0) + b.mean(0)) / 2, difference.mean(0), difference.std(0, ddof=1) / np.sqrt(len(difference)), a.std(0, ddof=1)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs=2, type=Path, help="of demos, one folder a seed in each")
    parser.add_argument("--width", type=int, default=12, help="of a block in pixels (%(default)s)")
    parser.add_argument("--tolerance", type=float, default=0.5, help="percent (%(default)s)")
    options = parser.parse_args()
    first, second = map(sets, options.folders)
    if first.keys() != second.keys():
        print(f"only in one of them: {', '.join(sorted(first.keys() ^ second.keys()))}")
        return 1
    found = {name: compare(name, first[name], second[name], options.width) for name in first}
    tests, freedom = sum(mean.size for mean, *_ in found.values()), len(next(iter(first.values()))) - 1
    t = student_quantile(1 - (1 - 0.01) ** (1 / tests), freedom)
    print(f"{tests} block means, {freedom + 1} seeds; a difference must exceed {t:.1f} standard errors and {options.tolerance:g} %")
    bad = 0
    for name, (mean, difference, error, noise) in found.items():
        size = np.maximum(np.abs(mean), mean.mean())
        relative = difference / size
        real = (np.abs(difference) > t * error) & (np.abs(relative) > options.tolerance / 100)
        bad += int(real.sum())
        rms, grain = (100 * np.sqrt((part**2).mean()) for part in (relative, noise / size))
        print(f"{name:28} mean {100 * difference.mean() / mean.mean():+.3f} %, blocks {rms:.3f} % rms, worst {100 * np.abs(relative).max():.2f} %, "
              f"{int(real.sum())} differ (noise of a block in one render: {grain:.2f} %)")  # fmt: skip
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
