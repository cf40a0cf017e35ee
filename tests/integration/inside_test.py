"""Which points lie inside, against answers that were worked out by hand."""


import array
import json
import math
import unittest

import case_report
from made_scene import glb
from sightline_server import Server
from two_scenes import TwoScenes

# The clock tower is a box with |x|, |z| <= 3 from y = 0 to 24 with a ledge, a box around it from y = 18 to 18.5; the
# spire on it a pyramid up to y = 32. See lists_test.py.
BUILDING = {"include": {"names": ["clock tower", "spire"]}}
IN_TOWER, IN_SPIRE, IN_BOTH_BOXES, ABOVE, BESIDE = [0, 10, 0.5], [0.25, 28, 0], [0.5, 18.25, 1], [0, 33, 0], [9, 10, 0]
ON_WALL, ON_TIP, ON_TOP = [-3, 12, 1], [0, 32, 0], [0.5, 24, 0]


def solid_angle(a, b, c):
    """Of a triangle with corners a, b, c as the origin sees it, positive from its back [VanOosterom1983]."""
    dot = lambda p, q: sum(x * y for x, y in zip(p, q))
    cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]]
    la, lb, lc = (math.sqrt(dot(p, p)) for p in (a, b, c))
    return 2 * math.atan2(dot(a, cross), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)


class Inside(TwoScenes):
    def send(self, scene, **body):
        return self.send_json(f"/v1/scenes/{scene}/points:inside", body)

    def ask(self, scene, *points, **options):
        return self.ask_json(f"/v1/scenes/{scene}/points:inside", {"points": list(points), **options})

    def test_parity(self):
        answer = self.ask("town", IN_TOWER, IN_SPIRE, ABOVE, BESIDE, IN_BOTH_BOXES, **BUILDING)
        self.assertEqual(answer, {"method": "parity", "inside": [True, True, False, False, False], "on_surface": [False] * 5,
                                  "reliable": [True] * 5})

    def test_winding(self):
        answer = self.ask("town", IN_TOWER, IN_SPIRE, ABOVE, BESIDE, IN_BOTH_BOXES, method="winding", **BUILDING)
        self.assertEqual(answer, {"method": "winding", "inside": [True, True, False, False, True], "on_surface": [False] * 5,
                                  "reliable": [True] * 5, "winding": [1, 1, 0, 0, 2]})

    def test_open_meshes_have_generalized_winding_numbers(self):
        """Against the sum of the solid angles of all triangles, as GET /triangles lists them."""
        ids = ",".join(f"{instance}.0.{triangle}" for instance in range(2) for triangle in range(3))
        corners = [row["corners"] for row in self.server.ask(f"/v1/scenes/six/triangles?ids={ids}").json()["triangles"]]
        points = [[-5, 1, 0], [-3.5, 1.5, 0.25], [0, 9, 0], [6.5, 0.5, -1], [-5, 2, 0]]
        answer = self.ask("six", *points, method="solid_angle")
        for point, winding, error in list(zip(points, answer["winding"], answer["error"]))[:4]:
            whole = sum(solid_angle(*([x - y for x, y in zip(corner, point)] for corner in triangle)) for triangle in corners)
            self.assertLess(abs(winding - whole / (4 * math.pi)), error + 1e-14)
            self.assertLess(error, 1e-12)
        self.assertEqual((answer["on_surface"][4], answer["inside"][4], answer["winding"][4]), (True, None, None))
        self.assertNotIn("unreliable", answer)
        self.assertEqual(self.ask("town", IN_TOWER, ABOVE, IN_BOTH_BOXES, method="solid_angle", **BUILDING),
                         {"method": "solid_angle", "inside": [True, False, True], "on_surface": [False] * 3, "reliable": [True] * 3,
                          "winding": [1, 0, 2], "error": [0, 0, 0]})
        distance = self.ask_json("/v1/scenes/six/points:distance", {"points": points[:1], "method": "solid_angle"})
        self.assertEqual(distance["winding"], answer["winding"][:1])

    def test_an_open_box_has_an_inside_and_signed_distances(self):
        """The cube from (-1, -1, -1) to (1, 1, 1) without its top, which takes 4 asin(1 / (1 + h^2)) of 4 pi seen from a distance h."""
        corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (0, 2, 6, 4), (1, 5, 7, 3)]
        indices = [i for a, b, c, d in faces for i in (a, b, c, a, c, d)]
        data = array.array("f", (x for corner in corners for x in corner)).tobytes() + array.array("I", indices).tobytes()
        self.server.put("open", glb({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}], "buffers": [{"byteLength": len(data)}],
            "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": len(data) - 96}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8, "min": [-1] * 3, "max": [1] * 3},
                          {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": len(indices)}]}, data))
        heights, outside = [0, 0.5, 0.9375, 1, 1.0625, 2], [[3, 0, 0], [0, -2, 0]]
        points = [[0, y, 0] for y in heights] + outside + [[1, 0, 0]]
        told = self.ask("open", *points, method="solid_angle")
        signed = self.ask_json("/v1/scenes/open/points:distance", {"points": points, "method": "solid_angle"})
        # The hole counts as a wall where half of all directions meet the box: in the plane of the missing face, where nothing is certain.
        self.assertEqual(told["inside"], [True] * 3 + [False] * 5 + [None])
        self.assertEqual(told["on_surface"], [False] * 8 + [True])
        self.assertEqual(told["reliable"], [True] * 3 + [False] + [True] * 5)
        rim = [math.hypot(1, y - 1) if y > 1 else 1 for y in heights]
        self.assertEqual(signed["distance"], [-x for x in rim[:3]] + rim[3:] + [2, 1, 0])
        for name in ("winding", "error", "reliable"):
            self.assertEqual(signed[name], told[name])
        for y, winding, error in zip(heights, told["winding"], told["error"]):
            hole = math.asin(1 / (1 + (1 - y) ** 2)) / math.pi
            self.assertLess(abs(winding - (1 - hole if y < 1 else hole)), error + 1e-15)
        self.assertTrue(all(-0.05 < winding < 0 for winding in told["winding"][6:8]), told)
        # The other methods count crossings, which says nothing certain of a point below the hole.
        for method in ("parity", "winding"):
            other = self.ask("open", *points[:1], method=method)
            self.assertEqual((other["reliable"], other["unreliable"]), ([False], {"reason": "OPEN_EDGES", "open_edges": 4}))

    def test_on_the_surface_a_point_is_neither(self):
        for method in ("parity", "winding"):
            answer = self.ask("town", ON_WALL, ON_TIP, ON_TOP, [-3.0000000000000004, 12, 1], method=method, **BUILDING)
            self.assertEqual((answer["on_surface"], answer["inside"]), ([True] * 3 + [False], [None] * 3 + [False]))

    def test_triangles_that_enclose_nothing_are_not_reliable(self):
        # Beside "left" (triangles in planes with a steep normal) some directions meet triangles, others none.
        answer = self.ask("six", [-6.5, 0.75, 0], [0, 50, 0])
        self.assertEqual(answer["reliable"], [False, True])

    def test_work_and_no_points(self):
        self.assertEqual(self.ask("six")["inside"], [])
        self.assertGreater(self.ask("six", [-6.5, 1, 0], work=True)["work"]["nodes"] + 1, 0)

    def test_faults_are_named(self):
        for body, code, pointer in [({}, "KEY_MISSING", None), ({"points": [[1, 2]]}, "LENGTH_WRONG", "/points/0"),
                                    ({"points": [], "cull": "back"}, "KEY_UNKNOWN", "/cull"),
                                    ({"points": [], "method": "magic"}, "VALUE_UNKNOWN", "/method"),
                                    ({"points": [[1, 2, None]]}, "TYPE_WRONG", "/points/0/2")]:
            with self.subTest(body=body):
                answer = self.send("six", **body)
                self.assertEqual((answer.status, answer.json()["code"]), (422, code), answer.body)
                if pointer:
                    self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)


