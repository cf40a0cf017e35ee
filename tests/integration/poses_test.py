"""Poses by PATCH: joints, morph weights and animations, against files in that pose and an own reading of the file's bytes."""

import base64
import bisect
import json
import math
import random
import struct
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import case_report
from attributes_test import MAPPED_FROM, File
from patch_test import patch
from posed_attributes_test import Posed, local
from sightline_server import JSON_TYPE, SOURCE, Server, shared_scene, with_document

sys.path.insert(0, str(SOURCE / "proto/python"))
import sightline  # noqa: E402  (found only now)

SKINNED, HIP, KNEE, MORPHED, SECOND, MOVED, STILL, APART, FIXED = range(9)
FIELDS = ["t", "instance", "primitive", "triangle", "position", "normal", "shading_normal", "barycentrics", "node_id"]


def times(file, values):
    return file.add([[value] for value in values], "SCALAR", 5126, min=[min(values)], max=[max(values)])


def cloud(file, made, at, count=24, **more):
    """Triangles about a place, as a primitive."""
    rows = [[at[i] + made.uniform(-2, 2) for i in range(3)] for _ in range(3 * count)]
    position = file.add(rows, "VEC3", 5126, min=[min(row[i] for row in rows) for i in range(3)],
                        max=[max(row[i] for row in rows) for i in range(3)])
    normals = file.add([[made.uniform(-1, 1) for _ in range(3)] for _ in rows], "VEC3", 5126)
    return {"attributes": {"POSITION": position, "NORMAL": normals}, **more}


def moves(file, made, count=24):
    rows = [[made.uniform(-1, 1) for _ in range(3)] for _ in range(3 * count)]
    return file.add(rows, "VEC3", 5126, min=[-1, -1, -1], max=[1, 1, 1])


def turn(made):
    numbers = [made.gauss(0, 1) for _ in range(4)]
    length = math.sqrt(sum(x * x for x in numbers))
    return [x / length for x in numbers]


