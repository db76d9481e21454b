/* The objective of a distributed cage. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "objective.h"

#include "base/constants.h"
#include "base/tuning.h"
#include "collective.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { CUT_STEPS = 60 };               /* of bisection, in the logarithm of an error */
static const double LEAST_CUT = 1e-24; /* of the objective: where that bisection begins */

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int objective_is_third_order(int term) {
    switch ((curvopt_term)term) { /* no default: compilers name a term that is missing */
    case CURVOPT_TERM_MVS:
    case CURVOPT_TERM_MVS_CROSS:
    case CURVOPT_TERM_VARIATION:
    case CURVOPT_TERM_MEHLUM_TARROU:
        return 1;
    case CURVOPT_TERM_WILLMORE:
    case CURVOPT_TERM_AREA:
    case CURVOPT_TERM_MEAN:
    case CURVOPT_TERM_FORCE_INT: /* none */
        break;
    }
    return 0;
}

int objective_has_third_order(const curvopt_options *options) {
    for (int t = 0; t < CURVOPT_N_TERMS; t++)
        if (options->weights[t] > 0 && objective_is_third_order(t))
            return 1;
    return 0;
}

PetscErrorCode objective_frame(const subdomain *on, const double *own, double centroid[3], double *radius) {
    double sum[3] = {0, 0, 0}, square = 0, weight = 1 / (double)on->whole_vertices;
    PetscFunctionBeginUser;
    for (PetscInt i = 0; i < 3 * on->n_own; i++)
        sum[i % 3] += weight * own[i];
    PetscCallMPI(MPI_Allreduce(sum, centroid, 3, MPI_DOUBLE, MPI_SUM, on->comm));
    for (PetscInt i = 0; i < 3 * on->n_own; i++)
        square += weight * (own[i] - centroid[i % 3]) * (own[i] - centroid[i % 3]);
    PetscCallMPI(MPI_Allreduce(&square, radius, 1, MPI_DOUBLE, MPI_SUM, on->comm));
    *radius = sqrt(*radius);
    PetscFunctionReturn(0);
}

PetscErrorCode objective_create(const subdomain *on, const curvopt_options *options, objective *o, int *refused,
                                char *message) {
    curvopt_error error;
    PetscFunctionBeginUser;
    *o = (objective){.on = on, .options = options, .radius = 1, .least_seconds = (double)INFINITY};
    int32_t status = curvopt_problem_create_part(on->mesh, on->counts, options, &o->problem, &error);
    *refused = collective_status(on->comm, status, &error, message);
    if (*refused) {
        curvopt_problem_destroy(o->problem);
        o->problem = NULL;
        PetscFunctionReturn(0);
    }
    o->third = objective_has_third_order(options);
    o->gradients = COLLECTIVE_NEW(on->comm, double, 9 * (size_t)on->n_vertices);
    o->xyz = COLLECTIVE_NEW(on->comm, double, 3 * (size_t)on->n_vertices);
    o->own = COLLECTIVE_NEW(on->comm, double, 3 * (size_t)on->n_own);
    o->rules = COLLECTIVE_NEW(on->comm, int32_t, on->n_faces);
    o->errors = COLLECTIVE_NEW(on->comm, double, on->n_faces);
    curvopt_problem_get_rules(o->problem, o->rules);
    PetscFunctionReturn(0);
}

PetscErrorCode objective_free(objective *o) {
    PetscFunctionBeginUser;
    curvopt_hessian_destroy(o->hessian);
    curvopt_problem_destroy(o->problem);
    free(o->project);
    free(o->anchor);
    free(o->base);
    free(o->gradients);
    free(o->xyz);
    free(o->own);
    free(o->rules);
    free(o->errors);
    *o = (objective){0};
    PetscFunctionReturn(0);
}

