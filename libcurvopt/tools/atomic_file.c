/* Files written whole or not at all. SPDX-License-Identifier: GPL-3.0-or-later */
#include "atomic_file.h"

#include "platform.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static int error_number(void) {
    return errno ? errno : EIO;
}

/* A new file of this name, marked as one that is being written. */
static FILE *open_partial(const char *name, int *lock) {
    enum { TRIES = 8 }; /* each of them may be taken for a leftover by a run that begins just then */
    FILE *file = NULL;
    *lock = -1;
    for (int k = 0; k < TRIES && *lock < 0; k++) {
        if (file)
            fclose(file);
        errno = 0;
        file = platform_open(name, "wbx");
        if (!file)
            return NULL;
        *lock = platform_lock(file);
    }
    return file;
}

int staged_open(staged *s, const char *path) {
    *s = (staged){.path = path};
    errno = 0;
    if (strcmp(path, "-") == 0) {
        s->file = stdout;
        return 0;
    }
    if (platform_is_special(path)) {
        s->file = platform_open(path, "wb");
        return s->file ? 0 : error_number();
    }
    size_t length = strlen(path) + 32;
    s->partial = malloc(length);
    if (!s->partial)
        return ENOMEM;
    snprintf(s->partial, length, "%s.%u.part", path, platform_process_id());
    platform_remove_leftovers(path);
    s->file = open_partial(s->partial, &s->lock);
    if (s->file)
        return 0;
    int reason = error_number();
    free(s->partial);
    s->partial = NULL;
    return reason;
}

int staged_close(staged *s) {
    errno = 0;
    int failed = ferror(s->file);
    failed |= s->file == stdout ? fflush(s->file) : fclose(s->file);
    s->file = NULL;
    return failed ? error_number() : 0;
}

int staged_commit(staged *s) {
    int failed = s->partial ? platform_replace(s->partial, s->path) : 0;
    if (failed)
        platform_remove(s->partial);
    free(s->partial);
    s->partial = NULL;
    platform_unlock(s->lock);
    s->lock = 0;
    return failed;
}

void staged_discard(staged *s) {
    if (s->file && s->file != stdout)
        fclose(s->file);
    if (s->partial)
        platform_remove(s->partial);
    platform_unlock(s->lock);
    free(s->partial);
    *s = (staged){0};
}