def made_file(seed=1, count=24):
    """A skinned mesh, two nodes with one morphed mesh, and nodes that stand: with animations of every kind."""
    made, file = random.Random(seed), File()
    skinned = cloud(file, made, (0, 0, 0), count)
    weights = [[made.uniform(0.1, 1), made.uniform(0.1, 1), 0, 0] for _ in range(3 * count)]
    skinned["attributes"]["WEIGHTS_0"] = file.add([[x / sum(row) for x in row] for row in weights], "VEC4", 5126)
    skinned["attributes"]["JOINTS_0"] = file.add([[0, 1, 0, 0]] * (3 * count), "VEC4", 5121)
    morphed = cloud(file, made, (0, 0, 0), count, targets=[{"POSITION": moves(file, made, count), "NORMAL": moves(file, made, count)},
                                                          {"POSITION": moves(file, made, count)}])
    file.root["meshes"] = [{"primitives": [skinned]}, {"primitives": [morphed], "weights": [0.25, 0]},
                           {"primitives": [cloud(file, made, (0, 0, 0), count)]}, {"primitives": [cloud(file, made, (0, 0, 0), count)]}]
    binds = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, made.uniform(-1, 1), 0.25, 0, 1] for _ in range(2)]
    file.root["skins"] = [{"joints": [HIP, KNEE], "inverseBindMatrices": file.add(binds, "MAT4", 5126)}]
    file.root["nodes"] = [
        {"name": "skinned", "mesh": 0, "skin": 0},
        {"name": "hip", "translation": [-6, 0, 0], "rotation": turn(made), "children": [KNEE]},
        {"name": "knee", "translation": [0, 1, 0], "scale": [1, 1.5, 1]},
        {"name": "morphed", "mesh": 1, "translation": [0, 0, 0]},
        {"name": "second", "mesh": 1, "translation": [6, 0, 0], "weights": [0.25, 0]},
        {"name": "moved", "mesh": 2, "translation": [12, 0, 0]},
        {"name": "still", "mesh": 2, "translation": [18, 0, 0]},
        {"name": "apart", "mesh": 3, "translation": [24, 0, 0]},
        {"name": "fixed", "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 9, 0, 1]}]
    file.root["scenes"][0]["nodes"] = [SKINNED, HIP, MORPHED, SECOND, MOVED, STILL, APART, FIXED]
    keys = times(file, [0.5, 1, 1.75, 4])
    short = times(file, [0, 2])

    def rows(width, number):
        return file.add([[made.uniform(-2, 2) for _ in range(width)] for _ in range(number)], f"VEC{width}", 5126)

    def numbers(number):
        return file.add([[made.uniform(-1, 1)] for _ in range(number)], "SCALAR", 5126)
    small = file.add([[round(32767 * x) for x in turn(made)] for _ in range(2)], "VEC4", 5122, normalized=True)
    bytewise = file.add([[0], [255], [128], [51]], "SCALAR", 5121, normalized=True)
    turns = file.add([turn(made) for _ in range(4)], "VEC4", 5126)
    equal = file.add([[0.0, 0.6, 0.0, 0.8]] * 2, "VEC4", 5126)
    far = file.add([[0.0, 0.6, 0.0, 0.8], [0.0, -0.6, 0.0, -0.8]], "VEC4", 5126)

    def animation(name, *channels):
        samplers = [{"input": one[2], "output": one[3], "interpolation": one[4]} for one in channels]
        targets = [{"sampler": i, "target": {"node": one[0], "path": one[1]}} for i, one in enumerate(channels)]
        file.root.setdefault("animations", []).append({"name": name, "samplers": samplers, "channels": targets})
    animation("walk", (HIP, "rotation", keys, turns, "LINEAR"), (KNEE, "scale", keys, rows(3, 4), "STEP"),
              (MOVED, "translation", short, rows(3, 6), "CUBICSPLINE"), (MORPHED, "weights", keys, numbers(8), "LINEAR"))
    animation("jump", (HIP, "rotation", short, rows(4, 6), "CUBICSPLINE"), (KNEE, "rotation", short, small, "LINEAR"),
              (SECOND, "weights", short, numbers(12), "CUBICSPLINE"), (HIP, "translation", keys, rows(3, 4), "LINEAR"))
    animation("rest", (HIP, "rotation", short, equal, "LINEAR"), (KNEE, "rotation", short, far, "LINEAR"),
              (MORPHED, "weights", short, bytewise, "LINEAR"), (SECOND, "weights", short, bytewise, "STEP"))
    file.root["animations"][0]["samplers"][0].pop("interpolation")
    file.root["animations"].append({"channels": [{"sampler": 0, "target": {"path": "pointer"}}, *file.root["animations"][0]["channels"][1:2]],
                                    "samplers": file.root["animations"][0]["samplers"]})
    return file


class Sampled(Posed):
    """Samples animations by the formulas of glTF 2.0, in float64."""

    def sample(self, number, time):
        """{node: {path: values}}"""
        animation, found = self.root["animations"][number], {}
        for channel in animation["channels"]:
            if "node" not in channel["target"]:
                continue
            node, path = channel["target"]["node"], channel["target"]["path"]
            sampler = animation["samplers"][channel["sampler"]]
            keys = [self.element(sampler["input"], i)[0] for i in range(self.root["accessors"][sampler["input"]]["count"])]
            kind = sampler.get("interpolation", "LINEAR")
            width = {"rotation": 4, "weights": 2}.get(path, 3)

            def value(slot, width=width, output=sampler["output"]):
                if self.root["accessors"][output]["type"] != "SCALAR":
                    return self.element(output, slot)
                return [self.element(output, slot * width + i)[0] for i in range(width)]
            part = (lambda key, k: value(3 * key + k)) if kind == "CUBICSPLINE" else lambda key, k: value(key)
            k = bisect.bisect_right(keys, time) - 1
            if k < 0 or k == len(keys) - 1 or keys[k] == time or kind == "STEP":
                v = part(max(k, 0), 1)
            else:
                v = self.between(kind, path, (time - keys[k]) / (keys[k + 1] - keys[k]), keys[k + 1] - keys[k], k, part)
            if kind == "CUBICSPLINE" and path == "rotation":
                length = math.sqrt(((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]) + v[3] * v[3])
                v = [x / length for x in v]
            found.setdefault(node, {})[path] = v
        return found

    @staticmethod
    def between(kind, path, u, d, k, part):
        v, w = part(k, 1), part(k + 1, 1)
        if kind == "CUBICSPLINE":
            uu, uuu = u * u, u * u * u
            return [(((2 * uuu - 3 * uu) + 1) * v[i] + d * ((uuu - 2 * uu) + u) * part(k, 2)[i] + (3 * uu - 2 * uuu) * w[i])
                    + d * (uuu - uu) * part(k + 1, 0)[i] for i in range(len(v))]
        if path != "rotation":
            return [(1 - u) * a + u * b for a, b in zip(v, w)]
        c = ((v[0] * w[0] + v[1] * w[1]) + v[2] * w[2]) + v[3] * w[3]
        s, a = (-1 if c < 0 else 1), math.acos(min(abs(c), 1))
        if math.sin(a) == 0:
            return [(1 - u) * p + s * u * q for p, q in zip(v, w)]
        first, second = math.sin(a * (1 - u)) / math.sin(a), s * (math.sin(a * u) / math.sin(a))
        return [first * p + second * q for p, q in zip(v, w)]

    def positions(self, node_id):
        """The world corners of each triangle of a node, by the file's accessors."""
        node = self.root["nodes"][node_id]
        primitive, = self.root["meshes"][node["mesh"]]["primitives"]
        weights = node.get("weights", self.root["meshes"][node["mesh"]].get("weights", []))
        joints = list(self.joints(node["skin"])) if "skin" in node else []
        corners = []
        for vertex in range(self.root["accessors"][primitive["attributes"]["POSITION"]]["count"]):
            p = self.element(primitive["attributes"]["POSITION"], vertex)
            for weight, target in zip(weights, primitive.get("targets", [])):
                p = [a + weight * b for a, b in zip(p, self.element(target["POSITION"], vertex))]
            if joints:
                numbers, parts = (self.element(primitive["attributes"][name], vertex) for name in ("JOINTS_0", "WEIGHTS_0"))
                p = [math.fsum(part * (math.fsum(joints[int(j)][i][k] * p[k] for k in range(3)) + joints[int(j)][i][3])
                               for j, part in zip(numbers, parts)) for i in range(3)]
            else:
                matrix = self.world[node_id]
                p = [math.fsum(matrix[i][k] * p[k] for k in range(3)) + matrix[i][3] for i in range(3)]
            corners.append(p)
        return [corners[i:i + 3] for i in range(0, len(corners), 3)]


def in_pose(glb, changes):
    """The file whose nodes say what was changed: {node: {path: values}}."""

    def put(document):
        for number, members in changes.items():
            node = document["nodes"][number]
            if members.keys() - {"weights"}:
                node.pop("matrix", None)
            node.update(members)
        document.pop("animations", None)
    return with_document(glb, put)


def pose(server, scene, body, *arguments):
    return server.ask(f"/v1/scenes/{scene}/nodes", "-X", "PATCH", "-H", "Content-Type: application/json", *arguments, body=json.dumps(body))


class Poses(unittest.TestCase):
    def server(self, *arguments, **options):
        server = Server(*arguments, **options)
        self.addCleanup(server.end)
        return server

    def folder(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        return Path(folder.name, "data")

    def questions(self, seed=3):
        made = random.Random(seed)
        rays = []
        for _ in range(300):
            at = [made.uniform(-12, 30), made.uniform(-4, 4), made.uniform(-4, 4)]
            way = [made.gauss(0, 1) for _ in range(3)]
            rays.append({"origin": [p - 40 * d for p, d in zip(at, way)], "direction": way})
        boxes = [{"center": [made.uniform(-12, 30), 0, 0], "radius": 1} for _ in range(40)]
        points = [[made.uniform(-12, 30), made.uniform(-4, 4), 0] for _ in range(40)]
        return {"rays:closest": {"rays": rays, "fields": FIELDS}, "rays:all": {"rays": rays, "fields": FIELDS},
                "rays:count": {"rays": rays}, "boxes:list": {"boxes": boxes}, "points:closest": {"points": points},
                "clearance": {"a": {"names": ["skinned"]}, "b": {"names": ["morphed", "second"]}}}

    def answers(self, server, scene):
        found = {}
        for kind, body in self.questions().items():
            answer = server.ask(f"/v1/scenes/{scene}/{kind}", "-H", JSON_TYPE, body=json.dumps(body))
            self.assertEqual(answer.status, 200, answer.body[:400])
            found[kind] = answer.body
        return found

    def same(self, server, scene, glb, changes, name="twin"):
        """The answers of the scene are those of a file in that pose; returns them."""
        put = server.put(name, in_pose(glb, changes))
        self.assertIn(put.status, (200, 201), put.body)
        found, expected = self.answers(server, scene), self.answers(server, name)
        for kind, body in expected.items():
            self.assertEqual(found[kind], body, kind)
        counts = [server.ask(f"/v1/scenes/{each}").json() for each in (scene, name)]
        for key in ("bounds", "counts"):
            for each in counts:
                each["counts"].pop("bytes_touched", None)
            self.assertEqual(counts[0][key], counts[1][key], key)
        self.assertEqual(server.ask(f"/v1/scenes/{scene}/selfcheck?rays=100").json()["different"], [])
        return found

    def check_positions(self, server, scene, glb, changes):
        """Against positions computed from the file's accessors, in float64."""
        reading = Sampled(in_pose(glb, changes))
        for instance, node in enumerate((SKINNED, MORPHED, SECOND, MOVED, STILL, APART)):
            expected = reading.positions(node)
            ids = ",".join(f"{instance}.0.{i}" for i in range(len(expected)))
            found = server.ask(f"/v1/scenes/{scene}/triangles?ids={ids}").json()["triangles"]
            self.assertEqual([each["node_id"] for each in found], [node] * len(expected))
            for got, corners in zip(found, expected, strict=True):
                for a, b in zip(got["corners"], corners, strict=True):
                    for x, y in zip(a, b, strict=True):
                        # Of a mesh's space, and the world: rounded to float32 once.
                        self.assertAlmostEqual(x, y, delta=2e-5)

    def test_a_joint_poses_its_skin(self):
        glb = made_file().bytes()
        server = self.server()
        self.assertEqual(server.put("made", glb).status, 201)
        before = self.answers(server, "made")
        change = {"translation": [-6, 1, 0], "rotation": [0.5, 0.1, 0, math.sqrt(0.74)], "scale": [1, 1.25, 1]}
        answer = patch(server, HIP, change, scene="made")
        self.assertEqual(answer.status, 200, answer.body)
        self.check_positions(server, "made", glb, {HIP: change})
        after = self.same(server, "made", glb, {HIP: change})
        self.assertNotEqual(before["rays:closest"], after["rays:closest"])
        # Only the mesh that the joint poses is another one, and needs a tree.
        stats = server.ask("/v1/scenes/made/stats").json()
        self.assertEqual(stats["counts"]["posed_meshes"], 1)
        self.assertLessEqual(stats["trees"]["trees_built"], 1)
        # And back: the bytes of the beginning.
        node = Posed(glb).root["nodes"][HIP]
        back = {key: node[key] for key in ("translation", "rotation")}
        self.assertEqual(patch(server, HIP, back, scene="made").status, 200)
        self.assertEqual(self.answers(server, "made"), before)

    def test_weights_pose_the_node_that_has_them(self):
        glb = made_file().bytes()
        server = self.server()
        server.put("made", glb)
        self.assertEqual(server.ask("/v1/scenes/made").json()["counts"]["meshes"], 4)
        steps = [{SECOND: {"weights": [0.5, -0.75]}}, {MORPHED: {"weights": [0, 1]}}, {SECOND: {"weights": [0, 1]}},
                 {MORPHED: {"weights": [0.25, 0]}, SECOND: {"weights": [0.25, 0]}}]
        changes = {}
        for step, meshes in zip(steps, (5, 5, 4, 4), strict=True):
            with self.subTest(step=step):
                answer = pose(server, "made", {"nodes": [{"node": node, **members} for node, members in step.items()]})
                self.assertEqual(answer.status, 200, answer.body)
                changes.update(step)
                self.assertEqual(answer.json()["counts"]["meshes"], meshes)
                self.check_positions(server, "made", glb, changes)
                self.same(server, "made", glb, changes)
                pose_of = server.ask("/v1/scenes/made/nodes?with=pose").json()["nodes"]
                by_id = {node["node_id"]: node for node in pose_of}
                for node, members in changes.items():
                    self.assertEqual(by_id[node]["weights"], members["weights"])
                self.assertEqual(by_id[APART]["weights"], [])
                self.assertEqual(by_id[FIXED]["matrix"], [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 9, 0, 1])

    def test_an_animation_is_sampled_at_a_time(self):
        glb = made_file().bytes()
        reading = Sampled(glb)
        server = self.server()
        server.put("made", glb)
        listed = server.ask("/v1/scenes/made/animations")
        self.assertEqual(listed.status, 200, listed.body)
        self.assertEqual(listed.json(), {"total": 4, "animations": [
            {"index": 0, "name": "walk", "duration": 4, "nodes": [HIP, KNEE, MORPHED, MOVED]},
            {"index": 1, "name": "jump", "duration": 4, "nodes": [HIP, KNEE, SECOND]},
            {"index": 2, "name": "rest", "duration": 2, "nodes": [HIP, KNEE, MORPHED, SECOND]},
            {"index": 3, "name": None, "duration": 4, "nodes": [KNEE]}]})
        changes = {}
        for number, time in [(0, 0.75), (0, 1), (0, -3), (1, 0.3), (1, 2), (2, 0.5), (3, 1.5), (0, 1e308)]:
            with self.subTest(number=number, time=time):
                name = reading.root["animations"][number].get("name")
                answer = pose(server, "made", {"animation": {**({"name": name} if name else {"index": number}), "time": time}})
                self.assertEqual(answer.status, 200, answer.body)
                for node, members in reading.sample(number, time).items():
                    # What an animation does not target of a transform is that of the file.
                    kept = {"weights": changes.get(node, {}).get("weights")} if "weights" in changes.get(node, {}) else {}
                    fresh = {key: reading.root["nodes"][node][key] for key in ("translation", "rotation", "scale") if key in reading.root["nodes"][node]}
                    changes[node] = {**kept, **fresh, **members}
                self.check_positions(server, "made", glb, changes)
                self.same(server, "made", glb, changes)

    def test_a_node_beside_an_animation_has_the_last_word(self):
        glb = made_file().bytes()
        server = self.server()
        server.put("made", glb)
        before = server.ask("/v1/scenes/made").json()["revision"]
        answer = pose(server, "made", {"animation": {"index": 0, "time": 0.75}, "nodes": [{"node": MORPHED, "weights": [1, 1]},
                                                                                          {"node": MOVED, "translation": [12, 1, 0]},
                                                                                          {"node": APART, "hidden": True}]})
        self.assertEqual(answer.status, 200, answer.body)
        self.assertEqual(answer.json()["revision"], before + 1)
        nodes = {node["node_id"]: node for node in server.ask("/v1/scenes/made/nodes?with=pose").json()["nodes"]}
        self.assertEqual(nodes[MORPHED]["weights"], [1, 1])
        self.assertEqual(nodes[MOVED]["matrix"][12:15], [12, 1, 0])
        self.assertTrue(nodes[APART]["hidden"])
        self.assertNotEqual(nodes[HIP]["matrix"][:3], file_matrix(glb, HIP)[:3])

    def test_poses_are_the_same_on_every_kernel_and_survive_a_kill(self):
        file = made_file()
        for extra in (0, MAPPED_FROM):
            glb, folder, seen = file.bytes() + bytes(extra), self.folder(), set()
            server = self.server("--data", folder)
            self.assertEqual(server.put("made", glb).status, 201)
            for body in ({"animation": {"name": "walk", "time": 0.8}}, {"nodes": [{"node": SECOND, "weights": [0.1, 0.2]}]},
                         {"animation": {"name": "jump", "time": 1.1}, "nodes": [{"node": KNEE, "scale": [2, 1, 1]}]}):
                last = pose(server, "made", body)
                self.assertEqual(last.status, 200, last.body)
            first = self.answers(server, "made")
            kernels = server.ask("/version").json()["kernels"]
            server.kill()
            for kernel in kernels:
                server = self.server("--data", folder, "--kernel", kernel)
                self.assertEqual(server.ask("/v1/scenes/made").body, last.body)
                self.assertEqual(server.ask("/v1/scenes/made").headers["etag"], last.headers["etag"])
                self.assertEqual(self.answers(server, "made"), first, kernel)
                seen.add(json.dumps(server.ask("/v1/scenes/made/animations").json()))
                self.assertEqual(server.stop(), 0)
            self.assertEqual(len(seen), 1)

    def test_the_python_client_poses(self):
        glb = made_file().bytes()
        server = self.server()
        with sightline.Sightline(server.url) as client:
            client.put("made", glb)
            self.assertEqual([(each["name"], each["duration"]) for each in client.animations("made")[:2]], [("walk", 4), ("jump", 4)])
            client.pose("made", "walk", 0.8, {SECOND: {"weights": [1, 0.5]}})
            self.same(server, "made", glb, {**Sampled(glb).sample(0, 0.8), SECOND: {"weights": [1, 0.5]}})
            client.pose("made", 1, 0.25)
            client.patch_node("made", MORPHED, weights=[0.5, 0.5])
            self.assertEqual(client.nodes("made", name="morphed", extra=["pose"])[0]["weights"], [0.5, 0.5])
            with self.assertRaisesRegex(sightline.SightlineError, "walk"):
                client.pose("made", "wlk", 0)

    def test_poses_and_queries_at_once(self):
        glb = made_file().bytes()
        server = self.server()
        server.put("made", glb)
        server.put("other", glb)
        expected = {}
        for time in (0.6, 0.9, 1.4, 3):
            pose(server, "other", {"animation": {"index": 0, "time": time}})
            expected[self.answers(server, "other")["rays:closest"]] = time
        pose(server, "made", {"animation": {"index": 0, "time": 3}})
        done, stop = [], threading.Event()

        def ask():
            while True:
                done.append(self.answers(server, "made")["rays:closest"])
                if stop.is_set():
                    return

        asking = threading.Thread(target=ask)
        asking.start()
        statuses = []

        def play():
            for _ in range(3):
                for time in (0.6, 0.9, 1.4, 3):
                    statuses.append(pose(server, "made", {"animation": {"index": 0, "time": time}}).status)
        playing = [threading.Thread(target=play) for _ in range(2)]
        for thread in playing:
            thread.start()
        for thread in playing:
            thread.join()
        stop.set()
        asking.join()
        self.assertEqual(set(statuses), {200})
        self.assertTrue(done)
        self.assertLessEqual(set(done), set(expected))

    def test_faults_name_the_place_and_change_nothing(self):
        glb = made_file().bytes()
        server = self.server()
        server.put("made", glb)
        before = server.ask("/v1/scenes/made")
        answers = self.answers(server, "made")
        huge = [3e38, 0, 0]
        for body, status, code, pointer, detail in [
                ({"animation": {"name": "wal", "time": 0}}, 422, "ANIMATION_UNKNOWN", "/animation/name", '"walk"'),
                ({"animation": {"index": 4, "time": 0}}, 422, "ANIMATION_UNKNOWN", "/animation/index", "4 animations"),
                ({"animation": {"index": -1, "time": 0}}, 422, "NUMBER_OUT_OF_RANGE", "/animation/index", None),
                ({"animation": {"name": "walk"}}, 422, "KEY_MISSING", "/animation", "time"),
                ({"animation": {"time": 1}}, 422, "KEY_MISSING", "/animation", "name"),
                ({"animation": {"name": "walk", "index": 0, "time": 1}}, 422, "KEYS_MIXED", "/animation/index", None),
                ({"animation": {"name": "walk", "time": "1"}}, 422, "TYPE_WRONG", "/animation/time", None),
                ({"animation": {"name": 1, "time": 1}}, 422, "TYPE_WRONG", "/animation/name", None),
                ({"animation": {"name": "walk", "time": 1, "loop": True}}, 422, "KEY_UNKNOWN", "/animation/loop", None),
                ({"animation": []}, 422, "TYPE_WRONG", "/animation", None),
                ({"animation": {"index": 0, "time": 1}, "nodes": [{"node": 77, "hidden": True}]}, 404, "NODE_NOT_FOUND", "/nodes/0", None),
                ({"animation": {"index": 0, "time": 1}, "nodes": []}, 422, "KEY_MISSING", "/nodes", None),
                ({"nodes": [{"node": HIP, "scale": [2, 2, 2]}, {"node": APART, "weights": [1]}]}, 422, "NODE_WEIGHTS_WRONG", "/nodes/1/weights",
                 "has no morph targets"),
                ({"nodes": [{"node": SECOND, "weights": [1, 2, 3]}]}, 422, "NODE_WEIGHTS_WRONG", "/nodes/0/weights", "2 morph targets"),
                ({"nodes": [{"node": SECOND, "weights": [1, 1e39]}]}, 422, "NUMBER_OUT_OF_RANGE", "/nodes/0/weights/1", None),
                ({"nodes": [{"node": SECOND, "weights": []}]}, 422, "LENGTH_WRONG", "/nodes/0/weights", None),
                ({"nodes": [{"node": SECOND, "weights": [1, None]}]}, 422, "TYPE_WRONG", "/nodes/0/weights/1", None),
                ({"nodes": [{"node": HIP, "scale": huge, "translation": huge}]}, 422, "TRANSFORM_INVALID", None, None),
                ({}, 422, "KEY_MISSING", None, None)]:
            with self.subTest(body=body):
                problem = pose(server, "made", body)
                self.assertEqual((problem.status, problem.json()["code"]), (status, code), problem.body)
                if pointer:
                    self.assertEqual(problem.json()["errors"][0]["pointer"], pointer)
                if detail:
                    self.assertIn(detail, problem.json()["detail"])
        for text in ("NaN", "Infinity", "1e999", "-1e999"):
            answer = server.ask("/v1/scenes/made/nodes", "-X", "PATCH", "-H", JSON_TYPE, body='{"animation":{"index":0,"time":%s}}' % text)
            self.assertIn(answer.status, (400, 422), answer.body)
        one = patch(server, APART, {"weights": [1]}, scene="made")
        self.assertEqual((one.status, one.json()["errors"][0]["pointer"]), (422, "/weights"))
        self.assertEqual(server.ask("/v1/scenes/made").body, before.body)
        self.assertEqual(self.answers(server, "made"), answers)
        server.put("plain", one_triangle())
        none = pose(server, "plain", {"animation": {"index": 0, "time": 0}})
        self.assertEqual((none.status, none.json()["code"]), (422, "ANIMATION_UNKNOWN"))
        self.assertEqual(server.ask("/v1/scenes/plain/animations").json(), {"total": 0, "animations": []})
        self.assertEqual(server.ask("/v1/scenes/none/animations").status, 404)

    def test_a_wrong_animation_is_a_warning_and_an_error_of_its_use(self):
        def spoil(change):
            return with_document(made_file().bytes(), change)

        def accessor(document, part, number=0):
            return document["accessors"][document["animations"][0]["samplers"][number][part]]
        spoils = {
            "count": lambda d: accessor(d, "output").update(count=3),
            "type": lambda d: accessor(d, "output").update(type="VEC3"),
            "component": lambda d: accessor(d, "input").update(componentType=5125),
            "beyond": lambda d: accessor(d, "output").update(count=1 << 40),
            "view": lambda d: accessor(d, "output").update(byteOffset=1 << 30),
            "reference": lambda d: d["animations"][0]["samplers"][0].update(output=999),
            "node": lambda d: d["animations"][0]["channels"][0]["target"].update(node=999),
            "path": lambda d: d["animations"][0]["channels"][0]["target"].update(path="colour"),
            "sampler": lambda d: d["animations"][0]["channels"][0].update(sampler=99),
            "kind": lambda d: d["animations"][0]["samplers"][0].update(interpolation="ROUND"),
            "matrix": lambda d: d["animations"][0]["channels"][0]["target"].update(node=FIXED),
            "weights": lambda d: d["animations"][0]["channels"][3]["target"].update(node=APART),
            "twice": lambda d: d["animations"][0]["channels"].append(d["animations"][0]["channels"][0]),
            "empty": lambda d: d["animations"][0].update(channels=[]),
            "no object": lambda d: d["animations"].__setitem__(0, 7),
            "no list": lambda d: d["animations"][0].update(samplers="none"),
        }
        server = self.server()
        for name, change in spoils.items():
            with self.subTest(name=name):
                answer = server.put("wrong", spoil(change))
                self.assertIn(answer.status, (200, 201), answer.body)
                self.assertTrue(any("animation 0" in warning for warning in answer.json()["warnings"]), answer.json()["warnings"])
                before = server.ask("/v1/scenes/wrong").body
                listed = server.ask("/v1/scenes/wrong/animations").json()["animations"][0]
                self.assertIsNone(listed["duration"])
                self.assertTrue(listed["problem"])
                problem = pose(server, "wrong", {"animation": {"index": 0, "time": 1}})
                self.assertEqual((problem.status, problem.json()["code"]), (422, "ANIMATION_INVALID"), problem.body)
                self.assertEqual(server.ask("/v1/scenes/wrong").body, before)
                self.assertEqual(pose(server, "wrong", {"animation": {"index": 2, "time": 1}}).status, 200)

    def test_times_and_values_of_a_hostile_file(self):
        nan, inf = struct.pack("<f", math.nan), struct.pack("<f", math.inf)
        file = made_file()
        for part, at, number in (("input", 4, nan), ("input", 12, inf), ("input", 4, struct.pack("<f", 0.5)), ("output", 0, nan),
                                 ("output", 16, inf)):
            with self.subTest(part=part, at=at):
                view = file.root["bufferViews"][file.root["accessors"][file.root["animations"][0]["samplers"][0][part]]["bufferView"]]
                begin = view["byteOffset"] + at
                good, file.binary = file.binary, file.binary[:begin] + number + file.binary[begin + 4:]
                server = self.server()
                self.assertEqual(server.put("hostile", file.bytes()).status, 201)
                file.binary = good
                before = server.ask("/v1/scenes/hostile").body
                problem = pose(server, "hostile", {"animation": {"index": 0, "time": 0.75}})
                self.assertEqual((problem.status, problem.json()["code"]), (422, "ANIMATION_INVALID"), problem.body)
                self.assertEqual(server.ask("/v1/scenes/hostile").body, before)
                server.stop()

    def test_buffers_beside_the_file_and_inside_of_its_text(self):
        glb = made_file().bytes()
        reading = Sampled(glb)
        root = Path(self.folder().parent)
        body = {"animation": {"name": "walk", "time": 0.8}, "nodes": [{"node": SECOND, "weights": [1, 0.5]}]}
        inside = "data:application/octet-stream;base64," + base64.b64encode(reading.binary).decode()
        for uri in (inside, "made.bin"):
            for keeps in (True, False):
                with self.subTest(uri=uri[:10], keeps=keeps):
                    document = {**reading.root, "buffers": [{"byteLength": len(reading.binary), "uri": uri}]}
                    (root / "made.gltf").write_text(json.dumps(document))
                    (root / "made.bin").write_bytes(reading.binary)
                    folder = self.folder()
                    arguments = ("--scene-root", root, *(("--data", folder) if keeps else ()))
                    server = self.server(*arguments)
                    put = server.ask("/v1/scenes?wait=60", "-H", JSON_TYPE, body=json.dumps({"id": "made", "source": {"path": "made.gltf"}}))
                    self.assertEqual(put.status, 201, put.body)
                    (root / "made.bin").unlink()  # what poses need stays
                    last = pose(server, "made", body)
                    self.assertEqual(last.status, 200, last.body)
                    changes = {**reading.sample(0, 0.8), SECOND: {"weights": [1, 0.5]}}
                    found = self.same(server, "made", glb, changes)
                    server.kill()
                    if not keeps:
                        continue
                    server = self.server(*arguments)
                    self.assertEqual(server.ask("/v1/scenes/made").body, last.body)
                    self.assertEqual(self.answers(server, "made"), found)
                    self.assertEqual(server.ask("/v1/scenes/made/animations").json()["animations"][0]["duration"], 4)
                    server.kill()

    def test_animations_of_the_knight(self):
        glb = shared_scene(self, "knight_skinned.glb")
        reading = Sampled(glb)
        server = self.server(memory=None)
        self.assertEqual(server.put("knight", glb).status, 201)
        listed = server.ask("/v1/scenes/knight/animations").json()["animations"]
        self.assertEqual([each["name"] for each in listed], [each["name"] for each in reading.root["animations"]])
        for number in (3, 40):
            time = listed[number]["duration"] * 0.3
            answer = pose(server, "knight", {"animation": {"name": listed[number]["name"], "time": time}})
            self.assertEqual(answer.status, 200, answer.body)
            nodes = {node["node_id"]: node for node in server.ask("/v1/scenes/knight/nodes?with=pose").json()["nodes"]}
            posed = with_document(glb, lambda d, nodes=nodes: [(each.update(matrix=nodes[i]["matrix"]),
                                                               [each.pop(key, None) for key in ("translation", "rotation", "scale")])
                                                              for i, each in enumerate(d["nodes"]) if i in nodes])
            server.put("twin", posed)
            for each in ("bounds", "counts"):
                values = [server.ask(f"/v1/scenes/{name}").json()[each] for name in ("knight", "twin")]
                for value in values:
                    value.pop("bytes_touched", None)
                self.assertEqual(*values)
            self.assertEqual(*(self.rays_at(server, name) for name in ("knight", "twin")))
            # The matrices against an own sampling.
            for node, members in reading.sample(number, time).items():
                whole = {key: reading.root["nodes"][node][key] for key in ("translation", "rotation", "scale") if key in reading.root["nodes"][node]}
                expected = local({**whole, **members})
                for i in range(12):
                    self.assertAlmostEqual(nodes[node]["matrix"][i // 3 * 4 + i % 3], expected[i % 3][i // 3], delta=1e-9)

    def rays_at(self, server, name):
        bounds = server.ask(f"/v1/scenes/{name}").json()["bounds"]
        made, rays = random.Random(8), []
        for _ in range(300):
            at = [made.uniform(a, b) for a, b in zip(bounds["min"], bounds["max"])]
            way = [made.gauss(0, 1) for _ in range(3)]
            rays.append({"origin": [p - 100 * d for p, d in zip(at, way)], "direction": way})
        return server.query(name, "closest", {"rays": rays, "fields": FIELDS}).body

    def test_the_knight_of_the_shared_data(self):
        glb = shared_scene(self, "knight_skinned.glb")
        reading = Posed(glb)
        joint = reading.root["skins"][0]["joints"][1]
        folder = self.folder()
        server = self.server("--data", folder, memory=None)
        self.assertEqual(server.put("knight", glb).status, 201)
        change = {"rotation": [0.6, 0, 0, 0.8], "translation": reading.root["nodes"][joint].get("translation", [0, 0, 0])}
        self.assertEqual(patch(server, joint, change, scene="knight").status, 200)
        document = with_document(glb, lambda d: (d["nodes"][joint].pop("matrix", None), d["nodes"][joint].pop("scale", None),
                                                 d["nodes"][joint].update(change)))
        server.put("twin", document)
        bounds = server.ask("/v1/scenes/twin").json()["bounds"]
        self.assertEqual(server.ask("/v1/scenes/knight").json()["bounds"], bounds)
        self.assertEqual(*(self.rays_at(server, name) for name in ("knight", "twin")))


def file_matrix(glb, node):
    """Of a root, column by column."""
    world = Posed(glb).world[node]
    return [world[i % 4][i // 4] if i % 4 < 3 else float(i == 15) for i in range(16)]


def one_triangle():
    file = File()
    position = file.add([[0, 0, 0], [4, 0, 0], [0, 4, 0]], "VEC3", 5126, min=[0, 0, 0], max=[4, 4, 0])
    file.root["meshes"].append({"primitives": [{"attributes": {"POSITION": position}}]})
    file.node(0)
    return file.bytes()


if __name__ == "__main__":
    case_report.main()
