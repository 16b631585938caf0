# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render, final or in a view, found at each edit: how much light its entry took, or why it took none.

It is kept by the name of the entry until the next render or file; of several view layers the last counts. Panels, the list of edits and
the overlay show it."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import bpy

from . import core, registration, render_progress


class Found(NamedTuple):
    """What a render found at one edit."""

    matched: int  # paths that the entry took
    moved: int  # paths that exits sent on
    capped: int  # paths absorbed at the limit of edits per path
    acted: bool  # Did the entry take light, or paths from the eye?
    power_in: float  # W
    power_out: float  # W
    taken: float  # share of the lamps' light that the entry took; of the paths from the eye, where it took no light
    share: float  # share of the picture that the edit makes
    seconds: float
    floats: float  # how far the quad floats in front of its plane, m
    side: float  # the quad's shorter side, m
    crossed: int  # test paths that crossed the entry, whatever its expression
    probed: int  # test paths in all
    taker: str  # the edit that takes most of the light before it comes here
    arrivals: Sequence[tuple[str, float]]  # (expression, share) of the light that came here


METHOD = ("Share: of all light in the picture, what this edit took on its way, as the layer L.*F'…'.*E shows it. Seconds: measured on the paths "
          "behind its squares, over the threads; asking which light crosses them, and gathering it on surfaces, are not in it")

# A fraction of the shorter side. A quad that floats further than this visibly catches or sends out light at another place.
_FLOATS_TO_TELL = 1e-3

_found: dict[str, Found] = {}


def remember(session: core.Session) -> None:
    """Keeps a session's figures. The thread of a render may call it, too: it makes one assignment and touches no Blender data."""
    global _found
    told, passes = session.statistics(), max(1, session.progress()["pass"])
    _found = {**_found, **{row["name"]: _read(row, told, passes) for row in told.get("edits", ())}}


def _read(row: dict[str, Any], told: dict[str, Any], passes: int) -> Found:
    part, whole = (row["energy_in"], told["ledger"]["emitted"]) if row["energy_in"] > 0 else (row["matched"], told["view_paths"])
    return Found(row["matched"], row["moved"], row["capped"], row["acted"], row["energy_in"] / passes, row["energy_out"] / passes,
                 part / whole if whole else 0, row["share"], row["seconds"], row.get("floats", 0), row.get("side", 0),
                 row.get("crossed", 0), row.get("probed", 0), taker(row), row.get("arrivals", ()))


def taker(row: dict[str, Any]) -> str:
    """The name of the edit that takes light before it crosses an entry, where that is more than what does cross it; else empty."""
    return row["taker"] if row.get("taken", 0) > row.get("crossed", 0) else ""


def of(name: str) -> Found | None:
    """What was found at the entry of this name. None: it was not in the last render, or there was none."""
    return _found.get(name)


def forget(*_: object) -> None:
    """Drops all figures: another render or file begins."""
    global _found
    _found = {}


def shows(found: Found) -> bool:
    """Does light that it took go on, so that its share and its time say something?"""
    return found.moved > 0 or found.share > 0


def icon(found: Found | None) -> str:
    """The mark of an edit in lists."""
    return 'BLANK1' if found is None else 'CHECKMARK' if found.acted else 'ERROR'


