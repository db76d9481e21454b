/* Whether a cage is a minimum, by a Hessian from finite differences of the gradient. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef CURVOPT_TAO_VERIFY_H
#define CURVOPT_TAO_VERIFY_H

#include "objective.h"

/* What is known of a cage. The Hessian is shifted as the library's certificates shift it: by a tenth of the energy, by
 * the number of vertices, for positions of root mean square radius 1. */
typedef struct verification {
    double decrement; /* half of gradient . Hessian^-1 gradient, similarities left out where nothing is held; by the
                         Gauss-Newton matrix where the Hessian has negative directions: as the library's */
    int positive;     /* it has none */
    double gain; /* the report's verification: what Newton's method, from here to its end, takes off the energy. Where
                    the Hessian has negative directions that is no local figure: it leaves along them */
} verification;

/* At x, which stays as it is. Options of the Newton solver have this prefix, those of the linear solver for the
 * decrement this prefix and `decrement_`. energy_limit_steps() was called. */
PetscErrorCode verify_at(energy *e, const char *prefix, Vec x, verification *out);

#endif
