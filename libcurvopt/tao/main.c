/* curvopt minimize with TAO's solvers, the cage distributed over MPI's ranks.
 *
 * Frozen: it is kept building and tested, as a second opinion on the library's own solver, and gets no new features. It
 * reads cages on rank 0, keeps no symmetries and has no wide blends
 * (libcurvopt/notes/92-curvopt-tao-and-wide-blends.md). It uses the public interface and the table of constants
 * (base/tuning.h), nothing else of the library.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "main.h"
#include "collective.h"

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
    "  --symmetry           none, which is the default here; --escape, --slide, --trace, --strength, --within,\n"
    "                       --no-crossings, --through,\n"
    "                       --volume, --area, --total-mean-curvature, --reduced-volume, --spontaneous-curvature: not\n"
    "                       for this program\n"
    "  --strict             always on: nothing is held as an exception here\n"
    "  --blend-width        1, which is the default here\n"
    "  --pin FILE           with --levels 1, no weights\n"
    "  --threads N          for each rank, default 1\n"
    "  --verify             at the end what is left to gain, with a Hessian by finite differences, over everything "
    "that\n"
    "                       may move and over motion along normals (linear solver: -verify_decrement_ksp_...,\n"
    "                       -verify_shape_decrement_ksp_...), and what Newton's method gains from there\n"
    "                       (-verify_tao_..., -verify_shape_tao_...; newton_gain and shape_gain of `tao` in the JSON)\n"
    "PETSc's options also have -curvopt_gradient FILE: the objective's gradient at the input cage, a vertex a line.\n"
    "In the JSON `tao` has what each rank did.\n"
    "An interrupt ends the run without a result.\n";

int program_say(const program *p, int code, const char *what, const char *message) {
    if (p->rank == 0)
        fprintf(stderr,
                code == ARGUMENTS_USAGE ? "curvopt-tao: %s%s (see curvopt-tao --help)\n" : "curvopt-tao: %s: %s\n",
                what, message);
    return code;
}

int program_follow(const program *p, int code) {
    MPI_Bcast(&code, 1, MPI_INT, 0, p->comm);
    return code;
}

static PetscErrorCode refine(program *p) {
    subdomain fine;
    double *fine_xyz;
    PetscFunctionBeginUser;
    PetscCall(subdomain_subdivide(&p->on, p->xyz, &fine, &fine_xyz));
    PetscCall(subdomain_free(&p->on));
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
                           .touch_rise = (double)NAN,
                           .shape_decrement = (double)NAN,
                           .difference_decrement = (double)NAN,
                           .discretization_error = (double)NAN,
                           .clearance = (double)NAN,
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
    if (o->slide)
        return "--slide is not for this program";
    if (o->spontaneous_curvature != 0)
        return "--spontaneous-curvature is not for this program: a rank does not know the numbers of the whole surface";
    for (int i = 0; i < CURVOPT_N_SCALARS; i++)
        if (o->scalar_rule[i] != CURVOPT_SCALAR_RULE_FREE)
            return "--volume, --area, --total-mean-curvature and --reduced-volume are not for this program: a rank "
                   "does "
                   "not know the numbers of the whole surface";
    if (o->no_crossings)
        return "--no-crossings is not for this program";
    if (o->strength < 1 || o->within > 0)
        return "--strength and --within are not for this program";
    if (a->through)
        return "--through is not for this program";
    if (a->trace)
        return "--trace is not for this program: TAO has monitors, -tao_monitor";
    if (a->has_blend_width && o->blend_width != 1)
        return "--blend-width can be 1: a rank does not see how far it is to the next vertex that is not regular";
    if (a->pins && o->levels != 1)
        return "--pin is for --levels 1 in this program";
    return NULL;
}

/* Options that are AUTO, as the library resolves them. */
static void resolve_options(curvopt_options *o) {
    int third = objective_has_third_order(o);
    if (o->surface == CURVOPT_SURFACE_AUTO)
        o->surface = !third            ? CURVOPT_SURFACE_LIMIT
                     : o->joshi_sequin ? CURVOPT_SURFACE_PLANE
                                       : CURVOPT_SURFACE_POLYNOMIAL;
    o->threads = o->threads ? o->threads : 1;
    o->symmetry = CURVOPT_SYMMETRY_NONE;
    o->strict = 1;
    o->blend_width = 1;
}

static int minimize(program *p) {
    int refused = 0, code = input_cage(p);
    if (code == ARGUMENTS_DONE)
        code = input_pins(p);
    if (code == ARGUMENTS_DONE)
        code = report_gradient(p);
    if (code != ARGUMENTS_DONE)
        return code;
    PetscCallAbort(p->comm, solve(p, &refused));
    if (p->rank == 0 && !p->args.quiet && isatty(STDERR_FILENO))
        fprintf(stderr, "\n");
    return refused ? input_refuse(p, p->run.message) : report_result(p);
}

static int run_program(program *p, int argc, char **argv) {
    char message[COLLECTIVE_MESSAGE];
    if (argc < 2)
        return program_say(p, ARGUMENTS_USAGE, "no command", "");
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h"))
        return p->rank == 0 && fputs(help_text, stdout) < 0 ? ARGUMENTS_COULD_NOT : ARGUMENTS_DONE;
    if (!strcmp(argv[1], "--version")) {
        if (p->rank == 0)
            printf("curvopt-tao %s\n", curvopt_version());
        return ARGUMENTS_DONE;
    }
    int code = arguments_parse(argc, argv, &p->args, message, sizeof message);
    if (code != ARGUMENTS_DONE)
        return program_say(p, code, message, "");
    const char *refusal = not_for_tao(&p->args);
    if (refusal)
        return program_say(p, ARGUMENTS_USAGE, refusal, "");
    resolve_options(&p->args.options);
    return minimize(p);
}

int main(int argc, char **argv) {
    program p = {.comm = MPI_COMM_NULL};
    int own = argc, n_petsc;
    for (int i = argc - 1; i > 0; i--) /* what stands behind the first -- is PETSc's */
        own = strcmp(argv[i], "--") ? own : i;
    n_petsc = argc - own;
    char **petsc = calloc((size_t)n_petsc + 2, sizeof *petsc);
    if (!petsc) {
        fputs("curvopt-tao: out of memory\n", stderr);
        return ARGUMENTS_COULD_NOT;
    }
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
    code = program_follow(&p, code);
    PetscCallAbort(p.comm, subdomain_free(&p.on));
    free(p.xyz);
    free(p.pins.freedom);
    free(p.pins.direction);
    free(petsc);
    PetscCallAbort(PETSC_COMM_WORLD, PetscFinalize());
    return code;
}
