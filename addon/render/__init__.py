# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures in files: a scene that goes away again, light, camera, materials, captions."""
