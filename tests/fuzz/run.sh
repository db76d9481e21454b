#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Fuzzes with libFuzzer (clang, libclang-rt-dev): each harness for 60 s, or as many as the first argument says.
#
#   bash tests/fuzz/run.sh [SECONDS [address|memory [HARNESS...]]]
#
# With the address and undefined-behaviour sanitizers (the default) or the memory sanitizer. What is found stays in build/fuzz
# (build/fuzz-memory) as crash-*; new inputs worth keeping in its corpus_*.
set -euo pipefail
seconds=${1:-60}
sanitizer=${2:-address}
cd "$(dirname "$0")/../.."
case $sanitizer in
address) build=build/fuzz option=-DCURVOPT_SANITIZE=ON ;;
memory) build=build/fuzz-memory option=-DCURVOPT_SANITIZE_MEMORY=ON ;;
*) echo "fuzz: no sanitizer '$sanitizer'; there are: address memory" >&2 && exit 2 ;;
esac
harnesses=("${@:3}")
((${#harnesses[@]})) || harnesses=(obj mesh pins through api options)
# Less is kept of what was freed: most of the time would go into fresh pages.
export ASAN_OPTIONS=quarantine_size_mb=8:malloc_context_size=6
cmake -G Ninja -B "$build" -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    "$option" -DCURVOPT_PORTABLE=ON -DCURVOPT_FUZZ=ON >/dev/null
cmake --build "$build" --target "${harnesses[@]/#/fuzz_}"
for name in "${harnesses[@]}"; do
    mkdir -p "$build/corpus_$name"
    echo "fuzzing $name for $seconds s"
    "$build/tests/fuzz_$name" -max_total_time="$seconds" -timeout=60 -rss_limit_mb=3000 -print_final_stats=1 \
        -artifact_prefix="$build/" "$build/corpus_$name" "tests/fuzz/corpus_$name" 2>&1 | tail -n 12
done
