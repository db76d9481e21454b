# SPDX-License-Identifier: GPL-3.0-or-later
"""The batch command as people run it: another Blender, exit codes, and what lies on disk afterwards."""

import io
import json
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
import shapes
from mathutils import Vector

VERIFICATION = {"verdict", "newton_decrement", "negative_directions", "touch_rise", "delicate"}  # as the command line's
QUICK_PICTURE = ["--size", "240x120", "--samples", "4"]


@pytest.fixture
def cage_file(torus, tmp_path):
    """A .blend with the active object Torus and another mesh, Spare; nothing else in its folder."""
    folder = tmp_path / "work"
    folder.mkdir()
    spare = bpy.data.objects.new("Spare", torus.data.copy())
    bpy.context.scene.collection.objects.link(spare)
    path = folder / "cage.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def blender(cage_file, *arguments):
    """A background Blender with the file open: (exit code, lines of stderr)."""
    command = [bpy.app.binary_path, "-b", "--factory-startup", str(cage_file), "--python-exit-code", "1", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, cwd=cage_file.parent)
    return done.returncode, done.stderr.strip().split("\n")


@pytest.fixture(scope="module")
def noise(tmp_path_factory):
    """What this Blender writes to stderr by itself, such as remarks about the machine."""
    path = tmp_path_factory.mktemp("noise") / "empty.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return {"", *blender(path, "--python-expr", "pass")[1]}


@pytest.fixture
def batch(cage_file, part, noise):
    """Runs the installed add-on's batch.py on the file: (exit code, its lines on stderr, new files in its folder)."""
    program = Path(part("binding").__file__).parents[1] / "batch.py"

    def run(*arguments):
        code, lines = blender(cage_file, "-P", str(program), "--", *map(str, arguments))
        new = sorted(path.name for path in cage_file.parent.iterdir() if path != cage_file)
        return code, [line for line in lines if line not in noise], new

    return run


def save_again(cage_file):
    """Save the open file there, without leaving the older one beside it."""
    bpy.ops.wm.save_as_mainfile(filepath=str(cage_file), copy=True)
    for left in cage_file.parent.glob("*.blend1"):
        left.unlink()


def pixels(path):
    """(height, width, 3), bottom row first, 0 .. 1."""
    image = bpy.data.images.load(str(path))
    width, height = image.size
    return np.array(image.pixels[:]).reshape(height, width, 4)[:, :, :3]


def test_blend_picture_and_report_are_written(batch, cage_file):
    original = cage_file.read_bytes()
    outputs = ["--output", "out.blend", "--render", "out.png", "--json", "out.json"]
    work = ["--energy", "mvs", "--levels", "2", "--max-iterations", "40"]
    code, errors, new = batch(*work, *outputs, *QUICK_PICTURE)
    assert (code, errors, new) == (0, [], ["out.blend", "out.json", "out.png"])
    assert cage_file.read_bytes() == original
    _check_report(json.loads((cage_file.parent / "out.json").read_text()))
    _check_picture(pixels(cage_file.parent / "out.png"))
    bpy.ops.wm.open_mainfile(filepath=str(cage_file.parent / "out.blend"))
    assert sorted(obj.name for obj in bpy.data.objects) == ["Spare", "Torus", "Torus MVS"]
    assert [scene.name for scene in bpy.data.scenes] == ["Scene"] and not bpy.data.materials
    assert len(bpy.data.objects["Torus MVS"].data.vertices) == 128


def _check_report(report):
    assert (report["object"], report["result"], report["energy"]) == ("Torus", "Torus MVS", "mvs")
    assert (report["vertices"], report["faces"], report["euler"]) == (128, 128, 0)
    keys = {"area", "willmore", "h2", "mvs", "mvs_cross", "gauss", "gauss_bonnet_defect", "quadrature_error", "surface"}
    assert keys <= set(report) and keys <= set(report["before"])
    assert report["mvs"] < report["before"]["mvs"]
    assert [level["vertices"] for level in report["levels"]] == [32, 128]
    assert report["boundary"] == "position" and set(report["verification"]) == VERIFICATION
    assert report["verification"]["verdict"] in ("minimum", "saddle", "not stationary")
    level = {"level", "vertices", "iterations", "evaluations", "energy", "gradient_norm", "seconds", "stop"}
    assert set(report["levels"][0]) == level


