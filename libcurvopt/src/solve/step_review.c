/* The review of steps. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/step_review.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int32_t co_step_review_create(const co_tuning *tuning, const co_reviewed *function, co_step_review *r,
                              curvopt_error *error) {
    *r = (co_step_review){.tuning = tuning,
                          .function = *function,
                          .first = CO_NEW(double, function->n),
                          .safe = CO_NEW(double, function->n)};
    if (r->first && r->safe)
        return CURVOPT_OK;
    co_step_review_free(r);
    return co_status_no_memory(error);
}

void co_step_review_free(co_step_review *r) {
    free(r->first);
    free(r->safe);
    *r = (co_step_review){0};
}

static void remember(const co_step_review *r, double *place, const double *x) {
    memcpy(place, x, r->function.n * sizeof *place);
}

/* Radians; a smaller defect is rounding of the rules. */
static const double DEFECT_FLOOR = 1e-3;

void co_step_review_begin(co_step_review *r, const double *x, double defect) {
    remember(r, r->first, x);
    remember(r, r->safe, x);
    r->value = (double)INFINITY;
    r->defect = defect;
}

int co_step_review_is_due(const co_step_review *r, const co_step_facts *facts) {
    const co_tuning *t = r->tuning;
    int is_suspicious = !(facts->defect <= t->defect_growth * r->defect + DEFECT_FLOOR);
    return is_suspicious || facts->iteration % t->review_every == 0 ||
           (facts->counts_length && facts->length > t->review_step);
}

void co_step_review_take_back(co_step_review *r, co_iterate *now) {
    remember(r, now->x, r->safe);
    r->function.evaluate(r->function.context, now);
}

/* Whether `now` is below the safe iterate by the rules that stand now; both are evaluated by these. */
static int is_progress(co_step_review *r, co_iterate *now) {
    co_iterate safe = {.x = r->safe, .gradient = now->gradient};
    r->function.evaluate(r->function.context, &safe);
    r->function.evaluate(r->function.context, now);
    return now->value <= safe.value;
}

int32_t co_step_review_check(co_step_review *r, co_iterate *now, co_step_verdict *verdict, curvopt_error *error) {
    const co_reviewed *f = &r->function;
    int resolved, changed;
    double defect;
    int32_t status = f->resolve(f->context, now->x, &resolved, &changed, &defect, error);
    if (status != CURVOPT_OK) {
        co_step_review_take_back(r, now);
        *verdict = CO_STEP_STOP;
        return status;
    }
    const int stands = resolved && (!changed || is_progress(r, now));
    if (!stands)
        co_step_review_take_back(r, now);
    const int is_lost = changed && now->value > r->tuning->review_fold * fabs(r->value);
    if (!stands || is_lost) {
        *verdict = is_lost ? CO_STEP_STOP : CO_STEP_REJECT;
        return CURVOPT_OK;
    }
    r->defect = defect;
    remember(r, r->safe, now->x);
    r->value = now->value;
    *verdict = changed ? CO_STEP_CHANGED : CO_STEP_KEEP;
    if (changed)
        return CURVOPT_OK;
    status = f->coarsen(f->context, &changed, error);
    if (status == CURVOPT_OK && changed) {
        f->evaluate(f->context, now);
        *verdict = CO_STEP_CHANGED;
    }
    if (status != CURVOPT_OK)
        *verdict = CO_STEP_STOP;
    return status;
}
