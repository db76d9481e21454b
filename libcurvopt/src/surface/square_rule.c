/* Cubature on the square (sources: square_rule.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include "surface/square_rule.h"

#include "surface/gauss_legendre.h"

/* Points that the square's symmetries take to each other: (x, y) on -1..1, x >= y >= 0, and the weight of each. Found
 * by Newton's method from the conditions that moments are exact, of which there are as many as unknowns
 * (libcurvopt/notes/20-rules-at-an-extraordinary-vertex.md); test_square_rule.c tests them. */
typedef struct orbit {
    double x, y, weight;
} orbit;

static const orbit degree_5[] = {{0.68313005106397318, 0, 0.20408163265306123},
                                 {0.88191710368819687, 0.88191710368819687, 0.045918367346938778}};
static const orbit degree_7[] = {{0.92582009977255142, 0, 0.060493827160493827},
                                 {0.80597978291859873, 0.80597978291859873, 0.059357943672657558},
                                 {0.38055443320831567, 0.38055443320831567, 0.13014822916684862}};
static const orbit degree_9[] = {{0.48892685697436905, 0, 0.11354099017168726},
                                 {0.9396552580968377, 0.9396552580968377, 0.010682807966443941},
                                 {0.69088055048634389, 0.69088055048634389, 0.053550090231715405},
                                 {0.91862044105672225, 0.34487202536440359, 0.036113055815076699}};
static const orbit degree_11[] = {{0.78036107500268992, 0, 0.059486077242113515},
                                  {0.89413367561834711, 0.89413367561834711, 0.018143045131621533},
                                  {0.63057348160127635, 0.63057348160127635, 0.055633242022661095},
                                  {0.32796616722057642, 0.22979001710393285, 0.038144635688831731},
                                  {0.96217075160817578, 0.43088619762191954, 0.020224182112970192}};
static const orbit degree_13[] = {{0, 0, 0.00086698105633418803},
                                  {0.37760244682200256, 0, 0.068818035189043669},
                                  {0.96157792330976821, 0.96157792330976821, 0.0038692377097481715},
                                  {0.81668668875884021, 0.81668668875884021, 0.023223925473280695},
                                  {0.96942865317508242, 0.55273175239933359, 0.012852978510198902},
                                  {0.69682993710120278, 0.37471085476701421, 0.049117707816941615},
                                  {0.91652910445562419, 0.048958473815051466, 0.014965341854781438}};
static const orbit degree_15[] = {{0.30996775963142448, 0, 0.047124079799398436},
                                  {0.86903785354642249, 0, 0.028071064465205867},
                                  {0.442618283415257, 0.442618283415257, 0.013175370445376878},
                                  {0.97149362004498252, 0.97149362004498252, 0.0018043087307529594},
                                  {0.9769978535299203, 0.34365912439519442, 0.0099629113600971098},
                                  {0.94836873825024548, 0.78699644070404395, 0.0095168606260035496},
                                  {0.62376368694986917, 0.27445179528645702, 0.03574833572498911},
                                  {0.81389004069912074, 0.57254913639999372, 0.024684480568543166}};
static const orbit degree_17[] = {{0.89169685711069835, 0, 0.016922602158810498},
                                  {0.58498490769389178, 0, 0.037612694181316103},
                                  {0.84256896454494401, 0.84256896454494401, 0.011500172230979605},
                                  {0.18741733531854768, 0.18741733531854768, 0.035101211224027533},
                                  {0.66338103845425866, 0.66338103845425866, 0.021875840526676942},
                                  {0.47908406508454121, 0.37329642537149171, 0.018236896311971885},
                                  {0.94296430624211502, 0.61317102867482265, 0.011635026841384432},
                                  {0.98061992625528493, 0.25943267768681416, 0.0064731773369548834},
                                  {0.99017429471687035, 0.89473007870309396, 0.0026626863818321814},
                                  {0.79062274885069916, 0.34944859243076687, 0.024485952966951278}};

/* Rules by the points a side of Gauss's of their degree, where they have fewer. */
#define RULE(points, orbits)                                                                                           \
    { points, sizeof(orbits) / sizeof(orbit), orbits }
static const struct {
    int n, n_orbits;
    const orbit *orbits;
} listed[CO_SQUARE_RULE_GAUSS + 1] = {
    [3] = RULE(8, degree_5),   [4] = RULE(12, degree_7),  [5] = RULE(20, degree_9), [6] = RULE(28, degree_11),
    [7] = RULE(37, degree_13), [8] = RULE(48, degree_15), [9] = RULE(60, degree_17)};

int co_square_rule_size(int gauss) {
    return listed[gauss].n ? listed[gauss].n : gauss * gauss;
}

static void add_point(co_square_rule *rule, double x, double y, double weight) {
    rule->point[rule->n][0] = (1 + x) / 2;
    rule->point[rule->n][1] = (1 + y) / 2;
    rule->weight[rule->n++] = weight;
}

/* A place and those that it goes to where coordinates change their sign. */
static void add_signs(co_square_rule *rule, double x, double y, double weight) {
    for (int i = 0; i < (x != 0 ? 2 : 1); i++)
        for (int j = 0; j < (y != 0 ? 2 : 1); j++)
            add_point(rule, i ? -x : x, j ? -y : y, weight);
}

static void make_product(int gauss, co_square_rule *rule) {
    double node[CO_SQUARE_RULE_GAUSS], weight[CO_SQUARE_RULE_GAUSS];
    co_gauss_legendre(gauss, node, weight);
    for (int j = 0; j < gauss; j++)
        for (int i = 0; i < gauss; i++)
            add_point(rule, 2 * node[i] - 1, 2 * node[j] - 1, weight[i] * weight[j]);
}

void co_square_rule_make(int gauss, co_square_rule *rule) {
    rule->n = 0;
    if (!listed[gauss].n)
        make_product(gauss, rule);
    for (int k = 0; k < listed[gauss].n_orbits; k++) {
        const orbit *o = &listed[gauss].orbits[k];
        add_signs(rule, o->x, o->y, o->weight);
        if (o->x != o->y)
            add_signs(rule, o->y, o->x, o->weight);
    }
}
