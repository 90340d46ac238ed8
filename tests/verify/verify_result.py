#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Recomputes what `graft-lfd learn` says about a result from the files it wrote,
with readers and definitions of its own, and checks that the robot can do the
motion. Usage: verify_result.py TASK.xml RESULT [--graft-lfd PROGRAM]

Prints one line a check; exit code 1 if any disagrees."""
import argparse
import math
import os
import re
import subprocess
import sys

import files
import poses
from floor_map import FloorMap
from robot import Chain

MEAN_TOLERANCE = 1e-9  # of means and spreads, m and rad
SHARE_TOLERANCE = 1e-12
FK_DISTANCE = 1e-3  # joints.csv on base.tum against gripper.tum, m
FK_ANGLE = math.radians(0.1)
SPEED_FACTOR = 2.0  # of a joint's URDF limit ...
SPEED_SHARE = 0.99  # ... that this share of all steps must keep
ENTITIES = ("hand", "object", "torso", "gripper", "base")


class Report:
    def __init__(self, out=sys.stdout):
        self.out = out
        self.failures = []

    def check(self, good, name, text):
        if not good:
            self.failures.append(f"{name}: {text}")
        print(f"{'ok  ' if good else 'FAIL'} {name}: {text}", file=self.out)

    def skip(self, name, why):
        print(f"skip {name}: {why}", file=self.out)

    def equal(self, name, own, written, tolerance):
        if written is None or own is None:
            self.check(written is None and own is None, name, f"own {own}, written {written}")
        else:
            self.check(abs(own - written) <= tolerance, name,
                       f"own {own:.12g}, written {written:.12g}")


class Demonstration:
    """The five trajectories of one demonstration in a folder."""

    def __init__(self, folder, name, segment):
        self.name = name
        self.tracks = {}
        for entity in ENTITIES:
            self.stamps, self.tracks[entity] = files.read_track(
                os.path.join(folder, name, entity + ".tum"))
            first = self.tracks["hand"]
            if len(first) != len(self.tracks[entity]):
                raise ValueError(f"{name}: {entity}.tum and hand.tum differ in length")
        self.grasp = self.stamps.index(segment[0])
        self.release = self.stamps.index(segment[1])

    def seen_from_object(self, entity, i):
        return poses.compose(poses.inverse(self.tracks["object"][i]), self.tracks[entity][i])


def table(demos, grasps, floor_map, metric, before):
    """Rows 1 to 7 of the paper's Table I, from trajectories."""
    rows = {}
    sigma_t, sigma_r = metric["sigma_t"], metric["sigma_r"]
    to_grasp = []
    for demo in demos:
        held = demo.seen_from_object("gripper", demo.grasp)

        def offset(grasp):
            return (poses.norm(poses.sub(held[0], grasp[2][0])), poses.angle(held[1], grasp[2][1]))

        nearest = min(grasps, key=lambda g: (offset(g)[0] / sigma_t) ** 2 +
                      (offset(g)[1] / sigma_r) ** 2)
        to_grasp.append(offset(nearest))
    rows["gripper_grasp_m"] = math.fsum(d for d, _ in to_grasp) / len(demos)
    rows["gripper_grasp_rad"] = math.fsum(a for _, a in to_grasp) / len(demos)
    for entity in ("gripper", "hand"):
        held = [demo.seen_from_object(entity, i) for demo in demos
                for i in range(demo.grasp, demo.release + 1)]
        rows[entity + "_object_sd_m"], rows[entity + "_object_sd_rad"] = poses.spread(held)
    pairs = [pair for demo in demos for pair in zip(demo.tracks["gripper"], demo.tracks["hand"])]
    if before:
        rows["gripper_hand_m"] = rows["gripper_hand_rad"] = None
    else:
        rows["gripper_hand_m"] = math.fsum(
            poses.norm(poses.sub(g[0], h[0])) for g, h in pairs) / len(pairs)
        rows["gripper_hand_rad"] = math.fsum(poses.angle(g[1], h[1]) for g, h in pairs) / len(pairs)
    rows["map_collision_free"] = None
    if floor_map:
        bases = [base for demo in demos for base in demo.tracks["base"]]
        free = sum(not floor_map.collides(b[0][0], b[0][1], poses.heading(b[1])) for b in bases)
        rows["map_collision_free"] = free / len(bases)
    return rows


def check_table(report, column, own, written):
    for name, value in own.items():
        tolerance = SHARE_TOLERANCE if name == "map_collision_free" else MEAN_TOLERANCE
        report.equal(f"table1.{column}.{name}", value, written[name], tolerance)


