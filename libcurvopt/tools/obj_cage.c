/* Wavefront OBJ cages. SPDX-License-Identifier: GPL-3.0-or-later */
#include "obj_cage.h"

#include "platform.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_NUMBER = 64 };

/* Text being read: a position that never passes the end. */
typedef struct cursor {
    const char *at, *end;
    int line;
} cursor;

typedef struct builder {
    obj_cage *cage;
    size_t vertex_room, face_room, corner_room, n_corners;
    size_t crease_room, crease_pair_room, sharp_room, sharp_vertex_room, hole_room, line_room, end_room, n_ends;
    int hides_boundary; /* faces with a vertex on a boundary are holes */
    char *message;
    size_t message_size;
    int line;
} builder;

static int complain(const builder *b, const char *what, const char *detail) {
    snprintf(b->message, b->message_size, "line %d: %s%s", b->line, what, detail);
    return 1;
}

/* Room for one more element; sizes double. */
static int make_room(builder *b, void **array, size_t *room, size_t used, size_t size) {
    if (used < *room)
        return 0;
    size_t bigger = *room ? 2 * *room : 256;
    if (bigger > INT32_MAX || bigger > SIZE_MAX / size)
        return complain(b, "more elements than 32-bit indices can count", "");
    void *p = realloc(*array, bigger * size);
    if (!p)
        return complain(b, "out of memory", "");
    *array = p;
    *room = bigger;
    return 0;
}

static int is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/* Characters of a backslash and the end of a line behind it, with which the line goes on; 0 where there are none. */
static size_t continues(const cursor *c) {
    const size_t left = (size_t)(c->end - c->at);
    if (left > 1 && !memcmp(c->at, "\\\n", 2))
        return 2;
    return left > 2 && !memcmp(c->at, "\\\r\n", 3) ? 3 : 0;
}

/* The next word of the line into word [MAX_NUMBER]; its length, 0 at the line's end. What is longer than any number
 * becomes a word that is none. */
static size_t next_word(cursor *c, char *word) {
    size_t length = 0;
    for (;;) {
        const size_t end_of_line = continues(c);
        if (c->at < c->end && is_blank(*c->at))
            c->at++;
        else if (end_of_line)
            c->at += end_of_line, c->line++;
        else
            break;
    }
    while (c->at < c->end && !is_blank(*c->at) && *c->at != '\n' && *c->at != '#') {
        if (length + 1 < MAX_NUMBER)
            word[length++] = *c->at ? *c->at : '?'; /* a byte 0 ends no word */
        else
            memcpy(word, "...", 4), length = 3;
        c->at++;
    }
    word[length] = 0;
    return length;
}

static int add_vertex(builder *b, cursor *c) {
    char word[MAX_NUMBER];
    size_t used = (size_t)b->cage->n_vertices;
    if (make_room(b, (void **)&b->cage->xyz, &b->vertex_room, used, 3 * sizeof(double)))
        return 1;
    for (size_t i = 0; i < 3; i++) {
        char *end;
        if (!next_word(c, word))
            return complain(b, "a vertex with fewer than three coordinates", "");
        b->cage->xyz[3 * used + i] = strtod(word, &end);
        if (*end)
            return complain(b, "not a coordinate: ", word);
    }
    b->cage->n_vertices++;
    return 0;
}

/* A vertex "v", "v/vt", "v//vn" or "v/vt/vn"; negative counts from the last vertex. */
static int add_index(builder *b, const char *word, int32_t **array, size_t *room, size_t *n) {
    char *end;
    errno = 0;
    long v = strtol(word, &end, 10);
    if (end == word || (*end && *end != '/') || errno)
        return complain(b, "not a vertex index: ", word);
    if (v < 0)
        v += (long)b->cage->n_vertices + 1;
    if (v < 1 || v > INT32_MAX)
        return complain(b, "there is no vertex ", word);
    if (make_room(b, (void **)array, room, *n, sizeof(int32_t)))
        return 1;
    (*array)[(*n)++] = (int32_t)(v - 1);
    return 0;
}

static int add_face(builder *b, cursor *c) {
    char word[MAX_NUMBER];
    size_t first = b->n_corners;
    if (make_room(b, (void **)&b->cage->face_sizes, &b->face_room, (size_t)b->cage->n_faces, sizeof(int32_t)))
        return 1;
    while (next_word(c, word))
        if (add_index(b, word, &b->cage->face_vertices, &b->corner_room, &b->n_corners))
            return 1;
    b->cage->face_sizes[b->cage->n_faces++] = (int32_t)(b->n_corners - first);
    return 0;
}

