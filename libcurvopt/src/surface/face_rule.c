/* Which points a rule takes on a face: rings round an extraordinary vertex, and the rules of their cells.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/face_rule.h"

#include "base/elementary.h"
#include "mesh/fan.h"
#include "surface/patches.h"

#include <curvopt.h>
#include <math.h>

/* Quadrature rules of each kind of face, from coarse to fine, found by experiment
 * (notes/20-rules-at-an-extraordinary-vertex.md). A regular face has a product rule of Gauss, one of a wide disc away
 * from the vertex a rule that is exact to a total degree. Round an extraordinary vertex each ring of three cells has
 * rules of its own, down to a hole; the integral over the hole is not dropped: what happens in the last ring repeats in
 * the rings inside it with a known ratio (co_ring_tail), which its weights take up.
 *
 * The degree to which a cell's rule is exact, here as the points a side of Gauss's rule of that degree (square_rule.h),
 * falls from ring to ring, down to `least`:
 * - `limit`: by one. All rings look alike, and inner ones count for less and less.
 * - `plane`, `polynomial`: by the factor `fall`. A blend varies most in the first ring.
 * - the vertex of a wide disc: by one, and down to a large hole, since w is flat there and the surface all but a
 *   polynomial of the chart.
 * Every rule is finer than the one before it in the outer rings, and has a deeper hole. Inner rings may have the same
 * rule in both, if what that is off by is little: comparing the two would not tell what is missing there.
 *
 * Example: rule 1 of `limit`, {4, 3, 1e-4, 0}, at valence 3. Integrals shrink by lambda^2 = 0.168 a ring, and 0.168^6 <
 * 1e-4 makes 6 rings, of degrees 7, 5, 5, 5, 5, 5: 3 (12 + 5 * 8) = 156 samples. */
enum { RULES_REGULAR, RULES_PIECE, RULES_LIMIT, RULES_PLANE, RULES_POLYNOMIAL, RULES_WIDE, N_RULE_SETS };
typedef struct listed_rule {
    int points, least;
    double hole, fall; /* fall 0: by one from ring to ring */
} listed_rule;
static const listed_rule of_regular[CO_LADDER_RULES] = {
    {.points = 3, .hole = 1},  {.points = 4, .hole = 1},  {.points = 6, .hole = 1},  {.points = 12, .hole = 1},
    {.points = 24, .hole = 1}, {.points = 48, .hole = 1}, {.points = 72, .hole = 1}, {.points = 96, .hole = 1}};
static const listed_rule of_piece[CO_LADDER_RULES] = {
    {.points = 3, .hole = 1},  {.points = 4, .hole = 1},  {.points = 6, .hole = 1},  {.points = 8, .hole = 1},
    {.points = 11, .hole = 1}, {.points = 18, .hole = 1}, {.points = 30, .hole = 1}, {.points = 50, .hole = 1}};
static const listed_rule of_limit[CO_LADDER_RULES] = {{3, 2, 1e-3, 0},   {4, 3, 1e-4, 0},  {6, 4, 1e-5, 0},
                                                      {10, 5, 1e-6, 0},  {16, 6, 1e-7, 0}, {22, 8, 1e-8, 0},
                                                      {33, 10, 1e-9, 0}, {44, 11, 1e-9, 0}};
static const listed_rule of_plane[CO_LADDER_RULES] = {{8, 3, 1e-3, 0.5},  {16, 4, 1e-4, 0.5},  {24, 5, 1e-5, 0.5},
                                                      {36, 6, 1e-6, 0.5}, {48, 7, 1e-7, 0.5},  {72, 8, 1e-8, 0.5},
                                                      {96, 9, 3e-9, 0.5}, {120, 10, 1e-9, 0.5}};
static const listed_rule of_polynomial[CO_LADDER_RULES] = {
    {4, 1, 1e-3, 0.62},  {6, 1, 1e-4, 0.64},  {8, 2, 1e-5, 0.62},  {12, 3, 1e-6, 0.62},
    {16, 4, 3e-7, 0.62}, {22, 6, 1e-7, 0.62}, {33, 9, 3e-8, 0.62}, {44, 11, 1e-8, 0.62}};
static const listed_rule of_wide[CO_LADDER_RULES] = {{3, 2, 1e-1, 0},   {4, 3, 1e-2, 0},  {6, 4, 1e-3, 0},
                                                     {10, 5, 1e-4, 0},  {16, 6, 1e-5, 0}, {22, 8, 1e-6, 0},
                                                     {33, 10, 1e-7, 0}, {44, 11, 1e-8, 0}};
static const listed_rule *const rules[N_RULE_SETS] = {
    [RULES_REGULAR] = of_regular, [RULES_PIECE] = of_piece,           [RULES_LIMIT] = of_limit,
    [RULES_PLANE] = of_plane,     [RULES_POLYNOMIAL] = of_polynomial, [RULES_WIDE] = of_wide};
static const listed_rule rough = {2, 1, 1e-2, 0}; /* CO_ROUGH_RULE */
enum {
    MIN_RINGS = 4, /* least number of rings at an extraordinary vertex */
    MAX_RINGS = 40 /* largest number of rings */
};

static int set_of(int32_t surface, int32_t kind) {
    static const int of_surface[] = {[CURVOPT_SURFACE_LIMIT] = RULES_LIMIT,
                                     [CURVOPT_SURFACE_PLANE] = RULES_PLANE,
                                     [CURVOPT_SURFACE_POLYNOMIAL] = RULES_POLYNOMIAL};
    if (kind == CO_FAN_REGULAR)
        return RULES_REGULAR;
    if (co_patches_is_one_piece(kind))
        return RULES_PIECE;
    if (co_fan_is_half(kind)) /* whose E is as narrow as a blend of width 1 (blend_fit_half.h) */
        return RULES_POLYNOMIAL;
    return co_fan_is_wide(kind) && co_fan_wide_width(kind) > 1 ? RULES_WIDE : of_surface[surface];
}

co_face_rule co_face_rule_of(int32_t surface, int32_t kind, int32_t number) {
    const int set = set_of(surface, kind);
    const listed_rule *r = number == CO_ROUGH_RULE ? &rough : &rules[set][number];
    return (co_face_rule){.points = r->points, .least = r->least, .hole = r->hole, .fall = r->fall};
}

int32_t co_face_rule_coarsest(int32_t surface, int32_t kind) {
    return set_of(surface, kind) == RULES_LIMIT ? CO_ROUGH_RULE : 0;
}

co_cell_rule co_face_rule_of_cell(const co_face_rule *rule, int ring) {
    int points =
        rule->fall > 0 ? (int)floor(rule->points * co_power(rule->fall, ring - 1) + 0.5) : rule->points - (ring - 1);
    points = points > rule->least ? points : rule->least;
    const int splits = (points + CO_SQUARE_RULE_GAUSS - 1) / CO_SQUARE_RULE_GAUSS;
    return (co_cell_rule){.splits = splits, .gauss = (points + splits - 1) / splits};
}

int32_t co_face_rule_samples(const co_face_rule *rule, int ring) {
    const co_cell_rule c = co_face_rule_of_cell(rule, ring);
    return c.splits * c.splits * co_square_rule_size(c.gauss);
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
