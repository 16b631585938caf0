# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on in a real window under Xvfb: panels, overlay, undo, rendered mode, F12. Keeps the pictures in out/test/gui."""
import os
import shutil
import subprocess
from pathlib import Path

import bpy
import numpy as np
import pytest
from conftest import HERE, ROOT

OUT = Path(os.environ.get("SLUICE_TEST_OUT", ROOT / "out" / "test")) / "gui"
NEEDED = ("xvfb-run", "import", "xdotool")


def _pixels(name):
    image = bpy.data.images.load(str(OUT / f"{name}.png"))
    found = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(found)
    return found.reshape(image.size[1], image.size[0], 4)[..., :3]


def _difference(a, b):
    """Share of pixels that differ visibly."""
    return float((np.abs(_pixels(a) - _pixels(b)).max(axis=2) > 0.05).mean())


@pytest.mark.skipif(not all(map(shutil.which, NEEDED)), reason=f"needs {', '.join(NEEDED)}")
def test_a_session_in_a_window():
    environment = dict(os.environ, SLUICE_CORE=str(HERE / "fakes"), SLUICE_TURNS="20" if os.environ.get("SLUICE_FULL") else "4")
    shutil.rmtree(OUT, ignore_errors=True)
    command = ["xvfb-run", "-a", "-s", "-screen 0 1200x800x24", bpy.app.binary_path, "--factory-startup", "-Y", "--addons", "sluice",
               "-p", "0", "0", "1200", "800", "--python", str(HERE / "gui" / "smoke.py"), "--", str(OUT)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    said = done.stdout + done.stderr
    assert done.returncode == 0 and "gui: done" in said, said[-4000:]
    assert "addons/sluice" not in said and "WARN (bpy.rna)" not in said, said[-4000:]  # no traceback passes through us
    blue = _pixels("overlay") - _pixels("overlays_off")
    assert ((blue[..., 2] > 0.1) & (blue[..., 2] > blue[..., 0] + 0.1)).mean() > 0.002  # the tinted entry
    assert _difference("entry_panel", "expression_error") > 0.001
    assert _difference("overlay", "rendered") > 0.2
    assert _difference("rendered_after_undo", "rendered_error") < 0.1  # the last image stays under the message
    assert _pixels("f12").std() > 0.01
    assert _pixels("escaped").std() > 0.01  # the partial image
