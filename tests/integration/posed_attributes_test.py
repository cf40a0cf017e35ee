"""Attributes of meshes that skins and morph targets pose: against an own reading of the file's bytes."""

import itertools
import json
import math
import random
import struct
import tempfile
import unittest

import case_report
from attributes_test import MAPPED_FROM, File, Reading
from sightline_server import Server, shared_scene

FIELDS = ["shading_normal", "tangent", "uv", "colour"]
NAMES = {"NORMAL": 3, "TANGENT": 4, "TEXCOORD_0": 2, "COLOR_0": 4}
PLACES = ["barycentrics", "mesh_id", "primitive", "triangle", "node_id", "normal"]


def product(a, b):
    """Of two 3x4 matrices, as affine maps."""
    return [[sum(a[i][k] * b[k][j] for k in range(3)) + (a[i][3] if j == 3 else 0) for j in range(4)] for i in range(3)]


def local(node):
    if "matrix" in node:
        return [[node["matrix"][4 * j + i] for j in range(4)] for i in range(3)]
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    scale, move = node.get("scale", [1, 1, 1]), node.get("translation", [0, 0, 0])
    return [[turn[i][j] * scale[j] for j in range(3)] + [move[i]] for i in range(3)]


def cofactors(m):
    """The matrix for normals, and whether the map is a reflection."""
    rows = [[m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3] - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3]
             for j in range(3)] for i in range(3)]
    return rows, sum(a * b for a, b in zip(m[0][:3], rows[0])) < 0


def unit(v):
    length = math.sqrt(math.fsum(x * x for x in v))
    return [x / length for x in v]


def mapped(m, v):
    return [math.fsum(m[i][j] * v[j] for j in range(3)) for i in range(3)]


class Posed(Reading):
    """The pose of the file, by the formulas of glTF 2.0."""

    def __init__(self, glb):
        super().__init__(glb)
        nodes = self.root["nodes"]
        self.world = {}
        parents = {child: i for i, node in enumerate(nodes) for child in node.get("children", [])}

        def of(i):
            own = local(nodes[i])
            return product(of(parents[i]), own) if i in parents else own
        for i in range(len(nodes)):
            self.world[i] = of(i)

    def joints(self, skin):
        entry = self.root["skins"][skin]
        for k, joint in enumerate(entry["joints"]):
            bind = self.element(entry["inverseBindMatrices"], k) if "inverseBindMatrices" in entry else None
            yield product(self.world[joint], [[bind[4 * j + i] for j in range(4)] for i in range(3)]) if bind else self.world[joint]

    def pose(self, node, primitive, vertex):
        """The posed attributes of a vertex, by name."""
        values = {}
        for name, width in NAMES.items():
            if name not in primitive["attributes"]:
                continue
            value = self.element(primitive["attributes"][name], vertex)
            value += [1.0] * (width - len(value))
            for weight, target in zip(node.get("weights", self.root["meshes"][node["mesh"]].get("weights", [])), primitive.get("targets", [])):
                if name in target:
                    added = self.element(target[name], vertex)
                    value = [a + weight * (added[c] if c < len(added) else 0) for c, a in enumerate(value)]
            values[name] = value
        matrix = self.world[self.root["nodes"].index(node)]
        if "skin" in node:
            joints = list(self.joints(node["skin"]))
            matrix = [[0.0] * 4 for _ in range(3)]
            for number in (0, 1):
                if f"JOINTS_{number}" not in primitive["attributes"]:
                    continue
                numbers, weights = (self.element(primitive["attributes"][f"{part}_{number}"], vertex) for part in ("JOINTS", "WEIGHTS"))
                for joint, weight in zip(numbers, weights):
                    matrix = [[matrix[i][j] + weight * joints[int(joint)][i][j] for j in range(4)] for i in range(3)]
        turn, is_mirror = cofactors(matrix)
        if "NORMAL" in values and "skin" in node:
            values["NORMAL"] = unit([-x if is_mirror else x for x in mapped(turn, values["NORMAL"])])
        if "TANGENT" in values and "skin" in node:
            *direction, sign = values["TANGENT"]
            values["TANGENT"] = [*unit(mapped(matrix, direction)), -sign if is_mirror else sign]
        return values, None if "skin" in node else matrix

    def expected(self, hit):
        corners, primitive = self.corners(hit)
        node = self.root["nodes"][hit["node_id"]]
        u, v = hit["barycentrics"]
        posed = [self.pose(node, primitive, corner) for corner in corners]
        matrix = posed[0][1] or [[float(i == j) for j in range(4)] for i in range(3)]
        turn, is_mirror = cofactors(matrix)

        def mixed(name):
            if name not in posed[0][0]:
                return None
            return [((1 - u) - v) * a + u * b + v * c for a, b, c in zip(*(values[name] for values, _ in posed))]
        normal, tangent = mixed("NORMAL"), mixed("TANGENT")
        return {"shading_normal": normal and unit([-x if is_mirror else x for x in mapped(turn, normal)]),
                "tangent": tangent and [*unit(mapped(matrix, tangent[:3])), math.copysign(1, tangent[3]) * (-1 if is_mirror else 1)],
                "uv": mixed("TEXCOORD_0"), "colour": mixed("COLOR_0")}


