#!/usr/bin/env python3
"""Draws FOLDER/skip.json as FOLDER/skip.svg and skip.png: seconds to the first answer and the peak of memory,
lazily and with nothing skipped, on logarithmic axes.

Usage: plot_skip.py FOLDER
"""

import json
import math
import sys
from pathlib import Path

from svg_chart import FAINT, GREY, INK, Drawing

LAZY, NONE = "#0b6e4f", "#d9822b"
LEFT, TOP, WIDTH, ROW, GAP = 190, 74, 330, 20, 46


def panel(drawing, left, title, rows, value_of, names):
    values = [value_of(row, twin) for row in rows for twin in ("lazy", "none")]
    low = math.floor(math.log10(min(values)))
    high = math.ceil(math.log10(max(values)) + 1e-9)
    bottom = TOP + len(rows) * ROW

    def x_of(value):
        return left + (math.log10(value) - low) / (high - low) * WIDTH

    drawing.text(left + WIDTH / 2, TOP - 12, title, 12, "middle", INK, "bold")
    for power in range(low, high + 1):
        drawing.line(x_of(10.0 ** power), TOP, x_of(10.0 ** power), bottom, FAINT)
        drawing.text(x_of(10.0 ** power), bottom + 16, f"{10.0 ** power:g}", 10, "middle", GREY)
    for i, row in enumerate(rows):
        y = TOP + i * ROW + ROW / 2
        if names:
            drawing.text(left - 8, y + 4, row["scene"], 11, "end", INK)
        drawing.line(x_of(value_of(row, "lazy")), y, x_of(value_of(row, "none")), y, GREY)
        drawing.marker(x_of(value_of(row, "none")), y, "square", NONE, 4.5,
                       note=f"{row['scene']}, nothing skipped: {value_of(row, 'none'):.4g}")
        drawing.marker(x_of(value_of(row, "lazy")), y, "circle", LAZY, 4.5,
                       note=f"{row['scene']}, lazily: {value_of(row, 'lazy'):.4g}")


def main():
    folder = Path(sys.argv[1])
    result = json.loads((folder / "skip.json").read_text(encoding="utf-8"))
    rows = sorted(result["scenes"], key=lambda row: -row["triangles"])
    drawing = Drawing(LEFT + 2 * WIDTH + GAP + 24, TOP + len(rows) * ROW + 40)
    drawing.text(LEFT, 24, "What skipping saves: lazily beside nothing skipped", 15, "start", INK, "bold")
    drawing.marker(LEFT + 6, 42, "circle", LAZY, 4.5)
    drawing.text(LEFT + 16, 46, "lazily", 11, "start", GREY)
    drawing.marker(LEFT + 76, 42, "square", NONE, 4.5)
    drawing.text(LEFT + 86, 46, f"nothing skipped ({result['machine']})", 11, "start", GREY)
    panel(drawing, LEFT, "seconds from the file to the first answer", rows,
          lambda row, twin: row[twin]["first_answer_seconds"], True)
    panel(drawing, LEFT + WIDTH + GAP, "peak of memory after 10,000 rays, MiB", rows,
          lambda row, twin: row[twin]["peak_mib"], False)
    drawing.write(folder / "skip.svg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