/* A line element, which is carried through; it makes no surface. */
static int add_line(builder *b, cursor *c) {
    char word[MAX_NUMBER];
    size_t first = b->n_ends;
    if (make_room(b, (void **)&b->cage->line_sizes, &b->line_room, (size_t)b->cage->n_lines, sizeof(int32_t)))
        return 1;
    while (next_word(c, word))
        if (add_index(b, word, &b->cage->line_ends, &b->end_room, &b->n_ends))
            return 1;
    b->cage->line_sizes[b->cage->n_lines++] = (int32_t)(b->n_ends - first);
    return 0;
}

static int next_integer(builder *b, cursor *c, int32_t *out) {
    char word[MAX_NUMBER], *end;
    errno = 0;
    long value = next_word(c, word) ? strtol(word, &end, 10) : -1;
    if (value < 0 || value > INT32_MAX || *end || errno)
        return complain(b, "not a vertex of a tag: ", word);
    *out = (int32_t)value;
    return 0;
}

static int next_real(builder *b, cursor *c, double *out) {
    char word[MAX_NUMBER], *end = word;
    if (next_word(c, word))
        *out = strtod(word, &end);
    if (end == word || *end)
        return complain(b, "not a sharpness: ", word);
    return 0;
}

/* Room for one more crease (pairs of vertices) or corner. */
static int make_tag_room(builder *b, int is_crease) {
    obj_cage *g = b->cage;
    if (is_crease)
        return make_room(b, (void **)&g->crease_sharpness, &b->crease_room, (size_t)g->n_creases, sizeof(double)) ||
               make_room(b, (void **)&g->crease_vertices, &b->crease_pair_room, (size_t)g->n_creases,
                         2 * sizeof(int32_t));
    return make_room(b, (void **)&g->corner_sharpness, &b->sharp_room, (size_t)g->n_corners, sizeof(double)) ||
           make_room(b, (void **)&g->corner_vertices, &b->sharp_vertex_room, (size_t)g->n_corners, sizeof(int32_t));
}

/* The vertices of a tag, then its sharpnesses, one for all or one for each. */
static int add_creases(builder *b, cursor *c, int is_crease, int n_vertices, int n_values) {
    obj_cage *g = b->cage;
    int32_t first = is_crease ? g->n_creases : g->n_corners, n = is_crease ? n_vertices - 1 : n_vertices, before = 0;
    double value = 0;
    for (int i = 0; i < n_vertices; i++) {
        int32_t v;
        if (next_integer(b, c, &v))
            return 1;
        if (!is_crease || i > 0) {
            if (make_tag_room(b, is_crease))
                return 1;
            if (is_crease) {
                g->crease_vertices[2 * g->n_creases] = before;
                g->crease_vertices[2 * g->n_creases++ + 1] = v;
            } else {
                g->corner_vertices[g->n_corners++] = v;
            }
        }
        before = v;
    }
    for (int32_t i = 0; i < n; i++) {
        if (i < n_values && next_real(b, c, &value))
            return 1;
        (is_crease ? g->crease_sharpness : g->corner_sharpness)[first + i] = value;
    }
    return 0;
}

/* "2/1/0": how many vertices, real numbers and texts a tag has. */
static int parse_counts(const char *word, int count[3]) {
    for (int i = 0; i < 3; i++) {
        char *end;
        errno = 0;
        long value = strtol(word, &end, 10);
        if (end == word || errno || value < 0 || value > 999999999 || *end != (i < 2 ? '/' : 0))
            return 1;
        count[i] = (int)value;
        word = end + 1;
    }
    return 0;
}

static int add_holes(builder *b, cursor *c, int n) {
    obj_cage *g = b->cage;
    for (int i = 0; i < n; i++) {
        if (make_room(b, (void **)&g->holes, &b->hole_room, (size_t)g->n_holes, sizeof(int32_t)) ||
            next_integer(b, c, &g->holes[g->n_holes]))
            return 1;
        g->n_holes++;
    }
    return 0;
}

static int set_boundary_rule(builder *b, cursor *c) {
    int32_t rule;
    if (next_integer(b, c, &rule))
        return 1;
    if (rule > 2)
        return complain(b, "interpolateboundary is neither 0, 1 nor 2", "");
    b->hides_boundary = rule == 0;
    b->cage->boundary_rule = rule == 1 ? CURVOPT_BOUNDARY_RULE_CORNERS : CURVOPT_BOUNDARY_RULE_SMOOTH;
    return 0;
}

/* As many names as there is room for. */
static void pass_over(obj_cage *cage, const char *name) {
    size_t used = strlen(cage->passed_over), length = strlen(name);
    for (const char *p = name; *p; p++)
        if (*p < 'a' || *p > 'z')
            return;
    if (!strstr(cage->passed_over, name) && used + length + 3 < sizeof cage->passed_over)
        snprintf(cage->passed_over + used, sizeof cage->passed_over - used, "%s%s", used ? ", " : "", name);
}

