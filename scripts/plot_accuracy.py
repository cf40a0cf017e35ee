#!/usr/bin/env python3
"""Draws FOLDER/accuracy.json as FOLDER/accuracy.svg and accuracy.png: run time against wrong answers.

Usage: plot_accuracy.py FOLDER
"""

import json
import math
import sys
from pathlib import Path

from svg_chart import FAINT, GREY, INK, Drawing, LogScale

# contestant: label, colour
LABELS = {
    "scene": {
        "sightline": ("Sightline", "#0b6e4f"),
        "sightline_unrounded": ("Sightline without the final rounding", "#6cbf8f"),
        "embree1": ("Embree 3.13.5", "#8f4b0e"),
        "embree1_robust": ("Embree, robust", "#e08a2e"),
        "moeller_trumbore_float32": ("Möller-Trumbore, float32", "#2f6fb2"),
        "moeller_trumbore_float64": ("Möller-Trumbore, float64", "#7fb0de"),
        "woop_float32": ("Woop watertight, float32", "#8a4fa3"),
        "pluecker_float32": ("Plücker, float32", "#c1417a"),
    },
    "box": {
        "sightline": ("Sightline, outcome and t", "#0b6e4f"),
        "slab_swap_divide": ("swap and divide", "#2f6fb2"),
        "williams2005": ("Williams 2005", "#8a4fa3"),
        "branchless_min_max": ("branchless min, max", "#c1417a"),
        "fma_inverse": ("inverse and FMA", "#8f4b0e"),
        "ize2013_padded": ("Ize 2013, padded", "#e08a2e"),
    },
}
# group: marker, hollow, label
GROUPS = {
    "scene": {
        "ordinary": ("circle", False, "ordinary rays"),
        "hard_float32": ("triangle", False, "hard rays, float32 numbers"),
        "hard_float64": ("diamond", True, "hard rays, float64 numbers"),
    },
    "box": {
        "ordinary": ("circle", False, "ordinary pairs"),
        "hard": ("triangle", False, "hard pairs"),
    },
}
TITLES = {"scene": "Rays and triangles", "box": "Rays and boxes"}
UNITS = {"scene": "nanoseconds per ray", "box": "nanoseconds per pair"}
LEFT, TOP, WIDTH, HEIGHT, BETWEEN = 114, 108, 440, 400, 104
LANE = 17  # of the row of those that were never wrong


def ticks(low, high):
    return [m * 10.0 ** k for k in range(-1, 6) for m in (1, 2, 5) if low <= m * 10.0 ** k <= high]


def axes(drawing, left, panel, x, y, bottom, row):
    for share in y.decades():
        drawing.line(left, y(share), left + WIDTH, y(share), FAINT, 0.8)
        drawing.text(left - 8, y(share) + 4, f"{1e6 * share:,.0f}", 13, "end", GREY)
    drawing.rect(left, bottom - row, WIDTH, row, "#e6f3ec")
    drawing.text(left - 8, bottom - row / 2 + 4, "none", 13, "end", INK, "bold")
    for ns in ticks(x.low, x.high):
        drawing.line(x(ns), TOP, x(ns), bottom, FAINT, 0.8)
        drawing.text(x(ns), bottom + 18, f"{ns:,g}", 13, "middle", GREY)
    drawing.text(left + WIDTH / 2, bottom + 40, UNITS[panel] + ", one thread", 13, "middle", INK)


def lanes(marks):
    """Marks (x, first) of the row of zeros to lanes, so that none lies on another; `first` ones come first."""
    lane_of, ends = {}, []
    for key, (x, first) in sorted(marks.items(), key=lambda item: (not item[1][1], item[1][0])):
        lane = next((k for k, xs in enumerate(ends) if all(abs(x - other) >= 15 for other in xs)), len(ends))
        if lane == len(ends):
            ends.append([])
        ends[lane].append(x)
        lane_of[key] = lane
    return lane_of, max(1, len(ends))


