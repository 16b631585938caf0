# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles in the 3D view: corners for the size of the active quad, an arrow for an exit's intensity, a dial for its hue shift; and the
border of every quad, to pick it by.

Values go through handlers that ask for the active object each time: a property bound in setup() crashes Blender after undo. Blender
makes no undo step of what handlers change, so the end of a drag is noticed and makes one."""
import colorsys
import math
from collections.abc import Callable, Sequence
from typing import Any

import bpy
from mathutils import Matrix, Vector

from . import interface, model

_ARROW = 0.7  # At intensity 1 the arrow is this fraction of the shorter half side long.
# Arrows lean at least so many radians off the line of sight: one that points at the eye is a dot, which nobody can drag.
_LEAN = 0.4
_before: tuple[float, ...] | None = None  # The values before the drag that is going on; None: nothing is dragged.


def _active() -> bpy.types.Object | None:
    """The Empty of an edit that is active and may be changed, or None."""
    item = bpy.context.object
    editable = item is not None and model.is_part(item) and item.library is None
    return item if editable and item.select_get() else None


def _frame(item: bpy.types.Object) -> tuple[Matrix, Vector]:
    """The quad's centre and its unit axes."""
    matrix = item.matrix_world
    x, y = matrix.col[0].xyz, matrix.col[1].xyz
    x.normalize()
    z = x.cross(y).normalized()
    z *= math.copysign(1, z.dot(matrix.col[2].xyz))
    return Matrix((x, z.cross(x), z)).transposed().to_4x4(), matrix.translation


def _leaning(axis: Vector, towards_eye: Vector, up: Vector) -> Vector:
    """The direction in which an arrow is drawn: its axis, turned away from the line of sight as far as it takes to see it. All are unit
    vectors; `up` points upwards in the picture."""
    along = axis.dot(towards_eye)
    across = axis - towards_eye * along
    if across.length >= math.sin(_LEAN):
        return axis
    across = across.normalized() if across.length > 1e-3 else up
    return towards_eye * math.copysign(math.cos(_LEAN), along) + across * math.sin(_LEAN)


def _arrow_axes(axes: Matrix, centre: Vector, region_3d: bpy.types.RegionView3D) -> Matrix:
    """The axes of a quad for its arrow."""
    back, z = region_3d.view_matrix.inverted(), axes.col[2].xyz
    towards_eye = (back.translation - centre).normalized() if region_3d.is_perspective else back.col[2].xyz
    return z.rotation_difference(_leaning(z, towards_eye, back.col[1].xyz)).to_matrix().to_4x4() @ axes


def _sides(item: bpy.types.Object) -> list[float]:
    """Lengths of the quad's sides."""
    return [2 * item.empty_display_size * item.matrix_world.col[axis].xyz.length for axis in (0, 1)]


def _reach(item: bpy.types.Object) -> float:
    return _ARROW * max(1e-6, min(_sides(item))) / 2


def _values(item: bpy.types.Object) -> tuple[float, ...]:
    return (*item.scale, item.sluice.intensity, item.sluice.hue_shift)


def _begin(item: bpy.types.Object) -> None:
    global _before
    if _before is None:
        _before = _values(item)


def _end() -> None:
    """A timer that runs when a drag is over. It makes the step of undo, unless the drag was cancelled or led nowhere."""
    global _before
    item = _active()
    if item is not None and _before is not None and _values(item) != _before:
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
            bpy.ops.ed.undo_push(message="Drag Light Edit")
    _before = None


def _get_size() -> list[float]:
    item = _active()
    width, height = _sides(item) if item else (1, 1)
    matrix = Matrix.Diagonal((width, height, 1, 1))
    return [matrix[row][column] for column in range(4) for row in range(4)]


def _set_size(values: Sequence[float]) -> None:
    item = _active()
    if item is None:
        return
    _begin(item)
    for axis, length in enumerate(_sides(item)):
        wanted = Vector(values[4 * axis:4 * axis + 3]).length
        if length > 0 and wanted > 1e-6:
            item.scale[axis] *= wanted / length


# An arrow's length tells the logarithm of the intensity: none for 0, one reach for 1, seven reaches for 100.
def _get_intensity() -> float:
    item = _active()
    return _reach(item) * math.log2(1 + item.sluice.intensity) if item else 0.0


def _set_intensity(value: float) -> None:
    item = _active()
    if item is not None:
        _begin(item)
        item.sluice.intensity = 2 ** min(14.0, max(0.0, value / _reach(item))) - 1


# Blender's dials count clockwise.
def _get_hue() -> float:
    item = _active()
    return -item.sluice.hue_shift if item else 0.0


def _set_hue(value: float) -> None:
    item = _active()
    if item is not None:
        _begin(item)
        item.sluice.hue_shift = math.remainder(-value, 2 * math.pi)


class _Group:
    """A group of handles for our engine, in object mode, where overlays are shown and `wanted` says so."""
    bl_space_type = 'VIEW_3D'
    bl_region_type = 'WINDOW'

    @classmethod
    def wanted(cls, context: bpy.types.Context) -> bool:
        """Is there something to handle?"""
        raise NotImplementedError

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        view = context.space_data
        return context.engine == interface.ENGINE and context.mode == 'OBJECT' and view.overlay.show_overlays and cls.wanted(context)


