/* curvopt.h - fair surfaces from control cages.
 *
 * The library evaluates Catmull-Clark limit surfaces exactly up to third derivatives. It integrates curvature energies
 * over them, with exact gradients, and minimizes these energies over the vertices of the control cage, level by level.
 *
 * The energies and the idea are those of Pushkar Joshi, "Minimizers of Curvature-Based Surface Energy", project report,
 * University of California, Berkeley, May 2006
 * (https://people.eecs.berkeley.edu/~sequin/CS285/PROJ_06/Pushkar/ppj_report.pdf), published as Pushkar Joshi and Carlo
 * Sequin, "Energy Minimizers for Curvature-Based Surface Functionals", Computer-Aided Design and Applications 4, 2007
 * (http://graphics.berkeley.edu/papers/Joshi-EMC-2007-06/). "The report" below means the first of them.
 *
 * Conventions, for every function below:
 *   - Real numbers are `double`, indices and counts `int32_t`, in every build. Vectors of points are packed x y z, one
 *     point after the other. [n] after a pointer's name is the number of elements that it must hold.
 *   - A fallible function returns a curvopt_status (0 is success) and fills `error` unless that is NULL. On failure it
 *     writes nothing else, except that `*out` becomes NULL.
 *   - The caller owns every array that it passes and every handle that it gets. Each `_destroy` accepts NULL.
 *   - A fallible function refuses NULL handles and arrays with ERROR_ARGUMENT, unless its comment allows them. The
 *     other functions (_get_..., _count_..., curvopt_cancel_request, curvopt_result_mesh) must not get NULL.
 *   - The `element` of an error is the vertex, face or field that its function's comment names, else -1.
 *   - Energies are dimensionless and invariant under similarities, unless their comment says otherwise.
 *
 * Threads. The library keeps no state between calls, writes no output and installs no signal handlers. A curvopt_mesh
 * never changes after its creation, and several threads may use it at once. Every other handle belongs to one thread at
 * a time; curvopt_cancel_request alone may come from any thread. Several threads may run curvopt_minimize at once.
 *
 * A problem and a run have threads of their own (curvopt_options.threads), which sleep while they have nothing to do
 * and are joined before curvopt_problem_destroy and curvopt_minimize return. After that the library can be unloaded.
 * Callbacks are called on the calling thread. Where the system gives fewer threads, the work is done by those. No
 * environment variable is read. In a child process after fork() handles of the parent must not be used.
 *
 * Determinism. The same call gives the same bits, with any number of threads and on every processor: products are
 * rounded before they are added, sums have one order, and the BLAS is the library's own. That is tested on Linux with
 * AVX-512, AVX2 and neither, on Windows and on arm64. A library that takes CHOLMOD and the BLAS from the system
 * (Debian's package) has other last digits; there energies of given positions agree to rounding, while a run may take
 * other steps and end in another minimum. Libraries for macOS have not been run.
 *
 * Structs grow at their end. A caller that was compiled with an older or a newer header works with this library:
 *   - curvopt_options begins with struct_size. Members beyond it have their defaults. A caller's struct may be larger
 *     than the library's if all bytes beyond are 0; else the call is refused: the library does not know the option.
 *   - A function that fills in a struct takes the caller's sizeof as `size`. It writes the members that fit, and 0 into
 *     bytes that it does not know.
 *   - curvopt_progress begins with struct_size, the library's: members beyond it are not there.
 *   - curvopt_error and curvopt_creases never change. curvopt_constraints says by has_places whether places is there.
 *   - curvopt_through begins with struct_size, the caller's: members beyond it are 0, and a larger one is refused.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#ifndef CURVOPT_H
#define CURVOPT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32) && defined(CURVOPT_EXPORTS)
#define CURVOPT_API __declspec(dllexport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define CURVOPT_API __attribute__((visibility("default")))
#else
#define CURVOPT_API
#endif

#define CURVOPT_VERSION_MAJOR 0
#define CURVOPT_VERSION_MINOR 1
#define CURVOPT_VERSION_PATCH 0

/* ------------------------------------------------------------------------------------------------ limits -- */

#define CURVOPT_MAX_TERMS       8  /* room for terms in weights and energies; CURVOPT_N_TERMS of them exist */
#define CURVOPT_MAX_LEVELS      12 /* options.levels */
#define CURVOPT_MAX_BLEND_WIDTH 8  /* options.blend_width, in faces */
/* Free variables up to which negative directions of a Hessian are counted; with more, the count is -1. */
#define CURVOPT_MAX_COUNTED_VARIABLES 15000
/* Largest of options.weights; a gradient could not be held in doubles far beyond it. */
#define CURVOPT_WEIGHT_MAX 1e100
/* Vertices up to which a result gets a verdict; with more, it is UNKNOWN. */
#define CURVOPT_MAX_CERTIFIED_VERTICES 50000
/* Mean edges by which a result's vertices are moved, as far as curvopt_summary.touch_rise says what that does. */
#define CURVOPT_TOUCH 1e-3
/* Vertices up to which options.escape leaves a saddle. */
#define CURVOPT_MAX_ESCAPE_VERTICES 5000
/* Symmetries of a cage up to which its group is kept; of a larger group none is. */
#define CURVOPT_MAX_SYMMETRIES 512

/* ------------------------------------------------------------------------------------------- enumerations -- */

/* Each enumeration is a list X(NAME, value, "name"). For each, curvopt_..._name() gives the name of a value, or NULL
 * for an unknown one; curvopt_..._from_name() gives the value of a name, or -1 for an unknown one and for NULL. The
 * values of an enumeration follow each other from 0, except curvopt_plane's. */
#define CURVOPT_ENUMERATOR(prefix, name, value) CURVOPT_##prefix##_##name = value,

/* ------------------------------------------------------------------------------------------------ errors -- */

/* X(name, value, short name, text); curvopt_status_text() gives the text. */
#define CURVOPT_STATUS_LIST(X)                                                                                         \
    X(OK, 0, "ok", "done")                                                                                             \
    X(ERROR_ARGUMENT, 1, "argument", "an argument is out of its range")                                                \
    X(ERROR_MEMORY, 2, "memory", "out of memory")                                                                      \
    X(ERROR_SIZE, 3, "size", "the input is larger than 32-bit indices allow")                                          \
    X(ERROR_TOPOLOGY, 4, "topology", "the cage is not a manifold, consistently oriented surface")                      \
    X(ERROR_GEOMETRY, 5, "geometry", "the cage's coordinates do not make a surface")                                   \
    X(ERROR_SURFACE, 6, "surface", "the chosen surface cannot carry the chosen energy")                                \
    X(ERROR_UNSUPPORTED, 7, "unsupported", "this build cannot do that")                                                \
    X(ERROR_RESOLUTION, 8, "resolution", "the energy of this surface cannot be resolved")                              \
    X(ERROR_CANCELLED, 9, "cancelled", "it was cancelled")

typedef enum curvopt_status {
#define CURVOPT_STATUS_ENUM(name, value, short_name, text) CURVOPT_##name = value,
    CURVOPT_STATUS_LIST(CURVOPT_STATUS_ENUM)
#undef CURVOPT_STATUS_ENUM
        CURVOPT_STATUS_FORCE_INT = 0x7fffffff
} curvopt_status;

/* The reason of a failure: `message` is one sentence that names the element and the value. */
typedef struct curvopt_error {
    int32_t code;      /* curvopt_status */
    int32_t element;   /* index of the offending vertex, face or field, or -1 */
    char message[248]; /* zero-terminated UTF-8 */
} curvopt_error;

/* The text of a status; never NULL, also for an unknown code. */
CURVOPT_API const char *curvopt_status_text(int32_t status);
CURVOPT_API const char *curvopt_status_name(int32_t status);
CURVOPT_API int32_t curvopt_status_from_name(const char *name);
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
    int32_t euler; /* V - E + F, isolated vertices not counted */
    int32_t all_quads;
    int32_t n_isolated;     /* vertices that no face uses */
    int32_t n_flawed_edges; /* edges of three or more faces, and of two that run the same way over it */
} curvopt_mesh_info;

/* Checks polygons and builds their half-edges.
 *   face_sizes [n_faces]         corners of each face, >= 3
 *   face_vertices [sum of sizes] vertex indices, face after face, counter-clockwise seen from outside
 * The cage need not be a manifold: where it is none, its surface is OpenSubdiv's, with infinitely sharp edges and
 * vertices that stay, and it is held as it is (curvopt_exception).
 * ERROR_ARGUMENT (NULL, counts < 1), ERROR_SIZE, ERROR_TOPOLOGY (a face of fewer than three corners, an index out of
 * range, a vertex twice in a face; `element` is the face), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_mesh_create(int32_t n_vertices, int32_t n_faces, const int32_t *face_sizes,
                                        const int32_t *face_vertices, curvopt_mesh **out, curvopt_error *error);

/* The rule for a boundary vertex that belongs to one face.
 *   SMOOTH   the boundary runs smoothly through it (Blender's modifier: ALL; OpenSubdiv: EDGE_ONLY)
 *   CORNERS  it is a corner and stays where it is (PRESERVE_CORNERS; EDGE_AND_CORNER) */
#define CURVOPT_BOUNDARY_RULE_LIST(X)                                                                                  \
    X(SMOOTH, 0, "smooth")                                                                                             \
    X(CORNERS, 1, "corners")

typedef enum curvopt_boundary_rule {
#define CURVOPT_BOUNDARY_RULE_ENUM(name, value, text) CURVOPT_ENUMERATOR(BOUNDARY_RULE, name, value)
    CURVOPT_BOUNDARY_RULE_LIST(CURVOPT_BOUNDARY_RULE_ENUM)
#undef CURVOPT_BOUNDARY_RULE_ENUM
        CURVOPT_BOUNDARY_RULE_FORCE_INT = 0x7fffffff
} curvopt_boundary_rule;
CURVOPT_API const char *curvopt_boundary_rule_name(int32_t boundary_rule);
CURVOPT_API int32_t curvopt_boundary_rule_from_name(const char *name);

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
CURVOPT_API void curvopt_mesh_get_info(const curvopt_mesh *mesh, curvopt_mesh_info *info, size_t size);
/* Copies the polygons out: face_sizes [n_faces], face_vertices [n_corners]. */
CURVOPT_API void curvopt_mesh_get_faces(const curvopt_mesh *mesh, int32_t *face_sizes, int32_t *face_vertices);
/* Sharp edges and vertices that the mesh has, counted and copied out; none of sharpness 0. A subdivided mesh has those
 * of its cage, each sharpness less by 1. Corners kept by the rule CORNERS are among them, infinitely sharp, so that
 * what is copied out means the same surface under either rule. crease_vertices [2 n_creases], crease_sharpness
 * [n_creases], corner_vertices [n_corners], corner_sharpness [n_corners] */
