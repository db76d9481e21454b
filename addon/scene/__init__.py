# SPDX-License-Identifier: GPL-3.0-or-later
"""Between Blender's data and arrays: a cage is read from an object, a result is written to one."""
