#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How much of a recording can be missing: learns from copies of the four tasks with
lost samples, lost demonstrations, no torso tracks, another robot, and from freshly
taught scenes, and says which bounds hold.

Usage: GRAFT_BINARY_DIR=build GRAFT_DATA=... sweep.py OUT [KIND...]
Kinds: dropout fewer single torso taught robot (default: all). Writes OUT/table.csv
and OUT/dropout.svg. SEEDS="21 22": of taught scenes; LUCK=2: which samples are
lost; KEEP=folder: leaves all task folders and results there."""
import csv
import os
import shutil
import sys
import tempfile
import time

import bounds
import dropout_picture
import files
import truth
import variants
from program import DATA, run

TASKS = ("room_door", "swivel_door", "drawer", "sliding_door")
SHARES = (0, 0.1, 0.2, 0.3, 0.4, 0.5)
SEEDS = [int(s) for s in os.environ.get("SEEDS", "11 12 13").split()]  # of taught scenes
LUCK = int(os.environ.get("LUCK", "1"))  # seed of which samples are lost
TIAGO = ("robots/tiago/tiago_no_hand.urdf", "base_footprint", "arm_tool_link",
         "0.19 0.19  0 0.27  -0.19 0.19  -0.27 0  -0.19 -0.19  0 -0.27  0.19 -0.19  0.27 0",
         "0.15 0 0 0 0 0 1")


def source(name):
    return os.path.join(DATA, "tasks", name, "task.xml")


def dropout(folder):
    for name in TASKS:
        for share in SHARES:
            change = variants.losing(share, seed=LUCK)
            yield (name, f"{share:.0%} of samples lost",
                   variants.write_variant(source(name), folder(), change_track=change))


def demonstrations(name):
    return list(files.Task(source(name)).demonstrations)


def fewer(folder):
    for name in TASKS:
        names = demonstrations(name)
        for count in sorted({2, 3, len(names) // 2}):
            change = variants.keeping(names[:count])
            yield (name, f"{count} demonstrations",
                   variants.write_variant(source(name), folder(), change_xml=change))


def single(folder):
    for name in TASKS:
        for demo in demonstrations(name):
            change = variants.keeping([demo])
            yield (name, f"{demo} alone",
                   variants.write_variant(source(name), folder(), change_xml=change))


def torso(folder):
    for name in ("room_door", "swivel_door"):
        yield (name, "no torso tracks",
               variants.write_variant(source(name), folder(), change_xml=variants.without_torso))


def taught(folder):
    for name in TASKS:
        for seed in SEEDS:
            place = folder()
            result = run("teach", name, "--seed", str(seed), "-o", place)
            if result.returncode != 0:
                raise RuntimeError(result.stderr)
            yield (name, f"taught, seed {seed}", os.path.join(place, "task.xml"))


def robot(folder):
    urdf, base, tip, footprint, tool = TIAGO
    path = os.path.join(DATA, urdf)
    for name in ("swivel_door", "drawer", "sliding_door"):
        change = variants.with_robot("robot.urdf", base, tip, footprint, tool)
        yield (name, "TIAGo", variants.write_variant(source(name), folder(), change_xml=change,
                                                     urdf=path))


KINDS = {"dropout": dropout, "fewer": fewer, "single": single, "torso": torso, "taught": taught,
         "robot": robot}


def learn_all(kinds, keep=None):
    """Yields one dictionary a case: kind, task, case, exit, seconds, rows by name,
    `failed` rows."""
    with tempfile.TemporaryDirectory(prefix="graft-sweep-") as place:
        count = 0

        def folder():
            nonlocal count
            count += 1
            return os.path.join(keep or place, f"case_{count:03d}")

        for kind in kinds:
            for name, case, path in KINDS[kind](folder):
                begin = time.monotonic()
                out = os.path.join(os.path.dirname(path), "result")
                result = run("learn", path, "-o", out, "--snapshots", "0")
                line = {"kind": kind, "task": name, "case": case, "exit": result.returncode,
                        "seconds": round(time.monotonic() - begin, 1), "rows": {}, "failed": []}
                if result.returncode == 0:
                    for row, value, bound, good in bounds.rows(path, out, name):
                        line["rows"][row] = value
                        if not good:
                            line["failed"].append(f"{row} {value:.4g} ({bound:.4g})")
                    teacher = os.path.join(os.path.dirname(
                        path if kind == "taught" else source(name)), "truth")
                    line["rows"].update(truth.errors(out, teacher))
                else:
                    line["failed"].append(result.stderr.strip().split("\n")[-1])
                if not keep:
                    shutil.rmtree(os.path.dirname(path))
                yield line


def main():
    out = sys.argv[1]
    kinds = sys.argv[2:] or list(KINDS)
    os.makedirs(out, exist_ok=True)
    lines = []
    for line in learn_all(kinds, os.environ.get("KEEP")):
        lines.append(line)
        verdict = "; ".join(line["failed"]) or "ok"
        print(f"{line['task']:13} {line['case']:24} {line['seconds']:5} s  {verdict}", flush=True)
    names = sorted({row for line in lines for row in line["rows"]})
    with open(os.path.join(out, "table.csv"), "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["kind", "task", "case", "exit", *names, "failed"])
        for line in lines:
            writer.writerow([line["kind"], line["task"], line["case"], line["exit"],
                             *(line["rows"].get(n, "") for n in names), "; ".join(line["failed"])])
    if "dropout" in kinds:
        dropout_picture.write(os.path.join(out, "dropout.svg"), lines)
    bad = sum(bool(line["failed"]) for line in lines)
    print(f"{bad} of {len(lines)} cases miss a bound")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
