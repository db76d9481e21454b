/* What the user wants the surface to go through. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/given_through.h"

#include "base/memory.h"
#include "base/vec3.h"
#include "constraints/given_chains.h"
#include "mesh/similarity.h"
#include "surface/vertex_mask.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* Cosine up to which a tangent is at right angles to a normal. */
static const double RIGHT_ANGLE = 1e-6;
/* Least cosine of the angle by which a tangent plane or a tangent is turned at the beginning. */
static const double LEAST_COSINE = 1e-3;

/* Least sine of the angle between the tangents that springs draw, by rounding: below, there is no tangent plane. */
static const double LEAST_SINE = 1e-9;

/* Largest curvature, in parts of 1 / size of the input: of springs of 1e9 rounding hides the energy (note 125). */
static const double LARGEST_CURVATURE = 1e6;
/* Distance from where a point is to be that is none, in sizes of the input. */
static const double MET = 1e-9;

/* An entry, checked. */
typedef struct entry {
    int32_t number, vertex, face, corner; /* corner: half-edge, as in co_surface_value */
    double uv[2];
    int32_t freedom;
    double direction[3], place[3]; /* place: NAN where it is not given */
    int has_normal, has_tangent, is_along_v;
    int has_curvatures;
    double normal[3], tangent[3]; /* unit */
    double curvature[9];          /* symmetric tensor */
    double weight;
} entry;

/* A unit vector from number i of an array; `what` names it. */
static int32_t read_unit(const double *from, const entry *e, const char *what, double out[3], curvopt_error *error) {
    const double *d = from + 3 * (size_t)e->number, length = co_length3(d);
    if (!(length > 0) || !isfinite(length))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, e->number, "entry %d has the %s %g %g %g", e->number, what,
                              d[0], d[1], d[2]);
    for (int c = 0; c < 3; c++)
        out[c] = d[c] / length;
    return CURVOPT_OK;
}

/* Whether number i of an array is left out. */
static int is_absent(const double *from, int32_t i) {
    const double *d = from ? from + 3 * (size_t)i : NULL;
    return !d || (isnan(d[0]) && isnan(d[1]) && isnan(d[2]));
}

/* ------------------------------------------------------------------------------------------ where it is -- */

/* A half-edge that leaves vertex v, to w if that is not -1; -1 if there is none. */
static int32_t half_edge(const curvopt_mesh *m, int32_t v, int32_t w) {
    const int32_t first = m->vertex_corner[v];
    int32_t h = first;
    while (h >= 0 && w >= 0 && co_mesh_destination(m, h) != w) {
        h = co_mesh_rotate(m, h);
        if (h == first)
            return -1;
    }
    return h;
}

static int32_t read_vertex(const curvopt_mesh *m, const curvopt_through *t, entry *e, curvopt_error *error) {
    const int32_t i = e->number, v = e->vertex, to = e->has_tangent && t->toward ? t->toward[i] : -1;
    if (v >= m->info.n_vertices)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d is at vertex %d; there are %d vertices", i, v,
                              m->info.n_vertices);
    if (!co_vertex_mask_exists(m, v))
        return co_status_fail(
            error, CURVOPT_ERROR_ARGUMENT, i,
            "entry %d is at the limit point of vertex %d, where a crease fades or ends, or there is no "
            "surface",
            i, v);
    if (e->has_curvatures && co_vertex_mask_has_tangents(m, v) && !co_vertex_mask_has_second(m, v))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "entry %d holds curvatures at vertex %d: vertices have them only where four faces meet; "
                              "take a point inside a face",
                              i, v);
    if ((e->has_normal || e->has_tangent) && !co_vertex_mask_has_tangents(m, v))
        return co_status_fail(
            error, CURVOPT_ERROR_ARGUMENT, i,
            "entry %d holds a normal or tangent at vertex %d, which is on a boundary or a crease: these "
            "can be held only where the surface is smooth all round",
            i, v);
    e->corner = half_edge(m, v, to);
    if (e->has_tangent && (to < 0 || e->corner < 0))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "entry %d holds the tangent at vertex %d toward %d, but no edge goes there", i, v, to);
    return CURVOPT_OK;
}

