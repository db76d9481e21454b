# SPDX-License-Identifier: GPL-3.0-or-later
"""curvopt.h as Python sees it: versions, names of enumerations, struct mirrors, one table of signatures. No bpy."""

import ctypes as C
from typing import NamedTuple

HEADER_VERSION = (0, 1)  # CURVOPT_VERSION_MAJOR, _MINOR of the curvopt.h that this file mirrors

TERMS = ("willmore", "mvs", "mvs_cross", "variation", "mehlum_tarrou", "area", "mean_curvature")  # by curvopt_term
SURFACES = ("auto", "limit", "plane", "polynomial")  # by curvopt_surface
STOPS = ("converged", "stalled", "limit", "cancelled", "unresolved", "settled", "grown")  # by curvopt_stop
VERDICTS = ("unknown", "minimum", "saddle", "not stationary")  # by curvopt_verdict
STATUSES = (  # by curvopt_status
    "ok", "argument", "memory", "size", "topology", "geometry", "surface", "unsupported", "resolution", "cancelled",
)  # fmt: skip
BOUNDARIES = ("position", "tangent", "curvature", "free")  # by curvopt_boundary
SYMMETRIES = ("auto", "none", "rotations", "keep", "planes")  # by curvopt_symmetry
SCALARS = ("volume", "area", "total_mean_curvature")  # by curvopt_scalar: numbers of a whole surface
SCALAR_RULES = ("free", "keep", "value", "reduced")  # by curvopt_scalar_rule
BOUNDARY_RULES = ("smooth", "corners")  # by curvopt_boundary_rule
EXCEPTIONS = (  # by curvopt_exception: why vertices are held and faces left out of the energy
    "isolated", "crowded_edge", "flipped", "pinched", "cone", "corner", "degenerate", "beside", "hole",
)  # fmt: skip
SHARPNESS_INFINITE = 10.0
SHAPE_ERRORS = tuple(map(STATUSES.index, ("geometry", "resolution")))  # coordinates without a surface

MAX_TERMS = 8  # CURVOPT_MAX_TERMS
MAX_SCALARS = 6  # CURVOPT_MAX_SCALARS

# Enumerations of the header. The names above are wanted before there is a library; it is asked once it is loaded.
ENUMS = (
    "status boundary_rule surface term method boundary spacing symmetry plane scalar scalar_rule exception"
    " step stop verdict"
).split()
NAMES = {
    "curvopt_status_name": STATUSES,
    "curvopt_term_name": TERMS,
    "curvopt_surface_name": SURFACES,
    "curvopt_stop_text": STOPS,
    "curvopt_verdict_text": VERDICTS,
    "curvopt_boundary_name": BOUNDARIES,
    "curvopt_symmetry_name": SYMMETRIES,
    "curvopt_scalar_name": SCALARS,
    "curvopt_scalar_rule_name": SCALAR_RULES,
    "curvopt_boundary_rule_name": BOUNDARY_RULES,
    "curvopt_exception_name": EXCEPTIONS,
}


class Defaults(NamedTuple):
    """What curvopt_options_init() sets, for those who must show it before a library is loaded. A test compares them."""

    energy: str = "willmore"
    surface: str = "auto"
    levels: int = 4
    max_iterations: int = 10000
    threads: int = 0
    boundary: str = "position"
    symmetry: str = "auto"
    escape: bool = False
    strength: float = 1.0
    within: float = 0.0
    spontaneous_curvature: float = 0.0
    slide: bool = False
    no_crossings: bool = False


DEFAULTS = Defaults()

# ---------------------------------------------------------------------------------------------- mirrored structs --


class CError(C.Structure):
    """curvopt_error"""

    _fields_ = [("code", C.c_int32), ("element", C.c_int32), ("message", C.c_char * 248)]


class CMeshInfo(C.Structure):
    """curvopt_mesh_info"""

    _fields_ = [
        (name, C.c_int32)
        for name in (
            "n_vertices n_edges n_faces n_corners n_components n_boundary_edges n_extraordinary max_valence"
            " euler all_quads n_isolated n_flawed_edges"
        ).split()
    ]


class CCreases(C.Structure):
    """curvopt_creases"""

    _fields_ = [
        ("crease_vertices", C.POINTER(C.c_int32)),
        ("crease_sharpness", C.POINTER(C.c_double)),
        ("corner_vertices", C.POINTER(C.c_int32)),
        ("corner_sharpness", C.POINTER(C.c_double)),
        *((name, C.c_int32) for name in "n_creases n_corners boundary_rule reserved".split()),
    ]


