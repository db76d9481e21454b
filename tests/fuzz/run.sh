#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Fuzzes with libFuzzer (clang, libclang-rt-dev, libomp-dev): each harness for 60 s, or as many as the first argument
# says. What is found stays in build/fuzz as crash-*; new inputs worth keeping in build/fuzz/corpus_*.
set -euo pipefail
seconds=${1:-60}
cd "$(dirname "$0")/../.."
cmake -G Ninja -B build/fuzz -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCURVOPT_SANITIZE=ON -DCURVOPT_FUZZ=ON >/dev/null
cmake --build build/fuzz --target fuzz_obj fuzz_mesh fuzz_pins fuzz_through fuzz_api fuzz_options
for name in obj mesh pins through api options; do
    mkdir -p build/fuzz/corpus_$name
    echo "fuzzing $name for $seconds s"
    ./build/fuzz/tests/fuzz_$name -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 -print_final_stats=1 \
        -artifact_prefix=build/fuzz/ build/fuzz/corpus_$name tests/fuzz/corpus_$name 2>&1 | tail -n 12
done
