/* The command line. SPDX-License-Identifier: GPL-3.0-or-later */
#include "curvopt.h"

#include "arguments.h"
#include "atomic_file.h"
#include "held.h"
#include "help.h"
#include "measures.h"
#include "obj_cage.h"
#include "pins.h"
#include "platform.h"
#include "report_json.h"
#include "through.h"
#include "trace.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

static int usage_error(const char *message) {
    fprintf(stderr, "curvopt: %s (see curvopt --help)\n", message);
    return ARGUMENTS_USAGE;
}

static int could_not(const char *path, const char *message) {
    fprintf(stderr, "curvopt: %s: %s\n", path, message);
    return ARGUMENTS_COULD_NOT;
}

/* ----------------------------------------------------------------------------------------------- reporting -- */

static int is_standard_output(const char *path) {
    return path && !strcmp(path, "-");
}

/* One file staged by its writer; none if `path` is NULL. */
static int stage(const char *path, void (*write)(FILE *, const void *), const void *what, staged *out) {
    *out = (staged){0};
    if (!path)
        return ARGUMENTS_DONE;
    int failed = staged_open(out, path);
    if (!failed) {
        write(out->file, what);
        failed = staged_close(out);
        if (failed)
            staged_discard(out);
    }
    return failed ? could_not(path, strerror(failed)) : ARGUMENTS_DONE;
}

static void write_json(FILE *file, const void *report) {
    json_write(file, report);
}

static void write_cage(FILE *file, const void *cage) {
    obj_write(file, cage);
}

static void write_trace(FILE *file, const void *rows) {
    trace_write(file, rows);
}

static int commit(staged *out) {
    int failed = out->path ? staged_commit(out) : 0;
    return failed ? could_not(out->path, strerror(failed)) : ARGUMENTS_DONE;
}

static void print_number(const char *name, double value, double error) {
    if (!isfinite(value))
        printf("%-22s -\n", name);
    else if (error > 0)
        printf("%-22s %.10g  (quadrature error %.1e)\n", name, value, error);
    else
        printf("%-22s %.10g\n", name, value);
}

static void print_energies(const curvopt_mesh_info *info, const curvopt_energies *e, double spontaneous_curvature) {
    printf("%-22s %d vertices, %d faces, Euler characteristic %d\n", "cage", info->n_vertices, info->n_faces,
           info->euler);
    printf("%-22s %s\n", "surface", curvopt_surface_name(e->surface));
    print_number("area", e->area, e->area_error);
    print_number("volume", e->volume, 0);
    for (int t = 0; t < CURVOPT_TERM_AREA; t++)
        print_number(curvopt_term_name(t), e->term[t], e->term_error[t]);
    print_number("integral of H", e->total_mean_curvature, 0);
    print_number("integral of H^2", e->h2, 0);
    if (spontaneous_curvature != 0)
        print_number("Helfrich's energy", e->helfrich, 0);
    print_number("integral of K", e->gauss, 0);
    print_number("Gauss-Bonnet defect", e->gauss_bonnet_defect, 0);
}

/* What a touch does, where the result is not one that bears it. */
static void print_delicacy(const json_report *r) {
    const double rise = r->summary->touch_rise / fabs(r->energies->objective + r->summary->spring_energy);
    if (!r->summary->is_delicate)
        return;
    printf("; delicate: with its vertices moved by a thousandth of an edge it rises ");
    printf(rise < 1 ? "by %.2g %%" : "to %.2g times as much", rise < 1 ? 100 * rise : 1 + rise);
    printf(", and minimized again from there it may end elsewhere");
}

/* A verdict looks at shapes that keep the symmetries; --verify at all shapes, if they are few enough to count. */
static void print_verdict(const curvopt_summary *s, int was_verified) {
    int leads_down = s->free_negative_directions;
    printf("by its Hessian: %s", curvopt_verdict_text(s->verdict));
    if (s->symmetry_order == 1 || s->verdict != CURVOPT_VERDICT_MINIMUM)
        return;
    if (leads_down == 0) {
        printf(", also without its %d symmetries", s->symmetry_order);
        return;
    }
    printf(" among shapes with its %d symmetries", s->symmetry_order);
    if (leads_down > 0)
        printf("; %d direction%s without them lead%s down", leads_down, leads_down == 1 ? "" : "s",
               leads_down == 1 ? "s" : "");
    else
        printf(was_verified ? "; others are not known" : "; --verify looks at all");
}

