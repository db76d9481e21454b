# SPDX-License-Identifier: GPL-3.0-or-later
"""The binding against the real library and the real header; no Blender."""

import ctypes as C
import gc
import re
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest
import shapes
from addon.binding import abi, library, locate
from addon.binding.values import Held
from addon.core import job

ROOT = Path(__file__).resolve().parents[2]
HEADER = ROOT / "libcurvopt" / "include" / "curvopt.h"


@pytest.fixture(scope="module")
def lib():
    return library.load()


def torus_mesh(lib):
    points, faces = shapes.torus()
    return library.Mesh.create(lib, len(points), *shapes.packed(faces)), points


def compiled(tmp_path, source, *flags):
    """Path of `source` compiled against the header."""
    code, out = tmp_path / "t.c", tmp_path / "t.bin"
    code.write_text(source)
    subprocess.run(["cc", f"-I{HEADER.parent}", *flags, str(code), "-o", str(out)], check=True)
    return out


# ------------------------------------------------------------------------------------------ header and mirrors --


def test_struct_layouts_are_those_of_the_header(tmp_path):
    mirrors = {struct.__doc__: struct for struct in abi.STRUCT_SIZES}
    lines = []
    for name, struct in mirrors.items():
        lines.append(f'printf("{name} %zu\\n", sizeof({name}));')
        for field, _ in struct._fields_:
            place = f"offsetof({name}, {field}), sizeof((({name} *)0)->{field})"
            lines.append(f'printf("{name}.{field} %zu %zu\\n", {place});')
    includes = "#include <stddef.h>\n#include <stdio.h>\n#include <curvopt.h>\n"
    program = compiled(tmp_path, f"{includes}int main(void) {{ {' '.join(lines)} return 0; }}")
    seen = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout.split("\n")
    expected = []
    for name, struct in mirrors.items():
        assert C.sizeof(struct) == abi.STRUCT_SIZES[struct]
        expected.append(f"{name} {C.sizeof(struct)}")
        expected += [f"{name}.{f} {getattr(struct, f).offset} {getattr(struct, f).size}" for f, _ in struct._fields_]
    assert seen[:-1] == expected


def test_no_struct_field_of_the_header_is_left_out():
    text = re.sub(r"/\*.*?\*/", "", HEADER.read_text(), flags=re.S)
    for struct in abi.STRUCT_SIZES:
        body = re.search(rf"typedef struct {struct.__doc__} {{(.*?)}} {struct.__doc__};", text, re.S).group(1)
        fields = re.findall(r"\*?(\w+)(?:\[\w+\])?;", body)
        assert fields == [name for name, _ in struct._fields_], struct.__doc__


def test_signature_table_covers_every_prototype():
    text = re.sub(r"/\*.*?\*/", "", HEADER.read_text(), flags=re.S)
    prototypes = dict(re.findall(r"CURVOPT_API [^;(]*?(curvopt_\w+)\(([^;]*)\);", text))
    assert set(prototypes) == set(abi.SIGNATURES)
    for name, arguments in prototypes.items():
        count = 0 if arguments.strip() == "void" else arguments.count(",") + 1
        assert count == len(abi.SIGNATURES[name][1]), name


def test_numbers_follow_the_header():
    text = HEADER.read_text()
    assert re.findall(r"curvopt_(\w+)_from_name", text) == abi.ENUMS
    assert int(re.search(r"CURVOPT_MAX_TERMS\s+(\d+)", text).group(1)) == abi.MAX_TERMS
    assert int(re.search(r"CURVOPT_MAX_SCALARS\s+(\d+)", text).group(1)) == abi.MAX_SCALARS
    assert int(re.search(r"CURVOPT_N_SCALARS\s+(\d+)", text).group(1)) == len(abi.SCALARS)
    assert float(re.search(r"SHARPNESS_INFINITE (\S+)", text).group(1)) == abi.SHARPNESS_INFINITE
    version = tuple(int(re.search(rf"VERSION_{part} (\d+)", text).group(1)) for part in ("MAJOR", "MINOR"))
    assert version == abi.HEADER_VERSION


