# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist's main control: what the first press does to a bumpy bottle, a touch, the minimum, and what is said."""

from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest
import shapes


def positions(obj):
    return np.array([vertex.co for vertex in obj.data.vertices])


def lip(points):
    """Mean radius of the rings of a bottle's lip, each about its middle."""
    rings = points.reshape(len(shapes.BOTTLE), -1, 3)[list(shapes.BOTTLE_LIP)][:, :, :2]
    return np.linalg.norm(rings - rings.mean(axis=1, keepdims=True), axis=2).mean()


def moved(result, original):
    """The largest displacement of a vertex, by the original's size; the result stands beside it."""
    start, end = positions(original), positions(result)
    return np.linalg.norm(end - start, axis=1).max() / np.ptp(start, axis=0).max()


@pytest.fixture
def bottle(add):
    """The active object: a bumpy bottle of 240 vertices."""
    obj = add(*shapes.bottle(), name="Bottle")
    assert len(obj.data.vertices) == 240
    return obj


def press(**arguments):
    assert bpy.ops.curvopt.minimize(**arguments) == {"FINISHED"}
    return bpy.context.view_layer.objects.active


def test_settings_of_a_newcomer(newcomer):
    assert newcomer.strength == pytest.approx(0.3) and newcomer.resolution == "SAME" and newcomer.energy == "WILLMORE"
    strength = newcomer.bl_rna.properties["strength"]
    assert (strength.subtype, strength.hard_max) == ("FACTOR", 1.0) and strength.hard_min == pytest.approx(0.01)


def test_first_press_smooths_bumps_and_keeps_the_bottle(newcomer, bottle, part):
    result = press()
    assert len(result.data.vertices) == 240
    assert moved(result, bottle) < 0.1
    assert lip(positions(result)) == pytest.approx(lip(positions(bottle)), rel=0.05)
    assert result["curvopt_after_willmore"] < 0.75 * result["curvopt_before_willmore"]
    assert result["curvopt_strength"] == 0.3
    message = part("ui.properties").state.message
    shown = part("core.energy").number_text
    before, after = (shown(result[f"curvopt_{when}_willmore"]) for when in ("before", "after"))
    assert message.startswith(f"Willmore {before} to {after}, stayed near the original (strength 0.3), ")
    verdict = result["curvopt_verdict"]
    assert verdict == "Checked: a local minimum of energy and nearness to the original together."
    assert "global" not in message + verdict


def test_least_strength_changes_nothing_that_is_seen(newcomer, bottle):
    assert moved(press(strength=0.01), bottle) < 1e-3


@pytest.mark.parametrize("resolution, levels", [("SAME", 1), ("REFINE", 2)])
def test_full_strength_is_the_librarys_default(newcomer, torus, part, resolution, levels):
    job = part("core.job")
    source = part("scene.read_cage").read_source(bpy.context, torus)
    wanted = job.solve(source.cage, job.Request("willmore", levels))
    result = press(strength=1.0, resolution=resolution, levels=levels)
    assert positions(result) == pytest.approx(wanted.cage.positions, abs=1e-6)
    assert result["curvopt_verdict"].startswith("Checked: a true local minimum")
    assert "near the original" not in part("ui.properties").state.message


def test_strength_of_the_scene_is_used_when_the_call_gives_none(newcomer, torus):
    newcomer.strength = 0.125
    assert press()["curvopt_strength"] == 0.125


# ------------------------------------------------------------------------------------------------ adjusting it --


def test_adjusting_runs_again_with_another_strength(newcomer, bottle, part, monkeypatch):
    monkeypatch.setattr(part("core.variants"), "_LONGEST", 600.0)  # a busy machine takes long
    first = positions(press())
    adjust, job, calls = part("ui.adjust"), part("core.job"), []
    solve = job.solve
    monkeypatch.setattr(job, "solve", lambda *arguments: calls.append(arguments) or solve(*arguments))

    def again(strength):
        bpy.data.objects.remove(bpy.data.objects["Bottle Willmore"])
        bpy.context.view_layer.objects.active = bottle
        assert bpy.ops.curvopt.apply_result(number=adjust._finished[0], strength=strength) == {"FINISHED"}
        return bpy.data.objects["Bottle Willmore"]

    gentle = again(0.1)
    assert gentle["curvopt_strength"] == 0.1 and moved(gentle, bottle) < 0.2 * np.abs(first - positions(bottle)).max()
    assert "(strength 0.1)" in part("ui.properties").state.message and len(calls) == 1
    assert np.array_equal(positions(again(0.3)), first)
    assert again(0.1)["curvopt_strength"] == 0.1 and len(calls) == 1  # both are kept
    assert "(strength 0.1)" in part("ui.properties").state.message
    assert again(1.0)["curvopt_verdict"].startswith("Checked: ") and len(calls) == 2
    assert "near the original" not in part("ui.properties").state.message


def test_adjusting_gives_up_what_takes_too_long(newcomer, bottle, part, contents, monkeypatch):
    press()
    adjust = part("ui.adjust")
    monkeypatch.setattr(part("core.variants"), "_LONGEST", 0.0)
    before, message = contents(), part("ui.properties").state.message
    with pytest.raises(RuntimeError, match="Strength 0.7 takes over 0 s: set it in the sidebar and press Minimize"):
        bpy.ops.curvopt.apply_result(number=adjust._finished[0], strength=0.7)
    assert contents() == before and part("ui.properties").state.message == message


