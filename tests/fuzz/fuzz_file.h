/* Bytes as a file that can be read. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEST_FUZZ_FILE_H
#define TEST_FUZZ_FILE_H

#include "fuzz.h"

#include <stdio.h>

#ifdef _WIN32 /* has no fmemopen: a file in the current folder */
static FILE *file_of(void *text, size_t size) {
    char name[64];
    snprintf(name, sizeof name, "fuzz_%s.tmp", fuzz_name);
    FILE *file = fopen(name, "w+b");
    FUZZ_CHECK(file && fwrite(text, 1, size, file) == size);
    rewind(file);
    return file;
}
#else
static FILE *file_of(void *text, size_t size) {
    return fmemopen(text, size, "r");
}
#endif

#endif
