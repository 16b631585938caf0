# SPDX-License-Identifier: GPL-3.0-or-later
"""The names an object answers to in expressions: its own, those of its collections and of the collections around them."""


def local_names(objects):
    """Names that objects of this file bear."""
    return {item.name for item in objects if item.library is None}


def own_names(item, local):
    """Its name, and with its library as Blender tells it: "Egg", "Egg [shelf.blend]". The first alone would mean the object of this file
    where that has the same name (`local`)."""
    return [item.name_full] if item.library is not None and item.name in local else list(dict.fromkeys((item.name, item.name_full)))


class Names:
    """Walks the file's collections once. `collections`: every collection but the scenes' own roots; `objects`: all there are."""

    def __init__(self, collections=(), objects=()):
        self._local = local_names(objects)
        self._of_object = {}
        parents = {}
        collections = list(collections)
        for collection in collections:
            for child in collection.children:
                parents.setdefault(child.name_full, []).append(collection)
        for collection in collections:
            around = _ancestors(collection, parents)
            for item in collection.objects:
                known = self._of_object.setdefault(item.name_full, [])
                known.extend(name for name in around if name not in known)

    def of(self, original):
        """[own names, collections …] of an original (not evaluated) object."""
        own = own_names(original, self._local)
        return own + [name for name in self._of_object.get(original.name_full, ()) if name not in own]

    def of_instance(self, original, instancer):
        """An instance bears its original's names first; then those of the object that makes the instance."""
        names = self.of(original)
        if instancer is not None:
            names += [name for name in self.of(instancer) if name not in names]
        return names


def _ancestors(collection, parents):
    """Names of a collection and of all that hold it, nearest first. A collection may have several parents."""
    names, queue = [], [collection]
    while queue:
        item = queue.pop(0)
        if item.name not in names:
            names.append(item.name)
            queue.extend(parents.get(item.name_full, ()))
    return names
