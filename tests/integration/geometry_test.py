"""GET /v1/scenes/{id}/geometry: the triangles that a page draws, against the exact corners of the same scene."""

import gzip
import json
import math
import struct
import unittest

import case_report
from sightline_server import DATA, JSON_TYPE, Server

LETTERS = {1: "d", 2: "I", 3: "B", 4: "Q", 5: "q", 6: "f"}
NONE = 0xFFFFFFFF


def columns(body):
    """Name -> rows, each a tuple where there are several numbers in a row."""
    magic, count, zero = struct.unpack_from("<4sIQ", body)
    assert magic == b"SLA1" and zero == 0, body[:16]
    found = {}
    for i in range(count):
        name, kind, width, at, rows = struct.unpack_from("<16sIIQQ", body, 16 + 40 * i)
        assert at % 8 == 0
        numbers = struct.unpack_from(f"<{rows * width}{LETTERS[kind]}", body, at)
        found[name.rstrip(b"\0").decode()] = numbers if width == 1 else [numbers[k:k + width] for k in range(0, len(numbers), width)]
        if name.rstrip(b"\0") == b"linear":
            # Byte b of number k stands in row 9 b + k.
            apart = [bytes(numbers[k:k + width]) for k in range(0, len(numbers), width)]
            found["linear"] = [struct.unpack("<9f", bytes(apart[9 * b + k][i] for k in range(9) for b in range(4))) for i in range(width if apart else 0)]
    return found


def corners(found, placement, triangle):
    """The corners in the world of a triangle of a placement, each with a bound of what float32 may lose."""
    mesh, linear, at = found["placed_mesh"][placement], found["linear"][placement], found["at"][placement]
    origin = found["origin"][mesh]
    for index in found["indices"][found["first_triangle"][mesh] + triangle]:
        position = found["positions"][found["first_position"][mesh] + index]
        world = [at[r] + sum(linear[3 * r + k] * position[k] for k in range(3)) for r in range(3)]
        # Positions and matrix are rounded to float32, `at` is a sum of float64.
        stretch = sum(map(abs, linear))
        lost = 2 ** -22 * max(map(abs, position)) + 2 ** -50 * max(map(abs, origin))
        yield world, lost * stretch + 2 ** -49 * (max(map(abs, world)) + max(map(abs, at)))