void objective_project(const objective *o, double *own) {
    for (PetscInt v = 0; o->project && v < o->on->n_own; v++) {
        const double *p = o->project + 9 * (size_t)v;
        double *x = own + 3 * (size_t)v, y[3] = {x[0], x[1], x[2]};
        for (int i = 0; i < 3; i++)
            x[i] = p[3 * i] * y[0] + p[3 * i + 1] * y[1] + p[3 * i + 2] * y[2];
    }
}

void objective_positions(const objective *o, const double *x, double *own) {
    for (PetscInt i = 0; i < 3 * o->on->n_own; i++)
        own[i] = o->project ? x[i] - o->anchor[i] : x[i];
    objective_project(o, own);
    for (PetscInt i = 0; o->project && i < 3 * o->on->n_own; i++)
        own[i] += o->anchor[i];
}

PetscErrorCode objective_constrain(objective *o, Vec x, double *projectors) {
    const PetscScalar *at;
    double *anchor = COLLECTIVE_NEW(o->on->comm, double, 3 * (size_t)o->on->n_own);
    PetscFunctionBeginUser;
    PetscCall(VecGetArrayRead(x, &at));
    objective_positions(o, at, anchor);
    PetscCall(VecRestoreArrayRead(x, &at));
    free(o->anchor);
    free(o->project);
    o->anchor = anchor;
    o->project = projectors;
    PetscFunctionReturn(0);
}

PetscErrorCode objective_place(objective *o, Vec x) {
    const PetscScalar *at;
    PetscFunctionBeginUser;
    PetscCall(VecGetArrayRead(x, &at));
    objective_positions(o, at, o->own);
    PetscCall(VecRestoreArrayRead(x, &at));
    PetscCall(subdomain_fetch(o->on, o->own, o->xyz));
    o->radius = 1;
    o->centroid[0] = o->centroid[1] = o->centroid[2] = 0;
    if (!o->framed)
        PetscCall(objective_frame(o->on, o->own, o->centroid, &o->radius));
    for (PetscInt i = 0; !o->framed && i < 3 * o->on->n_vertices; i++)
        o->xyz[i] = (o->xyz[i] - o->centroid[i % 3]) / o->radius;
    PetscFunctionReturn(0);
}

/* Square of the longest step of an own vertex. */
static double longest_step(const objective *o) {
    double longest = 0;
    for (PetscInt v = 0; o->base && v < o->on->n_own; v++) {
        double square = 0;
        for (PetscInt i = 3 * v; i < 3 * v + 3; i++)
            square += (o->own[i] - o->base[i]) * (o->own[i] - o->base[i]);
        longest = fmax(longest, square);
    }
    return longest;
}

/* o->sums of the whole, from this rank's; *too_far: whether a step is too long. */
static PetscErrorCode add_up(objective *o, const curvopt_sums *mine, int *too_far) {
    enum { N_SUMS = sizeof(curvopt_sums) / sizeof(double) - 1 }; /* min_jacobian, the last, is no sum */
    double least[2] = {mine->min_jacobian, -longest_step(o)}, least_of_all[2];
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Allreduce(mine, &o->sums, N_SUMS, MPI_DOUBLE, MPI_SUM, o->on->comm));
    PetscCallMPI(MPI_Allreduce(least, least_of_all, 2, MPI_DOUBLE, MPI_MIN, o->on->comm));
    o->sums.min_jacobian = least_of_all[0];
    *too_far = o->base && -least_of_all[1] > o->longest * o->longest;
    PetscFunctionReturn(0);
}

static double value_of(const objective *o) {
    return o->sums.second + (o->third ? o->sums.area * o->sums.third : 0);
}

/* own [3 n_own]: what of a gradient with respect to normalized positions is one with respect to positions. What would
 * change centroid and radius drops out. */
