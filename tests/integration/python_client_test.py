"""proto/python/sightline.py against a real server: its README, its columns, its errors."""

import contextlib
import io
import json
import math
import os
import random
import re
import socketserver
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import case_report
from sightline_server import SOURCE, demo_glb
from two_scenes import TwoScenes

sys.path.insert(0, str(SOURCE / "proto/python"))
import sightline  # noqa: E402  (found only now)

# See rays_test.py.
ORIGINS, DIRECTIONS = [[-10, 1, 0], [1, 10, 0], [3, 10, 0]], [[1, 0, 0], [0, -1, 0], [0, -1, 0]]


def listed(column):
    return column.tolist() if hasattr(column, "tolist") else column


class PythonClient(TwoScenes):
    """Without numpy, wherever it may be installed."""

    numpy = None

    def setUp(self):
        self.addCleanup(setattr, sightline, "numpy", sightline.numpy)
        sightline.numpy = self.numpy
        self.client = sightline.Sightline(self.server.url)
        self.addCleanup(self.client.close)

    def test_the_example_of_its_readme(self):
        page = (SOURCE / "proto/python/README.md").read_text(encoding="utf-8")
        example = re.search(r"```python\n(.*?)```", page, re.DOTALL).group(1)
        expected = re.findall(r"  # (.*)$", example, re.MULTILINE)
        printed = io.StringIO()
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(printed):
            Path(folder, "house.glb").write_bytes(demo_glb("six"))
            before = os.getcwd()
            try:
                os.chdir(folder)
                exec(example.replace("http://127.0.0.1:8080", self.server.url), {})
            finally:
                os.chdir(before)
        told = re.sub(r"np\.\w+\(([^)]*)\)", r"\1", printed.getvalue())  # numpy 2 shows its types
        self.assertEqual(told.splitlines(), expected)

    def test_every_kind_of_ray_query(self):
        hits = self.client.closest("six", ORIGINS, DIRECTIONS, fields=["t", "triangle", "position", "front"])
        self.assertEqual((listed(hits["t"]), listed(hits["triangle"])), ([4.5, math.inf, 8], [0, -1, 0]))
        self.assertEqual(listed(hits["position"][0]), [-5.5, 1, 0])
        self.assertEqual(listed(self.client.any("six", ORIGINS, DIRECTIONS)), [True, False, True])
        self.assertEqual(listed(self.client.count("six", ORIGINS, DIRECTIONS, tmax=8)), [2, 0, 1])
        self.assertEqual(listed(self.client.count("six", ORIGINS, DIRECTIONS, tmin=[5, 0, 9], tmax=[math.inf] * 3)), [5, 0, 0])
        lists = self.client.all("six", ORIGINS, DIRECTIONS, max_hits=2, fields=["t"])
        self.assertEqual([listed(lists[name]) for name in ("totals", "first", "t")], [[6, 0, 1], [0, 2, 2, 3], [4.5, 6.5, 8]])
        names = self.client.closest("six", ORIGINS, DIRECTIONS, tmax=math.inf, fields=["node", "t"])
        self.assertEqual(names, {"t": [4.5, None, 8], "node": ["left", None, "right"]})

    def test_every_kind_of_point_query(self):
        hits = self.client.closest_points("six", [[-7, 3, 0], [90, 0, 0]], max_distance=20, fields=["distance", "position", "triangle"])
        self.assertEqual((listed(hits["distance"]), listed(hits["triangle"])), ([math.sqrt(5), math.inf], [0, -1]))
        self.assertEqual(listed(hits["position"][0]), [-5, 2, 0])
        near = self.client.nearest("six", [[-7, 3, 0], [1, 2, 0]], 2)
        self.assertEqual((listed(near["first"]), listed(near["instance"])), ([0, 2, 4], [0, 0, 0, 1]))
        tower = {"include": {"names": ["clock tower", "spire"]}}
        signed = self.client.distance("town", [[0, 10, 0.5], [-7, 9, 0]], method="winding", **tower)
        self.assertEqual([listed(signed[name]) for name in ("distance", "reliable", "winding")], [[-2.5, 4], [1, 1], [1, 0]])
        with self.assertRaises(ValueError):
            self.client.closest_points("six", [[0, 0, 0]], fields=["node"])

    def test_columns_are_what_json_says(self):
        random.seed(4)
        origins = [[random.uniform(-300, 300), 60, random.uniform(-300, 300)] for _ in range(500)]
        directions = [[random.uniform(-1, 1), -1, random.uniform(-1, 1)] for _ in range(500)]
        fields = ["t", "instance", "triangle", "normal", "front"]
        hits = self.client.closest("town", origins, directions, fields=fields, cull="back")
        rows = [{"origin": o, "direction": d} for o, d in zip(origins, directions)]
        plain = self.server.query("town", "closest", {"rays": rows, "fields": fields, "cull": "back"}).json()["hits"]
        for i, hit in enumerate(plain):
            if hit:
                got = {field: listed(hits[field][i]) for field in fields}
                self.assertEqual({**got, "front": bool(got["front"])}, hit)
            else:
                self.assertEqual((hits["t"][i], hits["instance"][i]), (math.inf, -1))

    def test_scenes_come_and_go(self):
        self.assertEqual(self.client.put("mine", demo_glb("six"))["state"], "ready")
        self.assertIn("mine", [scene["id"] for scene in self.client.scenes()])
        self.assertEqual(self.client.scene("mine")["counts"]["triangles"], 6)
        self.assertEqual([node["name"] for node in self.client.nodes("mine")], ["root", "left", "right"])
        self.assertEqual(self.client.triangles("mine", [(0, 0, 0)])[0]["corners"][1], [-4, 4, 0])
        self.assertEqual(self.client.boxes("mine", "count", [{"min": [-9, 0, -9], "max": [0, 9, 9]}])["counts"], [3])
        self.client.delete("mine")
        with self.assertRaises(sightline.SightlineError) as caught:
            self.client.stats("mine")
        self.assertEqual((caught.exception.status, caught.exception.code), (404, "SCENE_NOT_FOUND"))

    def test_faults_are_exceptions(self):
        with self.assertRaises(sightline.SightlineError) as caught:
            self.client.closest("six", ORIGINS, DIRECTIONS, colour="red")
        self.assertEqual((caught.exception.code, caught.exception.errors[0]["pointer"]), ("KEY_UNKNOWN", "/colour"))
        with self.assertRaises(ValueError):
            self.client.closest("six", ORIGINS, DIRECTIONS[:2])
        with self.assertRaises(ValueError):
            self.client.closest("six", ORIGINS)
        with self.assertRaises(ValueError):
            sightline.Sightline("127.0.0.1:8080")
        # The connection is good for the next question.
        self.assertEqual(listed(self.client.any("six", ORIGINS, DIRECTIONS)), [True, False, True])

    def test_a_kept_connection_that_was_closed_is_opened_again(self):
        served = []

        class Closing(socketserver.StreamRequestHandler):
            def handle(self):
                line = self.rfile.readline()
                if not line:
                    return
                while self.rfile.readline().strip():
                    pass
                served.append(line)
                body = json.dumps({"scenes": []}).encode()
                self.wfile.write(b"HTTP/1.1 200 OK\r\nContent-Length: %d\r\n\r\n" % len(body) + body)

        with socketserver.TCPServer(("127.0.0.1", 0), Closing) as closing:
            thread = threading.Thread(target=closing.serve_forever)
            thread.start()
            try:
                with sightline.Sightline(f"http://127.0.0.1:{closing.server_address[1]}") as client:
                    self.assertEqual([client.scenes() for _ in range(3)], [[], [], []])
            finally:
                closing.shutdown()
                thread.join()
        self.assertEqual(len(served), 3)


@unittest.skipUnless(sightline.numpy, "numpy is not installed")
class PythonClientWithNumpy(PythonClient):
    numpy = sightline.numpy

    def test_float32_stays_float32_on_the_way(self):
        o, d = (self.numpy.asarray(points, "float32") for points in (ORIGINS, DIRECTIONS))
        self.assertLess(len(sightline._pack(o, d, None, None, {})), 24 + 3 * 48)
        self.assertEqual(self.client.count("six", o, d).tolist(), [6, 0, 1])


if __name__ == "__main__":
    case_report.main()
