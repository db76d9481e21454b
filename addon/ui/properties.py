# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sidebar shows: settings on the Scene, saved with the file; the state of the last run in plain Python, which
neither saving nor undo touches."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import bpy

from ..binding import abi
from ..binding.abi import DEFAULTS
from ..binding.values import Held
from ..core.energy import AREA, ENERGY_LABELS, text_of
from ..core.job import Request

# Choices as (identifier, label, tooltip). Identifiers are the library's names in capitals.
ENERGIES = (
    ("WILLMORE", "Willmore", "Bending: the integral of k1² + k2². For soap-film-like shapes. A sphere has the least"),
    ("MVS", "MVS", "Change of each principal curvature along its own line of curvature. For round arms of even "
     "thickness. Spheres, tori and cyclides have none"),
    ("MVS_CROSS", "MVS_cross", "Change of both principal curvatures along all lines of curvature. For rounder bodies "
     "and thinner arms than MVS"),
    ("VARIATION", "Variation", "Change of curvature in every direction: the squared gradient of the second fundamental "
     "form. For shapes between MVS and MVS_cross"),
    ("MEHLUM_TARROU", "Mehlum-Tarrou", "Change of normal curvature along each direction, averaged over all directions. "
     "For shapes between MVS and MVS_cross"),
    ("MEAN_CURVATURE", "Mean Curvature", "The integral of squared mean curvature. For the soap film in a boundary that "
     "is held"),
    ("MIX", "Mix", "Several energies at once, each with a weight"),
)  # fmt: skip

BOUNDARIES = (
    ("POSITION", "Position", "Boundary curves stay, and so do vertices on creases of 1"),
    ("TANGENT", "Tangent", "Boundary curves stay, and the tangent planes along them: two rows of vertices are held"),
    ("CURVATURE", "Curvature", "Boundary curves stay, and the tangent planes, the curvature and its change along them: "
     "three rows of vertices are held"),
    ("FREE", "Free", "Nothing is held: boundaries and creases move, too"),
)  # fmt: skip

RIMS = (
    ("FREE", "Free", "All selected vertices move. The surface of the faces beside them follows, so the transition is "
     "smooth"),
    ("POSITION", "Position", "Vertices on the rim stay"),
    ("TANGENT", "Tangent", "Two rows of vertices stay at the rim. The surface outside the selection stays exactly as "
     "it is, with the same tangent planes and curvature on both sides of the rim"),
    ("CURVATURE", "Curvature", "Three rows of vertices stay at the rim: also the change of curvature at it"),
)  # fmt: skip

SYMMETRIES = (
    ("AUTO", "Automatic", "Keeps the reflections and rotations of the cage. At strength 1, with third-order energies, "
     "it gives some up where each halving of their number lowers the energy by 6 % or more, on levels of 20 to 2000 "
     "vertices"),
    ("KEEP", "All", "Keeps all reflections and rotations of the cage. With n symmetries a run is almost n times as "
     "fast"),
    ("ROTATIONS", "Rotations", "Keeps the rotations of the cage, but no reflections. For third-order energies on "
     "coarse cages, where twisted grid lines have less energy"),
    ("PLANES", "Planes", "Keeps reflections across the axes that you choose, and no other symmetry. The cage must have "
     "them"),
    ("NONE", "None", "Keeps no symmetry: every vertex moves by itself"),
)  # fmt: skip

PINS = (
    ("NOTHING", "Nothing", "No vertex is pinned; Boundary may still hold some"),
    ("GROUP", "Vertex Group", "Pins the vertices of a vertex group by their weights: 1 is exact, less is a spring, 0 "
     "is free"),
    ("SELECTED", "Selection", "Pins the vertices that are selected in Edit Mode"),
    ("UNSELECTED", "All but Selection", "Pins all vertices but those that are selected in Edit Mode. For changing one "
     "part of a shape"),
)  # fmt: skip

RESOLUTIONS = (
    ("SAME", "Same Vertices", "The result has the vertices and faces of your cage: one level. Where all of them are held, "
     "as in a plane, the cage is refined once or twice"),
    ("REFINE", "Refine", "The cage is subdivided before each level but the first. For a fairer surface, with more "
     "vertices"),
)  # fmt: skip

SURFACES = (
    ("AUTO", "Automatic", "The limit surface for Willmore and mean curvature, Polynomial for third-order energies"),
    ("LIMIT", "Limit", "The Catmull-Clark limit surface, which Blender shows. Third-order energies do not exist on it "
     "at extraordinary vertices (poles)"),
    ("PLANE", "Plane", "Flat at extraordinary vertices (poles), as in Joshi and Séquin's report"),
    ("POLYNOMIAL", "Polynomial", "One polynomial at each extraordinary vertex (pole). For third-order energies"),
)  # fmt: skip

