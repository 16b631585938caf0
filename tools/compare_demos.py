# SPDX-License-Identifier: GPL-3.0-or-later
"""Do two machines (Blenders, Debians) make the same pictures? Compares demos rendered on both with the same seeds, block by block:

    for seed in 1 2 3 4; do ./run demo --out DIR/$seed --seed $seed --passes 8 --percent 25; done     on each of the two
    ./run python tools/compare_demos.py DIR_A DIR_B

Of every seed the block means of Combined are subtracted, and the differences asked whether their mean is 0: Student's t over the seeds,
Sidak over all blocks of all pictures, the spread that of the whole picture or of the block, whichever is more (paths that part after a
rounding are few and far between). Equal seeds make most of the noise equal too, so this sees far less than the noise. What it sees counts
when it is more than --tolerance. Exit code 1 if anything does, or if a difference of that size could mostly not be seen. Frames of an
animation have no EXR and are compared as PNG."""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/python"))
from statistics_of_renders import blocks, student_quantile

ALARM = 0.01  # of a false one, over everything


def picture(path: Path) -> np.ndarray:
    """Rows, columns and linear colour of Combined; of a PNG its display values."""
    if path.suffix == ".png":
        return np.asarray(Image.open(path).convert("RGB"), float) / 255
    with tempfile.TemporaryDirectory() as folder:
        planes = [Path(folder) / f"{c}.tif" for c in "RGB"]
        for plane in planes:
            command = ["oiiotool", path, "--ch", f"ViewLayer.Combined.{plane.stem}", "-d", "float", "--compression", "none", "-o", plane]
            subprocess.run(command, check=True)
        return np.dstack([np.asarray(Image.open(plane), float) for plane in planes])


def sets(folder: Path) -> dict[str, list[Path]]:
    """Pictures by name, each seed's."""
    seeds = sorted(item for item in folder.iterdir() if item.is_dir())
    names = [path.name for kind in ("*_with*.exr", "*_with*_0*.png") for path in sorted(seeds[0].glob(kind))]
    return {name: [seed / name for seed in seeds] for name in names}


def whole(image: np.ndarray, width: int) -> np.ndarray:
    """Without the rest that fills no block."""
    rows, columns = (side // width * width for side in image.shape[:2])
    return image[:rows, :columns]


def compare(first: list[Path], second: list[Path], width: int):
    """Of each block and colour the mean relative difference; its standard error; the noise of a block in one render."""
    a, b = (np.array([blocks(whole(picture(path), width), width) for path in paths]) for paths in (first, second))
    size = np.maximum((a.mean(0) + b.mean(0)) / 2, a.mean())  # a dark block counts as one of the picture's mean
    spread, noise = ((c / size).var(0, ddof=1) for c in (b - a, a))
    return ((b - a) / size).mean(0), np.sqrt(np.maximum(spread, spread.mean()) / len(a)), np.sqrt(noise.mean())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs=2, type=Path, help="of demos, one folder a seed in each")
    parser.add_argument("--width", type=int, default=15, help="of a block in pixels (%(default)s)")
    parser.add_argument("--tolerance", type=float, default=1.0, help="percent (%(default)s)")
    options = parser.parse_args()
    first, second = map(sets, options.folders)
    if first.keys() != second.keys():
        print(f"only in one of them: {', '.join(sorted(first.keys() ^ second.keys()))}")
        return 1
    found = {name: compare(first[name], second[name], options.width) for name in first}
    seeds, tests, bad = len(next(iter(first.values()))), sum(relative.size for relative, *_ in found.values()), 0
    print(f"{tests} block means of {len(found)} pictures, {seeds} seeds; percent of a block, or of the picture's mean where that is more")
    print(f"{'':28}{'mean':>8}{'rms':>8}{'worst':>8}{'seen from':>11}{'one render’s noise':>20}")
    for name, (relative, error, noise) in found.items():
        limits = np.maximum(options.tolerance / 100, error * student_quantile(1 - (1 - ALARM) ** (1 / tests), relative.size * (seeds - 1)))
        differ, blind = int((np.abs(relative) > limits).sum()), np.median(limits) > 2 * options.tolerance / 100
        bad += differ > 0 or blind
        values = relative.mean(), np.sqrt((relative**2).mean()), np.abs(relative).max(), np.median(limits), noise
        told = "".join(f"{100 * value:{space}.3f}" for value, space in zip(values, (8, 8, 8, 11, 20), strict=True))
        print(f"{name:28}{told}" + (f"  {differ} DIFFER" if differ else "  TOO NOISY TO TELL" if blind else ""))
    print(f"{bad} pictures differ or are too noisy" if bad else "the same pictures")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
