# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices move in a part of a cage, which faces change, and who is whose mirror image; without Blender."""

from dataclasses import replace

import numpy as np
import pytest
import shapes
from addon.binding import abi, library
from addon.binding.values import Cage, Creases, Held
from addon.core import job, partners, rims, targets
from addon.core.crop import Crop

N = 10  # quads of the grid along a side; its vertex y * (N + 1) + x is over (x, y)


def cage_of(points, faces, creases=None):
    sizes, vertices = (np.array(part, np.int32) for part in shapes.packed(faces))
    return Cage(np.array(points, float), sizes, vertices, creases or Creases())


def grid(creases=None):
    return cage_of(*shapes.grid(N), creases)


def block(low, high):
    """The grid's vertices low .. high along both axes, as a mask."""
    at = np.arange(N + 1)
    inside = (at >= low) & (at <= high)
    return (inside[:, None] & inside[None, :]).reshape(-1)


def part_of(selected, marks=None):
    """`marks` by pairs of vertices."""
    edges = np.array(list(marks or {}), np.int32).reshape(-1, 2)
    return rims.Part(selected, edges, np.array([rims.MARKS.index(name) for name in (marks or {}).values()], np.int32))


def moving(selected, rim="free", boundary="free", marks=None, cage=None):
    return rims.moving_vertices(cage or grid(), part_of(selected, marks), rim, boundary)


@pytest.mark.parametrize("rim, rows", rims.ROWS.items())
def test_each_row_takes_a_ring_of_vertices_from_the_selection(rim, rows):
    assert np.array_equal(moving(block(1, 9), rim), block(1 + rows, 9 - rows))


@pytest.mark.parametrize("boundary, rows", rims.ROWS.items())
def test_rows_of_the_boundary_are_those_of_the_library(boundary, rows):
    """What a run of the library holds by itself and what is held for it, with all vertices selected."""
    cage, found = grid(Creases(rule="corners")), moving(np.ones((N + 1) ** 2, bool), boundary=boundary)
    assert np.array_equal(found, block(rows, N - rows))
    theirs = job.solve(cage, job.Request("willmore", 1, boundary=boundary, options={"max_iterations": 5}))
    assert np.array_equal((theirs.cage.positions != cage.positions).any(axis=1), found)


def test_rows_are_counted_over_selected_faces_only():
    """Two blocks side by side, a column of faces between them: the rim of one holds nothing of the other."""
    selected = np.zeros((N + 1, N + 1), bool)
    selected[0:5, 1:5] = selected[0:5, 6:10] = True
    found = moving(selected.reshape(-1), "tangent").reshape(N + 1, N + 1)
    assert found[:3, 3].sum() == 0 and not found[:, [1, 2, 3, 4]].any()
    selected[0:5, 1:10] = True
    assert moving(selected.reshape(-1), "tangent").reshape(N + 1, N + 1)[:3, 3:8].all()


def test_a_selected_vertex_without_a_selected_face_moves_with_a_free_rim_only():
    selected = np.zeros((N + 1) ** 2, bool)
    selected[[60, 61]] = True
    assert np.array_equal(moving(selected), selected)
    assert not moving(selected, "position").any()


def test_marks_are_for_their_edges():
    """The lower rim of the block is marked, once each way; the other three sides are as the setting says."""
    low = {(y, y + 1): "tangent" for y in range(3 * (N + 1) + 3, 3 * (N + 1) + 7)}
    low = {(b, a) if a % 2 else (a, b): name for (a, b), name in low.items()}
    found = moving(block(3, 7), marks=low).reshape(N + 1, N + 1)
    assert not found[3:5].any() and found[5:8, 3:8].all() and found.sum() == 15
    found = moving(block(3, 7), "position", marks={edge: "free" for edge in low}).reshape(N + 1, N + 1)
    assert np.array_equal(np.argwhere(found)[:, 0].min(), 3) and found[3, 4:7].all() and not found[3, [3, 7]].any()


def test_marks_inside_the_selection_and_unknown_ones_hold_nothing():
    inside = {(5 * (N + 1) + 5, 5 * (N + 1) + 6): "curvature"}
    assert np.array_equal(moving(block(3, 7), marks=inside), block(3, 7))
    part = rims.Part(block(3, 7), np.array([[3 * (N + 1) + 3, 3 * (N + 1) + 4], [0, 60]]), np.array([77, 2]))
    assert np.array_equal(rims.moving_vertices(grid(), part, "free", "free"), block(3, 7))


