# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.curvopt
settings.energy = "MIX"
settings.weight_willmore = 1.0
settings.weight_mvs = 0.0
settings.weight_mvs_cross = 0.1
settings.weight_variation = 0.0
settings.weight_mehlum_tarrou = 0.0
settings.weight_mean_curvature = 0.0
settings.weight_area = 0.0
settings.resolution = "SAME"
settings.boundary = "TANGENT"
