/* The BLAS and LAPACK routines that CHOLMOD calls and own_blas.c has, by the names and arguments of Fortran: Dongarra,
 * Du Croz, Hammarling, Duff, "A set of level 3 basic linear algebra subprograms", ACM TOMS 16(1), 1990. CHOLMOD gives
 * no lengths of character arguments. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_LINALG_OWN_BLAS_H
#define CO_LINALG_OWN_BLAS_H

#include "linalg/blas.h"

extern void zgemm_(void), zgemv_(void), zherk_(void), zpotrf_(void), ztrsm_(void), ztrsv_(void);

#endif