static int32_t read_place_on_face(const curvopt_mesh *m, const curvopt_through *t, entry *e, curvopt_error *error) {
    const int32_t i = e->number, f = t->faces ? t->faces[i] : -1, corner = t->corners ? t->corners[i] : 0;
    if (f < 0 || f >= m->info.n_faces)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d is on face %d; there are %d faces", i, f,
                              m->info.n_faces);
    const int is_quad = co_mesh_face_size(m, f) == 4;
    if (corner < 0 || corner >= (is_quad ? 1 : co_mesh_face_size(m, f)))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "entry %d is at corner %d of face %d; it must be 0 to %d", i, corner, f,
                              is_quad ? 0 : co_mesh_face_size(m, f) - 1);
    const double u = t->uv ? t->uv[2 * (size_t)i] : (double)NAN, v = t->uv ? t->uv[2 * (size_t)i + 1] : (double)NAN;
    const int u_ends = u == 0 || u == 1, v_ends = v == 0 || v == 1;
    if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d has u = %g, v = %g; they must be 0 to 1", i,
                              u, v);
    if (is_quad ? u_ends && v_ends : u == v && u_ends)
        return co_status_fail(
            error, CURVOPT_ERROR_ARGUMENT, i,
            "entry %d, u = %g, v = %g of face %d, is at a vertex, or in the middle of a face that is no "
            "quad: give the vertex itself, or subdivide the cage once",
            i, u, v, f);
    const int32_t along = e->has_tangent && t->toward ? t->toward[i] : 0;
    if (along < 0 || along > 1)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "entry %d holds the tangent along %d; inside a face it is 0, along u, or 1, along v", i,
                              along);
    e->face = f;
    e->corner = m->face_start[f] + corner;
    e->uv[0] = u;
    e->uv[1] = v;
    e->is_along_v = along;
    return CURVOPT_OK;
}

/* ----------------------------------------------------------------------------------------- what is said -- */

static int32_t read_point(const curvopt_through *t, entry *e, curvopt_error *error) {
    const int32_t i = e->number;
    const double *p = is_absent(t->places, i) ? NULL : t->places + 3 * (size_t)i;
    e->freedom = t->freedom ? t->freedom[i] : CO_FREEDOM_NONE;
    if (e->freedom < CO_FREEDOM_NONE || e->freedom > CO_FREEDOM_ALL)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "entry %d leaves its point %d dimensions; it must be 0 to 3", i, e->freedom);
    if (p && !(isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2])))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d has the place %g %g %g", i, p[0], p[1], p[2]);
    if (p && e->freedom == CO_FREEDOM_ALL)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d has a place, but its point is free", i);
    for (int c = 0; c < 3; c++)
        e->place[c] = p ? p[c] : (double)NAN;
    if (e->freedom != CO_FREEDOM_LINE && e->freedom != CO_FREEDOM_PLANE)
        return CURVOPT_OK;
    if (!t->directions)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d has no direction", i);
    return read_unit(t->directions, e, "direction", e->direction, error);
}

static int32_t read_frame(const curvopt_through *t, entry *e, curvopt_error *error) {
    int32_t status = CURVOPT_OK;
    e->has_normal = !is_absent(t->normals, e->number);
    e->has_tangent = !is_absent(t->tangents, e->number);
    if (e->has_normal)
        status = read_unit(t->normals, e, "normal", e->normal, error);
    if (status == CURVOPT_OK && e->has_tangent)
        status = read_unit(t->tangents, e, "tangent", e->tangent, error);
    if (status != CURVOPT_OK || !e->has_normal || !e->has_tangent)
        return status;
    const double part = co_dot3(e->normal, e->tangent);
    if (fabs(part) > RIGHT_ANGLE)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, e->number,
                              "entry %d has a tangent that is not at right angles to its normal: the cosine is %.3g",
                              e->number, part);
    for (int c = 0; c < 3; c++)
        e->tangent[c] -= part * e->normal[c];
    return CURVOPT_OK;
}

