/* Vertices slide along boundaries and creases before a level is solved. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CO_SOLVE_SLIDE_H
#define CO_SOLVE_SLIDE_H

#include "solve/run.h"

/* Puts vertices of the present mesh back on their curves (sliding.h); on the first level lets them slide, in turns: in
 * each the objective, with a part for an even spacing, is minimized over everything that may move, and besides over the
 * vertices on curves along their tangents. Then these are put back on their curves. The result is run->at.start, from
 * which the level is then solved with these vertices held; iterations are counted in run->spent. Where the run was
 * cancelled by the callback, run->at has the level's result. Nothing happens where nothing may slide. As
 * curvopt_minimize. */
int32_t co_slide_level(co_run *run, int32_t number, curvopt_error *error);

#endif
