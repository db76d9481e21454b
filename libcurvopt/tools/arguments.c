/* The command line's arguments. SPDX-License-Identifier: GPL-3.0-or-later */
#include "arguments.h"

#include "option_values.h"

#include <stdio.h>
#include <string.h>

static int complain(char *message, size_t size, const char *what, const char *which) {
    snprintf(message, size, "%s%s%s", what, which ? " " : "", which ? which : "");
    return ARGUMENTS_USAGE;
}

/* A number of the whole surface that is held; 0 if understood, or if it is none. */
static int parse_held(arguments *a, const char *name, const char *value) {
    curvopt_options *o = &a->options;
    if (!strcmp(name, "--volume")) {
        a->has_volume = 1;
        return parse_scalar(value, CURVOPT_SCALAR_VOLUME, o);
    }
    if (!strcmp(name, "--area"))
        return parse_scalar(value, CURVOPT_SCALAR_AREA, o);
    if (!strcmp(name, "--total-mean-curvature"))
        return parse_scalar(value, CURVOPT_SCALAR_MEAN_CURVATURE, o);
    if (!strcmp(name, "--reduced-volume")) {
        a->has_reduced_volume = 1;
        o->scalar_rule[CURVOPT_SCALAR_VOLUME] = CURVOPT_SCALAR_RULE_REDUCED;
        return parse_real(value, &o->scalar_value[CURVOPT_SCALAR_VOLUME]);
    }
    return 0;
}

/* An option with a value; 0 if understood. */
static int parse_valued(arguments *a, const char *name, const char *value) {
    curvopt_options *o = &a->options;
    if (!strcmp(name, "--json"))
        a->json = value;
    else if (!strcmp(name, "--energy"))
        return parse_energy(a->energy = value, o->weights);
    else if (!strcmp(name, "--surface")) {
        o->surface = curvopt_surface_from_name(value);
        return o->surface < 0;
    } else if (!strcmp(name, "--boundary-rule")) {
        a->boundary_rule = curvopt_boundary_rule_from_name(value);
        return a->boundary_rule < 0;
    } else if (!strcmp(name, "--boundary")) {
        o->boundary = curvopt_boundary_from_name(value);
        return o->boundary < 0;
    } else if (!strcmp(name, "--tolerance"))
        return parse_real(value, &o->tolerance);
    else if (!strcmp(name, "--decrement-tolerance"))
        return parse_real(value, &o->decrement_tolerance);
    else if (!strcmp(name, "--spontaneous-curvature"))
        return parse_real(value, &o->spontaneous_curvature);
    else if (!strcmp(name, "--threads"))
        return parse_integer(value, &o->threads);
    else if (!strcmp(name, "--blend-width")) {
        a->has_blend_width = 1;
        return parse_integer(value, &o->blend_width);
    } else if (!strcmp(name, "-o") || !strcmp(name, "--output"))
        a->output = value;
    else if (!strcmp(name, "--levels"))
        return parse_integer(value, &o->levels);
    else if (!strcmp(name, "--max-iterations"))
        return parse_integer(value, &o->max_iterations);
    else if (!strcmp(name, "--deviation-from"))
        a->deviation_from = value;
    else if (!strcmp(name, "--pin"))
        a->pins = value;
    else if (!strcmp(name, "--through"))
        a->through = value;
    else if (!strcmp(name, "--trace"))
        a->trace = value;
    else if (!strcmp(name, "--symmetry"))
        return parse_symmetry(value, o);
    else if (!strcmp(name, "--method")) {
        o->method = curvopt_method_from_name(value);
        return o->method < 0;
    } else if (!strcmp(name, "--spacing")) {
        o->spacing = curvopt_spacing_from_name(value);
        return o->spacing < 0;
    } else if (!strcmp(name, "--strength"))
        return parse_real(value, &o->strength);
    else if (!strcmp(name, "--within"))
        return parse_real(value, &o->within);
    else
        return parse_held(a, name, value);
    return 0;
}

/* The names of an option's values in the order of their numbers, NULL behind the last one. */
static const char *name_of_energy(int32_t i) {
    return i == CURVOPT_N_TERMS ? "mixes such as mvs:1,willmore:0.1" : curvopt_term_name(i);
}

static const char *name_of_symmetry(int32_t i) {
    return i == CURVOPT_SYMMETRY_PLANES ? "mirror planes such as x or y,z" : curvopt_symmetry_name(i);
}

typedef struct known_option {
    const char *name;
    int has_value, commands;
    const char *(*value_name)(int32_t); /* NULL where values have no names */
} known_option;

enum { EVALUATE = 1, MINIMIZE = 2, BOTH = EVALUATE | MINIMIZE };

