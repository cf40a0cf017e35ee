"""Several nodes in one PATCH: one revision, the bytes of the same changes one by one, all or nothing, and durable."""

import json
import math
import random
import tempfile
import unittest
from pathlib import Path

import case_report
from made_scene import glb, glb_parts, tiles
from sightline_server import Server

DOWN = [([5 + 10 * x, 50, 5 + 10 * z], [0, -1, 0.01]) for x in range(32) for z in range(4)]
FIELDS = ["t", "node_id", "position", "instance"]


def patch(server, body, *arguments, scene="tiles", node=""):
    return server.ask(f"/v1/scenes/{scene}/nodes{node}", "-X", "PATCH", "-H", "Content-Type: application/json", *arguments,
                      body=json.dumps(body))


def random_changes(made, nodes, count):
    changes = []
    for node in made.sample(range(nodes), count):
        change = {"node": node}
        kind = made.randrange(4)
        if kind == 0:
            change["translation"] = [10 * (node % 32), made.uniform(0, 9), 10 * (node // 32)]
        elif kind == 1:
            angle = made.uniform(-1, 1)
            change |= {"translation": [10 * (node % 32), 1, 10 * (node // 32)], "rotation": [0, 0, math.sin(angle), math.cos(angle)]}
        elif kind == 2:
            change["hidden"] = made.random() < 0.5
        else:
            change["mask"] = made.randrange(1, 8)
        changes.append(change)
    return changes


class PatchMany(unittest.TestCase):
    def server(self, *arguments):
        server = Server(*arguments)
        self.addCleanup(server.end)
        return server

    def put(self, server, scene="tiles", count=128):
        answer = server.put(scene, tiles(4, count))
        self.assertEqual(answer.status, 201, answer.body)

    def answers(self, server, scene="tiles"):
        nodes = server.ask(f"/v1/scenes/{scene}/nodes?limit=100000").json()["nodes"]
        return nodes, server.closest(scene, *DOWN, fields=FIELDS)

    def test_the_answers_are_those_of_the_same_changes_one_by_one(self):
        server = self.server()
        made = random.Random(24)
        for scene in ("tiles", "single"):
            self.put(server, scene)
        for _ in range(4):
            changes = random_changes(made, 128, 40)
            # Scenes share the numbers of revisions.
            before = max(server.ask(f"/v1/scenes/{scene}").json()["revision"] for scene in ("tiles", "single"))
            done = patch(server, {"nodes": changes})
            self.assertEqual(done.status, 200, done.body)
            self.assertEqual(done.headers["x-scene-revision"], str(done.json()["revision"]))
            self.assertEqual(done.json()["revision"], before + 1, "one revision")
            for change in changes:
                rest = {key: value for key, value in change.items() if key != "node"}
                self.assertEqual(patch(server, rest, scene="single", node=f"/{change['node']}").status, 200)
            self.assertEqual(self.answers(server), self.answers(server, "single"))
        etags = [server.ask(f"/v1/scenes/{scene}").headers["etag"] for scene in ("tiles", "single")]
        self.assertEqual(etags[0], etags[1], "the same content has the same tag")

    def test_all_or_nothing(self):
        server = self.server()
        self.put(server)
        before, revision = self.answers(server), server.ask("/v1/scenes/tiles").json()["revision"]
        good = {"node": 3, "translation": [0, 5, 0]}
        for nodes, status, code, pointer in [
                ([good, {"node": 128, "hidden": True}], 404, "NODE_NOT_FOUND", "/nodes/1"),
                ([good, {"node": 4}], 422, "KEY_MISSING", "/nodes/1"),
                ([good, {"hidden": True}], 422, "KEY_MISSING", "/nodes/1"),
                ([good, good], 422, "KEY_DUPLICATE", "/nodes/1"),
                ([good, {"node": 4, "translation": [0, 1]}], 422, "LENGTH_WRONG", "/nodes/1/translation"),
                ([good, {"node": 4, "translation": [0, 1e300, 0]}], 422, "TRANSFORM_INVALID", "/nodes/1/translation"),
                ([good, {"node": 4, "matrix": [1] * 16, "scale": [1, 1, 1]}], 422, "KEYS_MIXED", "/nodes/1/scale"),
                ([good, {"node": -4, "mask": 1}], 422, "NUMBER_OUT_OF_RANGE", "/nodes/1/node"),
                ([good, {"node": 4, "mask": 2**32}], 422, "NUMBER_OUT_OF_RANGE", "/nodes/1/mask"),
                ([good, {"node": 4, "colour": 1}], 422, "KEY_UNKNOWN", "/nodes/1/colour"),
                ([good, 7], 422, "TYPE_WRONG", "/nodes/1"),
                ([], 422, "KEY_MISSING", "/nodes")]:
            with self.subTest(nodes=nodes):
                answer = patch(server, {"nodes": nodes})
                self.assertEqual((answer.status, answer.json()["code"]), (status, code), answer.body)
                self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)
        self.assertEqual(patch(server, {}).json()["code"], "KEY_MISSING")
        self.assertEqual(patch(server, {"nodes": [good]}, "-H", 'If-Match: "other"').status, 412)
        self.assertEqual(patch(server, {"nodes": [good]}, scene="none").status, 404)
        self.assertEqual(self.answers(server), before)
        self.assertEqual(server.ask("/v1/scenes/tiles").json()["revision"], revision)

    def test_a_thousand_of_four_thousand_nodes_answer_as_a_file_with_their_transforms(self):
        made = random.Random(4000)
        for own in (False, True):
            file = glb_parts(tiles(4, 4000, own))
            changes = []
            for node in made.sample(range(4000), 1000):
                angle, scale = made.uniform(-1, 1), [made.uniform(0.5, 2) for _ in range(3)]
                changes.append({"node": node, "translation": [10 * (node % 32), made.uniform(-5, 5), 10 * (node // 32)],
                                "rotation": [0, math.sin(angle), 0, math.cos(angle)], "scale": scale})
            for change in changes:
                file[0]["nodes"][change["node"]].update({key: change[key] for key in ("translation", "rotation", "scale")})
            rays = [{"origin": [made.uniform(0, 320), 50, made.uniform(0, 1250)], "direction": [0.01, -1, 0.02]} for _ in range(500)]
            with self.subTest(own=own), Server(memory=None) as server:
                self.assertEqual(server.put("moved", tiles(4, 4000, own)).status, 201)
                self.assertEqual(server.put("fresh", glb(*file)).status, 201)
                # With trees of the file, without trees of the moved scene, and with both.
                for nodes in (changes[:500], changes):
                    server.query("moved", "closest", {"rays": rays[:1]})
                    self.assertEqual(patch(server, {"nodes": nodes}, scene="moved").status, 200)
                for kind in ("closest", "all", "any"):
                    fields = {} if kind == "any" else {"fields": [*FIELDS, "triangle", "normal", "barycentrics", "node"]}
                    both = [server.query(scene, kind, {"rays": rays, **fields}) for scene in ("moved", "fresh")]
                    self.assertEqual(both[0].status, 200, both[0].body)
                    self.assertEqual(both[0].body, both[1].body)
                both = [server.ask(f"/v1/scenes/{scene}/nodes?limit=10000").json()["nodes"] for scene in ("moved", "fresh")]
                self.assertEqual(*both)

    def test_a_thousand_changes_survive_a_kill(self):
        with tempfile.TemporaryDirectory() as folder:
            data = Path(folder, "data")
            server = self.server("--data", data)
            self.put(server, count=1200)
            changes = [{"node": node, "translation": [10 * (node % 32), node % 7 / 4, 10 * (node // 32)]} for node in range(1000)]
            done = patch(server, {"nodes": changes})
            self.assertEqual(done.status, 200, done.body)
            expected = self.answers(server)
            self.assertEqual(expected[1][0]["node_id"], 0)
            server.kill()
            again = self.server("--data", data)
            self.assertEqual(self.answers(again), expected)
            self.assertEqual(again.ask("/v1/scenes/tiles").json()["revision"], done.json()["revision"])
            # Before its folder goes: it still writes trees there.
            self.assertEqual(again.stop(), 0)


if __name__ == "__main__":
    case_report.main()
