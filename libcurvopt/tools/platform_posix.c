/* The system, where it is POSIX. SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "platform.h"

#include <errno.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

int platform_start(int *argc, char ***argv) {
    (void)argc;
    (void)argv;
#ifdef SIGXFSZ /* a file that may not grow is then an error of writing, and nothing of it is left */
    signal(SIGXFSZ, SIG_IGN);
#endif
    return 0;
}

FILE *platform_open(const char *path, const char *mode) {
    return fopen(path, mode); /* reading a directory fails with EISDIR */
}

int platform_replace(const char *from, const char *to) {
    errno = 0;
    if (rename(from, to) == 0)
        return 0;
    return errno ? errno : EIO;
}

void platform_remove(const char *path) {
    remove(path);
}

int platform_is_special(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && !S_ISREG(info.st_mode);
}

int platform_is_watched(void) {
    return isatty(STDERR_FILENO);
}

unsigned platform_process_id(void) {
    return (unsigned)getpid();
}