def test_marks_on_the_boundary_override_the_setting():
    lower = {(x, x + 1): "free" for x in range(N)}
    found = moving(np.ones((N + 1) ** 2, bool), boundary="position", marks=lower).reshape(N + 1, N + 1)
    assert found[:N, 1:N].all() and found.sum() == N * (N - 1)
    lower = {edge: "tangent" for edge in lower}
    found = moving(np.ones((N + 1) ** 2, bool), marks=lower).reshape(N + 1, N + 1)
    assert not found[:2].any() and found[2:].all()


def test_infinitely_sharp_vertices_and_creases_stay_unless_boundaries_are_free():
    edges, vertices = np.array([[48, 49]], np.int32), np.array([60, 61], np.int32)
    sharp = Creases(edges, np.array([10.0]), vertices, np.array([10.0, 5.0]))
    found = moving(block(1, 9), boundary="position", cage=grid(sharp))
    assert np.flatnonzero(block(1, 9) & ~found).tolist() == [48, 49, 60]
    assert np.array_equal(moving(block(1, 9), cage=grid(sharp)), block(1, 9))


def limit_points(cage, xyz):
    faces = np.repeat(np.arange(len(cage.face_sizes)), 4)
    uv = np.tile([[0.0, 0.0], [0.6, 0.1], [0.9, 0.9], [0.4, 0.5]], (len(cage.face_sizes), 1))
    with library.Mesh.of_cage(library.load(), cage) as mesh:
        return mesh.jets(xyz, faces, np.zeros(len(faces)).astype(int), uv)[:, 0].reshape(-1, 12)


@pytest.mark.parametrize("vertices", [[60], [0], [5], [33, 34, 90]])
def test_faces_that_change_are_those_whose_limit_surface_does(vertices):
    cage, free = grid(), np.zeros((N + 1) ** 2, bool)
    free[vertices] = True
    moved = cage.positions + np.outer(free, (0.3, -0.2, 0.5))
    differ = (limit_points(cage, moved) != limit_points(cage, cage.positions)).any(axis=1)
    assert np.array_equal(rims.changing_faces(cage, free), differ)


# curvopt_spacing: else the mean edge, which is that of faces that count, has a part in it; and less than the rules differ by
FREELY = {"spacing": 2, "tolerance": 1e-6}


def run(cage, free, whole=False, energy="willmore", strength=1.0):
    """The `whole` surface, or only the faces that change."""
    holes = np.flatnonzero(~rims.changing_faces(cage, free) & (not whole)).astype(np.int32)
    held = Held.exactly(np.flatnonzero(~free))
    request = job.Request(energy, 1, FREELY, boundary="free", held=held, holes=holes, strength=strength)
    return job.solve(cage, request)


def rough_torus(noise):
    """A cage, and a part of its vertices (n,)."""
    points, faces = shapes.torus(16, 8)
    free = np.zeros(len(points), bool)
    free[[17, 18, 25, 26, 27, 33, 34]] = True
    return cage_of(points + noise * np.random.default_rng(5).normal(size=points.shape), faces), free


def test_a_run_with_holes_ends_where_one_with_pins_does():
    cage, free = rough_torus(0.05)
    rough, part, whole = cage.positions, run(cage, free), run(cage, free, whole=True)
    assert np.array_equal((part.cage.positions != rough).any(axis=1), free)
    assert part.start.objective - part.end.objective == pytest.approx(whole.start.objective - whole.end.objective, 1e-4)
    assert part.start.objective < 0.8 * whole.start.objective
    assert part.exceptions.n_held == part.exceptions.n_left_out == 0


@pytest.mark.parametrize("energy", ["willmore", "mvs"])
def test_strength_is_the_same_with_holes(energy):
    """Third-order energies have the area of the faces that count as a factor; so have the springs then."""
    cage, free = rough_torus(0.02)
    ends = [run(cage, free, all_faces, energy, 0.3).cage.positions for all_faces in (False, True)]
    sizes = [np.sqrt(((end - cage.positions)[free] ** 2).mean()) for end in ends]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.05) and sizes[0] > 5e-5


