#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds graft and runs all tests. Works on a fresh Debian 12: installs what is
# missing. Usage: bash tests/run.sh [ctest options]
#   BUILD_DIR   where to build (default: build)
#   BUILD_TYPE  CMake build type (default: Release)
#   SANITIZE    e.g. address,undefined (default: none)
#   TARGETS     what to build, where -R picks tests that need no more (default: all)
#   GRAFT_DATA  folder of the evaluation data; tests that need it are skipped without
set -euo pipefail
cd "$(dirname "$0")/.."

bash .ci/packages.sh liborocos-kdl-dev liburdfdom-dev
build=${BUILD_DIR:-build}
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE="${BUILD_TYPE:-Release}" \
  -DGRAFT_BUILD_TESTS=ON -DGRAFT_WERROR=ON -DGRAFT_SANITIZE="${SANITIZE:-}" >"$build.configure.log" 2>&1 || {
  cat "$build.configure.log"
  exit 1
}
rm -f "$build.configure.log"
read -ra targets <<<"${TARGETS:-all}"
cmake --build "$build" --target "${targets[@]}"
ctest --test-dir "$build" --no-tests=error --output-on-failure -j "$(nproc)" "$@"