def _check_picture(image):
    assert image.shape == (120, 240, 3)
    paper = image[-1, 0]
    drawn = np.abs(image - paper).max(axis=2) > 0.1
    for half in (drawn[:, :120], drawn[:, 120:]):
        assert 0.1 < half.mean() < 0.7
    assert not drawn[[0, -1]].any() and not drawn[:, [0, 119, 120, 239]].any()  # both are whole and apart


def test_zebra_picture_has_stripes(batch, cage_file):
    code, _, new = batch("--energy", "willmore", "--levels", 1, "--render", "z.png", "--look", "zebra", *QUICK_PICTURE)
    assert (code, new) == (0, ["z.png"])
    middle = pixels(cage_file.parent / "z.png")[:, 60, 0]
    assert (np.abs(np.diff((middle > 0.5).astype(int)))).sum() >= 8


def test_creases_and_boundary_are_minded(batch, cage_file, torus, crease):
    """A ring of creases stays where it is, unless the boundary is free; the result remembers its verdict."""
    crease(torus, {(4 * i, 4 * ((i + 1) % 8)): 1.0 for i in range(8)})
    save_again(cage_file)
    common = ["--energy", "willmore", "--levels", "1", "--max-iterations", "5"]
    kept = _ring_of_result(batch, cage_file, *common, "--output", "held.blend")
    freed = _ring_of_result(batch, cage_file, *common, "--boundary", "free", "--output", "free.blend")
    start = shapes.torus()[0][::4]
    assert np.abs(kept - start).max() < 1e-6 and np.abs(freed - start).max() > 1e-3


def _ring_of_result(batch, cage_file, *arguments):
    assert batch(*arguments)[:2] == (0, [])
    bpy.ops.wm.open_mainfile(filepath=str(cage_file.parent / arguments[-1]))
    result = bpy.data.objects["Torus Willmore"]
    assert result["curvopt_verdict"].endswith(".")
    return np.array([vertex.co for vertex in result.data.vertices])[::4]


def test_pins_and_symmetry(batch, cage_file, torus):
    torus.vertex_groups.new(name="My pins").add([0, 16], 1.0, "REPLACE")
    save_again(cage_file)
    common = ["--energy", "willmore", "--levels", "1", "--json", "out.json", "--output", "out.blend"]
    start = shapes.torus()[0].astype(np.float32)
    for arguments, order, kept in (
        ([], 32, []),
        (["--symmetry", "none"], 1, []),
        (["--pin-group", "My pins"], 8, [0, 16]),
        (["--pin-group", "My pins", "--symmetry", "none"], 1, [0, 16]),
    ):
        assert batch(*common, *arguments)[:2] == (0, [])
        assert json.loads((cage_file.parent / "out.json").read_text())["symmetry_order"] == order
        bpy.ops.wm.open_mainfile(filepath=str(cage_file.parent / "out.blend"))
        result = bpy.data.objects["Torus Willmore"]
        moved = np.abs(np.array([vertex.co for vertex in result.data.vertices]) - start).max(axis=1)
        assert np.flatnonzero(moved == 0).tolist() == kept