@pytest.mark.parametrize("surface", ["auto", "plane"])
@pytest.mark.parametrize("strength", [0.3, 1.0])
def test_what_is_cropped_ends_as_the_whole_does(surface, strength):
    """A grid with creases, of a sharp corner and of a triangle, apart from the size of what the library sees."""
    creases = Creases(
        np.array([[48, 49], [49, 50], [0, 1]], np.int32), np.array([2.5, 2.5, 10.0]), np.array([71, 5], np.int32),
        np.array([1.5, 3.0]),
    )  # fmt: skip
    points, faces = shapes.grid(N)
    faces[44:45] = [faces[44][:3], [faces[44][0], *faces[44][2:]]]
    points[:, 2] += 0.1 * np.random.default_rng(8).normal(size=len(points))
    cage, free = cage_of(points, faces, creases), block(5, 6)
    holes = np.flatnonzero(~rims.changing_faces(cage, free)).astype(np.int32)
    held = Held.exactly(np.flatnonzero(~free))
    options = {"surface": abi.SURFACES.index(surface)}
    request = job.Request("willmore", 1, options, "free", "none", held, strength, holes)
    assert job._can_be_cropped(cage, request)
    seeing = replace(request, options={**options, "no_crossings": 1})
    assert not job._can_be_cropped(cage, seeing)  # faces that do not change are in the way
    part, whole = job.solve(cage, request), job._solve(cage, request, None, None, None)
    crop = Crop.of_faces(cage, job._counted(cage, request))
    assert len(crop.cage.positions) == 10 * 10 and len(crop.cage.creases.edges) == 2
    assert np.abs(part.cage.positions - whole.cage.positions).max() < 2e-5 and part.euler == whole.euler == 1
    assert part.start.objective == pytest.approx(whole.start.objective, 1e-9)
    assert part.end.objective == pytest.approx(whole.end.objective, 1e-6)
    assert np.array_equal(part.cage.face_vertices, cage.face_vertices) and part.cage.creases is cage.creases


def with_cone(cage, vertex):
    return replace(cage, creases=replace(cage.creases, vertices=np.array([vertex]), vertex_sharpness=np.array([10.0])))


def test_a_selection_without_finite_energy_is_refused_in_a_sentence():
    """One that is infinitely sharp."""
    cage = with_cone(cage_of(*shapes.grid(N)), 60)
    free = np.arange(121) == 60
    with pytest.raises(library.CurvoptError, match="nothing may move: where the selection is, the surface"):
        run(cage, free)


def test_only_exceptions_that_hold_the_selection_count():
    """An infinitely sharp vertex beside the selection, with which it shares one face."""
    cage = with_cone(cage_of(*shapes.grid(N)), 12)
    found = run(cage, block(2, 7)).exceptions
    assert [vertices.tolist() for _, vertices in found.reasons] == [[12]]
    assert found.n_held == found.n_left_out == 1
    far = run(cage, block(6, 8)).exceptions
    assert far.n_held == far.n_left_out == 0 and not far.reasons


# -------------------------------------------------------------------------------------------------------- partners --


def test_partners_are_the_nearest_within_the_tolerance():
    points = np.array([(1, 2, 3), (-1, 2, 3 + 1e-5), (-1, 2, 3 + 2e-4), (0, 5, 0), (4, 0, 0), (-4.1, 0, 0)], float)
    assert partners.Pairs.of_points(points, 0).partner.tolist() == [1, 0, -1, 3, -1, -1]
    random = np.random.default_rng(3).normal(size=(300, 3))
    both = np.concatenate([random, random * (1, -1, 1)])
    assert np.array_equal(partners.Pairs.of_points(both, 1).partner, (np.arange(600) + 300) % 600)
    assert (partners.Pairs.of_points(both + (0, 0.1, 0), 1).partner == -1).all()


def test_images_of_images_are_chosen_for_several_axes():
    points = np.array([(x, y, 1) for x in (-1, 1) for y in (-1, 1)], float)
    pairs = [partners.Pairs.of_points(points, axis) for axis in (0, 1)]
    assert partners.with_partners(np.array([True, False, False, False]), pairs).all()
    assert partners.with_partners(np.array([True, False, False, False]), pairs[:1]).tolist() == [1, 0, 1, 0]


