# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoises what the 3D view shows, beside Blender: the view goes on to be drawn meanwhile."""
from __future__ import annotations

import sys
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING

from . import core, denoising, passes

if TYPE_CHECKING:
    import numpy as np

_FIRST = 4  # So many passes are shown as they are; before them denoised pictures would be of blotches.


class Cleaner:
    """Denoises the pictures of one session, one at a time: after 4 passes, then each time that there are twice as many, and at the end."""

    def __init__(self) -> None:
        self._pool: ThreadPoolExecutor | None = None
        self._work: Future[np.ndarray] | None = None
        self._passes = 0  # of the picture that was taken up last
        self._failed = False
        self.shows = False  # Has it given a picture yet? From then on raw ones are no longer shown.

    @property
    def is_busy(self) -> bool:
        """Is a picture being denoised, or has one been that nobody has taken?"""
        return self._work is not None

    @property
    def is_ready(self) -> bool:
        """Is there a denoised picture to be taken?"""
        return self._work is not None and self._work.done()

    def offer(self, session: core.Session, is_last: bool) -> None:
        """Takes up the session's picture if it is time."""
        done = session.progress()["pass"]
        is_due = done >= (max(_FIRST, self._passes + 1) if is_last else max(_FIRST, 2 * self._passes))
        if self._work is not None or self._failed or not is_due:
            return
        images = session.snapshot(["Combined", *passes.GUIDES])
        if images is not None:
            self._pool = self._pool or ThreadPoolExecutor(1)
            self._work, self._passes = self._pool.submit(denoising.denoise, images), done

    def take(self) -> np.ndarray | None:
        """The denoised picture, once. If the package fails, that is told in the console and the view stays as it is rendered."""
        if self._work is None or not self._work.done():
            return None
        work, self._work = self._work, None
        try:
            picture = work.result()
        except denoising.Failed as failure:
            print(f"sluice: warning: {denoising.ITEM}: {failure}", file=sys.stderr, flush=True)
            self._failed, self.shows = True, False
            return None
        self.shows = True
        return picture

    def stop(self) -> None:
        """Nobody wants its pictures any more."""
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
        self._work = None
