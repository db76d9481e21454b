/* The features that the macOS build for Intel's processors finds, by the compiler's own question for them. The file is
 * compiled here for this system, which answers as macOS would.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "check.h"

#include <stdio.h>
#include <string.h>

void co_cpu_model_read(void);
int sysctlbyname(const char *name, void *out, size_t *out_size, const void *in, size_t in_size);

static const char *there; /* names, with a space behind each, that this system knows and says yes to */

int sysctlbyname(const char *name, void *out, size_t *out_size, const void *in, size_t in_size) {
    char found[64];
    assert_true(*out_size == sizeof(int) && !in && in_size == 0);
    snprintf(found, sizeof found, "%s ", name);
    if (strstr(name, "512")) { /* names that an older macOS does not know */
        if (!there || !strstr(there, found))
            return -1;
    }
    *(int *)out = there && strstr(there, found);
    return 0;
}

/* How the compiler is answered on a system with these features, one digit for each question. */
static int asked(const char *names) {
    there = names;
    co_cpu_model_read();
    int answer = __builtin_cpu_supports("avx2") ? 1 : 0;
    answer += __builtin_cpu_supports("fma") ? 10 : 0;
    answer += __builtin_cpu_supports("avx512f") ? 100 : 0;
    answer += __builtin_cpu_supports("avx512vl") ? 1000 : 0;
    return answer + (__builtin_cpu_supports("avx512dq") ? 10000 : 0);
}

static void every_feature_is_the_one_that_the_compiler_asks_for(void **state) {
    (void)state;
    assert_int_equal(asked(""), 0);
    assert_int_equal(asked("hw.optional.avx2_0 "), 1);
    assert_int_equal(asked("hw.optional.fma "), 10);
    assert_int_equal(asked("hw.optional.avx512f "), 100);
    assert_int_equal(asked("hw.optional.avx512vl "), 1000);
    assert_int_equal(asked("hw.optional.avx512dq "), 10000);
    assert_int_equal(asked("hw.optional.avx2_0 hw.optional.fma hw.optional.avx512f "), 111);
    assert_int_equal(asked(""), 0); /* nothing is left of the question before */
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_feature_is_the_one_that_the_compiler_asks_for)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
