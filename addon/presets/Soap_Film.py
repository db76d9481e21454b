# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.curvopt
settings.energy = "WILLMORE"
settings.strength = 1.0
settings.resolution = "REFINE"
settings.levels = 4
settings.symmetry = "AUTO"
