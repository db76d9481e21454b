/* Cages that tests work on. SPDX-License-Identifier: GPL-3.0-or-later */
#include "cages.h"

#include "check.h"

#include <stdlib.h>

static const double pi = 3.14159265358979323846;

static int32_t corners_of(int32_t n_faces, const int32_t *sizes) {
    int32_t n = 0;
    for (int32_t f = 0; f < n_faces; f++)
        n += sizes[f];
    return n;
}

static cage allocate(int32_t n_vertices, int32_t n_faces, int32_t n_corners) {
    cage c = {.n_vertices = n_vertices, .n_faces = n_faces};
    c.sizes = calloc((size_t)n_faces + 1, sizeof *c.sizes);
    c.vertices = calloc((size_t)n_corners + 1, sizeof *c.vertices);
    c.xyz = calloc(3 * (size_t)n_vertices + 1, sizeof *c.xyz);
    CHECK_TRUE(c.sizes && c.vertices && c.xyz);
    return c;
}

cage cage_of(int32_t n_vertices, int32_t n_faces, const int32_t *sizes, const int32_t *vertices, const double *xyz) {
    int32_t n_corners = corners_of(n_faces, sizes);
    cage c = allocate(n_vertices, n_faces, n_corners);
    memcpy(c.sizes, sizes, sizeof *sizes * (size_t)n_faces);
    memcpy(c.vertices, vertices, sizeof *vertices * (size_t)n_corners);
    memcpy(c.xyz, xyz, sizeof *xyz * 3 * (size_t)n_vertices);
    return c;
}