FREEDOM_OF_LIMIT_POINT = 4  # CURVOPT_FREEDOM_OF_LIMIT_POINT


class CConstraints(C.Structure):
    """curvopt_constraints"""

    _fields_ = [
        ("vertices", C.POINTER(C.c_int32)),
        ("freedom", C.POINTER(C.c_int32)),
        ("directions", C.POINTER(C.c_double)),
        ("n", C.c_int32),
        ("has_places", C.c_int32),
        ("weights", C.POINTER(C.c_double)),
        ("places", C.POINTER(C.c_double)),
    ]


class CChain(C.Structure):
    """curvopt_chain"""

    _fields_ = [
        ("vertices", C.POINTER(C.c_int32)),
        *((name, C.POINTER(C.c_double)) for name in "curve parameters".split()),
        *((name, C.c_int32) for name in "n_vertices n_points is_closed is_curve_closed".split()),
    ]


class CThrough(C.Structure):
    """curvopt_through"""

    _fields_ = [
        *((name, C.c_int32) for name in "struct_size n".split()),
        *((name, C.POINTER(C.c_int32)) for name in "vertices faces corners".split()),
        ("uv", C.POINTER(C.c_double)),
        ("freedom", C.POINTER(C.c_int32)),
        *((name, C.POINTER(C.c_double)) for name in "directions places normals tangents".split()),
        ("toward", C.POINTER(C.c_int32)),
        ("weights", C.POINTER(C.c_double)),
        ("chains", C.POINTER(CChain)),
        *((name, C.c_int32) for name in "n_chains reserved".split()),
        *((name, C.POINTER(C.c_double)) for name in "chain_weights curvatures curvature_directions".split()),
    ]


class COptions(C.Structure):
    """curvopt_options"""

    _fields_ = [
        *(
            (name, C.c_int32)
            for name in "struct_size surface method levels max_iterations threads joshi_sequin boundary".split()
        ),
        ("weights", C.c_double * MAX_TERMS),
        ("tolerance", C.c_double),
        ("gradient_tolerance", C.c_double),
        ("decrement_tolerance", C.c_double),
        ("max_step", C.c_double),
        ("constraints", C.POINTER(CConstraints)),
        ("symmetry", C.c_int32),
        ("verify", C.c_int32),
        ("escape", C.c_int32),
        ("symmetry_planes", C.c_int32),
        ("blend_width", C.c_int32),
        ("spacing", C.c_int32),
        ("strength", C.c_double),
        ("holes", C.POINTER(C.c_int32)),
        ("n_holes", C.c_int32),
        ("strict", C.c_int32),
        ("slide", C.c_int32),
        ("scalar_rule", C.c_int32 * MAX_SCALARS),
        ("scalar_value", C.c_double * MAX_SCALARS),
        ("within", C.c_double),
        ("spontaneous_curvature", C.c_double),
        ("through", C.POINTER(CThrough)),
        ("no_crossings", C.c_int32),
        ("reserved", C.c_int32),
    ]


# Fields of curvopt_options that are set by name, and their types.
OPTION_KINDS = {
    name: kind for name, kind in COptions._fields_
    if kind in (C.c_int32, C.c_double) and name not in ("struct_size", "n_holes", "reserved")
}  # fmt: skip


class CEnergies(C.Structure):
    """curvopt_energies"""

    _fields_ = [
        ("objective", C.c_double),
        ("area", C.c_double),
        ("term", C.c_double * MAX_TERMS),
        ("h2", C.c_double),
        ("gauss", C.c_double),
        ("gauss_bonnet_defect", C.c_double),
        ("objective_error", C.c_double),
        ("area_error", C.c_double),
        ("term_error", C.c_double * MAX_TERMS),
        ("min_jacobian", C.c_double),
        ("surface", C.c_int32),
        ("n_samples", C.c_int32),
        ("volume", C.c_double),
        ("total_mean_curvature", C.c_double),
        ("helfrich", C.c_double),
    ]


class CProgress(C.Structure):
    """curvopt_progress"""

    _fields_ = [
        *((name, C.c_int32) for name in "struct_size level levels iteration evaluations n_vertices".split()),
        *((name, C.c_int32) for name in "samples method rejected reserved".split()),
        ("xyz", C.POINTER(C.c_double)),
        ("mesh", C.c_void_p),
        *((name, C.c_double) for name in "energy start_energy gradient_norm seconds".split()),
        *((name, C.c_double) for name in "predicted shift gain_ratio step".split()),
    ]


