"""Filters of single triangles: the answers are those of the other hits of each ray."""

import json
import random
import unittest

import case_report
from made_scene import tiles
from sightline_server import Server

NODES = 9
FIELDS = ["t", "instance", "primitive", "triangle"]


def made_rays(count, seed=5):
    made = random.Random(seed)
    return [{"origin": [made.uniform(0, 90), 3, made.uniform(-3, 13)], "direction": [made.uniform(-1, 1), made.uniform(-.5, .1), made.uniform(-.3, .3)]}
            for _ in range(count)]


class TriangleFilters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server(memory=None)
        cls.addClassCleanup(cls.server.end)
        answer = cls.server.put("tiles", tiles(6, NODES))
        assert answer.status == 201, answer.body

    def ask(self, kind, body, status=200, scene="tiles"):
        answer = self.server.query(scene, kind, body)
        self.assertEqual(answer.status, status, answer.body)
        return answer.json()

    def named(self, hit):
        return hit["instance"], hit["primitive"], hit["triangle"]

    def test_each_question_of_rays_leaves_out_what_is_excluded_and_takes_what_is_included(self):
        rays = made_rays(600)
        plain = self.ask("all", {"rays": rays, "fields": FIELDS})["results"]
        every = sorted({self.named(hit) for result in plain for hit in result["hits"]})
        self.assertGreater(len(every), 200)
        chosen = set(random.Random(2).sample(every, len(every) // 3))
        some = [list(name) for name in chosen]
        for filters, counts in (({"exclude": {"triangles": some}}, lambda hit: self.named(hit) not in chosen),
                                ({"include": {"triangles": some}}, lambda hit: self.named(hit) in chosen),
                                ({"exclude": {"triangles": some, "names": ["tile 1", "tile 4"]}},
                                 lambda hit: self.named(hit) not in chosen or hit["instance"] not in (1, 4)),
                                ({"include": {"triangles": some}, "exclude": {"nodes": [2]}},
                                 lambda hit: self.named(hit) in chosen and hit["instance"] != 2)):
            with self.subTest(filters=list(filters)):
                expected = [[hit for hit in result["hits"] if counts(hit)] for result in plain]
                self.assertEqual([result["hits"] for result in self.ask("all", {"rays": rays, "fields": FIELDS, **filters})["results"]], expected)
                self.assertEqual(self.ask("closest", {"rays": rays, "fields": FIELDS, **filters})["hits"],
                                 [hits[0] if hits else None for hits in expected])
                self.assertEqual(self.ask("any", {"rays": rays, **filters})["hits"], [bool(hits) for hits in expected])
                self.assertEqual(self.ask("count", {"rays": rays, **filters})["counts"], [len(hits) for hits in expected])
                each = {"filters": {"list": [{}, filters], "rays": [i % 2 for i in range(len(rays))]}}
                self.assertEqual(self.ask("count", {"rays": rays, **each})["counts"],
                                 [len((plain[i]["hits"], expected[i])[i % 2]) for i in range(len(rays))])
        # Culling applies to what is left.
        backs = self.ask("all", {"rays": rays, "fields": FIELDS, "cull": "back"})["results"]
        self.assertEqual([result["hits"] for result in self.ask("all", {"rays": rays, "fields": FIELDS, "cull": "back", "exclude": {"triangles": some}})
                          ["results"]], [[hit for hit in result["hits"] if self.named(hit) not in chosen] for result in backs])

    def test_explanations_nearest_triangles_and_sweeps_leave_it_out_too(self):
        ray = {"origin": [15.3, 3, 5.2], "direction": [0, -1, 0]}
        hit = self.ask("closest", {"rays": [ray], "fields": FIELDS})["hits"][0]
        without = {"exclude": {"triangles": [list(self.named(hit))]}}
        self.assertEqual(self.ask("closest", {"rays": [ray], **without})["hits"], [None])
        explained = self.ask("closest", {"rays": [ray], "explain": True, **without})
        self.assertEqual(explained["hits"], [None])
        self.assertEqual(self.ask("any", {"rays": [ray], **without})["hits"], [False])

        def post(path, body):
            answer = self.server.ask("/v1/scenes/tiles/" + path, "-H", "Content-Type: application/json", body=json.dumps(body))
            self.assertEqual(answer.status, 200, answer.body)
            return answer.json()
        near = {"points": [[15.3, 3, 5.2]], "count": 5, "fields": ["distance", *FIELDS[1:]]}
        first = post("points:nearest", near)["results"][0]["hits"]
        self.assertEqual(len(first), 5)
        left = {"exclude": {"triangles": [list(self.named(first[0])), list(self.named(first[2]))]}}
        self.assertEqual(post("points:nearest", {**near, "count": 3, **left})["results"][0]["hits"], [first[1], first[3], first[4]])
        only = {"include": {"triangles": [list(self.named(first[3]))]}}
        self.assertEqual(post("points:closest", {"points": near["points"], "fields": near["fields"], **only})["hits"], [first[3]])
        sweep = {"sweeps": [{"origin": [15, 3, 5], "direction": [0, -1, 0], "radius": 0.01}], "fields": FIELDS}
        met = post("sweeps:closest", sweep)["hits"][0]
        other = post("sweeps:closest", {**sweep, "exclude": {"triangles": [list(self.named(met))]}})["hits"][0]
        self.assertTrue(other is None or (self.named(other) != self.named(met) and other["t"] >= met["t"]))
        self.assertEqual(post("sweeps:closest", {**sweep, "include": {"triangles": [list(self.named(met))]}})["hits"], [met])

    def test_what_is_wrong_has_a_place(self):
        ray = made_rays(1)
        for triangles, code, pointer in (([[0, 0, 72]], "TRIANGLE_UNKNOWN", "/exclude/triangles/0"), ([[0, 0, 1], [9, 0, 0]], "TRIANGLE_UNKNOWN", "/exclude/triangles/1"),
                                         ([[0, 0]], "LENGTH_WRONG", "/exclude/triangles/0"), ([[0, 0, 1, 2]], "LENGTH_WRONG", "/exclude/triangles/0"),
                                         ([[0, 0, "x"]], "TYPE_WRONG", "/exclude/triangles/0/2"), (["0.0.1"], "TYPE_WRONG", "/exclude/triangles/0"),
                                         ({}, "TYPE_WRONG", "/exclude/triangles")):
            with self.subTest(triangles=triangles):
                answer = self.server.query("tiles", "closest", {"rays": ray, "exclude": {"triangles": triangles}}).json()
                self.assertEqual((answer["code"], answer["errors"][0]["pointer"]), (code, pointer))
        answer = self.server.query("tiles", "closest", {"rays": ray, "exclude": {"triangles": [[0, 0, 1]] * 100_001}})
        self.assertEqual((answer.status, answer.json()["code"]), (413, "FILTER_TOO_LARGE"))
        warned = self.ask("closest", {"rays": ray, "include": {"triangles": [[0, 0, 1]], "nodes": [3]}})
        self.assertEqual((warned["hits"], warned["warnings"][0]["pointer"]), ([None], "/include"))
        self.assertEqual(self.ask("closest", {"rays": ray, "include": {"triangles": []}})["hits"], [None])
        # The inside of a body and clearances are of whole primitives.
        answer = self.server.ask("/v1/scenes/tiles/points:inside", "-H", "Content-Type: application/json",
                                 body=json.dumps({"points": [[0, 0, 0]], "exclude": {"triangles": [[0, 0, 1]]}}))
        self.assertEqual((answer.status, answer.json()["code"]), (422, "KEY_UNKNOWN"))


if __name__ == "__main__":
    case_report.main()
