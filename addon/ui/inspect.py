# SPDX-License-Identifier: GPL-3.0-or-later
"""Inspect: the switch, its settings, and what goes from the active object to the worker and from the worker to the viewports.

While the switch is on, a timer of the application looks whether the cage has changed. Handlers only tell it that something
has. The mouse is followed by an entry of the keymap, as Blender's Outliner does, and not by a modal operator: Blender refuses
undo while one is there.
"""

from __future__ import annotations

import time
import traceback
from dataclasses import replace

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..binding import library
from ..core import colours, messages
from ..core.combs import Choice, OnEdges, OnSections, is_same
from ..core.inspected import Inspected, Subject, is_alike
from ..core.inspector import Inspector
from ..core.probe import Probe
from ..scene import handles, watched
from ..scene.modifiers import CageError, subdivision
from . import live, properties

_TICK = 0.016  # seconds between looks
_SHARE = 4.0  # the timer waits that many times longer than a look takes: a fifth of the main thread at most
_THOROUGH = 0.3  # seconds after the last change until creases, modifiers and faces are read again
_LAST_WAIT = 5.0  # seconds that the end waits for the worker

_KINDS = (
    ("ZEBRA", "Zebra", "Reflections of ring-shaped lights round the light direction. They move as you turn the view. A kink: the "
     "tangent planes jump; a bend: the curvature jumps"),
    ("ISOPHOTES", "Isophotes", "Bands of equal angle between the normal and the light. They stay as you turn the view"),
    ("CURVATURE", "Curvature", "Colours of curvature"),
    ("DISTANCE", "Distance", "Colours of the distance to the original: of a result, a shape key, or what Live pulls"),
    ("PLAIN", "Plain", "The surface, without stripes and colours"),
    ("NOTHING", "Nothing", "Blender's own picture of the object, with combs and probe only"),
)  # fmt: skip
_COMB_CURVES = (
    ("SELECTED", "Selected Edges", "The edges that are selected in Edit Mode"),
    ("LOOPS", "Their Loops", "The edge loops of the selected edges"),
    ("ALL", "All Edges", "All edges of the cage"),
    ("X", "Sections across X", "The curves in which planes across the object's X axis cut the surface"),
    ("Y", "Sections across Y", "The curves in which planes across the object's Y axis cut the surface"),
    ("Z", "Sections across Z", "The curves in which planes across the object's Z axis cut the surface"),
)

_BY_SELECTION, AXES = ("SELECTED", "LOOPS"), ("X", "Y", "Z")


def _changed(_self: object, _context: bpy.types.Context) -> None:
    if _session is not None:
        _session.is_dirty = True


def _is_on(_self: object) -> bool:
    return _session is not None


def _set_on(_self: object, on: bool) -> None:
    _switch(on)


class CURVOPT_PG_inspect(bpy.types.PropertyGroup):
    """What is drawn on the active object itself; no data of the file."""

    # fmt: off
    is_on: bpy.props.BoolProperty(
        name="Inspect", description="Draw the true limit surface of the active object's cage over the object, to read how fair "
        "it is. It follows edits, shape keys and Live", get=_is_on, set=_set_on,
    )
    kind: bpy.props.EnumProperty(name="Show", description="What is drawn on the surface", items=_KINDS, default="ZEBRA", update=_changed)
    light: bpy.props.FloatVectorProperty(
        name="Light", description="Where the light comes from, in the world", subtype="DIRECTION", size=3, default=(0.0, 0.0, 1.0),
        update=_changed,
    )
    width: bpy.props.FloatProperty(
        name="Width", description="Width of a stripe: the angle between two of its edges, in the mirror image or of the normal",
        subtype="ANGLE", default=np.radians(8.0), min=np.radians(0.5), max=np.radians(90.0), update=_changed,
    )
    quantity: bpy.props.EnumProperty(
        name="Colour", description="The curvature that is shown", items=[(n, label, tip) for n, label, tip in colours.QUANTITIES],
        default="H", update=_changed,
    )
    in_front: bpy.props.BoolProperty(
        name="In Front", description="Draw over everything else in the view. In Edit Mode only where the object has no Subdivision "
        "Surface modifier: else the surface is drawn on the modifier's, and the cage's vertices stay visible", default=True,
        update=_changed,
    )
    combs: bpy.props.BoolProperty(
        name="Combs", description="Curvature combs, on the curves that edges of the cage become on the surface or on plane sections: "
        "teeth away from where the curve bends to, as long as it is curved", default=False, update=_changed,
    )
    comb_curves: bpy.props.EnumProperty(name="On", description="Which curves have combs", items=_COMB_CURVES, default="LOOPS", update=_changed)
    comb_sections: bpy.props.IntProperty(
        name="Sections", description="Number of planes, at equal distances over the whole surface", default=5, min=1, soft_max=20, max=100,
        update=_changed,
    )
    comb_length: bpy.props.FloatProperty(
        name="Length", description="Length of a tooth where the curve is curved as a circle of the cage's RMS radius, in these radii",
        default=0.1, min=0.0, soft_max=2.0, max=100.0, update=_changed,
    )
    comb_teeth: bpy.props.IntProperty(
        name="Teeth", description="Teeth on each edge of the cage; of a section, on the mean length of an edge", default=8, min=1,
        soft_max=32, max=200, update=_changed,
    )
    probe: bpy.props.BoolProperty(
        name="Probe", description="Under the mouse: the two radii of curvature, the normal, the energy per area, and how both sides "
        "of the next edge meet: gap (G0), angle (G1), jump of curvature (G2)", default=False, update=_changed,
    )
    # fmt: on


