#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Table of line coverage per room, and the sources that are covered least, from gcovr's
JSON summary. Usage: rooms.py coverage.json"""
import collections
import json
import os
import sys

files = json.load(open(sys.argv[1]))["files"]
rooms = collections.defaultdict(lambda: [0, 0])
for entry in files:
    for room in (os.path.dirname(entry["filename"]), "all"):
        rooms[room][0] += entry["line_covered"]
        rooms[room][1] += entry["line_total"]
print("%-24s %8s %8s %7s" % ("room", "covered", "lines", "share"))
for room, (covered, total) in sorted(rooms.items(), key=lambda item: (item[0] == "all", item[0])):
    if total > 0:
        print("%-24s %8d %8d %6.1f%%" % (room, covered, total, 100 * covered / total))
print("\nleast covered, of at least 20 lines:")
for entry in sorted((f for f in files if f["line_total"] >= 20), key=lambda f: f["line_percent"])[:15]:
    print("%6.1f%%  %s" % (entry["line_percent"], entry["filename"]))
