/* curvopt minimize with TAO's solvers, the cage shared out over MPI's ranks.
 *
 * Every rank parses the arguments; rank 0 alone reads, prints and writes. Whatever is refused is refused by all: what
 * one rank finds wrong the others are told, and all end with the same code.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "agree.h"
#include "arguments.h"
#include "json.h"
#include "level.h"
#include "obj.h"
#include "pins.h"
#include "staged.h"
#include "write.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char help_text[] =
    "curvopt-tao - the fairest surface of a control cage, by PETSc's TAO, on many processes\n"
    "\n"
    "usage: mpirun -n RANKS curvopt-tao minimize CAGE.obj -o OUT.obj [options] [-- PETSC OPTIONS]\n"
    "       curvopt-tao --version | --help\n"
    "\n"
    "Arguments and files are those of `curvopt minimize` (see its help), but for these:\n"
    "  --method             is not for this program: the solver is TAO's, by default `-- -tao_type lmvm`; blmvm, and "
    "with\n"
    "                       the assembled Hessian nls, ntr and the like; -tao_fd_hessian or -tao_mf_hessian: by\n"
    "                       differences\n"
    "  --symmetry           none, which is the default here; --escape: not for this program\n"
    "  --blend-width        1, which is the default here\n"
    "  --pin FILE           with --levels 1, no weights\n"
    "  --threads N          for each rank, default 1\n"
    "  --verify             at the end Newton's method with a Hessian by finite differences, over everything that may\n"
    "                       move and over motion along normals (its options: -verify_tao_..., -verify_shape_tao_...)\n"
    "PETSc's options also have -curvopt_gradient FILE: the objective's gradient at the input cage, a vertex a line.\n"
    "In the JSON `tao` has what each rank did.\n"
    "An interrupt ends the run without a result.\n";

/* The whole program, on this rank. */
typedef struct program {
    MPI_Comm comm;
    PetscMPIInt rank, n_ranks;
    arguments args;
    run run;
    portion on;
    double *xyz; /* [3 n_own] */
    level_pins pins;
    double memory; /* of this rank, in bytes, at the end of the last level */
} program;

/* Said once; `code` is every rank's. */
static int say(const program *p, int code, const char *what, const char *message) {
    if (p->rank == 0)
        fprintf(stderr,
                code == ARGUMENTS_USAGE ? "curvopt-tao: %s%s (see curvopt-tao --help)\n" : "curvopt-tao: %s: %s\n",
                what, message);
    return code;
}

/* Rank 0's failure, or success, is everybody's. */
static int follow(const program *p, int code) {
    MPI_Bcast(&code, 1, MPI_INT, 0, p->comm);
    return code;
}

/* ------------------------------------------------------------------------------------------------- reading -- */

static int read_cage(const program *p, obj_cage *cage, curvopt_mesh **mesh, char *message) {
    curvopt_error error;
    *mesh = NULL;
    if (obj_read(p->args.input, cage, message, AGREE_MESSAGE))
        return ARGUMENTS_COULD_NOT;
    curvopt_creases creases = obj_creases(cage, p->args.boundary_rule);
    int32_t status = curvopt_mesh_create_creased(cage->n_vertices, cage->n_faces, cage->face_sizes, cage->face_vertices,
                                                 &creases, mesh, &error);
    if (status == CURVOPT_OK && cage->n_faces < p->n_ranks) {
        snprintf(message, AGREE_MESSAGE, "the cage has %d faces, fewer than there are ranks (%d)", cage->n_faces,
                 p->n_ranks);
        curvopt_mesh_destroy(*mesh);
    } else if (status == CURVOPT_OK) {
        return ARGUMENTS_DONE;
    } else {
        snprintf(message, AGREE_MESSAGE, "%s", error.message);
    }
    obj_free(cage);
    return ARGUMENTS_COULD_NOT;
}

/* Coordinates that the library would refuse must not come as far as any arithmetic. */
static int32_t check_positions(const program *p, const curvopt_mesh *mesh, const double *xyz, curvopt_error *error) {
    int32_t face = 0, corner = 0, surface = CURVOPT_SURFACE_LIMIT;
    double uv[2] = {0.5, 0.5}, jets[30];
    (void)p;
    return curvopt_surface_jets(mesh, xyz, surface, 0, &face, &corner, uv, jets, error);
}

