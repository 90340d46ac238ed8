# SPDX-License-Identifier: BSD-3-Clause
"""What a learned result of the four tasks has to reach, whatever was left out of
the recording. m, degrees, shares."""
import math
import os

import files
import poses
import truth
from robot import Chain

# Spread of the hand on the object, per task (paper, Table I, "after").
HAND_SPREAD = {"room_door": (0.005, 4.6), "swivel_door": (0.0016, 0.9),
               "drawer": (0.0028, 0.3), "sliding_door": (0.0016, 0.6)}


def mean_grasp(folder):
    """Mean object_T_hand of the matched input over all manipulation tuples."""
    held = []
    for demo, (grasp, release) in files.read_segments(os.path.join(folder, "segments.csv")).items():
        place = os.path.join(folder, "iterations", "0", demo)
        stamps, hand = files.read_track(os.path.join(place, "hand.tum"))
        _, thing = files.read_track(os.path.join(place, "object.tum"))
        held += [poses.compose(poses.inverse(o), h)
                 for t, o, h in zip(stamps, thing, hand) if grasp <= t <= release]
    place = poses.scale(1 / len(held), tuple(math.fsum(p[0][k] for p in held) for k in range(3)))
    return (place, poses.mean_rotation([p[1] for p in held]))


def hand_to_grasp(task, folder, metric):
    """Distance and angle from the mean human grasp to the nearest valid grasp."""
    hand = mean_grasp(folder)

    def offset(pose):
        return (poses.norm(poses.sub(hand[0], pose[0])), poses.angle(hand[1], pose[1]))

    offsets = [offset(pose) for _, _, pose in files.read_grasps(task.grasps, task.min_quality)]
    return min(offsets, key=lambda o: (o[0] / metric["sigma_t"]) ** 2 +
               (o[1] / metric["sigma_r"]) ** 2)


def speed_share(task, folder):
    """Share of steps in which no joint needs more than twice its URDF velocity."""
    chain = Chain(task.urdf, task.base_link, task.tip_link, task.tool)
    steps = fast = 0
    for demo in files.read_segments(os.path.join(folder, "segments.csv")):
        stamps, names, rows = files.read_joints(
            os.path.join(folder, "optimized", demo, "joints.csv"))
        for i in range(1, len(rows)):
            if rows[i] is None or rows[i - 1] is None:
                continue
            steps += 1
            for name, now, last in zip(names, rows[i], rows[i - 1]):
                way = now - last
                if name in chain.continuous:
                    way = math.remainder(way, 2 * math.pi)
                allowed = 2 * chain.limits[name][2] * (stamps[i] - stamps[i - 1])
                if abs(way) > allowed * (1 + 1e-6):
                    fast += 1
                    break
    return 1 - fast / steps if steps else 0.0


def rows(task_path, folder, name):
    """[(row, value, bound, good)] of a result of the task called `name`."""
    task = files.Task(task_path)
    metrics = files.read_json(os.path.join(folder, "metrics.json"))
    after = metrics["table1"]["after"]
    near = hand_to_grasp(task, folder, metrics["weights"]["grasp_quality"])
    spread = HAND_SPREAD[name]
    most = [("gripper_grasp_m", after["gripper_grasp_m"], 0.003),
            ("gripper_grasp_deg", math.degrees(after["gripper_grasp_rad"]), 0.5),
            ("gripper_hand_m", after["gripper_hand_m"], near[0] + 0.005),
            ("gripper_hand_deg", math.degrees(after["gripper_hand_rad"]),
             math.degrees(near[1]) + 2),
            ("gripper_object_sd_m", after["gripper_object_sd_m"], 0.001),
            ("gripper_object_sd_deg", math.degrees(after["gripper_object_sd_rad"]), 0.2),
            ("hand_object_sd_m", after["hand_object_sd_m"], spread[0]),
            ("hand_object_sd_deg", math.degrees(after["hand_object_sd_rad"]), spread[1])]
    least = [("kinematically_achievable", after["kinematically_achievable"], 0.999),
             ("ik_achievable", after["ik_achievable"], 0.995),
             ("joint_speed", speed_share(task, folder), 0.99)]
    if after["map_collision_free"] is not None:
        least.append(("map_collision_free", after["map_collision_free"], 1.0))
    return ([(row, value, bound, value <= bound) for row, value, bound in most] +
            [(row, value, bound, value >= bound) for row, value, bound in least])


# Most of the matched input's error against the truth that may be left.
TRUTH_SHARE = {"hand_m": 0.5, "hand_rad": 0.5, "object_m": 0.8, "object_rad": 0.95,
               "hand_interpolated_m": 1, "hand_interpolated_rad": 1,
               "object_interpolated_m": 1, "object_interpolated_rad": 1,
               "handle_m": 0.8, "handle_rad": 1}
E1_PER_DOF = (0.3, 2)  # weighted squared E1 residual per degree of freedom


def truth_rows(task_path, folder, teacher):
    """[(row, value, bound, good)] of a result of a simulated teacher's recordings, whose
    noise-free tracks lie in the folder `teacher`."""
    left = truth.shares(files.Task(task_path), folder, teacher)
    residual = files.read_json(os.path.join(folder, "metrics.json"))["e1_per_dof"]
    return ([(row, left[row], bound, left[row] <= bound) for row, bound in TRUTH_SHARE.items()] +
            [("e1_per_dof", residual, E1_PER_DOF, E1_PER_DOF[0] <= residual <= E1_PER_DOF[1])])
