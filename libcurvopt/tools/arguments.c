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
static int parse_held(const char *name, const char *value, curvopt_options *o) {
    if (!strcmp(name, "--volume"))
        return parse_scalar(value, CURVOPT_SCALAR_VOLUME, o);
    if (!strcmp(name, "--area"))
        return parse_scalar(value, CURVOPT_SCALAR_AREA, o);
    if (!strcmp(name, "--total-mean-curvature"))
        return parse_scalar(value, CURVOPT_SCALAR_MEAN_CURVATURE, o);
    if (!strcmp(name, "--reduced-volume")) {
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
        return parse_held(name, value, o);
    return 0;
}

/* The options with a value that a command has. */
static int is_valued(const char *name, int minimize) {
    static const char *const both[] = {"--json",    "--energy",        "--surface",     "--tolerance",
                                       "--threads", "--boundary-rule", "--blend-width", "--spontaneous-curvature"};
    static const char *const only_minimize[] = {"-o",
                                                "--output",
                                                "--levels",
                                                "--max-iterations",
                                                "--decrement-tolerance",
                                                "--method",
                                                "--boundary",
                                                "--symmetry",
                                                "--pin",
                                                "--through",
                                                "--trace",
                                                "--spacing",
                                                "--volume",
                                                "--area",
                                                "--total-mean-curvature",
                                                "--reduced-volume",
                                                "--strength",
                                                "--within"};
    size_t length = strlen(name);
    if (!minimize && !strcmp(name, "--deviation-from"))
        return 1;
    return parse_name(both, sizeof both / sizeof *both, name, length) >= 0 ||
           (minimize && parse_name(only_minimize, sizeof only_minimize / sizeof *only_minimize, name, length) >= 0);
}

int arguments_parse(int argc, char **argv, arguments *a, char *message, size_t size) {
    *a = (arguments){.command = argv[1], .energy = "willmore", .boundary_rule = -1};
    int minimize = !strcmp(a->command, "minimize");
    if (!minimize && strcmp(a->command, "evaluate") != 0)
        return complain(message, size, "unknown command", a->command);
    curvopt_options_init(&a->options, sizeof a->options);
    for (int i = 2; i < argc; i++) {
        const char *arg = argv[i];
        if (is_valued(arg, minimize)) {
            if (++i == argc)
                return complain(message, size, "a value is missing after", arg);
            if (parse_valued(a, arg, argv[i])) {
                snprintf(message, size, "%s cannot be %s", arg, argv[i]);
                return ARGUMENTS_USAGE;
            }
        } else if (!strcmp(arg, "--quiet")) {
            a->quiet = 1;
        } else if (!strcmp(arg, "--strict")) {
            a->options.strict = 1;
        } else if (minimize && !strcmp(arg, "--joshi-sequin")) {
            a->options.joshi_sequin = 1;
        } else if (minimize && !strcmp(arg, "--slide")) {
            a->options.slide = 1;
        } else if (minimize && !strcmp(arg, "--no-crossings")) {
            a->options.no_crossings = 1;
        } else if (minimize && !strcmp(arg, "--verify")) {
            a->options.verify = 1;
        } else if (minimize && !strcmp(arg, "--escape")) {
            a->options.escape = 1;
        } else if (arg[0] == '-' && arg[1]) {
            return complain(message, size, "unknown option", arg);
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
    if (a->through && !strcmp(a->input, "-") && !strcmp(a->through, "-"))
        return complain(message, size, "standard input can be the cage or the file of --through, not both", NULL);
    curvopt_error error;
    if (curvopt_options_validate(&a->options, &error) == CURVOPT_OK)
        return ARGUMENTS_DONE;
    complain(message, size, error.message, NULL);
    return error.code == CURVOPT_ERROR_UNSUPPORTED ? ARGUMENTS_COULD_NOT : ARGUMENTS_USAGE;
}