def test_the_mean_of_both_sides_is_symmetric_and_leaves_the_rest():
    points = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (3, 3, 3), (2, 0, 1), (-2, 0, 1)], float)
    pair = partners.Pairs.of_points(points, 0)
    moved = points + np.random.default_rng(1).normal(size=points.shape) * 0.1
    moving = np.array([True, True, True, True, True, False])
    mean = partners.mean_of_sides(moved, moving, [pair])
    assert np.array_equal(mean[0], mean[1] * (-1, 1, 1)) and mean[2, 0] == 0
    assert np.array_equal(mean[3:], moved[3:])


def test_symmetric_cages_are_found_to_be_so():
    cage = cage_of(*shapes.torus())
    everything = np.ones(32, bool)
    for axis in range(3):
        pair = partners.Pairs.of_points(cage.positions, axis)
        assert partners.is_symmetric(cage, everything, pair)
        half = cage.positions[:, axis] > 0.1
        assert not partners.is_symmetric(cage, half, pair)
        creases = Creases(np.array([[0, 4]]), np.array([2.0]))
        creased = Cage(cage.positions, cage.face_sizes, cage.face_vertices, creases)
        assert partners.is_symmetric(creased, everything, pair) == (pair.partner[[0, 4]].tolist() in ([0, 4], [4, 0]))
    moved = cage.positions.copy()
    moved[3, 0] += 1e-3
    assert not partners.is_symmetric(
        Cage(moved, cage.face_sizes, cage.face_vertices), everything, partners.Pairs.of_points(moved, 0)
    )


def test_what_only_position_holds_may_slide():
    """Of a selection that meets the boundary: its vertices there. Not with other boundaries, not with a mark Free."""
    cage, part = grid(), part_of(block(0, 5))
    found = rims.sliding_vertices(cage, part, "free", "position")
    assert np.array_equal(found, block(0, 5) & ~block(1, 9))
    assert not any(rims.sliding_vertices(cage, part, "free", name).any() for name in ("tangent", "curvature", "free"))
    marked = part_of(block(0, 5), {(1, 2): "free", (0, 1): "free", (2, 3): "free"})
    assert not rims.sliding_vertices(cage, marked, "free", "position").any()


def test_curves_along_which_vertices_slide():
    """A boundary that Position holds, or a crease that any boundary but Free holds."""
    names = ("free", "position", "tangent", "curvature")
    assert [rims.has_curves(grid(), name) for name in names] == [False, True, False, False]
    closed = cage_of(*shapes.torus())
    assert not any(rims.has_curves(closed, name) for name in names)
    for sharpness, there in ((10.0, True), (2.0, False)):
        creased = replace(closed, creases=Creases(np.array([[0, 4]]), np.array([sharpness])))
        assert [rims.has_curves(creased, name) for name in names] == [False, there, there, there]


# ----------------------------------------------------------------------------------------- marks of a whole cage --


def side(y, rim):
    """Marks of the grid's edges over that y."""
    return {(y * (N + 1) + x, y * (N + 1) + x + 1): rim for x in range(N)}


def marked(boundary, marks, levels=1, cage=None, held=None, **more):
    part = part_of(np.ones((N + 1) ** 2, bool), marks)
    request = job.Request("willmore", levels, boundary=boundary, held=held or Held(), symmetry="none", **more)
    return job.with_marks(cage or grid(), request, part.edges, part.marks)


@pytest.mark.parametrize("boundary", rims.ROWS)
@pytest.mark.parametrize("first", ["free", "position", "tangent", "curvature"])
@pytest.mark.parametrize("second", ["", "free", "curvature"])
def test_without_a_selection_marks_hold_what_they_hold_in_edit_mode(boundary, first, second):
    """On one level, for marks on one side of the grid and on two."""
    cage, marks = grid(), {**side(0, first), **({**side(N, second)} if second else {})}
    request = marked(boundary, marks)
    assert request.marked == len(marks)
    solution = job.solve(cage, replace(request, options={"max_iterations": 5}))
    moved = (solution.cage.positions != cage.positions).any(axis=1)
    expected = moving(np.ones((N + 1) ** 2, bool), "free", boundary, marks)
    if not expected.all():  # else all of it is put back in place, by rounding
        assert np.array_equal(moved, expected)


