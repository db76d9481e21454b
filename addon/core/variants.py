# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished run, and others like it with another setting, as the adjust-last-operation panel asks for them. No bpy."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable

from ..binding.values import Cage
from . import job
from .job import Request, Solution
from .messages import UserError

QUICK = 5.0  # seconds that a run may have taken whose settings can be adjusted
_LONGEST = 10.0  # seconds after which a run with another setting is given up: Blender does nothing else meanwhile
_MOST_OTHERS = 8  # results of other settings that are kept


class Variants:
    """Runs on one cage by their key, which says what is particular to each."""

    def __init__(self, cage: Cage, key: Hashable, request: Request, solution: Solution) -> None:
        self.first = request, solution
        self._cage, self._key = cage, key
        self._others: dict[Hashable, tuple[Request, Solution]] = {}

    @property
    def is_quick(self) -> bool:
        """Whether other settings are worth offering."""
        return self.first[1].seconds <= QUICK

    def get(self, key: Hashable, request: Callable[[], Request], name: str) -> tuple[Request, Solution]:
        """The run of that key, now if there was none: that of `request`, called `name`. UserError if that takes too
        long."""
        if key == self._key:
            return self.first
        if key not in self._others:
            self._others[key] = self._run(request(), name)
            while len(self._others) > _MOST_OTHERS:
                del self._others[next(iter(self._others))]
        return self._others[key]

    def _run(self, request: Request, name: str) -> tuple[Request, Solution]:
        deadline = time.monotonic() + _LONGEST
        found = job.solve(self._cage, request, lambda _: time.monotonic() > deadline)
        if found.stop == "cancelled":
            raise UserError(f"{name} takes over {_LONGEST:.0f} s: set it in the sidebar and press Minimize.")
        return request, found
