# SPDX-License-Identifier: GPL-3.0-or-later
"""What the next render computes and what it leaves out, and why: in sentences, for a panel. Settings are known before; what the scene
calls for is found when it is compiled, so that is what the last render found."""
from __future__ import annotations

from typing import Any, TypeAlias

from . import checking, edit_statistics, model, passes, render_statistics

Told: TypeAlias = tuple[str, str]  # (sentence, icon)

# The names of effects as the core tells them, and their switches.
_SWITCHES = {"direct": "use_direct", "caustics": "use_caustics", "edited light": "use_edited", "indirect": "use_indirect"}
_SWITCHED_OFF = "switched off"  # the core's own reason
_RUNS, _OFF, _UNKNOWN = 'CHECKMARK', 'X', 'QUESTION'


def _reasons() -> dict[str, tuple[bool, str]]:
    """By the name that the core tells: did it run, and why. Edits and layers are called 'edit …' and 'layer …' there."""
    return {name: (runs, why) for name, runs, why in render_statistics.last().effects}


def effects(scene: Any) -> list[Told]:
    """Of each effect: does it run?"""
    settings = scene.sluice
    known = {name: reason for name, reason in _reasons().items() if not name.startswith(("edit ", "layer "))}
    told = []
    for name in dict.fromkeys((*_SWITCHES, *known)):
        runs, why = known.get(name, (False, ""))
        label = name.capitalize()
        if name in _SWITCHES and not getattr(settings, _SWITCHES[name]):
            told.append((f"{label}: off: switched off above", _OFF))
        elif not why or why == _SWITCHED_OFF:
            told.append((f"{label}: switched on", _UNKNOWN))
        else:
            told.append((f"{label}: runs: {why}" if runs else f"{label}: off: {why}", _RUNS if runs else _OFF))
    if any(icon == _UNKNOWN for _sentence, icon in told):
        told.append(("Whether the scene calls for it is found when it is compiled", 'BLANK1'))
    return told


def edits(scene: Any) -> list[Told]:
    """Of each edit: can it take anything?"""
    found = [(entry.name, *_edit(scene, entry)) for entry in model.entries_of(scene)]
    return [(f"{name}: {sentence}", icon) for name, sentence, icon in found]


def _edit(scene: Any, entry: Any) -> Told:
    if not scene.sluice.use_edits:
        return "off: Light Edits are switched off above", _OFF
    if not entry.sluice.enabled:
        return "off: not enabled", _OFF
    alone = model.solo_of(scene)
    if alone not in {None, entry}:
        return f"off: {alone.name} acts alone (Solo)", _OFF
    if checking.check(entry.sluice.expression, (), "en").error is not None:
        return "its expression is not understood: nothing is rendered", 'ERROR'
    runs, why = _reasons().get(f"edit {entry.name_full}", (True, ""))
    if not runs and why != _SWITCHED_OFF:
        return f"off in the last render: {why}", _OFF
    found = edit_statistics.of(entry.name_full)
    if found is None:
        return "whether light that matches comes here is found by a render", _UNKNOWN
    sentence, _icon = edit_statistics.lines(found)[0]
    return sentence[0].lower() + sentence[1:], _RUNS if found.acted else _OFF


def layers(view_layer: Any) -> list[Told]:
    """Of each light layer: does it show anything?"""
    shares, reasons = render_statistics.last().layers, _reasons()
    told = []
    for layer in passes.export_layers(view_layer):
        share = shares.get(layer["name"])
        runs, why = reasons.get(f"layer {layer['name']}", (True, ""))
        if not runs:
            told.append((f"{layer['name']}: off: {why}", _OFF))
        elif share is None:
            told.append((f"{layer['name']}: how much it shows is found by a render", _UNKNOWN))
        elif share > 0:
            told.append((f"{layer['name']}: {edit_statistics.percent(share)} of the picture's light", _RUNS))
        else:
            told.append((f"{layer['name']}: nothing in the picture matches", _OFF))
    return told


def render_passes(scene: Any, view_layer: Any) -> list[Told]:
    """Who asks for each render pass that is made."""
    return [(f"{item.name}: {who}", _RUNS) for item, who in passes.asked(scene, view_layer, ()).items()]