CURVOPT_API void curvopt_mesh_count_creases(const curvopt_mesh *mesh, int32_t *n_creases, int32_t *n_corners);
CURVOPT_API void curvopt_mesh_get_creases(const curvopt_mesh *mesh, int32_t *crease_vertices, double *crease_sharpness,
                                          int32_t *corner_vertices, double *corner_sharpness);

/* One Catmull-Clark subdivision. Vertices of the result: the cage's vertices, then its edges, then its faces
 * (n_vertices + n_edges + n_faces of them); child k of a face starts at the face's corner k. Creases go with it.
 *   xyz [3 n_vertices], fine_xyz [3 (n_vertices + n_edges + n_faces)]: both NULL for connectivity alone. */
CURVOPT_API int32_t curvopt_mesh_refine(const curvopt_mesh *mesh, const double *xyz, curvopt_mesh **out,
                                        double *fine_xyz, curvopt_error *error);

/* ------------------------------------------------------------------------------------------------ options -- */

/* The surface that a cage stands for.
 *   AUTO        LIMIT if every term accepts it, else POLYNOMIAL
 *   LIMIT       the Catmull-Clark limit surface itself. Energies take a blend as of POLYNOMIAL at vertices where they
 *               would be infinite: smooth boundary and crease vertices of one face or of four and more on a side, and
 *               inner vertices of two edges; and at inner vertices of 12 faces and more, where most of the energy lies
 *               in a spot too small to see
 *   PLANE       the limit surface, blended into the tangent plane at extraordinary vertices, as in the report; on
 *               boundaries and creases as POLYNOMIAL
 *   POLYNOMIAL  the limit surface, blended into a fitted polynomial there, up to options.blend_width faces wide;
 * nothing changes along boundaries and creases, and wider than one face blends are there only where the cage's points
 * lie evenly */
#define CURVOPT_SURFACE_LIST(X)                                                                                        \
    X(AUTO, 0, "auto")                                                                                                 \
    X(LIMIT, 1, "limit")                                                                                               \
    X(PLANE, 2, "plane")                                                                                               \
    X(POLYNOMIAL, 3, "polynomial")

typedef enum curvopt_surface {
#define CURVOPT_SURFACE_ENUM(name, value, text) CURVOPT_ENUMERATOR(SURFACE, name, value)
    CURVOPT_SURFACE_LIST(CURVOPT_SURFACE_ENUM)
#undef CURVOPT_SURFACE_ENUM
        CURVOPT_SURFACE_FORCE_INT = 0x7fffffff
} curvopt_surface;
CURVOPT_API const char *curvopt_surface_name(int32_t surface);
CURVOPT_API int32_t curvopt_surface_from_name(const char *name);

/* The terms of the objective, which is the sum of weights[i] * term i. A is the area of the surface, k1 and k2 are its
 * principal curvatures, e1 and e2 their directions, H = (k1 + k2) / 2, and grad h is the covariant derivative of the
 * second fundamental form.
 *   WILLMORE       int (k1^2 + k2^2) dA
 *   MVS            A int ((dk1/de1)^2 + (dk2/de2)^2) dA
 *   MVS_CROSS      A int (|grad k1|^2 + |grad k2|^2) dA
 *   VARIATION      A int |grad h|^2 dA
 *   MEHLUM_TARROU  A int (1/pi) int_0^{2 pi} kappa'(theta)^2 dtheta dA
 *   AREA           A / (root mean square distance of the cage's vertices from their centroid)^2
 *   MEAN           int H^2 dA; on closed surfaces a quarter of WILLMORE plus a constant, on open ones 0 exactly for
 *                  minimal surfaces */
#define CURVOPT_TERM_LIST(X)                                                                                           \
    X(WILLMORE, 0, "willmore")                                                                                         \
    X(MVS, 1, "mvs")                                                                                                   \
    X(MVS_CROSS, 2, "mvs_cross")                                                                                       \
    X(VARIATION, 3, "variation")                                                                                       \
    X(MEHLUM_TARROU, 4, "mehlum_tarrou")                                                                               \
    X(AREA, 5, "area")                                                                                                 \
    X(MEAN, 6, "mean_curvature")

typedef enum curvopt_term {
#define CURVOPT_TERM_ENUM(name, value, text) CURVOPT_ENUMERATOR(TERM, name, value)
    CURVOPT_TERM_LIST(CURVOPT_TERM_ENUM)
#undef CURVOPT_TERM_ENUM
        CURVOPT_TERM_FORCE_INT = 0x7fffffff
} curvopt_term;
/* Terms that exist. */
#define CURVOPT_N_TERMS 7
CURVOPT_API const char *curvopt_term_name(int32_t term);
CURVOPT_API int32_t curvopt_term_from_name(const char *name);

/* The optimizer.
 *   AUTO          GAUSS_NEWTON; LMVM with options.joshi_sequin
 *   LMVM          limited-memory variable metric (L-BFGS) on all coordinates, the report's optimizer. It keeps
 *                 symmetries only if options.symmetry asks for them
 *   GAUSS_NEWTON  L-BFGS with the factored Gauss-Newton matrix as initial Hessian; at the end of the last level
 *                 Newton's method along normals, or with the spacing FREE over all coordinates */
#define CURVOPT_METHOD_LIST(X)                                                                                         \
    X(AUTO, 0, "auto")                                                                                                 \
    X(LMVM, 1, "lmvm")                                                                                                 \
    X(GAUSS_NEWTON, 2, "gauss_newton")

typedef enum curvopt_method {
#define CURVOPT_METHOD_ENUM(name, value, text) CURVOPT_ENUMERATOR(METHOD, name, value)
    CURVOPT_METHOD_LIST(CURVOPT_METHOD_ENUM)
#undef CURVOPT_METHOD_ENUM
        CURVOPT_METHOD_FORCE_INT = 0x7fffffff
} curvopt_method;
CURVOPT_API const char *curvopt_method_name(int32_t method);
CURVOPT_API int32_t curvopt_method_from_name(const char *name);

/* The part of an open surface that a minimization keeps. All but FREE also keep infinitely sharp vertices and the
 * vertices on infinitely sharp creases.
 *   POSITION   the boundary curves: the vertices on them are held
 *   TANGENT    also the tangent planes along them: two rows of vertices are held. Curvature at the boundary of a
 *              Catmull-Clark surface depends on no more than that
 *   CURVATURE  also the change of curvature there: three rows
 *   FREE       nothing */
#define CURVOPT_BOUNDARY_LIST(X)                                                                                       \
    X(POSITION, 0, "position")                                                                                         \
    X(TANGENT, 1, "tangent")                                                                                           \
    X(CURVATURE, 2, "curvature")                                                                                       \
    X(FREE, 3, "free")

typedef enum curvopt_boundary {
#define CURVOPT_BOUNDARY_ENUM(name, value, text) CURVOPT_ENUMERATOR(BOUNDARY, name, value)
    CURVOPT_BOUNDARY_LIST(CURVOPT_BOUNDARY_ENUM)
#undef CURVOPT_BOUNDARY_ENUM
        CURVOPT_BOUNDARY_FORCE_INT = 0x7fffffff
} curvopt_boundary;
CURVOPT_API const char *curvopt_boundary_name(int32_t boundary);
CURVOPT_API int32_t curvopt_boundary_from_name(const char *name);

/* How the vertices of the cage lie in its surface.
 *   AUTO  EVEN; FREE with LMVM, and where strength is below 1
 *   EVEN  evenly spaced: until the shape stands that is worth a part of the objective (a hundredth, a thousandth
 *         for third-order terms, and less from level to level). Then only the shape changes, by the objective
 *         alone: vertices move along normals, on free boundaries and creases across these. The verdict is on that.
 *         A cage that is a minimum already, but for a twentieth of an edge along normals, stays as it lies where
 *         no entries or numbers are held
 *   FREE  where the discrete objective is least, the report's way: all coordinates are minimized over, and the
 *         verdict is on them, too. Runs are longer, and cages are more distorted */
#define CURVOPT_SPACING_LIST(X)                                                                                        \
    X(AUTO, 0, "auto")                                                                                                 \
    X(EVEN, 1, "even")                                                                                                 \
    X(FREE, 2, "free")

typedef enum curvopt_spacing {
#define CURVOPT_SPACING_ENUM(name, value, text) CURVOPT_ENUMERATOR(SPACING, name, value)
    CURVOPT_SPACING_LIST(CURVOPT_SPACING_ENUM)
#undef CURVOPT_SPACING_ENUM
        CURVOPT_SPACING_FORCE_INT = 0x7fffffff
} curvopt_spacing;
CURVOPT_API const char *curvopt_spacing_name(int32_t spacing);
CURVOPT_API int32_t curvopt_spacing_from_name(const char *name);

/* The symmetries of the cage that a minimization keeps.
 *   AUTO       those of KEEP, but some are given up for third-order terms, whose discretization on coarse cages is
 *              often a saddle that symmetry hides: on levels of 20 to 2000 vertices the group is halved as long as
 *              each halving lowers the energy by 6 %. With LMVM: NONE
 *   NONE       none
 *   ROTATIONS  those of KEEP that are rotations: vertices on a mirror plane may leave it
 *   KEEP       those that the input cage has, with its creases and constraints, to 1e-5 of its size. The result has
 *              them to rounding, and one of several equivalent faces stands for all
 *   PLANES     the reflections in options.symmetry_planes and what they generate, no others. They are not given up. A
 *              cage without them is refused */
#define CURVOPT_SYMMETRY_LIST(X)                                                                                       \
    X(AUTO, 0, "auto")                                                                                                 \
    X(NONE, 1, "none")                                                                                                 \
    X(ROTATIONS, 2, "rotations")                                                                                       \
    X(KEEP, 3, "keep")                                                                                                 \
    X(PLANES, 4, "planes")

