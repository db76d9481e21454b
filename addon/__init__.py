# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvopt: the fairest surface of a control cage, as a Blender add-on.

This file only says what the add-on is and registers its parts in order. The parts, each using only those before it:

    header       curvopt.h as Python sees it                              (no bpy)
    values       cages, energies, reports: plain values                   (no bpy)
    crease       Blender's creases <-> sharpness                          (no bpy)
    native       ctypes binding of libcurvopt                             (no bpy)
    job          one run on a worker thread, progress, cancel             (no bpy)
    cage         mesh object -> arrays, and every reason to refuse one
    result       arrays -> the new object beside the original
    properties   what the sidebar remembers
    operators    the modal operator
    panel        the sidebar
    studio       what every picture needs: scene, light, camera, materials, captions
    render       before and after in one picture
    batch        `blender -b FILE -P batch.py -- ...`
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

_REGISTERED_IN_ORDER = ("properties", "operators", "panel")


def register() -> None:
    """Register every class; works without the native library, which is looked for when a run starts."""
    for name in _REGISTERED_IN_ORDER:
        importlib.import_module("." + name, __package__).register()


def unregister() -> None:
    """Undo `register()` backwards and forget the parts, so that an updated add-on starts from its new files."""
    for name in reversed(_REGISTERED_IN_ORDER):
        sys.modules[f"{__package__}.{name}"].unregister()
    for name in [name for name in sys.modules if name.startswith(__package__ + ".")]:
        del sys.modules[name]
