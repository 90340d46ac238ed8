#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Whether learn's grasp is the best: taught scenes are optimized again with each valid
grasp as the only one, and the final chi2 are compared.

Usage: GRAFT_BINARY_DIR=build grasp_choice.py TASK... (SEEDS="21 22": of taught scenes).
Prints a line a scene; exit code 1 if more than one of twenty scenes has a better grasp.
What learn does not choose from, as it is not like the person's, counts as well."""
import json
import os
import shutil
import subprocess
import sys
import tempfile

import files
from program import BUILD, run

SEEDS = [int(s) for s in os.environ.get("SEEDS", "21 22 23 24 25").split()]
SAME = 1e-6  # relative, of chi2


def optimized(graph):
    """Final chi2 within the iterations that learn makes."""
    result = subprocess.run([os.path.join(BUILD, "bin", "graft"), "optimize", graph,
                             "--iterations", "20", "--json", "-"],
                            capture_output=True, text=True, check=True)
    return json.loads(result.stdout)["chi2_final"]


def compare(name, seed, folder):
    """(own chi2, own row, best chi2, its row)."""
    task, result = os.path.join(folder, "task"), os.path.join(folder, "result")
    for arguments in (("teach", name, "--seed", str(seed), "-o", task),
                      ("learn", os.path.join(task, "task.xml"), "-o", result)):
        done = run(*arguments)
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
    graph = os.path.join(result, "graph.g2o")
    own = optimized(graph)
    row = files.read_json(os.path.join(result, "grasp.json"))["grasp_row"]
    path = os.path.join(result, "resources", "grasps.csv")
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    quality = files.Task(os.path.join(task, "task.xml")).min_quality
    found = []
    for k, line in enumerate(lines[1:]):
        if line and float(line.split(",")[7]) >= quality:
            with open(path, "w", encoding="utf-8") as file:
                file.write(lines[0] + "\n" + line + "\n")
            found.append((optimized(graph), k))
    return (own, row, *min(found))


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    worse = count = 0
    for name in sys.argv[1:]:
        for seed in SEEDS:
            folder = tempfile.mkdtemp(prefix="graft-grasps-")
            try:
                own, row, best, best_row = compare(name, seed, folder)
            finally:
                shutil.rmtree(folder)
            count += 1
            good = own <= best * (1 + SAME)
            worse += not good
            print(f"{name:13} seed {seed}: row {row} {own:.4f}, best row {best_row} {best:.4f} "
                  f"{'same or lower' if good else f'higher by {own / best - 1:.2%}'}", flush=True)
    print(f"{count - worse} of {count} scenes: no grasp is better")
    return 1 if 20 * worse > count else 0


if __name__ == "__main__":
    sys.exit(main())
