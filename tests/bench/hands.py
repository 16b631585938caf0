# SPDX-License-Identifier: GPL-3.0-or-later
"""What a hand feels of rendered mode in a real window (Xvfb), and how long the add-on takes to start.

    ./run python tests/bench/hands.py

Prints a table: commit, processor, what, value, unit, goal (issue: an artist's hands). The window is drawn by software, on the processors
that render: rows say what Blender alone takes to show the same drag in solid mode, and what comes on top."""

import csv
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "blend_scenes/glass_egg.blend"
GOALS = {"add-on start": 0.2, "drag to first image": 0.3, "longest call while dragging": 50, "viewport overhead": 10}
MOVES, DRAGS, PASSES, TURNS = 5, 20, 16, 2


def row(what, value, unit):
    print(f"hands:{what};{value:.4g};{unit}", flush=True)


# --- inside Blender -------------------------------------------------------------------------------------------------------------------------


def start():
    """In background: as a user's Blender does it at its start. The core waits for the first render."""
    import addon_utils
    begin, work = time.perf_counter(), time.process_time()
    addon_utils.enable("sluice")
    row("add-on start", time.perf_counter() - begin, "s")
    row("add-on start, on the processor", time.process_time() - work, "s")
    from sluice import core
    begin = time.perf_counter()
    core.load()
    row("core, at the first render", time.perf_counter() - begin, "s")


def alone():
    """The same drag without a window: Blender draws nothing."""
    import bpy
    sys.path.insert(0, str(ROOT / "tests/blender"))
    from windowless import Window
    scene, waits = bpy.context.scene, []
    window = Window(990, 690, scene.camera)
    moved = next(item for item in scene.objects if item.sluice.role == 'EXIT')
    window.update()
    window.follow()
    for _ in range(2 * MOVES):
        begin = time.perf_counter()
        moved.location.x += 0.01
        window.update(moved)
        window.follow()
        waits.append(time.perf_counter() - begin)
    row("drag to first image, without a window", statistics.median(waits), "s")
    row("drag to first image, without a window, best", min(waits), "s")


class Calls:
    """How long each call of ours takes in Blender's own thread, by the clock and on the processor, and how long its timers wait."""

    def __init__(self):
        from sluice import overlay, renaming, viewport
        self.longest, self.work, self.gap, self.beat, self.ticks = {}, 0.0, 0.0, None, False
        overlay.unregister()
        for room, names in ((viewport, ("update", "draw", "_look")), (overlay, ("_draw", "_draw_names")), (renaming, ("follow",))):
            for name in names:
                setattr(room, name, self.timed(getattr(room, name), name))
        overlay.register()

    def timed(self, function, name):
        def call(*arguments):
            begin, work = time.perf_counter(), time.thread_time()
            found = function(*arguments)
            took = time.perf_counter() - begin, time.thread_time() - work
            self.work += took[1]
            self.longest[name] = [max(pair) for pair in zip(took, self.longest.get(name, (0, 0)))]
            return found
        return call

    def tick(self):
        if not self.ticks:  # it wakes Blender 200 times a second: nothing else is timed then
            return None
        now = time.perf_counter()
        self.gap, self.beat = max(self.gap, now - (self.beat or now)), now
        return 0.005

    def start_ticks(self):
        import bpy
        self.ticks, self.beat = True, None
        bpy.app.timers.register(self.tick)

    def clear(self):
        self.longest.clear()
        self.work = self.gap = 0.0


def window():
    sys.path.insert(0, str(ROOT / "tests/blender/gui"))
    from session import main
    main(window_steps)


def window_steps():
    import bpy
    from session import area
    from sluice import viewport
    calls, views = Calls(), []
    begin = viewport._start
    viewport._start = lambda engine, view, *more: (views.append(view), begin(engine, view, *more))
    drawn, draw_image = [], viewport._draw_image
    viewport._draw_image = lambda *arguments: (draw_image(*arguments), drawn.append(time.perf_counter()))
    space, scene = area('VIEW_3D').spaces.active, bpy.context.scene
    moved = next(item for item in scene.objects if item.sluice.role == 'EXIT')
    scene.sluice.passes, scene.sluice.photons = PASSES, 50000
    yield from drag(calls, moved, "longest gap while dragging, solid mode")
    blender_alone = yield from drawn_in_solid_mode(moved)
    row("drag drawn in solid mode: Blender alone", blender_alone, "s")
    space.shading.type = 'RENDERED'
    yield None, 4
    view = views[-1]
    waits = []
    for _ in range(MOVES):
        waits.append((yield from first_image(view, moved, drawn)))
        yield None, 1
    handed, shown = zip(*waits)
    row("drag to first image", statistics.median(shown), "s")
    row("drag to first image, beyond what Blender alone takes", statistics.median(shown) - blender_alone, "s")
    row("drag to first image, worst", max(shown), "s")
    row("drag to first image, of that until it is handed to Blender", statistics.median(handed), "s")
    yield from drag(calls, moved, "longest gap while dragging, rendered mode")
    for what, of_calls in (("longest call while dragging", 0), ("longest call while dragging, on the processor", 1)):
        name, took = max(calls.longest.items(), key=lambda call: call[1][of_calls])
        row(what, 1e3 * took[of_calls], f"ms ({name})")
    yield from overhead(calls, view, moved)