def made_file(seed, has_skin, count=30):
    """Triangles apart from each other, with two morph targets, and three joints of which one is a mirror."""
    made, file = random.Random(seed), File()

    def rows(width, low=-1.0, high=1.0):
        return [[made.uniform(low, high) for _ in range(width)] for _ in range(3 * count)]
    places = [[8 * (i // 3 % 6) + made.uniform(0, 4), 8 * (i // 18) + made.uniform(0, 4), made.uniform(-1, 1)] for i in range(3 * count)]

    def floats(values, **more):
        return file.add(values, f"VEC{len(values[0])}", 5126, **more)

    def moves(values):
        return floats(values, min=[min(row[i] for row in values) for i in range(3)], max=[max(row[i] for row in values) for i in range(3)])
    signs = [[*row, made.choice([-1, 1])] for row in rows(3)]
    for k in range(0, 3 * count, 3):  # the sign is that of a triangle
        signs[k + 1][3] = signs[k + 2][3] = signs[k][3]
    attributes = {"POSITION": moves(places), "NORMAL": floats(rows(3)), "TANGENT": floats(signs), "TEXCOORD_0": floats(rows(2)),
                  "COLOR_0": floats(rows(4, 0, 1))}
    targets = [{"POSITION": moves(rows(3, -.3, .3)), "NORMAL": floats(rows(3, -.4, .4)), "TANGENT": floats(rows(3, -.4, .4))},
               {"TEXCOORD_0": floats(rows(2)), "COLOR_0": floats(rows(4, -.2, .2)), "NORMAL": floats(rows(3, -.4, .4))}]
    file.root["meshes"].append({"primitives": [{"attributes": attributes, "targets": targets}], "weights": [0.75, -0.5]})
    file.node(0, rotation=[0, 0, 0.6, 0.8], scale=[1, -2, 1] if not has_skin else [5, 5, 5])
    if has_skin:
        weights = [[made.uniform(0.1, 1) for _ in range(3)] + [0.0] for _ in range(3 * count)]
        attributes["WEIGHTS_0"] = floats([[x / sum(row) for x in row] for row in weights])
        # One triangle in three follows the mirror alone.
        attributes["JOINTS_0"] = file.add([[2] * 4 if i // 3 % 3 == 0 else [0, made.randrange(2), made.randrange(2), 0]
                                           for i in range(3 * count)], "VEC4", 5121)
        joints = [{"rotation": [0.6, 0, 0, 0.8], "scale": [1, 1, 1.5]}, {"rotation": [0.5, 0.1, 0, math.sqrt(0.74)], "translation": [0.2, 0, 0.3]},
                  {"scale": [-1, 1, 1]}]
        for joint in joints:
            file.root["nodes"].append(joint)
            file.root["scenes"][0]["nodes"].append(len(file.root["nodes"]) - 1)
        binds = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, made.uniform(-1, 1), 0.25, 0, 1] for _ in joints]
        file.root["skins"] = [{"joints": [1, 2, 3], "inverseBindMatrices": file.add(binds, "MAT4", 5126)}]
        file.root["nodes"][0]["skin"] = 0
    return file.bytes()


class PosedAttributes(unittest.TestCase):
    def compare(self, server, name, reading, at_least):
        """Rays at the middle of each triangle, where it stands."""
        made, rays = random.Random(4), []
        bounds = server.ask(f"/v1/scenes/{name}").json()["bounds"]
        low, high = bounds["min"], bounds["max"]
        size = max(b - a for a, b in zip(low, high))
        for _ in range(1500):
            at = [made.uniform(a, b) for a, b in zip(low, high)]
            towards = unit([made.gauss(0, 1) for _ in range(3)])
            rays.append({"origin": [p - 2 * size * d for p, d in zip(at, towards)], "direction": towards})
        hits = server.query(name, "closest", {"rays": rays, "fields": [*FIELDS, *PLACES]}).json()["hits"]
        hits = [hit for hit in hits if hit]
        self.assertGreater(len(hits), at_least)
        for hit in hits:
            expected = reading.expected(hit)
            for field in FIELDS:
                self.assertEqual(hit[field] is None, expected[field] is None, (field, hit))
                for got, exact in zip(hit[field] or [], expected[field] or [], strict=True):
                    self.assertAlmostEqual(got, exact, delta=1e-9, msg=(field, hit, expected))
        return hits

    def test_morph_targets_and_skins_pose_every_attribute(self):
        for is_kept, has_skin in itertools.product((False, True), repeat=2):
            with self.subTest(is_kept=is_kept, has_skin=has_skin), tempfile.TemporaryDirectory() as folder:
                glb = made_file(7 + has_skin, has_skin)
                with Server(*("--data", folder) if is_kept else ()) as server:
                    # A large file is mapped, and its attributes are read where they lie.
                    answer = server.put("posed", glb + bytes(MAPPED_FROM if is_kept else 0))
                    self.assertEqual(answer.status, 201, answer.body)
                    self.compare(server, "posed", Posed(glb), 20)

    def test_the_knight_of_the_shared_data(self):
        glb = shared_scene(self, "knight_skinned.glb")
        reading = Posed(glb)
        with Server() as server:
            server.put("knight", glb)
            hits = self.compare(server, "knight", reading, 100)
        skinned = [hit for hit in hits if "skin" in reading.root["nodes"][hit["node_id"]]]
        self.assertGreater(len(skinned), 50)

    def test_a_wrong_target_leaves_the_attribute_out_with_a_warning(self):
        for wrong in ("short", "type", "reference"):
            glb = made_file(3, False, count=2)
            length, = struct.unpack_from("<I", glb, 12)
            root = json.loads(glb[20:20 + length])
            target = root["meshes"][0]["primitives"][0]["targets"][0]
            accessor = root["accessors"][target["NORMAL"]]
            if wrong == "short":
                accessor["count"] -= 1
            elif wrong == "type":
                accessor["type"] = "VEC2"
            else:
                target["NORMAL"] = 999
            text = json.dumps(root).encode()
            text += b" " * (-len(text) % 4)
            rest = glb[20 + length:]
            body = struct.pack("<III", 0x46546C67, 2, 20 + len(text) + len(rest)) + struct.pack("<II", len(text), 0x4E4F534A) + text + rest
            with self.subTest(wrong=wrong), Server() as server:
                answer = server.put("wrong", body)
                self.assertEqual(answer.status, 201, answer.body)
                self.assertTrue(any("NORMAL" in warning for warning in answer.json()["warnings"]), answer.json()["warnings"])
                hits = self.compare_fields(server)
                self.assertTrue(all(hit["shading_normal"] is None and hit["tangent"] for hit in hits))

    def compare_fields(self, server):
        ids = server.ask("/v1/scenes/wrong/triangles?ids=0.0.0,0.0.1").json()["triangles"]
        rays = [{"origin": [sum(corner[i] for corner in each["corners"]) / 3 + (50 if i == 2 else 0) for i in range(3)], "direction": [0, 0, -1]}
                for each in ids]
        return [hit for hit in server.query("wrong", "closest", {"rays": rays, "fields": FIELDS}).json()["hits"] if hit]


if __name__ == "__main__":
    case_report.main()
