/* Every heuristic number of quadrature, of the optimizers and of the solver. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include "base/tuning.h"

#define CO_TUNING_VALUE(type, name, value, ...) .name = (value),
const co_tuning co_tuning_defaults = {CO_TUNING_LIST(CO_TUNING_VALUE)};

const co_tuning *co_tuning_of_runs(void) {
    return &co_tuning_defaults;
}

enum { CO_TUNING_IS_int = 1, CO_TUNING_IS_double = 0 };
#define CO_TUNING_ROW(type, name, value, least, largest, unit, why, note)                                              \
    {#name, unit, why, note, offsetof(co_tuning, name), value, least, largest, CO_TUNING_IS_##type},

const co_tuning_entry *co_tuning_table(size_t *n) {
    static const co_tuning_entry rows[] = {CO_TUNING_LIST(CO_TUNING_ROW)};
    *n = sizeof rows / sizeof *rows;
    return rows;
}
