"""Stored files that are cut while their scenes are served: the answers stay, and so does the server."""

import os
import re
import struct
import tempfile
import unittest
from pathlib import Path

import case_report
from attributes_test import File
from process_status import is_sanitized
from sightline_server import Server

SQUARES = 20000


def strip():
    """A strip of squares at z = 5 with attributes; each column has pages of its own."""
    points = [p for i in range(SQUARES) for p in ((i, 0, 5), (i + 1, 0, 5), (i + 1, 1, 5), (i, 0, 5), (i + 1, 1, 5), (i, 1, 5))]
    file = File()
    names = {"POSITION": file.add(points, "VEC3", 5126, min=[0, 0, 5], max=[SQUARES, 1, 5]),
             "NORMAL": file.add([(0, 0, 1)] * len(points), "VEC3", 5126),
             "TEXCOORD_0": file.add([p[:2] for p in points], "VEC2", 5126),
             "COLOR_0": file.add([(1, .5, .25, 1)] * len(points), "VEC4", 5126)}
    # Bytes that no scene needs.
    file.view(bytes(8 << 20))
    file.root["meshes"].append({"primitives": [{"attributes": names}]})
    file.node(0)
    return file.bytes()


QUERY = {"rays": [{"origin": [i + .5, .25, 9], "direction": [0, 0, -1]} for i in range(0, SQUARES, 500)],
         "fields": ["t", "triangle", "uv", "colour", "shading_normal"]}


def resident(server):
    status = Path(f"/proc/{server.process.pid}/status").read_text(encoding="ascii")
    return int(re.search(r"RssAnon:\s+(\d+) kB", status)[1])


class CutFiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name, "data")

    def start(self, wait=True):
        server = Server("--data", str(self.folder), wait=wait)
        self.addCleanup(server.end)
        return server

    def cut(self, folder):
        files = [file for file in (self.folder / folder).iterdir() if file.stat().st_size >= 1 << 20]
        self.assertTrue(files, folder)
        for file in files:
            os.truncate(file, 0)

    def wait_for_trees(self, server):
        while True:
            stats = server.ask("/v1/scenes/strip/stats").json()
            if stats["trees"]["complete"] and any((self.folder / "trees").glob("*.trees")):
                return

    def answer(self, server):
        answer = server.query("strip", "closest", QUERY)
        self.assertEqual(answer.status, 200, answer.body[:300])
        return answer.json()["hits"]

    def test_a_cut_file_changes_no_answer_of_a_scene_that_was_put(self):
        reference, server = self.start_reference(), self.start()
        self.assertEqual(server.put("strip", strip()).status, 201)
        self.cut("blobs")
        self.assertEqual(self.answer(server), reference)
        self.assertIsNone(server.process.poll())

    def test_cut_files_change_no_answer_of_a_scene_that_was_loaded_at_the_start(self):
        first = self.start()
        first.put("strip", strip())
        reference = self.answer(first)
        self.wait_for_trees(first)
        self.assertEqual(first.stop(), 0)
        server = self.start()
        self.wait_for_trees(server)
        self.cut("blobs")
        self.cut("trees")
        self.assertEqual(self.answer(server), reference)
        self.assertEqual(server.kill(), -9)

        # Now the scene is damaged, and the only one that fails.
        server = self.start(wait=False)
        while server.ask("/v1/scenes/strip").json()["state"] != "failed":
            self.assertIsNone(server.process.poll())
        self.assertEqual(server.put("other", strip()).status, 201)
        self.assertEqual(server.query("other", "closest", QUERY).json()["hits"], reference)

    def test_bytes_that_a_scene_does_not_need_leave_memory(self):
        server = self.start()
        if is_sanitized(server):
            self.skipTest("a sanitizer keeps what is freed")
        before = resident(server)
        server.put("strip", strip())
        self.answer(server)
        needed = 6 * SQUARES * (12 + 12 + 8 + 16) >> 10
        self.assertLess(resident(server) - before, needed + 16 * 1024 + (4 << 10))

    def start_reference(self):
        with tempfile.TemporaryDirectory() as folder:
            server = Server("--data", str(Path(folder, "data")))
            try:
                server.put("strip", strip())
                return self.answer(server)
            finally:
                server.end()


if __name__ == "__main__":
    case_report.main()