/* Refuses what k1 and k2 [2] and the direction of k1, if it has one, cannot be. */
static int32_t check_curvatures(const entry *e, const double *k, const double *direction, curvopt_error *error) {
    const int32_t i = e->number;
    const char *what = !e->has_normal               ? "curvatures, but no normal"
                       : !direction && k[0] != k[1] ? "two curvatures, but no direction of the first one, nor a tangent"
                                                    : NULL;
    if (!isfinite(k[0]) || !isfinite(k[1]))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d has the curvatures %g and %g", i, k[0], k[1]);
    if (what)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d has %s", i, what);
    const double part = direction ? co_dot3(e->normal, direction) : 0;
    if (fabs(part) > RIGHT_ANGLE)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i,
                              "entry %d has a direction of curvature that is not at right angles to its normal: the "
                              "cosine is %.3g",
                              i, part);
    return CURVOPT_OK;
}

/* k2 (1 - n n) + (k1 - k2) d d, with k1 in the direction d. */
static void make_curvature(entry *e, const double *k, const double *direction) {
    double d[3] = {0};
    const double part = direction ? co_dot3(e->normal, direction) : 0;
    for (int c = 0; direction && c < 3; c++)
        d[c] = direction[c] - part * e->normal[c];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            e->curvature[3 * r + c] = k[1] * ((r == c) - e->normal[r] * e->normal[c]) + (k[0] - k[1]) * d[r] * d[c];
}

static int32_t read_curvatures(const curvopt_through *t, entry *e, curvopt_error *error) {
    const int32_t i = e->number;
    const double *k = t->curvatures ? t->curvatures + 2 * (size_t)i : NULL;
    const int has_own = !is_absent(t->curvature_directions, i);
    double own[3] = {0};
    if (!k || (isnan(k[0]) && isnan(k[1])))
        return CURVOPT_OK;
    int32_t status = has_own ? read_unit(t->curvature_directions, e, "direction of curvature", own, error) : CURVOPT_OK;
    const double *direction = has_own ? own : e->has_tangent ? e->tangent : NULL;
    if (status == CURVOPT_OK)
        status = check_curvatures(e, k, direction, error);
    if (status != CURVOPT_OK)
        return status;
    e->has_curvatures = 1;
    make_curvature(e, k, direction);
    return CURVOPT_OK;
}

static int32_t read_weight(const curvopt_through *t, entry *e, curvopt_error *error) {
    const int32_t i = e->number;
    e->weight = t->weights ? co_constraint_weight(t->weights[i]) : 1;
    if (e->weight >= 0 && e->weight <= 1)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d has the weight %g; it must be 0 to 1", i,
                          e->weight);
}

static int32_t read_entry(const curvopt_mesh *m, const curvopt_through *t, int32_t i, entry *e, curvopt_error *error) {
    *e = (entry){.number = i, .vertex = t->vertices ? t->vertices[i] : -1, .face = -1};
    int32_t status = read_point(t, e, error);
    if (status == CURVOPT_OK)
        status = read_frame(t, e, error);
    if (status == CURVOPT_OK)
        status = read_curvatures(t, e, error);
    if (status == CURVOPT_OK)
        status = read_weight(t, e, error);
    if (status == CURVOPT_OK && e->freedom == CO_FREEDOM_ALL && !e->has_normal && !e->has_tangent)
        status = co_status_fail(error, CURVOPT_ERROR_ARGUMENT, i, "entry %d holds nothing", i);
    if (status != CURVOPT_OK)
        return status;
    return e->vertex >= 0 ? read_vertex(m, t, e, error) : read_place_on_face(m, t, e, error);
}

enum { MOST_VALUES = 6 }; /* of an entry: its point, two tangents and three second derivatives */

