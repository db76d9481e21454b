# SPDX-License-Identifier: GPL-3.0-or-later
"""A run as it is seen in the viewports: limit surface and cage where the result will stand, energy curve in a corner.
In Edit Mode that is where the object is: what changes is drawn in front of everything, and the old cage shines through.

Drawn by the GPU from the worker's snapshots: no object, mesh or material comes into being, so that there is nothing to
undo, to save or to clean up. Not for Blenders in background.
"""

from __future__ import annotations

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..core.energy import number_text
from ..core.job import Job
from ..core.snapshot import Snapshot
from . import overlay

CLAY, _WIRE = (0.60, 0.68, 0.78, 1.0), (0.05, 0.05, 0.06, 0.55)
_GLASS = (*CLAY[:3], 0.8)
IN_FRONT = Matrix(((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 0.01, -0.99), (0, 0, 0, 1)))  # depths to the nearest 1 %
_CURVE = (1.0, 0.66, 0.25, 1.0)
_CURVE_POINTS = 300
_SIZE = (250.0, 96.0)  # of the curve, in units of the interface
_PLACE = (70.0, 24.0)  # of its lower left corner

_shader: gpu.types.GPUShader | None = None  # made when first drawn with


class Preview:
    """From its creation to `end`, both on the main thread; it only reads the job. `loose` (2 k, 3) are the ends of
    loose edges in the source's frame: they stay where they are. `in_place`: the object is there, too."""

    def __init__(
        self, scene_name: str, placement: Matrix, job: Job, label: str, loose: np.ndarray, in_place: bool
    ) -> None:
        self._scene_name, self._placement, self._job, self._label = scene_name, placement, job, label
        self._in_place = in_place
        self._loose = loose.astype(np.float32)
        self._picture = Picture()
        self._handlers = [
            overlay.Handler(self._draw_surface, "POST_VIEW"), overlay.Handler(self._draw_curve, "POST_PIXEL")
        ]  # fmt: skip

    def end(self) -> None:
        """Draw no more, and free what the GPU holds."""
        for handler in self._handlers:
            handler.remove()
        self._picture.forget()

    def _shown_here(self) -> bool:
        return bpy.context.scene is not None and bpy.context.scene.name == self._scene_name

    def _draw_surface(self) -> None:
        snapshot = self._job.watcher.latest
        if snapshot is None or not self._shown_here():
            return
        projection = bpy.context.region_data.perspective_matrix
        if self._in_place:
            projection = IN_FRONT @ projection
        self._picture.draw(snapshot, self._loose, projection, self._placement, _GLASS if self._in_place else CLAY)

    def _draw_curve(self) -> None:
        if not self._shown_here():
            return
        unit = overlay.scale()
        x, y = (unit * length for length in _PLACE)
        width, height = (unit * length for length in _SIZE)
        overlay.rectangle(x, y, width, height + 22 * unit, overlay.PAPER)
        progress = self._job.latest
        if progress is None:
            overlay.text(x + 8 * unit, y + height + 5 * unit, f"{self._label}: preparing")
            return
        words = f"{number_text(progress.energy)}   level {progress.level}/{progress.levels}, step {progress.iteration}"
        overlay.text(x + 8 * unit, y + height + 5 * unit, f"{self._label}  {words}")
        margin = 8 * unit
        box = np.array([[x + margin, y + margin], [x + width - margin, y + height - margin]])
        overlay.polyline(curve_points(self._job.history, progress.start_energy, box), _CURVE)
        overlay.text(box[0, 0] + 0.6 * width, box[1, 1] - 9 * unit, f"from {number_text(progress.start_energy)}",
                     overlay.DIM, 10)  # fmt: skip


def curve_points(history: list[tuple[float, int, float]], start: float, box: np.ndarray) -> np.ndarray:
    """The logarithm of the energy over the steps, as points (n, 2) in `box` (lower left, upper right)."""
    count = len(history)
    if count == 0:
        return np.empty((0, 2))
    chosen = np.unique(np.linspace(0, count - 1, min(count, _CURVE_POINTS)).astype(int))
    energies = np.array([start, *(history[index][2] for index in chosen)])
    heights = np.log(np.maximum(energies, 1e-300))
    span = np.ptp(heights) or 1.0
    unit = np.stack([np.linspace(0, 1, len(heights)), (heights - heights.min()) / span], -1)
    return box[0] + unit * (box[1] - box[0])


