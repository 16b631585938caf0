# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws that hold for any widths and samples are tried with both kinds of settings (scenes.py, `defaults`); in the fast form of the tests one in
four of those with the product's own."""

import os
import zlib

FULL = bool(os.environ.get("SLUICE_FULL"))


def pytest_collection_modifyitems(config, items):
    def is_left_out(item):
        shipped = getattr(getattr(item, "callspec", None), "params", {}).get("defaults") == "as shipped"
        return shipped and not FULL and zlib.crc32(item.nodeid.encode()) % 4 > 0

    left_out = [item for item in items if is_left_out(item)]
    items[:] = [item for item in items if item not in left_out]
    config.hook.pytest_deselected(items=left_out)