/* Second derivatives of an entry, of which nothing is held before its tangents are known (held_curvatures.h). */
static void add_second(const entry *e, const co_surface_value *at, co_surface_values *fs) {
    for (int k = 0; k < 3; k++) {
        co_surface_value *f = &fs->item[fs->n++];
        *f = *at;
        f->order = 2;
        f->along[k] = 1;
        f->freedom = CO_FREEDOM_PLANE;
        memcpy(f->direction, e->normal, sizeof f->direction);
        memcpy(f->curvature, e->curvature, sizeof f->curvature);
    }
}

static void add_values(const entry *e, co_surface_values *fs) {
    const co_surface_value at = {.number = e->number,
                                 .vertex = e->vertex,
                                 .corner = e->corner,
                                 .uv = {e->uv[0], e->uv[1]},
                                 .pivot = -1,
                                 .stiffness = e->weight < 1 ? e->weight / (1 - e->weight) : 0};
    if (e->freedom != CO_FREEDOM_ALL) {
        co_surface_value *f = &fs->item[fs->n++];
        *f = at;
        f->freedom = e->freedom;
        memcpy(f->direction, e->direction, sizeof f->direction);
        memcpy(f->anchor, e->place, sizeof f->anchor);
    }
    for (int k = 0; k < 2; k++) {
        const int is_line = e->has_tangent && k == e->is_along_v;
        if (!is_line && !e->has_normal)
            continue;
        co_surface_value *f = &fs->item[fs->n++];
        *f = at;
        f->order = 1;
        f->along[k] = 1;
        f->freedom = is_line ? CO_FREEDOM_LINE : CO_FREEDOM_PLANE;
        memcpy(f->direction, is_line ? e->tangent : e->normal, sizeof f->direction);
    }
    if (e->has_curvatures)
        add_second(e, &at, fs);
}

/* Whether values i and i + 1 are both tangents of one entry. */
static int is_pair_at(const co_surface_values *fs, int32_t i) {
    const co_surface_value *f = &fs->item[i];
    return i + 1 < fs->n && f[0].order == 1 && f[1].order == 1 && f[0].number == f[1].number;
}

static int32_t no_tangent_plane(const co_surface_value *f, curvopt_error *error) {
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, f->number,
                          "entry %d: the surface has no tangent plane there to begin with", f->number);
}

/* Tangent i that a spring draws gets length 1 on the first cage, and the other one of its entry, if there is one,
 * length 1 at right angles to it; value [3 n]. What they are off by is then the sine of an angle, whatever the
 * parameters are.
 */
static int32_t scale_tangents(co_surface_values *fs, int32_t i, const double *value, curvopt_error *error) {
    const int is_pair = is_pair_at(fs, i);
    const int32_t first = i + (is_pair && fs->item[i + 1].freedom == CO_FREEDOM_LINE), second = 2 * i + 1 - first;
    const double *t = value + 3 * (size_t)first;
    double *along = fs->item[first].along, length = co_length3(t), rest[3];
    int status = length > 0 && isfinite(1 / length) ? CURVOPT_OK : no_tangent_plane(&fs->item[first], error);
    for (int k = 0; status == CURVOPT_OK && k < 2; k++)
        along[k] /= length;
    if (!is_pair || status != CURVOPT_OK)
        return status;
    const double *other = value + 3 * (size_t)second, part = co_dot3(other, t) / length;
    for (int c = 0; c < 3; c++)
        rest[c] = other[c] - part * t[c] / length;
    length = co_length3(rest);
    if (!(length > LEAST_SINE * co_length3(other)))
        return no_tangent_plane(&fs->item[second], error);
    for (int k = 0; k < 2; k++)
        fs->item[second].along[k] = (fs->item[second].along[k] - part * along[k]) / length;
    return CURVOPT_OK;
}

