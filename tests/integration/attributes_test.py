"""Shading normals, texture coordinates and colours of hits: by hand, and by an own reading of the file's bytes."""

import json
import math
import random
import struct
import tempfile
import unittest
from fractions import Fraction

import case_report
from sightline_server import JSON_TYPE, Server, shared_scene

FIELDS = ["shading_normal", "uv", "colour"]
FORMATS = {5120: ("b", 127), 5121: ("B", 255), 5122: ("h", 32767), 5123: ("H", 65535), 5125: ("I", None), 5126: ("f", None)}
MAPPED_FROM = 1 << 20  # core/store/file_bytes.h
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class File:
    """A .glb under construction."""

    def __init__(self):
        self.binary = b""
        self.root = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "accessors": [],
                     "bufferViews": []}

    def view(self, data, **more):
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **more})
        self.binary += data + b"\0" * (-len(data) % 4)
        return len(self.root["bufferViews"]) - 1

    def add(self, rows, kind, component, **more):
        """An accessor with a view of its own."""
        letter = FORMATS[component][0]
        data = b"".join(struct.pack(f"<{len(row)}{letter}", *row) for row in rows)
        return self.accessor(self.view(data), len(rows), kind, component, **more)

    def add_strided(self, draw, rows, kind, component, **more):
        """As add(), with a stride at random."""
        letter = FORMATS[component][0]
        size = struct.calcsize("<" + letter) * len(rows[0])
        stride = size + (-size % 4) + 4 * draw.randint(0, 2)
        packed = b"".join(struct.pack(f"<{len(row)}{letter}", *row).ljust(stride, b"\xff") for row in rows)
        return self.accessor(self.view(packed, byteStride=stride), len(rows), kind, component, **more)

    def replace(self, draw, accessor, rows):
        """Makes an accessor sparse: `rows` stand for elements at random."""
        entry = self.root["accessors"][accessor]
        letter = FORMATS[entry["componentType"]][0]
        replaced = sorted(draw.sample(range(entry["count"]), len(rows)))
        values = b"".join(struct.pack(f"<{len(row)}{letter}", *row) for row in rows)
        entry["sparse"] = {
            "count": len(rows), "indices": {"bufferView": self.view(struct.pack(f"<{len(rows)}H", *replaced)), "componentType": 5123},
            "values": {"bufferView": self.view(values)}}

    def accessor(self, view, count, kind, component, **more):
        self.root["accessors"].append({"bufferView": view, "componentType": component, "count": count, "type": kind, **more})
        return len(self.root["accessors"]) - 1

    def node(self, mesh, **more):
        self.root["nodes"].append({"mesh": mesh, **more})
        self.root["scenes"][0]["nodes"].append(len(self.root["nodes"]) - 1)

    def bytes(self):
        text = json.dumps({**self.root, "buffers": [{"byteLength": len(self.binary)}]}).encode()
        text += b" " * (-len(text) % 4)
        return (struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(self.binary)) + struct.pack("<II", len(text), 0x4E4F534A) + text
                + struct.pack("<II", len(self.binary), 0x004E4942) + self.binary)


def triangle(**attributes):
    """(0,0,0) (4,0,0) (0,4,0) with attributes given as (rows, type, component, more)."""
    file = File()
    indices = file.add([[0], [1], [2]], "SCALAR", 5123)
    named = {"POSITION": file.add([[0, 0, 0], [4, 0, 0], [0, 4, 0]], "VEC3", 5126, min=[0, 0, 0], max=[4, 4, 0])}
    for name, (rows, kind, component, more) in attributes.items():
        named[name] = file.add(rows, kind, component, **more)
    file.root["meshes"].append({"primitives": [{"attributes": named, "indices": indices}]})
    file.node(0)
    return file


FLAT = {"NORMAL": ([[0, 0, 1], [0, 1, 0], [1, 0, 0]], "VEC3", 5126, {}),
        "TEXCOORD_0": ([[0, 0], [65535, 0], [0, 65535]], "VEC2", 5123, {"normalized": True}),
        "COLOR_0": ([[255, 0, 0, 51], [0, 255, 0, 51], [0, 0, 255, 51]], "VEC4", 5121, {"normalized": True})}


