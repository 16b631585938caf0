# SPDX-License-Identifier: GPL-3.0-or-later
"""What a running render shows: status line, progress bar, memory, and the image as it refines."""
from __future__ import annotations

import json
import os
import time
from typing import Any, TypeAlias

import bpy

from . import core, passes

Progress: TypeAlias = dict[str, Any]  # what Session.progress() tells

_STOPS = {
    'passes': "all passes done", 'time': "stopped by the time limit", 'error': "stopped at the error target",
    'cancelled': "cancelled",
}


# Design §5. Tooltips tell it.
ERROR = ("The error: how far pixels are from what the render converges to, relative to each pixel (dark ones to a tenth of the mean), as root mean "
         "square over the picture without its worst 0.1 %, noise and blur together, told without a reference")


def in_background() -> bool:
    """Does Blender run without a window? Asked through a function, so that tests can answer."""
    return bpy.app.background


def duration(seconds: float) -> str:
    """A time as text: 0:07, 12:34, 1:02:03."""
    minutes, rest = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def count(number: float) -> str:
    """A number as text: below 10,000 as it is (1,234), above as 12.3 k, 4.5 M, 6.7 G."""
    for unit, size in (("G", 1e9), ("M", 1e6), ("k", 1e4)):
        if number >= size:
            return f"{number / (1e3 if unit == 'k' else size):.1f} {unit}"
    return f"{int(number):,}"


def about(number: float) -> str:
    """An estimate as text: two digits of a whole number (410, 1,300)."""
    return f"{round(float(f'{number:.2g}')):,}"


def line(progress: Progress, target: float = 0, denoised: bool = False) -> str:
    """The status line of a session that stops at an error of `target` percent (0: of any)."""
    if progress["state"] == 'compiling':
        return f"{progress['message'] or 'Building the scene'} | Time {duration(progress['seconds'])}"
    if progress["state"] == 'rendering' and progress["pass"] == 0:
        return f"Looking where the light goes, then the first of {progress['passes']} passes | Time {duration(progress['seconds'])}"
    parts = [f"Pass {progress['pass']}/{progress['passes']}", f"Photons {count(progress['photons'])}"]
    if _known(progress["error_estimate"]):
        parts.append(f"{'Error before denoising' if denoised else 'Error'} {error(progress)}")
    parts.append(f"Time {duration(progress['seconds'])}")
    if _known(progress["seconds_left"]):
        parts.append(f"Left {duration(progress['seconds_left'])}")
    if 4 * progress["pass"] >= progress["passes"] and _misses(progress, target):
        parts.append(_cost(progress, target))
    if progress["main_cause"]:
        parts.append(main_cause(progress["main_cause"]))
    if denoised:
        parts.append("Denoised")
    return " | ".join(parts)


def percent(relative: float) -> str:
    """A relative error as text: 0.83 %, 3.1 %, 120 %."""
    return f"{float(f'{100 * relative:.2g}'):g} %"


def error(progress: Progress) -> str:
    """The error, told apart: 3.1 % (noise 2.9 %, blur 1.1 %)."""
    return (f"{percent(progress['error_estimate'])} (noise {percent(progress['noise'])}, blur {percent(progress['bias'])}"
            f"{_unmet(progress)})")


def main_cause(cause: tuple[str, float]) -> str:
    """What makes most of the error: its name and its share of the square."""
    return f"most of the error: {cause[0]}, {100 * cause[1]:.0f} %"


def _unmet(progress: Progress) -> str:
    """What the estimate of the error does not know of: lights and effects of which nothing was found before the first pass."""
    names = progress.get("unmet") or ()
    return "" if not names else f"; without {', '.join(names[:2])}{' …' if len(names) > 2 else ''}: not met"


def _misses(progress: Progress, target: float) -> bool:
    """Are the passes that were asked for too few to reach the target, as far as is known?"""
    return target > 0 and _known(progress["passes_to_target"]) and progress["passes_to_target"] > progress["passes"]


def _cost(progress: Progress, target: float) -> str:
    """What the target would take."""
    return f"{target:.3g} % takes about {about(progress['passes_to_target'])} passes"


