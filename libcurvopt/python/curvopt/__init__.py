# SPDX-License-Identifier: GPL-3.0-or-later
"""Curvature energies of Catmull-Clark surfaces and their minimizers; libcurvopt through ctypes.

    import curvopt
    cube = curvopt.cage(points, faces)
    print(curvopt.energies(cube).terms["willmore"])
    fair = curvopt.minimize(cube, "mvs", levels=3)
    print(fair.energies.objective, fair.summary.verification.verdict, fair.cage.positions.shape)

The public side is `api`, with errors of `library` and plain values of `values`. `abi` mirrors curvopt.h, `locate` finds the file.
"""

from .api import *  # noqa: F403
from .api import __all__ as _public
from .library import Cancelled, CurvoptError, LibraryError
from .solver import Solver
from .values import Energies, Exceptions, LevelReport, Progress, Summary, Verification
from .version import VERSION as __version__

__all__ = [
    *_public, "Cancelled", "CurvoptError", "Energies", "Exceptions", "LevelReport", "LibraryError", "Progress", "Solver", "Summary", "Verification",
    "__version__",
]  # fmt: skip