def lines(found: Found | None) -> list[tuple[str, str]]:
    """What the panel tells, as pairs (sentence, icon)."""
    if found is None:
        return []
    floats = [(f"Floats {length(found.floats)} in front of its plane", 'INFO')] if found.floats > _FLOATS_TO_TELL * found.side > 0 else []
    if not found.acted:
        return [(sentence, 'ERROR' if number == 0 else 'BLANK1') for number, sentence in enumerate(_nothing(found))] + floats
    if found.matched:
        told = [(f"Took {render_progress.count(found.matched)} paths, sent on {render_progress.count(found.moved)}", 'CHECKMARK')]
    else:  # Paths from the eye were taken, no photons.
        told = [("Took light on its way to the eye", 'CHECKMARK')]
    if found.power_in > 0:  # Paths from the eye carry no power.
        told.append((f"In {power(found.power_in)}, {percent(found.taken)} of the lamps' light; out {power(found.power_out)}", 'BLANK1'))
    elif found.matched:
        told.append((f"{percent(found.taken)} of the paths from the eye", 'BLANK1'))
    if shows(found):
        told.append((f"{percent(found.share)} of the picture; about {found.seconds:.2g} s", 'BLANK1'))
        # Light that leaves should be seen; so should what paths from the eye bring.
        if found.share == 0 and (found.power_out > 0 or found.power_in == 0):
            told.append(("The picture has nothing of it: is an exit behind a surface, or out of sight?", 'INFO'))
    if found.capped:
        told.append((f"Absorbed {render_progress.count(found.capped)} paths at Max Edits per Path", 'INFO'))
    return told + floats


def _nothing(found: Found) -> list[str]:
    """Why an entry took no light, as far as the test paths tell."""
    if not found.probed:
        return ["Nothing that matches crossed the entry"]
    if found.taker:
        return [f"{found.taker} takes the light before it comes here"]
    if not found.crossed:
        return ["No light that matches crossed the entry", "No light crosses it at all: is it where the light is?"]
    crossed, probed = render_progress.count(found.crossed), render_progress.count(found.probed)
    return [f"No light that matches crossed the entry; {crossed} of {probed} test paths crossed it"]


def percent(share: float) -> str:
    """A share as text: 3.1 %, 12 %, 100 %."""
    return f"{100 * share:.2g} %" if 1e-4 <= share < 0.0995 else "under 0.01 %" if 0 < share < 1e-4 else f"{100 * share:.0f} %"


def length(metres: float) -> str:
    """A length as text: 1.23 m, 4.5 cm, 6.7 mm."""
    for unit, size in (("km", 1e3), ("m", 1), ("cm", 1e-2), ("mm", 1e-3)):
        if metres >= size:
            return f"{metres / size:.3g} {unit}"
    return f"{metres:.1e} m"


def power(watts: float) -> str:
    """A power as text: 1.23 W, 4.5 mW, 0 W."""
    for unit, size in (("kW", 1e3), ("W", 1), ("mW", 1e-3), ("µW", 1e-6)):
        if watts >= size:
            return f"{watts / size:.3g} {unit}"
    return "0 W" if watts == 0 else f"{watts:.1e} W"


def stamp(found: Found) -> str:
    """What was found at an edit in one line, for the header of the image's file."""
    took = f"took {100 * found.taken:.4g} % of the {'lamps' if found.power_in > 0 else 'view'}, " if found.matched else ""
    acted = "took light on its way to the eye, " if found.acted and not found.matched else ""
    return (f"matched {found.matched}, moved {found.moved}, capped {found.capped}, in {found.power_in:.6g} W, out {found.power_out:.6g} W, "
            f"{took}{acted}makes {100 * found.share:.4g} % of the picture, about {found.seconds:.2g} s, "
            f"crossed {found.crossed} of {found.probed} test paths")


def stamps() -> dict[str, str]:
    """The lines for the header of the last render, by the names of edits."""
    return {name: stamp(found) for name, found in _found.items()}


@bpy.app.handlers.persistent
def redraw(*_: object) -> None:
    """Draws anew what shows figures. Also a handler of Blender's, whose arguments say nothing here."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {'PROPERTIES', 'VIEW_3D'}:
                area.tag_redraw()


@bpy.app.handlers.persistent
def _begin(*_: object) -> None:
    forget()


_handlers = {"render_init": _begin, "render_pre": _begin, "render_complete": redraw, "load_post": _begin}


def register() -> None:
    registration.add_handlers(_handlers)


def unregister() -> None:
    registration.remove_handlers(_handlers)
    forget()