static PetscErrorCode unnormalize(const objective *o, double *own) {
    const double *at = o->own;
    double weight = 1 / (double)o->on->whole_vertices, mine[4] = {0}, mean[4];
    PetscFunctionBeginUser;
    for (PetscInt i = 0; i < 3 * o->on->n_own; i++) {
        mine[i % 3] += weight * own[i];
        mine[3] += weight * own[i] * (at[i] - o->centroid[i % 3]) / o->radius;
    }
    PetscCallMPI(MPI_Allreduce(mine, mean, 4, MPI_DOUBLE, MPI_SUM, o->on->comm));
    for (PetscInt i = 0; i < 3 * o->on->n_own; i++)
        own[i] = (own[i] - mean[i % 3] - mean[3] * (at[i] - o->centroid[i % 3]) / o->radius) / o->radius;
    PetscFunctionReturn(0);
}

PetscErrorCode objective_evaluate(objective *o, Vec x, double *value, Vec gradient) {
    curvopt_sums mine;
    curvopt_error error;
    size_t n = 3 * (size_t)o->on->n_vertices;
    PetscScalar *out;
    int too_far;
    PetscFunctionBeginUser;
    double began = MPI_Wtime();
    PetscCall(objective_place(o, x));
    double started = cpu_seconds();
    collective_check(o->on->comm,
                     curvopt_problem_sum(o->problem, o->xyz, 0, gradient ? o->gradients : NULL, &mine, &error), &error);
    o->cpu_seconds += cpu_seconds() - started;
    o->evaluations++;
    PetscCall(add_up(o, &mine, &too_far));
    *value = too_far ? (double)INFINITY : value_of(o);
    if (!gradient)
        PetscFunctionReturn(0);
    for (size_t i = 0; o->third && i < n; i++)
        o->gradients[i] += o->sums.area * o->gradients[n + i] + o->sums.third * o->gradients[2 * n + i];
    PetscCall(VecGetArrayWrite(gradient, &out));
    PetscCall(subdomain_sum(o->on, o->gradients, out));
    if (!o->framed)
        PetscCall(unnormalize(o, out));
    objective_project(o, out);
    PetscCall(VecRestoreArrayWrite(gradient, &out));
    o->least_seconds = fmin(o->least_seconds, MPI_Wtime() - began);
    PetscFunctionReturn(0);
}

PetscErrorCode objective_set_base(objective *o, Vec x) {
    const PetscScalar *at;
    PetscFunctionBeginUser;
    PetscCall(VecGetArrayRead(x, &at));
    objective_positions(o, at, o->base);
    PetscCall(VecRestoreArrayRead(x, &at));
    PetscFunctionReturn(0);
}

PetscErrorCode objective_limit_steps(objective *o, Vec x, double max_step) {
    curvopt_mesh_info info;
    MPI_Comm comm = o->on->comm;
    double mine[2] = {0, 0}, all[2];
    PetscFunctionBeginUser;
    curvopt_mesh_get_info(o->on->mesh, &info, sizeof info);
    int32_t *sizes = COLLECTIVE_NEW(comm, int32_t, info.n_faces),
            *vertices = COLLECTIVE_NEW(comm, int32_t, info.n_corners);
    curvopt_mesh_get_faces(o->on->mesh, sizes, vertices);
    PetscCall(objective_place(o, x));
    for (int32_t f = 0, c = 0; f < info.n_faces; c += sizes[f++])
        for (int32_t k = 0; o->on->counts[f] != 0 && k < sizes[f]; k++) {
            const double *a = o->xyz + 3 * (size_t)vertices[c + k],
                         *b = o->xyz + 3 * (size_t)vertices[c + (k + 1) % sizes[f]];
            mine[0] +=
                sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
            mine[1]++;
        }
    PetscCallMPI(MPI_Allreduce(mine, all, 2, MPI_DOUBLE, MPI_SUM, comm));
    free(sizes);
    free(vertices);
    o->longest = max_step * o->radius * all[0] / all[1];
    o->base = o->base ? o->base : COLLECTIVE_NEW(comm, double, 3 * (size_t)o->on->n_own);
    PetscCall(objective_set_base(o, x));
    PetscFunctionReturn(0);
}

