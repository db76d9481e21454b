# SPDX-License-Identifier: GPL-3.0-or-later
"""curvopt-tao on one rank and on several, against the library and against curvopt.

It is taken from build/release, as the library is (tests/numeric/lib.py), or from the folder that CURVOPT_BUILD names.
"""
from __future__ import annotations

import itertools
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

import lib
from nets import read_obj, write_obj

OBJ = lib.ROOT / "blend_files" / "obj"
CAGES = lib.ROOT / "tests" / "cages" / "numeric"
CLOSED = ("torus_030", "lawson_g2", "lawson_g3")
ENERGIES = ("willmore", "mvs", "mvs_cross")
TERMS = ("area", *lib.TERMS, "h2", "gauss", "objective", "min_jacobian")
EXACT = 1e-12
STATIONARY = 1e-6  # what the library's certificates ask for
TIMEOUT = 1800  # seconds on the clock: a run that takes so long hangs, at load 20, too

# A tube of 5 x 4 quads: a sharp crease along it, one that fades and a vertex that is sharp for a while.
CREASED = "\n".join(
    [f"v {k} {np.cos(np.pi * j / 2)} {np.sin(np.pi * j / 2) + 0.1 * k * j}" for k in range(6) for j in range(4)]
    + [f"f {4 * k + j + 1} {4 * k + (j + 1) % 4 + 1} {4 * k + (j + 1) % 4 + 5} {4 * k + j + 5}"
       for k in range(5) for j in range(4)]
    + ["t crease 2/1/0 5 9 10", "t crease 2/1/0 9 13 10", "t crease 2/1/0 14 15 1.5", "t corner 1/1/0 11 0.75", ""])


def tao(ranks: int, *arguments: str, prefix: tuple[str, ...] = ()) -> subprocess.CompletedProcess:
    """The program on so many ranks; `prefix` stands before it on the second of two."""
    environment = {**os.environ, "OMPI_MCA_rmaps_base_oversubscribe": "1",
                   "OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
                   "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                   "HWLOC_COMPONENTS": "-gl"}  # which asks X servers for GPUs, and dies with one of another test
    program = [str(lib.BUILD / "curvopt-tao"), *arguments]
    command = ["mpirun", "-q", "-n", str(ranks), *program]
    if prefix:
        command = ["mpirun", "-q", "-n", "1", *program, ":", "-n", "1", *prefix, *program]
    # A folder of its own: in a shared one, an mpirun that ends removes what another is making. Its name is short, for
    # sockets are in it.
    with tempfile.TemporaryDirectory(prefix="mpi_", ignore_cleanup_errors=True) as session:
        environment["OMPI_MCA_orte_tmpdir_base"] = session
        return subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, env=environment)


def minimize(ranks: int, cage: Path, out: Path, *arguments: str, petsc: tuple[str, ...] = ()) -> dict:
    """The report of a run that must succeed."""
    report = out.with_suffix(".json")
    run = tao(ranks, "minimize", str(cage), "-o", str(out), "--json", str(report), "--quiet", *arguments, "--", *petsc)
    assert run.returncode == 0, run.stderr
    return json.loads(report.read_text())


def ours(cage: Path, out: Path, *arguments: str) -> dict:
    """The same by curvopt over all coordinates, symmetries not kept, blends as narrow as TAO's."""
    report = out.with_suffix(".json")
    run = lib.run_cli("minimize", str(cage), "-o", str(out), "--json", str(report), "--quiet", "--symmetry", "none",
                      "--spacing", "free", "--blend-width", "1", *arguments)
    assert run.returncode == 0, run.stderr
    return json.loads(report.read_text())


def check_figures(cage: Path, tmp_path: Path, ranks: int, *arguments: str, gradient: np.ndarray | None = None) -> None:
    """Terms, and the gradient where it is given, of a cage under a fixed rule are those of the library."""
    here = ("--levels", "1", "--max-iterations", "0", "--joshi-sequin", *arguments)
    slope = tmp_path / "gradient"
    got = minimize(ranks, cage, tmp_path / "tao.obj", *here, petsc=("-curvopt_gradient", str(slope)))
    expected = ours(cage, tmp_path / "ours.obj", *here)
    for key in TERMS:
        a, b = got["start"][key], expected["start"][key]
        assert (a is None) == (b is None), key
        assert a is None or abs(a - b) <= EXACT * max(abs(b), 1), key
    assert got["start"]["samples"] == expected["start"]["samples"]
    a, b = (report["levels"][0]["gradient_norm"] for report in (got, expected))
    assert abs(a - b) <= 1e-11 * b
    if gradient is not None:
        assert np.abs(np.loadtxt(slope) - gradient).max() <= EXACT * np.abs(gradient).max()


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("energy", ENERGIES)
def test_energies_and_gradients_are_the_library_s(name, energy, ranks, tmp_path):
    cage = read_obj(OBJ / f"{name}.obj")
    surface = "limit" if energy == "willmore" else "polynomial"
    options = lib.options(energy, surface, joshi_sequin=1, blend_width=1)
    _, gradient = lib.Problem(cage, options).evaluate(cage.xyz, gradient=True)
    check_figures(OBJ / f"{name}.obj", tmp_path, ranks, "--energy", energy, "--surface", surface, gradient=gradient)


