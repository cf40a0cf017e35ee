#!/usr/bin/env python3
"""Draws FOLDER/http.json as FOLDER/http.svg and http.png, and writes http.csv and http.md: what a ray costs over HTTP by
the size of the request, in each form, beside the codec alone and Embree.

Usage: plot_http.py FOLDER
"""

import json
import sys
from pathlib import Path

from svg_chart import GREY, INK, Drawing, LogScale

COLOURS = {"JSON rows": "#0b6e4f", "JSON columns": "#2a78b5", "NDJSON": "#a4488f", "binary": "#d9822b"}
CONNECTIONS = {"sightline": (8, 1), "embree": (8,)}
LEFT, TOP, WIDTH, HEIGHT, GAP = 80, 76, 380, 330, 110


def series(result, server, form, key):
    """(rays, figure) with the few connections where there are such, else with one."""
    points = {}
    for connections in reversed(CONNECTIONS[server]):
        for cell in result["cells"]:
            if (cell["server"], cell["form"], cell["connections"]) == (server, form, connections) and cell["rays"] > 0:
                points[cell["rays"]] = cell[key]
    return sorted(points.items())


def panel(drawing, left, title, result, key, alone):
    groups = [(form, server, series(result, server, form, key)) for server in CONNECTIONS for form in COLOURS]
    if alone:
        groups += [(form, "alone", sorted((each["rays"], each["sum_ns"]) for each in result["alone"] if each["form"] == form))
                   for form in COLOURS]
    groups = [group for group in groups if group[2]]
    figures = [figure for _, _, points in groups for _, figure in points]
    x = LogScale(1, 1e6, left, left + WIDTH)
    y = LogScale(min(f[1] for f in figures) / 1.5, max(f[2] for f in figures) * 1.5, TOP + HEIGHT, TOP)
    drawing.text(left, TOP - 14, title, 12, "start", INK, "bold")
    for decade in y.decades():
        drawing.line(left, y(decade), left + WIDTH, y(decade))
        drawing.text(left - 8, y(decade) + 4, f"{decade:,.0f}", 10, "end", GREY)
    for rays in (1, 100, 10_000, 1_000_000):
        drawing.line(x(rays), TOP, x(rays), TOP + HEIGHT)
        drawing.text(x(rays), TOP + HEIGHT + 18, f"{rays:,}", 10, "middle", GREY)
    drawing.text(left + WIDTH / 2, TOP + HEIGHT + 36, "rays in a request", 11, "middle", GREY)
    for form, server, points in groups:
        shape, dash = {"sightline": ("circle", ""), "embree": ("triangle", "6 4"), "alone": ("square", "2 3")}[server]
        places = [(x(rays), y(figure[0])) for rays, figure in points]
        for (x1, y1), (x2, y2) in zip(places, places[1:]):
            drawing.line(x1, y1, x2, y2, COLOURS[form], 1.6, dash)
        for (rays, figure), (px, py) in zip(points, places):
            drawing.line(px, y(figure[1]), px, y(figure[2]), COLOURS[form], 1.2)
            drawing.marker(px, py, shape, COLOURS[form], 4, server != "sightline", f"{server} {form} {rays}: {figure[0]:.1f}")


def legend(drawing, top):
    at = LEFT
    for form, colour in COLOURS.items():
        drawing.rect(at, top - 9, 12, 10, colour)
        drawing.text(at + 18, top, form, 11, "start", INK)
        at += 110
    for shape, name in (("circle", "Sightline"), ("square", "codec and trace alone"), ("triangle", "Embree and nlohmann")):
        drawing.marker(at + 6, top - 4, shape, GREY, 4, shape != "circle")
        drawing.text(at + 18, top, name, 11, "start", INK)
        at += 100 if shape == "circle" else 170


def table(head, rows):
    lines = [head, ("---",) * len(head), *rows]
    return "".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines)


def spread(figure, digits=0):
    return f"{figure[0]:,.{digits}f} ({figure[1]:,.{digits}f} to {figure[2]:,.{digits}f})"


def main():
    folder = Path(sys.argv[1])
    result = json.loads((folder / "http.json").read_text(encoding="utf-8"))
    drawing = Drawing(LEFT + 2 * WIDTH + GAP + 40, TOP + HEIGHT + 92)
    drawing.text(LEFT, 24, "A ray over HTTP", 15, "start", INK, "bold")
    drawing.text(LEFT, 44, f"scene {result['scene']}, 8 connections (1 for 1,000,000 rays), client beside the server ({result['machine']})",
                 11, "start", GREY)
    panel(drawing, LEFT, "server CPU, nanoseconds per ray", result, "cpu_ns", True)
    panel(drawing, LEFT + WIDTH + GAP, "rays per second", result, "per_second", False)
    legend(drawing, TOP + HEIGHT + 70)
    drawing.write(folder / "http.svg")
    cells = [(c["server"], c["rays"], c["form"] if c["rays"] else "GET", c["connections"], spread(c["per_second"]), spread(c["cpu_ns"], 1), c["failed"])
             for c in result["cells"]]
    alone = [(a["rays"], a["form"], *(spread(a[key], 1) for key in ("decode_ns", "trace_ns", "encode_ns", "sum_ns"))) for a in result["alone"]]
    head = ("server", "rays in a request", "form", "connections", "rays per second", "server CPU ns per ray", "failed")
    (folder / "http.md").write_text(table(head, cells) + "\n" + table(
        ("rays", "form", "decode alone", "trace alone", "encode alone", "sum, ns per ray"), alone), encoding="utf-8")
    lines = [("server", "rays", "form", "connections", "rays_per_second", "cpu_ns_per_ray", "failed")]
    lines += [(c["server"], c["rays"], c["form"], c["connections"], c["per_second"][0], c["cpu_ns"][0], c["failed"]) for c in result["cells"]]
    (folder / "http.csv").write_text("".join(",".join(map(str, line)) + "\n" for line in lines), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