class Session:
    """From switching on to switching off."""

    def __init__(self) -> None:
        self.message = ""
        self.is_dirty = True
        self.inspector = Inspector()
        self.view = None
        self.mouse: tuple[int, int, int, np.ndarray, np.ndarray] | None = None  # region, x, y, its matrix, place -1 .. 1
        self._watched = watched.Watched()
        self._subject: Subject | None = None
        self._key: tuple[str, str] | None = None  # active object and mode at the last look
        self._live: object = None  # the state of Live then
        self._thorough_at = 0.0  # when to look thoroughly, 0 for no need
        self._target: tuple[str, Matrix] | None = None  # the object, and its cage's frame in its coordinates
        self._shown: Inspected | None = None
        self._count = self._since = 0  # subjects so far, and those before this object
        self._probe: Probe | None = None
        self._mouse_is_new = False
        if not bpy.app.background:
            from . import inspect_view  # needs a GPU

            self.view = inspect_view.current = inspect_view.InspectView()

    def step(self) -> None:
        """What the timer does."""
        context, now = bpy.context, time.monotonic()
        obj = context.view_layer.objects.active
        obj = handles.owner(obj) or obj
        key, view = (obj.name, obj.mode) if obj is not None else None, _live_view(obj)
        if key != self._key or view is not self._live:
            self._key, self._live, self.is_dirty = key, view, True
        is_thorough = self._thorough_at and now >= self._thorough_at
        if self.is_dirty or is_thorough:
            self._look(context, obj, bool(is_thorough))
            self._thorough_at = 0.0 if is_thorough else now + _THOROUGH
            self.is_dirty = False
        self._take(context)
        if self._mouse_is_new:
            self._mouse_is_new = False
            self._read(context)

    def point(self, mouse: tuple[int, int, int, np.ndarray, np.ndarray]) -> None:
        """The mouse is there."""
        self.mouse, self._mouse_is_new = mouse, True

    def stop(self) -> None:
        """End the worker and the drawing."""
        self.inspector.close(_LAST_WAIT)
        if self._probe is not None:
            self._probe.close()
        if self.view is not None:
            from . import inspect_view  # needs a GPU

            self.view.end()
            inspect_view.current = None

    def _look(self, context: bpy.types.Context, obj: bpy.types.Object | None, thorough: bool) -> None:
        """The cage to the worker, if it has changed; a refusal into the panel."""
        settings, message = context.window_manager.curvopt_inspect, ""
        try:
            seen = self._seen(context, obj, thorough, settings)
            quantity = {"CURVATURE": settings.quantity, "DISTANCE": colours.DISTANCE}.get(settings.kind, "")
            if settings.kind == "DISTANCE" and seen.original is None:
                quantity, message = "", f"The original of '{obj.name}' is not known: it is no result, and has no shape keys."
            choice = _choice(settings, seen, obj)
            if self._target is None or self._target[0] != obj.name:
                self._shown, self._since = None, self._count
            self._aim(Subject(seen.cage, quantity, seen.original if quantity == colours.DISTANCE else None, choice))
            self._target = obj.name, obj.matrix_world.inverted() @ seen.frame
        except CageError as error:
            self._subject, self._target, message = None, None, str(error)
        self._show(context)
        self._say(context, message)

    def _seen(
        self, context: bpy.types.Context, obj: bpy.types.Object | None, thorough: bool, settings: CURVOPT_PG_inspect
    ) -> watched.Seen:
        session, view = live.current(), _live_view(obj)
        if view is None:
            by_selection = settings.combs and settings.comb_curves in _BY_SELECTION
            return self._watched.look(context, obj, thorough, by_selection, settings.kind == "DISTANCE")
        cage = replace(session.source.cage, positions=view.snapshot.cage.astype(np.float64))
        frame, pairs = handles.frame_of(obj, session.source), watched.selected_pairs(obj, session.source.layout)
        return watched.Seen(cage, frame, pairs, session.source.cage.positions)

    def _aim(self, subject: Subject) -> None:
        if self._subject is not None and _is_same(self._subject, subject):
            return
        self._count += 1
        self._subject = replace(subject, number=self._count)
        self.inspector.look(self._subject)

    def _take(self, context: bpy.types.Context) -> None:
        """The worker's newest picture to the view."""
        latest, error = self.inspector.latest, self.inspector.error
        if error is not None and self._subject is not None:
            self._say(context, messages.failure_text(error))
        if latest is not self._shown and (latest is None or latest.subject.number > self._since):
            self._shown, self._mouse_is_new = latest, self.mouse is not None
            self._show(context)

    def _show(self, context: bpy.types.Context) -> None:
        if self.view is None:
            return
        from .overlay import redraw  # needs a GPU

        settings = context.window_manager.curvopt_inspect
        if self._target is None or self._shown is None:
            self.view.show(None, "", Matrix(), None)
        else:
            self.view.show(self._shown, *self._target, _looks(settings, bpy.data.objects.get(self._target[0])))
        if self._target is None or not settings.probe:
            self.view.read(None, 0, 0, 0)
        redraw(context, ("WINDOW",))

    def _read(self, context: bpy.types.Context) -> None:
        """What the probe reads."""
        placement = self.view.placement() if self.view is not None else None
        if self._shown is None or self._target is None or placement is None or not context.window_manager.curvopt_inspect.probe:
            return
        from .overlay import redraw  # needs a GPU

        region, x, y, matrix, at = self.mouse
        if self._probe is None or self._probe.inspected is not self._shown:
            if self._probe is not None:
                self._probe.close()
            self._probe = Probe(library.load(), self._shown)
        reading = self._probe.read(matrix @ np.array(placement, np.float64), at, _energy(context.scene))
        self.view.read(reading, region, x, y)
        redraw(context, ("WINDOW",))

    def _say(self, context: bpy.types.Context, message: str) -> None:
        if message != self.message:
            self.message = message
            if not bpy.app.background:
                from .overlay import redraw  # needs a GPU

                redraw(context, ("UI",))