@pytest.mark.parametrize("ranks", [2, 5] if lib.LONG else [3])
@pytest.mark.parametrize("name", ["mixed", "frame_3", "creased", "branch_open", "report's"])
def test_polygons_creases_boundaries_and_the_report_s_surface(name, ranks, tmp_path):
    cage, arguments = CAGES / f"{name}.obj", ("--energy", "willmore:1,mean_curvature:0.5", "--boundary", "free")
    if name == "creased":
        cage = tmp_path / "creased.obj"
        cage.write_text(CREASED)
    elif name == "branch_open":
        cage, arguments = OBJ / "branch_open.obj", ("--boundary", "tangent")
    elif name == "report's":
        cage, arguments = OBJ / "lawson_g2.obj", ("--energy", "mvs:1,willmore:0.1")
    check_figures(cage, tmp_path, ranks, *arguments)


@pytest.mark.parametrize("ranks", [1, 2, 4] if lib.LONG else [3])
@pytest.mark.parametrize("name", ["mixed", "creased", "branch_open"])
def test_a_subdivided_cage_is_numbered_as_by_the_library(name, ranks, tmp_path):
    cage = {"mixed": CAGES / "mixed.obj", "branch_open": OBJ / "branch_open.obj"}.get(name, tmp_path / "creased.obj")
    if name == "creased":
        cage.write_text(CREASED)
    options = ("--levels", "3", "--max-iterations", "0", "--joshi-sequin")  # the area to scale to by the same rules
    minimize(ranks, cage, tmp_path / "tao.obj", *options)
    ours(cage, tmp_path / "ours.obj", *options)
    got, expected = (tmp_path.joinpath(f"{who}.obj").read_text().split("\n") for who in ("tao", "ours"))
    kinds = [[sorted(sorted(line.split()) for line in text if line[:1] == kind) if kind == "t" else
              [line for line in text if line[:1] == kind] for kind in "vft"] for text in (got, expected)]
    assert kinds[0][1:] == kinds[1][1:]
    a, b = (np.array([line.split()[1:] for line in kind[0]], float) for kind in kinds)
    assert a.shape == b.shape and np.abs(a - b).max() <= 1e-11 * np.abs(b).max()


def minimizer(name: str, energy: str, folder: Path) -> tuple[Path, tuple[str, ...], float, float]:
    """The library's, of a function that both programs see alike; the options for that, its energy, and how far the
    programs may differ. By a fixed quadrature rule; of MVS, which on the torus falls through a fixed one (869, where
    finer rules have 1014), by rules so fine that it does not matter which."""
    if energy == "mvs":
        fine = ("--tolerance", "1e-7", "--energy", energy, "--levels", "1")
        return folder / "start.obj", fine, ours(OBJ / f"{name}.obj", folder / "start.obj", *fine)["objective"], 1e-7
    fixed = ("--joshi-sequin", "--surface", "limit" if energy == "willmore" else "polynomial", "--energy", energy,
             "--levels", "1")
    ours(OBJ / f"{name}.obj", folder / "start.obj", "--energy", energy, "--levels", "1")
    end = ours(folder / "start.obj", folder / "minimizer.obj", *fixed, "--method", "gauss_newton")
    return folder / "minimizer.obj", fixed, end["objective"], 1e-11


TAKES_LONG = {(name, "mvs", ranks) for name in CLOSED if name != "torus_030" for ranks in (1, 2)} | {("lawson_g3", "mvs_cross", 1)}


@pytest.mark.parametrize("name, energy, ranks", [
    of for of in itertools.product(CLOSED, ENERGIES, (1, 2)) if lib.LONG or of not in TAKES_LONG])
