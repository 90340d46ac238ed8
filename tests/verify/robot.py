# SPDX-License-Identifier: BSD-3-Clause
"""Forward kinematics and limits of a chain, straight from its URDF."""
import math
import xml.etree.ElementTree as ElementTree

import poses


def numbers(text, default):
    return tuple(float(w) for w in text.split()) if text else default


class Chain:
    def __init__(self, urdf, base_link, tip_link, tool=poses.IDENTITY):
        parents = {}
        for joint in ElementTree.parse(urdf).getroot().findall("joint"):
            parents[joint.find("child").get("link")] = joint
        path = []
        link = tip_link
        while link != base_link:
            if link not in parents:
                raise ValueError(f"{urdf}: no way from {base_link} to {tip_link}")
            path.insert(0, parents[link])
            link = parents[link].find("parent").get("link")
        self.tool = tool
        self.steps = []  # (parent_T_joint, kind, axis, name)
        self.limits = {}  # name: (lower, upper, velocity)
        for joint in path:
            origin = joint.find("origin")
            get = origin.get if origin is not None else (lambda key: None)
            place = (numbers(get("xyz"), (0.0, 0.0, 0.0)),
                     poses.from_rpy(*numbers(get("rpy"), (0.0, 0.0, 0.0))))
            axis = joint.find("axis")
            axis = numbers(axis.get("xyz") if axis is not None else None, (1.0, 0.0, 0.0))
            kind, name = joint.get("type"), joint.get("name")
            self.steps.append((place, kind, axis, name))
            if kind == "fixed":
                continue
            limit = joint.find("limit")
            bounds = (-math.inf, math.inf)
            if kind != "continuous":
                bounds = (float(limit.get("lower", 0)), float(limit.get("upper", 0)))
            velocity = float(limit.get("velocity", 0)) if limit is not None else 0
            self.limits[name] = (*bounds, velocity if velocity > 0 else math.inf)
        self.names = list(self.limits)
        self.continuous = {name for _, kind, _, name in self.steps if kind == "continuous"}

    def forward(self, values):
        """base_T_gripper for {joint name: value}."""
        pose = poses.IDENTITY
        for place, kind, axis, name in self.steps:
            pose = poses.compose(pose, place)
            if kind in ("revolute", "continuous"):
                pose = poses.compose(pose, ((0, 0, 0), poses.about_axis(axis, values[name])))
            elif kind == "prismatic":
                along = poses.scale(values[name] / poses.norm(axis), axis)
                pose = poses.compose(pose, (along, (0.0, 0.0, 0.0, 1.0)))
            elif kind != "fixed":
                raise ValueError(f"joint {name} is {kind}")
        return poses.compose(pose, self.tool)
