# SPDX-License-Identifier: GPL-3.0-or-later
"""An object while its surface follows handles: what connects scene/handles.py to core/live.py. It reads the file and changes
nothing in it, `begin` excepted."""

from __future__ import annotations

import contextlib
import time
from dataclasses import replace

import bpy
import numpy as np

from ..binding.values import Held
from ..core import job, messages
from ..core.energy import weights_of
from ..core.live import Live, View
from ..core.targets import Base, any_in_one_place
from ..scene import handles, placement, read_cage, read_marks
from ..scene.modifiers import CageError
from . import display, properties

_WORDS = 0.2  # seconds between two changes of the words in the sidebar
_LAST_WAIT = 5.0  # seconds that the end waits for the worker, which looks up every few milliseconds
_FARTHEST = 1e6  # sizes of the cage: float32, in which Blender has places and pictures, has steps of a sixteenth of it there
# Settings that are looked at all the time. The others count when it starts, or are for runs on several levels.
_WATCHED = tuple(
    name for name in properties.SETTINGS
    if name not in ("resolution", "levels", "slide", "rim", "pin", "pin_surface", "vertex_group", "through", "through_normals", "through_balls", "through_weight", "outcome", "threads",
                    "animation")
)  # fmt: skip


class Session:
    """One object while Live is on, or, once it `ended` by itself, until its handles are taken away."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object | None) -> None:
        """CageError unless Live is possible there."""
        values = _values(context.scene)
        outcome, edits = values["outcome"], obj is not None and obj.mode == "EDIT"
        if edits:
            obj.update_from_editmode()
        read_cage.check_object(obj, outcome == "SHAPE_KEY" and not edits, "EDIT" if edits else "OBJECT")
        self.name, self.scene_name = obj.name, context.scene.name
        self.id = ""  # of the marks in the file, from `begin` on
        self.source = read_cage.source_of(context, obj, obj.data)
        self._marks = read_marks.read_marks(obj.data, self.source)
        left = None if edits else handles.left_by_another(obj)
        self._pins, self.chosen = _pins(obj, self.source, values, edits, None if left is None else left[0])
        # Without Pin the points of the surface are dragged; in Edit Mode that is not what one has in hand.
        on_surface = not edits if values["pin"] == "NOTHING" else bool(values["pin_surface"])
        if left is not None:
            on_surface = left[1]
        self.base = Base.of_cage(self.source.cage, self.source.layout, on_surface)
        self._size = float(np.ptp(self.source.cage.positions, axis=0).max())
        self._values: dict[str, object] = {}
        self._plain = self._request = job.Request()
        self._seen: tuple[View | None, BaseException | None] = (None, None)
        self._spoken = 0.0
        self._refusal: BaseException | None = None  # of settings
        self._too_far: BaseException | None = None  # of handles
        self.live: Live | None = None
        self._recorder: Recorder | None = None
        self._edits = edits
        self.view = None
        self.ended = self.finishing = False
        self._places = np.empty((0, 3))
        self.positions = self.source.mesh.positions  # of the mesh's vertices (n, 3) at the last look
        placement.check_outcome(outcome, replace(self._plain, levels=1), obj)

    def begin(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Handles and drawing. ValueError and CageError for settings, before anything is made; `stop` ends what has begun.
        The worker starts with the first `look`, after the operator: one that is called under `temp_override` has a dictionary
        that Blender 3.4 reads without Python's lock, and crashes at times if a thread has that."""
        self._read_settings()
        if self._refusal is not None:
            raise self._refusal
        self._check_points(obj.name, context.scene.curvopt.pin)
        if not bpy.app.background:
            from .live_view import LiveView  # needs a GPU

            self.view = LiveView(self.scene_name)
        in_edit_mode = obj.mode == "EDIT"
        self.id = handles.begin(context, obj, self.source, self.base, self.chosen[:0] if in_edit_mode else self.chosen)
        if not in_edit_mode:  # the empties are the handles, and who is deleted is none any more
            self.chosen = self.chosen[:0]

    def _check_points(self, name: str, pin: str) -> None:
        """CageError for a handle that cannot be a point of the surface."""
        vertex = self.base.without_point(self.chosen)
        if vertex < 0:
            return
        instead = "set Pin to Selection" if pin == "NOTHING" else "turn off On Surface"
        raise CageError(
            f"The surface has no point that belongs to vertex {vertex} of object '{name}', because a crease fades or ends there: "
            f"{instead}, and the vertex itself is the handle."
        )

    def look(self, thorough: bool = False) -> None:
        """Tell the worker where the handles and the settings are, if that is new. CageError where Live cannot go on; while
        faces are edited, some reasons for that are found by a `thorough` look only."""
        obj = handles.find(self.id, self.name)
        if obj is None:
            raise CageError(f"'{self.name}' was deleted, or undone to before Live: Live has ended.")
        self.name = obj.name
        seen = handles.observe(obj, self.source, self.base, self.chosen, None if thorough else self.positions)
        self.positions = seen.positions
        if not len(seen.vertices) and not len(self._pins.vertices) and obj.mode != "EDIT":
            raise CageError("All handles were deleted: Live has ended.")
        self._too_far = _too_far(seen, self._size)
        if self._too_far is not None:
            if self.live is None:
                raise self._too_far
            return
        changed = self._read_settings()
        planes = ["xyz".index(axis) for axis in self._plain.symmetry.split(",") if axis in ("x", "y", "z")]
        others = [axis for axis in planes if axis not in self.source.layout.halves.axes]
        held, places = self.base.held(self._plain.held, seen.vertices, seen.shifts, others)
        if changed or self.live is None or not _alike(held, self._request.held):
            self._request = replace(self._plain, held=held)
        elif np.array_equal(places, self._places, equal_nan=True):
            held = None
        self._places = places
        if self.live is None:
            self.restart()
        elif held is not None:
            self.live.aim(self._request, places)
        if self.view is not None:
            there = self.source.layout.in_cage(seen.vertices) >= 0
            self.view.show(self.live, seen.frame, self.base.of_vertices(seen.vertices[there]) + seen.shifts[there], self.name)

    def restart(self) -> None:
        """A worker for the newest targets. Its way goes on where that of the one before ended."""
        self.live = Live(self.source.cage, self._request, self._places, self._recorder)
        self._recorder = self.live.recorder
        self.live.start()

    def resume(self) -> None:
        """Finish no more: the next `look` starts another worker."""
        self.live.close(_LAST_WAIT)
        self.live, self.finishing = None, False

    def check_finish(self, outcome: str, animation: bool) -> None:
        """CageError or ValueError, before anything is written, where the result cannot be as the settings want it."""
        if self._refusal is not None or self._too_far is not None:
            raise self._refusal or self._too_far
        plain = replace(self._plain, levels=1, records=animation and not self._edits)
        placement.check_outcome(outcome, plain)
        obj = handles.find(self.id, self.name)
        if obj is not None:
            placement.check_outcome(outcome, plain, obj)
            placement.check_keys(outcome, obj)

    def source_there(self) -> read_cage.Source:
        """What was read, under the name that the object has by now, and where it is."""
        obj, space = handles.find(self.id, self.name), self.source.space
        if obj is not None:
            with contextlib.suppress(CageError):  # of another scale: where it was
                space = replace(space, frame=handles.frame_of(obj, self.source))
        return replace(self.source, name=self.name, space=space)

    def _read_settings(self) -> bool:
        """Whether they have changed, and can be used."""
        scene = bpy.data.scenes.get(self.scene_name)
        if scene is None:
            raise CageError(f"Scene '{self.scene_name}' was deleted or renamed: Live has ended.")
        values = _values(scene)
        if {name: values[name] for name in _WATCHED} == self._values:
            return False
        self._values, self._refusal = {name: values[name] for name in _WATCHED}, None
        try:
            if values["within"] > 0:
                raise CageError("Live moves vertices away from their places, and Within keeps them near: set Within to 0.")
            if values["no_crossings"]:
                raise CageError("Live does not look for crossings: turn No Crossings off.")
            request = properties.request_of({**values, "resolution": "SAME", "slide": False, "animation": False}, self._pins)
            weights_of(request.energy)
            request = job.with_marks(self.source.cage, self.source.fitted(request), *self._marks)
        except (CageError, ValueError) as error:  # an empty mix, no plane
            self._refusal = error
            return False
        self._plain = request
        return True

    def speak(self) -> None:
        """What is going on, into the sidebar; and have the viewports drawn if there is something new."""
        live = self.live
        if live.error is not None and not self.finishing:
            raise live.error
        seen = live.latest, self._refusal or self._too_far or live.trouble
        now = time.monotonic()
        if seen[0] is None or (seen[0] is self._seen[0] and seen[1] is self._seen[1]):
            return
        if seen[0] is not self._seen[0] and not bpy.app.background:
            from .overlay import redraw  # needs a GPU

            redraw(bpy.context, ("WINDOW",))
        if now < self._spoken + _WORDS and seen[1] is self._seen[1] and seen[0].summary is None:
            self._seen = seen[0], self._seen[1]
            return
        self._seen, self._spoken = seen, now
        if seen[1] is not None:
            text = messages.failure_text(self.source.named(seen[1]))
            display.show(bpy.context, text + (self._on_handles() if seen[1] is live.trouble else ""), failed=True)
        else:
            is_good = seen[0].summary is None or seen[0].summary.verification.verdict == "minimum"
            display.show(bpy.context, messages.live_text(self._request, seen[0]) + ("" if is_good else self._on_handles()))

    def _on_handles(self) -> str:
        """Where handles are, if that may be why there is no good surface."""
        return messages.IN_ONE_PLACE if any_in_one_place(self._places, self._size) else ""

    @property
    def request(self) -> job.Request:
        """What is minimized now, through the handles."""
        held = self._request.held
        return replace(self._request, held=replace(held, places=self._places if len(self._places) else None))

    def found(self, animation: bool) -> tuple[job.Request, job.Solution]:
        """What was minimized, and the result; in Object Mode with the way there, if an animation is wanted."""
        records, solution = animation and not self._edits, self.live.solution
        return replace(self.request, records=records), solution if records else replace(solution, path=())

    def stop(self) -> None:
        """End the worker and the drawing."""
        if self.live is not None:
            self.live.close(_LAST_WAIT)
        if self.view is not None:
            self.view.end()
        self.ended = True