def check_robot(report, task, demos, folder, written):
    """Arm configurations: kinematics, limits, speeds, and the share that has one."""
    chain = Chain(task.urdf, task.base_link, task.tip_link, task.tool)
    tuples = solved = steps = fast = 0
    worst = {"distance": (0, ""), "angle": (0, ""), "limit": (-math.inf, "")}

    def worse(kind, value, where):
        worst[kind] = max(worst[kind], (value, where))

    for demo in demos:
        stamps, names, rows = files.read_joints(os.path.join(folder, demo.name, "joints.csv"))
        report.check(names == chain.names, f"{demo.name} joints", ", ".join(names))
        report.check(stamps == demo.stamps, f"{demo.name} stamps",
                     "joints.csv has those of the tracks")
        for i, row in enumerate(rows):
            tuples += 1
            if row is None:
                continue
            solved += 1
            where = f"{demo.name} at {stamps[i]!r}"
            values = dict(zip(names, row))
            gripper = poses.compose(demo.tracks["base"][i], chain.forward(values))
            wanted = demo.tracks["gripper"][i]
            worse("distance", poses.norm(poses.sub(gripper[0], wanted[0])), where)
            worse("angle", poses.angle(gripper[1], wanted[1]), where)
            for name, value in values.items():
                lower, upper, _ = chain.limits[name]
                worse("limit", max(lower - value, value - upper), f"{name}, {where}")
            if i == 0 or rows[i - 1] is None:
                continue
            steps += 1
            for name, now, last in zip(names, row, rows[i - 1]):
                way = now - last
                if name in chain.continuous:
                    way = math.remainder(way, 2 * math.pi)
                allowed = SPEED_FACTOR * chain.limits[name][2] * (stamps[i] - stamps[i - 1])
                if abs(way) > allowed * (1 + 1e-6):
                    fast += 1
                    break
    value, where = worst["distance"]
    report.check(value <= FK_DISTANCE, "forward kinematics, distance",
                 f"at most {1e3 * value:.3g} mm ({where})")
    value, where = worst["angle"]
    report.check(value <= FK_ANGLE, "forward kinematics, angle",
                 f"at most {math.degrees(value):.3g} degrees ({where})")
    value, where = worst["limit"]
    report.check(value <= 1e-9, "joint limits", f"at most {value:.3g} beyond ({where})")
    report.check(fast <= (1 - SPEED_SHARE) * steps, "joint speeds",
                 f"{fast} of {steps} steps need more than {SPEED_FACTOR} x the limit")
    report.equal("table1.after.ik_achievable", solved / tuples, written["ik_achievable"],
                 SHARE_TOLERANCE)