OUTCOMES = (
    ("NEW", "New Object", "The result is a new object beside the original, which stays as it is"),
    ("REPLACE", "In Place", "The result replaces the mesh of the object. With Refine, UV maps and weights are lost"),
    ("SHAPE_KEY", "Shape Key", "The result is a shape key of the object. Needs Same Vertices"),
)

_DEFAULT_WEIGHTS = {"mvs": 1.0, "willmore": 0.1}
WEIGHT_TERMS = (*ENERGY_LABELS, AREA)


def _weight(term: str) -> object:
    """The property of a term's weight in a mix."""
    label = ENERGY_LABELS.get(term, "Area")
    about = "keeps the surface small" if term == AREA else "0 leaves it out"
    return bpy.props.FloatProperty(
        name=label, description=f"Weight of {label} in the mix: {about}", default=_DEFAULT_WEIGHTS.get(term, 0.0),
        min=0.0, soft_max=1.0, max=1e6,
    )  # fmt: skip


# For a newcomer. The library and the batch command begin with the minimum.
_STRENGTH = 0.3
_RESOLUTION = "SAME"


class RunSettings:
    """The controls of a run, for settings and operator alike."""

    # fmt: off
    energy: bpy.props.EnumProperty(
        name="Energy", description="The energy to minimize", items=ENERGIES, default=DEFAULTS.energy.upper()
    )
    weight_willmore: _weight("willmore")
    weight_mvs: _weight("mvs")
    weight_mvs_cross: _weight("mvs_cross")
    weight_variation: _weight("variation")
    weight_mehlum_tarrou: _weight("mehlum_tarrou")
    weight_mean_curvature: _weight("mean_curvature")
    weight_area: _weight("area")
    strength: bpy.props.FloatProperty(
        name="Strength", description="How much of the shape may go, from a touch to the global minimum. Small bumps go "
        "first, then larger features; what is longer than the length below the slider stays, and nothing moves farther than "
        "a fifth of that. 0.3 takes bumps away and "
        "keeps features. 1 forgets the original and finds the surface of least energy, a ball for a closed shape "
        "without holes", default=_STRENGTH, min=0.01, max=1.0, subtype="FACTOR",
    )
    within: bpy.props.FloatProperty(
        name="Within", description="No vertex and no point of the surface gets farther than this from where it was; 0 sets no "
        "limit. At strength 1 the result is the fairest surface within the distance",
        default=DEFAULTS.within, min=0.0, precision=3, subtype="DISTANCE",
    )
    keep_volume: bpy.props.BoolProperty(
        name="Keep Volume", description="The result has the volume of the original: it does not shrink. An open surface keeps "
        "the volume between it and its boundary, which must stay. Where nothing else holds the shape, at strength 1 "
        "without pins, this only sets the size of the result", default=False,
    )
    no_crossings: bpy.props.BoolProperty(
        name="No Crossings", description="The surface comes to cross itself nowhere: parts of it that come close repel each "
        "other. For knots, fingers and other shapes that would pass through themselves. What crosses in the original may "
        "go on crossing. Takes several times as long", default=DEFAULTS.no_crossings,
    )
    resolution: bpy.props.EnumProperty(
        name="Resolution", description="Whether the result has more vertices than the cage", items=RESOLUTIONS,
        default=_RESOLUTION,
    )
    levels: bpy.props.IntProperty(
        name="Levels", description="Number of optimizations. The cage is subdivided before each but the first, so "
        "each level has four times the faces of the one before", default=DEFAULTS.levels, min=1, max=12, soft_max=6,
    )
    boundary: bpy.props.EnumProperty(
        name="Boundary", description="What an open surface keeps at its boundary. Edges of Mark Rim, in Edit Mode, say it "
        "for themselves", items=BOUNDARIES, default=DEFAULTS.boundary.upper(),
    )
    slide: bpy.props.BoolProperty(
        name="Slide", description="Vertices on a boundary or an infinitely sharp crease that Boundary keeps move along "
        "it; its curve and its corners stay. For a boundary with bunched vertices that spoil the surface beside them. "
        "Little slides at a strength below 1", default=DEFAULTS.slide,
    )
    rim: bpy.props.EnumProperty(
        name="Rim", description="In Edit Mode: what stays at the rim, between selected faces and others. Mark Rim sets "
        "it for single edges", items=RIMS, default="FREE",
    )
    symmetry: bpy.props.EnumProperty(
        name="Symmetry", description="Which symmetries of the cage the result keeps", items=SYMMETRIES,
        default=DEFAULTS.symmetry.upper(),
    )
    symmetry_planes: bpy.props.BoolVectorProperty(
        name="Mirror", description="Axes of the object across which reflections are kept. The planes go through "
        "the middle of the cage, wherever the object's origin is", size=3, subtype="XYZ",
        default=(True, False, False),
    )
    pin: bpy.props.EnumProperty(
        name="Pin", description="Vertices of the cage that stay where they are, in a finer result as well. The surface "
        "comes closer to them with every level; it stays itself where all vertices of a face and of all faces that touch "
        "it are pinned",
        items=PINS, default="NOTHING",
    )
    pin_surface: bpy.props.BoolProperty(
        name="On Surface", description="Pin the points of the surface that belong to the vertices, and let the vertices "
        "move as that needs: the surface goes through the same points. A weight below 1 pulls the vertex itself",
        default=False,
    )
    vertex_group: bpy.props.StringProperty(
        name="Vertex Group", description="The vertex group whose weights pin vertices: 1 is exact, 0 is free, and "
        "between them a spring pulls the vertex back, whatever the size, the levels and the number of vertices",
    )
    through: bpy.props.StringProperty(
        name="Go Through", description="A collection: the surface goes through its empties, the vertices of its "
        "meshes, and points along its curves, one and a half edges apart. Of the surface, the points that are "
        "nearest to them go there. If a curve has the name of a vertex group, the chain of edges of that group follows the curve. "
        "Needs a Strength of 1; does not count in Edit Mode and Live",
    )
    through_normals: bpy.props.BoolProperty(
        name="Normals", description="The surface is perpendicular to the Z axes of the empties, and to the vectors that "
        "meshes have in an attribute curvopt_normal of their vertices", default=False,
    )
    through_balls: bpy.props.BoolProperty(
        name="Curvatures", description="Empties that are shown as spheres are balls: the surface touches each at the tip of "
        "its Z axis, and is curved there like the ball, or the ellipsoid if its scale is uneven. Point the Z axis out of "
        "the shape, or into it for a hollow", default=False,
    )
    through_weight: bpy.props.FloatProperty(
        name="Weight", description="How firmly the surface goes through them. 1: exactly; less: springs draw it there, and it stays "
        "fairer. For places that were measured, or drawn by hand, and for curves that cross without meeting", default=1.0,
        min=0.01, max=1.0, subtype="FACTOR",
    )
    outcome: bpy.props.EnumProperty(
        name="Result", description="Where the result goes", items=OUTCOMES, default="NEW"
    )
    animation: bpy.props.BoolProperty(
        name="Animation", description="Keeps the way from the original to the result as shape keys of the result with "
        "keyframes: play the timeline to see the run. 25 states at most, equally far from each other. Not with Shape Key as "
        "the result", default=False,
    )
    surface: bpy.props.EnumProperty(
        name="Surface", description="The surface whose energy is minimized, at extraordinary vertices and n-gons",
        items=SURFACES, default=DEFAULTS.surface.upper(),
    )
    spontaneous_curvature: bpy.props.FloatProperty(
        name="Spontaneous Curvature", description="Of Willmore and Mean Curvature, for membranes (Helfrich): the sum of the "
        "principal curvatures at which the surface has no bending energy, in 1 / units. A sphere of radius R has 2 / R. A closed "
        "result keeps the original's area; with Keep Volume it is a vesicle", default=DEFAULTS.spontaneous_curvature,
        soft_min=-10.0, soft_max=10.0, precision=3,
    )
    max_iterations: bpy.props.IntProperty(
        name="Iterations", description="Largest number of steps of a level", default=DEFAULTS.max_iterations, min=1,
        max=100_000, soft_max=5000,
    )
    escape: bpy.props.BoolProperty(
        name="Leave Saddles", description="Where the result is a saddle among shapes of less symmetry, go on to a "
        "lower energy. Takes longer", default=DEFAULTS.escape,
    )
    threads: bpy.props.IntProperty(
        name="Threads", description="Number of processor cores to use; 0 means all", default=DEFAULTS.threads,
        min=0, max=256, soft_max=16,
    )
    # fmt: on


