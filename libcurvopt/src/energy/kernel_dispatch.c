/* Choice of the element kernel for this processor. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/element_kernel.h"

#include <string.h>

extern const co_element_kernel co_element_kernel_portable;
#ifdef CO_HAVE_X86_KERNELS
extern const co_element_kernel co_element_kernel_avx2, co_element_kernel_avx512;
#endif

const co_element_kernel *co_element_kernel_select(const char *wanted) {
    const co_element_kernel *available[3];
    int n = 0;
#ifdef CO_HAVE_X86_KERNELS
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        available[n++] = &co_element_kernel_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        available[n++] = &co_element_kernel_avx2;
#endif
    available[n++] = &co_element_kernel_portable;
    for (int i = 0; i < n; i++)
        if (!wanted || strcmp(wanted, available[i]->name) == 0)
            return available[i];
    return NULL;
}
