# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run tells people: its progress, its outcome, its verdict, its failure; each in a sentence. No bpy."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..binding.library import CurvoptError, LibraryError
from ..binding.values import Energies, Exceptions, Progress, Verification
from . import least
from .energy import number_text, weights_of
from .job import ModalRun, Phase, Request, Solution
from .live import View
from .rims import is_open


class UserError(RuntimeError):
    """Something cannot be done; the message is a sentence that says what, where, and what to do."""


# ---------------------------------------------------------------------------------------------------- while it runs --


def status_text(run: ModalRun) -> str:
    """What a run is doing."""
    progress = run.job.latest
    if run.phase is Phase.FINISHING:
        return f"Minimizing {run.label}: finishing with the best surface so far"
    return f"Minimizing {run.label}: {progress_text(progress) if progress else 'preparing'}"


def progress_text(progress: Progress) -> str:
    """Level, iteration and energy in words."""
    return (
        f"level {progress.level} of {progress.levels}, iteration {progress.iteration}, "
        f"energy {number_text(progress.energy)} (from {number_text(progress.start_energy)})"
    )


_MANY = 2_000  # vertices from which on a cage is the reason why a surface comes late
_LATE = 0.5  # seconds behind the hand from which on it is said


def live_text(request: Request, view: View) -> str:
    """What a surface that follows the hand has come to."""
    vertices = len(view.snapshot.cage)
    if view.number == 0:
        slow = f": {vertices:,} vertices take their time" if vertices > _MANY else ""
        return f"Live: preparing{slow}"
    now = f"Live: {_before_number(request, _objective_name(request))} {number_text(view.energy)}"
    summary = view.summary
    if summary is None:
        behind = f" {view.lag:.1f} s behind the hand, because the cage is large ({vertices:,} vertices)"
        return f"{now}, following{behind if view.lag > _LATE and vertices > _MANY else ''}"
    verdict = verdict_text(
        summary.verification, summary.end.objective, summary.symmetry_order, summary.stop, request.strength
    )
    return f"{now} (from {number_text(summary.start.objective)}). {verdict}"


IN_ONE_PLACE = " Some handles are in one place: move them apart."  # behind an outcome that may be their fault


# --------------------------------------------------------------------------------------------------------- its end --


_STOP_WORDS = {
    "converged": "converged",
    "stalled": "stopped early: no further decrease was found",
    "limit": "stopped early at the iteration limit, still falling",
    "cancelled": "stopped early as you asked, still falling",
    "memory": "stopped early: the next level needs more memory than there is",
    "unresolved": "stopped early: the surface develops features too fine to resolve",
    "settled": "settled: it falls too slowly to go on",
    "grown": "stopped early: the surface grows without end",
}


def solution_text(request: Request, solution: Solution, remark: str = "") -> str:
    """The outcome in one sentence, and a remark in another."""
    return _report(request, solution, "", f"{len(solution.cage.positions)} vertices", remark)


def part_text(request: Request, solution: Solution, n_moved: int, remark: str = "") -> str:
    """The same of a run on a part of a cage, of which `n_moved` vertices moved."""
    faces = _counted(len(solution.cage.face_sizes) - len(request.holes), "face", "faces")
    moved = _counted(n_moved, "vertex", "vertices")
    return _report(request, solution, f" of the {faces} that change", f"{moved} moved", remark)


def _report(request: Request, solution: Solution, of_what: str, counted: str, remark: str) -> str:
    before, after = (number_text(_reported(request, energies)) for energies in (solution.start, solution.end))
    subject = f"{_reported_name(request)}{of_what}"
    if before == after == "0":
        least_of_all = f"{subject} is 0 already, the least that there is ({counted}, {solution.seconds:.1f} s)"
        return f"{least_of_all}{f'. {remark}' if remark else ''}"
    outcome = f"{subject} is {after} as before" if before == after else f"{_before_number(request, subject)} {before} to {after}"
    order = solution.symmetry_order
    kept = f", {order} symmetries kept" if order > 1 else ""
    near = "" if request.strength == 1 else f"stayed near the original (strength {request.strength:.3g}), "
    near += f"stayed within {number_text(request.within)} of the original, " if request.within > 0 else ""
    near += through_text(request)
    return (
        f"{outcome}, {near}{_STOP_WORDS[solution.stop]} "
        f"({counted}{kept}, {solution.seconds:.1f} s)"
        f"{f'. {remark}' if remark else ''}"
    )


