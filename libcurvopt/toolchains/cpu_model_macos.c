/* What __builtin_cpu_supports() reads, for macOS on Intel's processors. Compilers bring it in their run time, which
 * Debian's clang has for Linux alone. macOS is asked by name: the processor's own word is not enough there, since macOS
 * switches the registers of AVX-512 on when a thread first uses them.
 *
 * Follows: compiler-rt, lib/builtins/cpu_model.c (layout and bits); of the features those alone that the library asks
 * for.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stddef.h>

/* of <sys/sysctl.h>, which the system of the test of this file has not got */
extern int sysctlbyname(const char *name, void *out, size_t *out_size, const void *in, size_t in_size);

struct cpu_model {
    unsigned vendor, type, subtype, features[1];
};
extern struct cpu_model __cpu_model; /* NOLINT: the compiler's name */
struct cpu_model __cpu_model;        /* NOLINT */

void co_cpu_model_read(void);

/* Runs when the library is loaded. */
__attribute__((constructor)) void co_cpu_model_read(void) {
    static const struct {
        const char *name;
        unsigned bit;
    } features[] = {{"hw.optional.avx2_0", 10},
                    {"hw.optional.fma", 14},
                    {"hw.optional.avx512f", 15},
                    {"hw.optional.avx512vl", 20},
                    {"hw.optional.avx512dq", 22}};
    __cpu_model.features[0] = 0;
    for (size_t i = 0; i < sizeof features / sizeof *features; i++) {
        int has = 0;
        size_t size = sizeof has;
        if (sysctlbyname(features[i].name, &has, &size, NULL, 0) == 0 && has)
            __cpu_model.features[0] |= 1U << features[i].bit;
    }
}
