# SPDX-License-Identifier: GPL-3.0-or-later
"""./run and the build use Debian's Python, the one that Blender embeds, whatever other stands first on PATH."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DEBIANS = "/usr/bin/python3"
TELL = "import sys, numpy; print('home', sys.prefix, sys.version_info[:2])"


def virtual_environment(folder):
    """As python -m venv and virtualenv make them."""
    subprocess.run([DEBIANS, "-m", "venv", "--without-pip", folder], check=True)


def whole_python(folder):
    """As pyenv and conda lay them: a standard library of its own, nothing else in it."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    (folder / "bin").mkdir(parents=True)
    for name in ("python3", version):
        (folder / "bin" / name).write_text(f'#!/bin/sh\nexec {DEBIANS} "$@"\n')
        (folder / "bin" / name).chmod(0o755)
    (folder / "lib").mkdir()
    (folder / "lib" / version).symlink_to(f"/usr/lib/{version}")


@pytest.fixture(params=(virtual_environment, whole_python))
def foreign(request, tmp_path):
    """The environment of a shell in which another Python is active."""
    home = tmp_path / "other"
    request.param(home)
    (tmp_path / "numpy.py").write_text("raise ImportError('a foreign NumPy')\n")
    return {**os.environ, "PATH": f"{home}/bin:{os.environ['PATH']}", "PYTHONHOME": str(home), "PYTHONPATH": str(tmp_path),
            "VIRTUAL_ENV": str(home), "CONDA_PREFIX": str(home)}  # fmt: skip


def told(command, environment):
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return next(line for line in done.stdout.splitlines() if line.startswith("home"))


def test_blender_and_python_find_their_own_home(foreign):
    wanted = told([DEBIANS, "-I", "-c", TELL], {"PATH": "/usr/bin"})
    blender = [ROOT / "run", "blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python-expr"]
    assert told([*blender, f"{TELL}; from sluice import core; core.load()"], foreign) == wanted
    assert told([ROOT / "run", "python", "-c", f"{TELL}; import sluice_core"], foreign) == wanted


def test_the_build_is_for_debians_python(foreign, tmp_path):
    del foreign["PYTHONHOME"], foreign["PYTHONPATH"]  # with them no other Python runs at all; ./run takes them away
    subprocess.run(["cmake", "-S", ROOT, "-B", tmp_path / "build", "-G", "Ninja", "-DSLUICE_TESTS=OFF"], env=foreign, check=True, capture_output=True)
    cache = (tmp_path / "build/CMakeCache.txt").read_text().splitlines()
    assert f"_Python_EXECUTABLE:INTERNAL={DEBIANS}" in cache