_HELFRICH = "Helfrich"


def _objective_name(request: Request) -> str:
    """What is minimized: with a spontaneous curvature that is another number than the energy alone."""
    spontaneous = request.options.get("spontaneous_curvature")
    return f"{request.label} with Spontaneous Curvature {spontaneous:.4g}" if spontaneous else request.label


def _is_helfrich(request: Request) -> bool:
    """Whether bending with a spontaneous curvature is minimized, and nothing else."""
    return bool(request.options.get("spontaneous_curvature")) and len(weights_of(request.energy)) == 1


def _reported_name(request: Request) -> str:
    return _HELFRICH if _is_helfrich(request) else _objective_name(request)


def _before_number(request: Request, subject: str) -> str:
    """With a colon if it is more than a name."""
    return subject if subject in (request.label, _HELFRICH) else f"{subject}:"


def _reported(request: Request, energies: Energies) -> float:
    """The number of a report. What is minimized leaves out the part of Helfrich's energy that cannot change."""
    return energies.helfrich if _is_helfrich(request) else energies.objective


def nothing_found_text(label: str) -> str:
    """That a run was ended before it had anything to write, in a sentence."""
    return f"Minimizing {label} was ended before its first step: nothing was found yet, and nothing was changed. Let it run longer."


def torn_text(n_torn: int) -> str:
    """That the mesh is open where vertices of its boundary lie in one place, and what to do, in a sentence; empty for none."""
    if not n_torn:
        return ""
    return (
        f"{n_torn} vertices of the boundary lie where another one does, so the surface is torn open there: if it is to be "
        "closed, join them by Merge by Distance in Edit Mode, and run again"
    )


def through_text(request: Request) -> str:
    """What the surface goes through, and what follows curves, with a comma behind each; empty for nothing."""
    drawn = [one.weight < 1 for one in (*request.through, *request.chains)]
    word = "near" if any(drawn) else "through"
    text = f"{word} {_counted(len(request.through), 'place', 'places')}, " if request.through else ""
    return text + (f"{'near' if any(drawn) else 'along'} {_counted(len(request.chains), 'curve', 'curves')}, " if request.chains else "")


def refined_text(request: Request) -> str:
    """That more vertices came out than were asked for, and why, in a sentence; empty if not."""
    if not request.refined:
        return ""
    often = {1: "once", 2: "twice"}.get(request.refined, f"{request.refined} times")
    return f"The cage was refined {often}, because all of its own vertices are held by boundary, creases or pins"


def marks_text(request: Request) -> str:
    """That marks counted, in a sentence; empty if there are none on the boundary."""
    if not request.marked:
        return ""
    return f"Of {_counted(request.marked, 'edge', 'edges')} of the boundary the marks say what stays"


def sliding_text(request: Request, solution: Solution) -> str:
    """How many vertices Slide lets move, in a sentence; empty without it."""
    if not request.options.get("slide"):
        return ""
    if not solution.n_sliding:
        return "Slide moves nothing: no vertex may move along a boundary or a crease"
    little = "" if request.strength == 1 else ", but little at strengths below 1"
    return f"Slide lets {_counted(solution.n_sliding, 'vertex', 'vertices')} move along boundaries and creases{little}"


_REACHED = 1e-8  # relative distance from a number that is held up to which it is kept


def volume_text(request: Request, solution: Solution) -> str:
    """That the volume that was to be kept is another one, in a sentence; empty if it was kept, or not asked for. What lies
    under faces that are left out is not in it, and they follow those beside them."""
    residual = abs(solution.scalar_residuals.get("volume", 0.0))
    if not request.keeps_volume:
        return ""
    if residual <= _REACHED:
        left_out = solution.exceptions.n_left_out
        return "Keep Volume does not see the faces that are left out: the volume under them may change" if left_out else ""
    known = math.isfinite(residual) and math.isfinite(solution.end.volume)  # else it is not a part of the volume
    return f"The volume could not be kept{f', it is {100 * residual:.2g} % off' if known else ''}"


