/* Whether a cage is a minimum, by a Hessian from finite differences of the gradient. SPDX-License-Identifier:
 * GPL-3.0-or-later */
#ifndef CURVOPT_TAO_CERTIFICATE_H
#define CURVOPT_TAO_CERTIFICATE_H

#include "objective.h"

/* What is known of a cage. The Hessian is shifted as the library's certificates shift it: by `shift_least`
 * (base/tuning.h) of the objective divided by the number of vertices, for positions of root mean square radius 1. */
typedef struct certificate {
    double decrement; /* half of gradient . Hessian^-1 gradient, similarities left out where nothing is fixed; by the
                         Gauss-Newton matrix where the Hessian has negative directions: as the library's */
    int positive;     /* the Hessian has no negative directions */
    double gain;      /* the report's verification: what Newton's method, from here to its end, takes off the objective.
                         Where      the Hessian has negative directions that is no local figure: it leaves along them */
} certificate;

/* At x, which stays as it is. Options of the Newton solver have this prefix, those of the linear solver for the
 * decrement this prefix and `decrement_`. objective_limit_steps() was called. */
PetscErrorCode certificate_find(objective *o, const char *prefix, Vec x, certificate *out);

#endif
