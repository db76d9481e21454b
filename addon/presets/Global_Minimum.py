# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.curvopt
settings.strength = 1.0
settings.resolution = "REFINE"
settings.levels = 4
