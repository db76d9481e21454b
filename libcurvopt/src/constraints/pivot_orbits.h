/* Pivots that symmetries take to each other.
 *
 * A symmetry takes positions to positions where it takes vertices to vertices, and so dof_map.h needs that each value
 * has its pivot where the symmetry takes that of another one. Values are dealt with by orbits: one of each, the chief,
 * gets a pivot w, and its images get the images of w. A value v with a stabilizer S, as at a point on a mirror plane,
 * has no vertex alone that could give way; there the m vertices S w do together, and the position of each is
 *
 *     y_w = x_w - mean of x over S w + v .
 *
 * Their mean is v, symmetries take them to each other, and on a symmetric cage it is P y_w with the projector P onto
 * what S keeps. So what is held of v holds as much of each y_w as P leaves; where P leaves nothing, the symmetry holds
 * the value by itself.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_PIVOT_ORBITS_H
#define CO_CONSTRAINTS_PIVOT_ORBITS_H

#include "constraints/constraints.h"
#include "constraints/value_images.h"

typedef struct co_pivot_orbits {
    const curvopt_mesh *mesh;
    const co_symmetry *symmetry;
    co_value_images images;
    int32_t *chief;    /* [n] the value whose pivot decides that of value i */
    uint8_t *is_given; /* [n] whether the symmetry holds all that is held of a value, so that it needs no pivot */
    uint8_t *is_taken; /* [n_vertices] whether a vertex is a pivot */
    int32_t *set;      /* [order] work */
} co_pivot_orbits;

/* Of values with rows; root [n]: the least value of each one's group, images of which are groups. *fits: whether the
 * symmetry takes values to values. ERROR_MEMORY. */
int32_t co_pivot_orbits_create(const curvopt_mesh *mesh, const co_symmetry *symmetry, const co_surface_values *values,
                               const int32_t *root, co_pivot_orbits *out, int *fits, curvopt_error *error);
void co_pivot_orbits_free(co_pivot_orbits *orbits);

/* How many vertices a value's mean is of if vertex w is its pivot; 0: w cannot be, for a symmetry that leaves w where
 * it is moves the value. */
int32_t co_pivot_orbits_count(const co_pivot_orbits *orbits, int32_t value, int32_t w);
/* orbits->set becomes these vertices of the image of the value under element g, that of w first. Returns their
 * number. */
int32_t co_pivot_orbits_set(const co_pivot_orbits *orbits, int32_t value, int32_t w, int32_t g);
/* No value can have w or an image of it any more. */
void co_pivot_orbits_take(co_pivot_orbits *orbits, int32_t w);
/* Replaces constraints->values by what stands in the place of pivots, with rows, and enters constraints there.
 * pivot [n]: of chiefs. ERROR_MEMORY. */
int32_t co_pivot_orbits_enter(const co_pivot_orbits *orbits, const int32_t *pivot, co_constraints *constraints,
                              curvopt_error *error);

#endif
