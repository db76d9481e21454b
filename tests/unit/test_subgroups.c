/* Subgroups: as many classes as group theory counts, each one closed, each one a symmetry of its own.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"
#include "check.h"

#include "constraints/subgroups.h"

#include <stdlib.h>

static co_symmetry symmetry_of(cage c, curvopt_mesh **mesh) {
    curvopt_error error;
    co_constraints hold = {0};
    co_symmetry s = {0};
    *mesh = cage_mesh(&c);
    CHECK_OK(co_symmetry_create(*mesh, c.xyz, &hold, 1, NULL, &s, &error), &error);
    cage_free(&c);
    return s;
}

static int is_closed(const co_symmetry *s, const uint8_t *member) {
    for (int32_t a = 0; a < s->order; a++)
        for (int32_t b = 0; b < s->order; b++)
            if (member[a] && member[b] && !member[s->product[a * s->order + b]])
                return 0;
    return member[0];
}

/* Products of matrices are the table's. */
static void check_table(const co_symmetry *s) {
    for (int32_t a = 0; a < s->order; a++)
        for (int32_t b = 0; b < s->order; b++) {
            const double *p = s->matrix + 9 * (size_t)a, *q = s->matrix + 9 * (size_t)b,
                         *r = s->matrix + 9 * (size_t)s->product[a * s->order + b];
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++)
                    CHECK_NEAR(p[3 * i] * q[j] + p[3 * i + 1] * q[3 + j] + p[3 * i + 2] * q[6 + j], r[3 * i + j],
                               1e-12);
        }
}

static void check_classes(cage c, int32_t order, int32_t n_classes) {
    curvopt_error error;
    curvopt_mesh *mesh;
    co_subgroups groups;
    co_symmetry s = symmetry_of(c, &mesh);
    CHECK_INT(s.order, order);
    check_table(&s);
    CHECK_OK(co_subgroups_create(&s, &groups, &error), &error);
    CHECK_INT(groups.n, n_classes);
    CHECK_INT(groups.order[0], order);
    CHECK_INT(groups.order[groups.n - 1], 1);
    for (int32_t k = 0; k < groups.n; k++) {
        const uint8_t *member = groups.member + (size_t)k * (size_t)order;
        co_symmetry part;
        int32_t count = 0;
        for (int32_t g = 0; g < order; g++)
            count += member[g];
        CHECK_INT(count, groups.order[k]);
        CHECK_TRUE(k == 0 || groups.order[k] <= groups.order[k - 1]);
        CHECK_TRUE(is_closed(&s, member));
        CHECK_OK(co_subgroup_select(&s, member, &part, &error), &error);
        CHECK_INT(part.order, count);
        check_table(&part);
        co_symmetry_free(&part);
    }
    co_subgroups_free(&groups);
    co_symmetry_free(&s);
    curvopt_mesh_destroy(mesh);
}

static void test_octahedral_group_has_33_classes(void **state) {
    (void)state;
    check_classes(cage_cube(), 48, 33);
}

static void test_tetrahedral_group_has_11_classes(void **state) {
    (void)state;
    check_classes(cage_tetrahedron(), 24, 11);
}

/* Of the dihedral group of 2 n elements: the divisors of n, twice, and those of n / 2 once more if n is even. */
static void test_dihedral_groups(void **state) {
    (void)state;
    check_classes(cage_prism(3), 12, 10);
    check_classes(cage_prism(5), 20, 10);
    check_classes(cage_trapezohedron(4), 16, 11);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_octahedral_group_has_33_classes),
        cmocka_unit_test(test_tetrahedral_group_has_11_classes),
        cmocka_unit_test(test_dihedral_groups),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
