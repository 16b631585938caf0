# SPDX-License-Identifier: GPL-3.0-or-later
"""From outside Blender: runs this folder's tests inside it, so that plain `pytest tests/blender` works."""
import os
import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


@pytest.mark.skipif(not shutil.which("blender"), reason="no blender on PATH")
def test_inside_blender(tmp_path):
    environment = dict(os.environ)
    if not (Path(environment.get("BLENDER_USER_SCRIPTS", "/nonexistent")) / "addons" / "sluice").exists():
        addons = tmp_path / "scripts" / "addons"
        addons.mkdir(parents=True)
        (addons / "sluice").symlink_to(ROOT / "addon")
        environment["BLENDER_USER_SCRIPTS"] = str(addons.parent)
    environment.setdefault("SLUICE_CORE", str(ROOT / "build"))
    command = ["blender", "-b", "--factory-startup", "--addons", "sluice", "--python-exit-code", "1", "--python", str(HERE / "run.py")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stdout[-8000:] + done.stderr[-2000:]
