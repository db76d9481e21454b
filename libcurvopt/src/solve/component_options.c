/* The options of a run, for each component of its cage. SPDX-License-Identifier: GPL-3.0-or-later */
#include "solve/component_options.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

int co_component_options_fit(const curvopt_options *o) {
    int is_tied = o->no_crossings || o->joshi_sequin;
    for (int s = 0; s < CURVOPT_N_SCALARS; s++)
        is_tied |= o->scalar_rule[s] == CURVOPT_SCALAR_RULE_VALUE || o->scalar_rule[s] == CURVOPT_SCALAR_RULE_REDUCED;
    return !is_tied;
}

/* ----------------------------------------------------------------------------------------- which has what -- */

/* Numbers the items by the component that `component_of` says; -1: of none. */
static int32_t group(const curvopt_options *o, const co_components *c, int32_t n,
                     int32_t (*component_of)(const curvopt_options *o, const co_components *c, int32_t i),
                     co_component_items *out, curvopt_error *error) {
    out->first = CO_NEW(int32_t, (size_t)c->n + 2);
    out->item = CO_NEW(int32_t, n);
    if (!out->first || !out->item)
        return co_status_no_memory(error);
    for (int32_t i = 0; i < n; i++)
        if (component_of(o, c, i) >= 0)
            out->first[component_of(o, c, i) + 2]++;
    for (int32_t k = 0; k < c->n; k++)
        out->first[k + 2] += out->first[k + 1];
    for (int32_t i = 0; i < n; i++)
        if (component_of(o, c, i) >= 0)
            out->item[out->first[component_of(o, c, i) + 1]++] = i;
    return CURVOPT_OK;
}

static int32_t of_constraint(const curvopt_options *o, const co_components *c, int32_t i) {
    return c->of_vertex[o->constraints->vertices[i]];
}

static int is_at_vertex(const curvopt_through *t, int32_t i) {
    return t->vertices && t->vertices[i] >= 0;
}

static int32_t of_entry(const curvopt_options *o, const co_components *c, int32_t i) {
    const curvopt_through *t = o->through;
    return is_at_vertex(t, i) ? c->of_vertex[t->vertices[i]] : c->of_face[t->faces[i]];
}

static int32_t of_chain(const curvopt_options *o, const co_components *c, int32_t i) {
    return c->of_vertex[o->through->chains[i].vertices[0]];
}

static int32_t of_hole(const curvopt_options *o, const co_components *c, int32_t i) {
    return c->of_face[o->holes[i]];
}

int32_t co_component_shares_create(const curvopt_options *o, const co_components *c, co_component_shares *out,
                                   curvopt_error *error) {
    *out = (co_component_shares){0};
    int32_t status = group(o, c, o->constraints ? o->constraints->n : 0, of_constraint, &out->constraints, error);
    if (status == CURVOPT_OK)
        status = group(o, c, o->through ? o->through->n : 0, of_entry, &out->entries, error);
    if (status == CURVOPT_OK)
        status = group(o, c, o->through ? o->through->n_chains : 0, of_chain, &out->chains, error);
    if (status == CURVOPT_OK)
        status = group(o, c, o->n_holes, of_hole, &out->holes, error);
    if (status != CURVOPT_OK)
        co_component_shares_free(out);
    return status;
}

void co_component_shares_free(co_component_shares *s) {
    co_component_items *const all[] = {&s->constraints, &s->entries, &s->chains, &s->holes};
    for (int k = 0; k < 4; k++) {
        free(all[k]->first);
        free(all[k]->item);
    }
    *s = (co_component_shares){0};
}

/* -------------------------------------------------------------------------------------- what one has of it -- */

/* Some items of the whole's options, and where copies of their arrays go. */
typedef struct share {
    int32_t n;
    const int32_t *item;
    int32_t *integers; /* the next free place */
    double *reals;
} share;

static share share_of(const co_component_items *items, int32_t c, share *after) {
    return (share){.n = items->first[c + 1] - items->first[c],
                   .item = items->item + items->first[c],
                   .integers = after->integers,
                   .reals = after->reals};
}

/* The items' integers, renumbered unless `number` is NULL; NULL where there are none. */
static const int32_t *take_integers(share *s, const int32_t *from, const int32_t *number) {
    int32_t *to = s->integers;
    if (!from)
        return NULL;
    for (int32_t i = 0; i < s->n; i++)
        to[i] = number ? number[from[s->item[i]]] : from[s->item[i]];
    s->integers += s->n;
    return to;
}

/* The items' tuples of `width` numbers; NULL where there are none. */
static const double *take_reals(share *s, const double *from, size_t width) {
    double *to = s->reals;
    if (!from)
        return NULL;
    for (size_t i = 0; i < (size_t)s->n; i++)
        for (size_t k = 0; k < width; k++)
            to[width * i + k] = from[width * (size_t)s->item[i] + k];
    s->reals += width * (size_t)s->n;
    return to;
}

static void take_constraints(share *s, const curvopt_constraints *from, const co_components *c,
                             curvopt_constraints *out) {
    *out = (curvopt_constraints){.n = s->n,
                                 .vertices = take_integers(s, from->vertices, c->vertex),
                                 .freedom = take_integers(s, from->freedom, NULL),
                                 .directions = take_reals(s, from->directions, 3),
                                 .weights = take_reals(s, from->weights, 1),
                                 .has_places = from->has_places,
                                 .places = from->has_places ? take_reals(s, from->places, 3) : NULL};
}

