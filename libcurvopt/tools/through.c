/* Files of what the surface goes through. SPDX-License-Identifier: GPL-3.0-or-later */
#include "through.h"

#include "json_reader.h"
#include "platform.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An entry or a chain that is being read. */
typedef struct entry {
    const json_document *document;
    const json_node *node;
    const char *name; /* "entry" or "chain" */
    int32_t number;
    char *message;
    size_t size;
} entry;

void through_free(through_list *list) {
    free(list->integers);
    free(list->reals);
    for (int32_t i = 0; list->chains && i < list->given.n_chains; i++) {
        free((void *)list->chains[i].vertices);
        free((void *)list->chains[i].curve);
        free((void *)list->chains[i].parameters);
    }
    free((void *)list->given.chain_weights);
    free(list->chains);
    *list = (through_list){0};
}

static int fail(const entry *e, const char *what) {
    snprintf(e->message, e->size, "%s %d, line %d: %s", e->name, (int)e->number, (int)e->node->line, what);
    return 1;
}

static int fail_key(const entry *e, const char *key, const char *what) {
    snprintf(e->message, e->size, "%s %d, line %d: \"%.40s\" %s", e->name, (int)e->number, (int)e->node->line, key,
             what);
    return 1;
}

/* Numbers of a list. */
static int take_numbers(const entry *e, const json_node *list, const char *key, double *out) {
    const json_node *node = e->document->node;
    for (int32_t i = list->first, k = 0; i >= 0; i = node[i].next, k++) {
        if (node[i].kind != JSON_NUMBER)
            return fail_key(e, key, "has something else than numbers");
        out[k] = node[i].number;
    }
    return 0;
}

/* As many as there must be. */
static int take_reals(const entry *e, const json_node *list, int32_t n, const char *key, double *out) {
    const json_node *node = e->document->node;
    int good = list->kind == JSON_LIST && list->size == n;
    for (int32_t i = good ? list->first : -1; i >= 0; i = node[i].next)
        good = good && node[i].kind == JSON_NUMBER;
    return good ? take_numbers(e, list, key, out)
                : fail_key(e, key, n == 2 ? "must be a list of two numbers" : "must be a list of three numbers");
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
    double *uv, *direction, *place, *normal, *tangent, *weight, *curvatures, *curvature_direction;
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

static int take_curvatures(const entry *e, const slot *to) {
    const json_node *curvatures = member(e, "curvatures"), *direction = member(e, "curvature_direction");
    if (!curvatures)
        return direction ? fail(e, "\"curvature_direction\" needs \"curvatures\"") : 0;
    if (isnan(*to->normal))
        return fail(e, "\"curvatures\" need a \"normal\"");
    return take_reals(e, curvatures, 2, "curvatures", to->curvatures) ||
           (direction && take_reals(e, direction, 3, "curvature_direction", to->curvature_direction));
}

static int take_weight(const entry *e, double *to) {
    const json_node *weight = member(e, "weight");
    *to = weight ? weight->number : 1;
    if (weight && !(weight->kind == JSON_NUMBER && weight->number >= 0 && weight->number <= 1))
        return fail_key(e, "weight", "must be a number, 0 to 1");
    return 0;
}

static int take_entry(const entry *e, const slot *to) {
    static const char *const known[] = {"vertex", "face",   "uv",      "corner", "at",         "line",
                                        "plane",  "normal", "tangent", "weight", "curvatures", "curvature_direction",
                                        NULL};
    if (e->node->kind != JSON_OBJECT)
        return fail(e, "an object was expected");
    if (check_keys(e, e->node, known) || take_location(e, to) || take_point(e, to) || take_frame(e, to) ||
        take_curvatures(e, to) || take_weight(e, to->weight))
        return 1;
    if (*to->freedom == 3 && isnan(*to->normal) && isnan(*to->tangent))
        return fail(e, "holds nothing: give \"at\", \"line\", \"plane\", \"normal\" or \"tangent\"");
    return 0;
}

/* Arrays for n entries; 1 if memory is out. */
static int make_room(int32_t n, through_list *out) {
    const size_t size = (size_t)n;
    out->integers = calloc(5 * size + 1, sizeof *out->integers);
    out->reals = calloc(20 * size + 1, sizeof *out->reals);
    if (!out->integers || !out->reals)
        return 1;
    for (size_t i = 0; i < 19 * size; i++)
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
                                   .curvature_directions = r + 14 * size,
                                   .curvatures = r + 17 * size,
                                   .weights = r + 19 * size};
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
                  .curvature_direction = real + 14 * n,
                  .curvatures = list->reals + 17 * n + 2 * k,
                  .weight = list->reals + 19 * n + k};
}

/* -------------------------------------------------------------------------------------------------- chains -- */

static int take_flag(const entry *e, const char *key, int32_t *out) {
    const json_node *value = member(e, key);
    *out = value && value->kind == JSON_TRUE;
    return value && value->kind != JSON_TRUE && value->kind != JSON_FALSE ? fail_key(e, key, "must be true or false")
                                                                          : 0;
}

/* The list under a key, which has `least` elements. NULL with a message. */
static const json_node *find_list(const entry *e, const char *key, int32_t least) {
    const json_node *list = member(e, key);
    if (list && list->kind == JSON_LIST && list->size >= least)
        return list;
    fail_key(e, key, least == 1 ? "must be a list of at least one point" : "must be a list of at least two vertices");
    return NULL;
}

