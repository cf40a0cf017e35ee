"""proto/python/sightline.py: slices, streams, threads, several servers, meshes, and a server of its own."""

import collections
import contextlib
import http.client
import io
import json
import math
import re
import struct
import subprocess
import sys
import tempfile
import threading
import types
import unittest
from pathlib import Path
from unittest import mock

import case_report
from sightline_server import BINARY, SOURCE, Server, demo_glb
from two_scenes import TwoScenes

sys.path.insert(0, str(SOURCE / "proto/python"))
import sightline  # noqa: E402  (found only now)

RAYS = [([-10, 1, 0], [1, 0, 0]), ([1, 10, 0], [0, -1, 0]), ([3, 10, 0], [0, -1, 0])] * 5
ORIGINS, DIRECTIONS = map(list, zip(*RAYS))
# What browsers load: no method of the client asks for it.
PAGES = {"page", "pageScript", "pageStyle", "learn", "learnScript", "bootScript", "statusPage", "statusScript", "document", "documents",
         "guideScript", "docs", "docsScript", "docsStyle"}
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
        with contextlib.redirect_stderr(drawn), mock.patch.dict(sys.modules, tqdm=None):  # As if tqdm were not installed.
            self.client.any("six", ORIGINS, DIRECTIONS, progress=True)
        self.assertEqual(drawn.getvalue(), "\r6 of 15 rows\r12 of 15 rows\r15 of 15 rows\n")

    def test_progress_is_a_bar_of_tqdm_if_it_is_installed(self):
        bars = []

        class Bar:
            def __init__(self, total, **_):
                self.total, self.steps, self.closed = total, [], 0
                bars.append(self)

            def update(self, step):
                self.steps.append(step)

            def close(self):
                self.closed += 1

        module = types.ModuleType("tqdm")
        module.tqdm, sightline._SLICE, drawn = Bar, 6, io.StringIO()
        with mock.patch.dict(sys.modules, tqdm=module), contextlib.redirect_stderr(drawn):
            self.client.any("six", ORIGINS, DIRECTIONS, progress=True)
            with self.assertRaises(sightline.SightlineError):
                self.client.any("six", ORIGINS, DIRECTIONS[:-1] + [[0, 0, 0]], progress=True)
        self.assertEqual([(bar.total, bar.steps, bar.closed) for bar in bars], [(15, [6, 6, 3], 1), (15, [6, 6], 1)])
        self.assertEqual(drawn.getvalue(), "")

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

    def test_each_operation_of_the_description_is_sent_by_a_method(self):
        ray, box, ends = (ORIGINS[:1], DIRECTIONS[:1]), [{"min": [-9, 0, -9], "max": [0, 9, 9]}], ([[-10, 1, 0]], [[0, 1, 0]])
        calls = {
            "listScenes": lambda c: c.scenes(), "loadScene": lambda c: c.load("read", {"path": "read.glb"}, wait=60),
            "getScene": lambda c: c.scene("six"), "putScene": lambda c: c.put("own", demo_glb("six")),
            "deleteScene": lambda c: c.delete("read"),
            "getJob": lambda c: c.job("six", c.ask_later("six", "points:inside", {"points": []})),
            "deleteJob": lambda c: c.delete_job("six", c.ask_later("six", "points:inside", {"points": []})),
            "jobResult": lambda c: self.result(c, c.ask_later("six", "points:inside", {"points": []})),
            "sceneEvents": lambda c: list(c.events("six")), "sceneStats": lambda c: c.stats("six"), "sceneNodes": lambda c: c.nodes("six"),
            "patchNodes": lambda c: c.patch_nodes("own", {1: {"hidden": True}}),
            "patchNode": lambda c: c.patch_node("own", 1, hidden=False),
            "deleteNode": lambda c: c.remove_node("own", 1), "sceneTriangles": lambda c: c.triangles("six", [(0, 0, 0)]),
            "sceneAnimations": lambda c: c.animations("six"), "sceneGeometry": lambda c: c.geometry("six"),
            "sceneTrees": lambda c: c.bvh("six"), "selfCheck": lambda c: c.selfcheck("six", rays=1), "raysClosest": lambda c: c.closest("six", *ray),
            "raysAny": lambda c: c.any("six", *ray), "raysAll": lambda c: c.all("six", *ray), "raysCount": lambda c: c.count("six", *ray),
            "raysGenerate": lambda c: c.generate(CAMERA), "visibility": lambda c: c.visibility("six", *ends),
            "pointsInside": lambda c: c.inside("six", ORIGINS), "pointsClosest": lambda c: c.closest_points("six", ORIGINS),
            "pointsNearest": lambda c: c.nearest("six", ORIGINS, 2), "pointsDistance": lambda c: c.distance("six", ORIGINS),
            "pointsSky": lambda c: c.sky("six", ORIGINS),
            "clearance": lambda c: c.clearance("six", {"names": ["left"]}, {"names": ["right"]}),
            "sweepsClosest": lambda c: c.sweeps_closest("six", *ray, radius=1), "sweepsAny": lambda c: c.sweeps_any("six", *ray, radius=1),
            "raysBoxes": lambda c: c.rays_boxes(*ray, box), "boxesAny": lambda c: c.boxes_any("six", box),
            "boxesList": lambda c: c.boxes_list("six", box), "boxesCount": lambda c: c.boxes_count("six", box),
            "health": lambda c: c.health(), "readiness": lambda c: c.ready(), "version": lambda c: c.version(),
            "metrics": lambda c: c.metrics(), "openapi": lambda c: c.openapi()}
        sent = []

        class Recording(http.client.HTTPConnection):
            def request(self, method, url, *arguments, **options):
                sent.append((method, url.split("?")[0]))
                super().request(method, url, *arguments, **options)

        with tempfile.TemporaryDirectory() as folder, Server("--preload", "six=demo:six", "--scene-root", folder) as server, \
                sightline.Sightline(server.url) as client:
            Path(folder, "read.glb").write_bytes(demo_glb("six"))
            operations = {each["operationId"]: (method.upper(), path) for path, methods in client.openapi()["paths"].items()
                          for method, each in methods.items() if "operationId" in each}
            self.assertEqual(set(operations), set(calls) | PAGES)
            client._pools[0]._kind = Recording
            client._pools[0].close()
            for name, call in calls.items():
                with self.subTest(name):
                    sent.clear()
                    call(client)
                    method, path = operations[name]
                    form = re.sub(r"\\{\w+\\}", "[^/:]+", re.escape(path))
                    self.assertTrue([each for each in sent if each[0] == method and re.fullmatch(form, each[1])], sent)
        questions = json.loads((SOURCE / "proto/questions.json").read_text(encoding="utf-8"))
        self.assertEqual([each["python"] for each in questions if not callable(getattr(self.client, each["python"], None))], [])

    def result(self, client, job):
        while client.job("six", job)["state"] not in ("done", "failed"):
            pass
        return client.job_result("six", job)

    def test_scenes_of_the_servers_folder_have_figures_and_a_sky(self):
        with tempfile.TemporaryDirectory() as folder, Server("--scene-root", folder) as server, sightline.Sightline(server.url) as client:
            Path(folder, "my six.glb").write_bytes(demo_glb("six"))
            loaded = client.load("six", {"path": "my six.glb"}, wait=60)
            self.assertEqual((loaded["id"], loaded["state"], loaded["counts"]["triangles"]), ("six", "ready", 6))
            with self.assertRaises(sightline.SightlineError) as caught:
                client.load("other", {"path": "none.glb", "surplus": "x"})
            self.assertEqual((caught.exception.status, [scene["id"] for scene in client.scenes()]), (422, ["six"]))
            stats = client.stats("six")
            self.assertEqual(json.loads(server.ask("/v1/scenes/six/stats").body).keys(), stats.keys())
            self.assertEqual(stats["counts"]["triangles"], 6)
            points, normals = [[1, 50, 0], [-5.5, 0.5, 0]], [[0, 1, 0], [1, 0, 0]]
            for told, more in ((client.sky("six", points, count=64), {}),
                               (client.sky("six", points, normals, count=64), {"normals": normals})):
                asked = client.ask("six", "points:sky", {"points": points, "count": 64, **more})
                self.assertEqual((plain(told["counts"]), told["counts"][0]), (asked["counts"], 64))
                self.assertTrue(0 < told["counts"][1] < 64, told)
                self.assertEqual(plain(told["ratios"]), [each / 64 for each in asked["counts"]])

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

    def test_a_server_of_its_own_loads_files(self):
        with tempfile.TemporaryDirectory() as folder:
            file, other = Path(folder, "my house (2).glb"), Path(folder, "broken.glb")
            file.write_bytes(demo_glb("six"))
            other.write_bytes(b"glTF")
            with sightline.Sightline.local(file, f"cellar={file}", binary=BINARY) as server:
                self.assertEqual(sorted(scene["id"] for scene in server.scenes()), ["cellar", "my-house-2"])
                for scene in ("cellar", "my-house-2"):
                    self.assertEqual(plain(server.any(scene, ORIGINS[:2], DIRECTIONS[:2])), [True, False])
            started, start = [], subprocess.Popen

            def noted(*arguments, **options):
                started.append(start(*arguments, **options))
                return started[-1]

            for source, message in ((other, "^scene broken is failed: GLTF_CONTAINER_INVALID: GLB: the header needs 12 bytes, "),
                                    (Path(folder, "none.glb"), "did not start: .*there is no file '.*none.glb'")):
                with mock.patch.object(subprocess, "Popen", noted), self.assertRaisesRegex(RuntimeError, message):
                    sightline.Sightline.local(source, binary=BINARY)
            self.assertEqual([process.poll() is None for process in started], [False, False])

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

    def test_images_are_arrays(self):
        columns = self.client.closest("six", generator=CAMERA, fields=["t", "node_id", "normal"])
        images = {name: self.client.image("six", name, CAMERA)
                  for name in ("depth", "node", "visits", "normal", "node_colours", "shaded")}
        self.assertEqual({name: (image.shape, image.dtype.name) for name, image in images.items()},
                         {"depth": ((2, 3), "float32"), "node": ((2, 3), "int64"), "visits": ((2, 3), "int64"),
                          "normal": ((2, 3, 3), "float32"), "node_colours": ((2, 3, 3), "float32"), "shaded": ((2, 3, 3), "float32")})
        hit = columns["hit"]
        self.assertTrue(hit.any() and not hit.all())
        self.assertEqual(plain(images["depth"]), plain(columns["t"].astype("float32")))
        self.assertEqual(plain(images["node"]), plain(columns["node_id"]))
        self.assertEqual(plain(images["normal"]), plain(self.numpy.where(hit[..., None], columns["normal"], 0).astype("float32")))
        self.assertGreater(images["visits"].min(), 0)
        for name in ("node_colours", "shaded"):
            self.assertEqual(plain(images[name].max(axis=2) > 0), plain(hit))
        sightline.numpy = None
        for name, image in images.items():
            self.assertEqual(self.client.image("six", name, CAMERA), image.tolist())


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