# ------------------------------------------------------------------------------------------------- the library --


def test_missing_library_names_the_places(tmp_path, monkeypatch):
    monkeypatch.setenv(locate.LIBRARY_VARIABLE, str(tmp_path / "none.so"))
    with pytest.raises(library.LibraryError, match="missing.*none.so"):
        library.load()


def test_the_environment_comes_before_the_addon_and_the_build(monkeypatch):
    monkeypatch.setenv(locate.LIBRARY_VARIABLE, "libcurvopt.so")  # not what the system's loader finds by that name
    assert locate.library_candidates() == [Path.cwd() / "libcurvopt.so"]
    monkeypatch.setenv(locate.LIBRARY_VARIABLE, "/somewhere/libcurvopt.so")
    assert locate.library_candidates() == [Path("/somewhere/libcurvopt.so")]
    monkeypatch.delenv(locate.LIBRARY_VARIABLE)
    inside, build = locate.library_candidates()
    assert inside == ROOT / "libcurvopt/python/curvopt/native" / locate.platform_name() / "libcurvopt.so"
    assert build == ROOT / "build" / "release" / "libcurvopt.so"


def test_a_file_that_is_no_library_is_refused(tmp_path):
    path = tmp_path / "libcurvopt.so"
    path.write_bytes(b"not an ELF file")
    with pytest.raises(library.LibraryError, match="cannot be loaded"):
        library.Library(path)


def test_older_library_is_refused(tmp_path):
    source = '#include <curvopt.h>\nconst char *curvopt_version(void) { return "0.0.9"; }'
    with pytest.raises(library.LibraryError, match=r"version 0\.0\.9.*needs 0\.1"):
        library.Library(compiled(tmp_path, source, "-shared", "-fPIC"))


def test_library_without_a_function_is_refused(tmp_path):
    source = '#include <curvopt.h>\nconst char *curvopt_version(void) { return "0.1.7"; }'
    with pytest.raises(library.LibraryError, match="has no function curvopt_status_text"):
        library.Library(compiled(tmp_path, source, "-shared", "-fPIC"))


def test_loaded_once(lib):
    assert library.load() is lib
    assert lib.version.startswith("0.1.")


# ------------------------------------------------------------------------------------------------------ arrays --


def test_indices_refuse_what_int32_cannot_hold():
    assert library.indices(np.array([1, 2], np.int64), "x").dtype == np.int32
    with pytest.raises(ValueError, match="beyond 32 bits"):
        library.indices([2**31], "x")
    with pytest.raises(ValueError, match="must be integers"):
        library.indices([0.5], "x")


def test_reals_are_copied_contiguous_and_counted():
    strided = np.arange(12, dtype=np.float32).reshape(2, 6)[:, ::2]
    out = library.reals(strided, 6, "x")
    assert out.flags.c_contiguous and out.dtype == np.float64 and out.tolist() == [0, 2, 4, 6, 8, 10]
    with pytest.raises(ValueError, match="holds 6 numbers, expected 9"):
        library.reals(strided, 9, "x")


def test_lengths_are_checked_before_c_reads(lib):
    with pytest.raises(ValueError, match="add up to 5"):
        library.Mesh.create(lib, 4, [5], [0, 1, 2, 3])
    mesh, points = torus_mesh(lib)
    with mesh, pytest.raises(ValueError, match="xyz holds 93"):
        mesh.refine(points[:-1])


# ----------------------------------------------------------------------------------------------------- handles --


def test_mesh_gives_back_its_faces(lib):
    _, faces = shapes.torus()
    mesh, _ = torus_mesh(lib)
    with mesh:
        info = mesh.info()
        assert (info.n_vertices, info.n_edges, info.n_faces, info.n_corners) == (32, 64, 32, 128)
        assert (info.euler, info.n_boundary_edges, info.all_quads) == (0, 0, 1)
        sizes, vertices = mesh.faces()
    assert sizes.tolist() == [4] * 32
    assert vertices.reshape(-1, 4).tolist() == faces


