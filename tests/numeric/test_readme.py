# SPDX-License-Identifier: GPL-3.0-or-later
"""The README's table of figures is what the library computes: to the last digit that is printed, give or take one."""
from __future__ import annotations

import re

import pytest

import lib
from nets import read_obj

FILES = {
    "torus 8×4, ρ = .15, .3, .5, .85": ("torus_030", "torus_085"), "torus 8×4, ρ = .1 to .9": ("torus_010", "torus_070"),
    "Lawson genus 2": ("lawson_g2",), "Lawson genus 3": ("lawson_g3",), "Lawson genus 5": ("lawson_g5",),
    "tetrahedral genus 3": ("tetrahedral_g3",), "cubical genus 5": ("cubical_g5",), "sphere as a cube": ("sphere_cube",),
}  # fmt: skip
ENERGIES = {"Willmore": "willmore", "∫H²": "mean_curvature", "MVS": "mvs"}
NUMBER = r"\d[\d ]*(?:\.\d+)?"


def rows() -> list[tuple[str, str, str, list[str], list[str]]]:
    """(cage, energy, result with `keep` or "", its figures without, symmetries): of each row of the table."""
    text = (lib.ROOT / "README.md").read_text(encoding="utf-8")
    table = text[text.index("| cage | energy | result |"):].split("\n\n")[0].splitlines()[2:]
    found = []
    for line in table:
        cage, energy, result, _exact, symmetries, _seconds = (cell.strip() for cell in line.strip("|").split("|"))
        keep = re.search(rf"\(keep: ({NUMBER})\)", result)
        found.append((cage, energy, keep.group(1) if keep else "", re.findall(NUMBER, re.sub(r"\(.*\)", "", result)),
                      re.findall(r"\d+", symmetries)))
    return found


def is_the_same(printed: str, value: float) -> bool:
    """Whether the figure is the value's, but for one in its last digit."""
    digits = len(printed.partition(".")[2])
    return abs(float(printed.replace(" ", "")) - value) <= 1.5 * 10.0**-digits


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row[0]}, {row[1]}")
def test_figures_are_those_of_this_library(row):
    cage, energy, keep, figures, symmetries = row
    assert len(figures) <= len(FILES[cage])
    for printed, name in zip(figures if len(figures) > 1 else figures * len(FILES[cage]), FILES[cage]):
        mesh = read_obj(lib.ROOT / "blend_files" / "obj" / f"{name}.obj")
        result = lib.minimize(mesh, ENERGIES[energy], levels=4)
        assert result.verdict == "minimum" and is_the_same(printed, result.summary.end.objective), result.summary.end.objective
        assert result.summary.symmetry_order == int(symmetries[0])
        if keep and name == FILES[cage][0]:
            kept = lib.minimize(mesh, ENERGIES[energy], levels=4, symmetry=3).summary
            assert is_the_same(keep, kept.end.objective) and kept.symmetry_order == int(symmetries[1])
