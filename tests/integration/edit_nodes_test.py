"""Nodes that clients add and remove: the answers are those of a file that says so, at once, after a restart and a kill."""

import http.client
import json
import os
import random
import struct
import tempfile
import unittest
from pathlib import Path

import case_report
from made_scene import glb
from poses_test import APART, FIXED, HIP, MORPHED, MOVED, SECOND, SKINNED, STILL, made_file
from sightline_server import GLB_TYPE, JSON_TYPE, Server, demo_glb

SCRIPTS = int(os.environ.get("SIGHTLINE_EDIT_SCRIPTS", "10"))  # of 20 edits each
FIELDS = ["t", "node_id", "node", "node_instance", "primitive", "triangle", "position", "normal", "shading_normal", "uv", "material"]
IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
TETRAHEDRON = ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2])
SQUARE = ([(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1)], [0, 2, 1, 0, 3, 2])
ROOF = ([(-1, 1, 0), (1, 1, 0), (0, 2, 0.5)], [0, 1, 2])
MESHES = [[SQUARE, ROOF], [TETRAHEDRON]]
PLACES = [(0.0, 0.0, 0.0), (2.5, 0.25, 0.0), (-2.5, 0.0, 1.25)]  # of the node "row"


def product(parent, child):
    """Of 16 numbers each, column by column, rounded as the server rounds."""
    out = list(IDENTITY)
    for row in range(3):
        for column in range(4):
            a, b = [parent[4 * k + row] for k in range(4)], child[4 * column:4 * column + 3]
            total = (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
            out[4 * column + row] = total + a[3] if column == 3 else total
    return out


class Node:
    def __init__(self, name, parent=None, mesh=None, matrix=None, is_row=False):
        self.name, self.parent, self.mesh, self.matrix, self.is_row = name, parent, mesh, matrix or IDENTITY, is_row
        self.hidden = self.removed = False
        self.positions = None  # of its mesh, one primitive after the other, where they are not those of the file

    def gltf(self, matrix):
        made = {"name": self.name, "matrix": matrix}
        if self.mesh is not None:
            made["mesh"] = self.mesh
        if self.is_row:
            made["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}
        return made


class Model:
    """What a scene should be: nodes by their numbers, those of the file first. Node 6 is in no scene of the file."""

    FILE = 7

    def __init__(self, made):
        self.nodes = {0: Node("root", matrix=some_matrix(made)), 1: Node("left", 0, 0, some_matrix(made)), 2: Node("right", 0, 1, some_matrix(made)),
                      3: Node("pair", None, None, some_matrix(made)), 4: Node("deep", 3, 0, some_matrix(made)),
                      5: Node("row", None, 1, some_matrix(made), True)}

    def live(self):
        return [number for number, node in self.nodes.items() if not node.removed]

    def above(self, number):
        """The node and those above it."""
        while number is not None:
            yield self.nodes[number]
            number = self.nodes[number].parent

    def world(self, number):
        node = self.nodes[number]
        return node.matrix if node.parent is None else product(self.world(node.parent), node.matrix)

    def file(self):
        """The file before it is changed."""
        nodes = [self.nodes[i].gltf(self.nodes[i].matrix) for i in range(6)] + [{"name": "elsewhere", "mesh": 0}]
        for i in range(6):
            if self.nodes[i].parent is not None:
                nodes[self.nodes[i].parent].setdefault("children", []).append(i)
        return self.glb(nodes, [i for i in range(6) if self.nodes[i].parent is None])

    def flat(self):
        """A file of what is there, without a hierarchy, in which nodes and instances stand in the same order."""
        nodes = [{"name": "elsewhere"} for _ in range(max(self.FILE, max(self.nodes) + 1))]
        for number in self.live():
            nodes[number] = self.nodes[number].gltf(self.world(number))
        return self.glb(nodes, self.live())

    def hidden(self):
        return [number for number in self.live() if any(node.hidden for node in self.above(number))]

    def glb(self, nodes, roots):
        """A file of these nodes; accessor 0 has the places of a row. Nodes with positions of their own have a mesh of their own."""
        nodes = [dict(node) for node in nodes]
        data, views, accessors = bytearray(), [], []

        def add(packed, kind, component, count, **more):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
            accessors.append({"bufferView": len(views) - 1, "componentType": component, "type": kind, "count": count, **more})
            data.extend(packed)
            return len(accessors) - 1

        def vectors(rows):
            return struct.pack(f"<{3 * len(rows)}f", *(x for row in rows for x in row))

        add(vectors(PLACES), "VEC3", 5126, len(PLACES))
        own = [node for number, node in self.nodes.items() if node.positions and not node.removed]
        for number, node in self.nodes.items():
            if node in own:
                nodes[number]["mesh"] = len(MESHES) + own.index(node)
        meshes = []
        for number, parts in enumerate([*MESHES, *(moved_parts(node.mesh, node.positions) for node in own)]):
            primitives = []
            for positions, indices in parts:
                bounds = {"min": [min(row[k] for row in positions) for k in range(3)], "max": [max(row[k] for row in positions) for k in range(3)]}
                normals = [(0, 1, 0) if k % 2 else (0.6, 0.8, 0) for k in range(len(positions))]
                uv = struct.pack(f"<{2 * len(positions)}f", *(x / 8 for x in range(2 * len(positions))))
                primitives.append({"attributes": {"POSITION": add(vectors(positions), "VEC3", 5126, len(positions), **bounds),
                                                  "NORMAL": add(vectors(normals), "VEC3", 5126, len(positions)),
                                                  "TEXCOORD_0": add(uv, "VEC2", 5126, len(positions))},
                                   "indices": add(struct.pack(f"<{len(indices)}I", *indices), "SCALAR", 5125, len(indices)),
                                   "material": len(primitives)})
            meshes.append({"name": f"mesh {number}", "primitives": primitives})
        document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}], "nodes": nodes, "meshes": meshes,
                    "materials": [{"name": "wall"}, {"name": "roof"}], "buffers": [{"byteLength": len(data)}],
                    "bufferViews": views, "accessors": accessors, "extensionsUsed": ["EXT_mesh_gpu_instancing"]}
        if not roots:
            del document["scenes"][0]["nodes"]
        return glb(document, bytes(data))