def test_the_library_s_minimizers_are_tao_s(name, energy, ranks, tmp_path):
    """The decrements by differences are no more than the certificate says, over everything and along normals."""
    cage, fixed, energy_there, alike = minimizer(name, energy, tmp_path)
    found = minimize(ranks, cage, tmp_path / "end.obj", *fixed, "--max-iterations", "0", "--verify",
                     petsc=("-verify_tao_max_it", "2", "-verify_shape_tao_max_it", "2"))
    left = found["verification"]
    assert abs(found["objective"] - energy_there) <= alike * energy_there
    assert left["verdict"] == "minimum"
    assert left["difference_decrement"] <= STATIONARY * energy_there
    assert left["newton_decrement"] <= STATIONARY * energy_there


def both(cage: Path, folder: Path, ranks: int, *options: str) -> tuple[dict, dict]:
    """What TAO and the library say of a cage as it is, by quadrature so fine that it does not matter which."""
    here = ("--levels", "1", "--max-iterations", "0", "--verify", "--tolerance", "1e-9", *options)
    return minimize(ranks, cage, folder / "tao.obj", *here), ours(cage, folder / "ours.obj", *here)


@pytest.mark.parametrize("name, energy, ranks", [("torus_030", "mvs_cross", 1), ("torus_030", "mvs_cross", 2),
                                                 ("torus_030", "mvs", 1),
                                                 *([("lawson_g2", "willmore", 2)] if lib.LONG else [])])
def test_decrements_are_the_library_s(name, energy, ranks, tmp_path):
    """At a minimizer that was shaken, so that there is something left: by TAO with a Hessian by differences, by the
    library with its exact one."""
    ours(OBJ / f"{name}.obj", tmp_path / "end.obj", "--energy", energy, "--levels", "1")
    shaken = read_obj(tmp_path / "end.obj")
    shaken.xyz[:] += np.random.default_rng(1).uniform(-1e-5, 1e-5, shaken.xyz.shape)
    found = both(write_obj(tmp_path / "shaken.obj", shaken), tmp_path, ranks, "--energy", energy)
    got, expected = (report["verification"] for report in found)
    assert got["verdict"] == expected["verdict"]
    assert (got["all_negative_directions"] == 0) == (expected["all_negative_directions"] == 0)
    for key in ("newton_decrement", "shape_decrement"):
        assert expected[key] > 1e-10 * found[1]["objective"]
        assert got[key] == pytest.approx(expected[key], rel=0.02), key


@pytest.mark.parametrize("ranks", [1, 2])
def test_where_sliding_goes_down_newton_s_method_does_but_nothing_is_left(ranks, tmp_path):
    """The report's verification takes 5e-4 off a torus that is stationary: it leaves along a negative direction of the
    Hessian over everything. The decrement says how far from stationary it is, and both programs see the direction."""
    cage = Path(__file__).with_name("sliding_torus.obj")
    tao_s, library_s = both(cage, tmp_path, ranks, "--energy", "mvs_cross")
    got, expected = tao_s["verification"], library_s["verification"]
    assert expected["all_negative_directions"] > 0 and not tao_s["tao"]["hessian_positive"]
    assert expected["negative_directions"] == 0 and tao_s["tao"]["shape_hessian_positive"]
    assert got["verdict"] == expected["verdict"] == "minimum"
    energy = library_s["objective"]
    assert max(got["newton_decrement"], expected["newton_decrement"]) <= 1e-6 * energy
    assert tao_s["tao"]["newton_gain"] >= 1e-4 * energy


@pytest.mark.parametrize("method", ["lmvm", "blmvm", "nls", "ntr"])
def test_solvers_of_tao_get_as_far_down(method, tmp_path):
    """From the library's minimizer, shaken: that may have a lower one beside it."""
    cage, fixed, expected, _ = minimizer("torus_030", "mvs_cross", tmp_path)
    shaken = read_obj(cage)
    shaken.xyz[:] += np.random.default_rng(1).uniform(-0.003, 0.003, shaken.xyz.shape)
    start = write_obj(tmp_path / "shaken.obj", shaken)
    found = minimize(2, start, tmp_path / "tao.obj", *fixed, petsc=("-tao_type", method))
    assert found["start"]["objective"] > (1 + 1e-4) * expected
    assert found["method"] == method and 0.999 * expected <= found["objective"] <= (1 + 1e-5) * expected


def test_hessians_by_tao_s_own_differences(tmp_path):
    ours(OBJ / "torus_030.obj", tmp_path / "start.obj", "--energy", "mvs_cross", "--levels", "1")
    for difference in ("-tao_fd_hessian", "-tao_mf_hessian"):
        found = minimize(1, tmp_path / "start.obj", tmp_path / "end.obj", "--energy", "mvs_cross", "--levels", "1",
                         petsc=("-tao_type", "nls", difference, "-tao_nls_pc_type", "none", "-tao_max_it", "3"))
        assert found["objective"] <= found["start"]["objective"] * (1 + 1e-4)


