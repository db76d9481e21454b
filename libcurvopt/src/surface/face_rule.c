/* Which points a rule takes on a face: rings round an extraordinary vertex, and Gauss points in their cells.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/face_rule.h"

#include "base/elementary.h"
#include "mesh/fan.h"
#include "surface/patches.h"

#include <curvopt.h>
#include <math.h>

/* Quadrature rules of each kind of face, from coarse to fine, found by experiment
 * (notes/20-rules-at-an-extraordinary-vertex.md). A regular face has one product rule of Gauss. Round an extraordinary
 * vertex each ring of three cells has rules of its own, down to a hole; the integral over the hole is not dropped: what
 * happens in the last ring repeats in the rings inside it with a known ratio (co_ring_tail), which its weights take up.
 *
 * Points a side fall from ring to ring, down to `least`:
 * - `limit`: by one. All rings look alike, and inner ones count for less and less.
 * - `plane`, `polynomial`: by the factors in `fall`. A blend varies most in the first ring
 *   (libcurvopt/notes/20-rules-at-an-extraordinary-vertex.md).
 * - the vertex of a wide disc: by one, and down to a large hole, since w is flat there and the surface all but a
 *   polynomial of the chart.
 * Every rule is finer in all respects than the one before it, or comparing the two would not tell what is missing.
 *
 * Example: rule 1 of `limit`, {4, 3, 1e-4}, at valence 3. Integrals shrink by lambda^2 = 0.168 a ring, and 0.168^6 <
 * 1e-4 makes 6 rings, of 4, 3, 3, 3, 3, 3 points a side: 3 (16 + 5 * 9) = 183 samples. */
enum { RULES_REGULAR, RULES_LIMIT, RULES_PLANE, RULES_POLYNOMIAL, RULES_WIDE, N_RULE_SETS };
typedef struct listed_rule {
    int points, least;
    double hole;
} listed_rule;
static const listed_rule rules[N_RULE_SETS][CO_LADDER_RULES] = {
    {{3, 3, 1}, {4, 4, 1}, {6, 6, 1}, {12, 12, 1}, {24, 24, 1}, {48, 48, 1}, {72, 72, 1}, {96, 96, 1}},
    {{3, 2, 1e-3},
     {4, 3, 1e-4},
     {6, 4, 1e-5},
     {10, 5, 1e-6},
     {16, 6, 1e-7},
     {24, 8, 1e-8},
     {36, 10, 1e-9},
     {48, 12, 1e-9}},
    {{8, 3, 1e-3},
     {16, 4, 1e-4},
     {24, 5, 1e-5},
     {36, 6, 1e-6},
     {48, 7, 1e-7},
     {72, 8, 1e-8},
     {96, 9, 3e-9},
     {120, 10, 1e-9}},
    {{4, 1, 1e-3},
     {6, 2, 1e-4},
     {8, 3, 1e-5},
     {12, 4, 1e-6},
     {16, 5, 3e-7},
     {24, 6, 1e-7},
     {36, 9, 3e-8},
     {48, 12, 1e-8}},
    {{3, 2, 1e-1},
     {4, 3, 1e-2},
     {6, 4, 1e-3},
     {10, 5, 1e-4},
     {16, 6, 1e-5},
     {24, 8, 1e-6},
     {36, 10, 1e-7},
     {48, 12, 1e-8}}};
static const listed_rule rough = {2, 1, 1e-2}; /* CO_ROUGH_RULE */
/* Points a side of a ring over those of the ring around it; 0: one less instead. */
static const double fall[N_RULE_SETS] = {[RULES_PLANE] = 0.5, [RULES_POLYNOMIAL] = 0.62};
enum {
    MIN_RINGS = 4, /* least number of rings at an extraordinary vertex */
    MAX_RINGS = 40 /* largest number of rings */
};

static int set_of(int32_t surface, int32_t kind) {
    static const int of_surface[] = {[CURVOPT_SURFACE_LIMIT] = RULES_LIMIT,
                                     [CURVOPT_SURFACE_PLANE] = RULES_PLANE,
                                     [CURVOPT_SURFACE_POLYNOMIAL] = RULES_POLYNOMIAL};
    if (co_patches_is_one_piece(kind))
        return RULES_REGULAR;
    if (co_fan_is_half(kind)) /* whose E is as narrow as a blend of width 1 (blend_fit_half.h) */
        return RULES_POLYNOMIAL;
    return co_fan_is_wide(kind) && co_fan_wide_width(kind) > 1 ? RULES_WIDE : of_surface[surface];
}

co_face_rule co_face_rule_of(int32_t surface, int32_t kind, int32_t number) {
    const int set = set_of(surface, kind);
    const listed_rule *r = number == CO_ROUGH_RULE ? &rough : &rules[set][number];
    return (co_face_rule){.points = r->points, .least = r->least, .hole = r->hole, .fall = fall[set]};
}

int32_t co_face_rule_coarsest(int32_t surface, int32_t kind) {
    return set_of(surface, kind) == RULES_LIMIT ? CO_ROUGH_RULE : 0;
}

int co_face_rule_points(const co_face_rule *rule, int ring) {
    int points = rule->fall > 0 ? (int)ceil(rule->points * co_power(rule->fall, ring - 1)) : rule->points - (ring - 1);
    points = points > rule->least ? points : rule->least;
    int splits = (points + CO_FACE_RULE_GAUSS - 1) / CO_FACE_RULE_GAUSS; /* equal sub-cells: rounded up to a multiple */
    return (points + splits - 1) / splits * splits;
}

co_ring_tail co_face_rule_tail(const co_face_rule *rule, const co_stam_disc *disc, int32_t surface) {
    double lambda = disc->lambda, mu = disc->mu;
    co_ring_tail t = {.area_ratio = lambda * lambda, .curvature_ratio = mu * mu / (lambda * lambda)};
    if (surface != CURVOPT_SURFACE_LIMIT) /* smooth there: curvature behaves like a constant */
        t.curvature_ratio = t.area_ratio;
    const double ratio = fmax(t.area_ratio, t.curvature_ratio);
    t.n_rings = MIN_RINGS;
    while (t.n_rings < MAX_RINGS && co_power(ratio, t.n_rings) > rule->hole)
        t.n_rings++;
    return t;
}
