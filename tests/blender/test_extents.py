# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo egg on grounds of 40 m to 5 km: its moved caustic is what it is on its table alone."""
import os

import bits
import bpy
import numpy as np
import pytest
from conftest import ROOT

FULL = bool(os.environ.get("SLUICE_FULL"))
SEEDS = 8 if FULL else 4


def _edited(ground, seed):
    """Mean of the picture that edited light makes."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "blend_scenes/glass_egg.blend"))
    if ground:
        bpy.ops.mesh.primitive_plane_add(size=ground, location=(0, 0, -0.5))
    return bits.render(seed=seed, photons=30000)["edited"].mean()


@pytest.fixture(scope="module")
def alone(core):
    return np.array([_edited(0, seed) for seed in range(SEEDS)])


@pytest.mark.parametrize("ground", [40, 200, 1000, 5000] if FULL else [5000])
def test_the_moved_caustic_stays(alone, ground):
    found = np.array([_edited(ground, seed + 100) for seed in range(SEEDS)])
    error = np.sqrt((alone.var(ddof=1) + found.var(ddof=1)) / SEEDS)
    assert error < 0.04 * alone.mean()  # else it says nothing
    assert abs(found.mean() - alone.mean()) < min(5 * error, 0.08 * alone.mean())