cage cage_tetrahedron(void) {
    static const int32_t sizes[] = {3, 3, 3, 3}, vertices[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    static const double xyz[] = {1, 1, 1, -1, 1, -1, 1, -1, -1, -1, -1, 1};
    return cage_of(4, 4, sizes, vertices, xyz);
}

cage cage_cube(void) {
    static const int32_t sizes[] = {4, 4, 4, 4, 4, 4};
    static const int32_t vertices[] = {0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
    static const double xyz[] = {-1, -1, -1, -1, -1, 1, -1, 1, -1, -1, 1, 1, 1, -1, -1, 1, -1, 1, 1, 1, -1, 1, 1, 1};
    return cage_of(8, 6, sizes, vertices, xyz);
}

cage cage_torus(int32_t n_u, int32_t n_v, double big_radius, double small_radius) {
    cage c = allocate(n_u * n_v, n_u * n_v, 4 * n_u * n_v);
    for (int32_t i = 0; i < n_u; i++)
        for (int32_t j = 0; j < n_v; j++) {
            int32_t f = i * n_v + j, i1 = (i + 1) % n_u, j1 = (j + 1) % n_v, *corner = c.vertices + 4 * f;
            double a = 2 * pi * i / n_u, b = 2 * pi * j / n_v, r = big_radius + small_radius * cos(b);
            c.sizes[f] = 4;
            corner[0] = i * n_v + j;
            corner[1] = i1 * n_v + j;
            corner[2] = i1 * n_v + j1;
            corner[3] = i * n_v + j1;
            c.xyz[3 * f] = r * cos(a);
            c.xyz[3 * f + 1] = r * sin(a);
            c.xyz[3 * f + 2] = small_radius * sin(b);
        }
    return c;
}

cage cage_trapezohedron(int32_t n) {
    cage c = allocate(2 * n + 2, 2 * n, 8 * n);
    for (int32_t k = 0; k < 2 * n; k++) {
        int32_t before = (k + 2 * n - 1) % (2 * n), after = (k + 1) % (2 * n), *corner = c.vertices + 4 * k;
        int upper = k % 2 == 0;
        c.sizes[k] = 4; /* the kite below or above ring vertex k */
        corner[0] = upper ? 2 * n : 2 * n + 1;
        corner[1] = upper ? before : after;
        corner[2] = k;
        corner[3] = upper ? after : before;
        c.xyz[3 * k] = cos(pi * k / n);
        c.xyz[3 * k + 1] = sin(pi * k / n);
        c.xyz[3 * k + 2] = upper ? -0.3 : 0.3;
    }
    c.xyz[6 * n + 2] = 1.2;
    c.xyz[6 * n + 5] = -1.2;
    return c;
}

cage cage_half_star(int32_t n, int32_t m) {
    const int32_t per_sector = m * (m + 1); /* places x = 1 .. m, y = 0 .. m; the last sector's x = 0 comes after all */
    cage c = allocate(1 + n * per_sector + m, n * m * m, 4 * n * m * m);
    for (int32_t s = 0; s <= n; s++)
        for (int32_t y = 0; y <= (s < n ? m : 0); y++)
            for (int32_t x = 1; x <= m; x++) {
                double *to = c.xyz + 3 * (1 + s * per_sector + y * m + x - 1);
                const double angle = (s * pi + 2 * atan2(y, x)) / n;
                to[0] = hypot(x, y) * cos(angle);
                to[1] = hypot(x, y) * sin(angle);
                to[2] = 0.1 * m * sin(1.3 * to[0] / m) * (1 + to[1] / m);
            }
    for (int32_t f = 0; f < n * m * m; f++) {
        static const int32_t corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        c.sizes[f] = 4;
        for (int k = 0; k < 4; k++) {
            const int32_t s = f / (m * m), x = f % m + corner[k][0], y = f / m % m + corner[k][1];
            c.vertices[4 * f + k] = x > 0   ? 1 + s * per_sector + y * m + x - 1
                                    : y > 0 ? 1 + (s + 1) * per_sector + y - 1
                                            : 0;
        }
    }
    return c;
}

cage cage_prism(int32_t n) {
    cage c = allocate(2 * n, n + 2, 6 * n);
    c.sizes[0] = c.sizes[1] = n;
    for (int32_t k = 0; k < n; k++) {
        int32_t next = (k + 1) % n, *side = c.vertices + 2 * n + 4 * k;
        c.vertices[k] = n - 1 - k; /* bottom, seen from below */
        c.vertices[n + k] = n + k;
        c.sizes[2 + k] = 4;
        side[0] = k;
        side[1] = next;
        side[2] = n + next;
        side[3] = n + k;
        for (int level = 0; level < 2; level++) {
            double *p = c.xyz + 3 * (k + level * n);
            p[0] = cos(2 * pi * k / n);
            p[1] = sin(2 * pi * k / n);
            p[2] = level ? 0.8 : -0.8;
        }
    }
    return c;
}

cage cage_both(cage a, cage b, double shift) {
    int32_t corners_a = corners_of(a.n_faces, a.sizes), corners_b = corners_of(b.n_faces, b.sizes);
    cage c = allocate(a.n_vertices + b.n_vertices, a.n_faces + b.n_faces, corners_a + corners_b);
    memcpy(c.sizes, a.sizes, sizeof *a.sizes * (size_t)a.n_faces);
    memcpy(c.sizes + a.n_faces, b.sizes, sizeof *b.sizes * (size_t)b.n_faces);
    memcpy(c.vertices, a.vertices, sizeof *a.vertices * (size_t)corners_a);
    for (int32_t k = 0; k < corners_b; k++)
        c.vertices[corners_a + k] = b.vertices[k] + a.n_vertices;
    memcpy(c.xyz, a.xyz, sizeof *a.xyz * 3 * (size_t)a.n_vertices);
    for (int32_t i = 0; i < 3 * b.n_vertices; i++)
        c.xyz[3 * a.n_vertices + i] = b.xyz[i] + (i % 3 == 0 ? shift : 0);
    cage_free(&a);
    cage_free(&b);
    return c;
}

cage cage_refined(cage c, int times) {
    for (int i = 0; i < times; i++) {
        curvopt_mesh *mesh = cage_mesh(&c), *fine;
        curvopt_mesh_info info;
        curvopt_error error;
        curvopt_mesh_get_info(mesh, &info, sizeof info);
        int32_t n_vertices = info.n_vertices + info.n_edges + info.n_faces;
        double *xyz = calloc(3 * (size_t)n_vertices, sizeof *xyz);
        CHECK_TRUE(xyz != NULL);
        CHECK_OK(curvopt_mesh_refine(mesh, c.xyz, &fine, xyz, &error), &error);
        curvopt_mesh_get_info(fine, &info, sizeof info);
        cage_free(&c);
        c = allocate(info.n_vertices, info.n_faces, info.n_corners);
        curvopt_mesh_get_faces(fine, c.sizes, c.vertices);
        memcpy(c.xyz, xyz, sizeof *xyz * 3 * (size_t)n_vertices);
        free(xyz);
        curvopt_mesh_destroy(fine);
        curvopt_mesh_destroy(mesh);
    }
    return c;
}

void cage_perturb(cage *c, double amount, uint64_t seed) {
    for (int32_t i = 0; i < 3 * c->n_vertices; i++)
        c->xyz[i] += amount * check_random(&seed);
}

cage cage_shaken(cage c, double amount) {
    cage_perturb(&c, amount, 5);
    return c;
}

void cage_free(cage *c) {
    free(c->sizes);
    free(c->vertices);
    free(c->xyz);
    *c = (cage){0};
}

curvopt_mesh *cage_mesh(const cage *c) {
    curvopt_mesh *mesh = NULL;
    curvopt_error error;
    CHECK_OK(curvopt_mesh_create(c->n_vertices, c->n_faces, c->sizes, c->vertices, &mesh, &error), &error);
    return mesh;
}