def test_closed_handle_is_refused_and_closing_twice_is_harmless(lib):
    mesh, _ = torus_mesh(lib)
    mesh.close()
    mesh.close()
    with pytest.raises(ValueError, match="This Mesh is closed"):
        mesh.info()


def test_refined_faces_lie_face_after_face(lib):
    points, faces = shapes.cube()
    triangle_prism = [[0, 1, 2], [5, 4, 3], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]]
    for count, polygons in ((len(points), faces), (6, triangle_prism)):
        with library.Mesh.create(lib, count, *shapes.packed(polygons)) as mesh:
            fine, _ = mesh.refine(np.random.default_rng(1).normal(size=(count, 3)))
            with fine:
                children = fine.faces()[1].reshape(-1, 4)
        assert children[:, 0].tolist() == [vertex for face in polygons for vertex in face]


def creased_torus(lib, rule="smooth"):
    points, faces = shapes.torus()
    creases = library.Creases(np.array([[1, 0], [4, 5]]), [2.5, 11.0], np.array([9]), [1.25], rule)
    return library.Mesh.create(lib, len(points), *shapes.packed(faces), creases), points


def test_mesh_gives_back_its_creases(lib):
    mesh, _ = creased_torus(lib)
    with mesh:
        creases = mesh.creases()
    assert sorted(zip(np.sort(creases.edges, 1).tolist(), creases.edge_sharpness)) == [([0, 1], 2.5), ([4, 5], 11.0)]
    assert (creases.vertices.tolist(), creases.vertex_sharpness.tolist(), creases.rule) == ([9], [1.25], "smooth")
    mesh, _ = torus_mesh(lib)
    with mesh:
        assert mesh.creases().edges.shape == (0, 2) and len(mesh.creases().vertices) == 0


def test_creases_of_the_finer_mesh_are_one_softer(lib):
    mesh, points = creased_torus(lib, "corners")
    with mesh, mesh.refine(points)[0] as fine:
        creases = fine.creases()
    assert sorted(creases.edge_sharpness) == [1.5, 1.5, 11.0, 11.0]
    assert creases.vertex_sharpness.tolist() == [0.25] and creases.rule == "corners"


def test_creases_are_checked_before_c_reads(lib):
    points, faces = shapes.torus()
    for wrong, match in (
        ({"edges": np.array([[0, 1]]), "edge_sharpness": [1.0, 2.0]}, "edge_sharpness holds 2 numbers, expected 1"),
        ({"edges": np.array([0, 1]), "edge_sharpness": [1.0, 2.0]}, "edges holds 2 indices, expected 4"),
        ({"vertices": np.array([0]), "vertex_sharpness": []}, "vertex_sharpness holds 0 numbers, expected 1"),
        ({"rule": "sharp"}, "no boundary rule 'sharp'"),
    ):
        with pytest.raises(ValueError, match=match):
            library.Mesh.create(lib, len(points), *shapes.packed(faces), library.Creases(**wrong))
    with pytest.raises(library.CurvoptError, match="no edge of the cage"):
        library.Mesh.create(lib, len(points), *shapes.packed(faces), library.Creases(np.array([[0, 2]]), [1.0]))


def test_refinement_of_a_cube(lib):
    points, faces = shapes.cube()
    with library.Mesh.create(lib, 8, *shapes.packed(faces)) as mesh:
        fine, xyz = mesh.refine(points)
        with fine:
            assert fine.info().n_vertices == 26
    assert np.allclose(np.abs(xyz[:8]), 5 / 9)  # (F + 2 R + (n - 3) P) / n
    assert np.allclose(xyz[20:], [points[face].mean(0) for face in faces])


def test_topology_error_has_code_element_and_sentence(lib):
    with pytest.raises(library.CurvoptError, match="7") as caught:
        library.Mesh.create(lib, 4, [3, 3], [0, 1, 2, 0, 7, 1])
    assert caught.value.code == 4 and caught.value.element >= 0
    assert str(caught.value) == caught.value.message


