"""proto/python/sightline.py: slices, streams, threads, several servers, meshes, and a server of its own."""

import collections
import contextlib
import io
import json
import math
import struct
import subprocess
import sys
import threading
import types
import unittest

import case_report
from sightline_server import BINARY, SOURCE, Server, demo_glb
from two_scenes import TwoScenes

sys.path.insert(0, str(SOURCE / "proto/python"))
import sightline  # noqa: E402  (found only now)

RAYS = [([-10, 1, 0], [1, 0, 0]), ([1, 10, 0], [0, -1, 0]), ([3, 10, 0], [0, -1, 0])] * 5
ORIGINS, DIRECTIONS = map(list, zip(*RAYS))
CAMERA = {"kind": "pinhole", "position": [-10, 1, 0], "forward": [1, 0, 0], "width": 3, "height": 2}


def plain(value):
    """Arrays as lists."""
    if isinstance(value, dict):
        return {name: plain(each) for name, each in value.items()}
    return value.tolist() if hasattr(value, "tolist") else value


class Calls(TwoScenes):
    numpy = None

    def setUp(self):
        self.addCleanup(setattr, sightline, "numpy", sightline.numpy)
        self.addCleanup(setattr, sightline, "_SLICE", sightline._SLICE)
        sightline.numpy = self.numpy
        self.client = sightline.Sightline(self.server.url)
        self.addCleanup(self.client.close)

    def test_slices_answer_as_one_request(self):
        fields = ["t", "position", "triangle"]
        masks = [0xFFFFFFFF, 0, 1] * 5
        calls = [lambda c: c.closest("six", ORIGINS, DIRECTIONS, fields=fields), lambda c: c.any("six", ORIGINS, DIRECTIONS),
                 lambda c: c.closest("six", ORIGINS, DIRECTIONS, fields=fields + ["node"], tmax=[9.0] * 15),
                 lambda c: c.count("six", ORIGINS, DIRECTIONS), lambda c: c.all("six", ORIGINS, DIRECTIONS, fields=fields),
                 lambda c: c.all("six", ORIGINS, DIRECTIONS, fields=["node"]), lambda c: c.any("six", ORIGINS, DIRECTIONS, masks=masks),
                 lambda c: c.closest("six", [ORIGINS[:5]] * 3, [DIRECTIONS[:5]] * 3, on_invalid="mark"),
                 lambda c: c.inside("six", ORIGINS, method="winding"), lambda c: c.nearest("six", ORIGINS, 2),
                 lambda c: c.sweeps_closest("six", ORIGINS, DIRECTIONS, radius=0.5), lambda c: c.distance("six", ORIGINS)]
        for number, call in enumerate(calls):
            whole = repr(plain(call(self.client)))
            for size in (1, 4, 7, 15):
                sightline._SLICE = size
                with self.subTest(number, size=size):
                    self.assertEqual(repr(plain(call(self.client))), whole)
            sightline._SLICE = 65_536

    def test_an_error_of_a_slice_names_the_row_of_the_call(self):
        sightline._SLICE = 4
        with self.assertRaises(sightline.SightlineError) as caught:
            self.client.any("six", ORIGINS, DIRECTIONS[:9] + [[0, 0, 0]] * 6)
        self.assertEqual(caught.exception.errors[0]["pointer"], "/rays/9/direction")
        with self.assertRaises(sightline.SightlineError) as caught:
            self.client.closest("six", ORIGINS, DIRECTIONS[:9] + [[0, 0, 0]] * 6, fields=["node"])
        self.assertEqual(caught.exception.errors[0]["pointer"], "/directions/27")

    def test_progress_is_told_by_a_function_or_a_bar(self):
        sightline._SLICE, told = 6, []
        self.client.any("six", ORIGINS, DIRECTIONS, progress=lambda done, total: told.append((done, total)))
        self.assertEqual(told, [(6, 15), (12, 15), (15, 15)])
        drawn = io.StringIO()
        with contextlib.redirect_stderr(drawn):
            self.client.any("six", ORIGINS, DIRECTIONS, progress=True)
        self.assertIn("15", drawn.getvalue())

    def test_a_stream_keeps_the_order_and_reads_two_batches_ahead_at_most(self):
        taken = []

        def batches():
            for i in range(20):
                taken.append(i)
                yield {"origins": [ORIGINS[i % 3]], "directions": [DIRECTIONS[i % 3]]} if i % 2 else ([ORIGINS[i % 3]], [DIRECTIONS[i % 3]])
        for i, hits in enumerate(self.client.stream("six", batches(), fields=["t"])):
            self.assertEqual(plain(hits["t"]), [[4.5, math.inf, 8][i % 3]])
            self.assertLessEqual(len(taken), i + 2)
        self.assertEqual(i, 19)
        self.assertEqual([plain(each) for each in self.client.stream("six", [(ORIGINS, DIRECTIONS)], "count")], [[6, 0, 1] * 5])

    def test_threads_share_a_client(self):
        wrong = []

        def ask(i):
            for _ in range(20):
                if plain(self.client.closest("six", [ORIGINS[i]], [DIRECTIONS[i]])["t"]) != [[4.5, math.inf, 8][i % 3]]:
                    wrong.append(i)
        threads = [threading.Thread(target=ask, args=(i,)) for i in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_remarks_come_with_texts_and_without(self):
        for fields in (["t"], ["t", "node"]):
            hits = self.client.closest("six", ORIGINS, DIRECTIONS, fields=fields, include={"names": ["zz"]})
            self.assertEqual(hits["warnings"][0]["code"], "SELECTION_EMPTY")
        self.assertIn("boxes", self.client.closest("six", ORIGINS[:1], DIRECTIONS[:1], explain=True, fields=["node"])["explain"])

    def test_every_route_has_its_method(self):
        client = self.client
        self.assertTrue(client.health() and client.ready())
        self.assertIn("limits", client.version())
        self.assertIn("sightline_", client.metrics())
        self.assertEqual(client.openapi()["openapi"][:2], "3.")
        self.assertIn("trees", client.bvh("six"))
        self.assertEqual(client.selfcheck("six", rays=10)["different"], [])
        self.assertEqual(plain(client.geometry("six")["all_meshes"]), [2])
        rays = client.generate(CAMERA)
        again = client.closest("six", rays["origins"], rays["directions"])
        self.assertEqual(plain(again["t"]), plain(client.closest("six", generator=CAMERA)["t"]))
        rounded = [[struct.unpack("f", struct.pack("f", t))[0] for t in row] for row in plain(again["t"])]
        self.assertEqual(plain(client.image("six", "depth", CAMERA)), rounded)
        self.assertEqual(client.image("six", "node", CAMERA, png=True)[:4], b"\x89PNG")
        self.assertTrue(client.rays_boxes([[-10, 1, 0]], [[1, 0, 0]], [{"min": [0, 0, 0], "max": [2, 2, 2]}])[0]["hit"])
        self.assertEqual(plain(client.sweeps_any("six", ORIGINS[:1], DIRECTIONS[:1], half=[1, 1, 1])), [True])
        turned = client.sweeps_closest("six", ORIGINS[:2], DIRECTIONS[:2], half=[1, 1, 1], axes=[[1, 1, 0], [-1, 1, 0], [0, 0, 1]], fields=["t"])
        each = client.ask("six", "sweeps:closest", {"sweeps": [
            {"origin": o, "direction": d, "half": [1, 1, 1], "axes": [[1, 1, 0], [-1, 1, 0], [0, 0, 1]]}
            for o, d in zip(ORIGINS[:2], DIRECTIONS[:2])]})["hits"]
        self.assertEqual(plain(turned["t"]), [hit["t"] for hit in each])
        ends = [[x, y + 1, z] for x, y, z in ORIGINS[:2]]
        capsules = client.sweeps_closest("six", ORIGINS[:2], DIRECTIONS[:2], radius=0.5, to=ends, fields=["t", "normal"])
        each = client.ask("six", "sweeps:closest", {"sweeps": [{"from": o, "to": end, "direction": d, "radius": 0.5}
                                                               for o, end, d in zip(ORIGINS[:2], ends, DIRECTIONS[:2])]})["hits"]
        self.assertEqual(plain(capsules["hit"]), [hit is not None for hit in each])
        self.assertEqual(plain(capsules["t"])[0], each[0]["t"])
        self.assertEqual(plain(client.boxes_any("six", [{"min": [-9, 0, -9], "max": [0, 9, 9]}])), [True])
        self.assertEqual(client.boxes_list("six", [{"min": [-9, 0, -9], "max": [0, 9, 9]}], of="nodes")[0]["total"], 1)
        self.assertGreater(client.clearance("six", {"names": ["left"]}, {"names": ["right"]})["pair"]["distance"], 3)
        self.assertEqual(plain(client.visibility("six", [[-10, 1, 0]], [[-6, 1, 0], [0, 1, 0]])["visible"]), [[True, False]])
        self.assertEqual(client.put("moved", demo_glb("six"))["state"], "ready")
        self.assertIn("ready", [event.get("state") for event in client.events("moved")])
        self.assertEqual(client.patch_node("moved", 2, hidden=True)["bounds"]["max"], [0, 4, 2])
        client.delete("moved")

    def test_meshes_of_arrays_and_of_objects_become_scenes(self):
        vertices, faces = [[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]]
        far = [[x + 500_000.1, y, z] for x, y, z in vertices]
        self.assertEqual(self.client.put_mesh("mesh", far, faces)["counts"]["triangles"], 1)
        corner = self.client.triangles("mesh", [(0, 0, 0)])[0]["corners"][0]
        self.assertLess(abs(corner[0] - 500_000.1), 1e-6)
        glb = sightline._mesh_glb(vertices, faces, "it")
        for source in (types.SimpleNamespace(vertices=vertices, faces=faces), types.SimpleNamespace(vertices=vertices, triangles=faces),
                       types.SimpleNamespace(to_legacy=lambda: types.SimpleNamespace(vertices=vertices, triangles=faces)),
                       types.SimpleNamespace(export=lambda file_type: glb if file_type == "glb" else None)):
            self.client.put("mesh", source)
            self.assertEqual(plain(self.client.closest("mesh", [[1, 1, 5]], [[0, 0, -1]])["t"]), [5])
        for wrong in ([[0, 1, 3]], [[0, 1, -1]], [[0, 1]], [], [[0.5, 1, 2]]):
            with self.subTest(wrong), self.assertRaises(ValueError):
                self.client.put_mesh("mesh", vertices, wrong)
        self.client.delete("mesh")

    def test_a_server_of_its_own_starts_and_stops(self):
        with sightline.Sightline.local("demo:six", binary=BINARY) as server:
            process = server._process._process
            self.assertEqual(plain(server.any("six", ORIGINS[:2], DIRECTIONS[:2])), [True, False])
        self.assertIsNotNone(process.returncode)
        with self.assertRaises(FileNotFoundError):
            sightline.Sightline.local("demo:six", binary="/there/is/none")
        with self.assertRaises(RuntimeError):
            sightline.Sightline.local("demo:six", binary=BINARY, arguments=["--no-such-flag"])

    def test_scenes_live_on_one_of_several_servers_that_share_none(self):
        with Server() as other:
            urls = [self.server.url, other.url]
            with sightline.Sightline(urls, shared=False) as both, sightline.Sightline(urls[::-1], shared=False) as reversed_list:
                names = [f"shared{i}" for i in range(40)]
                for name in names:
                    both.put(name, demo_glb("six"))
                homes = collections.Counter(each["id"] for each in both.scenes())
                self.assertEqual([homes[name] for name in names], [1] * len(names))
                for name in names:
                    self.assertEqual(plain(reversed_list.count(name, ORIGINS[:1], DIRECTIONS[:1])), [6])
                self.assertTrue(0 < sum(each["id"] in names for each in self.client.scenes()) < len(names))
                for name in names:
                    reversed_list.delete(name)


@unittest.skipUnless(sightline.numpy, "numpy is not installed")
class CallsWithNumpy(Calls):
    numpy = sightline.numpy


class Types(unittest.TestCase):
    def test_mypy_finds_no_fault(self):
        try:
            done = subprocess.run(["mypy", "--strict", "--allow-any-generics", "--no-warn-return-any", "--cache-dir=/dev/null",
                                   *map(str, sorted(SOURCE.glob("proto/python/*.py")))], capture_output=True, text=True, check=False)
        except FileNotFoundError:
            self.skipTest("mypy is not installed")
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    case_report.main()
