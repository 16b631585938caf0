# SPDX-License-Identifier: GPL-3.0-or-later
"""What menus offer: kinds of light by plain names, each with the expression that takes it, and what can become of light. No bpy."""
from __future__ import annotations

from typing import NamedTuple

from . import expression_names


class Kind(NamedTuple):
    """A kind of light, as menus offer it."""

    label: str
    expression: str  # {} stands for the name of an object
    description: str
    icon: str


class Action(NamedTuple):
    """What can become of light."""

    name: str  # the item of the operators' enumeration
    label: str
    description: str
    icon: str


ARRIVING = (
    Kind("Caustic", "LS+", "Light focused by mirrors and glass", 'LIGHTPROBE_GRID'),
    Kind("Straight Light", "L", "Light straight from its lamp", 'LIGHT'),
    Kind("Colour Bleeding", "L.*D", "Light that bounced off something diffuse last", 'SHADING_RENDERED'),
    Kind("All Indirect Light", "L.+", "Light that met anything on its way", 'SHADING_TEXTURE'),
    Kind("Everything", "L.*", "All light that comes by", 'LIGHT_HEMI'),
)
NAMED = (
    Kind("From This Lamp…", "L{}.*", "All light of one lamp, whatever it met", 'LIGHT_AREA'),
    Kind("Through This Object…", "L.*S{}+", "Light that a thing mirrored or refracted last", 'META_BALL'),
    Kind("Colour of This Object…", "L.*D{}", "Light that bounced off a thing last, and took its colour", 'MATERIAL'),
)
SEEN = (
    Kind("What the Eye Sees", "E", "The picture itself, where it is seen directly", 'HIDE_OFF'),
    Kind("All Reflections", "S+E", "What is seen in mirrors and through glass", 'MOD_MIRROR'),
)
GROUPS = (ARRIVING, NAMED, SEEN)

ACTIONS = (
    Action('MOVE', "Move", "The light goes to an exit beside the entry, to be laid where it is wanted", 'CON_LOCLIKE'),
    Action('COPY', "Copy", "The light stays, and falls at the 3D cursor too", 'DUPLICATE'),
    Action('RECOLOUR', "Recolour", "The light stays, in another colour", 'COLOR'),
    Action('DIM', "Dim", "The light stays, weaker", 'LIGHT_SUN'),
    Action('REMOVE', "Remove", "The light is gone", 'X'),
)


def title(expression: str) -> str:
    """What an edit with this expression may be called: by the plain name of the kind, or by the last thing that is named."""
    for kind in ARRIVING:
        if kind.expression == expression:
            return kind.label
    event, name = expression_names.last_in(expression)
    return f"Light {'from' if event == 'L' else 'by'} {name}" if name and not set("!^") & set(expression) else "Light Edit"
