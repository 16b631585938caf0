# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the page of ./run report for the open file, beside Blender, where the add-on lies in Sluice's repository."""
from __future__ import annotations

import subprocess
import tempfile
import webbrowser
from pathlib import Path
from typing import Any

import bpy

from . import registration, renaming

_LOOK = 0.5  # seconds between two looks at the report that is being made
_MARK = "Report: "  # With it ./run report tells its page.
_running: tuple[Any, Any] | None = None  # the process, and the file that gets what it says


def script() -> Path | None:
    """The repository's script, if the add-on's folder is that of a repository which can make reports."""
    root = Path(__file__).resolve().parents[1]
    return root / "run" if (root / "run").is_file() and (root / "tools/report.py").is_file() else None


class SLUICE_OT_make_report(bpy.types.Operator):
    """Render the file as it is saved several times beside Blender, and open a page that tells what accuracy costs in it: error against time, by
    effect and edit, and what other settings would give. It takes some minutes"""

    bl_idname = "sluice.make_report"
    bl_label = "Make Report"
    bl_options = {'INTERNAL'}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        why = ""
        if script() is None:
            why = "Reports are made by the script run of Sluice's repository, which is not beside this installed add-on"
        elif _running is not None:
            why = "A report is being made"
        if why:
            cls.poll_message_set(why)  # type: ignore[call-arg,arg-type]
        return not why

    def execute(self, _context: bpy.types.Context) -> set[str]:
        if not bpy.data.filepath:
            self.report({'WARNING'}, "Save the file first: the report is made of what is saved")
            return {'CANCELLED'}
        _start()
        unsaved = ", without what was changed since the file was saved" if bpy.data.is_dirty else ""
        self.report({'INFO'}, f"A report is being made{unsaved}: it opens when it is done")
        return {'FINISHED'}


def _start() -> None:
    global _running
    said: Any = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115  (closed when the report is done)
    command = ["bash", str(script()), "report", bpy.data.filepath]
    _running = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT), said
    bpy.app.timers.register(look, first_interval=_LOOK, persistent=True)


def look() -> float | None:
    """A timer: when the report is done it says so and opens the page. Returns the seconds until it looks again, None to end."""
    global _running
    if _running is None:
        return None
    process, said = _running
    if process.poll() is None:
        return _LOOK
    _running = None
    said.seek(0)
    lines = [line.strip() for line in said if line.strip()]
    said.close()
    page = next((line[len(_MARK):] for line in reversed(lines) if line.startswith(_MARK)), "")
    if process.returncode == 0 and page:
        renaming.notice(f"The report is done: {page}")
        webbrowser.open(Path(page).as_uri())
    else:
        renaming.notice(f"There is no report: {lines[-1] if lines else 'its script ended without a word'}")
    return None


_register, _unregister = registration.of_classes(SLUICE_OT_make_report)


def register() -> None:
    _register()


def unregister() -> None:
    global _running
    if _running is not None:
        _running[0].terminate()
        _running = None
    _unregister()