def test_adjusting_slide_runs_again(newcomer, add, part, monkeypatch):
    """A waved sheet whose boundary is bunched on one side, which is straight: vertices move along that. With strength,
    each is a run of its own; a shape without curves is not offered it."""
    n = 6
    points, faces = shapes.grid(n)
    side = np.arange(n + 1)
    points[side, 0], points[side, 2] = n * (side / n) ** 1.5, 0
    sheet = add(points, faces, name="Sheet")
    sheet.modifiers.new("Limit", "SUBSURF").boundary_smooth = "PRESERVE_CORNERS"
    monkeypatch.setattr(part("core.variants"), "_LONGEST", 600.0)  # a busy machine takes long
    first = positions(press(strength=1.0))
    adjust, job, calls = part("ui.adjust"), part("core.job"), []
    assert adjust._finished[-1] and np.array_equal(first[side], positions(sheet)[side])
    solve = job.solve
    monkeypatch.setattr(job, "solve", lambda *arguments: calls.append(arguments) or solve(*arguments))

    def again(**chosen):
        bpy.data.objects.remove(bpy.data.objects["Sheet Willmore"])
        bpy.context.view_layer.objects.active = sheet
        assert bpy.ops.curvopt.apply_result(number=adjust._finished[0], **chosen) == {"FINISHED"}
        return positions(bpy.data.objects["Sheet Willmore"])

    assert "Slide" not in part("ui.properties").state.message
    slid = again(slide=True)
    said = part("ui.properties").state.message
    assert f"Slide lets {4 * (n - 1)} vertices move along boundaries and creases" in said and "below 1" not in said
    steps = np.diff(slid[side, 0])
    assert np.ptp(steps) < 0.7 * np.ptp(np.diff(first[side, 0])) and (steps > 0).all()
    assert np.abs(slid[side, 1:] - first[side, 1:]).max() < 1e-6
    assert np.array_equal(again(slide=False), first) and len(calls) == 1
    assert np.array_equal(again(slide=True), slid) and len(calls) == 1
    assert not np.array_equal(again(slide=True, strength=0.5), slid) and len(calls) == 2
    assert "creases, but little at strengths below 1" in part("ui.properties").state.message
    add(*shapes.torus())
    press(slide=True)
    assert not adjust._finished[-1] and "Slide moves nothing: no vertex may" in part("ui.properties").state.message


# ------------------------------------------------------------------------------------------------ the panel's line --


def test_panel_says_what_length_of_waves_goes(newcomer, add, part):
    """In the world, in the scene's units. The corners of the cube of edge 2 have an RMS radius of the root of 3."""
    wave_text = part("ui.wave_length").wave_text

    def text(context, strength):
        return wave_text(context, context.view_layer.objects.active, strength)

    obj = add(*shapes.cube())
    obj.location, obj.rotation_euler, obj.scale = (5, 0, 0), (0.3, 0.2, 0.1), (2, 2, 2)
    bpy.context.view_layer.update()
    units = bpy.context.scene.unit_settings
    units.system = "NONE"
    assert text(bpy.context, 0.5) == "Waves below 3.46 go"
    units.system, units.scale_length = "METRIC", 0.01
    assert text(bpy.context, 0.25).startswith("Waves below 1.15")
    assert text(bpy.context, 1.0) == ""
    bpy.ops.object.mode_set(mode="EDIT")
    assert text(bpy.context, 0.5) == ""
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.data.vertices[0].co.x = float("nan")
    assert text(bpy.context, 0.5) == ""
    bpy.data.objects.remove(obj)
    assert text(bpy.context, 0.5) == ""


# ------------------------------------------------------------------------------------------------------- the words --


@pytest.mark.parametrize("verdict", ["minimum", "saddle", "not stationary"])
def test_verdicts_below_full_strength_are_of_energy_and_nearness(torus, part, verdict):
    job, messages, values = part("core.job"), part("core.messages"), part("binding.values")
    request = job.Request("willmore", 1, {"max_iterations": 2}, strength=0.5)
    solution = job.solve(part("scene.read_cage").read_source(bpy.context, torus).cage, request)
    solution = replace(solution, verification=values.Verification(verdict, 1e-3, int(verdict == "saddle")))
    assert "of energy and nearness to the original together" in messages.verdict_of(request, solution)
    assert "true" not in messages.verdict_of(request, solution)
    full = messages.verdict_of(replace(request, strength=1.0), solution)
    assert "nearness" not in full and full.startswith("Checked: ")


@pytest.mark.parametrize("name", ["12_strength.png", "15_slide.png"])
def test_manual_has_the_picture(name):
    manual = Path(__file__).resolve().parents[3] / "addon" / "manual"
    picture = manual / "pictures" / name
    assert f"(pictures/{name})" in (manual / "README.md").read_text()
    data = picture.read_bytes()
    assert len(data) < 300_000 and not any(chunk in data for chunk in (b"tEXt", b"iTXt", b"zTXt"))
