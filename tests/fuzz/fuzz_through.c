/* Any bytes as a file of what the surface goes through: they are refused with a message, or give entries.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "fuzz_file.h"

#include "through.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char fuzz_name[] = "through";

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char message[128], *text = malloc(size + 1);
    through_list list;
    if (!text)
        return 0;
    memcpy(text, data, size);
    FILE *file = size ? file_of(text, size) : NULL;
    memset(message, 'x', sizeof message);
    if (file && through_parse(file, &list, message, sizeof message)) {
        FUZZ_CHECK(memchr(message, 0, sizeof message) && message[0] && !list.integers && !list.reals && !list.chains);
    } else if (file) {
        const curvopt_through *t = &list.given;
        FUZZ_CHECK(t->n > 0 || t->n_chains > 0);
        for (int32_t i = 0; i < t->n_chains; i++) {
            const curvopt_chain *c = &t->chains[i];
            FUZZ_CHECK(c->n_vertices > 1 && c->n_points > 0 && c->curve);
            FUZZ_CHECK(t->chain_weights[i] >= 0 && t->chain_weights[i] <= 1);
            FUZZ_CHECK(c->vertices[0] >= 0 && c->vertices[c->n_vertices - 1] >= 0);
            FUZZ_CHECK(!isnan(c->curve[3 * c->n_points - 1]));
            FUZZ_CHECK(!c->parameters || !isnan(c->parameters[c->n_vertices - 1]));
        }
        for (int32_t i = 0; i < t->n; i++) {
            FUZZ_CHECK(t->freedom[i] >= 0 && t->freedom[i] <= 3 && t->vertices[i] >= -1);
            FUZZ_CHECK(t->vertices[i] >= 0 || (t->faces[i] >= 0 && !isnan(t->uv[2 * i]) && !isnan(t->uv[2 * i + 1])));
            FUZZ_CHECK(t->weights[i] >= 0 && t->weights[i] <= 1);
            FUZZ_CHECK(isnan(t->curvatures[2 * i]) == isnan(t->curvatures[2 * i + 1]));
            FUZZ_CHECK(isnan(t->curvatures[2 * i]) || !isnan(t->normals[3 * i]));
            FUZZ_CHECK(isnan(t->curvature_directions[3 * i]) || !isnan(t->curvatures[2 * i]));
            FUZZ_CHECK(t->freedom[i] < 3 || !isnan(t->normals[3 * i]) || !isnan(t->tangents[3 * i]));
        }
        through_free(&list);
    }
    if (file)
        fclose(file);
    free(text);
    return 0;
}
