#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plants one small fault at a time in a copy of the sources, builds the test program
that should notice, and says whether it did. See README.md.
Usage: mutate.py [-n 40] [--seed 1] [--only TEXT] [--tree build-mutants]"""
import argparse
import pathlib
import random
import re
import shutil
import subprocess
import sys
import time

# Source -> test programs, by whose cases a fault in it has to be noticed.
TARGETS = {
    "core/base/text.cpp": ["core_base"],
    "core/graph/graph.cpp": ["core_optimizer", "core_inspection", "core_io"],
    "core/io/g2o_reader.cpp": ["core_io"],
    "core/io/graph_builder.cpp": ["core_io"],
    "core/io/information_check.cpp": ["core_io"],
    "core/io/trajectory.cpp": ["core_io"],
    "core/linear/block_cholesky.cpp": ["core_linear"],
    "core/linear/block_product.cpp": ["core_linear"],
    "core/linear/ordering.cpp": ["core_linear"],
    "core/linear/schur_pattern.cpp": ["core_linear"],
    "core/linear/selected_inverse.cpp": ["core_linear"],
    "core/linear/symbolic.cpp": ["core_linear"],
    "core/solve/alternatives.cpp": ["core_optimizer"],
    "core/solve/information.cpp": ["core_optimizer"],
    "core/solve/inner_iterations.cpp": ["core_optimizer"],
    "core/solve/normal_equations.cpp": ["core_optimizer", "core_inspection"],
    "core/solve/step_strategy.cpp": ["core_optimizer"],
    "core/solve/whiten.cpp": ["core_optimizer", "core_inspection"],
    "types_lfd/build/base_start.cpp": ["lfd_build"],
    "types_lfd/build/graph_builder.cpp": ["lfd_build"],
    "types_lfd/demo/match.cpp": ["lfd_demo"],
    "types_lfd/demo/segment.cpp": ["lfd_demo"],
    "types_lfd/demo/task.cpp": ["lfd_demo"],
    "types_lfd/grasp/grasp_set.cpp": ["lfd_grasp"],
    "types_lfd/map/grey_image.cpp": ["lfd_map"],
    "types_lfd/map/map_yaml.cpp": ["lfd_map"],
    "types_lfd/map/occupancy_map.cpp": ["lfd_map"],
    "types_lfd/map/polygon.cpp": ["lfd_map"],
    "types_lfd/robot/srdf.cpp": ["lfd_self_collision"],
    "types_lfd/robot/urdf.cpp": ["lfd_urdf", "lfd_chain"],
    "types_lfd/robot/urdf_checks.cpp": ["lfd_urdf"],
}

# What is found -> what takes its place. Blanks keep templates and pointers out.
SWAPS = [
    (r" < ", " <= "), (r" <= ", " < "), (r" > ", " >= "), (r" >= ", " > "),
    (r" == ", " != "), (r" != ", " == "), (r" && ", " || "), (r" \|\| ", " && "),
    (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" / ", " * "),
    (r" \+= ", " -= "), (r" -= ", " += "), (r"\btrue\b", "false"), (r"\bfalse\b", "true"),
    (r"\bstd::max\b", "std::min"), (r"\bstd::min\b", "std::max"),
    (r"\bif \((?=[^;]*\) )", "if (!"), (r"(?<![\w.\"'])(\d+)(?![\w.\"'])", None),
    (r"\bbreak;", ";"), (r"\bcontinue;", ";"),
]


def code_of(line):
    """The line with comments and texts blanked out, at the same columns."""
    blank = lambda m: " " * len(m.group())
    line = re.sub(r'"(\\.|[^"\\])*"', blank, line)
    return re.sub(r"//.*", blank, line)


def places(text):
    """All mutations of a source: (line number, column, old text, new text)."""
    for number, line in enumerate(text.splitlines()):
        code = code_of(line)
        if re.match(r"\s*(#|template|static_assert|using|///)", code):
            continue
        for pattern, new in SWAPS:
            for match in re.finditer(pattern, code):
                old = match.group()
                if old == "if (":
                    # The whole condition is negated where it ends on this line.
                    depth, end = 1, match.end()
                    while end < len(code) and depth:
                        depth += {"(": 1, ")": -1}.get(code[end], 0)
                        end += 1
                    if depth or "=" in re.sub(r"[<>=!]=", "", code[match.end():end]):
                        continue
                    inner = line[match.end():end - 1]
                    yield number, match.start(), line[match.start():end], "if (!(%s))" % inner
                elif '"' in line and old in (" + ", " - "):
                    continue  # texts put together
                elif new is None:
                    yield number, match.start(), old, str(int(old) + 1)
                else:
                    yield number, match.start(), old, new


def run(command, limit, **options):
    try:
        return subprocess.run(command, timeout=limit, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, **options).returncode
    except subprocess.TimeoutExpired:
        return "timeout"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("-n", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="sources whose path has this text")
    parser.add_argument("--tree", type=pathlib.Path, default=pathlib.Path("build-mutants"))
    options = parser.parse_args()
    root = pathlib.Path(__file__).resolve().parents[2]
    tree = options.tree.resolve()
    source, build = tree / "src", tree / "build"
    for name in subprocess.check_output(["git", "ls-files"], cwd=root, text=True).splitlines():
        # What did not change keeps its time, so that it is not built again.
        copy = source / name
        if not copy.exists() or copy.read_bytes() != (root / name).read_bytes():
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(root / name, copy)
    if not (build / "build.ninja").exists():
        subprocess.run(["cmake", "-S", source, "-B", build, "-G", "Ninja",
                        "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS=-O1"],
                       stdout=subprocess.DEVNULL, check=True)

    targets = {s: t for s, t in TARGETS.items() if options.only in s}
    tests = sorted({t for names in targets.values() for t in names})
    subprocess.run(["cmake", "--build", build, "--target", *["test_" + t for t in tests]],
                   stdout=subprocess.DEVNULL, check=True)
    seconds = {}
    for test in tests:
        begin = time.time()
        if run([build / "tests" / ("test_" + test)], 600, cwd=tree) != 0:
            sys.exit("error: test_%s fails without any mutation" % test)
        seconds[test] = time.time() - begin

    chosen = random.Random(options.seed)
    sources = sorted(targets)
    candidates = {s: list(places((root / s).read_text())) for s in sources}
    counts = {"killed": 0, "survived": 0, "does not compile": 0}
    for i in range(options.n):
        name = sources[i % len(sources)]  # every source gets its turn
        if not candidates[name]:
            continue
        number, column, old, new = candidates[name].pop(chosen.randrange(len(candidates[name])))
        text = (root / name).read_text()
        lines = text.splitlines(keepends=True)
        line = lines[number]
        lines[number] = line[:column] + new + line[column + len(old):]
        (source / name).write_text("".join(lines))
        verdict = "survived"
        for test in targets[name]:
            if run(["cmake", "--build", build, "--target", "test_" + test], 900) != 0:
                verdict = "does not compile"
                break
            if run([build / "tests" / ("test_" + test)], 20 + 10 * seconds[test], cwd=tree) != 0:
                verdict = "killed"
                break
        (source / name).write_text(text)
        counts[verdict] += 1
        print("%-16s %s:%d: %s" % (verdict, name, number + 1, line.strip()), flush=True)
        if verdict == "survived":
            print("%-16s   becomes: %s" % ("", lines[number].strip()), flush=True)
    print(", ".join("%d %s" % (n, verdict) for verdict, n in counts.items()))


if __name__ == "__main__":
    main()