static int read_and_share(program *p) {
    obj_cage cage;
    curvopt_mesh *mesh = NULL;
    curvopt_error error;
    char message[AGREE_MESSAGE];
    int code = ARGUMENTS_DONE;
    if (p->rank == 0)
        code = read_cage(p, &cage, &mesh, message);
    if (p->rank == 0 && code == ARGUMENTS_DONE && check_positions(p, mesh, cage.xyz, &error) != CURVOPT_OK) {
        snprintf(message, sizeof message, "%s", error.message);
        obj_free(&cage);
        curvopt_mesh_destroy(mesh);
        code = ARGUMENTS_COULD_NOT;
    }
    code = follow(p, code);
    if (code != ARGUMENTS_DONE)
        return say(p, code, p->args.input, message);
    portion_source source = {.mesh = mesh, .xyz = p->rank == 0 ? cage.xyz : NULL};
    PetscCallAbort(p->comm, portion_share(p->comm, &source, &p->on, &p->xyz));
    if (p->rank == 0) {
        obj_free(&cage);
        curvopt_mesh_destroy(mesh);
    }
    return ARGUMENTS_DONE;
}

/* The library's own words on why it refuses a cage, asked for when that cannot cost a run any more; or `message`. */
static void explain(const program *p, char *message) {
    obj_cage cage;
    curvopt_mesh *mesh;
    curvopt_result *result = NULL;
    curvopt_error error;
    pin_list pins = {0};
    char ignored[AGREE_MESSAGE];
    curvopt_options o = p->args.options;
    curvopt_constraints constraints;
    o.levels = 1;
    o.max_iterations = 0;
    if (!strcmp(p->args.input, "-") || read_cage(p, &cage, &mesh, ignored) != ARGUMENTS_DONE)
        return;
    if (p->args.pins && pins_read(p->args.pins, &pins, ignored, sizeof ignored) == 0) {
        constraints = (curvopt_constraints){
            .vertices = pins.vertices, .freedom = pins.freedom, .directions = pins.directions, .n = pins.n};
        o.constraints = &constraints;
    }
    if (curvopt_minimize(mesh, cage.xyz, &o, NULL, NULL, NULL, &result, &error) != CURVOPT_OK)
        snprintf(message, AGREE_MESSAGE, "%s", error.message);
    curvopt_result_destroy(result);
    curvopt_mesh_destroy(mesh);
    pins_free(&pins);
    obj_free(&cage);
}

static int refuse(const program *p, char *message) {
    if (p->rank == 0)
        explain(p, message);
    return say(p, ARGUMENTS_COULD_NOT, p->args.input, message);
}

/* ---------------------------------------------------------------------------------------------------- pins -- */

static int same_pin(const pin_list *pins, int32_t i, int32_t j) {
    return pins->freedom[i] == pins->freedom[j] &&
           (!pins->freedom[i] ||
            !memcmp(pins->directions + 3 * (size_t)i, pins->directions + 3 * (size_t)j, 3 * sizeof(double)));
}

/* Every rank has all pins for a moment; they are the user's lines. */
static void broadcast_pins(const program *p, pin_list *pins) {
    MPI_Bcast(&pins->n, 1, MPI_INT32_T, 0, p->comm);
    if (p->rank != 0) {
        pins->vertices = AGREE_NEW(p->comm, int32_t, pins->n);
        pins->freedom = AGREE_NEW(p->comm, int32_t, pins->n);
        pins->directions = AGREE_NEW(p->comm, double, 3 * (size_t)pins->n);
    }
    MPI_Bcast(pins->vertices, pins->n, MPI_INT32_T, 0, p->comm);
    MPI_Bcast(pins->freedom, pins->n, MPI_INT32_T, 0, p->comm);
    MPI_Bcast(pins->directions, 3 * pins->n, MPI_DOUBLE, 0, p->comm);
}

