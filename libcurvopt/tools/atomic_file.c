/* Files written whole or not at all. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "atomic_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int error_number(void) {
    return errno ? errno : EIO;
}

int staged_open(staged *s, const char *path) {
    struct stat info;
    *s = (staged){.path = path};
    errno = 0;
    if (strcmp(path, "-") == 0) {
        s->file = stdout;
        return 0;
    }
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        s->file = fopen(path, "wb");
        return s->file ? 0 : error_number();
    }
    size_t length = strlen(path) + 32;
    s->partial = malloc(length);
    if (!s->partial)
        return ENOMEM;
    snprintf(s->partial, length, "%s.%ld.part", path, (long)getpid());
    errno = 0;
    s->file = fopen(s->partial, "wbx");
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
    errno = 0;
    int failed = s->partial && rename(s->partial, s->path) != 0 ? error_number() : 0;
    if (failed)
        remove(s->partial);
    free(s->partial);
    s->partial = NULL;
    return failed;
}

void staged_discard(staged *s) {
    if (s->file && s->file != stdout)
        fclose(s->file);
    if (s->partial)
        remove(s->partial);
    free(s->partial);
    *s = (staged){0};
}
