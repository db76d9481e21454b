/* CHOLMOD is not compiled for the memory sanitizer, which does not see what it writes: all that it allocates counts as
 * written. Linked to the fuzzers under that sanitizer only. SPDX-License-Identifier: GPL-3.0-or-later */
#include <sanitizer/msan_interface.h>
#include <stdlib.h>
#include <suitesparse/SuiteSparse_config.h>

static void *allocate(size_t size) {
    return calloc(1, size);
}

static void *resize(void *old, size_t size) {
    void *grown = realloc(old, size);
    if (grown)
        __msan_unpoison(grown, size);
    return grown;
}

int LLVMFuzzerInitialize(int *argc, char ***argv) {
    (void)argc;
    (void)argv;
    SuiteSparse_config.malloc_func = allocate;
    SuiteSparse_config.realloc_func = resize;
    return 0;
}
