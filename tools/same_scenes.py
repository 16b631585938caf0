# SPDX-License-Identifier: GPL-3.0-or-later
"""Inside Blender, with the add-on of one tree: copies the demo scenes and the two boxes of the bench, as F12 does at 64 × 48.

    blender … --python tools/same_scenes.py -- TREE OUT

OUT is a pickle: {scene: {"description", "settings", "hash"}}; it stays on this machine, and only tools/same.py reads it."""
import pickle
import sys
from pathlib import Path

import bpy

tree, out = Path(sys.argv[-2]), Path(sys.argv[-1])
sys.path[:0] = [str(tree / "tests" / "blender"), str(tree / "tests" / "bench")]
import bits
import box


def copy():
    from sluice.export.settings import export_settings
    description, _ = bits.describe()
    return {"description": description, "settings": export_settings(bpy.context.scene), "hash": bits.fingerprint(description)}


found = {}
for path in sorted((tree / "blend_scenes").glob("*.blend")):
    bpy.ops.wm.open_mainfile(filepath=str(path))
    found[path.stem] = copy()
for lamp in box.LAMPS:
    box.build(lamp)
    found[f"box, {lamp} lamp"] = {**copy(), "hash": None}  # Blender makes a sphere's faces in another order each time
out.write_bytes(pickle.dumps(found))
