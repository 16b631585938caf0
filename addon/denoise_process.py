# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoises one picture: a program that denoising.py starts beside Blender, with Blender's own Python. Nothing of Blender is here.

Its input is a line of JSON (`path`: where Python finds packages; `package`; `shape`: rows, columns and channels of each image; `images`:
their names) and then the images one after another, as float32. Its output is the picture alone, as float32."""
import importlib
import json
import os
import sys


def main() -> None:
    """Reads, denoises, writes."""
    output = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # What libraries print must not come between the numbers.
    task = json.loads(sys.stdin.buffer.readline())
    sys.path[:] = task["path"]
    import numpy as np
    size = 4 * task["shape"][0] * task["shape"][1] * task["shape"][2]
    images = {name: np.frombuffer(sys.stdin.buffer.read(size), np.float32).reshape(task["shape"]) for name in task["images"]}
    denoised = importlib.import_module(task["package"]).denoise(images.pop("color"), **images, hdr=True)
    with os.fdopen(output, "wb") as file:
        file.write(np.ascontiguousarray(denoised, np.float32).tobytes())


if __name__ == "__main__":
    main()
