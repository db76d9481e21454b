/* Which instruction sets there are: compiled in (libcurvopt/instruction_sets.cmake) and run by this processor.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_BASE_INSTRUCTION_SET_H
#define CO_BASE_INSTRUCTION_SET_H

typedef enum { CO_PORTABLE, CO_AVX2, CO_AVX512, CO_N_INSTRUCTION_SETS } co_instruction_set; /* the fastest last */

/* One name for each instruction set, such as co_blas_routines_avx2; CO_NAME_OF_SET: of the one being compiled for. */
#define CO_JOIN_NAME(name, set)   name##_##set
#define CO_EXPAND_NAME(name, set) CO_JOIN_NAME(name, set)
#define CO_NAME_OF_SET(name)      CO_EXPAND_NAME(name, CO_INSTRUCTION_SET)

/* The objects of these names, by co_instruction_set; NULL for what was not compiled. */
#ifdef CO_HAVE_AVX
#define CO_OBJECTS_OF_SETS(name)                                                                                       \
    { &name##_portable, &name##_avx2, &name##_avx512 }
#define CO_DECLARE_SETS(type, name) extern const type name##_portable, name##_avx2, name##_avx512
#else
#define CO_OBJECTS_OF_SETS(name)                                                                                       \
    { &name##_portable }
#define CO_DECLARE_SETS(type, name) extern const type name##_portable
#endif

/* Whether code for it may run here. */
int co_has_instruction_set(co_instruction_set set);
/* The fastest of those. */
co_instruction_set co_best_instruction_set(void);

#endif
