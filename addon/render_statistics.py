# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render found of the whole picture: which effects ran and why, how the error fell, and what makes most of it.

It is kept until the next render or file, as edit_statistics.py keeps what was found at edits; of several view layers the last counts.
Effects and layers are those of views too, errors those of final renders alone: a view that comes to rest must not hide the curve of a
long render."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import bpy

from . import core, registration


@dataclass(frozen=True)
class Found:
    """What was found."""

    effects: Sequence[tuple[str, bool, str]] = ()  # (name, did it run?, why)
    layers: Mapping[str, float] = field(default_factory=dict)  # the share of the picture that each light layer shows
    progress: Mapping[str, Any] = field(default_factory=dict)  # as a session tells it at its end; empty: there was no final render
    seconds: Mapping[str, float] = field(default_factory=dict)  # by what they were spent on
    denoised: bool = False  # was its picture denoised after that?
    accuracy: Sequence[Mapping[str, Any]] = ()  # after each few passes: seconds, error, noise, bias, and those of parts and edits


_found = Found()


def remember_effects(session: core.Session) -> None:
    """Keeps what ran. The thread of a render may call it, too: it makes one assignment and touches no Blender data."""
    global _found
    told = session.statistics()
    layers = {row["name"]: row["share"] for row in told.get("layers", ())}
    _found = replace(_found, effects=tuple(told.get("effects", ())), layers={**_found.layers, **layers})


def remember(session: core.Session, denoised: bool = False) -> None:
    """Keeps what ran and how the error fell, of a final render that is over and whose picture may have been denoised then."""
    global _found
    remember_effects(session)
    told = session.statistics()
    _found = replace(_found, progress=session.progress(), seconds=told.get("seconds", {}), denoised=denoised,
                     accuracy=tuple(told.get("accuracy", ())))


def last() -> Found:
    """What was found last."""
    return _found


@bpy.app.handlers.persistent
def forget(*_: object) -> None:
    """Drops all: another render or file begins. Also a handler of Blender's, whose arguments say nothing here."""
    global _found
    _found = Found()


def shares(now: Mapping[str, Any]) -> tuple[list[tuple[str, float, float, float]], list[tuple[str, float, float, float]]]:
    """(name, share of the error's square, noise, bias) of each part of the picture, and of each edit, the largest first. The light of
    an edit is light of a part too, mostly of Edited."""
    rows = [[(row["name"], row["noise"] ** 2 + row["bias"] ** 2, row["noise"], row["bias"]) for row in now[kind]] for kind in ("parts", "edits")]
    whole = sum(row[1] for row in rows[0]) or 1
    parts, edits = (sorted(((name, square / whole, noise, bias) for name, square, noise, bias in kind if square > 0),
                           key=lambda row: -row[1]) for kind in rows)
    return parts, edits


_handlers = {"render_init": forget, "render_pre": forget, "load_post": forget}


def register() -> None:
    registration.add_handlers(_handlers)


def unregister() -> None:
    registration.remove_handlers(_handlers)
    forget()
