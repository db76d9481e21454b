# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvopt: the fairest surface of a control cage, as a Blender add-on.

This file says what the add-on is and registers its parts in order. The packages follow the flow of data. A file imports
from packages that stand above its own in this list, and from files above it in its own package:

binding/            the package of libcurvopt/python/curvopt              (no bpy)
core/               everything that works on arrays                       (no bpy)
    energy          names of energies, mixes, numbers for people
    crease          Blender's creases <-> sharpness
    mirror          half a cage <-> the whole of a Mirror modifier
    layout          a mesh <-> the cage that is optimized
    crop            the part of a cage that a run with holes depends on
    rims            part of a cage: what moves, what changes with it
    partners        mirror images within a mesh
    surface_points  points of a surface and the quads between
    curvature       jets -> principal, mean, Gauss curvature, variation
    density         jets -> how much of each energy is at a point
    colours         curvature -> colour
    edges           edges of a cage as curves of its surface; loops
    sections        plane sections of a surface, as curves
    combs           curvature combs on them
    snapshot        what the viewport shows of a run; the worker takes it
    memory          refuses meshes beyond memory
    record          the way of a run, as a few states
    job             one run: here and now, on a worker thread, modal
    live            a surface that follows the hand: a worker that stays
    targets         handles that were moved -> what is held, and where
    balls           empties as balls: where a surface touches one, and how it is curved there
    go_through      places in space -> points of the surface that go there
    guides          curves that chains of edges follow
    least           least bending energies that theorems know
    messages        progress, outcome, verdict, failure as sentences
    variants        a finished run, and others like it
    inspected       a surface as Inspect draws it
    probe           what a surface is like under the mouse
    inspector       the worker that samples it
    catalogue       cages to start from
scene/              between Blender's data and arrays
    multires        whether Multiresolution holds sculpted detail
    modifiers       which modifiers the cage goes through
    frame           where a cage is in the world
    read_cage       mesh object -> arrays, and every reason to refuse one
    amount          the slider from original to optimum
    animation       a run as shape keys with keyframes
    read_targets    what a collection says the surface goes through
    read_marks      what single edges hold where they are a boundary, or a rim
    read_edit       what of an object in Edit Mode is to move
    write_result    arrays -> the new object beside the original
    placement       new object, the object's own mesh, or a shape key
    watched         the cage of an object as it is shown now
    handles         empties to drag, and vertices that were moved
    write_edit      a result -> the mesh that is edited
    write_guide     a curve along selected edges, which they follow
ui/                 what the user sees and presses
    properties      settings of the sidebar
    reports         failures as reports
    wave_length     what length of waves a strength below 1 takes away
    overlay         flat drawing over a viewport                          (needs a GPU)
    preview         a run as the viewports show it                        (needs a GPU)
    display         message, status bar and preview of a run
    adjust          the operator that writes a result and can be adjusted
    adjust_edit     the same in Edit Mode
    mark_rim        the operator that marks edges as rims
    new_guide       the operator that makes a curve for a chain of edges
    operators       the modal operator, Finish, Cancel
    inspect_view    stripes, combs and readings on the object itself      (needs a GPU)
    live_view       a surface that follows the hand, in the viewports     (needs a GPU)
    live_session    an object while its surface follows handles
    live            the operators of Live
    inspect         the switch of Inspect, its settings, the mouse
    analysis        colours of curvature, legend, looks
    menus           Object and Add menu, presets
    panel           the sidebar
render/             pictures in files
    studio          scene, light, camera, materials, captions
    before_after    before and after in one picture
batch/              the batch command, which batch.py starts
    leftovers       what runs that were killed have left
    one             one run and what it writes
    many            many files, objects, energies and levels
    command         the command line

Nothing that needs bpy is imported before `register()`, so binding/ and core/ work without Blender.
"""

import importlib
import sys

bl_info = {
    "name": "Curvopt",
    "description": "Minimize curvature energies (Willmore, MVS, MVS_cross) of Catmull-Clark surfaces",
    "author": "The curvopt authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Curvopt",
    "category": "Mesh",
}

_REGISTERED_IN_ORDER = (
    "ui.properties", "scene.amount", "ui.adjust", "ui.adjust_edit", "ui.mark_rim", "ui.new_guide", "ui.operators", "ui.live",
    "ui.inspect", "ui.analysis", "ui.menus", "ui.panel",
)  # fmt: skip


def register() -> None:
    """Register every class; works without the native library, which is looked for when a run starts."""
    for name in _REGISTERED_IN_ORDER:
        importlib.import_module("." + name, __package__).register()


def unregister() -> None:
    """Undo `register()` backwards and forget all modules, so that an updated add-on starts from its new files."""
    for name in reversed(_REGISTERED_IN_ORDER):
        sys.modules[f"{__package__}.{name}"].unregister()  # ui.operators ends the runs that are on
    importlib.import_module(".binding.library", __package__).forget()
    inside = __package__ + "."
    for name in [name for name in sys.modules if name.startswith(inside)]:
        del sys.modules[name]
        vars(sys.modules[__package__]).pop(name[len(inside) :], None)  # a package: where `from . import` looks first
