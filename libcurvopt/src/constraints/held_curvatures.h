/* Curvatures of the surface at points, held by its tangents and second derivatives there.
 *
 * The second form is -n . S_uu = A(S_u, S_u), and so on, with the normal n of the faces' side and the tensor A that the
 * surface is to have, positive where it bends away from n. It is linear in the cage where tangents are fixed vectors:
 * each entry with curvatures holds tangents, and its second derivatives in planes across n. Finer levels have the same
 * curvatures, for S_u is half of what it was on the level before, and S_uu a quarter (surface_values.h). Beside normal
 * and curvatures that holds four numbers, of the parameters at the point and not of the shape: which tangents is chosen
 * by how far vertices move, here, and by the minimum without curvatures (solve/tangent_choice.h).
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_HELD_CURVATURES_H
#define CO_CONSTRAINTS_HELD_CURVATURES_H

#include "constraints/surface_values.h"

/* Whether there are entries with curvatures. */
int co_held_curvatures_exist(const co_surface_values *values);
/* Holds of these entries no more than points, normals and directions of tangents. */
void co_held_curvatures_release(co_surface_values *values);
/* Fixes their tangents near those of the cage at xyz [3 n_vertices], where normals are what they are to be, and by them
 * second derivatives. Makes the rows. ERROR_ARGUMENT, the element the entry's number, where tangents span no plane; as
 * co_surface_values_make_rows. */
int32_t co_held_curvatures_fix(const curvopt_mesh *mesh, const double *xyz, co_surface_values *values,
                               curvopt_error *error);

#endif