def test_options_defaults_and_refusals(lib):
    options = lib.options({"mvs": 2.0})
    assert list(options.weights) == [0, 2, 0, 0, 0, 0, 0, 0]
    assert (options.levels, options.max_iterations, options.surface) == (4, 10000, 0)
    with pytest.raises(ValueError, match="no energy 'mvx'"):
        lib.options({"mvx": 1.0})
    with pytest.raises(ValueError, match="no option 'level'"):
        lib.options({"mvs": 1.0}, level=3)
    with pytest.raises(ValueError, match="no option 'constraints'"):
        lib.options({"mvs": 1.0}, constraints=0)
    with pytest.raises(ValueError, match="no option 'scalar_rule'"):
        lib.options({"mvs": 1.0}, scalar_rule=1)
    with pytest.raises(ValueError, match="levels = 8589934592 is beyond"):
        lib.options({"mvs": 1.0}, levels=2**33)
    with pytest.raises(library.CurvoptError, match="levels.*13"):
        lib.options({"mvs": 1.0}, levels=13)


def test_defaults_are_the_librarys(lib):
    """What Blender's controls and the batch command show before a library is loaded, and what a request has."""
    options, defaults = abi.COptions(), abi.DEFAULTS
    lib.c.curvopt_options_init(C.byref(options), C.sizeof(options))
    weights = {term: weight for term, weight in zip(abi.TERMS, options.weights) if weight}
    assert weights == {defaults.energy: 1.0}
    for name, names in (("surface", abi.SURFACES), ("boundary", abi.BOUNDARIES), ("symmetry", abi.SYMMETRIES)):
        assert names[getattr(options, name)] == getattr(defaults, name), name
    for name in ("levels", "max_iterations", "threads", "escape", "strength", "slide"):
        assert getattr(options, name) == getattr(defaults, name), name
    assert not any(options.scalar_rule) and not any(options.scalar_value)
    request = job.Request()
    for name in ("energy", "levels", "boundary", "symmetry", "strength"):
        assert getattr(request, name) == getattr(defaults, name), name
    assert request.options == {}


def test_evaluation_and_gradient(lib):
    mesh, points = torus_mesh(lib)
    with mesh, library.Problem.create(mesh, lib.options({"willmore": 1.0})) as problem:
        energies, gradient = problem.evaluate(points, with_gradient=True)
        direction = np.random.default_rng(2).normal(size=points.shape)
        h = 1e-5
        ahead, behind = (problem.evaluate(points + s * h * direction)[0].objective for s in (1, -1))
    assert energies.objective == pytest.approx(energies.terms["willmore"], rel=1e-12)
    assert energies.gauss_bonnet_defect < 1e-2
    assert float((gradient * direction).sum()) == pytest.approx((ahead - behind) / (2 * h), rel=1e-5)


def test_jets_of_a_regular_corner_are_the_limit_point(lib):
    mesh, points = torus_mesh(lib)
    grid = points.reshape(8, 4, 3)
    with mesh:
        jets = mesh.jets(points, [0], [0], [[0.0, 0.0]])
    mask = np.array([1, 4, 1]) / 6
    expected = sum(mask[i + 1] * mask[j + 1] * grid[i, j] for i in (-1, 0, 1) for j in (-1, 0, 1))
    assert jets.shape == (1, 10, 3)
    assert np.allclose(jets[0, 0], expected, atol=1e-13)


# -------------------------------------------------------------------------------------------------- minimizing --


def test_minimize_reports_every_level(lib):
    mesh, points = torus_mesh(lib)
    seen = []
    with mesh:
        options = lib.options({"willmore": 1.0}, levels=2, max_iterations=30)
        with library.minimize(mesh, points, options, seen.append) as result:
            summary, cage = result.summary(), result.cage()
            levels = [result.level(i) for i in range(summary.n_levels)]
            with pytest.raises(library.CurvoptError):
                result.level(2)
    assert cage.positions.shape == (128, 3) and len(cage.face_sizes) == 128
    assert summary.end.terms["willmore"] < summary.start.terms["willmore"]
    assert [level.level for level in levels] == [1, 2] and [level.n_vertices for level in levels] == [32, 128]
    assert seen[0].start_energy == pytest.approx(summary.start.objective, rel=1e-6)
    assert {progress.level for progress in seen} == {1, 2} and seen[-1].n_vertices == 128


