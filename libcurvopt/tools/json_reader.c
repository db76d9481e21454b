/* Reading JSON. SPDX-License-Identifier: GPL-3.0-or-later */
#include "json_reader.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    json_document *out;
    char *at;
    int32_t line, depth;
    char *message;
    size_t size;
} reader;

void json_free(json_document *d) {
    free(d->text);
    free(d->node);
    *d = (json_document){0};
}

const json_node *json_member(const json_document *d, const json_node *object, const char *key) {
    for (int32_t i = object->first; i >= 0; i = d->node[i].next)
        if (d->node[i].key && !strcmp(d->node[i].key, key))
            return &d->node[i];
    return NULL;
}

static int fail(const reader *r, const char *what) {
    snprintf(r->message, r->size, "line %d: %s", (int)r->line, what);
    return 1;
}

static void skip_blank(reader *r) {
    for (; *r->at == ' ' || *r->at == '\t' || *r->at == '\n' || *r->at == '\r'; r->at++)
        r->line += *r->at == '\n';
}

/* Index of a new node; -1 if memory is out. */
static int32_t new_node(reader *r) {
    json_document *d = r->out;
    if (d->n == d->room) {
        size_t room = d->room ? 2 * (size_t)d->room : 256;
        json_node *grown = room < INT32_MAX / 2 ? realloc(d->node, room * sizeof *grown) : NULL;
        if (!grown) {
            fail(r, "out of memory");
            return -1;
        }
        d->node = grown;
        d->room = (int32_t)room;
    }
    d->node[d->n] = (json_node){.first = -1, .next = -1, .line = r->line};
    return d->n++;
}

/* -------------------------------------------------------------------------------------------- strings -- */

/* Four hexadecimal digits; -1 if there are none. */
static long take_hex(reader *r) {
    long value = 0;
    for (int i = 0; i < 4; i++) {
        const char c = *r->at;
        const int digit = c >= '0' && c <= '9'   ? c - '0'
                          : c >= 'a' && c <= 'f' ? c - 'a' + 10
                          : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                                 : -1;
        if (digit < 0)
            return -1;
        value = 16 * value + digit;
        r->at++;
    }
    return value;
}

static char *put_utf8(char *to, long code) {
    if (code < 0x80) {
        *to++ = (char)code;
        return to;
    }
    const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static const int lead[4] = {0, 0xc0, 0xe0, 0xf0};
    *to++ = (char)(lead[more] | (code >> (6 * more)));
    for (int i = more - 1; i >= 0; i--)
        *to++ = (char)(0x80 | ((code >> (6 * i)) & 0x3f));
    return to;
}

/* What \u means, perhaps two of them; -1 if nothing. */
static long take_code(reader *r) {
    const long high = take_hex(r);
    if (high < 0xd800 || high > 0xdfff)
        return high > 0 ? high : -1; /* no end of a string within it */
    if (high > 0xdbff || r->at[0] != '\\' || r->at[1] != 'u')
        return -1;
    r->at += 2;
    const long low = take_hex(r);
    return low < 0xdc00 || low > 0xdfff ? -1 : 0x10000 + ((high - 0xd800) << 10) + (low - 0xdc00);
}

/* A string, from behind its first quotation mark; it is put together in its own place, where it never gets longer. */
static int take_string(reader *r, const char **out) {
    static const char from[] = "\"\\/bfnrt", means[] = "\"\\/\b\f\n\r\t";
    char *to = r->at;
    *out = to;
    while (*r->at != '"') {
        if ((unsigned char)*r->at < 0x20)
            return fail(r, "a string does not end in its line");
        if (*r->at != '\\') {
            *to++ = *r->at++;
            continue;
        }
        const char escape = *++r->at;
        const char *known = escape ? strchr(from, escape) : NULL;
        r->at += escape != 0;
        const long code = known ? means[known - from] : escape == 'u' ? take_code(r) : -1;
        if (code < 0)
            return fail(r, "a string has \\ before something that it cannot be before");
        to = put_utf8(to, code);
    }
    r->at++;
    *to = 0;
    return 0;
}

/* ------------------------------------------------------------------------------------- all the others -- */

static int take_digits(reader *r) {
    const char *first = r->at;
    while (*r->at >= '0' && *r->at <= '9')
        r->at++;
    return r->at > first;
}

static int take_number(reader *r, double *out) {
    const char *first = r->at;
    r->at += *r->at == '-';
    const int starts_with_0 = *r->at == '0';
    const char *whole = r->at;
    int good = take_digits(r) && !(starts_with_0 && r->at > whole + 1);
    if (good && *r->at == '.') {
        r->at++;
        good = take_digits(r);
    }
    if (good && (*r->at == 'e' || *r->at == 'E')) {
        r->at++;
        r->at += *r->at == '-' || *r->at == '+';
        good = take_digits(r);
    }
    *out = good ? strtod(first, NULL) : 0;
    return good && isfinite(*out) ? 0 : fail(r, "no number that JSON has, or one that is too large");
}

