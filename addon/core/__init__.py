# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that works on arrays: energies, creases, curvatures, a run on a worker thread and its texts. No bpy."""
