"""What a scene is made of, and whether its answers are those of brute force."""

import array
import random
from fractions import Fraction

import case_report
from made_scene import triangle_glb
from sightline_server import Server
from two_scenes import TwoScenes


def exact_t(origin, direction, corners):
    """t of a proper crossing by rational arithmetic; None without one."""
    o, d = [Fraction(x) for x in origin], [Fraction(x) for x in direction]
    a, b, c = [[Fraction(x) for x in corner] for corner in corners]

    def minus(p, q):
        return [x - y for x, y in zip(p, q)]

    def cross(p, q):
        return [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]

    def dot(p, q):
        return sum(x * y for x, y in zip(p, q))

    normal = cross(minus(b, a), minus(c, a))
    if dot(normal, d) == 0:
        return None
    t = dot(normal, minus(a, o)) / dot(normal, d)
    point = [x + t * y for x, y in zip(o, d)]
    signs = [dot(normal, cross(minus(q, p), minus(point, p))) for p, q in ((a, b), (b, c), (c, a))]
    return t if t >= 0 and all(sign >= 0 for sign in signs) else None


class Parts(TwoScenes):
    def get(self, path):
        answer = self.server.ask("/v1/scenes/" + path)
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def test_nodes_of_six_triangles(self):
        nodes = self.get("six/nodes")
        self.assertEqual(nodes["total"], 3)
        self.assertNotIn("next", nodes)
        root, left, right = nodes["nodes"]
        self.assertEqual((root["parent"], root["triangles"], root["bounds"]), (None, 0, None))
        self.assertEqual(left, {"node_id": left["node_id"], "name": "left", "parent": root["node_id"], "children": 0,
                                "instances": 1, "first_instance": 0, "triangles": 3, "triangles_below": 3, "hidden": False, "mask": 2**32 - 1, "bounds": {"min": [-6, 0, -2], "max": [0, 4, 2]}})
        self.assertEqual((right["name"], right["bounds"]), ("right", {"min": [2, 0, -2], "max": [8, 4, 2]}))

    def test_nodes_come_in_pages(self):
        whole = self.get("town/nodes?limit=100000")
        paged, first = [], 0
        while first is not None:
            page = self.get(f"town/nodes?first={first}&limit=1000")
            paged += page["nodes"]
            first = page.get("next")
        self.assertEqual(paged, whole["nodes"])
        self.assertEqual(len(paged), whole["total"])
        self.assertEqual(self.get("town/nodes?first=4000000000")["nodes"], [])
        total = self.server.ask("/v1/scenes/town/stats").json()["counts"]["triangles"]
        self.assertEqual(sum(node["triangles"] for node in paged), total)

    def test_triangles_are_the_numbers_that_answers_are_about(self):
        six = self.get("six/triangles?ids=0.0.0,1.0.2")["triangles"]
        self.assertEqual([t["corners"] for t in six], [[[-6, 0, 2], [-4, 4, 0], [-6, 0, -2]], [[6, 0, 2], [8, 4, 0], [6, 0, -2]]])
        random.seed(8)
        rays = [([random.uniform(-300, 300), 60, random.uniform(-300, 300)],
                 [random.uniform(-1, 1), -1, random.uniform(-1, 1)]) for _ in range(60)]
        hits = self.server.closest("town", *rays, fields=["t", "instance", "primitive", "triangle", "node_id"])
        met = [(ray, hit) for ray, hit in zip(rays, hits) if hit]
        self.assertGreater(len(met), 20)
        ids = ",".join(f"{hit['instance']}.{hit['primitive']}.{hit['triangle']}" for _, hit in met)
        for ((origin, direction), hit), triangle in zip(met, self.get("town/triangles?ids=" + ids)["triangles"]):
            self.assertEqual(triangle["node_id"], hit["node_id"])
            t = exact_t(origin, direction, triangle["corners"])
            self.assertEqual(hit["t"], float(t), "the exact t, rounded once")

    def test_brute_force_agrees(self):
        for scene, rays in [("six", 3000), ("town", 8)]:
            with self.subTest(scene=scene):
                check = self.get(f"{scene}/selfcheck?rays={rays}&seed=11")
                self.assertEqual((check["rays"], check["different"]), (rays, []))
                self.assertGreater(check["hits"], rays // 3)
                total = self.server.ask(f"/v1/scenes/{scene}/stats").json()["counts"]["triangles"]
                self.assertEqual(check["triangles_decided"], rays * total)

    def test_brute_force_tries_what_can_be_seen_only(self):
        # One of a hundred thousand placements is not hidden: to find it by chance, for each ray, takes longer than there is.
        server = Server("--request-seconds", 30)
        self.addCleanup(server.end)
        places = array.array("f", bytes(12 * 100000))
        self.assertEqual(server.put("hid", triangle_glb([{"mesh": 0}, {"mesh": 0}], places)).status, 201)
        hide = server.ask("/v1/scenes/hid/nodes/0", "-X", "PATCH", "-H", "Content-Type: application/json", body='{"hidden":true}')
        self.assertEqual(hide.status, 200, hide.body)
        check = server.ask("/v1/scenes/hid/selfcheck?rays=50000")
        self.assertEqual(check.status, 200, check.body)
        self.assertEqual((check.json()["triangles_decided"], check.json()["different"]), (check.json()["rays"], []))
        both = server.ask("/v1/scenes/hid/nodes/1", "-X", "PATCH", "-H", "Content-Type: application/json", body='{"hidden":true}')
        self.assertEqual(both.status, 200, both.body)
        self.assertEqual(server.ask("/v1/scenes/hid/selfcheck").json()["rays"], 0)

    def test_faults(self):
        for path, status, code in [("none/nodes", 404, "SCENE_NOT_FOUND"), ("six/nodes?limit=many", 422, "QUERY_INVALID"),
                                   ("six/nodes?page=1", 422, "QUERY_INVALID"), ("six/nodes?first=1&first=1", 422, "QUERY_INVALID"),
                                   ("six/triangles?ids=0.0.3", 422, "TRIANGLE_UNKNOWN"),
                                   ("six/triangles?ids=2.0.0", 422, "TRIANGLE_UNKNOWN"),
                                   ("six/triangles?ids=0.1.0", 422, "TRIANGLE_UNKNOWN"),
                                   ("six/triangles?ids=0.0", 422, "TRIANGLE_UNKNOWN"),
                                   ("six/triangles?ids=0.0.0.0", 422, "TRIANGLE_UNKNOWN"),
                                   ("six/triangles?ids=" + ",".join(["0.0.0"] * 1001), 413, "TOO_MANY_TRIANGLES"),
                                   ("six/selfcheck?rays=-1", 422, "QUERY_INVALID"),
                                   ("six/selfcheck?rays=100001", 422, "QUERY_INVALID")]:
            with self.subTest(path=path):
                answer = self.server.ask("/v1/scenes/" + path)
                self.assertEqual((answer.status, answer.json()["code"]), (status, code), answer.body)
        self.assertEqual(self.get("six/triangles"), {"triangles": []})


if __name__ == "__main__":
    case_report.main()
