/* What this processor runs. SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/instruction_set.h"

int co_has_instruction_set(co_instruction_set set) {
#ifdef CO_HAVE_AVX
    if (set == CO_AVX512)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl");
    if (set == CO_AVX2)
        return __builtin_cpu_supports("avx2");
#endif
    return set == CO_PORTABLE;
}

co_instruction_set co_best_instruction_set(void) {
    co_instruction_set set = CO_N_INSTRUCTION_SETS - 1;
    while (set > CO_PORTABLE && !co_has_instruction_set(set))
        set--;
    return set;
}
