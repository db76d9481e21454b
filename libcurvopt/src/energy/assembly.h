/* Sums over faces: a surface's energies and their gradients.
 *
 * Everything inside works on normalized positions (centroid 0, root mean square radius 1), so that no input is too
 * large or too small and the energies' invariance under translation and scaling is exact.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ASSEMBLY_H
#define CO_ENERGY_ASSEMBLY_H

#include "base/work_sharing.h"
#include "energy/element_batches.h"
#include "energy/quadrature_error.h"
#include "surface/boundary_turning.h"

/* The finest rule that is held against a finer one. */
enum { CO_FINEST_RULE = CO_N_RULES - 2 };

typedef struct co_assembly {
    co_patches patches;
    co_basis_table_cache *cache; /* the caller's, or */
    co_basis_table_cache own_cache;
    const co_element_kernel *kernel;
    co_functional functional;
    double weights[CURVOPT_N_TERMS]; /* what it is made of */
    int32_t surface;
    co_boundary_turning rim; /* boundaries and creases, for Gauss-Bonnet */
    int32_t n_threads;
    int32_t *active; /* [n_active] points that patches are made of, ascending; NULL where that is all of them */
    int32_t n_active, n_active_cage; /* and those of them that are the cage's, which come first */
    int met;                         /* the tolerance has been met before */
    int third_allowed;               /* the surface can carry third-order energies */
    double *weight;                  /* [n_patches] how often each counts; NULL: once */
    uint8_t *rule;                   /* [n_patches] 0 .. CO_FINEST_RULE */
    int32_t rules_version;           /* counts their changes */
    co_element_batches layout;       /* of these rules */
    co_element_batches finer;        /* of rules one step finer, values only; made when first needed */
    double *points;                  /* [3 n_points] */
    double *point_gradient;
    double *point_shares;          /* [6 n_points] the integrand's gradient and the area's, summed over patches */
    double radius;                 /* of the positions evaluated last */
    int32_t worst_face;            /* of them: the one with the least |S_u x S_v| */
    co_patch_terms *coarse, *fine; /* [n_patches] shares by the rules, and by those one step finer */
    co_patch_terms *finest;        /* [n_patches] and two steps finer, */
    uint8_t *looked;               /* [n_patches] where these were looked at */
    double *patch_error;           /* [n_patches] relative differences of these, */
    double *price;                 /* [n_patches] and by what a rule that mends them costs; */
    double *sorted;                /* [2 n_patches] work */
    double error;                  /* sum of patch_error when last resolved */
    double *work;                  /* [n_threads][work_stride] */
    size_t work_stride;
    co_work_sharing *deal; /* [n_threads] */
} co_assembly;

/* What an evaluation is asked for. */
typedef struct co_request {
    int is_normalized; /* positions have centroid 0 and radius 1 already, and are taken as they are; so is the gradient
                        */
    int all_terms;     /* third-order integrals are wanted even if the objective has none */
    double *gradient;  /* [3 n_cage] or NULL */
} co_request;

typedef struct co_values {
    double objective;
    double integral[CO_N_INTEGRALS];
    double radius; /* integrals of area are in its square */
    double min_jacobian;
    int32_t worst_face; /* cage face that has it */
} co_values;

/* options->surface is not AUTO. tables: of that surface, to be shared by several assemblies one after another, which
 * they must outlive; NULL: the assembly has its own and must then stay where it is in memory. face_weight [n_faces] or
 * NULL: how often each face's share counts. Faces of weight 0 are left out. With weights from a cage's symmetry
 * (dof_map.h) values are those of the whole; of gradients that is true of their symmetric part only. As
 * curvopt_problem_create. */
int32_t co_assembly_create(const curvopt_mesh *mesh, const curvopt_options *options, co_basis_table_cache *tables,
                           const double *face_weight, co_assembly *out, curvopt_error *error);
void co_assembly_free(co_assembly *assembly);

/* Takes over the rules of another assembly, of the same mesh, surface and weights. ERROR_MEMORY. */
int32_t co_assembly_copy_rules(co_assembly *assembly, const co_assembly *from, curvopt_error *error);
/* The same of rules [n_patches] that it has had itself. ERROR_MEMORY. */
int32_t co_assembly_take_rules(co_assembly *assembly, const uint8_t *rules, curvopt_error *error);

/* With face weights that leave faces out, positions of vertices that no patch is made of are not read, and their part
 * of a gradient is not written (`active`).
 *
 * Values at xyz [3 n_cage] by the present rules; the gradient is that of the normalized objective, so it has no
 * component along translations and scaling. Never fails; a surface that degenerates gives values that are not finite.
 */
void co_assembly_evaluate(co_assembly *assembly, const double *xyz, const co_request *request, co_values *out);

/* Sets assembly->points from xyz [3 n_cage]: the cage's, normalized unless they are so already, and what is derived
 * from them. Returns the radius that was divided by. */
double co_assembly_place(co_assembly *assembly, const double *xyz, int is_normalized);

/* Gradients [3 n_cage] of what an objective is made of: second + area * third. NULL: not wanted; `third` and `area`
 * only together. Where the objective has no such terms they are not written. */
typedef struct co_pieces {
    double *second, *third, *area;
} co_pieces;

/* Values at x [3 n_cage], normalized, and raw gradients: normalization is not differentiated. */
void co_assembly_pieces(co_assembly *assembly, const double *x, int all_terms, const co_pieces *gradients,
                        co_values *out);
/* What boundaries and creases turn (boundary_turning.h), of the positions that were evaluated last. */
double co_assembly_turning(const co_assembly *assembly);

/* How far total curvature is from what Gauss and Bonnet say, of the positions that were evaluated last. */
double co_assembly_defect(const co_assembly *assembly, const co_values *values);

/* The layout that goes with the present rules; empty on failure. ERROR_MEMORY. */
int32_t co_assembly_update_batches(co_assembly *assembly, curvopt_error *error);
/* Values by another layout of the assembly's patches, at the positions that were evaluated last. ERROR_MEMORY. */
int32_t co_assembly_evaluate_layout(co_assembly *assembly, const co_element_batches *layout, int third, co_values *out,
                                    curvopt_error *error);

#endif
