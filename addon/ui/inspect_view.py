# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface that is inspected, as the viewports show it: stripes, isophotes or colours on it, combs, a legend, and what the
probe reads. Not for Blenders in background.

Stripes are computed for each pixel from the true surface's normals, interpolated between its points. Nothing of this is data
of the file.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix, Vector

from ..core.colours import colours
from ..core.energy import number_text
from ..core.inspected import Inspected
from ..core.probe import Reading, words
from . import overlay
from .preview import IN_FRONT

KINDS = ("NOTHING", "PLAIN", "ZEBRA", "ISOPHOTES", "COLOURS")  # what the shader knows, by number; of NOTHING no surface
_GLASS = 0.8  # opacity in Edit Mode, where it is over the cage
_LIFT = 0.002  # of the way to the eye, in front of the object's own faces
_LINES = {"teeth": (0.85, 0.25, 0.1, 0.9), "curves": (0.05, 0.05, 0.06, 1.0), "crests": (1.0, 0.66, 0.25, 1.0)}
_DOT, _DOT_COLOUR, _EDGE_COLOUR = 8.0, (1.0, 0.66, 0.25, 1.0), (0.3, 0.85, 1.0, 1.0)

_shaders: dict[str, gpu.types.GPUShader] = {}  # made when first drawn with

# What is written is linear: the view's framebuffer encodes it as sRGB, and only Blender's own shaders are told so.
_LINEAR = """
vec3 to_linear(vec3 srgb) {
  return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), step(vec3(0.04045), srgb));
}
"""
_FRAGMENT = _LINEAR + """
void main() {
  vec3 to_eye = normalize(eye.w > 0.5 ? eye.xyz - place : eye.xyz);
  float size = length(normal);
  vec3 n = size > 0.0 ? normal / size : to_eye;
  float facing = dot(n, to_eye);
  float light_on_clay = 0.3 + 0.7 * abs(facing);
  vec3 paint = vec3(0.60, 0.68, 0.78) * light_on_clay;
  if (look.x > 1.5 && look.x < 3.5) {
    vec3 way = look.x < 2.5 ? reflect(-to_eye, facing < 0.0 ? -n : n) : n;
    float bands = acos(clamp(dot(way, light.xyz), -1.0, 1.0)) / light.w;
    float soft = clamp(fwidth(bands), 0.0001, 1.0);
    float wave = abs(mod(bands, 2.0) - 1.0);
    float stripe = smoothstep(0.5 - soft, 0.5 + soft, wave);
    paint = mix(vec3(0.05), vec3(0.95), stripe) * (0.75 + 0.25 * abs(facing));
  }
  if (look.x > 3.5) {
    paint = tint.rgb * (0.65 + 0.35 * abs(facing));
  }
  colour = vec4(to_linear(paint), look.y);
}
"""


@dataclass(frozen=True)
class Looks:
    """How it is drawn: a kind, of KINDS; the unit vector towards the light in the world; the width of bands in radians;
    whether over everything else; the label of what colours mean, and the quantity."""

    kind: str
    light: Vector
    width: float
    in_front: bool
    label: str
    quantity: str


