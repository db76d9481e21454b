/* The objective of a cage that is shared out. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "objective.h"

#include "collective.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double SHIFT = 0.1;                         /* as the library's level.c has it */
enum { CUT_STEPS = 60 };                                 /* of bisection, in the logarithm of an error */
static const double LEAST_CUT = 1e-24, ALIKE = 1 - 1e-6; /* errors that differ by less are those of symmetric faces */

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

PetscErrorCode energy_frame(const portion *on, const double *own, double centroid[3], double *radius) {
    double sum[3] = {0, 0, 0}, square = 0, part = 1 / (double)on->whole_vertices;
    PetscFunctionBeginUser;
    for (PetscInt i = 0; i < 3 * on->n_own; i++)
        sum[i % 3] += part * own[i];
    PetscCallMPI(MPI_Allreduce(sum, centroid, 3, MPI_DOUBLE, MPI_SUM, on->comm));
    for (PetscInt i = 0; i < 3 * on->n_own; i++)
        square += part * (own[i] - centroid[i % 3]) * (own[i] - centroid[i % 3]);
    PetscCallMPI(MPI_Allreduce(&square, radius, 1, MPI_DOUBLE, MPI_SUM, on->comm));
    *radius = sqrt(*radius);
    PetscFunctionReturn(0);
}

PetscErrorCode energy_create(const portion *on, const curvopt_options *options, energy *e, int *refused,
                             char *message) {
    curvopt_error error;
    PetscFunctionBeginUser;
    *e = (energy){.on = on, .options = options, .radius = 1, .least_seconds = (double)INFINITY};
    int32_t status = curvopt_problem_create_part(on->mesh, on->counts, options, &e->problem, &error);
    *refused = agree_on_status(on->comm, status, &error, message);
    if (*refused) {
        curvopt_problem_destroy(e->problem);
        e->problem = NULL;
        PetscFunctionReturn(0);
    }
    for (int t = CURVOPT_TERM_MVS; t <= CURVOPT_TERM_MEHLUM_TARROU; t++)
        e->third |= options->weights[t] > 0;
    e->shares = AGREE_NEW(on->comm, double, 9 * (size_t)on->n_vertices);
    e->xyz = AGREE_NEW(on->comm, double, 3 * (size_t)on->n_vertices);
    e->own = AGREE_NEW(on->comm, double, 3 * (size_t)on->n_own);
    e->rules = AGREE_NEW(on->comm, int32_t, on->n_faces);
    e->errors = AGREE_NEW(on->comm, double, on->n_faces);
    curvopt_problem_get_rules(e->problem, e->rules);
    PetscFunctionReturn(0);
}

PetscErrorCode energy_free(energy *e) {
    PetscFunctionBeginUser;
    curvopt_hessian_destroy(e->hessian);
    curvopt_problem_destroy(e->problem);
    free(e->project);
    free(e->anchor);
    free(e->base);
    free(e->shares);
    free(e->xyz);
    free(e->own);
    free(e->rules);
    free(e->errors);
    *e = (energy){0};
    PetscFunctionReturn(0);
}

void energy_project(const energy *e, double *own) {
    for (PetscInt v = 0; e->project && v < e->on->n_own; v++) {
        const double *p = e->project + 9 * (size_t)v;
        double *x = own + 3 * (size_t)v, y[3] = {x[0], x[1], x[2]};
        for (int i = 0; i < 3; i++)
            x[i] = p[3 * i] * y[0] + p[3 * i + 1] * y[1] + p[3 * i + 2] * y[2];
    }
}

void energy_positions(const energy *e, const double *x, double *own) {
    for (PetscInt i = 0; i < 3 * e->on->n_own; i++)
        own[i] = e->project ? x[i] - e->anchor[i] : x[i];
    energy_project(e, own);
    for (PetscInt i = 0; e->project && i < 3 * e->on->n_own; i++)
        own[i] += e->anchor[i];
}

PetscErrorCode energy_hold(energy *e, Vec x, double *projectors) {
    const PetscScalar *at;
    double *anchor = AGREE_NEW(e->on->comm, double, 3 * (size_t)e->on->n_own);
    PetscFunctionBeginUser;
    PetscCall(VecGetArrayRead(x, &at));
    energy_positions(e, at, anchor);
    PetscCall(VecRestoreArrayRead(x, &at));
    free(e->anchor);
    free(e->project);
    e->anchor = anchor;
    e->project = projectors;
    PetscFunctionReturn(0);
}

