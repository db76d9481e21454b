# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside a Blender with a real window: what is there to make an edit fair, compared on one edit. With a picture and a table
for the manual.

A sheet like a body panel: 16 vertices in its middle are raised by hand. The vertices round them, six rows, are to make a fair
transition; all others stay, the raised ones too. Who does that: Blender's modifiers Smooth, Smooth Laplacian and Corrective
Smooth on a vertex group, with the number of iterations (and for Smooth Laplacian the factor) that gives the least energy of all that are
tried; sculpting's Fair, for positions and for tangents; and Curvopt in Edit Mode. Times are processor time of one such operation, and for
modifiers of one evaluation. Energies are Willmore's and MVS, of the limit surface of the whole sheet.

Sculpting's Fair takes the face set under the mouse, hence the window."""

import importlib
import sys
import time
import traceback
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from driver import RESULTS, log, part, setup, start, turns, viewport, window  # noqa: E402

SIDE, RAISED, ROWS, HEIGHT = 27, 4, 6, 0.45  # quads of the sheet, vertices raised, rows round them, how far
ITERATIONS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
FACTORS = (0.1, 0.5, 1.0, 5.0, 20.0, 100.0)


def sheet():
    """Points (n, 3), faces, and which vertices are raised and which are free (n,)."""
    step = np.linspace(-1.5, 1.5, SIDE + 1)
    x, y = (a.ravel() for a in np.meshgrid(step, step))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(SIDE + 1), np.arange(SIDE + 1)))
    from_middle = np.maximum(np.abs(i - SIDE / 2), np.abs(j - SIDE / 2))
    raised = from_middle < RAISED / 2
    free = ~raised & (from_middle < RAISED / 2 + ROWS)
    z = -0.12 * x**2 - 0.05 * y**2 + HEIGHT * raised
    starts = [row * (SIDE + 1) + column for row in range(SIDE) for column in range(SIDE)]
    return np.stack([x, y, z], -1), [[k, k + 1, k + SIDE + 2, k + SIDE + 1] for k in starts], raised, free


def add(points, faces, free):
    """The sheet as the active object, with a vertex group of what is free, and its faces selected."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    mesh = bpy.data.meshes.new("Sheet")
    mesh.from_pydata(points.tolist(), [], faces)
    obj = bpy.data.objects.new("Sheet", mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    obj.vertex_groups.new(name="Free").add(np.flatnonzero(free).tolist(), 1.0, "REPLACE")
    return obj


def select(mesh, vertices, faces):
    """Vertices (n,) and faces (m,), bool; in Edit Mode edges would add vertices."""
    for parts, chosen in ((mesh.vertices, vertices), (mesh.edges, np.zeros(len(mesh.edges), bool)), (mesh.polygons, faces)):
        parts.foreach_set("select", chosen.tolist())


def call(operator, *arguments, **named):
    area, region = viewport()
    with bpy.context.temp_override(window=window(), area=area, region=region):
        return operator(*arguments, **named)


def positions(mesh):
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.reshape(-1))
    return points.astype(float)


class Judge:
    """Energies of the sheet at positions."""

    def __init__(self, points, faces):
        self.library = part("binding.library")
        values = part("binding.values")
        sizes = np.full(len(faces), 4, np.int32)
        self.cage = values.Cage(points, sizes, np.array(faces, np.int32).ravel())
        lib = self.library.load()
        self.mesh = self.library.Mesh.of_cage(lib, self.cage)
        self.problem = self.library.Problem.create(self.mesh, lib.options({"willmore": 1.0}))
        self.rows = []  # name, seconds, Willmore, MVS, positions

    def energies(self, points):
        """(Willmore, MVS)"""
        terms = self.problem.evaluate(points)[0].terms
        return terms["willmore"], terms["mvs"]

    def add(self, name, seconds, points):
        self.rows.append((name, seconds, *self.energies(points), points))
        print(f"COMPARISON {name}: {seconds:.4f} s, Willmore {self.rows[-1][2]:.4g}, MVS {self.rows[-1][3]:.4g}", flush=True)


def of_modifier(judge, name, kind, points, faces, free, settings):
    """The best of some settings of a modifier; iterations are tried with all of them."""
    best = None
    for chosen in settings:
        for iterations in ITERATIONS:
            obj = add(points, faces, free)
            modifier = obj.modifiers.new("Fair", kind)
            modifier.vertex_group, modifier.iterations = "Free", iterations
            for key, value in chosen.items():
                setattr(modifier, key, value)
            begin = time.process_time()
            evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            seconds, moved = time.process_time() - begin, positions(evaluated.data)
            found = judge.energies(moved)[0]
            if best is None or found < best[0]:
                words = ", ".join([*(f"{key} {value}" for key, value in chosen.items() if not isinstance(value, bool)), f"{iterations} iterations"])
                best = found, seconds, moved, words
    judge.add(f"{name} ({best[3]})", best[1], best[2])


def fair(judge, mode, points, faces, raised, free):
    """Sculpting's Fair on the face set of what is free, whose border faces stay; a generator."""
    obj = add(points, faces, free)
    corners = np.array(faces)
    part_of = (free | raised)[corners].any(axis=1) & ~raised[corners].all(axis=1)  # so that exactly the free ones are inside
    select(obj.data, np.isin(np.arange(len(points)), corners[part_of]), part_of)
    view = viewport()[0].spaces.active.region_3d
    view.view_perspective, view.view_rotation, view.view_location, view.view_distance = "ORTHO", (1, 0, 0, 0), (0, 0, 0), 5.0
    yield from turns(5)
    call(bpy.ops.object.mode_set, mode="SCULPT")
    yield from turns(5)
    call(bpy.ops.sculpt.face_sets_create, "EXEC_DEFAULT", True, mode="SELECTION")
    target = view.perspective_matrix @ obj.data.polygons[int(np.flatnonzero(part_of)[0])].center.to_4d()
    region = viewport()[1]
    x, y = region.x + int((1 + target.x) * region.width / 2), region.y + int((1 + target.y) * region.height / 2)
    for shift in (0, 1, 0):
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x + shift, y=y)
        yield from turns(4)
    begin = time.process_time()
    call(bpy.ops.sculpt.face_set_edit, "INVOKE_DEFAULT", True, mode=mode)
    seconds = time.process_time() - begin
    yield from turns(4)
    call(bpy.ops.object.mode_set, mode="OBJECT")
    moved = positions(obj.data)
    changed = np.abs(moved - points).max(axis=1) > 1e-5
    assert changed[free].mean() > 0.9 and not changed[~free].any(), (changed[free].sum(), changed[~free].sum())
    judge.add(f"Sculpt: Fair, {mode.removeprefix('FAIR_').title()}", seconds, moved)


