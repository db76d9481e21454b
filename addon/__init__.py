# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvopt: the fairest surface of a control cage, as a Blender add-on.

This file only says what the add-on is and registers its parts in order. The parts, each using only those before it:

    header       curvopt.h as Python sees it                              (no bpy)
    values       cages, energies, reports: plain values                   (no bpy)
    crease       Blender's creases <-> sharpness                          (no bpy)
    energy       names of energies, mixes, numbers for people             (no bpy)
    native       ctypes binding of libcurvopt                             (no bpy)
    lattice      points of a limit surface and the quads between          (no bpy)
    curvature    jets -> principal, mean, Gauss curvature, variation      (no bpy)
    colours      curvature -> colour                                      (no bpy)
    snapshot     what the viewport shows of a run, taken by the worker    (no bpy)
    memory       meshes beyond memory                                     (no bpy)
    job          one run on a worker thread, progress, keep, cancel       (no bpy)
    catalogue    cages to start from                                      (no bpy)
    cage         mesh object -> arrays, and every reason to refuse one
    amount       the slider from original to optimum
    result       arrays -> the new object beside the original
    outcome      or its own mesh, or a shape key
    properties   what the sidebar remembers
    apply        the end of a run, which the adjust panel repeats
    overlay      flat drawing over a viewport                             (needs a GPU)
    preview      a run as the viewports show it                           (needs a GPU)
    operators    the modal operator, Keep, Cancel
    analysis     colours of curvature, legend, looks
    menus        Object and Add menu, presets
    panel        the sidebar
    studio       what every picture needs: scene, light, camera, materials, captions
    render       before and after in one picture
    parts        those that Blender runs with -P find the others          (no bpy)
    batch, many  `blender -b FILE -P batch.py -- ...`, and many files at once
    gallery      `blender -b -P gallery.py -- ...`, the report's tables, figures and questions; its parts:
      gallery_store, _schedule      items, what is finished on disk, and in which order          (no bpy)
      gallery_surface, _solve       dense meshes of any surface kind; optimizations              (no bpy)
      gallery_profile, _torus, _answers     the questions' experiments                           (no bpy)
      gallery_plot, _png, _html, _figures, _page, _answers_page     what people see              (no bpy)
      gallery_items                 the list of everything, after what it needs                  (no bpy)
      gallery_pictures              rows and sheets of shapes

Nothing that needs bpy is imported before `register()`, so those marked are usable and testable without Blender.
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

_REGISTERED_IN_ORDER = ("properties", "amount", "apply", "operators", "analysis", "menus", "panel")


def register() -> None:
    """Register every class; works without the native library, which is looked for when a run starts."""
    for name in _REGISTERED_IN_ORDER:
        importlib.import_module("." + name, __package__).register()


def unregister() -> None:
    """Undo `register()` backwards and forget the parts, so that an updated add-on starts from its new files."""
    for name in reversed(_REGISTERED_IN_ORDER):
        sys.modules[f"{__package__}.{name}"].unregister()
    package = sys.modules[__package__]
    for name in [name for name in sys.modules if name.startswith(__package__ + ".")]:
        del sys.modules[name]
        package.__dict__.pop(name.rpartition(".")[2], None)  # where `from . import name` looks first
