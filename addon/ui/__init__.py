# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user sees and presses: settings, operators, panels, menus, and drawing over a viewport."""