/* Second derivatives from i on, which a spring draws, become those along the tangents before them. */
static void follow_tangents(co_surface_values *fs, int32_t i) {
    const double *a = fs->item[i - 2].along, *b = fs->item[i - 1].along;
    for (int k = 0; k < 3; k++) {
        const double *s = k < 2 ? a : b, *t = k ? b : a;
        fs->item[i + k].along[0] = s[0] * t[0];
        fs->item[i + k].along[1] = s[0] * t[1] + s[1] * t[0];
        fs->item[i + k].along[2] = s[1] * t[1];
    }
}

/* Refuses curvatures that are too large for a surface of this size. */
static int32_t check_size(const co_surface_value *f, double size, curvopt_error *error) {
    double square = 0;
    for (int i = 0; i < 9; i++)
        square += size * f->curvature[i] * size * f->curvature[i];
    if (square <= LARGEST_CURVATURE * LARGEST_CURVATURE)
        return CURVOPT_OK;
    return co_status_fail(
        error, CURVOPT_ERROR_ARGUMENT, f->number,
        "entry %d has curvatures that are too large: a radius is less than %g of the surface's size, %g", f->number,
        1 / LARGEST_CURVATURE, size);
}

/* Refuses places that are too far for a surface of this size. */
static int32_t check_place(const co_surface_value *f, const double origin[3], double size, curvopt_error *error) {
    const double *p = f->anchor;
    if (co_similarity_reaches(origin, size, p))
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, f->number,
                          "entry %d has the place %g %g %g, which is more than %g times the surface's size away",
                          f->number, p[0], p[1], p[2], CO_SIMILARITY_FARTHEST);
}

/* Points without a place are held where they are; springs draw tangents of length 1. */
static int32_t find_places(const curvopt_mesh *m, const double *xyz, co_surface_values *fs, curvopt_error *error) {
    double origin[3], *value = CO_NEW(double, 3 * (size_t)fs->n);
    const double size = co_similarity_mesh_frame(m, xyz, origin);
    int32_t status = value ? co_surface_values_make_rows(m, fs, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK)
        co_sparse_rows_apply(&fs->rows, xyz, value);
    for (int32_t i = 0; status == CURVOPT_OK && i < fs->n; i++) {
        co_surface_value *f = &fs->item[i];
        const int follows = i > 0 && is_pair_at(fs, i - 1);
        if (isnan(f->anchor[0]))
            memcpy(f->anchor, value + 3 * (size_t)i, sizeof f->anchor);
        if (f->order == 0)
            status = check_place(f, origin, size, error);
        if (f->order == 1 && f->stiffness > 0 && !follows)
            status = scale_tangents(fs, i, value, error);
        if (f->order == 2 && f[-1].order == 1) {
            if (f->stiffness > 0)
                follow_tangents(fs, i);
            status = check_size(f, size, error);
        }
    }
    free(value);
    return status;
}

/* Whether a point at x is as far from where it is held as rounding leaves it. */
static int is_met(const co_surface_value *f, const double x[3], double size) {
    double d[3], rest = 0;
    for (int c = 0; c < 3; c++)
        d[c] = x[c] - f->anchor[c];
    const double along = f->freedom == CO_FREEDOM_NONE ? 0 : co_dot3(d, f->direction);
    for (int c = 0; c < 3; c++) {
        const double part = along * f->direction[c], off = f->freedom == CO_FREEDOM_PLANE ? part : d[c] - part;
        rest += off * off;
    }
    return sqrt(rest) <= MET * size;
}

/* Whether all vertices of value i are held themselves. */
static int hangs_on_held(const co_constraints *all, const co_sparse_rows *rows, int32_t i) {
    for (size_t e = rows->start[i]; e < rows->start[i + 1]; e++)
        if (all->freedom[rows->column[e]] != CO_FREEDOM_NONE || all->of_limit[rows->column[e]])
            return 0;
    return 1;
}

