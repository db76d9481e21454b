# SPDX-License-Identifier: GPL-3.0-or-later
"""What goes into the library and what comes out of it, as plain values without pointers or handles. No bpy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .header import SURFACES, TERMS, CEnergies, CProgress


@dataclass(frozen=True)
class Cage:
    """Polygons as arrays: positions (n, 3) float64, face_sizes (m,) and face_vertices (sum of sizes,) int32."""

    positions: np.ndarray
    face_sizes: np.ndarray
    face_vertices: np.ndarray


@dataclass(frozen=True)
class Energies:
    """curvopt_energies; `terms` and `term_errors` by name, NAN where the surface cannot give one. Area in units^2."""

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

    @classmethod
    def from_c(cls, raw: CEnergies) -> Energies:
        same = "objective area h2 gauss gauss_bonnet_defect objective_error min_jacobian n_samples".split()
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
class Summary:
    """curvopt_summary; `stop` as text."""

    start: Energies
    end: Energies
    seconds: float
    stop: str
    n_levels: int
    n_vertices: int
    n_faces: int
