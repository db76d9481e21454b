/* curvopt.h - the fairest surface of a control cage.
 *
 * Catmull-Clark limit surfaces evaluated exactly to third derivatives, curvature energies integrated over
 * them with exact gradients, and minimized over the control cage, level by level.
 *
 * Conventions, for every function below:
 *   - Real numbers are `double`, indices and counts `int32_t`, in every build. Vectors of points are packed
 *     x y z, one point after the other; [n] after a pointer's name is the number of elements it must hold.
 *   - A fallible function returns a curvopt_status (0 is success) and, if `error` is not NULL, fills it. Nothing
 *     else is written on failure, except that `*out` becomes NULL.
 *   - The caller owns every array it passes and every handle it is given; each `_destroy` accepts NULL.
 *   - No global state, no output, no signal handlers. A curvopt_mesh never changes after its creation and may be
 *     used from several threads; every other handle from one thread at a time, curvopt_cancel excepted.
 *   - Energies are dimensionless and invariant under similarities, unless their line says otherwise.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#ifndef CURVOPT_H
#define CURVOPT_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define CURVOPT_API __attribute__((visibility("default")))
#else
#define CURVOPT_API
#endif

#define CURVOPT_VERSION_MAJOR 0
#define CURVOPT_VERSION_MINOR 1
#define CURVOPT_VERSION_PATCH 0

/* ------------------------------------------------------------------------------------------------ errors -- */

/* X(name, value, text): every status there is; curvopt_status_text() gives the text. */
#define CURVOPT_STATUS_LIST(X)                                                                                         \
    X(OK, 0, "done")                                                                                                   \
    X(ERROR_ARGUMENT, 1, "an argument is out of its range")                                                            \
    X(ERROR_MEMORY, 2, "out of memory")                                                                                \
    X(ERROR_SIZE, 3, "the input is larger than 32-bit indices allow")                                                  \
    X(ERROR_TOPOLOGY, 4, "the cage is not a manifold, consistently oriented surface")                                  \
    X(ERROR_GEOMETRY, 5, "the cage's coordinates do not make a surface")                                               \
    X(ERROR_SURFACE, 6, "the chosen surface cannot carry the chosen energy")                                           \
    X(ERROR_UNSUPPORTED, 7, "this build cannot do that")                                                               \
    X(ERROR_RESOLUTION, 8, "the energy of this surface cannot be resolved")

typedef enum curvopt_status {
#define CURVOPT_STATUS_ENUM(name, value, text) CURVOPT_##name = value,
    CURVOPT_STATUS_LIST(CURVOPT_STATUS_ENUM)
#undef CURVOPT_STATUS_ENUM
        CURVOPT_STATUS_FORCE_INT = 0x7fffffff
} curvopt_status;

/* What went wrong: `message` is one sentence that names the element and the value. */
typedef struct curvopt_error {
    int32_t code;      /* curvopt_status */
    int32_t element;   /* index of the offending vertex, face or field, or -1 */
    char message[248]; /* zero-terminated UTF-8 */
} curvopt_error;

/* The text of a status; never NULL, also for an unknown code. */
CURVOPT_API const char *curvopt_status_text(int32_t status);
/* "major.minor.patch" of the library that is loaded; compare with CURVOPT_VERSION_* of the header. */
CURVOPT_API const char *curvopt_version(void);

/* ------------------------------------------------------------------------------------------------- meshes -- */

/* A polygon cage's connectivity: immutable, shareable. */
typedef struct curvopt_mesh curvopt_mesh;

typedef struct curvopt_mesh_info {
    int32_t n_vertices;
    int32_t n_edges;
    int32_t n_faces;
    int32_t n_corners; /* sum of all face sizes */
    int32_t n_components;
    int32_t n_boundary_edges;
    int32_t n_extraordinary; /* interior vertices of valence other than 4 */
    int32_t max_valence;
    int32_t euler; /* V - E + F */
    int32_t all_quads;
} curvopt_mesh_info;

