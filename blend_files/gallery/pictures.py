# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's pictures: rows of shapes before one camera at one scale, with their figures under them, and sheets of
rows. Shapes are dense meshes with exact normals, so that `plane` shows as it is, too, in the light of `light`. Captions
do without signs that Blender's own font may lack."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from addon.binding.library import Mesh, load
from addon.binding.values import Cage
from addon.core.energy import ENERGY_LABELS, number_text
from addon.scene.write_result import make_mesh
from addon.render import studio
from . import contents, falling, figures, light, png, solve
from . import dense as dense_shapes
from .dense import Dense, centre_and_size, dense, faceted
from .png import halved, write_below, write_png
from .store import Item, Store

USES = (light, dense_shapes, png, studio, figures, falling)  # on these, too, it depends how pictures look (`store`)
COLOURS = {
    "input": (0.50, 0.50, 0.50), "willmore": (0.16, 0.34, 0.66),
    "mvs": (0.16, 0.46, 0.26), "mvs_cross": (0.74, 0.28, 0.11),
}  # fmt: skip
SETTING_TITLES = {"default": "curvopt", "report": "as the report"}

_WHITE = (1.0, 1.0, 1.0)
_ACROSS, _ABOVE = 0.92, 0.04  # the largest shape's width, and the room above and below it, in cells
_TALLEST = 0.95  # height of a shape, in cells, at most
_LINE, _LETTER = 0.078, 0.061  # of captions, in cells
_HEAD = 0.105  # a line of a sheet's head
_SHEET_BYTES = 1_400_000  # of a picture that is committed
_RULE = 216  # grey of the line between rows
_FRONT, _BACK = "front", "back"
_FIGURE_QUADS = {"limit": 60_000, "plane": 60_000, "polynomial": 3_500}  # few: a point takes 4 ms on faces like these
_TABLE_QUADS = 25_000
_FROM_CORNER = np.array([-0.45, -0.62, 0.64]) / np.linalg.norm([-0.45, -0.62, 0.64])
_COVER = (0.80, 0.30, 0.10)
_EDGE = 0.03  # half the width of a cage's edges, in faces


@dataclass(frozen=True)
class Cell:
    """A shape of unit size round the origin, its colour, its lines of caption, and its colours by point (n, 3) if it is
    a map."""

    shape: Dense
    colour: tuple[float, float, float]
    lines: tuple[str, ...]
    colours: np.ndarray | None = None


def unit(shape: Dense) -> Dense:
    """The shape moved and scaled so that its centroid is the origin and its mean square distance from there is 1."""
    centre, size = centre_and_size(shape)
    return replace(shape, points=(shape.points - centre) / size)


def draw_cells(
    cells: Sequence[Cell], path: Path, measure: Mapping[str, object], direction: np.ndarray, look: str = "clay"
) -> int:
    """A row of cells to a PNG, all at the scale that lets the largest fill its cell; `measure` has the `width` of a
    cell in pixels and `samples`. How many lines of pixels lie above the captions. RenderError."""
    rotation = studio.view_rotation(direction)
    axes = np.array(rotation)
    boxes = [((cell.shape.points @ axes).min(0), (cell.shape.points @ axes).max(0)) for cell in cells]
    extent = np.max([high - low for low, high in boxes], axis=0)
    scale = min(_ACROSS / extent[0], _TALLEST / extent[1])
    room = scale * extent[1] + 2 * _ABOVE
    text = _LINE * (max(len(cell.lines) for cell in cells) + 0.3)
    height = room + text
    picture = studio.Picture(
        measure["width"] * len(cells), round(measure["width"] * height), measure["samples"], "cycles", look
    )
    with studio.temporary_scene() as scene:
        studio.set_up_render(scene, picture, _WHITE)
        for index, (cell, (low, high)) in enumerate(zip(cells, boxes)):
            across = index - (len(cells) - 1) / 2
            surface = _added(scene, cell, picture, axes)
            place = axes @ (across, text / 2, 0.0) - scale * (axes @ ((low + high) / 2))
            surface.matrix_world = Matrix.Translation(place) @ Matrix.Scale(scale, 4)
            for line, words in enumerate(cell.lines):
                down = -height / 2 + text - _LINE * (line + 0.6)
                studio.add_caption(scene, words, Vector(axes @ (across, down, 1.0)), rotation, _LETTER, picture)
        studio.add_camera(scene, rotation, float(len(cells)), height, max(2.0, scale * float(extent[2])))
        draft = path.with_name(f".{path.stem}.{os.getpid()}.png")
        studio.render(scene, draft)
    os.replace(draft, path)
    return round(measure["width"] * room)


