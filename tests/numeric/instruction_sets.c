/* curvopt as on a processor that runs no more than
 *
 *   --instruction-set portable | avx2 | avx512
 *
 * which is the first argument. For tests/numeric/test_instruction_sets.py. Exit code 77 if this processor has not got
 * it. The linker puts this file's co_has_instruction_set() in the place of the library's, and the command line's main()
 * is compiled as curvopt_main(). SPDX-License-Identifier: GPL-3.0-or-later */
#include "base/instruction_set.h"

#include <stdio.h>
#include <string.h>

enum { NOT_HERE = 77 };

int curvopt_main(int argc, char **argv);
int __wrap_co_has_instruction_set(co_instruction_set set);
int __real_co_has_instruction_set(co_instruction_set set);

static co_instruction_set most = CO_PORTABLE;

int __wrap_co_has_instruction_set(co_instruction_set set) {
    return set <= most && __real_co_has_instruction_set(set);
}

int main(int argc, char **argv) {
    static const char *const names[CO_N_INSTRUCTION_SETS] = {"portable", "avx2", "avx512"};
    int set = 0;
    while (argc > 2 && set < CO_N_INSTRUCTION_SETS && strcmp(argv[2], names[set]) != 0)
        set++;
    if (argc < 3 || strcmp(argv[1], "--instruction-set") != 0 || set == CO_N_INSTRUCTION_SETS) {
        fputs("usage: curvopt_sets --instruction-set portable|avx2|avx512 ARGUMENTS\n", stderr);
        return 2;
    }
    most = (co_instruction_set)set;
    if (!__real_co_has_instruction_set(most))
        return NOT_HERE;
    argv[2] = argv[0];
    return curvopt_main(argc - 2, argv + 2);
}
