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
        # numpy 2 shows its types: np.float64(4.5), np.True_.
        told = re.sub(r"np\.\w+\(([^)]*)\)|np\.(True|False)_", r"\1\2", printed.getvalue())
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
        self.assertEqual({name: listed(column) for name, column in names.items()},
                         {"t": [4.5, math.inf, 8], "node": ["left", None, "right"], "hit": [True, False, True]})

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

    def test_a_wrong_shape_is_refused_with_its_name(self):
        six = [[1, 0, 0]] * 6
        for origins, directions, limits, message in (
                ([[0] * 7] * 3, [[1] * 7] * 3, {}, r"^origins has shape \(3, 7\): expected \(n, 3\) or \(h, w, 3\)$"),
                (ORIGINS, [[1, 0]] * 3, {}, r"^directions has shape \(3, 2\)"),
                (ORIGINS[0], DIRECTIONS[0], {}, r"^origins has shape \(3,\)"),
                (0, 0, {}, r"^origins has shape \(\)"),
                ([[]], [[]], {}, r"^origins has shape \(1, 0\)"),
                ([[[[0, 0, 0]]]], [[[[1, 0, 0]]]], {}, "^origins.* at most three axes"),
                (six, DIRECTIONS, {}, r"^directions has shape \(3, 3\), origins has shape \(6, 3\)"),
                (six, [six[:3], six[:3]], {}, r"^directions has shape \(2, 3, 3\), origins has shape \(6, 3\)"),
                (ORIGINS, DIRECTIONS, {"tmin": [0, 0]}, r"^tmin has shape \(2,\), origins has shape \(3, 3\)"),
                (ORIGINS, DIRECTIONS, {"tmax": [9]}, r"^tmax has shape \(1,\)"),
                (ORIGINS, DIRECTIONS, {"tmax": [[9, 9, 9]]}, r"^tmax has shape \(1, 3\)"),
                ([[0, 0, 0], [0, 0]], six[:2], {}, r"^origins\[1\] has shape \(2,\), origins\[0\] has shape \(3,\)")):
            for method in (self.client.closest, self.client.any, self.client.count, self.client.all):
                with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                    method("six", origins, directions, **limits)
        for method in (self.client.closest_points, self.client.distance, self.client.inside,
                       lambda scene, points: self.client.nearest(scene, points, 1)):
            for points in ([[0, 0]], [0, 0, 0], [[0] * 4] * 3, 0, [[[[0, 0, 0]]]]):
                with self.subTest(points), self.assertRaisesRegex(ValueError, "^points"):
                    method("six", points)
        with self.assertRaisesRegex(ValueError, r"^points_to has shape \(3, 2\)"):
            self.client.visibility("six", ORIGINS, [[0, 0]] * 3)
        with self.assertRaisesRegex(ValueError, r"^points_from has shape \(3, 3\), points_to has shape \(2, 3\)"):
            self.client.visibility("six", ORIGINS, ORIGINS[:2], pairing="each")
        for ids in ([[0, 0]], [[1.0, 0, 0]], [[True, 0, 0]], ["0.0.0"], [(1.5, 2)], [0, 0, 0], True, 0, "0.0.0"):
            with self.subTest(ids), self.assertRaisesRegex(ValueError, "^ids"):
                self.client.triangles("six", ids)

    def test_what_is_no_number_is_refused(self):
        for wrong in (True, "1", None, 1j, b"1", 10 ** 400, {0: 1}):
            for rows in ([[0, wrong, 0]], [[wrong, wrong, wrong]]):
                with self.subTest(rows), self.assertRaisesRegex(ValueError, r"^origins\[0\]"):
                    self.client.any("six", rows, [[1, 0, 0]])
            if wrong is not None:
                with self.subTest(wrong), self.assertRaisesRegex(ValueError, "^tmax"):
                    self.client.any("six", [[0, 0, 0]], [[1, 0, 0]], tmax=wrong)
        for text in ("abc", ["abc"], b"abc", {0: [1, 2, 3]}, {(1, 2, 3)}, iter(ORIGINS)):
            with self.subTest(text), self.assertRaisesRegex(ValueError, "^points"):
                self.client.closest_points("six", text)

    def test_numbers_that_are_not_finite_are_refused_with_their_row(self):
        inf, nan = math.inf, math.nan
        for fields in (["t"], ["t", "node"]):
            for wrong in (inf, -inf, nan):
                with self.assertRaisesRegex(ValueError, rf"^origins\[1\]\[2\] is {wrong}"):
                    self.client.closest("six", [[0, 0, 0], [0, 0, wrong]], [[1, 0, 0]] * 2, fields=fields)
                with self.assertRaisesRegex(ValueError, rf"^directions\[0\]\[1\]\[0\] is {wrong}"):
                    self.client.closest("six", [[[0, 0, 0]] * 2], [[[0, 0, 1], [wrong, 0, 0]]], fields=fields)
                with self.assertRaisesRegex(ValueError, rf"^points\[0\]\[0\] is {wrong}"):
                    self.client.inside("six", [[wrong, 0, 0]])
            with self.assertRaisesRegex(ValueError, r"^tmin\[2\] is nan"):
                self.client.closest("six", ORIGINS, DIRECTIONS, tmin=[0, 0, nan], fields=fields)
            with self.assertRaisesRegex(ValueError, "^tmax is nan"):
                self.client.closest("six", ORIGINS[:1], DIRECTIONS[:1], tmax=nan, fields=fields)
        self.assertEqual(listed(self.client.any("six", ORIGINS, DIRECTIONS, tmin=-inf, tmax=inf)), [True, False, True])
        self.assertEqual(listed(self.client.any("six", ORIGINS, DIRECTIONS, tmin=[0, 0, inf])), [True, False, False])
        with self.assertRaisesRegex(ValueError, r"^tmin\[1\] is -inf: expected a finite number$"):
            self.client.closest("six", ORIGINS, DIRECTIONS, tmin=[0, -inf, 0], fields=["node"])
        with self.assertRaisesRegex(ValueError, "^/max_distance cannot be written as JSON"):
            self.client.closest_points("six", ORIGINS, max_distance=inf)
        with self.assertRaisesRegex(ValueError, "^/boxes/0/min/1 cannot be written as JSON"):
            self.client.boxes_any("six", [{"min": [0, nan, 0], "max": [1, 1, 1]}])

    def test_marked_rays_are_marked_whatever_is_asked_for(self):
        bad = [[1, 0, 0], [0, 0, 0], [math.nan, 0, 0]]
        marked = self.client.closest("six", [[-10, 1, 0]] * 3, bad, on_invalid="mark")
        self.assertEqual((listed(marked["invalid"]), listed(marked["hit"])), ([0, 2, 1], [True, False, False]))
        named = self.client.closest("six", [[-10, 1, 0]] * 2, bad[:2], on_invalid="mark", fields=["node"])
        self.assertEqual((listed(named["invalid"]), named["node"]), ([0, 2], ["left", None]))
        listing = self.client.all("six", [[-10, 1, 0]] * 2, bad[:2], on_invalid="mark", fields=["node"], max_hits=1)
        self.assertEqual((listed(listing["invalid"]), listed(listing["totals"])), ([0, 2], [6, 0]))
        with self.assertRaisesRegex(ValueError, r"^directions\[2\]\[0\] is nan"):
            self.client.closest("six", [[-10, 1, 0]] * 3, bad, on_invalid="mark", fields=["node"])

    def test_a_generator_has_no_limits_beside_it_and_columns_no_picture(self):
        camera = {"kind": "pinhole", "position": [-10, 1, 0], "forward": [1, 0, 0], "width": 3, "height": 2}
        for limits in ({"tmin": 0}, {"tmax": 1}, {"image": "depth"}):
            with self.subTest(limits), self.assertRaises(ValueError):
                self.client.closest("six", generator=camera, **limits)
        for fields in ("t", {"t"}, None, [1]):
            with self.subTest(fields), self.assertRaisesRegex(ValueError, "^fields"):
                self.client.closest("six", generator=camera, fields=fields)

    def shape(self, column):
        """Of an array, or of nested lists; their depth alone where a list is empty."""
        if hasattr(column, "shape"):
            return column.shape
        shape = []
        while isinstance(column, list):
            shape.append(len(column))
            column = column[0] if column else None
        return tuple(shape)

    def kind(self, column):
        """The dtype, or the types of the numbers in nested lists."""
        if hasattr(column, "dtype"):
            return str(column.dtype)
        if isinstance(column, list):
            return set().union(*map(self.kind, column)) if column else set()
        return {type(column)}

    EVERYTHING = ["t", "distance", "instance", "primitive", "triangle", "position", "normal", "barycentrics", "shading_normal", "uv",
                  "colour", "front", "on_edge", "node_id", "mesh_id", "material_id"]
    NAMES = ["node", "node_path", "mesh", "material"]
    WIDE = {"position": 3, "normal": 3, "shading_normal": 3, "barycentrics": 2, "uv": 2, "colour": 4}

    def test_columns_have_their_shape_and_type_whatever_is_asked_for(self):
        """One ray and one pixel at a time, none, many; with names and without; fields alone and together."""
        hit, miss = ([-10, 1, 0], [1, 0, 0]), ([1, 10, 0], [0, -1, 0])
        image = lambda part: [[ray[part] for ray in (hit, miss, hit)], [ray[part] for ray in (miss, miss, hit)]]  # noqa: E731
        batches = [((0,), [], []), ((1,), [hit[0]], [hit[1]]), ((1,), [miss[0]], [miss[1]]), ((2,), [hit[0], miss[0]], [hit[1], miss[1]]),
                   ((1, 1), [[hit[0]]], [[hit[1]]]), ((2, 3), image(0), image(1))]
        for lead, origins, directions in batches:
            whole = self.client.closest("six", origins, directions, fields=self.EVERYTHING)
            named = self.client.closest("six", origins, directions, fields=self.EVERYTHING + self.NAMES)
            self.assertEqual(set(named), {*self.EVERYTHING, *self.NAMES, "hit"})
            for name in [*self.EVERYTHING, "hit"]:
                asked = [] if name == "hit" else [name]
                alone = self.client.closest("six", origins, directions, fields=asked or ["t"])
                self.assertEqual(set(alone), {"hit", *(asked or ["t"])})
                for columns in (whole, named, alone):
                    with self.subTest(name, lead=lead):
                        self.assertEqual(self.kind(columns[name]), self.kind(whole[name]))
                        expected = lead + ((self.WIDE[name],) if name in self.WIDE else ())
                        if 0 not in lead or self.numpy:
                            self.assertEqual(self.shape(columns[name]), expected)
                        self.assertEqual(repr(listed(columns[name])), repr(listed(whole[name])))
            for name in self.NAMES:
                self.assertIsInstance(named[name], list)
                self.assertEqual(self.shape(named[name]), lead)
            if 0 not in lead:
                self.assertEqual(self.shape(self.client.any("six", origins, directions)), lead)
                self.assertEqual(self.shape(self.client.count("six", origins, directions)), lead)
            lists = self.client.all("six", origins, directions, fields=["position", "front"])
            again = self.client.all("six", origins, directions, fields=["position", "front", "node"])
            self.assertEqual(set(again) - set(lists), {"node"})
            for name in lists:
                self.assertEqual((repr(listed(lists[name])), self.kind(lists[name])), (repr(listed(again[name])), self.kind(again[name])))
        points = self.client.closest_points("six", [[[-7, 3, 0], [90, 0, 0]]], max_distance=20, fields=["position", "front"])
        self.assertEqual((self.shape(points["position"]), listed(points["hit"])), ((1, 2, 3), [[True, False]]))
        self.assertEqual(self.shape(self.client.distance("six", [[[-7, 3, 0], [90, 0, 0]]])["distance"]), (1, 2))

    def test_a_miss_is_told_by_one_rule(self):
        for fields in (self.EVERYTHING, self.EVERYTHING + self.NAMES):
            miss = self.client.closest("six", ORIGINS[1:2], DIRECTIONS[1:2], fields=fields)
            for name in fields:
                value = listed(miss[name])[0]
                if name in ("t", "distance"):
                    self.assertEqual(value, math.inf)
                elif name in ("front", "on_edge"):
                    self.assertIs(value, False)
                elif name in self.WIDE:
                    self.assertTrue(all(map(math.isnan, value)), name)
                else:
                    self.assertEqual(value, None if name in self.NAMES else -1)
            self.assertEqual(listed(miss["hit"]), [False])

    def test_the_rays_of_a_camera_are_answered_in_its_shape(self):
        camera = {"kind": "pinhole", "position": [-10, 1, 0], "forward": [1, 0, 0], "width": 3, "height": 2}
        flat = self.server.ask("/v1/scenes/six/rays:closest", "-H", "Content-Type: application/json",
                               body=json.dumps({"generator": camera, "fields": ["t"]})).json()["t"]
        rows = [[math.inf if t is None else t for t in flat[i:i + 3]] for i in (0, 3)]
        for fields in (["t", "position"], ["t", "position", "node"]):
            hits = self.client.closest("six", generator=camera, fields=fields)
            self.assertEqual((listed(hits["t"]), self.shape(hits["position"])), (rows, (2, 3, 3)))
        self.assertEqual(self.shape(self.client.any("six", generator=camera)), (2, 3))

    def test_work_is_told_whatever_is_asked_for(self):
        for fields in (["t"], ["t", "node"]):
            self.assertIn("microseconds", self.client.closest("six", ORIGINS, DIRECTIONS, fields=fields, work=True)["work"])
        self.assertEqual(self.client.distance("six", ORIGINS)["unreliable"]["reason"], "OPEN_EDGES")

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
                self.assertEqual(got, hit)
            else:
                self.assertEqual((hits["t"][i], hits["instance"][i]), (math.inf, -1))

    def test_parts_of_pictures_and_tables(self):
        view = {"kind": "pinhole", "position": [-10, 1, 0], "forward": [1, 0, 0], "width": 9, "height": 7}
        whole = listed(self.client.closest("six", generator=view, fields=["t"])["t"])
        crop = listed(self.client.closest("six", generator={**view, "crop": [2, 1, 4, 3]}, fields=["t"])["t"])
        self.assertEqual(crop, [row[2:6] for row in whole[1:4]])
        pixels = listed(self.client.closest("six", generator={**view, "pixels": [[4, 3], [0, 6]]}, fields=["t"])["t"])
        self.assertEqual(pixels, [whole[3][4], whole[6][0]])
        hits = sum(t != math.inf for row in whole for t in row)
        self.assertIn(f"element vertex {hits}\n".encode(), self.client.table("six", view, fields=["t", "node_id"]))
        self.assertEqual(len(self.client.table("six", view, "csv", fields=["t"]).splitlines()), 1 + 9 * 7)
        with self.assertRaises(ValueError):
            self.client.table("six", view, "obj")

    def test_several_nodes_are_changed_at_once(self):
        self.client.put("changed", demo_glb("six"))
        self.client.patch_nodes("changed", {1: {"hidden": True}, 2: {"mask": 4}})
        nodes = self.client.nodes("changed")
        self.assertEqual([(node["hidden"], node["mask"]) for node in nodes], [(False, 2**32 - 1), (True, 2**32 - 1), (False, 4)])
        self.client.delete("changed")

    def test_nodes_are_added_and_removed(self):
        self.client.put("edited", demo_glb("six"))
        self.client.add_node("edited", 10, 2, parent=0, name="again", translation=[0, 20, 0])
        self.client.patch_nodes("edited", {11: {"copy_of": 10}, 1: {"removed": True}})
        self.assertEqual([(node["node_id"], node["name"], node["parent"]) for node in self.client.nodes("edited")],
                         [(0, "root", None), (2, "right", 0), (10, "again", 0), (11, None, None)])
        vertices = {node["node_id"]: node["vertices"] for node in self.client.nodes("edited", extra=["pose"])}
        triangle = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        self.assertEqual(self.client.set_positions("edited", 11, triangle * (vertices[11] // 3))["bounds"]["min"][2], -2)
        self.assertEqual(self.client.nodes("edited", name="again")[0]["bounds"]["min"][1], 20)
        for wrong in ([], [0, 0, 0], [[0, 0]] * 9, [[0, 0, float("nan")]] * 9, "abc"):
            with self.subTest(wrong), self.assertRaises((ValueError, sightline.SightlineError)):
                self.client.set_positions("edited", 11, wrong)
        with self.assertRaises(sightline.SightlineError) as refused:
            self.client.set_positions("edited", 11, triangle)
        self.assertEqual(refused.exception.code, "NODE_POSITIONS_WRONG")
        self.assertEqual(self.client.remove_node("edited", 0)["counts"]["nodes"], 1)
        with self.assertRaises(sightline.SightlineError) as refused:
            self.client.remove_node("edited", 0)
        self.assertEqual(refused.exception.code, "NODE_NOT_FOUND")
        self.client.delete("edited")

    def test_scenes_come_and_go(self):
        self.assertEqual(self.client.put("mine", demo_glb("six"))["state"], "ready")
        self.assertIn("mine", [scene["id"] for scene in self.client.scenes()])
        self.assertEqual(self.client.scene("mine")["counts"]["triangles"], 6)
        self.assertEqual([node["name"] for node in self.client.nodes("mine")], ["root", "left", "right"])
        found = self.client.nodes("mine", path="/root/r*", extra=["path", "extras"])
        self.assertEqual([(node["path"], node["extras"]) for node in found], [("/root/right", None)])
        self.assertEqual([node["node_id"] for node in self.client.nodes("mine", instance=0)], [1])
        self.assertEqual(self.client.triangles("mine", [(0, 0, 0)])[0]["corners"][1], [-4, 4, 0])
        self.assertEqual(listed(self.client.boxes_count("mine", [{"min": [-9, 0, -9], "max": [0, 9, 9]}])), [3])
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
        self.assertLess(len(sightline._pack(sightline._read_rays(o, d, None, None), {})), 24 + 3 * 48)
        self.assertEqual(self.client.count("six", o, d).tolist(), [6, 0, 1])

    def test_arrays_count_by_value_in_any_layout(self):
        numpy = self.numpy
        for dtype in ("f2", "<f4", ">f4", "<f8", ">f8", "i1", "<i2", ">i4", "<i8", ">i8"):
            o, d = (numpy.array(points, dtype) for points in (ORIGINS, DIRECTIONS))
            wide, backwards = numpy.zeros((6, 6), dtype), o[::-1].copy()
            wide[::2, ::2] = o
            for layout in (o, numpy.asfortranarray(o), wide[::2, ::2], backwards[::-1], numpy.matrix(o), list(o), list(map(list, o))):
                with self.subTest(dtype):
                    self.assertEqual(self.client.closest("six", layout, d, tmax=numpy.full(3, 100, dtype))["t"].tolist(), [4.5, math.inf, 8])
        constant = numpy.broadcast_to(numpy.array([1.0, 0, 0]), (3, 3))
        self.assertEqual(self.client.any("six", ORIGINS, constant).tolist(), [True, False, False])
        self.assertEqual(self.client.any("six", ORIGINS, constant, tmax=numpy.float32(4.5)).tolist(), [True, False, False])
        with self.assertRaisesRegex(ValueError, r"^tmax has shape \(1,\)"):
            self.client.any("six", ORIGINS, constant, tmax=numpy.array([4.5]))

    def test_arrays_of_no_numbers_are_refused(self):
        numpy = self.numpy
        for wrong in (numpy.ones((1, 3), bool), numpy.ones((1, 3), complex), numpy.ones((1, 3), object), numpy.full((1, 3), "1"),
                      numpy.ones((1, 3), numpy.longdouble), numpy.ones((1, 3), "m8[s]"), numpy.ma.masked_equal([[0.0, 1, 2]], 1)):
            with self.subTest(wrong.dtype), self.assertRaisesRegex(ValueError, "^origins (has dtype|is a masked array)"):
                self.client.any("six", wrong, [[1, 0, 0]])
        for empty in (numpy.zeros(0), numpy.zeros((0, 2)), numpy.zeros((3, 0)), numpy.array(1.0)):
            with self.subTest(empty.shape), self.assertRaisesRegex(ValueError, "^points has shape"):
                self.client.closest_points("six", empty)
        with self.assertRaisesRegex(ValueError, r"^origins\[0\]\[0\] is of type bool"):
            self.client.any("six", [numpy.array([True, False, False])], [[1, 0, 0]])

    def test_empty_arrays_have_empty_answers_of_the_right_shape(self):
        empty = self.numpy.zeros((0, 3), "float32")
        for fields in (["t", "position", "front"], ["t", "position", "front", "node"]):
            columns = self.client.closest("six", empty, empty, fields=fields)
            self.assertEqual([columns[name].shape for name in ("t", "position", "front", "hit")], [(0,), (0, 3), (0,), (0,)])
            self.assertEqual(self.client.all("six", empty, empty, fields=fields)["first"].tolist(), [0])
            wide = self.client.closest("six", self.numpy.zeros((4, 0, 3)), self.numpy.zeros((4, 0, 3)), fields=fields)
            self.assertEqual([wide[name].shape for name in ("t", "position")], [(4, 0), (4, 0, 3)])
        self.assertEqual(self.client.closest_points("six", empty, fields=["position"])["position"].shape, (0, 3))
        self.assertEqual(self.client.distance("six", empty)["distance"].shape, (0,))

    def test_columns_can_be_written_to(self):
        for fields in (["t", "front", "position"], ["t", "front", "position", "node"]):
            for column in self.client.closest("six", ORIGINS, DIRECTIONS, fields=fields).values():
                self.assertTrue(isinstance(column, list) or column.flags.writeable)

    def test_options_and_boxes_may_be_arrays(self):
        numpy = self.numpy
        box = {"min": numpy.array([-9, 0, -9]), "max": numpy.array([0, 9, 9], ">f4")}
        self.assertEqual(listed(self.client.boxes_count("six", [box])), [3])
        self.assertEqual(self.client.triangles("six", numpy.array([[0, 0, 0]]))[0]["corners"][1], [-4, 4, 0])
        near = self.client.nearest("six", numpy.array([[-7, 3, 0]]), numpy.int32(2), max_distance=numpy.float32(50))
        self.assertEqual(near["first"].tolist(), [0, 2])


if __name__ == "__main__":
    case_report.main()
