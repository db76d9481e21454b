/* Linked into the shared library only. Debian's static archives are compiled for programs, which may refer to the C
 * library's stdout and stderr directly; a shared library may not. The linker (--wrap) gives them these instead. Nobody
 * prints through them: CHOLMOD and OpenBLAS are told to be quiet. SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>

extern FILE *__wrap_stdout, *__wrap_stderr; /* NOLINT: names that the linker makes */
FILE *__wrap_stdout, *__wrap_stderr;
