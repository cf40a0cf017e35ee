#!/usr/bin/env python3
"""Draws FOLDER/door.json as FOLDER/door.svg and door.png, and writes door.csv and door.md: trivial requests per
second and CPU time for each, of Sightline, cpp-httplib as it comes, and nginx.

Usage: plot_door.py FOLDER
"""

import json
import sys
from pathlib import Path

from svg_chart import GREY, INK, Drawing

COLOURS = {"sightline": "#0b6e4f", "cpp-httplib": "#d9822b", "nginx": "#7a7a7a"}
LEFT, TOP, WIDTH, ROW, GAP = 110, 74, 300, 34, 120


def panel(drawing, left, title, rows, key, form, names):
    most = max(row[key] for row in rows)
    drawing.text(left, TOP - 12, title, 12, "start", INK, "bold")
    for i, row in enumerate(rows):
        y = TOP + i * ROW
        if names:
            drawing.text(left - 8, y + 16, row["name"], 12, "end", INK)
        drawing.rect(left, y, WIDTH * row[key] / most, ROW - 12, COLOURS[row["name"]], row["name"])
        drawing.text(left + WIDTH * row[key] / most + 6, y + 16, form.format(row[key]), 11, "start", GREY)


def main():
    folder = Path(sys.argv[1])
    result = json.loads((folder / "door.json").read_text(encoding="utf-8"))
    rows = result["servers"]
    drawing = Drawing(LEFT + 2 * WIDTH + GAP + 70, TOP + len(rows) * ROW + 20)
    drawing.text(LEFT, 24, f"Trivial requests over {result['connections']} connections", 15, "start", INK, "bold")
    drawing.text(LEFT, 44, f"{result['workers']} workers, client beside the server ({result['machine']})", 11, "start", GREY)
    panel(drawing, LEFT, "requests per second", rows, "requests_per_second", "{:,.0f}", True)
    panel(drawing, LEFT + WIDTH + GAP, "server CPU per request, microseconds", rows, "cpu_us_per_request", "{:.1f}", False)
    drawing.write(folder / "door.svg")
    table = [(row["name"], f"{row['requests_per_second']:.0f}", f"{row['cpu_us_per_request']:.2f}", row["failed"]) for row in rows]
    head = ("server", "requests_per_second", "cpu_us_per_request", "failed")
    (folder / "door.csv").write_text("".join(",".join(map(str, line)) + "\n" for line in (head, *table)), encoding="utf-8")
    lines = [head, ("---",) * len(head), *table]
    (folder / "door.md").write_text("".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