def test_through_a_collection(batch, cage_file, torus):
    """An empty above the torus, its Z axis tilted; a collection that is not there."""
    targets = bpy.data.collections.new("Targets")
    bpy.context.scene.collection.children.link(targets)
    empty = bpy.data.objects.new("Place", None)
    targets.objects.link(empty)
    empty.location, empty.rotation_euler = (1.0, 0.1, 0.6), (0.3, 0.0, 0.0)
    bpy.context.view_layer.objects.active = torus
    save_again(cage_file)
    common = ["--energy", "willmore", "--levels", "1", "--output", "out.blend"]
    assert batch(*common, "--through", "Targets", "--through-normals")[:2] == (0, [])
    bpy.ops.wm.open_mainfile(filepath=str(cage_file.parent / "out.blend"))
    result = bpy.data.objects["Torus Willmore"]
    modifier = next(m for m in result.modifiers if m.type == "SUBSURF")
    modifier.levels, modifier.use_limit_surface, modifier.quality = 5, True, 10
    found = result.evaluated_get(bpy.context.evaluated_depsgraph_get()).closest_point_on_mesh((1.0, 0.1, 0.6))
    assert (found[1] - Vector((1.0, 0.1, 0.6))).length < 2e-4
    assert abs(found[2].dot(Vector((0, -np.sin(0.3), np.cos(0.3))))) > 0.9995
    code, lines, _ = batch(*common, "--through", "Nothing")
    assert code == 1 and "There is no collection 'Nothing'" in lines[-1]


def test_near_a_collection(batch, cage_file, torus):
    """Drawn to two empties over each other it goes through one at most; weights that are none."""
    targets = bpy.data.collections.new("Targets")
    bpy.context.scene.collection.children.link(targets)
    for height in (0.6, 0.9):
        empty = bpy.data.objects.new("Place", None)
        targets.objects.link(empty)
        empty.location = (1.0, 0.1, height)
    bpy.context.view_layer.objects.active = torus
    save_again(cage_file)
    common = ["--energy", "willmore", "--levels", "1", "--output", "out.blend", "--through", "Targets"]
    assert batch(*common, "--through-weight", "0.2")[:2] == (0, [])
    bpy.ops.wm.open_mainfile(filepath=str(cage_file.parent / "out.blend"))
    result = bpy.data.objects["Torus Willmore"]
    modifier = next(m for m in result.modifiers if m.type == "SUBSURF")
    modifier.levels, modifier.use_limit_surface, modifier.quality = 5, True, 10
    shown = result.evaluated_get(bpy.context.evaluated_depsgraph_get())
    far = [(shown.closest_point_on_mesh(place)[1] - Vector(place)).length for place in ((1.0, 0.1, 0.6), (1.0, 0.1, 0.9))]
    assert max(far) > 0.05
    for weight in ("0", "2", "nan", "much"):
        code, lines, _ = batch(*common, "--through-weight", weight)
        assert code == 2 and f"'{weight}' is no weight: it must be 0.01 to 1" in lines[-1]


def test_strength_keeps_the_surface_near_and_the_default_is_the_minimum(batch, cage_file):
    reports = []
    for arguments in ([], ["--strength", "1"], ["--strength", "0.3"]):
        assert batch("--energy", "willmore", "--levels", "1", *arguments, "--json", "out.json")[:2] == (0, [])
        reports.append(json.loads((cage_file.parent / "out.json").read_text()))
    assert [report["strength"] for report in reports] == [1.0, 1.0, 0.3]
    assert reports[0]["willmore"] == pytest.approx(reports[1]["willmore"], rel=1e-9)
    assert reports[1]["willmore"] < reports[2]["willmore"] < reports[2]["before"]["willmore"]
    assert [" nearness to the original " in report["verdict"] for report in reports] == [False, False, True]
    code, errors, _ = batch("--strength", "0", "--json", "out.json")
    assert code == 1 and errors == ["Strength is 0; it must be 0.001 to 1."]


