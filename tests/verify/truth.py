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