/* Checks polygons and builds their half-edges.
 *   face_sizes [n_faces]         corners of each face, >= 3
 *   face_vertices [sum of sizes] vertex indices, face after face, counter-clockwise seen from outside
 * ERROR_ARGUMENT (NULL, counts < 1), ERROR_SIZE, ERROR_TOPOLOGY (a face too small, an index out of range, a repeated
 * vertex, a non-manifold edge, flipped faces, an isolated vertex, a vertex joining two fans), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_mesh_create(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                                        const int32_t *face_vertices, curvopt_mesh **out, curvopt_error *error);

/* What becomes of a boundary vertex that belongs to one face. The names of Blender's modifier, and OpenSubdiv's: */
typedef enum curvopt_boundary_rule {
    CURVOPT_BOUNDARY_RULE_SMOOTH = 0, /* the boundary runs smoothly through it (ALL; EDGE_ONLY) */
    CURVOPT_BOUNDARY_RULE_CORNERS = 1 /* it stays where it is, a corner (PRESERVE_CORNERS; EDGE_AND_CORNER) */
} curvopt_boundary_rule;

/* From this sharpness on a crease never softens; below, each subdivision takes 1 off, as OpenSubdiv does. */
#define CURVOPT_SHARPNESS_INFINITE 10.0
#define CURVOPT_SHARPNESS_MAX      1000.0 /* larger ones are refused: a percentage or a length, most likely */

/* Sharp edges and vertices. Where one is named several times, the last time counts. */
typedef struct curvopt_creases {
    const int32_t *crease_vertices; /* [2 n_creases] both ends of an edge, in any order */
    const double *crease_sharpness; /* [n_creases] 0..CURVOPT_SHARPNESS_MAX */
    const int32_t *corner_vertices; /* [n_corners] */
    const double *corner_sharpness; /* [n_corners] 0..CURVOPT_SHARPNESS_MAX */
    int32_t n_creases;
    int32_t n_corners;
    int32_t boundary_rule; /* curvopt_boundary_rule */
    int32_t reserved;      /* 0 */
} curvopt_creases;

/* As curvopt_mesh_create, with creases; NULL is no creases and the rule SMOOTH. Besides its errors, ERROR_ARGUMENT: an
 * array NULL, a negative count, a sharpness out of range or NAN, a vertex that does not exist, a crease that is no edge
 * of the cage (`element` is its index). */
CURVOPT_API int32_t curvopt_mesh_create_creased(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                                                const int32_t *face_vertices, const curvopt_creases *creases,
                                                curvopt_mesh **out, curvopt_error *error);
CURVOPT_API void curvopt_mesh_destroy(curvopt_mesh *mesh);
CURVOPT_API void curvopt_mesh_get_info(const curvopt_mesh *mesh, curvopt_mesh_info *info);
/* Copies the polygons out: face_sizes [n_faces], face_vertices [n_corners]. */
CURVOPT_API void curvopt_mesh_get_faces(const curvopt_mesh *mesh, int32_t *face_sizes, int32_t *face_vertices);
/* Sharp edges and vertices that the mesh has, counted and copied out; none of sharpness 0. A subdivided mesh has those
 * of its cage, one softer. Corners kept by the rule CORNERS are among them, infinitely sharp, so that what is copied
 * out means the same surface under either rule. crease_vertices [2 n_creases], crease_sharpness [n_creases],
 * corner_vertices [n_corners], corner_sharpness [n_corners] */
CURVOPT_API void curvopt_mesh_count_creases(const curvopt_mesh *mesh, int32_t *n_creases, int32_t *n_corners);
CURVOPT_API void curvopt_mesh_get_creases(const curvopt_mesh *mesh, int32_t *crease_vertices, double *crease_sharpness,
                                          int32_t *corner_vertices, double *corner_sharpness);

/* One Catmull-Clark subdivision. Vertices of the result: the cage's vertices, then its edges, then its faces
 * (n_vertices + n_edges + n_faces of them); child k of a face starts at the face's corner k. Creases go with it.
 *   xyz [3 n_vertices], fine_xyz [3 (n_vertices + n_edges + n_faces)]: both NULL for connectivity alone. */
