/* Vertices that a minimization does not move freely. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_CONSTRAINTS_CONSTRAINTS_H
#define CO_CONSTRAINTS_CONSTRAINTS_H

#include "constraints/chains.h"
#include "constraints/soft_constraints.h"
#include "constraints/surface_values.h"
#include "surface/vertex_mask.h"

/* What a level's position of a vertex is (interpolation.h). */
enum {
    CO_OF_VERTEX = 0,    /* the vertex */
    CO_OF_OWN_POINT = 1, /* its limit point, or where it is after the subdivisions that follow */
    CO_OF_POINT = 2,     /* a value whose pivot it is: a point of the limit surface, */
    CO_OF_TANGENT = 3    /* or a tangent or second derivative, which translations leave as it is */
};

/* A weight that somebody gives, or 1 where it is so near that its spring would be too stiff for doubles. */
static inline double co_constraint_weight(double given) {
    return given > 1 - 1e-9 && given < 1 ? 1 : given;
}

/* How each vertex may move. */
typedef struct co_constraints {
    uint8_t *freedom;  /* [n_vertices] dimensions in which a vertex may move (freedom.h); NULL: all are free */
    double *direction; /* [3 n_vertices] unit: along the line, or normal to the plane; else not read */
    double *anchor;    /* [3 n_vertices] where it is held, or a point of the line or plane, in the user's units */
    uint8_t
        *of_limit; /* [n_vertices] what is constrained: CO_OF_VERTEX, or something that is an unknown in its place */
    uint8_t *subdivisions;       /* [n_vertices] of what is CO_OF_OWN_POINT, after how many; 0: the limit point */
    co_soft_constraints springs; /* soft constraints, within what `freedom` leaves; none if freedom is NULL */
    co_surface_values values; /* other points of the surface, and derivatives; with pivots (pivots.h) their constraints
                                   are above, too */
    co_surface_values drawn;  /* those that springs draw, within what is held; none if freedom is NULL */
    co_chains chains;      /* what of them is held on this level is above, too: points of their vertices, and values */
    const double *tangent; /* [3 n_vertices] borrowed: unit tangents where vertices slide along their curve, else 0;
                              NULL: none does. For CO_MOTION_SLIDE */
    uint8_t *left_out; /* [n_faces] whether a face is left out of the energy; its vertices are held. NULL: none is */
} co_constraints;

/* Room for constraints where there is none yet: every vertex is free. On failure there are no constraints any more.
 * ERROR_MEMORY. */
int32_t co_constraints_allocate(int32_t n_vertices, co_constraints *constraints, curvopt_error *error);
/* Adds springs as co_soft_constraints_add_all. On failure there are no constraints any more. */
int32_t co_constraints_pull_back(const curvopt_mesh *mesh, const double *xyz, const double *stiffness, double reach,
                                 co_constraints *constraints, curvopt_error *error);
/* Faces that are left out of the energy, from face [n_faces]: those of 0 and more. ERROR_MEMORY. */
int32_t co_constraints_leave_out(const curvopt_mesh *mesh, const int32_t *face, co_constraints *constraints,
                                 curvopt_error *error);
/* Holds the limit points of the chains' vertices, and the middles of open ones' end edges; or draws them by springs.
 * ERROR_MEMORY. */
int32_t co_constraints_hold_chains(const curvopt_mesh *mesh, co_constraints *constraints, curvopt_error *error);
/* The faces alone that are left out. ERROR_MEMORY. */
int32_t co_constraints_copy_left_out(const curvopt_mesh *mesh, const co_constraints *from, co_constraints *to,
                                     curvopt_error *error);
/* But for the chains: the copy is for the same level. ERROR_MEMORY. */
int32_t co_constraints_copy(const curvopt_mesh *mesh, const co_constraints *from, co_constraints *to,
                            curvopt_error *error);
void co_constraints_free(co_constraints *constraints);