SETTINGS = tuple(RunSettings.__annotations__)


class CURVOPT_PG_settings(RunSettings, bpy.types.PropertyGroup):
    """Settings of the next run."""


def with_other(request: Request, strength: float, slide: bool, keeps_volume: bool) -> Request:
    """The same request with another strength, with or without Slide and Keep Volume."""
    options = {**request.options, "slide": int(slide)}
    return replace(request, strength=strength, options=options, keeps_volume=keeps_volume)


def other_name(request: Request, strength: float, slide: bool, keeps_volume: bool) -> str:
    """What `with_other` changes, for people; empty for nothing."""
    if strength != request.strength:
        return f"Strength {strength:.3g}"
    if slide != bool(request.options.get("slide")):
        return "Slide"
    return "Keep Volume" if keeps_volume != request.keeps_volume else ""


class AdjustSettings:
    """The controls of a finished run in the adjust panel, whatever mode it was in; `number` says of which run."""

    # fmt: off
    number: bpy.props.IntProperty(options={"HIDDEN", "SKIP_SAVE"})
    strength: bpy.props.FloatProperty(
        name="Strength", description="How much of the shape may go, from a touch to the global minimum: runs again",
        min=0.01, max=1.0, default=1.0, subtype="FACTOR", options={"SKIP_SAVE"},
    )
    slide: bpy.props.BoolProperty(
        name="Slide", description="Vertices on a boundary or an infinitely sharp crease that Boundary keeps move along "
        "it: runs again", default=False, options={"SKIP_SAVE"},
    )
    keep_volume: bpy.props.BoolProperty(
        name="Keep Volume", description="The result has the volume of the original: runs again", default=False,
        options={"SKIP_SAVE"},
    )
    amount: bpy.props.FloatProperty(
        name="Amount", description="0 is the surface of the original, 1 the result", min=0.0, max=1.0, default=1.0,
        subtype="FACTOR", options={"SKIP_SAVE"},
    )
    # fmt: on


