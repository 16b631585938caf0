# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoises a picture by the Python package pyoidn, which brings Open Image Denoise, if somebody has installed it for Blender's Python.

The package works in a process of its own (denoise_process.py): its libraries and those of Blender are other versions of the same ones, and
within Debian's Blender they end it, with the picture."""
from __future__ import annotations

import importlib
import importlib.util
import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import bpy
import numpy as np

from . import passes

PACKAGE = "pyoidn"
ITEM = "Denoise"  # the name under which warnings tell of it
MISSING = f"The Python package {PACKAGE} is not there: Set Up Denoising tells how to install it"  # for panels, which wrap lines
_NEEDS = ("cffi", "pycparser")  # what the package needs beside NumPy, which Blender has and no other version may hide
_PATIENCE = 600.0  # Seconds that the process may take; 4K takes half a minute on two cores.


class Failed(Exception):
    """Why a picture was not denoised."""


def is_there() -> bool:
    """Can Blender's Python import the package? It is looked for anew, as it may have been installed meanwhile."""
    importlib.invalidate_caches()
    return importlib.util.find_spec(PACKAGE) is not None


def missing() -> str:
    """What to do to get the package, as one sentence."""
    folder = bpy.utils.user_resource('SCRIPTS', path="addons/modules")
    return (f"the Python package {PACKAGE} is not there, so pictures stay as they are rendered. Install it with: "
            f"{_python()} -m pip install --target \"{folder}\" --no-deps {' '.join((PACKAGE, *_NEEDS))}")


def denoise(images: Mapping[str, np.ndarray]) -> np.ndarray:
    """The picture Combined denoised, its alpha as it was. Albedo and Normal guide it where they are among the images, all of which are
    (rows, columns, channels). Raises Failed."""
    picture = images["Combined"]
    parts = {"color": picture[..., :3], **{name.lower(): images[name] for name in passes.GUIDES if name in images}}
    shape = parts["color"].shape
    head = {"path": _path(), "package": PACKAGE, "shape": shape, "images": list(parts)}
    data = [json.dumps(head).encode() + b"\n", *(np.ascontiguousarray(part, np.float32).tobytes() for part in parts.values())]
    denoised = np.frombuffer(_run(b"".join(data)), np.float32)
    if denoised.size != picture[..., :3].size or not np.isfinite(denoised).all():
        raise Failed(f"the package {PACKAGE} gave no picture")
    result = picture.copy()
    result[..., :3] = denoised.reshape(shape)
    return result


def _run(data: bytes) -> bytes:
    """What the process answers."""
    program = Path(__file__).with_name("denoise_process.py")
    try:
        done = subprocess.run([_python(), "-I", str(program)], input=data, capture_output=True, timeout=_PATIENCE, check=False)
    except (OSError, subprocess.SubprocessError) as error:
        raise Failed(f"the package {PACKAGE} does not run: {error}") from error
    if done.returncode != 0:
        told = done.stderr.decode(errors="replace").strip().splitlines()
        raise Failed(f"the package {PACKAGE} failed: {told[-1] if told else f'exit code {done.returncode}'}")
    return done.stdout


def _path() -> list[str]:
    """Where the process finds packages: first where this one lies, as those that it needs lie there too and others may have other versions."""
    found = importlib.util.find_spec(PACKAGE)
    first = [str(Path(place).parent) for place in found.submodule_search_locations or ()] if found else []
    return first + sys.path


def _python() -> str:
    """The Python that Blender has inside, as a program. What PATH calls so may be another one."""
    own = Path(sys.prefix, "bin", f"python{sys.version_info[0]}.{sys.version_info[1]}")
    return str(own) if own.exists() else sys.executable