/* Pins of own vertices; nonzero if there is something wrong with any. */
static int take_pins(program *p, const pin_list *pins) {
    PetscInt whole = p->on.whole_vertices;
    int wrong = 0;
    int32_t *pin_of = AGREE_NEW(p->comm, int32_t, whole); /* 0: none, else its number and 1 */
    for (int32_t i = 0; i < pins->n; i++) {
        int32_t v = pins->vertices[i];
        const double *d = pins->directions + 3 * (size_t)i;
        double length = pins->freedom[i] ? sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) : 1;
        int in_range = v >= 0 && v < whole;
        wrong |= !in_range || !(length > 0) || !isfinite(length) ||
                 (in_range && pin_of[v] && !same_pin(pins, i, pin_of[v] - 1));
        if (in_range)
            pin_of[v] = i + 1;
    }
    p->pins.freedom = AGREE_NEW(p->comm, unsigned char, p->on.n_own);
    p->pins.direction = AGREE_NEW(p->comm, double, 3 * (size_t)p->on.n_own);
    for (PetscInt k = 0; k < p->on.n_own; k++) {
        int32_t pin = pin_of[p->on.vertex[p->on.own[k]]];
        p->pins.freedom[k] = pin ? (unsigned char)pins->freedom[pin - 1] : 3;
        if (pin)
            memcpy(p->pins.direction + 3 * (size_t)k, pins->directions + 3 * (size_t)(pin - 1), 3 * sizeof(double));
    }
    free(pin_of);
    return wrong;
}

/* The first vertex that is to be held by a spring, which is nothing that this program has; or -1. */
static int32_t find_spring(const pin_list *pins) {
    for (int32_t i = 0; i < pins->n; i++)
        if (pins->weights[i] != 1)
            return pins->vertices[i];
    return -1;
}

static int read_pins(program *p) {
    pin_list pins = {0};
    char message[AGREE_MESSAGE];
    int code = ARGUMENTS_DONE;
    if (!p->args.pins)
        return ARGUMENTS_DONE;
    if (p->rank == 0 && pins_read(p->args.pins, &pins, message, sizeof message))
        code = ARGUMENTS_COULD_NOT;
    int32_t spring = code == ARGUMENTS_DONE ? find_spring(&pins) : -1;
    if (spring >= 0) {
        snprintf(message, sizeof message, "vertex %d has a weight: curvopt-tao holds vertices exactly or not at all",
                 (int)spring);
        code = ARGUMENTS_COULD_NOT;
    }
    code = follow(p, code);
    if (code != ARGUMENTS_DONE) {
        pins_free(&pins);
        return say(p, code, p->args.pins, message);
    }
    broadcast_pins(p, &pins);
    int wrong = take_pins(p, &pins);
    pins_free(&pins);
    strcpy(message, "two pins on one vertex contradict, or a pin has no direction, or its vertex does not exist");
    return wrong ? refuse(p, message) : ARGUMENTS_DONE;
}

/* ------------------------------------------------------------------------------------------------- writing -- */

/* A file of rank 0 that all ranks write to; `writer` as write_cage(). */
static int stage(const program *p, const char *path,
                 PetscErrorCode (*writer)(const portion *, const double *, FILE *, int *), const double *what,
                 staged *out) {
    int failed = 0;
    *out = (staged){0};
    if (p->rank == 0)
        failed = staged_open(out, path);
    failed = follow(p, failed);
    if (failed)
        return say(p, ARGUMENTS_COULD_NOT, path, strerror(failed));
    PetscCallAbort(p->comm, writer(&p->on, what, out->file, &failed));
    if (p->rank == 0) {
        failed = staged_close(out);
        if (failed)
            staged_discard(out);
    }
    failed = follow(p, failed);
    return failed ? say(p, ARGUMENTS_COULD_NOT, path, strerror(failed)) : ARGUMENTS_DONE;
}

static int commit(const program *p, staged *out) {
    const char *path = out->path;
    int failed = p->rank == 0 && path ? staged_commit(out) : 0;
    failed = follow(p, failed);
    return failed ? say(p, ARGUMENTS_COULD_NOT, path, strerror(failed)) : ARGUMENTS_DONE;
}