/* ------------------------------------------------------------------------------------------------ quadrature -- */

PetscErrorCode objective_compare(objective *o, Vec x, double *value, double *relative_error) {
    curvopt_sums mine;
    curvopt_error error;
    double sum[2] = {0, 0}, whole[2];
    int too_far;
    PetscFunctionBeginUser;
    PetscCall(objective_place(o, x));
    collective_check(o->on->comm, curvopt_problem_sum(o->problem, o->xyz, 1, NULL, &mine, &error), &error);
    PetscCall(add_up(o, &mine, &too_far));
    collective_check(o->on->comm,
                     curvopt_problem_face_errors(o->problem, o->xyz, o->sums.area, o->sums.third, o->errors, &error),
                     &error);
    for (PetscInt f = 0; f < o->on->n_faces; f++) {
        sum[0] += o->errors[f];
        sum[1] += fabs(o->errors[f]);
    }
    PetscCallMPI(MPI_Allreduce(sum, whole, 2, MPI_DOUBLE, MPI_SUM, o->on->comm));
    *value = value_of(o);
    o->error_net = whole[0];
    o->error_gross = whole[1];
    *relative_error = whole[1] / fabs(*value);
    PetscFunctionReturn(0);
}

static int is_refinable(const objective *o, PetscInt f) {
    return o->on->counts[f] != 0 && o->rules[f] < CURVOPT_FINEST_RULE;
}

/* Errors below the cut, of faces whose rule could be finer, in all; of the objective. */
static PetscErrorCode kept_error(const objective *o, double cut, double *kept) {
    double mine = 0;
    PetscFunctionBeginUser;
    for (PetscInt f = 0; f < o->on->n_faces; f++)
        if (is_refinable(o, f) && fabs(o->errors[f]) < cut)
            mine += fabs(o->errors[f]);
    PetscCallMPI(MPI_Allreduce(&mine, kept, 1, MPI_DOUBLE, MPI_SUM, o->on->comm));
    PetscFunctionReturn(0);
}

PetscErrorCode objective_refine_rules(objective *o, double tolerance, PetscInt *raised) {
    curvopt_error error;
    double value = fabs(value_of(o)), low = log(LEAST_CUT), high = log(fmax(o->error_gross / value, LEAST_CUT));
    PetscInt mine = 0;
    PetscFunctionBeginUser;
    for (int step = 0; step < CUT_STEPS; step++) {
        double kept, middle = (low + high) / 2;
        PetscCall(kept_error(o, exp(middle) * value, &kept));
        *(kept <= co_tuning_defaults.quadrature_unmarked * tolerance * value ? &low : &high) = middle;
    }
    double cut = exp(low) * value * (1 - CO_MARKING_TIE);
    for (PetscInt f = 0; f < o->on->n_faces; f++)
        if (is_refinable(o, f) && !(fabs(o->errors[f]) < cut)) {
            o->rules[f]++;
            mine++;
        }
    PetscCallMPI(MPI_Allreduce(&mine, raised, 1, MPIU_INT, MPI_SUM, o->on->comm));
    if (mine)
        collective_check(o->on->comm, curvopt_problem_set_rules(o->problem, o->rules, &error), &error);
    PetscFunctionReturn(0);
}

PetscErrorCode objective_resolve(objective *o, Vec x, double tolerance, double *value, double *relative_error) {
    PetscInt raised = 1;
    PetscFunctionBeginUser;
    PetscCall(objective_compare(o, x, value, relative_error));
    while (raised && isfinite(*value) && !(*relative_error <= tolerance)) {
        PetscCall(objective_refine_rules(o, tolerance, &raised));
        if (raised)
            PetscCall(objective_compare(o, x, value, relative_error));
    }
    PetscFunctionReturn(0);
}

/* --------------------------------------------------------------------------------------------------- Hessian -- */

