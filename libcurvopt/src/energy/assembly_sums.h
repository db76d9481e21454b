/* Sums over faces: a surface's energies and their gradients.
 *
 *     points of an assembly
 *       |  element kernels, block by block
 *       v
 *     values, and gradients of points --add derived points' to the cage--> --undo the normalization--> gradient
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ASSEMBLY_SUMS_H
#define CO_ENERGY_ASSEMBLY_SUMS_H

#include "energy/assembly.h"

/* The request to co_assembly_evaluate(). */
typedef struct co_request {
    int is_normalized; /* positions have centroid 0 and radius 1, and are taken as they are; so is the gradient */
    int all_terms;     /* third-order integrals are wanted even if the objective has none */
    int volume;        /* the volume is wanted */
    double *gradient;  /* [3 n_cage] out, or NULL */
} co_request;

typedef struct co_values {
    double objective;
    double reference;                /* objective + reference is never near 0 (spontaneous_curvature.h) */
    double integral[CO_N_INTEGRALS]; /* integrals over the normalized surface */
    double radius;                   /* root mean square radius of the positions; areas are in units of its square */
    double min_jacobian;             /* least |S_u x S_v|, by the mean on the same face */
    int32_t worst_face;              /* cage face that has it */
} co_values;

/* Values at xyz [3 n_cage] by the present rules; the gradient is that of the normalized objective, so it has no
 * component along translations and, without spontaneous curvature, scaling. Never fails; a surface that degenerates
 * gives values that are not finite, and so does an evaluation that is cancelled.
 *
 * With face weights that leave faces out, positions of vertices that no patch is made of are not read, and their part
 * of a gradient is not written (`active`). */
void co_assembly_evaluate(co_assembly *assembly, const double *xyz, const co_request *request, co_values *out);

/* Gradients [3 n_cage] of the parts of an objective, second + area * third. NULL: not wanted; `third` and `area` only
 * together. Where the objective has no such terms they are not written. */
typedef struct co_pieces {
    double *second, *third, *area;
} co_pieces;

/* Values at x [3 n_cage], normalized, and raw gradients: normalization is not differentiated. */
void co_assembly_pieces(co_assembly *assembly, const double *x, int all_terms, const co_pieces *gradients,
                        co_values *out);
/* Area and volume alone, and with `mean` total mean curvature, at x [3 n_cage], normalized or not. */
void co_assembly_numbers(co_assembly *assembly, const double *x, int mean, double integral[CO_N_INTEGRALS]);
/* The gradient [3 n_cage] of one number (curvopt_scalar) at the positions that were evaluated last, as they are. */
void co_assembly_number_gradient(co_assembly *assembly, int scalar, double *gradient);
/* Total turning of boundaries and creases (boundary_turning.h) at the positions that were evaluated last. */
double co_assembly_turning(const co_assembly *assembly);

/* Distance of the total curvature from what Gauss and Bonnet say, at the positions that were evaluated last; 0 where
 * faces are left out. */
double co_assembly_defect(const co_assembly *assembly, const co_values *values);

/* Values by other batches of the assembly's patches, at the positions that were evaluated last. ERROR_MEMORY,
 * CO_CANCELLED. */
int32_t co_assembly_evaluate_batches(co_assembly *assembly, co_element_batches *batches, int third, co_values *out,
                                     curvopt_error *error);

#endif