/* Times the area of the input, from which on an open surface with a free boundary is said to have grown. */
static const double GROWN = 10;

static void print_growth(const json_report *r, int32_t boundary) {
    const double times = r->energies->area / r->start->area;
    if (boundary == CURVOPT_BOUNDARY_FREE && r->info->n_boundary_edges > 0 && times > GROWN)
        printf("%-22s %.3g times the area: with a free boundary bending falls as it grows; hold the boundary, or more "
               "vertices\n",
               "grown", times);
}

/* Relative distance from a number that is held up to which it is kept, as the verdict has it. */
static const double KEPT = 1e-8;

/* The numbers of the whole surface that are not what they were to be. */
static void print_missed(const curvopt_summary *s) {
    for (int k = 0; k < CURVOPT_N_SCALARS; k++)
        if (fabs(s->scalar_residual[k]) > KEPT)
            printf(
                "%-22s %s is %.2g %% %s than it was to be: with all else that is asked for, the run came no nearer\n",
                "not kept", curvopt_scalar_name(k), 100 * fabs(s->scalar_residual[k]),
                s->scalar_residual[k] < 0 ? "less" : "more");
}

/* Says to people, not to programs, what the run did. */
static void print_run(const json_report *r, const curvopt_options *options) {
    const curvopt_summary *s = r->summary;
    if (isnan(r->start->objective)) {
        printf("%s: cancelled before the energies of the input were known; the output is the input\n", r->energy);
        return;
    }
    printf("%s: %.10g -> %.10g in %.2f s, %s (", r->energy, r->start->objective, r->energies->objective, s->seconds,
           curvopt_stop_text(s->stop));
    print_verdict(s, options->verify);
    print_delicacy(r);
    printf("%s)\n", s->n_touching ? "; held by contact" : "");
    if (s->n_sliding)
        printf(
            "%d vertices could slide along their curves, which are %.2g off between vertices, in units of the cage\n",
            s->n_sliding, s->curve_deviation);
    if (s->n_refused && (s->stop == CURVOPT_STOP_UNRESOLVED || s->stop == CURVOPT_STOP_STALLED))
        printf("%d step%s would have led through the surface: where neighbours fold, or boundaries meet, nothing "
               "repels them, "
               "and a run may end\n",
               s->n_refused, s->n_refused == 1 ? "" : "s");
    if (s->spring_energy > 0)
        printf("%-22s %.5g  (what springs add to the objective; in no energy)\n", "springs", s->spring_energy);
    const double error = r->energies->objective_error;
    if (s->stop != CURVOPT_STOP_CANCELLED && error > options->tolerance * fabs(r->energies->objective))
        printf("%-22s %.2g  (more than the %.2g that was wanted)\n", "quadrature error", error,
               options->tolerance * fabs(r->energies->objective));
    if (isfinite(s->discretization_error))
        printf("%-22s %.2g  (estimated: what finer nets would still take away)\n", "discretization error",
               s->discretization_error);
    print_missed(s);
    print_growth(r, options->boundary);
}

/* ------------------------------------------------------------------------------------------------ commands -- */

/* The cage, and what of it will be held; its holes become an option. */
typedef struct input {
    obj_cage cage;
    curvopt_mesh *mesh;
    held_list held;
} input;

static void unload(input *in) {
    held_free(&in->held);
    curvopt_mesh_destroy(in->mesh);
    obj_free(&in->cage);
}

static int load(arguments *a, input *in) {
    char message[256];
    curvopt_error error;
    *in = (input){.mesh = NULL};
    if (obj_read(a->input, &in->cage, message, sizeof message))
        return could_not(a->input, message);
    curvopt_creases creases = obj_creases(&in->cage, a->boundary_rule);
    int32_t status = curvopt_mesh_create_creased(in->cage.n_vertices, in->cage.n_faces, in->cage.face_sizes,
                                                 in->cage.face_vertices, &creases, &in->mesh, &error);
    a->options.holes = in->cage.holes;
    a->options.n_holes = in->cage.n_holes;
    if (status == CURVOPT_OK)
        status = held_find(in->mesh, in->cage.xyz, &a->options, &in->held, &error);
    in->held.passed_over = in->cage.passed_over;
    if (status == CURVOPT_OK)
        return ARGUMENTS_DONE;
    unload(in);
    return could_not(a->input, error.message);
}