static int add_tag(builder *b, cursor *c) {
    char word[MAX_NUMBER];
    int count[3];
    next_word(c, word);
    int is_crease = strcmp(word, "crease") == 0, is_hole = strcmp(word, "hole") == 0;
    int is_rule = strcmp(word, "interpolateboundary") == 0;
    if (!is_crease && !is_hole && !is_rule && strcmp(word, "corner") != 0) {
        pass_over(b->cage, word);
        return 0;
    }
    next_word(c, word);
    if (is_hole || is_rule) {
        if (parse_counts(word, count) || (is_rule && count[0] != 1))
            return complain(b, "not the counts of a tag: ", word);
        return is_rule ? set_boundary_rule(b, c) : add_holes(b, c, count[0]);
    }
    if (parse_counts(word, count) || count[0] < 1 + is_crease || (count[1] != 1 && count[1] != count[0] - is_crease))
        return complain(b, "not the counts of a crease or corner: ", word);
    return add_creases(b, c, is_crease, count[0], count[1]);
}

/* One line. Words that OBJ knows and a cage does not need are passed over; others mean that this is no OBJ. */
static int parse_line(builder *b, cursor *c) {
    static const char *const passed_over[] = {"vt", "vn", "vp", "g", "o", "s", "usemtl", "mtllib", "p", "lod"};
    char word[MAX_NUMBER];
    if (!next_word(c, word))
        return 0;
    if (strcmp(word, "v") == 0)
        return add_vertex(b, c);
    if (strcmp(word, "f") == 0)
        return add_face(b, c);
    if (strcmp(word, "l") == 0)
        return add_line(b, c);
    if (strcmp(word, "t") == 0)
        return add_tag(b, c);
    for (size_t i = 0; i < sizeof passed_over / sizeof *passed_over; i++)
        if (strcmp(word, passed_over[i]) == 0)
            return 0;
    for (char *p = word; *p; p++)
        if ((unsigned char)*p < 32 || (unsigned char)*p > 126)
            *p = '?';
    return complain(b, "this is no OBJ file: unknown statement ", word);
}

/* ----------------------------------------------------------------------------------------- hidden boundary -- */

typedef struct edge_ends {
    int32_t low, high;
} edge_ends;

static int by_ends(const void *a, const void *b) {
    const edge_ends *x = a, *y = b;
    if (x->low != y->low)
        return (x->low > y->low) - (x->low < y->low);
    return (x->high > y->high) - (x->high < y->high);
}

/* Marks the ends of edges of one face; edges [n] is sorted. */
static void mark_boundary(const obj_cage *cage, const edge_ends *edges, size_t n, unsigned char *on_boundary) {
    for (size_t i = 0, count; i < n; i += count) {
        for (count = 1; i + count < n && !by_ends(&edges[i], &edges[i + count]);)
            count++;
        if (count == 1 && edges[i].high < cage->n_vertices)
            on_boundary[edges[i].low] = on_boundary[edges[i].high] = 1;
    }
}

/* Faces with a vertex on a boundary become holes. */
static int hide_boundary(builder *b) {
    obj_cage *g = b->cage;
    const int32_t *corner = g->face_vertices;
    size_t at = 0;
    edge_ends *edges = malloc(sizeof *edges * (b->n_corners + 1));
    unsigned char *on_boundary = calloc((size_t)g->n_vertices, 1);
    int failed = !edges || !on_boundary;
    for (int32_t f = 0; !failed && f < g->n_faces; corner += g->face_sizes[f++])
        for (int32_t k = 0; k < g->face_sizes[f]; k++) {
            int32_t v = corner[k], w = corner[(k + 1) % g->face_sizes[f]];
            edges[at++] = (edge_ends){v < w ? v : w, v < w ? w : v};
        }
    if (!failed) {
        qsort(edges, at, sizeof *edges, by_ends);
        mark_boundary(g, edges, at, on_boundary);
    }
    corner = g->face_vertices;
    for (int32_t f = 0; !failed && f < g->n_faces; corner += g->face_sizes[f++]) {
        int is_hidden = 0;
        for (int32_t k = 0; k < g->face_sizes[f]; k++)
            is_hidden |= corner[k] < g->n_vertices && on_boundary[corner[k]];
        failed = is_hidden && make_room(b, (void **)&g->holes, &b->hole_room, (size_t)g->n_holes, sizeof(int32_t));
        if (is_hidden && !failed)
            g->holes[g->n_holes++] = f;
    }
    free(edges);
    free(on_boundary);
    return failed ? complain(b, "out of memory", "") : 0;
}

/* -------------------------------------------------------------------------------------------------- files -- */

