# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of all edits of the scene: they are chosen here, switched on and off, one alone, all at once; marks tell which took light."""
from typing import Any

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import checking, edit_statistics, model, registration
from .interface import Panel, is_narrow, sentence


def _row(_manager: object) -> int:
    """The list's active row is the active Empty's edit."""
    entry = model.entry_of(getattr(bpy.context, "object", None))
    return -1 if entry is None else bpy.data.objects.find(entry.name)


def _choose_row(_manager: object, row: int) -> None:
    if 0 <= row < len(bpy.data.objects):
        item = bpy.data.objects[row]
        if bpy.context.mode == 'OBJECT' and item.name in bpy.context.view_layer.objects:
            model.select_only(bpy.context, [item], item)


class SLUICE_UL_edits(bpy.types.UIList):
    """Rows of Blender's objects of which only the scene's entries are shown."""

    def filter_items(self, context: bpy.types.Context, data: Any, name: str) -> tuple[list[int], list[int]]:
        items = getattr(data, name)
        wanted = self.filter_name.lower()
        places = {item: place for place, item in enumerate(model.entries_of(context.scene)) if wanted in item.name.lower()}
        flags = [self.bitflag_filter_item if item in places else 0 for item in items]
        order = bpy.types.UI_UL_list.sort_items_helper([(row, places.get(item, len(items))) for row, item in enumerate(items)],
                                                       key=lambda pair: pair[1])
        return flags, order

    def draw_item(self, context: bpy.types.Context, layout: bpy.types.UILayout,
                  _data: Any, item: Any, _icon: int, _active_data: Any, _active_name: str) -> None:
        edit, scene = item.sluice, context.scene
        row = layout.row(align=True)
        row.active = model.acts(scene, item)
        row.prop(edit, "enabled", text="")
        is_wrong = checking.check(edit.expression, (), "en").error is not None
        split = row.row() if is_narrow(context.region) else row.split(factor=0.55)
        split.alert = is_wrong
        split.prop(item, "name", text="", emboss=False)
        if not is_narrow(context.region):
            split.label(text=edit.expression)
        icon: Any = 'ERROR' if is_wrong else edit_statistics.icon(edit_statistics.of(item.name_full))
        row.label(text="", icon=icon)
        row.operator("sluice.solo_edit", text="", icon='SOLO_ON' if model.solo_of(scene) == item else 'SOLO_OFF', emboss=False).name = item.name


class SLUICE_OT_solo_edit(bpy.types.Operator):
    """Let this edit act alone, or all that are enabled again"""

    bl_idname = "sluice.solo_edit"
    bl_label = "Solo"
    bl_options = {'REGISTER', 'UNDO', 'INTERNAL'}

    name: StringProperty(name="Object", description="Name of the entry")

    def execute(self, context: bpy.types.Context) -> set[str]:
        item: bpy.types.Object | None = context.scene.objects.get(self.name)
        if item is None:
            return {'CANCELLED'}
        context.scene.sluice.solo = None if model.solo_of(context.scene) == item else item
        return {'FINISHED'}


class SLUICE_OT_enable_edits(bpy.types.Operator):
    """Switch edits on or off: those selected, or all of the scene"""

    bl_idname = "sluice.enable_edits"
    bl_label = "Enable Light Edits"
    bl_options = {'REGISTER', 'UNDO'}

    action: EnumProperty(
        name="Action", description="What happens to the edits", default='ENABLE',
        items=(('ENABLE', "Enable", "They act"), ('DISABLE', "Disable", "They do nothing"), ('TOGGLE', "Toggle", "Each is switched")))
    which: EnumProperty(
        name="Which", description="Which edits are meant", default='ALL',
        items=(('ALL', "All", "Every edit of the scene"), ('SELECTED', "Selected", "Edits of which an entry or exit is selected")))

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        found = model.entries_of(context.scene)
        if self.which == 'SELECTED':
            selected = {model.entry_of(item) for item in context.selected_objects}
            found = [item for item in found if item in selected]
        for item in found:
            if item.library is None:
                item.sluice.enabled = {'ENABLE': True, 'DISABLE': False, 'TOGGLE': not item.sluice.enabled}[self.action]
        if not found:
            self.report({'INFO'}, "No light edit is meant")
        return {'FINISHED'} if found else {'CANCELLED'}


class SLUICE_MT_edits(bpy.types.Menu):
    bl_label = "Light Edits"

    def draw(self, _context: bpy.types.Context) -> None:
        for which, label in (('ALL', "All"), ('SELECTED', "Selected")):
            if which == 'SELECTED':
                self.layout.separator()
            for action, icon in (('ENABLE', 'CHECKBOX_HLT'), ('DISABLE', 'CHECKBOX_DEHLT'), ('TOGGLE', 'ARROW_LEFTRIGHT')):
                row = self.layout.operator("sluice.enable_edits", text=f"{action.title()} {label}", icon=icon)  # type: ignore[arg-type]
                row.action, row.which = action, which


class _ListPanel(Panel):
    bl_label = "Light Edits"

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.sluice, "use_edits", text="")

    def draw(self, context: bpy.types.Context) -> None:
        scene, layout = context.scene.sluice, self.layout
        row = layout.row()
        row.active = scene.use_edits
        manager = context.window_manager
        row.template_list("SLUICE_UL_edits", "", bpy.data, "objects", manager, "sluice_edit_row", rows=3)
        side = row.column(align=True)
        side.operator("sluice.add_edit", text="", icon='ADD')
        side.menu("SLUICE_MT_edits", text="", icon='DOWNARROW_HLT')
        alone = model.solo_of(context.scene)
        if alone is not None:
            sentence(layout, context.region, f"{alone.name} acts alone", 'SOLO_ON')


class SLUICE_PT_edits(_ListPanel, bpy.types.Panel):
    bl_context = "scene"


class SLUICE_PT_edits_sidebar(_ListPanel, bpy.types.Panel):
    bl_space_type = 'VIEW_3D'  # type: ignore[assignment]
    bl_region_type = 'UI'  # type: ignore[assignment]
    bl_category = "Sluice"
    bl_order = 1


_classes = (SLUICE_UL_edits, SLUICE_OT_solo_edit, SLUICE_OT_enable_edits, SLUICE_MT_edits, SLUICE_PT_edits, SLUICE_PT_edits_sidebar)
_register, _unregister = registration.of_classes(*_classes)


def register() -> None:
    _register()
    bpy.types.WindowManager.sluice_edit_row = IntProperty(
        name="Light Edit", description="The edit that is chosen", get=_row, set=_choose_row, options={'SKIP_SAVE'})


def unregister() -> None:
    del bpy.types.WindowManager.sluice_edit_row
    _unregister()