def _added(scene: bpy.types.Scene, cell: Cell, picture: studio.Picture, axes: np.ndarray) -> bpy.types.Object:
    """The cell's shape in the scene: lit beforehand, or a mirror of stripes."""
    mesh = _mesh(cell.shape)
    if picture.look == "zebra":
        return studio.add_surface(scene, mesh, picture)
    own = cell.colour if cell.colours is None else cell.colours
    for name, colours in zip((_FRONT, _BACK), light.shaded(cell.shape, np.asarray(own), axes)):
        layer = mesh.color_attributes.new(name, "FLOAT_COLOR", "POINT")
        with_alpha = np.concatenate([colours, np.ones((len(colours), 1))], 1)
        layer.data.foreach_set("color", with_alpha.astype(np.float32).ravel())
    return studio.add_painted(scene, mesh, _FRONT, _BACK)


def _mesh(shape: Dense) -> bpy.types.Mesh:
    sizes = np.full(len(shape.quads), 4, np.int32)
    mesh = make_mesh("Curvopt gallery", Cage(shape.points, sizes, shape.quads.ravel().astype(np.int32)))
    if bpy.app.version < (4, 1, 0):
        mesh.use_auto_smooth = True  # else its own normals are not looked at
    mesh.normals_split_custom_set_from_vertices(np.ascontiguousarray(shape.normals, np.float32))
    return mesh


def minimizer(store: Store, solved: str, surface: str) -> Dense:
    """The shape that an item ended at: as Blender shows it, but for `plane`, which Blender cannot. `polynomial` differs
    from the limit surface by less than a pixel here, and takes a millisecond and more a point."""
    return unit(dense(store.cage(solved), surface if surface == "plane" else "limit", _TABLE_QUADS))


# ---------------------------------------------------------------------------------------------------------- tables --


def draw_row(store: Store, item: Item) -> dict[str, object]:
    """A cage and its minimizers by one setting, as its table has them; and each cell by itself, smaller."""
    name, table, setting = (item.inputs[key] for key in ("cage", "table", "setting"))
    (cage,) = item.cages.values()
    first = unit(dense(cage, "limit", _TABLE_QUADS))
    cells = [Cell(first, COLOURS["input"], input_lines(name, store.result(f"input.{name}")))]
    for energy, found in contents.columns(table):
        if found == setting:
            solved = contents.solve_name(name, energy, setting)
            record = store.result(solved)
            shape = minimizer(store, solved, record["surface"])
            cells.append(Cell(shape, COLOURS[energy], result_lines(name, record)))
    direction = studio.view_direction(first.points)
    row, *small = (store.path(file) for file in item.files)
    shown = draw_cells(cells, row, item.inputs, direction)
    pixels = read_pixels(row)
    for index, path in enumerate(small):
        one = pixels[:shown, item.inputs["width"] * index : item.inputs["width"] * (index + 1)]
        store.write(str(path.relative_to(store.root)), write_png(halved(one)))
    return {"cells": len(cells), "view": direction.tolist()}


def input_lines(name: str, figures: Mapping[str, float]) -> tuple[str, ...]:
    """Under a cage as it comes."""
    title = {"torus": "Torus cage, ratio {}", "lawson": "Lawson, genus {}"}.get(name.split("_")[0])
    number = name.split("_")[1]
    label = title.format(f"{int(number) / 100:g}" if name.startswith("torus") else number[1:]) if title else name
    return (
        label.replace("_g", ", genus ").replace("_", " "),
        f"W {number_text(figures['willmore'])}   int H² {figures['h2']:.4f}",
        f"MVS {number_text(figures['mvs'])}   cross {number_text(figures['mvs_cross'])}",
    )


