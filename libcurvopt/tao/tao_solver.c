/* What TAO's solvers are told of the objective. SPDX-License-Identifier: GPL-3.0-or-later */
#include "tao_solver.h"

#include <string.h>

enum { LARGEST_FACTORED = 30000 };

static PetscErrorCode value_and_gradient(Tao tao, Vec x, PetscReal *value, Vec gradient, void *context) {
    PetscFunctionBeginUser;
    (void)tao;
    PetscCall(objective_evaluate(context, x, value, gradient));
    PetscFunctionReturn(0);
}

static PetscErrorCode value_alone(Tao tao, Vec x, PetscReal *value, void *context) {
    PetscFunctionBeginUser;
    (void)tao;
    PetscCall(objective_evaluate(context, x, value, NULL));
    PetscFunctionReturn(0);
}

static PetscErrorCode assemble(Tao tao, Vec x, Mat full, Mat preconditioner, void *context) {
    PetscFunctionBeginUser;
    (void)tao;
    PetscCall(objective_hessian(context, x, &full, &preconditioner));
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

PetscErrorCode tao_solver_set_preconditioner(const char *prefix, PetscInt whole) {
    static const char *const small[][2] = {{"pc_type", "redundant"},
                                           {"redundant_pc_type", "cholesky"},
                                           {"redundant_pc_factor_mat_ordering_type", "nd"},
                                           {"redundant_pc_factor_shift_type", "positive_definite"}};
    static const char *const large[][2] = {{"pc_type", "bjacobi"},
                                           {"sub_pc_type", "icc"},
                                           {"sub_pc_factor_mat_ordering_type", "nd"},
                                           {"sub_pc_factor_shift_type", "positive_definite"}};
    const char *const(*option)[2] = whole <= LARGEST_FACTORED ? small : large;
    PetscFunctionBeginUser;
    for (size_t k = 0; k < sizeof small / sizeof *small; k++)
        PetscCall(set_default(prefix, option[k][0], option[k][1]));
    PetscFunctionReturn(0);
}

/* Truncated conjugate gradients. */
static PetscErrorCode set_linear_defaults(const char *prefix, const char *type, PetscInt whole) {
    char own[64];
    PetscFunctionBeginUser;
    PetscCall(PetscSNPrintf(own, sizeof own, "%stao_%s_", prefix, type));
    PetscCall(set_default(own, "ksp_max_it", "300"));
    PetscCall(set_default(own, "ksp_rtol", "1e-3"));
    PetscCall(tao_solver_set_preconditioner(own, whole));
    PetscFunctionReturn(0);
}

static int is_newton(const char *type) {
    static const char *const types[] = {"nls", "ntr", "ntl", "bnls", "bntr", "bntl"};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (!strcmp(type, types[i]))
            return 1;
    return 0;
}

PetscErrorCode tao_solver_create(objective *o, const char *prefix, const char *type, Vec x, Tao *out) {
    char option[64], used[64];
    Mat full = NULL, preconditioner = NULL;
    PetscFunctionBeginUser;
    PetscCall(PetscStrncpy(used, type, sizeof used));
    PetscCall(PetscSNPrintf(option, sizeof option, "-%stao_type", prefix));
    PetscCall(PetscOptionsGetString(NULL, NULL, option, used, sizeof used, NULL));
    PetscCall(TaoCreate(o->on->comm, out));
    PetscCall(TaoSetOptionsPrefix(*out, prefix));
    PetscCall(TaoSetType(*out, type));
    PetscCall(set_default(prefix, "tao_ls_type", "armijo")); /* knows what to do about values that are infinite */
    PetscCall(TaoSetObjective(*out, value_alone, o));
    PetscCall(TaoSetObjectiveAndGradient(*out, NULL, value_and_gradient, o));
    if (is_newton(used)) {
        PetscCall(set_linear_defaults(prefix, used, 3 * o->on->whole_vertices));
        PetscCall(objective_hessian(o, x, &full, &preconditioner));
        PetscCall(TaoSetHessian(*out, full, preconditioner, assemble, o));
        PetscCall(MatDestroy(&preconditioner));
        PetscCall(MatDestroy(&full));
    }
    PetscFunctionReturn(0);
}