typedef enum curvopt_symmetry {
#define CURVOPT_SYMMETRY_ENUM(name, value, text) CURVOPT_ENUMERATOR(SYMMETRY, name, value)
    CURVOPT_SYMMETRY_LIST(CURVOPT_SYMMETRY_ENUM)
#undef CURVOPT_SYMMETRY_ENUM
        CURVOPT_SYMMETRY_FORCE_INT = 0x7fffffff
} curvopt_symmetry;
CURVOPT_API const char *curvopt_symmetry_name(int32_t symmetry);
CURVOPT_API int32_t curvopt_symmetry_from_name(const char *name);

/* Mirror planes perpendicular to the axes, through the mean of the cage's vertices; flags to be added up. */
#define CURVOPT_PLANE_LIST(ENTRY)                                                                                      \
    ENTRY(X, 1, "x")                                                                                                   \
    ENTRY(Y, 2, "y")                                                                                                   \
    ENTRY(Z, 4, "z")

typedef enum curvopt_plane {
#define CURVOPT_PLANE_ENUM(name, value, text) CURVOPT_ENUMERATOR(PLANE, name, value)
    CURVOPT_PLANE_LIST(CURVOPT_PLANE_ENUM)
#undef CURVOPT_PLANE_ENUM
        CURVOPT_PLANE_FORCE_INT = 0x7fffffff
} curvopt_plane;
CURVOPT_API const char *curvopt_plane_name(int32_t plane);
CURVOPT_API int32_t curvopt_plane_from_name(const char *name);

/* Added to a freedom: not the vertex is constrained but its limit point, which lies on the surface. */
enum { CURVOPT_FREEDOM_OF_LIMIT_POINT = 4 };

/* Vertices that may not move freely; the arrays are the caller's. A subdivision moves vertices. What is held is the
 * vertex of the last level's cage: coarser levels hold where it will be after the subdivisions that follow, so that
 * each level goes on with the surface of the one before. A run that ends before its last level then returns the last
 * level's cage of the surface that it has and, unless it was cancelled, that cage's figures. With any weight between 0
 * and 1, a strength below 1, a distance or no crossings, where creases fade or end at a vertex, and where these points
 * cannot be chosen freely, vertices go back to their points, lines and planes after each subdivision. Where all
 * vertices of a face have the same constraint, the face is held as a piece of surface: its children inherit the
 * constraint and stay where subdivision puts them.
 *
 * A constrained limit point is a point of the surface: on every level the surface goes through it (held), or touches
 * its line or plane. The vertex then moves as that needs. Where a crease fades or ends at the vertex, where the vertex
 * has no face, and with weights below 1 that is refused. What a boundary or a crease holds stays itself. On the
 * first level at most 1 000 vertices whose masks overlap; where these do not move independently, as all eight of a
 * cube, that is refused, too. On finer levels they do not overlap.
 *
 * Points, lines and planes go through where the vertices and limit points are, or through `places`: the first level
 * then begins with a cage that has been put there. Held limit points at places are interpolation. A place is at most
 * 1e9 times the cage's size (root mean square) away from its middle. With a strength below 1 only what is held exactly
 * can have a place.
 *
 * A weight w between 0 and 1 draws a vertex to its point, line or plane by a spring, whose energy adds to the
 * objective: w / (1 - w) * (distance / size of the input)^2 * half of the stiffness of a sphere (for Willmore 24 pi).
 * It depends on neither scale nor levels. A connected patch of vertices with weights counts as one spring, however many
 * they are. With springs centroid, orientation and size are not held otherwise. Decrements and verdicts are of the sum
 * of energy and springs; every reported energy is the surface's alone. */
typedef struct curvopt_constraints {
    const int32_t *vertices;  /* [n] a vertex may stand here twice only with the same constraint */
    const int32_t *freedom;   /* [n] 0: held, 1: moves along its direction, 2: moves across it; each plus
                                 CURVOPT_FREEDOM_OF_LIMIT_POINT: so the limit point; NULL: all 0 */
    const double *directions; /* [3 n] of any length, ignored where the freedom is 0; NULL if it is 0 everywhere */
    int32_t n;
    int32_t has_places;    /* 0: `places` is not read, which older headers do not have; 1: it is */
    const double *weights; /* [n] 0: not held at all, to 1 (1 - 1e-9 counts as 1): held exactly; NULL: all 1 */
    const double *places;  /* [3 n] points that are held, or of the lines and planes; three NANs: where it is; NULL:
                              all are where they are */
} curvopt_constraints;

/* A chain of edges whose limit curve follows a curve: the cubic spline through n_points points, by the length of the
 * polygon that joins them; open ends are not-a-knot, a closed curve goes on from its last point to the first one.
 * Points that repeat the one before, to 1e-6 of the polygon's length, do not count, nor does the last one of a closed
 * curve if it repeats the first; then there must be 2, or 3 if the curve is closed.
 *
 * On every level the limit points of the chain's vertices lie on the curve, those that subdivision has put in the
 * middles of its edges as well, and of an open chain the middles of its first and last edges: where faces are quads and
 * vertices have valence 4 the distance falls to about a sixteenth with each level. These two wait for a level on which
 * the curve bends by a radian at most along the end edge. Each vertex of the input goes to the nearest place of the
 * curve, from its limit point, or to a given parameter; between them the places follow a cubic spline of these
 * parameters. All must grow, or fall, from vertex to vertex. What a boundary or a crease holds stays itself, also where
 * a chain ends in it. Where a chain turns, its edges no opposite ones, its limit curve has a corner, and comes to a
 * smooth curve with order 1 only. For a curve with a corner let one chain end and another one begin there.
 *
 * Two chains may have vertices in common, whose places are then the same to 1e-6 of the input's size, but no edges.
 * Chains that springs draw (curvopt_through.chain_weights) may be anywhere. */
typedef struct curvopt_chain {
    const int32_t *vertices;  /* [n_vertices] each joined to the next by an edge; none twice */
    const double *curve;      /* [3 n_points] */
    const double *parameters; /* [n_vertices] in numbers of points: 1.25 is a quarter of the way from point 1 to point
                                 2, measured by the polygon; 0 to n_points - 1, if the curve is closed to n_points.
                                 NULL: nearest places */
    int32_t n_vertices;       /* 2 at least, of a closed chain 3 */
    int32_t n_points;
    int32_t is_closed;       /* whether an edge joins the last vertex to the first; the curve must be closed, too */
    int32_t is_curve_closed; /* an open chain may follow a part of a closed curve */
} curvopt_chain;

/* What the limit surface goes through: n entries, each of one of its points, at a vertex or inside a face. On every
 * level they are the same points of the surface; what is said of them holds exactly, to rounding, from the beginning of
 * the first level on, which vertices near them are moved for.
 *
 * A weight w between 0 and 1 draws the point and the tangents by springs instead: w / (1 - w) * half of the stiffness
 * of a sphere (as in curvopt_constraints), times (distance / size of the input)^2 of the point from its place, line or
 * plane, plus the squares of the cosines between the normal and two tangents at right angles; a tangent that has a
 * direction counts by the square of the sine between them. Lengths of tangents are in parts of those on the input.
 * That adds to the objective (curvopt_summary.spring_energy) and depends on neither scale nor levels. There may be any
 * number of such entries near each other: where they contradict, the result is between them. As w goes to 1 distances
 * fall like 1 - w, to the result that holds exactly.
 *
 * The unknowns at entries of weight 1 are the points and tangents themselves, in place of as many cage vertices near
 * them (libcurvopt/notes/87-through-limit-points.md). An entry that those near it, or other constraints, leave no
 * freedom for is refused, with its number as `element`; so are two that contradict. But a point that is where it is to
 * be, and of which nothing may move, stands. Entries are of the Catmull-Clark limit surface, also where energies are
 * those of a blend. Of the cage's symmetries those are kept that take entries to entries (to 1e-5 of the size), as far
 * as their unknowns can be chosen so; with chains or curvatures none are.
 *
 * Chains of weight 1 hold exactly, as entries do. No entry of weight 1 may hold a point of such a chain's vertex or
 * edge. Those that have vertices in common hold at most 1 000 limit points together on the last level. A chain of a
 * weight below 1 is drawn by springs: w / (1 - w) * half of the stiffness of a sphere, times the integral of (distance
 * / size of the input)^2 between limit curve and curve along it, where each edge of the input has the length 1. It may
 * have vertices and edges in common with others. Errors that begin with "chain" have its number as `element`.
 *
 * Normals and tangents need a surface that is smooth there: not on boundaries and creases. Their signs do not count.
 *
 * Principal curvatures k1 and k2 are held with a normal: k1 in its direction, k2 at right angles to that. Their signs
 * are by the faces, whatever the sign of the normal is: both are positive on a sphere whose faces are counterclockwise
 * as seen from outside. They can be held inside faces, and at vertices where four faces meet; at other vertices the
 * surface has no curvature. Radii are at least 1e-6 of the input's size. A weight below 1 draws them by a spring, too:
 * w / (1 - w) * half of the stiffness of a sphere, times the square of the tensor (second form - wanted one) * size of
 * the input. Where the tangent plane is another one the wanted form is turned along with it. With entries of weight 1
 * each level begins with its minimum without curvatures, of which progress is told; then both tangents at the entry are
 * held as vectors near those of that minimum, for by fixed tangents curvatures are linear in the cage. Along a row of a
 * regular net such entries must be three edges apart.
 *
 * Refused with a strength below 1, a distance `within`, and by solvers that stay; with the symmetry PLANES where
 * entries are not symmetric about these, and chains and curvatures in each case. */
