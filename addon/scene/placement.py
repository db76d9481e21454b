# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a result goes: a new object (write_result.py), the object's own mesh, or a shape key of it.

Only the name of the object was kept while the run was on. If it is gone by now, or its mesh is not the one that was
read, the result becomes a new object, whatever was asked for: hours of work are not thrown away.
"""

from __future__ import annotations

import math

import bpy
import numpy as np

from ..binding.values import Cage
from ..core.crease import BOUNDARY_SMOOTH
from ..core.job import Request, Solution
from ..core.layout import Written
from .amount import has_blend, store_blend
from .animation import animate
from .frame import space_of
from .modifiers import CageError, mirror_modifier, read_mirror, subdivision
from .read_cage import Source, check_relative, has_faces_of, read_positions
from .write_result import (
    add_result,
    add_subdivision,
    carry_materials,
    keep_apart,
    local_object,
    make_result_mesh,
    shown_levels,
    store,
)

KEY_PREFIX = "Curvopt "
_SAME = 1e-5  # of the shape's size: float32 positions times the object's scale
_NAMED = 3  # other objects with the same mesh in a sentence


def check_outcome(outcome: str, request: Request, obj: bpy.types.Object | None = None) -> None:
    """CageError, before a run, for an outcome that is not possible for `obj`."""
    if outcome == "SHAPE_KEY" and request.records:
        raise CageError("Animation gives the result shape keys of its own: set Result to New Object or In Place, or untick it.")
    if not is_possible(outcome, request):
        if request.refined:
            raise CageError(
                "Nothing may move: boundary, creases or pins hold all vertices, and a shape key has no others. Set "
                "Boundary to Free, pin fewer vertices, or set Result to New Object, which is refined."
            )
        raise CageError("A shape key needs the vertices of your cage: set Resolution to Same Vertices, or Levels to 1.")
    if outcome == "SHAPE_KEY" and obj is not None:
        check_relative(obj)
    many = request.levels > 1 and obj is not None and any(m.type == "MULTIRES" for m in obj.modifiers)
    if outcome == "REPLACE" and many:
        or_same = "" if request.refined else "Resolution to Same Vertices, or "
        raise CageError(
            f"Object '{obj.name}' has a Multires modifier, which belongs to the vertices of its mesh"
            f"{', and all of these are held' if request.refined else ''}: set {or_same}Result to New Object."
        )


def check_amount(amount: float, request: Request) -> None:
    """CageError for a part of a result whose shape keys show the way there."""
    if amount != 1.0 and request.records:
        raise CageError("Amount cannot be less than 1 of a result with an animation, whose shape keys show what lies between.")


def check_keys(outcome: str, obj: bpy.types.Object) -> None:
    """CageError, after a run, for an outcome that the shape keys of `obj` stand against."""
    if outcome == "REPLACE" and obj.data.shape_keys:
        raise CageError(f"Object '{obj.name}' has shape keys: the result can be another one, or a new object.")


def is_possible(outcome: str, request: Request) -> bool:
    """Whether such a run can end there."""
    return outcome != "SHAPE_KEY" or (request.levels == 1 and not request.records)


def is_shown_smooth(name: str) -> bool:
    """Whether an object has a Subdivision Surface modifier, or is no longer there."""
    obj = local_object(name)
    return obj is None or obj.type != "MESH" or subdivision(obj) is not None


def set_amount(obj: bpy.types.Object, amount: float) -> None:
    """Show so much of a result that write() has put there."""
    key = active_key(obj)
    if key is not None:
        key.value = amount
    elif has_blend(obj):
        obj.curvopt_amount = amount


def write(
    context: bpy.types.Context, source: Source, request: Request, solution: Solution, outcome: str
) -> tuple[bpy.types.Object, str]:
    """Put the result where it was wanted; the object, and what else the user should know, or "". CageError if it cannot
    be there."""
    check_outcome(outcome, request)
    if outcome == "NEW":
        return add_result(context, source, request, solution), ""
    obj = local_object(source.name)
    why = _changed(obj, source)
    if why:
        return add_result(context, source, request, solution), f"{why} meanwhile, so the result is a new object"
    check_outcome(outcome, request, obj)
    check_keys(outcome, obj)
    if outcome == "SHAPE_KEY":
        remark = _add_key(obj, source, request, solution)
    else:
        remark = _replace(obj, source, request, solution)
    store(obj, source.name, request, solution)
    return obj, remark


def animate_run(context: bpy.types.Context, obj: bpy.types.Object, source: Source, solution: Solution) -> str:
    """The recorded run, if there is one and anything has moved, as shape keys of the result that write() has made; which frames
    show it, in a sentence, or ""."""
    if len(solution.path) < 2:
        return ""
    written, loose = source.layout.written(solution.cage), source.space.to_frame(source.mesh.positions[source.layout.loose])
    if obj.name == source.name:  # in place
        states = [local_positions(source, written, xyz) for xyz in solution.path]
    else:
        states = [written.positions(xyz, loose) for xyz in solution.path]
    first, last = animate(obj, states, context.scene.frame_current)
    return f"Frames {first} to {last} show the run"


def _changed(obj: bpy.types.Object | None, source: Source) -> str:
    """What has happened to the object since it was read, or ""."""
    if obj is None or obj.type != "MESH":
        return f"'{source.name}' was renamed or deleted"
    if obj.mode != "OBJECT":
        return f"'{source.name}' went into another mode"
    return what_changed(obj, obj.data, source)


def what_changed(obj: bpy.types.Object, mesh: bpy.types.Mesh, source: Source) -> str:
    """How the object's mesh, or a copy of it, differs from what was read, or ""."""
    was = source.mesh
    if not has_faces_of(mesh, was):
        return f"The mesh of '{source.name}' was changed"
    if np.abs(read_positions(mesh) - was.positions).max() > _SAME * np.ptp(was.positions):
        return f"The mesh of '{source.name}' was changed"
    return "" if _is_mirrored_alike(obj, source) else f"The Mirror modifier of '{source.name}' was changed"


