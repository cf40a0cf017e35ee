"""Scenes beyond --memory-budget: their geometry and trees are in temporary files, and no answer depends on it."""

import json
import os
import random
import struct
import tempfile
import time
import unittest
from pathlib import Path

import case_report
from sightline_server import JSON_TYPE, PATIENCE, Server, demo_glb

SIDE = 300  # cells of the ground along an edge, two triangles each
MIB = 1 << 20


def ground():
    """A GLB of a height field; 18 bytes for each triangle."""
    n = SIDE + 1
    chance = random.Random(4)
    positions = b"".join(struct.pack("<3f", x, chance.uniform(-1, 1), z) for z in range(n) for x in range(n))
    cells = ((z * n + x) for z in range(SIDE) for x in range(SIDE))
    indices = b"".join(struct.pack("<6I", c, c + n, c + 1, c + 1, c + n, c + n + 1) for c in cells)
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "ground"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(positions) + len(indices)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)}, {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": n * n, "type": "VEC3", "min": [0, -1, 0], "max": [SIDE, 1, SIDE]},
                      {"bufferView": 1, "componentType": 5125, "count": 6 * SIDE * SIDE, "type": "SCALAR"}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(positions) + len(indices)
    return (struct.pack("<III", 0x46546C67, 2, size) + struct.pack("<II", len(text), 0x4E4F534A) + text +
            struct.pack("<II", len(positions) + len(indices), 0x004E4942) + positions + indices)


def rays(count, seed=1):
    chance = random.Random(seed)
    return [{"origin": [chance.uniform(0, SIDE), chance.uniform(2, 20), chance.uniform(0, SIDE)],
             "direction": [chance.uniform(-1, 1), -0.3, chance.uniform(-1, 1)]} for _ in range(count)]


FIELDS = ["t", "triangle", "position", "normal", "barycentrics"]
QUESTIONS = [("rays:closest", {"rays": rays(5000), "fields": FIELDS}), ("rays:any", {"rays": rays(1000, 2)}),
             ("rays:all", {"rays": rays(100, 3), "fields": FIELDS}), ("boxes:count", {"boxes": [{"min": [10, -2, 10], "max": [90, 2, 70]}]}),
             ("points:nearest", {"points": [[i % 299 + 0.3, 3, i % 271 + 0.2] for i in range(4200)], "fields": ["distance"]})]


class Overflow(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def serve(self, *arguments):
        server = Server(*arguments)
        self.addCleanup(server.end)
        return server

    def answers(self, server, scene):
        asked = (server.ask(f"/v1/scenes/{scene}/{path}", "-H", JSON_TYPE, body=json.dumps(body)) for path, body in QUESTIONS)
        return [(answer.status, answer.body) for answer in asked]

    def overflow_of(self, server):
        return server.metric("sightline_overflow_bytes"), server.metric("sightline_overflow_evicted_bytes_total")

    def test_a_scene_of_many_times_the_budget_is_answered_as_any(self):
        glb = ground()
        plenty = self.serve()
        self.assertIn(plenty.put("ground", glb).status, (200, 201))
        truth = self.answers(plenty, "ground")
        self.assertEqual({status for status, _ in truth}, {200})
        for data in (["--data", str(self.folder)], []):
            with self.subTest(data=data):
                # Geometry of 3.2 MB, and 12 MB of trees.
                server = self.serve("--memory-budget", MIB, *data)
                self.assertIn(server.put("ground", glb).status, (200, 201))
                for _ in range(3):
                    self.assertEqual(self.answers(server, "ground"), truth)
                overflow, evicted = self.overflow_of(server)
                self.assertGreater(overflow, 10 * MIB)
                self.assertGreater(evicted, MIB)
                move = json.dumps({"translation": [0, 1, 0]})
                for each in (server, plenty):
                    moved = each.ask("/v1/scenes/ground/nodes/0", "-X", "PATCH", "-H", JSON_TYPE, body=move)
                    self.assertEqual(moved.status, 200, moved.body)
                moved = self.answers(plenty, "ground")
                self.assertNotEqual(moved, truth)
                self.assertEqual(self.answers(server, "ground"), moved)
                self.assertIn(plenty.put("ground", glb).status, (200, 201))
                self.assertIn(server.ask("/v1/scenes/ground", "-X", "DELETE").status, (200, 204))
                self.wait_for_nothing(server)

    def wait_for_nothing(self, server):
        end = time.monotonic() + PATIENCE
        while self.overflow_of(server)[0] > 0:
            self.assertLess(time.monotonic(), end)

    def test_a_mesh_that_is_removed_or_replaced_is_no_longer_counted(self):
        server = self.serve("--data", str(self.folder), "--memory-budget", MIB)
        self.assertIn(server.put("ground", ground()).status, (200, 201))
        removed = server.ask("/v1/scenes/ground/nodes/0", "-X", "DELETE")
        self.assertIn(removed.status, (200, 204), removed.body)
        self.assertEqual(server.closest("ground", ([5, 9, 5], [0, -1, 0]))[0], None)

    def test_a_scene_that_is_queried_takes_the_memory_of_trees_that_are_not(self):
        server = self.serve("--data", str(self.folder), "--memory-budget", 24 * MIB)
        for name in ("first", "second"):
            self.assertIn(server.put(name, ground()).status, (200, 201))
            self.answers(server, name)
        self.assertEqual(self.answers(server, "second"), self.answers(server, "first"))
        self.assertLess(server.metric("sightline_tree_bytes") + server.metric("sightline_geometry_bytes"), 24 * MIB)

    def test_a_stored_scene_is_there_after_a_start(self):
        server = self.serve("--data", str(self.folder), "--memory-budget", MIB)
        self.assertIn(server.put("ground", ground()).status, (200, 201))
        truth = self.answers(server, "ground")
        server.end()
        again = self.serve("--data", str(self.folder), "--memory-budget", MIB)
        self.assertEqual(self.answers(again, "ground"), truth)
        self.assertGreater(self.overflow_of(again)[0], 0)

    def test_the_budget_is_half_of_the_memory_unless_a_flag_says_more_or_less(self):
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        for file in ("memory.max", "memory/memory.limit_in_bytes"):
            limit = Path("/sys/fs/cgroup", file)
            if limit.exists() and limit.read_text().strip() != "max":
                memory = min(memory, int(limit.read_text()))
        for flags, budget in (((), memory // 2), (("--memory-budget", MIB), MIB)):
            server = self.serve(*flags)
            self.assertEqual(server.ask("/version").json()["limits"]["memory_budget"], budget)

    def test_a_full_disk_refuses_the_scene_alone(self):
        server = self.serve("--data", str(self.folder), "--memory-budget", MIB, "--disk-budget", MIB)
        self.assertIn(server.put("six", demo_glb("six")).status, (200, 201))
        refused = server.put("ground", ground())
        self.assertEqual((refused.status, refused.json()["code"]), (507, "OVERFLOW_FULL"))
        self.assertEqual(server.query("six", "closest", {"rays": rays(1)}).status, 200)


if __name__ == "__main__":
    case_report.main()