class CLevelReport(C.Structure):
    """curvopt_level_report"""

    _fields_ = [
        *((name, C.c_double) for name in "energy gradient_norm seconds".split()),
        *((name, C.c_int32) for name in "level n_vertices iterations evaluations stop reserved".split()),
    ]


class CSummary(C.Structure):
    """curvopt_summary"""

    _fields_ = [
        *((name, C.c_double) for name in "seconds newton_decrement shape_decrement".split()),
        *((name, C.c_int32) for name in "n_levels stop n_vertices n_faces method verdict".split()),
        *((name, C.c_int32) for name in "negative_directions symmetry_order".split()),
        ("difference_decrement", C.c_double),
        *((name, C.c_int32) for name in "all_negative_directions free_negative_directions n_held n_left_out".split()),
        ("curve_deviation", C.c_double),
        *((name, C.c_int32) for name in "n_sliding n_folded".split()),
        ("multiplier", C.c_double * MAX_SCALARS),
        ("scalar_residual", C.c_double * MAX_SCALARS),
        ("discretization_error", C.c_double),
        ("clearance", C.c_double),
        *((name, C.c_int32) for name in "n_touching n_crossing_before n_refused n_unfolded".split()),
        *((name, C.c_double) for name in "spring_energy touch_rise".split()),
        *((name, C.c_int32) for name in "is_delicate reserved".split()),
    ]


class CDeviation(C.Structure):
    """curvopt_deviation"""

    _fields_ = [
        *((name, C.c_double) for name in "max rms bound size".split()),
        ("point", C.c_double * 3), ("other_point", C.c_double * 3),
    ]  # fmt: skip


class CCrossings(C.Structure):
    """curvopt_crossings"""

    _fields_ = [(name, C.c_int32) for name in "n_pairs n_contacts n_unresolved n_listed is_complete reserved".split()]


# Bytes of each struct in every build of the library; COptions is compared with the library's own size as well.
STRUCT_SIZES = {
    CError: 256,
    CMeshInfo: 48,
    CCreases: 48,
    CConstraints: 48,
    CChain: 40,
    CThrough: 136,
    COptions: 296,
    CEnergies: 224,
    CProgress: 120,
    CLevelReport: 48,
    CSummary: 248,
    CDeviation: 80,
    CCrossings: 24,
}

# ------------------------------------------------------------------------------------------------ signature table --

PROGRESS_FN = C.CFUNCTYPE(C.c_int32, C.POINTER(CProgress), C.c_void_p)

_I = C.c_int32
INTS = C.POINTER(C.c_int32)
REALS = C.POINTER(C.c_double)
_HANDLE = C.c_void_p
_OUT = C.POINTER(C.c_void_p)
_ERROR = C.POINTER(CError)
_SIZE = C.c_size_t

