# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sidebar shows: settings on the Scene, saved with the file; the state of the last run in plain Python, which
neither saving nor undo touches."""

from dataclasses import dataclass

import bpy

from .energy import AREA, ENERGY_LABELS, text_of

ENERGIES = (
    ("WILLMORE", "Willmore", "Bending: the integral of both principal curvatures squared. Spheres are best"),
    ("MVS", "MVS", "Variation of each principal curvature along its own direction. Spheres, tori, cyclides are best"),
    ("MVS_CROSS", "MVS_cross", "Variation of both principal curvatures in every direction"),
    ("VARIATION", "Variation", "The whole change of curvature: the gradient of the second fundamental form, squared"),
    ("MEHLUM_TARROU", "Mehlum-Tarrou", "Change of normal curvature along each direction, averaged over all directions"),
    ("MEAN_CURVATURE", "Mean Curvature", "The integral of mean curvature squared: the soap film in a boundary that stays"),
    ("MIX", "Mix", "Several energies at once, with a weight for each"),
)

BOUNDARIES = (
    ("POSITION", "Position", "Boundary curves stay. Vertices on creases of 1 stay, too"),
    ("TANGENT", "Tangent", "Boundary curves and the surface's slope along them stay: two rows of vertices"),
    ("CURVATURE", "Curvature", "Curves, slope and how curvature changes along them stay: three rows of vertices"),
    ("FREE", "Free", "Nothing stays: boundary and creases move, too"),
)

SYMMETRIES = (
    ("KEEP", "All", "Mirror images and turns that map the cage to itself are all kept, and make the work less"),
    ("AUTO", "Where It Pays", "Some are given up where MVS and its kin gain much by that; takes longer"),
    ("ROTATIONS", "Turns", "Turns only: the cage's lines may twist across mirror planes, which can pay with MVS"),
    ("PLANES", "Planes", "Mirror images across chosen axes of the object are kept, no others. The cage must have them"),
    ("NONE", "Off", "Every vertex moves by itself: the result may lose symmetries"),
)

KEEPS = (
    ("NOTHING", "Nothing", "No vertices but those that Boundary says"),
    ("GROUP", "Vertex Group", "Weights in a vertex group say how firmly: 1 stays, less is drawn back, 0 is free"),
    ("SELECTED", "Selection", "Vertices that are selected in Edit Mode stay"),
    ("UNSELECTED", "All but Selection", "Only vertices that are selected in Edit Mode move"),
)

RESOLUTIONS = (
    ("KEEP", "Keep Mine", "The result has the vertices and faces of your cage, moved: one level"),
    ("REFINE", "Refine", "The cage is subdivided between levels: a fairer surface, with more vertices"),
)

SURFACES = (
    ("AUTO", "Auto", "The limit surface for Willmore, the polynomial one for energies of third order"),
    ("LIMIT", "Limit", "What Blender shows. Energies of third order are infinite on it at poles"),
    ("PLANE", "Plane", "Flattened at poles, as in Joshi and Séquin's report"),
    ("POLYNOMIAL", "Polynomial", "One polynomial at each pole, for energies of third order"),
)

OUTCOMES = (
    ("NEW", "New Object", "The result stands beside the original, which stays as it is"),
    ("REPLACE", "In Place", "The object's own mesh becomes the result. Refined, it loses UV maps and weights"),
    ("SHAPE_KEY", "Shape Key", "The result is a shape key of the object. Needs the resolution Keep Mine"),
)

_DEFAULT_WEIGHTS = {"mvs": 1.0, "willmore": 0.1}
WEIGHT_TERMS = (*ENERGY_LABELS, AREA)


def _weight(term: str) -> object:
    label = ENERGY_LABELS.get(term, "Area")
    about = "keeps the surface small" if term == AREA else "0 leaves it out"
    return bpy.props.FloatProperty(
        name=label, description=f"Weight of {label} in the mix: {about}", default=_DEFAULT_WEIGHTS.get(term, 0.0),
        min=0.0, soft_max=1.0, max=1e6,
    )  # fmt: skip


class RunSettings:
    """What a run is told, for settings and operator alike."""

    energy: bpy.props.EnumProperty(name="Energy", description="What to minimize", items=ENERGIES, default="MVS")
    weight_willmore: _weight("willmore")
    weight_mvs: _weight("mvs")
    weight_mvs_cross: _weight("mvs_cross")
    weight_variation: _weight("variation")
    weight_mehlum_tarrou: _weight("mehlum_tarrou")
    weight_mean_curvature: _weight("mean_curvature")
    weight_area: _weight("area")
    resolution: bpy.props.EnumProperty(
        name="Resolution", description="Whether the result has more vertices", items=RESOLUTIONS, default="REFINE"
    )
    levels: bpy.props.IntProperty(
        name="Levels",
        description="Optimizations, with a subdivision of the cage before each but the first: 1 keeps the cage's faces",
        default=4,
        min=1,
        max=12,
        soft_max=6,
    )
    boundary: bpy.props.EnumProperty(
        name="Boundary", description="What an open surface keeps at its boundary", items=BOUNDARIES, default="POSITION"
    )
    symmetry: bpy.props.EnumProperty(
        name="Symmetry", description="What becomes of the cage's symmetries", items=SYMMETRIES, default="KEEP"
    )
    symmetry_planes: bpy.props.BoolVectorProperty(
        name="Mirror", description="Axes of the object across which mirror images are kept; the planes go through the "
        "cage's middle, wherever the object's origin is", size=3, subtype="XYZ", default=(True, False, False),
    )  # fmt: skip
    keep: bpy.props.EnumProperty(
        name="Keep",
        description="Vertices of the cage that stay where they are; the surface comes closer to them with every level. "
        "Where all vertices of a face and of all faces that touch it are kept, the surface itself stays",
        items=KEEPS,
        default="NOTHING",
    )
    vertex_group: bpy.props.StringProperty(
        name="Vertex Group",
        description="How firmly vertices are held is their weight in this vertex group: 1 exactly, less by a pull back "
        "that depends on neither size nor levels, 0 not at all",
    )
    outcome: bpy.props.EnumProperty(
        name="Result", description="Where the result goes", items=OUTCOMES, default="NEW"
    )
    surface: bpy.props.EnumProperty(
        name="Surface", description="The surface whose energy is meant, at poles and n-gons", items=SURFACES,
        default="AUTO",
    )  # fmt: skip
    max_iterations: bpy.props.IntProperty(
        name="Iterations", description="The most steps of a level", default=3000, min=1, max=100_000, soft_max=5000
    )
    escape: bpy.props.BoolProperty(
        name="Leave Saddles",
        description="Where the shape is a saddle once symmetries are disregarded, go on downwards; takes longer",
        default=False,
    )
    threads: bpy.props.IntProperty(
        name="Threads", description="Processor cores to use: 0 is all of them", default=0, min=0, max=256, soft_max=16
    )


SETTINGS = tuple(RunSettings.__annotations__)


class CURVOPT_PG_settings(RunSettings, bpy.types.PropertyGroup):
    """Settings of the next run."""


def energy_text_of(values: dict[str, object]) -> str:
    """Settings' choice of energy as energy.py writes it. ValueError for an empty mix."""
    if values["energy"] != "MIX":
        return str(values["energy"]).lower()
    return text_of({term: float(values[f"weight_{term}"]) for term in WEIGHT_TERMS})


def symmetry_text_of(values: dict[str, object]) -> str:
    """Settings' choice of symmetry as job.py writes it. ValueError for planes without one."""
    if values["symmetry"] != "PLANES":
        return str(values["symmetry"]).lower()
    planes = ",".join(axis for axis, chosen in zip("xyz", values["symmetry_planes"]) if chosen)
    if not planes:
        raise ValueError("No mirror plane is chosen: choose X, Y or Z, or another Symmetry.")
    return planes


@dataclass
class State:
    """What the sidebar reports. `running` is true from the start of a modal run to its end; `about` is the name of the
    object that the message tells the making of, if it does."""

    message: str = ""
    about: str = ""
    running: bool = False
    failed: bool = False


state = State()


def register() -> None:
    bpy.utils.register_class(CURVOPT_PG_settings)
    bpy.types.Scene.curvopt = bpy.props.PointerProperty(type=CURVOPT_PG_settings)


def unregister() -> None:
    del bpy.types.Scene.curvopt
    bpy.utils.unregister_class(CURVOPT_PG_settings)