/* Whether a face that vertex v is in is constrained as a piece of surface. */
int co_constraints_are_of_face(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t v);
/* Visits the mask of the point of vertex v, of which CO_OF_OWN_POINT is (vertex_mask.h). */
void co_constraints_visit_own_point(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t v,
                                    co_vertex_mask_fn visit, void *context);
/* Moves x, where vertex v or its limit point is, to the closest point that the constraint there allows. */
void co_constraints_put_back(const co_constraints *constraints, int32_t v, double x[3]);

/* The faces alone that are left out: of `mesh` before, of the mesh that is once finer after. ERROR_MEMORY. */
int32_t co_constraints_subdivide_left_out(const curvopt_mesh *mesh, co_constraints *constraints, curvopt_error *error);
/* Takes constraints from a cage to its subdivision `fine` by `rows` (subdivide.h), at xyz [3 fine vertices].
 *
 * Where all vertices of a face have the same constraint, the face is constrained as a piece of surface: the vertices of
 * its children inherit the constraint, at the places where subdivision puts them. Any other constrained vertex keeps
 * its point, line or plane, and is put back there; the surface comes closer to it with every level. Constrained limit
 * points stay where they are: they are points of the same surface; so do vertices of finer cages (look_ahead.h), which
 * on the last of these are constrained themselves. What chains hold is made anew, at places where the surface at xyz
 * need not be yet. The children of faces that are left out are left out. ERROR_MEMORY. */
int32_t co_constraints_subdivide(const curvopt_mesh *mesh, const curvopt_mesh *fine, const co_sparse_rows *rows,
                                 double *xyz, co_constraints *constraints, curvopt_error *error);

/* Adds the constraints of `boundary` (curvopt_boundary).
 *
 * The limit of a boundary is a B-spline curve of the boundary's vertices. Of the surface's derivatives across it the
 * first depends on the next row of vertices too, and the second, 0 in the parameter across, on no more than that; a
 * third row determines how curvature changes. Subdivision keeps all this: the finer cage's rows determine the same
 * derivatives as the coarser one's did. Rows are counted by faces: all vertices of a face that touches the row before.
 * ERROR_MEMORY. */
int32_t co_constraints_boundary(const curvopt_mesh *mesh, int32_t boundary, co_constraints *constraints,
                                curvopt_error *error);
/* Sets mark [n_vertices] of the boundary's vertices and of the further rows that `boundary` holds. ERROR_MEMORY. */
int32_t co_constraints_mark_rows(const curvopt_mesh *mesh, int32_t boundary, uint8_t *mark, curvopt_error *error);

/* All constraints: a copy of `constraints`, with those of `boundary`; vertices that no face uses, and those of faces
 * that are left out, are held. ERROR_MEMORY. */
int32_t co_constraints_all(const curvopt_mesh *mesh, const co_constraints *constraints, int32_t boundary,
                           co_constraints *out, curvopt_error *error);
/* What is left of `all` for motion that changes the shape at xyz [3 n_vertices], and does not slide vertices in it: a
 * vertex moves along its normal, on a boundary or an infinitely sharp crease across the curve, at a corner of these
 * anywhere; where it is held on a line or in a plane, in the direction of these that is nearest to that, or not at all.
 * ERROR_MEMORY. */
int32_t co_constraints_to_normals(const curvopt_mesh *mesh, const co_constraints *all, const double *xyz,
                                  co_constraints *out, curvopt_error *error);

/* Whether constraints leave a cage its size: from some point it can be enlarged, and what is held, or drawn by springs,
 * stays where it is to be. With all of them (co_constraints_all), at xyz, where they hold; `radius`: of the input. */
int co_constraints_allow_dilation(const curvopt_mesh *mesh, const double *xyz, const co_constraints *all,
                                  double radius);
/* Whether a vertex may move. */
int co_constraints_allow_motion(const curvopt_mesh *mesh, const co_constraints *constraints);
/* ERROR_ARGUMENT: none may. */
int32_t co_constraints_refuse(const curvopt_mesh *mesh, curvopt_error *error);

#endif