def result_lines(cage: str, record: Mapping[str, object]) -> tuple[str, ...]:
    """Under a minimizer: its energy, int H^2, what is left open of the energy, and what is certain of it."""
    label = "W" if record["energy"] == "willmore" else ENERGY_LABELS[record["energy"]]
    return (
        f"{label} {number_text(record['value'])}   int H² {record['h2']:.4f}",
        left_open(record),
        figures.mark(cage, record),
    )  # fmt: skip


def left_open(record: Mapping[str, object]) -> str:
    """What is left open of a result's energy."""
    return "   ".join(f"{name} {figures.error_text(record[key])}" for name, key in figures.LEFT_OPEN)


def draw_sheet(store: Store, item: Item) -> dict[str, object]:
    """Some rows of a table under a head, for the README: what curvopt makes of them."""
    table, width = item.inputs["table"], item.inputs["width"]
    energies = [energy for energy, setting in contents.columns(table) if setting == "default"]
    heads = ["Input", *(ENERGY_LABELS[energy] for energy in energies)]
    head, foot = (store.path(f"pictures/.{end}.{table}.{os.getpid()}.png") for end in ("head", "foot"))
    try:
        _draw_head(heads, head, width)
        _draw_head([_LEGEND], foot, width * len(heads), 0.72 * _HEAD / len(heads))
        pictures = [head, *(store.path(f"pictures/row.{name}.png") for name in contents.README_ROWS[table]), foot]
        stacked = stack([read_pixels(path) for path in pictures])
    finally:
        for path in (head, foot):
            path.unlink(missing_ok=True)
    store.write(item.files[0], write_below(stacked, _SHEET_BYTES))
    return {"size": [stacked.shape[1], stacked.shape[0]]}


_LEGEND = "net: what finer nets would still take away, an estimate; rule: error of the integration; W: Willmore"


def _draw_head(heads: Sequence[str], path: Path, width: int, line: float = _HEAD) -> None:
    """Words over cells of `width` pixels; a line is `line` cells high."""
    height = line * 1.4
    picture = studio.Picture(width * len(heads), round(width * height), 32)
    rotation = Matrix.Identity(3)
    with studio.temporary_scene() as scene:
        studio.set_up_render(scene, picture, _WHITE)
        for index, words in enumerate(heads):
            place = Vector((index - (len(heads) - 1) / 2, 0.0, 0.0))
            studio.add_caption(scene, words, place, rotation, line * 0.72, picture)
        studio.add_camera(scene, rotation, float(len(heads)), height, 1.0)
        studio.render(scene, path)


def read_pixels(path: Path) -> np.ndarray:
    """A picture's pixels (height, width, 3) uint8, top row first."""
    image = bpy.data.images.load(str(path), check_existing=False)
    try:
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
    finally:
        bpy.data.images.remove(image)
    return np.round(255 * pixels.reshape(height, width, 4)[::-1, :, :3]).clip(0, 255).astype(np.uint8)


