# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit Light Here: asks the core which kinds of light arrive at a place, and offers an edit for each. No grammar needed.

The answer comes from a short session of its own, in which an additional entry lies at the place. Its expression matches no path (none has
two lamps), so it takes nothing; the core tells which light crosses it."""
from typing import Any

import bpy
import numpy as np

from . import checking, compat, core, edit_statistics, export, expression_words, final, interface, light_kinds, placement
from .export.scene_names import Names
from .export.settings import export_settings

_PLACE, _NOTHING = "Edit Light Here", "LL"
_POLL = 0.1
# Nobody looks at the picture of this session, so it costs as little as it can.
_NO_PICTURE = {"passes": 1, "photons": 64, "pilot_paths": 1024, "use_adaptive_sampling": False}


def ask(depsgraph: bpy.types.Depsgraph, data: bpy.types.BlendData, matrix: np.ndarray) -> core.Session:
    """Starts a session that finds what arrives at the square of this matrix. Blender's data is not touched afterwards."""
    context = export.Context(Names(data.collections, data.objects, data.worlds))
    matrix = compat.matrix(matrix)
    camera = {"name": _PLACE, "kind": 'Orthographic', "matrix": matrix, "ortho_scale": 1.0, "sensor_fit": 'Horizontal',
              "sensor_width": 36.0, "sensor_height": 36.0, "clip_start": 0.0, "clip_end": 1.0, "aperture_radius": 0.0}
    frame = {"width": 4, "height": 4, "x0": 0, "y0": 0, "x1": 4, "y1": 4, "pixel_aspect_x": 1.0, "pixel_aspect_y": 1.0,
             "filter_width": 1.0, "filter_box": True}
    description = export.export_scene(depsgraph, camera, frame, context)
    quad = {"name": _PLACE, "matrix": matrix, "half_size": 1.0, "offset": 0.0, "order": _last_order(description["edits"])}
    description["edits"].append({"entry": quad, "expression": _NOTHING, "enabled": True, "repeat": False, "amount": 1.0,
                                 "feather": 0.0, "exits": [], "collections": []})
    settings = {**export_settings(depsgraph.scene_eval), **_NO_PICTURE, "time_limit": 0.0, "error_target": 0.0, "use_edits": True,
                "explain_edits": True}
    session = core.new_session()
    session.start(description, settings)
    return session


def _last_order(edits: list[dict[str, Any]]) -> int:
    """An order behind that of all edits: where quads lie in one plane, what the others take is gone before it arrives."""
    quads = [quad for edit in edits for quad in (edit["entry"], *(out["quad"] for out in edit["exits"]))]
    return 1 + max((quad["order"] for quad in quads), default=0)


def answer(session: core.Session) -> tuple[list[tuple[str, float]], str]:
    """What a session that is over has found: (expression, share) of each kind of light, and the name of an edit that takes the light before,
    if one does. Raises a Failure if the session failed."""
    progress = session.progress()
    if progress["state"] == 'failed':
        raise final.core_failure(progress)
    found = [row for row in session.statistics()["edits"] if row["name"] == _PLACE]
    return (found[0].get("arrivals", []), edit_statistics.taker(found[0])) if found else ([], "")


def told(expression: str, share: float) -> str:
    """One line of the menu, such as "62 %   light from Lamp, then one or more mirrors or glass"."""
    return f"{100 * share:.0f} %   {expression_words.tell(core.load().parse(expression), checking.language())}"


class SLUICE_OT_edit_light_here(interface.AddsEdit, bpy.types.Operator):
    """Find which light falls on the selected faces, or at the 3D cursor, and choose the one to edit"""

    bl_idname = "sluice.edit_light_here"
    bl_label = "Edit Light Here"
    bl_options = {'REGISTER'}

    size: bpy.props.FloatProperty(name="Size", description="Side of the square at the cursor; 0: by its distance from the eye",
                                  subtype='DISTANCE', default=0.0, min=0.0, soft_max=10.0)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """For scripts: waits for the answer. The interface calls invoke, which shows the menu."""
        try:
            session = self._ask(context)
            while not session.wait(_POLL):
                pass
            self._offer(context, *answer(session))
        except Exception as error:
            return self._fail(error)
        return {'FINISHED'}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        try:
            self._session = self._ask(context)
        except Exception as error:
            return self._fail(error)
        manager = context.window_manager
        self._timer = manager.event_timer_add(_POLL, window=context.window)
        manager.modal_handler_add(self)
        context.workspace.status_text_set("Looking for the light that arrives here. Esc: stop")
        return {'RUNNING_MODAL'}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == 'ESC':
            self.cancel(context)
            return {'CANCELLED'}
        if event.type != 'TIMER' or not self._session.wait(0):
            return {'PASS_THROUGH'}
        self.cancel(context)
        try:
            self._offer(context, *answer(self._session))
        except Exception as error:
            return self._fail(error)
        return {'FINISHED'}

    def cancel(self, context: bpy.types.Context) -> None:
        self._session.cancel()
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)

    def _ask(self, context: bpy.types.Context) -> core.Session:
        matrix = np.array(placement.find(context, self.size)[0])
        return ask(context.evaluated_depsgraph_get(), bpy.data, matrix)

    def _fail(self, error: Exception) -> set[str]:
        self.report({'ERROR'}, str(final.as_failure(error)))
        return {'CANCELLED'}

    def _offer(self, context: bpy.types.Context, arrivals: list[tuple[str, float]], taker: str) -> None:
        if not arrivals:
            self.report({'INFO'}, f"No light arrives here: the edit {taker} takes it before" if taker else "No light arrives here")
            return
        if bpy.app.background:
            return
        size = self.size

        def draw(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
            for expression, share in arrivals:
                row = menu.layout.operator("sluice.add_edit", text=told(expression, share), icon='LIGHT')
                row.name = light_kinds.title(expression)
                # All of them are set: Blender fills in the rest from the last call.
                row.expression, row.action, row.size = expression, 'MOVE', size

        context.window_manager.popup_menu(draw, title="Light That Arrives Here", icon='LIGHT')


def register() -> None:
    bpy.utils.register_class(SLUICE_OT_edit_light_here)


def unregister() -> None:
    bpy.utils.unregister_class(SLUICE_OT_edit_light_here)
