/* What --help prints. SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CURVOPT_TOOL_HELP_H
#define CURVOPT_TOOL_HELP_H

/* On standard output; negative if that failed. */
int help_print(void);

#endif
