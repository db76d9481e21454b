/* Standard streams for code in static archives; linked into the shared library only. Debian's static archives are
 * compiled for programs, which may refer to the C library's stdout and stderr directly; a shared library may not. The
 * linker (--wrap) gives them these instead. CHOLMOD and OpenBLAS are told to be quiet; should one of them print all the
 * same, it must not find a null stream. SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>

extern FILE *__wrap_stdout, *__wrap_stderr, *__real_stdout, *__real_stderr; /* NOLINT: names that the linker makes */
FILE *__wrap_stdout, *__wrap_stderr;

__attribute__((constructor)) static void find_streams(void) {
    __wrap_stdout = __real_stdout;
    __wrap_stderr = __real_stderr;
}