CURVOPT_API int32_t curvopt_mesh_refine(const curvopt_mesh *mesh, const double *xyz, curvopt_mesh **out,
                                        double *fine_xyz, curvopt_error *error);

/* ------------------------------------------------------------------------------------------------ options -- */

/* The surface that a cage stands for. */
typedef enum curvopt_surface {
    CURVOPT_SURFACE_AUTO = 0,      /* limit where every term accepts it, else the smoothest the build has */
    CURVOPT_SURFACE_LIMIT = 1,     /* the Catmull-Clark limit surface itself */
    CURVOPT_SURFACE_PLANE = 2,     /* blended into the tangent plane at extraordinary vertices (the report's) */
    CURVOPT_SURFACE_POLYNOMIAL = 3 /* blended into a fitted polynomial there, widely where there is room */
} curvopt_surface;

/* The terms of the objective, which is sum of weights[i] * term i. With A the area, k1, k2 the principal curvatures,
 * e1, e2 their directions, and C = grad h the covariant derivative of the second fundamental form: */
typedef enum curvopt_term {
    CURVOPT_TERM_WILLMORE = 0,      /* int (k1^2 + k2^2) dA */
    CURVOPT_TERM_MVS = 1,           /* A int ((dk1/de1)^2 + (dk2/de2)^2) dA */
    CURVOPT_TERM_MVS_CROSS = 2,     /* A int (|grad k1|^2 + |grad k2|^2) dA */
    CURVOPT_TERM_VARIATION = 3,     /* A int |grad h|^2 dA */
    CURVOPT_TERM_MEHLUM_TARROU = 4, /* A int (1/pi) int_0^{2 pi} kappa'(theta)^2 dtheta dA */
    CURVOPT_TERM_AREA = 5,          /* A / (root mean square distance of the cage's vertices from their centroid)^2 */
    CURVOPT_TERM_MEAN = 6,          /* int H^2 dA, H = (k1 + k2) / 2; a quarter of Willmore's and a constant on closed
                                       surfaces, but 0 on open ones that are minimal */
    CURVOPT_N_TERMS = 7
} curvopt_term;

typedef enum curvopt_method {
    CURVOPT_METHOD_AUTO = 0,        /* gauss_newton; the report's with as_report */
    CURVOPT_METHOD_LMVM = 1,        /* limited-memory variable metric on all coordinates, the report's: symmetries
                                       are kept only where that is asked for */
    CURVOPT_METHOD_GAUSS_NEWTON = 2 /* the same, with the factored Gauss-Newton matrix as its initial Hessian; then
                                       Newton's method, of second-order energies at the last level only */
} curvopt_method;

/* What a minimization leaves as it is on an open surface. Vertices on infinitely sharp creases, and infinitely sharp
 * ones, stay where they are with all of these but FREE. */
typedef enum curvopt_boundary {
    CURVOPT_BOUNDARY_POSITION = 0,  /* the boundary curves: vertices on them are held */
    CURVOPT_BOUNDARY_TANGENT = 1,   /* the surface's tangent planes along them, too: two rows of vertices are held. On
                                       Catmull-Clark surfaces curvature there depends on no more than that */
    CURVOPT_BOUNDARY_CURVATURE = 2, /* how curvature changes there, too: three rows */
    CURVOPT_BOUNDARY_FREE = 3       /* nothing */
} curvopt_boundary;

/* Whether a cage's symmetries are kept. */
typedef enum curvopt_symmetry {
    /* KEEP, but where the objective has third-order terms, whose discretization on coarse cages is often a saddle that
     * symmetry hides (the cage's lines want to twist): there, on levels of 100 to 2000 vertices, symmetries are given
     * up as long as each halving of their number brings 6 % of the energy. NONE with CURVOPT_METHOD_LMVM */
    CURVOPT_SYMMETRY_AUTO = 0,
    CURVOPT_SYMMETRY_NONE = 1,
    CURVOPT_SYMMETRY_ROTATIONS =
        2,                      /* of KEEP's, the ones that mirror nothing: vertices on a mirror plane may leave it */
    CURVOPT_SYMMETRY_KEEP = 3,  /* those that the input cage has, to 1e-5 of its size, with its creases and
                                   constraints: the result has them to rounding, and one of several like faces
                                   stands for all */
    CURVOPT_SYMMETRY_PLANES = 4 /* mirror images across the planes of options.symmetry_planes and what these generate,
                                   no others; a cage that does not have them is refused. They are not given up */
} curvopt_symmetry;

