/* Sizes that no size_t holds are refused, not cut off. SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include "base/memory.h"

static void test_products_that_overflow_are_refused(void **state) {
    (void)state;
    double *p = CO_NEW(double, 4);
    CHECK_TRUE(p != NULL);
    p[3] = 7;
    /* cut off, these would be 0, 8 and 64 bytes */
    CHECK_TRUE(CO_RESIZED(p, SIZE_MAX / sizeof *p + 1) == NULL);
    CHECK_TRUE(CO_RESIZED(p, SIZE_MAX / sizeof *p + 2) == NULL);
    CHECK_TRUE(CO_RESIZED(p, SIZE_MAX / sizeof *p + 9) == NULL);
    CHECK_NEAR(p[3], 7, 0);
    CHECK_TRUE(CO_NEW(double, SIZE_MAX / sizeof *p + 2) == NULL);
    CHECK_TRUE(CO_NEW_ALIGNED(double, SIZE_MAX / sizeof *p + 9) == NULL);
    CHECK_TRUE(CO_NEW_ALIGNED(double, SIZE_MAX / sizeof *p) == NULL); /* only when rounded up to a cache line */
    free(p);
}

static void test_resizing_keeps_what_is_there(void **state) {
    (void)state;
    int32_t *p = NULL;
    for (int32_t n = 1; n <= 1000; n++) {
        int32_t *q = CO_RESIZED(p, n);
        CHECK_TRUE(q != NULL);
        p = q;
        p[n - 1] = n;
    }
    for (int32_t i = 0; i < 1000; i++)
        CHECK_INT(p[i], i + 1);
    free(p);
}

static void test_nothing_is_a_block_of_its_own(void **state) {
    (void)state;
    double *zeroed = CO_NEW(double, 0), *aligned = CO_NEW_ALIGNED(double, 0), *none = NULL;
    CHECK_TRUE(zeroed != NULL && aligned != NULL);
    CHECK_INT((uintptr_t)aligned % CO_MEMORY_ALIGNMENT, 0);
    double *shrunk = CO_RESIZED(zeroed, 0); /* realloc(p, 0) may free p and return NULL */
    CHECK_TRUE(shrunk != NULL);
    double *fresh = CO_RESIZED(none, 0);
    CHECK_TRUE(fresh != NULL);
    free(shrunk);
    free(fresh);
    free(aligned);
}

/* Large blocks, which may have pages of their own kind, hold what is written to their ends. */
static void test_large_blocks(void **state) {
    (void)state;
    for (size_t bytes = (size_t)15 << 20; bytes < (size_t)35 << 20; bytes += ((size_t)9 << 20) + 1) {
        unsigned char *p = CO_NEW_ALIGNED(unsigned char, bytes);
        CHECK_TRUE(p != NULL);
        CHECK_INT((uintptr_t)p % CO_MEMORY_ALIGNMENT, 0);
        p[0] = 3;
        p[bytes - 1] = 4;
        CHECK_INT(p[0] + p[bytes - 1], 7);
        free(p);
    }
    /* to be rounded up to a huge page it has no place */
    CHECK_TRUE(CO_NEW_ALIGNED(unsigned char, SIZE_MAX - 2 * CO_MEMORY_ALIGNMENT) == NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_products_that_overflow_are_refused), cmocka_unit_test(test_resizing_keeps_what_is_there),
        cmocka_unit_test(test_nothing_is_a_block_of_its_own), cmocka_unit_test(test_large_blocks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
