# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of addon/batch.py: one file, or many."""