def moved_parts(mesh, positions):
    parts = []
    for old, indices in MESHES[mesh]:
        parts.append((positions[:len(old)], indices))
        positions = positions[len(old):]
    return parts


def some_positions(made, model, node):
    """Vertices as float32: at random, on a grid, those of the file, those of another node, or some that coincide."""
    file = [row for positions, _ in MESHES[node.mesh] for row in positions]
    others = [other.positions for other in model.nodes.values() if other.positions and other.mesh == node.mesh]
    kind = made.randrange(5)
    if kind == 0:
        return file
    if kind == 1 and others:
        return made.choice(others)
    if kind == 2:
        return [tuple(float(made.randrange(-2, 3)) / 2 for _ in row) for row in file]
    if kind == 3:
        return [file[0]] * 2 + file[2:]
    return [struct.unpack("<3f", struct.pack("<3f", *(made.uniform(-1.5, 1.5) for _ in row))) for row in file]


def some_matrix(made):
    if made.random() < 0.3:  # planes of triangles that meet others exactly
        return [*IDENTITY[:12], float(made.randrange(-3, 4)), float(made.randrange(-2, 3)), float(made.randrange(-3, 4)), 1]
    matrix = [made.uniform(-1.5, 1.5) for _ in range(16)]
    matrix[3] = matrix[7] = matrix[11] = 0
    matrix[12:] = [made.uniform(-4, 4), made.uniform(-2, 2), made.uniform(-4, 4), 1]
    return matrix


def some_changes(made, model, fresh):
    """Changes of a PATCH, as the model has them afterwards. `fresh`: numbers that no node has."""
    changes, changed = [], set()
    for _ in range(made.randrange(1, 4)):
        live = [number for number in model.live() if number not in changed]
        kind = made.choice(("add", "add", "move", "hide", "remove", "shape", "shape"))
        if kind == "add":
            sources = [number for number in model.live() if model.nodes[number].mesh is not None]
            if not sources:
                continue
            source = model.nodes[made.choice(sources)]
            number, parent, matrix = next(fresh), made.choice([None, *model.live()]), made.choice((None, some_matrix(made)))
            change = {"node": number, "copy_of": next(k for k, node in model.nodes.items() if node is source), "name": f"new {number}"}
            if parent is not None or made.random() < 0.5:
                change["parent"] = parent
            if matrix:
                change["matrix"] = matrix
            added = model.nodes[number] = Node(change["name"], parent, source.mesh, matrix, source.is_row)
            added.positions = source.positions
            if made.random() < 0.2:
                change["positions"] = added.positions = some_positions(made, model, added)
            changed.add(number)
            changes.append(change)
            continue
        if not live or (kind == "remove" and len(live) < 3):
            continue
        number = made.choice(live)
        node = model.nodes[number]
        change = {"node": number}
        if kind == "move":
            change["matrix"] = node.matrix = some_matrix(made)
        elif kind == "shape":
            if node.mesh is None:
                continue
            change["positions"] = node.positions = some_positions(made, model, node)
        elif kind == "hide":
            change["hidden"] = node.hidden = not node.hidden
        else:
            change["removed"] = True
        changed.add(number)
        changes.append(change)
    # Removals come last.
    for change in changes:
        if change.get("removed"):
            model.nodes[change["node"]].removed = True
    for number, node in model.nodes.items():
        node.removed = any(each.removed for each in model.above(number))
    return changes


class Asking:
    """Questions over one connection."""

    def __init__(self, server):
        self.connection = http.client.HTTPConnection("127.0.0.1", server.port)

    def ask(self, method, path, body=None, kind=JSON_TYPE, **headers):
        if isinstance(body, dict):
            body = json.dumps(body)
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        self.connection.request(method, f"/v1/scenes/{path}", body, {"Content-Type": kind.split(": ")[1], **headers})
        answer = self.connection.getresponse()
        return answer.status, answer.read(), answer.headers

    def answers(self, scene, questions):
        found = {}
        for kind, body in questions:
            status, text, _ = self.ask("POST", f"{scene}/{kind}", body)
            found[kind, json.dumps(body)[:60]] = (status, text)
        return found

    def nodes(self, scene):
        return json.loads(self.ask("GET", f"{scene}/nodes?limit=100000&with=path,materials")[1])

    def put(self, scene, body):
        status, text, _ = self.ask("PUT", scene, body, GLB_TYPE)
        assert status in (200, 201), text