/* Mirror planes across the axes; each through the mean of the cage's vertices, for symmetric about another it cannot
 * be. */
typedef enum curvopt_plane { CURVOPT_PLANE_X = 1, CURVOPT_PLANE_Y = 2, CURVOPT_PLANE_Z = 4 } curvopt_plane;

/* Vertices that may not move freely; the arrays are the caller's. A subdivision moves vertices; then those that are
 * held go back to their point, line or plane, so that the surface comes closer to them with every level. But where all
 * vertices of a face have the same constraint, the face is held as a piece of surface: its children inherit the
 * constraint and are where subdivision puts them.
 *
 * With a weight w between 0 and 1 a vertex is drawn to its point, line or plane by a spring, whose energy is added to
 * the objective: w / (1 - w) times the square of the distance over the input's size, times half of how stiff a sphere
 * is to the objective (for Willmore 24 pi). So it depends on neither scale nor levels; and a connected patch of
 * vertices with weights counts as one spring, however many they are. Where vertices have springs, centroid, orientation
 * and size are not held otherwise. Decrements and verdicts are of the sum, all energies that are reported are the
 * surface's. */
typedef struct curvopt_constraints {
    const int32_t *vertices;  /* [n] none twice, unless it says the same */
    const int32_t *freedom;   /* [n] dimensions: 0 held, 1 moves along its direction, 2 across it; NULL: all 0 */
    const double *directions; /* [3 n] of any length; not looked at where the freedom is 0; NULL if it is everywhere */
    int32_t n;
    int32_t reserved;
    const double *weights; /* [n] how firmly: 0 not at all to 1 exactly; NULL: all 1 */
} curvopt_constraints;

/* Fill with curvopt_options_init(), then change what you want. */
typedef struct curvopt_options {
    int32_t struct_size;    /* sizeof(curvopt_options) of the caller's header, set by the init */
    int32_t surface;        /* curvopt_surface; default AUTO */
    int32_t method;         /* curvopt_method; default AUTO */
    int32_t levels;         /* optimizations, levels - 1 subdivisions between them; 1..12, default 4 */
    int32_t max_iterations; /* per level; >= 0, default 3000 */
    int32_t threads;        /* 0: all cores; default 0 */
    int32_t as_report;      /* 1: as the report: where they are AUTO, its surface (`plane` for third-order terms) and
                               method, and a fixed quadrature rule that nothing checks; default 0 */
    int32_t boundary;       /* curvopt_boundary; default POSITION */
    double weights[8];      /* by curvopt_term, >= 0, not all 0; entries from CURVOPT_N_TERMS on must be 0;
                               default Willmore 1, the others 0 */
    double tolerance;       /* relative quadrature error wanted; 1e-12..0.5, default 1e-4 */
    double
        gradient_tolerance; /* a level has converged when |gradient| * size < this * energy; 1e-15..1, default 1e-6 */
    double decrement_tolerance; /* the last level has converged when the quadratic model predicts less than this *
                                   energy to gain; coarser levels when it is less than the larger of this and 1e-5;
                                   1e-15..1, default 2e-7. Not for CURVOPT_METHOD_LMVM, which has no model */
    double max_step;            /* longest step of a vertex, in mean edge lengths; default 0.5 */
    const curvopt_constraints *constraints; /* for curvopt_minimize(); NULL, the default: none */
    int32_t symmetry;                       /* curvopt_symmetry; default AUTO; as_report keeps none */
    int32_t verify;                         /* 1: the result is also looked at without its symmetries, and by a Hessian
                                               from finite differences; takes longer than the run may; default 0 */
    int32_t escape;                         /* 1: a level of at most 5000 vertices whose shape is a saddle (verdict, all
                                               symmetries disregarded) is left along the saddle's negative direction
                                               and solved again, with as much symmetry as that has; default 0 */
    int32_t symmetry_planes;                /* with PLANES, a sum of curvopt_plane; else 0, the default */
    int32_t blend_width; /* `polynomial`: over how many faces of each sector at an extraordinary vertex
                            blends may reach; they take a quarter of the way to the next vertex that
                            is not regular. 1..8, default 8; 1 for parts (curvopt_experimental.h) */
    int32_t reserved;    /* must be 0 */
} curvopt_options;