/* -curvopt_gradient; a cage that is refused will be so again. */
static int write_gradient(program *p) {
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
    enum { N_FIGURES = 5, ROOM = 32 };
    static const char *const name[N_FIGURES] = {"own_vertices", "halo_vertices", "faces", "cpu_seconds_an_evaluation",
                                                "memory_bytes"};
    double own_faces = 0;
    for (PetscInt f = 0; f < p->on.n_faces; f++)
        own_faces += p->on.counts[f];
    const double mine[N_FIGURES] = {p->on.n_own, p->on.n_vertices - p->on.n_own, own_faces,
                                    p->run.cpu_seconds / p->run.evaluations, p->memory};
    double *all = AGREE_NEW(p->comm, double, N_FIGURES *(size_t)p->n_ranks);
    size_t size = 200 + N_FIGURES * ROOM * ((size_t)p->n_ranks + 1), at = 0;
    char *text = AGREE_NEW(p->comm, char, size);
    MPI_Gather(mine, N_FIGURES, MPI_DOUBLE, all, N_FIGURES, MPI_DOUBLE, 0, p->comm);
    at += (size_t)snprintf(text + at, size - at, "  \"tao\": {\"ranks\": %d, \"threads\": %d", p->n_ranks,
                           (int)p->args.options.threads);
    for (int k = 0; k < N_FIGURES; k++) {
        at += (size_t)snprintf(text + at, size - at, ", \"%s\": [", name[k]);
        for (int r = 0; r < p->n_ranks; r++)
            at += (size_t)snprintf(text + at, size - at, "%s%.6g", r ? ", " : "", all[N_FIGURES * r + k]);
        at += (size_t)snprintf(text + at, size - at, "]");
    }
    snprintf(text + at, size - at, "},\n");
    free(all);
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
    failed = follow(p, failed);
    return failed ? say(p, ARGUMENTS_COULD_NOT, p->args.json, strerror(failed)) : ARGUMENTS_DONE;
}

