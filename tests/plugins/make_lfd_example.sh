#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# A learner's graph with its grasp set, reachability map and free space.
# Usage: make_lfd_example.sh GRAFT_LFD FOLDER
set -eu
mkdir -p "$2"
GRAFT_CACHE_DIR=$2/cache
export GRAFT_CACHE_DIR
"$1" teach drawer -o "$2/task" --seed 1 >/dev/null
"$1" build "$2/task/task.xml" -o "$2/graph" >/dev/null
