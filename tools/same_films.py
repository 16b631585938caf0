# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders what same_scenes.py copied, by the core that PYTHONPATH names. Prints, one line of JSON each, [scene, way, film hash, guide hash].

    python tools/same_films.py SCENES              every scene in three ways: with edits, without, and recompiled as in the viewport
    python tools/same_films.py SCENES SCENE        that scene alone, with edits, on one thread: for counting instructions
    python tools/same_films.py SCENES SCENE idle   all of that but the render"""
import json
import pickle
import sys
from pathlib import Path

import sluice_core

SMALL = {"passes": 2, "photons": 8192, "pilot_paths": 8192, "seed": 0, "threads": 2, "time_limit": 0.0, "error_target": 0.0}
SHOT = ("edits", "max_gates", "camera", "frame")


def wait(session):
    while not session.wait(10):
        pass
    progress = session.progress()
    if progress["state"] != "finished":
        raise SystemExit(f"a render ended as {progress}")
    return session


def started(scene, **settings):
    session = sluice_core.Session()
    session.start(scene["description"], {**scene["settings"], **SMALL, **settings})
    return wait(session)


def recompiled(scene):
    """From what a session without edits compiled, as the viewport does when an edit is moved."""
    description, settings = scene["description"], {**scene["settings"], **SMALL}
    base = sluice_core.Session()
    base.start({**description, "edits": []}, {**settings, "passes": 1})
    wait(base)
    session = sluice_core.Session()
    if not session.start_from(base, {key: description[key] for key in SHOT if key in description}, settings):
        raise SystemExit("the session did not start from the base")
    return wait(session)


def main(file, only=None, idle=False):
    scenes = pickle.loads(Path(file).read_bytes())
    if only:
        return None if idle else started(scenes[only], threads=1)
    for name, scene in scenes.items():
        ways = {"edits": started, "no edits": lambda s: started(s, use_edits=False), "recompiled": recompiled}
        for way, render in ways.items():
            session = render(scene)
            print(json.dumps([name, way, session.film_hash(), session.statistics()["guide_hash"]]), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
