#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Line coverage of every room by the tests. Usage: bash tests/coverage/run.sh [ctest options]
#   BUILD_DIR   where to build (default: build-coverage)
#   TARGETS     what to build (default: all)
# Left out: sweeps of whole results, which run for long what other tests run as well; what
# links the library into a program of its own; what counts every file that a program writes.
set -euo pipefail
cd "$(dirname "$0")/../.."

bash .ci/packages.sh gcovr
build=${BUILD_DIR:-build-coverage}
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Debug \
  -DCMAKE_CXX_FLAGS="--coverage -fprofile-update=atomic -O1 -g0" -DCMAKE_C_FLAGS="--coverage" >/dev/null
read -ra targets <<<"${TARGETS:-all}"
cmake --build "$build" --target "${targets[@]}"
find "$build" -name '*.gcda' -delete
left_out='^verify\.|^lfd_reach_accuracy\.|^install\.|\.NothingGetsItsName|\.ManyRunsMayWrite'
status=0
ctest --test-dir "$build" -j "$(nproc)" -E "$left_out" "$@" | tail -8 || status=$?
gcovr --root . --object-directory "$build" --filter 'core/' --filter 'types_lfd/' \
  --filter 'plugins/' --filter 'apps/' --gcov-ignore-parse-errors \
  --json-summary "$build/coverage.json" >/dev/null
python3 tests/coverage/rooms.py "$build/coverage.json"
exit "$status"
