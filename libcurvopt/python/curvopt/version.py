# SPDX-License-Identifier: GPL-3.0-or-later
"""The version of this package. The root CMakeLists.txt decides; a test compares."""

VERSION = "0.1.0"