def some_questions(made, count=24):
    def place(size):
        return [made.uniform(-size, size) for _ in range(3)]

    def near(size):  # what meets exactly
        return [float(made.randrange(-size, size + 1)) / 2 for _ in range(3)]

    rays = [{"origin": near(12), "direction": [0, -1, 0]} if k % 3 == 0 else {"origin": place(9), "direction": place(1)} for k in range(count)]
    boxes = [{"center": place(5), "radius": made.uniform(0.1, 3)} for _ in range(count)]
    return [("rays:closest", {"rays": rays, "fields": FIELDS}), ("rays:all", {"rays": rays, "fields": FIELDS}), ("rays:any", {"rays": rays}),
            ("rays:count", {"rays": rays}), ("rays:closest", {"rays": rays, "fields": FIELDS, "exclude": {"materials": ["roof"]}}),
            ("boxes:list", {"boxes": boxes, "of": "nodes"}), ("boxes:count", {"boxes": boxes}),
            ("points:closest", {"points": [place(6) for _ in range(count)], "fields": ["distance", "node_id", "primitive", "triangle", "position"]})]


class EditNodes(unittest.TestCase):
    maxDiff = 2000

    def server(self, *arguments):
        server = Server(*arguments)
        self.addCleanup(server.end)
        return server

    def folder(self):
        """A folder that stays until the servers of the test have ended."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        return Path(folder.name)

    def expect_listed(self, asking, scene, model):
        """Listings and counts have what the model has, and nothing else."""
        page = asking.nodes(scene)
        live = model.live()
        self.assertEqual((page["total"], [node["node_id"] for node in page["nodes"]]), (len(live), live))
        for node in page["nodes"]:
            number, expected = node["node_id"], model.nodes[node["node_id"]]
            children = sum(1 for each in live if model.nodes[each].parent == number)
            self.assertEqual((node["name"], node["parent"], node["children"]), (expected.name, expected.parent, children))
        counts = json.loads(asking.ask("GET", scene)[1])["counts"]
        instances = sum(0 if model.nodes[k].mesh is None else len(PLACES) if model.nodes[k].is_row else 1 for k in live)
        meshes = set()
        for node in (model.nodes[k] for k in live if model.nodes[k].mesh is not None):
            file = [row for positions, _ in MESHES[node.mesh] for row in positions]
            meshes.add((node.mesh, struct.pack(f"<{3 * len(file)}f", *(x for row in node.positions or file for x in row))))
        self.assertEqual((counts["nodes"], counts["instances"], counts["meshes"]), (len(live), instances, len(meshes)))
        return page, counts

    def expect_equal(self, asking, scene, model, made):
        """The answers are the bytes of a file of what the model shows."""
        asking.put("flat", model.flat())
        if hidden := model.hidden():
            self.assertEqual(asking.ask("PATCH", "flat/nodes", {"nodes": [{"node": number, "hidden": True} for number in hidden]})[0], 200)
        questions = some_questions(made)
        self.assertEqual(asking.answers(scene, questions), asking.answers("flat", questions))
        page, counts = self.expect_listed(asking, scene, model)
        shown = {node["node_id"]: node for node in asking.nodes("flat")["nodes"]}
        for node in page["nodes"]:
            for key in ("instances", "triangles", "bounds", "materials", "name"):
                self.assertEqual(node[key], shown[node["node_id"]][key], (node["node_id"], key))
        flat = json.loads(asking.ask("GET", "flat")[1])
        self.assertEqual(json.loads(asking.ask("GET", scene)[1])["bounds"], flat["bounds"])
        for key in ("nodes", "instances", "triangles"):
            self.assertEqual(counts[key], flat["counts"][key], key)

    def test_random_edits_answer_as_a_file_of_the_result(self):
        server = self.server()
        asking = Asking(server)
        for script in range(SCRIPTS):
            made = random.Random(script)
            model, fresh = Model(made), iter(range(Model.FILE, 1000))
            asking.put("edited", model.file())
            for _ in range(20):
                changes = some_changes(made, model, fresh)
                if not changes:
                    continue
                status, text, _ = asking.ask("PATCH", "edited/nodes", {"nodes": changes})
                self.assertEqual(status, 200, (script, changes, text))
                with self.subTest(script=script, changes=changes):
                    self.expect_equal(asking, "edited", model, made)
        self.assertEqual(json.loads(asking.ask("GET", "edited/selfcheck?rays=200")[1])["different"], [])

    def test_a_restart_and_a_kill_change_no_byte(self):
        folder = self.folder()
        data, made = Path(folder, "data"), random.Random(77)
        server = self.server("--data", data)
        model, fresh = Model(made), iter(range(Model.FILE, 1000))
        Asking(server).put("edited", model.file())
        gets = ["edited", "edited/nodes?with=path,materials,pose", "edited/geometry"]
        for step in range(6):
            asking = Asking(server)
            for _ in range(4):
                changes = some_changes(made, model, fresh)
                if changes:
                    status, text, _ = asking.ask("PATCH", "edited/nodes", {"nodes": changes})
                    self.assertEqual(status, 200, text)
            questions = [*some_questions(made), ("rays:all", {"rays": [{"origin": [0, 9, 0], "direction": [0.01, -1, 0.02]}]})]
            before = asking.answers("edited", questions), [asking.ask("GET", path)[:2] for path in gets]
            etag = asking.ask("GET", "edited")[2]["ETag"]
            if step % 2:
                server.kill()
            else:
                self.assertEqual(server.stop(), 0)
            server = self.server("--data", data)
            asking = Asking(server)
            self.assertEqual(asking.ask("GET", "edited")[2]["ETag"], etag)
            self.assertEqual(asking.answers("edited", questions), before[0])
            self.assertEqual([asking.ask("GET", path)[:2] for path in gets], before[1])
            self.expect_equal(asking, "edited", model, made)
        self.assertEqual(server.stop(), 0)

    def test_a_node_is_added_below_another_and_shows_the_mesh_of_a_third(self):
        server = self.server("--skip", "none", "--preload", "six=demo:six")
        asking = Asking(server)
        before = json.loads(asking.ask("GET", "six")[1])
        listed = asking.nodes("six")["nodes"]
        added = {"copy_of": 2, "parent": 0, "name": "again", "translation": [0, 30, 0]}
        status, text, headers = asking.ask("PATCH", "six/nodes/100", added)
        self.assertEqual((status, json.loads(text)["revision"]), (200, before["revision"] + 1))
        self.assertNotEqual(headers["ETag"], f'"{before["sha256"]}"')
        nodes = asking.nodes("six")["nodes"]
        self.assertEqual([node["node_id"] for node in nodes], [0, 1, 2, 100])
        self.assertEqual((nodes[3]["path"], nodes[3]["parent"], nodes[3]["instances"], nodes[3]["first_instance"]), ("/root/again", 0, 1, 2))
        self.assertEqual(nodes[0]["children"], listed[0]["children"] + 1)
        self.assertEqual(nodes[3]["bounds"]["min"][1], listed[2]["bounds"]["min"][1] + 30)
        hit = server.closest("six", ([3, 60, 0], [0, -1, 0]), fields=["t", "node", "node_id", "instance", "node_path"])[0]
        self.assertEqual((hit["node"], hit["node_id"], hit["instance"], hit["node_path"]), ("again", 100, 2, "/root/again"))
        trees = json.loads(asking.ask("GET", "six/stats")[1])["trees"]
        self.assertEqual((trees["full_builds"], trees["trees_built"]), (0, 1), "the tree of the one mesh that it shows")
        # A change of it is as of any node; it moves and goes with what it is below.
        self.assertEqual(asking.ask("PATCH", "six/nodes/0", {"translation": [0, 5, 0]})[0], 200)
        self.assertEqual(server.closest("six", ([3, 60, 0], [0, -1, 0]))[0]["t"], hit["t"] - 5)
        for key, of in (("include", {"nodes": [100]}), ("include", {"names": ["again"]})):
            status, text, _ = asking.ask("POST", "six/rays:closest", {"rays": [{"origin": [3, 0, 0], "direction": [0, 1, 0]}], key: of})
            self.assertEqual((status, json.loads(text)["hits"][0]["node"]), (200, "again"))
        self.assertEqual(asking.ask("DELETE", "six/nodes/0")[0], 200)
        self.assertEqual(asking.nodes("six")["nodes"], [])
        self.assertEqual(server.closest("six", ([3, 60, 0], [0, -1, 0])), [None])

    def test_what_is_removed_is_nowhere(self):
        server = self.server("--preload", "town=demo:town")
        asking = Asking(server)
        nodes = asking.nodes("town")["nodes"]
        gone = next(node for node in nodes if node["instances"] and node["name"])
        name, number, first = gone["name"], gone["node_id"], gone["first_instance"]
        same = sum(1 for node in nodes if node["name"] == name)
        below = {number}
        for node in nodes:
            if node["parent"] in below:
                below.add(node["node_id"])
        before = json.loads(asking.ask("GET", "town")[1])
        status, text, headers = asking.ask("DELETE", f"town/nodes/{number}", If_Match=f'"{before["revision"]}"')
        self.assertEqual((status, json.loads(text)["code"]), (412, "PRECONDITION_FAILED"))
        status, text, headers = asking.ask("DELETE", f"town/nodes/{number}", If_Match="*")
        after = json.loads(text)
        self.assertEqual((status, headers["X-Scene-Revision"]), (200, str(after["revision"])))
        for key in ("nodes", "instances", "triangles"):
            lost = {"nodes": len(below), "instances": sum(node["instances"] for node in nodes if node["node_id"] in below),
                    "triangles": sum(node["triangles"] for node in nodes if node["node_id"] in below)}
            self.assertEqual(after["counts"][key], before["counts"][key] - lost[key], key)
        self.assertEqual(len(asking.nodes("town")["nodes"]), len(nodes) - len(below))
        for search, total in ((f"name={name.replace(' ', '%20')}", same - 1), (f"instance={first}", 0)):
            self.assertEqual(json.loads(asking.ask("GET", f"town/nodes?{search}")[1])["total"], total, search)
        ray = {"origin": [0, 99, 0], "direction": [0, -1, 0]}
        for body, code in (({"rays": [ray], "include": {"nodes": [number]}}, "FILTER_NODE_UNKNOWN"),
                           ({"rays": [ray], "include": {"triangles": [[first, 0, 0]]}}, "TRIANGLE_UNKNOWN")):
            status, text, _ = asking.ask("POST", "town/rays:closest", body)
            self.assertEqual((status, json.loads(text)["code"]), (422, code))
        for method, body in (("DELETE", None), ("PATCH", {"hidden": False})):
            status, text, _ = asking.ask(method, f"town/nodes/{number}", body)
            self.assertEqual((status, json.loads(text)["code"]), (404, "NODE_NOT_FOUND"))
        self.assertEqual(asking.ask("GET", f"town/triangles?ids={first}.0.0")[0], 422)

    def test_open_meshes_that_are_removed_do_not_count(self):
        server = self.server()
        asking = Asking(server)
        model = Model(random.Random(8))
        asking.put("edited", model.file())
        question = {"points": [[x / 2, y / 2 + 0.1, z / 2] for x in range(-8, 9) for y in range(-4, 5) for z in range(-8, 9)]}
        status, text, _ = asking.ask("POST", "edited/points:inside", question)
        self.assertEqual((status, json.loads(text)["unreliable"]["reason"]), (200, "OPEN_EDGES"))
        self.assertEqual(asking.ask("PATCH", "edited/nodes", {"nodes": [{"node": 1, "removed": True}, {"node": 3, "removed": True},
                                                                        {"node": 9, "copy_of": 2, "scale": [3, 3, 3]}]})[0], 200)
        model.nodes[9] = Node("", None, 1, [3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1])
        for number in (1, 3, 4):
            model.nodes[number].removed = True
        asking.put("flat", model.flat())
        answers = [asking.ask("POST", f"{scene}/points:inside", question)[:2] for scene in ("edited", "flat")]
        self.assertEqual(answers[0], answers[1])
        self.assertEqual(answers[0][0], 200)
        found = json.loads(answers[0][1])
        self.assertNotIn("unreliable", found)
        self.assertIn(True, found["inside"])

    def test_another_server_of_the_origin_answers_the_same(self):
        folder = self.folder()
        def server(name):
            return Asking(self.server("--data", Path(folder, name), "--origin", Path(folder, "origin"), "--origin-seconds", 3600))

        made = random.Random(5)
        model, fresh = Model(made), iter(range(Model.FILE, 1000))
        servers = [server("a"), server("b")]
        servers[0].put("edited", model.file())
        for step in range(8):
            changes = some_changes(made, model, fresh)
            if not changes:
                continue
            one, other = servers[step % 2], servers[1 - step % 2]
            # It changes the content of the other server.
            status, text, headers = one.ask("PATCH", "edited/nodes", {"nodes": changes})
            self.assertEqual(status, 200, text)
            least = {"X_Scene_Min_Revision": headers["X-Scene-Revision"]}
            seen = other.ask("GET", "edited?wait=60", **least)
            self.assertEqual((seen[0], seen[1], seen[2]["ETag"]), (200, text, headers["ETag"]))
            for kind, body in some_questions(made):
                self.assertEqual(other.ask("POST", f"edited/{kind}", body)[:2], one.ask("POST", f"edited/{kind}", body)[:2])
            self.expect_equal(other, "edited", model, made)

    def test_nodes_with_equal_meshes_share_a_tree_whichever_of_them_changes(self):
        corners = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 0, 1)
        count = 4
        file = glb({"asset": {"version": "2.0"}, "scenes": [{"nodes": list(range(count))}], "buffers": [{"byteLength": count * len(corners)}],
                    "nodes": [{"mesh": k, "translation": [0, k, 0]} for k in range(count)],
                    "meshes": [{"name": f"mesh {k}", "primitives": [{"attributes": {"POSITION": k}}]} for k in range(count)],
                    "bufferViews": [{"buffer": 0, "byteOffset": k * len(corners), "byteLength": len(corners)} for k in range(count)],
                    "accessors": [{"bufferView": k, "componentType": 5126, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 0, 1]}
                                  for k in range(count)]}, corners * count)
        rays = {"rays": [{"origin": [0.2, 9, 0.2], "direction": [0, -1, 0]}], "fields": ["t", "node_id", "mesh"]}
        gets = ["equal", "equal/nodes?with=path,materials,pose", "equal/geometry"]
        for path, change, ts, left in (("DELETE", None, [6, 7, 8], 3), ("PATCH", {"positions": [[0, 5, 0], [1, 5, 0], [0, 5, 1]]}, [4, 6, 7, 8], 4)):
            data = self.folder()
            server = self.server("--data", data)
            asking = Asking(server)
            asking.put("equal", file)
            self.assertEqual(asking.ask("POST", "equal/rays:all", rays)[0], 200)
            # The first mesh is the one whose content the shared tree reads.
            status, text, _ = asking.ask(path, "equal/nodes/0", *([] if change is None else [change]))
            self.assertEqual((status, json.loads(text)["counts"]["meshes"]), (200, left), text)
            answer = asking.ask("POST", "equal/rays:all", rays)[1]
            self.assertEqual([hit["t"] for hit in json.loads(answer)["results"][0]["hits"]], ts)
            self.assertEqual([hit["mesh"] for hit in json.loads(answer)["results"][0]["hits"]][-3:], ["mesh 3", "mesh 2", "mesh 1"])
            stats = json.loads(asking.ask("GET", "equal/stats")[1])["trees"]
            self.assertLessEqual(stats["meshes_total"], 2)
            before = [asking.ask("GET", each)[1] for each in gets]
            server.kill()
            server.end()
            asking = Asking(self.server("--data", data))
            asking.ask("GET", "equal?wait=60")
            self.assertEqual(asking.ask("POST", "equal/rays:all", rays)[1], answer)
            self.assertEqual([asking.ask("GET", each)[1] for each in gets], before)

    def test_the_number_of_an_added_node_fits_int32(self):
        asking = Asking(self.server())
        asking.put("edited", made_file().bytes())
        for number, status, code in ((0x7FFFFFFF, 422, "NUMBER_OUT_OF_RANGE"), (0xFFFFFFFF, 422, "NUMBER_OUT_OF_RANGE"), (0x7FFFFFFE, 200, None)):
            answer = asking.ask("PATCH", "edited/nodes", {"nodes": [{"node": number, "copy_of": APART}]})
            self.assertEqual((answer[0], json.loads(answer[1]).get("code")), (status, code), answer[1])
            if code:
                self.assertEqual(json.loads(answer[1])["errors"][0]["pointer"], "/nodes/0")

    def test_removed_nodes_leave_little_in_the_record(self):
        data = self.folder()
        asking = Asking(self.server("--data", data))
        asking.put("edited", made_file().bytes())
        name = "long " * 2000
        self.assertEqual(asking.ask("PATCH", "edited/nodes/500", {"copy_of": APART, "name": name, "mask": 3})[0], 200)
        record = data / "scenes/edited.json"
        self.assertIn(name, record.read_text())
        self.assertEqual(asking.ask("DELETE", "edited/nodes/500")[0], 200)
        self.assertLess(record.stat().st_size, 1000)

    def test_cameras_of_removed_nodes_vanish(self):
        server = self.server()
        asking = Asking(server)
        document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1]}], "nodes": [{"name": "eye", "camera": 0}, {"name": "other"}],
                    "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]}
        asking.put("seen", glb(document, b""))
        image = {"generator": {"kind": "camera", "camera": "eye", "width": 2, "height": 2}}
        self.assertEqual(asking.ask("POST", "seen/rays:any", image)[0], 200)
        self.assertEqual(asking.ask("DELETE", "seen/nodes/0")[0], 200)
        status, text, _ = asking.ask("POST", "seen/rays:any", image)
        self.assertEqual((status, json.loads(text)["code"]), (422, "CAMERA_UNKNOWN"))

    def test_a_removed_joint_still_poses_and_a_removed_mesh_does_not(self):
        folder = self.folder()
        server = self.server("--data", Path(folder, "data"))
        asking = Asking(server)
        for scene in ("whole", "part"):
            asking.put(scene, made_file().bytes())
        for path in (f"{HIP}", f"{SECOND}"):
            self.assertEqual(asking.ask("DELETE", f"part/nodes/{path}")[0], 200)
        self.assertEqual([node["node_id"] for node in asking.nodes("part")["nodes"]], [SKINNED, MORPHED, MOVED, STILL, APART, FIXED])
        rays = [{"origin": [x / 3, 9, z / 2], "direction": [0, -1, 0.01]} for x in range(-30, 90) for z in (-2, 0, 2)]
        questions = [("rays:all", {"rays": rays, "fields": ["t", "node_id", "primitive", "triangle", "shading_normal"], "exclude": {"nodes": [k]}})
                     for k in (SECOND, APART)]
        for time in (0.25, 1.2):
            for scene in ("whole", "part"):
                status, text, _ = asking.ask("PATCH", f"{scene}/nodes", {"animation": {"name": "walk", "time": time}, "nodes": [
                    {"node": MORPHED, "weights": [time, 0.25]}, {"node": MOVED, "translation": [12, time, 0]}]})
                self.assertEqual(status, 200, text)
            # Without SECOND the same, by an answer of the other scene.
            body = {key: value for key, value in questions[0][1].items() if key != "exclude"}
            self.assertEqual(asking.ask("POST", "part/rays:all", body)[1], asking.ask("POST", "whole/rays:all", questions[0][1])[1])
        for node in (SKINNED, MORPHED):
            status, text, _ = asking.ask("PATCH", f"part/nodes/{node}", {"positions": [[0, 0, 0]] * 72})
            self.assertEqual((status, json.loads(text)["code"]), (422, "NODE_POSED"))
        for node, code, copied in ((SKINNED, "NODE_POSED", 422), (MORPHED, "NODE_POSED", 422), (SECOND, "NODE_NOT_FOUND", 404)):
            status, text, _ = asking.ask("PATCH", "part/nodes/50", {"copy_of": node})
            self.assertEqual((status, json.loads(text)["code"]), (copied, code))
        self.assertEqual(asking.ask("PATCH", "part/nodes/50", {"copy_of": STILL, "translation": [40, 0, 0]})[0], 200)
        before = asking.answers("part", questions[1:]), asking.nodes("part")
        server.kill()
        server = self.server("--data", Path(folder, "data"))
        asking = Asking(server)
        self.assertEqual((asking.answers("part", questions[1:]), asking.nodes("part")), before)
        # Poses after the restart, with nodes that the file does not have.
        for scene in ("whole", "part"):
            self.assertEqual(asking.ask("PATCH", f"{scene}/nodes", {"animation": {"name": "rest", "time": 1}})[0], 200)
        self.assertEqual(asking.ask("POST", "part/rays:all", {**questions[0][1], "exclude": {"nodes": [50]}})[1],
                         asking.ask("POST", "whole/rays:all", questions[0][1])[1])
        self.assertEqual(server.stop(), 0)

    def test_positions_are_those_of_one_node(self):
        server = self.server("--skip", "none", "--preload", "six=demo:six")
        asking = Asking(server)
        listed = json.loads(asking.ask("GET", "six/nodes?with=pose")[1])["nodes"]
        self.assertEqual([node["vertices"] for node in listed], [0, 9, 9])
        self.assertEqual(asking.ask("PATCH", "six/nodes/9", {"copy_of": 2, "translation": [0, 30, 0]})[0], 200)
        ray = {"rays": [{"origin": [3, 60, 0], "direction": [0, -1, 0]}, {"origin": [3, 20, 0], "direction": [0, -1, 0]},
                        {"origin": [-10, 1, 0], "direction": [1, 0, 0]}], "fields": ["t", "node_id", "uv"]}
        before = json.loads(asking.ask("POST", "six/rays:closest", ray)[1])["hits"]
        trees = json.loads(asking.ask("GET", "six/stats")[1])["trees"]
        flat = [[x, 7 if k < 3 else -100, z] for k, (x, z) in enumerate([(-9, -9), (9, -9), (0, 9)] * 3)]
        status, text, _ = asking.ask("PATCH", "six/nodes/2", {"positions": flat})
        self.assertEqual((status, json.loads(text)["counts"]["meshes"]), (200, 3))
        after = json.loads(asking.ask("POST", "six/rays:closest", ray)[1])["hits"]
        self.assertEqual((after[0], after[2]), (before[0], before[2]), "the copy has its mesh, and the other node")
        self.assertEqual((after[1]["t"], after[1]["node_id"]), (13 if after[1]["node_id"] == 2 else None, 2))
        now = json.loads(asking.ask("GET", "six/stats")[1])["trees"]
        self.assertEqual((now["full_builds"], now["trees_built"]), (0, 1), "the tree of its new mesh")
        self.assertGreater(trees["trees_kept"], 0)
        self.assertEqual(json.loads(asking.ask("GET", "six/selfcheck?rays=300")[1])["different"], [])


    def test_a_record_beyond_its_limit_changes_nothing(self):
        folder = self.folder()
        server = self.server("--data", Path(folder, "data"), "--memory", 800 << 20)
        asking, count = Asking(server), 120_000
        rows = struct.pack(f"<{3 * count}f", *(k % 3 for k in range(3 * count)))
        indices = struct.pack("<3I", 0, 1, count - 1)
        document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "buffers": [{"byteLength": len(rows + indices)}],
                    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                    "bufferViews": [{"buffer": 0, "byteLength": len(rows)}, {"buffer": 0, "byteOffset": len(rows), "byteLength": 12}],
                    "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": count, "min": [0, 0, 0], "max": [2, 2, 2]},
                                  {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3}]}
        asking.put("large", glb(document, rows + indices))

        def adding(number):
            return {"node": number, "copy_of": 0, "positions": [[number, 0, 0], [0, 1, 0], *[[0, 0, 0]] * (count - 3), [0, 0, 1]]}

        self.assertEqual(asking.ask("PATCH", "large/nodes", {"nodes": [adding(1)]})[0], 200)
        before = asking.ask("GET", "large")[1], asking.ask("GET", "large")[2]["ETag"]
        status, text, _ = asking.ask("PATCH", "large/nodes", {"nodes": [adding(number) for number in range(2, 8)]})
        self.assertEqual((status, json.loads(text)["code"]), (413, "CHANGES_TOO_MANY"))
        self.assertEqual((asking.ask("GET", "large")[1], asking.ask("GET", "large")[2]["ETag"]), before)
        # What is removed leaves room.
        self.assertEqual(asking.ask("DELETE", "large/nodes/1")[0], 200)
        self.assertEqual(asking.ask("PATCH", "large/nodes", {"nodes": [adding(number) for number in range(2, 7)]})[0], 200)
        hits = asking.ask("POST", "large/rays:all", {"rays": [{"origin": [-1, 0.125, 0.25], "direction": [1, 0, 0]}], "fields": ["t", "node_id"]})[1]
        server.kill()
        server = self.server("--data", Path(folder, "data"), "--memory", 800 << 20)
        again = Asking(server).ask("POST", "large/rays:all", {"rays": [{"origin": [-1, 0.125, 0.25], "direction": [1, 0, 0]}], "fields": ["t", "node_id"]})[1]
        self.assertEqual(hits, again)
        self.assertEqual({hit["node_id"] for hit in json.loads(hits)["results"][0]["hits"]} - {0}, {2, 3, 4, 5, 6})
        self.assertEqual(server.stop(), 0)

    def test_faults_change_nothing(self):
        server = self.server()
        asking = Asking(server)
        model = Model(random.Random(3))
        asking.put("edited", model.file())
        self.assertEqual(asking.ask("PATCH", "edited/nodes", {"nodes": [{"node": 9, "copy_of": 1}, {"node": 2, "removed": True}]})[0], 200)
        before = asking.ask("GET", "edited")[1]
        add = {"node": 20, "copy_of": 1}
        for changes, status, code, pointer in [
                ([{**add, "node": 1}], 409, "NODE_EXISTS", "/nodes/0"), ([add, {**add, "node": 6}], 409, "NODE_EXISTS", "/nodes/1"),
                ([{**add, "node": 9}], 409, "NODE_EXISTS", "/nodes/0"), ([{**add, "node": 2}], 409, "NODE_EXISTS", "/nodes/0"),
                ([{**add, "copy_of": 2}], 404, "NODE_NOT_FOUND", "/nodes/0/copy_of"), ([{**add, "copy_of": 20}], 404, "NODE_NOT_FOUND", "/nodes/0/copy_of"),
                ([{**add, "copy_of": 21}, {**add, "node": 21}], 404, "NODE_NOT_FOUND", "/nodes/0/copy_of"),
                ([{**add, "parent": 6}], 404, "NODE_NOT_FOUND", "/nodes/0/parent"), ([{**add, "parent": 2}], 404, "NODE_NOT_FOUND", "/nodes/0/parent"),
                ([{**add, "copy_of": 0}], 422, "NODE_MESHLESS", "/nodes/0/copy_of"), ([{**add, "weights": [1]}], 422, "NODE_WEIGHTS_WRONG", "/nodes/0/weights"),
                ([{"node": 1, "hidden": True}, {"node": 2, "removed": True}], 404, "NODE_NOT_FOUND", "/nodes/1"),
                ([{"node": 1, "removed": False}], 422, "VALUE_UNKNOWN", "/nodes/0/removed"), ([{"node": 1, "removed": 1}], 422, "TYPE_WRONG", "/nodes/0/removed"),
                ([{"node": 1, "removed": True, "hidden": True}], 422, "KEYS_MIXED", "/nodes/0/removed"),
                ([{**add, "removed": True}], 422, "KEYS_MIXED", "/nodes/0/removed"), ([{"node": 1, "name": "x"}], 422, "KEY_MISSING", "/nodes/0/name"),
                ([{"node": 1, "parent": 0}], 422, "KEY_MISSING", "/nodes/0/parent"), ([{**add, "name": 7}], 422, "TYPE_WRONG", "/nodes/0/name"),
                ([{**add, "copy_of": -1}], 422, "NUMBER_OUT_OF_RANGE", "/nodes/0/copy_of"), ([{**add, "copy_of": None}], 422, "TYPE_WRONG", "/nodes/0/copy_of"),
                ([{**add, "parent": 2**32}], 422, "NUMBER_OUT_OF_RANGE", "/nodes/0/parent"), ([{**add, "parent": "0"}], 422, "TYPE_WRONG", "/nodes/0/parent"),
                ([{**add, "matrix": [1e300] * 16}], 422, "TRANSFORM_INVALID", "/nodes/0/matrix"),
                ([{"node": 1, "positions": [[0, 0, 0]] * 6}], 422, "NODE_POSITIONS_WRONG", "/nodes/0/positions"),
                ([{**add, "positions": [[0, 0, 0]] * 8}], 422, "NODE_POSITIONS_WRONG", "/nodes/0/positions"),
                ([{"node": 0, "positions": [[0, 0, 0]]}], 422, "NODE_MESHLESS", "/nodes/0/positions"),
                ([{"node": 1, "positions": []}], 422, "LENGTH_WRONG", "/nodes/0/positions"),
                ([{"node": 1, "positions": [[0, 0, 0], [0, 0]]}], 422, "LENGTH_WRONG", "/nodes/0/positions/1"),
                ([{"node": 1, "positions": [0, 0, 0]}], 422, "TYPE_WRONG", "/nodes/0/positions/0"),
                ([{"node": 1, "positions": "AAAA"}], 422, "TYPE_WRONG", "/nodes/0/positions"),
                ([{"node": 1, "positions": [[0, 0, 0], [0, None, 0]]}], 422, "TYPE_WRONG", "/nodes/0/positions/1/1"),
                ([{"node": 1, "positions": [[0, 0, 3.5e38]]}], 422, "NUMBER_OUT_OF_RANGE", "/nodes/0/positions/0/2")]:
            with self.subTest(changes=changes):
                answer = asking.ask("PATCH", "edited/nodes", {"nodes": changes})
                problem = json.loads(answer[1])
                self.assertEqual((answer[0], problem["code"], problem["errors"][0]["pointer"]), (status, code, pointer))
                if len(changes) == 1 and status != 404 or pointer.count("/") > 2 and len(changes) == 1:
                    # Of one node: the same without the place in the list.
                    body = {key: value for key, value in changes[0].items() if key != "node"}
                    answer = asking.ask("PATCH", f"edited/nodes/{changes[0]['node']}", body)
                    problem = json.loads(answer[1])
                    self.assertEqual((answer[0], problem["code"]), (status, code))
                    if pointer != "/nodes/0":
                        self.assertEqual(problem["errors"][0]["pointer"], pointer.removeprefix("/nodes/0"))
        for number in ("x", "-1", "4294967296", "6"):
            status, text, _ = asking.ask("DELETE", f"edited/nodes/{number}")
            self.assertEqual((status, json.loads(text)["code"]), (404, "NODE_NOT_FOUND"))
        for method, path, body in (("DELETE", "none/nodes/1", None), ("PATCH", "none/nodes/1", {"copy_of": 1})):
            status, text, _ = asking.ask(method, path, body)
            self.assertEqual((status, json.loads(text)["code"]), (404, "SCENE_NOT_FOUND"))
        self.assertEqual(asking.ask("DELETE", "edited/nodes/1?wait=1")[0], 422)
        self.assertEqual(asking.ask("GET", "edited")[1], before)

    def test_a_retry_under_if_match_adds_one_node(self):
        server = self.server("--preload", "six=demo:six")
        asking = Asking(server)
        tag = asking.ask("GET", "six")[2]["ETag"]
        self.assertEqual(asking.ask("PATCH", "six/nodes/9", {"copy_of": 1}, If_Match=tag)[0], 200)
        self.assertEqual(asking.ask("PATCH", "six/nodes/9", {"copy_of": 1}, If_Match=tag)[0], 412)
        status, text, _ = asking.ask("PATCH", "six/nodes/9", {"copy_of": 1})
        self.assertEqual((status, json.loads(text)["code"]), (409, "NODE_EXISTS"))
        self.assertEqual(len(asking.nodes("six")["nodes"]), 4)
        # A new file is what it says.
        self.assertEqual(server.put("six", demo_glb("six")).status, 200)
        self.assertEqual(len(asking.nodes("six")["nodes"]), 3)


if __name__ == "__main__":
    case_report.main()