typedef struct curvopt_through {
    int32_t struct_size;     /* sizeof(curvopt_through) */
    int32_t n;               /* number of entries */
    const int32_t *vertices; /* [n] whose limit point it is; -1: a point inside a face; NULL: all are that */
    const int32_t *faces; /* [n] with corners and uv as in curvopt_sampler_jets; ignored for vertices. NULL: all are at
                             vertices */
    const int32_t *corners;   /* [n] NULL: all 0 */
    const double *uv;         /* [2 n] not a corner of the face, nor the middle of one that is no quad */
    const int32_t *freedom;   /* [n] of the point: 0: held, 1: moves along its direction, 2: moves across it, 3: free;
                                 NULL: all 0 */
    const double *directions; /* [3 n] of any length, ignored for the freedoms 0 and 3; NULL if there are no others */
    const double *places;  /* [3 n] where the point is held, or points of the lines and planes; three NANs: where it is;
                              NULL: all are where they are */
    const double *normals; /* [3 n] of the surface, of any length; three NANs: not held; NULL: none is */
    const double *tangents; /* [3 n] directions, of any length, of the tangent that `toward` names; three NANs: not
                               held; NULL: none is. At right angles to the normal, if there is one, to 1e-6 */
    const int32_t *toward;  /* [n] at a vertex the other end of an edge there, along which the tangent is; inside a face
                               0: along u, 1: along v; ignored where there is no tangent */
    const double
        *weights; /* [n] 0: the entry does not count, to 1 (1 - 1e-9 counts as 1): it holds exactly; NULL: all 1 */
    const curvopt_chain *chains; /* [n_chains] chains of edges that follow curves */
    int32_t n_chains;
    int32_t reserved;            /* 0 */
    const double *chain_weights; /* [n_chains] as `weights`, of chains; NULL: all 1 */
    const double *curvatures; /* [2 n] principal curvatures k1 and k2 of the surface, 1 / unit of length; two NANs: not
                                 held; NULL: none is */
    const double *curvature_directions; /* [3 n] directions of k1, of any length, at right angles to the normal to 1e-6;
                                           three NANs, NULL: that of the tangent, or none where k1 = k2 */
} curvopt_through;

/* Numbers of a whole surface. H = (k1 + k2) / 2, positive where the surface is convex. Normals point to where faces are
 * counterclockwise as seen from; where the volume is negative they point inwards, and both numbers change their sign.
 *   VOLUME          inside a surface without boundary; what a boundary or left-out faces leave open is closed by a cone
 *                   to the centroid of the input's vertices, and only differences say something
 *   AREA
 *   MEAN_CURVATURE  int H dA; 2 d times it is the difference in area of two surfaces d to either side */
#define CURVOPT_SCALAR_LIST(X)                                                                                         \
    X(VOLUME, 0, "volume")                                                                                             \
    X(AREA, 1, "area")                                                                                                 \
    X(MEAN_CURVATURE, 2, "total_mean_curvature")

typedef enum curvopt_scalar {
#define CURVOPT_SCALAR_ENUM(name, value, text) CURVOPT_ENUMERATOR(SCALAR, name, value)
    CURVOPT_SCALAR_LIST(CURVOPT_SCALAR_ENUM)
#undef CURVOPT_SCALAR_ENUM
        CURVOPT_SCALAR_FORCE_INT = 0x7fffffff
} curvopt_scalar;
/* Scalars that exist. */
#define CURVOPT_N_SCALARS 3
/* Length of arrays by curvopt_scalar, with room for later ones. */
#define CURVOPT_MAX_SCALARS 6
CURVOPT_API const char *curvopt_scalar_name(int32_t scalar);
CURVOPT_API int32_t curvopt_scalar_from_name(const char *name);

/* What a scalar of the result is to be.
 *   FREE     anything
 *   KEEP     as the input's
 *   VALUE    options.scalar_value, in units of the cage
 *   REDUCED  options.scalar_value times that of the sphere with the result's area (not of AREA) */
#define CURVOPT_SCALAR_RULE_LIST(X)                                                                                    \
    X(FREE, 0, "free")                                                                                                 \
    X(KEEP, 1, "keep")                                                                                                 \
    X(VALUE, 2, "value")                                                                                               \
    X(REDUCED, 3, "reduced")

typedef enum curvopt_scalar_rule {
#define CURVOPT_SCALAR_RULE_ENUM(name, value, text) CURVOPT_ENUMERATOR(SCALAR_RULE, name, value)
    CURVOPT_SCALAR_RULE_LIST(CURVOPT_SCALAR_RULE_ENUM)
#undef CURVOPT_SCALAR_RULE_ENUM
        CURVOPT_SCALAR_RULE_FORCE_INT = 0x7fffffff
} curvopt_scalar_rule;
CURVOPT_API const char *curvopt_scalar_rule_name(int32_t rule);
CURVOPT_API int32_t curvopt_scalar_rule_from_name(const char *name);

/* Fill it in with curvopt_options_init(), then change members. */
typedef struct curvopt_options {
    /* sizeof(curvopt_options) of the caller's header, set by the init. */
    int32_t struct_size;
    /* curvopt_surface; default AUTO. */
    int32_t surface;
    /* curvopt_method; default AUTO. */
    int32_t method;
    /* Number of optimizations; the cage is subdivided between them. 1..CURVOPT_MAX_LEVELS, default 4. */
    int32_t levels;
    /* Largest number of steps of a level. A level that is solved again, with fewer symmetries or by finer rules, has as
     * many anew, and its report counts them all. 0 or more, default 10000. */
    int32_t max_iterations;
    /* Number of threads. 0..1024, default 0: as many as processors that the process may use. */
    int32_t threads;
    /* 1: the settings of the report (Joshi, Sequin; see the top). The surface is PLANE for third-order terms and the
     * method LMVM where they are AUTO, no symmetries are kept, and a fixed quadrature rule is used that nothing checks.
     * 0 or 1, default 0. */
    int32_t joshi_sequin;
    /* curvopt_boundary; default POSITION. */
    int32_t boundary;
    /* Weights of the terms, by curvopt_term. 0..CURVOPT_WEIGHT_MAX, not all 0; 0 from CURVOPT_N_TERMS on. Defaults:
     * WILLMORE 1, the others 0. */
    double weights[CURVOPT_MAX_TERMS];
    /* Relative quadrature error wanted. 1e-12..0.5, default 1e-4. */
    double tolerance;
    /* A level has converged when |gradient| * size < gradient_tolerance * energy. 1e-15..1, default 1e-6. */
    double gradient_tolerance;
    /* The last level has converged when the quadratic model predicts a gain of less than decrement_tolerance * energy.
     * A coarser level has when it predicts less than the larger of 1e-5 and decrement_tolerance, times energy. What
     * counts as settled on the last level scales with it. LMVM has no model and does not use it.
     * 1e-15..1, default 2e-7. */
    double decrement_tolerance;
    /* Longest displacement of a vertex in one step, in mean edge lengths of the present cage. 1e-6..100, default 0.5.
     */
    double max_step;
    /* Vertices that may not move freely, for curvopt_minimize() only; default NULL: none. */
    const curvopt_constraints *constraints;
    /* curvopt_symmetry; default AUTO. */
    int32_t symmetry;
    /* 1: examine the result also without its symmetries, and by a Hessian from finite differences. This may take longer
     * than the run. 0 or 1, default 0. */
    int32_t verify;
    /* 1: leave a level of at most CURVOPT_MAX_ESCAPE_VERTICES vertices whose shape is a saddle, all symmetries
     * disregarded, along the negative direction of the saddle, and solve it again with the symmetries that this
     * direction has. 0 or 1, default 0. */
    int32_t escape;
    /* Sum of curvopt_plane with the symmetry PLANES, else 0; default 0. */
    int32_t symmetry_planes;
    /* Largest width of a blend of POLYNOMIAL, in faces of each sector at an extraordinary vertex. Blends take a quarter
     * of the way to the next vertex that is not regular; on boundaries and creases 8, 4 or 2 faces within that, or 1
     * where the positions that a problem, a sampler or a level begins with are uneven (longest edge of the curve above
     * 1.8 shortest, or the polynomial 8 edges off), and where 1, or 17 and more faces meet.
     * 1..CURVOPT_MAX_BLEND_WIDTH, default 8. */
    int32_t blend_width;
    /* curvopt_spacing; default AUTO. */
    int32_t spacing;
    /* How much of the cage's shape may go. Below 1 the surface stays near the input: a spring pulls each vertex back,
     * in proportion to the area round it, so firmly that of a wave of length L = strength / (1 - strength), times the
     * input cage's root mean square radius, half the height stays. Shorter waves go, longer ones stay. No vertex that a
     * spring holds, and so no point of the surface, gets farther than L / 5 from where it was, and where the energy
     * round a vertex is much more than that of such waves, at creases and poles, its spring is stiffer. Then AUTO is
     * the spacing FREE, for the springs hold the spacing, and the symmetry KEEP. Springs are not in the energies that
     * are reported, but in decrements and verdicts. 1: the objective's minimum. 0.001..1, default 1. */
    double strength;
    /* Faces that are not there for whoever looks: they are left out of the energy, and their vertices are held
     * (curvopt_exception). [n_holes] indices of faces, or NULL; default NULL. */
    const int32_t *holes;
    /* Number of them. 0 or more, default 0. */
    int32_t n_holes;
    /* 1: refuse cages that have exceptions other than holes, with the sentence of the first. 0 or 1, default 0. */
    int32_t strict;
    /* 1: vertices on boundaries and infinitely sharp creases that are held slide along these, for a better spacing of
     * the surface beside them. The limit curves stay: limit points of vertices stay on the input's curves exactly, and
     * between them curves differ by third order in the spacing (curvopt_summary.curve_deviation). Ends of curves
     * (corners, vertices where several meet), vertices with constraints, left-out faces and curves with fading creases
     * stay. With the boundary TANGENT and CURVATURE the boundary stays, and creases slide; with FREE nothing is held,
     * and nothing slides. Vertices find their places before the first level is solved; then they are held there, as
     * without the option, and the verdict is on that. Subdivided curves are put back on the input's. 0 or 1, default 0.
     */
    int32_t slide;
    /* curvopt_scalar_rule of each curvopt_scalar, for curvopt_minimize() only; 0 from CURVOPT_N_SCALARS on. Default:
     * all FREE.
     *
     * Where nothing of the cage is held, energies do not depend on size. A volume or a mean curvature that is kept by
     * itself then costs nothing: the result has that size instead of the input's area. What is held beside is a
     * shape's: volume and area together, or one that is REDUCED. Where what is held of a cage leaves it its size,
     * as one place does, or places in a plane, curvopt_minimize() keeps the input's area, too, unless the area has a
     * weight. Of a cage of several pieces KEEP keeps the number of each.
     *
     * Refused are: a volume where options.boundary is FREE and there is one; its VALUE, or a REDUCED volume, where
     * there is a boundary or a face is left out; a volume larger than that of the sphere with the area that is held. */
    int32_t scalar_rule[CURVOPT_MAX_SCALARS];
    /* [..] the value of each curvopt_scalar with the rule VALUE or REDUCED: positive and finite; else 0. */
    double scalar_value[CURVOPT_MAX_SCALARS];
    /* Where it is positive, no vertex of the cage, and so no point of the surface, gets farther than this from where it
     * was, in the units of the positions; on finer levels from where subdivision puts it, but for single vertices that
     * constraints hold where they were. By a logarithmic barrier that
     * is worth a few hundredths of the energy: the result is the objective's minimum within the distance but for that.
     * Symmetry is chosen as with a strength below 1, and the barrier is in decrements and verdicts, not in energies,
     * like springs. Refused with constraints that have places, or whose weight is below 1 and which leave
     * directions free. 0: no limit. 0 or more, finite, default 0. */
    double within;
    /* c0, in 1 / units of the cage: the bending energy is Helfrich's. WILLMORE then counts in the objective as
     * int (k1^2 + k2^2 - 2 c0 (k1 + k2) + c0^2) dA, which is int (k1 + k2 - c0)^2 dA - 2 int K dA, and MEAN as
     * int (H - c0 / 2)^2 dA; both can be 0 or, WILLMORE, negative. curvopt_energies.term stay as they are. c0 counts
     * for normals that point outwards, where a surface is closed, else as its faces run: 2 / R is the curvature of a
     * sphere of radius R. Where nothing of the cage is held, the result has a given size, the input's area or what
     * scalar_rule says, and c0 is at that size; the reduced curvature of the literature is c0 sqrt(area / (4 pi)).
     * Tolerances and verdicts are then relative to the objective plus (2 WILLMORE + MEAN / 2) c0^2 times that area,
     * which is never near 0. Refused where WILLMORE and MEAN have no weight, and by curvopt_problem_create_part(). Up
     * to 1e100 and down to -1e100, default 0. */
    double spontaneous_curvature;
    /* Points, normals and tangents of the surface that are held; for curvopt_minimize() only. NULL: none are. Default
     * NULL. */
    const curvopt_through *through;
    /* 1: the surface comes to cross itself nowhere, for curvopt_minimize() only. From a fifth of a mean edge on faces
     * that are no neighbours repel each other by a barrier (IPC), which is worth the energy where all of the surface is
     * as close; steps that would lead to a crossing are shortened. So the result is the objective's minimum among
     * surfaces without crossings but for the barrier, whose reach halves with each level. It is in decrements and
     * verdicts, not in energies; the Hessian leaves second derivatives of distances out. The summary says by how many
     * pairs of faces it is held, and how close they are. curvopt_find_crossings() finds none in the result.
     *
     * A surface that crosses itself at the start may go on, at those faces and two rings round them, and in no more
     * pairs of faces than before. What touches at the start does not repel each other. Limit points and vertices that
     * are put at places must not make it cross (ERROR_GEOMETRY). Boundaries repel surfaces, but not other boundaries,
     * and neighbours do not repel each other: there runs may end early, with the stop UNRESOLVED or STALLED and
     * summary.n_refused. Several times as slow as without, and more where much of the surface is in contact. Refused
     * with slide, joshi_sequin and by a solver that stays. 0 or 1, default 0. */
    int32_t no_crossings;
    /* 0 */
    int32_t reserved;
} curvopt_options;

