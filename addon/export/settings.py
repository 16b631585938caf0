# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a session: scene.sluice under its own names, and what the render asks beside them. Max Edits per Path and Specular
Threshold are no settings for the core but part of the scene that it compiles (__init__.py)."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import bpy
NAMES = (
    "passes", "photons", "seed", "use_animated_seed", "max_depth", "time_limit", "error_target", "use_adaptive_sampling", "use_direct",
    "use_caustics", "use_edited", "use_indirect", "use_edits",
)


def export_settings(scene: bpy.types.Scene, threads: int | None = None) -> dict[str, Any]:
    """A dict for Session.start, in the units that the panels show (error_target in percent)."""
    render = scene.render
    found = {name: getattr(scene.sluice, name) for name in NAMES}
    found["threads"] = render.threads if threads is None else threads
    found["frame"] = scene.frame_current
    found["film_transparent"] = render.film_transparent
    return found


def for_preview(settings: dict[str, Any]) -> dict[str, Any]:
    """Little work for a material preview: a thumbnail that appears at once."""
    return {**settings, "passes": min(settings["passes"], 8), "photons": min(settings["photons"], 30000),
            "pilot_paths": 8192, "render_passes": [], "time_limit": min(settings["time_limit"] or 2.0, 2.0), "error_target": 0.0,
            "use_adaptive_sampling": False}