class Geometry(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server(*[f"--preload={name}=demo:{name}" for name in ("six", "town", "painted")])
        cls.addClassCleanup(cls.server.end)

    def geometry(self, scene, query=""):
        answer = self.server.ask(f"/v1/scenes/{scene}/geometry{query}")
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, "application/octet-stream"), answer.body[:300])
        return columns(answer.body)

    def exact(self, server, scene, ids):
        """Corners by instance.primitive.triangle, as many as one answer has."""
        answer = server.ask(f"/v1/scenes/{scene}/triangles?ids={','.join(ids)}")
        self.assertEqual(answer.status, 200, answer.body[:300])
        return answer.json()["triangles"]

    def hold(self, server, scene, found, most=400):
        """Every placement's first and last triangle of each part, against the exact corners."""
        wanted = []
        for placement, mesh in enumerate(found["placed_mesh"]):
            for part, owner in enumerate(found["part_mesh"]):
                if owner == mesh:
                    for number in {0, found["part_triangles"][part] - 1}:
                        wanted.append((placement, part, number))
        wanted = wanted[::max(1, len(wanted) // most)]
        ids = [f"{found['instance'][placement]}.{found['primitive'][part]}.{number}" for placement, part, number in wanted]
        for begin in range(0, len(ids), 300):
            for (placement, part, number), exact in zip(wanted[begin:begin + 300], self.exact(server, scene, ids[begin:begin + 300])):
                self.assertEqual(exact["node_id"], found["node_id"][placement])
                self.assertEqual(exact["material_id"], None if found["material_id"][part] == NONE else found["material_id"][part])
                for (world, bound), corner in zip(corners(found, placement, found["part_first"][part] + number), exact["corners"]):
                    self.assertLessEqual(math.dist(world, corner), 2 * bound)
        return len(wanted)

    def test_corners_are_those_of_the_scene(self):
        for scene in ("six", "town", "painted"):
            with self.subTest(scene=scene):
                self.assertGreater(self.hold(self.server, scene, self.geometry(scene)), 1)

    def test_all_instances_and_triangles_are_there(self):
        for scene in ("six", "town", "painted"):
            found = self.geometry(scene)
            counts = self.server.ask(f"/v1/scenes/{scene}").json()["counts"]
            self.assertEqual(sorted(found["instance"]), list(range(counts["instances"])))
            sizes = [end - begin for begin, end in zip(found["first_triangle"], found["first_triangle"][1:])]
            self.assertEqual(sum(sizes[mesh] for mesh in found["placed_mesh"]), counts["triangles"])
            self.assertEqual(found["all_meshes"], (len(found["mesh_id"]),))
            self.assertEqual(found["next"], ())
            for mesh, size in enumerate(sizes):
                self.assertEqual(size, sum(found["part_triangles"][part] for part, owner in enumerate(found["part_mesh"]) if owner == mesh))
            for mesh in range(len(sizes)):
                begin, end = found["first_triangle"][mesh:mesh + 2]
                positions = found["first_position"][mesh + 1] - found["first_position"][mesh]
                self.assertTrue(all(index < positions for row in found["indices"][begin:end] for index in row))

    def test_pieces_make_up_the_whole_and_the_largest_come_first(self):
        whole, first, got, pieces = self.geometry("town"), 0, [], 0
        bounds = {node["node_id"]: node["bounds"] for node in self.server.ask("/v1/scenes/town/nodes?limit=100000").json()["nodes"]}
        sizes = []
        while first is not None:
            answer = self.server.ask(f"/v1/scenes/town/geometry?first={first}&max_bytes=60000")
            piece = columns(answer.body)
            self.assertTrue(len(answer.body) < 70000 or len(piece["mesh_id"]) == 1)
            self.assertEqual((piece["all_meshes"], piece["all_bytes"]), (whole["all_meshes"], whole["all_bytes"]))
            got += piece["mesh_id"]
            for mesh in range(len(piece["mesh_id"])):
                sizes.append(max(math.dist(bounds[node]["min"], bounds[node]["max"])
                                 for node, owner in zip(piece["node_id"], piece["placed_mesh"]) if owner == mesh))
            first = piece["next"][0] if piece["next"] else None
            pieces += 1
        self.assertEqual(got, list(whole["mesh_id"]))
        self.assertEqual(sizes, sorted(sizes, reverse=True))
        self.assertGreater(pieces, 3)

    def test_what_is_near_and_large_comes_first(self):
        bounds = {node["node_id"]: node["bounds"] for node in self.server.ask("/v1/scenes/town/nodes?limit=100000").json()["nodes"]}
        whole = self.geometry("town")
        orders = set()
        for eye in ([60, 45, 80], [0, 20, 0], [-300, 100, 5], [1e6, -1e6, 1e6]):
            def apparent(node):
                low, high = bounds[node]["min"], bounds[node]["max"]
                away = math.hypot(*(max(a - x, 0, x - b) for a, x, b in zip(low, eye, high)))
                return (math.dist(low, high) / away if away else math.inf), math.dist(low, high)
            found, first = [], 0
            while first is not None:
                piece = self.geometry("town", f"?first={first}&max_bytes=60000&eye={','.join(map(str, eye))}")
                found += [(piece["mesh_id"][mesh], max(apparent(node) for node, owner in zip(piece["node_id"], piece["placed_mesh"]) if owner == mesh))
                          for mesh in range(len(piece["mesh_id"]))]
                first = piece["next"][0] if piece["next"] else None
            self.assertEqual(sorted(mesh for mesh, _ in found), sorted(whole["mesh_id"]))
            sizes = [size for _, size in found]
            for one, other in zip(sizes, sizes[1:]):
                self.assertTrue(one > other or math.isclose(one[0], other[0], rel_tol=1e-12))
            orders.add(tuple(mesh for mesh, _ in found))
        self.assertGreater(len(orders), 1)

    def test_nothing_but_totals_for_no_bytes(self):
        found, whole = self.geometry("town", "?max_bytes=0"), self.geometry("town")
        self.assertEqual((found["mesh_id"], found["next"], found["all_bytes"]), ((), (0,), whole["all_bytes"]))
        self.assertEqual(self.geometry("town", "?first=1000")["next"], ())
        size = len(self.server.ask("/v1/scenes/town/geometry").body)
        self.assertLess(abs(size - whole["all_bytes"][0]), 2000)

    def test_what_is_hidden_or_moved_is_sent_so(self):
        with Server("--preload", "six=demo:six") as server:
            def patch(change):
                done = server.ask("/v1/scenes/six/nodes/2", "-X", "PATCH", "-H", JSON_TYPE, body=json.dumps(change))
                self.assertEqual(done.status, 200, done.body)
            def found():
                answer = server.ask("/v1/scenes/six/geometry")
                return answer.headers["x-scene-revision"], columns(answer.body)
            before, whole = found()
            patch({"translation": [0, 3, 0]})
            after, moved = found()
            self.assertNotEqual(before, after)
            self.assertEqual([each[1] for each in moved["at"]], [each[1] + (3 if node == 2 else 0)
                                                                 for each, node in zip(whole["at"], whole["node_id"])])
            patch({"hidden": True})
            self.assertEqual(found()[1]["node_id"], (1,))

    def test_bad_requests_are_refused(self):
        for query, code in (("?first=-1", "QUERY_INVALID"), ("?max_bytes=x", "QUERY_INVALID"), ("?max_bytes=1073741825", "QUERY_INVALID"), ("?x=1", "QUERY_INVALID"),
                            *((f"?eye={eye}", "QUERY_INVALID") for eye in ("", "1,2", "1,2,3,4", "1,2,x", "1,,2", "1,2,nan", "1,2,1e999", "1;2;3"))):
            answer = self.server.ask(f"/v1/scenes/six/geometry{query}")
            self.assertEqual((answer.status, answer.json()["code"]), (422, code))
        self.assertEqual(self.server.ask("/v1/scenes/none/geometry").json()["code"], "SCENE_NOT_FOUND")
        self.assertEqual(self.server.ask("/v1/scenes/six/geometry", "-X", "POST", body="{}").status, 405)

    def test_answers_are_the_same_bytes(self):
        first = self.server.ask("/v1/scenes/town/geometry").body
        self.assertEqual(self.server.ask("/v1/scenes/town/geometry").body, first)
        with Server("--preload", "town=demo:town", "--skip", "none") as other:
            self.assertEqual(other.ask("/v1/scenes/town/geometry").body, first)

    def test_files_of_other_tools(self):
        sizes = {}
        for name in ("furnished_house", "city_nodes", "city_gpu_instancing", "knight_skinned", "spot_quantized"):
            file = DATA / "scenes" / f"{name}.glb"
            if not file.exists():
                self.skipTest(f"{file} is not there")
            with self.subTest(name=name), Server(memory=None) as server:
                put = server.put("x", file.read_bytes())
                self.assertIn(put.status, (200, 201), put.body[:300])
                body = server.ask("/v1/scenes/x/geometry?max_bytes=1073741824").body
                found = columns(body)
                self.assertGreater(self.hold(server, "x", found), 0)
                unique = 12 * (len(found["positions"]) + len(found["indices"]))
                for coding in ("gzip", "zstd"):
                    sent = server.ask("/v1/scenes/x/geometry?max_bytes=1073741824", "-H", f"Accept-Encoding: {coding}")
                    self.assertEqual((sent.headers["content-encoding"], sent.headers["vary"]), (coding, "Accept-Encoding"))
                    sizes[f"{name} {coding}"] = round(len(sent.body) / unique, 3)
                    if coding == "gzip":
                        self.assertEqual(gzip.decompress(sent.body), body)
                    self.assertLess(sizes[f"{name} {coding}"], 1.2)
        print("bytes sent, as a multiple of unique positions and indices:", sizes)


if __name__ == "__main__":
    case_report.main()
