# SPDX-License-Identifier: BSD-3-Clause
"""Errors of a result against the simulated teacher's noise-free tracks."""
import bisect
import math
import os

import files
import poses


def interpolated(stamps, track, t):
    k = min(max(bisect.bisect_right(stamps, t) - 1, 0), len(stamps) - 2)
    f = (t - stamps[k]) / (stamps[k + 1] - stamps[k])
    return poses.between(track[k], track[k + 1], min(max(f, 0.0), 1.0))


def errors(folder, truth):
    """RMS distance (m) of hand and object from the truth over the true manipulation,
    and the largest error of a grasp time (s)."""
    segments = files.read_segments(os.path.join(folder, "segments.csv"))
    true_segments = files.read_segments(os.path.join(truth, "segments.csv"))
    squares = {"hand": [], "object": []}
    late = 0.0
    for demo, (grasp, _) in segments.items():
        begin, end = true_segments[demo]
        late = max(late, abs(grasp - begin))
        for entity, sums in squares.items():
            true = files.read_track(os.path.join(truth, f"{demo}_{entity}.tum"))
            stamps, track = files.read_track(
                os.path.join(folder, "optimized", demo, entity + ".tum"))
            sums += [poses.norm(poses.sub(pose[0], interpolated(*true, t)[0])) ** 2
                     for t, pose in zip(stamps, track) if begin <= t <= end]
    rms = {entity: math.sqrt(math.fsum(s) / len(s)) for entity, s in squares.items()}
    return {"truth_hand_m": rms["hand"], "truth_object_m": rms["object"], "grasp_time_s": late}


class Errors:
    """Root mean square distance (m) and angle (rad) of pairs of poses."""

    def __init__(self):
        self.distances, self.angles = [], []

    def add(self, a, b):
        self.distances.append(poses.norm(poses.sub(a[0], b[0])))
        self.angles.append(poses.angle(a[1], b[1]))

    def rms(self):
        return [math.sqrt(math.fsum(e * e for e in values) / len(values))
                for values in (self.distances, self.angles)]


def chosen_grasp(task, folder):
    """object_T_gripper of the row of grasps.csv that grasp.json names."""
    chosen = files.read_json(os.path.join(folder, "grasp.json"))
    for row, flipped, pose in files.read_grasps(task.grasps, task.min_quality):
        if (row, flipped) == (chosen["grasp_row"], chosen["flipped"]):
            return pose
    raise ValueError(f"{folder}: grasp.json names no valid grasp")


def shares(task, folder, truth):
    """{row: error against the truth as a share of the matched input's (iterations/0)},
    RMS over the true manipulation of all demonstrations: `hand`, `object`; the same at
    interpolated tuples only; `handle`, the gripper against the chosen grasp on the true
    object, as a share of that grasp on the recorded one. Each in _m and _rad."""
    true_segments = files.read_segments(os.path.join(truth, "segments.csv"))
    grasp = chosen_grasp(task, folder)
    before, after = {}, {}

    def note(row, truth_pose, matched, estimate):
        before.setdefault(row, Errors()).add(truth_pose, matched)
        after.setdefault(row, Errors()).add(truth_pose, estimate)

    for demo, (begin, end) in true_segments.items():
        def track(*names):
            return files.read_track(os.path.join(folder, *names))

        for entity in ("hand", "object"):
            true = files.read_track(os.path.join(truth, f"{demo}_{entity}.tum"))
            recorded = set(task.raw_track(demo, entity)[0])
            stamps, estimates = track("optimized", demo, entity + ".tum")
            _, matched = track("iterations", "0", demo, entity + ".tum")
            _, grippers = track("optimized", demo, "gripper.tum")
            for t, raw, estimate, gripper in zip(stamps, matched, estimates, grippers):
                if not begin <= t <= end:
                    continue
                pose = interpolated(*true, t)
                note(entity, pose, raw, estimate)
                if t not in recorded:
                    note(entity + "_interpolated", pose, raw, estimate)
                if entity == "object":
                    note("handle", poses.compose(pose, grasp), poses.compose(raw, grasp), gripper)
    result = {}
    for row in before:
        (m0, r0), (m1, r1) = before[row].rms(), after[row].rms()
        result[row + "_m"], result[row + "_rad"] = m1 / m0, r1 / r0
    return result
