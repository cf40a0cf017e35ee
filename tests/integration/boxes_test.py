"""Boxes by curl: rays against boxes of the request, and boxes against scenes."""

import json
import math
import random
import re
import unittest
from fractions import Fraction

import case_report
from sightline_server import JSON_TYPE, Server, demo_glb

BOX = '{"min":[-2,-3,-4],"max":[4,3,2]}'
# The golden cases: name, origin, direction, entry and exit of the line, t of the ray, faces at t. Text, so
# that -0.0 reaches the server.
GOLDEN = [
    ("from the front, oblique", "[-10,0,0]", "[1,0.015625,0.015625]", (8, 14), 8, "-x"),
    ("along +x", "[-10,0,0]", "[1,0,0]", (8, 14), 8, "-x"),
    ("along -x", "[10,0,0]", "[-1,0,0]", (6, 12), 6, "+x"),
    ("direction (1,-0,0)", "[-10,0,0]", "[1,-0.0,0]", (8, 14), 8, "-x"),
    ("parallel, outside the slab", "[-10,5,0]", "[1,0,0]", None, None, ""),
    ("in the plane y = 3 (touching)", "[-10,3,0]", "[1,0,0]", (8, 14), 8, "-x +y"),
    ("in the plane y = 3 with -0", "[-10,3,0]", "[1,-0.0,0]", (8, 14), 8, "-x +y"),
    ("origin inside, along +x", "[0,0,0]", "[1,0,0]", (-2, 4), 4, "+x"),
    ("origin inside, negative diagonal", "[0,0,0]", "[-1,-0.5,-0.25]", (-4, 2), 2, "-x"),
    ("box behind", "[10,0,0]", "[1,0.015625,0.015625]", (-12, -6), None, ""),
    ("origin on the entry face", "[-2,0,0]", "[1,0.015625,0.015625]", (0, 6), 0, "-x"),
    ("origin on the exit face, leaving", "[4,0,0]", "[1,0.015625,0.015625]", (-6, 0), 0, "+x"),
    ("along an edge", "[-10,3,2]", "[1,0,0]", (8, 14), 8, "-x +y +z"),
    ("through a corner", "[-3,-4,-5]", "[1,1,1]", (1, 7), 1, "-x -y -z"),
    ("negative diagonal", "[10,1,1]", "[-1,-0.0625,-0.0625]", (6, 12), 6, "+x"),
]
NORMALS = {"-x": [-1, 0, 0], "+x": [1, 0, 0]}


def ray(origin, direction):
    return f'{{"origin":{origin},"direction":{direction}}}'