def test_what_is_held_stays(tmp_path):
    cage, pins = OBJ / "branch_open.obj", tmp_path / "pins"
    pins.write_text("12\n13 line 0 0 1\n14 plane 1 0 0\n")
    found = minimize(2, cage, tmp_path / "end.obj", "--levels", "1", "--pin", str(pins), "--max-iterations", "30")
    ours(cage, tmp_path / "ours.obj", "--levels", "1", "--pin", str(pins), "--max-iterations", "30")
    start, end, theirs = (read_obj(path).xyz for path in (cage, tmp_path / "end.obj", tmp_path / "ours.obj"))
    held = np.all(start == theirs, axis=1)
    assert 12 in np.flatnonzero(held) and not held.all() and np.array_equal(start[held], end[held])
    moved = end - start
    assert np.abs(moved[13, :2]).max() <= 1e-12 and abs(moved[14, 0]) <= 1e-12 and np.abs(moved).max() > 1e-3
    assert found["objective"] < found["start"]["objective"]


def test_a_rank_has_its_faces_and_a_halo(tmp_path):
    found = minimize(2, OBJ / "torus_050_16x8.obj", tmp_path / "end.obj", "--levels", "4", "--max-iterations", "0")
    ranks = found["tao"]
    assert ranks["faces"] == [4096, 4096] and sum(ranks["own_vertices"]) == 8192
    assert max(ranks["halo_vertices"]) <= 2 * 5 * 64 + 64


CUBE_FACES = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
CUBE = "".join(f"v {x} {y} {z}\n" for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)) + CUBE_FACES
GRID = "".join(f"v {i} {j} 0\n" for i in range(5) for j in range(5)) + "".join(
    f"f {5 * i + j + 1} {5 * i + j + 6} {5 * i + j + 7} {5 * i + j + 2}\n" for i in range(4) for j in range(4))

BAD = {
    "no file": (None, ()),
    "nothing": ("", ()),
    "words": ("hello\n", ()),
    "a flipped face": (CUBE.replace("f 1 2 4 3", "f 1 3 4 2"), ()),
    "not a number": (CUBE.replace("v -1 -1 -1", "v nan 0 0"), ()),
    "no area": ("".join(f"v {k} 0 0\n" for k in range(8)) + CUBE_FACES, ()),
    "one point": ("v 1 1 1\n" * 8 + CUBE_FACES, ()),
    "folded flat": (CUBE.replace("v 1 ", "v -1 "), ()),
    "no third order": (CUBE, ("--energy", "mvs", "--surface", "limit")),
    "a cone": (CUBE + "t corner 1/1/0 0 10\n", ("--boundary", "free")),
    "nothing may move": (CUBE, ("--pin", "ALL", "--levels", "1")),
    "a pin that is no vertex": (CUBE, ("--pin", "PINS", "--levels", "1")),
}


@pytest.mark.parametrize("what", BAD)
def test_what_the_library_refuses_every_rank_refuses(what, tmp_path):
    """With the library's sentence, once, and nothing written."""
    text, arguments = BAD[what]
    cage, pins = tmp_path / "cage.obj", tmp_path / "pins"
    pins.write_text("99\n" if "PINS" in arguments else "".join(f"{v}\n" for v in range(8)))
    arguments = [str(pins) if a in ("PINS", "ALL") else a for a in arguments]
    if text is not None:
        cage.write_text(text)
    before = sorted(tmp_path.iterdir())
    command = ("minimize", str(cage), "-o", str(tmp_path / "out.obj"), *arguments)
    expected, got = lib.run_cli(*command, "--strict"), tao(2, *command)
    assert expected.returncode == got.returncode == 1, (expected.stderr, got.stderr)
    sentence = expected.stderr.strip().replace("curvopt:", "curvopt-tao:")
    if "PINS" in BAD[what][1]:  # curvopt names the file of pins and the line, curvopt-tao the cage
        sentence = sentence.replace(f"{pins}: line 1:", f"{cage}:")
    assert got.stderr.strip() == sentence
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("arguments, sentence", [
    (("--method", "lmvm"), "--method is not for this program"), (("--symmetry", "keep"), "--symmetry can be none"),
    (("--escape",), "--escape is not for this program"), (("--slide",), "--slide is not for this program"),
    (("--spontaneous-curvature", "1"), "--spontaneous-curvature is not for this program"), (("--levels", "0"), "levels is 0"),
    (("--volume", "keep"), "--volume, --area, --total-mean-curvature and --reduced-volume are not for this program"),
    (("--reduced-volume", "0.8"), "--volume, --area,"), (("--strength", "0.3"), "--strength and --within are not for this program"),
    (("--no-crossings",), "--no-crossings is not for this program"),
    (("--within", "0.1"), "--strength and --within are not for this program"),
    (("--through", "points.json"), "--through is not for this program"),
    (("--frobnicate",), "unknown option --frobnicate"), (("--pin", "x"), "--pin is for --levels 1")])