class Picture:
    """A snapshot on the GPU: the surface, and the cage as wire."""

    def __init__(self) -> None:
        self._drawn: Snapshot | None = None
        self._batches: tuple[gpu.types.GPUBatch, gpu.types.GPUBatch | None] | None = None
        self._triangles: list[tuple[np.ndarray, gpu.types.GPUIndexBuf]] = []  # of connectivities, the last drawn one at the end

    def forget(self) -> None:
        """Free what the GPU holds."""
        self._batches = self._drawn = None
        self._triangles.clear()

    def draw(
        self, snapshot: Snapshot, loose: np.ndarray | None, projection: Matrix, placement: Matrix, paint: tuple[float, ...]
    ) -> None:
        """Within a draw handler of the view: at `placement`, with the ends (2 k, 3) of loose edges in its frame, or, if that
        is None, without the wire."""
        if snapshot is not self._drawn:
            self._batches, self._drawn = self._batches_of(snapshot, loose), snapshot
        camera = bpy.context.region_data.view_matrix.inverted().to_3x3()
        to_local = placement.to_3x3().transposed()
        surface, wire = self._batches
        shader = _surface_shader()
        shader.bind()
        shader.uniform_float("matrix", projection @ placement)
        shader.uniform_float("towards", to_local @ camera.col[2])
        shader.uniform_float("upwards", to_local @ camera.col[1])
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(True)
        gpu.state.blend_set("ALPHA" if paint[3] < 1 else "NONE")
        shader.uniform_float("paint", paint)
        surface.draw(shader)
        gpu.state.depth_mask_set(False)
        if wire is not None:
            gpu.state.blend_set("ALPHA")
            shader.uniform_float("paint", _WIRE)
            wire.draw(shader)
        gpu.state.blend_set("NONE")
        gpu.state.depth_test_set("NONE")

    def _batches_of(
        self, snapshot: Snapshot, loose: np.ndarray | None
    ) -> tuple[gpu.types.GPUBatch, gpu.types.GPUBatch | None]:
        shader = _surface_shader()
        buffer = gpu.types.GPUVertBuf(_vertex_format(), len(snapshot.points))
        buffer.attr_fill("pos", snapshot.points)
        buffer.attr_fill("nor", snapshot.normals)
        surface = gpu.types.GPUBatch(type="TRIS", buf=buffer, elem=self._indices_of(snapshot.triangles))
        if loose is None:
            return surface, None
        points = np.concatenate([snapshot.cage, loose])
        ends = len(snapshot.cage) + np.arange(len(loose), dtype=np.int32).reshape(-1, 2)
        wire = {"pos": points, "nor": np.zeros_like(points)}
        return surface, batch_for_shader(shader, "LINES", wire, indices=np.concatenate([snapshot.edges, ends]))

    def _indices_of(self, triangles: np.ndarray) -> gpu.types.GPUIndexBuf:
        """Kept for two connectivities, because Live goes from a coarse picture to a fine one and back."""
        found = [pair for pair in self._triangles if pair[0] is triangles]
        found = found or [(triangles, gpu.types.GPUIndexBuf(type="TRIS", seq=triangles))]
        self._triangles = [pair for pair in self._triangles if pair[0] is not triangles][-1:] + found
        return found[0][1]


def _vertex_format() -> gpu.types.GPUVertFormat:
    """Of the surface's points. GPUShader.format_calc() gives one without names in Blender 5."""
    form = gpu.types.GPUVertFormat()
    for name in ("pos", "nor"):
        form.attr_add(id=name, comp_type="F32", len=3, fetch_mode="FLOAT")
    return form


def _surface_shader() -> gpu.types.GPUShader:
    """Clay lit from the camera and above; what has no normal is left flat."""
    global _shader
    if _shader is None:
        interface = gpu.types.GPUStageInterfaceInfo("curvopt_surface")
        interface.smooth("VEC3", "normal")
        info = gpu.types.GPUShaderCreateInfo()
        info.push_constant("MAT4", "matrix")
        info.push_constant("VEC3", "towards")
        info.push_constant("VEC3", "upwards")
        info.push_constant("VEC4", "paint")
        info.vertex_in(0, "VEC3", "pos")
        info.vertex_in(1, "VEC3", "nor")
        info.vertex_out(interface)
        info.fragment_out(0, "VEC4", "colour")
        info.vertex_source("void main() { normal = nor; gl_Position = matrix * vec4(pos, 1.0); }")
        info.fragment_source(
            "void main() {"
            "  float size = length(normal);"
            "  vec3 n = size > 0.0 ? normal / size : vec3(0.0);"
            "  float facing = abs(dot(n, towards));"
            "  float light = size > 0.0 ? 0.25 + 0.6 * facing + 0.15 * dot(n, upwards) : 1.0;"
            "  colour = vec4(paint.rgb * light, paint.a);"
            "}"
        )
        _shader = gpu.shader.create_from_info(info)
    return _shader