/* The flag of the run or evaluation, NULL unless there is one. */
static curvopt_cancel *volatile running;
static volatile sig_atomic_t was_interrupted;

static void on_interrupt(int number) {
    was_interrupted = 1;
    if (running)
        curvopt_cancel_request(running); /* NOLINT(bugprone-signal-handler): one lock-free store */
    signal(number, SIG_DFL);
}

/* From here on an interrupt raises the flag *cancel; 0, or an exit code. */
static int hear_interrupts(const char *path, curvopt_cancel **cancel) {
    curvopt_error error;
    if (curvopt_cancel_create(cancel, &error) != CURVOPT_OK)
        return could_not(path, error.message);
    running = *cancel;
    signal(SIGINT, on_interrupt);
    return ARGUMENTS_DONE;
}

static void stop_hearing(curvopt_cancel *cancel) {
    running = NULL;
    curvopt_cancel_destroy(cancel);
}

/* Measures a cage, and how far it is from the one that --deviation-from names. */
static int measure(const arguments *a, const input *in, const curvopt_cancel *cancel, measures *out) {
    input from = {.mesh = NULL};
    arguments other = *a;
    curvopt_error error;
    int result = ARGUMENTS_DONE;
    *out = (measures){.pairs = NULL};
    if (a->deviation_from) {
        other.input = a->deviation_from;
        result = load(&other, &from);
    }
    if (result == ARGUMENTS_DONE && measures_take(in->mesh, in->cage.xyz, in->mesh, from.mesh, from.cage.xyz,
                                                  a->options.threads, cancel, out, &error) != CURVOPT_OK)
        result = could_not(a->deviation_from ? a->deviation_from : a->input, error.message);
    if (result == ARGUMENTS_DONE &&
        measures_take_folds(in->mesh, in->cage.xyz, &a->options, cancel, out, &error) != CURVOPT_OK)
        result = could_not(a->input, error.message);
    if (result == ARGUMENTS_DONE && was_interrupted) {
        measures_free(out);
        result = could_not(a->input, curvopt_status_text(CURVOPT_ERROR_CANCELLED));
    }
    if (from.mesh)
        unload(&from);
    return result;
}

/* Whether the program tells of what it found: no file goes where it would. */
static int tells(const arguments *a) {
    return !a->quiet && !is_standard_output(a->json) && !is_standard_output(a->output) && !is_standard_output(a->trace);
}

/* Writes and prints what is known of a cage. */
static int report_cage(const arguments *a, const input *in, const curvopt_energies *energies,
                       const curvopt_cancel *cancel) {
    curvopt_mesh_info info;
    measures measured;
    staged json;
    int result = measure(a, in, cancel, &measured);
    if (result != ARGUMENTS_DONE)
        return result;
    curvopt_mesh_get_info(in->mesh, &info, sizeof info);
    if (tells(a)) {
        print_energies(&info, energies, a->options.spontaneous_curvature);
        measures_print(stdout, &measured, 1);
        held_print(stdout, &in->held);
    }
    json_report report = {.info = &info,
                          .energies = energies,
                          .energy = a->energy,
                          .spontaneous_curvature = a->options.spontaneous_curvature,
                          .held = &in->held,
                          .measures = &measured};
    result = stage(a->json, write_json, &report, &json);
    if (result == ARGUMENTS_DONE)
        result = commit(&json);
    measures_free(&measured);
    return result;
}

static int run_evaluate(arguments *a) {
    input in;
    curvopt_problem *problem = NULL;
    curvopt_cancel *cancel = NULL;
    curvopt_energies energies;
    curvopt_error error;
    int result = load(a, &in);
    if (result != ARGUMENTS_DONE)
        return result;
    result = hear_interrupts(a->input, &cancel);
    if (result == ARGUMENTS_DONE &&
        (curvopt_problem_create_interruptible(in.mesh, in.cage.xyz, &a->options, NULL, NULL, cancel, &problem,
                                              &error) != CURVOPT_OK ||
         curvopt_problem_evaluate_interruptible(problem, in.cage.xyz, NULL, NULL, cancel, &energies, sizeof energies,
                                                NULL, &error) != CURVOPT_OK))
        result = could_not(a->input, error.message);
    if (result == ARGUMENTS_DONE)
        result = report_cage(a, &in, &energies, cancel);
    curvopt_problem_destroy(problem);
    stop_hearing(cancel);
    unload(&in);
    return result;
}

