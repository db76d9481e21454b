/* Whether a cage is a minimum. SPDX-License-Identifier: GPL-3.0-or-later */
#include "certificate.h"

#include "base/constants.h"
#include "base/tuning.h"
#include "collective.h"
#include "tao_solver.h"

#include <stdio.h>
#include <stdlib.h>

enum { NEWTON_ITERATIONS = 20, LINEAR_ITERATIONS = 1000, N_SIMILARITIES = 7 };
static const double NEWTON_TOLERANCE = 1e-9; /* gradient, of the objective */
static const double LINEAR_TOLERANCE = 1e-4; /* in the preconditioner's norm: the decrement's error is its square */

typedef struct differences {
    objective *objective;
    Mat full, preconditioner; /* assembled */
    Mat matrix;               /* by differences at `base` */
    Vec base, inside, at, ahead, behind;
    double shift;
    int gauss_newton; /* it is the Gauss-Newton matrix instead, which has its shift */
    Vec *motion;      /* [n_motions] similarities, as far as they are allowed, orthonormal; */
    int n_motions;
    double stiffness; /* of these, which nothing else acts on: as stiff as the matrix is in the mean */
} differences;

/* --------------------------------------------------------------------------------------------- the Hessian -- */

static PetscErrorCode allow(const objective *o, Vec motion) {
    PetscScalar *own;
    PetscFunctionBeginUser;
    PetscCall(VecGetArray(motion, &own));
    objective_project(o, own);
    PetscCall(VecRestoreArray(motion, &own));
    PetscFunctionReturn(0);
}

/* out = Hessian in, by differences, with the shift. Central ones: PETSc's, to one side, are wrong by the third
 * derivative along the step, which on a curved valley floor is more than the floor's own curvature. The longest
 * displacement is CO_DIFFERENCE_STEP of the longest step that is allowed. */
static PetscErrorCode apply_differences(differences *d, Vec in, Vec out) {
    PetscReal longest;
    double value;
    PetscFunctionBeginUser;
    PetscCall(VecNorm(in, NORM_INFINITY, &longest));
    double step = longest > 0 ? CO_DIFFERENCE_STEP * d->objective->longest / longest : 1;
    PetscCall(VecWAXPY(d->at, step, in, d->base));
    PetscCall(objective_evaluate(d->objective, d->at, &value, d->ahead));
    PetscCall(VecWAXPY(d->at, -step, in, d->base));
    PetscCall(objective_evaluate(d->objective, d->at, &value, d->behind));
    PetscCall(VecCopy(in, out));
    PetscCall(allow(d->objective, out));
    PetscCall(VecAXPBYPCZ(out, 1 / (2 * step), -1 / (2 * step), d->shift, d->ahead, d->behind));
    PetscFunctionReturn(0);
}

/* Takes similarities out of v. Of the gradient nothing is along them; along normals what they keep there slides only.
 */
static PetscErrorCode leave_out_similarities(const differences *d, Vec v) {
    PetscScalar along;
    PetscFunctionBeginUser;
    for (int k = 0; k < d->n_motions; k++) {
        PetscCall(VecDot(v, d->motion[k], &along));
        PetscCall(VecAXPY(v, -along, d->motion[k]));
    }
    PetscFunctionReturn(0);
}

/* Of the matrix that was chosen. */
static PetscErrorCode apply(Mat matrix, Vec in, Vec out) {
    differences *d;
    PetscScalar along;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(matrix, &d));
    PetscCall(VecCopy(in, d->inside));
    PetscCall(leave_out_similarities(d, d->inside));
    if (d->gauss_newton) {
        PetscCall(allow(d->objective, d->inside));
        PetscCall(MatMult(d->preconditioner, d->inside, out));
        PetscCall(allow(d->objective, out));
    } else {
        PetscCall(apply_differences(d, d->inside, out));
    }
    PetscCall(leave_out_similarities(d, out));
    for (int k = 0; k < d->n_motions; k++) {
        PetscCall(VecDot(in, d->motion[k], &along));
        PetscCall(VecAXPY(out, d->stiffness * along, d->motion[k]));
    }
    PetscFunctionReturn(0);
}

