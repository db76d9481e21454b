/* Bytes one after the other, and 0 behind the last. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEST_FUZZ_READER_H
#define TEST_FUZZ_READER_H

#include <stdint.h>

typedef struct reader {
    const uint8_t *at, *end;
} reader;

static inline int next(reader *r) {
    return r->at < r->end ? *r->at++ : 0;
}

#endif