def test_wrong_use_is_named(arguments, sentence, tmp_path):
    run = tao(2, "minimize", str(OBJ / "torus_030.obj"), "-o", str(tmp_path / "out.obj"), *arguments)
    assert run.returncode == 2 and sentence in run.stderr and run.stderr.count("curvopt-tao:") == 1


def test_more_ranks_than_faces(tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE)
    run = tao(7, "minimize", str(tmp_path / "cube.obj"), "-o", str(tmp_path / "out.obj"))
    assert run.returncode == 1 and "fewer than there are ranks" in run.stderr


# Allocations of a rank that fail: the first is made before MPI is there, the next before the cage is; then it is shared
# out, and subdivided, and TAO is at work, and the verification is. Of about this many.
ALLOCATIONS = 1000
FAILING = range(1, ALLOCATIONS + 1, 9) if lib.LONG else (1, 2, 20, 60, 150, 400, 700, 1000)


@pytest.fixture(scope="module")
def failing(tmp_path_factory) -> Path:
    """The library that lets an allocation fail, when it is preloaded."""
    built = tmp_path_factory.mktemp("failing") / "failing_rank.so"
    subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", str(built), str(Path(__file__).with_name("failing_rank.c"))],
                   check=True)
    return built


def with_a_failing_rank(built: Path, at: int, folder: Path, *more: str) -> subprocess.CompletedProcess:
    """Two levels, verified, on two ranks of which the second fails; 0: it does not."""
    prefix = ("env", f"LD_PRELOAD={built}", f"FAILING_RANK_AT={at}", f"FAILING_RANK_COUNT={folder / 'count'}")
    return tao(2, "minimize", str(OBJ / "torus_030.obj"), "-o", str(folder / "out.obj"), "--levels", "2",
               "--max-iterations", "3", "--verify", "--quiet", *more, prefix=prefix)


def test_a_rank_without_failures_comes_to_its_end(failing, tmp_path):
    run = with_a_failing_rank(failing, 0, tmp_path)
    assert run.returncode == 0, run.stderr
    assert int((tmp_path / "count").read_text()) >= ALLOCATIONS and (tmp_path / "out.obj").exists()


@pytest.mark.parametrize("at", FAILING)
def test_a_rank_that_runs_out_of_memory_ends_the_run(failing, at, tmp_path):
    """With a sentence, without a hang, with nothing written; by whichever of the two ranks says it."""
    run = with_a_failing_rank(failing, at, tmp_path, "--json", str(tmp_path / "report.json"))
    assert run.returncode == 1, run.stderr
    assert "curvopt-tao: " in run.stderr and "out of memory" in run.stderr
    assert not (tmp_path / "out.obj").exists() and not (tmp_path / "report.json").exists()


@pytest.mark.skipif(not lib.LONG, reason="takes a cage of 10^5 vertices: CURVOPT_LONG=1")
@pytest.mark.parametrize("room", [500_000, 700_000])  # KiB: too little before the solve, and in it
def test_a_rank_with_too_little_memory_ends_the_run(room, tmp_path):
    """The second rank has too little memory for its portion."""
    cage = tmp_path / "large.obj"
    assert tao(1, "minimize", str(OBJ / "torus_050_16x8.obj"), "-o", str(cage), "--levels", "6", "--max-iterations", "0",
               "--joshi-sequin", "--quiet").returncode == 0
    prefix = ("bash", "-c", f'ulimit -v {room}; exec "$@"', "limited")
    fine = tao(2, "--version", prefix=prefix)
    assert fine.returncode == 0, fine.stderr
    run = tao(2, "minimize", str(cage), "-o", str(tmp_path / "out.obj"), "--levels", "2", "--max-iterations", "1",
              "--joshi-sequin", prefix=prefix)
    assert run.returncode not in (0, 2) and "memory" in run.stderr.lower()
    assert not (tmp_path / "out.obj").exists()
