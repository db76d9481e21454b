#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Runs a command in a session of its own, until it ends or its processes have used so much CPU time together, or none at
# all for ten minutes on the clock. Time on the clock says nothing on a busy machine.
#
#   cpu_limit.sh SECONDS COMMAND...     the command's exit code; 124 if it was stopped
set -u
limit=$1
shift
IDLE=${CURVOPT_IDLE:-600} # seconds on the clock
hz=$(getconf CLK_TCK)

# CPU seconds of the session's processes, and of those that they have waited for.
used() {
    cat /proc/[0-9]*/stat 2>/dev/null | sed 's/^\([0-9]*\) (.*) /\1 /' |
        awk -v session="$session" -v hz="$hz" '$5 == session { n += $13 + $14 + $15 + $16 } END { print int(n / hz) }'
}

# Ends the session: politely, then not.
stop() {
    trap "" PIPE # whoever reads the output may have been ended by the interrupt already
    echo "cpu_limit: $1"
    pkill -TERM -s "$session"
    sleep 5
    pkill -KILL -s "$session"
    exit 124
}

# A command in the background of a script ignores interrupts, and so would its tests of interrupts; env mends that.
setsid env --default-signal=INT,QUIT "$@" &
session=$!
trap 'stop "interrupted"' INT TERM
last=-1 since=$SECONDS
while [[ -e /proc/$session ]] && kill -0 "$session" 2>/dev/null; do
    now=$(used)
    ((now == last)) || last=$now since=$SECONDS
    ((now < limit)) || stop "$now s of CPU time are more than $limit"
    ((SECONDS - since < IDLE)) || stop "no CPU time was used for $IDLE s"
    for ((k = 0; k < 20; k++)); do # the end is seen soon
        kill -0 "$session" 2>/dev/null || break
        sleep 0.1
    done
done
wait "$session"
