# SPDX-License-Identifier: GPL-3.0-or-later
"""One file, one seed, one picture: demo scenes exported and rendered again and again, in two processes, with other numbers of threads."""
import json
import os
import subprocess

import bits
import bpy
import numpy as np
import pytest
from conftest import HERE, ROOT

FULL = bool(os.environ.get("SLUICE_FULL"))
ALL = sorted(path.stem for path in (ROOT / "blend_scenes").glob("*.blend"))
SCENES = ALL if FULL else ["animation", "cornell", "fig1", "fig3", "fig7", "glass_egg"]  # quick to open; the normals of all but one raced
# Bevel of Blender 5.2 merges UVs in an order of its own: last bits (6e-8) of UV maps that no material of these scenes reads
STEADY_UVS = "compositing_node_group" not in bpy.types.Scene.bl_rna.properties
HOW = {"exports": 20, "renders": 3} if FULL else {"exports": 1, "renders": 1}


def _path(scene):
    return str(ROOT / "blend_scenes" / f"{scene}.blend")


@pytest.fixture(scope="module")
def elsewhere(core):
    """elsewhere(scene): hashes by another Blender, which starts at once and runs beside the tests. Its hashes of text are other ones."""
    asked = json.dumps([[_path(scene), {**HOW, "threads": 1}] for scene in SCENES])
    command = [bpy.app.binary_path, "--factory-startup", "-Y", "-b", "--addons", "sluice", "--python-exit-code", "1",
               "--python", HERE / "bits.py", "--", asked]
    environment = dict(os.environ, SLUICE_CORE=os.path.dirname(core.__file__))
    process = subprocess.Popen([str(part) for part in command], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    found, said = {}, []

    def read(scene):
        while _path(scene) not in found:
            line = process.stdout.readline()
            assert line, "".join(said[-30:])
            said.append(line)
            if line.startswith("BITS "):
                path, hashes = json.loads(line[5:])
                found[path] = hashes
        return found[_path(scene)]

    yield read
    process.kill()
    process.wait()


def test_all_demo_scenes_are_here():
    assert len(ALL) == 12 and set(SCENES) <= set(ALL)


@pytest.mark.parametrize("scene", SCENES)
def test_a_file_has_one_description_and_one_film(elsewhere, scene):
    """One thread there, two here."""
    here, there = bits.hashes(_path(scene), **HOW, threads=2), elsewhere(scene)
    for kind in ("descriptions", "films", "guides")[0 if STEADY_UVS else 1:]:
        assert len(here[kind]) == 1, (kind, here)
        assert here[kind] == there[kind]


@pytest.mark.parametrize("scene", ALL if FULL else ["glass_egg"])
def test_seeds_and_borders(core, scene):
    """Another seed is another film; a border is a crop of the whole frame, by one guide."""
    bpy.ops.wm.open_mainfile(filepath=_path(scene))
    whole, other = bits.render(), bits.render(seed=1)
    part = bits.render(border=(0.25, 0.2, 0.8, 0.9))
    assert whole["film"] != other["film"] and whole["guide"] == part["guide"]
    np.testing.assert_array_equal(part["picture"], whole["picture"][6:27, 10:32])
