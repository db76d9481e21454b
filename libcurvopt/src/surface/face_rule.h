/* Quadrature rules of each kind of face (fan.h), from coarse to fine. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_FACE_RULE_H
#define CO_SURFACE_FACE_RULE_H

#include "surface/stam.h"

/* Rules grow finer with their number; which face gets which is decided by assembly.h. CO_ROUGH_RULE is of `limit`
 * alone: too coarse for figures, and enough while a shape forms, and for a matrix by which steps are found
 * (libcurvopt/notes/25-checking-steps.md, 75-rules-of-a-steps-matrix.md). The ladder's are 0 and up. */
enum { CO_LADDER_RULES = 8, CO_ROUGH_RULE = -1, CO_N_RULES = CO_LADDER_RULES - CO_ROUGH_RULE };
enum { CO_FACE_RULE_GAUSS = 12 }; /* points a side of one Gauss rule at most; finer rules are of several sub-cells */

typedef struct co_face_rule {
    int points;  /* points a side of the face, or of the first ring's cells */
    int least;   /* points a side of the cells of inner rings, at least */
    double hole; /* largest part that the hole may have of an integral over the face; 1: there is no hole */
    double fall; /* points a side of a ring over those of the ring around it; 0: one less instead */
} co_face_rule;

/* Ratios of the integrals over successive rings, of area and of squared curvature (stam.h). */
typedef struct co_ring_tail {
    double area_ratio;      /* lambda^2 */
    double curvature_ratio; /* (mu / lambda^2)^2 lambda^2; where a blend makes curvature a constant, lambda^2 */
    int n_rings;            /* rings down to the hole */
} co_ring_tail;

/* Rule `number`, co_face_rule_coarsest() .. CO_LADDER_RULES - 1, of a kind of face on a surface (curvopt_surface). */
co_face_rule co_face_rule_of(int32_t surface, int32_t kind, int32_t number);
/* The number of the coarsest: CO_ROUGH_RULE or 0. */
int32_t co_face_rule_coarsest(int32_t surface, int32_t kind);
/* Points a side of the cells of a ring, 1, 2 and so on from the outermost. */
int co_face_rule_points(const co_face_rule *rule, int ring);
co_ring_tail co_face_rule_tail(const co_face_rule *rule, const co_stam_disc *disc, int32_t surface);

#endif