class Edges(unittest.TestCase):
    def test_the_memory_to_count_open_edges_is_counted(self):
        # A plane of 180,000 triangles and one of another material, so that a filter leaves a part of the mesh.
        side = 300
        positions = array.array("f", (c for y in range(side + 1) for x in range(side + 1) for c in (x, y, 0)))
        indices = array.array("I")
        for y in range(side):
            for corner in range(y * (side + 1), y * (side + 1) + side):
                indices.extend((corner, corner + 1, corner + side + 2, corner, corner + side + 2, corner + side + 1))
        binary = positions.tobytes() + indices.tobytes()
        scene = glb({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "materials": [{"name": "a"}, {"name": "b"}],
                     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0},
                                                {"attributes": {"POSITION": 0}, "indices": 2, "material": 1}]}],
                     "buffers": [{"byteLength": len(binary)}],
                     "bufferViews": [{"buffer": 0, "byteLength": 4 * len(positions)},
                                     {"buffer": 0, "byteOffset": 4 * len(positions), "byteLength": 4 * len(indices)}],
                     "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(positions) // 3,
                                    "min": [0, 0, 0], "max": [side, side, 0]},
                                   {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": len(indices)},
                                   {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3}]}, binary)
        body = {"points": [[1.2, 1.2, 5]]}
        part = {**body, "exclude": {"materials": ["b"]}}
        answers = {}
        for memory in (2 << 20, 32 << 20):
            server = Server("--max-request-memory", memory)
            self.addCleanup(server.end)
            self.assertEqual(server.put("plane", scene).status, 201)
            for path in ("points:inside", "points:distance"):
                for name, asked in (("whole", body), ("part", part)):
                    answer = server.ask(f"/v1/scenes/plane/{path}", "-H", "Content-Type: application/json", body=json.dumps(asked))
                    code = answer.json().get("code")
                    answers.setdefault((memory >> 20, name), set()).add((answer.status, code))
        # 24 bytes for each triangle and some 20 for each corner are 6 MB.
        self.assertEqual(answers, {(2, "whole"): {(413, "REQUEST_TOO_LARGE")}, (2, "part"): {(413, "REQUEST_TOO_LARGE")},
                                   (32, "whole"): {(200, None)}, (32, "part"): {(200, None)}})


if __name__ == "__main__":
    case_report.main()
