# SPDX-License-Identifier: BSD-3-Clause
"""A map_server map and a footprint on it, by brute force: every occupied cell
near the base as a closed square against the closed polygon."""
import math
import os
import re


def read_pgm(path):
    """Width, height, maximum and values row by row from the top."""
    with open(path, "rb") as file:
        data = file.read()
    words, at = [], 0
    while len(words) < 4:
        match = re.compile(rb"(?:\s|#[^\n]*\n)*([^\s#]+)").match(data, at)
        words.append(match.group(1))
        at = match.end()
    magic, (width, height, top) = words[0], (int(w) for w in words[1:])
    if magic == b"P5":
        size = 1 if top < 256 else 2
        raw = data[at + 1:at + 1 + size * width * height]
        values = [int.from_bytes(raw[i:i + size], "big") for i in range(0, len(raw), size)]
    elif magic == b"P2":
        values = [int(w) for w in data[at:].split()]
    else:
        raise NotImplementedError(f"{path} is no pgm")
    if len(values) != width * height:
        raise ValueError(f"{path}: {len(values)} values, not {width} x {height}")
    return width, height, top, values


def sides(polygon):
    return zip(polygon, polygon[1:] + polygon[:1])


def inside(polygon, x, y):
    """Even-odd rule."""
    odd = False
    for (ax, ay), (bx, by) in sides(polygon):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            odd = not odd
    return odd


def meet(a, b, c, d):
    """Whether two closed segments share a point."""

    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    def on(p, q, r):
        return (min(p[0], q[0]) <= r[0] <= max(p[0], q[0]) and
                min(p[1], q[1]) <= r[1] <= max(p[1], q[1]))

    s = (side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b))
    if s[0] * s[1] < 0 and s[2] * s[3] < 0:
        return True
    pairs = ((s[0], a, b, c), (s[1], a, b, d), (s[2], c, d, a), (s[3], c, d, b))
    return any(value == 0 and on(p, q, r) for value, p, q, r in pairs)


def overlap(polygon, square):
    if any(inside(polygon, *corner) for corner in square):
        return True
    if any(inside(square, *corner) for corner in polygon):
        return True
    return any(meet(a, b, c, d) for a, b in sides(polygon) for c, d in sides(square))


class FloorMap:
    def __init__(self, yaml, footprint):
        with open(yaml, encoding="utf-8") as file:
            text = file.read()

        def value(key):
            return re.search(rf"^{key}\s*:\s*(.*?)\s*(#.*)?$", text, re.M).group(1)

        image = value("image").strip("\"'")
        self.resolution = float(value("resolution"))
        self.x, self.y, self.yaw = (float(w) for w in value("origin").strip("[] ").split(","))
        negate = value("negate").strip() not in ("0", "false")
        threshold = float(value("occupied_thresh"))
        self.width, self.height, top, values = read_pgm(
            os.path.join(os.path.dirname(yaml), image))
        self.footprint = footprint
        self.occupied = set()
        for i, v in enumerate(values):
            share = v / top if negate else (top - v) / top
            if share > threshold:
                self.occupied.add((i % self.width, self.height - 1 - i // self.width))

    def collides(self, x, y, yaw):
        """Whether the footprint of a base at this pose touches an occupied cell."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        corners = []
        for px, py in self.footprint:
            wx = x + math.cos(yaw) * px - math.sin(yaw) * py - self.x
            wy = y + math.sin(yaw) * px + math.cos(yaw) * py - self.y
            corners.append(((c * wx + s * wy) / self.resolution,
                            (c * wy - s * wx) / self.resolution))
        columns = [p[0] for p in corners]
        rows = [p[1] for p in corners]
        for column in range(math.floor(min(columns)) - 1, math.ceil(max(columns)) + 1):
            for row in range(math.floor(min(rows)) - 1, math.ceil(max(rows)) + 1):
                if (column, row) not in self.occupied:
                    continue
                square = [(column, row), (column + 1, row), (column + 1, row + 1),
                          (column, row + 1)]
                if overlap(corners, square):
                    return True
        return False
