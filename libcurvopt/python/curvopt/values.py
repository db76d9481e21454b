# SPDX-License-Identifier: GPL-3.0-or-later
"""What goes into the library and what comes out of it, as plain values without pointers or handles. No bpy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from .abi import SURFACES, TERMS, CEnergies, CProgress


def _no_indices() -> np.ndarray:
    return np.empty(0, np.int32)


def _no_reals() -> np.ndarray:
    return np.empty(0)


def rms_radius(points: np.ndarray) -> float:
    """Root mean square distance of points (n, 3) from their mean: what the library takes for the size of a cage."""
    return float(np.linalg.norm(points - points.mean(axis=0)) / np.sqrt(len(points)))


@dataclass(frozen=True)
class Creases:
    """curvopt_creases: sharp edges as pairs of vertices (k, 2), their sharpness (k,), sharp vertices (c,), theirs (c,);
    `rule`, of abi.BOUNDARY_RULES, says what becomes of boundary vertices that belong to one face."""

    edges: np.ndarray = field(default_factory=lambda: _no_indices().reshape(0, 2))
    edge_sharpness: np.ndarray = field(default_factory=_no_reals)
    vertices: np.ndarray = field(default_factory=_no_indices)
    vertex_sharpness: np.ndarray = field(default_factory=_no_reals)
    rule: str = "smooth"


@dataclass(frozen=True)
class Cage:
    """Polygons as arrays: positions (n, 3) float64, face_sizes (m,) and face_vertices (sum of sizes,) int32."""

    positions: np.ndarray
    face_sizes: np.ndarray
    face_vertices: np.ndarray
    creases: Creases = field(default_factory=Creases)


@dataclass(frozen=True)
class Held:
    """Vertices (k,) of a cage that may not move freely, and how firmly each is held (k,), 0 .. 1; 1: exactly.
    `limit_points`, of all or (k,): of exact ones the point of the limit surface is held, and the vertex moves as that
    needs. `places` (k, 3): where it is held; None, or NAN in its three numbers: where it is."""

    vertices: np.ndarray = field(default_factory=_no_indices)
    weights: np.ndarray = field(default_factory=_no_reals)
    limit_points: bool | np.ndarray = False
    places: np.ndarray | None = None

    @classmethod
    def exactly(cls, vertices: object) -> Held:
        """Vertices that may not move at all."""
        vertices = np.asarray(vertices)
        return cls(vertices, np.ones(vertices.size))


@dataclass(frozen=True)
class Energies:
    """curvopt_energies; `terms` and `term_errors` by name, NAN where the surface cannot give one: none depends on size, so
    `terms["area"]` is the area over the mean squared distance of the cage's vertices from their middle. `area` itself in units^2; volume
    in units^3, NAN where there is a boundary or faces are left out; total mean curvature, int H dA, in units, positive on a ball (4 pi R);
    `helfrich`, int (k1 + k2 - c0)^2 dA with the spontaneous curvature c0."""

    objective: float
    area: float
    terms: Mapping[str, float]
    h2: float
    gauss: float
    gauss_bonnet_defect: float
    objective_error: float
    term_errors: Mapping[str, float]
    min_jacobian: float
    surface: str
    n_samples: int
    volume: float
    total_mean_curvature: float
    helfrich: float

    @property
    def reduced_volume(self) -> float:
        """The volume as a part of that of the sphere with the same area; NAN without a volume."""
        return 6 * math.sqrt(math.pi) * self.volume / self.area**1.5

    @classmethod
    def from_c(cls, raw: CEnergies) -> Energies:
        """A copy of the struct."""
        same = (
            "objective area h2 gauss gauss_bonnet_defect objective_error min_jacobian n_samples volume total_mean_curvature "
            "helfrich"
        ).split()
        return cls(
            terms=dict(zip(TERMS, raw.term)),
            term_errors=dict(zip(TERMS, raw.term_error)),
            surface=SURFACES[raw.surface],
            **{name: getattr(raw, name) for name in same},
        )


@dataclass(frozen=True)
class Progress:
    """curvopt_progress without its pointers: `gradient_norm` is dimensionless, `seconds` since the start."""

    energy: float
    start_energy: float
    gradient_norm: float
    seconds: float
    level: int
    levels: int
    iteration: int
    evaluations: int
    n_vertices: int

    @classmethod
    def from_c(cls, raw: CProgress) -> Progress:
        """A copy of the struct's numbers."""
        return cls(**{name: getattr(raw, name) for name in cls.__dataclass_fields__})


@dataclass(frozen=True)
class LevelReport:
    """curvopt_level_report; `stop` as text."""

    level: int
    n_vertices: int
    iterations: int
    evaluations: int
    energy: float
    gradient_norm: float
    seconds: float
    stop: str


@dataclass(frozen=True)
class Exceptions:
    """What a run held and left out of the energy: vertices of the cage (k,) by the reason, the library's text, in
    the library's order; the number of vertices that were held, with those that only lie beside these; and the number
    of faces. Holes that were asked for do not count."""

    reasons: tuple[tuple[str, np.ndarray], ...] = ()
    n_held: int = 0
    n_left_out: int = 0


@dataclass(frozen=True)
class Verification:
    """What the Hessian says of a result: the verdict, of abi.VERDICTS; the Newton decrement, NAN if unknown; the
    number of negative directions, -1 if there are some but not counted, or if nothing is known. `touch_rise`: how much
    objective and springs rise in the mean where each vertex is moved by a thousandth of a mean edge in a random
    direction, NAN if unknown; `is_delicate`: a minimum of which that is more than 2e-3, so that, minimized again
    after such a touch, it may end elsewhere."""

    verdict: str
    newton_decrement: float
    negative_directions: int
    touch_rise: float = math.nan
    is_delicate: bool = False


@dataclass(frozen=True)
class Summary:
    """curvopt_summary; `stop` and the verdict as text; `symmetry_order` 1 means none; the negative directions are -1
    without options.verify; `n_sliding` vertices of the input cage may slide. By the names of abi.SCALARS: `multipliers`, how
    much the least objective rises for each unit by which what is held does; `scalar_residuals`, relative distances of what is
    held from what it is to be. Both are 0 where nothing is held. `discretization_error`: how far the energy may be above that
    of finer nets, by what the last levels brought; NAN if unknown, as after one level. `spring_energy`: what springs (weights
    below 1, a strength below 1) add to the objective; in no reported energy.

    With options.no_crossings: `touching`, pairs of faces (f, g) of the input cage by which the result is held; `clearance`,
    their least distance, NAN if there are none or without the option; `n_crossing_before` pairs of faces of the input cross, and still may;
    `n_refused` steps were shortened because of a crossing.

    `n_folded` faces of the input cage were folded, where that was looked for (curvopt.folds); `n_unfolded` of its vertices
    were put between their neighbours before the run began."""

    start: Energies
    end: Energies
    seconds: float
    stop: str
    verification: Verification
    n_levels: int
    n_vertices: int
    n_faces: int
    symmetry_order: int
    free_negative_directions: int
    all_negative_directions: int
    n_sliding: int
    multipliers: Mapping[str, float]
    scalar_residuals: Mapping[str, float]
    discretization_error: float
    clearance: float = math.nan
    touching: tuple[tuple[int, int], ...] = ()
    n_crossing_before: int = 0
    n_refused: int = 0
    spring_energy: float = 0.0
    n_folded: int = 0
    n_unfolded: int = 0
