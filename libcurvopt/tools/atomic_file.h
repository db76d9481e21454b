/* Files written whole or not at all. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_STAGED_H
#define CURVOPT_TOOL_STAGED_H

#include <stdio.h>

/* A file being written beside its destination; `-` is standard output, and what exists and is no regular file (a
 * device, a pipe) is written to directly. */
typedef struct staged {
    const char *path;
    char *partial; /* where it is being written, if that is not the destination itself */
    FILE *file;
    int lock; /* of a partial file, so that nobody takes it for a leftover; 0: none */
} staged;

/* All three return 0, or an errno. What processes that are gone have left of this destination is removed first. After
 * staged_open() succeeded call exactly one of the two others. */
int staged_open(staged *s, const char *path);
/* Closes; what was written is complete, but not yet in its place. */
int staged_close(staged *s);
/* Puts it in its place. */
int staged_commit(staged *s);
void staged_discard(staged *s);

#endif
