# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sidebar shows: settings on the Scene, saved with the file; the state of the last run in plain Python, which
neither saving nor undo touches."""

from dataclasses import dataclass

import bpy

ENERGIES = (
    ("WILLMORE", "Willmore", "Bending: the integral of both principal curvatures squared. Spheres are best"),
    ("MVS", "MVS", "Variation of each principal curvature along its own direction. Spheres, tori, cyclides are best"),
    ("MVS_CROSS", "MVS_cross", "Variation of both principal curvatures in every direction"),
)


BOUNDARIES = (
    ("POSITION", "Position", "Boundary curves stay. Vertices on creases of 1 stay, too"),
    ("TANGENT", "Tangent", "Boundary curves and the surface's slope along them stay: two rows of vertices"),
    ("CURVATURE", "Curvature", "Curves, slope and how curvature changes along them stay: three rows of vertices"),
    ("FREE", "Free", "Nothing stays: boundary and creases move, too"),
)


SYMMETRIES = (
    ("AUTO", "Auto", "Mirror images and turns that map the cage to itself are found and kept, and make the work less"),
    ("NONE", "Off", "Every vertex moves by itself: the result may lose symmetries"),
    ("ROTATIONS", "Turns", "Turns only: the cage's lines may twist across mirror planes, which can pay with MVS"),
)

KEEPS = (
    ("NOTHING", "Nothing", "No vertices but those that Boundary says"),
    ("GROUP", "Vertex Group", "Vertices with a weight above 0.5 in a vertex group stay"),
    ("SELECTED", "Selection", "Vertices that are selected in Edit Mode stay"),
    ("UNSELECTED", "All but Selection", "Only vertices that are selected in Edit Mode move"),
)


def energy_property() -> object:
    """The choice of energy, for settings and operator alike; identifiers are keys of job.ENERGY_LABELS in capitals."""
    return bpy.props.EnumProperty(name="Energy", description="What to minimize", items=ENERGIES, default="MVS")


def levels_property() -> object:
    """The number of optimizations, for settings and operator alike."""
    return bpy.props.IntProperty(
        name="Levels",
        description="Optimizations, with a subdivision of the cage before each but the first: 1 keeps the cage's faces",
        default=4,
        min=1,
        max=12,
        soft_max=6,
    )


def boundary_property() -> object:
    """What stays, for settings and operator alike; identifiers are header.BOUNDARIES in capitals."""
    return bpy.props.EnumProperty(
        name="Boundary", description="What an open surface keeps at its boundary", items=BOUNDARIES, default="POSITION"
    )


def symmetry_property() -> object:
    """Whether symmetries are kept, for settings and operator alike; identifiers are header.SYMMETRIES in capitals."""
    return bpy.props.EnumProperty(
        name="Symmetry", description="What becomes of the cage's symmetries", items=SYMMETRIES, default="AUTO"
    )


def keep_property() -> object:
    """The vertices that are held, for settings and operator alike; identifiers are those of cage.read_held."""
    return bpy.props.EnumProperty(
        name="Keep",
        description="Vertices of the cage that stay where they are; the surface comes closer to them with every level. "
        "Where all vertices of a face and of all faces that touch it are kept, the surface itself stays",
        items=KEEPS,
        default="NOTHING",
    )


def vertex_group_property() -> object:
    """The name of the group that `keep` means, for settings and operator alike."""
    return bpy.props.StringProperty(
        name="Vertex Group", description="Vertices with a weight above 0.5 in this vertex group stay"
    )


class CURVOPT_PG_settings(bpy.types.PropertyGroup):
    """Settings of the next run."""

    energy: energy_property()
    levels: levels_property()
    boundary: boundary_property()
    symmetry: symmetry_property()
    keep: keep_property()
    vertex_group: vertex_group_property()


@dataclass
class State:
    """What the sidebar reports. `running` is true from the start of a modal run to its end."""

    message: str = ""
    running: bool = False
    failed: bool = False


state = State()


def register() -> None:
    bpy.utils.register_class(CURVOPT_PG_settings)
    bpy.types.Scene.curvopt = bpy.props.PointerProperty(type=CURVOPT_PG_settings)


def unregister() -> None:
    del bpy.types.Scene.curvopt
    bpy.utils.unregister_class(CURVOPT_PG_settings)
