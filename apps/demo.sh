#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# From nothing to a learned robot motion: installs what is missing, builds graft,
# lets a simulated teacher demonstrate how to open a drawer, learns from it, and
# generates a motion for the robot. Usage: bash apps/demo.sh [TASK] [FOLDER]
#   TASK    room_door, swivel_door, drawer (default) or sliding_door
#   FOLDER  where results go (default: out/demo)
set -euo pipefail
cd "$(dirname "$0")/.."

task=${1:-drawer}
out=${2:-out/demo}
bash .ci/packages.sh
echo "== Building (a few minutes the first time)"
mkdir -p build
cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DGRAFT_BUILD_TESTS=OFF >build/configure.log ||
  { cat build/configure.log; exit 1; }
cmake --build build
mkdir -p "$out"

echo
echo "== 1. A pose graph: simulate a noisy sphere and optimize it"
build/bin/graft simulate sphere --seed 1 -o "$out/sphere.g2o"
build/bin/graft optimize "$out/sphere.g2o" -o "$out/sphere_optimized.g2o"

echo
echo "== 2. A person shows the task '$task' (simulated, with noise and gaps)"
build/bin/graft-lfd teach "$task" -o "$out/$task" --seed 1

echo
echo "== 3. Learn from the demonstrations"
build/bin/graft-lfd learn "$out/$task/task.xml" -o "$out/learned"

echo
echo "== 4. Generate a motion from what was learned"
build/bin/graft-lfd reproduce "$out/learned" -o "$out/motion"

cat <<TEXT

What to look at:
  $out/learned/report.html          before and after, in a browser
  $out/learned/metrics.json         the numbers
  $out/learned/optimized/           hand, object, gripper and base of every demonstration
  $out/learned/graph.g2o            the factor graph; build/bin/graft optimize solves it, too
  $out/motion/motion/               gripper and base motion, and the arm's joints
TEXT
