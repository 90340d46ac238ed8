#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What was learned is nearer to the simulated teacher's noise-free motion than what was
recorded; and a result that is not is found."""
import json
import os
import shutil
import unittest

import bounds
import sweep
from program import FolderTest


class TruthTest(FolderTest):
    def learn(self, task, name):
        if not os.path.exists(self.path(name)):
            self.must_run("learn", task, "-o", self.path(name), "--snapshots", "0")
        return self.path(name)

    def missed(self, task, result):
        teacher = os.path.join(os.path.dirname(task), "truth")
        return [row[:3] for row in bounds.truth_rows(task, result, teacher) if not row[3]]


class Taught(TruthTest):
    """Scenes other than those of the evaluation data."""

    def taught(self, name, seed):
        folder = self.path(f"{name}_{seed}")
        if not os.path.exists(folder):
            self.must_run("teach", name, "--seed", str(seed), "-o", folder)
        return os.path.join(folder, "task.xml")

    def test_nearer_to_the_truth(self):
        for name in sweep.TASKS:
            for seed in (21, 22):
                with self.subTest(name=name, seed=seed):
                    task = self.taught(name, seed)
                    result = self.learn(task, f"{name}_{seed}_result")
                    self.assertEqual(self.missed(task, result), [])

    def spoiled(self, change):
        """Names of the rows that a spoiled copy of a result misses."""
        task = self.taught("drawer", 21)
        result = self.learn(task, "drawer_21_result")
        copy = self.path("copy")
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(result, copy)
        change(copy)
        return {row[0] for row in self.missed(task, copy)}

    def test_finds_a_result_that_is_the_input(self):
        def forget(folder):
            shutil.rmtree(os.path.join(folder, "optimized"))
            shutil.copytree(os.path.join(folder, "iterations", "0"),
                            os.path.join(folder, "optimized"))

        # Interpolated tuples may be as the input.
        self.assertEqual(self.spoiled(forget), {"hand_m", "hand_rad", "object_m", "object_rad",
                                                "handle_m", "handle_rad"})

    def test_finds_tracks_moved_by_two_centimetres(self):
        for entity in ("hand", "object", "gripper"):
            def move(folder):
                for demo in os.listdir(os.path.join(folder, "optimized")):
                    path = os.path.join(folder, "optimized", demo, entity + ".tum")
                    with open(path, encoding="utf-8") as file:
                        lines = [line.split() for line in file if not line.startswith("#")]
                    for line in lines:
                        line[1] = repr(float(line[1]) + 0.02)
                    with open(path, "w", encoding="utf-8") as file:
                        file.writelines(" ".join(line) + "\n" for line in lines)

            with self.subTest(entity):
                rows = {"gripper": {"handle_m"}}.get(
                    entity, {entity + "_m", entity + "_interpolated_m"})
                self.assertEqual(self.spoiled(move), rows)

    def test_finds_residuals_that_are_not_those_of_the_weights(self):
        for factor in (0.4, 3):
            def scale(folder):
                path = os.path.join(folder, "metrics.json")
                with open(path, encoding="utf-8") as file:
                    metrics = json.load(file)
                metrics["e1_per_dof"] *= factor
                with open(path, "w", encoding="utf-8") as file:
                    json.dump(metrics, file)

            with self.subTest(factor):
                self.assertEqual(self.spoiled(scale), {"e1_per_dof"})


class SharedTasks(TruthTest):
    def test_nearer_to_the_truth(self):
        for name in sweep.TASKS:
            with self.subTest(name):
                task = self.data(f"tasks/{name}/task.xml")
                self.assertEqual(self.missed(task, self.learn(task, name)), [])


if __name__ == "__main__":
    unittest.main()
