"""uv1 and tangents of hits: by the formulas of docs/reference/fields.md, written again here."""

import math
import random
import unittest

import case_report
from attributes_test import File, triangle
from sightline_server import Server


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(a):
    length = math.hypot(*a)
    return [x / length for x in a]


def turned(made):
    """A random rotation as three columns."""
    a = unit([made.gauss(0, 1) for _ in range(3)])
    b = unit(cross(a, [made.gauss(0, 1) for _ in range(3)]))
    return [a, b, cross(a, b)]


def mixed(weights, rows):
    return [(weights[0] * a + weights[1] * b) + weights[2] * c for a, b, c in zip(*rows)]


class Tangents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        cls.addClassCleanup(cls.server.end)

    def put(self, file):
        answer = self.server.put("s", file.bytes())
        self.assertIn(answer.status, (200, 201), answer.body)
        return answer.json()["warnings"]

    def hit(self, x, y, fields, name="s"):
        hit, = self.server.closest(name, ([x, y, 9], [0, 0, -1]), fields=fields)
        return hit

    def test_uv1_is_that_of_texcoord_1_to_the_last_bit(self):
        made = random.Random(2)
        uv, uv1 = ([[made.random(), made.random()] for _ in range(3)] for _ in range(2))
        stored = [[round(65535 * x) for x in row] for row in uv1]
        self.assertEqual(self.put(triangle(TEXCOORD_0=(uv, "VEC2", 5126, {}), TEXCOORD_1=(stored, "VEC2", 5123, {"normalized": True}))), [])
        for _ in range(40):
            x = made.uniform(0.1, 3)
            hit = self.hit(x, made.uniform(0.1, 3.8 - x), ["uv", "uv1", "barycentrics"])
            u, v = hit["barycentrics"]
            self.assertEqual(hit["uv1"], mixed([(1 - u) - v, u, v], [[x / 65535 for x in row] for row in stored]))
            self.assertNotEqual(hit["uv"], hit["uv1"])

    def test_tangents_are_mapped_and_keep_the_bitangent(self):
        made = random.Random(24)
        for case in range(40):
            normal, tangent, _ = turned(made)
            w = made.choice([1, -1])
            file = triangle(NORMAL=([normal] * 3, "VEC3", 5126, {}), TANGENT=([[*tangent, w]] * 3, "VEC4", 5126, {}))
            rotation, mirror = turned(made), made.choice([1, -1])
            if mirror < 0:
                rotation[0] = [-x for x in rotation[0]]
            scale = made.uniform(0.1, 10)
            matrix = [[scale * x for x in column] for column in rotation]
            file.root["nodes"][0]["matrix"] = [*matrix[0], 0, *matrix[1], 0, *matrix[2], 0, 0, 0, 0, 1]

            def mapped(v, columns=rotation):
                return [sum(columns[k][i] * v[k] for k in range(3)) for i in range(3)]

            self.assertEqual(self.put(file), [])
            centre = [sum(matrix[k][i] * (1, 1, 0)[k] for k in range(3)) for i in range(3)]
            above = mapped([0, 0, 1])
            hit, = self.server.closest("s", ([c + a for c, a in zip(centre, above)], [-a for a in above]), fields=["tangent", "shading_normal"])
            with self.subTest(case=case, mirror=mirror, w=w):
                for got, exact in zip(hit["tangent"], mapped(tangent)):
                    self.assertAlmostEqual(got, exact, delta=1e-6)
                self.assertAlmostEqual(dot(hit["tangent"][:3], hit["tangent"][:3]), 1, delta=1e-15)
                bitangent = [hit["tangent"][3] * x for x in cross(hit["shading_normal"], hit["tangent"][:3])]
                for got, exact in zip(bitangent, mapped([w * x for x in cross(normal, tangent)])):
                    self.assertAlmostEqual(got, exact, delta=1e-6)

    def test_the_tangent_is_interpolated(self):
        rows = [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 2, 1]]
        self.put(triangle(TANGENT=(rows, "VEC4", 5126, {})))
        # The point (1, 2) has the weights 1/4, 1/4, 1/2.
        hit = self.hit(1, 2, ["tangent"])
        for got, exact in zip(hit["tangent"], [*unit([1, 1, 4]), 1]):
            self.assertAlmostEqual(got, exact, delta=1e-15)

    def test_what_the_file_does_not_say_is_null(self):
        self.put(triangle())
        self.assertEqual(self.hit(1, 1, ["uv1", "tangent"]), {"uv1": None, "tangent": None})
        self.put(triangle(TANGENT=([[0, 0, 0, 1]] * 3, "VEC4", 5126, {})))
        self.assertEqual(self.hit(1, 1, ["tangent"]), {"tangent": None}, "no direction")
        self.put(triangle(TANGENT=([[1, 0, 0, 1], [1, 0, 0, -1], [1, 0, 0, -1]], "VEC4", 5126, {})))
        self.assertEqual(self.hit(2, 0, ["tangent"]), {"tangent": None}, "no sign")
        warnings = self.put(triangle(TANGENT=([[1, 0, 0]] * 3, "VEC3", 5126, {}), TEXCOORD_1=([[1, 0, 0]] * 3, "VEC3", 5126, {})))
        self.assertEqual(len(warnings), 2, warnings)
        self.assertEqual(self.hit(1, 1, ["uv1", "tangent"]), {"uv1": None, "tangent": None})

    def test_a_morphed_mesh_has_uv1_and_its_tangent(self):
        file = triangle(TANGENT=([[1, 0, 0, 1]] * 3, "VEC4", 5126, {}), TEXCOORD_1=([[0.5, 0.25]] * 3, "VEC2", 5126, {}))
        self.assertIsInstance(file, File)
        moved = file.add([[0, 0, 1]] * 3, "VEC3", 5126, min=[0, 0, 1], max=[0, 0, 1])
        primitive = file.root["meshes"][0]["primitives"][0]
        primitive["targets"] = [{"POSITION": moved}]
        file.root["meshes"][0]["weights"] = [1]
        self.put(file)
        self.assertEqual(self.hit(1, 1, ["t", "uv1", "tangent"]), {"t": 8, "uv1": [0.5, 0.25], "tangent": [1, 0, 0, 1]})


if __name__ == "__main__":
    case_report.main()