class Reading:
    """What the file's own bytes say, by nothing of the product."""

    def __init__(self, glb):
        length, = struct.unpack_from("<I", glb, 12)
        self.root = json.loads(glb[20:20 + length])
        self.binary = glb[28 + length:]

    def element(self, accessor, index):
        source = self.root["accessors"][accessor]
        letter, most = FORMATS[source["componentType"]]
        width = WIDTHS[source["type"]]
        size = struct.calcsize("<" + letter) * width
        values = (0,) * width
        if "bufferView" in source:
            view = self.root["bufferViews"][source["bufferView"]]
            at = view.get("byteOffset", 0) + source.get("byteOffset", 0) + index * view.get("byteStride", size)
            values = struct.unpack_from(f"<{width}{letter}", self.binary, at)
        if "sparse" in source:
            sparse = source["sparse"]
            first, second = (self.root["bufferViews"][sparse[part]["bufferView"]]["byteOffset"] for part in ("indices", "values"))
            replaced = struct.unpack_from(f"<{sparse['count']}{FORMATS[sparse['indices']['componentType']][0]}", self.binary, first)
            if index in replaced:
                values = struct.unpack_from(f"<{width}{letter}", self.binary, second + replaced.index(index) * size)
        return [max(x / most, -1.0) if source.get("normalized") else float(x) for x in values]

    def corners(self, hit):
        """Vertex numbers of the triangle that a hit names, and its primitive."""
        primitive = self.root["meshes"][hit["mesh_id"]]["primitives"][hit["primitive"]]
        k = 3 * hit["triangle"]
        if "indices" not in primitive:
            return [k, k + 1, k + 2], primitive
        return [int(self.element(primitive["indices"], k + i)[0]) for i in range(3)], primitive

    def matrix(self, node):
        m = self.root["nodes"][node].get("matrix")
        if m:
            return [[Fraction(m[4 * j + i]) for j in range(3)] for i in range(3)]
        return [[Fraction(int(i == j)) for j in range(3)] for i in range(3)]

    def expected(self, hit):
        """[shading_normal within 1e-12, uv and colour to the last bit]."""
        corners, primitive = self.corners(hit)
        u, v = hit["barycentrics"]
        weights = [(1 - u) - v, u, v]

        def mixed(name):
            accessor = primitive["attributes"].get(name)
            if accessor is None:
                return None
            rows = [self.element(accessor, corner) for corner in corners]
            return [(weights[0] * a + weights[1] * b) + weights[2] * c for a, b, c in zip(*rows)]

        colour = mixed("COLOR_0")
        normal = mixed("NORMAL")
        if normal:
            m = self.matrix(hit["node_id"])
            cofactors = [[m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3]
                          - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3] for j in range(3)] for i in range(3)]
            sign = 1 if sum(a * b for a, b in zip(m[0], cofactors[0])) > 0 else -1
            turned = [float(sign * sum(c * Fraction(n) for c, n in zip(row, normal))) for row in cofactors]
            length = math.hypot(*turned)
            normal = [x / length for x in turned]
        return [normal, mixed("TEXCOORD_0"), colour and (colour + [1.0])[:4]]


def shower(seed, count, low, high):
    """Rays between random points of two boxes around the scene."""
    draw = random.Random(seed)

    def point():
        return [draw.uniform(a, b) for a, b in zip(low, high)]

    rays = []
    while len(rays) < count:
        a, b = point(), point()
        rays.append({"origin": a, "direction": [y - x for x, y in zip(a, b)]})
    return rays