def of_curvopt(judge, energy, points, faces, free):
    """Minimize in Edit Mode on the selected vertices that are free."""
    obj = add(points, faces, free)
    select(obj.data, free, np.zeros(len(faces), bool))
    bpy.ops.object.mode_set(mode="EDIT")
    begin = time.process_time()
    assert bpy.ops.curvopt.minimize("EXEC_DEFAULT", True, energy=energy, strength=1.0, rim="FREE", symmetry="NONE") == {"FINISHED"}
    seconds = time.process_time() - begin
    bpy.ops.object.mode_set(mode="OBJECT")
    moved = positions(obj.data)
    changed = np.abs(moved - points).max(axis=1) > 1e-7
    assert not changed[~free].any(), changed[~free].sum()
    judge.add(f"Curvopt, {'MVS' if energy == 'MVS' else energy.title()}", seconds, moved)


def picture(judge, names, path):
    """These rows side by side with zebra stripes."""
    before_after = importlib.import_module("curvopt.render.before_after")
    shapes = []
    for name in names:
        row = next(row for row in judge.rows if row[0].startswith(name))
        shapes.append((replace(judge.cage, positions=row[4]), f"{name}: {row[2]:.3g}"))
    before_after.render_side_by_side(shapes, path, before_after.Picture(1500, 420, 96, "workbench", "zebra"))


def compare():
    """All of them on one sheet, the table on standard output; a generator."""
    setup()
    viewport()[0].spaces.active.show_region_ui = False
    points, faces, raised, free = sheet()
    judge = Judge(points, faces)
    judge.add("As edited", 0.0, points)
    of_modifier(judge, "Smooth", "SMOOTH", points, faces, free, [{"factor": 0.5}])
    laplacian = [{"lambda_factor": factor, "use_volume_preserve": False} for factor in FACTORS]
    of_modifier(judge, "Smooth Laplacian", "LAPLACIANSMOOTH", points, faces, free, laplacian)
    corrective = [{"factor": factor, "use_only_smooth": True, "smooth_type": kind} for factor in (0.5, 1.0) for kind in ("SIMPLE", "LENGTH_WEIGHTED")]
    of_modifier(judge, "Corrective Smooth", "CORRECTIVE_SMOOTH", points, faces, free, corrective)
    for mode in ("FAIR_POSITIONS", "FAIR_TANGENCY"):
        yield from fair(judge, mode, points, faces, raised, free)
    for energy in ("WILLMORE", "MVS"):
        of_curvopt(judge, energy, points, faces, free)
    names = "As edited", "Smooth Laplacian", "Sculpt: Fair, Tangency", "Curvopt, Willmore", "Curvopt, MVS"
    picture(judge, names, RESULTS.with_name("24_comparison.png"))
    for name, seconds, willmore, mvs, _ in judge.rows:
        print(f"| {name} | {'' if name == 'As edited' else f'{seconds:.3f} s'} | {willmore:.3g} | {mvs:.3g} |", flush=True)
    judge.problem.close()
    judge.mesh.close()


def everything():
    try:
        yield from compare()
        log("PASS compare")
    except Exception as error:
        traceback.print_exc()
        log(f"FAIL {error!r}")
    bpy.ops.wm.quit_blender()


start(everything())