def test_volume_is_kept(batch, cage_file, add):
    """In the report before and after; the library refuses it of a boundary that may move."""
    volumes, common = [], ["--energy", "willmore", "--levels", "1", "--strength", "0.5", "--json", "out.json"]
    for arguments in ([], ["--keep-volume"]):
        assert batch(*common, *arguments)[:2] == (0, [])
        found = json.loads((cage_file.parent / "out.json").read_text())
        assert found["keep_volume"] == bool(arguments) and abs(found["scalar_residuals"]["volume"]) < 1e-8
        assert (found["multipliers"]["volume"] != 0) == bool(arguments)
        assert 0 < found["reduced_volume"] < 1 and found["total_mean_curvature"] > 0
        volumes.append(found["volume"] / found["before"]["volume"] - 1)
    assert abs(volumes[0]) > 1e-3 and abs(volumes[1]) < 1e-6
    bpy.data.objects.remove(bpy.data.objects["Spare"])
    add(*shapes.grid())
    save_again(cage_file)
    assert batch(*common, "--keep-volume")[:2] == (0, [])
    found = json.loads((cage_file.parent / "out.json").read_text())
    assert found["volume"] is None and found["before"]["volume"] is None and found["multipliers"]["volume"] != 0
    code, errors, _ = batch(*common, "--keep-volume", "--boundary", "free")
    assert code == 1 and len(errors) == 1 and errors[0].startswith("The volume cannot be held: the boundary may move")


def test_the_result_can_be_animated(batch, cage_file):
    """Saved as shape keys with keyframes; and by many files as well."""
    code, errors, _ = batch("--animation", "--levels", "2", "--output", "out.blend")
    assert (code, errors) == (0, [])
    for arguments in ([], ["--animation"]):  # what is there without is made again
        assert batch(*arguments, "--levels", "1", "--into", "many", cage_file)[0] == 0
    for path in (cage_file.with_name("out.blend"), cage_file.parent / "many" / "cage-willmore-1.blend"):
        bpy.ops.wm.open_mainfile(filepath=str(path))
        keys = bpy.data.objects["Torus Willmore"].data.shape_keys
        assert len(keys.key_blocks) > 5 and keys.animation_data.action is not None
        bpy.context.scene.frame_set(2)
        assert keys.key_blocks["Run 1"].value == 1.0


def test_within_is_a_distance_in_the_scene(batch, cage_file):
    common = ["--energy", "willmore", "--levels", "1", "--json", "out.json"]
    for within in (0.0, 0.01):
        assert batch(*common, *(["--within", str(within)] if within else []))[:2] == (0, [])
        found = json.loads((cage_file.parent / "out.json").read_text())
        assert found["within"] == within and (found["deviation"]["bound"] < 0.01) == bool(within)
    code, errors, _ = batch("--within", "-1", "--json", "out.json")
    assert code == 1 and errors == ["Within is -1; it must be finite, 0 or more."]


def test_volume_is_one_of_the_settings_of_many(batch, cage_file):
    """A second call with it is another run."""
    common = [cage_file, "--into", cage_file.parent / "into", "--levels", "1", "--strength", "0.5"]
    for arguments, keep_volume in (([], False), (["--keep-volume"], True)):
        assert batch(*common, *arguments)[:2] == (0, [])
        found = json.loads((cage_file.parent / "into" / "cage-willmore-1.json").read_text())
        assert found["input"]["keep_volume"] == found["keep_volume"] == keep_volume


def test_object_is_chosen_by_name(batch, cage_file):
    code, _, _ = batch("--energy", "willmore", "--levels", "1", "--object", "Spare", "--json", "out.json")
    assert code == 0
    assert json.loads((cage_file.parent / "out.json").read_text())["result"] == "Spare Willmore"


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        (["--object", "Nobody", "--output", "out.blend"], "There is no object 'Nobody'"),
        (["--pin-group", "Pins", "--output", "out.blend"], "Object 'Torus' has no vertex group 'Pins'"),
        (["--levels", "0", "--output", "out.blend", "--json", "out.json"], "Levels is 0"),
        (["--levels", "99999999999", "--output", "out.blend"], "levels = 99999999999"),
        (["--output", "missing/out.blend", "--json", "out.json"], "missing/out.blend cannot be written"),
        (["--json", "out.json", "--output", "."], "it is a folder"),
    ],
)
def test_failure_is_exit_1_one_sentence_and_nothing_written(batch, arguments, sentence):
    code, errors, new = batch(*arguments)
    assert (code, len(errors), new) == (1, 1, [])
    assert sentence in errors[0] and errors[0].endswith(".")


