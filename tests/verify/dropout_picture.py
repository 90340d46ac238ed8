# SPDX-License-Identifier: BSD-3-Clause
"""A small SVG: what is left of a task's rows as more samples are lost."""

import math

PANELS = (("hand_object_sd_m", 1e3, "hand on object, spread [mm]"),
          ("gripper_hand_m", 1e2, "gripper to hand [cm]"),
          ("truth_hand_m", 1e3, "hand to truth while held, RMS [mm]"),
          ("truth_object_m", 1e3, "object to truth while held, RMS [mm]"))
COLORS = {"room_door": "#1b6ca8", "swivel_door": "#c0392b", "drawer": "#2e8b57",
          "sliding_door": "#8e5ba6"}
WIDTH, HEIGHT, LEFT, TOP = 340, 240, 56, 40


def round_step(least):
    """The smallest of 1, 2, 2.5, 5 times a power of ten that is not below."""
    power = 10 ** math.floor(math.log10(least))
    return next(f * power for f in (1, 2, 2.5, 5, 10) if f * power >= least)


def panel(column, row, name, factor, title, lines):
    """One chart; x is the share of samples lost in percent."""
    series = {}
    for line in lines:
        if line["kind"] == "dropout" and name in line["rows"]:
            x = float(line["case"].split("%")[0])
            series.setdefault(line["task"], []).append((x, factor * line["rows"][name]))
    if not series:
        return []
    step = round_step(max(y for points in series.values() for _, y in points) / 3.6 or 1)
    top = 4 * step
    right = max(x for points in series.values() for x, _ in points) or 1
    wide, high = WIDTH - LEFT - 16, HEIGHT - TOP - 40

    def place(x, y):
        return (column * WIDTH + LEFT + wide * x / right,
                row * HEIGHT + TOP + high * (1 - y / top))

    out = [f'<text x="{place(0, 0)[0]:.0f}" y="{row * HEIGHT + TOP - 14}" '
           f'font-weight="bold">{title}</text>']
    for k in range(5):
        x0, y = place(0, top * k / 4)
        x1, _ = place(right, 0)
        out.append(f'<path d="M{x0:.1f} {y:.1f}H{x1:.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{x0 - 6:.1f}" y="{y + 4:.1f}" text-anchor="end">'
                   f'{top * k / 4:.3g}</text>')
    for x in sorted({x for points in series.values() for x, _ in points}):
        px, py = place(x, 0)
        out.append(f'<text x="{px:.1f}" y="{py + 16:.1f}" text-anchor="middle">{x:.0f}</text>')
    px, py = place(right / 2, 0)
    out.append(f'<text x="{px:.1f}" y="{py + 32:.1f}" text-anchor="middle">samples lost [%]</text>')
    for task, points in series.items():
        places = [place(x, y) for x, y in sorted(points)]
        path = " ".join(f"{px:.1f},{py:.1f}" for px, py in places)
        color = COLORS[task]
        out.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="2"/>')
        out += [f'<circle cx="{px:.1f}" cy="{py:.1f}" r="3" fill="{color}"/>' for px, py in places]
    return out


def write(path, lines):
    out = []
    for i, (name, factor, title) in enumerate(PANELS):
        out += panel(i % 2, i // 2, name, factor, title, lines)
    for i, (task, color) in enumerate(COLORS.items()):
        x, y = LEFT + 150 * i, 2 * HEIGHT + 16
        out.append(f'<rect x="{x}" y="{y - 10}" width="12" height="12" fill="{color}"/>')
        out.append(f'<text x="{x + 18}" y="{y}">{task}</text>')
    with open(path, "w", encoding="utf-8") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="{2 * WIDTH}" '
                   f'height="{2 * HEIGHT + 30}" font-family="sans-serif" font-size="11">\n'
                   '<rect width="100%" height="100%" fill="white"/>\n' + "\n".join(out) +
                   "\n</svg>\n")