class InspectView:
    """From its creation to `end`; `show`, `aim` and `read` say what is drawn."""

    def __init__(self) -> None:
        self.shown: Inspected | None = None
        self._object, self._local, self._looks = "", Matrix(), None
        self._reading: Reading | None = None
        self._at = (0, 0, 0)
        self._radius = 1.0
        self._batches: dict[str, gpu.types.GPUBatch] = {}
        self._drawn: Inspected | None = None
        self._triangles: tuple[np.ndarray, gpu.types.GPUIndexBuf] | None = None
        self.draws = 0  # counted for tests
        self._handlers = [overlay.Handler(self._surface, "POST_VIEW"), overlay.Handler(self._flat, "POST_PIXEL")]

    def show(self, shown: Inspected | None, obj_name: str, local: Matrix, looks: Looks | None) -> None:
        """This surface, on that object, in whose coordinates its frame is `local`."""
        self.shown, self._object, self._local, self._looks = shown, obj_name, local, looks
        if shown is not None:
            points = shown.subject.cage.positions
            self._radius = float(np.linalg.norm(points - points.mean(axis=0)) / np.sqrt(len(points)))

    def read(self, reading: Reading | None, region: int, x: int, y: int) -> None:
        """What the probe reads at pixel (x, y) of a region, its pointer; None for nothing."""
        self._reading, self._at = reading, (region, x, y)

    def end(self) -> None:
        """Draw no more, and free what the GPU holds."""
        for handler in self._handlers:
            handler.remove()
        self._batches, self._drawn, self._triangles, self.shown = {}, None, None, None

    def covers(self, name: str) -> bool:
        """Whether this is the surface that is to be seen on an object."""
        return self.shown is not None and self._object == name and self._looks.kind != "NOTHING" and self._is_here()

    def placement(self) -> Matrix | None:
        """Where the frame of the cage is in the world now; None where the object is not to be seen."""
        obj = bpy.data.objects.get(self._object)
        return obj.matrix_world @ self._local if obj is not None else None

    def _is_here(self) -> bool:
        obj = bpy.data.objects.get(self._object)
        if self.shown is None or obj is None or not bpy.context.space_data.overlay.show_overlays:
            return False
        return obj.name in bpy.context.view_layer.objects and obj.visible_get(viewport=bpy.context.space_data)

    def _surface(self) -> None:
        if not self._is_here():
            return
        shown, looks, region = self.shown, self._looks, bpy.context.region_data
        if shown is not self._drawn:
            self._batches, self._drawn = self._batches_of(shown), shown
        self.draws += 1
        placement, camera = self.placement(), region.view_matrix.inverted()
        transparent = looks.in_front and bpy.context.mode == "EDIT_MESH"
        matrix = _projection(region, camera, looks.in_front) @ placement
        gpu.state.depth_test_set("LESS_EQUAL")
        if looks.kind != "NOTHING":
            kind = "PLAIN" if looks.kind == "COLOURS" and shown.tints is None else looks.kind
            self._draw_surface(matrix, placement, camera, region.is_perspective, kind, _GLASS if transparent else 1.0)
        gpu.state.blend_set("ALPHA")
        for name, paint in _LINES.items():
            if name in self._batches:
                shader = _line_shader()
                shader.bind()
                shader.uniform_float("to_clip", matrix)
                shader.uniform_float("paint", paint)
                self._batches[name].draw(shader)
        gpu.state.blend_set("NONE")
        gpu.state.depth_test_set("NONE")

    def _draw_surface(
        self, matrix: Matrix, placement: Matrix, camera: Matrix, perspective: bool, kind: str, opacity: float
    ) -> None:
        turn = placement.to_3x3().normalized().transposed()
        eye = placement.inverted() @ camera.translation if perspective else turn @ camera.to_3x3().col[2]
        light = (turn @ self._looks.light).normalized()
        shader = _surface_shader()
        shader.bind()
        shader.uniform_float("to_clip", matrix)
        shader.uniform_float("eye", (*eye, float(perspective)))
        shader.uniform_float("light", (*light, self._looks.width))
        shader.uniform_float("look", (float(KINDS.index(kind)), opacity, 0.0, 0.0))
        gpu.state.depth_mask_set(True)
        if opacity < 1:  # depths first, so that the surface does not shine through itself
            gpu.state.color_mask_set(False, False, False, False)
            self._batches["surface"].draw(shader)
            gpu.state.color_mask_set(True, True, True, True)
        gpu.state.blend_set("ALPHA" if opacity < 1 else "NONE")
        self._batches["surface"].draw(shader)
        gpu.state.depth_mask_set(False)

    def _batches_of(self, shown: Inspected) -> dict[str, gpu.types.GPUBatch]:
        if self._triangles is None or self._triangles[0] is not shown.net.triangles:
            self._triangles = shown.net.triangles, gpu.types.GPUIndexBuf(type="TRIS", seq=shown.net.triangles)
        buffer = gpu.types.GPUVertBuf(_vertex_format(), len(shown.points))
        tints = np.ones((len(shown.points), 4), np.float32) if shown.tints is None else shown.tints
        for name, values in (("pos", shown.points), ("nor", shown.normals), ("col", tints)):
            buffer.attr_fill(name, values)
        batches = {"surface": gpu.types.GPUBatch(type="TRIS", buf=buffer, elem=self._triangles[1])}
        if shown.combs is not None and len(shown.combs.feet):
            points, lines = shown.combs.lines()
            for name, pairs in lines.items():
                batches[name] = batch_for_shader(_line_shader(), "LINES", {"pos": points}, indices=pairs)
        return batches

    def _flat(self) -> None:
        """Legend and reading."""
        if not self._is_here():
            return
        if self._looks.kind == "COLOURS" and self.shown.span is not None:
            overlay.legend(self._looks.label, *self.shown.span, lambda values: colours(self._looks.quantity, values, *self.shown.span))
        region, x, y = self._at
        if self._reading is None or bpy.context.region.as_pointer() != region:
            return
        placement, unit = self.placement(), overlay.scale()
        for point, colour in ((self._reading.edge.point, _EDGE_COLOUR), (self._reading.point, _DOT_COLOUR)):
            place = _pixel(placement @ Vector(point))
            for side, paint in ((_DOT + 2, (0.05, 0.05, 0.06, 1.0)), (_DOT, colour)):
                overlay.squares(np.array([place]), side * unit, paint)
        direction = placement.to_3x3().normalized() @ Vector(self._reading.normal)
        lines = words(self._reading, np.array(direction), self._radius)
        overlay.box(x + 18 * unit, y + 14 * unit, lines)