def test_callback_exception_comes_back_and_the_library_stays_usable(lib):
    class Mine(BaseException):
        pass

    def raising(progress):
        raise Mine(progress.iteration)

    mesh, points = torus_mesh(lib)
    with mesh:
        options = lib.options({"willmore": 1.0}, levels=1, max_iterations=50)
        with pytest.raises(Mine):
            library.minimize(mesh, points, options, raising)
        with library.minimize(mesh, points, options) as result:
            assert result.summary().stop != "cancelled"


def test_true_from_the_callback_cancels(lib):
    calls = []
    mesh, points = torus_mesh(lib)
    with mesh:
        options = lib.options({"willmore": 1.0}, levels=1)
        with library.minimize(mesh, points, options, lambda p: calls.append(p) or len(calls) == 2) as result:
            assert result.summary().stop == "cancelled"
            assert np.isfinite(result.cage().positions).all()
    assert len(calls) == 2


def test_cancel_from_another_thread(lib):
    mesh, points = torus_mesh(lib)
    going = threading.Event()
    with mesh, library.Cancel.create(lib) as cancel:
        canceller = threading.Thread(target=lambda: going.wait(20) and cancel.request())
        canceller.start()
        options = lib.options({"mvs": 1.0}, levels=6)
        with library.minimize(mesh, points, options, lambda p: going.set(), cancel) as result:
            assert result.summary().stop == "cancelled"
        canceller.join()


def test_open_cage_keeps_its_boundary(lib):
    points, faces = shapes.torus()
    with library.Mesh.create(lib, len(points), *shapes.packed(faces[1:])) as mesh:
        assert mesh.info().n_boundary_edges == 4
        with library.minimize(mesh, points, lib.options({"willmore": 1.0}, levels=1)) as result:
            moved = np.linalg.norm(result.cage().positions - points, axis=1)
    assert moved[faces[0]].max() < 1e-12 < 1e-3 < moved.max()


def test_held_vertices_stay_exactly_where_they_are(lib):
    """Also when nothing but the options remembers which they are."""
    mesh, points = torus_mesh(lib)
    held = [3, 7, 20]
    options = lib.options({"willmore": 1.0}, Held.exactly(np.array(held, np.int64)), levels=1)
    gc.collect()
    with mesh, library.minimize(mesh, points, options) as result:
        moved = np.abs(result.cage().positions - points).max(axis=1)
    assert moved[held].tolist() == [0, 0, 0] and np.delete(moved, held).min() > 1e-6


@pytest.mark.parametrize("symmetry", [0, 1])
@pytest.mark.parametrize("held", [[0], [1, 6, 30], list(range(20))])
def test_held_vertices_stay_or_go_with_their_patch(lib, held, symmetry):
    """The cages of every step, as the progress callback is shown them, and the result: single vertices are where they were
    on the last level, and will be after subdividing on the first; those of a patch are where subdividing puts them."""
    mesh, points = torus_mesh(lib)
    seen = {1: [points], 2: []}

    def look(progress, _user):
        now = progress.contents
        seen[now.level].append(np.ctypeslib.as_array(now.xyz, (now.n_vertices, 3)).copy())
        return 0

    options = lib.options({"mvs": 1.0}, Held.exactly(held), levels=2, max_iterations=5, symmetry=symmetry)
    raw = points.ctypes.data_as(abi.REALS)
    with mesh:
        callback = abi.PROGRESS_FN(look)
        pointer = lib.create("curvopt_minimize", mesh.pointer, raw, C.byref(options), callback, None, None)
        with library.Result(lib, pointer, "smooth") as result:
            seen[2].append(result.cage().positions)
        finer = [mesh.refine(cage)[1] for cage in seen[1]]
    for cages in seen.values():
        assert np.abs(cages[-1] - cages[0]).max() > 1e-3
    assert all(np.array_equal(cage[held], seen[2][0][held]) for cage in seen[2])
    if len(held) == 20:
        assert all(np.array_equal(cage[held], points[held]) for cage in seen[1])
        assert np.abs(seen[2][0][held] - finer[-1][held]).max() < 1e-14
    else:
        assert all(np.abs(cage[held] - points[held]).max() < 1e-14 for cage in finer[1:] + seen[2])


