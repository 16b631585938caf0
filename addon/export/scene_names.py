# SPDX-License-Identifier: GPL-3.0-or-later
"""The names a thing answers to in expressions: its own, those of its collections and of the collections around them, and those of all
that instances it."""
from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..expression_names import names_in, renamed

if TYPE_CHECKING:
    import bpy


class Homes:
    """Where each name is at home: in this file (None) or in libraries. Kinds of things share their names, as in expressions."""

    def __init__(self, *kinds: Iterable[bpy.types.ID]) -> None:
        # Of each name: the libraries that it is at home in, with the full name that Blender tells there.
        self._full: dict[str, dict[bpy.types.Library | None, str]] = {}
        for items in kinds:
            for item in items:
                self._full.setdefault(item.name, {})[item.library] = item.name if item.library is None else item.name_full

    def own(self, item: bpy.types.ID) -> list[str]:
        """Its name, and with its library as Blender tells it: "Egg", "Egg [shelf.blend]". The first alone would mean what this file has
        of that name."""
        hidden = item.library is not None and None in self._full.get(item.name, ())
        return [item.name_full] if hidden else list(dict.fromkeys((item.name, item.name_full)))

    def meant(self, name: str, library: bpy.types.Library | None = None) -> dict[bpy.types.Library | None, str]:
        """{library: full name} of the things that a name means in an expression of `library`: those of that file, else of the files that
        it links, else of this file, else all."""
        full = self._full.get(name, {})
        below = {other: told for other, told in full.items() if library is not None and _links(library, other)}
        return {library: full[library]} if library in full else below or ({None: full[None]} if None in full else full)

    def read(self, text: str, library: bpy.types.Library | None = None) -> str:
        """An expression of `library`, its names as this file tells them."""
        changes = {}
        for name in names_in(text):
            meant = self.meant(name, library)
            if None not in meant and len(self._full.get(name, ())) > 1:
                changes[name] = list(meant.values())
        return renamed(text, changes)


def _links(library: bpy.types.Library, other: bpy.types.Library | None) -> bool:
    """Did `other` come into this file through `library`?"""
    while other is not None and other != library:
        other = other.parent
    return other is not None


class Names:
    """Walks the file's collections once. `collections`: every collection but the scenes' own roots; the others: all there are."""

    def __init__(self, collections: Iterable[bpy.types.Collection] = (), objects: Iterable[bpy.types.Object] = (),
                 worlds: Iterable[bpy.types.World] = ()) -> None:
        collections = list(collections)
        self.homes = Homes(objects, collections, worlds)
        self._of_object: dict[str, dict[str, None]] = {}
        self._of_chain: dict[tuple[bpy.types.Object, ...], list[str]] = {}
        parents: dict[str, list[bpy.types.Collection]] = {}
        for collection in collections:
            for child in collection.children:
                parents.setdefault(child.name_full, []).append(collection)
        for collection in collections:
            around = [name for item in _with_ancestors(collection, parents) for name in self.homes.own(item)]
            for item in collection.objects:
                known = self._of_object.setdefault(item.name_full, {})
                known.update(dict.fromkeys(around))

    def of(self, original: bpy.types.ID) -> list[str]:
        """[own names, collections …] of an original (not evaluated) object."""
        return list(dict.fromkeys((*self.homes.own(original), *self._of_object.get(original.name_full, ()))))

    def of_instance(self, original: bpy.types.Object, *instancers: bpy.types.Object) -> list[str]:
        """An instance bears its original's names first; then those of the objects that make it, the nearest first."""
        chain = (original, *instancers)
        if chain not in self._of_chain:
            self._of_chain[chain] = list(dict.fromkeys(name for item in chain for name in self.of(item)))
        return self._of_chain[chain]

    def of_world(self, world: bpy.types.World) -> str:
        """A world bears one name: with its library where something else has the first."""
        return self.homes.own(world)[0] if len(self.homes.meant(world.name)) < 2 else world.name_full


def _with_ancestors(collection: bpy.types.Collection, parents: dict[str, list[bpy.types.Collection]]) -> Iterable[bpy.types.Collection]:
    """A collection and all that hold it, nearest first. A collection may have several parents."""
    found, queue = {}, [collection]
    while queue:
        item = queue.pop(0)
        if item.name_full not in found:
            found[item.name_full] = item
            queue.extend(parents.get(item.name_full, ()))
    return found.values()
