#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Where a scene stands changes nothing but the frame: tracks and map moved and
turned on the floor give the same result, moved and turned."""
import os
import unittest

import files
import poses
import variants
from program import FolderTest
from verify_result import ENTITIES

# Coordinates of some metres carry rounding of 1e-15; the optimizer adds little.
POSE_TOLERANCE = 1e-9
# The arm stops within a tolerance of the pose, so its joints keep rounding that
# their iteration multiplied: 1e-8 as a rule, 1e-5 met beside a singularity.
JOINT_TOLERANCE = 1e-4
MOTION = variants.floor_motion(3.7, -11.3, 2.1)


def flat(value, path=""):
    """{path: leaf} of a JSON value."""
    if isinstance(value, dict):
        parts = value.items()
    elif isinstance(value, list):
        parts = enumerate(value)
    else:
        return {path: value}
    return {k: v for key, part in parts for k, v in flat(part, f"{path}/{key}").items()}


def track_difference(still, moved, motion):
    """Largest distance or angle between the poses of two result folders, the
    second brought back to where the first stands."""
    back = poses.inverse(motion)
    largest = (0.0, "")
    for demo in files.read_segments(os.path.join(still, "segments.csv")):
        for entity in ENTITIES:
            name = os.path.join("optimized", demo, entity + ".tum")
            stamps, track = files.read_track(os.path.join(still, name))
            other_stamps, other = files.read_track(os.path.join(moved, name))
            if stamps != other_stamps:
                return (float("inf"), f"stamps of {name}")
            for t, a, b in zip(stamps, track, other):
                b = poses.compose(back, b)
                apart = max(poses.norm(poses.sub(a[0], b[0])), poses.angle(a[1], b[1]))
                largest = max(largest, (apart, f"{name} at {t!r}"))
    return largest


class Invariance(FolderTest):
    def learn_both(self, task, name):
        """Learns as recorded, at full precision, and moved; returns the folders."""
        results = []
        for kind, motion in (("still", None), ("moved", MOTION)):
            folder = self.path(f"{name}-{kind}")
            path = variants.write_variant(task, folder, motion=motion)
            self.must_run("learn", path, "-o", folder + "/result")
            results.append(folder + "/result")
        return results

    def expect_same(self, task, name):
        still, moved = self.learn_both(task, name)
        segments = [files.read_segments(f + "/segments.csv") for f in (still, moved)]
        self.assertEqual(*segments)
        apart, where = track_difference(still, moved, MOTION)
        self.assertLessEqual(apart, POSE_TOLERANCE, where)
        self.expect_same_joints(still, moved, segments[0])
        self.expect_same_numbers(still, moved, "grasp.json", lambda key: "covariance" in key)
        # What a model holds is seen from the object; only that stands elsewhere.
        self.expect_same_numbers(still, moved, "model.json", lambda key: "world_T_object" in key)
        tables = [files.read_json(f + "/metrics.json")["table1"] for f in (still, moved)]
        for key, value in flat(tables[0]).items():
            other = flat(tables[1])[key]
            if value is None or "achievable" in key or "collision" in key:
                self.assertEqual(value, other, key)
            else:
                self.assertAlmostEqual(value, other, delta=1e-9, msg=key)
        # The comparison itself sees a micrometre.
        off = variants.floor_motion(3.7 + 1e-6, -11.3, 2.1)
        self.assertGreater(track_difference(still, moved, off)[0], 1e-7)

    def expect_same_joints(self, still, moved, segments):
        for demo in segments:
            name = f"/optimized/{demo}/joints.csv"
            rows = [files.read_joints(f + name)[2] for f in (still, moved)]
            for i, (a, b) in enumerate(zip(*rows)):
                self.assertEqual(a is None, b is None, f"{demo}, tuple {i}")
                if a is not None:
                    apart = max(abs(x - y) for x, y in zip(a, b))
                    self.assertLessEqual(apart, JOINT_TOLERANCE, f"{demo}, tuple {i}")

    def expect_same_numbers(self, still, moved, name, left_out):
        a, b = (flat(files.read_json(os.path.join(f, name))) for f in (still, moved))
        self.assertEqual(list(a), list(b))
        for key, value in a.items():
            if left_out(key):
                continue
            if isinstance(value, float):
                self.assertAlmostEqual(value, b[key], delta=1e-7 * max(1, abs(value)),
                                       msg=f"{name} {key}")
            else:
                self.assertEqual(value, b[key], f"{name} {key}")


class TaughtRoomDoor(Invariance):
    def test_moving_the_scene_moves_the_result(self):
        self.must_run("teach", "room_door", "--seed", "2", "-o", self.path("task"))
        self.expect_same(self.path("task", "task.xml"), "room_door")


class SharedTasks(Invariance):
    def test_all(self):
        for name in ("room_door", "swivel_door", "drawer", "sliding_door", "mocap_suitcase"):
            with self.subTest(name):
                self.expect_same(self.data(f"tasks/{name}/task.xml"), name)


if __name__ == "__main__":
    unittest.main()
