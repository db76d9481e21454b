/* How much of a minimum's energy is the net's. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/discretization_error.h"

#include <math.h>

static const double LEAST_RATIO = 0.6;
static const double MOST_RATIO = 0.9; /* with more, the estimate would be over nine times the last difference */

/* Whether a level came to what its net has. */
static int is_finished(const curvopt_level_report *level) {
    return level->stop == CURVOPT_STOP_CONVERGED || level->stop == CURVOPT_STOP_SETTLED ||
           level->stop == CURVOPT_STOP_STALLED;
}

double co_discretization_error(const curvopt_level_report *levels, int32_t n) {
    if (n < 2)
        return (double)NAN;
    for (int32_t i = n > 3 ? n - 3 : 0; i < n; i++)
        if (!is_finished(&levels[i]))
            return (double)NAN;
    const double last = fabs(levels[n - 2].energy - levels[n - 1].energy);
    const double before = n > 2 ? fabs(levels[n - 3].energy - levels[n - 2].energy) : (double)INFINITY;
    if (last == 0)
        return 0;
    if (!(last <= MOST_RATIO * before))
        return (double)NAN;
    const double ratio = fmax(last / before, LEAST_RATIO);
    return fmin(last * ratio / (1 - ratio), levels[n - 1].energy);
}
