/* What the command line asks of the system. Paths and arguments are UTF-8; on Windows paths may have more than 260
 * characters. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_PLATFORM_H
#define CURVOPT_TOOL_PLATFORM_H

#include <stdio.h>

/* First thing in main(): arguments as UTF-8 into *argc and *argv, which live as long as the process; standard streams
 * that change no byte, and that no other file gets the number of if they are closed; a limit on the size of files and a
 * reader that has gone are errors of writing, and no signals. 0, or an errno. */
int platform_start(int *argc, char ***argv);
/* fopen(), errno included; a directory is EISDIR. An `x` at the end of mode: the file must be new. */
FILE *platform_open(const char *path, const char *mode);
/* Renames; what stands at `to` is replaced. 0, or an errno. */
int platform_replace(const char *from, const char *to);
void platform_remove(const char *path);
/* Marks the new file PATH.PROCESS.part as one that is being written, until platform_unlock() or the process' end; 0
 * where files cannot be marked, and -1 if another run has just taken it for a leftover and removed it. */
int platform_lock(FILE *file);
void platform_unlock(int lock);
/* Removes what processes that are gone have left of PATH: files PATH.PROCESS.part that are not marked. */
void platform_remove_leftovers(const char *path);
/* Whether path exists and is no regular file: a device, a pipe, a directory. */
int platform_is_special(const char *path);
/* Whether someone reads standard error on a terminal. */
int platform_is_watched(void);
unsigned platform_process_id(void);

#endif