def summary(progress: Progress, target: float = 0, denoised: bool = False) -> str:
    """One sentence at the end: what was done, why it stopped, how far from the target of `target` percent (0: there is none)."""
    parts = [f"{_STOPS.get(progress['stop_reason'], progress['stop_reason'])}: {progress['pass']} of {progress['passes']} passes",
             f"{count(progress['photons'])} photons", f"{progress['seconds']:.1f} s"]
    if _known(progress["error_estimate"]):
        parts.append(f"{'error before denoising' if denoised else 'error'} {error(progress)}")
    if progress["main_cause"]:
        parts.append(main_cause(progress["main_cause"]))
    is_open = target > 0 and _known(progress["error_estimate"]) and 100 * progress["error_estimate"] > target
    if is_open and _known(progress["passes_to_target"]) and progress["passes_to_target"] > progress["pass"]:
        parts.append(_cost(progress, target))
    if denoised:
        parts.append("denoised")
    return ", ".join(parts)


def stamps(progress: Progress) -> dict[str, str]:
    """The error in numbers, for the header of the image's file; without them where it is not known."""
    if not _known(progress["error_estimate"]):
        return {}
    return {name: f"{100 * progress[key]:.4g} %" for name, key in (("error", "error_estimate"), ("noise", "noise"), ("bias", "bias"))}


def _known(number: float | None) -> bool:
    """Can the session tell this figure? If it cannot, it is None, negative or infinite."""
    return number is not None and 0 <= number < 1e9


class Stream:
    """Refreshes what Blender shows of a session, as often as it is cheap: numbers 4 times a second (in background once a second at
    first, each time later by twice as much, to 16 s, since Blender prints a line each time), images so that copying them takes
    less than a thirtieth of the time."""

    def __init__(self, engine: bpy.types.RenderEngine, result: bpy.types.RenderResult, names: list[str], enabled: bool,
                 target: float = 0) -> None:
        self._engine, self._result, self._names, self._enabled, self._target = engine, result, names, enabled, target
        self._next_line, self._interval = 0.0, 0.25 if enabled else 1.0
        self._next_image, self._shown_pass = 0.0, 0

    def refresh(self, session: core.Session) -> None:
        progress = session.progress()
        now = time.monotonic()
        if now >= self._next_line:
            self._show_numbers(progress)
            self._next_line = now + self._interval
            if not self._enabled:
                self._interval = min(2 * self._interval, 16.0)
        if self._enabled and now >= self._next_image and progress["pass"] > self._shown_pass:
            self._show_image(session)
            self._shown_pass = progress["pass"]
            done = time.monotonic()
            self._next_image = done + min(5.0, max(0.2, 30 * (done - now)))

    def _show_numbers(self, progress: Progress) -> None:
        engine = self._engine
        engine.update_stats("", line(progress, self._target))
        megabytes = progress["memory"] / 2 ** 20
        engine.update_memory_stats(memory_used=megabytes, memory_peak=megabytes)
        left = progress["seconds_left"]
        if _known(left) and progress["seconds"] + left > 0:
            engine.update_progress(progress["seconds"] / (progress["seconds"] + left))
        elif progress["passes"]:
            engine.update_progress(progress["pass"] / progress["passes"])

    def _show_image(self, session: core.Session) -> None:
        images = session.snapshot(self._names)
        if images is not None:
            passes.write(self._result, images)
            self._engine.update_result(self._result)


class ProgressLog:
    """One JSON object per line for each pass that ended, into the file that the environment variable SLUICE_PROGRESS_LOG names (none:
    nothing happens). For tools that plot error against time; a render's last line holds statistics and warnings too. A process begins
    the file anew and appends its other renders: the frames of an animation, each of its view layers."""

    _KEYS = ("seconds", "pass", "passes", "photons", "error_estimate", "noise", "bias", "main_cause", "stop_reason")
    _begun: set[str | None] = set()  # The files that this process has begun.

    def __init__(self, frame: int, layer: str) -> None:
        path = os.environ.get("SLUICE_PROGRESS_LOG")
        mode = "a" if path in self._begun else "w"
        self._begun.add(path)
        self._file = open(path, mode, encoding="utf-8") if path else None  # noqa: SIM115  (closed by close, or with the process)
        self._pass, self._of = 0, {"frame": frame, "view_layer": layer}

    def write(self, session: core.Session) -> None:
        if self._file is None or session.progress()["pass"] == self._pass:
            return
        self._pass = session.progress()["pass"]
        self._put(session, {})

    def close(self, session: core.Session, warnings: list[tuple[str, str]]) -> None:
        if self._file is None:
            return
        found = warnings + [tuple(warning) for warning in session.warnings()]
        self._put(session, {"statistics": session.statistics(), "warnings": found})
        self._file.close()
        self._file = None

    def _put(self, session: core.Session, more: dict[str, Any]) -> None:
        progress = session.progress()
        row = {**self._of, **{key: progress[key] for key in self._KEYS}}
        print(json.dumps({**row, "effects": session.statistics()["effects"], **more}), file=self._file, flush=True)