/* A run that is on, as its callback sees it. */
typedef struct watch {
    const arguments *args;
    trace trace;
} watch;

static int32_t on_progress(const curvopt_progress *p, void *user) {
    watch *w = user;
    const arguments *a = w->args;
    if (a->trace)
        trace_add(&w->trace, p);
    if (!a->quiet && platform_is_watched())
        fprintf(stderr, "\rlevel %d/%d  iteration %5d  energy %.8g  |g| %.1e  %.1f s   ", p->level, p->levels,
                p->iteration, p->energy, p->gradient_norm, p->seconds);
    return 0;
}

/* The faces of the result that come from the input's holes: face h of a subdivided cage is the child at corner h.
 * levels: number of subdivisions. Memory is out where there are holes and *holes is NULL. */
static int32_t subdivide_holes(const obj_cage *from, int levels, int32_t **holes) {
    int32_t n_children = 1, n = 0;
    for (int level = 1; level < levels; level++)
        n_children *= 4;
    int32_t *start = calloc((size_t)from->n_faces + 1, sizeof *start);
    size_t room = 0;
    for (int32_t f = 0; start && f < from->n_faces; f++)
        start[f + 1] = start[f] + from->face_sizes[f];
    for (int32_t i = 0; start && i < from->n_holes; i++)
        room += (size_t)from->face_sizes[from->holes[i]] * (size_t)n_children;
    *holes = start ? malloc(sizeof **holes * (room + 1)) : NULL;
    for (int32_t i = 0; *holes && i < from->n_holes; i++) {
        int32_t f = from->holes[i], first = levels ? start[f] * n_children : f;
        int32_t end = levels ? start[f + 1] * n_children : f + 1;
        for (int32_t child = first; child < end; child++)
            (*holes)[n++] = child;
    }
    free(start);
    return n;
}

/* The result as a cage; 0 if memory is out. Lines are the input's: its vertices keep their numbers. */
static int take_result(const curvopt_result *result, const curvopt_mesh_info *info, const obj_cage *from, int levels,
                       obj_cage *cage) {
    const curvopt_mesh *mesh = curvopt_result_mesh(result);
    *cage = (obj_cage){.n_vertices = info->n_vertices, .n_faces = info->n_faces};
    cage->n_holes = subdivide_holes(from, levels, &cage->holes);
    curvopt_mesh_count_creases(mesh, &cage->n_creases, &cage->n_corners);
    cage->xyz = malloc(sizeof(double) * 3 * (size_t)info->n_vertices);
    cage->face_sizes = malloc(sizeof(int32_t) * (size_t)info->n_faces);
    cage->face_vertices = malloc(sizeof(int32_t) * (size_t)info->n_corners);
    cage->crease_vertices = malloc(sizeof(int32_t) * (2 * (size_t)cage->n_creases + 1));
    cage->crease_sharpness = malloc(sizeof(double) * ((size_t)cage->n_creases + 1));
    cage->corner_vertices = malloc(sizeof(int32_t) * ((size_t)cage->n_corners + 1));
    cage->corner_sharpness = malloc(sizeof(double) * ((size_t)cage->n_corners + 1));
    if (!cage->xyz || !cage->holes || !cage->face_sizes || !cage->face_vertices || !cage->crease_vertices ||
        !cage->crease_sharpness || !cage->corner_vertices || !cage->corner_sharpness) {
        obj_free(cage);
        return 0;
    }
    curvopt_result_get_positions(result, cage->xyz);
    curvopt_mesh_get_faces(mesh, cage->face_sizes, cage->face_vertices);
    curvopt_mesh_get_creases(mesh, cage->crease_vertices, cage->crease_sharpness, cage->corner_vertices,
                             cage->corner_sharpness);
    cage->n_lines = from->n_lines;
    cage->line_sizes = from->line_sizes;
    cage->line_ends = from->line_ends;
    return 1;
}

static void free_result(obj_cage *cage) {
    cage->line_sizes = cage->line_ends = NULL; /* the input's */
    obj_free(cage);
}

