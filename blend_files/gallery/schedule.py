# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the gallery's items in an order that their needs allow: calculations on some threads, drawing on the main one.

No bpy. A finished item is written down at once, so that a run which is killed loses no more than the items in work.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field

from .store import Item, Store, keys


@dataclass
class Outcome:
    """Names of what was made, of what was fresh already, and what failed, with why."""

    made: list[str] = field(default_factory=list)
    fresh: list[str] = field(default_factory=list)
    failed: dict[str, str] = field(default_factory=dict)


def with_needs(items: Sequence[Item], names: Collection[str]) -> list[Item]:
    """The items of these names and all that they need, in the order of `items`, which stand after what they need."""
    wanted = set(names)
    for item in reversed(items):
        if item.name in wanted:
            wanted.update(item.needs)
    return [item for item in items if item.name in wanted]


def run(items: Sequence[Item], store: Store, jobs: int, say: Callable[[str], None]) -> Outcome:
    """Make every item that is not fresh, `jobs` calculations at a time. An item that raises is failed, and so are those
    that need it; the others are made."""
    return _Run(items, store, say).run(jobs)


class _Run:
    def __init__(self, items: Sequence[Item], store: Store, say: Callable[[str], None]) -> None:
        self.store, self.say = store, say
        self.keys = keys(items, store.version)
        self.outcome = Outcome(fresh=[item.name for item in items if store.fresh(item, self.keys[item.name])])
        self.done = set(self.outcome.fresh)
        self.waiting = [item for item in items if item.name not in self.done]
        self.total = len(self.waiting)
        self.costs = {item.name: self._guess(item) for item in self.waiting}
        self.spent = 0.0  # of the costs that were guessed
        self.start = time.monotonic()

    def _guess(self, item: Item) -> float:
        """Seconds that an item may take: what it took the last time, whatever has changed, or else its cost."""
        entry = self.store.entry(item.name)
        return max(0.01, entry["seconds"] if entry is not None else item.cost)

    def run(self, jobs: int) -> Outcome:
        """Make everything, `jobs` calculations at a time."""
        if self.outcome.fresh:
            self.say(f"{len(self.outcome.fresh)} items are finished already, {self.total} are to be made")
        pool = ThreadPoolExecutor(jobs, thread_name_prefix="gallery")
        working: dict[Future, Item] = {}
        try:
            while self.waiting or working:
                for item in self._ready(drawn=False):  # all of them, so that threads have work while this one draws
                    self.waiting.remove(item)
                    working[pool.submit(self._timed, item)] = item
                drawn = self._ready(drawn=True)
                if drawn:
                    self.waiting.remove(drawn[0])
                    self._settle(drawn[0], self._timed(drawn[0]))
                elif not working:
                    self._give_up()
                finished, _ = wait(working, timeout=0 if drawn else None, return_when=FIRST_COMPLETED)
                for future in finished:
                    self._settle(working.pop(future), future.result())
        finally:
            pool.shutdown(wait=False, cancel_futures=True)  # after an interrupt, work that waits is not to be done
        return self.outcome

    def _ready(self, drawn: bool) -> list[Item]:
        return [item for item in self.waiting if item.drawn == drawn and self.done.issuperset(item.needs)]

    def _timed(self, item: Item) -> tuple[float, BaseException | None]:
        """Make an item and write it down; the seconds that it took, and what it raised."""
        start = time.monotonic()
        try:
            result = item.work(self.store, item)
            self.store.finish(item, self.keys[item.name], time.monotonic() - start, result)
        except Exception as error:  # the others go on; reported below
            return time.monotonic() - start, error
        return time.monotonic() - start, None

    def _settle(self, item: Item, made: tuple[float, BaseException | None]) -> None:
        seconds, error = made
        self.spent += self.costs[item.name]
        if error is None:
            self.done.add(item.name)
            self.outcome.made.append(item.name)
        else:
            self.outcome.failed[item.name] = f"{type(error).__name__}: {error}"
        number = len(self.outcome.made) + len(self.outcome.failed)
        word = f"{seconds:.1f} s" if error is None else f"FAILED, {self.outcome.failed[item.name]}"
        self.say(f"[{number}/{self.total}] {item.name}: {word}; {self._left()}")

    def _left(self) -> str:
        left = sum(self.costs.values()) - self.spent
        seconds = left * (time.monotonic() - self.start) / self.spent
        return f"about {seconds / 60:.0f} min left" if seconds >= 90 else f"about {seconds:.0f} s left"

    def _give_up(self) -> None:
        """Nothing can be made any more: what waits needs something that has failed."""
        for item in self.waiting:
            lacking = [need for need in item.needs if need not in self.done]
            self.outcome.failed[item.name] = f"it needs {', '.join(lacking)}"
            self.say(f"{item.name}: not made, {self.outcome.failed[item.name]}")
        self.waiting = []
