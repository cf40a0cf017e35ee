#!/usr/bin/env python3
"""Draws FOLDER/trace.json as FOLDER/trace.svg and trace.png: speed against rtcIntersect1.

Usage: plot_trace.py FOLDER
"""

import json
import sys
from pathlib import Path

from svg_chart import FAINT, GREY, INK, Drawing

BASE = "embree1"
# label, colour, the contestants of which the fastest counts
BARS = [
    ("Sightline, batches of 262,144", "#0b6e4f", lambda name: name == "sightline"),
    ("Sightline, batches of 64", "#5bb88f", lambda name: name == "sightline_64"),
    ("Sightline, single rays", "#b7dfcb", lambda name: name == "sightline_1"),
    ("Embree single, isa=avx2", "#f2b880", lambda name: name == "embree1_avx2"),
    ("Embree's best robust entry", "#d9822b", lambda name: name.startswith("embree") and name.endswith("_robust")),
    ("Embree's best entry of any kind", "#8f4b0e", lambda name: name.startswith("embree")),
]
PANEL, GAP, LEFT, TOP = 190, 16, 60, 110
RAYS = ["camera", "lidar", "ao", "incoherent"]


def speed(cell, chosen):
    times = [c["ns_per_ray"] for name, c in cell["contestants"].items() if chosen(name)]
    base = cell["contestants"].get(BASE)
    return base["ns_per_ray"] / min(times) if times and base else None


def row(drawing, cells, query, scenes, top, height):
    found = {(c["scene"], c["rays"]): c for c in cells if c["query"] == query}
    values = [speed(c, chosen) for c in found.values() for _, _, chosen in BARS]
    most = max([2.0] + [v for v in values if v])
    scale = height / (most * 1.05)
    drawing.text(LEFT - 44, top + height / 2, {"closest": "closest hit", "any": "any hit"}[query], 14, "middle", INK,
                 "bold", -90)
    step = 0.5 if most < 4 else 1.0 if most < 8 else 2.0
    for index, scene in enumerate(scenes):
        left = LEFT + index * (PANEL + GAP)
        tick = 0.0
        while tick <= most * 1.05:
            y = top + height - tick * scale
            strong = abs(tick - 1) < 1e-9
            drawing.line(left, y, left + PANEL, y, GREY if strong else FAINT, 1.4 if strong else 0.8)
            if index == 0:
                drawing.text(left - 6, y + 4, f"{tick:g}", 11, "end", GREY)
            tick += step
        group = PANEL / len(RAYS)
        for place, rays in enumerate(RAYS):
            cell = found.get((scene, rays))
            x = left + place * group + 4
            drawing.text(x + (group - 8) / 2, top + height + 15, rays, 10, "middle", GREY)
            if cell is None:
                continue
            width = (group - 8) / len(BARS)
            for k, (label, colour, chosen) in enumerate(BARS):
                value = speed(cell, chosen)
                if value:
                    drawing.rect(x + k * width, top + height - value * scale, width - 0.8, value * scale, colour,
                                 f"{scene} {rays}, {label}: {value:.2f}")


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    result = json.loads((folder / "trace.json").read_text(encoding="utf-8"))
    scenes = [scene["name"] for scene in result["scenes"]]
    queries = [q for q in ("closest", "any") if any(c["query"] == q for c in result["cells"])]
    width = max(LEFT + len(scenes) * (PANEL + GAP), 760)
    height = 230
    drawing = Drawing(width, TOP + len(queries) * (height + 60) - 10)
    drawing.text(LEFT, 26, "Speed against Embree 3.13.5, rtcIntersect1 and rtcOccluded1 = 1 (higher is faster)", 16,
                 weight="bold")
    drawing.text(LEFT, 46, f"{result['machine']}; one thread; medians of {result['repetitions']} interleaved "
                 f"repetitions{', quick run' if result['quick'] else ''}. Sightline's answers are exact.", 11,
                 colour=GREY)
    for k, (label, colour, _) in enumerate(BARS):
        x, y = LEFT + k % 3 * 240, 66 + k // 3 * 17
        drawing.rect(x, y - 9, 11, 11, colour)
        drawing.text(x + 16, y + 1, label, 11)
    for index, scene in enumerate(scenes):
        drawing.text(LEFT + index * (PANEL + GAP) + PANEL / 2, TOP - 4, scene, 13, "middle", INK, "bold")
    for k, query in enumerate(queries):
        row(drawing, result["cells"], query, scenes, TOP + 8 + k * (height + 60), height)
    drawing.write(folder / "trace.svg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
