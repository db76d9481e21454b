/* Reading JSON (RFC 8259), strictly: nothing beside the standard, and no key twice. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef JSON_READER_H
#define JSON_READER_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef enum json_kind { JSON_NULL, JSON_FALSE, JSON_TRUE, JSON_NUMBER, JSON_STRING, JSON_LIST, JSON_OBJECT } json_kind;

/* Nodes know each other by their indices, 0 being the whole; -1: none. */
typedef struct json_node {
    json_kind kind;
    int32_t first, next; /* of a list or object its first child; the parent's next child */
    int32_t size;        /* number of children */
    int32_t line;        /* that it begins in, from 1 */
    const char *key;     /* in an object; else NULL */
    const char *text;    /* of a string, as UTF-8 */
    double number;
} json_node;

typedef struct json_document {
    char *text; /* strings are in it */
    json_node *node;
    int32_t n, room;
} json_document;

/* Most members of an object, and levels of lists and objects in each other. */
enum { JSON_MOST_MEMBERS = 64, JSON_DEEPEST = 16 };

/* Nonzero with a sentence in message [size] that names the line if the file is no JSON. Numbers are doubles and finite.
 */
int json_read(FILE *file, json_document *out, char *message, size_t size);
void json_free(json_document *document);
/* The member of an object by its key; NULL. */
const json_node *json_member(const json_document *document, const json_node *object, const char *key);

#endif