/* Fills in the defaults, and `size`, which is sizeof(curvopt_options), as struct_size. */
CURVOPT_API void curvopt_options_init(curvopt_options *options, size_t size);
/* OK, or ERROR_ARGUMENT with a message that names the field and its value. */
CURVOPT_API int32_t curvopt_options_validate(const curvopt_options *options, curvopt_error *error);

/* --------------------------------------------------------------------------------------------- exceptions -- */

/* Why vertices are held and faces left out of the energy. A face is left out if the surface has no finite energy at one
 * of its corners, or no neighbourhood like a disc's or a half disc's; it stays out on finer levels. The vertices of
 * such faces are held: they stay where they are, to rounding, and on finer levels where subdivision puts them, unless
 * options.constraints put them at a place, which goes before this and before options.boundary. All the rest
 * is optimized. A run decides once, by the cage that it begins with. X(NAME, value, "name", text)
 *   ISOLATED, CROWDED_EDGE, FLIPPED, PINCHED
 *                     the cage is no manifold there, or not consistently oriented
 *   CONE, CORNER      the Catmull-Clark rules leave no tangent plane, and int k^2 dA is infinite: an infinitely sharp
 *                     vertex, a corner of two and more faces between sharp edges
 *   DEGENERATE        the same, by the vertices' positions: edges of length 0, up to CURVOPT_COINCIDENT, leave no
 *                     tangent plane there, for example at a pole that is a boundary of many vertices in one place. A
 *                     quad two of whose corners are in one place mostly has one, and counts
 *   BESIDE            a vertex of a face that is left out for another of its vertices
 *   HOLE              a face of options.holes */
#define CURVOPT_EXCEPTION_LIST(X)                                                                                      \
    X(ISOLATED, 0, "isolated", "no face uses the vertex")                                                              \
    X(CROWDED_EDGE, 1, "crowded_edge", "three or more faces share an edge")                                            \
    X(FLIPPED, 2, "flipped", "two faces run the same way over an edge: one of them is flipped")                        \
    X(PINCHED, 3, "pinched", "separate fans of faces meet in the vertex")                                              \
    X(CONE, 4, "cone", "an infinitely sharp vertex makes a cone")                                                      \
    X(CORNER, 5, "corner", "a corner has several faces and makes a cone")                                              \
    X(DEGENERATE, 6, "degenerate", "edges of length 0, or far too short for the cage, leave no tangent plane")         \
    X(BESIDE, 7, "beside", "a face beside the vertex is left out")                                                     \
    X(HOLE, 8, "hole", "the face is a hole")

typedef enum curvopt_exception {
#define CURVOPT_EXCEPTION_ENUM(name, value, short_name, text) CURVOPT_ENUMERATOR(EXCEPTION, name, value)
    CURVOPT_EXCEPTION_LIST(CURVOPT_EXCEPTION_ENUM)
#undef CURVOPT_EXCEPTION_ENUM
        CURVOPT_EXCEPTION_FORCE_INT = 0x7fffffff
} curvopt_exception;
/* Exceptions that exist. */
#define CURVOPT_N_EXCEPTIONS 9
/* Edges are of length 0 up to this part of the root mean square radius of the cage's vertices: ten times what rounding
 * to single precision moves them. */
#define CURVOPT_COINCIDENT 1e-6
CURVOPT_API const char *curvopt_exception_name(int32_t exception);
CURVOPT_API int32_t curvopt_exception_from_name(const char *name);
/* The text of an exception; never NULL, also for an unknown one. */
CURVOPT_API const char *curvopt_exception_text(int32_t exception);

/* The exceptions of a cage: by its connectivity and creases, by its positions xyz [3 n_vertices] (DEGENERATE; NULL:
 * these are not looked for) and, of the options, by the holes. vertex_reason [n_vertices]  curvopt_exception of each
 * vertex, of several the least; -1: it is not held face_reason [n_faces]       curvopt_exception of each face; -1: it
 * counts Both arrays are the caller's; either may be NULL. ERROR_ARGUMENT (also a hole that is no face: `element` is
 * its index), ERROR_GEOMETRY (not finite, zero size), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_mesh_find_exceptions(const curvopt_mesh *mesh, const double *xyz,
                                                 const curvopt_options *options, int32_t *vertex_reason,
                                                 int32_t *face_reason, curvopt_error *error);

/* --------------------------------------------------------------------------------------- progress, cancel -- */

/* A flag that any thread may raise to stop an evaluation, a measurement or a run. It stays raised. */
typedef struct curvopt_cancel curvopt_cancel;
CURVOPT_API int32_t curvopt_cancel_create(curvopt_cancel **out, curvopt_error *error);
CURVOPT_API void curvopt_cancel_request(curvopt_cancel *cancel);
CURVOPT_API void curvopt_cancel_destroy(curvopt_cancel *cancel);

/* The method that made a step.
 *   NONE    no step: the start of a level
 *   LBFGS   limited-memory BFGS with a line search
 *   NEWTON  Newton's method with a shifted Hessian */
#define CURVOPT_STEP_LIST(X)                                                                                           \
    X(NONE, 0, "none")                                                                                                 \
    X(LBFGS, 1, "lbfgs")                                                                                               \
    X(NEWTON, 2, "newton")

typedef enum curvopt_step {
#define CURVOPT_STEP_ENUM(name, value, text) CURVOPT_ENUMERATOR(STEP, name, value)
    CURVOPT_STEP_LIST(CURVOPT_STEP_ENUM)
#undef CURVOPT_STEP_ENUM
        CURVOPT_STEP_FORCE_INT = 0x7fffffff
} curvopt_step;
CURVOPT_API const char *curvopt_step_name(int32_t step);
CURVOPT_API int32_t curvopt_step_from_name(const char *name);

/* The record of one iteration of a run (curvopt_problem_create_interruptible says what it is of an evaluation). The
 * callback gets it at the start of every level (iteration 0) and after every accepted step. Its pointers are valid
 * during the call only. A number that is not known is NAN. */
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
    const double *xyz;        /* [3 n_vertices] the current cage; cancelling now returns it, or what the level had
                                 before it began once more, if that is better */
    const curvopt_mesh *mesh; /* its connectivity */
    double energy;            /* weighted sum of the terms now; what springs add is not in it */
    double start_energy;      /* the same of the input cage */
    double gradient_norm;     /* |gradient| * size / energy, dimensionless; with spontaneous curvature over what
                                 tolerances are relative to (curvopt_options) */
    double seconds;           /* since the start of the run */
    double predicted;  /* decrease of the objective that the quadratic model predicted for the step; of L-BFGS, whose
                          model is rough, it may be negative; NAN without a step */
    double shift;      /* multiple of the identity that was added to the Hessian for the step, in the objective's
                          units at root mean square radius 1; of L-BFGS: of the metric in which its matrix is damped,
                          mean edge^2 / 4 sum |d_v - d_w|^2 / |x_v - x_w|^2 over the edges for displacements d, which
                          is 1 for a vertex of an even net of squares. NAN for steps without a matrix */
    double gain_ratio; /* actual decrease over predicted decrease of the step; NAN without a step */
    double step;       /* longest displacement of a vertex in the step, in mean edge lengths of the cage; NAN
                          without a step */
} curvopt_progress;