CURVOPT_API void curvopt_options_init(curvopt_options *options);
/* OK, or ERROR_ARGUMENT with a message that names the field and its value. */
CURVOPT_API int32_t curvopt_options_validate(const curvopt_options *options, curvopt_error *error);

/* ----------------------------------------------------------------------------------------------- energies -- */

/* What an evaluation found. NAN stands for an energy that the surface cannot give (third order on `limit` with an
 * extraordinary vertex). */
typedef struct curvopt_energies {
    double objective;           /* weighted sum of terms, as the options say */
    double area;                /* in squared units of the cage */
    double term[8];             /* every term by curvopt_term, whatever its weight */
    double h2;                  /* int H^2 dA, H = (k1 + k2) / 2 */
    double gauss;               /* int K dA */
    double gauss_bonnet_defect; /* 0 for a resolved surface: |int K dA - 2 pi chi|; boundaries and infinitely sharp
                                   creases cut it, and their geodesic curvature and corner angles count */
    double objective_error;     /* estimated |objective - exact integral|, as the next two: from finer rules */
    double area_error;          /* in squared units of the cage */
    double term_error[8];       /* by curvopt_term */
    double min_jacobian;        /* least |S_u x S_v| over its face's mean; near 0 the surface folds or pinches */
    int32_t surface;            /* curvopt_surface that was used, never AUTO */
    int32_t n_samples;          /* quadrature points */
} curvopt_energies;

/* A cage's connectivity made ready for evaluation with some options; reusable for any positions. */
typedef struct curvopt_problem curvopt_problem;

/* ERROR_ARGUMENT, ERROR_TOPOLOGY (vertices of 16383 faces), ERROR_UNSUPPORTED, ERROR_MEMORY, and ERROR_SURFACE where
 * the surface has no finite energy: third order on `limit` at extraordinary vertices, and on every surface at those on
 * boundaries and infinitely sharp creases; any curvature where the Catmull-Clark rules leave no tangent plane: a vertex
 * of one face that boundary or crease run smoothly through, one of more than three faces on a side of them, a corner of
 * more than one face, an infinitely sharp vertex inside a smooth surface (`element` is the vertex).
 * Keeps its own copy of the connectivity. */
CURVOPT_API int32_t curvopt_problem_create(const curvopt_mesh *mesh, const curvopt_options *options,
                                           curvopt_problem **out, curvopt_error *error);
CURVOPT_API void curvopt_problem_destroy(curvopt_problem *problem);
/* Energies at xyz [3 n_vertices]; the objective's exact gradient into gradient [3 n_vertices] unless it is NULL.
 * Quadrature is refined until every term meets options.tolerance, and not made coarser again for the next positions (so
 * that differences of nearby energies are smooth). ERROR_ARGUMENT, ERROR_GEOMETRY (not finite, zero area),
 * ERROR_RESOLUTION (folded flat), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_problem_evaluate(curvopt_problem *problem, const double *xyz, curvopt_energies *out,
                                             double *gradient, curvopt_error *error);

/* Points of the surface and their derivatives.
 * face [n], corner [n], uv [2 n]: where. On a face with four corners only corner 0, u towards corner 1 and v towards
 * corner 3, both in 0..1 over the face; on a face with another number the quarter at that corner, u towards the middle
 * of the edge to the next corner, v of the edge to the one before. jets [30 n]: S, S_u, S_v, S_uu, S_uv, S_vv, S_uuu,
 * S_uuv, S_uvv, S_vvv of each point.
 *
 * `surface` is not AUTO. Exactly at an extraordinary vertex derivatives do not exist: NAN.
 *
 * ERROR_ARGUMENT, ERROR_TOPOLOGY, ERROR_GEOMETRY, ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_surface_jets(const curvopt_mesh *mesh, const double *xyz, int32_t surface, int32_t n,
                                         const int32_t *face, const int32_t *corner, const double *uv, double *jets,
                                         curvopt_error *error);

/* --------------------------------------------------------------------------------------------- minimizing -- */

