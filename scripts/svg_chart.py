"""Small SVG drawings with the standard library: text, bars, dots, axes; and a PNG beside each.

Every chart of docs/benchmarks is drawn with this, so that the same figures give the same bytes.
"""

import math
import shutil
import subprocess
import sys
from pathlib import Path
from xml.sax.saxutils import escape

FONT = "DejaVu Sans, Verdana, sans-serif"
INK = "#1c2733"
FAINT = "#d9dfe6"
GREY = "#66727f"


class Drawing:
    """Coordinates are pixels from the top left."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self.parts = []

    def text(self, x, y, text, size=12, anchor="start", colour=INK, weight="normal", turn=0):
        where = f' transform="rotate({turn} {x:.1f} {y:.1f})"' if turn else ""
        self.parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" fill="{colour}"'
            f' font-weight="{weight}"{where}>{escape(str(text))}</text>')

    def line(self, x1, y1, x2, y2, colour=FAINT, width=1.0, dash=""):
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}"'
            f' stroke-width="{width}"{dashes}/>')

    def rect(self, x, y, width, height, fill, note=""):
        title = f"<title>{escape(note)}</title>" if note else ""
        self.parts.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
            f' fill="{fill}">{title}</rect>')

    def marker(self, x, y, shape, colour, size=6.0, hollow=False, note=""):
        """shape: "circle", "square", "diamond" or "triangle"."""
        paint = f'fill="{"white" if hollow else colour}" stroke="{colour}" stroke-width="1.8"'
        title = f"<title>{escape(note)}</title>" if note else ""
        if shape == "circle":
            self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{size:.1f}" {paint}>{title}</circle>')
            return
        corners = {
            "square": [(-1, -1), (1, -1), (1, 1), (-1, 1)],
            "diamond": [(0, -1.35), (1.35, 0), (0, 1.35), (-1.35, 0)],
            "triangle": [(0, -1.3), (1.2, 0.9), (-1.2, 0.9)],
        }[shape]
        points = " ".join(f"{x + size * dx:.1f},{y + size * dy:.1f}" for dx, dy in corners)
        self.parts.append(f'<polygon points="{points}" {paint}>{title}</polygon>')

    def write(self, file):
        """Writes FILE, and a PNG of twice the size beside it where rsvg-convert is installed."""
        file = Path(file)
        body = "\n".join(self.parts)
        file.write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}"'
            f' viewBox="0 0 {self.width} {self.height}" font-family="{FONT}">\n'
            f'<rect width="{self.width}" height="{self.height}" fill="white"/>\n{body}\n</svg>\n',
            encoding="utf-8")
        if shutil.which("rsvg-convert") is None:
            print(f"{file.name}: no PNG, rsvg-convert is not installed", file=sys.stderr)
            return
        subprocess.run(["rsvg-convert", "--zoom", "2", "-o", str(file.with_suffix(".png")), str(file)], check=True)


class LogScale:
    """Maps [low, high] to pixels [start, end] logarithmically."""

    def __init__(self, low, high, start, end):
        self.low, self.high, self.start, self.end = low, high, start, end

    def __call__(self, value):
        value = min(max(value, self.low), self.high)
        share = math.log(value / self.low) / math.log(self.high / self.low)
        return self.start + share * (self.end - self.start)

    def decades(self):
        first, last = math.ceil(math.log10(self.low) - 1e-9), math.floor(math.log10(self.high) + 1e-9)
        return [10.0 ** k for k in range(first, last + 1)]