def random_file(seed):
    """Two meshes of several primitives, in every type and layout that glTF has for these attributes."""
    draw = random.Random(seed)
    file = File()
    count = 90
    kinds = {"NORMAL": [(5126, {}), (5120, {"normalized": True}), (5122, {"normalized": True})],
             "TEXCOORD_0": [(5126, {}), (5121, {"normalized": True}), (5123, {"normalized": True})],
             "COLOR_0": [(5126, {}), (5121, {"normalized": True}), (5123, {"normalized": True})]}

    def numbers(component, width, name):
        if component == 5126:
            low = 0 if name == "COLOR_0" else -2
            return [[draw.uniform(low, 2) for _ in range(width)] for _ in range(count)]
        most = FORMATS[component][1]
        low = -most - 1 if component in (5120, 5122) else 0
        return [[draw.randint(low, most) for _ in range(width)] for _ in range(count)]

    for _ in range(2):
        primitives = []
        for number in range(3):
            positions = [[draw.uniform(-1, 1) for _ in range(3)] for _ in range(count)]
            attributes = {"POSITION": file.add(positions, "VEC3", 5126, min=[-1] * 3, max=[1] * 3)}
            for name, width in (("NORMAL", 3), ("TEXCOORD_0", 2), ("COLOR_0", draw.choice([3, 4]))):
                component, more = draw.choice(kinds[name])
                attributes[name] = file.add_strided(draw, numbers(component, width, name), f"VEC{width}", component, **more)
                if number == 1:
                    file.replace(draw, attributes[name], numbers(component, width, name)[:9])
            if draw.random() < 0.3:
                del attributes[draw.choice(["NORMAL", "TEXCOORD_0", "COLOR_0"])]
            primitive = {"attributes": attributes}
            if number != 2:
                # Not from the first vertex on, so that vertices of the mesh are not those of the accessor.
                corners = [[draw.randint(10, count - 1)] for _ in range(60)]
                primitive["indices"] = file.add(corners, "SCALAR", draw.choice([5121, 5123, 5125]))
            primitives.append(primitive)
        file.root["meshes"].append({"primitives": primitives})
    for node in range(4):
        m = [draw.uniform(-1.5, 1.5) for _ in range(9)]
        file.node(node % 2, matrix=[*m[:3], 0, *m[3:6], 0, *m[6:], 0, 3.0 * node, 0, 0, 1])
    return file.bytes()


