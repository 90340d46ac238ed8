# SPDX-License-Identifier: BSD-3-Clause
"""Copies of a task folder with something changed: the scene moved, samples lost,
demonstrations left out, torso tracks left out, another robot."""
import math
import os
import random
import re
import shutil
import xml.etree.ElementTree as ElementTree

import files
import poses


def write_track(path, stamps, track):
    with open(path, "w", encoding="utf-8") as file:
        for t, (place, turn) in zip(stamps, track):
            file.write(" ".join(repr(v) for v in (t, *place, *turn)) + "\n")


def floor_motion(x, y, yaw):
    return ((x, y, 0.0), poses.about_axis((0, 0, 1), yaw))


def write_variant(source, folder, change_track=None, change_xml=None, motion=None,
                  urdf=None):
    """Writes a self-contained copy of the task folder of `source` (a task.xml).

    change_track(demo, entity, stamps, poses) -> stamps, poses; change_xml(root);
    motion: new_T_old of the fixed frame, upright on the floor; urdf: of another robot,
    which becomes robot.urdf. Returns the path of the new task.xml."""
    task = files.Task(source)
    os.makedirs(folder)
    tree = ElementTree.parse(source)
    root = tree.getroot()
    shutil.copy(urdf or task.urdf, os.path.join(folder, "robot.urdf"))
    root.find("robot").set("urdf", "robot.urdf")
    shutil.copy(task.grasps, os.path.join(folder, "grasps.csv"))
    root.find("grasps").set("file", "grasps.csv")
    if task.map:
        copy_map(task.map, folder, motion)
        root.find("map").set("file", "map.yaml")
    if change_xml:
        change_xml(root)
    for demo in root.findall("demonstration"):
        name = demo.get("name")
        os.makedirs(os.path.join(folder, name))
        for entity in ("hand", "object", "torso"):
            if not demo.get(entity):
                continue
            stamps, track = files.read_track(task.demonstrations[name][entity])
            if change_track:
                stamps, track = change_track(name, entity, stamps, track)
            if motion:
                track = [poses.compose(motion, pose) for pose in track]
            demo.set(entity, f"{name}/{entity}.tum")
            write_track(os.path.join(folder, name, entity + ".tum"), stamps, track)
    path = os.path.join(folder, "task.xml")
    tree.write(path, encoding="utf-8", xml_declaration=True)
    return path


def copy_map(yaml, folder, motion):
    with open(yaml, encoding="utf-8") as file:
        text = file.read()
    image = re.search(r"^image\s*:\s*(\S+)", text, re.M).group(1).strip("\"'")
    shutil.copy(os.path.join(os.path.dirname(yaml), image), folder)
    if motion:
        origin = re.search(r"^origin\s*:\s*\[(.*)\]", text, re.M)
        x, y, yaw = (float(v) for v in origin.group(1).split(","))
        moved = poses.compose(motion, floor_motion(x, y, yaw))
        turned = poses.heading(motion[1]) + yaw
        text = text.replace(origin.group(0), f"origin: [{moved[0][0]!r}, {moved[0][1]!r}, {turned!r}]")
    with open(os.path.join(folder, "map.yaml"), "w", encoding="utf-8") as file:
        file.write(text)


def losing(share, seed):
    """A change_track that drops a share of the samples of every track, each by its
    own luck; the first and last sample stay, so that the span does."""
    luck = random.Random(seed)

    def change(_demo, _entity, stamps, track):
        last = len(stamps) - 1
        kept = [i for i in range(len(stamps)) if i in (0, last) or luck.random() >= share]
        return [stamps[i] for i in kept], [track[i] for i in kept]

    return change


def keeping(names):
    """A change_xml that leaves out all demonstrations but these."""

    def change(root):
        for demo in root.findall("demonstration"):
            if demo.get("name") not in names:
                root.remove(demo)

    return change


def without_torso(root):
    """A change_xml: torsos were not recorded."""
    for demo in root.findall("demonstration"):
        demo.attrib.pop("torso", None)


def with_robot(urdf, base_link, tip_link, footprint, tool=None):
    """A change_xml that puts another robot in the place of the first."""

    def change(root):
        robot = root.find("robot")
        robot.attrib.clear()
        robot.set("urdf", urdf)
        robot.set("base_link", base_link)
        robot.set("tip_link", tip_link)
        robot.set("footprint", footprint)
        if tool:
            robot.set("tool", tool)

    return change


