# SPDX-License-Identifier: GPL-3.0-or-later
"""Marked edges in Object Mode: on the boundary they say what stays, in place of Boundary."""

import bpy
import numpy as np
import pytest
import shapes
from runs import minimize, positions

N = 8  # quads of the sheet along a side
SIDE = [(x, x + 1) for x in range(N)]  # its edges over y = 0


@pytest.fixture
def sheet(add):
    """The active object: N x N quads, bumpy, open; vertex y * (N + 1) + x is over (x, y)."""
    points, faces = shapes.grid(N)
    points[:, 2] += 0.15 * np.random.default_rng(12).normal(size=len(points))
    obj = add(points, faces, name="Sheet")
    obj.modifiers.new("Limit", "SUBSURF").boundary_smooth = "PRESERVE_CORNERS"
    return obj


@pytest.fixture
def mark(part):
    """Marks edges of an object, given by pairs of vertices."""

    def mark_edges(obj, pairs, rim):
        index = {tuple(sorted(edge.vertices)): edge.index for edge in obj.data.edges}
        name = part("scene.read_marks").MARK
        layer = obj.data.attributes.get(name) or obj.data.attributes.new(name, "INT", "EDGE")
        for pair in pairs:
            layer.data[index[tuple(sorted(pair))]].value = part("core.rims").MARKS.index(rim)

    return mark_edges


def still(obj, result):
    """Rows y of vertices in the middle of the sheet that have not moved."""
    moved = (positions(obj) != positions(result)).any(axis=1).reshape(N + 1, N + 1)
    return np.flatnonzero(~moved[:, N // 2]).tolist()


@pytest.mark.parametrize("boundary, end", [("POSITION", [N]), ("FREE", [])])
@pytest.mark.parametrize("rim, rows", [("position", 1), ("tangent", 2), ("curvature", 3)])
def test_marks_say_for_single_edges_what_stays(sheet, mark, part, boundary, end, rim, rows):
    mark(sheet, SIDE, rim)
    result = minimize(sheet, boundary=boundary, strength=0.5)
    assert still(sheet, result) == [*range(rows), *end]
    assert f"Of {N} edges of the boundary the marks say what stays" in part("ui.properties").state.message


def test_free_lets_a_side_move_and_no_mark_is_as_before(sheet, mark, part):
    assert still(sheet, minimize(sheet, boundary="POSITION", strength=0.5)) == [0, N]
    assert "marks" not in part("ui.properties").state.message
    mark(sheet, SIDE, "free")
    assert still(sheet, minimize(sheet, boundary="POSITION", strength=0.5)) == [N]
    mark(sheet, SIDE, "")
    assert still(sheet, minimize(sheet, boundary="POSITION", strength=0.5)) == [0, N]
    assert "marks" not in part("ui.properties").state.message


def test_the_marks_of_mark_rim_are_these(sheet):
    """Made in Edit Mode by the operator, used in Object Mode."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    assert bpy.ops.curvopt.mark_rim(rim="TANGENT") == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert still(sheet, minimize(sheet, boundary="FREE", strength=0.5)) == [0, 1, N - 1, N]


def test_what_a_refined_cage_cannot_do_is_refused_in_a_sentence(sheet, mark, contents):
    mark(sheet, SIDE, "free")
    before = contents()
    with pytest.raises(RuntimeError, match=r"Use the cage's own vertices \(Same Vertices, one level\), or mark"):
        minimize(sheet, boundary="POSITION", resolution="REFINE", levels=2)
    assert contents() == before
    mark(sheet, SIDE, "tangent")
    result = minimize(sheet, boundary="POSITION", resolution="REFINE", levels=2, strength=0.5)
    assert len(result.data.vertices) == (2 * N + 1) ** 2


def test_pins_of_other_vertices_stay_and_amount_and_strength_can_be_adjusted(sheet, mark, part):
    middle = (N // 2) * (N + 1) + N // 2
    sheet.vertex_groups.new(name="Pins").add([middle], 1.0, "REPLACE")
    mark(sheet, SIDE, "tangent")
    result = minimize(sheet, boundary="FREE", strength=0.5, pin="GROUP", vertex_group="Pins")
    assert still(sheet, result) == [0, 1, N // 2]
    bpy.data.objects.remove(result)
    bpy.context.view_layer.objects.active = sheet
    assert bpy.ops.curvopt.apply_result(number=part("ui.adjust")._finished[0], strength=0.8) == {"FINISHED"}
    assert still(sheet, bpy.context.view_layer.objects.active) == [0, 1, N // 2]


def test_marks_of_half_a_cage_are_marks_of_the_whole(sheet, mark, part):
    """Mirror across x at the side x = 0, which is then no boundary: marks there hold nothing."""
    sheet.modifiers.new("Mirror", "MIRROR")
    bpy.ops.object.modifier_move_to_index(modifier="Mirror", index=0)
    seam = [(y * (N + 1), (y + 1) * (N + 1)) for y in range(N)]
    points = positions(sheet)
    points[:: N + 1, 0] = 0
    sheet.data.vertices.foreach_set("co", points.ravel())
    mark(sheet, [*SIDE, *seam], "tangent")
    result = minimize(sheet, boundary="FREE", strength=0.5)
    assert still(sheet, result) == [0, 1]
    assert f"Of {2 * N} edges of the boundary" in part("ui.properties").state.message


def test_an_attribute_of_that_name_that_is_something_else_is_refused(sheet, part):
    sheet.data.attributes.new(part("scene.read_marks").MARK, "FLOAT", "EDGE")
    with pytest.raises(RuntimeError, match="is no integer of edges: delete it, and mark edges with Mark Rim again"):
        minimize(sheet)


def test_marks_count_in_the_batch_command(sheet, mark, part, tmp_path, capsys):
    mark(sheet, SIDE, "tangent")
    report = str(tmp_path / "out.json")
    arguments = ["--energy", "willmore", "--levels", "1", "--strength", "0.5", "--boundary", "free", "--json", report]
    assert part("batch.command").main(arguments) == 0
    assert f"Of {N} edges of the boundary the marks say what stays" in "".join(capsys.readouterr())
    assert still(sheet, bpy.context.view_layer.objects.active) == [0, 1]