static PetscErrorCode set_base(Tao tao, Vec x, Mat matrix, Mat preconditioner, void *context) {
    differences *d = context;
    PetscFunctionBeginUser;
    (void)tao;
    (void)matrix;
    (void)preconditioner;
    PetscCall(objective_hessian(d->objective, x, &d->full, &d->preconditioner));
    PetscCall(VecCopy(x, d->base));
    PetscFunctionReturn(0);
}

static PetscErrorCode differences_create(objective *o, Vec x, differences *d) {
    PetscInt n;
    PetscFunctionBeginUser;
    *d = (differences){.objective = o};
    PetscCall(VecGetLocalSize(x, &n));
    PetscCall(VecDuplicate(x, &d->base));
    PetscCall(VecDuplicate(x, &d->inside));
    PetscCall(VecDuplicate(x, &d->at));
    PetscCall(VecDuplicate(x, &d->ahead));
    PetscCall(VecDuplicate(x, &d->behind));
    PetscCall(MatCreateShell(o->on->comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, d, &d->matrix));
    PetscCall(MatShellSetOperation(d->matrix, MATOP_MULT, (void (*)(void))apply));
    PetscCall(MatSetOption(d->matrix, MAT_SYMMETRIC, PETSC_TRUE));
    PetscCall(set_base(NULL, x, NULL, NULL, d));
    PetscFunctionReturn(0);
}

static PetscErrorCode differences_free(differences *d) {
    PetscFunctionBeginUser;
    PetscCall(MatDestroy(&d->matrix));
    PetscCall(MatDestroy(&d->full));
    PetscCall(MatDestroy(&d->preconditioner));
    PetscCall(VecDestroy(&d->base));
    PetscCall(VecDestroy(&d->inside));
    PetscCall(VecDestroy(&d->at));
    PetscCall(VecDestroy(&d->ahead));
    PetscCall(VecDestroy(&d->behind));
    PetscFunctionReturn(0);
}

/* --------------------------------------------------------------------------------------------- similarities -- */

/* Motion k at x: scaling, translations, rotations. */
static void similarity(int k, const double *x, double *out) {
    int axis = (k + 2) % 3, next = (axis + 1) % 3, last = (axis + 2) % 3;
    for (int i = 0; i < 3; i++)
        out[i] = k == 0 ? x[i] : 0;
    if (k > 3) {
        out[next] = -x[last];
        out[last] = x[next];
    } else if (k > 0) {
        out[axis] = 1;
    }
}

/* d->motion; at d->base. */
static PetscErrorCode span_similarities(differences *d) {
    const objective *o = d->objective;
    double centroid[3], radius, *own = COLLECTIVE_NEW(o->on->comm, double, 3 * (size_t)o->on->n_own);
    const PetscScalar *at;
    PetscScalar *out, dot;
    PetscReal whole, kept, norm;
    PetscFunctionBeginUser;
    PetscCall(VecDuplicateVecs(d->base, N_SIMILARITIES, &d->motion));
    PetscCall(VecGetArrayRead(d->base, &at));
    objective_positions(o, at, own);
    PetscCall(VecRestoreArrayRead(d->base, &at));
    PetscCall(objective_frame(o->on, own, centroid, &radius));
    for (PetscInt i = 0; i < 3 * o->on->n_own; i++)
        own[i] -= centroid[i % 3];
    for (int k = 0; k < N_SIMILARITIES; k++) {
        Vec v = d->motion[d->n_motions];
        PetscCall(VecGetArrayWrite(v, &out));
        for (PetscInt i = 0; i < o->on->n_own; i++)
            similarity(k, own + 3 * (size_t)i, out + 3 * (size_t)i);
        PetscCall(VecRestoreArrayWrite(v, &out));
        PetscCall(VecNorm(v, NORM_2, &whole));
        PetscCall(allow(o, v));
        PetscCall(VecNorm(v, NORM_2, &kept));
        for (int j = 0; j < 2 * d->n_motions; j++) { /* twice, against rounding */
            PetscCall(VecDot(v, d->motion[j % d->n_motions], &dot));
            PetscCall(VecAXPY(v, -dot, d->motion[j % d->n_motions]));
        }
        PetscCall(VecNormalize(v, &norm));
        d->n_motions += kept > CO_ALLOWED_MOTION * whole && norm > CO_INDEPENDENT_MOTION * kept;
    }
    free(own);
    PetscFunctionReturn(0);
}