static const known_option KNOWN[] = {{"--json", 1, BOTH, NULL},
                                     {"--energy", 1, BOTH, name_of_energy},
                                     {"--surface", 1, BOTH, curvopt_surface_name},
                                     {"--tolerance", 1, BOTH, NULL},
                                     {"--threads", 1, BOTH, NULL},
                                     {"--boundary-rule", 1, BOTH, curvopt_boundary_rule_name},
                                     {"--blend-width", 1, BOTH, NULL},
                                     {"--spontaneous-curvature", 1, BOTH, NULL},
                                     {"--quiet", 0, BOTH, NULL},
                                     {"--strict", 0, BOTH, NULL},
                                     {"--deviation-from", 1, EVALUATE, NULL},
                                     {"-o", 1, MINIMIZE, NULL},
                                     {"--output", 1, MINIMIZE, NULL},
                                     {"--levels", 1, MINIMIZE, NULL},
                                     {"--max-iterations", 1, MINIMIZE, NULL},
                                     {"--decrement-tolerance", 1, MINIMIZE, NULL},
                                     {"--method", 1, MINIMIZE, curvopt_method_name},
                                     {"--boundary", 1, MINIMIZE, curvopt_boundary_name},
                                     {"--symmetry", 1, MINIMIZE, name_of_symmetry},
                                     {"--pin", 1, MINIMIZE, NULL},
                                     {"--through", 1, MINIMIZE, NULL},
                                     {"--trace", 1, MINIMIZE, NULL},
                                     {"--spacing", 1, MINIMIZE, curvopt_spacing_name},
                                     {"--volume", 1, MINIMIZE, NULL},
                                     {"--area", 1, MINIMIZE, NULL},
                                     {"--total-mean-curvature", 1, MINIMIZE, NULL},
                                     {"--reduced-volume", 1, MINIMIZE, NULL},
                                     {"--strength", 1, MINIMIZE, NULL},
                                     {"--within", 1, MINIMIZE, NULL},
                                     {"--joshi-sequin", 0, MINIMIZE, NULL},
                                     {"--slide", 0, MINIMIZE, NULL},
                                     {"--no-crossings", 0, MINIMIZE, NULL},
                                     {"--verify", 0, MINIMIZE, NULL},
                                     {"--escape", 0, MINIMIZE, NULL}};

/* The option of a command whose name is at most so many edits away, the nearest; NULL. */
static const known_option *find_option(const char *name, int command, int most) {
    const known_option *nearest = NULL;
    for (size_t k = 0; k < sizeof KNOWN / sizeof *KNOWN; k++) {
        const int distance = KNOWN[k].commands & command ? edit_distance(name, KNOWN[k].name) : most + 1;
        if (distance <= most) {
            nearest = &KNOWN[k];
            most = distance - 1;
        }
    }
    return nearest;
}

static int complain_unknown(char *message, size_t size, const char *name, int command) {
    enum { MOST_EDITS = 2, SHORTEST = 5 }; /* of a name: nearly everything is near a shorter one */
    const known_option *near = strlen(name) < SHORTEST ? NULL : find_option(name, command, MOST_EDITS);
    snprintf(message, size, "unknown option %.100s%s%s", name, near ? "; the nearest is " : "", near ? near->name : "");
    return ARGUMENTS_USAGE;
}

/* With the values that there are, where they have names. */
static int complain_value(char *message, size_t size, const known_option *option, const char *value) {
    int length = snprintf(message, size, "%s cannot be %.100s", option->name, value);
    for (int32_t i = 0; option->value_name && option->value_name(i) && length >= 0 && (size_t)length < size; i++)
        length +=
            snprintf(message + length, size - (size_t)length, "%s%s", i ? ", " : "; there are ", option->value_name(i));
    return ARGUMENTS_USAGE;
}

static void set_flag(arguments *a, const char *name) {
    curvopt_options *o = &a->options;
    if (!strcmp(name, "--quiet"))
        a->quiet = 1;
    else if (!strcmp(name, "--strict"))
        o->strict = 1;
    else if (!strcmp(name, "--joshi-sequin"))
        o->joshi_sequin = 1;
    else if (!strcmp(name, "--slide"))
        o->slide = 1;
    else if (!strcmp(name, "--no-crossings"))
        o->no_crossings = 1;
    else if (!strcmp(name, "--verify"))
        o->verify = 1;
    else
        o->escape = 1;
}

int arguments_parse(int argc, char **argv, arguments *a, char *message, size_t size) {
    *a = (arguments){.command = argv[1], .energy = "willmore", .boundary_rule = -1};
    int minimize = !strcmp(a->command, "minimize");
    if (!minimize && strcmp(a->command, "evaluate") != 0)
        return complain(message, size, "unknown command", a->command);
    curvopt_options_init(&a->options, sizeof a->options);
    for (int i = 2; i < argc; i++) {
        const char *arg = argv[i];
        const known_option *option = find_option(arg, minimize ? MINIMIZE : EVALUATE, 0);
        if (option && option->has_value) {
            if (++i == argc)
                return complain(message, size, "a value is missing after", arg);
            if (parse_valued(a, arg, argv[i]))
                return complain_value(message, size, option, argv[i]);
        } else if (option) {
            set_flag(a, arg);
        } else if (arg[0] == '-' && arg[1]) {
            return complain_unknown(message, size, arg, minimize ? MINIMIZE : EVALUATE);
        } else if (a->input) {
            return complain(message, size, "more than one cage:", arg);
        } else {
            a->input = arg;
        }
    }
    if (!a->input)
        return complain(message, size, "no cage was named", NULL);
    if (minimize && !a->output)
        return complain(message, size, "no output was named: -o OUT.obj", NULL);
    if (a->has_volume && a->has_reduced_volume)
        return complain(message, size,
                        "--volume and --reduced-volume exclude each other: give the volume, or the volume and the area",
                        NULL);
    if (a->through && !strcmp(a->input, "-") && !strcmp(a->through, "-"))
        return complain(message, size, "standard input can be the cage or the file of --through, not both", NULL);
    curvopt_error error;
    if (curvopt_options_validate(&a->options, &error) == CURVOPT_OK)
        return ARGUMENTS_DONE;
    complain(message, size, error.message, NULL);
    return error.code == CURVOPT_ERROR_UNSUPPORTED ? ARGUMENTS_COULD_NOT : ARGUMENTS_USAGE;
}
