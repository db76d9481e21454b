# SPDX-License-Identifier: GPL-3.0-or-later
"""A solver that stays: one level of a cage, solved again and again while its targets move."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .api import Cancel, Energy, run_options
from .library import Iterate, load
from .library import Mesh as _Mesh
from .library import Solver as _Solver
from .values import Cage, LevelReport, Progress, Summary


class Solver:
    """The cage itself, without subdivision, made ready to be minimized over again and again. A context manager; belongs to
    one thread at a time.

        with Solver(cage, "mvs", held=[3, 8], places=points) as solver:
            solver.solve()
            solver.set_places(points + [0, 0, 0.1])
            solver.solve(settle=False, on_positions=show)
            solver.solve()
            fair = solver.cage()

    The options are those of minimize(), but `levels` and `slide`. Tables, rules, factors and positions are kept between
    solutions. CurvoptError where the library refuses, ValueError for unknown names and wrong lengths."""

    def __init__(self, cage: Cage, energy: Energy = "willmore", **options: object) -> None:
        lib = load()
        raw = run_options(lib, cage, energy, **options)
        self._cage = cage
        with _Mesh.of_cage(lib, cage) as mesh:
            self._solver = _Solver.create(mesh, cage.positions, raw)

    def set_places(self, places: object) -> None:
        """Where the held vertices or limit points are to be from now on: (k, 3); NAN: where they were at first. Cheap."""
        self._solver.set_places(places)

    def set_options(self, energy: Energy = "willmore", **options: object) -> None:
        """Another energy, other held vertices and other options: all of them, as for a new Solver; it goes on from where it
        stands."""
        self._solver.set_options(run_options(load(), self._cage, energy, **options))

    def set_positions(self, positions: object = None) -> None:
        """Stand at positions (n, 3), or, without, at those of the first cage."""
        self._solver.set_positions(positions)

    def solve(
        self,
        settle: bool = True,
        *,
        on_progress: Callable[[Progress], object] | None = None,
        on_positions: Callable[[np.ndarray], object] | None = None,
        cancel: Cancel | None = None,
    ) -> Summary:
        """From where it stands to its targets.

        settle        whether to the optimum, with a verdict; else to where the energy falls by little any more
        on_progress   called on this thread at the start and after every step; a true value ends the solution there
        on_positions  called before it with a copy of the positions (n, 3)
        cancel        ends it from any thread

        A cancelled solution is no error: its `stop` is "cancelled", and the next one goes on from there."""

        def watch(iterate: Iterate) -> None:
            on_positions(iterate.positions())

        flag = cancel._flag if cancel is not None else None
        self._solver.solve(settle, on_progress, flag, watch if on_positions else None)
        return self._solver.summary()

    @property
    def positions(self) -> np.ndarray:
        """A copy of where it stands (n, 3)."""
        return self._solver.positions()

    @property
    def summary(self) -> Summary:
        """Of the last solution."""
        return self._solver.summary()

    @property
    def report(self) -> LevelReport:
        """Steps and evaluations of the last solution."""
        return self._solver.report()

    def cage(self) -> Cage:
        """The cage where it stands."""
        old = self._cage
        return Cage(self.positions, old.face_sizes, old.face_vertices, old.creases)

    def close(self) -> None:
        """Free it; a second time does nothing."""
        self._solver.close()

    def __enter__(self) -> Solver:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


__all__ = ["Solver"]
