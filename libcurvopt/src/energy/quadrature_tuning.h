/* Constants of adaptive quadrature: name, default, range, unit, reason, and the note in libcurvopt/notes that has the
 * experiment. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_QUADRATURE_TUNING_H
#define CO_ENERGY_QUADRATURE_TUNING_H

/* X(type, name, default, least, largest, unit, why, note) */
#define CO_QUADRATURE_TUNING_LIST(X)                                                                                   \
    X(double, quadrature_acceptable, 1e-2, 1e-6, 1, "relative error",                                                  \
      "resolved, though the finest rules miss the tolerance: far from what an optimizer could gain in the gap", "21")  \
    X(double, quadrature_hysteresis, 3, 1, 100, "of the tolerance",                                                    \
      "rules that met it once are kept up to this error, so that energies are continuous but for rare steps", "21")    \
    X(double, quadrature_unmarked, 0.5, 0.01, 1, "of the tolerance",                                                   \
      "most error of all patches that keep their rules; the rest is for the refined ones", "21")                       \
    X(double, quadrature_tie, 1e-6, 0, 0.1, "relative difference",                                                     \
      "errors per cost of symmetric patches differ by less, by rounding: they are marked alike", "21")                 \
    X(double, quadrature_coarsened, 0.5, 0.01, 1, "of the tolerance",                                                  \
      "most error of coarser rules: with more they would have to be refined again at once", "22")                      \
    X(double, quadrature_saving, 0.8, 0.01, 1, "of the cost",                                                          \
      "coarser rules that cost more are not taken: values change, and optimizers drop what they learnt", "22")         \
    X(double, quadrature_two_rules, 0.2, 0, 1, "of the error",                                                         \
      "most error of the patches for which two rules are compared, and not three", "23")                               \
    X(double, quadrature_negligible, 1e-2, 0, 1, "of the tolerance",                                                   \
      "an error that is not worth a third rule, which takes as long as half an evaluation", "23")                      \
    X(double, quadrature_reference, 0.2, 0, 1, "of the last change",                                                   \
      "error of the finest rule compared; with a twentieth some claims are a tenth of the true error", "23")           \
    X(double, quadrature_area, 1e-9, 0, 1e-3, "of the radius squared", "a smaller area is none", "24")                 \
    X(double, quadrature_defect, 1, 1e-3, 100, "radians",                                                              \
      "a larger Gauss-Bonnet defect, less quadrature_acceptable of W, means that curvature was missed", "24")

typedef struct co_quadrature_tuning {
#define CO_QUADRATURE_TUNING_MEMBER(type, name, ...) type name;
    CO_QUADRATURE_TUNING_LIST(CO_QUADRATURE_TUNING_MEMBER)
#undef CO_QUADRATURE_TUNING_MEMBER
} co_quadrature_tuning;

extern const co_quadrature_tuning co_quadrature_tuning_default;

#endif