class Attributes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.servers = {"kept": Server("--data", cls.folder.name), "in memory": Server()}

    @classmethod
    def tearDownClass(cls):
        for server in cls.servers.values():
            server.end()
        cls.folder.cleanup()

    def each(self, name, glb):
        for kind, server in self.servers.items():
            # Small files are read and not mapped, and what is behind the end of a GLB is nobody's.
            answer = server.put(name, glb + bytes(MAPPED_FROM if kind == "kept" else 0))
            self.assertIn(answer.status, (200, 201), answer.body)
            yield server

    def attributes_touched(self, server, name):
        bytes_of = server.ask(f"/v1/scenes/{name}/stats").json()["bytes"]
        self.assertEqual(sum(bytes_of["by_kind"].values()), bytes_of["touched"])
        return bytes_of["by_kind"]["attributes"]

    def test_by_hand(self):
        # The point (1, 2) has the weights 1/4, 1/4, 1/2.
        for server in self.each("triangle", triangle(**FLAT).bytes()):
            down = {"origin": [1, 2, 9], "direction": [0, 0, -1]}
            row, = server.query("triangle", "closest", {"rays": [down], "fields": FIELDS}).json()["hits"]
            self.assertEqual((row["uv"], row["colour"]), ([0.25, 0.5], [0.25, 0.25, 0.5, 0.2]))
            for got, exact in zip(row["shading_normal"], [2 / 6**0.5, 1 / 6**0.5, 1 / 6**0.5]):
                self.assertAlmostEqual(got, exact, delta=1e-15)
            nearest = server.ask("/v1/scenes/triangle/points:closest", body=json.dumps({"points": [[1, 2, -3]], "fields": FIELDS})).json()
            self.assertEqual(nearest["hits"], [row])
            every = server.query("triangle", "all", {"rays": [down], "fields": ["uv"]}).json()
            self.assertEqual(every["results"], [{"total": 1, "hits": [{"uv": [0.25, 0.5]}]}])

    def test_a_mirror_and_an_uneven_scale_turn_normals_by_the_inverse_transpose(self):
        file = triangle(NORMAL=([[3, 3, 3]] * 3, "VEC3", 5126, {}))
        file.root["nodes"][0]["scale"] = [-2, 1, 4]
        for server in self.each("scaled", file.bytes()):
            # (1,1,1) over (-2,1,4) is (-2,4,1)/4, of length sqrt(21)/4.
            hit, = server.closest("scaled", ([-1, 1, 9], [0, 0, -1]), fields=["shading_normal", "front"])
            for got, exact in zip(hit["shading_normal"], [-2 / 21**0.5, 4 / 21**0.5, 1 / 21**0.5]):
                self.assertAlmostEqual(got, exact, delta=1e-15)
            server.ask("/v1/scenes/scaled/nodes/0", "-X", "PATCH", "-H", JSON_TYPE, body='{"scale":[1,1,1]}')
            hit, = server.closest("scaled", ([1, 1, 9], [0, 0, -1]), fields=["shading_normal"])
            for got in hit["shading_normal"]:
                self.assertAlmostEqual(got, 1 / 3**0.5, delta=1e-15)

    def test_what_the_file_does_not_say_is_null(self):
        for server in self.each("bare", triangle().bytes()):
            rays = [{"origin": [1, 1, 9], "direction": [0, 0, -1]}, {"origin": [1, 1, 9], "direction": [0, 0, 1]}]
            self.assertEqual(server.query("bare", "closest", {"rays": rays, "fields": FIELDS}).json()["hits"],
                             [{"shading_normal": None, "uv": None, "colour": None}, None])
            columns = {"origins": [1, 1, 9] * 2, "directions": [0, 0, -1, 0, 0, 1], "fields": FIELDS}
            self.assertEqual(server.query("bare", "closest", columns).json(),
                             {"shading_normal": [None] * 6, "uv": [None] * 4, "colour": [None] * 8})
            self.assertEqual(self.attributes_touched(server, "bare"), 0)

    def test_numbers_that_are_none_are_null(self):
        inf = float("inf")
        spoilt = {"NORMAL": ([[0, 0, 0]] * 3, "VEC3", 5126, {}), "TEXCOORD_0": ([[0, inf]] * 3, "VEC2", 5126, {}),
                  "COLOR_0": ([[0, float("nan"), 1]] * 3, "VEC3", 5126, {})}
        for server in self.each("spoilt", triangle(**spoilt).bytes()):
            self.assertEqual(server.closest("spoilt", ([1, 1, 9], [0, 0, -1]), fields=FIELDS),
                             [{"shading_normal": None, "uv": None, "colour": None}])

    def test_what_is_wrong_with_them_is_a_warning_and_null(self):
        def spoil(change):
            file = triangle(**FLAT)
            attributes = file.root["meshes"][0]["primitives"][0]["attributes"]
            change(attributes, [file.root["accessors"][attributes[name]] for name in FLAT])
            return file.bytes()

        def no_view_for(attributes, accessors):
            for accessor in accessors:
                accessor["bufferView"] = 0

        cases = {
            "no such accessor": lambda attributes, accessors: attributes.update(NORMAL=99, TEXCOORD_0=-1, COLOR_0="x"),
            "too few": lambda attributes, accessors: [accessor.update(count=2) for accessor in accessors],
            "beyond the view": lambda attributes, accessors: [accessor.update(byteOffset=4096) for accessor in accessors],
            "another's view": no_view_for,
            "another type": lambda attributes, accessors: [accessor.update(type="SCALAR") for accessor in accessors],
            "a matrix": lambda attributes, accessors: [accessor.update(type="MAT2") for accessor in accessors],
            "integers as they are": lambda attributes, accessors: [accessor.update(componentType=5121, normalized=False)
                                                                   for accessor in accessors],
            "uint32": lambda attributes, accessors: [accessor.update(componentType=5125, normalized=True) for accessor in accessors],
        }
        for name, change in cases.items():
            for server in self.each("wrong", spoil(change)):
                with self.subTest(name):
                    self.assertEqual(server.closest("wrong", ([1, 1, 9], [0, 0, -1]), fields=["t", *FIELDS]),
                                     [{"t": 9, "shading_normal": None, "uv": None, "colour": None}])
                    warnings = server.ask("/v1/scenes/wrong").json()["warnings"]
                    self.assertEqual(sum("left out" in warning for warning in warnings), 3, warnings)

    def test_every_type_and_layout_against_the_bytes_of_the_file(self):
        for seed in (20, 21):
            glb = random_file(seed)
            reading = Reading(glb)
            rays = shower(seed, 400, [-2, -2, -2], [11, 2, 2])
            for server in self.each("random", glb):
                self.check(server, "random", reading, rays, seed, at_least=200)

    def check(self, server, name, reading, rays, seed, at_least, with_normals=True):
        fields = [*FIELDS, "barycentrics", "mesh_id", "primitive", "triangle", "node_id"]
        hits = server.query(name, "closest", {"rays": rays, "fields": fields}).json()["hits"]
        self.assertGreaterEqual(sum(hit is not None for hit in hits), at_least, f"seed {seed}")
        for i, hit in enumerate(hits):
            if hit is None:
                continue
            normal, uv, colour = reading.expected(hit)
            self.assertEqual((hit["uv"], hit["colour"]), (uv, colour), f"seed {seed}, ray {i}")
            if normal is None:
                self.assertIsNone(hit["shading_normal"], f"seed {seed}, ray {i}")
                continue
            for got, exact in zip(hit["shading_normal"], normal if with_normals else hit["shading_normal"]):
                self.assertAlmostEqual(got, exact, delta=1e-11, msg=f"seed {seed}, ray {i}")
        return hits

    def test_rows_columns_lines_and_bytes_agree(self):
        glb, rays = random_file(22), shower(22, 200, [-2, -2, -2], [11, 2, 2])
        for server in self.each("random", glb):
            rows = server.query("random", "closest", {"rays": rays, "fields": FIELDS}).json()["hits"]
            lines = json.dumps({"options": {"fields": FIELDS}}) + "\n" + "".join(json.dumps(ray) + "\n" for ray in rays)
            answer = server.ask("/v1/scenes/random/rays:closest", "-H", "Content-Type: application/x-ndjson", body=lines)
            self.assertEqual([json.loads(line) for line in answer.body.splitlines()], rows)
            flat = {"origins": sum((ray["origin"] for ray in rays), []), "directions": sum((ray["direction"] for ray in rays), [])}
            columns = server.query("random", "closest", {**flat, "fields": FIELDS}).json()
            binary = server.query("random", "closest", {**flat, "fields": FIELDS}, "-H", "Accept: application/octet-stream").body
            for entry, (field, width) in enumerate((("shading_normal", 3), ("uv", 2), ("colour", 4))):
                name, kind, wide, at, count = struct.unpack_from("<16sIIQQ", binary, 16 + 40 * entry)
                self.assertEqual((name.rstrip(b"\0").decode(), kind, wide, count), (field, 1, width, len(rays)))
                for i, row in enumerate(rows):
                    value = (row and row[field]) or [None] * width
                    self.assertEqual(columns[field][width * i:width * i + width], value)
                    numbers = struct.unpack_from(f"<{width}d", binary, at + 8 * width * i)
                    self.assertEqual([None if math.isnan(x) else x for x in numbers], value)

    def test_nothing_is_read_for_those_who_do_not_ask(self):
        server = self.servers["kept"]
        server.put("quiet", triangle(**FLAT).bytes() + bytes(MAPPED_FROM))
        down = {"origin": [1, 2, 9], "direction": [0, 0, -1]}
        every_other = ["t", "position", "normal", "barycentrics", "material", "node_path", "on_edge"]
        for body in ({"rays": [down] * 100}, {"rays": [down], "fields": every_other}, {"rays": [{**down, "tmax": 1}], "fields": FIELDS}):
            self.assertEqual(server.query("quiet", "closest", body).status, 200)
            self.assertEqual(self.attributes_touched(server, "quiet"), 0)
        # Three vertices of 2 uint16, then of 3 float32 and 4 uint8 as well.
        server.query("quiet", "closest", {"rays": [down], "fields": ["uv"]})
        self.assertEqual(self.attributes_touched(server, "quiet"), 12)
        server.query("quiet", "closest", {"rays": [down], "fields": FIELDS})
        self.assertEqual(self.attributes_touched(server, "quiet"), 12 + 12 + 36 + 12)
        # Without a data folder there is nothing to come back to: they are copied at once, and never read again.
        server = self.servers["in memory"]
        server.put("quiet", triangle(**FLAT).bytes())
        self.assertEqual(self.attributes_touched(server, "quiet"), 60)
        server.query("quiet", "closest", {"rays": [down], "fields": FIELDS})
        self.assertEqual(self.attributes_touched(server, "quiet"), 60)

    def test_a_restart_changes_nothing(self):
        glb, rays = random_file(23), shower(23, 100, [-2, -2, -2], [11, 2, 2])
        with tempfile.TemporaryDirectory() as folder:
            answers = []
            for start in range(2):
                with Server("--data", folder) as server:
                    if start == 0:
                        server.put("stays", glb)
                    answers.append(server.query("stays", "closest", {"rays": rays, "fields": FIELDS}).body)
        self.assertEqual(*answers)

    def test_a_morph_target_moves_what_it_has(self):
        file = triangle(**FLAT)
        primitive = file.root["meshes"][0]["primitives"][0]
        primitive["targets"] = [{"POSITION": file.add([[0, 0, 1]] * 3, "VEC3", 5126, min=[0, 0, 1], max=[0, 0, 1])},
                                {"COLOR_0": file.add([[0.5] * 4] * 3, "VEC4", 5126)}]
        plain = None
        for weights, added in (([0, 0], 0), ([1, 0], 0), ([0, 1], 0.5)):
            file.root["meshes"][0]["weights"] = weights
            for server in self.each("posed", file.bytes()):
                hit, = server.closest("posed", ([1, 2, 9], [0, 0, -1]), fields=FIELDS)
                plain = plain or hit
                self.assertEqual((hit["shading_normal"], hit["uv"]), (plain["shading_normal"], plain["uv"]))
                for got, before in zip(hit["colour"], plain["colour"], strict=True):
                    self.assertAlmostEqual(got, before + added, delta=1e-15)

    def test_a_skinned_figure_of_the_shared_data(self):
        glb = shared_scene(self, "knight_skinned.glb")
        reading = Reading(glb)
        skinned = {i for i, node in enumerate(reading.root["nodes"]) if "skin" in node}
        for server in self.each("knight", glb):
            bounds = server.ask("/v1/scenes/knight").json()["bounds"]
            hits = self.check(server, "knight", reading, shower(1, 400, bounds["min"], bounds["max"]), 1, 40, with_normals=False)
            self.assertTrue(any(hit and hit["uv"] for hit in hits))
            self.assertTrue(any(hit and hit["node_id"] in skinned for hit in hits))

    def test_instances_of_the_shared_data_have_their_normals(self):
        for server in self.each("city", shared_scene(self, "city_gpu_instancing.glb")):
            bounds = server.ask("/v1/scenes/city").json()["bounds"]
            rays = shower(2, 300, bounds["min"], bounds["max"])
            hits = server.query("city", "closest", {"rays": rays, "fields": ["normal", "shading_normal"]}).json()["hits"]
            self.assertGreater(sum(hit is not None for hit in hits), 50)
            for hit in filter(None, hits):
                self.assertAlmostEqual(math.hypot(*hit["shading_normal"]), 1, delta=1e-15)
                # The sign is another one where an instance is a mirror image.
                self.assertGreater(abs(sum(a * b for a, b in zip(hit["shading_normal"], hit["normal"]))), 0.9)

    def test_instances_are_numbered_within_their_node(self):
        glb = shared_scene(self, "city_gpu_instancing.glb")
        reading = Reading(glb)
        for server in self.each("city", glb):
            bounds = server.ask("/v1/scenes/city").json()["bounds"]
            rays = shower(3, 300, bounds["min"], bounds["max"])
            hits = server.query("city", "closest", {"rays": rays, "fields": ["instance", "node_id", "node_instance"]}).json()["hits"]
            first = {}
            for hit in filter(None, hits):
                node = reading.root["nodes"][hit["node_id"]]
                extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
                accessor = next(iter(extension["attributes"].values())) if extension else None
                count = reading.root["accessors"][accessor]["count"] if extension else 1
                self.assertIn(hit["node_instance"], range(count))
                # Instances of a node follow each other, so that all hits agree on the first one.
                begin = hit["instance"] - hit["node_instance"]
                self.assertEqual(first.setdefault(hit["node_id"], begin), begin)
            self.assertGreater(len({hit["node_instance"] for hit in filter(None, hits)}), 5)


if __name__ == "__main__":
    case_report.main()