class SLUICE_GGT_edit(_Group, bpy.types.GizmoGroup):
    """Handles of the active entry or exit"""

    bl_label = "Light Edit"
    bl_options = {'3D', 'PERSISTENT', 'SHOW_MODAL_ALL'}

    @classmethod
    def wanted(cls, _context: bpy.types.Context) -> bool:
        return _active() is not None

    def setup(self, _context: bpy.types.Context) -> None:
        self.size = self._handle("GIZMO_GT_cage_2d", "matrix", _get_size, _set_size)
        self.size.transform = {'SCALE'}
        self.intensity = self._handle("GIZMO_GT_arrow_3d", "offset", _get_intensity, _set_intensity)
        self.intensity.draw_style = 'BOX'
        self.intensity.draw_options = {'STEM'}
        self.intensity.length = 0
        self.hue = self._handle("GIZMO_GT_dial_3d", "offset", _get_hue, _set_hue)
        self.hue.draw_options = {'ANGLE_VALUE', 'ANGLE_START_Y'}
        self.hue.scale_basis = 0.6

    def _handle(self, kind: str, target: str, getter: Callable[[], Any], setter: Callable[[Any], None]) -> Any:
        gizmo = self.gizmos.new(kind)
        gizmo.target_set_handler(target, get=getter, set=setter)
        gizmo.use_draw_modal = True
        gizmo.use_event_handle_all = False
        gizmo.line_width = 2
        gizmo.alpha, gizmo.alpha_highlight = 0.8, 1.0
        gizmo.color_highlight = (1.0, 1.0, 1.0)
        return gizmo

    def draw_prepare(self, context: bpy.types.Context) -> None:
        item = _active()
        if _before is not None and not any(gizmo.is_modal for gizmo in self.gizmos) and not bpy.app.timers.is_registered(_end):
            bpy.app.timers.register(_end)
        if item is None:
            return
        axes, centre = _frame(item)
        is_exit = item.sluice.role == 'EXIT'
        self.size.matrix_basis = self.hue.matrix_basis = Matrix.Translation(centre) @ axes
        for gizmo in (self.size, self.intensity, self.hue):
            gizmo.color = interface.EXIT_COLOR if is_exit else interface.ENTRY_COLOR
        if not self.intensity.is_modal:  # The arrow must not turn under the hand that drags it.
            self.intensity.matrix_basis = Matrix.Translation(centre) @ _arrow_axes(axes, centre, context.region_data)
        self.intensity.hide = self.hue.hide = not is_exit
        hue = item.sluice.hue_shift
        if is_exit and hue != 0:  # The needle shows how far the hue turns, the colour of the dial what becomes of red.
            self.hue.color = colorsys.hsv_to_rgb(hue / (2 * math.pi) % 1, 0.75, 1)
        if not self.hue.is_modal:  # While a dial is dragged, Blender itself turns the needle.
            self.hue.matrix_basis = self.hue.matrix_basis @ Matrix.Rotation(hue, 4, 'Z')


class SLUICE_GT_border(bpy.types.Gizmo):
    """The border of a quad: a click selects its Empty."""

    def draw(self, _context: bpy.types.Context) -> None:
        if self.is_highlight:
            self.draw_custom_shape(self.shape)

    def draw_select(self, _context: bpy.types.Context, select_id: int) -> None:
        self.draw_custom_shape(self.shape, select_id=select_id)

    def setup(self) -> None:
        corners = ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))
        self.shape = self.new_custom_shape('LINES', [corners[k % 4] for side in range(4) for k in (side, side + 1)])


class SLUICE_GGT_borders(_Group, bpy.types.GizmoGroup):
    """Quads can be picked by their borders"""

    bl_label = "Light Edits"
    bl_options = {'3D', 'PERSISTENT', 'SELECT'}

    @classmethod
    def wanted(cls, context: bpy.types.Context) -> bool:
        return any(map(model.is_part, context.view_layer.objects))

    def setup(self, context: bpy.types.Context) -> None:
        self.refresh(context)

    def refresh(self, context: bpy.types.Context) -> None:
        """Shows one border per quad. Those left over wait, hidden."""
        items = model.visible_parts(context)
        while len(self.gizmos) < len(items):
            gizmo = self.gizmos.new("SLUICE_GT_border")
            gizmo.use_draw_scale = False
            gizmo.line_width = 2
            gizmo.color_highlight, gizmo.alpha_highlight = (1.0, 1.0, 1.0), 0.9
        for number, gizmo in enumerate(self.gizmos):
            gizmo.hide = number >= len(items) or items[number] == _active()  # The active one has handles instead.
            if number < len(items):
                gizmo.target_set_operator("sluice.select_one").name = items[number].name
                gizmo.matrix_basis = items[number].matrix_world @ Matrix.Scale(items[number].empty_display_size, 4)

    def draw_prepare(self, context: bpy.types.Context) -> None:
        for gizmo, item in zip(self.gizmos, model.visible_parts(context)):
            gizmo.matrix_basis = item.matrix_world @ Matrix.Scale(item.empty_display_size, 4)


_classes = (SLUICE_GT_border, SLUICE_GGT_borders, SLUICE_GGT_edit)


def register() -> None:
    for cls in _classes:
        bpy.utils.register_class(cls)


def unregister() -> None:
    if bpy.app.timers.is_registered(_end):
        bpy.app.timers.unregister(_end)
    for cls in reversed(_classes):
        bpy.utils.unregister_class(cls)