static int has_tangent(const curvopt_through *t, int32_t i) {
    const double *d = t->tangents ? t->tangents + 3 * (size_t)i : NULL;
    return d && !(isnan(d[0]) && isnan(d[1]) && isnan(d[2]));
}

/* Of an entry at a vertex `toward` is a vertex, too; without a tangent it may be anything. */
static void take_entries(share *s, const curvopt_through *from, const co_components *c, curvopt_through *out) {
    int32_t *vertices = s->integers, *faces = vertices + s->n, *toward = faces + s->n;
    s->integers += 3 * (size_t)s->n;
    for (int32_t i = 0; i < s->n; i++) {
        const int32_t k = s->item[i], at_vertex = is_at_vertex(from, k), to = from->toward ? from->toward[k] : 0;
        vertices[i] = at_vertex ? c->vertex[from->vertices[k]] : -1;
        faces[i] = at_vertex ? 0 : c->face[from->faces[k]];
        toward[i] = at_vertex && has_tangent(from, k) ? c->vertex[to] : to;
    }
    *out = (curvopt_through){.struct_size = (int32_t)sizeof *out,
                             .n = s->n,
                             .vertices = vertices,
                             .faces = faces,
                             .corners = take_integers(s, from->corners, NULL),
                             .uv = take_reals(s, from->uv, 2),
                             .freedom = take_integers(s, from->freedom, NULL),
                             .directions = take_reals(s, from->directions, 3),
                             .places = take_reals(s, from->places, 3),
                             .normals = take_reals(s, from->normals, 3),
                             .tangents = take_reals(s, from->tangents, 3),
                             .toward = from->toward ? toward : NULL,
                             .weights = take_reals(s, from->weights, 1),
                             .curvatures = take_reals(s, from->curvatures, 2),
                             .curvature_directions = take_reals(s, from->curvature_directions, 3)};
}

static void take_chains(share *s, const curvopt_through *from, const co_components *c, curvopt_chain *chains,
                        curvopt_through *out) {
    for (int32_t i = 0; i < s->n; i++) {
        chains[i] = from->chains[s->item[i]];
        for (int32_t k = 0; k < chains[i].n_vertices; k++)
            s->integers[k] = c->vertex[chains[i].vertices[k]];
        chains[i].vertices = s->integers;
        s->integers += chains[i].n_vertices;
    }
    out->chains = chains;
    out->n_chains = s->n;
    out->chain_weights = take_reals(s, from->chain_weights, 1);
}

/* Vertices of the component's chains in all. */
static size_t count_chain_vertices(const curvopt_options *o, const co_component_items *chains, int32_t c) {
    size_t n = 0;
    for (int32_t i = chains->first[c]; i < chains->first[c + 1]; i++)
        n += (size_t)o->through->chains[chains->item[i]].n_vertices;
    return n;
}

static int32_t allocate(const curvopt_options *o, const co_component_shares *shares, int32_t c,
                        co_component_options *out, curvopt_error *error) {
    share none = {0};
    const size_t constraints = (size_t)share_of(&shares->constraints, c, &none).n;
    const size_t entries = (size_t)share_of(&shares->entries, c, &none).n;
    const size_t chains = (size_t)share_of(&shares->chains, c, &none).n;
    const size_t holes = (size_t)share_of(&shares->holes, c, &none).n;
    out->integers =
        CO_NEW(int32_t, 2 * constraints + 5 * entries + holes + count_chain_vertices(o, &shares->chains, c));
    out->reals = CO_NEW(double, 7 * constraints + 20 * entries + chains);
    out->chains = CO_NEW(curvopt_chain, chains);
    if (out->integers && out->reals && out->chains)
        return CURVOPT_OK;
    co_component_options_free(out);
    return co_status_no_memory(error);
}

int32_t co_component_options_create(const curvopt_options *o, const co_components *components,
                                    const co_component_shares *shares, int32_t c, co_component_options *out,
                                    curvopt_error *error) {
    *out = (co_component_options){.options = *o};
    int32_t status = allocate(o, shares, c, out, error);
    if (status != CURVOPT_OK)
        return status;
    share begin = {.integers = out->integers, .reals = out->reals};
    share s = share_of(&shares->constraints, c, &begin);
    if (s.n)
        take_constraints(&s, o->constraints, components, &out->constraints);
    out->options.constraints = s.n ? &out->constraints : NULL;
    s = share_of(&shares->entries, c, &s);
    int32_t n_through = s.n;
    if (s.n)
        take_entries(&s, o->through, components, &out->through);
    s = share_of(&shares->chains, c, &s);
    if (s.n)
        take_chains(&s, o->through, components, out->chains, &out->through);
    n_through += s.n;
    out->through.struct_size = (int32_t)sizeof out->through;
    out->options.through = n_through ? &out->through : NULL;
    s = share_of(&shares->holes, c, &s);
    out->options.n_holes = s.n;
    out->options.holes = s.n ? take_integers(&s, o->holes, components->face) : NULL;
    return CURVOPT_OK;
}

void co_component_options_free(co_component_options *o) {
    free(o->integers);
    free(o->reals);
    free(o->chains);
    *o = (co_component_options){0};
}
