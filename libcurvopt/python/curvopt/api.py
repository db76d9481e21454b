# SPDX-License-Identifier: GPL-3.0-or-later
"""The public side: cages in, energies, minimizers and points of the surface out, as numpy arrays.

Arrays that go in are read and never kept; arrays that come out are the caller's own copies. Lengths are in units of the
cage; energies are dimensionless and do not change with scale, unless their description says otherwise (`curvopt.h`, "Terms").
"""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real

import numpy as np

from .abi import BOUNDARIES, DEFAULTS, OPTION_KINDS, SURFACES, SYMMETRIES, TERMS, COptions
from .library import Cancel as _Cancel
from .library import Mesh as _Mesh
from .library import Problem as _Problem
from .library import Sampler as _Sampler
from .library import Library, indices, load, option_value, reals
from .library import minimize as _minimize
from .measure import Crossings, Deviation
from .measure import crossings as _crossings
from .measure import deviation as _deviation
from .measure import folds as _folds
from .through import Chain, Through
from .values import Cage, Creases, Energies, Exceptions, Held, LevelReport, Progress, Summary

Energy = "str | Mapping[str, float]"


def cage(positions: object, faces: Sequence[Sequence[int]], creases: Creases | None = None) -> Cage:
    """A control cage: positions (n, 3), or a grid of them (..., 3); faces as lists of vertex numbers, counter-clockwise seen from outside.

    ValueError for arrays of other shapes and for vertex numbers that are not whole. Whether they make a surface is found out
    when the cage is used."""
    try:
        points = np.array(positions, float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"positions must be (n, 3) numbers: {error}.") from None
    if points.ndim < 2 or points.shape[-1] != 3:
        raise ValueError(f"positions have the shape {points.shape}; it must be (n, 3).")
    try:
        rows = [list(face) for face in faces]
    except TypeError:
        raise ValueError("faces must be lists of vertex numbers, one list for each face.") from None
    numbers = np.asarray([vertex for row in rows for vertex in row])
    if numbers.dtype.kind == "f" and (numbers == np.floor(numbers)).all():  # as files of numbers give them
        numbers = numbers.astype(np.int64)
    vertices = indices(numbers, "vertex numbers of faces")
    return Cage(points.reshape(-1, 3), np.array([len(row) for row in rows], np.int32), vertices, creases or Creases())


def _weights(energy: Energy) -> dict[str, float]:
    if isinstance(energy, str):
        return {energy: 1.0}
    if not isinstance(energy, Mapping):
        raise ValueError(f"energy is {energy!r}; it must be a name of TERMS, or weights by name.")
    return dict(energy)


def _listed(name: str, given: object, alone: type = type(None)) -> list[object]:
    """What was given as a list; one thing of type `alone` is a list of it."""
    if isinstance(given, alone):
        return [given]
    try:
        return list(given)
    except TypeError:
        raise ValueError(f"{name} is {given!r}; it must be a list.") from None


def _switch(name: str, given: object) -> int:
    if not isinstance(given, (bool, np.bool_, int)) or given not in (0, 1):
        raise ValueError(f"{name} is {given!r}; it must be True or False.")
    return int(given)


def _number(name: str, names: Sequence[str], what: str) -> int:
    if not isinstance(name, str) or name not in names:
        raise ValueError(f"There is no {what} '{name}'; there are {', '.join(names)}.")
    return names.index(name)


def _options(lib: Library, energy: Energy, surface: str, **fields: object) -> COptions:
    return lib.options(_weights(energy), surface=_number(surface, SURFACES, "surface"), **fields)


def _is_keep(wanted: object) -> bool:
    return isinstance(wanted, str) and wanted == "keep"


def _rule(name: str, wanted: str | float, rule: str) -> tuple[str, float]:
    """The rule, of abi.SCALAR_RULES, and the value of a number that is to be held; `rule` is for one that is given."""
    if _is_keep(wanted):
        return "keep", 0.0
    if isinstance(wanted, bool) or not isinstance(wanted, Real):
        raise ValueError(f"{name} is {wanted!r}: it must be 'keep' or a number.")
    return rule, option_value(name, wanted)


