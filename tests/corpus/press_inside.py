# SPDX-License-Identifier: GPL-3.0-or-later
"""The half of press.py that runs in Blender: makes a shape, presses Minimize with default settings, draws both.

    blender -b --factory-startup -P press_inside.py -- JOBS.json EVENTS.jsonl

JOBS.json is {"runs": [[shape, energy], ..], "limit": seconds, "pictures": folder or null}. A shape is the path of an OBJ
file with tags, or a name of PRIMITIVES. Each run appends an event when it begins, and one with its record when it has
ended.
"""
from __future__ import annotations

import importlib
import json
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable

import addon_utils
import bmesh
import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import tagged  # noqa: E402
from press import NAME, PRIMITIVES, Record, is_file, picture_of  # noqa: E402

SIZE = (400, 200)  # pixels of before and after together


def part(name: str) -> Any:
    """A file of the installed add-on."""
    return importlib.import_module(f"{NAME}.{name}")


# ------------------------------------------------------------------------------------------------------------ shapes --

def from_file(path: Path) -> bpy.types.Object:
    """The object of a file with tags, and its modifier."""
    shape = tagged.parse(path.read_text())
    mesh = bpy.data.meshes.new(path.stem)
    mesh.from_pydata(shape.points, [], shape.faces)
    mesh.validate()  # as Blender's importers do: a face with a vertex twice goes
    edges, corners = np.zeros(len(mesh.edges), np.float32), np.zeros(len(mesh.vertices), np.float32)
    for edge in mesh.edges:
        edges[edge.index] = tagged.crease_of(shape.edges.get(tuple(sorted(edge.vertices)), 0.0))
    for vertex, sharpness in shape.corners.items():
        corners[vertex] = tagged.crease_of(sharpness)
    set_creases(mesh, edges, corners)
    obj = bpy.data.objects.new(path.stem, mesh)
    bpy.context.collection.objects.link(obj)
    return with_modifier(obj, shape.boundary_smooth)


def set_creases(mesh: bpy.types.Mesh, edges: np.ndarray, vertices: np.ndarray) -> None:
    """Creases of all edges and of all vertices."""
    if bpy.app.version >= (4, 0, 0):
        mesh.attributes.new("crease_edge", "FLOAT", "EDGE").data.foreach_set("value", edges)
        mesh.attributes.new("crease_vert", "FLOAT", "POINT").data.foreach_set("value", vertices)
        return
    if vertices.any():
        edit = bmesh.new()
        edit.from_mesh(mesh)
        edit.verts.layers.crease.verify()
        edit.to_mesh(mesh)
        edit.free()
        mesh.vertex_creases[0].data.foreach_set("value", vertices)
    mesh.edges.foreach_set("crease", edges)


def with_modifier(obj: bpy.types.Object, boundary_smooth: str = "ALL") -> bpy.types.Object:
    """The object, with a Subdivision Surface modifier that shows the limit surface, and alone active and selected."""
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.use_limit_surface, modifier.boundary_smooth = True, boundary_smooth
    modifier.levels = modifier.render_levels = 2
    for other in bpy.context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    return obj


def primitive(name: str) -> bpy.types.Object:
    """The object that the Add menu makes, as a mesh."""
    operator, arguments, curve = PRIMITIVES[name]
    group, _, verb = operator.partition(".")
    assert getattr(getattr(bpy.ops, group), verb)(**arguments) == {"FINISHED"}
    obj = bpy.context.object
    if obj.type != "MESH":
        for attribute, value in curve.items():
            setattr(obj.data, attribute, value)
        bpy.ops.object.convert(target="MESH")
        obj = bpy.context.object
    return with_modifier(obj)


# ------------------------------------------------------------------------------------------------------------- a run --

def press(obj: bpy.types.Object, energy: str, limit: float) -> tuple[Record, list[Any]]:
    """The record of a press, and [source's cage, solution] if there is one. After `limit` seconds the run ends as by
    Enter."""
    job, library, found, began = part("core.job"), part("binding.library"), [], time.monotonic()
    real: Callable[..., Any] = job.solve
    flag = library.Cancel.create(library.load())
    timer = threading.Timer(limit, flag.request)

    def timed(cage: Any, request: Any) -> Any:
        found[:] = [cage, real(cage, request, lambda _: time.monotonic() - began > limit, flag)]
        return found[1]

    record: Record = {"vertices": len(obj.data.vertices), "faces": len(obj.data.polygons)}
    job.solve = timed
    timer.start()
    try:
        bpy.ops.curvopt.minimize(energy=energy.upper(), outcome="NEW")
        record.update(of_solution(found[1]))
        record["verdict"] = bpy.context.view_layer.objects.active["curvopt_verdict"]
    except RuntimeError as error:
        record.update(outcome="refused", said=str(error).strip().removeprefix("Error: "))
    finally:
        job.solve = real
        timer.cancel()
    record["said"] = part("ui.properties").state.message or record["said"]
    return {**record, "seconds": time.monotonic() - began}, found


def of_solution(solution: Any) -> Record:
    """What the record has of a finished run."""
    found, end = solution.exceptions, solution.end
    moved = np.linalg.norm(solution.cage.positions - solution.start_positions, axis=1)
    radius = np.linalg.norm(solution.start_positions - solution.start_positions.mean(0), axis=1)
    return {
        "outcome": "out of time" if solution.stop == "cancelled" else solution.verification.verdict,
        "stop": solution.stop, "decrement": solution.verification.newton_decrement,
        "negative": solution.verification.negative_directions, "before": solution.start.objective,
        "after": end.objective, "error": end.objective_error, "held": found.n_held, "left_out": found.n_left_out,
        "reasons": [[text, len(vertices), [int(v) for v in vertices[:3]]] for text, vertices in found.reasons],
        "iterations": sum(level.iterations for level in solution.levels), "symmetries": solution.symmetry_order,
        "moved": float(moved.max() / radius.max()), "grown": float(_size(solution.cage.positions)
                                                                   / _size(solution.start_positions)),
    }


def _size(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def draw(path: Path, record: Record, cage: Any, solution: Any) -> None:
    """Both limit surfaces."""
    captions = f"{record['before']:.4g}", f"{record['after']:.4g}"
    picture = part("render.studio").Picture(*SIZE, engine="workbench")
    shapes = list(zip((cage, solution.cage), captions))
    part("render.before_after").render_side_by_side(shapes, path, picture)


def run(shape: str, energy: str, limit: float) -> tuple[Record, list[Any]]:
    """The record of a run, and what can be drawn of it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    try:
        return press(from_file(Path(shape)) if is_file(shape) else primitive(shape), energy, limit)
    except Exception as error:  # a fault of the add-on or of this program; the other runs go on
        return {"outcome": "failed", "said": f"{type(error).__name__}: {error}"}, []


def main(jobs_file: str, events_file: str) -> int:
    """All runs of the file."""
    if addon_utils.enable(NAME, default_set=True) is None:
        print("The add-on could not be enabled.", file=sys.stderr)
        return 1
    jobs = json.loads(Path(jobs_file).read_text())
    with open(events_file, "a", encoding="utf-8", buffering=1) as events:
        for shape, energy in jobs["runs"]:
            events.write(json.dumps({"begins": [shape, energy]}) + "\n")
            record, found = run(shape, energy, jobs["limit"])
            events.write(json.dumps({"ended": [shape, energy], "record": record}) + "\n")
            if jobs["pictures"] and len(found) == 2:
                draw(Path(jobs["pictures"]) / picture_of(shape, energy), record, *found)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[sys.argv.index("--") + 1:]))