# name: (result, arguments). Functions whose last argument is an error are called through Library.call().
SIGNATURES = {
    "curvopt_status_text": (C.c_char_p, (_I,)),
    "curvopt_exception_text": (C.c_char_p, (_I,)),
    "curvopt_version": (C.c_char_p, ()),
    **{f"curvopt_{enum}_name": (C.c_char_p, (_I,)) for enum in ENUMS},
    **{f"curvopt_{enum}_from_name": (_I, (C.c_char_p,)) for enum in ENUMS},
    "curvopt_mesh_create": (_I, (_I, _I, INTS, INTS, _OUT, _ERROR)),
    "curvopt_mesh_create_creased": (_I, (_I, _I, INTS, INTS, C.POINTER(CCreases), _OUT, _ERROR)),
    "curvopt_mesh_destroy": (None, (_HANDLE,)),
    "curvopt_mesh_get_info": (None, (_HANDLE, C.POINTER(CMeshInfo), _SIZE)),
    "curvopt_mesh_get_faces": (None, (_HANDLE, INTS, INTS)),
    "curvopt_mesh_count_creases": (None, (_HANDLE, INTS, INTS)),
    "curvopt_mesh_get_creases": (None, (_HANDLE, INTS, REALS, INTS, REALS)),
    "curvopt_mesh_refine": (_I, (_HANDLE, REALS, _OUT, REALS, _ERROR)),
    "curvopt_mesh_find_exceptions": (_I, (_HANDLE, REALS, C.POINTER(COptions), INTS, INTS, _ERROR)),
    "curvopt_options_init": (None, (C.POINTER(COptions), _SIZE)),
    "curvopt_options_validate": (_I, (C.POINTER(COptions), _ERROR)),
    "curvopt_problem_create": (_I, (_HANDLE, REALS, C.POINTER(COptions), _OUT, _ERROR)),
    "curvopt_problem_create_interruptible": (
        _I, (_HANDLE, REALS, C.POINTER(COptions), PROGRESS_FN, _HANDLE, _HANDLE, _OUT, _ERROR)
    ),
    "curvopt_problem_destroy": (None, (_HANDLE,)),
    "curvopt_problem_evaluate": (_I, (_HANDLE, REALS, C.POINTER(CEnergies), _SIZE, REALS, _ERROR)),
    "curvopt_problem_evaluate_interruptible": (
        _I, (_HANDLE, REALS, PROGRESS_FN, _HANDLE, _HANDLE, C.POINTER(CEnergies), _SIZE, REALS, _ERROR)
    ),
    "curvopt_sampler_create": (_I, (_HANDLE, REALS, C.POINTER(COptions), _OUT, _ERROR)),
    "curvopt_sampler_destroy": (None, (_HANDLE,)),
    "curvopt_sampler_jets": (_I, (_HANDLE, _I, INTS, INTS, REALS, REALS, _ERROR)),
    "curvopt_measure_deviation": (
        _I, (_HANDLE, REALS, _HANDLE, REALS, _I, _HANDLE, C.POINTER(CDeviation), _SIZE, REALS, _ERROR)
    ),
    "curvopt_find_crossings": (_I, (_HANDLE, REALS, _I, _HANDLE, _I, INTS, C.POINTER(CCrossings), _SIZE, _ERROR)),
    "curvopt_find_folds": (_I, (_HANDLE, REALS, C.POINTER(COptions), _HANDLE, INTS, INTS, _ERROR)),
    "curvopt_stop_text": (C.c_char_p, (_I,)),
    "curvopt_verdict_text": (C.c_char_p, (_I,)),
    "curvopt_cancel_create": (_I, (_OUT, _ERROR)),
    "curvopt_cancel_request": (None, (_HANDLE,)),
    "curvopt_cancel_destroy": (None, (_HANDLE,)),
    "curvopt_find_moving_level": (_I, (_HANDLE, REALS, C.POINTER(COptions), INTS, _ERROR)),
    "curvopt_minimize": (_I, (_HANDLE, REALS, C.POINTER(COptions), PROGRESS_FN, _HANDLE, _HANDLE, _OUT, _ERROR)),
    "curvopt_solver_create": (_I, (_HANDLE, REALS, C.POINTER(COptions), _OUT, _ERROR)),
    "curvopt_solver_destroy": (None, (_HANDLE,)),
    "curvopt_solver_set_places": (_I, (_HANDLE, REALS, _ERROR)),
    "curvopt_solver_set_options": (_I, (_HANDLE, C.POINTER(COptions), _ERROR)),
    "curvopt_solver_set_positions": (_I, (_HANDLE, REALS, _ERROR)),
    "curvopt_solver_solve": (_I, (_HANDLE, _I, PROGRESS_FN, _HANDLE, _HANDLE, _ERROR)),
    "curvopt_solver_get_positions": (None, (_HANDLE, REALS)),
    "curvopt_solver_get_summary": (None, (_HANDLE, C.POINTER(CSummary), _SIZE)),
    "curvopt_solver_get_energies": (None, (_HANDLE, C.POINTER(CEnergies), C.POINTER(CEnergies), _SIZE)),
    "curvopt_solver_get_report": (None, (_HANDLE, C.POINTER(CLevelReport), _SIZE)),
    "curvopt_result_destroy": (None, (_HANDLE,)),
    "curvopt_result_mesh": (_HANDLE, (_HANDLE,)),
    "curvopt_result_get_positions": (None, (_HANDLE, REALS)),
    "curvopt_result_get_summary": (None, (_HANDLE, C.POINTER(CSummary), _SIZE)),
    "curvopt_result_get_touching": (None, (_HANDLE, INTS)),
    "curvopt_result_get_energies": (None, (_HANDLE, C.POINTER(CEnergies), C.POINTER(CEnergies), _SIZE)),
    "curvopt_result_get_level": (_I, (_HANDLE, _I, C.POINTER(CLevelReport), _SIZE, _ERROR)),
}