class Boxes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town", "--max-rays", 2000,
                            "--max-hits", 5000, "--max-query-bytes", 200000)
        cls.addClassCleanup(cls.server.end)

    def post(self, path, body):
        return self.server.ask(path, "-H", JSON_TYPE, body=body if isinstance(body, str) else json.dumps(body))

    def pairs(self, rays, boxes, **more):
        options = "".join(f',"{key}":{json.dumps(value)}' for key, value in more.items())
        answer = self.post("/v1/rays-boxes", f'{{"rays":[{",".join(rays)}],"boxes":[{",".join(boxes)}]{options}}}')
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()["results"]

    def touch(self, scene, kind, *boxes, **more):
        answer = self.post(f"/v1/scenes/{scene}/boxes:{kind}", {"boxes": boxes, **more})
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def expect(self, answer, status, code, pointer=None):
        self.assertEqual(answer.status, status, answer.body)
        self.assertEqual(answer.headers["content-type"], "application/problem+json")
        self.assertEqual(answer.json()["code"], code)
        if pointer is not None:
            self.assertEqual([place["pointer"] for place in answer.json()["errors"]], [pointer])

    def test_spheres(self):
        # The clock tower's wall is the plane x = -3 between y = 0 and 24; its ledge sticks out from y = 18 to 18.5.
        tower = {"of": "nodes"}

        def names(center, radius):
            (result,) = self.touch("town", "list", {"center": center, "radius": radius}, **tower)["results"]
            return [node["node"] for node in result["nodes"]]

        self.assertEqual(names([-8, 12, 1], 5), ["clock tower"])
        self.assertEqual(names([-8, 12, 1], 4.999999999999999), [])
        # The tip of the spire is (0, 32, 0): 3, 4 and 12 away make 13, away from everything else.
        self.assertEqual(names([3, 44, 4], 13), ["spire"])
        self.assertEqual(names([3, 44, 4], 12.999999999999998), [])
        ball = {"center": [-5.5, 1, 0], "radius": 0}
        # The next triangle is 2 away along x, so 2 / sqrt(1.25) = 1.79 straight.
        self.assertEqual(self.touch("six", "count", ball, {**ball, "radius": 1.75}, {**ball, "radius": 1.8}), {"counts": [1, 1, 2]})
        self.assertEqual(self.touch("six", "any", {**ball, "center": [-5.5, 1.25, 0]}), {"hits": [False]})

    def test_faults_of_spheres_are_named(self):
        for sphere, code, pointer in [({"radius": 1}, "KEY_MISSING", "/boxes/0"),
                                      ({"center": [0, 0, 0], "radius": -1}, "BOX_RADIUS_NEGATIVE", "/boxes/0/radius"),
                                      ({"center": [0, 0, 0], "radius": None}, "TYPE_WRONG", "/boxes/0/radius"),
                                      ({"center": [0, 0, 0], "radius": 1, "half": [1, 1, 1]}, "KEYS_MIXED", "/boxes/0")]:
            with self.subTest(sphere=sphere):
                self.expect(self.post("/v1/scenes/six/boxes:any", {"boxes": [sphere]}), 422, code, pointer)
        body = {"rays": [], "boxes": [{"center": [0, 0, 0], "radius": 1}]}
        self.expect(self.post("/v1/rays-boxes", body), 422, "KEY_UNKNOWN", "/boxes/0/radius")

    def test_capsules(self):
        # The wall of the clock tower is the plane x = -3 between y = 0 and 24, |z| <= 3; its ledge sticks out to 3.5.
        names = lambda shape: [node["node"] for node in self.touch("town", "list", shape, of="nodes")["results"][0]["nodes"]]
        upright = {"from": [-8, 11, 1], "to": [-8, 13, 1], "radius": 5}
        self.assertEqual(names(upright), ["clock tower"])
        self.assertEqual(names({**upright, "radius": 4.999999999999999}), [])
        # A rod of no thickness through the spire, whose tip is (0, 32, 0), and one that ends at the tip.
        self.assertEqual(names({"from": [0, 31, -5], "to": [0, 31, 5], "radius": 0}), ["spire"])
        self.assertEqual(names({"from": [0, 40, 0], "to": [0, 32, 0], "radius": 0}), ["spire"])
        self.assertEqual(names({"from": [0, 40, 0], "to": [0, 32.00000000000001, 0], "radius": 0}), [])

    def test_regions_of_planes(self):
        # Triangle i of "left" has the corners (x,0,2) (x+2,4,0) (x,0,-2) with x = -6 + 2i, "right" has x = 2 + 2i.
        def count(*planes):
            return self.touch("six", "count", {"planes": planes})["counts"][0]
        self.assertEqual(count([0, -1, 0, -4]), 6)  # y >= 4: the tips
        self.assertEqual(count([0, -1, 0, -4.000000000000001]), 0)
        self.assertEqual(count([0, -1, 0, -4], [1, 0, 0, 0]), 3)  # and x <= 0
        self.assertEqual(count([0, -1, 0, -4], [1, 0, 0, -0.25]), 2)
        # A thin upright prism at x = -5.5, z = 0: inside the first triangle and none of its corners.
        self.assertEqual(count([1, 0, 0, -5.4], [-1, 0, 0, 5.6], [0, 0, 1, 0.1], [0, 0, -1, 0.1]), 1)
        self.assertEqual(count([1, 0, 0, 0], [-1, 0, 0, -1]), 0)  # nothing is in both

    def test_hulls_of_points(self):
        # Triangle i of "left" has the corners (x,0,2) (x+2,4,0) (x,0,-2) with x = -6 + 2i, "right" has x = 2 + 2i.
        def count(*points, **more):
            return self.touch("six", "count", {"hull": points}, **more)["counts"][0]
        # A point, a segment, a triangle and a tetrahedron, the lowest point of each at the tip (-4, 4, 0) of the first triangle.
        for others in ([], [[-4, 9, 0]], [[-4, 9, 0], [-4, 9, 1]], [[-4, 9, 0], [-4, 9, 1], [-3, 9, 1]], [[-4, 9, 0], [-4, 9, 0], [-4, 6.5, 0]]):
            self.assertEqual(count([-4, 4, 0], *others), 1, others)
            self.assertEqual(count([-4, 4.000000000000001, 0], *others), 0, others)
        # The corners of a box and points in it are the box, whatever their order.
        corners = [[x, y, z] for x in (-6, -2) for y in (0, 4) for z in (-2, 2)]
        for chance in map(random.Random, range(5)):
            points = corners + [[chance.choice((-6, -4, -2)), chance.choice((0, 3, 4)), chance.choice((-2, 0.1, 2))] for _ in range(100)]
            chance.shuffle(points)
            self.assertEqual((count(*points), count(*points, mode="contained"), count(*points, of="nodes")), (3, 2, 1))
        self.assertEqual(count(*corners[:-1], [-2, 4, 1.9999999999999998], mode="contained"), 2)
        self.assertEqual(count(*([x, y * 0.9999999999999998, z] for x, y, z in corners), mode="contained"), 0)
        self.assertEqual(self.touch("six", "any", {"hull": corners}, {"hull": [[100, 100, 100]] * 256}), {"hits": [True, False]})
        # A list goes on with its cursor, of the same points only.
        (part,) = self.touch("six", "list", {"hull": corners}, limit=2)["results"]
        (rest,) = self.touch("six", "list", {"hull": corners, "cursor": part["next"]})["results"]
        self.assertEqual([t["triangle"] for t in part["triangles"] + rest["triangles"]], [0, 1, 2])
        others = self.post("/v1/scenes/six/boxes:list", {"boxes": [{"hull": corners[::-1], "cursor": part["next"]}]})
        self.expect(others, 422, "CURSOR_OF_OTHERS", "/boxes/0/cursor")

    def contacts(self, scene, *boxes, **more):
        """(triangle, depth, contact normal) of the listed triangles of the first shape."""
        results = self.touch(scene, "list", *boxes, contacts=True, **more)["results"]
        return [(t["triangle"], t["depth"], t["contact_normal"]) for t in results[0]["triangles"]]

    def test_how_deep_shapes_are_and_where_they_come_out(self):
        # The wall of the clock tower is the plane x = -3, its corners run counter-clockwise as seen from outside.
        ball = {"center": [-7, 12, 1], "radius": 5}
        for shape in (ball, {"from": [-7, 12, 1], "to": [-7, 14, 1], "radius": 5}, {"min": [-12, 10, 0], "max": [-2, 14, 1]},
                      {"center": [-7, 12, 1], "half": [5, 1, 1], "rotation": [0, 0, 0, 1]}, {"hull": [[x, y, z] for x in (-12, -2) for y in (11, 13) for z in (0, 2)]}):
            deepest = max(self.contacts("town", shape), key=lambda contact: contact[1])
            self.assertEqual(deepest[1:], (1, [-1, 0, 0]), shape)
        # Triangle 0 of "left" has the corners (-6,0,2) (-4,4,0) (-6,0,-2): its plane is 2x - y = -12, its normal (2,-1,0) or its reverse.
        tip = [-4, 4, 0]
        (contact,) = self.contacts("six", {"center": [-4, 7, 0], "radius": 5})[:1]
        self.assertEqual(contact, (0, 2, [0, 1, 0]), "3 above the tip")
        (contact,) = self.contacts("six", {"center": tip, "radius": 0})
        self.assertEqual(contact[:2], (0, 0))
        self.assertIn(contact[2], [[s * 0.8944271909999159, s * -0.4472135954999579, 0] for s in (1, -1)])
        # A rod through the triangle, of no thickness, and one of thickness 1: out along the plane's normal, at the shorter end, or beyond an edge.
        rod = {"from": [-5.5, 1, 0], "to": [-5.25, 1, 0], "radius": 0}
        (contact,) = self.contacts("six", rod)
        self.assertEqual(contact[:2], (0, 0), "its end is on the triangle")
        (thin,) = self.contacts("six", {**rod, "from": [-6, 1, 0]})
        (thick,) = self.contacts("six", {**rod, "from": [-6, 1, 0], "radius": 0.25})[:1]
        self.assertEqual(thin[1], 0.22360679774997896, "0.25 of x along the normal (2,-1,0) / sqrt(5)")
        self.assertAlmostEqual(thick[1], 0.22360679774997896 + 0.25, delta=1e-16)
        self.assertEqual(thick[2], thin[2])
        self.assertEqual([abs(x) for x in thin[2]], [0.8944271909999159, 0.4472135954999579, 0])
        # A box that is open in every direction has no way out, one that is closed below z = 3 has one.
        (contact,) = self.contacts("six", {"min": [None] * 3, "max": [None] * 3}, limit=1)
        self.assertEqual(contact, (0, None, None))
        (contact,) = self.contacts("six", {"min": [None] * 3, "max": [None, None, 3]}, limit=1)
        self.assertEqual(contact, (0, 5, [0, 0, -1]))

    def test_a_translation_by_the_depth_separates(self):
        """Of shapes that are moved by a little more than the depth nothing is left in the triangle, by a little less something is."""
        chance = random.Random(24)
        judged = 0
        for _ in range(12):
            at = [chance.uniform(-4, 4), chance.uniform(18, 26), chance.uniform(-4, 4)]
            points = [[chance.uniform(-2, 2) for _ in range(3)] for _ in range(6)]
            axis, half = [chance.uniform(-2, 2) for _ in range(3)], [chance.uniform(0.5, 2) for _ in range(3)]

            def shapes(by):
                center = [x + d for x, d in zip(at, by)]

                def moved(offset):
                    return [x + d for x, d in zip(center, offset)]

                return [{"center": center, "radius": half[0]}, {"from": center, "to": moved(axis), "radius": half[1]},
                        {"min": center, "max": moved(half)}, {"center": center, "half": half, "axes": [[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]},
                        {"hull": [moved(p) for p in points]}]

            for kind, result in enumerate(self.touch("town", "list", *shapes([0, 0, 0]), contacts=True)["results"]):
                for triangle in result["triangles"][:3]:
                    key = {name: triangle[name] for name in ("instance", "primitive", "triangle")}
                    for factor, is_met in ((1 + 1e-9, False), (1 - 1e-9, True)):
                        by = [factor * triangle["depth"] * n for n in triangle["contact_normal"]]
                        (other,) = self.touch("town", "list", shapes(by)[kind], limit=5000)["results"]
                        found = [{name: t[name] for name in key} for t in other["triangles"]]
                        if triangle["depth"] > 1e-3:
                            self.assertEqual(key in found, is_met, (kind, triangle, factor))
                            judged += 1
        self.assertGreater(judged, 100)

    def test_contacts_are_refused_where_there_are_none(self):
        level = {"kind": "orthographic", "position": [-10, 1, 0], "forward": [1, 0, 0], "extent_y": 1, "width": 2, "height": 1}
        for shape in ({"planes": [[0, -1, 0, -4]]}, {"view": level}):
            body = {"boxes": [{"center": [0, 0, 0], "radius": 1}, shape], "contacts": True}
            self.expect(self.post("/v1/scenes/six/boxes:list", body), 422, "BOX_CONTACTS", "/boxes/1")
        body = {"boxes": [{"center": [0, 0, 0], "radius": 1}], "contacts": True}
        self.expect(self.post("/v1/scenes/six/boxes:list", {**body, "of": "nodes"}), 422, "KEYS_MIXED", "/contacts")
        self.expect(self.post("/v1/scenes/six/boxes:count", body), 422, "KEY_UNKNOWN", "/contacts")
        self.expect(self.post("/v1/scenes/six/boxes:any", body), 422, "KEY_UNKNOWN", "/contacts")

    def test_faults_of_hulls_are_named(self):
        for body, code, pointer in (('{"hull":[]}', "BOX_HULL_COUNT", "/boxes/0/hull"),
                                    ('{"hull":[' + "[0,0,0]," * 256 + "[0,0,0]]}", "BOX_HULL_COUNT", "/boxes/0/hull/256"),
                                    ('{"hull":[[0,0,0],[0,0]]}', "LENGTH_WRONG", "/boxes/0/hull/1"),
                                    ('{"hull":[[0,0,1e999]]}', "NUMBER_NOT_FINITE", "/boxes/0/hull/0/2"),
                                    ('{"hull":[[0,0,null]]}', "TYPE_WRONG", "/boxes/0/hull/0/2"),
                                    ('{"hull":7}', "TYPE_WRONG", "/boxes/0/hull"),
                                    ('{"hull":[[0,0,0]],"center":[0,0,0]}', "KEYS_MIXED", "/boxes/0")):
            with self.subTest(body=body[:40]):
                self.expect(self.post("/v1/scenes/six/boxes:any", f'{{"boxes":[{body}]}}'), 422, code, pointer)
        self.expect(self.post("/v1/rays-boxes", {"rays": [], "boxes": [{"hull": [[0, 0, 0]]}]}), 422, "KEY_UNKNOWN", "/boxes/0/hull")
        # Numbers at the ends of float64: refused or answered, and the server goes on.
        for size in (1e308, 1.7976931348623157e308, 5e-324, 1e-310, -0.0):
            hull = [[size * x, size * y, size * z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
            self.assertEqual(self.touch("six", "count", {"hull": hull}), {"counts": [6 if size > 1 else 0]}, size)

    def test_what_a_camera_sees(self):
        # It looks along x from x = -10: y from 0.5 to 1.5, z from -1 to 1; the first triangle has x = -5.75 at y = 0.5.
        level = {"kind": "orthographic", "position": [-10, 1, 0], "forward": [1, 0, 0], "extent_y": 1, "width": 2, "height": 1}
        self.assertEqual(self.touch("six", "count", *({"view": {**level, "range": [0, far]}} for far in (4.25, 4.249999999999999, None))),
                         {"counts": [1, 0, 6]})
        # All of a triangle is seen only if the picture is high enough: y from -1 to 5, z from -3 to 3.
        high = {**level, "position": [-10, 2, 0], "extent_y": 6, "height": 2, "range": [0, 8]}
        self.assertEqual(self.touch("six", "count", {"view": high}, {"view": {**level, "range": [0, 8]}}, mode="contained"), {"counts": [2, 0]})
        # From x = -10 it sees as far as x = -6.1, -4 (where the second triangle has its feet) and without an end.
        pinhole = {"kind": "pinhole", "position": [-10, 1, 0], "look_at": [0, 1, 0], "fov_y": 90, "width": 1, "height": 1}
        self.assertEqual(self.touch("six", "count", *({"view": {**pinhole, "range": [0, far]}} for far in (3.9, 6, None))), {"counts": [0, 2, 6]})
        # A camera of the file has a view too, and what is no camera has none.
        for view, code, pointer in (({"kind": "camera", "camera": "none", "width": 2, "height": 1}, "CAMERA_UNKNOWN", "/boxes/0/view/camera"),
                                    ({"kind": "equirectangular", "width": 2, "height": 1}, "VIEW_KIND", "/boxes/0/view/kind"),
                                    ({"kind": "lidar", "azimuths": 2}, "KEY_UNKNOWN", "/boxes/0/view/azimuths"),
                                    ({**pinhole, "up": [1, 0, 0]}, "GENERATOR_POSE", "/boxes/0/view"),
                                    ({**pinhole, "height": 0}, "VIEW_RANGE", "/boxes/0/view"),
                                    ({**pinhole, "fov_y": 180}, "NUMBER_OUT_OF_RANGE", "/boxes/0/view/fov_y")):
            self.expect(self.post("/v1/scenes/six/boxes:any", {"boxes": [{"view": view}]}), 422, code, pointer)
        self.expect(self.post("/v1/scenes/six/boxes:any", {"boxes": [{"view": pinhole, "radius": 1}]}), 422, "KEYS_MIXED", "/boxes/0")

    def test_whatever_a_ray_of_a_picture_meets_its_view_lists(self):
        camera = {"kind": "pinhole", "position": [90, 60, 120], "look_at": [0, 10, 0], "fov_y": 40, "width": 40, "height": 30, "range": [20, 170]}
        answer = self.post("/v1/scenes/town/rays:closest", {"generator": camera, "fields": ["instance", "primitive", "triangle"]}).json()
        met = {hit for hit in zip(answer["instance"], answer["primitive"], answer["triangle"]) if hit[0] >= 0}
        (seen,) = self.touch("town", "list", {"view": camera}, limit=5000)["results"]
        self.assertEqual(seen["total"], len(seen["triangles"]))
        self.assertLessEqual(met, {(t["instance"], t["primitive"], t["triangle"]) for t in seen["triangles"]})
        self.assertGreater(len(met), 20)

    def test_eight_corners_are_the_planes_through_them(self):
        # The box of the next test, and one with its corners counted from the other face.
        near, far = ([[x, y, z] for y, z in ((0, -2), (0, 2), (4, 2), (4, -2))] for x in (-6, -2))
        for corners in (near + far, far + near, near[::-1] + far[::-1]):
            self.assertEqual(self.touch("six", "count", {"corners": corners}, mode="contained"), {"counts": [2]})
            self.assertEqual(self.touch("six", "count", {"corners": corners}), {"counts": [3]})
        chance = random.Random(7)
        faces = ((0, 1, 2), (4, 5, 6), (0, 1, 5), (1, 2, 6), (2, 3, 7), (3, 0, 4))

        def planes_of(corners):
            """As docs/guides/picking.md says, outwards."""
            planes = []
            for a, b, c in ([corners[i] for i in face] for face in faces):
                (ux, uy, uz), (vx, vy, vz) = ([q - p for p, q in zip(a, end)] for end in (b, c))
                n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx]
                d = (n[0] * a[0] + n[1] * a[1]) + n[2] * a[2]
                out = sum(sum(x * y for x, y in zip(n, corner)) - d for corner in corners) > 0
                planes.append([-x for x in [*n, d]] if out else [*n, d])
            return planes

        regions, frusta = [], []
        for _ in range(40):
            x, y, z = (chance.uniform(-250, 250), chance.uniform(0, 20), chance.uniform(-250, 250))
            small, large, deep = chance.uniform(1, 9), chance.uniform(10, 60), chance.uniform(5, 80)
            corners = [[x + side * a, y + side * b, z - far] for side, far in ((small, 0), (large, deep)) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            frusta.append({"corners": corners})
            regions.append({"planes": planes_of(corners)})
        for more in ({}, {"mode": "contained"}):
            listed = self.touch("town", "list", *frusta, limit=100, **more)["results"]
            expected = self.touch("town", "list", *regions, limit=100, **more)["results"]
            self.assertEqual([each["triangles"] for each in listed], [each["triangles"] for each in expected])
            self.assertGreater(sum(each["total"] for each in listed), 50)
        for corners, code, pointer in ((near + far[:3], "LENGTH_WRONG", "/boxes/0/corners"), (near + far + near, "LENGTH_WRONG", "/boxes/0/corners"),
                                       (near + near, "BOX_CORNERS", "/boxes/0/corners"), (near + far[2:] + far[:2], "BOX_CORNERS", "/boxes/0/corners"),
                                       ([near[0]] * 4 + far, "BOX_CORNERS", "/boxes/0/corners"),
                                       (near + [[0, 1, "x"], *far[1:]], "TYPE_WRONG", "/boxes/0/corners/4/2")):
            self.expect(self.post("/v1/scenes/six/boxes:any", {"boxes": [{"corners": corners}]}), 422, code, pointer)

    def test_what_is_contained(self):
        low = {"min": [-6, 0, -2], "max": [-2, 4, 2]}  # holds the first two of "left", their corners on its border
        self.assertEqual(self.touch("six", "count", low, mode="contained"), {"counts": [2]})
        self.assertEqual(self.touch("six", "count", low), {"counts": [3]})
        self.assertEqual(self.touch("six", "count", {**low, "max": [-2, 3.9999999999999996, 2]}, mode="contained"), {"counts": [0]})
        self.assertEqual(self.touch("six", "any", low, {**low, "min": [-1, 0, -2], "max": [1, 4, 2]}, mode="contained"), {"hits": [True, False]})
        # A node is contained if all of its triangles are.
        self.assertEqual(self.touch("six", "count", low, {**low, "max": [0, 4, 2]}, mode="contained", of="nodes"), {"counts": [0, 1]})
        # The farthest corners from (-3, 2, 0) are (-6, 0, 2) and its like: 9 + 4 + 4 = 17.
        def around(square):
            """The float64 numbers below and above its root."""
            root = math.sqrt(square)
            return (root, math.nextafter(root, 9)) if Fraction(root) ** 2 < square else (math.nextafter(root, 0), root)

        below, above = around(17)
        ball = {"center": [-3, 2, 0]}
        self.assertEqual(self.touch("six", "count", {**ball, "radius": above}, {**ball, "radius": below}, mode="contained"),
                         {"counts": [3, 2]})
        below, above = around(20)  # the tip of the first one from the edge at its feet
        rod = {"from": [-6, 0, -2], "to": [-6, 0, 2]}
        self.assertEqual(self.touch("six", "count", {**rod, "radius": above}, {**rod, "radius": below}, mode="contained"),
                         {"counts": [1, 0]})
        self.assertEqual(self.touch("six", "count", {"planes": [[0, 1, 0, 4], [1, 0, 0, -2]]}, mode="contained"), {"counts": [2]})

    def test_a_list_goes_on_with_its_cursor(self):
        for more in ({}, {"of": "nodes"}, {"mode": "contained"}):
            with self.subTest(more=more):
                key = more.get("of", "triangles")
                tower = {"min": [-5, 0, -5], "max": [5, 33, 5]}
                (whole,) = self.touch("town", "list", tower, limit=5000, **more)["results"]
                self.assertNotIn("next", whole)
                limit = max(1, whole["total"] // 5)
                pieces, box = [], tower
                while True:
                    (part,) = self.touch("town", "list", box, limit=limit, **more)["results"]
                    self.assertEqual(part["total"], whole["total"])
                    pieces += part[key]
                    if "next" not in part:
                        break
                    box = {**tower, "cursor": part["next"]}
                self.assertEqual(pieces, whole[key])
                self.assertGreater(len(pieces), 0)

    def test_a_cursor_of_another_revision_is_refused(self):
        with Server() as other:
            def list_of(**box):
                return other.ask("/v1/scenes/six/boxes:list", "-H", JSON_TYPE, body=json.dumps(
                    {"boxes": [{"min": [None] * 3, "max": [None] * 3}, {"min": [None] * 3, "max": [None] * 3, **box}], "limit": 2}))
            self.assertEqual(other.put("six", demo_glb("six")).status, 201)
            begun = list_of().json()["results"][1]["next"]
            on = list_of(cursor=begun).json()["results"]
            self.assertEqual([(t["instance"], t["triangle"]) for t in on[1]["triangles"]], [(0, 2), (1, 0)])
            self.assertEqual([(t["instance"], t["triangle"]) for t in on[0]["triangles"]], [(0, 0), (0, 1)])
            self.assertEqual(other.put("six", demo_glb("town")).status, 200)
            self.expect(list_of(cursor=begun), 409, "CURSOR_STALE", "/boxes/1/cursor")
            fresh = list_of().json()["results"][1]["next"]
            answer = other.ask("/v1/scenes/six/boxes:list", "-H", JSON_TYPE, body=json.dumps(
                {"boxes": [{"min": [None] * 3, "max": [None] * 3, "cursor": fresh}], "of": "nodes"}))
            self.expect(answer, 422, "CURSOR_OF_OTHERS", "/boxes/0/cursor")

    def test_a_cursor_of_another_question_is_refused(self):
        tower = {"min": [-5, 0, -5], "max": [5, 33, 5]}
        (part,) = self.touch("town", "list", tower, limit=1)["results"]
        for box, more in (({**tower, "max": [5, 33, 5.000000000000001]}, {}), ({"center": [0, 16, 0], "radius": 40}, {}),
                          ({"center": [0, 16.5, 0], "half": [5, 16.5, 5], "rotation": [0, 0, 0, 1]}, {}), (tower, {"mode": "contained"})):
            answer = self.post("/v1/scenes/town/boxes:list", {"boxes": [tower, {**box, "cursor": part["next"]}], "limit": 1, **more})
            self.expect(answer, 422, "CURSOR_OF_OTHERS", "/boxes/1/cursor")
        # The limit and the place in the list are not part of the question.
        on = self.touch("town", "list", {"center": [0, 0, 0], "radius": 1}, {**tower, "cursor": part["next"]}, limit=7)["results"][1]
        self.assertEqual((len(on["triangles"]), on["total"]), (7, part["total"]))
        other = part["next"][:16] + "0" * 16 + part["next"][32:]
        self.expect(self.post("/v1/scenes/town/boxes:list", {"boxes": [{**tower, "cursor": other}]}), 422, "CURSOR_OF_OTHERS", "/boxes/0/cursor")

    def test_the_golden_cases(self):
        rays = [ray(origin, direction) for _, origin, direction, *_ in GOLDEN]
        results = self.pairs(rays, [BOX] * len(rays))
        lines = self.pairs(rays, [BOX], pairing="all", line=True)
        for (name, _, _, span, t, faces), result, line in zip(GOLDEN, results, lines):
            with self.subTest(name):
                self.assertEqual(line["hit"], span is not None)
                if span:
                    self.assertEqual((line["t_enter"], line["t_exit"]), span)
                self.assertEqual(result["hit"], t is not None)
                if t is not None:
                    self.assertEqual((result["t"], result["t_enter"], result["t_exit"]), (t, *span))
                    self.assertEqual(" ".join(result["faces"]), faces)
                    self.assertEqual(result["face"], faces[:2])
                    self.assertEqual(result["normal"], NORMALS[result["face"]])
        by_name = {name: result for (name, *_), result in zip(GOLDEN, results)}
        self.assertEqual(by_name["parallel, outside the slab"], {"hit": False, "miss": ["y"]})
        self.assertEqual(by_name["box behind"]["miss"], "behind")
        self.assertTrue(by_name["origin inside, along +x"]["inside"])
        self.assertTrue(by_name["origin on the entry face"]["on_surface"])

    def test_an_answer_of_every_shape_in_full(self):
        self.assertEqual(self.pairs([ray("[-10,1,0]", "[1,-0.5,0]")], [BOX], planes=True), [
            {"hit": True, "t": 8, "t_enter": 8, "t_exit": 8, "inside": False, "on_surface": False, "face": "-x",
             "faces": ["-x", "-y"], "normal": [-1, 0, 0], "planes": [8, 14, 8, -4, None, None]}])
        self.assertEqual(self.pairs([ray("[-10,-10,0]", "[1,4,0]")], [BOX]), [{"hit": False, "miss": ["x", "y"]}])
        self.assertEqual(self.pairs(['{"origin":[-10,0,0],"direction":[1,0,0],"tmax":7}'], [BOX]), [
            {"hit": False, "miss": "beyond", "t_enter": 8, "t_exit": 14, "inside": False, "on_surface": False}])
        self.assertEqual(self.pairs(['{"origin":[0,0,0],"direction":[1,0,0],"tmax":3}'], [BOX]), [
            {"hit": True, "t": None, "t_enter": -2, "t_exit": 4, "inside": True, "on_surface": False, "face": None,
             "faces": [], "normal": None}])

    def test_the_three_figures_in_two_dimensions(self):
        square = '{"min":[1,1,null],"max":[3,3,null]}'
        rays = [ray(origin, "[1,1,0]") for origin in ("[0,2.5,0]", "[0,0.5,0]", "[0,-2.5,0]")]
        one, two, three = self.pairs(rays, [square], pairing="all")
        self.assertEqual(one, {"hit": False, "miss": ["x", "y"]})
        self.assertEqual((two["t_enter"], two["t_exit"]), (1, 2.5))
        self.assertEqual(three, {"hit": False, "miss": ["x", "y"]})

    def test_every_ray_with_every_box(self):
        boxes = [f'{{"min":[0,{y},0],"max":[1,{y + 1},1]}}' for y in (0, 2, 4)]
        rays = [ray(f"[-1,{y + 0.5},0.5]", "[1,0,0]") for y in (0, 2)]
        hits = [result["hit"] for result in self.pairs(rays, boxes, pairing="all")]
        self.assertEqual(hits, [True, False, False, False, True, False])

    def test_oriented_boxes(self):
        turned = '{"center":[0,0,0],"half":[1,5,1],"rotation":[0,0,0.7071067811865476,0.7071067811865476]}'
        (result,) = self.pairs([ray("[-10,0,0]", "[1,0,0]")], [turned])
        self.assertAlmostEqual(result["t"], 5, places=12)
        self.assertEqual(result["face"], "+y")
        diamond = '{"center":[0,0,0],"half":[1,1,1],"axes":[[1,1,0],[1,-1,0],[0,0,1]]}'
        touch, miss = self.pairs([ray("[1,-10,0]", "[0,1,0]"), ray("[1.0000000000000002,-10,0]", "[0,1,0]")],
                                 [diamond], pairing="all")
        self.assertEqual((touch["t_enter"], touch["t_exit"], touch["faces"]), (10, 10, ["+y", "+x"]))
        self.assertFalse(miss["hit"])

    def test_no_epsilon_at_any_scale(self):
        for scale in ("e-30", "e-6", "", "e6", "e30"):
            with self.subTest(scale):
                box = f'{{"min":[0,0,0],"max":[1{scale},1{scale},1{scale}]}}'
                inside, beside = self.pairs([ray(f"[0,1{scale},0]", "[1,0,0]"),
                                             ray(f"[0,1.0000000000000004{scale},0]", "[1,0,0]")], [box], pairing="all")
                self.assertTrue(inside["on_surface"])
                self.assertEqual(inside["t"], 0)
                self.assertFalse(beside["hit"])

    def test_which_triangles_a_box_touches(self):
        # "left" has its triangles in the planes x = -6 + 2i + y/2, "right" with x = 2 + 2i.
        at_feet = {"min": [-6, 0, -2], "max": [-4, 0, 2]}
        answer = self.touch("six", "list", at_feet, {"min": [-0.5, 1, 0], "max": [0.5, 1, 0]})["results"]
        self.assertEqual([(item["node"], item["triangle"]) for item in answer[0]["triangles"]], [("left", 0), ("left", 1)])
        self.assertEqual(answer[0]["total"], 2)
        self.assertEqual(answer[1], {"total": 0, "triangles": []})
        self.assertEqual(self.touch("six", "count", at_feet), {"counts": [2]})
        self.assertEqual(self.touch("six", "any", at_feet, {"min": [20, 0, 0], "max": [21, 1, 1]}), {"hits": [True, False]})

    def test_which_nodes_a_box_touches(self):
        everything = {"min": [None, None, None], "max": [None, None, None]}
        (answer,) = self.touch("six", "list", everything, of="nodes")["results"]
        self.assertEqual(answer["total"], 2)
        self.assertEqual([node["node"] for node in answer["nodes"]], ["left", "right"])
        self.assertEqual(self.touch("six", "count", everything, of="nodes"), {"counts": [2]})
        (tower,) = self.touch("town", "list", {"min": [-4, 20, -4], "max": [4, 33, 4]}, of="nodes")["results"]
        self.assertEqual([node["node"] for node in tower["nodes"]], ["clock tower", "spire"])

    def test_touching_is_exact(self):
        # The tip of the spire is (0, 32, 0).
        tip, above = {"min": [0, 32, 0], "max": [9, 99, 9]}, {"min": [0, 32.00000000000001, 0], "max": [9, 99, 9]}
        self.assertEqual(self.touch("town", "any", tip, above), {"hits": [True, False]})
        (answer,) = self.touch("town", "list", tip)["results"]
        self.assertEqual([(item["node"], item["triangle"]) for item in answer["triangles"]], [("spire", i) for i in range(4)])
        diamond = {"center": [0, 33, 0], "half": [1, 1, 1], "axes": [[1, 1, 0], [1, -1, 0], [0, 0, 1]]}
        self.assertEqual(self.touch("town", "count", diamond, {**diamond, "half": [0.9999999999999999, 1, 1]}),
                         {"counts": [4, 0]})

    def test_a_cut_list_says_how_many_there_were(self):
        town = {"min": [None, None, None], "max": [None, None, None]}
        (answer,) = self.touch("town", "list", town, limit=3)["results"]
        self.assertEqual(answer["total"], 362254)
        self.assertEqual([(item["instance"], item["triangle"]) for item in answer["triangles"]], [(0, 0), (0, 1), (0, 2)])
        (answer,) = self.touch("town", "list", town, limit=0)["results"]
        self.assertEqual(answer, {"total": 362254, "triangles": []})
        self.assertEqual(self.touch("town", "count", town), {"counts": [362254]})

    def test_no_boxes_have_no_answers(self):
        self.assertEqual(self.touch("six", "any"), {"hits": []})
        self.assertEqual(self.touch("six", "count"), {"counts": []})
        self.assertEqual(self.touch("six", "list"), {"results": []})
        self.assertEqual(self.pairs([], []), [])

    def test_a_wrong_request_is_answered_with_its_place(self):
        good = {"min": [0, 0, 0], "max": [1, 1, 1]}
        one = {"origin": [0, 0, 0], "direction": [0, 0, 1]}
        for path, body, status, code, pointer in [
                ("/v1/rays-boxes", "", 400, "JSON_MALFORMED", None),
                ("/v1/rays-boxes", {"rays": [one]}, 422, "KEY_MISSING", None),
                ("/v1/rays-boxes", {"rays": [one], "boxes": [good, good]}, 422, "PAIRS_UNEQUAL", "/boxes"),
                ("/v1/rays-boxes", {"rays": [one], "boxes": [{"min": [0, 0, 2], "max": [1, 1, 1]}]}, 422,
                 "BOX_REVERSED", "/boxes/0/min/2"),
                ("/v1/rays-boxes", {"rays": [{**one, "direction": [0, 0, 0]}], "boxes": [good]}, 422,
                 "RAY_DIRECTION_ZERO", "/rays/0/direction"),
                ("/v1/rays-boxes", {"rays": [one] * 1200, "boxes": [good] * 1200, "pairing": "all"}, 413,
                 "PAIRS_TOO_MANY", "/boxes"),
                ("/v1/rays-boxes", " " * 200001, 413, "BODY_TOO_LARGE", None),
                ("/v1/scenes/six/boxes:any", {"boxes": [{"min": [0, 0, 0]}]}, 422, "KEY_MISSING", "/boxes/0"),
                ("/v1/scenes/six/boxes:any", {"boxes": [], "limit": 1}, 422, "KEY_UNKNOWN", "/limit"),
                ("/v1/scenes/six/boxes:list", {"boxes": [], "of": "meshes"}, 422, "VALUE_UNKNOWN", "/of"),
                ("/v1/scenes/six/boxes:list", {"boxes": [], "limit": 5001}, 422, "NUMBER_OUT_OF_RANGE", "/limit"),
                ("/v1/scenes/six/boxes:count", {"boxes": [good] * 2001}, 413, "BOXES_TOO_MANY", "/boxes/2000"),
                ("/v1/scenes/town/boxes:list",
                 {"boxes": [{"min": [None] * 3, "max": [None] * 3}] * 6, "limit": 1000}, 413, "TOO_MANY_HITS", None),
                ("/v1/scenes/none/boxes:any", {"boxes": []}, 404, "SCENE_NOT_FOUND", None),
                ("/v1/scenes/six/boxes:all", {"boxes": []}, 404, "ROUTE_NOT_FOUND", None),
        ]:
            with self.subTest(path=path, code=code):
                self.expect(self.post(path, body), status, code, pointer)
        self.expect(self.server.ask("/v1/rays-boxes"), 405, "METHOD_NOT_ALLOWED")
        self.expect(self.server.ask("/v1/rays-boxes", "-H", "Content-Type: text/plain", body="{}"), 415,
                    "MEDIA_TYPE_UNSUPPORTED")

    def test_the_same_bytes_from_any_number_of_threads(self):
        boxes = [{"min": [x * 20 - 300, 0, z * 20 - 300], "max": [x * 20 - 280, 8, z * 20 - 285]}
                 for x in range(30) for z in range(30)]
        expected = self.post("/v1/scenes/town/boxes:list", {"boxes": boxes, "limit": 5})
        self.assertEqual(expected.status, 200)
        self.assertGreater(sum(result["total"] for result in expected.json()["results"]), 1000)
        with Server("--preload", "town=demo:town", "--threads", 3) as other:
            answer = other.ask("/v1/scenes/town/boxes:list", "-H", JSON_TYPE,
                               body=json.dumps({"boxes": boxes, "limit": 5}))
            # Cursors name the revision, which each server counts for itself.
            self.assertEqual(*(re.sub(r'"next":"[0-9a-f]{16}', "", each.body.decode()) for each in (answer, expected)))


if __name__ == "__main__":
    case_report.main()