def check_observations(report, folder, demos, written):
    """e1_per_dof from the E1 edges of graph.g2o: an edge belongs to the hand or
    object whose optimized pose its vertex has."""
    entity_of = {}
    vertices = {}
    for demo in demos:
        for entity in ("hand", "object"):
            for pose in demo.tracks[entity]:
                entity_of[tuple(round(v, 9) for v in pose[0])] = pose
    total = count = 0
    with open(os.path.join(folder, "graph_optimized.g2o"), encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if words and words[0] == "VERTEX_SE3:QUAT":
                vertices[words[1]] = [float(w) for w in words[2:]]
    with open(os.path.join(folder, "graph.g2o"), encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if not words or words[0] != "LFD_OBSERVATION":
                continue
            key = tuple(round(v, 9) for v in vertices[words[1]][:3])
            if key not in entity_of:
                continue  # a torso's
            estimate = entity_of[key]
            numbers = [float(w) for w in words[2:]]
            observed, information = files.pose_of(numbers[:7]), numbers[7:]
            t = poses.norm(poses.sub(estimate[0], observed[0]))
            r = poses.angle(estimate[1], observed[1])
            total += information[0] * t ** 2 + information[15] * r ** 2
            count += 6
    own = total / count if count else 0
    report.equal("e1_per_dof", own, written["e1_per_dof"], 1e-9 * max(1, own))


def said_to_be_dropped(messages, demo):
    """How many poses of each track of a demonstration the program says it dropped."""
    text = " ".join(m for m in messages if f" {demo}: " in m)
    return {entity: int(n) for entity, n in re.findall(r"(\w+): (\d+) of \d+ poses dropped", text)}


def dropped_before(raw, start, said):
    """How many poses a track lost to begin at `start`, no more than it is said to have
    lost; None if none begins there."""
    counts = [stamps.index(start) for entity, (stamps, _) in raw.items()
              if start in stamps and stamps.index(start) <= said.get(entity, 0)]
    return min(counts, default=None)


def check_matching(report, task, demos, messages):
    """The matched input (iterations/0) against the recorded tracks: the stamps
    are the union within the common span; recorded poses stay, but for dropped
    outliers; between them poses are interpolated."""
    dropped = recorded = 0
    largest = 0.0
    for demo in demos:
        raw = {entity: task.raw_track(demo.name, entity)
               for entity in task.demonstrations[demo.name]}
        first = max(stamps[0] for stamps, _ in raw.values())
        last = min(stamps[-1] for stamps, _ in raw.values())
        said = said_to_be_dropped(messages, demo.name)
        if first < demo.stamps[0] and (lost := dropped_before(raw, demo.stamps[0], said)):
            first = demo.stamps[0]
            dropped += lost
        back = {entity: (stamps[::-1], track) for entity, (stamps, track) in raw.items()}
        if last > demo.stamps[-1] and (lost := dropped_before(back, demo.stamps[-1], said)):
            last = demo.stamps[-1]
            dropped += lost
        union = sorted({t for stamps, _ in raw.values() for t in stamps if first <= t <= last})
        report.check(union == demo.stamps, f"{demo.name} matching",
                     f"{len(union)} stamps in the union, {len(demo.stamps)} written")
        if union != demo.stamps:
            continue
        for entity, (stamps, track) in raw.items():
            matched = dict(zip(demo.stamps, demo.tracks[entity]))
            kept = []
            for t, pose in zip(stamps, track):
                if t in matched:
                    recorded += 1
                    off = poses.norm(poses.sub(matched[t][0], pose[0]))
                    if off + poses.angle(matched[t][1], pose[1]) > 1e-9:
                        dropped += 1
                        continue
                kept.append((t, pose))
            at = 0
            for t in demo.stamps:
                while at + 2 < len(kept) and kept[at + 1][0] <= t:
                    at += 1
                (t0, a), (t1, b) = kept[at], kept[at + 1]
                if not t0 <= t <= t1:
                    continue
                own = poses.between(a, b, (t - t0) / (t1 - t0))
                largest = max(largest, poses.norm(poses.sub(own[0], matched[t][0])),
                              poses.angle(own[1], matched[t][1]))
    report.check(largest <= 1e-8, "matching, poses", f"differ by at most {largest:.3g}")
    report.check(dropped <= 0.05 * recorded, "matching, outliers",
                 f"{dropped} of {recorded} recorded poses were replaced")


def check_reach(report, program, folder, demos, written):
    """Row 8: the map's answer for some tuples. The map itself is checked by joints.csv:
    where the arm has a solution, the base is in reach."""
    name = "table1.after.kinematically_achievable"
    if not program:
        report.skip(name, "needs --graft-lfd to ask the reachability map")
        return
    if written["kinematically_achievable"] != 1:
        report.skip(name, f"{written['kinematically_achievable']} cannot be told from a sample")
        return
    everything = [(demo, i) for demo in demos for i in range(len(demo.stamps))]
    sample = everything[::max(1, len(everything) // 40)]
    missing = []
    for demo, i in sample:
        gripper, base = demo.tracks["gripper"][i], demo.tracks["base"][i]
        answer = subprocess.run(
            [program, "reach", "query", os.path.join(folder, "resources", "reach.map"),
             "--gripper", " ".join(repr(v) for v in (*gripper[0], *gripper[1])),
             "--base", f"{base[0][0]!r} {base[0][1]!r} {poses.heading(base[1])!r}"],
            capture_output=True, text=True, check=False).stdout
        if "reachable: yes" not in answer:
            missing.append(f"{demo.name} at {demo.stamps[i]!r}")
    report.check(not missing, name, f"{len(sample)} tuples asked, not in reach: {missing}")


def verify(task_path, folder, program=None, out=sys.stdout):
    """All checks; returns the report."""
    report = Report(out)
    task = files.Task(task_path)
    metrics = files.read_json(os.path.join(folder, "metrics.json"))
    segments = files.read_segments(os.path.join(folder, "segments.csv"))
    grasps = files.read_grasps(task.grasps, task.min_quality)
    floor_map = FloorMap(task.map, task.footprint) if task.map else None
    metric = metrics["weights"]["grasp_quality"]
    report.check(list(segments) == list(task.demonstrations), "demonstrations",
                 ", ".join(segments))

    def demonstrations(place):
        return [Demonstration(os.path.join(folder, place), name, segment)
                for name, segment in segments.items()]

    after = demonstrations("optimized")
    report.equal("tuples", sum(len(demo.stamps) for demo in after), metrics["tuples"], 0)
    floor = all(b[0][2] == 0 and b[1][0] == b[1][1] == 0
                for demo in after for b in demo.tracks["base"])
    report.check(floor, "bases", "upright on the floor")
    check_table(report, "after", table(after, grasps, floor_map, metric, False),
                metrics["table1"]["after"])
    check_robot(report, task, after, os.path.join(folder, "optimized"), metrics["table1"]["after"])
    check_reach(report, program, folder, after, metrics["table1"]["after"])
    check_observations(report, folder, after, metrics)
    if os.path.isdir(os.path.join(folder, "iterations", "0")):
        before = demonstrations(os.path.join("iterations", "0"))
        check_matching(report, task, before, metrics["messages"])
        check_table(report, "before", table(before, grasps, floor_map, metric, True),
                    metrics["table1"]["before"])
    else:
        report.skip("table1.before", "there are no iterations/0")
    return report


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("task")
    parser.add_argument("result")
    parser.add_argument("--graft-lfd")
    options = parser.parse_args()
    report = verify(options.task, options.result, options.graft_lfd)
    print(f"{len(report.failures)} checks failed")
    return 1 if report.failures else 0


if __name__ == "__main__":
    sys.exit(main())
