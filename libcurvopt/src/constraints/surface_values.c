/* Values of the surface that are constrained. SPDX-License-Identifier: GPL-3.0-or-later */
#include "constraints/surface_values.h"

#include "base/memory.h"
#include "surface/place_rows.h"
#include "surface/vertex_mask.h"

#include <stdlib.h>
#include <string.h>

int32_t co_surface_values_copy(const co_surface_values *from, co_surface_values *to, curvopt_error *error) {
    *to = (co_surface_values){.n = from->n};
    if (!from->n)
        return CURVOPT_OK;
    to->item = CO_NEW(co_surface_value, from->n);
    if (!to->item) {
        to->n = 0;
        return co_status_no_memory(error);
    }
    memcpy(to->item, from->item, (size_t)from->n * sizeof *to->item);
    return CURVOPT_OK;
}

void co_surface_values_free(co_surface_values *f) {
    free(f->item);
    co_sparse_rows_free(&f->rows);
    *f = (co_surface_values){0};
}

/* ----------------------------------------------------------------------------------------- subdivision -- */

/* S_u is the part `factor` of what it was on the level before. Springs draw the same vector on every level; what is
 * held is the derivative by the level's parameters. */
static void shrink(co_surface_value *f, double factor) {
    for (int k = 0; k < 3 && f->stiffness > 0; k++)
        f->along[k] *= f->order == 2 ? 1 / (factor * factor) : 1 / factor;
    for (int c = 0; c < 3 && f->stiffness == 0 && f->order > 0; c++)
        f->anchor[c] *= f->order == 1 ? factor : factor * factor;
}

/* Coefficients by parameters that are turned by so many quarters. */
static void turn(co_surface_value *f, int32_t quarters) {
    const double a = f->along[0], b = f->along[1], c = f->along[2];
    const double tangent[4][2] = {{a, b}, {b, -a}, {-a, -b}, {-b, a}};
    const double second[2][3] = {{a, b, c}, {c, -b, a}};
    if (f->order == 2)
        memcpy(f->along, second[quarters % 2], sizeof second[0]);
    else
        memcpy(f->along, tangent[quarters], sizeof tangent[0]);
}

/* A point of a quad goes into the child at the nearest corner, whose parameters are turned by as many quarters. */
static void into_child(const curvopt_mesh *m, co_surface_value *f) {
    const double u = f->uv[0], v = f->uv[1];
    const int32_t h = f->corner, face = m->corner_face[h];
    int32_t quarter = h - m->face_start[face];
    if (co_mesh_face_size(m, face) == 4) {
        quarter = u < 0.5 ? (v < 0.5 ? 0 : 3) : v < 0.5 ? 1 : 2;
        const double to[4][2] = {{2 * u, 2 * v}, {2 * v, 2 - 2 * u}, {2 - 2 * u, 2 - 2 * v}, {2 - 2 * v, 2 * u}};
        memcpy(f->uv, to[quarter], sizeof f->uv);
        turn(f, quarter);
        shrink(f, 0.5);
    }
    f->corner = 4 * (m->face_start[face] + quarter);
}

void co_surface_values_subdivide(const curvopt_mesh *m, co_surface_values *fs) {
    for (int32_t i = 0; i < fs->n; i++) {
        co_surface_value *f = &fs->item[i];
        f->pivot = -1;
        if (f->vertex < 0) {
            into_child(m, f);
            continue;
        }
        if (f->order)
            shrink(f, co_vertex_mask_tangents_shrink(m, f->vertex));
        f->corner *= 4; /* the child at that corner begins with the half-edge to the middle of the edge */
    }
    co_sparse_rows_free(&fs->rows);
}

/* ------------------------------------------------------------------------------------------------ rows -- */

/* Weights as they are found, in any order. */
typedef struct entry {
    int32_t row, column;
    double value;
} entry;

typedef struct entry_list {
    entry *entry;
    size_t n, room;
    int is_out_of_memory;
    const co_surface_values *of;
    const int32_t *in_face; /* [places] the first value of each place inside a face */
    int32_t at;             /* value whose entries are found */
} entry_list;

static void add(entry_list *list, int32_t row, int32_t column, double value) {
    if (list->n == list->room) {
        const size_t room = list->room ? 2 * list->room : 1024;
        entry *more = CO_NEW(entry, room);
        if (!more) {
            list->is_out_of_memory = 1;
            return;
        }
        if (list->n)
            memcpy(more, list->entry, list->n * sizeof *more);
        free(list->entry);
        list->entry = more;
        list->room = room;
    }
    list->entry[list->n++] = (entry){row, column, value};
}

static void add_point(int32_t vertex, double weight, void *context) {
    entry_list *list = context;
    add(list, list->at, vertex, weight);
}