/* The shift, and similarities that are left out, as the library has them; without them it is the Hessian as it is, for
 * Newton. Nothing is left out where vertices are fixed: there the objective sees every motion. */
static PetscErrorCode regularize(differences *d, double value) {
    Vec diagonal;
    PetscFunctionBeginUser;
    d->shift = objective_shift(d->objective, value);
    PetscCall(VecDuplicate(d->base, &diagonal));
    PetscCall(MatGetDiagonal(d->preconditioner, diagonal));
    PetscCall(VecSum(diagonal, &d->stiffness));
    d->stiffness /= 3 * (double)d->objective->on->whole_vertices;
    PetscCall(VecDestroy(&diagonal));
    if (!d->objective->framed)
        PetscCall(span_similarities(d));
    PetscFunctionReturn(0);
}

static PetscErrorCode undo_regularize(differences *d) {
    PetscFunctionBeginUser;
    d->shift = 0;
    d->gauss_newton = d->n_motions = 0;
    if (d->motion)
        PetscCall(VecDestroyVecs(N_SIMILARITIES, &d->motion));
    PetscFunctionReturn(0);
}

/* Of a matrix, what acts on allowed motion; the identity, as stiff as the matrix, on the rest. */
static PetscErrorCode restrict_to_allowed(const differences *d, Mat *matrix) {
    const objective *o = d->objective;
    PetscInt n = 3 * o->on->n_own;
    Mat allowed, restricted;
    PetscFunctionBeginUser;
    if (!o->project)
        PetscFunctionReturn(0);
    PetscCall(MatCreateAIJ(o->on->comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, 3, NULL, 0, NULL, &allowed));
    for (PetscInt v = 0; v < o->on->n_own; v++) {
        PetscInt first = 3 * (o->on->first_own + v), at[3] = {first, first + 1, first + 2};
        PetscCall(MatSetValues(allowed, 3, at, 3, at, o->project + 9 * (size_t)v, INSERT_VALUES));
    }
    PetscCall(MatAssemblyBegin(allowed, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(allowed, MAT_FINAL_ASSEMBLY));
    PetscCall(MatPtAP(*matrix, allowed, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &restricted));
    PetscCall(MatScale(allowed, -d->stiffness));
    PetscCall(MatShift(allowed, d->stiffness));
    PetscCall(MatAXPY(restricted, 1, allowed, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatDestroy(&allowed));
    PetscCall(MatDestroy(matrix));
    *matrix = restricted;
    PetscFunctionReturn(0);
}

/* ------------------------------------------------------------------------------------------------ decrement -- */

/* matrix . out = in by conjugate gradients, preconditioned by what is `like` it; *positive: none of their directions
 * was a negative one. */
static PetscErrorCode solve(const differences *d, const char *prefix, Mat like, Vec in, Vec out, int *positive) {
    KSP ksp;
    KSPConvergedReason reason;
    char own[64];
    PetscFunctionBeginUser;
    PetscCall(PetscSNPrintf(own, sizeof own, "%sdecrement_", prefix));
    PetscCall(tao_solver_set_preconditioner(own, 3 * d->objective->on->whole_vertices));
    PetscCall(KSPCreate(d->objective->on->comm, &ksp));
    PetscCall(KSPSetOptionsPrefix(ksp, own));
    PetscCall(KSPSetType(ksp, KSPSTCG)); /* says so when a direction is negative; without a radius it is plain CG */
    PetscCall(KSPSetOperators(ksp, d->matrix, like));
    PetscCall(KSPSetTolerances(ksp, LINEAR_TOLERANCE, 0, PETSC_DEFAULT, LINEAR_ITERATIONS));
    PetscCall(KSPSetFromOptions(ksp));
    PetscCall(KSPSolve(ksp, in, out));
    PetscCall(KSPGetConvergedReason(ksp, &reason));
    *positive = reason != KSP_CONVERGED_CG_NEG_CURVE && reason != KSP_DIVERGED_INDEFINITE_MAT;
    PetscCall(KSPDestroy(&ksp));
    PetscFunctionReturn(0);
}

/* Whether the Hessian has negative directions is asked of a right-hand side that has something of every direction: the
 * gradient of a symmetric cage has nothing of those that break the symmetry. */
static PetscErrorCode find_decrement(differences *d, const char *prefix, certificate *out) {
    Vec gradient, anything, solution;
    Mat like;
    PetscRandom random;
    PetscScalar product;
    double value;
    int ignored;
    PetscFunctionBeginUser;
    PetscCall(VecDuplicate(d->base, &gradient));
    PetscCall(VecDuplicate(d->base, &anything));
    PetscCall(VecDuplicate(d->base, &solution));
    PetscCall(PetscRandomCreate(d->objective->on->comm, &random));
    PetscCall(PetscRandomSetInterval(random, -1, 1));
    PetscCall(VecSetRandom(anything, random));
    PetscCall(PetscRandomDestroy(&random));
    PetscCall(allow(d->objective, anything));
    PetscCall(objective_evaluate(d->objective, d->base, &value, gradient));
    PetscCall(regularize(d, value));
    PetscCall(leave_out_similarities(d, gradient));
    PetscCall(objective_sparse(d->full, d->shift, &like));
    PetscCall(restrict_to_allowed(d, &like));
    PetscCall(solve(d, prefix, like, anything, solution, &out->positive));
    if (!out->positive) {
        d->gauss_newton = 1;
        PetscCall(MatDestroy(&like));
        PetscCall(MatDuplicate(d->preconditioner, MAT_COPY_VALUES, &like));
        PetscCall(restrict_to_allowed(d, &like));
    }
    PetscCall(solve(d, prefix, like, gradient, solution, &ignored));
    PetscCall(undo_regularize(d));
    PetscCall(MatDestroy(&like));
    PetscCall(VecDot(gradient, solution, &product));
    out->decrement = product / 2;
    PetscCall(VecDestroy(&gradient));
    PetscCall(VecDestroy(&anything));
    PetscCall(VecDestroy(&solution));
    PetscFunctionReturn(0);
}

/* -------------------------------------------------------------------------------------------------- Newton -- */

static PetscErrorCode find_gain(differences *d, const char *prefix, Vec x, double *gain) {
    Tao tao;
    Vec at;
    double before, after;
    PetscFunctionBeginUser;
    PetscCall(VecDuplicate(x, &at));
    PetscCall(VecCopy(x, at));
    PetscCall(objective_evaluate(d->objective, x, &before, NULL));
    PetscCall(tao_solver_create(d->objective, prefix, TAONLS, x, &tao));
    PetscCall(TaoSetHessian(tao, d->matrix, d->preconditioner, set_base, d));
    PetscCall(TaoSetSolution(tao, at));
    PetscCall(TaoSetTolerances(tao, 0, NEWTON_TOLERANCE, 0));
    PetscCall(TaoSetMaximumIterations(tao, NEWTON_ITERATIONS));
    PetscCall(TaoSetFromOptions(tao));
    PetscCall(TaoSolve(tao));
    PetscCall(objective_evaluate(d->objective, at, &after, NULL));
    *gain = before - after;
    PetscCall(TaoDestroy(&tao));
    PetscCall(VecDestroy(&at));
    PetscFunctionReturn(0);
}

PetscErrorCode certificate_find(objective *o, const char *prefix, Vec x, certificate *out) {
    differences d;
    PetscFunctionBeginUser;
    PetscCall(differences_create(o, x, &d));
    PetscCall(find_decrement(&d, prefix, out));
    PetscCall(find_gain(&d, prefix, x, &out->gain));
    PetscCall(differences_free(&d));
    PetscFunctionReturn(0);
}
