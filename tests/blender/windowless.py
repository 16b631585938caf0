# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's half of rendered mode where there is no window, for tests and measurements."""
import time
from types import SimpleNamespace

import bpy


class Updated:
    """The depsgraph, with a list of updates of our own."""

    def __init__(self, *datablocks):
        self._graph = bpy.context.evaluated_depsgraph_get()
        everything = {f"is_updated_{what}": True for what in ("geometry", "transform", "shading")}
        self.updates = [SimpleNamespace(id=item.evaluated_get(self._graph), **everything) for item in datablocks]

    def __getattr__(self, name):
        return getattr(self._graph, name)


class Engine:
    """What Blender gives the engine's callbacks."""

    def __init__(self):
        self.view, self.said = None, []

    def update_stats(self, _, text):
        self.said.append(text)

    def tag_redraw(self):
        pass

    def get_preview_pixel_size(self, _scene):
        return 1


class Window:
    """A 3D view through a camera; keeps the sessions that were started for it, and counts how often the scene was copied."""

    def __init__(self, width, height, camera, replace=setattr):
        from sluice import export, viewport
        replace(viewport, "_make_texture", lambda pixels: pixels)
        replace(viewport, "_draw_image", lambda *_: None)
        self._export_scene = export.export_scene
        replace(export, "export_scene", self._copy)
        self._viewport = viewport
        lens = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=width, y=height)
        self.region_3d = SimpleNamespace(is_perspective=True, view_matrix=camera.matrix_world.inverted(), window_matrix=lens)
        self.context = SimpleNamespace(blend_data=bpy.data, region=SimpleNamespace(width=width, height=height), region_data=self.region_3d)
        self.engine, self.copies, self.sessions = Engine(), 0, []

    def _copy(self, *arguments):
        self.copies += 1
        return self._export_scene(*arguments)

    @property
    def view(self):
        return self.engine.view

    def update(self, *datablocks):
        self._viewport.update(self.engine, self.context, Updated(*datablocks))

    def draw(self):
        self._viewport.draw(self.engine, self.context, bpy.context.evaluated_depsgraph_get())
        if self.view.session is not None and self.view.session not in self.sessions:
            self.sessions.append(self.view.session)

    def follow(self):
        """Draws until an image of what is now was seen."""
        self.draw()
        while self.view.stale or self.view.level == 0 and not self.view.shown_pass:
            assert self.view.session is not None, self.engine.said[-1]
            time.sleep(0.002)
            self.draw()

    def settle(self):
        """Draws until the finest level is done."""
        while self.view.level < 2 or not self.view.told:
            assert self.view.session is not None, self.engine.said[-1]
            self.view.session.wait(60)
            self.draw()
