#!/usr/bin/env python3
"""Draws FOLDER/scale.json as FOLDER/scale.svg and scale.png: time and visits as scenes grow.

Usage: plot_scale.py FOLDER
"""

import json
import math
import sys
from pathlib import Path

from svg_chart import FAINT, GREY, INK, Drawing, LogScale

RAYS = {"camera": "#0b6e4f", "lidar": "#d9822b", "ao": "#2c5aa0", "incoherent": "#8e44ad"}
LEFT, TOP, WIDTH, HEIGHT, GAP = 64, 98, 320, 220, 66


def short(size):
    for unit, name in ((1 << 20, "Mi"), (1 << 10, "Ki")):
        if size >= unit and size % unit == 0:
            return f"{size // unit} {name}"
    for unit, name in ((10 ** 6, "M"), (10 ** 3, "k")):
        if size >= unit and size % unit == 0:
            return f"{size // unit} {name}"
    return str(size)


def panel(drawing, left, top, title, rows, field, fits, fitted):
    sizes = sorted({row["size"] for row in rows})
    x_of = LogScale(sizes[0], max(sizes[-1], sizes[0] * 2), left + 8, left + WIDTH - 8)
    timed = field == "ns_per_ray"
    most = max(row[field] for row in rows) * 1.08
    if timed:
        most = max(most, min(2 * most, max(row["embree_ns"] for row in rows) * 1.08))
    drawing.text(left + WIDTH / 2, top - 8, title, 12, "middle", INK, "bold")
    step = next(s for s in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000) if most / s <= 6)
    tick = 0
    while tick <= most:
        y = top + HEIGHT - tick / most * HEIGHT
        drawing.line(left, y, left + WIDTH, y, FAINT)
        drawing.text(left - 6, y + 4, f"{tick:g}", 10, "end", GREY)
        tick += step
    for size in sizes:
        drawing.text(x_of(size), top + HEIGHT + 15, short(size), 10, "middle", GREY)
    y_of = lambda value: top + HEIGHT - max(value, 0) / most * HEIGHT  # noqa: E731
    for rays in RAYS if timed else ():
        embree = sorted((row["size"], row["embree_ns"]) for row in rows if row["rays"] == rays and row["embree_ns"] > 0)
        label = f"{rays} {embree[-1][1]:.0f}" if embree else ""
        for (s1, v1), (s2, v2) in zip(embree, embree[1:]):
            if v1 < most < v2:  # leaves the picture
                s2, v2 = s1 * (s2 / s1) ** ((most - v1) / (v2 - v1)), most
            if v2 <= most:
                drawing.line(x_of(s1), y_of(v1), x_of(s2), y_of(v2), GREY, 1.2)
                end = (s2, v2)
        if embree and end[1] == most:
            drawing.text(x_of(end[0]) - 4, y_of(most) + 12, label, 9, "end", GREY)
        elif embree:
            drawing.text(x_of(end[0]) + 5, y_of(end[1]) + 3, label, 9, "start", GREY)
    for rays, colour in RAYS.items():
        line = sorted((row["size"], row[field]) for row in rows if row["rays"] == rays)
        if not line:
            continue
        fit = fits.get(rays)
        if fit and len(line) > 2:
            ends = [(s, fit[fitted]["a"] + fit[fitted]["b"] * math.log2(s)) for s in (line[0][0], line[-1][0])]
            drawing.line(x_of(ends[0][0]), y_of(ends[0][1]), x_of(ends[1][0]), y_of(ends[1][1]), colour, 1.0, "4 3")
        for (s1, v1), (s2, v2) in zip(line, line[1:]):
            drawing.line(x_of(s1), y_of(v1), x_of(s2), y_of(v2), colour, 1.8)
        if timed:
            warm = sorted((row["size"], row["warm_ns_per_ray"]) for row in rows if row["rays"] == rays)
            for (s1, v1), (s2, v2) in zip(warm, warm[1:]):
                drawing.line(x_of(s1), y_of(v1), x_of(s2), y_of(v2), colour, 1.4, "1 3")
        for size, value in line:
            drawing.marker(x_of(size), y_of(value), "circle", colour, 3.2, False, f"{rays}, {size}: {value:.1f}")


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    result = json.loads((folder / "scale.json").read_text(encoding="utf-8"))
    subjects = [s for s in ("triangles", "instances") if any(r["subject"] == s for r in result["rows"])]
    drawing = Drawing(LEFT + 2 * (WIDTH + GAP), TOP + len(subjects) * (HEIGHT + 66) - 20)
    drawing.text(LEFT - 44, 26, "How time grows with the scene (closest hit, one thread)", 16, weight="bold")
    drawing.text(LEFT - 44, 45, f"{result['machine']}. Dashed: fitted a + b log2(size). Dotted: rays whose nodes are "
                 "in the caches already. Grey: Embree's best entry.", 11, colour=GREY)
    for k, (rays, colour) in enumerate(RAYS.items()):
        drawing.marker(LEFT - 38 + k * 110, 60, "circle", colour, 4.2)
        drawing.text(LEFT - 28 + k * 110, 64, rays, 11)
    for row_index, subject in enumerate(subjects):
        rows = [row for row in result["rows"] if row["subject"] == subject]
        fits = {fit["rays"]: fit for fit in result.get("fits", []) if fit["subject"] == subject}
        top = TOP + row_index * (HEIGHT + 66)
        panel(drawing, LEFT, top, f"ns per ray against {subject}", rows, "ns_per_ray", fits, "ns")
        panel(drawing, LEFT + WIDTH + GAP, top, f"nodes per ray against {subject}", rows, "nodes_per_ray", fits,
              "nodes")
    drawing.write(folder / "scale.svg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
