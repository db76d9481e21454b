# SPDX-License-Identifier: GPL-3.0-or-later
"""Flat drawing over a viewport, for draw handlers of POST_PIXEL: rectangles, lines, text. Lengths in pixels, colours
RGBA 0 .. 1. Also how a draw handler is kept from failing sixty times a second."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ..core.energy import number_text

PAPER, INK, DIM = (0.08, 0.08, 0.09, 0.72), (0.95, 0.95, 0.95, 1.0), (0.7, 0.7, 0.72, 1.0)


def scale() -> float:
    """Pixels per unit of the interface."""
    return bpy.context.preferences.system.ui_scale


def _uniform() -> gpu.types.GPUShader:
    """Blender's shader of one colour, under its name of this version."""
    try:
        return gpu.shader.from_builtin("UNIFORM_COLOR")
    except ValueError:
        return gpu.shader.from_builtin("3D_UNIFORM_COLOR")


def _fill(kind: str, points: np.ndarray, colour: Sequence[float]) -> None:
    shader = _uniform()
    flat = np.zeros((len(points), 3), np.float32)
    flat[:, :2] = points
    batch = batch_for_shader(shader, kind, {"pos": flat})
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("color", colour)
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def rectangle(x: float, y: float, width: float, height: float, colour: Sequence[float]) -> None:
    """A filled rectangle with its lower left corner at (x, y)."""
    corners = [(x, y), (x + width, y), (x, y + height), (x + width, y + height)]
    _fill("TRI_STRIP", np.array(corners), colour)


def squares(middles: np.ndarray, side: float, colour: Sequence[float]) -> None:
    """Filled squares around middles (n, 2), all at once."""
    if len(middles):
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, -1), (1, 1), (-1, 1)]) * side / 2
        _fill("TRIS", (np.asarray(middles)[:, None] + corners).reshape(-1, 2), colour)


def polyline(points: np.ndarray, colour: Sequence[float]) -> None:
    """Through points (n, 2)."""
    if len(points) > 1:
        _fill("LINE_STRIP", points, colour)


def text(x: float, y: float, words: str, colour: Sequence[float] = INK, size: float = 12.0) -> float:
    """Words with their lower left corner there; how long they are."""
    blf.size(0, size * scale())
    blf.color(0, *colour)
    blf.position(0, x, y, 0)
    blf.draw(0, words)
    return blf.dimensions(0, words)[0]


def legend(label: str, low: float, high: float, colours_of: Callable[[np.ndarray], np.ndarray]) -> None:
    """A scale from low to high at the lower right, colours_of(values (n,)) as RGBA (n, 4), below its label."""
    unit, steps = scale(), 48
    width, height, margin = 210 * unit, 14 * unit, 10 * unit
    x, y = bpy.context.region.width - 470 * unit, 30 * unit
    x = max(x, 330 * unit)
    rectangle(x - margin, y - 24 * unit, width + 2 * margin, height + 54 * unit, PAPER)
    for step, colour in enumerate(colours_of(np.linspace(low, high, steps))):
        rectangle(x + step * width / steps, y, width / steps + 1, height, colour.tolist())
    text(x, y + height + 8 * unit, label)
    for part, value in ((0.0, low), (0.44, (low + high) / 2), (0.82, high)):
        text(x + part * width, y - 16 * unit, number_text(value), DIM, 10)


def box(x: float, y: float, lines: Sequence[str]) -> None:
    """Lines of words in a box with its lower left corner at (x, y), or as near to that as the region has room."""
    unit, size, step = scale(), 11.0, 16.0
    blf.size(0, size * scale())
    width = max(blf.dimensions(0, line)[0] for line in lines) + 16 * unit
    height = (step * len(lines) + 10) * unit
    region = bpy.context.region
    x, y = max(0.0, min(x, region.width - width)), max(0.0, min(y, region.height - height))
    rectangle(x, y, width, height, PAPER)
    for number, line in enumerate(lines):
        text(x + 8 * unit, y + height - (step * (number + 1) - 2) * unit, line, INK, size)


class Handler:
    """A draw handler of all 3D views. An exception in it is printed once and ends it: what is drawn is not worth a
    viewport that fails on every redraw."""

    def __init__(self, draw: Callable[[], None], when: str) -> None:
        self._draw = draw
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._call, (), "WINDOW", when)

    def _call(self) -> None:
        if self._draw is None:
            return
        try:
            self._draw()
        except Exception:
            traceback.print_exc()
            self._draw = None

    def remove(self) -> None:
        """Draw no more; a second time does nothing."""
        handle, self._handle, self._draw = self._handle, None, None
        if handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")


def redraw(context: bpy.types.Context, kinds: Sequence[str] = ("WINDOW", "UI")) -> None:
    """Draw such regions of all 3D views anew."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type in kinds:
                        region.tag_redraw()
