# SPDX-License-Identifier: GPL-3.0-or-later
"""The model of light edits: what the Empties of a scene are to the light, which exits belong to which entry, which edits act.

An edit is one entry and the exits that name it. All of it is stored on the Empties themselves (object.sluice, see properties.py);
panels, operators and the overlay ask and change it through the functions below."""
from __future__ import annotations

import bpy
from mathutils import Matrix


def is_part(item: bpy.types.Object) -> bool:
    """Is the object an Empty that is the entry or an exit of an edit?"""
    return item.type == 'EMPTY' and item.sluice.role != 'NONE'


def is_entry(item: bpy.types.Object) -> bool:
    """Is the object an Empty that captures light?"""
    return item.type == 'EMPTY' and item.sluice.role == 'ENTRY'


def entry_of(item: bpy.types.Object | None) -> bpy.types.Object | None:
    """The entry of the edit that an Empty belongs to; None if it belongs to none."""
    if item is None or not is_part(item):
        return None
    return item if item.sluice.role == 'ENTRY' else item.sluice.entry


def exits_of(entry: bpy.types.Object) -> list[bpy.types.Object]:
    """The exits that name an entry, sorted by their names."""
    return sorted((item for item in bpy.data.objects if item.sluice.role == 'EXIT' and item.sluice.entry == entry),
                  key=lambda item: item.name)


def entries_of(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The entries of a scene's edits in the order in which they act."""
    return sorted(filter(is_entry, scene.objects), key=lambda item: (item.sluice.order, item.name))


def solo_of(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The entry of the edit that acts alone, or None. A deleted Empty may still be pointed at, so the scene must hold it."""
    item = scene.sluice.solo
    return item if item is not None and item.sluice.role == 'ENTRY' and item.name in scene.objects else None


def acts(scene: bpy.types.Scene, entry: bpy.types.Object) -> bool:
    """Does the edit of this entry act: it is enabled, edits are not bypassed, and no other edit acts alone?"""
    return entry.sluice.enabled and scene.sluice.use_edits and solo_of(scene) in {None, entry}


def visible_parts(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The entries and exits that the 3D view of the context shows; none where its overlays are switched off."""
    view = context.space_data
    if view is None or not view.overlay.show_overlays:
        return []
    return [item for item in context.view_layer.objects
            if is_part(item) and item.visible_in_viewport_get(view) and item.visible_get()]


def new_empty(context: bpy.types.Context, name: str, matrix: Matrix, role: str) -> bpy.types.Object:
    """A new Empty with a role, in the active collection; in the scene's own if that one is linked from a library."""
    item = bpy.data.objects.new(name, None)
    item.empty_display_type = 'SINGLE_ARROW'
    item.empty_display_size = 1.0
    item.matrix_world = matrix
    collection = context.collection
    (collection if collection and not collection.library else context.scene.collection).objects.link(item)
    item.sluice.role = role
    return item


def new_exit(context: bpy.types.Context, entry: bpy.types.Object, matrix: Matrix, display_size: float) -> bpy.types.Object:
    """A new exit for the light of an entry."""
    item = new_empty(context, f"{entry.name} Exit", matrix, 'EXIT')
    item.empty_display_size = display_size
    item.sluice.entry = entry
    return item


def select_only(context: bpy.types.Context, items: list[bpy.types.Object], active: bpy.types.Object) -> None:
    """Selects these objects and no others, as far as the view layer holds them."""
    for item in context.selected_objects:
        item.select_set(False)
    for item in items:
        if item.name in context.view_layer.objects:
            item.select_set(True)
    if active.name in context.view_layer.objects:
        context.view_layer.objects.active = active