/* Called on the thread that called the function which was given it. Nonzero cancels. */
typedef int32_t (*curvopt_progress_fn)(const curvopt_progress *progress, void *user);

/* ----------------------------------------------------------------------------------------------- energies -- */

/* The result of an evaluation. NAN stands for an energy that the surface does not have: third order on LIMIT with an
 * extraordinary vertex. */
typedef struct curvopt_energies {
    double objective;                     /* weighted sum of the terms, by the options */
    double area;                          /* in squared units of the cage */
    double term[CURVOPT_MAX_TERMS];       /* every term by curvopt_term, whatever its weight */
    double h2;                            /* int H^2 dA, H = (k1 + k2) / 2 */
    double gauss;                         /* int K dA, K = k1 k2 */
    double gauss_bonnet_defect;           /* |int K dA + int kappa_g ds + corner angles - 2 pi chi| with the curves at
                                             boundaries and infinitely sharp creases; 0 for a resolved surface; NAN
                                             where faces are left out */
    double objective_error;               /* estimate of |objective - exact integral|: from finer rules, and from where
                                             umbilics lie, at which integrands of MVS and MVS_CROSS jump; of a run
                                             that was cancelled the last estimate, some steps before its end */
    double area_error;                    /* the same of the area, in squared units of the cage */
    double term_error[CURVOPT_MAX_TERMS]; /* the same of each term, by curvopt_term */
    double min_jacobian;                  /* smallest |S_u x S_v| over its mean on the face; near 0 the surface folds */
    int32_t surface;                      /* curvopt_surface that was used, never AUTO */
    int32_t n_samples;                    /* quadrature points */
    double volume;                        /* inside, in cubic units of the cage; NAN where there is a boundary or faces
                                             are left out */
    double total_mean_curvature;          /* int H dA, in units of the cage; positive on a ball, 4 pi R, if its faces
                                             run counterclockwise seen from outside */
    double helfrich;                      /* int (k1 + k2 - c0)^2 dA with c0 = options.spontaneous_curvature, here of
                                             normals that point outwards where the surface is closed */
} curvopt_energies;

/* A cage's connectivity made ready for evaluation with some options; reusable for any positions. */
typedef struct curvopt_problem curvopt_problem;

/* The energy of all faces but those that are left out (curvopt_exception).
 * ERROR_ARGUMENT, ERROR_TOPOLOGY (vertices of 16383 faces), ERROR_UNSUPPORTED, ERROR_MEMORY, and ERROR_SURFACE: no face
 * is left, or third-order terms on `limit`, which has no finite ones at extraordinary vertices. With options.strict
 * also ERROR_TOPOLOGY, ERROR_SURFACE and ERROR_GEOMETRY for each other exception (`element` is the vertex, of edges
 * the face). Faces that are degenerate at xyz [3 n_vertices] are left out, wherever the problem is evaluated, and
 * blends on boundaries and creases are as wide as xyz allows (options.blend_width). NULL: nothing is looked for, and
 * these are of width 1. ERROR_GEOMETRY also for an xyz that is not finite or of no size. Keeps its own copy of the
 * connectivity. */
CURVOPT_API int32_t curvopt_problem_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                           curvopt_problem **out, curvopt_error *error);
CURVOPT_API void curvopt_problem_destroy(curvopt_problem *problem);
/* Energies at xyz [3 n_vertices] into out, whose sizeof is `size`, and the objective's exact gradient into gradient
 * [3 n_vertices] unless that is NULL. Quadrature is refined until every term meets options.tolerance, and not made
 * coarser again for the next positions, so that differences of nearby energies are smooth.
 * ERROR_ARGUMENT, ERROR_GEOMETRY (not finite, zero area; `element` is the face, or the vertex where the gradient is not
 * finite), ERROR_RESOLUTION (the surface is folded flat; `element` is the face), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_problem_evaluate(curvopt_problem *problem, const double *xyz, curvopt_energies *out,
                                             size_t size, double *gradient, curvopt_error *error);

/* The same two, for cages with which they take long (a vertex of 64 faces: seconds). Each takes a progress callback and
 * a flag, all of which may be NULL, as in curvopt_minimize; once it is cancelled it ends with ERROR_CANCELLED, and
 * writes nothing else. The problem of a cancelled evaluation can be evaluated again, with the same bits as if it had
 * not been cancelled.
 *
 * The callback is called after each basis table that is made, and each time that all faces were evaluated by the
 * present quadrature rules and by those one step finer. Of curvopt_progress, iteration and evaluations are the number
 * of these times so far, samples and energy those of the last one (0 and NAN before the first), seconds those of this
 * call, xyz the caller's (in curvopt_problem_create_interruptible it may be NULL); level and levels are 1, mesh is
 * NULL, and all that is about steps is 0 or NAN. */
CURVOPT_API int32_t curvopt_problem_create_interruptible(const curvopt_mesh *mesh, const double *xyz,
                                                         const curvopt_options *options, curvopt_progress_fn progress,
                                                         void *user, const curvopt_cancel *cancel,
                                                         curvopt_problem **out, curvopt_error *error);
CURVOPT_API int32_t curvopt_problem_evaluate_interruptible(curvopt_problem *problem, const double *xyz,
                                                           curvopt_progress_fn progress, void *user,
                                                           const curvopt_cancel *cancel, curvopt_energies *out,
                                                           size_t size, double *gradient, curvopt_error *error);

/* A surface made ready to be sampled: a cage with positions, and the same options as for minimizing or evaluating it.
 */
typedef struct curvopt_sampler curvopt_sampler;

/* The surface of cage xyz [3 n_vertices] that these options stand for: of their members surface, weights (for AUTO),
 * joshi_sequin and blend_width count here. Keeps its own copy of mesh and positions.
 * ERROR_ARGUMENT, ERROR_TOPOLOGY, ERROR_GEOMETRY (not finite, zero size), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_sampler_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                           curvopt_sampler **out, curvopt_error *error);
CURVOPT_API void curvopt_sampler_destroy(curvopt_sampler *sampler);
/* Points of the surface and their derivatives.
 *   face [n], corner [n], uv [2 n]: places. On a face with four corners, corner is 0, and u (towards corner 1) and v
 *     (towards corner 3) run from 0 to 1 over the face. On another face, corner chooses the quarter at that corner; u
 *     runs to the middle of the edge to the next corner, v to the middle of the edge to the previous one.
 *   jets [30 n]: S, S_u, S_v, S_uu, S_uv, S_vv, S_uuu, S_uuv, S_uvv, S_vvv of each point. Exactly at an extraordinary
 *     vertex derivatives do not exist: NAN.
 * ERROR_ARGUMENT (`element` is the point's index), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_sampler_jets(curvopt_sampler *sampler, int32_t n, const int32_t *face,
                                         const int32_t *corner, const double *uv, double *jets, curvopt_error *error);

/* ---------------------------------------------------------------------------------------------- measuring -- */

/* How far two limit surfaces are from each other. Lengths are in units of the cages. */
typedef struct curvopt_deviation {
    double max;            /* largest distance found from a point of either surface to the other one; near
                              extraordinary vertices up to 1 % or 1e-5 of a face too large */
    double rms;            /* root mean square distance of the first surface's points from the second, by area; NAN if
                              cancelled */
    double bound;          /* no point of either surface is farther from the other one. At most 1.2 max, unless that is
                              below 1e-9 size or 1e-4 of a face at an extraordinary vertex; larger also if cancelled,
                              or if 20 million steps of Newton's method did not do */
    double size;           /* root mean square distance of the first cage's vertices from their centroid */
    double point[3];       /* the point of the first surface, */
    double other_point[3]; /* and that of the second, whose distance is max; both NAN, and max 0, if it was cancelled
                              before any point was measured */
} curvopt_deviation;

/* Measures from the limit surface of a cage xyz [3 n_vertices] to that of another one, other_xyz [3 n_vertices of the
 * other], and back (Hausdorff distance), whatever the surface that was optimized. All faces count, also those that are
 * left out of energies. The cages need not have the same faces: matching is by nearest points.
 *   threads: as in the options. cancel may be NULL; a cancelled measurement is OK, with a larger bound.
 *   distances [n_vertices of the other]: how far the limit points of the other cage's vertices are from the first
 *     surface, near extraordinary vertices up to 2.5 % of max or 1e-5 of a face too large; NAN for isolated vertices,
 *     and where it was cancelled before. May be NULL.
 * `bound` holds up to rounding, by convex hulls of control nets, or where one cage is the other one subdivided and
 * moved, by how far its vertices have moved; only the extent of the tips at extraordinary vertices,
 * 1 % of max or 2e-5 of a face, is an estimate. ERROR_ARGUMENT, ERROR_TOPOLOGY (vertices of 16383 faces),
 * ERROR_GEOMETRY (not finite, zero size), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_measure_deviation(const curvopt_mesh *mesh, const double *xyz, const curvopt_mesh *other,
                                              const double *other_xyz, int32_t threads, const curvopt_cancel *cancel,
                                              curvopt_deviation *out, size_t size, double *distances,
                                              curvopt_error *error);

/* How often a limit surface crosses itself. */
typedef struct curvopt_crossings {
    int32_t n_pairs;      /* pairs of faces whose surfaces cross: Newton's method found a common point, to 1e-10 of the
                             size, at which their tangent planes are at least 1e-3 radians apart */
    int32_t n_contacts;   /* pairs of faces that come that close, but with nearly parallel tangent planes wherever it
                             was looked: they touch, cross at a small angle, or lie on each other */
    int32_t n_unresolved; /* pairs of faces not decided: parts of 1/256 of a face still may meet, and no common point
                             was found */
    int32_t n_listed;     /* pairs written to the caller's array: n_pairs or its room, whichever is less */
    int32_t is_complete;  /* 1: everything was looked at; 0: cancelled, and there may be more */
    int32_t reserved;     /* 0 */
} curvopt_crossings;