def deviation_text(solution: Solution) -> str:
    """How far the result's surface is from the original's, in a sentence; empty if that was not measured."""
    found = solution.deviation
    if found is None:
        return ""
    return (
        f"Farthest from the original: {number_text(found.max)} (at most {number_text(found.bound)}), "
        f"root mean square {number_text(found.rms)}."
    )


_GROWN = 10.0  # times the area that the original had, from which on that is said


def growth_text(request: Request, solution: Solution) -> str:
    """That an open surface has grown because nothing holds its boundary, in a sentence; empty if it has not."""
    times = solution.end.area / solution.start.area if solution.start.area > 0 else math.nan
    if request.boundary != "free" or not times > _GROWN or not is_open(solution.cage):
        return ""
    return f"The surface has {times:.3g} times the area that it had: with a free boundary bending falls as it grows. Hold the boundary, or more vertices"


_NEXT_TO_ALL = 0.99  # of the energy, from which on a strength below 1 is said to have left the shape as it was


def unchanged_text(request: Request, solution: Solution) -> str:
    """That the strength left next to all of the shape, and what to do, in a sentence; empty if not."""
    before, after = solution.start.objective, solution.end.objective
    ended = solution.stop in ("converged", "settled")
    if not ended or request.strength == 1 or request.within > 0 or not 0 < before * _NEXT_TO_ALL <= after <= before:
        return ""
    return f"Strength {request.strength:.3g} takes short bumps only, and there are next to none here: raise it to change more"


def crossings_text(solution: Solution) -> str:
    """That the result's surface crosses itself, in a sentence; empty if it was not found to."""
    if solution.crossings is None or not solution.crossings.n_pairs:
        return ""
    before = f", the original at {solution.n_crossing_before}" if solution.n_crossing_before else ""
    return f"The surface crosses itself at {_counted(solution.crossings.n_pairs, 'pair', 'pairs')} of faces{before}"


def folds_text(solution: Solution) -> str:
    """What was done about faces of the original that are folded, or is to be done, in a sentence; empty if none is."""
    if not solution.folded:
        return ""
    named = ", ".join(f"face {face}" for face in solution.folded[:_MOST_NAMED])
    more = f" and {len(solution.folded) - _MOST_NAMED} more" if len(solution.folded) > _MOST_NAMED else ""
    folded = f"The original is folded ({named}{more})"
    if solution.n_unfolded:
        return f"{folded}: {_counted(solution.n_unfolded, 'vertex was', 'vertices were')} put between their neighbours first"
    return f"{folded}, so that the energy is infinite: move vertices back that lie beyond others"


def contact_text(request: Request, solution: Solution) -> str:
    """What No Crossings holds the result by, and what it could not prevent, in a sentence; empty without it."""
    if not request.options.get("no_crossings"):
        return ""
    parts = []
    if solution.touching:
        pairs, gap = _counted(len(solution.touching), "pair", "pairs"), number_text(solution.clearance)
        parts.append(f"The surface is held by contact with itself: {pairs} of faces, {gap} apart at the closest")
    if solution.n_crossing_before and not crossings_text(solution):
        pairs_before = _counted(solution.n_crossing_before, "pair", "pairs")
        parts.append(f"The original crosses itself at {pairs_before} of faces, which may go on crossing")
    return ". ".join(parts)


def smoothed_text(name: str, in_place: bool) -> str:
    """That a result looks smoother than object `name`, which had no Subdivision Surface modifier, for that reason
    alone."""
    if in_place:
        return f"Object '{name}' got a Subdivision Surface modifier, because its smooth surface was optimized"
    return f"The result has a Subdivision Surface modifier: give '{name}' one as well to compare them"


