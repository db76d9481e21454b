/* What the command line asks of the system. Paths and arguments are UTF-8; on Windows paths may have more than 260
 * characters. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_PLATFORM_H
#define CURVOPT_TOOL_PLATFORM_H

#include <stdio.h>

/* First thing in main(): arguments as UTF-8 into *argc and *argv, which live as long as the process; standard streams
 * that change no byte; a limit on the size of files is an error of writing, and no signal. 0, or an errno. */
int platform_start(int *argc, char ***argv);
/* fopen(), errno included; a directory is EISDIR. An `x` at the end of mode: the file must be new. */
FILE *platform_open(const char *path, const char *mode);
/* Renames; what stands at `to` is replaced. 0, or an errno. */
int platform_replace(const char *from, const char *to);
void platform_remove(const char *path);
/* Whether path exists and is no regular file: a device, a pipe, a directory. */
int platform_is_special(const char *path);
/* Whether someone reads standard error on a terminal. */
int platform_is_watched(void);
unsigned platform_process_id(void);

#endif
