# SPDX-License-Identifier: BSD-3-Clause
"""Readers of a task folder and of what `graft-lfd learn` writes, as their formats
are described; nothing here comes from graft."""
import csv
import json
import os
import xml.etree.ElementTree as ElementTree

import poses


def pose_of(numbers):
    return (tuple(numbers[:3]), poses.unit(numbers[3:7]))


def read_track(path):
    """Stamps and poses of a TUM file."""
    stamps, track = [], []
    with open(path, encoding="utf-8-sig") as file:
        for line in file:
            words = line.split()
            if not words or words[0].startswith("#"):
                continue
            numbers = [float(w) for w in words]
            if len(numbers) != 8:
                raise ValueError(f"{path}: a line has {len(numbers)} numbers, not 8")
            stamps.append(numbers[0])
            track.append(pose_of(numbers[1:]))
    return stamps, track


def read_grasps(path, min_quality):
    """(row, flipped, object_T_gripper) of all valid grasps, both ways round."""
    grasps = []
    with open(path, encoding="utf-8") as file:
        for row, line in enumerate(csv.DictReader(file)):
            if float(line["quality"]) < min_quality:
                continue
            names = ("x", "y", "z", "qx", "qy", "qz", "qw")
            pose = pose_of([float(line[k]) for k in names])
            grasps.append((row, False, pose))
            about_approach = ((0, 0, 0), (1.0, 0.0, 0.0, 0.0))
            grasps.append((row, True, poses.compose(pose, about_approach)))
    return grasps


def read_joints(path):
    """Stamps, joint names, and a list of values or None a row."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.reader(file))
    names = rows[0][1:]
    stamps, values = [], []
    for row in rows[1:]:
        stamps.append(float(row[0]))
        filled = [field != "" for field in row[1:]]
        if any(filled) != all(filled) or len(row) != 1 + len(names):
            raise ValueError(f"{path}: the row at {row[0]} is filled in part")
        values.append([float(field) for field in row[1:]] if all(filled) else None)
    return stamps, names, values


def read_segments(path):
    """{demo: (grasp_time, release_time)} in the order of the file."""
    with open(path, encoding="utf-8") as file:
        return {line["demo"]: (float(line["grasp_time"]), float(line["release_time"]))
                for line in csv.DictReader(file)}


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


class Task:
    """A task.xml; paths are absolute."""

    def __init__(self, path):
        folder = os.path.dirname(os.path.abspath(path))

        def absolute(name):
            return os.path.normpath(os.path.join(folder, name))

        root = ElementTree.parse(path).getroot()
        robot = root.find("robot")
        self.urdf = absolute(robot.get("urdf"))
        self.base_link = robot.get("base_link")
        self.tip_link = robot.get("tip_link")
        corners = [float(w) for w in robot.get("footprint").split()]
        self.footprint = list(zip(corners[0::2], corners[1::2]))
        tool = robot.get("tool")
        self.tool = pose_of([float(w) for w in tool.split()]) if tool else poses.IDENTITY
        self.grasps = absolute(root.find("grasps").get("file"))
        self.min_quality = float(root.find("grasps").get("min_quality", "0"))
        self.map = absolute(root.find("map").get("file")) if root.find("map") is not None else None
        self.demonstrations = {}
        self.offsets = {}
        for demo in root.findall("demonstration"):
            name = demo.get("name")
            self.demonstrations[name] = {
                entity: absolute(demo.get(entity))
                for entity in ("hand", "object", "torso") if demo.get(entity)}
            if demo.get("hand_offset"):
                self.offsets[name] = pose_of([float(w) for w in demo.get("hand_offset").split()])

    def raw_track(self, demo, entity):
        stamps, track = read_track(self.demonstrations[demo][entity])
        if entity == "hand" and demo in self.offsets:
            track = [poses.compose(pose, self.offsets[demo]) for pose in track]
        return stamps, track
