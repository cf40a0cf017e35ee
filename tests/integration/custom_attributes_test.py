"""Vertex attributes of the file's own (_NAME): judged by exact barycentric interpolation of the file's bytes."""

import io
import json
import math
import random
import struct
import subprocess
import sys
import tempfile
import unittest
from fractions import Fraction
from pathlib import Path

import case_report
from attributes_test import WIDTHS, File, Reading, shower, triangle
from sightline_server import BINARY, DATA, JSON_TYPE, PATIENCE, SOURCE, Server, with_document

sys.path.insert(0, str(SOURCE / "proto/python"))
from sightline import Sightline, SightlineError, numpy  # noqa: E402

DOWN = ([1, 2, 9], [0, 0, -1])  # Meets triangle() at (1, 2), with the weights 1/4, 1/4, 1/2.
LINES_TYPE = "Content-Type: application/x-ndjson"
KINDS = ("SCALAR", "VEC2", "VEC3", "VEC4")


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def exact_weights(ray, corners):
    """The barycentric weights of the point where a ray meets the plane of a triangle."""
    origin, direction = ([Fraction(x) for x in ray[key]] for key in ("origin", "direction"))
    a, b, c = ([Fraction(x) for x in corner] for corner in corners)
    edges = [[y - x for x, y in zip(a, other)] for other in (b, c)]
    normal = cross(*edges)
    t = dot(normal, [x - y for x, y in zip(a, origin)]) / dot(normal, direction)
    point = [o + t * d - x for o, d, x in zip(origin, direction, a)]
    u = dot(cross(point, edges[1]), normal) / dot(normal, normal)
    v = dot(cross(edges[0], point), normal) / dot(normal, normal)
    return [1 - u - v, u, v]


def mixed_file(seed):
    """Two meshes of three primitives with _A (one number) to _D (four), in every type and layout; `_D` not everywhere."""
    draw = random.Random(seed)
    file = File()
    count = 60
    types = [(5126, {}), *((component, more) for component in (5120, 5121, 5122, 5123) for more in ({}, {"normalized": True})), (5125, {})]

    def rows(component, width):
        if component == 5126:
            return [[draw.uniform(-1000, 1000) for _ in range(width)] for _ in range(count)]
        low, high = {5120: (-128, 127), 5121: (0, 255), 5122: (-32768, 32767), 5123: (0, 65535), 5125: (0, 2**32 - 1)}[component]
        return [[draw.randint(low, high) for _ in range(width)] for _ in range(count)]

    for mesh in range(2):
        primitives = []
        for number in range(3):
            positions = [[draw.uniform(-1, 1) for _ in range(3)] for _ in range(count)]
            attributes = {"POSITION": file.add(positions, "VEC3", 5126, min=[-1] * 3, max=[1] * 3)}
            for width, name in enumerate(("_A", "_B.x", "_C", "_D"), 1):
                if name == "_D" and number == 1:
                    continue
                component, more = draw.choice(types)
                attributes[name] = file.add_strided(draw, rows(component, width), KINDS[width - 1], component, **more)
                if number == 2:
                    file.replace(draw, attributes[name], rows(component, width)[:9])
            # Not from the first vertex on, so that vertices of the mesh are not those of the accessor.
            corners = [[draw.randint(5, count - 1)] for _ in range(60)]
            primitives.append({"attributes": attributes, "indices": file.add(corners, "SCALAR", 5123)})
        file.root["meshes"].append({"primitives": primitives})
        file.node(mesh, matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4 * mesh, 0, 0, 1])
    return file.bytes()


def one(**more):
    """A file of one triangle with _T = 10, 20, 40 at its corners."""
    return triangle(_T=([[10], [20], [40]], "SCALAR", 5126, {}), **more)


