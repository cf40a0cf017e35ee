"""Nodes that are moved and hidden: what is answered before and after, what is rebuilt, and what a kill leaves."""

import json
import random
import tempfile
import threading
import unittest
from pathlib import Path

import case_report
from sightline_server import JSON_TYPE, Server, demo_glb, with_document

DOWN = ([3, 10, 0], [0, -1, 0])
ALONG = ([-10, 1, 0], [1, 0, 0])
RIGHT, LEFT = 2, 1  # nodes of "six"


def patch(server, node, body, *arguments, scene="six"):
    return server.ask(f"/v1/scenes/{scene}/nodes/{node}", "-X", "PATCH", "-H", "Content-Type: application/json", *arguments,
                      body=json.dumps(body))


def with_matrices(glb, matrices):
    """The GLB with other matrices of some nodes, by index."""

    def put(document):
        for index, matrix in matrices.items():
            node = document["nodes"][index]
            for key in ("translation", "rotation", "scale"):
                node.pop(key, None)
            node["matrix"] = matrix

    return with_document(glb, put)


class Patch(unittest.TestCase):
    def server(self, *arguments):
        server = Server(*arguments)
        self.addCleanup(server.end)
        return server

    def test_a_node_moves_and_readers_see_it(self):
        server = self.server("--skip", "none", "--preload", "six=demo:six")
        self.assertEqual(server.closest("six", DOWN)[0]["t"], 8)  # the triangle has y = 2 at x = 3
        before = server.ask("/v1/scenes/six")
        built = server.ask("/v1/scenes/six/stats").json()["trees"]["full_builds"]
        self.assertEqual(built, 1)
        place = server.ask("/v1/scenes/six/nodes").json()["nodes"][2]["bounds"]
        # glTF's translation is the whole transform where the others are left out.
        moved = patch(server, RIGHT, {"translation": [0, 3, 0]})
        self.assertEqual(moved.status, 200, moved.body)
        self.assertEqual(moved.json()["revision"], before.json()["revision"] + 1)
        self.assertEqual(moved.headers["x-scene-revision"], str(moved.json()["revision"]))
        self.assertNotEqual(moved.headers["etag"], before.headers["etag"])
        self.assertEqual(server.closest("six", DOWN)[0]["t"], 5)
        bounds = server.ask("/v1/scenes/six/nodes").json()["nodes"][2]["bounds"]
        self.assertEqual(bounds["min"][1], place["min"][1] + 3)
        trees = server.ask("/v1/scenes/six/stats").json()["trees"]
        self.assertEqual((trees["full_builds"], trees["trees_built"]), (0, 1), "the tree of the one mesh that left")
        self.assertEqual(patch(server, RIGHT, {"translation": [0, 4, 0]}).status, 200)
        self.assertEqual(server.closest("six", DOWN)[0]["t"], 4)
        trees = server.ask("/v1/scenes/six/stats").json()["trees"]
        self.assertEqual((trees["full_builds"], trees["trees_built"], trees["trees_kept"]), (0, 0, 2))
        self.assertEqual(server.ask("/v1/scenes/six/selfcheck?rays=200").json()["different"], [])

    def test_what_is_below_moves_and_hides_too(self):
        server = self.server("--preload", "six=demo:six")
        self.assertEqual(server.closest("six", ALONG)[0]["t"], 4.5)
        self.assertEqual(patch(server, 0, {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.25, 0, 0, 1]}).status, 200)
        self.assertEqual(server.closest("six", ALONG)[0]["t"], 4.75)
        hidden = patch(server, LEFT, {"hidden": True})
        self.assertEqual(hidden.json()["counts"]["triangles"], 6)
        hit = server.closest("six", ALONG)[0]
        self.assertEqual((hit["t"], hit["instance"], hit["node"]), (12.75, 1, "right"))
        nodes = server.ask("/v1/scenes/six/nodes").json()["nodes"]
        self.assertEqual([(node["hidden"], node["bounds"] is None) for node in nodes], [(False, True), (True, True), (False, False)])
        self.assertEqual(patch(server, 0, {"hidden": True}).json()["bounds"], None)
        self.assertEqual(server.closest("six", ALONG), [None])
        patch(server, 0, {"hidden": False})
        patch(server, LEFT, {"hidden": False})
        self.assertEqual(server.closest("six", ALONG)[0]["t"], 4.75)

    def test_answers_are_the_bytes_of_a_file_that_says_so(self):
        server = self.server("--preload", "town=demo:town")
        glb, made = demo_glb("town"), random.Random(4)
        count = server.ask("/v1/scenes/town/nodes?limit=0").json()["total"]
        matrices = {}
        for _ in range(12):
            node = made.randrange(count)
            matrix = [made.uniform(-2, 2) for _ in range(16)]
            matrix[3] = matrix[7] = matrix[11] = 0
            matrix[12:] = [made.uniform(-60, 60), made.uniform(0, 9), made.uniform(-60, 60), 1]
            matrices[node] = matrix
            self.assertEqual(patch(server, node, {"matrix": matrix}, scene="town").status, 200)
        self.assertEqual(server.put("fresh", with_matrices(glb, matrices)).status, 201)
        rays = {"rays": [{"origin": [made.uniform(-90, 90), 60, made.uniform(-90, 90)],
                          "direction": [made.uniform(-1, 1), -1, made.uniform(-1, 1)]} for _ in range(400)]}
        boxes = {"boxes": [{"center": [made.uniform(-90, 90), 3, made.uniform(-90, 90)], "radius": 4} for _ in range(60)], "of": "nodes"}
        points = {"points": [[made.uniform(-90, 90), made.uniform(0, 30), made.uniform(-90, 90)] for _ in range(60)]}
        for kind, body in (("rays:closest", rays), ("rays:all", rays), ("boxes:list", boxes), ("points:closest", points)):
            with self.subTest(kind=kind):
                answers = [server.ask(f"/v1/scenes/{scene}/{kind}", "-H", JSON_TYPE, body=json.dumps(body)) for scene in ("town", "fresh")]
                self.assertEqual([answer.status for answer in answers], [200, 200])
                self.assertEqual(answers[0].body, answers[1].body)

    def test_what_was_acknowledged_survives_a_kill(self):
        with tempfile.TemporaryDirectory() as folder:
            data = Path(folder, "data")
            server = self.server("--data", data)
            server.put("six", demo_glb("six"))
            patch(server, RIGHT, {"translation": [0, 3, 0]})
            last = patch(server, LEFT, {"hidden": True})
            server.kill()
            server = self.server("--data", data)
            self.assertEqual(server.ask("/v1/scenes/six").body, last.body)
            self.assertEqual(server.ask("/v1/scenes/six").headers["etag"], last.headers["etag"])
            self.assertEqual(server.closest("six", DOWN, ALONG)[0]["t"], 5)
            self.assertEqual(patch(server, LEFT, {"hidden": False}).json()["revision"], last.json()["revision"] + 1)
            server.kill()
            server = self.server("--data", data)
            self.assertEqual([hit["t"] for hit in server.closest("six", DOWN, ALONG)], [5, 4.5])
            # A new file is what it says, whatever was changed of the one before.
            server.put("six", demo_glb("six"))
            server.kill()
            server = self.server("--data", data)
            self.assertEqual(server.closest("six", DOWN)[0]["t"], 8)
            # Before its folder goes: it still writes trees there.
            self.assertEqual(server.stop(), 0)

    def test_of_changes_at_once_each_is_there(self):
        server = self.server("--preload", "six=demo:six")
        done = []

        def move(node, coordinate):
            for step in range(8):
                done.append(patch(server, node, {"translation": [coordinate, step, 0]}).status)

        threads = [threading.Thread(target=move, args=each) for each in ((LEFT, 0), (RIGHT, 0))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(done, [200] * 16)
        bounds = [node["bounds"]["min"][1] for node in server.ask("/v1/scenes/six/nodes").json()["nodes"][1:]]
        self.assertEqual(bounds, [7, 7])
        self.assertEqual(server.ask("/v1/scenes/six").json()["revision"], 17)

    def test_faults_change_nothing(self):
        server = self.server("--preload", "six=demo:six")
        before = server.ask("/v1/scenes/six")
        for node, body, status, code, pointer in [
                (RIGHT, {}, 422, "KEY_MISSING", None), (RIGHT, {"hiden": True}, 422, "KEY_UNKNOWN", "/hiden"),
                (RIGHT, {"hidden": 1}, 422, "TYPE_WRONG", "/hidden"), (RIGHT, [], 422, "TYPE_WRONG", None),
                (RIGHT, {"scale": [1, 1]}, 422, "LENGTH_WRONG", "/scale"),
                (RIGHT, {"scale": [1, None, 1]}, 422, "TYPE_WRONG", "/scale/1"),
                (RIGHT, {"matrix": [0] * 16}, 422, "TRANSFORM_INVALID", "/matrix"),
                (RIGHT, {"matrix": [1] * 16, "scale": [1, 1, 1]}, 422, "KEYS_MIXED", "/scale"),
                (RIGHT, {"rotation": [0, 0, 0, 0]}, 422, "TRANSFORM_INVALID", "/rotation"),
                (RIGHT, {"translation": [1e39, 0, 0]}, 422, "TRANSFORM_INVALID", "/translation"),
                (99, {"hidden": True}, 404, "NODE_NOT_FOUND", None), ("right", {"hidden": True}, 404, "NODE_NOT_FOUND", None)]:
            with self.subTest(node=node, body=body):
                problem = patch(server, node, body)
                self.assertEqual((problem.status, problem.json()["code"]), (status, code))
                if pointer:
                    self.assertEqual(problem.json()["errors"][0]["pointer"], pointer)
        self.assertEqual(patch(server, 0, {"hidden": True}, scene="none").json()["code"], "SCENE_NOT_FOUND")
        for node in ("0?wait=1", "0?scene=0&hidden=true"):
            problem = patch(server, node, {"hidden": True})
            self.assertEqual((problem.status, problem.json()["code"]), (422, "QUERY_INVALID"))
        for body in ("{", '{"hidden":true,"hidden":false}'):
            answer = server.ask("/v1/scenes/six/nodes/1", "-X", "PATCH", "-H", "Content-Type: application/json", body=body)
            self.assertIn(answer.status, (400, 422))
        untyped = server.ask("/v1/scenes/six/nodes/1", "-X", "PATCH", "-H", "Content-Type:", body='{"hidden":true}')
        self.assertEqual(untyped.status, 415)
        self.assertEqual(patch(server, 1, {"hidden": True}, "-H", 'If-Match: "another", W/' + before.headers["etag"]).status, 412)
        self.assertEqual(server.ask("/v1/scenes/six").body, before.body)
        self.assertEqual(patch(server, 1, {"hidden": True}, "-H", 'If-Match: "another", ' + before.headers["etag"]).status, 200)
        self.assertEqual(patch(server, 1, {"hidden": False}, "-H", "If-Match: *").status, 200)


if __name__ == "__main__":
    case_report.main()
