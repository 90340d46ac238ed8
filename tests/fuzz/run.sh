#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds the fuzz targets with clang and runs each; ends with 1 if one has a finding.
# Usage: bash tests/fuzz/run.sh [seconds per target, default 60] [target ...]
#   BUILD_DIR   where to build (default: build-fuzz); found inputs are kept in its corpus
set -euo pipefail
cd "$(dirname "$0")/../.."

seconds=${1:-60}
build=${BUILD_DIR:-build-fuzz}
CC=clang CXX=clang++ cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
  -DGRAFT_FUZZ=ON >/dev/null
cmake --build "$build" --target fuzz

python3 tests/fuzz/seeds.py "$build/seeds"
targets=("${@:2}")
[ "${#targets[@]}" -gt 0 ] || mapfile -t targets < <(ls tests/fuzz | sed -n 's/_fuzz\.cpp$//p')
failed=0
printf '%-8s %10s %8s %8s %8s %22s  %s\n' target inputs per_s edges corpus taken result
for target in "${targets[@]}"; do
  mkdir -p "$build/corpus/$target" "$build/findings"
  seeds=()
  for folder in "tests/fuzz/corpus/$target" "$build/seeds/$target"; do
    [ -d "$folder" ] && seeds+=("$folder")
  done
  log="$build/findings/$target.log"
  result=clean
  # Larger inputs find no more and are slow; what a reader may allocate is bounded by
  # the size of its file.
  "$build/fuzz/fuzz_$target" -max_total_time="$seconds" -max_len=4096 -timeout=10 \
    -rss_limit_mb=3000 -print_final_stats=1 -artifact_prefix="$build/findings/$target-" \
    "$build/corpus/$target" "${seeds[@]}" >"$log" 2>&1 || { result="FINDING, see $log"; failed=1; }
  stat() { sed -n "s/^stat::$1: *//p" "$log"; }
  printf '%-8s %10s %8s %8s %8s %22s  %s\n' "$target" "$(stat number_of_executed_units)" \
    "$(stat average_exec_per_sec)" "$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -1)" \
    "$(ls "$build/corpus/$target" | wc -l)" "$(sed -n 's/^taken //p' "$log" | tail -1)" "$result"
done
exit "$failed"