PetscErrorCode energy_place(energy *e, Vec x) {
    const PetscScalar *at;
    PetscFunctionBeginUser;
    PetscCall(VecGetArrayRead(x, &at));
    energy_positions(e, at, e->own);
    PetscCall(VecRestoreArrayRead(x, &at));
    PetscCall(portion_fetch(e->on, e->own, e->xyz));
    e->radius = 1;
    e->centroid[0] = e->centroid[1] = e->centroid[2] = 0;
    if (!e->framed)
        PetscCall(energy_frame(e->on, e->own, e->centroid, &e->radius));
    for (PetscInt i = 0; !e->framed && i < 3 * e->on->n_vertices; i++)
        e->xyz[i] = (e->xyz[i] - e->centroid[i % 3]) / e->radius;
    PetscFunctionReturn(0);
}

/* Square of the longest step of an own vertex. */
static double longest_step(const energy *e) {
    double longest = 0;
    for (PetscInt v = 0; e->base && v < e->on->n_own; v++) {
        double square = 0;
        for (PetscInt i = 3 * v; i < 3 * v + 3; i++)
            square += (e->own[i] - e->base[i]) * (e->own[i] - e->base[i]);
        longest = fmax(longest, square);
    }
    return longest;
}

/* e->sums of the whole, from this rank's; *too_far: whether a step is too long. */
static PetscErrorCode add_up(energy *e, const curvopt_sums *mine, int *too_far) {
    enum { N_SUMS = sizeof(curvopt_sums) / sizeof(double) - 1 }; /* min_jacobian, the last, is no sum */
    double least[2] = {mine->min_jacobian, -longest_step(e)}, least_of_all[2];
    PetscFunctionBeginUser;
    PetscCallMPI(MPI_Allreduce(mine, &e->sums, N_SUMS, MPI_DOUBLE, MPI_SUM, e->on->comm));
    PetscCallMPI(MPI_Allreduce(least, least_of_all, 2, MPI_DOUBLE, MPI_MIN, e->on->comm));
    e->sums.min_jacobian = least_of_all[0];
    *too_far = e->base && -least_of_all[1] > e->longest * e->longest;
    PetscFunctionReturn(0);
}

static double value_of(const energy *e) {
    return e->sums.second + (e->third ? e->sums.area * e->sums.third : 0);
}

/* own [3 n_own]: what of a gradient with respect to normalized positions is one with respect to positions. What would
 * change centroid and radius drops out. */
static PetscErrorCode unnormalize(const energy *e, double *own) {
    const double *at = e->own;
    double part = 1 / (double)e->on->whole_vertices, mine[4] = {0}, mean[4];
    PetscFunctionBeginUser;
    for (PetscInt i = 0; i < 3 * e->on->n_own; i++) {
        mine[i % 3] += part * own[i];
        mine[3] += part * own[i] * (at[i] - e->centroid[i % 3]) / e->radius;
    }
    PetscCallMPI(MPI_Allreduce(mine, mean, 4, MPI_DOUBLE, MPI_SUM, e->on->comm));
    for (PetscInt i = 0; i < 3 * e->on->n_own; i++)
        own[i] = (own[i] - mean[i % 3] - mean[3] * (at[i] - e->centroid[i % 3]) / e->radius) / e->radius;
    PetscFunctionReturn(0);
}

