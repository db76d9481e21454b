/* What goes out: cage, report, gradient. SPDX-License-Identifier: GPL-3.0-or-later */
#include "atomic_file.h"
#include "collective.h"
#include "main.h"
#include "output_obj.h"
#include "report_json.h"

#include <stdlib.h>
#include <string.h>

/* A file of rank 0 that all ranks write to; `writer` as write_cage(). */
static int stage(const program *p, const char *path,
                 PetscErrorCode (*writer)(const portion *, const double *, FILE *, int *), const double *what,
                 staged *out) {
    int failed = 0;
    *out = (staged){0};
    if (p->rank == 0)
        failed = staged_open(out, path);
    failed = program_follow(p, failed);
    if (failed)
        return program_say(p, ARGUMENTS_COULD_NOT, path, strerror(failed));
    PetscCallAbort(p->comm, writer(&p->on, what, out->file, &failed));
    if (p->rank == 0) {
        failed = staged_close(out);
        if (failed)
            staged_discard(out);
    }
    failed = program_follow(p, failed);
    return failed ? program_say(p, ARGUMENTS_COULD_NOT, path, strerror(failed)) : ARGUMENTS_DONE;
}

static int commit(const program *p, staged *out) {
    const char *path = out->path;
    int failed = p->rank == 0 && path ? staged_commit(out) : 0;
    failed = program_follow(p, failed);
    return failed ? program_say(p, ARGUMENTS_COULD_NOT, path, strerror(failed)) : ARGUMENTS_DONE;
}

int deliver_gradient(program *p) {
    char path[PETSC_MAX_PATH_LEN];
    PetscBool wanted;
    staged file;
    int refused = 0;
    PetscCallAbort(p->comm, PetscOptionsGetString(NULL, NULL, "-curvopt_gradient", path, sizeof path, &wanted));
    if (!wanted)
        return ARGUMENTS_DONE;
    double *own = AGREE_NEW(p->comm, double, 3 * (size_t)p->on.n_own);
    PetscCallAbort(p->comm, level_gradient(&p->on, &p->args.options, p->xyz, own, &refused));
    int code = refused ? ARGUMENTS_DONE : stage(p, path, write_vectors, own, &file);
    if (!refused && code == ARGUMENTS_DONE)
        code = commit(p, &file);
    free(own);
    return code;
}

/* What each rank did, as members of the JSON object; on rank 0. */
static char *rank_figures(const program *p) {
    enum { N_FIGURES = 6, ROOM = 32 };
    static const char *const name[N_FIGURES] = {
        "own_vertices", "halo_vertices", "faces", "cpu_seconds_an_evaluation", "least_seconds_a_gradient",
        "memory_bytes"};
    double own_faces = 0;
    for (PetscInt f = 0; f < p->on.n_faces; f++)
        own_faces += p->on.counts[f];
    const double mine[N_FIGURES] = {p->on.n_own,
                                    p->on.n_vertices - p->on.n_own,
                                    own_faces,
                                    p->run.cpu_seconds / p->run.evaluations,
                                    p->run.least_seconds,
                                    p->memory};
    double *gathered = AGREE_NEW(p->comm, double, N_FIGURES *(size_t)p->n_ranks);
    size_t size = 400 + N_FIGURES * ROOM * ((size_t)p->n_ranks + 1), at = 0;
    char *text = AGREE_NEW(p->comm, char, size);
    MPI_Gather(mine, N_FIGURES, MPI_DOUBLE, gathered, N_FIGURES, MPI_DOUBLE, 0, p->comm);
    at += (size_t)snprintf(text + at, size - at, "  \"tao\": {\"ranks\": %d, \"threads\": %d", p->n_ranks,
                           (int)p->args.options.threads);
    for (int k = 0; k < N_FIGURES; k++) {
        at += (size_t)snprintf(text + at, size - at, ", \"%s\": [", name[k]);
        for (int r = 0; r < p->n_ranks; r++)
            at += (size_t)snprintf(text + at, size - at, "%s%.6g", r ? ", " : "", gathered[N_FIGURES * r + k]);
        at += (size_t)snprintf(text + at, size - at, "]");
    }
    const verification *all = &p->run.all, *shape = &p->run.shape;
    if (p->run.verified)
        at += (size_t)snprintf(text + at, size - at,
                               ", \"newton_gain\": %.6g, \"shape_gain\": %.6g, \"hessian_positive\": %s, "
                               "\"shape_hessian_positive\": %s",
                               all->gain, shape->gain, all->positive ? "true" : "false",
                               shape->positive ? "true" : "false");
    snprintf(text + at, size - at, "},\n");
    free(gathered);
    return text;
}

static int stage_json(const program *p, staged *out) {
    const portion *on = &p->on;
    *out = (staged){0};
    if (!p->args.json)
        return ARGUMENTS_DONE;
    char *more = rank_figures(p);
    int failed = p->rank == 0 ? staged_open(out, p->args.json) : 0;
    if (p->rank == 0 && !failed) {
        curvopt_mesh_info info = {.n_vertices = on->whole_vertices,
                                  .n_faces = on->whole_faces,
                                  .euler = on->whole_vertices - on->whole_edges + on->whole_faces};
        json_report report = {.info = &info,
                              .energies = &p->run.summary.end,
                              .summary = &p->run.summary,
                              .levels = p->run.level,
                              .energy = p->args.energy,
                              .method = p->run.tao_type,
                              .more = more};
        json_write(out->file, &report);
        failed = staged_close(out);
        if (failed)
            staged_discard(out);
    }
    free(more);
    failed = program_follow(p, failed);
    return failed ? program_say(p, ARGUMENTS_COULD_NOT, p->args.json, strerror(failed)) : ARGUMENTS_DONE;
}

int deliver(const program *p) {
    staged cage, json;
    const curvopt_summary *s = &p->run.summary;
    int code = stage(p, p->args.output, write_cage, p->xyz, &cage);
    if (code != ARGUMENTS_DONE)
        return code;
    code = stage_json(p, &json);
    if (code == ARGUMENTS_DONE)
        code = commit(p, &cage);
    else
        staged_discard(&cage);
    if (code != ARGUMENTS_DONE) {
        staged_discard(&json);
        return code;
    }
    if (p->rank == 0 && !p->args.quiet && !(p->args.json && !strcmp(p->args.json, "-")) && strcmp(p->args.output, "-"))
        printf("%s: %.10g -> %.10g in %.2f s by TAO's %s on %d ranks, %s (by Newton's method: %s)\n", p->args.energy,
               s->start.objective, s->end.objective, s->seconds, p->run.tao_type, p->n_ranks,
               curvopt_stop_text(s->stop), curvopt_verdict_text(s->verdict));
    return commit(p, &json);
}