def _live_view(obj: bpy.types.Object | None) -> object:
    """The newest state of Live on this object, or None."""
    session = live.current()
    on_it = session is not None and not session.ended and obj is not None and session.name == obj.name
    return session.live.latest if on_it and session.live is not None else None


def _looks(settings: CURVOPT_PG_inspect, obj: bpy.types.Object | None) -> object:
    """The settings as inspect_view.Looks for that object."""
    from .inspect_view import Looks  # needs a GPU

    kind = "COLOURS" if settings.kind in ("CURVATURE", "DISTANCE") else settings.kind
    by_distance = settings.kind == "DISTANCE"
    label = "Distance to the original" if by_distance else next(label for n, label, _ in colours.QUANTITIES if n == settings.quantity)
    quantity = colours.DISTANCE if by_distance else settings.quantity
    light = Vector(settings.light) if Vector(settings.light).length > 0 else Vector((0, 0, 1))
    shows_cage = obj is None or obj.mode != "EDIT" or subdivision(obj) is None
    return Looks(kind, light.normalized(), settings.width, settings.in_front and shows_cage, label, quantity)


def _choice(settings: CURVOPT_PG_inspect, seen: watched.Seen, obj: bpy.types.Object) -> Choice | None:
    """The combs that are wanted."""
    if not settings.combs:
        return None
    if settings.comb_curves in AXES:
        axis = (obj.matrix_world.inverted() @ seen.frame).to_3x3().transposed().col[AXES.index(settings.comb_curves)].normalized()
        return OnSections(tuple(axis), settings.comb_sections, settings.comb_teeth, settings.comb_length)
    pairs = seen.selected if settings.comb_curves in _BY_SELECTION else None
    return OnEdges(pairs, settings.comb_curves == "LOOPS", settings.comb_teeth, settings.comb_length)


