/* Constants of adaptive quadrature. SPDX-License-Identifier: GPL-3.0-or-later */
#include "energy/quadrature_tuning.h"

#define CO_QUADRATURE_TUNING_VALUE(type, name, value, ...) .name = (value),
const co_quadrature_tuning co_quadrature_tuning_default = {CO_QUADRATURE_TUNING_LIST(CO_QUADRATURE_TUNING_VALUE)};
