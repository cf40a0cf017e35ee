"""Every hit of a ray, and how many there are, by curl, against answers that were worked out by hand."""


import case_report
from sightline_server import Server
from two_scenes import TwoScenes

# Triangle i of "left" stands at x + y/2 with x = -6 + 2i, of "right" with x = 2 + 2i, see rays_test.py.
THROUGH = {"origin": [-10, 1, 0], "direction": [1, 0, 0]}
BETWEEN = {"origin": [1, 10, 0], "direction": [0, -1, 0]}
SIX = [(4.5, "left", 0), (6.5, "left", 1), (8.5, "left", 2), (12.5, "right", 0), (14.5, "right", 1), (16.5, "right", 2)]

# Down the axis of the clock tower: the spire is a pyramid with its tip at y = 32 and its square bottom at
# y = 24, the tower a box from y = 0 to 24 with a ledge, a box from y = 18 to 18.5. The axis meets the tip,
# where 4 triangles meet, and the diagonal of each square, where 2 do.
DOWN = {"origin": [0, 100, 0], "direction": [0, -1, 0], "tmax": 99}
TOWER = [(68, "spire", 4), (76, "clock tower", 2), (76, "spire", 2), (81.5, "clock tower", 2), (82, "clock tower", 2)]


def passages(hits):
    """Runs of hits at one t on one node, as (t, node, length)."""
    runs = []
    for hit in hits:
        if runs and runs[-1][:2] == (hit["t"], hit["node"]):
            runs[-1] = (*runs[-1][:2], runs[-1][2] + 1)
        else:
            runs.append((hit["t"], hit["node"], 1))
    return runs


class Lists(TwoScenes):
    def ask(self, scene, kind, body):
        answer = self.server.query(scene, kind, body)
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def count(self, scene, *rays, **more):
        return self.ask(scene, "count", {"rays": list(rays), **more})["counts"]

    def test_all_of_six_triangles_in_the_order_of_t(self):
        through, between = self.ask("six", "all", {"rays": [THROUGH, BETWEEN]})["results"]
        self.assertEqual(through["total"], 6)
        self.assertEqual([(hit["t"], hit["node"], hit["triangle"]) for hit in through["hits"]], SIX)
        self.assertEqual(between, {"total": 0, "hits": []})
        self.assertEqual(self.count("six", THROUGH, BETWEEN), [6, 0])

    def test_limits_are_closed_here_too(self):
        ray = {**THROUGH, "tmin": 6.5, "tmax": 14.5}
        results = self.ask("six", "all", {"rays": [ray], "fields": ["t"]})["results"]
        self.assertEqual(results, [{"total": 4, "hits": [{"t": t} for t in (6.5, 8.5, 12.5, 14.5)]}])
        self.assertEqual(self.count("six", ray), [4])

    def test_a_cut_list_says_how_many_there_were(self):
        for most in (0, 1, 5, 6, 7):
            with self.subTest(max_hits=most):
                (result,) = self.ask("six", "all", {"rays": [THROUGH], "max_hits": most, "fields": ["t"]})["results"]
                self.assertEqual(result["total"], 6)
                self.assertEqual([hit["t"] for hit in result["hits"]], [t for t, _, _ in SIX][:most])

    def test_columns_in_columns_out(self):
        body = {"origins": THROUGH["origin"] + BETWEEN["origin"] + THROUGH["origin"],
                "directions": THROUGH["direction"] + BETWEEN["direction"] + [-1, 0, 0], "tmin": [0, 0, -5]}
        self.assertEqual(self.ask("six", "count", body), {"counts": [6, 0, 1]})
        lists = self.ask("six", "all", {**body, "fields": ["t", "triangle", "position", "node"], "max_hits": 2})
        self.assertEqual(lists, {"totals": [6, 0, 1], "first": [0, 2, 2, 3], "t": [4.5, 6.5, -4.5], "triangle": [0, 1, 0],
                                 "position": [-5.5, 1, 0, -3.5, 1, 0, -5.5, 1, 0], "node": ["left"] * 3})

    def test_a_hit_in_a_list_has_what_the_closest_has(self):
        for fields in (None, ["t", "instance", "primitive", "triangle", "position", "normal", "barycentrics", "front", "node",
                              "node_id", "mesh", "mesh_id", "material", "material_id"]):
            with self.subTest(fields=fields):
                body = {"rays": [DOWN, {"origin": [-40, 12, 1], "direction": [1, 0, 0]}]}
                if fields:
                    body["fields"] = fields
                closest = self.ask("town", "closest", body)["hits"]
                lists = self.ask("town", "all", body)["results"]
                self.assertEqual([result["hits"][0] for result in lists], closest)

    def test_the_tip_of_the_spire_is_four_hits_and_what_lies_below(self):
        (result,) = self.ask("town", "all", {"rays": [DOWN]})["results"]
        self.assertEqual(passages(result["hits"]), TOWER)
        self.assertEqual([hit["triangle"] for hit in result["hits"][:4]], [0, 1, 2, 3])
        self.assertEqual(result["total"], 12)

    def test_crossings_once_count_each_surface_once(self):
        (result,) = self.ask("town", "all", {"rays": [DOWN], "crossings": "once"})["results"]
        self.assertEqual(passages(result["hits"]), [(t, node, 1) for t, node, _ in TOWER])
        self.assertEqual(result["total"], 5)
        self.assertEqual(self.count("town", DOWN, crossings="once"), [5])
        self.assertEqual(self.count("town", DOWN, crossings="every"), [12])

    def test_parity_tells_inside_from_outside_though_the_ray_leaves_by_the_tip(self):
        # (0, y, 0) looking up: above the tip, in the spire, and in the tower below it but not in the ledge.
        points = [(33, 0), (28, 1), (20, 3)]
        rays = [{"origin": [0, y, 0], "direction": [0, 1, 0]} for y, _ in points]
        self.assertEqual(self.count("town", *rays, crossings="once"), [crossings for _, crossings in points])
        # By every triangle: 4 at the tip say "outside" to a point inside of the spire.
        self.assertEqual(self.count("town", *rays), [0, 4, 8])

    def test_no_rays_have_no_lists(self):
        self.assertEqual(self.ask("six", "all", {"rays": []}), {"results": []})
        self.assertEqual(self.ask("six", "count", {"rays": []}), {"counts": []})
        self.assertEqual(self.ask("six", "all", {"origins": [], "directions": [], "fields": ["t"]}),
                         {"totals": [], "first": [0], "t": []})

    def test_counts_are_the_totals_of_lists_on_any_kernel_and_number_of_threads(self):
        rays = [{"origin": [x * 14 - 350, 60, z * 35 - 350], "direction": [0.25, -1, 0.125 * x]}
                for x in range(50) for z in range(20)]
        expected = self.server.query("town", "all", {"rays": rays})
        totals = [result["total"] for result in expected.json()["results"]]
        self.assertGreater(sum(totals), 500)
        for kernel in self.server.ask("/version").json()["kernels"]:
            with self.subTest(kernel=kernel), \
                    Server("--preload", "town=demo:town", "--kernel", kernel, "--threads", 3) as other:
                self.assertEqual(other.query("town", "all", {"rays": rays}).body, expected.body)
                self.assertEqual(other.query("town", "count", {"rays": rays}).json()["counts"], totals)


if __name__ == "__main__":
    case_report.main()