def _part(wanted: str | float, cage: Cage, energy: Energy, surface: str, left_out: Sequence[int]) -> str | float:
    """A reduced volume; for "keep" the cage's. ValueError where that has none."""
    if not _is_keep(wanted):
        return wanted
    part = abs(energies(cage, energy, surface=surface, left_out=left_out).reduced_volume)
    if not part > 0:
        raise ValueError("The cage's surface has no volume that could be kept: it is not closed, or faces are left out.")
    return part


class Cancel:
    """A flag that any thread may raise to end a run, an evaluation or a measurement; a context manager. It stays raised.

        with Cancel() as cancel: threading.Timer(5, cancel.request).start(); minimize(cage, cancel=cancel)"""

    def __init__(self) -> None:
        self._flag = _Cancel.create(load())

    def request(self) -> None:
        """End the call that was given this flag: a run at its next step, with the best cage so far."""
        self._flag.request()

    def close(self) -> None:
        """Free the flag; not while a run has it. A second time does nothing."""
        self._flag.close()

    def __enter__(self) -> Cancel:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _flag(cancel: Cancel | None) -> _Cancel | None:
    return cancel._flag if cancel is not None else None


class Problem:
    """A cage made ready for evaluation: energies and their exact gradient at any positions. A context manager.

    `energy`: a name of TERMS or weights by name; it is the objective. `surface`: of SURFACES; "auto" is the limit surface
    unless a term of third order needs another. `spontaneous_curvature`: as of minimize(). Faces that are degenerate at the
    cage's positions are left out. `cancel`: ends what takes long at poles of many faces, from any thread; the call then raises
    Cancelled, and the problem can be evaluated again. CurvoptError for cages without a surface, ValueError for unknown names.
    Belongs to one thread at a time."""

    def __init__(
        self, cage: Cage, energy: Energy = "willmore", *, surface: str = "auto", tolerance: float = 1e-4,
        left_out: Sequence[int] = (), threads: int = 0, spontaneous_curvature: float = DEFAULTS.spontaneous_curvature,
        cancel: Cancel | None = None,
    ) -> None:  # fmt: skip
        lib = load()
        options = _options(
            lib, energy, surface, tolerance=tolerance, holes=left_out, threads=threads, spontaneous_curvature=spontaneous_curvature
        )
        with _Mesh.of_cage(lib, cage) as mesh:
            self._problem = _Problem.create(mesh, options, cage.positions, _flag(cancel))

    def energies(self, positions: object, *, cancel: Cancel | None = None) -> Energies:
        """All energies, with estimates of their quadrature errors, at positions (n, 3)."""
        return self._problem.evaluate(positions, cancel=_flag(cancel))[0]

    def gradient(self, positions: object, *, cancel: Cancel | None = None) -> tuple[float, np.ndarray]:
        """The objective and its derivative by positions (n, 3), in 1 / units of the cage."""
        found, gradient = self._problem.evaluate(positions, with_gradient=True, cancel=_flag(cancel))
        return found.objective, gradient

    def close(self) -> None:
        """Free it; a second time does nothing."""
        self._problem.close()

    def __enter__(self) -> Problem:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def energies(cage: Cage, energy: Energy = "willmore", *, cancel: Cancel | None = None, **options: object) -> Energies:
    """All energies of a cage's surface; options as of Problem. `energy` decides about `objective` and the surface "auto"."""
    with Problem(cage, energy, cancel=cancel, **options) as problem:
        return problem.energies(cage.positions, cancel=cancel)


@dataclass(frozen=True)
class Minimum:
    """Where a run ended: the cage, energies before and after and the verdict (`summary`), a report of each level, and what
    was held because the surface has no finite energy there."""

    cage: Cage
    summary: Summary
    levels: tuple[LevelReport, ...]
    exceptions: Exceptions

    @property
    def energies(self) -> Energies:
        """Of the result."""
        return self.summary.end


def _check_names(options: Mapping[str, float]) -> None:
    """ValueError for a name that neither minimize() nor curvopt_options has."""
    for name in options:
        if name not in OPTION_KINDS:
            near = difflib.get_close_matches(name, [*inspect.signature(minimize).parameters, *OPTION_KINDS], 1)
            raise ValueError(f"There is no option '{name}'" + (f"; the nearest is '{near[0]}'." if near else "."))


