/* Any bytes as a file of pins: they are refused with a message, or give pins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "fuzz_file.h"

#include "pins.h"

#include <stdlib.h>
#include <string.h>

const char fuzz_name[] = "pins";

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char message[128], *text = malloc(size + 1);
    pin_list pins;
    if (!text)
        return 0;
    memcpy(text, data, size);
    FILE *file = size ? file_of(text, size) : NULL;
    memset(message, 'x', sizeof message);
    if (file && pins_parse(file, &pins, message, sizeof message)) {
        FUZZ_CHECK(memchr(message, 0, sizeof message) && message[0] && !pins.vertices && !pins.n);
    } else if (file) {
        FUZZ_CHECK(pins.n > 0);
        for (int32_t i = 0; i < pins.n; i++)
            FUZZ_CHECK(pins.vertices[i] >= 0 && pins.freedom[i] >= 0 &&
                       pins.freedom[i] % CURVOPT_FREEDOM_OF_LIMIT_POINT <= 2 &&
                       pins.freedom[i] < 2 * CURVOPT_FREEDOM_OF_LIMIT_POINT);
        pins_free(&pins);
    }
    if (file)
        fclose(file);
    free(text);
    return 0;
}