def test_what_is_held_is_named_and_counted(batch, cage_file, add, crease):
    """A cone in the middle of a grid."""
    bpy.data.objects.remove(bpy.data.objects["Spare"])
    crease(add(*shapes.grid()), vertices={12: 1.0})
    save_again(cage_file)
    code, errors, new = batch("--energy", "willmore", "--levels", "2", "--json", "out.json")
    assert (code, errors, new) == (0, [], ["out.json"])
    found = json.loads((cage_file.parent / "out.json").read_text())
    assert (found["n_held"], found["n_left_out"]) == (9, 4)


def test_levels_that_move_nothing_are_refused_with_a_number_that_does(batch, cage_file):
    bpy.ops.mesh.primitive_plane_add()
    save_again(cage_file)
    work = ["--object", "Plane", "--energy", "willmore", "--strength", "0.3", "--json", "out.json", "--levels"]
    code, errors, new = batch(*work, "1")
    assert (code, new) == (1, []) and len(errors) == 1
    assert errors[0].startswith("Nothing may move with --levels 1:") and errors[0].endswith("use --levels 2.")
    assert batch(*work, "2") == (0, [], ["out.json"])


def test_refused_cage_leaves_an_older_output_as_it_was(batch, cage_file, torus):
    torus.modifiers.new("Row", "ARRAY")
    save_again(cage_file)
    (cage_file.parent / "out.json").write_text("older")
    code, errors, new = batch("--json", "out.json", "--output", "out.blend")
    assert (code, new) == (1, ["out.json"]) and "Modifier 'Row' of object 'Torus'" in errors[0]
    assert (cage_file.parent / "out.json").read_text() == "older"


def test_objects_whose_files_would_have_one_name_are_not_written_over_each_other(batch, cage_file, torus):
    torus.name, bpy.data.objects["Spare"].name = "A b", "a_b"
    save_again(cage_file)
    code, errors, _ = batch(cage_file.name, "--into", "out", "--all-objects", "--levels", "1", "--max-iterations", "1")
    out = cage_file.parent / "out"
    assert code == 1 and len(errors) == 1 and "would have the names of another one's" in errors[0]
    assert len(list(out.glob("*.blend"))) == len(list(out.glob("*.json"))) == 1


def test_names_of_objects_do_not_leave_the_folder_and_leftovers_go(batch, cage_file, torus):
    torus.name = "../../up\\and: <b>"
    bpy.data.objects.remove(bpy.data.objects["Spare"])
    save_again(cage_file)
    out = cage_file.parent / "out"
    out.mkdir()
    (out / f".cage-.._.._up_and_b_-willmore-1.{2**31 - 2}.blend").write_text("left by a run that was killed")
    work = ["--into", "out", "--all-objects", "--levels", "1", "--max-iterations", "1"]
    assert batch(cage_file.name, *work) == (0, [], ["out"])
    assert sorted(path.name for path in out.iterdir()) == [f"cage-.._.._up_and_b_-willmore-1.{end}" for end in ("blend", "json")]


def test_scripts_of_a_blend_file_do_not_run(batch, cage_file):
    """Blender runs a text that is marked so when a file is opened, where its user allows that; by default none does."""
    text = bpy.data.texts.new("run.py")
    text.write(f"open({str(cage_file.parent / 'ran')!r}, 'w').close()\n")
    text.use_module = True
    save_again(cage_file)
    code, errors, new = batch(cage_file.name, "--into", "out", "--object", "Torus", "--levels", "1", "--max-iterations", "1")
    assert (code, new) == (0, ["out"]), errors