/* Points that are where they are to be, and cannot move: what is chosen may reach into a boundary that is held. */
static int32_t find_what_stands(const curvopt_mesh *m, const double *xyz, int32_t boundary, co_constraints *c,
                                curvopt_error *error) {
    co_surface_values *fs = &c->values;
    co_constraints all = {0};
    double origin[3], *at = CO_NEW(double, 3 * (size_t)(m->info.n_vertices + fs->n)), *value = at;
    const double size = co_similarity_mesh_frame(m, xyz, origin);
    int32_t status = at ? co_constraints_all(m, c, boundary, &all, error) : co_status_no_memory(error);
    if (status == CURVOPT_OK) {
        memcpy(at, xyz, 3 * sizeof *at * (size_t)m->info.n_vertices);
        for (int32_t v = 0; v < m->info.n_vertices; v++)
            if (!c->of_limit[v])
                co_constraints_put_back(c, v, at + 3 * (size_t)v);
        value = at + 3 * (size_t)m->info.n_vertices;
        co_sparse_rows_apply(&fs->rows, at, value);
    }
    for (int32_t i = 0; status == CURVOPT_OK && i < fs->n; i++)
        fs->item[i].stands = fs->item[i].order == 0 && hangs_on_held(&all, &fs->rows, i) &&
                             is_met(&fs->item[i], value + 3 * (size_t)i, size);
    co_constraints_free(&all);
    free(at);
    return status;
}

/* What options stand against. */
static int32_t check_options(const curvopt_options *o, curvopt_error *error) {
    const char *what = o->strength < 1 ? "a strength below 1"
                       : o->within > 0 ? "a distance that the surface stays within"
                                       : NULL;
    if (!what)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "what the surface goes through cannot be had with %s",
                          what);
}

int32_t co_given_through_take(const curvopt_through *from, curvopt_through *out, curvopt_error *error) {
    const int32_t size = from->struct_size;
    *out = (curvopt_through){0};
    if (size < (int32_t)offsetof(curvopt_through, toward) || size % 8 || size > (int32_t)sizeof *out)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "through: struct_size is %d; here it is %d", size,
                              (int)sizeof *out);
    memcpy(out, from, (size_t)size);
    if (out->n < 0)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "through: %d entries", out->n);
    if (out->n_chains < 0 || (out->n_chains > 0 && !out->chains))
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "through: %d chains, which are %s", out->n_chains,
                              out->chains ? "given" : "NULL");
    if (out->reserved)
        return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, -1, "through: reserved is %d; it must be 0",
                              out->reserved);
    return CURVOPT_OK;
}

/* Reads the entries into constraints->values, and those that springs draw into constraints->drawn. */
static int32_t read_entries(const curvopt_mesh *m, const curvopt_through *t, co_constraints *constraints,
                            curvopt_error *error) {
    co_surface_values *held = &constraints->values, *drawn = &constraints->drawn;
    held->item = CO_NEW(co_surface_value, MOST_VALUES * (size_t)t->n + 2 * (size_t)t->n_chains);
    drawn->item = CO_NEW(co_surface_value, MOST_VALUES * (size_t)t->n);
    if (!held->item || !drawn->item)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < t->n; i++) {
        entry e;
        int32_t status = read_entry(m, t, i, &e, error);
        if (status != CURVOPT_OK)
            return status;
        if (e.weight > 0)
            add_values(&e, e.weight < 1 ? drawn : held);
    }
    return CURVOPT_OK;
}

