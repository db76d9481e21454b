# SPDX-License-Identifier: GPL-3.0-or-later
"""Random draws that no version of numpy changes: SplitMix64 (Steele, Lea and Flood 2014), and what cages draw from it."""
from __future__ import annotations

import math
from typing import Sequence, TypeVar

import numpy as np

T = TypeVar("T")
WORD = 2 ** 64 - 1


class Draw:
    """A stream of draws; the same numbers start the same stream."""

    def __init__(self, *numbers: int) -> None:
        self._state = 0
        for number in numbers:
            self._state = (self._state + (number & WORD)) & WORD
            self._state = self._word()

    def _word(self) -> int:
        self._state = (self._state + 0x9E3779B97F4A7C15) & WORD
        z = self._state
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & WORD
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB & WORD
        return z ^ (z >> 31)

    def real(self, low: float, high: float) -> float:
        """Uniform in [low, high)."""
        return low + (high - low) * ((self._word() >> 11) / 2 ** 53)

    def ratio(self, low: float, high: float) -> float:
        """Uniform in the logarithm, in [low, high)."""
        return math.exp(self.real(math.log(low), math.log(high)))

    def integer(self, low: int, high: int) -> int:
        """Uniform in low..high, both included."""
        return low + self._word() % (high - low + 1)

    def choice(self, items: Sequence[T]) -> T:
        """One of the items."""
        return items[self.integer(0, len(items) - 1)]

    def chance(self, share: float) -> bool:
        """True in this share of draws."""
        return self.real(0, 1) < share

    def sample(self, items: Sequence[T], n: int) -> list[T]:
        """n different ones of the items, in random order."""
        left = list(items)
        return [left.pop(self.integer(0, len(left) - 1)) for _ in range(n)]

    def reals(self, n: int, low: float, high: float) -> np.ndarray:
        """Uniform points [n, 3] in a cube."""
        return np.array([[self.real(low, high) for _ in range(3)] for _ in range(n)])

    def directions(self, n: int) -> np.ndarray:
        """Unit vectors [n, 3], uniform on the sphere."""
        out: list[np.ndarray] = []
        while len(out) < n:
            p = self.reals(1, -1, 1)[0]
            length = math.sqrt(float(p[0] ** 2 + p[1] ** 2 + p[2] ** 2))
            if 0.1 < length < 1:
                out.append(p / length)
        return np.array(out)

    def size(self) -> int:
        """Wanted number of vertices: 85 % between 8 and 60, the others up to 200."""
        return round(self.ratio(8, 60) if self.chance(0.85) else self.ratio(60, 200))