def _symmetry(wanted: str) -> dict[str, int]:
    """The fields of a symmetry, or of mirror planes with commas."""
    names = [name for name in SYMMETRIES if name != "planes"]
    if isinstance(wanted, str) and wanted in names:
        return {"symmetry": SYMMETRIES.index(wanted)}
    every = ("x", "y", "z", *names)
    planes = {_number(name, every, "symmetry or mirror plane") for name in str(wanted).split(",")}
    if max(planes) > 2:
        raise ValueError(f"symmetry is '{wanted}': only mirror planes x, y, z can be several.")
    return {"symmetry": SYMMETRIES.index("planes"), "symmetry_planes": sum(1 << plane for plane in planes)}


def _array(name: str, given: object) -> np.ndarray:
    try:
        return np.asarray(given, float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be numbers, not {given!r}.") from None


def _pins(held: object, weights: object, limit_points: bool, places: object) -> Held | None:
    if held is None:
        for name, value in (("weights", weights), ("places", places)):
            if value is not None:
                raise ValueError(f"{name} are of held vertices, and held names none.")
        return None
    vertices = indices(held, "held")
    firmness = np.ones(vertices.size) if weights is None else reals(weights, vertices.size, "weights of held vertices")
    at = None if places is None else _array("places", places)
    if at is not None and at.size != 3 * vertices.size:
        raise ValueError(f"places have the shape {at.shape}; for {vertices.size} held vertices it must be ({vertices.size}, 3).")
    return Held(vertices, firmness, bool(_switch("limit_points", limit_points)), at)


def run_options(
    lib: Library, cage: Cage, energy: Energy, *, levels: int = DEFAULTS.levels, surface: str = DEFAULTS.surface,
    boundary: str = DEFAULTS.boundary, symmetry: str = DEFAULTS.symmetry, strength: float = DEFAULTS.strength,
    within: float = DEFAULTS.within, spontaneous_curvature: float = DEFAULTS.spontaneous_curvature,
    slide: bool = DEFAULTS.slide, no_crossings: bool = DEFAULTS.no_crossings, volume: str | float | None = None, area: str | float | None = None, total_mean_curvature: str | float | None = None, reduced_volume: str | float | None = None, held: object = None,
    weights: object = None, limit_points: bool = False, places: object = None, left_out: Sequence[int] = (), through: Sequence[Through] | Through = (),
    chains: Sequence[Chain] | Chain = (), **options: float,
) -> COptions:  # fmt: skip
    """The options of minimize() as the library's struct."""
    _check_names(options)
    options.update(_symmetry(symmetry))
    pins = _pins(held, weights, limit_points, places)
    through, chains = _listed("through", through, Through), _listed("chains", chains, Chain)
    left_out = _listed("left_out", left_out)
    numbers = {"volume": volume, "area": area, "total_mean_curvature": total_mean_curvature}
    scalars = {name: _rule(name, wanted, "value") for name, wanted in numbers.items() if wanted is not None}
    if reduced_volume is not None:
        if volume is not None:
            raise ValueError("volume and reduced_volume exclude each other: give the volume, or the volume and the area.")
        scalars["volume"] = _rule("reduced_volume", _part(reduced_volume, cage, energy, surface, left_out), "reduced")
    return _options(
        lib, energy, surface, held=pins, holes=left_out, levels=levels, boundary=_number(boundary, BOUNDARIES, "boundary"),
        strength=strength, within=within, spontaneous_curvature=spontaneous_curvature, slide=_switch("slide", slide),
        no_crossings=_switch("no_crossings", no_crossings), scalars=scalars, through=through, chains=chains, **options,
    )  # fmt: skip


def minimize(
    cage: Cage,
    energy: Energy = "willmore",
    *,
    levels: int = DEFAULTS.levels,
    surface: str = DEFAULTS.surface,
    boundary: str = DEFAULTS.boundary,
    symmetry: str = DEFAULTS.symmetry,
    strength: float = DEFAULTS.strength,
    within: float = DEFAULTS.within,
    spontaneous_curvature: float = DEFAULTS.spontaneous_curvature,
    slide: bool = DEFAULTS.slide,
    no_crossings: bool = DEFAULTS.no_crossings,
    volume: str | float | None = None,
    area: str | float | None = None,
    total_mean_curvature: str | float | None = None,
    reduced_volume: str | float | None = None,
    held: object = None,
    weights: object = None,
    limit_points: bool = False,
    places: object = None,
    left_out: Sequence[int] = (),
    through: Sequence[Through] | Through = (),
    chains: Sequence[Chain] | Chain = (),
    on_progress: Callable[[Progress], object] | None = None,
    cancel: Cancel | None = None,
    **options: float,
) -> Minimum:
    """Minimize an energy over the vertices of a cage, on `levels` levels between which the cage is subdivided.

    energy       a name of TERMS, or weights by name
    boundary     of BOUNDARIES: what an open surface keeps
    symmetry     of SYMMETRIES, or mirror planes such as "x" or "y,z"
    strength     0.001 .. 1; below 1 the surface stays near the cage's: waves shorter than S / (1 - S) RMS radii go
    within       where positive, no vertex and no point of the surface gets farther than this from where it was
    spontaneous_curvature
                 c0, in 1 / units: bending energy is int (k1 + k2 - c0)^2 dA (Helfrich), less the constant 2 int K dA of
                 "willmore", a fourth of it as "mean_curvature". 2 / R is a sphere's of radius R. Where nothing is held, at the
                 size of the result: that of the cage's area, or of a number below
    slide        whether held vertices on boundaries and creases slide along these
    no_crossings whether the surface is kept from coming to cross itself: faces that are no neighbours repel each other from
                 a fifth of a mean edge on. `summary.touching` has the pairs by which the result is held, `summary.clearance`
                 their least distance
    volume, area, total_mean_curvature (int H dA)
                 numbers of the whole surface that the result is to have: "keep", as the cage's, or a positive number in
                 units^3, units^2, units. Where nothing else is held and the strength is 1, one of them only sets the result's
                 size, which else has the cage's area
    reduced_volume  the volume as a part of that of the sphere with the result's area: "keep", or above 0 .. 1; not with
                 `volume`
    held (k,)    vertices that stay; with `weights` (k,) 0 .. 1 below 1 a spring pulls them back
    limit_points whether, in place of vertices that stay, the surface goes on through the points that belong to them
    places (k, 3) where the held vertices or limit points are to be; NAN: where they are
    left_out     faces that do not count and stay
    through      points of the surface, at vertices and inside faces, with places, normals, tangents and curvatures: a list of
                 Through, or one; symmetries are kept that take these to each other, with curvatures none
    chains       chains of edges whose limit curves follow curves: a list of Chain, or one; no symmetries are kept then
    on_progress  called on this thread after every step; a true value ends the run with the best cage so far
    cancel       the same from any thread
    options      further fields of curvopt_options by name, as numbers

    CurvoptError where the library refuses, as a volume of a boundary that may move, or one that does not fit into the area;
    ValueError for unknown names, wrong lengths and what is neither "keep" nor a number; and whatever `on_progress` raises.
    A cancelled run is no error: its `summary.stop` is "cancelled". Nor is one that could not reach a number that is to be
    held: `summary.scalar_residuals` says by how much, relatively, it misses; mostly it is below 1e-8."""
    lib = load()
    raw = run_options(
        lib, cage, energy, levels=levels, surface=surface, boundary=boundary, symmetry=symmetry, strength=strength,
        within=within, spontaneous_curvature=spontaneous_curvature, slide=slide, no_crossings=no_crossings,
        volume=volume, area=area, total_mean_curvature=total_mean_curvature,
        reduced_volume=reduced_volume, held=held,
        weights=weights, limit_points=limit_points, places=places, left_out=left_out, through=through, chains=chains,
        **options,
    )  # fmt: skip
    with _Mesh.of_cage(lib, cage) as mesh:
        with _minimize(mesh, cage.positions, raw, on_progress, _flag(cancel)) as result:
            summary = result.summary()
            levels_done = tuple(result.level(i) for i in range(summary.n_levels))
            return Minimum(result.cage(), summary, levels_done, mesh.exceptions(cage.positions, raw))


def refine(cage: Cage, times: int = 1) -> Cage:
    """The cage after Catmull-Clark subdivision: the same limit surface."""
    mesh, points = _Mesh.of_cage(load(), cage), cage.positions
    for _ in range(times):
        finer, points = mesh.refine(points)
        mesh.close()
        mesh = finer
    with mesh:
        return Cage(points, *mesh.faces(), mesh.creases())


def deviation(cage: Cage, other: Cage, *, threads: int = 0, cancel: Cancel | None = None) -> Deviation:
    """How far the limit surfaces of two cages are apart, whatever their faces: largest distance with a bound, and root mean
    square. A cancelled measurement has a larger bound, and `rms` NAN."""
    lib = load()
    with _Mesh.of_cage(lib, cage) as mesh, _Mesh.of_cage(lib, other) as another:
        return _deviation(mesh, cage.positions, another, other.positions, threads, _flag(cancel))


def crossings(cage: Cage, *, threads: int = 0, cancel: Cancel | None = None) -> Crossings:
    """Where the limit surface of a cage crosses itself, by pairs of faces."""
    with _Mesh.of_cage(load(), cage) as mesh:
        return _crossings(mesh, cage.positions, threads, _flag(cancel))


def folds(cage: Cage) -> np.ndarray:
    """The faces, ascending, at which the limit surface of a cage is folded: at a point it has no tangent plane (a pinch
    point), and energies of curvature are infinite. A vertex that was dragged over others folds a cage.

    minimize() puts vertices of such faces between their neighbours first: `summary.n_unfolded`."""
    lib = load()
    with _Mesh.of_cage(lib, cage) as mesh:
        return _folds(mesh, cage.positions, _options(lib, "willmore", "auto"))


class Sampler:
    """Points of a cage's surface and their derivatives. A context manager; belongs to one thread at a time.

    `surface` and `energy` (for "auto") as of Problem."""

    def __init__(self, cage: Cage, *, surface: str = "limit", energy: Energy = "willmore") -> None:
        lib = load()
        with _Mesh.of_cage(lib, cage) as mesh:
            self._sampler = _Sampler.create(mesh, cage.positions, _options(lib, energy, surface))

    def jets(self, face: object, corner: object, uv: object) -> np.ndarray:
        """(n, 10, 3): S, S_u, S_v, S_uu, S_uv, S_vv, S_uuu, S_uuv, S_uvv, S_vvv at uv (n, 2) of face (n,), corner (n,).

        Quads: corner 0, uv over the face. Other faces: the quarter at `corner`; u runs to the middle of the edge to the next
        corner, v to that of the edge to the previous one. NAN derivatives exactly at an extraordinary vertex."""
        return self._sampler.jets(face, corner, uv)

    def curvatures(self, face: object, corner: object, uv: object) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Points (n, 3), unit normals (n, 3), mean curvature H (n,) and Gauss curvature K (n,) there.

        H = (k1 + k2) / 2 is negative where the surface bends away from the normal, as on a sphere seen from outside
        (`Energies.total_mean_curvature` has the other sign); in 1 / units of the cage, K in 1 / units^2 (do Carmo,
        Differential Geometry of Curves and Surfaces, 3.3)."""
        jets = self.jets(face, corner, uv)
        point, su, sv, suu, suv, svv = np.moveaxis(jets[:, :6], 1, 0)
        normal = np.cross(su, sv)
        area = np.linalg.norm(normal, axis=1)
        normal /= area[:, None]
        dot = lambda a, b: np.einsum("ij,ij->i", a, b)  # noqa: E731
        e, f, g = dot(su, su), dot(su, sv), dot(sv, sv)
        ll, m, n = dot(suu, normal), dot(suv, normal), dot(svv, normal)
        return point, normal, (e * n - 2 * f * m + g * ll) / (2 * area**2), (ll * n - m**2) / area**2

    def close(self) -> None:
        """Free it; a second time does nothing."""
        self._sampler.close()

    def __enter__(self) -> Sampler:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def library_version() -> str:
    """Version of the loaded library. LibraryError, with what to do, if there is none that can be used."""
    return load().version


__all__ = [
    "BOUNDARIES", "SURFACES", "SYMMETRIES", "TERMS", "Cage", "Cancel", "Chain", "Creases", "Crossings", "Deviation", "Minimum", "Problem",
    "Sampler", "Through", "cage", "crossings", "deviation", "energies", "folds", "library_version", "minimize", "refine",
]  # fmt: skip
