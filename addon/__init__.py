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
    render       before and after in one picture
    batch        `blender -b FILE -P batch.py -- ...`

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
