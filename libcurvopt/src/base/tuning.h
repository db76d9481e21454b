/* Every heuristic number of quadrature, of the optimizers and of the solver, in one table.
 *
 * A number stands here if another value would also give a correct program, slower or faster, to the same or another
 * minimum. Numbers that define the surface, its quadrature rules or a limit of memory stand where they are used. A
 * number is named once, here; code reads it through a `const co_tuning *`, so that a test or an experiment can change
 * one (tests/corpus/sensitivity.py halves and doubles each). `note` is the file of libcurvopt/notes that has the
 * experiment; "textbook" numbers are those of the source that the code cites.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_TUNING_H
#define CO_BASE_TUNING_H

#include "curvopt.h"

#include <stddef.h>

/* X(type, name, default, least, largest, unit, why, note): type is int or double. */
#define CO_TUNING_LIST(X)                                                                                              \
    /* All of optimize/. */                                                                                            \
    X(double, rounding, 1e-15, 1e-17, 1e-12, "of the value", "a difference below is rounding", "50")                   \
    X(int, trials, 30, 5, 1000, "evaluations or factors", "most for one step", "50")                                   \
    /* Length of steps: optimize/step_control.c. */                                                                    \
    X(double, cap_rejected, 0.25, 0.05, 0.9, "factor", "the step cap falls by this when a step is taken back", "50")   \
    X(double, cap_accepted, 2, 1, 16, "factor", "the step cap grows by this after a step, up to max_step", "50")       \
    /* Line search: optimize/line_search.c. */                                                                         \
    X(double, wolfe_curvature, 0.9, 0.1, 0.99, "of the slope", "strong Wolfe condition, textbook", "50")               \
    X(double, search_growth, 4, 1.1, 100, "factor", "the step grows by this while it may be longer", "50")             \
    /* L-BFGS: optimize/lbfgs.c. */                                                                                    \
    X(int, lbfgs_memory, 12, 1, 100, "pairs", "more bring nothing with a preconditioner", "50")                        \
    X(int, lbfgs_update_every, 25, 1, 100, "steps", "between updates of the preconditioner", "46")                     \
    X(int, lbfgs_update_often, 5, 1, 100, "steps", "the same beside repulsion, and where spacing is free", "46")       \
    X(double, lbfgs_short_share, 0.5, 0.01, 1, "of a direction", "a shorter step says that the matrix is too soft",    \
      "51")                                                                                                            \
    X(double, lbfgs_least_part, 0.05, 1e-6, 1, "of a direction", "a search begins with no less; of a matrix likewise", \
      "51")                                                                                                            \
    X(int, lbfgs_small_steps, 4, 1, 100, "steps", "one may be small because the matrix was stiffened", "50")           \
    /* Damped Newton: optimize/damped_newton.c. Gain ratio: actual over predicted decrease. */                         \
    X(double, newton_accept, 0.01, 1e-8, 0.5, "gain ratio", "from here on a step stands", "55")                        \
    X(double, newton_poor, 0.1, 1e-4, 0.5, "gain ratio", "below, the shift rises by newton_change", "55")              \
    X(double, newton_good, 0.5, 0.1, 0.9, "gain ratio", "above, the shift falls by newton_change", "55")               \
    X(double, newton_exact, 0.9, 0.5, 1, "gain ratio", "above, the shift falls by newton_fall", "55")                  \
    X(double, newton_change, 3, 1.1, 100, "factor", "of the shift", "55")                                              \
    X(double, newton_fall, 8, 1.1, 100, "factor", "of the shift", "55")                                                \
    X(double, newton_raise, 4, 1.1, 100, "factor", "of a shift that leaves the matrix indefinite", "55")               \
    X(double, newton_mix, 1.0 / 3, 0.01, 1, "part", "first mixture with the Gauss-Newton matrix; the second is 1",     \
      "57")                                                                                                            \
    X(double, newton_mix_fall, 4, 1.1, 100, "factor", "of the mixture where a longer step is tried", "57")             \
    X(double, newton_stiff, 1.1, 1, 10, "gain ratio", "above, the mixture is too stiff", "57")                         \
    X(double, newton_longer_from, 0.7, 0.1, 1, "gain ratio", "from here on a longer step is tried", "56")              \
    X(double, newton_softer, 1.3, 1.01, 10, "factor", "damping that is softer by less is not worth a trial", "56")     \
    X(int, newton_longer, 2, 0, 20, "trials", "most longer steps by one matrix", "56")                                 \
    X(int, newton_coarser, 1, 0, 7, "steps", "from the rules to coarser ones, by which matrices of steps are", "75")   \
    /* The matrix of a level: solve/level_hessian.c. */                                                                \
    X(double, shift_least, 0.1, 1e-6, 10, "of the energy by vertices",                                                 \
      "curvature that counts as none; defines the certificate, too", "70")                                             \
    X(double, shift_raise, 4, 1.1, 100, "factor", "of a shift that leaves L-BFGS' matrix indefinite", "51")            \
    X(double, stiffen_from, 1.5, 0.5, 100, "step excess", "above, the shift grows by stiffen_factor", "51")            \
    X(double, stiffen_factor, 2, 1, 100, "factor", "of the shift", "51")                                               \
    X(double, soften_below, 0.7, 0.01, 2, "step excess", "below, the shift falls by soften_factor", "51")              \
    X(double, soften_factor, 1.0 / 3, 0.01, 1, "factor", "of the shift", "51")                                         \
    X(int, inverse_iterations, 30, 1, 1000, "solves", "for the direction of most negative curvature", "65")            \
    /* Quadrature: energy/adaptive_quadrature.c. */                                                                    \
    X(double, quadrature_hysteresis, 3, 1, 100, "of the tolerance",                                                    \
      "rules that met it once are kept up to this error, so that energies are continuous but for rare steps", "21")    \
    X(double, quadrature_unmarked, 0.5, 0.01, 1, "of the tolerance",                                                   \
      "most error of all patches that keep their rules; the rest is for the refined ones", "21")                       \
    X(double, quadrature_coarsened, 0.5, 0.01, 1, "of the tolerance",                                                  \
      "most error of coarser rules: with more they would have to be refined again at once", "22")                      \
    X(double, quadrature_saving, 0.8, 0.01, 1, "of the cost",                                                          \
      "coarser rules that cost more are not taken: values change, and optimizers drop what they learnt", "22")         \
    X(double, quadrature_two_rules, 0.05, 0, 1, "of the error",                                                        \
      "most error of the patches for which two rules are compared, and not three", "23")                               \
    X(double, quadrature_negligible, 1e-2, 0, 1, "of the tolerance",                                                   \
      "an error that is not worth a third rule, which takes as long as half an evaluation", "23")                      \
    X(double, quadrature_reference, 0.8, 0, 1, "of the last change",                                                   \
      "error of the finest rule compared, of second order: 1 / (1.5^2 - 1)", "23")                                     \
    X(double, quadrature_jump, 0.3, 0, 1, "of the jump of X",                                                          \
      "what a rule misses at an umbilic: less in seven of ten places where that can lie", "23")                        \
    X(double, quadrature_agreement, 10, 1, 1000, "largest changes",                                                    \
      "most for what a rule misses at umbilics: values that hardly change have none", "23")                            \
    /* Review of a step: solve/step_review.c. */                                                                       \
    X(int, review_every, 5, 1, 1000, "steps", "with one: quadrature is checked", "25")                                 \
    X(double, review_step, 0.05, 1e-4, 10, "mean edges", "a longer step is always checked", "25")                      \
    X(double, review_fold, 2, 1.01, 1e6, "factor", "of a reviewed value: finer rules that see more see a fold", "25")  \
    X(double, finer_factor, 0.1, 1e-3, 0.9, "of the tolerance", "a level that is lost begins again by that", "25")     \
    X(double, finer_gradient, 100, 2, 1e6, "factor", "of its gradient by which the last level is lost", "25")          \
    X(int, finer_tries, 2, 0, 10, "times", "most for a level", "25")                                                   \
    X(double, defect_growth, 4, 1, 1000, "factor", "of the Gauss-Bonnet defect: a check out of turn", "25")            \
    X(double, working_factor, 10, 1, 1000, "of the tolerance", "quadrature on the way", "25")                          \
    X(double, working_forming, 100, 1, 1e4, "of the tolerance",                                                        \
      "the same while the shape forms, of third order or by rough rules", "25")                                        \
    X(int, rough_from, 256, 0, 1000000, "faces at extraordinary vertices", "with as many rules may be rough", "25")    \
    /* Schedule of a level: solve/level_schedule.c. */                                                                 \
    X(double, coarse_decrement, 1e-5, 1e-10, 1e-1, "of the energy", "the shape is formed", "59")                       \
    X(double, coarse_settled, 1e-3, 1e-8, 1, "of the energy", "settled: less in quick_steps, or slow_steps", "59")     \
    X(double, last_decrement, 1e-6, 1e-10, 1e-1, "of the energy", "the last level has settled", "59")                  \
    X(double, final_settled, 10, 0.01, 1e4, "decrement tolerances", "settled: less in slow_steps, at the last level",  \
      "59")                                                                                                            \
    X(int, slow_steps, 15, 1, 1000, "steps", "over which settling is judged", "59")                                    \
    X(int, quick_steps, 5, 1, 1000, "steps", "the same before the last level", "53")                                   \
    X(double, stationary, 4, 0.01, 1e4, "decrement tolerances",                                                        \
      "a level ends; by default .8 of certificate_stationary, to be met by more than rounding", "53")                  \
    X(double, spacing, 1e-2, 0, 10, "of the energy", "what an even cage is worth while the shape forms", "53")         \
    X(double, spacing_fall, 0.3, 0.01, 1, "factor", "of that from level to level, which inherit even cages", "53")     \
    X(double, spacing_third, 1e-3, 0, 10, "of the energy", "the same for third order", "53")                           \
    X(double, spacing_forming, 1e-1, 0, 10, "of the energy", "the same while the first level's shape forms", "53")     \
    X(double, spacing_slide, 1e-2, 0, 10, "of the energy", "what it is worth while vertices slide along curves", "85") \
    X(double, repulsion, 1, 1e-4, 100, "of the energy", "of a surface that is close to itself all over", "113")        \
    X(double, repulsion_reach, 0.2, 0.01, 1, "mean edges", "distance at which parts of a surface repel each other",    \
      "113")                                                                                                           \
    /* A start that stands: solve/standing_start.c. */                                                                 \
    X(double, standing_step, 0.05, 0, 1, "mean edges", "a shorter step along normals: it is a minimum already", "68")  \
    X(double, standing_gain, 0.1, 0, 1, "of the energy", "what a first step over everything brings at most", "68")     \
    X(double, standing_touches, 100, 0, 1e6, "touches", "or so many times what a touch raises, if that is no more",    \
      "68")                                                                                                            \
    X(double, delicate_rise, 2e-3, 0, 1, "of the energy", "a minimum that a touch raises by more may end elsewhere",   \
      "68")                                                                                                            \
    /* A solver that stays: solve/live.c, solve/level_response.c. */                                                   \
    X(double, near_passing, 1e-5, 1e-12, 1e-1, "of the energy", "decrement at which a passing state is shown", "66")   \
    X(double, near_settled, 1e-9, 1e-15, 1e-2, "of the energy", "decrement at which the spacing has settled", "66")    \
    X(double, near_finished, 0.1, 1e-6, 1, "decrement tolerances", "decrement at which the end is looked at", "66")    \
    X(int, near_steps, 20, 1, 1000, "steps", "a matrix that takes more is made anew", "66")                            \
    X(double, near_straight, 0.03, 0, 100, "mean edges", "longest move that one Newton step follows", "66")            \
    X(double, near_reach, 0.5, 0.01, 100, "mean edges", "longest move of targets that is followed at once", "66")      \
    X(int, near_parts, 32, 1, 1000, "parts", "most in which a longer one is followed", "66")                           \
    /* Ways down from saddles, symmetry: solve/saddle_escape.c, solve/symmetry_reduction.c. */                         \
    X(int, escape_index, 4, 2, 48, "index", "of the subgroups that are tried", "63")                                   \
    X(int, escape_vertices, CURVOPT_MAX_ESCAPE_VERTICES, 1, 1000000, "vertices", "above, --escape is not tried", "65") \
    X(int, loosen_least_vertices, 20, 1, 1000000, "vertices", "below, ways down are those of few lines", "62")         \
    X(int, loosen_most_vertices, 2000, 1, 1000000, "vertices", "above, a run with less symmetry takes too long", "62") \
    X(double, loosen_half, 0.06, 1e-6, 1, "of the energy", "what giving up half of the symmetries must bring", "64")   \
    X(double, loosen_same, 0.01, 1e-6, 1, "of the energy", "what a way down must bring that keeps them all", "64")     \
    X(double, loosen_perhaps, 0.5, 0.01, 1, "of that", "enough for a first of two steps", "64")                        \
    /* Certificate: solve/certificate.c. */                                                                            \
    X(double, certificate_stationary, 1e-6, 1e-12, 1e-2, "of the energy", "most of the Newton decrement", "70")

#define CO_TUNING_MEMBER(type, name, ...) type name;
typedef struct co_tuning {
    CO_TUNING_LIST(CO_TUNING_MEMBER)
} co_tuning;
#undef CO_TUNING_MEMBER

/* A row of the table, for experiments and documents. */
typedef struct co_tuning_entry {
    const char *name, *unit, *why, *note;
    size_t offset; /* in co_tuning */
    double value, least, largest;
    int is_integer;
} co_tuning_entry;

extern const co_tuning co_tuning_defaults;
/* The defaults, as a run takes them: an experiment's program replaces this function. */
const co_tuning *co_tuning_of_runs(void);
/* All rows; *n of them. */
const co_tuning_entry *co_tuning_table(size_t *n);

#endif