/* Cage and report: both are complete before either is put in its place. */
static int deliver(const program *p) {
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

/* ---------------------------------------------------------------------------------------------------- runs -- */

static PetscErrorCode refine(program *p) {
    portion fine;
    double *fine_xyz;
    PetscFunctionBeginUser;
    PetscCall(portion_refine(&p->on, p->xyz, &fine, &fine_xyz));
    PetscCall(portion_free(&p->on));
    free(p->xyz);
    p->on = fine;
    p->xyz = fine_xyz;
    PetscFunctionReturn(0);
}

static PetscErrorCode solve(program *p, int *refused) {
    run *r = &p->run;
    curvopt_summary *s = &r->summary;
    const curvopt_options *o = &p->args.options;
    PetscLogDouble memory;
    PetscFunctionBeginUser;
    *r = (run){.comm = p->comm, .options = o, .quiet = p->args.quiet, .started = level_now()};
    *s = (curvopt_summary){.newton_decrement = (double)NAN,
                           .shape_decrement = (double)NAN,
                           .difference_decrement = (double)NAN,
                           .negative_directions = -1,
                           .all_negative_directions = -1,
                           .free_negative_directions = -1,
                           .symmetry_order = 1};
    for (int number = 1; number <= o->levels && !*refused; number++) {
        if (number > 1)
            PetscCall(refine(p));
        PetscCall(level_solve(r, &p->on, &p->pins, number, p->xyz, refused));
        if (!*refused && s->stop == CURVOPT_STOP_UNRESOLVED)
            break;
    }
    PetscCall(PetscMemoryGetCurrentUsage(&memory));
    p->memory = memory;
    s->n_levels = r->n_levels;
    s->n_vertices = p->on.whole_vertices;
    s->n_faces = p->on.whole_faces;
    s->seconds = level_now() - r->started;
    PetscFunctionReturn(0);
}

/* What only `curvopt` has. */
static const char *not_for_tao(const arguments *a) {
    const curvopt_options *o = &a->options;
    if (strcmp(a->command, "minimize") != 0)
        return "there is minimize only; curvopt evaluates";
    if (o->method != CURVOPT_METHOD_AUTO)
        return "--method is not for this program: the solver is TAO's, after -- by -tao_type";
    if (o->symmetry != CURVOPT_SYMMETRY_AUTO && o->symmetry != CURVOPT_SYMMETRY_NONE)
        return "--symmetry can be none: TAO keeps no symmetries";
    if (o->escape)
        return "--escape is not for this program";
    if (a->has_blend_width && o->blend_width != 1)
        return "--blend-width can be 1: a rank does not see how far it is to the next vertex that is not regular";
    if (a->pins && o->levels != 1)
        return "--pin is for --levels 1 in this program";
    return NULL;
}

/* As the library settles it. */
static void settle_options(curvopt_options *o) {
    int third = 0;
    for (int t = CURVOPT_TERM_MVS; t <= CURVOPT_TERM_MEHLUM_TARROU; t++)
        third |= o->weights[t] > 0;
    if (o->surface == CURVOPT_SURFACE_AUTO)
        o->surface = !third ? CURVOPT_SURFACE_LIMIT : o->as_report ? CURVOPT_SURFACE_PLANE : CURVOPT_SURFACE_POLYNOMIAL;
    o->threads = o->threads ? o->threads : 1;
    o->symmetry = CURVOPT_SYMMETRY_NONE;
    o->blend_width = 1;
}

static int minimize(program *p) {
    int refused = 0, code = read_and_share(p);
    if (code == ARGUMENTS_DONE)
        code = read_pins(p);
    if (code == ARGUMENTS_DONE)
        code = write_gradient(p);
    if (code != ARGUMENTS_DONE)
        return code;
    PetscCallAbort(p->comm, solve(p, &refused));
    if (p->rank == 0 && !p->args.quiet && isatty(STDERR_FILENO))
        fprintf(stderr, "\n");
    return refused ? refuse(p, p->run.message) : deliver(p);
}

static int run_program(program *p, int argc, char **argv) {
    char message[AGREE_MESSAGE];
    if (argc < 2)
        return say(p, ARGUMENTS_USAGE, "no command", "");
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))
        return p->rank == 0 && fputs(help_text, stdout) < 0 ? ARGUMENTS_COULD_NOT : ARGUMENTS_DONE;
    if (!strcmp(argv[1], "--version")) {
        if (p->rank == 0)
            printf("curvopt-tao %s\n", curvopt_version());
        return ARGUMENTS_DONE;
    }
    int code = arguments_parse(argc, argv, &p->args, message, sizeof message);
    if (code != ARGUMENTS_DONE)
        return say(p, code, message, "");
    const char *refusal = not_for_tao(&p->args);
    if (refusal)
        return say(p, ARGUMENTS_USAGE, refusal, "");
    settle_options(&p->args.options);
    return minimize(p);
}

int main(int argc, char **argv) {
    program p = {.comm = MPI_COMM_NULL};
    int own = argc, n_petsc;
    for (int i = argc - 1; i > 0; i--) /* what stands behind the first -- is PETSc's */
        own = strcmp(argv[i], "--") ? own : i;
    n_petsc = argc - own;
    char **petsc = calloc((size_t)n_petsc + 2, sizeof *petsc);
    if (!petsc)
        return ARGUMENTS_COULD_NOT;
    petsc[0] = argv[0];
    for (int i = 1; i < n_petsc; i++)
        petsc[i] = argv[own + i];
    n_petsc = n_petsc ? n_petsc : 1;
    char **list = petsc;
    if (PetscInitialize(&n_petsc, &list, NULL, NULL))
        return ARGUMENTS_COULD_NOT;
    p.comm = PETSC_COMM_WORLD;
    MPI_Comm_rank(p.comm, &p.rank);
    MPI_Comm_size(p.comm, &p.n_ranks);
    int code = run_program(&p, own, argv);
    if (fflush(stdout) != 0 || ferror(stdout))
        code = code == ARGUMENTS_DONE ? ARGUMENTS_COULD_NOT : code;
    code = follow(&p, code);
    PetscCallAbort(p.comm, portion_free(&p.on));
    free(p.xyz);
    free(p.pins.freedom);
    free(p.pins.direction);
    free(petsc);
    PetscCallAbort(PETSC_COMM_WORLD, PetscFinalize());
    return code;
}
