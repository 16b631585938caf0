# SPDX-License-Identifier: GPL-3.0-or-later
"""The names an object answers to in expressions: its own, those of its collections and of the collections around them."""


class Names:
    """Walks the file's collections once. `collections`: every collection but the scenes' own roots."""

    def __init__(self, collections=()):
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
        """[own name, collections …] of an original (not evaluated) object."""
        return [original.name] + [name for name in self._of_object.get(original.name_full, ()) if name != original.name]

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
