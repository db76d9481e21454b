# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface that follows the hand, as the viewports show it: where the object is, with a dot on each handle. Not for
Blenders in background."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from ..core.live import Live
from . import inspect_view, overlay
from .preview import CLAY, Picture

_DOT = 7.0  # sides of a handle's dot, in units of the interface
_RIM, _HANDLE = (0.05, 0.05, 0.06, 1.0), (1.0, 0.66, 0.25, 1.0)


class LiveView:
    """From its creation to `end`. `show` says what, and where."""

    def __init__(self, scene_name: str) -> None:
        self.live: Live | None = None
        self._frame, self._handles = Matrix(), np.empty((0, 3))
        self._scene_name, self._name = scene_name, ""
        self._picture = Picture()
        self._handlers = [overlay.Handler(self._surface, "POST_VIEW"), overlay.Handler(self._dots, "POST_PIXEL")]

    def show(self, live: Live, frame: Matrix, handles: np.ndarray, name: str) -> None:
        """The newest state of `live` in `frame`, and handles (h, 3) in it; the object's name."""
        self.live, self._frame, self._handles, self._name = live, frame, handles, name

    def end(self) -> None:
        """Draw no more, and free what the GPU holds."""
        for handler in self._handlers:
            handler.remove()
        self._picture.forget()
        self.live = None

    def _is_here(self) -> bool:
        return self.live is not None and bpy.context.scene is not None and bpy.context.scene.name == self._scene_name

    def _surface(self) -> None:
        if not self._is_here() or self.live.latest is None:
            return
        view, inspected = self.live.latest, inspect_view.current
        if inspected is None or not inspected.covers(self._name):
            self._picture.draw(view.snapshot, None, bpy.context.region_data.perspective_matrix, self._frame, CLAY)
        self.live.seen(view)

    def _dots(self) -> None:
        if not self._is_here():
            return
        region, view, unit = bpy.context.region, bpy.context.region_data, overlay.scale()
        matrix = np.array(view.perspective_matrix @ self._frame, np.float64)
        seen = np.c_[self._handles, np.ones(len(self._handles))] @ matrix.T
        seen = seen[seen[:, 3] > 0]  # not behind the eye
        places = (1 + seen[:, :2] / seen[:, 3:]) * np.array([region.width, region.height]) / 2
        for side, colour in ((_DOT + 2, _RIM), (_DOT, _HANDLE)):
            overlay.squares(places, side * unit, colour)
