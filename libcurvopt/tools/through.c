/* Files of what the surface goes through. SPDX-License-Identifier: GPL-3.0-or-later */
#include "through.h"

#include "json_reader.h"
#include "platform.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entry that is being read. */
typedef struct entry {
    const json_document *document;
    const json_node *node;
    int32_t number;
    char *message;
    size_t size;
} entry;

void through_free(through_list *list) {
    free(list->integers);
    free(list->reals);
    *list = (through_list){0};
}

static int fail(const entry *e, const char *what) {
    snprintf(e->message, e->size, "entry %d, line %d: %s", (int)e->number, (int)e->node->line, what);
    return 1;
}

static int fail_key(const entry *e, const char *key, const char *what) {
    snprintf(e->message, e->size, "entry %d, line %d: \"%.40s\" %s", (int)e->number, (int)e->node->line, key, what);
    return 1;
}

/* Numbers of a list, as many as there must be. */
static int take_reals(const entry *e, const json_node *list, int32_t n, const char *key, double *out) {
    const json_node *node = e->document->node;
    int good = list->kind == JSON_LIST && list->size == n;
    for (int32_t i = good ? list->first : -1, k = 0; i >= 0; i = node[i].next, k++) {
        good = good && node[i].kind == JSON_NUMBER;
        out[k] = node[i].number;
    }
    return good ? 0 : fail_key(e, key, n == 2 ? "must be a list of two numbers" : "must be a list of three numbers");
}

/* A number that counts something. */
static int take_count(const entry *e, const json_node *value, const char *key, int32_t *out) {
    if (value->kind != JSON_NUMBER || !(value->number >= 0 && value->number <= INT32_MAX) ||
        value->number != floor(value->number))
        return fail_key(e, key, "must be a whole number, 0 or more");
    *out = (int32_t)value->number;
    return 0;
}

/* Every key of an object must be one of these. */
static int check_keys(const entry *e, const json_node *object, const char *const *known) {
    const json_node *node = e->document->node;
    for (int32_t i = object->first; i >= 0; i = node[i].next) {
        int found = 0;
        for (int k = 0; known[k]; k++)
            found |= !strcmp(node[i].key, known[k]);
        if (!found)
            return fail_key(e, node[i].key, "is not known here");
    }
    return 0;
}

static const json_node *member(const entry *e, const char *key) {
    return json_member(e->document, e->node, key);
}

/* Where arrays of curvopt_through have an entry. */
typedef struct slot {
    int32_t *vertex, *face, *corner, *freedom, *toward;
    double *uv, *direction, *place, *normal, *tangent, *weight;
} slot;

static int take_location(const entry *e, const slot *to) {
    const json_node *vertex = member(e, "vertex"), *face = member(e, "face"), *uv = member(e, "uv"),
                    *corner = member(e, "corner");
    *to->vertex = -1;
    if (!vertex == !face)
        return fail(e, "either \"vertex\" or \"face\" says where it is");
    if (vertex && (uv || corner))
        return fail(e, "\"uv\" and \"corner\" are of faces");
    if (vertex)
        return take_count(e, vertex, "vertex", to->vertex);
    if (!uv)
        return fail(e, "a face needs \"uv\": [U, V]");
    return take_count(e, face, "face", to->face) || take_reals(e, uv, 2, "uv", to->uv) ||
           (corner && take_count(e, corner, "corner", to->corner));
}

static int take_point(const entry *e, const slot *to) {
    const json_node *at = member(e, "at"), *line = member(e, "line"), *plane = member(e, "plane");
    if (line && plane)
        return fail(e, "\"line\" and \"plane\" together: give the point where they meet, or its line");
    *to->freedom = line ? 1 : plane ? 2 : at ? 0 : 3;
    if (at && at->kind == JSON_STRING && !strcmp(at->text, "here"))
        at = NULL;
    if (at && at->kind == JSON_STRING)
        return fail_key(e, "at", "must be a list of three numbers, or \"here\"");
    return (at && take_reals(e, at, 3, "at", to->place)) || (line && take_reals(e, line, 3, "line", to->direction)) ||
           (plane && take_reals(e, plane, 3, "plane", to->direction));
}