static int take_vertices(const entry *e, curvopt_chain *to) {
    const json_node *node = e->document->node, *list = find_list(e, "vertices", 2);
    int32_t *out = list ? calloc((size_t)list->size, sizeof *out) : NULL;
    to->vertices = out;
    to->n_vertices = list ? list->size : 0;
    if (!out)
        return list ? fail(e, "out of memory") : 1;
    for (int32_t i = list->first, k = 0; i >= 0; i = node[i].next, k++)
        if (take_count(e, &node[i], "vertices", &out[k]))
            return 1;
    return 0;
}

static int take_curve(const entry *e, curvopt_chain *to) {
    const json_node *node = e->document->node, *list = find_list(e, "curve", 1);
    double *out = list ? calloc(3 * (size_t)list->size, sizeof *out) : NULL;
    to->curve = out;
    to->n_points = list ? list->size : 0;
    if (!out)
        return list ? fail(e, "out of memory") : 1;
    for (int32_t i = list->first, k = 0; i >= 0; i = node[i].next, k++) {
        const entry at = {e->document, &node[i], e->name, e->number, e->message, e->size};
        if (take_reals(&at, &node[i], 3, "curve", out + 3 * (size_t)k))
            return 1;
    }
    return 0;
}

static int take_parameters(const entry *e, curvopt_chain *to) {
    const json_node *list = member(e, "parameters");
    if (!list)
        return 0;
    if (list->kind != JSON_LIST || list->size != to->n_vertices)
        return fail_key(e, "parameters", "must be a list of as many numbers as there are vertices");
    double *out = calloc((size_t)list->size, sizeof *out);
    to->parameters = out;
    return out ? take_numbers(e, list, "parameters", out) : fail(e, "out of memory");
}

static int take_chain(const entry *e, curvopt_chain *to, double *to_weight) {
    static const char *const known[] = {"vertices", "closed", "curve", "curve_closed", "parameters", "weight", NULL};
    if (e->node->kind != JSON_OBJECT)
        return fail(e, "an object was expected");
    return check_keys(e, e->node, known) || take_flag(e, "closed", &to->is_closed) ||
           take_flag(e, "curve_closed", &to->is_curve_closed) || take_vertices(e, to) || take_curve(e, to) ||
           take_parameters(e, to) || take_weight(e, to_weight);
}

/* ------------------------------------------------------------------------------------------------- the file -- */

/* The lists of points and of chains; NULL where there is none. */
static int find_lists(const json_document *d, const json_node **points, const json_node **chains, char *message,
                      size_t size) {
    static const char *const known[] = {"points", "chains", NULL};
    const json_node *whole = &d->node[0];
    const entry e = {.document = d, .node = whole, .name = "entry", .message = message, .size = size};
    *points = whole->kind == JSON_LIST ? whole : NULL;
    *chains = NULL;
    if (whole->kind == JSON_OBJECT) {
        if (check_keys(&e, whole, known)) {
            const int is_entry = json_member(d, whole, "vertex") || json_member(d, whole, "face");
            snprintf(message, size, "only \"points\" and \"chains\" are known there%s",
                     is_entry ? "; put [ ] round an entry: they are in a list" : "");
            return 1;
        }
        *points = json_member(d, whole, "points");
        *chains = json_member(d, whole, "chains");
    }
    if ((*points && (*points)->kind != JSON_LIST) || (*chains && (*chains)->kind != JSON_LIST) ||
        !((*points && (*points)->size > 0) || (*chains && (*chains)->size > 0))) {
        snprintf(message, size,
                 "a list with at least one entry was expected, or an object with lists \"points\" or "
                 "\"chains\"");
        return 1;
    }
    return 0;
}

static int take_lists(const json_document *d, const json_node *points, const json_node *chains, through_list *out,
                      char *message, size_t size) {
    entry e = {.document = d, .message = message, .size = size};
    const size_t room = chains ? (size_t)chains->size + 1 : 1;
    double *weights = NULL;
    int failed = make_room(points ? points->size : 0, out);
    if (!failed) {
        out->given.chain_weights = weights = calloc(room, sizeof *weights);
        out->chains = calloc(room, sizeof *out->chains);
        failed = !weights || !out->chains;
    }
    if (failed) {
        snprintf(message, size, "out of memory");
        return 1;
    }
    e.name = "entry";
    for (int32_t i = points ? points->first : -1; i >= 0; i = d->node[i].next, e.number++) {
        const slot to = slot_of(out, e.number);
        e.node = &d->node[i];
        if (take_entry(&e, &to))
            return 1;
    }
    e.name = "chain";
    e.number = 0;
    out->given.chains = out->chains;
    out->given.n_chains = chains ? chains->size : 0;
    for (int32_t i = chains ? chains->first : -1; i >= 0; i = d->node[i].next, e.number++) {
        e.node = &d->node[i];
        if (take_chain(&e, &out->chains[e.number], &weights[e.number]))
            return 1;
    }
    return 0;
}

int through_parse(FILE *file, through_list *out, char *message, size_t size) {
    json_document d;
    const json_node *points, *chains;
    *out = (through_list){0};
    if (json_read(file, &d, message, size))
        return 1;
    int failed = find_lists(&d, &points, &chains, message, size) || take_lists(&d, points, chains, out, message, size);
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
