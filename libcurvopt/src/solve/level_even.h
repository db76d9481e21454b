/* A level whose faces fold while its shape forms: it forms once more, with walls against thin corners.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_LEVEL_EVEN_H
#define CO_SOLVE_LEVEL_EVEN_H

#include "solve/level.h"

/* Callbacks of the schedule (co_scheduled); level: a co_level. */

/* Once the shape has formed: whether, with `begun`, faces have folded or pinched on the way, on the first level, where
 * cages are to be even and edges have no walls of their own (third order). Then the iterate is the first one again,
 * corners have walls, and level->formed has the shape. ERROR_MEMORY. */
int32_t co_level_begin_even(void *level, int *begun, curvopt_error *error);
/* After the stage that follows, however that has ended: walls go. The shape stays if its energy is about what it is
 * without; if not, the iterate is the shape without. */
void co_level_end_even(void *level);

#endif