/* Why a run or a level stopped; none of these is an error, all return the best iterate. */
typedef enum curvopt_stop {
    CURVOPT_STOP_CONVERGED = 0,  /* the gradient is below its tolerance, or what is left to gain */
    CURVOPT_STOP_STALLED = 1,    /* no further decrease is possible in floating point */
    CURVOPT_STOP_LIMIT = 2,      /* max_iterations */
    CURVOPT_STOP_CANCELLED = 3,  /* by the callback or curvopt_cancel_request */
    CURVOPT_STOP_UNRESOLVED = 4, /* the surface develops features that the finest quadrature cannot resolve */
    CURVOPT_STOP_SETTLED = 5     /* it still falls, but by less than 5e-6 in 15 steps (1e-3 before the last level);
                                    gauss_newton only */
} curvopt_stop;
/* "converged", "stalled", "limit", "cancelled", "unresolved", "settled"; never NULL. */
CURVOPT_API const char *curvopt_stop_text(int32_t stop);

/* The method that made a step. */
typedef enum curvopt_step {
    CURVOPT_STEP_NONE = 0,  /* no step: the start of a level */
    CURVOPT_STEP_LBFGS = 1, /* limited-memory BFGS with a line search */
    CURVOPT_STEP_NEWTON = 2 /* Newton's method with a shifted Hessian */
} curvopt_step;

/* The record of one iteration. The callback gets it at the start of every level (iteration 0) and after every accepted
 * step. Its pointers are valid during the call only. A number that is not known is NAN. */
typedef struct curvopt_progress {
    int32_t struct_size;      /* sizeof(curvopt_progress) of the library: members beyond it are absent */
    int32_t level;            /* 1 .. levels */
    int32_t levels;           /* as in the options */
    int32_t iteration;        /* accepted steps within the level */
    int32_t evaluations;      /* of the objective, within the level */
    int32_t n_vertices;       /* of the current cage */
    int32_t samples;          /* quadrature points of the present rules */
    int32_t method;           /* curvopt_step: the method that made the step */
    int32_t rejected;         /* steps taken back within the level so far */
    int32_t reserved;         /* 0 */
    const double *xyz;        /* [3 n_vertices] the current cage; cancelling now returns it */
    const curvopt_mesh *mesh; /* its connectivity */
    double energy;            /* objective now */
    double start_energy;      /* objective of the input cage */
    double gradient_norm;     /* |gradient| * size / energy, dimensionless */
    double seconds;           /* since the start of the run */
    double decrement;  /* decrease of the objective that the quadratic model predicted for the step; NAN without a
                          step */
    double shift;      /* multiple of the identity that was added to the Hessian for the step, in the objective's
                          units at root mean square radius 1; NAN for steps without a Hessian */
    double gain_ratio; /* actual decrease over predicted decrease of the step; NAN without a step */
    double step;       /* longest displacement of a vertex in the step, in mean edge lengths of the cage; NAN
                          without a step */
} curvopt_progress;

/* Called on the thread that called curvopt_minimize. Nonzero cancels. */
typedef int32_t (*curvopt_progress_fn)(const curvopt_progress *progress, void *user);

/* A flag that any thread may raise to stop a run. */
typedef struct curvopt_cancel curvopt_cancel;
CURVOPT_API int32_t curvopt_cancel_create(curvopt_cancel **out, curvopt_error *error);
CURVOPT_API void curvopt_cancel_request(curvopt_cancel *cancel);
CURVOPT_API void curvopt_cancel_destroy(curvopt_cancel *cancel);

typedef struct curvopt_result curvopt_result;

typedef struct curvopt_level_report {
    double energy;        /* objective at the end of the level */
    double gradient_norm; /* as in curvopt_progress */
    double seconds;
    int32_t level; /* 1 .. */
    int32_t n_vertices;
    int32_t iterations;
    int32_t evaluations;
    int32_t stop; /* curvopt_stop */
    int32_t reserved;
} curvopt_level_report;