def energy_text_of(values: Mapping[str, object]) -> str:
    """The chosen energy as energy.py writes it. ValueError for an empty mix."""
    if values["energy"] != "MIX":
        return str(values["energy"]).lower()
    return text_of({term: float(values[f"weight_{term}"]) for term in WEIGHT_TERMS})


def symmetry_text_of(values: Mapping[str, object]) -> str:
    """The chosen symmetry as job.py reads it. ValueError for planes without one."""
    if values["symmetry"] != "PLANES":
        return str(values["symmetry"]).lower()
    planes = ",".join(axis for axis, chosen in zip("xyz", values["symmetry_planes"]) if chosen)
    if not planes:
        raise ValueError("No mirror plane is chosen: choose X, Y or Z, or another Symmetry.")
    return planes


def request_of(values: Mapping[str, object], held: Held) -> Request:
    """The request of settings by name. ValueError as above."""
    options = {
        "surface": abi.SURFACES.index(values["surface"].lower()),
        "max_iterations": values["max_iterations"],
        "threads": values["threads"],
        "escape": int(values["escape"]),
        "slide": int(values["slide"]),
        "no_crossings": int(values["no_crossings"]),
        "spontaneous_curvature": strength_of(values["spontaneous_curvature"]),
    }
    levels = 1 if values["resolution"] == "SAME" else values["levels"]
    energy, symmetry, strength = energy_text_of(values), symmetry_text_of(values), strength_of(values["strength"])
    boundary, keeps_volume = values["boundary"].lower(), bool(values["keep_volume"])
    return Request(
        energy, levels, options, boundary, symmetry, held, strength, keeps_volume=keeps_volume,
        within=strength_of(values["within"]), records=bool(values["animation"]),
    )  # fmt: skip


def strength_of(value: float) -> float:
    """A slider's value, to six digits; Blender stores float32."""
    return float(f"{value:.6g}")


@dataclass
class State:
    """What the sidebar reports. `running` is true from the start of a modal run to its end. `live` is ON while a surface
    follows its handles, and ENDED from where it could not go on until they are taken away. `is_undone` is there if the
    message reports a result, and says whether that has been undone or deleted since. A message that `failed` is about the
    object that was active, of the name `about`, "" for none; `is_checked` if it is what check_object said of that object."""

    message: str = ""
    about: str = ""
    is_checked: bool = False
    is_undone: Callable[[], bool] | None = None
    running: bool = False
    failed: bool = False
    live: str = ""


state = State()


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    """Another file: what was said is about the last one."""
    state.message, state.failed, state.is_undone = "", False, None


def register() -> None:
    """Comes first of all. RuntimeError, with what to do, if another Curvopt is on, such as an add-on beside the extension: both
    have the same names, and Blender would take from the other what belongs to it, also while it runs."""
    panel = getattr(bpy.types, "CURVOPT_PT_minimize", None)
    other = __package__ if panel is None else panel.__module__.rpartition(".")[0]
    if other != __package__:
        raise RuntimeError(
            f"Another Curvopt is switched on already: {other.removesuffix('.ui')}. Remove one of the two in Edit > Preferences > "
            "Add-ons, and tick the other."
        )
    bpy.utils.register_class(CURVOPT_PG_settings)
    bpy.types.Scene.curvopt = bpy.props.PointerProperty(type=CURVOPT_PG_settings)
    bpy.app.handlers.load_pre.append(_forget)  # before that of live.py, which says that Live has ended


def unregister() -> None:
    bpy.app.handlers.load_pre.remove(_forget)
    del bpy.types.Scene.curvopt
    bpy.utils.unregister_class(CURVOPT_PG_settings)
