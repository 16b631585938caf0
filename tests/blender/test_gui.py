# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on in a real window under Xvfb: panels, overlay, gizmos, undo, rendered mode, F12. Keeps the pictures in out/test/gui."""
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
needs_window = pytest.mark.skipif(not all(map(shutil.which, NEEDED)), reason=f"needs {', '.join(NEEDED)}")


def _pixels(name):
    image = bpy.data.images.load(str(OUT / f"{name}.png"))
    found = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(found)
    return found.reshape(image.size[1], image.size[0], 4)[..., :3]


def _difference(a, b):
    """Share of pixels that differ visibly."""
    return float((np.abs(_pixels(a) - _pixels(b)).max(axis=2) > 0.05).mean())


def _in_a_window(script, core, *more, turns="4"):
    """Runs one of gui/*.py in a Blender under Xvfb; its pictures go to OUT."""
    environment = dict(os.environ, SLUICE_CORE=str(core), SLUICE_TURNS=turns)
    command = ["xvfb-run", "-a", "-s", "-screen 0 1200x800x24", bpy.app.binary_path, "--factory-startup", "-Y", *more, "--addons", "sluice",
               "-p", "0", "0", "1200", "800", "--python", str(HERE / "gui" / script), "--", str(OUT)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    said = done.stdout + done.stderr
    assert done.returncode == 0 and "gui: done" in said, said[-4000:]
    assert "addons/sluice" not in said and "WARN (bpy.rna)" not in said, said[-4000:]  # no traceback passes through us


@needs_window
def test_an_artists_hands():
    """Menu, expressions, gizmos, undo, list and figures, with the real core; gui/edits.py asks most of it."""
    from sluice import core
    _in_a_window("edits.py", os.environ.get("SLUICE_CORE") or core.folders()[-1], "--enable-event-simulate")
    assert _difference("words", "words_error") > 0.001
    assert _difference("gizmos_exit", "gizmo_size") > 0.002
    mauve = _pixels("gizmos_exit") - _pixels("gizmos_off")
    assert (np.abs(mauve).max(axis=2) > 0.1).mean() > 0.002  # handles that the switch hides
    assert _difference("layers", "layers_error") > 0.001
    before, followed = (_pixels(name)[480:560, 570:640].mean() for name in ("followed_before", "followed"))
    assert followed > 1.15 * before  # where the exit lights the wall: three times as much light, on a display's curve
    assert _difference("figures", "no_match") > 0.002


@needs_window
def test_a_session_in_a_window():
    _in_a_window("smoke.py", HERE / "fakes", turns="20" if os.environ.get("SLUICE_FULL") else "4")
    blue = _pixels("overlay") - _pixels("overlays_off")
    assert ((blue[..., 2] > 0.1) & (blue[..., 2] > blue[..., 0] + 0.1)).mean() > 0.002  # the tinted entry
    assert _difference("entry_panel", "expression_error") > 0.001
    assert _difference("overlay", "rendered") > 0.2
    assert _difference("rendered_after_undo", "rendered_error") < 0.1  # the last image stays under the message
    assert _pixels("f12").std() > 0.01
    assert _pixels("escaped").std() > 0.01  # the partial image