def _is_mirrored_alike(obj: bpy.types.Object, source: Source) -> bool:
    try:
        mirror = read_mirror(obj)
        return mirror == source.mirror and (mirror is None or space_of(obj, mirror).is_like(source.space))
    except CageError:
        return False


def local_positions(source: Source, written: Written, positions: np.ndarray) -> np.ndarray:
    """Vertices (n, 3) of a result in the object's own coordinates, from those of its cage (N, 3) in the frame."""
    loose = source.mesh.positions[source.layout.loose]
    framed = written.positions(positions, source.space.to_frame(loose))
    local = source.space.to_mesh(framed)
    local[written.loose_place] = loose
    return local


def _add_key(obj: bpy.types.Object, source: Source, request: Request, solution: Solution) -> str:
    """A shape key at 1; those of earlier runs go to 0, so that there is one result at a time."""
    shared = _unshare(obj)
    if not obj.data.shape_keys:
        obj.shape_key_add(name="Basis")
    for key in obj.data.shape_keys.key_blocks:
        if key.name.startswith(KEY_PREFIX):
            key.value = 0.0
    key = obj.shape_key_add(name=KEY_PREFIX + request.label, from_mix=False)
    written = source.layout.written(solution.cage)
    end = local_positions(source, written, solution.cage.positions)
    key.data.foreach_set("co", end.astype(np.float32).reshape(-1))
    key.value = 1.0
    obj.active_shape_key_index = len(obj.data.shape_keys.key_blocks) - 1
    _show_limit(obj, source.cage, solution.cage)
    return ". ".join(filter(None, [shared, _kept_apart(obj, source, written, end)]))


def _replace(obj: bpy.types.Object, source: Source, request: Request, solution: Solution) -> str:
    """The object's mesh becomes the result; with the same vertices, everything else about it is kept. A cage that had to
    be refined and did not move leaves the mesh as it is, which shows the same surface."""
    if request.refined and not request.records and _is_still(solution):
        _show_limit(obj, source.cage, source.cage)
        return f"Nothing moved, so the mesh of '{obj.name}' is as it was"
    shared = _unshare(obj)
    written = source.layout.written(solution.cage)
    start, end = (local_positions(source, written, xyz) for xyz in (solution.start_positions, solution.cage.positions))
    if len(end) == len(obj.data.vertices):
        obj.data.vertices.foreach_set("co", end.astype(np.float32).reshape(-1))
        obj.data.update()
    else:
        mesh = make_result_mesh(obj.data.name, written, end, source.mirrored)
        carry_materials(obj, mesh, source, written)
        obj.data = mesh
    _show_limit(obj, source.cage, solution.cage)
    store_blend(obj, start, end)
    return ". ".join(filter(None, [shared, _kept_apart(obj, source, written, end)]))


def _is_still(solution: Solution) -> bool:
    """Whether the result is the first cage, subdivided as often."""
    start = solution.start_positions
    return bool(np.abs(solution.cage.positions - start).max() <= _SAME * np.ptp(start, axis=0).max())


def _unshare(obj: bpy.types.Object) -> str:
    """Give the object a mesh of its own; which other objects keep the old one, in a sentence, or ""."""
    if obj.data.users == 1:
        return ""
    others = [f"'{other.name}'" for other in bpy.data.objects if other.data == obj.data and other != obj]
    obj.data = obj.data.copy()
    if not others:
        return ""
    names = ", ".join(others[:_NAMED]) + (f" and {len(others) - _NAMED} more" if len(others) > _NAMED else "")
    keep = "keeps" if len(others) == 1 else "keep"
    return f"The mesh of '{obj.name}' was shared with {names}, which {keep} the old shape"


def _kept_apart(obj: bpy.types.Object, source: Source, written: Written, local: np.ndarray) -> str:
    """Have the Mirror modifier merge what is on its planes and nothing else; what the user should know of it, or ""."""
    modifier = mirror_modifier(obj)
    if modifier is None:
        return ""
    gaps = source.space.gaps(source.space.to_frame(local))
    if not keep_apart(modifier, written, gaps):
        return ""
    distance = f"{modifier.merge_threshold:.2g}"
    return f"Modifier '{modifier.name}' now merges within {distance}, so that no more vertices are merged than before"


def _show_limit(obj: bpy.types.Object, before: Cage, cage: Cage) -> None:
    """A Subdivision Surface modifier if there is none. The viewport level of another one is lowered by as many levels as
    `before` was refined to `cage`, so that it shows as many faces, but no further than looks smooth."""
    modifier = subdivision(obj)
    if modifier is None:
        add_subdivision(obj, cage.creases)
    else:
        refined = round(math.log(len(cage.face_vertices) / len(before.face_vertices), 4))
        enough = max(modifier.levels - refined, shown_levels(len(cage.face_sizes)))
        modifier.levels = min(modifier.levels, enough)
        modifier.boundary_smooth = BOUNDARY_SMOOTH[cage.creases.rule]


def active_key(obj: bpy.types.Object | None) -> bpy.types.ShapeKey | None:
    """The shape key of the last run on the object, if it has one."""
    if obj is None or obj.type != "MESH" or not obj.data.shape_keys:
        return None
    ours = [key for key in obj.data.shape_keys.key_blocks if key.name.startswith(KEY_PREFIX)]
    return ours[-1] if ours else None