/* What the product needs beside the sparse matrix. */
typedef struct dense_part {
    Mat sparse;
    Vec area, third, product; /* gradients of the two factors; work */
    objective *objective;
    double scale; /* of all of it: from normalized positions to the vector's */
} dense_part;

static PetscErrorCode apply(Mat full, Vec in, Vec out) {
    dense_part *d;
    PetscScalar along_area, along_third, *own;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(full, &d));
    PetscCall(VecCopy(in, d->product));
    PetscCall(VecGetArray(d->product, &own));
    objective_project(d->objective, own);
    PetscCall(VecRestoreArray(d->product, &own));
    PetscCall(MatMult(d->sparse, d->product, out));
    if (d->objective->third) {
        PetscCall(VecDot(d->product, d->area, &along_area));
        PetscCall(VecDot(d->product, d->third, &along_third));
        PetscCall(VecAXPBYPCZ(out, along_third, along_area, 1, d->area, d->third));
    }
    PetscCall(VecScale(out, d->scale));
    PetscCall(VecGetArray(out, &own));
    objective_project(d->objective, own);
    PetscCall(VecRestoreArray(out, &own));
    PetscFunctionReturn(0);
}

static PetscErrorCode destroy_dense(Mat full) {
    dense_part *d;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(full, &d));
    PetscCall(MatDestroy(&d->sparse));
    PetscCall(VecDestroy(&d->area));
    PetscCall(VecDestroy(&d->third));
    PetscCall(VecDestroy(&d->product));
    free(d);
    PetscFunctionReturn(0);
}

/* Both triangles of this rank's matrix, in PETSc's numbering; the diagonal once. */
static PetscErrorCode make_sparse(objective *o, Mat *sparse) {
    const subdomain *on = o->on;
    curvopt_matrix m;
    PetscFunctionBeginUser;
    curvopt_hessian_get(o->hessian, &m);
    PetscCount n = 0, n_entries = 2 * (PetscCount)m.column_start[m.n];
    PetscInt *row = COLLECTIVE_NEW(on->comm, PetscInt, n_entries),
             *column = COLLECTIVE_NEW(on->comm, PetscInt, n_entries);
    for (int32_t j = 0; j < m.n; j++)
        for (int32_t k = m.column_start[j]; k < m.column_start[j + 1]; k++) {
            int32_t i = m.row[k];
            PetscInt a = 3 * on->global[i / 3] + i % 3, b = 3 * on->global[j / 3] + j % 3;
            row[n] = a;
            column[n++] = b;
            row[n] = i == j ? -1 : b; /* passed over */
            column[n++] = a;
        }
    PetscCall(MatCreate(on->comm, sparse));
    PetscCall(MatSetSizes(*sparse, 3 * on->n_own, 3 * on->n_own, PETSC_DETERMINE, PETSC_DETERMINE));
    PetscCall(MatSetType(*sparse, MATAIJ));
    PetscCall(MatSetOption(*sparse, MAT_SYMMETRIC, PETSC_TRUE));
    PetscCall(MatSetPreallocationCOO(*sparse, n, row, column));
    free(row);
    free(column);
    PetscFunctionReturn(0);
}

static PetscErrorCode make_full(objective *o, Vec x, Mat sparse, Mat *full) {
    PetscFunctionBeginUser;
    dense_part *d = COLLECTIVE_NEW(o->on->comm, dense_part, 1);
    d->sparse = sparse;
    d->objective = o;
    PetscCall(PetscObjectReference((PetscObject)sparse));
    PetscCall(VecDuplicate(x, &d->area));
    PetscCall(VecDuplicate(x, &d->third));
    PetscCall(VecDuplicate(x, &d->product));
    PetscCall(
        MatCreateShell(o->on->comm, 3 * o->on->n_own, 3 * o->on->n_own, PETSC_DETERMINE, PETSC_DETERMINE, d, full));
    PetscCall(MatShellSetOperation(*full, MATOP_MULT, (void (*)(void))apply));
    PetscCall(MatShellSetOperation(*full, MATOP_DESTROY, (void (*)(void))destroy_dense));
    PetscCall(MatSetOption(*full, MAT_SYMMETRIC, PETSC_TRUE));
    PetscFunctionReturn(0);
}

