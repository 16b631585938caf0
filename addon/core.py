# SPDX-License-Identifier: GPL-3.0-or-later
"""The one import site of the compiled module sluice_core, and the list of sessions that still run.

The module is looked for in the folder named by the environment variable SLUICE_CORE, then in the add-on's own folder, where the
build and the packages put it. Whatever goes wrong becomes one sentence that says what was found and what is needed."""
from __future__ import annotations

import importlib.machinery
import importlib.util
import os
import platform
import sys
import weakref
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

VERSION = (0, 1, 0)  # The add-on's version; the core must be of the same one.

_sessions: weakref.WeakSet[Session] = weakref.WeakSet()  # Unregister, file load and exit stop those that still run.
# Cancelled sessions, kept until their threads are done: dropping the last reference would wait for them.
_ending: list[Session] = []


class Session(Protocol):
    """A render of the compiled core (bindings/session.cpp), as far as the add-on uses it."""

    def start(self, description: dict[str, Any], settings: dict[str, Any]) -> None:
        """Begins to compile and render a scene on threads of its own."""

    def start_from(self, base: Session, shot: dict[str, Any], settings: dict[str, Any]) -> bool:
        """The same with what `base` has compiled, seen by another camera and with other edits. False: that cannot be."""

    def wait(self, seconds: float) -> bool:
        """Waits so long at most. Returns whether the session is done."""

    def cancel(self) -> None:
        """Asks the threads to stop, without waiting for them."""

    def progress(self) -> dict[str, Any]:
        """State, passes, photons, seconds, estimated error."""

    def snapshot(self, names: list[str]) -> dict[str, Any] | None:
        """The images of these render passes after the last pass, or None before the first."""

    def statistics(self) -> dict[str, Any]:
        """What was found at edits, where time went, the report."""

    def warnings(self) -> list[tuple[str, str]]:
        """(name of a thing, message)."""

    def film_hash(self) -> str:
        """Equal for images that are equal bit by bit."""


class CoreMissing(RuntimeError):
    """The compiled core cannot be used; the message is one sentence for the artist."""


def folders() -> list[Path]:
    """Where the module is looked for, in this order."""
    named = os.environ.get("SLUICE_CORE")
    return ([Path(named)] if named else []) + [Path(__file__).parent]


def _find(folder: Path) -> Path | None:
    """The module's file in `folder`: for this Python, else a plain .py (tests), else None."""
    if folder.is_file():
        return folder
    for suffix in importlib.machinery.EXTENSION_SUFFIXES + [".py"]:
        path = folder / ("sluice_core" + suffix)
        if path.is_file():
            return path
    return None


def _explain_absence() -> str:
    found = [path.name for folder in folders() if folder.is_dir() for path in sorted(folder.glob("sluice_core*"))]
    python = "cp%d%d on %s" % (*sys.version_info[:2], platform.machine())
    if found:
        return f"Sluice's core does not fit this Blender: found {', '.join(found)}, needed one for Python {python}"
    return (f"Sluice's core is not built: no sluice_core for Python {python} in {' or '.join(map(str, folders()))}; "
            "install a package for this platform, or run ./run build in the repository")


def load() -> ModuleType:
    """The module, imported at the first call. Raises CoreMissing."""
    name = __package__ + ".sluice_core"
    if name in sys.modules:
        return sys.modules[name]
    path = next(filter(None, map(_find, folders())), None)
    if path is None:
        raise CoreMissing(_explain_absence())
    try:
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None and spec.loader is not None  # There always is one for a file with one of these suffixes.
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except (ImportError, OSError) as error:
        raise CoreMissing(f"Sluice's core at {path} does not load: {error}") from error
    found = tuple(int(part) for part in module.__version__.split(".")[:3])
    if found != VERSION:
        raise CoreMissing(f"Sluice's core at {path} is version {module.__version__}, "
                          f"the add-on needs {'.'.join(map(str, VERSION))}: rebuild or reinstall both together")
    sys.modules[name] = module
    return module


def new_session() -> Session:
    """A session that stop_all() knows of."""
    _ending[:] = [session for session in _ending if not session.wait(0)]
    session = load().Session()
    _sessions.add(session)
    return session


def retire(session: Session) -> None:
    """Cancels a session without waiting for its threads."""
    session.cancel()
    _ending.append(session)


def let_go() -> None:
    """Waits for what was retired, so that nothing of it stays in memory."""
    _ending.clear()


def stop_all(*_: object) -> None:
    """Stops every session; idempotent. For unregister, atexit and the load_pre handler."""
    for session in list(_sessions):
        session.cancel()
    _sessions.clear()
    _ending.clear()


def expression_problem(error: Exception) -> tuple[str, int | None, str]:
    """An ExpressionError or SceneError as (item, column or None, message)."""
    return getattr(error, "item", "") or "", getattr(error, "column", None), str(error)