/* Cage, report and trace: all are complete before any is put in its place. */
static int deliver_files(const arguments *a, const obj_cage *cage, const json_report *report, const trace *rows) {
    staged out[3] = {{0}};
    int status = stage(a->output, write_cage, cage, &out[0]);
    if (status == ARGUMENTS_DONE)
        status = stage(a->json, write_json, report, &out[1]);
    if (status == ARGUMENTS_DONE)
        status = rows->failed ? could_not(a->trace, strerror(ENOMEM)) : stage(a->trace, write_trace, rows, &out[2]);
    for (int i = 0; i < 3; i++) {
        if (status == ARGUMENTS_DONE)
            status = commit(&out[i]);
        else
            staged_discard(&out[i]);
    }
    return status;
}

/* What is measured of a result, and of the cage that it was made of. */
static int32_t measure_result(const arguments *a, const input *in, const curvopt_result *result, const double *xyz,
                              const curvopt_cancel *cancel, measures *out, curvopt_error *error) {
    curvopt_summary summary;
    curvopt_result_get_summary(result, &summary, sizeof summary);
    int32_t status = measures_take(curvopt_result_mesh(result), xyz, in->mesh, in->mesh, in->cage.xyz,
                                   a->options.threads, cancel, out, error);
    if (status == CURVOPT_OK && a->options.no_crossings)
        status = measures_take_touching(result, in->mesh, in->cage.xyz, a->options.threads, cancel, out, error);
    if (status == CURVOPT_OK && summary.n_folded)
        status = measures_take_folds(in->mesh, in->cage.xyz, &a->options, NULL, out, error);
    out->n_unfolded = summary.n_unfolded;
    out->has_folds = 1;
    return status;
}

/* Writes and prints a result. What nobody reads is not measured: it may take as long as the run. */
static int deliver(const watch *w, const input *in, const curvopt_result *result, const curvopt_cancel *cancel) {
    const arguments *a = w->args;
    obj_cage cage;
    curvopt_mesh_info info;
    curvopt_summary summary;
    curvopt_energies start, end;
    curvopt_error error;
    measures measured = {.pairs = NULL};
    curvopt_level_report levels[CURVOPT_MAX_LEVELS];
    curvopt_mesh_get_info(curvopt_result_mesh(result), &info, sizeof info);
    curvopt_result_get_summary(result, &summary, sizeof summary);
    curvopt_result_get_energies(result, &start, &end, sizeof end);
    for (int32_t i = 0; i < summary.n_levels; i++)
        curvopt_result_get_level(result, i, &levels[i], sizeof levels[i], NULL);
    json_report report = {.info = &info,
                          .energies = &end,
                          .start = &start,
                          .summary = &summary,
                          .levels = levels,
                          .energy = a->energy,
                          .spontaneous_curvature = a->options.spontaneous_curvature,
                          .held = &in->held,
                          .measures = &measured,
                          .method = curvopt_method_name(summary.method)};
    if (!take_result(result, &info, &in->cage, summary.n_levels - 1, &cage))
        return could_not(a->output, strerror(ENOMEM));
    if ((tells(a) || a->json) && measure_result(a, in, result, cage.xyz, cancel, &measured, &error) != CURVOPT_OK) {
        free_result(&cage);
        return could_not(a->input, error.message);
    }
    int status = deliver_files(a, &cage, &report, &w->trace);
    free_result(&cage);
    if (status == ARGUMENTS_DONE && tells(a)) {
        print_run(&report, &a->options);
        if (was_interrupted && report.summary->stop != CURVOPT_STOP_CANCELLED)
            printf("%-22s after the last step: of what is found out then, some is not known\n", "interrupted");
        measures_print(stdout, &measured, 0);
        held_print(stdout, &in->held);
    }
    measures_free(&measured);
    return status;
}

/* What is held, from files into the options. */
static int load_held(arguments *a, pin_list *pins, through_list *through) {
    char message[256];
    *pins = (pin_list){0};
    *through = (through_list){0};
    if (a->pins && pins_read(a->pins, pins, message, sizeof message))
        return could_not(a->pins, message);
    if (a->through && through_read(a->through, through, message, sizeof message))
        return could_not(a->through, message);
    a->constraints = pins_as_constraints(pins);
    a->options.constraints = a->pins ? &a->constraints : NULL;
    a->points = through->given;
    a->options.through = a->through ? &a->points : NULL;
    return ARGUMENTS_DONE;
}

