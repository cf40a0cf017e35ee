"""The happy road: rays by curl, against answers that were worked out by hand."""

import json

import case_report
from sightline_server import DATA, Server
from two_scenes import TwoScenes

# Triangle i of "left" has the corners (x,0,2) (x+2,4,0) (x,0,-2) with x = -6 + 2i, so at height y it
# stands at x + y/2. The four branches of the hierarchy:
BOTH = ([-10, 1, 0], [1, 0, 0])  # both subtrees are met; left's triangle 0 stands at -5.5
LEFT = ([-5, 10, 0], [0, -1, 0])  # straight down: triangle 0 has y = 2 at x = -5
RIGHT = ([3, 10, 0], [0, -1, 0])  # the same on the right, whose x begins at 2
NONE = ([1, 10, 0], [0, -1, 0])  # between the two


class Rays(TwoScenes):
    def test_the_four_branches_of_six_triangles(self):
        hits = self.server.closest("six", BOTH, LEFT, RIGHT, NONE)
        self.assertEqual([hit and (hit["t"], hit["node"], hit["triangle"]) for hit in hits],
                         [(4.5, "left", 0), (8, "left", 0), (8, "right", 0), None])

    def test_every_field_of_a_hit(self):
        fields = ["t", "instance", "primitive", "triangle", "position", "normal", "barycentrics", "front", "node",
                  "distance", "on_edge", "node_path", "node_id", "mesh", "mesh_id", "material", "material_id"]
        hit = self.server.closest("six", BOTH, fields=fields)[0]
        self.assertEqual(sorted(hit), sorted(fields))
        self.assertEqual(hit["position"], [-5.5, 1, 0])
        # (2,4,-2) x (0,0,-4) = (-16,8,0), of length 8 sqrt(5)
        for got, exact in zip(hit["normal"], [-2 / 5**0.5, 1 / 5**0.5, 0]):
            self.assertLess(abs(got - exact), 1e-15)
        # y = 4u gives u = 1/4; z = 2(1-u-v) - 2v = 0 gives v = 3/8
        self.assertEqual(hit["barycentrics"], [0.25, 0.375])
        self.assertIs(hit["front"], True)
        self.assertEqual((hit["instance"], hit["primitive"], hit["triangle"]), (0, 0, 0))
        self.assertEqual((hit["node"], hit["mesh"]), ("left", "left"))
        self.assertEqual(hit["distance"], 4.5)
        self.assertIs(hit["on_edge"], False)
        self.assertTrue(hit["node_path"].endswith("/left"), hit["node_path"])

    def test_edges_and_corners_are_told_exactly(self):
        # Triangle 0 of "left" has the corners (-6,0,2) (-4,4,0) (-6,0,-2): its side at height y spans |z| <= 2 - y/2.
        def on_edge(z, y=1):
            return self.server.closest("six", ([-10, y, z], [1, 0, 0]), fields=["on_edge"])[0]["on_edge"]

        self.assertEqual([on_edge(1.5), on_edge(-1.5), on_edge(0, y=0), on_edge(0, y=4), on_edge(2, y=0)], [True] * 5)
        self.assertEqual([on_edge(1.4999999999999998), on_edge(0), on_edge(0, y=3.9999999999999996)], [False] * 3)

    def test_normalize_counts_in_scene_units(self):
        # The same ray with a direction of length 8: t = 4.5/8, and 4.5 units away.
        ray = {"origin": BOTH[0], "direction": [8, 0, 0]}
        fields = ["t", "distance"]
        plain = self.server.query("six", "closest", {"rays": [ray], "fields": fields}).json()["hits"]
        self.assertEqual(plain, [{"t": 0.5625, "distance": 4.5}])
        for tmin, tmax, expected in [(0, 4.5, 4.5), (4.5, 100, 4.5), (4.6, 100, 6.5), (0, 4.4, None)]:
            with self.subTest(tmin=tmin, tmax=tmax):
                body = {"rays": [{**ray, "tmin": tmin, "tmax": tmax}], "fields": fields, "normalize": True}
                hit = self.server.query("six", "closest", body).json()["hits"][0]
                self.assertEqual(hit, expected and {"t": expected, "distance": expected})
        body = {"rays": [{**ray, "tmax": 6.5}], "normalize": True}
        self.assertEqual(self.server.query("six", "count", body).json(), {"counts": [2]})
        lists = self.server.query("six", "all", {**body, "fields": ["t"]}).json()
        self.assertEqual(lists, {"results": [{"total": 2, "hits": [{"t": 4.5}, {"t": 6.5}]}]})

    def test_a_hit_has_by_default_what_a_person_wants_to_know(self):
        hit = self.server.closest("town", ([-40, 12, 1], [1, 0, 0]))[0]
        self.assertEqual((hit["t"], hit["position"], hit["normal"], hit["node"], hit["mesh"]),
                         (37, [-3, 12, 1], [-1, 0, 0], "clock tower", "tower"))

    def test_limits_are_closed(self):
        origin, direction = BOTH
        for tmin, tmax, expected in [(0, 4.5, 4.5), (4.5, None, 4.5), (0, 4.4999999999999991, None),
                                     (4.5000000000000009, None, 6.5), (-100, 0, None), (-1e308, 1e308, 4.5)]:
            with self.subTest(tmin=tmin, tmax=tmax):
                ray = {"origin": origin, "direction": direction, "tmin": tmin, "tmax": tmax}
                hit = self.server.query("six", "closest", {"rays": [ray]}).json()["hits"][0]
                self.assertEqual(hit and hit["t"], expected)

    def test_t_counts_in_the_direction_as_given(self):
        origin = BOTH[0]
        hits = self.server.closest("six", (origin, [0.5, 0, 0]), (origin, [1024, 0, 0]))
        self.assertEqual([hit["t"] for hit in hits], [9, 4.5 / 1024])

    def test_columns_in_columns_out(self):
        rays = [BOTH, NONE, RIGHT]
        body = {"origins": sum((origin for origin, _ in rays), []),
                "directions": sum((direction for _, direction in rays), []),
                "fields": ["t", "triangle", "position", "node"]}
        answer = self.server.query("six", "closest", body)
        self.assertEqual(answer.status, 200, answer.body)
        self.assertEqual(answer.json(), {"t": [4.5, None, 8], "triangle": [0, -1, 0],
                                         "position": [-5.5, 1, 0, None, None, None, 3, 2, 0],
                                         "node": ["left", None, "right"]})

    def test_any_answers_true_or_false(self):
        body = {"rays": [{"origin": origin, "direction": direction} for origin, direction in (BOTH, LEFT, RIGHT, NONE)]}
        self.assertEqual(self.server.query("six", "any", body).json(), {"hits": [True, True, True, False]})
        columns = {"origins": BOTH[0] + NONE[0], "directions": BOTH[1] + NONE[1]}
        self.assertEqual(self.server.query("six", "any", columns).json(), {"hits": [True, False]})

    def test_no_rays_are_answered_with_no_hits(self):
        self.assertEqual(self.server.query("six", "closest", {"rays": []}).json(), {"hits": []})
        self.assertEqual(self.server.query("six", "any", {"rays": []}).json(), {"hits": []})

    def test_negative_zero_is_a_direction_like_zero(self):
        body = '{"rays":[{"origin":[-10,1,0],"direction":[1,-0.0,-0]},{"origin":[-10,1,0],"direction":[1,0,0]}]}'
        first, second = self.server.query("six", "closest", body).json()["hits"]
        self.assertEqual(first, second)

    def test_order_and_number_of_many_rays_are_kept(self):
        count = 5000
        # Ray i looks down at x = -5 + i/1000000: the triangle's height there is y = 2(x + 6).
        rays = [([-5 + i / 2**20, 10, 0], [0, -1, 0]) for i in range(count)]
        hits = self.server.closest("six", *rays, fields=["t"])
        self.assertEqual([hit["t"] for hit in hits], [8 - i / 2**19 for i in range(count)])

    def test_the_answer_says_which_revision_gave_it(self):
        answer = self.server.query("six", "any", {"rays": []})
        revision = self.server.ask("/v1/scenes/six").json()["revision"]
        self.assertEqual(answer.headers["x-scene-revision"], str(revision))

    def test_the_same_rays_give_the_same_bytes_on_any_kernel_and_number_of_threads(self):
        body = json.dumps({"rays": [{"origin": [x * 7 - 350, 60, z * 7 - 350], "direction": [0.3, -1, 0.1 * x]}
                                    for x in range(100) for z in range(20)]})
        kernels = self.server.ask("/version").json()["kernels"]
        expected = self.server.query("town", "closest", body).body
        for kernel in kernels:
            with self.subTest(kernel=kernel), \
                    Server("--preload", "town=demo:town", "--kernel", kernel, "--threads", 3) as other:
                self.assertEqual(other.query("town", "closest", body).body, expected)

    def test_large_scenes_of_the_data_folder(self):
        # By hand: a ray straight down from above the middle of the bounds meets at t = height - y.
        for name in ("furnished_house", "jacksboro_dem"):
            file = DATA / f"scenes/{name}.glb"
            if not file.exists():
                self.skipTest(f"no {file.name}: set SIGHTLINE_DATA")
            with self.subTest(scene=name):
                put = self.server.put(name, file.read_bytes())
                self.assertEqual(put.status, 201, put.body)
                low, high = put.json()["bounds"]["min"], put.json()["bounds"]["max"]
                middle = [(a + b) / 2 for a, b in zip(low, high)]
                hits = self.server.closest(name, *[([middle[0] + step, high[1] + 8, middle[2] + step], [0, -1, 0])
                                                   for step in (0, 0.25, 0.5)])
                hit = next(hit for hit in hits if hit)
                self.assertAlmostEqual(hit["t"], high[1] + 8 - hit["position"][1], delta=1e-9 * (abs(high[1]) + 8))
                self.assertTrue({"t", "position", "normal", "node", "mesh"} <= set(hit))


if __name__ == "__main__":
    case_report.main()