def _too_far(seen: handles.Observation, size: float) -> CageError | None:
    """What is wrong with a handle that is at infinity, or nearly so; None if none is."""
    with np.errstate(invalid="ignore"):
        lost = seen.vertices[~(np.abs(seen.shifts) <= _FARTHEST * size).all(axis=1)]
    if not len(lost):
        return None
    return CageError(
        f"The handle of vertex {lost[0]} is too far away for any surface, which stays as it was: give the handle another "
        "place, or undo."
    )


def _values(scene: bpy.types.Scene) -> dict[str, object]:
    """The settings of a scene, arrays as tuples."""
    values = {name: getattr(scene.curvopt, name) for name in properties.SETTINGS}
    return {**values, "symmetry_planes": tuple(values["symmetry_planes"])}


def _pins(
    obj: bpy.types.Object, source: read_cage.Source, values: dict[str, object], edits: bool, left: np.ndarray | None
) -> tuple[Held, np.ndarray]:
    """Vertices of the mesh that are pinned and no handles, and those that are handles (k,): what Pin holds exactly, or, if
    it holds nothing, the selection. Handles that are `left` (k,) are taken up in their place. CageError for none."""
    pin = values["pin"]
    if left is not None and pin in ("NOTHING", "SELECTED"):
        return Held(), left[source.layout.in_cage(left) >= 0]
    if pin == "NOTHING" and edits and not _selected(obj).any():
        return Held(), np.empty(0, np.intp)  # those that will be moved
    held = read_cage.read_held(obj, "SELECTED" if pin == "NOTHING" else pin, values["vertex_group"])
    exact = np.asarray(held.weights) == 1
    chosen, pins = held.vertices[exact], Held(held.vertices[~exact], held.weights[~exact])
    if pin == "UNSELECTED":
        chosen, pins = np.empty(0, np.intp), held
    chosen = np.asarray(chosen if left is None else left, np.intp)
    chosen = chosen[source.layout.in_cage(chosen) >= 0]
    if not edits:
        _check_number(obj, pin, len(chosen))
    return pins, chosen


def _selected(obj: bpy.types.Object) -> np.ndarray:
    selected = np.empty(len(obj.data.vertices), bool)
    obj.data.vertices.foreach_get("select", selected)
    return selected


def _check_number(obj: bpy.types.Object, pin: str, count: int) -> None:
    """CageError for no handles, and for more than a hand can use."""
    how = "select a few vertices in Edit Mode, or have Pin name a vertex group with a few"
    if not count:
        raise CageError(f"Pin gives no handles on object '{obj.name}': {how}, or start Live in Edit Mode.")
    if count > handles.MOST_HANDLES or count == len(obj.data.vertices):
        chosen = "selected" if pin in ("NOTHING", "SELECTED") else "pinned"
        raise CageError(
            f"{count} vertices of object '{obj.name}' are {chosen}, and each would become a handle: {how}, "
            f"{handles.MOST_HANDLES} at most."
        )


def _alike(one: Held, other: Held) -> bool:
    """Whether the same vertices are held as firmly."""
    return np.array_equal(one.vertices, other.vertices) and np.array_equal(one.weights, other.weights)