class CustomAttributes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        cls.server = Server("--data", folder.name)
        cls.addClassCleanup(cls.server.end)

    def put(self, file, name="s"):
        answer = self.server.put(name, file if isinstance(file, bytes) else file.bytes())
        self.assertIn(answer.status, (200, 201), answer.body)
        return answer.json()["warnings"]

    def hit(self, fields, name="s", ray=DOWN):
        hit, = self.server.closest(name, ray, fields=fields)
        return hit

    def post(self, question, body, *arguments, name="s"):
        return self.server.ask(f"/v1/scenes/{name}/{question}", "-H", JSON_TYPE, *arguments, body=json.dumps(body))

    def test_by_hand(self):
        self.assertEqual(self.put(one(_W=([[0, 255], [255, 0], [255, 255]], "VEC2", 5121, {"normalized": True}),
                                      _ID=([[7, 70000, 1], [7, 70004, 2], [7, 70008, 3]], "VEC3", 5125, {}))), [])
        # As the file has them, after all other fields and in the order of the request.
        self.assertEqual(list(self.hit(["_W", "t", "_T"]).items()), [("t", 9), ("_W", [0.75, 0.75]), ("_T", 27.5)])
        self.assertEqual(self.hit(["_ID"]), {"_ID": [7, 70005, 2.25]})
        ray = {"origin": DOWN[0], "direction": DOWN[1]}
        self.assertEqual(self.post("rays:all", {"rays": [ray], "fields": ["_T"]}).json()["results"], [{"total": 1, "hits": [{"_T": 27.5}]}])
        points = {"points": [[1, 2, -3]], "fields": ["distance", "_T"]}
        self.assertEqual(self.post("points:closest", points).json()["hits"], [{"distance": 3, "_T": 27.5}])
        self.assertEqual(self.post("points:nearest", points).json()["results"], [{"hits": [{"distance": 3, "_T": 27.5}]}])
        seen = self.post("visibility", {"from": [DOWN[0]], "to": [[1, 2, -9]], "pairing": "each", "first_blocker": True, "fields": ["_T"]})
        self.assertEqual(seen.json()["blockers"], [{"_T": 27.5}])
        # Of a triangle that counts, and of none.
        some = {"rays": [ray], "fields": ["_T"]}
        self.assertEqual(self.post("rays:closest", {**some, "include": {"nodes": [0]}}).json()["hits"], [{"_T": 27.5}])
        self.assertEqual(self.post("rays:closest", {**some, "exclude": {"nodes": [0]}}).json()["hits"], [None])

    def test_every_type_and_layout_against_the_bytes_of_the_file(self):
        for seed in (51, 52):
            glb = mixed_file(seed)
            reading = Reading(glb)
            self.assertEqual(self.put(glb), [])
            rays = shower(seed, 300, [-2, -2, -2], [7, 2, 2])
            names = ["_A", "_B.x", "_C", "_D"]
            fields = [*names, "barycentrics", "mesh_id", "primitive", "triangle", "node_id"]
            hits = self.post("rays:closest", {"rays": rays, "fields": fields}).json()["hits"]
            self.assertGreater(sum(hit is not None for hit in hits), 80)
            nulls = 0
            for i, (ray, hit) in enumerate(zip(rays, hits, strict=True)):
                if hit is None:
                    continue
                corners, primitive = reading.corners(hit)
                offset = reading.root["nodes"][hit["node_id"]]["matrix"][12]
                points = [reading.element(primitive["attributes"]["POSITION"], corner) for corner in corners]
                exact = exact_weights(ray, [[x + offset, y, z] for x, y, z in points])
                u, v = hit["barycentrics"]
                for name in names:
                    told = hit[name]
                    accessor = primitive["attributes"].get(name)
                    if accessor is None:
                        self.assertIsNone(told, f"seed {seed}, ray {i}")
                        nulls += 1
                        continue
                    values = [reading.element(accessor, corner) for corner in corners]
                    told = told if isinstance(told, list) else [told]
                    with self.subTest(seed=seed, ray=i, name=name):
                        # To the last bit from the barycentrics of the answer, and near the exact value.
                        self.assertEqual(told, [(((1 - u) - v) * a + u * b) + v * c for a, b, c in zip(*values)])
                        for got, (a, b, c) in zip(told, zip(*values), strict=True):
                            value = sum(w * Fraction(x) for w, x in zip(exact, (a, b, c)))
                            largest = max(abs(a), abs(b), abs(c))
                            self.assertLessEqual(abs(Fraction(got) - value), Fraction(largest) * 8 / 2**50)
            self.assertGreater(nulls, 3)

    def test_rows_columns_lines_bytes_and_tables_agree(self):
        self.put(mixed_file(53))
        rays = shower(53, 120, [-2, -2, -2], [7, 2, 2])
        fields = ["t", "_D", "_A"]
        rows = self.post("rays:closest", {"rays": rays, "fields": fields}).json()["hits"]
        lines = json.dumps({"options": {"fields": fields}}) + "\n" + "".join(json.dumps(ray) + "\n" for ray in rays)
        answer = self.server.ask("/v1/scenes/s/rays:closest", "-H", LINES_TYPE, body=lines)
        self.assertEqual([json.loads(line) for line in answer.body.splitlines()], rows)
        flat = {"origins": sum((ray["origin"] for ray in rays), []), "directions": sum((ray["direction"] for ray in rays), []), "fields": fields}
        columns = self.post("rays:closest", flat).json()
        self.assertEqual(list(columns), fields)
        binary = self.post("rays:closest", flat, "-H", "Accept: application/octet-stream").body
        csv = self.post("rays:closest", flat, "-H", "Accept: text/csv").body.decode().splitlines()
        self.assertEqual(csv[0], "t,_D_0,_D_1,_D_2,_D_3,_A")
        cells = [[float(cell) if cell else None for cell in line.split(",")] for line in csv[1:]]
        at = 1
        for entry, (field, width) in enumerate((("_D", 4), ("_A", 1)), 1):
            name, kind, wide, begin, count = struct.unpack_from("<16sIIQQ", binary, 16 + 40 * entry)
            self.assertEqual((name.rstrip(b"\0").decode(), kind, wide, count), (field, 1, width, len(rays)))
            for i, row in enumerate(rows):
                value = row and row[field]
                value = [None] * width if value is None else value if width > 1 else [value]
                self.assertEqual(columns[field][width * i:width * i + width], value)
                numbers = struct.unpack_from(f"<{width}d", binary, begin + 8 * width * i)
                self.assertEqual([None if math.isnan(x) else x for x in numbers], value)
                self.assertEqual(cells[i][at:at + width], value)
            at += width
        ply = self.post("rays:closest", flat, "-H", "Accept: application/x-ply").body
        self.assertIn(b"property double _D_3\nproperty double _A\nend_header\n", ply)
        if numpy is None:
            return
        npz = numpy.load(io.BytesIO(self.post("rays:closest", flat, "-H", "Accept: application/x-npz").body))
        npy = numpy.load(io.BytesIO(self.post("rays:closest", flat, "-H", "Accept: application/x-npy").body))
        for field in ("_D", "_A"):
            expected = numpy.array([numpy.nan if x is None else x for x in columns[field]]).reshape(npz[field].shape)
            numpy.testing.assert_array_equal(npz[field], expected)
            numpy.testing.assert_array_equal(npy[field], expected)
        lists = self.post("rays:all", flat, "-H", "Accept: text/csv").body.decode().splitlines()
        self.assertEqual(lists[0], "row,t,_D_0,_D_1,_D_2,_D_3,_A")

    def test_the_bytes_are_those_of_every_kernel_and_number_of_threads(self):
        glb, rays = mixed_file(54), shower(54, 200, [-2, -2, -2], [7, 2, 2])
        answers = set()
        for kernel in self.server.ask("/version").json()["kernels"]:
            for threads in ("1", "2"):
                with Server("--kernel", kernel, "--threads", threads) as server:
                    server.put("s", glb)
                    answers.add(server.query("s", "closest", {"rays": rays, "fields": ["t", "_A", "_B.x", "_C", "_D"]}).body)
        self.assertEqual(len(answers), 1)

    def test_a_name_that_no_primitive_has_is_a_warning(self):
        file = one(_OTHER=([[1], [2], [3]], "SCALAR", 5126, {}))
        # In the file, but in no mesh of the scene.
        file.root["meshes"].append({"primitives": [{"attributes": {**file.root["meshes"][0]["primitives"][0]["attributes"], "_ELSE": 0}}]})
        self.put(file)
        ray = {"origin": DOWN[0], "direction": DOWN[1]}
        for name, similar in (("_t", '; similar: "_T"'), ("_OTHR", '; similar: "_OTHER"'), ("_TEMPERATURE", ""), ("_ELSE", "")):
            body = {"rays": [ray], "fields": ["t", name, "_T"]}
            answer = self.post("rays:closest", body).json()
            self.assertEqual(answer["hits"], [{"t": 9, name: None, "_T": 27.5}])
            warning = {"code": "SELECTION_EMPTY", "pointer": "/fields", "message": f'no primitive has an attribute "{name}"{similar}'}
            self.assertEqual(answer["warnings"], [warning])
            told = self.post("rays:closest", body, "-H", "Accept: application/octet-stream").headers["x-sightline-warnings"]
            self.assertEqual(json.loads(told)["warnings"], [warning])
            refused = self.post("rays:closest", {**body, "strict": True})
            self.assertEqual((refused.status, refused.json()["code"], refused.json()["errors"][0]["pointer"]), (422, "SELECTION_EMPTY", "/fields"))
        lines = json.dumps({"options": {"fields": ["_t"]}}) + "\n" + json.dumps(ray) + "\n"
        refused = self.server.ask("/v1/scenes/s/rays:closest", "-H", LINES_TYPE, body=lines)
        self.assertEqual((refused.status, refused.json()["code"]), (422, "SELECTION_EMPTY"))

    def test_names_and_their_number_have_limits(self):
        self.put(one())
        ray = [{"origin": DOWN[0], "direction": DOWN[1]}]

        def refusal(question, fields, *arguments, **more):
            answer = self.post(question, {**more, "fields": fields}, *arguments)
            return answer.status, answer.json()["code"]

        for name in ("_", "_a b", '_"', "_ä", "_a,b", "_" + "x" * 64, "_" + "x" * 100_000, "TEMPERATURE", "uv2", "_\u0000"):
            self.assertEqual(refusal("rays:closest", ["t", name], rays=ray), (422, "FIELD_UNKNOWN"), name[:80])
        self.assertEqual(refusal("rays:closest", ["_T", "_T"], rays=ray), (422, "FIELD_DUPLICATE"))
        self.assertEqual(refusal("rays:closest", [f"_{i}" for i in range(17)], rays=ray), (413, "FIELDS_TOO_MANY"))
        self.assertEqual(self.post("rays:closest", {"rays": ray, "fields": [f"_{i}" for i in range(16)]}).status, 200)
        for accept in ("application/octet-stream", "application/x-npz"):
            self.assertEqual(self.post("rays:closest", {"rays": ray, "fields": ["_ABCDEFGHIJKLMNO"]}, "-H", f"Accept: {accept}").status, 200)
        bytes_wanted = ("-H", "Accept: application/octet-stream")
        self.assertEqual(refusal("rays:closest", ["_ABCDEFGHIJKLMNOP"], *bytes_wanted, rays=ray), (422, "FIELD_NAME_LONG"))
        self.assertEqual(refusal("points:closest", ["_ABCDEFGHIJKLMNOP"], "-H", "Accept: text/csv", points=[]), (422, "FIELD_NAME_LONG"))
        for question, more in (("sweeps:closest", {"sweeps": []}), ("clearance", {"a": {"nodes": [0]}, "b": {"nodes": [0]}})):
            self.assertEqual(refusal(question, ["_T"], **more), (422, "FIELD_UNKNOWN"))
        self.assertEqual(refusal("rays:any", ["_T"], rays=ray), (422, "KEY_UNKNOWN"))

    def test_what_is_wrong_with_one_is_a_warning_and_null(self):
        def spoiled(change):
            file = one(TEXCOORD_0=([[0, 0], [1, 0], [0, 1]], "VEC2", 5126, {}))
            attributes = file.root["meshes"][0]["primitives"][0]["attributes"]
            change(attributes, file.root["accessors"][attributes["_T"]])
            return file

        cases = {
            "no such accessor": lambda attributes, _: attributes.update(_T=99),
            "no accessor": lambda attributes, _: attributes.update(_T="x"),
            "too few": lambda _, accessor: accessor.update(count=2),
            "too many": lambda _, accessor: accessor.update(count=4),
            "beyond the view": lambda _, accessor: accessor.update(byteOffset=4096),
            "not aligned": lambda _, accessor: accessor.update(byteOffset=1, componentType=5123),
            "another's view": lambda _, accessor: accessor.update(bufferView=0),
            **{f"a {kind}": lambda _, accessor, kind=kind: accessor.update(type=kind) for kind in ("MAT2", "MAT3", "MAT4")},
        }
        for name, change in cases.items():
            warnings = self.put(spoiled(change))
            with self.subTest(name):
                self.assertEqual([warning for warning in warnings if "left out" not in warning], [])
                self.assertEqual(len(warnings), 1, warnings)
                self.assertEqual(self.hit(["t", "uv", "_T"]), {"t": 9, "uv": [0.25, 0.5], "_T": None})
        refused = self.server.put("refused", spoiled(lambda _, accessor: accessor.update(componentType=5124)).bytes())
        self.assertEqual(refused.status, 422)
        self.put(spoiled(lambda _, accessor: accessor.update(componentType=5121)))
        self.assertEqual(self.hit(["_T"]), {"_T": 16}, "the first bytes of 10.0, as uint8, are 0, 0 and 32")

    def test_numbers_that_are_none_are_null(self):
        self.put(triangle(_T=([[1], [math.nan], [2]], "SCALAR", 5126, {}), _V=([[1, 1, math.inf]] * 3, "VEC3", 5126, {})))
        self.assertEqual(self.hit(["_T", "_V"]), {"_T": None, "_V": None})

    def test_an_attribute_has_one_type_in_a_file(self):
        file = one()
        first = file.root["meshes"][0]["primitives"][0]
        moved = file.add([[10, 0, 0], [14, 0, 0], [10, 4, 0]], "VEC3", 5126, min=[10, 0, 0], max=[14, 4, 0])
        second = {**first, "attributes": {"POSITION": moved, "_T": file.add([[1, 2]] * 3, "VEC2", 5126)}}
        file.root["meshes"][0]["primitives"].append(second)
        warnings = self.put(file)
        self.assertEqual(warnings, ["mesh 0, primitive 1: _T was left out: accessor 4 is of another type than its attribute has"])
        self.assertEqual(self.hit(["_T"]), {"_T": 27.5})
        self.assertEqual(self.hit(["_T"], ray=([11, 2, 9], [0, 0, -1])), {"_T": None})

    def test_hostile_names(self):
        # 10,000 attributes of one primitive: the first 256 in the order of their names.
        file = one()
        attributes = file.root["meshes"][0]["primitives"][0]["attributes"]
        shared = attributes["_T"]
        attributes.update({f"_X{i:05}": shared for i in range(10_000)})
        warnings = self.put(file)
        self.assertEqual(len(warnings), 1, warnings[:3])
        self.assertIn('9745 attributes of primitives were left out, such as "_X00255": hits have the first 256 names', warnings[0])
        self.assertEqual(self.hit(["_T", "_X00254", "_X00255"]), {"_T": 27.5, "_X00254": 27.5, "_X00255": None})
        # A name of 1 MB, and others that are no fields.
        file = one()
        attributes = file.root["meshes"][0]["primitives"][0]["attributes"]
        attributes.update({name: shared for name in ("_" + "N" * (1 << 20), "_", "_a b", '_"', "_ä")})
        warnings = self.put(file)
        self.assertEqual(len(warnings), 1, [each[:200] for each in warnings])
        self.assertRegex(warnings[0], "^5 attributes of primitives were left out, such as ")
        self.assertLess(len(warnings[0]), 400)
        self.assertEqual(self.hit(["_T"]), {"_T": 27.5})

    def test_posed_meshes_moved_nodes_and_restarts_keep_them(self):
        file = one(_V=([[1, 0, 0]] * 3, "VEC3", 5126, {}), JOINTS_0=([[0] * 4] * 3, "VEC4", 5121, {}),
                   WEIGHTS_0=([[1, 0, 0, 0]] * 3, "VEC4", 5126, {}))
        primitive = file.root["meshes"][0]["primitives"][0]
        primitive["targets"] = [{"POSITION": file.add([[0, 0, 1]] * 3, "VEC3", 5126, min=[0, 0, 1], max=[0, 0, 1]),
                                 "_T": file.add([[8]] * 3, "SCALAR", 5126)}]
        file.root["meshes"][0]["weights"] = [0.5]
        file.root["nodes"].append({"name": "joint"})
        file.root["scenes"][0]["nodes"].append(1)
        file.root["nodes"][0]["skin"] = 0
        file.root["skins"] = [{"joints": [1]}]
        with tempfile.TemporaryDirectory() as folder:
            with Server("--data", folder) as server:
                self.assertEqual(server.put("posed", file.bytes()).json()["warnings"], [])
                self.assertEqual(server.closest("posed", DOWN, fields=["t", "_T", "_V"]), [{"t": 8.5, "_T": 31.5, "_V": [1, 0, 0]}])
                moved = server.ask("/v1/scenes/posed/nodes/1", "-X", "PATCH", "-H", JSON_TYPE, body='{"rotation":[0,0,1,0],"translation":[0,0,2]}')
                self.assertEqual(moved.status, 200, moved.body)
                # A turned joint turns normals, not these.
                at = ([-1, -2, 9], [0, 0, -1])
                self.assertEqual(server.closest("posed", at, fields=["t", "_T", "_V"]), [{"t": 6.5, "_T": 31.5, "_V": [1, 0, 0]}])
                weighed = server.ask("/v1/scenes/posed/nodes/0", "-X", "PATCH", "-H", JSON_TYPE, body='{"weights":[2]}')
                self.assertEqual(weighed.status, 200, weighed.body)
                expected = [{"t": 5, "_T": 43.5, "_V": [1, 0, 0]}]
                self.assertEqual(server.closest("posed", at, fields=["t", "_T", "_V"]), expected)
            with Server("--data", folder) as server:
                self.assertEqual(server.closest("posed", at, fields=["t", "_T", "_V"]), expected)

    def test_nothing_is_read_for_those_who_do_not_ask(self):
        # From 1 MiB on a file stays where it is.
        self.put(one().bytes() + bytes(1 << 20), "quiet")

        def read():
            return self.server.ask("/v1/scenes/quiet/stats").json()["bytes"]["by_kind"]["attributes"]

        self.hit(["t", "position", "barycentrics", "uv"], "quiet")
        self.assertEqual(read(), 0)
        self.hit(["_T"], "quiet")
        self.assertEqual(read(), 12)

    def test_the_command_line_has_them(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "one.glb")
            path.write_bytes(one().bytes())
            self.put(path.read_bytes())
            ray = ["--origin", "1,2,9", "--direction", "0,0,-1", "--format", "json"]
            for command in (["cast", path], ["query", self.server.url, "s"]):
                for mode, answer in (([], {"t": 9, "_T": 27.5}), (["--all"], {"total": 1, "hits": [{"t": 9, "_T": 27.5}]})):
                    done = subprocess.run([BINARY, *command, *ray, "--fields", "_T,t", *mode], capture_output=True, text=True, timeout=PATIENCE, check=False)
                    self.assertEqual((done.returncode, json.loads(done.stdout)), (0, answer), done.stderr)
                done = subprocess.run([BINARY, *command, *ray, "--fields", "_t"], capture_output=True, text=True, timeout=PATIENCE, check=False)
                self.assertEqual(done.returncode, 2)
                self.assertIn('no primitive has an attribute "_t"; similar: "_T"', done.stderr)

    def test_the_python_client_has_them(self):
        long = "_A_NAME_OF_MORE_THAN_16_BYTES"
        self.put(one(**{"_V": ([[1, 2, 3]] * 3, "VEC3", 5126, {}), long: ([[4, 5]] * 3, "VEC2", 5121, {})}))
        origins, directions = [DOWN[0], [9, 9, 9]], [DOWN[1]] * 2
        with Sightline(self.server.url) as client:
            for fields in (["_T", "_V"], ["node", "_T", "_V"], ["_T", "_V", long]):
                answer = client.closest("s", origins, directions, fields=fields)
                columns = {name: answer[name].tolist() if hasattr(answer[name], "tolist") else answer[name] for name in fields}
                self.assertEqual((columns["_T"][0], columns["_V"][0]), (27.5, [1, 2, 3]))
                self.assertTrue(math.isnan(columns["_T"][1]) and all(map(math.isnan, columns["_V"][1])))
                if long in fields:
                    self.assertEqual(columns[long][0], [4, 5])
            self.assertEqual([list(row) for row in client.all("s", origins, directions, fields=["_V"])["_V"]], [[1, 2, 3]])
            self.assertEqual(list(client.closest_points("s", [[1, 2, -3]], fields=["_T"])["_T"]), [27.5])
            with self.assertRaisesRegex(SightlineError, "FIELD_NAME_LONG"):
                client.closest_points("s", [[1, 2, -3]], fields=[long])

    def test_compressed_attributes_of_the_shared_data(self):
        def doubled(document):
            """Positions once more, as an attribute of the file's own."""
            for mesh in document["meshes"]:
                for primitive in mesh["primitives"]:
                    for attributes in (primitive["attributes"], *(each["attributes"] for each in primitive.get("extensions", {}).values())):
                        attributes["_POSITION"] = attributes["POSITION"]

        for name in ("spot_draco", "spot_meshopt", "spot_quantized"):
            path = DATA / f"scenes/{name}.glb"
            if not path.exists():
                self.skipTest(f"there is no {path}")
            self.assertEqual(self.put(with_document(path.read_bytes(), doubled)), [])
            bounds = self.server.ask("/v1/scenes/s").json()["bounds"]
            poses = {each["node_id"]: each["matrix"] for each in self.server.ask("/v1/scenes/s/nodes?with=pose").json()["nodes"]}
            rays = [(ray["origin"], ray["direction"]) for ray in shower(7, 200, bounds["min"], bounds["max"])]
            hits = list(filter(None, self.server.closest("s", *rays, fields=["position", "node_id", "_POSITION"])))
            self.assertGreater(len(hits), 40, name)
            for hit in hits:
                m = poses[hit["node_id"]]
                for k in range(3):
                    placed = m[12 + k] + sum(m[4 * i + k] * hit["_POSITION"][i] for i in range(3))
                    # Positions of the scene are rounded to float32.
                    self.assertAlmostEqual(placed, hit["position"][k], delta=1e-6, msg=name)


if __name__ == "__main__":
    case_report.main()