int obj_parse(const char *text, size_t length, obj_cage *cage, char *message, size_t size) {
    cursor c = {.at = text, .end = text + length, .line = 1};
    if (length >= 3 && !memcmp(text, "\xef\xbb\xbf", 3)) /* the mark that some editors begin with */
        c.at += 3;
    builder b = {.cage = cage, .message = message, .message_size = size};
    *cage = (obj_cage){.boundary_rule = -1};
    while (c.at < c.end) {
        b.line = c.line;
        if (parse_line(&b, &c)) {
            obj_free(cage);
            return 1;
        }
        while (c.at < c.end && *c.at != '\n')
            c.at++;
        if (c.at < c.end) {
            c.at++;
            c.line++;
        }
    }
    if (cage->n_vertices == 0 || cage->n_faces == 0) {
        snprintf(message, size, length == 0 ? "the file is empty" : "the file has %d vertices and %d faces",
                 cage->n_vertices, cage->n_faces);
        obj_free(cage);
        return 1;
    }
    if (b.hides_boundary && hide_boundary(&b)) {
        obj_free(cage);
        return 1;
    }
    return 0;
}

static int read_all(FILE *file, char **text, size_t *length) {
    size_t room = 0;
    *text = NULL;
    *length = 0;
    for (;;) {
        if (*length == room) {
            size_t bigger = room ? 2 * room : 65536;
            char *p = bigger > room ? realloc(*text, bigger) : NULL;
            if (!p)
                return ENOMEM;
            *text = p;
            room = bigger;
        }
        size_t n = fread(*text + *length, 1, room - *length, file);
        *length += n;
        if (n == 0)
            return ferror(file) ? (errno ? errno : EIO) : 0;
    }
}

int obj_read(const char *path, obj_cage *cage, char *message, size_t size) {
    char *text = NULL;
    size_t length = 0;
    int standard_input = strcmp(path, "-") == 0;
    *cage = (obj_cage){0};
    errno = 0;
    FILE *file = standard_input ? stdin : platform_open(path, "rb");
    int failed = file ? read_all(file, &text, &length) : errno;
    if (file && !standard_input)
        fclose(file);
    if (failed)
        snprintf(message, size, "%s", strerror(failed));
    else
        failed = obj_parse(text, length, cage, message, size);
    free(text);
    return failed;
}

int obj_write(FILE *file, const obj_cage *cage) {
    const int32_t *corner = cage->face_vertices, *end = cage->line_ends;
    for (int32_t v = 0; v < cage->n_vertices; v++)
        fprintf(file, "v %.17g %.17g %.17g\n", cage->xyz[3 * (size_t)v], cage->xyz[3 * (size_t)v + 1],
                cage->xyz[3 * (size_t)v + 2]);
    for (int32_t f = 0; f < cage->n_faces; f++) {
        fputc('f', file);
        for (int32_t k = 0; k < cage->face_sizes[f]; k++)
            fprintf(file, " %d", *corner++ + 1);
        fputc('\n', file);
    }
    for (int32_t i = 0; i < cage->n_creases; i++)
        fprintf(file, "t crease 2/1/0 %d %d %.17g\n", cage->crease_vertices[2 * i], cage->crease_vertices[2 * i + 1],
                cage->crease_sharpness[i]);
    for (int32_t i = 0; i < cage->n_corners; i++)
        fprintf(file, "t corner 1/1/0 %d %.17g\n", cage->corner_vertices[i], cage->corner_sharpness[i]);
    if (cage->n_holes)
        fprintf(file, "t hole %d/0/0", cage->n_holes);
    for (int32_t i = 0; i < cage->n_holes; i++)
        fprintf(file, i + 1 < cage->n_holes ? " %d" : " %d\n", cage->holes[i]);
    for (int32_t i = 0; i < cage->n_lines; i++) {
        fputc('l', file);
        for (int32_t k = 0; k < cage->line_sizes[i]; k++)
            fprintf(file, " %d", *end++ + 1);
        fputc('\n', file);
    }
    return ferror(file);
}

void obj_free(obj_cage *cage) {
    free(cage->holes);
    free(cage->line_sizes);
    free(cage->line_ends);
    free(cage->xyz);
    free(cage->face_sizes);
    free(cage->face_vertices);
    free(cage->crease_vertices);
    free(cage->crease_sharpness);
    free(cage->corner_vertices);
    free(cage->corner_sharpness);
    *cage = (obj_cage){0};
}

curvopt_creases obj_creases(const obj_cage *cage, int32_t boundary_rule) {
    return (curvopt_creases){.crease_vertices = cage->crease_vertices,
                             .crease_sharpness = cage->crease_sharpness,
                             .corner_vertices = cage->corner_vertices,
                             .corner_sharpness = cage->corner_sharpness,
                             .n_creases = cage->n_creases,
                             .n_corners = cage->n_corners,
                             .boundary_rule = boundary_rule >= 0         ? boundary_rule
                                              : cage->boundary_rule >= 0 ? cage->boundary_rule
                                                                         : CURVOPT_BOUNDARY_RULE_SMOOTH};
}
