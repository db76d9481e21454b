/* Which patches have a point in common. SPDX-License-Identifier: GPL-3.0-or-later */
#include "measure/patch_neighbours.h"

#include "base/memory.h"

#include <stdlib.h>

/* Faces round vertices, patches of faces. */
typedef struct survey {
    const curvopt_mesh *mesh;
    const co_patches *patches;
    size_t *faces_at;   /* [n_vertices + 1] */
    int32_t *face;      /* [n_corners] */
    size_t *patches_of; /* [n_faces + 1] */
    int32_t *patch;     /* [n_patches] */
    int32_t *seen;      /* [n_faces] the patch whose neighbours were last looked for in a face */
} survey;

/* Lists of what has each key: start [n_keys + 1], item [n]. */
static void sort_by_key(int32_t n, int32_t n_keys, int32_t (*key)(const survey *, int32_t),
                        int32_t (*value)(const survey *, int32_t), const survey *s, size_t *start, int32_t *item) {
    for (int32_t i = 0; i < n; i++)
        start[key(s, i) + 1]++;
    for (int32_t k = 0; k < n_keys; k++)
        start[k + 1] += start[k];
    for (int32_t i = n; i-- > 0;) /* ends move to beginnings, and back below */
        item[--start[key(s, i) + 1]] = value(s, i);
    for (int32_t k = 0; k < n_keys; k++)
        start[k] = start[k + 1];
    start[n_keys] = (size_t)n;
}

static int32_t vertex_of_corner(const survey *s, int32_t corner) {
    return s->mesh->corner_vertex[corner];
}

static int32_t face_of_corner(const survey *s, int32_t corner) {
    return s->mesh->corner_face[corner];
}

static int32_t face_of_patch(const survey *s, int32_t patch) {
    return s->patches->place[patch].face;
}

static int32_t itself(const survey *s, int32_t patch) {
    (void)s;
    return patch;
}

static int compare(const void *a, const void *b) {
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* Neighbours of a patch, ascending, into `out`; NULL: they are only counted. Returns their number. */
static size_t find(const survey *s, int32_t patch, int32_t stamp, int32_t *out) {
    static const double whole[2] = {0, 1};
    const curvopt_mesh *m = s->mesh;
    const int32_t face = s->patches->place[patch].face;
    const co_location here = co_location_of(&s->patches->place[patch], whole, whole);
    size_t n = 0;
    for (int32_t h = m->face_start[face]; h < m->face_start[face + 1]; h++)
        for (size_t f = s->faces_at[m->corner_vertex[h]]; f < s->faces_at[m->corner_vertex[h] + 1]; f++) {
            const int32_t other = s->face[f];
            if (s->seen[other] == stamp)
                continue;
            s->seen[other] = stamp;
            for (size_t p = s->patches_of[other]; p < s->patches_of[other + 1]; p++) {
                const int32_t q = s->patch[p];
                const co_location there = co_location_of(&s->patches->place[q], whole, whole);
                if (q != patch && co_location_contact(m, &here, &there) == CO_CONTACT_NONE)
                    continue;
                if (out)
                    out[n] = q;
                n++;
            }
        }
    if (out)
        qsort(out, n, sizeof *out, compare);
    return n;
}

static int32_t find_all(survey *s, co_patch_neighbours *out) {
    const int32_t n = s->patches->n_patches, n_faces = s->mesh->info.n_faces;
    sort_by_key(s->mesh->info.n_corners, s->mesh->info.n_vertices, vertex_of_corner, face_of_corner, s, s->faces_at,
                s->face);
    sort_by_key(n, n_faces, face_of_patch, itself, s, s->patches_of, s->patch);
    for (int32_t f = 0; f < n_faces; f++)
        s->seen[f] = -1;
    for (int32_t p = 0; p < n; p++)
        out->start[p + 1] = out->start[p] + find(s, p, p, NULL);
    out->patch = CO_NEW(int32_t, out->start[n]);
    for (int32_t p = 0; out->patch && p < n; p++)
        find(s, p, n + p, out->patch + out->start[p]);
    return out->patch != NULL;
}

int32_t co_patch_neighbours_create(const curvopt_mesh *mesh, const co_patches *patches, co_patch_neighbours *out,
                                   curvopt_error *error) {
    survey s = {.mesh = mesh,
                .patches = patches,
                .faces_at = CO_NEW(size_t, (size_t)mesh->info.n_vertices + 1),
                .face = CO_NEW(int32_t, mesh->info.n_corners),
                .patches_of = CO_NEW(size_t, (size_t)mesh->info.n_faces + 1),
                .patch = CO_NEW(int32_t, patches->n_patches),
                .seen = CO_NEW(int32_t, mesh->info.n_faces)};
    *out = (co_patch_neighbours){.start = CO_NEW(size_t, (size_t)patches->n_patches + 1)};
    const int fits = s.faces_at && s.face && s.patches_of && s.patch && s.seen && out->start && find_all(&s, out);
    free(s.faces_at);
    free(s.face);
    free(s.patches_of);
    free(s.patch);
    free(s.seen);
    if (!fits)
        co_patch_neighbours_free(out);
    return fits ? CURVOPT_OK : co_status_no_memory(error);
}

void co_patch_neighbours_free(co_patch_neighbours *n) {
    free(n->start);
    free(n->patch);
    *n = (co_patch_neighbours){0};
}

int co_patch_neighbours_are(const co_patch_neighbours *n, int32_t one, int32_t other) {
    return bsearch(&other, n->patch + n->start[one], n->start[one + 1] - n->start[one], sizeof *n->patch, compare) !=
           NULL;
}