PetscErrorCode energy_evaluate(energy *e, Vec x, double *value, Vec gradient) {
    curvopt_sums mine;
    curvopt_error error;
    size_t n = 3 * (size_t)e->on->n_vertices;
    PetscScalar *out;
    int too_far;
    PetscFunctionBeginUser;
    double began = MPI_Wtime();
    PetscCall(energy_place(e, x));
    double started = cpu_seconds();
    agree_succeeded(e->on->comm, curvopt_problem_sum(e->problem, e->xyz, 0, gradient ? e->shares : NULL, &mine, &error),
                    &error);
    e->cpu_seconds += cpu_seconds() - started;
    e->evaluations++;
    PetscCall(add_up(e, &mine, &too_far));
    *value = too_far ? (double)INFINITY : value_of(e);
    if (!gradient)
        PetscFunctionReturn(0);
    for (size_t i = 0; e->third && i < n; i++)
        e->shares[i] += e->sums.area * e->shares[n + i] + e->sums.third * e->shares[2 * n + i];
    PetscCall(VecGetArrayWrite(gradient, &out));
    PetscCall(portion_sum(e->on, e->shares, out));
    if (!e->framed)
        PetscCall(unnormalize(e, out));
    energy_project(e, out);
    PetscCall(VecRestoreArrayWrite(gradient, &out));
    e->least_seconds = fmin(e->least_seconds, MPI_Wtime() - began);
    PetscFunctionReturn(0);
}

PetscErrorCode energy_set_base(energy *e, Vec x) {
    const PetscScalar *at;
    PetscFunctionBeginUser;
    PetscCall(VecGetArrayRead(x, &at));
    energy_positions(e, at, e->base);
    PetscCall(VecRestoreArrayRead(x, &at));
    PetscFunctionReturn(0);
}

PetscErrorCode energy_limit_steps(energy *e, Vec x, double max_step) {
    curvopt_mesh_info info;
    MPI_Comm comm = e->on->comm;
    double mine[2] = {0, 0}, all[2];
    PetscFunctionBeginUser;
    curvopt_mesh_get_info(e->on->mesh, &info, sizeof info);
    int32_t *sizes = AGREE_NEW(comm, int32_t, info.n_faces), *vertices = AGREE_NEW(comm, int32_t, info.n_corners);
    curvopt_mesh_get_faces(e->on->mesh, sizes, vertices);
    PetscCall(energy_place(e, x));
    for (int32_t f = 0, c = 0; f < info.n_faces; c += sizes[f++])
        for (int32_t k = 0; e->on->counts[f] != 0 && k < sizes[f]; k++) {
            const double *a = e->xyz + 3 * (size_t)vertices[c + k],
                         *b = e->xyz + 3 * (size_t)vertices[c + (k + 1) % sizes[f]];
            mine[0] +=
                sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
            mine[1]++;
        }
    PetscCallMPI(MPI_Allreduce(mine, all, 2, MPI_DOUBLE, MPI_SUM, comm));
    free(sizes);
    free(vertices);
    e->longest = max_step * e->radius * all[0] / all[1];
    e->base = e->base ? e->base : AGREE_NEW(comm, double, 3 * (size_t)e->on->n_own);
    PetscCall(energy_set_base(e, x));
    PetscFunctionReturn(0);
}

/* ------------------------------------------------------------------------------------------------ quadrature -- */

PetscErrorCode energy_compare(energy *e, Vec x, double *value, double *relative_error) {
    curvopt_sums mine;
    curvopt_error error;
    double sum[2] = {0, 0}, whole[2];
    int too_far;
    PetscFunctionBeginUser;
    PetscCall(energy_place(e, x));
    agree_succeeded(e->on->comm, curvopt_problem_sum(e->problem, e->xyz, 1, NULL, &mine, &error), &error);
    PetscCall(add_up(e, &mine, &too_far));
    agree_succeeded(e->on->comm,
                    curvopt_problem_face_errors(e->problem, e->xyz, e->sums.area, e->sums.third, e->errors, &error),
                    &error);
    for (PetscInt f = 0; f < e->on->n_faces; f++) {
        sum[0] += e->errors[f];
        sum[1] += fabs(e->errors[f]);
    }
    PetscCallMPI(MPI_Allreduce(sum, whole, 2, MPI_DOUBLE, MPI_SUM, e->on->comm));
    *value = value_of(e);
    e->error_net = whole[0];
    e->error_gross = whole[1];
    *relative_error = whole[1] / fabs(*value);
    PetscFunctionReturn(0);
}

static int is_refinable(const energy *e, PetscInt f) {
    return e->on->counts[f] != 0 && e->rules[f] < CURVOPT_FINEST_RULE;
}