/* What the Hessian at the result says of it. */
typedef enum curvopt_verdict {
    CURVOPT_VERDICT_UNKNOWN = 0,        /* not looked at: as_report, cancelled, too many vertices */
    CURVOPT_VERDICT_MINIMUM = 1,        /* stationary, and no small change of shape that keeps symmetries goes down */
    CURVOPT_VERDICT_SADDLE = 2,         /* stationary, with negative directions */
    CURVOPT_VERDICT_NOT_STATIONARY = 3, /* a Newton decrement is above 1e-6 of the objective */
    CURVOPT_VERDICT_FORCE_INT = 0x7fffffff
} curvopt_verdict;
/* "unknown", "minimum", "saddle", "not stationary"; never NULL. */
CURVOPT_API const char *curvopt_verdict_text(int32_t verdict);

typedef struct curvopt_summary {
    curvopt_energies start; /* of the input cage */
    curvopt_energies end;   /* of the result */
    double seconds;
    double newton_decrement; /* half of gradient . Hessian^-1 gradient: what is left to gain; by the Gauss-Newton matrix
                                where the Hessian has negative directions; NAN if unknown. Either is shifted by a tenth
                                of the objective by the number of vertices, at radius 1: softer than that is not told
                                from flat */
    double shape_decrement;  /* the same for motion along the cage's normals alone; NAN if the Hessian has negative
                                directions there, or if unknown */
    int32_t n_levels;        /* levels that were worked on, the last one perhaps not to its end */
    int32_t stop;            /* curvopt_stop of the last of them */
    int32_t n_vertices;
    int32_t n_faces;
    int32_t method;              /* curvopt_method that was used, never AUTO */
    int32_t verdict;             /* curvopt_verdict */
    int32_t negative_directions; /* of the Hessian for motion along the cage's normals, symmetries kept, beyond the
                                    invariances (similarities; for Willmore alone Moebius maps). Sliding within the
                                    surface does not change the shape. -1: not counted, or unknown */
    int32_t symmetry_order;      /* symmetries that were kept; 1: none */
    /* with options.verify, else NAN and -1: */
    double difference_decrement;      /* shape_decrement by a Hessian from finite differences of the gradient, as the
                                         report checked its minima */
    int32_t all_negative_directions;  /* over everything that may move, sliding too, no symmetry kept */
    int32_t free_negative_directions; /* of motion along normals, no symmetry kept */
} curvopt_summary;

/* Minimizes the objective over all vertices of the cage, refines, repeats. Centroid, orientation and size are held,
 * unless options.boundary holds vertices: then these stay exactly where they are, and their limit curves.
 *   progress, user, cancel may be NULL.
 * Errors as curvopt_problem_create and _evaluate; ERROR_GEOMETRY for a cage that is not symmetric about a plane of
 * options.symmetry_planes (`element` is the first vertex without a partner, or face). A cancelled or stalled run is OK
 * and has a result. */
CURVOPT_API int32_t curvopt_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                     curvopt_progress_fn progress, void *user, const curvopt_cancel *cancel,
                                     curvopt_result **out, curvopt_error *error);
CURVOPT_API void curvopt_result_destroy(curvopt_result *result);
/* The optimized cage's connectivity, owned by the result, alive as long as it. */
CURVOPT_API const curvopt_mesh *curvopt_result_mesh(const curvopt_result *result);
/* Copies its positions into xyz [3 n_vertices]. */
CURVOPT_API void curvopt_result_get_positions(const curvopt_result *result, double *xyz);
CURVOPT_API void curvopt_result_get_summary(const curvopt_result *result, curvopt_summary *summary);
/* Report of level index 0 .. n_levels - 1; ERROR_ARGUMENT outside. */
CURVOPT_API int32_t curvopt_result_get_level(const curvopt_result *result, int32_t index, curvopt_level_report *report,
                                             curvopt_error *error);

#ifdef __cplusplus
}
#endif
#endif