def test_many_at_once_go_on_after_failures_and_are_skipped_when_done(batch, cage_file, torus):
    """Two objects, two energies: one object is refused. A second call does only that again; a third one, all once more
    after the settings changed."""
    bpy.data.objects["Spare"].modifiers.new("Row", "ARRAY")
    save_again(cage_file)
    (cage_file.parent / "broken.blend").write_text("no blend")
    files = [cage_file.name, "broken.blend", "missing.blend"]
    work = [*files, "--into", "out", "--all-objects", "--energy", "willmore", "--energy", "mvs:1,willmore:0.1"]
    out, victim = cage_file.parent / "out", cage_file.parent / "victim.txt"
    out.mkdir()
    victim.write_text("mine")
    (out / "cage-Spare-willmore-1.json").symlink_to(victim)
    code, errors, _ = batch(*work, "--levels", "1")
    assert victim.read_text() == "mine" and not (out / "cage-Spare-willmore-1.json").is_symlink()
    good = ["cage-Torus-mvs_1_willmore_0.1-1", "cage-Torus-willmore-1"]
    bad = ["cage-Spare-mvs_1_willmore_0.1-1", "cage-Spare-willmore-1"]
    assert code == 1 and len(errors) == 4 and sum("Modifier 'Row' of object 'Spare'" in line for line in errors) == 2
    assert all(any(line.startswith(f"{name}.blend: ") for line in errors) for name in ("broken", "missing"))
    assert sorted(path.stem for path in out.glob("*.blend")) == good
    assert sorted(path.stem for path in out.glob("*.json")) == sorted(good + bad)
    report = json.loads((out / f"{good[1]}.json").read_text())
    assert report["willmore"] < report["before"]["willmore"] and report["input"]["energy"] == "willmore"
    assert "Modifier 'Row'" in json.loads((out / f"{bad[0]}.json").read_text())["error"]
    times = {path: path.stat().st_mtime_ns for path in out.glob("cage-Torus*")}
    assert batch(*work, "--levels", "1")[0] == 1
    assert {path: path.stat().st_mtime_ns for path in times} == times
    bpy.data.objects["Spare"].modifiers.clear()
    save_again(cage_file)
    assert batch(*work[:1], *work[3:], "--levels", "1")[:2] == (0, [])
    assert all(path.stat().st_mtime_ns > then for path, then in times.items())  # the file is another one now
    assert sorted(path.stem for path in out.glob("*.blend")) == sorted(good + bad)


@pytest.mark.parametrize(
    "arguments",
    [["--energy", "bending", "--json", "x"], ["--energy", "mvs"], ["--sise", "1x1"], ["--symmetry", "off"],
     ["a.blend", "--json", "x"], ["--energy", "mvs", "--energy", "willmore", "--json", "x"], ["--into", "x"],
     ["a.blend", "--into", "x", "--json", "y"]],
)
def test_wrong_usage_is_exit_2(batch, arguments):
    code, errors, new = batch(*arguments)
    assert (code, new) == (2, []) and errors[0].startswith("usage:") and "error:" in errors[-1]


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize("stderr, shown", [(Terminal(), True), (io.StringIO(), False)])
def test_progress_goes_to_a_terminal_only(torus, part, tmp_path, monkeypatch, stderr, shown):
    monkeypatch.setattr(sys, "stderr", stderr)
    assert part("batch.command").main(["--energy", "willmore", "--levels", "1", "--json", str(tmp_path / "out.json")]) == 0
    assert ("\r\033[Klevel 1 of 1, iteration" in stderr.getvalue()) is shown
    assert stderr.getvalue().endswith("\n") is shown


def test_the_source_tree_runs_as_the_installed_add_on_does(cage_file):
    """addon/batch.py of the repository, which is not installed; the library is the build's."""
    root = Path(__file__).resolve().parents[3]
    arguments = ["--energy", "willmore", "--levels", "1", "--json", "out.json"]
    code, _ = blender(cage_file, "-P", str(root / "addon" / "batch.py"), "--", *arguments)
    assert code == 0 and json.loads((cage_file.parent / "out.json").read_text())["symmetry_order"] == 32
