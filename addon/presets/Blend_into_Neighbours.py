# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.curvopt
settings.energy = "WILLMORE"
settings.strength = 0.5
settings.resolution = "SAME"
settings.boundary = "TANGENT"
settings.pin = "UNSELECTED"