def drawn_in_solid_mode(moved):
    """Seconds from a move until Blender has drawn its window, nothing being rendered: median."""
    import bpy
    waits, drawn = [], []
    handler = bpy.types.SpaceView3D.draw_handler_add(lambda: drawn.append(True), (), 'WINDOW', 'POST_PIXEL')
    for _ in range(MOVES):
        yield None, 1
        drawn.clear()
        begin = time.perf_counter()
        moved.location.x += 0.01
        while not drawn:
            yield None, 0.01
        waits.append(time.perf_counter() - begin)
    bpy.types.SpaceView3D.draw_handler_remove(handler, 'WINDOW')
    return statistics.median(waits)


def first_image(view, moved, drawn):
    """Seconds from a move until the view has drawn the image of it, and until Blender has drawn the rest of the window."""
    begin = time.perf_counter()
    drawn.clear()
    old = view.session
    moved.location.x += 0.01
    while view.session is old or view.stale or view.level == 0 and not view.shown_pass:
        yield None, 0.01
    return drawn[-1] - begin, time.perf_counter() - begin


def drag(calls, moved, what):
    yield None, 0.5
    calls.clear()
    calls.start_ticks()
    for _ in range(DRAGS):
        moved.location.x += 0.002
        yield None, 0.03
    calls.ticks = False
    yield None, 0.1
    row(what, 1e3 * calls.gap, "ms")


def overhead(calls, view, moved):
    """The last level as the view renders it, and the same session with nobody looking. On a busy machine the second row says more: what
    our calls in Blender's thread cost, of the time that the view renders."""
    from sluice import core, viewport
    from sluice.export.camera import export_view
    seen, alone, ours = [], [], []
    for _ in range(TURNS):
        moved.sluice.intensity *= 1.01
        yield None, 0.5
        while view.level < 2:
            yield None, 0.02
        calls.clear()
        while not viewport._at_rest(view):
            yield None, 0.1
        seen.append(view.session.progress()["seconds"])
        ours.append(calls.work / seen[-1])
        size, is_perspective, view_matrix, window_matrix = view.seen
        camera, frame = export_view(view_matrix, window_matrix, is_perspective, size)
        session = core.new_session()
        session.start({**view.description, "camera": camera, "frame": frame}, viewport._settings_of_level(view.settings, 1))
        while not session.wait(10):
            pass
        alone.append(session.progress()["seconds"])
        assert session.film_hash() == view.session.film_hash()
    row("viewport overhead", 100 * (min(seen) / min(alone) - 1), "%")
    row("viewport overhead, our calls on the processor", 100 * min(ours), "%")


# --- outside --------------------------------------------------------------------------------------------------------------------------------


def blender(*arguments):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}  # an artist's Python keeps what it compiled
    done = subprocess.run(arguments, env=environment, capture_output=True, text=True, timeout=600)
    found = [line.removeprefix("hands:").split(";") for line in done.stdout.splitlines() if line.startswith("hands:")]
    if done.returncode or not found:
        sys.exit(done.stdout[-3000:] + done.stderr[-3000:])
    return found


def main():
    from tempfile import mkdtemp
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    sys.path.insert(0, str(ROOT / "tools"))
    from bench import processor
    starts = [blender("blender", "-b", "--factory-startup", "-Y", "--python", __file__, "--", "", "start") for _ in range(TURNS)]
    rows = min(starts, key=lambda found: float(found[0][1]))
    rows += blender("blender", "-b", "--factory-startup", "-Y", "--addons", "sluice", SCENE, "--python", __file__, "--", "", "alone")
    rows += blender("xvfb-run", "-a", "-s", "-screen 0 1200x800x24", "blender", "--factory-startup", "-Y", "--addons", "sluice", "-p", "0", "0", "1200", "800",
                    SCENE, "--python", __file__, "--", mkdtemp(), "window")  # fmt: skip
    table = csv.writer(sys.stdout)
    table.writerow(("commit", "processor", "what", "value", "unit", "goal"))
    table.writerows((commit, processor(), *found, GOALS.get(found[0], "")) for found in rows)


if __name__ == "__main__":
    if "bpy" in sys.modules:
        {"start": start, "alone": alone, "window": window}[sys.argv[-1]]()
    else:
        main()
