"""Masks of nodes and of rays."""

import json
import random
import unittest

import case_report
from patch_test import patch
from sightline_server import JSON_TYPE, Server, demo_glb, with_document

ALONG = {"origin": [-10, 1, 0], "direction": [1, 0, 0]}
LEFT_T, RIGHT_T = 4.5, 12.5


def masked(glb, masks):
    """The GLB with masks of some nodes, by index."""

    def put(document):
        for index, mask in masks.items():
            document["nodes"][index]["extras"] = {"sightline": {"mask": mask}, "other": [1]}

    return with_document(glb, put)


class Masks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "plain=demo:six")
        cls.addClassCleanup(cls.server.end)
        # The root's holds for left, which has none of its own.
        assert cls.server.put("six", masked(demo_glb("six"), {0: 1, 2: 6})).status == 201

    def ask(self, kind, body, scene="six"):
        answer = self.server.ask(f"/v1/scenes/{scene}/{kind}", "-H", JSON_TYPE, body=json.dumps(body))
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def test_a_ray_meets_what_has_a_bit_in_common(self):
        for mask, t in [(1, LEFT_T), (2, RIGHT_T), (4, RIGHT_T), (3, LEFT_T), (8, None), (0, None), (2**32 - 1, LEFT_T)]:
            for body in ({"rays": [ALONG], "mask": mask}, {"rays": [{**ALONG, "mask": mask}]}):
                with self.subTest(body=body):
                    hits = self.ask("rays:closest", {**body, "fields": ["t"]})["hits"]
                    self.assertEqual(hits, [t and {"t": t}])
        self.assertEqual(self.ask("rays:any", {"rays": [ALONG], "mask": 8})["hits"], [False])
        self.assertEqual(self.ask("rays:count", {"rays": [ALONG] * 2, "mask": 4})["counts"], [3, 3])
        points = self.ask("points:closest", {"points": [[-10, 1, 0]], "mask": 2, "fields": ["node"]})
        self.assertEqual(points["hits"], [{"node": "right"}])
        self.assertEqual(self.ask("visibility", {"from": [[-10, 1, 0]], "to": [[1, 1, 0]], "mask": 2})["visible"], ["1"])

    def test_nothing_meets_a_node_whose_mask_is_empty(self):
        assert self.server.put("empty", masked(demo_glb("six"), {0: 0, 2: 6})).status == 201
        for more in ({}, {"mask": 2**32 - 1}, {"cull": "none"}, {"exclude": {"nodes": []}}, {"exclude": {"names": ["nobody"]}}):
            with self.subTest(more=more):
                hits = self.ask("rays:closest", {"rays": [ALONG], "fields": ["t"], **more}, "empty")["hits"]
                self.assertEqual(hits, [{"t": RIGHT_T}])
                self.assertEqual(self.ask("rays:count", {"rays": [ALONG], **more}, "empty")["counts"], [3])
        points = self.ask("points:closest", {"points": [[-10, 1, 0]], "fields": ["node"]}, "empty")
        self.assertEqual(points["hits"], [{"node": "right"}])
        # A change takes it back.
        self.assertEqual(patch(self.server, 0, {"mask": 1}, scene="empty").status, 200)
        self.assertEqual(self.ask("rays:closest", {"rays": [ALONG], "fields": ["t"]}, "empty")["hits"], [{"t": LEFT_T}])

    def test_each_ray_may_have_its_own(self):
        columns = {"origins": ALONG["origin"] * 4, "directions": ALONG["direction"] * 4, "masks": [1, 2, 8, 5], "fields": ["t"]}
        self.assertEqual(self.ask("rays:closest", columns)["t"], [LEFT_T, RIGHT_T, None, LEFT_T])
        self.assertEqual(self.ask("rays:closest", {**columns, "mask": 6})["t"], [None, RIGHT_T, None, RIGHT_T])
        rows = {"rays": [ALONG, {**ALONG, "mask": 2}, ALONG, {**ALONG, "mask": 0}], "fields": ["t"]}
        self.assertEqual([hit and hit["t"] for hit in self.ask("rays:closest", rows)["hits"]], [LEFT_T, RIGHT_T, LEFT_T, None])
        # Without masks in the scene a ray meets everything, or nothing with a mask of 0.
        self.assertEqual(self.ask("rays:any", {"rays": [{**ALONG, "mask": 8}, {**ALONG, "mask": 0}]}, "plain")["hits"], [True, False])
        lines = "".join(json.dumps({**ALONG, "mask": mask}) + "\n" for mask in (2, 1, 8))
        lines += json.dumps(ALONG) + "\n"
        answer = self.server.ask("/v1/scenes/six/rays:any", "-H", "Content-Type: application/x-ndjson", body=lines)
        self.assertEqual(answer.body, b"true\ntrue\nfalse\ntrue\n")

    def test_an_explanation_names_the_mask(self):
        for body in ({"rays": [{**ALONG, "mask": 8}]}, {"rays": [ALONG], "mask": 8}):
            answer = self.ask("rays:closest", {**body, "explain": True})
            self.assertEqual(answer["hits"], [None])
            seen = [triangle for box in answer["explain"]["boxes"] for triangle in box.get("triangles", [])]
            self.assertEqual({triangle.get("by") for triangle in seen if triangle["verdict"] == "filtered"}, {"mask"})

    def test_random_masks_are_those_of_scenes_without_what_is_masked(self):
        made = random.Random(6)
        server, count = self.server, 12
        glb = demo_glb("town")
        masks = {node: made.choice([1, 2, 4, 6, 0]) for node in range(0, 900, 7)}
        self.assertEqual(server.put("town", masked(glb, masks)).status, 201)
        rays = [{"origin": [made.uniform(-80, 80), 40, made.uniform(-80, 80)],
                 "direction": [made.uniform(-1, 1), -1, made.uniform(-1, 1)]} for _ in range(count)]
        nodes = server.ask("/v1/scenes/town/nodes?limit=100000").json()["nodes"]
        fields = ["t", "instance", "triangle"]
        for bit in (1, 2, 4):
            visible = self.ask("rays:all", {"rays": rays, "mask": bit, "fields": fields}, "town")["results"]
            every = self.ask("rays:all", {"rays": rays, "fields": fields + ["node_id"]}, "town")["results"]
            mask_of = {node["node_id"]: node["mask"] for node in nodes}
            expected = [[{key: hit[key] for key in fields} for hit in result["hits"] if mask_of[hit["node_id"]] & bit]
                        for result in every]
            self.assertEqual([result["hits"] for result in visible], expected)

    def test_a_patch_gives_a_node_a_mask(self):
        with Server("--preload", "six=demo:six") as server:
            self.assertEqual(patch(server, 1, {"mask": 2}).status, 200)
            masks = [node["mask"] for node in server.ask("/v1/scenes/six/nodes").json()["nodes"]]
            self.assertEqual(masks, [2**32 - 1, 2, 2**32 - 1])
            answer = server.query("six", "closest", {"rays": [ALONG], "mask": 1, "fields": ["t"]})
            self.assertEqual(answer.json()["hits"], [{"t": RIGHT_T}])
            self.assertEqual(patch(server, 1, {"mask": -1}).json()["code"], "NUMBER_OUT_OF_RANGE")

    def test_what_is_no_mask_is_refused(self):
        for body, code, pointer in [({"rays": [ALONG], "mask": -1}, "NUMBER_OUT_OF_RANGE", "/mask"),
                                    ({"rays": [ALONG], "mask": 2**32}, "NUMBER_OUT_OF_RANGE", "/mask"),
                                    ({"rays": [{**ALONG, "mask": 1.5}]}, "NUMBER_OUT_OF_RANGE", "/rays/0/mask"),
                                    ({"rays": [ALONG], "masks": [1]}, "KEYS_MIXED", "/masks"),
                                    ({"origins": [0, 0, 0], "directions": [1, 0, 0], "masks": [1, 2]}, "LENGTH_WRONG", "/masks")]:
            with self.subTest(body=body):
                problem = self.server.query("six", "any", body)
                self.assertEqual((problem.status, problem.json()["code"]), (422, code))
                self.assertEqual(problem.json()["errors"][0]["pointer"], pointer)
        refused = self.server.put("bad", masked(demo_glb("six"), {1: "all"}))
        self.assertEqual((refused.status, refused.json()["code"]), (422, "GLTF_VALUE_INVALID"))


if __name__ == "__main__":
    case_report.main()