/* Finds where the limit surface of a cage xyz [3 n_vertices] crosses itself. A pair is (f, g), f <= g, with f = g for a
 * face that crosses itself. All faces count, also those that are left out of energies.
 *   threads: as in the options. cancel may be NULL; a cancelled search is OK, and has what it found.
 *   pairs [2 n_room]: the first pairs, ascending; NULL if n_room is 0.
 * What is proven: pairs that are in none of the counts do not cross, up to rounding. For neighbours (faces, or parts of
 * one, that share an edge or a vertex) this is by a cone of directions, and where three or more parts share a vertex
 * the outline of their projection is not looked at; folds of neighbours smaller than 1/256 of a face, and what is
 * nearer than that to an extraordinary vertex, are not seen. ERROR_ARGUMENT, ERROR_TOPOLOGY (vertices of 16383 faces),
 * ERROR_GEOMETRY (not finite, zero size), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_find_crossings(const curvopt_mesh *mesh, const double *xyz, int32_t threads,
                                           const curvopt_cancel *cancel, int32_t n_room, int32_t *pairs,
                                           curvopt_crossings *out, size_t size, curvopt_error *error);

/* Finds the faces at which the limit surface of a cage xyz [3 n_vertices] is folded: at a point of the face it has no
 * tangent plane (a pinch point, Whitney's umbrella), and energies of curvature are infinite. A vertex that was
 * dragged over others, or two corners of a face that have changed places, can fold a cage. Faces that are left out of
 * energies (curvopt_exception) are not looked at.
 *   Of the options the holes and `strict` are read. cancel may be NULL; a cancelled search is OK, and has what it
 * found. folded [n_faces]: 1 for each folded face, else 0; n_folded: how many; either may be NULL. By normals at 81
 * points of each face, or of each part of it where a face is not regular: folds that are smaller are not seen, and a
 * face is marked, too, where such a point is less than an eighth of a face beyond its edge. ERROR_ARGUMENT as
 * curvopt_mesh_find_exceptions, ERROR_TOPOLOGY (vertices of 16383 faces), ERROR_GEOMETRY (not finite, zero size),
 * ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_find_folds(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                       const curvopt_cancel *cancel, int32_t *folded, int32_t *n_folded,
                                       curvopt_error *error);

/* --------------------------------------------------------------------------------------------- minimizing -- */

/* The reason why a run or a level stopped. None of them is an error; each has the best iterate as its result.
 *   CONVERGED   the gradient is below gradient_tolerance, or what the model can still gain below decrement_tolerance
 *               (four times that where second-order terms end with the exact Hessian)
 *   STALLED     no further decrease is possible in floating point
 *   LIMIT       max_iterations steps were made
 *   CANCELLED   the callback or curvopt_cancel_request asked for it; figures that were not known yet are NAN
 *   UNRESOLVED  the surface develops features that the finest quadrature cannot resolve
 *   SETTLED     the energy still falls, but too slowly to go on; GAUSS_NEWTON only
 *   GROWN       an open surface whose boundary is free, in the input's frame and without springs, has become ten
 *               times as large as the cage that the level began with: energies without a size fall as it grows, and
 *               nothing ends that. Levels that would follow are left out */
#define CURVOPT_STOP_LIST(X)                                                                                           \
    X(CONVERGED, 0, "converged")                                                                                       \
    X(STALLED, 1, "stalled")                                                                                           \
    X(LIMIT, 2, "limit")                                                                                               \
    X(CANCELLED, 3, "cancelled")                                                                                       \
    X(UNRESOLVED, 4, "unresolved")                                                                                     \
    X(SETTLED, 5, "settled")                                                                                           \
    X(GROWN, 6, "grown")

typedef enum curvopt_stop {
#define CURVOPT_STOP_ENUM(name, value, text) CURVOPT_ENUMERATOR(STOP, name, value)
    CURVOPT_STOP_LIST(CURVOPT_STOP_ENUM)
#undef CURVOPT_STOP_ENUM
        CURVOPT_STOP_FORCE_INT = 0x7fffffff
} curvopt_stop;
CURVOPT_API const char *curvopt_stop_name(int32_t stop);
CURVOPT_API int32_t curvopt_stop_from_name(const char *name);
/* "converged", "stalled", "limit", "cancelled", "unresolved", "settled", "grown"; never NULL. */
CURVOPT_API const char *curvopt_stop_text(int32_t stop);

typedef struct curvopt_result curvopt_result;

typedef struct curvopt_level_report {
    double energy;        /* as in curvopt_progress, at the end of the level */
    double gradient_norm; /* as in curvopt_progress */
    double seconds;       /* of this level */
    int32_t level;        /* 1 .. levels */
    int32_t n_vertices;   /* of its cage */
    int32_t iterations;   /* accepted steps */
    int32_t evaluations;  /* of the objective */
    int32_t stop;         /* curvopt_stop */
    int32_t reserved;     /* 0 */
} curvopt_level_report;

/* The verdict of the Hessian on the result.
 *   UNKNOWN         not examined: joshi_sequin, cancelled, or more than CURVOPT_MAX_CERTIFIED_VERTICES vertices; or not
 *                   to be had: the Hessian is not positive and has more than CURVOPT_MAX_COUNTED_VARIABLES variables,
 *                   or is singular to rounding
 *   MINIMUM         stationary, and no small change of shape that keeps the symmetries lowers the objective
 *   SADDLE          stationary, with negative directions
 *   NOT_STATIONARY  a Newton decrement is above 1e-6 of the objective: that of the shape, or, with the spacing FREE,
 *                   that over all coordinates */
#define CURVOPT_VERDICT_LIST(X)                                                                                        \
    X(UNKNOWN, 0, "unknown")                                                                                           \
    X(MINIMUM, 1, "minimum")                                                                                           \
    X(SADDLE, 2, "saddle")                                                                                             \
    X(NOT_STATIONARY, 3, "not_stationary")

typedef enum curvopt_verdict {
#define CURVOPT_VERDICT_ENUM(name, value, text) CURVOPT_ENUMERATOR(VERDICT, name, value)
    CURVOPT_VERDICT_LIST(CURVOPT_VERDICT_ENUM)
#undef CURVOPT_VERDICT_ENUM
        CURVOPT_VERDICT_FORCE_INT = 0x7fffffff
} curvopt_verdict;
CURVOPT_API const char *curvopt_verdict_name(int32_t verdict);
CURVOPT_API int32_t curvopt_verdict_from_name(const char *name);
/* "unknown", "minimum", "saddle", "not stationary"; never NULL. */
CURVOPT_API const char *curvopt_verdict_text(int32_t verdict);

typedef struct curvopt_summary {
    double seconds;              /* of the whole run */
    double newton_decrement;     /* 1/2 gradient . Hessian^-1 gradient at the result, over what the run moved at its end
                                    (curvopt_spacing): the gain that the quadratic model predicts. With the Gauss-Newton
                                    matrix where the Hessian has negative directions; NAN if unknown. Both matrices get
                                    the shift 0.1 * objective / n_vertices at root mean square radius 1: curvature below
                                    it counts as 0 */
    double shape_decrement;      /* the same for motion along the cage's normals alone; NAN if the Hessian has negative
                                    directions there, or if unknown */
    int32_t n_levels;            /* levels that were worked on; the last of them perhaps not to its end */
    int32_t stop;                /* curvopt_stop of the last of them */
    int32_t n_vertices;          /* of the result */
    int32_t n_faces;             /* of the result */
    int32_t method;              /* curvopt_method that was used, never AUTO */
    int32_t verdict;             /* curvopt_verdict */
    int32_t negative_directions; /* of the Hessian for motion along the cage's normals that keeps the symmetries,
                                    without the invariances (similarities; where WILLMORE and MEAN are all, Moebius
                                    maps). Tangential motion does not change the shape and does not count. -1: not
                                    counted, or unknown */
    int32_t symmetry_order;      /* symmetries that were kept; 1: none */
    double difference_decrement; /* with options.verify: shape_decrement by a Hessian from finite differences of the
                                    gradient, as the report checked its minima; else NAN */
    int32_t all_negative_directions;  /* with options.verify: over everything that may move, tangential motion included,
                                         no symmetry kept; else -1 */
    int32_t free_negative_directions; /* with options.verify: for motion along normals, no symmetry kept; else -1 */
    int32_t n_held;                   /* vertices of the input cage that were held as exceptions (curvopt_exception) */
    int32_t n_left_out;               /* faces of the input cage that were left out of the energy */
    double curve_deviation;           /* with options.slide: longest distance of the result's limit curves on which
                                         vertices slide from the input's, in units of the cage; else 0 */
    int32_t n_sliding;                /* vertices of the input cage that may slide */
    int32_t n_folded;                 /* faces of the input cage that are folded (curvopt_find_folds); looked for only
                                         where its energies cannot be resolved, else 0 */
    double multiplier[CURVOPT_MAX_SCALARS]; /* by curvopt_scalar: how much the least objective rises for each unit by
                                               which what is held does (Lagrange's): of a volume a pressure, of an
                                               area a tension; 0 where nothing is held */
    double scalar_residual[CURVOPT_MAX_SCALARS]; /* relative distance of each held one from what it is to be, by the
                                                    last level's quadrature; 0 where nothing is held. The area is, too,
                                                    where it alone gives the size */
    double discretization_error; /* how far the energy of the result may be above that of finer and finer nets, by what
                                    the last levels brought; an estimate, no bound. NAN: unknown, as after one level */
    double clearance;            /* with options.no_crossings: least distance of parts of the result that face each
                                    other, at 25 points of each face; in units of the cage. NAN: nothing is as close as
                                    the repulsion reaches, nothing can move, or without the option */
    int32_t n_touching;          /* with options.no_crossings: pairs of faces of the input whose surfaces in the result
                                    are as close, and hold it (curvopt_result_get_touching) */
    int32_t n_crossing_before;   /* the same: pairs of faces of the input that cross, and which still may */
    int32_t n_refused;           /* the same: steps that were shortened because of a crossing */
    int32_t n_unfolded;   /* vertices of the input cage that were put between their neighbours, for it is folded */
    double spring_energy; /* what springs add to the objective at the result: of weights below 1 of constraints and
                             of what the surface goes through, of a strength below 1, and the barrier of
                             `within`. In no reported energy. 0 without any */
    double touch_rise;    /* what the result bears: how much objective and springs rise in the mean where each vertex is
                             moved by CURVOPT_TOUCH mean edges in a random direction, by the Hessian for motion along
                             the cage's normals. NAN: unknown, as the verdict */
    int32_t is_delicate;  /* a minimum of which that is more than 2e-3, as of one whose faces are tiny in places:
                             minimized again after such a touch, it may end elsewhere, lower or higher; of 132
                             results that chose nothing no other one fell. Of several pieces: whether one of them is.
                             0 with a strength below 1 or `within`: from the result these lead elsewhere anyway
                             (libcurvopt/notes/68-a-start-that-stands.md) */
    int32_t reserved;     /* 0 */
} curvopt_summary;

