/* Numbers of mathematics, and numbers that define what words of the interface mean. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef CO_BASE_CONSTANTS_H
#define CO_BASE_CONSTANTS_H

/* C11 itself names no constant. */
#define CO_PI 3.14159265358979323846

/* Resolved, though the finest rules miss the tolerance: relative error up to which that is so. It is far from what an
 * optimizer could gain in the gap (libcurvopt/notes/21-which-faces-get-finer-rules.md). */
#define CO_ACCEPTABLE_ERROR 1e-2
/* Degenerate: area of the surface, in units of the radius squared (libcurvopt/notes/24-true-errors.md). */
#define CO_LEAST_AREA 1e-9
/* Folded: a Gauss-Bonnet defect above it, in radians, besides CO_ACCEPTABLE_ERROR of Willmore's energy. */
#define CO_LARGEST_DEFECT 1.0
/* Errors per cost of symmetric patches differ by less, relatively, by rounding: they are marked alike. */
#define CO_MARKING_TIE 1e-6
/* An invariance: least part of a motion that must be free (libcurvopt/notes/72-invariances.md), */
#define CO_ALLOWED_MOTION 0.1
/* and of what is free, that must be left beside the other motions. */
#define CO_INDEPENDENT_MOTION 1e-6
/* Flat but for rounding: energy of a surface of radius 1. */
#define CO_FLAT_ENERGY 1e-20
/* Longest displacement for differences of the gradient, in mean edges. */
#define CO_DIFFERENCE_STEP 1e-3

#endif
