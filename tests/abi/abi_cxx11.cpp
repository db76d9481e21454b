/* The header in C++11. SPDX-License-Identifier: GPL-3.0-or-later */
#include "layout.h"

#if __cplusplus != 201103L
#error "this is not C++11"
#endif

int main() {
    int failed = use_library();
    if (failed)
        fprintf(stderr, "step %d of use_library() failed\n", failed);
    return failed;
}