/* The first level of a run at which a vertex may move: mostly 1; more where options.boundary, creases, pins and
 * exceptions hold the whole cage, but not what subdivision puts inside its faces; 0 if there is none among
 * options.levels, and curvopt_minimize would refuse. Quick. ERROR_ARGUMENT, ERROR_TOPOLOGY, ERROR_GEOMETRY,
 * ERROR_SURFACE as curvopt_minimize, ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_find_moving_level(const curvopt_mesh *mesh, const double *xyz,
                                              const curvopt_options *options, int32_t *level, curvopt_error *error);
/* Minimizes the objective over all vertices of the cage, subdivides, repeats. It holds centroid, orientation and size,
 * unless options.boundary, options.constraints or exceptions (curvopt_exception) hold vertices: then these stay exactly
 * where they are. Isolated vertices are carried through, with their numbers, to every level.
 *   A cage of several pieces, of which no two share a vertex, is minimized piece by piece, each as if it were alone,
 * level by level; what options measure by the cage's size (strength, weights of springs) goes by the piece's. Pieces
 * that a symmetry of the whole exchanges, and which nothing holds, are solved once. Figures are of all together:
 * third-order terms of pieces count as in the whole's objective, with the area of all, and spontaneous curvature by the
 * whole's normals. The verdict is the worst one, decrements and negative directions add up, symmetry_order is the
 * largest, and a multiplier is NAN where several pieces have one. With no_crossings, joshi_sequin and the scalar rules
 * VALUE and REDUCED pieces are tied together and minimized as one; then pieces that nothing holds may drift apart and
 * change their sizes. progress, user, cancel may be NULL. Errors as curvopt_problem_create and
 * curvopt_problem_evaluate; ERROR_GEOMETRY for a cage that is not symmetric about a plane of options.symmetry_planes
 * (`element` is the first vertex or face without a partner); ERROR_ARGUMENT where nothing may move on any level. A
 * cancelled or stalled run is OK and has a result.
 *   A cage that is folded (curvopt_find_folds), so that its energies cannot be resolved, is unfolded first: vertices of
 * folded faces, and more round them as far as need be, are put between the others, as a thin plate would lie there
 * (summary.n_unfolded). Held vertices stay. Not with joshi_sequin, a strength below 1 or `within`; and not where that
 * leaves folds: then the run begins as it is given. A level on which the surface comes to fold where quadrature does
 * not see it in time begins again with a tenth of options.tolerance, and if need be with a hundredth; not with
 * joshi_sequin or no_crossings. A run that ends UNRESOLVED and higher than its input has the input as its result,
 * subdivided as often, unless places or numbers are held. */
CURVOPT_API int32_t curvopt_minimize(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                     curvopt_progress_fn progress, void *user, const curvopt_cancel *cancel,
                                     curvopt_result **out, curvopt_error *error);
CURVOPT_API void curvopt_result_destroy(curvopt_result *result);
/* The optimized cage's connectivity, owned by the result, alive as long as it. */
CURVOPT_API const curvopt_mesh *curvopt_result_mesh(const curvopt_result *result);
/* Copies its positions into xyz [3 n_vertices]. */
CURVOPT_API void curvopt_result_get_positions(const curvopt_result *result, double *xyz);
CURVOPT_API void curvopt_result_get_summary(const curvopt_result *result, curvopt_summary *summary, size_t size);
/* Energies of the input cage and of the result; either pointer may be NULL. */
CURVOPT_API void curvopt_result_get_energies(const curvopt_result *result, curvopt_energies *start,
                                             curvopt_energies *end, size_t size);
/* Copies the pairs of faces of the input cage by which the result is held: pairs [2 summary.n_touching], ascending,
 * (f, g) with f <= g. */
CURVOPT_API void curvopt_result_get_touching(const curvopt_result *result, int32_t *pairs);
/* Report of level index 0 .. n_levels - 1; ERROR_ARGUMENT outside. */
CURVOPT_API int32_t curvopt_result_get_level(const curvopt_result *result, int32_t index, curvopt_level_report *report,
                                             size_t size, curvopt_error *error);

/* ------------------------------------------------------------------------------------ a solver that stays -- */

/* One level of a cage, solved again and again: for a surface that follows the hand. What a first solution has made is
 * kept (basis tables, quadrature rules, the pattern and symbolic factors of matrices, the last factor), and the next
 * one starts from where the last one ended, moved along with the targets.
 *
 * A solver belongs to one thread at a time; curvopt_cancel_request alone may come from another while it solves. It has
 * threads of its own (options.threads, when it is created), which sleep between solutions. The same calls in the same
 * order give the same bits, with any number of threads, unless one was cancelled from another thread. */
typedef struct curvopt_solver curvopt_solver;

/* Copies the mesh, xyz [3 n_vertices] and all that the options point to. There is no subdivision: options.levels is not
 * read. The symmetries AUTO are those of KEEP. Of a cage of several pieces those in which nothing is held or drawn, if
 * there are others, stay as they are and are left out of the energy, unless a scalar rule VALUE or REDUCED ties pieces
 * together. What refers to the input (strength, scalars to KEEP, places that are NAN, springs, half discs of
 * POLYNOMIAL) refers to this xyz as long as the solver lives. A folded cage is unfolded as by curvopt_minimize, and the
 * solver stands there. Nothing is solved yet. Errors as curvopt_minimize; ERROR_UNSUPPORTED: joshi_sequin, LMVM or
 * slide. */
CURVOPT_API int32_t curvopt_solver_create(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options,
                                          curvopt_solver **out, curvopt_error *error);
CURVOPT_API void curvopt_solver_destroy(curvopt_solver *solver);
/* Where the constraints of the options go through from now on: places [3 n] as in curvopt_constraints, in its order.
 * This is what is cheap: all that is kept stays, unless the places break symmetries that the solver keeps; these are
 * given up then, until curvopt_solver_set_positions(). On failure nothing has changed. ERROR_ARGUMENT: no constraints,
 * a place that is not finite nor three NANs, or what curvopt_constraints refuses; ERROR_GEOMETRY: places that break
 * planes of options.symmetry_planes. */
CURVOPT_API int32_t curvopt_solver_set_places(curvopt_solver *solver, const double *places, curvopt_error *error);
/* Other options, with their constraints: another energy, strength, tolerance, other vertices held. It goes on from
 * where it stands. Basis tables are kept where the surface is the same; the rest is made anew by the next solution. Not
 * read: levels and threads. On failure nothing has changed. Errors as curvopt_solver_create. */
CURVOPT_API int32_t curvopt_solver_set_options(curvopt_solver *solver, const curvopt_options *options,
                                               curvopt_error *error);
/* It stands at xyz [3 n_vertices] from now on, or, if that is NULL, where it was created. What is held goes from there
 * to its places in the next solution. Symmetries that were given up are looked for again. On failure nothing has
 * changed. ERROR_GEOMETRY (not finite, zero size), ERROR_MEMORY. */
CURVOPT_API int32_t curvopt_solver_set_positions(curvopt_solver *solver, const double *xyz, curvopt_error *error);
/* From where it stands to its targets. With settle 0 to where the energy falls by little any more, for a state that
 * passes: there is no verdict, and figures are by the rules that there are. With settle 1 to the optimum, with the
 * figures and the verdict of curvopt_minimize. As long as it is the same minimum it does not depend on the way there.
 *
 * With an even spacing the objective and what that is worth are minimized together, to the end, before vertices move
 * along normals; curvopt_minimize goes on to these earlier, and ends in a cage that is spaced a little otherwise.
 *
 * progress, user and cancel are as in curvopt_minimize and may be NULL. The first call of progress is the first answer
 * to targets that have moved: they are at their places, and the others have moved along to first order. Its energy is
 * without what motion along normals brings in the end. A cancelled solution is OK; the solver stands where it got to
 * and can go on. A flag stays raised: the next solution takes another one.
 *
 * Where the surface is degenerate at its targets, as where two of them coincide, the error is ERROR_GEOMETRY; the
 * solver then stands where it stood, and goes on with other targets. If it cannot begin where it stands, as with new
 * springs, it begins at its first cage. Other errors as curvopt_minimize. */
CURVOPT_API int32_t curvopt_solver_solve(curvopt_solver *solver, int32_t settle, curvopt_progress_fn progress,
                                         void *user, const curvopt_cancel *cancel, curvopt_error *error);
/* Copies where it stands into xyz [3 n_vertices]. */
CURVOPT_API void curvopt_solver_get_positions(const curvopt_solver *solver, double *xyz);
/* Of the last solution; n_levels is 0 before the first one. */
CURVOPT_API void curvopt_solver_get_summary(const curvopt_solver *solver, curvopt_summary *summary, size_t size);
/* Energies of the cage that it was created with, and of the last solution (all 0 before the first one, NAN where they
 * are not known); either pointer may be NULL. */
CURVOPT_API void curvopt_solver_get_energies(const curvopt_solver *solver, curvopt_energies *start,
                                             curvopt_energies *end, size_t size);
/* Steps, evaluations and the reason of the end of the last solution. */
CURVOPT_API void curvopt_solver_get_report(const curvopt_solver *solver, curvopt_level_report *report, size_t size);

#ifdef __cplusplus
}
#endif
#endif