def test_creases_stay_as_boundary_says_whatever_marks_free():
    crease = Creases(np.array([[60, 61]]), np.array([10.0]))
    for boundary, stays in (("position", True), ("free", False)):
        free = marked(boundary, side(0, "free"), cage=grid(crease)).free((N + 1) ** 2)
        assert not free[[60, 61]].any() if stays else free[[60, 61]].all()


def test_marks_elsewhere_and_other_pins_stay_as_they_are():
    pins = Held(np.array([30, 5]), np.array([0.5, 0.25]))
    inside = {(60, 61): "curvature"}
    assert marked("tangent", inside, held=pins).held is pins and marked("tangent", inside).marked == 0
    request = marked("position", {**side(0, "tangent"), **inside}, held=pins)
    weights = dict(zip(request.held.vertices.tolist(), request.held.weights.tolist()))
    assert weights[30] == 0.5 and weights[5] == weights[16] == 1 and len(weights) == 2 * (N + 1) + 1


@pytest.mark.parametrize("boundary", ["position", "free"])
@pytest.mark.parametrize("rim, rows", [("tangent", 2), ("curvature", 4)])
def test_a_refined_cage_keeps_curves_and_what_is_asked_for_beside_them(boundary, rim, rows):
    """The rows of the finer cage that depend on rows that are held of the first one are where the original has them."""
    cage = grid()
    points = cage.positions.copy()
    points[:, 2] += 0.1 * np.random.default_rng(4).normal(size=len(points))
    cage = replace(cage, positions=points)
    request = marked(boundary, side(0, rim), levels=2, cage=cage)
    solution = job.solve(cage, request)
    start, end = solution.start_positions, solution.cage.positions
    size = np.ptp(start, axis=0).max()
    gone = np.linalg.norm(end - start, axis=1) / size
    strip = start[:, 1] < 0.5 * (rows - 1) + 0.1  # y of the first one's rows is 0, 1, 2
    inner = (start[:, 0] > 2) & (start[:, 0] < N - 2)
    assert gone[strip & inner].max() < 1e-9 < 1e-4 < gone[~strip & inner & (start[:, 1] < rows / 2 + 0.1)].max()
    last = inner & (start[:, 1] > N - 0.1)
    assert (gone[last].max() < 1e-9) == (boundary == "position")


@pytest.mark.parametrize("boundary, rim", [("position", "free"), ("free", "position"), ("curvature", "free")])
def test_a_refined_cage_cannot_free_some_edges_and_keep_curves(boundary, rim):
    if boundary != "curvature":
        with pytest.raises(ValueError, match="a refined cage cannot do both. Use the cage's own vertices"):
            marked(boundary, side(0, rim), levels=2)
    else:
        assert marked(boundary, side(0, rim), levels=2).boundary == "free"
    assert marked(boundary, side(0, rim)).refinable == (boundary == "curvature")


def test_pins_on_the_surface_stay_on_it_beside_marks():
    """What marks hold are vertices; the pin's own vertex moves."""
    cage, pin = grid(), (N + 1) * (N // 2) + N // 2
    request = marked("position", side(0, "tangent"), cage=cage, held=Held(np.array([pin]), np.ones(1), True))
    moved = job.solve(cage, replace(request, options={"max_iterations": 20})).cage
    assert np.abs(targets.limit_points(moved) - targets.limit_points(cage))[pin].max() < 1e-9
    assert np.abs(moved.positions - cage.positions)[pin].max() > 1e-3
    assert (moved.positions[: 2 * (N + 1)] == cage.positions[: 2 * (N + 1)]).all()


def test_a_cage_all_of_which_marks_hold_is_refined_where_that_frees_some():
    strip = cage_of([(0, 0, 0), (1, 0, 0), (3, 0, 0), (0, 1, 0), (1, 1, 0.2), (3, 1, 0.6)], [[0, 1, 4, 3], [1, 2, 5, 4]])
    request = job.Request("willmore", 1, boundary="free")
    pairs = np.array([(0, 1), (1, 2), (2, 5), (5, 4), (4, 3), (3, 0)])
    kept = job.with_marks(strip, request, pairs, np.full(6, rims.MARKS.index("position")))
    assert not kept.free(6).any() and job.freed(strip, kept) is kept
    with pytest.raises(library.CurvoptError, match="nothing may move"):
        job.solve(strip, kept)
