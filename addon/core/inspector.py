# SPDX-License-Identifier: GPL-3.0-or-later
"""The worker that samples the surface which is inspected. No bpy.

The main thread says what to look at (`look`) and reads `latest`. The newest subject wins. For each there is a coarse picture
at once, and a fine one when no other subject has come meanwhile. How coarse depends on how long the last one took.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from ..binding import library
from .inspected import Inspected, Sampling, Subject

FINE = 40_000  # quads of the picture that stays
COARSE = 1_500, 12_000  # least and most quads of one that passes
_BUDGET = 0.03  # seconds of a picture that passes: two frames
_REST = 0.08  # seconds without another subject after which the fine picture is worth its tenth of a second


class Inspector:
    """Every method is for the main thread and returns at once, `close` excepted. `latest` is the newest picture or None;
    `error`, why there is none of the newest subject, or None."""

    def __init__(self, sampling: Callable[[], Sampling] = lambda: Sampling(library.load())) -> None:
        self.latest: Inspected | None = None
        self.error: BaseException | None = None
        self._make = sampling
        self._subject: Subject | None = None
        self._wanted = float(COARSE[1])
        self._closing = False
        self._flag: library.Cancel | None = None
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="curvopt reading", daemon=True)

    def look(self, subject: Subject) -> None:
        """Look at this now."""
        with self._changed:
            self._subject = subject
            self._interrupt()
        if self._thread.ident is None:
            self._thread.start()

    @property
    def is_settled(self) -> bool:
        """Whether the newest subject's last picture is there, or its refusal."""
        done = self.latest is not None and self.latest.subject is self._subject and self.latest.is_fine
        return self._subject is None or done or self.error is not None

    def close(self, timeout: float | None = None) -> bool:
        """End, and wait for that, `timeout` seconds at most: whether the worker has ended."""
        with self._changed:
            self._closing = True
            self._interrupt()
        if self._thread.ident is not None:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _interrupt(self) -> None:
        """With the lock."""
        self.error = None
        if self._flag is not None:
            self._flag.request()
        self._changed.notify()

    # -------------------------------------------------------------------------------------------------- worker --

    def _run(self) -> None:
        try:
            sampling = self._make()
        except BaseException as error:  # no library; the main thread reads it
            self.error = error
            return
        with sampling:
            done = None  # subject whose fine picture is there
            while True:
                with self._changed:
                    while not self._closing and (self._subject is None or self._subject is done):
                        self._changed.wait()
                    if self._closing:
                        return
                    subject = self._subject
                    fine = self.latest is not None and self.latest.subject is subject
                    if fine and self._changed.wait_for(lambda: self._closing or self._subject is not subject, _REST):
                        continue
                    flag = self._flag = library.Cancel.create(library.load())
                try:
                    self._take(sampling, subject, fine, flag)
                    done = subject if fine else done
                except BaseException as error:
                    done = subject
                    self._refuse(subject, error)
                finally:
                    with self._changed:
                        self._flag = None
                    flag.close()

    def _take(self, sampling: Sampling, subject: Subject, fine: bool, flag: library.Cancel) -> None:
        begin = time.thread_time()
        found = sampling.take(subject, FINE if fine else int(self._wanted), fine, flag)
        took = max(time.thread_time() - begin, 1e-6)
        if not fine:
            self._wanted = min(max(self._wanted * _BUDGET / took, COARSE[0]), COARSE[1])
        with self._changed:
            if self._subject is subject or not fine:  # a fine one that was cancelled is worth nothing
                self.latest = found

    def _refuse(self, subject: Subject, error: BaseException) -> None:
        with self._changed:
            if self._subject is subject:
                self.error, self.latest = error, None
