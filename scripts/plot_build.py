#!/usr/bin/env python3
"""Draws FOLDER/build.json as FOLDER/build.svg and build.png: build speed and bytes per triangle.

Usage: plot_build.py FOLDER
"""

import json
import sys
from pathlib import Path

from svg_chart import FAINT, GREY, INK, Drawing

COLOURS = {"sightline": "#0b6e4f", "sightline_fast": "#0b6e4f", "sightline_high": "#5bb88f",
           "embree_medium": "#d9822b", "embree_high": "#8f4b0e"}
LEFT, TOP, WIDTH, HEIGHT, GAP = 60, 92, 300, 220, 60


def panel(drawing, left, title, unit, rows, value_of):
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    builders = list(dict.fromkeys(row["builder"] for row in rows))
    most = max(value_of(row) for row in rows) * 1.08
    step = next(s for s in (0.5, 1, 2, 5, 10, 25, 50, 100) if most / s <= 6)
    drawing.text(left + WIDTH / 2, TOP - 8, title, 12, "middle", INK, "bold")
    tick = 0.0
    while tick <= most:
        y = TOP + HEIGHT - tick / most * HEIGHT
        drawing.line(left, y, left + WIDTH, y, FAINT)
        drawing.text(left - 6, y + 4, f"{tick:g}", 10, "end", GREY)
        tick += step
    group = WIDTH / len(scenes)
    for i, scene in enumerate(scenes):
        x = left + i * group + 8
        drawing.text(x + (group - 16) / 2, TOP + HEIGHT + 15, scene, 10, "middle", GREY)
        width = (group - 16) / len(builders)
        for row in rows:
            if row["scene"] == scene:
                value = value_of(row)
                height = value / most * HEIGHT
                drawing.rect(x + builders.index(row["builder"]) * width, TOP + HEIGHT - height, width - 1, height,
                             COLOURS.get(row["builder"], GREY), f"{scene}, {row['builder']}: {value:.2f} {unit}")


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    result = json.loads((folder / "build.json").read_text(encoding="utf-8"))
    drawing = Drawing(LEFT + 3 * (WIDTH + GAP), TOP + HEIGHT + 40)
    drawing.text(LEFT - 40, 26, "Building trees: Sightline beside Embree 3.13.5", 16, weight="bold")
    drawing.text(LEFT - 40, 45, f"{result['machine']}; medians of {result['repetitions']} interleaved repetitions.", 11,
                 colour=GREY)
    for k, builder in enumerate(dict.fromkeys(row["builder"] for row in result["rows"])):
        drawing.rect(LEFT - 40 + k * 150, 54, 11, 11, COLOURS.get(builder, GREY))
        drawing.text(LEFT - 24 + k * 150, 64, builder.replace("_", ", "), 11)
    for k, threads in enumerate((1, 2)):
        rows = [row for row in result["rows"] if row["threads"] == threads]
        if rows:
            title = f"Mtriangles/s, {threads} thread{'s' if threads > 1 else ''} (higher is faster)"
            panel(drawing, LEFT + k * (WIDTH + GAP), title, "Mtriangles/s", rows,
                  lambda row: row["mtriangles_per_second"])
    rows = [row for row in result["rows"] if row["threads"] == 1]
    panel(drawing, LEFT + 2 * (WIDTH + GAP), "bytes per triangle, all included", "bytes", rows,
          lambda row: row["bytes_per_triangle"])
    drawing.write(folder / "build.svg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
