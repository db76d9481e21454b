/* Energies and gradients in single precision, of twice as many faces in a vector, or by vectors half as long. Compiled
 * once per instruction set, as element_kernel.c. SPDX-License-Identifier: GPL-3.0-or-later */
#define CO_SINGLE

#include "energy/element_kernel.h"

#include "base/instruction_set.h"
#include "energy/kernel_samples.h"

#define STRING_(x) #x
#define STRING(x)  STRING_(x)
const co_element_kernel CO_NAME_OF_SET(co_element_kernel_single) = {
    .lanes = CO_LANES, .is_single = 1, .name = STRING(CO_INSTRUCTION_SET), .run = run};
