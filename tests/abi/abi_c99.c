/* The header in C99. SPDX-License-Identifier: GPL-3.0-or-later */
#include "layout.h"

#if __STDC_VERSION__ != 199901L
#error "this is not C99"
#endif

int main(void) {
    int failed = use_library();
    if (failed)
        fprintf(stderr, "step %d of use_library() failed\n", failed);
    return failed;
}
