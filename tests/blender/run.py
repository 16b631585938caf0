# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the tests of tests/blender inside Blender, with the arguments after -- for pytest:

    ./run blender -b --factory-startup --python-exit-code 1 --python tests/blender/run.py -- -k export"""
import os
import sys
from pathlib import Path

import pytest

here = Path(__file__).resolve().parent
arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
os.environ["SLUICE_INSIDE_BLENDER"] = "1"
status = pytest.main([str(here), "-p", "no:cacheprovider", "-q", *arguments])
sys.stdout.flush()
# Blender's own exit would run engines' destructors under a dying interpreter; sys.exit ends it in order and keeps the code
sys.exit(int(status))