def legend(drawing, left, top, panel, names, groups):
    for k, name in enumerate(names):
        label, colour = LABELS[panel][name]
        x, y = left + k % 2 * 225, top + k // 2 * 21
        drawing.rect(x, y - 9, 12, 12, colour)
        drawing.text(x + 18, y + 2, label, 13, weight="bold" if name == "sightline" else "normal")
    top += (len(names) + 1) // 2 * 21 + 8
    for k, group in enumerate(groups):
        shape, hollow, label = GROUPS[panel][group]
        x, y = left + k % 2 * 225, top + k // 2 * 21
        drawing.marker(x + 6, y - 3, shape, GREY, 5, hollow)
        drawing.text(x + 18, y + 2, label, 13)


def panel_of(drawing, points, panel, left, low):
    times = [p["ns"] for p in points]
    bottom = TOP + HEIGHT
    x = LogScale(min(times) / 1.35, max(times) * 1.35, left, left + WIDTH)
    lane_of, lane_count = lanes({(p["contestant"], p["group"]): (x(p["ns"]), p["contestant"] == "sightline")
                                 for p in points if p["wrong"] == 0})
    row = lane_count * LANE + 10
    y = LogScale(low, 1.0, bottom - row - 12, TOP + 6)
    drawing.text(left, TOP - 16, TITLES[panel], 15, weight="bold")
    axes(drawing, left, panel, x, y, bottom, row)
    where = {}
    for p in points:
        key = (p["contestant"], p["group"])
        height = y(p["wrong"] / p["judged"]) if p["wrong"] else bottom - 5 - LANE * (lane_of[key] + 0.5)
        where[key] = (x(p["ns"]), height, p)
    names = [n for n in LABELS[panel] if any(p["contestant"] == n for p in points)]
    groups = [g for g in GROUPS[panel] if any(p["group"] == g for p in points)]
    for name in names:
        path = [where[(name, g)] for g in groups if (name, g) in where]
        for (x1, y1, _), (x2, y2, _) in zip(path, path[1:]):
            drawing.line(x1, y1, x2, y2, LABELS[panel][name][1], 2.2 if name == "sightline" else 1.0,
                         "" if name == "sightline" else "3 3")
    # Sightline last, so that nothing lies on it.
    for name in reversed(names):
        label, colour = LABELS[panel][name]
        for group in groups:
            if (name, group) not in where:
                continue
            px, py, p = where[(name, group)]
            shape, hollow, what = GROUPS[panel][group]
            drawing.marker(px, py, shape, colour, 7 if name == "sightline" else 5.5, hollow,
                           f"{label}, {what}: {p['ns']:.1f} ns, wrong {p['wrong']} of {p['judged']}")
    legend(drawing, left, bottom + 72, panel, names, groups)


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    result = json.loads((folder / "accuracy.json").read_text(encoding="utf-8"))
    drawing = Drawing(LEFT + 2 * WIDTH + BETWEEN + 24, TOP + HEIGHT + 208)
    drawing.text(LEFT - 96, 28, "Run time against wrong answers (left and down is better)", 17, weight="bold")
    drawing.text(LEFT - 96, 48, f"Every answer judged by rational arithmetic. {result['machine']}; medians of "
                 f"{result['repetitions']} interleaved repetitions{', quick run' if result['quick'] else ''}.", 12,
                 colour=GREY)
    drawing.text(LEFT - 96, 65, f"Scene: {result['scene']}, {result['triangles']:,} triangles; the textbook tests run "
                 "on Sightline's tree. Hard: aimed at vertices and edges, on surfaces, grazing, in planes.", 12,
                 colour=GREY)
    drawing.text(LEFT - 92, TOP + HEIGHT / 2, "wrong answers per million", 13, "middle", INK, "normal", -90)
    shown = {panel: [p for p in result["points"] if p["panel"] == panel and p["group"] in GROUPS[panel]]
             for panel in GROUPS}
    shares = [p["wrong"] / p["judged"] for points in shown.values() for p in points if p["wrong"] > 0] or [0.1]
    low = 10 ** math.floor(math.log10(min(shares)))
    for index, (panel, points) in enumerate(shown.items()):
        panel_of(drawing, points, panel, LEFT + index * (WIDTH + BETWEEN), low)
    drawing.write(folder / "accuracy.svg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
