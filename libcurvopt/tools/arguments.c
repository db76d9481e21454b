/* The command line's arguments. SPDX-License-Identifier: GPL-3.0-or-later */
#include "arguments.h"

#include "option_values.h"
#include "report_json.h"

#include <stdio.h>
#include <string.h>

const char *const method_name[3] = {"auto", "lmvm", "gauss_newton"};
static const char *const boundary_name[4] = {"position", "tangent", "curvature", "free"};
static const char *const boundary_rule_name[2] = {"smooth", "corners"};

static int complain(char *message, size_t size, const char *what, const char *which) {
    snprintf(message, size, "%s%s%s", what, which ? " " : "", which ? which : "");
    return ARGUMENTS_USAGE;
}

/* An option with a value; 0 if understood. */
static int parse_valued(arguments *a, const char *name, const char *value) {
    curvopt_options *o = &a->options;
    int surface;
    if (!strcmp(name, "--json"))
        a->json = value;
    else if (!strcmp(name, "--energy"))
        return parse_energy(a->energy = value, o->weights);
    else if (!strcmp(name, "--surface")) {
        surface = parse_name(json_surface_name, 4, value, strlen(value));
        o->surface = surface;
        return surface < CURVOPT_SURFACE_LIMIT;
    } else if (!strcmp(name, "--boundary-rule")) {
        a->boundary_rule = parse_name(boundary_rule_name, 2, value, strlen(value));
        return a->boundary_rule < 0;
    } else if (!strcmp(name, "--boundary")) {
        o->boundary = parse_name(boundary_name, 4, value, strlen(value));
        return o->boundary < 0;
    } else if (!strcmp(name, "--tolerance"))
        return parse_real(value, &o->tolerance);
    else if (!strcmp(name, "--decrement-tolerance"))
        return parse_real(value, &o->decrement_tolerance);
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
    else if (!strcmp(name, "--pin"))
        a->pins = value;
    else if (!strcmp(name, "--trace"))
        a->trace = value;
    else if (!strcmp(name, "--symmetry"))
        return parse_symmetry(value, o);
    else if (!strcmp(name, "--method")) {
        o->method = parse_name(method_name, 3, value, strlen(value));
        return o->method < CURVOPT_METHOD_LMVM;
    }
    return 0;
}

static int is_valued(const char *name, int minimize) {
    static const char *const both[] = {"--json",    "--energy",        "--surface",    "--tolerance",
                                       "--threads", "--boundary-rule", "--blend-width"};
    static const char *const only_minimize[] = {
        "-o",         "--output",   "--levels", "--max-iterations", "--decrement-tolerance", "--method",
        "--boundary", "--symmetry", "--pin",    "--trace"};
    size_t length = strlen(name);
    return parse_name(both, sizeof both / sizeof *both, name, length) >= 0 ||
           (minimize && parse_name(only_minimize, sizeof only_minimize / sizeof *only_minimize, name, length) >= 0);
}

int arguments_parse(int argc, char **argv, arguments *a, char *message, size_t size) {
    *a = (arguments){.command = argv[1], .energy = "willmore"};
    int minimize = !strcmp(a->command, "minimize");
    if (!minimize && strcmp(a->command, "evaluate") != 0)
        return complain(message, size, "unknown command", a->command);
    curvopt_options_init(&a->options);
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
        } else if (minimize && !strcmp(arg, "--as-report")) {
            a->options.as_report = 1;
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
    curvopt_error error;
    if (curvopt_options_validate(&a->options, &error) == CURVOPT_OK)
        return ARGUMENTS_DONE;
    complain(message, size, error.message, NULL);
    return error.code == CURVOPT_ERROR_UNSUPPORTED ? ARGUMENTS_COULD_NOT : ARGUMENTS_USAGE;
}