def test_vertices_are_held_as_firmly_as_their_weights_say(lib):
    mesh, points = torus_mesh(lib)
    off = []
    with mesh:
        for weight in (0.1, 0.99):
            held = Held(np.array([3, 14, 20]), np.array([weight, weight, 1.0]))
            options = lib.options({"willmore": 1.0}, held, levels=1, symmetry=1)
            gc.collect()
            with library.minimize(mesh, points, options) as result:
                off.append(np.linalg.norm(result.cage().positions - points, axis=1)[[3, 14, 20]])
    assert off[0][2] == off[1][2] == 0 and (0 < 3 * off[1][:2]).all() and (3 * off[1][:2] < off[0][:2]).all()


def test_held_vertices_are_checked(lib):
    mesh, points = torus_mesh(lib)
    with pytest.raises(ValueError, match="held must be integers"):
        lib.options({"mvs": 1.0}, Held.exactly([0.5]))
    with pytest.raises(ValueError, match="weights of held vertices holds 1 numbers, expected 2"):
        lib.options({"mvs": 1.0}, Held(np.array([0, 1]), np.array([0.5])))
    with pytest.raises(library.CurvoptError, match="constraint 0 on vertex 3 has the weight 1.5"):
        library.minimize(mesh, points, lib.options({"mvs": 1.0}, Held(np.array([3]), np.array([1.5])), levels=1))
    for held, match in (([0, 32], "vertex 32; there are 32"), (range(32), "nothing may move: all 32 vertices")):
        with pytest.raises(library.CurvoptError, match=match) as caught:
            library.minimize(mesh, points, lib.options({"willmore": 1.0}, Held.exactly(held), levels=1))
        assert caught.value.code == 1
    mesh.close()


def test_symmetries_that_were_kept_are_counted(lib):
    """A torus of 8 has 8 turns about its axis and 8 about lines across it, and all of these mirrored."""
    mesh, points = torus_mesh(lib)
    orders = []
    with mesh:
        for held, symmetry in (([], 0), ([], 1), ([0], 0)):
            options = lib.options({"willmore": 1.0}, Held.exactly(held), levels=1, max_iterations=2, symmetry=symmetry)
            with library.minimize(mesh, points, options) as result:
                orders.append(result.summary().symmetry_order)
    assert orders == [32, 1, 4]


def test_result_has_creases_and_a_verdict(lib):
    ring = np.array([[4 * i, 4 * ((i + 1) % 8)] for i in range(8)])
    points, faces = shapes.torus()
    creases = library.Creases(ring, np.full(8, 1.5), rule="corners")
    with library.Mesh.create(lib, len(points), *shapes.packed(faces), creases) as mesh:
        options = lib.options({"willmore": 1.0}, levels=2, max_iterations=20)
        with library.minimize(mesh, points, options) as result:
            kept, found = result.cage().creases, result.summary().verification
    assert kept.edge_sharpness.tolist() == [0.5] * 16 and kept.rule == "corners"
    assert found.verdict in abi.VERDICTS and found.negative_directions >= -1


def test_verdict_on_a_minimum(lib):
    points, faces = shapes.grid(7)
    with library.Mesh.create(lib, len(points), *shapes.packed(faces), library.Creases(rule="corners")) as mesh:
        with library.minimize(mesh, points, lib.options({"willmore": 1.0}, levels=1, boundary=2)) as result:
            summary = result.summary()
    found, energy = summary.verification, summary.end.objective
    assert (found.verdict, found.negative_directions) == ("minimum", 0) and 0 <= found.newton_decrement < 1e-6 * energy


def test_positions_that_are_no_numbers_are_refused_by_vertex(lib):
    mesh, points = torus_mesh(lib)
    points[5, 1] = np.nan
    with mesh, pytest.raises(library.CurvoptError, match="5") as caught:
        library.minimize(mesh, points, lib.options({"willmore": 1.0}))
    assert (caught.value.code, caught.value.element) == (5, 5)
