# SPDX-License-Identifier: GPL-3.0-or-later
"""Chains of edges out of sets of vertices, against walks that are known; what is refused."""

import numpy as np
import pytest
import shapes
from addon.binding.library import CurvoptError
from addon.binding.through import Chain, Through
from addon.binding.values import Cage
from addon.core import guides, messages
from addon.core.go_through import Places
from addon.core.job import Request
from addon.core.surface_points import face_edges


def edges_of(faces):
    return face_edges(np.array([len(f) for f in faces], np.int32), np.array([v for f in faces for v in f], np.int32))


EDGES = edges_of(shapes.grid(4)[1])  # vertex y * 5 + x


@pytest.mark.parametrize("chain, is_closed", [
    ([5, 6, 7, 8, 9], False), ([2, 7, 12, 13, 14], False), ([0, 1], False), ([0, 1, 6, 5], True),
    ([0, 1, 2, 3, 4, 9, 14, 19, 24, 23, 22, 21, 20, 15, 10, 5], True), ([12, 7, 8, 3], False),
])  # fmt: skip
def test_vertices_in_any_order_are_the_chain(chain, is_closed):
    """From its end of the least number, or from the first vertex that is given, in either direction."""
    random = np.random.default_rng(3)
    for _ in range(8):
        given = random.permutation(chain)
        found, closed = guides.ordered(given, EDGES)
        assert closed == is_closed and len(found) == len(chain) and found[0] == (given[0] if closed else min(chain[0], chain[-1]))
        at = chain.index(found[0])
        turned = chain[at:] + chain[:at] if closed else chain
        assert found in (turned, turned[:1] + turned[:0:-1], chain[::-1])


@pytest.mark.parametrize("members, told", [
    ([7], "has vertex 7 alone"), ([0, 1, 3, 4], "is in pieces: no edges join vertex 0 to vertex 3"),
    ([11, 12, 13, 7], "branches at vertex 12, which edges join to 3 others"), ([3, 20], "is in pieces"),
    ([0, 1, 6, 5, 24, 23, 18, 19], "is in pieces: no edges join vertex 0 to vertex 18"),
    ([0, 1, 6, 5, 24, 23], "is in pieces: no edges join vertex 23 to vertex 0"),
])  # fmt: skip
def test_what_is_no_chain_is_refused(members, told):
    with pytest.raises(ValueError) as error:
        guides.ordered(np.array(members), EDGES)
    assert told in str(error.value)


def test_curves():
    line = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0]])
    closed = guides.followed([1, 2, 3], True, line, True, 0.5)
    assert closed.curve.tolist() == line[:-1].tolist() and closed.closed and closed.curve_closed and closed.weight == 0.5
    part = guides.followed([1, 2], False, line[:-1], False, 1.0)
    assert part.curve.tolist() == line[:-1].tolist() and not part.closed and not part.curve_closed
    with pytest.raises(ValueError, match="is open, and the chain of edges is closed"):
        guides.followed([1, 2, 3], True, line, False, 1.0)
    with pytest.raises(ValueError, match="is at no place"):
        guides.followed([1, 2, 3], False, line * np.nan, False, 1.0)


def test_refusals_have_the_names_of_curves():
    cage, places = Cage(np.empty((0, 3)), np.empty(0, np.int32), np.empty(0, np.int32)), Places(chain_names=("A", "B"))
    text = "chain 1 wants vertex 24 0.03 away from where chain 0 wants it: give both parameters at which their curves meet"
    told = messages.failure_text(places.named(CurvoptError(1, -1, text), cage))
    assert told == "The chain of 'B' wants vertex 24 0.03 away from where the chain of 'A' wants it: let the curves meet there, or set a Weight below 1."
    assert str(Places().named(CurvoptError(1, -1, text), cage)) == text


@pytest.mark.parametrize("request_, told", [
    (Request(), ""), (Request(through=(Through(vertex=1, at="here"),)), "through 1 place, "),
    (Request(chains=(Chain([0, 1], np.eye(3)),) * 2), "along 2 curves, "),
    (Request(through=(Through(vertex=1, at="here", weight=0.5),), chains=(Chain([0, 1], np.eye(3), weight=0.5),)), "near 1 place, near 1 curve, "),
])  # fmt: skip
def test_the_message_says_what_it_goes_through(request_, told):
    assert messages.through_text(request_) == told
