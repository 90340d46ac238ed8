#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""With an SRDF no arm configuration of a result has links in each other, by solids and
nearest points of their own (projections in turn) and kinematics from the URDF."""
import os
import shutil
import unittest
import xml.etree.ElementTree as ElementTree

import bounds
import files
import poses
from program import FolderTest
from robot import Chain, numbers


class Solid:
    def __init__(self, element):
        origin = element.find("origin")
        self.link_T_solid = (numbers(origin.get("xyz"), (0.0, 0.0, 0.0)),
                             poses.from_rpy(*numbers(origin.get("rpy"), (0.0, 0.0, 0.0))))
        shape = element.find("geometry")[0]
        self.kind = shape.tag
        if self.kind == "box":
            self.half = tuple(v / 2 for v in numbers(shape.get("size"), None))
        else:
            self.half = (float(shape.get("radius")), float(shape.get("length")) / 2)
        self.bound = poses.norm(self.half)

    def nearest(self, pose, point):
        """The point of the solid, placed at `pose`, nearest to a point."""
        x, y, z = poses.turn(poses.conjugate(pose[1]), poses.sub(point, pose[0]))
        if self.kind == "box":
            local = tuple(min(max(v, -h), h) for v, h in zip((x, y, z), self.half))
        else:
            across = max(poses.norm((x, y)), 1e-12)
            shrink = min(1.0, self.half[0] / across)
            local = (x * shrink, y * shrink, min(max(z, -self.half[1]), self.half[1]))
        return poses.add(pose[0], poses.turn(pose[1], local))


def distance(a, pose_a, b, pose_b):
    point = pose_a[0]
    for _ in range(200):
        other = b.nearest(pose_b, point)
        point = a.nearest(pose_a, other)
    return poses.norm(poses.sub(point, other))


class Robot:
    """Links of a serial robot with their solids, in order from the base."""

    def __init__(self, task):
        root = ElementTree.parse(task.urdf).getroot()
        self.solids = {link.get("name"): Solid(link.find("collision"))
                       for link in root.findall("link") if link.find("collision") is not None}
        self.links = list(self.solids)
        self.chains = {link: Chain(task.urdf, task.base_link, link) for link in self.links}

    def tested(self):
        """Pairs of links with at least two others between them."""
        return [(a, b) for i, a in enumerate(self.links) for b in self.links[i + 3:]]

    def least_gap(self, values):
        place = {}
        for link in self.links:
            place[link] = poses.compose(self.chains[link].forward(values),
                                        self.solids[link].link_T_solid)
        least = 1.0
        for a, b in self.tested():
            apart = poses.norm(poses.sub(place[a][0], place[b][0]))
            if apart < self.solids[a].bound + self.solids[b].bound + 0.01:
                least = min(least, distance(self.solids[a], place[a], self.solids[b], place[b]))
        return least


class Taught(FolderTest):
    def setUp(self):
        if not os.path.exists(self.path("task")):
            self.must_run("teach", "swivel_door", "--seed", "4", "-o", self.path("task"))
        self.task = files.Task(self.path("task", "task.xml"))
        self.robot = Robot(self.task)

    def write_srdf_task(self):
        """A copy whose SRDF disables neighbours and links one apart."""
        links, tested = self.robot.links, set(self.robot.tested())
        lines = [f'  <disable_collisions link1="{a}" link2="{b}" reason="Adjacent"/>'
                 for i, a in enumerate(links) for b in links[i + 1:] if (a, b) not in tested]
        shutil.copytree(self.path("task"), self.path("guarded"))
        with open(self.path("guarded", "robot.srdf"), "w", encoding="utf-8") as file:
            file.write('<robot name="teacher_robot">\n' + "\n".join(lines) + "\n</robot>\n")
        path = self.path("guarded", "task.xml")
        tree = ElementTree.parse(path)
        tree.getroot().find("robot").set("srdf", "robot.srdf")
        tree.write(path)
        return path

    def test_no_configuration_hits_the_robot(self):
        task, result = self.write_srdf_task(), self.path("result")
        self.must_run("learn", task, "-o", result, "--snapshots", "0")
        self.assertTrue(os.path.exists(os.path.join(result, "resources", "robot.srdf")))
        self.assertEqual([row for row in bounds.rows(task, result, "swivel_door") if not row[3]], [])
        tested = 0
        for demo in self.task.demonstrations:
            _, names, rows = files.read_joints(
                os.path.join(result, "optimized", demo, "joints.csv"))
            for values in rows[::5]:
                self.assertGreater(self.robot.least_gap(dict(zip(names, values))), 1e-6, demo)
                tested += 1
        self.assertGreater(tested, 50)
        self.must_run("evaluate", result)

    def test_finds_an_arm_in_the_body(self):
        chain = Chain(self.task.urdf, self.task.base_link, self.task.tip_link)
        folded = dict.fromkeys(chain.names, 0.0)
        folded.update(shoulder_pan_joint=-2.2, shoulder_lift_joint=1.0, elbow_flex_joint=-2.25,
                      upper_arm_roll_joint=-1.5, wrist_flex_joint=-0.05)
        gaps = [self.robot.least_gap({**folded, "shoulder_pan_joint": pan,
                                      "upper_arm_roll_joint": roll})
                for pan in (-2.2, -1, 0, 0.7) for roll in (-3, -1.5, 0, 0.7)]
        self.assertLess(min(gaps), 1e-6)
        self.assertGreater(max(gaps), 0.01)


if __name__ == "__main__":
    unittest.main()
