# SPDX-License-Identifier: GPL-3.0-or-later
"""The README's figures are what the library computes: its table to the last digit that is printed, give or take one, and
those in its pictures, by their stamp (blend_files/pictures/pictures.json), to what is visible. Pictures' runs that take more
than a second are made again with CURVOPT_LONG=1."""
from __future__ import annotations

import hashlib
import json
import re
from dataclasses import replace

import numpy as np

import pytest

import lib
from nets import read_obj

FILES = {
    "torus 8×4, ρ = .15, .3, .5, .85": ("torus_030", "torus_085"), "torus 8×4, ρ = .1 to .9": ("torus_070", "torus_030"),
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


PICTURES = lib.ROOT / "blend_files" / "pictures"
STAMP = json.loads((PICTURES / "pictures.json").read_text(encoding="utf-8"))
VISIBLE = 3e-4  # of an energy: captions have five digits, and shapes that differ by so little look the same
AUTO, KEEP = 0, 3  # curvopt_symmetry


def test_every_picture_of_the_readme_has_a_stamp_and_is_the_one_that_was_stamped():
    text = (lib.ROOT / "README.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"blend_files/pictures/(\w+\.png)", text))
    assert shown and shown == set(STAMP["pictures"])
    for name in shown:
        content = (PICTURES / name).read_bytes()
        assert hashlib.sha256(content).hexdigest() == STAMP["pictures"][name]["sha256"], name
        assert len(content) <= 1_500_000 and int.from_bytes(content[16:20], "big") >= 2400, name


def stamped() -> list[dict]:
    """Each run of the pictures once; those of a second and less, or all."""
    found = {}
    for picture in STAMP["pictures"].values():
        for run in picture["figures"]:
            found[run["cage"], run["energy"], run["symmetry"]] = run
    return [run for run in found.values() if lib.LONG or run["seconds"] <= 1]


@pytest.mark.parametrize("run", stamped(), ids=lambda run: f"{run['cage']}, {run['energy']}, {run['symmetry']}")
def test_figures_in_pictures_are_those_of_this_library(run):
    mesh = read_obj(lib.ROOT / "blend_files" / "obj" / f"{run['cage']}.obj")
    single = replace(mesh, xyz=np.asarray(mesh.xyz, np.float32).astype(float))  # as .blend files have it
    found = lib.minimize(single, run["energy"], levels=run["levels"], symmetry={"auto": AUTO, "keep": KEEP}[run["symmetry"]])
    summary = found.summary
    assert summary.end.objective == pytest.approx(run["value"], rel=VISIBLE)
    assert summary.end.h2 == pytest.approx(run["h2"], rel=VISIBLE)
    assert found.verdict == run["verdict"] and summary.symmetry_order == run["symmetry_order"]
    assert summary.discretization_error == pytest.approx(run["net_share"], rel=0.05)


def test_the_text_says_what_the_first_picture_says():
    text = (lib.ROOT / "README.md").read_text(encoding="utf-8")
    (run,) = STAMP["pictures"]["lawson_g2_mvs.png"]["figures"]
    assert f"at {run['value']:.2f}, as in this page's\nfirst picture" in text
    (keeps,) = (each for each in STAMP["pictures"]["table2.png"]["figures"] if (each["cage"], each["energy"]) == ("lawson_g2", "mvs"))
    assert keeps["symmetry"] == "keep"
    assert f"(`--symmetry keep`) it ends at {keeps['value']:.2f}, as in the picture of high genus" in text
