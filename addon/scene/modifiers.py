# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifiers of an object: which of them the cage goes through, and every reason to refuse one.

Before the first Subdivision Surface modifier there may be one Mirror: then the mesh is half of the cage. What comes
after it changes what is shown, not the cage, and is left alone. Multiresolution is a Subdivision Surface as long as
nothing was sculpted.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..core.messages import UserError
from .multires import has_detail


class CageError(UserError):
    """The object cannot be used; the message is a sentence that says what is wrong, where, and what to do."""


@dataclass(frozen=True)
class Mirror:
    """A Mirror modifier: the axes, 0 .. 2, across which it reflects, ascending; vertices nearer than `threshold` to
    their images are merged with them (0: none are); `carrier` is the object whose axes these are."""

    name: str
    axes: tuple[int, ...]
    threshold: float
    carrier: str


def check_modifiers(obj: bpy.types.Object) -> None:
    """CageError unless every modifier that the cage goes through is known. Quick."""
    before, subdivision_modifier = _parts(obj)
    for modifier in before:
        if modifier.type != "MIRROR" and not is_idle(modifier):
            below = "add a Subdivision Surface modifier above it" if subdivision_modifier is None else "move it below Subdivision Surface"
            raise CageError(f"{_where(obj, modifier)} changes the cage: {below}, or apply or remove it first.")
    _mirror(obj, before)
    if getattr(subdivision_modifier, "subdivision_type", "CATMULL_CLARK") != "CATMULL_CLARK":
        raise CageError(f"{_where(obj, subdivision_modifier)} is set to Simple: set it to Catmull-Clark first.")


def check_detail(obj: bpy.types.Object) -> None:
    """CageError for sculpted detail, which would be spread over another shape. Takes as long as showing it."""
    modifier = subdivision(obj)
    if modifier is not None and modifier.type == "MULTIRES" and has_detail(obj, modifier):
        raise CageError(
            f"{_where(obj, modifier)} has sculpted detail: remove the modifier, or apply it, which makes the detail a "
            "cage of its own."
        )


def is_idle(modifier: bpy.types.Modifier) -> bool:
    """Whether it leaves the mesh as it is: a Multiresolution modifier that has never been subdivided."""
    return modifier.type == "MULTIRES" and modifier.total_levels == 0


def subdivision(obj: bpy.types.Object) -> bpy.types.SubsurfModifier | bpy.types.MultiresModifier | None:
    """The first Subdivision Surface modifier that is switched on, or Multiresolution in its place."""
    return _parts(obj)[1]


def mirror_modifier(obj: bpy.types.Object) -> bpy.types.MirrorModifier | None:
    """The Mirror modifier that the cage goes through."""
    return next((m for m in _parts(obj)[0] if m.type == "MIRROR" and any(m.use_axis)), None)


def read_mirror(obj: bpy.types.Object) -> Mirror | None:
    """The settings of that modifier, or None without one. CageError as above."""
    return _mirror(obj, _parts(obj)[0])


def _parts(obj: bpy.types.Object) -> tuple[list[bpy.types.Modifier], bpy.types.Modifier | None]:
    """The modifiers that are on and stand before the first Subdivision Surface, and that one."""
    shown = [m for m in obj.modifiers if m.show_viewport or m.show_render]
    if shown and shown[0].type == "MULTIRES" and not is_idle(shown[0]):
        return [], shown[0]
    at = next((i for i, m in enumerate(shown) if m.type == "SUBSURF"), len(shown))
    return shown[:at], shown[at] if at < len(shown) else None


def _mirror(obj: bpy.types.Object, before: list[bpy.types.Modifier]) -> Mirror | None:
    found = [m for m in before if m.type == "MIRROR" and any(m.use_axis)]
    if len(found) > 1:
        raise CageError(f"{_where(obj, found[1])} is a second Mirror: apply one of them first.")
    if not found:
        return None
    modifier = found[0]
    if any(used and cut for used, cut in zip(modifier.use_axis, modifier.use_bisect_axis)):
        raise CageError(f"{_where(obj, modifier)} cuts the mesh: delete the half that it cuts away and switch Bisect off, or apply the modifier first.")
    axes = tuple(axis for axis in range(3) if modifier.use_axis[axis])
    threshold = modifier.merge_threshold if modifier.use_mirror_merge else 0.0
    return Mirror(modifier.name, axes, threshold, (modifier.mirror_object or obj).name)


def _where(obj: bpy.types.Object, modifier: bpy.types.Modifier) -> str:
    return f"Modifier '{modifier.name}' of object '{obj.name}'"


def with_images(obj: bpy.types.Object, points: np.ndarray) -> np.ndarray:
    """Points (n, 3) of an object in the world, and their images by its Mirror modifiers."""
    for modifier in obj.modifiers:
        if modifier.type == "MIRROR" and modifier.show_viewport:
            carrier = np.array((modifier.mirror_object or obj).matrix_world, np.float64)
            for axis in range(3):
                if modifier.use_axis[axis] and abs(np.linalg.det(carrier)) > 0:
                    turn = np.diag([-1.0 if i == axis else 1.0 for i in range(4)])
                    image = carrier @ turn @ np.linalg.inv(carrier)
                    points = np.concatenate([points, points @ image[:3, :3].T + image[:3, 3]])
    return points
