# SPDX-License-Identifier: GPL-3.0-or-later
"""libcurvopt through ctypes: the header's structs and names, plain values, and the library itself. No bpy."""
