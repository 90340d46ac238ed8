#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes the seeds that are not text: pictures, maps of reachability, a capability map,
models. Usage: seeds.py CORPUS_FOLDER"""
import json
import pathlib
import struct
import sys
import zlib


def png(depth, colour, rows):
    """A PNG of the given IHDR bit depth and colour type; `rows` hold bytes of pixels."""
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    width = len(rows[0]) * 8 // (depth * channels)
    header = struct.pack(">IIBBBBB", width, len(rows), depth, colour, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def reach_map(value):
    """A map of 2 x 2 x 1 x 3 x 1 x 4 nodes, all of one distance; the harness fills in
    size and checksum of the envelope."""
    nodes, cells, psi, rings = 4, 4, 4, 3
    packed = lambda byte, n: struct.pack("<QHH", 4 + n, 0, n) + bytes([byte]) * n
    count = nodes * psi * rings
    body = struct.pack("<QQQQddd", 1, 1, 64, count if value > 127 else 0, 0.9, 0.5, 0.5)
    body += struct.pack("<10i", 4, 0, 0, 0, 2, 2, 1, 1, 1, 0)
    for name in (b"robot", b"base", b"tip"):
        body += struct.pack("<I", len(name)) + name
    return bytes(32) + body + packed(value, count) + packed(7, cells * 4 * 3)


def capability_map():
    leaf = lambda shape: struct.pack("<B4dB", shape, 10, 20, 30, 1.5, 0)
    tree = struct.pack("<B4dB", 0, 0, 0, 0, 0, 0b10000001) + leaf(1) + leaf(2)
    return (b"# Octomap OcTree file\nid CapabilityOcTree\nsize 3\nres 0.1\ndata\n" + tree +
            b"\ngroup_name arm\nbase_name base\ntip_name tip\n")


def unit(size, index):
    return [float(i == index) for i in range(size)]


def model():
    axes = ["x", "y", "z"]
    names = (["t"] + ["gripper_" + a for a in axes] + ["gripper_r" + a for a in axes] +
             ["base_x", "base_y", "base_yaw"])
    segment = {
        "name": "reach", "duration": 2.0, "demonstrations": 1, "samples": 5,
        "gripper_frame": "object at the grasp",
        "base_frame": "floor below the object at the grasp", "heading_axis": "x",
        "orientation_chart": "rotation vector at the mean",
        "orientation_mean": [0.0, 0.0, 0.0, 1.0], "dimensions": names, "start": [0.0] * 9,
        "end": [0.0] * 9, "priors": [1.0], "means": [[0.5] + [0.0] * 9],
        "covariances": [[unit(10, i) for i in range(10)]],
        "selection": [{"components": 1, "log_likelihood": -1.5, "bic": 2, "aic": 3,
                       "iterations": 4, "converged": True}]}
    return json.dumps({"format": "graft motion model", "version": 1, "task": "door",
                       "segments": [segment]}, indent=1)


def mixture():
    labels = ["t", "x", "y", "z", "qx", "qy", "qz", "qw"] + ["x", "y", "z", "qx", "qy", "qz", "qw"]
    rows = ["%s 0 %d" % (label, 1 if label in ("t", "qw") else 0) for label in labels]
    rows = [row.replace("qw 0", "qw 1") for row in rows]
    text = '"Priors"\np 0.5 0.5\n"Mu"\n' + "\n".join(rows) + "\n"
    for k in (1, 2):
        text += '"Sigma%d"\n' % k
        text += "".join("s " + " ".join("%g" % (0.01 * x) for x in unit(15, i)) + "\n" for i in range(15))
    return text + '"Related_Object"\npose 0 0 0 0 0 0 1\ngrasp 0 0 0\nname door\n'


def plugin():
    """An ELF header and an empty table of sections."""
    ident = b"\x7fELF\x02\x01\x01" + bytes(9)
    return ident + struct.pack("<HHIQQQIHHHHHH", 3, 62, 1, 0, 0, 64, 0, 64, 0, 0, 64, 1, 0) + bytes(128)


SEEDS = {
    "image/grey.png": png(8, 0, [b"\x00\x80", b"\xff\xcd"]),
    "image/alpha.png": png(8, 6, [b"\x00\x80\x40\xff", b"\xff\xcd\x00\x00"]),
    "image/bits.png": png(1, 0, [b"\xaa", b"\x55"]),
    "reach/reachable.irm": reach_map(130),
    "reach/empty.irm": reach_map(0),
    "reach/map.cpm": capability_map(),
    "models/model.json": model().encode(),
    "models/mixture.txt": mixture().encode(),
    "plugin/header.so": plugin(),
    "plugin/metadata.txt": b"vertex VERTEX_SE2\nedge EDGE_SE2\nloader toro\n",
}

if __name__ == "__main__":
    for name, data in SEEDS.items():
        path = pathlib.Path(sys.argv[1]) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