static int take_word(reader *r, json_node *node) {
    static const struct {
        const char *name;
        json_kind kind;
    } words[] = {{"null", JSON_NULL}, {"false", JSON_FALSE}, {"true", JSON_TRUE}};
    for (int i = 0; i < 3; i++) {
        const size_t n = strlen(words[i].name);
        if (!strncmp(r->at, words[i].name, n)) {
            r->at += n;
            node->kind = words[i].kind;
            return 0;
        }
    }
    return fail(r, "a value was expected: a number, a string, a list, an object, true, false or null");
}

static int take_value(reader *r, int32_t *index);

/* The key of a member, and the colon. */
static int take_key(reader *r, const char **key) {
    skip_blank(r);
    if (*r->at != '"')
        return fail(r, "a key in quotation marks was expected");
    r->at++;
    if (take_string(r, key))
        return 1;
    skip_blank(r);
    if (*r->at != ':')
        return fail(r, "a colon was expected behind a key");
    r->at++;
    return 0;
}

/* One more child of node `parent`, behind child `last`. */
static int take_child(reader *r, int32_t parent, int32_t *last) {
    const char *key = NULL;
    int32_t child;
    json_node *node = r->out->node;
    if (node[parent].kind == JSON_OBJECT) {
        if (take_key(r, &key))
            return 1;
        if (json_member(r->out, &node[parent], key))
            return fail(r, "a key is there twice");
        if (node[parent].size == JSON_MOST_MEMBERS)
            return fail(r, "an object has too many members");
    }
    if (take_value(r, &child))
        return 1;
    node = r->out->node; /* it may have moved */
    node[child].key = key;
    if (*last < 0)
        node[parent].first = child;
    else
        node[*last].next = child;
    *last = child;
    node[parent].size++;
    return 0;
}

static int take_children(reader *r, int32_t parent) {
    const char end = r->out->node[parent].kind == JSON_OBJECT ? '}' : ']';
    int32_t last = -1;
    r->at++;
    skip_blank(r);
    if (++r->depth > JSON_DEEPEST)
        return fail(r, "lists and objects are too deep in each other");
    for (int more = *r->at != end; more;) {
        if (take_child(r, parent, &last))
            return 1;
        skip_blank(r);
        more = *r->at == ',';
        if (more)
            r->at++;
        else if (*r->at != end)
            return fail(r, end == '}' ? "a comma or } was expected" : "a comma or ] was expected");
    }
    r->at++;
    r->depth--;
    return 0;
}

static int take_value(reader *r, int32_t *index) {
    skip_blank(r);
    *index = new_node(r);
    if (*index < 0)
        return 1;
    json_node *node = &r->out->node[*index];
    const char c = *r->at;
    if (c == '{' || c == '[') {
        node->kind = c == '{' ? JSON_OBJECT : JSON_LIST;
        return take_children(r, *index);
    }
    if (c == '"') {
        r->at++;
        node->kind = JSON_STRING;
        return take_string(r, &node->text);
    }
    if (c == '-' || (c >= '0' && c <= '9')) {
        node->kind = JSON_NUMBER;
        return take_number(r, &node->number);
    }
    return take_word(r, node);
}

/* All of a file, with a 0 behind it; NULL with a message if that cannot be done. */
static char *read_all(FILE *file, char *message, size_t size) {
    size_t n = 0, room = 4096;
    char *text = malloc(room);
    while (text) {
        n += fread(text + n, 1, room - 1 - n, file);
        if (n < room - 1)
            break;
        char *grown = room < SIZE_MAX / 2 ? realloc(text, 2 * room) : NULL;
        if (!grown)
            free(text);
        text = grown;
        room *= 2;
    }
    const char *wrong = !text                ? "out of memory"
                        : ferror(file)       ? strerror(errno)
                        : memchr(text, 0, n) ? "it has a byte 0 in it"
                                             : NULL;
    if (!wrong) {
        text[n] = 0;
        return text;
    }
    snprintf(message, size, "%s", wrong);
    free(text);
    return NULL;
}

int json_read(FILE *file, json_document *out, char *message, size_t size) {
    int32_t whole;
    *out = (json_document){.text = read_all(file, message, size)};
    if (!out->text)
        return 1;
    reader r = {.out = out, .at = out->text, .line = 1, .message = message, .size = size};
    if (!strncmp(r.at, "\xef\xbb\xbf", 3)) /* the mark that some editors begin with */
        r.at += 3;
    int failed = take_value(&r, &whole);
    skip_blank(&r);
    if (!failed && *r.at)
        failed = fail(&r, "something follows behind the end");
    if (failed)
        json_free(out);
    return failed;
}
