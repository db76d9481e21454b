/* What TAO's solvers are told of the objective, and the report's verification. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#include "newton.h"

#include <string.h>

enum { VERIFY_ITERATIONS = 20, LARGEST_FACTORED = 30000 };
/* Of the differences' step, against PETSc's 1.5e-8: gradients are exact to some 1e-14 of the stiffest motion, and it is
 * the softest that matters. */
static const double DIFFERENCE_ERROR = 1e-6;
static const double VERIFY_TOLERANCE = 1e-9; /* gradient, of the energy */

static PetscErrorCode value_and_gradient(Tao tao, Vec x, PetscReal *value, Vec gradient, void *context) {
    PetscFunctionBeginUser;
    (void)tao;
    PetscCall(energy_evaluate(context, x, value, gradient));
    PetscFunctionReturn(0);
}

static PetscErrorCode value_alone(Tao tao, Vec x, PetscReal *value, void *context) {
    PetscFunctionBeginUser;
    (void)tao;
    PetscCall(energy_evaluate(context, x, value, NULL));
    PetscFunctionReturn(0);
}

static PetscErrorCode assemble(Tao tao, Vec x, Mat full, Mat guide, void *context) {
    PetscFunctionBeginUser;
    (void)tao;
    PetscCall(energy_hessian(context, x, &full, &guide));
    PetscCall(MatAssemblyBegin(full, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(full, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(0);
}

/* A default that the user's options override. */
static PetscErrorCode set_default(const char *prefix, const char *name, const char *value) {
    char whole[128];
    PetscBool is_set;
    PetscFunctionBeginUser;
    PetscCall(PetscSNPrintf(whole, sizeof whole, "-%s%s", prefix, name));
    PetscCall(PetscOptionsHasName(NULL, NULL, whole, &is_set));
    if (!is_set)
        PetscCall(PetscOptionsSetValue(NULL, whole, value));
    PetscFunctionReturn(0);
}

/* Truncated conjugate gradients, preconditioned by each rank's block of the Gauss-Newton matrix: its Cholesky factor,
 * incomplete where a complete one would be large. */
static PetscErrorCode set_linear_defaults(const char *prefix, const char *type, PetscInt whole) {
    char name[64];
    const char *const option[][2] = {{"ksp_max_it", "300"},
                                     {"ksp_rtol", "1e-3"},
                                     {"pc_type", "bjacobi"},
                                     {"sub_pc_type", whole <= LARGEST_FACTORED ? "cholesky" : "icc"},
                                     {"sub_pc_factor_mat_ordering_type", "nd"},
                                     {"sub_pc_factor_shift_type", "positive_definite"}};
    PetscFunctionBeginUser;
    for (size_t k = 0; k < sizeof option / sizeof *option; k++) {
        PetscCall(PetscSNPrintf(name, sizeof name, "tao_%s_%s", type, option[k][0]));
        PetscCall(set_default(prefix, name, option[k][1]));
    }
    PetscFunctionReturn(0);
}

static int is_newton(const char *type) {
    static const char *const types[] = {"nls", "ntr", "ntl", "bnls", "bntr", "bntl"};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (!strcmp(type, types[i]))
            return 1;
    return 0;
}

PetscErrorCode newton_create_solver(energy *e, const char *prefix, const char *type, Vec x, Tao *out) {
    char option[64], used[64];
    Mat full = NULL, guide = NULL;
    PetscFunctionBeginUser;
    PetscCall(PetscStrncpy(used, type, sizeof used));
    PetscCall(PetscSNPrintf(option, sizeof option, "-%stao_type", prefix));
    PetscCall(PetscOptionsGetString(NULL, NULL, option, used, sizeof used, NULL));
    PetscCall(TaoCreate(e->on->comm, out));
    PetscCall(TaoSetOptionsPrefix(*out, prefix));
    PetscCall(TaoSetType(*out, type));
    PetscCall(set_default(prefix, "tao_ls_type", "armijo")); /* knows what to do about values that are infinite */
    PetscCall(TaoSetObjective(*out, value_alone, e));
    PetscCall(TaoSetObjectiveAndGradient(*out, NULL, value_and_gradient, e));
    if (is_newton(used)) {
        PetscCall(set_linear_defaults(prefix, used, 3 * e->on->whole_vertices));
        PetscCall(energy_hessian(e, x, &full, &guide));
        PetscCall(TaoSetHessian(*out, full, guide, assemble, e));
        PetscCall(MatDestroy(&guide));
        PetscCall(MatDestroy(&full));
    }
    PetscFunctionReturn(0);
}

/* ---------------------------------------------------------------------------------------------- verification -- */

/* A Hessian by differences, with the Gauss-Newton matrix to precondition it. */
typedef struct differences {
    energy *e;
    Mat full, guide;
    Vec gradient;
} differences;

static PetscErrorCode gradient_at(void *context, Vec x, Vec gradient) {
    double value;
    PetscFunctionBeginUser;
    PetscCall(energy_evaluate(((differences *)context)->e, x, &value, gradient));
    PetscFunctionReturn(0);
}

static PetscErrorCode set_base(Tao tao, Vec x, Mat by_differences, Mat guide, void *context) {
    differences *d = context;
    PetscFunctionBeginUser;
    (void)tao;
    (void)guide;
    PetscCall(energy_hessian(d->e, x, &d->full, &d->guide));
    PetscCall(gradient_at(d, x, d->gradient));
    PetscCall(MatMFFDSetBase(by_differences, x, d->gradient));
    PetscCall(MatAssemblyBegin(by_differences, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(by_differences, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(0);
}

static PetscErrorCode create_differences(differences *d, const char *prefix, Vec x, Mat *by_differences) {
    PetscInt n, whole;
    PetscFunctionBeginUser;
    PetscCall(VecGetLocalSize(x, &n));
    PetscCall(VecGetSize(x, &whole));
    PetscCall(VecDuplicate(x, &d->gradient));
    PetscCall(energy_hessian(d->e, x, &d->full, &d->guide));
    PetscCall(MatCreateMFFD(d->e->on->comm, n, n, whole, whole, by_differences));
    PetscCall(MatSetOptionsPrefix(*by_differences, prefix));
    PetscCall(MatMFFDSetFunction(*by_differences, gradient_at, d));
    PetscCall(MatMFFDSetFunctionError(*by_differences, DIFFERENCE_ERROR));
    PetscCall(MatSetFromOptions(*by_differences));
    PetscCall(MatSetOption(*by_differences, MAT_SYMMETRIC, PETSC_TRUE));
    PetscFunctionReturn(0);
}

PetscErrorCode newton_verify(energy *e, const char *prefix, Vec x, double *decrease, int *negative) {
    differences d = {.e = e};
    Mat by_differences;
    Tao tao;
    Vec at;
    KSP ksp;
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    double before, after;
    PetscFunctionBeginUser;
    PetscCall(VecDuplicate(x, &at));
    PetscCall(VecCopy(x, at));
    PetscCall(energy_evaluate(e, x, &before, NULL));
    PetscCall(create_differences(&d, prefix, x, &by_differences));
    PetscCall(newton_create_solver(e, prefix, TAONLS, x, &tao));
    PetscCall(TaoSetHessian(tao, by_differences, d.guide, set_base, &d));
    PetscCall(TaoSetSolution(tao, at));
    PetscCall(TaoSetTolerances(tao, 0, VERIFY_TOLERANCE, 0));
    PetscCall(TaoSetMaximumIterations(tao, VERIFY_ITERATIONS));
    PetscCall(TaoSetFromOptions(tao));
    PetscCall(TaoSolve(tao));
    PetscCall(energy_evaluate(e, at, &after, NULL));
    PetscCall(TaoGetKSP(tao, &ksp));
    if (ksp)
        PetscCall(KSPGetConvergedReason(ksp, &reason));
    *decrease = before - after;
    *negative = reason == KSP_CONVERGED_CG_NEG_CURVE || reason == KSP_DIVERGED_INDEFINITE_MAT;
    PetscCall(TaoDestroy(&tao));
    PetscCall(MatDestroy(&by_differences));
    PetscCall(MatDestroy(&d.guide));
    PetscCall(MatDestroy(&d.full));
    PetscCall(VecDestroy(&d.gradient));
    PetscCall(VecDestroy(&at));
    PetscFunctionReturn(0);
}
