/* Any bytes as an OBJ file: they are refused with a message, or give a cage whose counts agree.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "fuzz.h"

#include "obj_cage.h"

#include <stdlib.h>
#include <string.h>

const char fuzz_name[] = "obj";

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char message[128];
    obj_cage cage;
    char *text = malloc(size ? size : 1); /* of exactly this size, so that reading past it is seen */
    if (!text)
        return 0;
    memcpy(text, data, size);
    memset(message, 'x', sizeof message);
    if (obj_parse(text, size, &cage, message, sizeof message)) {
        FUZZ_CHECK(memchr(message, 0, sizeof message) && message[0] && !cage.xyz && !cage.face_vertices);
    } else {
        int64_t n_corners = 0;
        double sum = 0;
        FUZZ_CHECK(cage.n_vertices > 0 && cage.n_faces > 0);
        for (int32_t f = 0; f < cage.n_faces; f++) {
            FUZZ_CHECK(cage.face_sizes[f] >= 0);
            n_corners += cage.face_sizes[f];
        }
        for (int64_t c = 0; c < n_corners; c++)
            FUZZ_CHECK(cage.face_vertices[c] >= 0);
        for (int32_t i = 0; i < 3 * cage.n_vertices; i++)
            sum += cage.xyz[i];
        FUZZ_CHECK(sum == sum || sum != sum); /* all of it has been read */
        obj_free(&cage);
    }
    free(text);
    return 0;
}
