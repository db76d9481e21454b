/* Loads the shared library 100 times, computes on four threads, and unloads it: no thread is left, and nothing of the
 * library. Every tenth time a run on a second thread of the program is cancelled in between.
 *
 *   unload LIBRARY
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "curvopt.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#ifdef _WIN32
#include <windows.h>
/* after windows.h */
#include <tlhelp32.h>
#else
#include <dirent.h>
#include <dlfcn.h>
#endif

enum { SIDE_U = 12, SIDE_V = 8, LOADS = 100, THREADS = 4 };

#define FUNCTIONS(X)                                                                                                   \
    X(curvopt_mesh_create)                                                                                             \
    X(curvopt_mesh_destroy)                                                                                            \
    X(curvopt_options_init)                                                                                            \
    X(curvopt_problem_create)                                                                                          \
    X(curvopt_problem_evaluate)                                                                                        \
    X(curvopt_problem_destroy)                                                                                         \
    X(curvopt_cancel_create)                                                                                           \
    X(curvopt_cancel_request)                                                                                          \
    X(curvopt_cancel_destroy)                                                                                          \
    X(curvopt_minimize)                                                                                                \
    X(curvopt_result_destroy)

typedef struct functions {
    void *library;
#define POINTER(name) __typeof__(name) *name;
    FUNCTIONS(POINTER)
} functions;

static void stop(const char *what) {
    fprintf(stderr, "unload: %s\n", what);
    exit(1);
}

#ifdef _WIN32
static void *open_library(const char *path) {
    void *library = LoadLibraryA(path);
    if (!library)
        stop("LoadLibrary");
    return library;
}

static void *find_function(void *library, const char *name) {
    return (void *)GetProcAddress(library, name);
}

static void close_library(void *library) {
    if (!FreeLibrary(library))
        stop("FreeLibrary");
}

static int is_loaded(const char *path) {
    return GetModuleHandleA(path) != NULL;
}

/* Threads of this process. */
static int count_threads(void) {
    int n = 0;
    THREADENTRY32 e = {.dwSize = sizeof e};
    HANDLE all = CreateToolhelp32Snapshot(TH32CS_SNAPTHREAD, 0);
    if (all == INVALID_HANDLE_VALUE)
        stop("CreateToolhelp32Snapshot");
    for (BOOL more = Thread32First(all, &e); more; more = Thread32Next(all, &e))
        n += e.th32OwnerProcessID == GetCurrentProcessId();
    CloseHandle(all);
    return n;
}
#else
static void *open_library(const char *path) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        stop(dlerror());
    return library;
}

static void *find_function(void *library, const char *name) {
    return dlsym(library, name);
}

static void close_library(void *library) {
    if (dlclose(library))
        stop(dlerror());
}

static int is_loaded(const char *path) {
    return dlopen(path, RTLD_NOW | RTLD_NOLOAD) != NULL;
}

/* Threads of this process. */
static int count_threads(void) {
    int n = 0;
    DIR *folder = opendir("/proc/self/task");
    if (!folder)
        stop("/proc/self/task");
    for (const struct dirent *e; (e = readdir(folder));)
        n += e->d_name[0] != '.';
    closedir(folder);
    return n;
}
#endif

