"""The scripts of docs/guides/python.md, as they stand there."""

import math
import os
import re
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import case_report
from process_status import is_sanitized
from sightline_server import PATIENCE, SOURCE, Server

PAGE = (SOURCE / "docs/guides/python.md").read_text(encoding="utf-8")
ADDRESS = "http://127.0.0.1:8080"
JOBS = dict(re.findall(r"^## (.*?)$.*?^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL))
MOST_LINES = 10


@unittest.skipIf(subprocess.run([sys.executable, "-c", "import numpy"], capture_output=True, check=False).returncode, "numpy is not installed")
class PythonJobs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "town=demo:town", "--preload", "painted=demo:painted", memory=None)
        cls.addClassCleanup(cls.server.end)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_job(self, title):
        """What a script prints, and what it writes on the error output."""
        script = JOBS[title]
        if is_sanitized(self.server):  # Every ray is slower there.
            script = script.replace("5_000_000", "200_000")
        done = subprocess.run([sys.executable, "-B", "-c", script.replace(ADDRESS, self.server.url)], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": str(SOURCE / "proto/python")}, cwd=self.folder, timeout=PATIENCE * 10, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout, done.stderr

    def test_each_script_has_ten_lines_at_most(self):
        self.assertEqual(len(JOBS), 6)
        self.assertEqual(PAGE.count("```python"), 6)
        for title, script in JOBS.items():
            self.assertLessEqual(len(script.strip().splitlines()), MOST_LINES, title)

    def test_a_scan_becomes_a_coloured_point_cloud(self):
        self.run_job("A scan as a coloured point cloud")
        head, body = (self.folder / "scan.ply").read_bytes().split(b"end_header\n", 1)
        count = int(re.search(rb"element vertex (\d+)", head)[1])
        properties = re.findall(r"property (\w+) (\w+)", head.decode())
        row = struct.Struct("<" + "".join({"double": "d", "int": "i", "uint": "I", "uchar": "B"}[kind] for kind, _ in properties))
        self.assertEqual(len(body), count * row.size)
        self.assertGreater(count, 5000)
        points = [dict(zip([name for _, name in properties], values)) for values in row.iter_unpack(body)]
        colours = {point["node_id"]: (point["red"], point["green"], point["blue"]) for point in points}
        self.assertGreater(len(set(colours.values())), 5)
        self.assertTrue(all(colours[point["node_id"]] == (point["red"], point["green"], point["blue"]) for point in points))
        self.assertTrue(all(math.dist((point["x"], point["y"], point["z"]), (40, 3, 30)) <= 300 for point in points))

    def test_lines_of_sight_become_a_table(self):
        told = self.run_job("Lines of sight between points")[0]
        rows = [line.split(",") for line in (self.folder / "sight.csv").read_text().splitlines()]
        self.assertEqual([len(row) for row in rows], [25, 25, 25])
        self.assertEqual({cell for row in rows for cell in row}, {"0", "1"})
        self.assertIn("of 75 lines are free", told)

    def test_clearance_is_told_by_node(self):
        lines = self.run_job("Clearance by node")[0].splitlines()
        distances = [float(line.split()[0]) for line in lines]
        self.assertEqual(distances, sorted(distances))
        self.assertTrue(any("spire - clock tower" in line or "clock tower - spire" in line for line in lines))
        self.assertEqual([line for line in lines if len(set(line.split("  ")[-1].split(" - "))) < 2], [])

    def test_pictures_of_depth_and_shade(self):
        told = self.run_job("A depth picture and a shaded picture")[0]
        self.assertRegex(told, r"^nearest [0-9.]+, [0-9]+% sky$")
        self.assertTrue((self.folder / "depth.png").read_bytes().startswith(b"\x89PNG"))
        picture = (self.folder / "shaded.png").read_bytes()
        self.assertTrue(picture.startswith(b"\x89PNG"))
        self.assertEqual(struct.unpack(">II", picture[16:24]), (640, 400))
        self.assertGreater(len(picture), 5000)

    def test_a_pixel_has_material_and_uv(self):
        told = self.run_job("What is at this pixel?")[0]
        for name in ("'material': '", "'uv': array([", "'t': "):
            self.assertIn(name, told)

    def test_five_million_rays_show_their_progress(self):
        told, bar = self.run_job("Five million rays with progress")
        self.assertRegex(told, r"^[0-9.]+% of (5000000|200000) rays hit; the mean distance is [0-9.]+$")
        self.assertRegex(bar.strip().splitlines()[-1].split("\r")[-1], r"\b(5000000|200000) of \1 rows|100%")


if __name__ == "__main__":
    case_report.main()