def _pixel(place: Vector) -> tuple[float, float]:
    """Where a point of the world is in this region."""
    region, seen = bpy.context.region, bpy.context.region_data.perspective_matrix @ place.to_4d()
    return (1 + seen.x / seen.w) * region.width / 2, (1 + seen.y / seen.w) * region.height / 2


def _projection(region: bpy.types.RegionView3D, camera: Matrix, in_front: bool) -> Matrix:
    """The view's, with depths before everything else, or a little nearer to the eye than they are."""
    if in_front:
        return IN_FRONT @ region.perspective_matrix
    if region.is_perspective:
        eye = Matrix.Translation(camera.translation)
        return region.perspective_matrix @ eye @ Matrix.Scale(1 - _LIFT, 4) @ eye.inverted()
    return region.perspective_matrix @ Matrix.Translation(camera.to_3x3().col[2] * (_LIFT * region.view_distance))


def _vertex_format() -> gpu.types.GPUVertFormat:
    form = gpu.types.GPUVertFormat()
    for name, length in (("pos", 3), ("nor", 3), ("col", 4)):
        form.attr_add(id=name, comp_type="F32", len=length, fetch_mode="FLOAT")
    return form


def _surface_shader() -> gpu.types.GPUShader:
    """112 bytes of push constants: Vulkan promises 128."""
    if "surface" not in _shaders:
        interface = gpu.types.GPUStageInterfaceInfo("curvopt_inspect")
        interface.smooth("VEC3", "normal")
        interface.smooth("VEC3", "place")
        interface.smooth("VEC4", "tint")
        info = gpu.types.GPUShaderCreateInfo()
        for kind, name in (("MAT4", "to_clip"), ("VEC4", "eye"), ("VEC4", "light"), ("VEC4", "look")):
            info.push_constant(kind, name)
        for slot, (kind, name) in enumerate((("VEC3", "pos"), ("VEC3", "nor"), ("VEC4", "col"))):
            info.vertex_in(slot, kind, name)
        info.vertex_out(interface)
        info.fragment_out(0, "VEC4", "colour")
        info.vertex_source(
            "void main() { normal = nor; place = pos; tint = col; gl_Position = to_clip * vec4(pos, 1.0); }"
        )
        info.fragment_source(_FRAGMENT)
        _shaders["surface"] = gpu.shader.create_from_info(info)
    return _shaders["surface"]


def _line_shader() -> gpu.types.GPUShader:
    if "line" not in _shaders:
        info = gpu.types.GPUShaderCreateInfo()
        info.push_constant("MAT4", "to_clip")
        info.push_constant("VEC4", "paint")
        info.vertex_in(0, "VEC3", "pos")
        info.fragment_out(0, "VEC4", "colour")
        info.vertex_source("void main() { gl_Position = to_clip * vec4(pos, 1.0); }")
        info.fragment_source(_LINEAR + "void main() { colour = vec4(to_linear(paint.rgb), paint.a); }")
        _shaders["line"] = gpu.shader.create_from_info(info)
    return _shaders["line"]


current: InspectView | None = None  # set by inspect.py while its switch is on