static int begins_with(const char *text, const char *begin) {
    return !strncmp(text, begin, strlen(begin));
}

/* Says an error with the file that it is of. The library's sentences about what the surface goes through begin with an
 * entry of its file, or with these words; those about pins with theirs. */
static int blame(const arguments *a, const pin_list *pins, const curvopt_error *error) {
    static const char *const begins[] = {"entry ", "chain ", "what the surface goes through "};
    const char *text = error->message;
    char message[sizeof error->message + 32];
    for (size_t k = 0; a->through && k < sizeof begins / sizeof *begins; k++)
        if (begins_with(text, begins[k]))
            return could_not(a->through, text);
    const int is_of_pin = begins_with(text, "constraint ") || strstr(text, " has two constraints ");
    if (!is_of_pin || error->element < 0 || error->element >= pins->n)
        return could_not(a->input, text);
    snprintf(message, sizeof message, "line %d: %s", (int)pins->lines[error->element], text);
    return could_not(a->pins, message);
}

/* Says why there is no result; where nothing may move, how many levels it takes until something may. */
static int refused(const arguments *a, const input *in, const pin_list *pins, const curvopt_error *error) {
    enum { MORE = 3 }; /* levels beyond those of the run that are looked at */
    char message[sizeof error->message + 64];
    curvopt_options o = a->options;
    curvopt_error none;
    int32_t level = 0;
    o.levels = o.levels < CURVOPT_MAX_LEVELS - MORE ? o.levels + MORE : CURVOPT_MAX_LEVELS;
    if (error->code != CURVOPT_ERROR_ARGUMENT || !begins_with(error->message, "nothing may move") ||
        curvopt_find_moving_level(in->mesh, in->cage.xyz, &o, &level, &none) != CURVOPT_OK ||
        level <= a->options.levels)
        return blame(a, pins, error);
    snprintf(message, sizeof message, "%s: from --levels %d on some may", error->message, level);
    return could_not(a->input, message);
}

static int run_minimize(arguments *a) {
    input in;
    curvopt_result *result = NULL;
    curvopt_error error;
    pin_list pins;
    through_list through;
    watch w = {.args = a};
    int status = load_held(a, &pins, &through);
    if (status == ARGUMENTS_DONE)
        status = load(a, &in);
    if (status != ARGUMENTS_DONE) {
        pins_free(&pins);
        through_free(&through);
        return status;
    }
    curvopt_cancel *cancel = NULL;
    status = hear_interrupts(a->input, &cancel);
    if (status == ARGUMENTS_DONE &&
        curvopt_minimize(in.mesh, in.cage.xyz, &a->options, on_progress, &w, cancel, &result, &error) != CURVOPT_OK)
        status = refused(a, &in, &pins, &error);
    if (!a->quiet && platform_is_watched())
        fprintf(stderr, "\n");
    if (status == ARGUMENTS_DONE)
        status = deliver(&w, &in, result, cancel);
    stop_hearing(cancel);
    trace_free(&w.trace);
    curvopt_result_destroy(result);
    unload(&in);
    pins_free(&pins);
    through_free(&through);
    return status;
}

static int wants_help(const char *argument) {
    return !strcmp(argument, "--help") || !strcmp(argument, "-h");
}

static int run(int argc, char **argv) {
    arguments a;
    char message[512];
    if (argc < 2)
        return usage_error("no command");
    if (wants_help(argv[1]) || (argc > 2 && wants_help(argv[2])))
        return help_print() < 0 ? ARGUMENTS_COULD_NOT : ARGUMENTS_DONE;
    if (!strcmp(argv[1], "--version")) {
        printf("curvopt %s\n", curvopt_version());
        return ARGUMENTS_DONE;
    }
    int status = arguments_parse(argc, argv, &a, message, sizeof message);
    if (status != ARGUMENTS_DONE) {
        usage_error(message);
        return status;
    }
    return strcmp(a.command, "minimize") ? run_evaluate(&a) : run_minimize(&a);
}

int main(int argc, char **argv) {
    if (platform_start(&argc, &argv) != 0)
        return could_not("arguments", strerror(ENOMEM));
    int status = run(argc, argv);
    if (fflush(stdout) != 0 || ferror(stdout)) /* figures that nobody got are not done */
        return status == ARGUMENTS_DONE ? could_not("standard output", strerror(errno)) : status;
    return status;
}
