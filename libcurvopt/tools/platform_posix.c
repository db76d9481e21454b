/* The system, where it is POSIX. SPDX-License-Identifier: GPL-3.0-or-later */
#define _DEFAULT_SOURCE /* flock */
#include "platform.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

/* A run takes and gives back blocks of many megabytes again and again. What the process has once got it keeps, for the
 * system clears pages anew each time it gives them (notes/94-where-the-time-goes.md). Advice: it may fail. */
static void keep_memory(void) {
#ifdef __GLIBC__
    mallopt(M_MMAP_MAX, 0);
    mallopt(M_TRIM_THRESHOLD, INT_MAX);
#endif
}

int platform_start(int *argc, char ***argv) {
    (void)argc;
    (void)argv;
    keep_memory();
#ifdef SIGXFSZ /* a file that may not grow is then an error of writing, and nothing of it is left */
    signal(SIGXFSZ, SIG_IGN);
#endif
    signal(SIGPIPE, SIG_IGN);
    for (int number = 0; number < 3;
         number++) /* writing to what is closed, or reading from it, is an error as before */
        if (fcntl(number, F_GETFD) < 0 && open("/dev/null", number == 0 ? O_WRONLY : O_RDONLY) < 0)
            return errno;
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

/* A lock belongs to the open file, whatever its numbers: it outlives fclose(file). */
int platform_lock(FILE *file) {
    struct stat info;
    const int lock = fcntl(fileno(file), F_DUPFD_CLOEXEC, 3);
    if (lock < 0)
        return 0;
    flock(lock, LOCK_EX); /* where that fails, leftovers cannot be told, and stay */
    if (fstat(lock, &info) == 0 && info.st_nlink > 0)
        return lock;
    close(lock);
    return -1;
}

void platform_unlock(int lock) {
    if (lock > 0)
        close(lock);
}

/* Whether name is BASE.DIGITS.part. */
static int is_part_of(const char *name, const char *base) {
    const size_t length = strlen(base);
    if (strncmp(name, base, length) != 0 || name[length] != '.')
        return 0;
    const char *digits = name + length + 1;
    const size_t n = strspn(digits, "0123456789");
    return n > 0 && strcmp(digits + n, ".part") == 0;
}

/* Removes a file of this folder, unless somebody writes it. */
static void remove_unless_locked(int folder, const char *name) {
    struct stat info;
    const int file = openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0)
        return;
    if (fstat(file, &info) == 0 && S_ISREG(info.st_mode) && flock(file, LOCK_EX | LOCK_NB) == 0)
        unlinkat(folder, name, 0);
    close(file);
}

void platform_remove_leftovers(const char *path) {
    const char *slash = strrchr(path, '/');
    const struct dirent *entry;
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : NULL;
    DIR *list = slash && !folder ? NULL : opendir(folder ? folder : ".");
    while (list && (entry = readdir(list)))
        if (is_part_of(entry->d_name, slash ? slash + 1 : path))
            remove_unless_locked(dirfd(list), entry->d_name);
    if (list)
        closedir(list);
    free(folder);
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
