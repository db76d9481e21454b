/* A surface in patches: their quadrature rules, and the points that they are made of.
 *
 * Everything inside works on normalized positions (centroid 0, root mean square radius 1), so that no input is too
 * large or too small and the energies' invariance under translation and scaling is exact.
 *
 *     xyz [3 n_cage] --normalize--> points [0 .. n_cage) --derive--> points [n_cage .. n_points)
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_ENERGY_ASSEMBLY_H
#define CO_ENERGY_ASSEMBLY_H

#include "base/thread_pool.h"
#include "base/tuning.h"
#include "base/work_sharing.h"
#include "energy/element_batches.h"
#include "energy/known_sums.h"
#include "energy/normalization.h"
#include "energy/quadrature_error.h"
#include "energy/spontaneous_curvature.h"
#include "surface/boundary_turning.h"
#include "surface/face_rule.h"
#include "surface/substitution.h"

/* The finest rule of a patch: there are finer ones to compare it with. */
enum { CO_FINEST_RULE = CO_LADDER_RULES - 2 };

typedef struct co_assembly {
    co_patches patches;
    co_basis_table_cache *cache;    /* tables in use: the caller's, or own_cache */
    co_basis_table_cache own_cache; /* tables of this assembly alone; empty where the caller has some */
    const co_element_kernel *kernel;
    const co_tuning *tuning; /* those of runs until replaced */
    co_cancel *cancel;       /* the cache's: ends evaluations, whose values are then NAN */
    co_functional functional;
    double weights[CURVOPT_N_TERMS];      /* the functional's */
    co_spontaneous_curvature spontaneous; /* what it adds is in every objective; lengths as they are until replaced */
    int32_t surface;                      /* curvopt_surface, not AUTO */
    co_boundary_turning turning;          /* boundaries and creases, for Gauss-Bonnet */
    co_thread_pool *threads;              /* the caller's, or own_threads */
    co_thread_pool *own_threads;          /* NULL where the caller has some */
    int32_t n_threads;                    /* size of the pool */
    int32_t *active;                      /* [n_active] points that patches are made of, ascending; NULL: all points */
    int32_t n_active;                     /* number of active points */
    int32_t n_active_cage;                /* number of active points that are vertices of the cage; they come first */
    int met;                              /* the tolerance has been met before */
    int third_allowed;                    /* the surface can carry third-order energies */
    int measures_volume;                  /* the volume is wanted in every evaluation */
    int is_closed;                        /* no boundary: the surface has a volume */
    double least_h2;                      /* int H^2 is no less; 0 where no bound is known: boundaries, creases */
    int leaves_out;                    /* faces of the surface are left out: Gauss and Bonnet say nothing of the rest */
    int32_t *isolated;                 /* [n_isolated] vertices that no face uses, ascending; NULL: none */
    int32_t n_isolated;                /* number of these */
    double *weight;                    /* [n_patches] factor of each patch's contribution; NULL: all are 1 */
    int8_t *rule;                      /* [n_patches] quadrature rule, up to CO_FINEST_RULE */
    int32_t coarsest;                  /* no patch's rule is below it: CO_ROUGH_RULE, else 0 */
    int32_t rules_version;             /* number of times that rules have changed */
    co_element_batches batches;        /* by the present rules */
    co_element_batches finer_batches;  /* by rules one step finer, for values only; made when first needed */
    co_element_batches finest_batches; /* by rules two steps finer, of estimates.in_finest; made when first needed */
    co_known_sums known;               /* of batches that were freed */
    double *points;                    /* [3 n_points] normalized positions, evaluated last */
    int64_t placement;                 /* 1, and one more with each change of points or of eps4 */
    double eps4;                       /* co_functional_eps4() of `points`: of radius 1 until replaced */
    double *point_gradient; /* [3 n_points] gradient with respect to derived points; the cage's part is unused */
    double *point_sums;     /* [n_points][2][3] gradients of the integrand and of the area */
    double radius;          /* root mean square radius of the positions evaluated last, before they were normalized */
    int32_t worst_face;     /* face with the least |S_u x S_v| at the positions evaluated last */
    co_quadrature_estimates estimates; /* errors of the rules */
    double *work;                      /* [n_threads][work_stride] work space of the kernels */
    size_t work_stride;                /* doubles that one thread needs */
    co_work_sharing *sharing;          /* [n_threads] */
} co_assembly;

/* Needs options->surface other than AUTO. xyz: as co_patches_create.
 * substitution: what stands in the place of vertices in all positions from then on; NULL: the vertices. `tables`: a
 * cache of that surface, which several assemblies may share one after another, and which they must not outlive; NULL:
 * the assembly has its own, and must then stay where it is in memory. Threads are those of the cache; where it has none
 * the assembly has options->threads of its own. face_weight [n_faces] or NULL: factor of each face's contribution;
 * faces of weight 0 are left out. With weights from a cage's symmetry (dof_map.h) values are those of the whole; of a
 * gradient, only the symmetric part is. Errors are those of curvopt_problem_create. */
int32_t co_assembly_create(const curvopt_mesh *mesh, const double *xyz, const co_substitution *substitution,
                           const curvopt_options *options, co_basis_table_cache *tables, const double *face_weight,
                           co_assembly *out, curvopt_error *error);
void co_assembly_free(co_assembly *assembly);

/* Patches may have rules down to this one, if their kind has it; those with the coarsest so far get the new one.
 * ERROR_MEMORY. */
int32_t co_assembly_set_coarsest(co_assembly *assembly, int32_t coarsest, curvopt_error *error);
/* Number of patches whose kind has CO_ROUGH_RULE. */
int32_t co_assembly_n_rough(const co_assembly *assembly);
/* The coarsest rule that patch p may have. */
int32_t co_assembly_coarsest_of(const co_assembly *assembly, int32_t p);

/* Takes over the rules of another assembly, of the same mesh, surface and weights, but none that is too coarse here.
 * ERROR_MEMORY. */
int32_t co_assembly_copy_rules(co_assembly *assembly, const co_assembly *from, curvopt_error *error);

/* Sets points [3 n_points] from normalized positions x [3 n_cage], as assembly->points; whether any of the cage's
 * changes. What is derived is as it was if none does. */
int co_assembly_place_normalized(const co_assembly *assembly, const double *x, double *points);
/* Sets assembly->points from xyz [3 n_cage]: the cage's, normalized unless they are so already, and what is derived
 * from them. Returns the radius that was divided by. While points stay what they are, values that were evaluated by the
 * present rules are not evaluated again (co_sums_of). */
double co_assembly_place(co_assembly *assembly, const double *xyz, int is_normalized);
/* Positions that are taken as they are belong to a cage of this root mean square radius; 1 until then. */
void co_assembly_take_radius(co_assembly *assembly, double radius);

/* What positions of this cage are normalized by. */
co_normalization co_assembly_normalization(const co_assembly *assembly);

/* Makes the batches of the present rules; they are empty on failure, and those of before if that is cancelled.
 * ERROR_MEMORY, CO_CANCELLED. */
int32_t co_assembly_update_batches(co_assembly *assembly, curvopt_error *error);
/* Work space of all threads becomes enough for these batches, too. ERROR_MEMORY. */
int32_t co_assembly_ensure_work(co_assembly *assembly, const co_element_batches *batches, curvopt_error *error);

#endif