def stack(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Pictures of one width, one under the other with a grey line between."""
    parts: list[np.ndarray] = []
    for picture in pictures:
        if parts:
            parts.append(np.full((1, picture.shape[1], 3), _RULE, np.uint8))
        parts.append(picture)
    return np.concatenate(parts)


def draw_cover(store: Store, item: Item) -> dict[str, object]:
    """The README's first pictures: a cage, its surface and what becomes of it; the two surfaces as stripes."""
    (cage,) = item.cages.values()
    (solved,) = item.needs
    record = store.result(solved)
    before, after = unit(dense(cage, "limit")), unit(dense(store.cage(solved), "limit"))
    net, on_edge = faceted(cage, _EDGE)
    centre, size = centre_and_size(dense(cage, "limit", 2_000))
    net = replace(net, points=(net.points - centre) / size)
    label, direction = ENERGY_LABELS[record["energy"]], studio.view_direction(before.points)
    grey, ink = np.array(COLOURS["input"]), np.array((0.06, 0.06, 0.07))
    captions = f"{label} {number_text(record['start'])}", f"{label} {number_text(record['value'])}"
    cells = [
        Cell(net, COLOURS["input"], ("Your cage",), np.where(on_edge[:, None], ink, 1.25 * grey)),
        Cell(before, COLOURS["input"], (f"its surface: {captions[0]}",)), Cell(after, _COVER, (f"minimized: {captions[1]}",)),
    ]  # fmt: skip
    for file, shown, look in zip(item.files, (cells, cells[1:]), ("clay", "zebra")):
        measure = {**item.inputs, "width": item.inputs["total"] // len(shown)}
        draft = store.path(f"pictures/.{item.name}.{os.getpid()}.png")
        try:
            draw_cells(shown, draft, measure, direction, look)
            store.write(file, write_below(read_pixels(draft), _SHEET_BYTES))
        finally:
            draft.unlink(missing_ok=True)
    return {"total": item.inputs["total"]}


# --------------------------------------------------------------------------------------------------------- figures --


def draw_flat(store: Store, item: Item) -> list[dict[str, object]]:
    """The report's figure 1: the surfaces of one cage at extraordinary vertices, as clay, stripes and curvature."""
    (cage,) = item.cages.values()
    found, cells = [], []
    for surface in ("limit", "plane", "polynomial"):
        shape = dense(cage, surface, _FIGURE_QUADS[surface])
        record = _spot(cage, surface, shape)
        found.append(record)
        mvs = "does not exist" if record["mvs"] is None else number_text(record["mvs"])
        lines = (surface, f"W {record['willmore']:.4f}   MVS {mvs}", f"flat: {100 * record['flat']:.2f} % of the area")
        cells.append(Cell(unit(shape), studio.CLAY, lines))
    _draw_figure(store, item, cells)
    return found


def draw_refined(store: Store, item: Item) -> list[dict[str, object]]:
    """The report's figure 2: `plane` of a cage that is subdivided, each vertex put where the limit surface is."""
    (cage,) = item.cages.values()
    found, cells = [], []
    for _ in range(4):
        shape = dense(cage, "plane", _FIGURE_QUADS["plane"])
        record = {"vertices": len(cage.positions), **_spot(cage, "plane", shape)}
        found.append(record)
        lines = (
            f"{record['vertices']} vertices", f"W {record['willmore']:.4f}   MVS {number_text(record['mvs'])}",
            f"flat: {100 * record['flat']:.2f} % of the area",
        )  # fmt: skip
        cells.append(Cell(unit(shape), studio.CLAY, lines))
        cage = _refined(cage)
    _draw_figure(store, item, cells)
    return found


def _spot(cage: Cage, surface: str, shape: Dense) -> dict[str, object]:
    """Energies of a surface, and the part of its area that is flat: mean curvature below half of the usual, looked for
    on the faces at extraordinary vertices."""
    energies = solve.evaluate(cage, "willmore", surface)
    valence = np.bincount(cage.face_vertices)
    near = np.unique(np.repeat(np.arange(len(cage.face_sizes)), cage.face_sizes)[valence[cage.face_vertices] != 4])
    fine = shape if surface == "polynomial" else dense(cage, surface, _FIGURE_QUADS[surface], near)
    flat = np.abs(fine.mean) < 0.5 * np.median(np.abs(shape.mean))
    return {
        "surface": surface, "flat": float(fine.areas[flat].sum() / energies.area),
        **{name: solve.plain(energies.terms[name]) for name in solve.ENERGIES},
    }  # fmt: skip


def _refined(cage: Cage) -> Cage:
    with Mesh.of_cage(load(), cage) as mesh:
        finer, positions = mesh.refine(cage.positions)
        with finer:
            return Cage(positions, *finer.faces())


def row_pixels(store: Store, item: Item, cells: Sequence[Cell], direction: np.ndarray, look: str = "clay") -> np.ndarray:
    """A row of cells as pixels."""
    path = store.path(f"pictures/.{item.name}.{os.getpid()}.png")
    try:
        draw_cells(cells, path, item.inputs, direction, look)
        return read_pixels(path)
    finally:
        path.unlink(missing_ok=True)


def _draw_figure(store: Store, item: Item, cells: Sequence[Cell]) -> None:
    """Cells as clay, stripes and a map of curvature, one row each, captions under the last."""
    mapped = [replace(cell, colours=curvature_colours(cell.shape.mean)) for cell in cells]
    bare = [replace(cell, lines=()) for cell in cells]
    looks = ((bare, "clay"), (bare, "zebra"), (mapped, "clay"))
    rows = [row_pixels(store, item, row, _FROM_CORNER, look) for row, look in looks]
    store.write(item.files[0], write_png(stack(rows)))


def curvature_colours(mean: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of mean curvatures (n,): grey where it is the usual (the median), to blue where it is none, to red
    where it is twice that."""
    usual = np.median(np.abs(mean))
    return diverging_colours(np.abs(mean) / usual - 1)


def diverging_colours(values: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of values (n,): grey at 0, to blue at -1, to red at 1."""
    t = np.clip(values, -1, 1)[:, None]
    grey, blue, red = (np.array(c) for c in ((0.62, 0.62, 0.60), (0.02, 0.12, 0.60), (0.65, 0.05, 0.03)))
    return np.where(t < 0, grey + (blue - grey) * -t, grey + (red - grey) * t)


def draw_saddles(store: Store, item: Item) -> dict[str, object]:
    """The symmetric Willmore minimizers and where they fall to when shaken."""
    rows = []
    for name in contents.SADDLES:
        symmetric = contents.solve_name(name, "willmore", "default")
        cells = [_saddle_cell(store, symmetric, name.replace("_g", ", genus "))]
        for share, rounds in contents.SHAKES:
            shaken = contents.shaken_name(name, "willmore", share, rounds)
            cells.append(_saddle_cell(store, shaken, f"shaken by {share:g}, smoothed {rounds}"))
        rows.append(row_pixels(store, item, cells, studio.view_direction(cells[0].shape.points)))
    store.write(item.files[0], write_png(stack(rows)))
    return {"rows": len(rows)}


def _saddle_cell(store: Store, name: str, title: str) -> Cell:
    record = store.result(name)
    shape = minimizer(store, name, record["surface"])
    value = "not resolved" if record["stop"] == "unresolved" else f"int H² {record['h2']:.4f}"
    return Cell(shape, COLOURS["willmore"], (title, value))


def draw_modes(store: Store, item: Item) -> dict[str, object]:
    """The symmetric Willmore minimizers, coloured by the mode in which they fall, between what they fall to on either
    side. All of a row in the same place, for modes are small and shapes keep theirs."""
    rows = []
    for name in contents.FALLING:
        mode, of = contents.mode_name(name), contents.solve_name(name, "willmore", "default")
        found, record = store.result(mode), store.result(of)
        sides = {side: contents.fall_name(name, side) for side in contents.SIDES}
        lines = (name.replace("_g", ", genus "), f"int H² {record['h2']:.4f}", f"eigenvalue {found['lowest'][0]:.2f}, size 1")
        between = Cell(
            unit(dense(store.cage(of), "limit", _TABLE_QUADS)), COLOURS["input"], lines,
            diverging_colours(falling.heights_on(store, mode, _TABLE_QUADS)),
        )  # fmt: skip
        cells = [_saddle_cell(store, sides["in"], "to one side"), between, _saddle_cell(store, sides["out"], "to the other")]
        rows.append(row_pixels(store, item, cells, studio.view_direction(between.shape.points)))
    store.write(item.files[0], write_png(stack(rows)))
    return {"rows": len(rows)}


DRAW = {
    "row": draw_row, "sheet": draw_sheet, "cover": draw_cover, "flat": draw_flat, "refined": draw_refined,
    "look": draw_saddles, "modes": draw_modes,
}  # fmt: skip