def _energy(scene: bpy.types.Scene) -> str:
    """The energy that is chosen; of an empty mix Willmore."""
    try:
        return properties.energy_text_of({name: getattr(scene.curvopt, name) for name in properties.SETTINGS})
    except ValueError:
        return "willmore"


def _is_same(one: Subject, other: Subject) -> bool:
    """Whether there is nothing new to sample."""
    if not is_same(one.choice, other.choice) or one.quantity != other.quantity or (one.original is None) != (other.original is None):
        return False
    places = np.array_equal(one.cage.positions, other.cage.positions, equal_nan=True)
    originals = one.original is None or np.array_equal(one.original, other.original)
    return places and originals and is_alike(one.cage, other.cage)


# ----------------------------------------------------------------------------------------------------- on and off --

_session: Session | None = None
_keys: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def message() -> str:
    """What the panel says: a refusal, or nothing."""
    return _session.message if _session is not None else ""


def _tick() -> float | None:
    """Seconds until the next look, or None at the end."""
    if _session is None:
        return None
    begin = time.perf_counter()
    try:
        _session.step()
    except Exception as error:  # else it would come again sixty times a second
        traceback.print_exc()
        print(messages.failure_text(error))
        _switch(False)
        return None
    return max(_TICK, _SHARE * (time.perf_counter() - begin))


@bpy.app.handlers.persistent
def _note(*_: object) -> None:
    """Something has changed."""
    if _session is not None:
        _session.is_dirty = True


@bpy.app.handlers.persistent
def _on_load(*_: object) -> None:
    _switch(False)


def _switch(on: bool) -> None:
    global _session
    if on == (_session is not None):
        return
    noted = [getattr(bpy.app.handlers, name) for name in ("depsgraph_update_post", "frame_change_post", "undo_post", "redo_post")]
    if on:
        _session = Session()
        for handlers in noted:
            handlers.append(_note)
        bpy.app.handlers.load_pre.append(_on_load)
        bpy.app.timers.register(_tick)
        return
    session, _session = _session, None
    session.stop()
    for handlers in (*noted, bpy.app.handlers.load_pre):
        for function in (_note, _on_load):
            if function in handlers:
                handlers.remove(function)
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    if not bpy.app.background:
        from .overlay import redraw  # needs a GPU

        redraw(bpy.context)


class CURVOPT_OT_probe(bpy.types.Operator):
    """Have Inspect's probe read the surface under the mouse"""

    bl_idname = "curvopt.probe"
    bl_label = "Probe"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _session is not None and context.window_manager.curvopt_inspect.probe and context.region_data is not None

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Where the mouse is; the timer reads. The event goes on to whoever else wants it."""
        region, x, y = context.region, event.mouse_region_x, event.mouse_region_y
        at = np.array([2 * x / region.width - 1, 2 * y / region.height - 1])
        _session.point((region.as_pointer(), x, y, np.array(context.region_data.perspective_matrix, np.float64), at))
        return {"CANCELLED", "PASS_THROUGH"}


_CLASSES = (CURVOPT_PG_inspect, CURVOPT_OT_probe)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.WindowManager.curvopt_inspect = bpy.props.PointerProperty(type=CURVOPT_PG_inspect)
    config = bpy.context.window_manager.keyconfigs.addon
    if config is not None:  # none in background
        keymap = config.keymaps.new("3D View", space_type="VIEW_3D")
        _keys.append((keymap, keymap.keymap_items.new(CURVOPT_OT_probe.bl_idname, "MOUSEMOVE", "ANY")))


def unregister() -> None:
    _switch(False)
    for keymap, item in _keys:
        keymap.keymap_items.remove(item)
    _keys.clear()
    del bpy.types.WindowManager.curvopt_inspect
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