/* The gradients of area and third-order integral, from o->gradients. */
static PetscErrorCode set_factors(objective *o, Mat full) {
    size_t n = 3 * (size_t)o->on->n_vertices;
    dense_part *d;
    PetscScalar *own;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(full, &d));
    PetscCall(VecGetArrayWrite(d->third, &own));
    PetscCall(subdomain_sum(o->on, o->gradients + n, own));
    PetscCall(VecRestoreArrayWrite(d->third, &own));
    PetscCall(VecGetArrayWrite(d->area, &own));
    PetscCall(subdomain_sum(o->on, o->gradients + 2 * n, own));
    PetscCall(VecRestoreArrayWrite(d->area, &own));
    PetscFunctionReturn(0);
}

/* Values of o->hessian as it is. */
static PetscErrorCode set_values(objective *o, Mat sparse) {
    curvopt_matrix m;
    PetscFunctionBeginUser;
    curvopt_hessian_get(o->hessian, &m);
    PetscCount n_entries = m.column_start[m.n];
    double *values = COLLECTIVE_NEW(o->on->comm, double, 2 * n_entries);
    for (PetscCount k = 0; k < n_entries; k++)
        values[2 * k] = values[2 * k + 1] = m.value[k];
    PetscCall(MatSetValuesCOO(sparse, values, INSERT_VALUES));
    free(values);
    PetscFunctionReturn(0);
}

double objective_shift(const objective *o, double value) {
    return co_tuning_defaults.shift_least * fabs(value) / (double)o->on->whole_vertices / (o->radius * o->radius);
}

PetscErrorCode objective_hessian(objective *o, Vec x, Mat *full, Mat *preconditioner) {
    curvopt_sums mine;
    curvopt_error error;
    MPI_Comm comm = o->on->comm;
    dense_part *d;
    Mat sparse;
    int too_far;
    PetscFunctionBeginUser;
    PetscCall(objective_place(o, x));
    collective_check(comm, curvopt_problem_sum(o->problem, o->xyz, 0, o->gradients, &mine, &error), &error);
    PetscCall(add_up(o, &mine, &too_far));
    if (!o->hessian)
        collective_check(comm, curvopt_hessian_create(o->problem, &o->hessian, &error), &error);
    if (!*full) {
        PetscCall(make_sparse(o, &sparse));
        PetscCall(make_full(o, x, sparse, full));
        PetscCall(MatDestroy(&sparse)); /* the full one has it */
        PetscCall(make_sparse(o, preconditioner));
    }
    PetscCall(set_factors(o, *full));
    PetscCall(MatShellGetContext(*full, &d));
    d->scale = 1 / (o->radius * o->radius);
    collective_check(comm, curvopt_hessian_assemble(o->hessian, o->xyz, 1, o->sums.area, o->sums.third, &error),
                     &error);
    PetscCall(set_values(o, d->sparse));
    collective_check(comm, curvopt_hessian_assemble(o->hessian, o->xyz, 0, o->sums.area, o->sums.third, &error),
                     &error);
    PetscCall(set_values(o, *preconditioner));
    PetscCall(MatScale(*preconditioner, 1 / (o->radius * o->radius)));
    PetscCall(MatShift(*preconditioner, objective_shift(o, value_of(o))));
    PetscFunctionReturn(0);
}

PetscErrorCode objective_sparse(Mat full, double shift, Mat *sparse) {
    dense_part *d;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(full, &d));
    PetscCall(MatDuplicate(d->sparse, MAT_COPY_VALUES, sparse));
    PetscCall(MatScale(*sparse, d->scale));
    PetscCall(MatShift(*sparse, shift));
    PetscFunctionReturn(0);
}