static functions load(const char *path) {
    functions f = {.library = open_library(path)};
#define FIND(name)                                                                                                     \
    *(void **)&f.name = find_function(f.library, #name);                                                               \
    if (!f.name)                                                                                                       \
        stop(#name);
    FUNCTIONS(FIND)
    return f;
}

/* Whether this process has n threads within 5 s: a thread that was joined is on the system's list for a moment longer,
 * in qemu longer than it takes to come here. */
static int has_threads_soon(int n) {
    for (int i = 0; i < 5000 && count_threads() != n; i++)
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    return count_threads() == n;
}

/* A torus of quads whose tube is wider on one side, so that a run has something to do. */
static curvopt_mesh *torus(const functions *f, double *xyz) {
    static const double across[SIDE_V][2] = {{1, 0},  {.7, .7},   {0, 1},  {-.7, .7},
                                             {-1, 0}, {-.7, -.7}, {0, -1}, {.7, -.7}};
    static const double round[SIDE_U][2] = {{1, 0},  {.87, .5},   {.5, .87},   {0, 1},  {-.5, .87}, {-.87, .5},
                                            {-1, 0}, {-.87, -.5}, {-.5, -.87}, {0, -1}, {.5, -.87}, {.87, -.5}};
    int32_t sizes[SIDE_U * SIDE_V], corners[4 * SIDE_U * SIDE_V];
    curvopt_mesh *mesh;
    curvopt_error error;
    for (int i = 0; i < SIDE_U; i++)
        for (int j = 0; j < SIDE_V; j++) {
            const int k = SIDE_V * i + j, next_i = SIDE_V * ((i + 1) % SIDE_U), next_j = (j + 1) % SIDE_V;
            const double radius = 2 + (.5 + .02 * i) * across[j][0];
            const int32_t face[4] = {k, next_i + j, next_i + next_j, SIDE_V * i + next_j};
            xyz[3 * k] = radius * round[i][0];
            xyz[3 * k + 1] = radius * round[i][1];
            xyz[3 * k + 2] = .5 * across[j][1];
            sizes[k] = 4;
            for (int c = 0; c < 4; c++)
                corners[4 * k + c] = face[c];
        }
    if (f->curvopt_mesh_create(SIDE_U * SIDE_V, SIDE_U * SIDE_V, sizes, corners, &mesh, &error))
        stop(error.message);
    return mesh;
}

static int most_threads; /* that this process had during an evaluation */

static void evaluate(const functions *f, const curvopt_mesh *mesh, const curvopt_options *options, const double *xyz) {
    static double gradient[3 * SIDE_U * SIDE_V];
    curvopt_problem *problem;
    curvopt_energies energies;
    curvopt_error error;
    if (f->curvopt_problem_create(mesh, xyz, options, &problem, &error) ||
        f->curvopt_problem_evaluate(problem, xyz, &energies, sizeof energies, gradient, &error))
        stop(error.message);
    const int n = count_threads();
    most_threads = n > most_threads ? n : most_threads;
    f->curvopt_problem_destroy(problem);
}

typedef struct run {
    const functions *f;
    const curvopt_mesh *mesh;
    const double *xyz;
    const curvopt_options *options;
    const curvopt_cancel *cancel;
} run;

static void *minimize(void *context) {
    const run *r = context;
    curvopt_result *result;
    curvopt_error error;
    if (r->f->curvopt_minimize(r->mesh, r->xyz, r->options, NULL, NULL, r->cancel, &result, &error))
        stop(error.message);
    r->f->curvopt_result_destroy(result);
    return NULL;
}

static void minimize_and_cancel(const functions *f, const curvopt_mesh *mesh, const curvopt_options *options,
                                const double *xyz) {
    pthread_t thread;
    curvopt_cancel *cancel;
    curvopt_error error;
    if (f->curvopt_cancel_create(&cancel, &error))
        stop(error.message);
    run r = {.f = f, .mesh = mesh, .xyz = xyz, .options = options, .cancel = cancel};
    if (pthread_create(&thread, NULL, minimize, &r))
        stop("pthread_create");
    nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
    f->curvopt_cancel_request(cancel);
    pthread_join(thread, NULL);
    f->curvopt_cancel_destroy(cancel);
}

int main(int argc, char **argv) {
    static double xyz[3 * SIDE_U * SIDE_V];
    if (argc != 2)
        stop("usage: unload LIBRARY");
    const int before = count_threads();
    for (int k = 0; k < LOADS; k++) {
        functions f = load(argv[1]);
        curvopt_options options;
        f.curvopt_options_init(&options, sizeof options);
        options.threads = THREADS;
        curvopt_mesh *mesh = torus(&f, xyz);
        evaluate(&f, mesh, &options, xyz);
        if (k % 10 == 0)
            minimize_and_cancel(&f, mesh, &options, xyz);
        f.curvopt_mesh_destroy(mesh);
        close_library(f.library);
        if (is_loaded(argv[1]))
            stop("the library is still loaded");
        if (!has_threads_soon(before))
            stop("a thread of the library is left");
    }
    if (most_threads != before + THREADS - 1)
        stop("the library had not the threads that it was to have");
    printf("unloaded %d times\n", LOADS);
    return 0;
}