static void add_tangent(int32_t vertex, const double weight[2], void *context) {
    entry_list *list = context;
    const double *along = list->of->item[list->at].along;
    add(list, list->at, vertex, along[0] * weight[0] + along[1] * weight[1]);
}

static void add_second(int32_t vertex, const double weight[3], void *context) {
    entry_list *list = context;
    const double *along = list->of->item[list->at].along;
    add(list, list->at, vertex, along[0] * weight[0] + along[1] * weight[1] + along[2] * weight[2]);
}

/* Whether values i and k are at the same place inside a face. Those of an entry follow each other, and are found
 * together. */
static int is_same_place(const co_surface_values *fs, int32_t i, int32_t k) {
    const co_surface_value *a = &fs->item[i], *b = &fs->item[k];
    return a->vertex < 0 && b->vertex < 0 && a->corner == b->corner && a->uv[0] == b->uv[0] && a->uv[1] == b->uv[1];
}

static void add_in_face(int32_t place, int32_t vertex, const double weight[CO_PLACE_ROWS], void *context) {
    entry_list *list = context;
    const int32_t first = list->in_face[place];
    for (list->at = first; list->at < list->of->n && is_same_place(list->of, first, list->at); list->at++) {
        const int32_t order = list->of->item[list->at].order;
        if (order == 0)
            add_point(vertex, weight[0], list);
        else if (order == 1)
            add_tangent(vertex, weight + 1, list);
        else
            add_second(vertex, weight + 3, list);
    }
}

static int32_t find_in_faces(const curvopt_mesh *m, const co_surface_values *fs, entry_list *list,
                             curvopt_error *error) {
    int32_t *in_face = CO_NEW(int32_t, fs->n), n = 0;
    co_face_place *place = CO_NEW(co_face_place, fs->n);
    int32_t status = in_face && place ? CURVOPT_OK : co_status_no_memory(error);
    for (int32_t i = 0; status == CURVOPT_OK && i < fs->n; i++) {
        const co_surface_value *f = &fs->item[i];
        if (f->vertex >= 0)
            continue;
        const int32_t face = m->corner_face[f->corner];
        if (i == 0 || !is_same_place(fs, i - 1, i)) {
            place[n] = (co_face_place){face, f->corner - m->face_start[face], {f->uv[0], f->uv[1]}, 0};
            in_face[n++] = i;
        }
        place[n - 1].has_second |= f->order == 2;
    }
    list->in_face = in_face;
    if (status == CURVOPT_OK)
        status = co_place_rows_visit(m, place, n, add_in_face, list, error);
    list->in_face = NULL;
    free(in_face);
    free(place);
    return status;
}

/* Rows from entries, which are added up where they are of one vertex. */
static int32_t gather(const entry_list *list, int32_t n_vertices, co_sparse_rows *rows, curvopt_error *error) {
    const int32_t n = list->of->n;
    size_t *end = CO_NEW(size_t, n);
    int32_t status = end ? co_sparse_rows_allocate(rows, n, n_vertices, list->n, error) : co_status_no_memory(error);
    for (size_t k = 0; status == CURVOPT_OK && k < list->n; k++)
        rows->start[list->entry[k].row + 1]++;
    for (int32_t i = 0; status == CURVOPT_OK && i < n; i++) {
        rows->start[i + 1] += rows->start[i];
        end[i] = rows->start[i];
    }
    for (size_t k = 0; status == CURVOPT_OK && k < list->n; k++) {
        const entry *e = &list->entry[k];
        size_t at = rows->start[e->row];
        while (at < end[e->row] && rows->column[at] != e->column)
            at++;
        if (at == end[e->row])
            rows->column[end[e->row]++] = e->column;
        rows->value[at] += e->value;
    }
    if (status == CURVOPT_OK)
        co_sparse_rows_close_gaps(rows, end);
    free(end);
    return status;
}

int32_t co_surface_values_make_rows(const curvopt_mesh *m, co_surface_values *fs, curvopt_error *error) {
    entry_list list = {.of = fs};
    co_sparse_rows_free(&fs->rows);
    int32_t status = find_in_faces(m, fs, &list, error);
    for (int32_t i = 0; status == CURVOPT_OK && i < fs->n; i++) {
        const co_surface_value *f = &fs->item[i];
        list.at = i;
        if (f->vertex >= 0 && f->order == 2)
            co_vertex_mask_visit_second(m, f->corner, add_second, &list);
        else if (f->vertex >= 0 && f->order)
            co_vertex_mask_visit_tangents(m, f->corner, add_tangent, &list);
        else if (f->vertex >= 0)
            co_vertex_mask_visit(m, f->vertex, add_point, &list);
    }
    if (status == CURVOPT_OK && list.is_out_of_memory)
        status = co_status_no_memory(error);
    if (status == CURVOPT_OK)
        status = gather(&list, m->info.n_vertices, &fs->rows, error);
    free(list.entry);
    return status;
}
