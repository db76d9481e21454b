# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel says and shows while Live is on."""

import time

import bpy
import pytest
from test_live import empties, finish, quick, shaken  # noqa: F401 (fixtures)


def spoken(part, until):
    """The panel's words once `until` holds of them, with Live on; looks as the timer does."""
    session, deadline = part("ui.live")._session, time.monotonic() + 120
    while True:
        bpy.context.view_layer.update()
        part("ui.live")._look()
        text = part("ui.properties").state.message
        if until(text):
            return text
        assert time.monotonic() < deadline and part("ui.live")._session is session, text
        time.sleep(0.01)


@pytest.mark.parametrize("place", [1e10, float("inf"), float("nan")])
def test_a_handle_that_is_too_far_is_said_and_it_goes_on(shaken, empties, part, place):
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    spoken(part, lambda text: text.endswith("minimum."))
    number, was = part("ui.live")._session.live.number, tuple(empties(shaken)[9].location)
    empties(shaken)[9].location.y = place
    text = spoken(part, lambda text: part("ui.properties").state.failed)
    assert text.startswith("The handle of vertex 9 is too far away for any surface") and part("ui.properties").state.live == "ON"
    with pytest.raises(RuntimeError, match="too far away for any surface"):
        bpy.ops.curvopt.live_finish()
    assert part("ui.live")._session.live.number == number
    empties(shaken)[9].location = was
    spoken(part, lambda text: text.endswith("minimum.") and not part("ui.properties").state.failed)
    assert finish()["curvopt_verdict"].startswith("Checked: a true local minimum")


def test_handles_in_one_place_are_said_and_it_goes_on(shaken, empties, part):
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    places = {vertex: handle.location.copy() for vertex, handle in empties(shaken).items()}
    for handle in empties(shaken).values():
        handle.location = places[0]
    text = spoken(part, lambda text: text.endswith("move them apart."))
    assert "Checked: not yet a minimum" in text and part("ui.properties").state.live == "ON"
    for vertex, handle in empties(shaken).items():
        handle.location = places[vertex]
    assert finish()["curvopt_verdict"].startswith("Checked: a true local minimum")


class Layout:
    """What the panel draws into: remembers names of properties, and labels."""

    def __init__(self):
        self.names, self.labels = [], []

    def column(self, **_):
        return self

    def prop(self, _owner, name, **_):
        self.names.append(name)

    def label(self, text="", **_):
        self.labels.append(text)

    def operator(self, *_, **__):
        pass

    operator_menu_enum = operator


def drawn(part, monkeypatch, name):
    """The layout after a part of the panel was drawn, lines unbroken."""
    panel, layout = part("ui.panel"), Layout()
    monkeypatch.setattr(panel, "_lines", lambda _context, text: [text])
    parts = {key: value for key, value in vars(panel.CURVOPT_PT_minimize).items() if key.startswith("_draw")}
    getattr(type("Panel", (), parts)(), name)(bpy.context, layout)  # Blender makes no panel for us
    return layout


def test_the_panel_says_that_go_through_does_not_count(shaken, part, monkeypatch):
    settings = bpy.context.scene.curvopt
    for name, where in (("_draw_live", "Live"), ("_draw_edit", "Edit Mode")):
        for through in ("", "Guides"):
            settings.through = through
            said = [text for text in drawn(part, monkeypatch, name).labels if "Go Through" in text]
            assert [text.startswith(f"Go Through does not count in {where}: ") for text in said] == [True] * bool(through)


def test_animation_can_be_ticked_before_finish(shaken, part, monkeypatch):
    settings = bpy.context.scene.curvopt
    for outcome, mode, there in (("NEW", "OBJECT", True), ("SHAPE_KEY", "OBJECT", False), ("NEW", "EDIT", False)):
        settings.outcome = outcome
        bpy.ops.object.mode_set(mode=mode)
        assert ("animation" in drawn(part, monkeypatch, "_draw_live").names) == there
    bpy.ops.object.mode_set(mode="OBJECT")


def test_a_vertex_without_a_point_of_the_surface_is_refused_at_once(shaken, crease):
    """Where a crease fades. The vertex itself can be a handle."""
    settings, across = bpy.context.scene.curvopt, next(edge for edge in shaken.data.edges if 9 in edge.vertices)
    crease(shaken, {tuple(across.vertices): 0.5})
    settings.pin = "NOTHING"
    with pytest.raises(RuntimeError, match="no point that belongs to vertex 9 of object .* fades or ends there: set Pin to Selection"):
        bpy.ops.curvopt.live()
    assert list(bpy.data.objects) == [shaken]
    settings.pin, settings.pin_surface = "SELECTED", True
    with pytest.raises(RuntimeError, match="fades or ends there: turn off On Surface, and the vertex itself is the handle"):
        bpy.ops.curvopt.live()
    settings.pin_surface = False
    assert bpy.ops.curvopt.live() == {"FINISHED"}
    assert finish()["curvopt_verdict"].startswith("Checked: a true local minimum")
