/* What of a cage is held and left out of the energy. SPDX-License-Identifier: GPL-3.0-or-later */
#include "held.h"

#include <stdlib.h>

enum { MOST_PRINTED = 5 }; /* numbers of a reason that people see; JSON has all */

int32_t held_find(const curvopt_mesh *mesh, const double *xyz, const curvopt_options *options, held_list *out,
                  curvopt_error *error) {
    curvopt_mesh_info info;
    curvopt_mesh_get_info(mesh, &info, sizeof info);
    *out = (held_list){.n_vertices = info.n_vertices,
                       .n_faces = info.n_faces,
                       .vertex_reason = malloc(sizeof(int32_t) * (size_t)info.n_vertices),
                       .face_reason = malloc(sizeof(int32_t) * (size_t)info.n_faces)};
    int32_t status = CURVOPT_ERROR_MEMORY;
    if (out->vertex_reason && out->face_reason)
        status = curvopt_mesh_find_exceptions(mesh, xyz, options, out->vertex_reason, out->face_reason, error);
    else
        *error = (curvopt_error){CURVOPT_ERROR_MEMORY, -1, "out of memory"};
    if (status != CURVOPT_OK) {
        held_free(out);
        return status;
    }
    for (int32_t v = 0; v < info.n_vertices; v++)
        out->n_held += out->vertex_reason[v] >= 0;
    for (int32_t f = 0; f < info.n_faces; f++)
        out->n_left_out += out->face_reason[f] >= 0;
    return CURVOPT_OK;
}

void held_free(held_list *held) {
    free(held->vertex_reason);
    free(held->face_reason);
    *held = (held_list){0};
}

static int32_t count(const int32_t *reasons, int32_t n, int32_t reason) {
    int32_t found = 0;
    for (int32_t i = 0; i < n; i++)
        found += reasons[i] == reason;
    return found;
}

/* The first `most` elements of this reason. */
static void put_numbers(FILE *f, const int32_t *reasons, int32_t n, int32_t reason, int32_t most, const char *between) {
    for (int32_t i = 0, found = 0; i < n && found < most; i++)
        if (reasons[i] == reason)
            fprintf(f, "%s%d", found++ ? between : "", i);
}

/* what: one, and several. */
static void print_reason(FILE *f, const char *const what[2], const int32_t *reasons, int32_t n, int32_t reason) {
    int32_t found = count(reasons, n, reason);
    if (!found)
        return;
    fprintf(f, "  %-20s %d %s: ", curvopt_exception_name(reason), found, what[found > 1]);
    put_numbers(f, reasons, n, reason, MOST_PRINTED, " ");
    fprintf(f, "%s (%s)\n", found > MOST_PRINTED ? " .." : "", curvopt_exception_text(reason));
}

void held_print(FILE *f, const held_list *h) {
    static const char *const vertex[2] = {"vertex", "vertices"}, *const face[2] = {"face", "faces"};
    if (h->passed_over && *h->passed_over)
        fprintf(f, "%-22s %s\n", "tags passed over", h->passed_over);
    if (!h->n_held)
        return;
    fprintf(f, "%-22s %d of %d vertices; %d of %d faces are left out of the energy\n", "held as they are", h->n_held,
            h->n_vertices, h->n_left_out, h->n_faces);
    for (int32_t r = 0; r < CURVOPT_N_EXCEPTIONS; r++)
        print_reason(f, vertex, h->vertex_reason, h->n_vertices, r);
    print_reason(f, face, h->face_reason, h->n_faces, CURVOPT_EXCEPTION_HOLE);
}

static void put_list(FILE *f, const char *key, const char *what, const int32_t *reasons, int32_t n, const char *after) {
    int32_t any = 0;
    fprintf(f, "  \"%s\": [", key);
    for (int32_t r = 0; r < CURVOPT_N_EXCEPTIONS; r++) {
        int32_t found = count(reasons, n, r);
        if (!found)
            continue;
        fprintf(f, "%s\n    {\"reason\": \"%s\", \"count\": %d, \"%s\": [", any++ ? "," : "", curvopt_exception_name(r),
                found, what);
        put_numbers(f, reasons, n, r, n, ", ");
        fprintf(f, "]}");
    }
    fprintf(f, "%s]%s", any ? "\n  " : "", after);
}

void held_write_json(FILE *f, const held_list *h) {
    fprintf(f, "  \"n_held\": %d, \"n_left_out\": %d,\n", h->n_held, h->n_left_out);
    put_list(f, "held", "vertices", h->vertex_reason, h->n_vertices, ",\n");
    put_list(f, "left_out", "faces", h->face_reason, h->n_faces, ",\n");
}
