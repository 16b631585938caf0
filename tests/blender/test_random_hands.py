# SPDX-License-Identifier: GPL-3.0-or-later
"""Random hands: seeded sequences of operators, properties, deletions and renamings, in rendered mode. Whatever they do, nothing raises, the
view comes to rest with a picture or a sentence, and the scene can still be copied, listed and drawn."""
import os
import random
import time

import bpy
import pytest
from windowless import Window

EXPRESSIONS = ("L", "LS+", "LS'Egg'+", "L.*D'Wall,Egg'", "S+E", "L(", "", "'", "L'it\\'s'", "é", "L" * 1024, "L{9}{9}", "F'Light Edit'")
SEQUENCES = 200 if os.environ.get("SLUICE_FULL") else 40
STEPS = 5


class Hands:
    def __init__(self, seed):
        self.dice = random.Random(seed)

    def any_object(self, kinds=None):
        found = [item for item in bpy.context.scene.objects if kinds is None or item.type in kinds]
        return self.dice.choice(found) if found else None

    def operator(self):
        ops, dice = bpy.ops.sluice, self.dice
        name = getattr(self.any_object(), "name", "nobody")
        action = dice.choice(['MOVE', 'COPY', 'RECOLOUR', 'DIM', 'REMOVE'])
        operator, arguments = dice.choice((
            (ops.add_edit, {"expression": dice.choice(EXPRESSIONS), "size": dice.choice((1e-4, 1, 1e6)), "action": action}),
            (ops.change_light, {"action": action}), (ops.add_exit, {}), (ops.select_exits, {}), (ops.select_one, {"name": name}),
            (ops.link_exits, {}), (ops.solo_edit, {"name": name}), (ops.take_arrival, {"expression": dice.choice(EXPRESSIONS)}),
            (ops.enable_edits, {"action": dice.choice(['ENABLE', 'DISABLE', 'TOGGLE']), "which": dice.choice(['ALL', 'SELECTED'])}),
            (ops.set_expression, {"expression": dice.choice(("LS+", "L.*S{}+", "L{}.*"))}),
        ))
        if operator.poll():
            operator(**arguments)

    def change(self):
        item, dice = self.any_object({'EMPTY'}), self.dice
        if item is None:
            return
        edit = item.sluice
        name, value = dice.choice((
            ("role", dice.choice(['NONE', 'ENTRY', 'EXIT'])), ("expression", dice.choice(EXPRESSIONS)), ("amount", dice.random()),
            ("entry", self.any_object({'EMPTY'})), ("enabled", dice.random() < 0.5), ("intensity", 10 ** dice.uniform(-3, 6)),
            ("hue_shift", dice.uniform(-9, 9)), ("tint", (dice.random(), dice.uniform(-1, 9), 0)), ("order", dice.randrange(3)), ("offset", dice.uniform(-1, 1))))
        setattr(edit, name, value)
        item.scale = dice.choice(((1, 1, 1), (0, 1, 1), (-1, 2, 1), (1e-8, 1e-8, 1e-8), (1e12, 1, 1)))

    def select(self):
        item = self.any_object()
        if item is not None:
            item.select_set(self.dice.random() < 0.7)
            bpy.context.view_layer.objects.active = item if self.dice.random() < 0.9 else None

    def rename(self):
        item = self.any_object()
        if item is not None:
            item.name = self.dice.choice(("Egg", "Wall", "it's", "a,b", "\\", "Light Edit", "x" * 63))

    def delete(self):
        item = self.any_object()
        if item is not None:
            if self.dice.random() < 0.5:
                bpy.data.objects.remove(item)
            else:
                item.select_set(True)
                bpy.ops.object.delete()

    def copy(self):
        item = self.any_object()
        if item is not None:
            bpy.context.scene.collection.objects.link(item.copy())

    def move(self):
        self.dice.choice((self.operator, self.operator, self.change, self.select, self.rename, self.delete, self.copy))()
        bpy.context.view_layer.update()


@pytest.fixture
def window(camera, monkeypatch):
    """A small view that renders with the real core."""
    from sluice import viewport
    bpy.context.scene.sluice.passes, bpy.context.scene.sluice.photons = 1, 1000
    found = Window(48, 32, camera, monkeypatch.setattr)
    yield found
    viewport.free(found.view)


def look(window, follow=False):
    """What Blender does after a change; to the end if it is to be followed. True: there is a picture of what is now."""
    from sluice import viewport
    window.update(bpy.context.scene, *bpy.context.scene.objects)
    window.draw()
    begin = time.monotonic()
    while follow and window.view.session is not None and not viewport._at_rest(window.view):
        assert time.monotonic() - begin < 60, "the render is stuck"
        window.view.session.wait(5)
        window.draw()
    assert not any("internal error" in said for said in window.engine.said)
    return window.view.session is not None


@pytest.mark.parametrize("start", range(0, SEQUENCES, 10))
def test_random_hands(start, new_object, cube_mesh, export_now, window):
    from sluice import checking, edit_statistics, expression_names, model, overlay
    met, seen = 0, 0
    for seed in range(start, start + 10):
        for name in ("Egg", "Wall"):
            new_object(name, cube_mesh())
        hands = Hands(seed)
        for _step in range(STEPS):
            bpy.ops.sluice.add_edit(expression="L.*D'Wall,Egg'", action=hands.dice.choice(['MOVE', 'COPY', 'DIM']))
            for _more in range(8):
                hands.move()
            look(window)
        seen += look(window, follow=True)
        description, _warnings = export_now()
        scene = bpy.context.scene
        met += len(description["edits"])
        assert len(description["edits"]) == len(model.entries_of(scene))
        edits = [item for item in scene.objects if item.type == 'EMPTY' and item.sluice.role != 'NONE']
        assert len(overlay.shapes(edits, scene).fills) == len(edits)
        for item in edits:
            checking.check(item.sluice.expression, checking.names_here(), "fr")
            expression_names.names_in(item.sluice.expression)
            edit_statistics.lines(edit_statistics.of(item.name))
            model.exits_of(item)
        for item in list(bpy.data.objects):
            bpy.data.objects.remove(item)
        bpy.context.view_layer.update()
    assert met > 20 and seen > 0