int32_t co_given_through_create(const curvopt_mesh *m, const double *xyz, const curvopt_options *options,
                                co_constraints *constraints, curvopt_error *error) {
    curvopt_through t;
    if (!options->through)
        return CURVOPT_OK;
    int32_t status = co_given_through_take(options->through, &t, error);
    if (status == CURVOPT_OK && (t.n > 0 || t.n_chains > 0))
        status = check_options(options, error);
    if (status != CURVOPT_OK || (t.n == 0 && t.n_chains == 0))
        return status;
    const int has_freedom = constraints->freedom != NULL;
    status = read_entries(m, &t, constraints, error);
    if (status == CURVOPT_OK && constraints->values.n + constraints->drawn.n + t.n_chains > 0) {
        status = co_constraints_allocate(m->info.n_vertices, constraints, error);
        if (status == CURVOPT_OK && !has_freedom)
            memcpy(constraints->anchor, xyz, 3 * sizeof *xyz * (size_t)m->info.n_vertices);
    }
    if (status == CURVOPT_OK && constraints->values.n)
        status = find_places(m, xyz, &constraints->values, error);
    if (status == CURVOPT_OK && constraints->values.n)
        status = find_what_stands(m, xyz, options->boundary, constraints, error);
    if (status == CURVOPT_OK && constraints->drawn.n)
        status = find_places(m, xyz, &constraints->drawn, error);
    if (status == CURVOPT_OK && t.n_chains)
        status = co_given_chains_create(m, xyz, &t, options->levels, constraints, error);
    const int holds_nothing = constraints->values.n + constraints->drawn.n + constraints->chains.n == 0;
    if (status != CURVOPT_OK || (!has_freedom && holds_nothing))
        co_constraints_free(constraints);
    return status;
}

/* ------------------------------------------------------------------------------------ the first level -- */

static int32_t make_unit(const co_surface_value *f, double d[3], curvopt_error *error) {
    const double length = co_length3(d);
    if (!(length > 0))
        return no_tangent_plane(f, error);
    for (int c = 0; c < 3; c++)
        d[c] /= length;
    return CURVOPT_OK;
}

/* Refuses to turn unit vector `now` to goal or -goal, between which nothing decides at a right angle. */
static int32_t check_turn(const co_surface_value *f, const double now[3], const double goal[3], curvopt_error *error) {
    if (fabs(co_dot3(now, goal)) > LEAST_COSINE)
        return CURVOPT_OK;
    return co_status_fail(error, CURVOPT_ERROR_ARGUMENT, f->number,
                          "entry %d: the surface begins at right angles to the normal or tangent that it is to have "
                          "there",
                          f->number);
}

/* Checks the tangents of value i, and of the next one if both are of one entry. */
static int32_t check_tangents(const co_surface_values *fs, int32_t i, int is_pair, const double *xyz,
                              curvopt_error *error) {
    const co_surface_value *f = &fs->item[i];
    double now[3];
    int32_t status = CURVOPT_OK;
    if (is_pair) {
        co_cross3(xyz + 3 * (size_t)f->pivot, xyz + 3 * (size_t)fs->item[i + 1].pivot, now);
        status = make_unit(f, now, error);
        if (status == CURVOPT_OK)
            status = check_turn(f, now, fs->item[i + (f->freedom == CO_FREEDOM_LINE)].direction, error);
    }
    for (int k = 0; status == CURVOPT_OK && k < 1 + is_pair; k++) {
        if (fs->item[i + k].freedom != CO_FREEDOM_LINE)
            continue;
        memcpy(now, xyz + 3 * (size_t)fs->item[i + k].pivot, sizeof now);
        status = make_unit(f, now, error);
        if (status == CURVOPT_OK)
            status = check_turn(f, now, fs->item[i + k].direction, error);
    }
    return status;
}

int32_t co_given_through_place(const co_constraints *constraints, double *xyz, curvopt_error *error) {
    const co_surface_values *fs = &constraints->values;
    int32_t status = CURVOPT_OK;
    for (int32_t i = 0; status == CURVOPT_OK && i < fs->n; i++) {
        if (fs->item[i].order != 1)
            continue;
        const int is_pair = is_pair_at(fs, i);
        status = check_tangents(fs, i, is_pair, xyz, error);
        i += is_pair;
    }
    for (int32_t i = 0; status == CURVOPT_OK && i < fs->n; i++)
        if (fs->item[i].pivot >= 0)
            co_constraints_put_back(constraints, fs->item[i].pivot, xyz + 3 * (size_t)fs->item[i].pivot);
    return status;
}
