# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a cage is in the world: a rigid frame, and what is left of the object's matrix.

Energies are those of the shape in the world. A cage is read in a rigid frame, the object's location and rotation; its
scale (uniform or not, mirrored or not) is worked into the positions. So lengths are the world's and numbers stay small.

Under a Mirror modifier the frame stands on the mirror planes, and its axes are perpendicular to them: they are the axes
of the object, or of the modifier's mirror object. The modifier reflects in that object's coordinates. In the world this
is a reflection only if the axis is at a right angle to the other two there.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix

from .modifiers import CageError, Mirror, mirror_modifier

_SAME_SCALE = 1e-6  # float32 matrices: a scale this close to uniform is uniform
_SQUARE = 2e-6  # cosine of the angle between axes at a right angle, as float32 matrices have it


@dataclass(frozen=True)
class Space:
    """A rigid `frame` (4 x 4), in which a point of the mesh is at `shape` (3, 3) times it plus `offset` (3,)."""

    frame: Matrix
    shape: np.ndarray
    offset: np.ndarray

    @property
    def mirrored(self) -> bool:
        """Whether faces that are counter-clockwise in the mesh are clockwise in the frame."""
        return bool(np.linalg.det(self.shape) < 0)

    def to_frame(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the mesh in the frame."""
        return points @ self.shape.T + self.offset

    def to_mesh(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the frame in the mesh."""
        return (points - self.offset) @ inverse(self.shape).T

    def gaps(self, points: np.ndarray) -> np.ndarray:
        """How far points (n, 3) of the frame are from their images across its planes, (n, 3), in the mesh's units."""
        return 2 * np.abs(points) * np.linalg.norm(inverse(self.shape), axis=0)

    def is_like(self, other: Space) -> bool:
        """Whether meshes stand in both frames alike."""
        near = 1e-5 * np.linalg.norm(self.shape, 2)
        far = 1e-5 * np.linalg.norm(self.offset)
        return bool(np.abs(self.shape - other.shape).max() <= near
                    and np.abs(self.offset - other.offset).max() <= near + far)  # fmt: skip


def space_of(obj: bpy.types.Object, mirror: Mirror | None) -> Space:
    """The object's frame, on the planes of `mirror` if there is one. CageError if the object is flat, or if the mirror
    is no reflection."""
    world = np.array(obj.matrix_world, np.float64)
    if _is_flat(world):
        raise CageError(f"Object '{obj.name}' is scaled to zero: give it a scale other than 0 on every axis.")
    frame = _frame_of_object(obj) if mirror is None else _frame_of_mirror(obj, mirror)
    turned = np.array(frame, np.float64)
    back = inverse(turned[:3, :3])
    shape = _without_dust(back @ world[:3, :3])
    return Space(frame, shape, back @ (world[:3, 3] - turned[:3, 3]))


def inverse(linear: np.ndarray) -> np.ndarray:
    """Of a matrix (3, 3) that is not flat. In place of NumPy's, which hands nine numbers to all threads of OpenBLAS: 5 ms on a
    busy machine, three times at each look of Live."""
    one, other = linear[[1, 2, 0]], linear[[2, 0, 1]]
    cofactors = one[:, [1, 2, 0]] * other[:, [2, 0, 1]] - one[:, [2, 0, 1]] * other[:, [1, 2, 0]]
    return cofactors.T / (linear[0] @ cofactors[0])


def _is_flat(world: np.ndarray) -> bool:
    scale = np.linalg.norm(world[:3, :3], 2)
    return not np.isfinite(scale) or bool(abs(np.linalg.det(world[:3, :3])) <= 1e-9 * scale**3)


def _frame_of_object(obj: bpy.types.Object) -> Matrix:
    world = obj.matrix_world
    return Matrix.Translation(world.to_translation()) @ world.to_quaternion().to_matrix().to_4x4()


def _frame_of_mirror(obj: bpy.types.Object, mirror: Mirror) -> Matrix:
    """Axes are the carrier's; the origin is the point of all planes that is nearest to the object's."""
    carrier = np.array((mirror_modifier(obj).mirror_object or obj).matrix_world, np.float64)
    if _is_flat(carrier):
        raise CageError(f"Object '{mirror.carrier}' is scaled to zero: give it a scale other than 0 on every axis.")
    axes = _right_angled(carrier[:3, :3], obj.name, mirror)
    place = np.array(obj.matrix_world, np.float64)[:3, 3]
    across = axes[:, list(mirror.axes)]
    origin = place - across @ (across.T @ (place - carrier[:3, 3]))
    frame = Matrix(axes.tolist()).to_4x4()
    frame.translation = origin.tolist()
    return frame


def _right_angled(linear: np.ndarray, name: str, mirror: Mirror) -> np.ndarray:
    """A rotation (3, 3) whose columns are the carrier's axes, those of the mirror exactly. CageError if one of these is
    not at a right angle to the others."""
    columns = linear / np.linalg.norm(linear, axis=0)
    cosines = np.abs(columns.T @ columns)
    rest = [axis for axis in range(3) if axis not in mirror.axes]
    for axis in mirror.axes:
        if np.delete(cosines[axis], axis).max() > _SQUARE:
            raise CageError(
                f"Modifier '{mirror.name}' of object '{name}' reflects along the {'XYZ'[axis]} axis of object "
                f"'{mirror.carrier}', which is sheared: its image has another shape. Clear the scale of its parents, "
                "or apply the modifier first."
            )
    rotation = np.zeros((3, 3))
    for axis in [*mirror.axes, *rest]:
        column = columns[:, axis] - rotation @ (rotation.T @ columns[:, axis])
        rotation[:, axis] = column / np.linalg.norm(column)
    return rotation if np.linalg.det(rotation) > 0 else -rotation


def _without_dust(shape: np.ndarray) -> np.ndarray:
    """A uniform scale exactly uniform, and axes that stay axes exactly that."""
    uniform = np.trace(shape) / 3
    if np.abs(shape - uniform * np.eye(3)).max() <= _SAME_SCALE * abs(uniform):
        return (1.0 if abs(uniform - 1.0) <= _SAME_SCALE else uniform) * np.eye(3)
    clean = shape.copy()
    for axis in range(3):
        beside = [other for other in range(3) if other != axis]
        near = _SAME_SCALE * abs(shape[axis, axis])
        if np.abs(shape[axis, beside]).max() <= near and np.abs(shape[beside, axis]).max() <= near:
            clean[axis, beside] = clean[beside, axis] = 0.0
    return clean