/* Errors below the cut, of faces whose rule could be finer, in all; of the objective. */
static PetscErrorCode kept_error(const energy *e, double cut, double *kept) {
    double mine = 0;
    PetscFunctionBeginUser;
    for (PetscInt f = 0; f < e->on->n_faces; f++)
        if (is_refinable(e, f) && fabs(e->errors[f]) < cut)
            mine += fabs(e->errors[f]);
    PetscCallMPI(MPI_Allreduce(&mine, kept, 1, MPI_DOUBLE, MPI_SUM, e->on->comm));
    PetscFunctionReturn(0);
}

PetscErrorCode energy_refine_rules(energy *e, double tolerance, PetscInt *raised) {
    curvopt_error error;
    double value = fabs(value_of(e)), low = log(LEAST_CUT), high = log(fmax(e->error_gross / value, LEAST_CUT));
    PetscInt mine = 0;
    PetscFunctionBeginUser;
    for (int step = 0; step < CUT_STEPS; step++) {
        double kept, middle = (low + high) / 2;
        PetscCall(kept_error(e, exp(middle) * value, &kept));
        *(kept <= 0.5 * tolerance * value ? &low : &high) = middle;
    }
    double cut = exp(low) * value * ALIKE;
    for (PetscInt f = 0; f < e->on->n_faces; f++)
        if (is_refinable(e, f) && !(fabs(e->errors[f]) < cut)) {
            e->rules[f]++;
            mine++;
        }
    PetscCallMPI(MPI_Allreduce(&mine, raised, 1, MPIU_INT, MPI_SUM, e->on->comm));
    if (mine)
        agree_succeeded(e->on->comm, curvopt_problem_set_rules(e->problem, e->rules, &error), &error);
    PetscFunctionReturn(0);
}

PetscErrorCode energy_resolve(energy *e, Vec x, double tolerance, double *value, double *relative_error) {
    PetscInt raised = 1;
    PetscFunctionBeginUser;
    PetscCall(energy_compare(e, x, value, relative_error));
    while (raised && isfinite(*value) && !(*relative_error <= tolerance)) {
        PetscCall(energy_refine_rules(e, tolerance, &raised));
        if (raised)
            PetscCall(energy_compare(e, x, value, relative_error));
    }
    PetscFunctionReturn(0);
}

/* --------------------------------------------------------------------------------------------------- Hessian -- */

/* What the product needs beside the sparse matrix. */
typedef struct dense_part {
    Mat sparse;
    Vec area, third, product; /* gradients of the two factors; work */
    energy *e;
    double scale; /* of all of it: from normalized positions to the vector's */
} dense_part;

static PetscErrorCode apply(Mat full, Vec in, Vec out) {
    dense_part *d;
    PetscScalar along_area, along_third, *own;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(full, &d));
    PetscCall(VecCopy(in, d->product));
    PetscCall(VecGetArray(d->product, &own));
    energy_project(d->e, own);
    PetscCall(VecRestoreArray(d->product, &own));
    PetscCall(MatMult(d->sparse, d->product, out));
    if (d->e->third) {
        PetscCall(VecDot(d->product, d->area, &along_area));
        PetscCall(VecDot(d->product, d->third, &along_third));
        PetscCall(VecAXPBYPCZ(out, along_third, along_area, 1, d->area, d->third));
    }
    PetscCall(VecScale(out, d->scale));
    PetscCall(VecGetArray(out, &own));
    energy_project(d->e, own);
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
static PetscErrorCode make_sparse(energy *e, Mat *sparse) {
    const portion *on = e->on;
    curvopt_matrix m;
    PetscFunctionBeginUser;
    curvopt_hessian_get(e->hessian, &m);
    PetscCount n = 0, n_entries = 2 * (PetscCount)m.column_start[m.n];
    PetscInt *row = AGREE_NEW(on->comm, PetscInt, n_entries), *column = AGREE_NEW(on->comm, PetscInt, n_entries);
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

static PetscErrorCode make_full(energy *e, Vec x, Mat sparse, Mat *full) {
    PetscFunctionBeginUser;
    dense_part *d = AGREE_NEW(e->on->comm, dense_part, 1);
    d->sparse = sparse;
    d->e = e;
    PetscCall(PetscObjectReference((PetscObject)sparse));
    PetscCall(VecDuplicate(x, &d->area));
    PetscCall(VecDuplicate(x, &d->third));
    PetscCall(VecDuplicate(x, &d->product));
    PetscCall(
        MatCreateShell(e->on->comm, 3 * e->on->n_own, 3 * e->on->n_own, PETSC_DETERMINE, PETSC_DETERMINE, d, full));
    PetscCall(MatShellSetOperation(*full, MATOP_MULT, (void (*)(void))apply));
    PetscCall(MatShellSetOperation(*full, MATOP_DESTROY, (void (*)(void))destroy_dense));
    PetscCall(MatSetOption(*full, MAT_SYMMETRIC, PETSC_TRUE));
    PetscFunctionReturn(0);
}

/* The gradients of area and third-order integral, from the shares that are there. */
static PetscErrorCode set_factors(energy *e, Mat full) {
    size_t n = 3 * (size_t)e->on->n_vertices;
    dense_part *d;
    PetscScalar *own;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(full, &d));
    PetscCall(VecGetArrayWrite(d->third, &own));
    PetscCall(portion_sum(e->on, e->shares + n, own));
    PetscCall(VecRestoreArrayWrite(d->third, &own));
    PetscCall(VecGetArrayWrite(d->area, &own));
    PetscCall(portion_sum(e->on, e->shares + 2 * n, own));
    PetscCall(VecRestoreArrayWrite(d->area, &own));
    PetscFunctionReturn(0);
}

