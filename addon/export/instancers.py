# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects make an instance. For an instance within an instance (of a collection, say) Blender tells the outermost one alone, not
those in between. But it lists instances depth first, each before those that it makes, with the numbers of the way to it."""
from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import bpy

_NONE = (0x7fffffff, -1)  # What Blender fills the list of numbers up with.


class Instancers:
    """Follows the list of instances. It must be asked of every one, in the order of the depsgraph."""

    def __init__(self) -> None:
        self._parent: bpy.types.Object | None = None
        # The instances that the last one lies in, as pairs (way, original): the outermost first, the last one itself at the end.
        self._open: list[tuple[tuple[int, ...], bpy.types.Object]] = []
        self._members: dict[bpy.types.Collection | None, list[bpy.types.Object]] = {}

    def of(self, instance: bpy.types.DepsgraphObjectInstance) -> tuple[bpy.types.Object, ...]:
        """The originals of the objects that make an instance, nearest first."""
        if instance.parent is None:
            return ()
        parent, item, numbers = instance.parent.original, instance.object.original, instance.persistent_id
        if numbers[1] in _NONE:
            self._parent, self._open = parent, [((numbers[0],), item)]
            return (parent,)
        way = tuple(number for number in reversed(numbers) if number not in _NONE)
        if parent != self._parent:
            self._parent, self._open = parent, []
        while self._open and not self._makes(*self._open[-1], way, item):
            self._open.pop()
        chain = [parent, *(maker for _way, maker in self._open)]
        chain += self._unseen(chain[-1], way[len(self._open[-1][0]) if self._open else 0:])
        self._open.append((way, item))
        return tuple(reversed(chain))

    def _makes(self, start: tuple[int, ...], maker: bpy.types.Object, way: tuple[int, ...], item: bpy.types.Object) -> bool:
        """Does `maker`, itself an instance that `start` leads to, make what `way` leads to?"""
        last = len(start) - 1
        if len(way) <= last + 1 or way[:last] != start[:last]:
            return False
        if maker.instance_type == 'COLLECTION':
            inner = way[last + 1:]
            return way[last] - start[last] in (0, 1) and (len(inner) > 1 or self._member(maker, inner[0]) == item)
        # Geometry nodes number an instance and what it makes apart, so nothing more can be checked.
        return way[last] - start[last] in (0, 1) and (maker.instance_type != 'NONE' or bool(maker.modifiers))

    def _unseen(self, maker: bpy.types.Object, inner: tuple[int, ...]) -> list[bpy.types.Object]:
        """Instances of collections that Blender leaves out of the list although they make others, as those that do not show themselves."""
        found = []
        while len(inner) > 1 and maker.instance_type == 'COLLECTION':
            member = self._member(maker, inner[0])
            if member is None:
                break
            maker, inner = member, inner[1:]
            found.append(maker)
        return found

    def _member(self, maker: bpy.types.Object, number: int) -> bpy.types.Object | None:
        collection = maker.instance_collection
        if collection not in self._members:
            self._members[collection] = list(collection.all_objects) if collection is not None else []
        members = self._members[collection]
        return members[number] if number < len(members) else None
