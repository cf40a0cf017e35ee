"""The 147 hostile files of tests/data/hostile, sent to a server and read by one from its disk."""

import json
import os
import struct
import tempfile
import time
import unittest
import zlib
from pathlib import Path

import case_report
import opened_files
from process_status import is_sanitized, status_bytes
from sightline_server import GLB_TYPE, JSON_TYPE, SOURCE, Server

CASES = SOURCE / "tests/data/hostile/cases"
MANIFEST = json.loads((CASES / "manifest.json").read_text())
MIB = 1 << 20
MOST_MEMORY = 256 * MIB  # above an idle server
MOST_SECONDS = 5  # of processor time, so that a busy machine changes nothing
GLTF_TYPE = "Content-Type: model/gltf+json"
RAY = ([-10, 1, 0], [1, 0, 0])


def forget_peak(server):
    Path(f"/proc/{server.process.pid}/clear_refs").write_text("5")


def processor_seconds(server):
    fields = Path(f"/proc/{server.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def outcome_of(scene):
    """What the manifest calls it; `scene` is the answer to GET of a scene, or None."""
    if scene is None:
        return "reject"
    counts = scene["counts"]
    unhittable = counts["nonfinite_triangles"] + counts["degenerate_triangles"]
    if counts["unique_triangles"] == unhittable:
        return "load_empty"
    return "load_warn" if scene["warnings"] or counts["skipped_primitives"] else "load"


def allowed(entry):
    return {entry["expect"], *entry["also_ok"]}


class Costs:
    """Memory and time of each case."""

    def __init__(self, server):
        self.server = server
        self.idle = status_bytes(server, "VmRSS")
        self.worst_memory = self.worst_seconds = (0, "")

    def begin(self):
        forget_peak(self.server)
        self.started = processor_seconds(self.server)

    def end(self, name):
        memory = status_bytes(self.server, "VmHWM") - self.idle
        seconds = processor_seconds(self.server) - self.started
        self.worst_memory = max(self.worst_memory, (memory, name))
        self.worst_seconds = max(self.worst_seconds, (seconds, name))
        return memory, seconds

    def __str__(self):
        (memory, heavy), (seconds, slow) = self.worst_memory, self.worst_seconds
        return (f"at most {memory / MIB:.0f} MiB above idle ({heavy}), "
                f"{seconds:.2f} s of processor time ({slow})")


class HostileFiles(unittest.TestCase):
    def check_alive(self, server):
        self.assertIsNone(server.process.poll(), "the server ended: " + server.log_text()[-2000:])
        self.assertEqual(server.closest("six", RAY)[0]["t"], 4.5)

    def check_costs(self, server, memory, seconds):
        if not is_sanitized(server):
            self.assertLess(memory, MOST_MEMORY)
            self.assertLess(seconds, MOST_SECONDS)

    def check_count(self, entry, scene):
        """Triangles that a correct loader keeps."""
        if entry["triangles"] is not None and scene["counts"]["instances"] <= 1:
            counts = scene["counts"]
            self.assertEqual(counts["triangles"] - counts["nonfinite_triangles"], entry["triangles"])

    def put(self, server, entry):
        name = entry["file"]
        media = GLTF_TYPE if name.endswith(".gltf") else GLB_TYPE
        answer = server.ask("/v1/scenes/hostile", "-X", "PUT", "-H", media, body=(CASES / name).read_bytes())
        if answer.status == 201:
            scene = server.ask("/v1/scenes/hostile").json()
            self.check_count(entry, scene)
            self.assertEqual(server.ask("/v1/scenes/hostile", "-X", "DELETE").status, 204)
            return scene
        self.assertIn(answer.status, range(400, 500), answer.body)
        problem = answer.json()
        self.assertTrue(problem["code"] and problem["detail"])
        self.assertLess(len(answer.body), 2000, "the answer echoes the file")
        self.assertEqual(server.ask("/v1/scenes/hostile").status, 404, "something was registered")
        return None

    def test_sent_to_a_server_end_as_the_manifest_allows(self):
        self.assertEqual(len(MANIFEST), 147)
        reason = opened_files.why_not()
        opened = None if reason else opened_files.OpenedFiles(self)
        server = Server("--preload", "six=demo:six", prefix=opened.prefix if opened else ())
        self.addCleanup(server.end)
        # What is opened once and late (the system's own files) is opened before the first case.
        for body in ((CASES / "type_integers_written_as_floats.gltf").read_bytes(), b"{}"):
            server.ask("/v1/scenes/first", "-X", "PUT", "-H", GLTF_TYPE, body=body)
        server.ask("/v1/scenes/first", "-X", "DELETE")
        self.check_alive(server)
        before = opened.paths() if opened else set()
        self.assertTrue(before or not opened, "strace saw nothing")
        costs = Costs(server)
        for entry in MANIFEST:
            with self.subTest(entry["file"]):
                costs.begin()
                scene = self.put(server, entry)
                memory, seconds = costs.end(entry["file"])
                self.check_alive(server)
                self.check_costs(server, memory, seconds)
                if entry["companions"]:
                    self.assertIsNone(scene, "an upload has no neighbours")
                else:
                    self.assertIn(outcome_of(scene), allowed(entry))
        print(f"147 files by PUT: {costs}")
        if not opened:
            self.skipTest(f"not shown which files were opened: {reason}")
        # malloc looks at /proc/sys/vm/overcommit_memory and sysconf at /sys: the system's, not a scene's.
        others = {path for path in opened.paths() - before if not path.startswith(("/proc/", "/sys/"))}
        self.assertEqual(others, set(), "an upload opened a file")

    def test_read_from_the_disk_end_as_the_manifest_allows_and_no_other_folder_is_opened(self):
        reason = opened_files.why_not()
        baseline, opened = opened_files.OpenedFiles(self), opened_files.OpenedFiles(self)
        with Server("--preload", "six=demo:six", prefix=() if reason else baseline.prefix) as server:
            self.check_alive(server)
        flags = ["--preload", "six=demo:six"]
        for number, entry in enumerate(MANIFEST):
            flags += ["--preload", f"case-{number}={CASES / entry['file']}"]
        began = time.monotonic()
        server = Server(*flags, prefix=() if reason else opened.prefix)
        self.addCleanup(server.end)
        took = time.monotonic() - began
        self.check_alive(server)
        peak = status_bytes(server, "VmHWM")
        self.check_costs(server, peak, processor_seconds(server) / len(MANIFEST))
        for number, entry in enumerate(MANIFEST):
            with self.subTest(entry["file"]):
                scene = server.ask(f"/v1/scenes/case-{number}").json()
                self.assertIn(scene["state"], ("ready", "failed"))
                if scene["state"] == "failed":
                    self.assertTrue(scene["reason"]["code"] and scene["reason"]["detail"])
                    self.assertNotIn(str(CASES), scene["reason"]["detail"])
                else:
                    self.check_count(entry, scene)
                self.assertIn(outcome_of(scene if scene["state"] == "ready" else None), allowed(entry))
        print(f"147 files by preload, at once: {peak / MIB:.0f} MiB with the server itself, "
              f"{processor_seconds(server):.2f} s of processor time, {took:.1f} s")
        if reason:
            self.skipTest(f"not shown which files were opened: {reason}")
        inside = {str(file) for file in CASES.iterdir()}
        others = {path for path in opened.paths() - baseline.paths() - inside
                  if not path.startswith(("/proc/", "/sys/", "/tmp/tsan.rodata."))}  # The last is ThreadSanitizer's own.
        self.assertEqual(others, set(), "a file outside the scene's folder was opened")
        self.assertIn(str(CASES / "my data.bin"), opened.paths(), "strace saw nothing")


    def test_named_below_a_root_end_as_the_manifest_allows_and_no_other_folder_is_opened(self):
        reason = opened_files.why_not()
        opened = None if reason else opened_files.OpenedFiles(self)
        server = Server("--preload", "six=demo:six", "--scene-root", CASES, prefix=opened.prefix if opened else ())
        self.addCleanup(server.end)
        self.check_alive(server)
        before = opened.opened() if opened else set()
        costs = Costs(server)
        for entry in MANIFEST:
            with self.subTest(entry["file"]):
                costs.begin()
                answer = server.ask("/v1/scenes?wait=60", "-H", JSON_TYPE,
                                    body=json.dumps({"id": "hostile", "source": {"path": entry["file"]}}))
                memory, seconds = costs.end(entry["file"])
                self.check_alive(server)
                self.check_costs(server, memory, seconds)
                scene = None
                if answer.status == 201:
                    scene = server.ask("/v1/scenes/hostile").json()
                    self.check_count(entry, scene)
                    self.assertEqual(server.ask("/v1/scenes/hostile", "-X", "DELETE").status, 204)
                else:
                    self.assertIn(answer.status, range(400, 500), answer.body)
                    self.assertEqual(server.ask("/v1/scenes/hostile").status, 404, "something was registered")
                self.assertIn(outcome_of(scene), allowed(entry), answer.body)
        print(f"147 files by POST: {costs}")
        if not opened:
            self.skipTest(f"not shown which files were opened: {reason}")
        there = opened.opened() - before
        others = {path for path in there if not path.startswith(("/proc/", "/sys/", f"{CASES}/")) and path != str(CASES)}
        self.assertEqual(others, set(), "a file outside the scene's folder was opened")
        self.assertIn(str(CASES / "my data.bin"), there, "strace saw nothing")


def png(side, seed):
    """A grey image of noise."""
    noise = bytearray(seed.to_bytes(4, "big") * (side // 4))
    rows = bytearray()
    for y in range(side):
        noise[y % side] ^= y & 255
        rows += b"\0" + noise
    def chunk(name, payload):
        return struct.pack(">I", len(payload)) + name + payload + struct.pack(">I", zlib.crc32(name + payload))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(bytes(rows), 1)) + chunk(b"IEND", b""))


class TexturedScene(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name).resolve()
        for number in range(4):
            (self.folder / f"image {number}.png").write_bytes(png(2048, number + 1))
        positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
        (self.folder / "needed.bin").write_bytes(positions)
        (self.folder / "unneeded.bin").write_bytes(positions)
        view = {"byteLength": 36}
        accessor = {"componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}
        document = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "material": 0}]}],
            "accessors": [{**accessor, "bufferView": 0}, {**accessor, "bufferView": 1}],
            "bufferViews": [{"buffer": 0, **view}, {"buffer": 1, **view}],
            "buffers": [{"uri": "needed.bin", **view}, {"uri": "unneeded.bin", **view}],
            "images": [{"uri": f"image%20{number}.png"} for number in range(4)],
            "textures": [{"source": number} for number in range(4)],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]}
        self.scene = self.folder / "scene.gltf"
        self.scene.write_text(json.dumps(document))

    def test_is_read_without_opening_an_image_or_a_buffer_that_no_ray_needs(self):
        if reason := opened_files.why_not():
            self.skipTest(reason)
        opened = opened_files.OpenedFiles(self)
        with Server("--preload", f"textured={self.scene}", prefix=opened.prefix) as server:
            hit = server.closest("textured", ([0.25, 0.25, 1], [0, 0, -1]))[0]
            self.assertEqual(hit["t"], 1)
        ours = {Path(path).name for path in opened.paths() if path.startswith(str(self.folder))}
        self.assertEqual(ours, {"scene.gltf", "needed.bin"})


if __name__ == "__main__":
    case_report.main()