/* Values of e->hessian as it is. */
static PetscErrorCode set_values(energy *e, Mat sparse) {
    curvopt_matrix m;
    PetscFunctionBeginUser;
    curvopt_hessian_get(e->hessian, &m);
    PetscCount n_entries = m.column_start[m.n];
    double *values = AGREE_NEW(e->on->comm, double, 2 * n_entries);
    for (PetscCount k = 0; k < n_entries; k++)
        values[2 * k] = values[2 * k + 1] = m.value[k];
    PetscCall(MatSetValuesCOO(sparse, values, INSERT_VALUES));
    free(values);
    PetscFunctionReturn(0);
}

double energy_shift(const energy *e, double value) {
    return SHIFT * fabs(value) / (double)e->on->whole_vertices / (e->radius * e->radius);
}

PetscErrorCode energy_hessian(energy *e, Vec x, Mat *full, Mat *guide) {
    curvopt_sums mine;
    curvopt_error error;
    MPI_Comm comm = e->on->comm;
    dense_part *d;
    Mat sparse;
    int too_far;
    PetscFunctionBeginUser;
    PetscCall(energy_place(e, x));
    agree_succeeded(comm, curvopt_problem_sum(e->problem, e->xyz, 0, e->shares, &mine, &error), &error);
    PetscCall(add_up(e, &mine, &too_far));
    if (!e->hessian)
        agree_succeeded(comm, curvopt_hessian_create(e->problem, &e->hessian, &error), &error);
    if (!*full) {
        PetscCall(make_sparse(e, &sparse));
        PetscCall(make_full(e, x, sparse, full));
        PetscCall(MatDestroy(&sparse)); /* the full one has it */
        PetscCall(make_sparse(e, guide));
    }
    PetscCall(set_factors(e, *full));
    PetscCall(MatShellGetContext(*full, &d));
    d->scale = 1 / (e->radius * e->radius);
    agree_succeeded(comm, curvopt_hessian_assemble(e->hessian, e->xyz, 1, e->sums.area, e->sums.third, &error), &error);
    PetscCall(set_values(e, d->sparse));
    agree_succeeded(comm, curvopt_hessian_assemble(e->hessian, e->xyz, 0, e->sums.area, e->sums.third, &error), &error);
    PetscCall(set_values(e, *guide));
    PetscCall(MatScale(*guide, 1 / (e->radius * e->radius)));
    PetscCall(MatShift(*guide, energy_shift(e, value_of(e))));
    PetscFunctionReturn(0);
}

PetscErrorCode energy_sparse(Mat full, double shift, Mat *sparse) {
    dense_part *d;
    PetscFunctionBeginUser;
    PetscCall(MatShellGetContext(full, &d));
    PetscCall(MatDuplicate(d->sparse, MAT_COPY_VALUES, sparse));
    PetscCall(MatScale(*sparse, d->scale));
    PetscCall(MatShift(*sparse, shift));
    PetscFunctionReturn(0);
}
