# SPDX-License-Identifier: GPL-3.0-or-later
"""Where faces fold while a shape forms it forms once more, with walls against thin corners, and the better shape stays
(libcurvopt/notes/116-short-edges-and-thin-corners.md). Jacobians are measured by Python alone (../corpus/measures.py)."""
import sys
from pathlib import Path

import lib
import pytest
from ccref import mesh_from_faces

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "corpus"))
import cages  # noqa: E402
from measures import least_jacobian, subdivided  # noqa: E402

FOLDING = (1000, 1002, 1044, 1050, 1072)  # even seeds


def cage_of(seed: int):
    points, faces, _ = cages.cage(seed)
    return mesh_from_faces(points, [list(face) for face in faces])


def energies_of_first_level(cage, stop_at: int | None = None, by_flag: bool = False):
    """Of its steps, and the result of a run that is cancelled at step `stop_at` of it, by a flag or the answer."""
    energies, cancel = [], lib.make_cancel()

    def note(report: lib.Progress) -> bool:
        if report.level == 1:
            energies.append(report.energy)
        is_there = report.level == 1 and report.iteration == stop_at
        if is_there and by_flag:
            lib.library().curvopt_cancel_request(cancel.pointer)
        return is_there and not by_flag

    return energies, lib.minimize(cage, levels=2, progress=note, cancel=cancel)


def where_it_begins_again(energies: list[float]) -> int:
    """The step from which energies rise: no method takes steps that go up."""
    ups = [k for k in range(1, len(energies)) if energies[k] > 1.5 * energies[k - 1]]
    assert len(ups) == 1
    return ups[0]


@pytest.mark.parametrize("seed", FOLDING)
def test_faces_keep_half_of_their_least_jacobian(seed):
    cage = cage_of(seed)
    energies, result = energies_of_first_level(cage)
    at = where_it_begins_again(energies)
    assert result.verdict == "minimum"
    assert least_jacobian(result.mesh) >= min(0.3, 0.5 * least_jacobian(subdivided(cage, 1)))
    assert result.levels[0].energy <= 1.1 * (1 + 1e-2) * energies[at - 1]  # the last factor: by finer rules


@pytest.mark.parametrize("by_flag", [False, True])
@pytest.mark.parametrize("after", [1, 5])
@pytest.mark.parametrize("seed", FOLDING[:3])
def test_cancelling_while_a_shape_forms_again_loses_nothing(seed, after, by_flag):
    cage = cage_of(seed)
    at = where_it_begins_again(energies_of_first_level(cage)[0])
    energies, result = energies_of_first_level(cage, at + after - 1, by_flag)
    assert result.stop == "cancelled" and len(energies) == at + after and energies[-1] > 1.2 * energies[at - 1]
    assert result.summary.end.objective == pytest.approx(energies[at - 1], rel=1e-2)
    assert lib.evaluate(result.mesh, tolerance=1e-6).objective == pytest.approx(energies[at - 1], rel=1e-2)