def not_smooth_text(name: str) -> str:
    """That object `name`, which has no Subdivision Surface modifier, shows its cage after a run in Edit Mode."""
    return f"Object '{name}' shows its cage: give it a Subdivision Surface modifier to see the surface that was optimized"


_MOST_NAMED = 3


def exceptions_text(found: Exceptions) -> str:
    """What was held and left out of the energy, and why, in a sentence; empty for nothing."""
    if found.n_held == 0:
        return ""
    parts = []
    for reason, vertices in found.reasons:
        named = ", ".join(f"vertex {vertex}" for vertex in vertices[:_MOST_NAMED])
        more = f" and {len(vertices) - _MOST_NAMED} more" if len(vertices) > _MOST_NAMED else ""
        parts.append(f"{reason} ({named}{more})")
    counts = f"{_counted(found.n_held, 'vertex', 'vertices')} held as they are"
    if found.n_left_out:
        counts += f", {_counted(found.n_left_out, 'face', 'faces')} left out of the energy"
    return in_blender(f"{counts}: {'; '.join(parts)}")


def _counted(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"


def verdict_text(
    verification: Verification, energy: float, symmetry_order: int = 1, stop: str = "converged", strength: float = 1.0
) -> str:
    """What the Hessian says of a result of this energy, in a sentence; without a Hessian, why the run stopped. Only
    directions that keep the symmetries were looked at. Below a strength of 1 the Hessian is that of the energy and of
    the springs to the original together."""
    directions = verification.negative_directions
    more = "some directions" if directions < 1 else f"{directions} direction{'s' if directions > 1 else ''}"
    gain = verification.newton_decrement / energy if energy > 0 else math.nan
    less = "less" if not math.isfinite(gain) else f"about {100 * gain:.2g} % less" if gain < 1 else "much less"
    among = " among shapes of the same symmetry" if symmetry_order > 1 else ""
    both = "" if strength == 1 else " of energy and nearness to the original together"
    if verification.verdict == "minimum":
        return f"Checked: a {'' if both else 'true '}local minimum{both}{among}."
    if verification.verdict == "saddle":
        return f"Checked: a saddle{both}, {more} would still lead down."
    if verification.verdict == "not stationary":
        also = f", more along {more}" if directions else ""
        return f"Checked: not yet a minimum{both}, {less} seems possible{also}."
    if stop in ("cancelled", "limit", "memory"):
        return "Not checked: the run was stopped early, the energy was still falling."
    return "Not checked: whether this is a minimum is not known."


def verdict_of(request: Request, solution: Solution) -> str:
    """The verdict on a run; whether a touch ends it; and where a theorem says that nothing of that topology has less,
    that, with its source."""
    text = verdict_text(
        solution.verification, solution.end.objective, solution.symmetry_order, solution.stop, request.strength
    )
    return f"{text}{delicacy_text(solution.verification, solution.end.objective)}{_least_text(request, solution)}"


def delicacy_text(verification: Verification, energy: float) -> str:
    """What a touch does to a minimum of this energy that does not bear one; otherwise nothing."""
    if not verification.is_delicate:
        return ""
    rise = verification.touch_rise / energy if energy > 0 else math.inf
    raised = f"by {100 * rise:.2g} %" if rise < 1 else f"to {1 + rise:.2g} times as much" if rise < math.inf else "far"
    return (
        f" It is delicate: with its vertices moved by a thousandth of an edge it rises {raised}, and minimized again "
        "from there it may end elsewhere."
    )


def _least_text(request: Request, solution: Solution) -> str:
    """Of bending alone, of a closed surface, by its value within the stated errors; otherwise nothing."""
    end, weights = solution.end, weights_of(request.energy)
    ((energy, weight),) = weights.items() if len(weights) == 1 else (("", 0.0),)
    bare = weight == 1 and not request.options.get("spontaneous_curvature")
    if not (bare and math.isfinite(end.volume) and solution.verification.verdict == "minimum"):
        return ""
    known = least.least(energy, solution.euler)
    if not least.is_least(end.objective, known, solution.discretization_error, end.objective_error):
        return ""
    genus = least.genus(solution.euler)
    return f" No surface of genus {genus} has less, within the error ({least.SOURCES[genus]})."


# ------------------------------------------------------------------------------------------------------ its failure --


GO_THROUGH_STRENGTH = "Go Through needs a Strength of 1"
GO_THROUGH_LIVE = "Go Through does not count in Live: only handles and pins hold the surface"
GO_THROUGH_EDIT = "Go Through does not count in Edit Mode: press Minimize in Object Mode for it"

# The library's words for what has another name in Blender.
_IN_BLENDER = (
    ("an infinitely sharp vertex makes a cone", "a vertex crease of 1, or the end of a loose edge, makes a cone"),
    (
        "edges of length 0, or far too short for the cage, leave no tangent plane",
        "vertices in one place, or next to it, leave no tangent plane, Merge by Distance joins them",
    ),
    ("; constrain the vertex itself", ": take it off the pins, or turn off On Surface"),
    ("no_crossings and slide exclude each other: that looks for no crossings", "No Crossings and Slide exclude each other: turn one of them off"),
    ("spontaneous_curvature is", "Spontaneous Curvature is"),
    ("neither willmore nor mean_curvature has a weight", "neither Willmore nor Mean curvature is minimized"),
    ("what the surface goes through cannot be had with a strength below 1", GO_THROUGH_STRENGTH),
    ("that the surface goes through cannot be had with mirror planes that were chosen", "need the Symmetry Automatic, or None"),
    ("what the surface goes through cannot be had with a distance that the surface stays within", "Go Through needs a Within of 0"),
    (
        ": leave the entry out; where on its curve a chain has its vertices its parameters say",
        ": move it away from the chain, or take it out of the collection",
    ),
    ("give both parameters at which their curves meet", "let the curves meet there, or set a Weight below 1"),
    (
        "give its vertices parameters, a curve that is as long as the chain, or a chain nearer to it",
        "let the curve run beside the chain, on one side from the first vertex to the last and beyond, or mark fewer vertices",
    ),
    ("follow each other smoothly: give parameters that are more even", "follow each other smoothly: let the curve run nearer to the chain"),
    ("has a constraint of its own: leave one of them out", "is pinned: take it off the pins or out of the vertex group"),
    (", weights below 1, or chains that do not touch", ", a Weight below 1, or chains that do not touch"),
    (", a weight below 1, or two chains that do not touch", ", a Weight below 1, or two curves for two chains that do not touch"),
    ("the boundary, a crease or left-out faces hold all of its vertices", "Boundary or creases hold all of its vertices"),
    ("nothing that its point depends on may move", "the surface is held there by Boundary, creases or pins"),
    ("or refine the cage once", "or subdivide the cage once"),
    ("hold less, or use more levels", "choose another Boundary, fewer pins, or Refine"),
    ("what is inside; hold the boundary", "what is inside: choose another Boundary, or turn off Keep Volume"),
)


def collapsed_text(faces: Sequence[int]) -> str:
    """What goes behind a refusal of a shape whose `faces` have corners in one place; empty for none of them."""
    if not len(faces):
        return ""
    several = f"{len(faces)} faces have" if len(faces) > 1 else "one face has"
    return f"; {several} corners in one place (face {faces[0]}): merge them by distance in Edit Mode first"


def is_foreseen(error: BaseException) -> bool:
    """Whether the error's message is for the user; all others are faults of the program, or the system's refusals."""
    return isinstance(error, (UserError, LibraryError, CurvoptError, ValueError))


def failure_text(error: BaseException) -> str:
    """An error as one sentence; anything unforeseen with its type, so that it can be reported."""
    if is_foreseen(error):
        return sentence(in_blender(str(error)))
    if isinstance(error, OSError):
        return sentence(f"Could not finish: {error}")
    return f"Unexpected {type(error).__name__}: {error}."


def in_blender(text: str) -> str:
    """The library's text with Blender's names for things."""
    for theirs, ours in _IN_BLENDER:
        text = text.replace(theirs, ours)
    return text


def sentence(text: str) -> str:
    """The text on one line with a capital and a full stop."""
    text = " ".join(text.split())
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")
