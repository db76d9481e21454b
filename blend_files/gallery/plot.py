# SPDX-License-Identifier: GPL-3.0-or-later
"""Line plots as SVG, drawn from measured data without any package. No bpy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

_WIDTH, _HEIGHT = 760, 420
_LEFT, _RIGHT, _TOP, _BOTTOM = 78, 210, 34, 52
_INKS = ("#1f5fa8", "#b5482a", "#2f7d46", "#7a4aa0", "#9a7b10", "#4a4a4a", "#c03a78", "#2a8f94")


@dataclass(frozen=True)
class Series:
    """Points to show as "line", "dashes" or "dots", with a label in the legend; ink by its place if none is given."""

    label: str
    points: Sequence[tuple[float, float]]
    style: str = "line"
    ink: str = ""


@dataclass(frozen=True)
class Axis:
    """An axis' title, its range (None: of the data), and whether it is logarithmic."""

    title: str
    low: float | None = None
    high: float | None = None
    log: bool = False
    ticks: Sequence[float] = field(default_factory=tuple)


class _Scale:
    def __init__(self, axis: Axis, values: Sequence[float], start: float, end: float) -> None:
        low = min(values) if axis.low is None else axis.low
        high = max(values) if axis.high is None else axis.high
        if low == high:
            low, high = low - 0.5 * abs(low or 1), high + 0.5 * abs(high or 1)
        self.log, self.low, self.high, self.start, self.end = axis.log, low, high, start, end
        self.ticks = list(axis.ticks) or (_decades(low, high) if axis.log else _steps(low, high))

    def __call__(self, value: float) -> float:
        low, high = self.low, self.high
        if self.log:
            low, high, value = math.log(low), math.log(high), math.log(value)
        return self.start + (self.end - self.start) * (value - low) / (high - low)

    def holds(self, value: float) -> bool:
        """Whether a value is in the range of the axis."""
        slack = 1e-9 * (self.high - self.low)
        return self.low - slack <= value <= self.high + slack


def _steps(low: float, high: float) -> list[float]:
    raw = (high - low) / 6
    unit = 10 ** math.floor(math.log10(raw))
    step = next(k * unit for k in (1, 2, 2.5, 5, 10) if k * unit >= raw)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def _decades(low: float, high: float) -> list[float]:
    exponents = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [10.0**k for k in exponents if low <= 10.0**k <= high]
    if len(ticks) >= 3:
        return ticks
    fine = [m * 10.0**k for k in exponents for m in (1, 2, 3, 5) if low <= m * 10.0**k <= high]
    return fine if len(fine) < 8 else [tick for tick in fine if not f"{tick:e}".startswith("3")]


def plot(title: str, x: Axis, y: Axis, series: Sequence[Series], levels: Sequence[tuple[str, float]] = ()) -> str:
    """The SVG of some series; `levels` are named horizontal lines. Points outside the axes' ranges are left out.

    ValueError if there is nothing to show."""
    points = [point for one in series for point in one.points]
    if not points:
        raise ValueError(f"'{title}' has no points")
    across = _Scale(x, [p[0] for p in points], _LEFT, _WIDTH - _RIGHT)
    up = _Scale(y, [p[1] for p in points] + [value for _, value in levels], _HEIGHT - _BOTTOM, _TOP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}" '
        f'height="{_HEIGHT}" font-family="sans-serif" font-size="12">',
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="white"/>',
        f'<text x="{_LEFT}" y="20" font-size="14" font-weight="bold">{escape(title)}</text>',
        *_grid(x, y, across, up),
    ]
    for name, value in levels:
        parts.append(_path([(_LEFT, up(value)), (_WIDTH - _RIGHT, up(value))], "#888", "2 4"))
        parts.append(f'<text x="{_LEFT + 6}" y="{up(value) - 4:.1f}" fill="#666">{escape(name)}</text>')
    for index, one in enumerate(series):
        parts += _drawn(one, one.ink or _INKS[index % len(_INKS)], index, across, up)
    return "\n".join([*parts, "</svg>"]) + "\n"


def _grid(x: Axis, y: Axis, across: _Scale, up: _Scale) -> list[str]:
    parts = []
    bottom, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    for tick in across.ticks:
        parts.append(_path([(across(tick), _TOP), (across(tick), bottom)], "#e4e4e4"))
        parts.append(f'<text x="{across(tick):.1f}" y="{bottom + 16}" text-anchor="middle">{tick:g}</text>')
    for tick in up.ticks:
        parts.append(_path([(_LEFT, up(tick)), (right, up(tick))], "#e4e4e4"))
        parts.append(f'<text x="{_LEFT - 6}" y="{up(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>')
    parts.append(_path([(_LEFT, _TOP), (_LEFT, bottom), (right, bottom)], "#444"))
    parts.append(f'<text x="{(_LEFT + right) / 2}" y="{_HEIGHT - 14}" text-anchor="middle">{escape(x.title)}</text>')
    middle = (_TOP + bottom) / 2
    parts.append(
        f'<text x="18" y="{middle}" text-anchor="middle" transform="rotate(-90 18 {middle})">{escape(y.title)}</text>'
    )
    return parts


def _drawn(one: Series, ink: str, index: int, across: _Scale, up: _Scale) -> list[str]:
    places = [(across(a), up(b)) for a, b in one.points if across.holds(a) and up.holds(b)]
    left, height = _WIDTH - _RIGHT + 14, _TOP + 12 + 20 * index
    legend = f'<text x="{left + 26}" y="{height + 4}">{escape(one.label)}</text>'
    if one.style == "dots":
        dots = [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3.6" fill="{ink}"/>' for a, b in [*places, (left + 10, height)]]
        return [*dots, legend]
    dashes = "6 4" if one.style == "dashes" else ""
    return [_path(places, ink, dashes, 2), _path([(left, height), (left + 20, height)], ink, dashes, 2), legend]


def _path(places: Sequence[tuple[float, float]], ink: str, dashes: str = "", width: float = 1) -> str:
    if not places:
        return ""
    line = " L".join(f"{a:.1f} {b:.1f}" for a, b in places)
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return f'<path d="M{line}" fill="none" stroke="{ink}" stroke-width="{width}"{dashed}/>'
