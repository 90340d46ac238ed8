#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""`graft-lfd learn --tune`: a grid of weights, its best trade-offs, a picture."""
import unittest
import xml.etree.ElementTree as ElementTree

import files
from program import FolderTest


class Tuning(FolderTest):
    def goals(self, trial):
        """To be as small as possible."""
        table = trial["table1"]
        return (table["gripper_grasp_m"], table["gripper_hand_m"],
                -table["kinematically_achievable"])

    def test_grid_front_and_picture(self):
        self.must_run("teach", "drawer", "--seed", "4", "-o", self.path("task"))
        printed = self.must_run("learn", self.path("task", "task.xml"), "-o", self.path("out"),
                                "--tune").stdout
        self.assertIn("E6 times", printed)
        trials = files.read_json(self.path("out", "tune.json"))["trials"]
        pairs = {(t["grasp_quality"], t["reachability"]) for t in trials}
        self.assertEqual(len(pairs), len(trials))
        self.assertEqual(pairs, {(a, b) for a, _ in pairs for _, b in pairs})
        # The front by brute force.
        for trial in trials:
            mine = self.goals(trial)
            beaten = any(all(o <= m for o, m in zip(other, mine)) and other != mine
                         for other in map(self.goals, trials))
            self.assertEqual(trial["best"], not beaten, trial)
        # The task's own weights give the task's own gripper.
        own = next(t for t in trials if t["grasp_quality"] == t["reachability"] == 1)
        after = files.read_json(self.path("out", "metrics.json"))["table1"]["after"]
        for row in ("gripper_grasp_m", "gripper_hand_m", "hand_object_sd_rad"):
            self.assertEqual(own["table1"][row], after[row])
        # What weighs less is kept less.
        chain = sorted((t["grasp_quality"], t["table1"]["gripper_grasp_m"])
                       for t in trials if t["reachability"] == 1)
        self.assertEqual([d for _, d in chain], sorted((d for _, d in chain), reverse=True))
        picture = ElementTree.parse(self.path("out", "pictures", "tune.svg")).getroot()
        self.assertTrue(picture.tag.endswith("svg"))

        # A later run without it leaves no picture of other weights behind.
        self.must_run("learn", self.path("task", "task.xml"), "-o", self.path("out"))
        with self.assertRaises(FileNotFoundError):
            files.read_json(self.path("out", "tune.json"))


if __name__ == "__main__":
    unittest.main()
