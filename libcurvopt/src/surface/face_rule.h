/* Quadrature rules of each kind of face (fan.h), from coarse to fine. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SURFACE_FACE_RULE_H
#define CO_SURFACE_FACE_RULE_H

#include "surface/square_rule.h"
#include "surface/stam.h"

/* Rules grow finer with their number; which face gets which is decided by assembly.h. CO_ROUGH_RULE is of `limit`
 * alone: too coarse for figures, and enough while a shape forms, and for a matrix by which steps are found
 * (libcurvopt/notes/25-checking-steps.md, 75-rules-of-a-steps-matrix.md). The ladder's are 0 and up. */
enum { CO_LADDER_RULES = 8, CO_ROUGH_RULE = -1, CO_N_RULES = CO_LADDER_RULES - CO_ROUGH_RULE };

/* Points are those a side of Gauss's rule of the same degree. */
typedef struct co_face_rule {
    int points;  /* of the face, or of the first ring's cells */
    int least;   /* of the cells of inner rings, at least */
    double hole; /* largest part that the hole may have of an integral over the face; 1: there is no hole */
    double fall; /* points of a ring over those of the ring around it; 0: one less instead */
} co_face_rule;

/* The rule of a ring's cell. */
typedef struct co_cell_rule {
    int splits; /* equal sub-cells a side */
    int gauss;  /* rule of each: co_square_rule_make() */
} co_cell_rule;

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
/* The rule of each cell of a ring, 1, 2 and so on from the outermost, and its number of samples. */
co_cell_rule co_face_rule_of_cell(const co_face_rule *rule, int ring);
int32_t co_face_rule_samples(const co_face_rule *rule, int ring);
co_ring_tail co_face_rule_tail(const co_face_rule *rule, const co_stam_disc *disc, int32_t surface);

#endif