static int take_frame(const entry *e, const slot *to) {
    static const char *const known[] = {"to", "along", NULL};
    const json_node *normal = member(e, "normal"), *tangent = member(e, "tangent");
    if (normal && take_reals(e, normal, 3, "normal", to->normal))
        return 1;
    if (!tangent)
        return 0;
    const json_node *toward = json_member(e->document, tangent, "to"),
                    *along = json_member(e->document, tangent, "along");
    if (tangent->kind != JSON_OBJECT || !toward || !along)
        return fail(e, "\"tangent\" must be {\"to\": W, \"along\": [X, Y, Z]}");
    if (check_keys(e, tangent, known) || take_reals(e, along, 3, "along", to->tangent))
        return 1;
    if (*to->vertex >= 0)
        return take_count(e, toward, "to", to->toward);
    const int is_u = toward->kind == JSON_STRING && !strcmp(toward->text, "u");
    *to->toward = !is_u;
    return is_u || (toward->kind == JSON_STRING && !strcmp(toward->text, "v"))
               ? 0
               : fail(e, "inside a face \"to\" must be \"u\" or \"v\"");
}

static int take_weight(const entry *e, const slot *to) {
    const json_node *weight = member(e, "weight");
    *to->weight = weight ? weight->number : 1;
    if (weight && !(weight->kind == JSON_NUMBER && weight->number >= 0 && weight->number <= 1))
        return fail_key(e, "weight", "must be a number, 0 to 1");
    return 0;
}

static int take_entry(const entry *e, const slot *to) {
    static const char *const known[] = {"vertex", "face",   "uv",      "corner", "at", "line",
                                        "plane",  "normal", "tangent", "weight", NULL};
    if (e->node->kind != JSON_OBJECT)
        return fail(e, "an object was expected");
    if (check_keys(e, e->node, known) || take_location(e, to) || take_point(e, to) || take_frame(e, to) ||
        take_weight(e, to))
        return 1;
    if (*to->freedom == 3 && isnan(*to->normal) && isnan(*to->tangent))
        return fail(e, "holds nothing: give \"at\", \"line\", \"plane\", \"normal\" or \"tangent\"");
    return 0;
}

/* Arrays for n entries; 1 if memory is out. */
static int make_room(int32_t n, through_list *out) {
    const size_t size = (size_t)n;
    out->integers = calloc(5 * size, sizeof *out->integers);
    out->reals = calloc(15 * size, sizeof *out->reals);
    if (!out->integers || !out->reals)
        return 1;
    for (size_t i = 0; i < 14 * size; i++)
        out->reals[i] = (double)NAN;
    const double *r = out->reals;
    const int32_t *k = out->integers;
    out->given = (curvopt_through){.struct_size = (int32_t)sizeof out->given,
                                   .n = n,
                                   .vertices = k,
                                   .faces = k + size,
                                   .corners = k + 2 * size,
                                   .freedom = k + 3 * size,
                                   .toward = k + 4 * size,
                                   .uv = r,
                                   .directions = r + 2 * size,
                                   .places = r + 5 * size,
                                   .normals = r + 8 * size,
                                   .tangents = r + 11 * size,
                                   .weights = r + 14 * size};
    return 0;
}

static slot slot_of(const through_list *list, int32_t i) {
    const size_t n = (size_t)list->given.n, k = (size_t)i;
    int32_t *integer = list->integers + k;
    double *real = list->reals + 3 * k;
    return (slot){.vertex = integer,
                  .face = integer + n,
                  .corner = integer + 2 * n,
                  .freedom = integer + 3 * n,
                  .toward = integer + 4 * n,
                  .uv = list->reals + 2 * k,
                  .direction = real + 2 * n,
                  .place = real + 5 * n,
                  .normal = real + 8 * n,
                  .tangent = real + 11 * n,
                  .weight = list->reals + 14 * n + k};
}

int through_parse(FILE *file, through_list *out, char *message, size_t size) {
    json_document d;
    *out = (through_list){0};
    if (json_read(file, &d, message, size))
        return 1;
    int failed = d.node[0].kind != JSON_LIST || d.node[0].size == 0;
    if (failed)
        snprintf(message, size, "a list with at least one entry was expected");
    else if (make_room(d.node[0].size, out)) {
        snprintf(message, size, "out of memory");
        failed = 1;
    }
    int32_t number = 0;
    for (int32_t i = d.node[0].first; !failed && i >= 0; i = d.node[i].next, number++) {
        const entry e = {.document = &d, .node = &d.node[i], .number = number, .message = message, .size = size};
        const slot to = slot_of(out, number);
        failed = take_entry(&e, &to);
    }
    json_free(&d);
    if (failed)
        through_free(out);
    return failed;
}

int through_read(const char *path, through_list *out, char *message, size_t size) {
    *out = (through_list){0};
    const int standard_input = !strcmp(path, "-");
    FILE *file = standard_input ? stdin : platform_open(path, "r");
    if (!file) {
        snprintf(message, size, "%s", strerror(errno));
        return 1;
    }
    int failed = through_parse(file, out, message, size);
    if (!standard_input)
        fclose(file);
    return failed;
}
