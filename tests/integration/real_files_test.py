"""Files that break a rule of alignment and that other readers load: they load, with a warning, where there is one way to read them."""

import array
import json
import struct
import unittest

import case_report
from sightline_server import Server

RAYS = [([x / 8, y / 8, 1], [0, 0, -1]) for x in range(-1, 10) for y in range(-1, 10)]
FIELDS = ["t", "triangle", "position", "normal", "uv"]


def square(shift=0, accessor_shift=0):
    """(document, binary): two triangles with uv and 16-bit indices; every bufferView begins `shift` bytes behind a multiple of
    four, each accessor `accessor_shift` bytes into its bufferView."""
    parts = [array.array("f", (0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5)), array.array("f", (0, 0, 1, 0, 0, 1, 1, 1)),
             array.array("H", (0, 1, 2, 2, 1, 3))]
    binary, views = b"", []
    for part in parts:
        binary += bytes(-len(binary) % 4 + shift)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": accessor_shift + 4 * ((len(part.tobytes()) + 3) // 4)})
        binary += bytes(accessor_shift) + part.tobytes() + bytes(-len(part.tobytes()) % 4)
    kinds = [(5126, "VEC3", 4), (5126, "VEC2", 4), (5123, "SCALAR", 6)]
    accessors = [{"bufferView": i, "byteOffset": accessor_shift, "componentType": component, "type": kind, "count": count}
                 for i, (component, kind, count) in enumerate(kinds)]
    accessors[0] |= {"min": [0, 0, 0], "max": [1, 1, 0.5]}
    return {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}]}],
            "buffers": [{"byteLength": len(binary)}], "bufferViews": views, "accessors": accessors}, binary


def chunk(kind, payload, padding=b""):
    return struct.pack("<I4s", len(payload), kind) + payload + padding


def glb(*chunks):
    body = b"".join(chunks)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def text(document, rest):
    """The JSON with a length of `rest` modulo 4."""
    plain = json.dumps(document).encode()
    return plain + b" " * ((rest - len(plain)) % 4)


class RealFiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        cls.addClassCleanup(cls.server.end)
        document, binary = square()
        cls.expected = cls.answers(glb(chunk(b"JSON", text(document, 0)), chunk(b"BIN\0", binary)))
        assert cls.expected[1] == [] and sum(hit is not None for hit in cls.expected[0]) > 60, cls.expected[1]

    @classmethod
    def answers(cls, file):
        """(hits, warnings) of a file."""
        put = cls.server.put("s", file)
        assert put.status in (200, 201), put.body
        return cls.server.closest("s", *RAYS, fields=FIELDS), put.json()["warnings"]

    def refuses(self, file, code, words):
        answer = self.server.put("bad", file)
        self.assertEqual(answer.json().get("code"), code, answer.body)
        self.assertIn(words, answer.json()["detail"])

    def test_lengths_of_chunks_that_are_no_multiple_of_four(self):
        document, binary = square()
        for rest in (1, 2, 3):
            odd, padding = text(document, rest), b" " * (4 - rest)
            last = binary + b"\1\2\3"[:rest]
            files = [("JSON, BIN at the next byte", 0, glb(chunk(b"JSON", odd), chunk(b"BIN\0", binary))),
                     ("JSON, BIN at the next multiple of four", 0, glb(chunk(b"JSON", odd, padding), chunk(b"BIN\0", binary))),
                     ("BIN up to the end", 1, glb(chunk(b"JSON", text(document, 0)), chunk(b"BIN\0", last))),
                     ("BIN with padding behind", 1, glb(chunk(b"JSON", text(document, 0)), chunk(b"BIN\0", last, bytes(4 - rest))))]
            for name, number, file in files:
                with self.subTest(name=name, rest=rest):
                    hits, warnings = self.answers(file)
                    self.assertEqual(hits, self.expected[0])
                    self.assertEqual(warnings, [f"GLB: the length of chunk {number} is not a multiple of 4; read as it stands"])

    def test_a_next_chunk_that_is_in_neither_place_is_refused(self):
        document, binary = square()
        for behind in (b"\0" * 40, b"BIN\0" * 10):
            with self.subTest(behind=behind[:4]):
                self.refuses(glb(chunk(b"JSON", text(document, 1)) + behind), "GLTF_CONTAINER_INVALID", "not clear")

    def test_unaligned_buffer_views(self):
        for shift in (1, 2, 3):
            with self.subTest(shift=shift):
                document, binary = square(shift)
                hits, warnings = self.answers(glb(chunk(b"JSON", text(document, 0)), chunk(b"BIN\0", binary + bytes(-len(binary) % 4))))
                self.assertEqual(hits, self.expected[0])
                numbers = [0, 1, 2] if shift % 2 else [0, 1]
                self.assertEqual([warning.split(":")[0] for warning in warnings], [f"bufferView {i}" for i in numbers], warnings)
                for warning in warnings:
                    self.assertIn("not aligned", warning)

    def test_unaligned_chunks_and_views_together(self):
        document, binary = square(1)
        hits, warnings = self.answers(glb(chunk(b"JSON", text(document, 3)), chunk(b"BIN\0", binary + bytes(-len(binary) % 4 + 1))))
        self.assertEqual((hits, len(warnings)), (self.expected[0], 4), warnings)

    def test_an_accessor_that_is_unaligned_in_its_view_is_refused(self):
        # three.js cannot read it; Blender and assimp can.
        for shift in (1, 2, 3):
            document, binary = square(0, shift)
            self.refuses(glb(chunk(b"JSON", text(document, 0)), chunk(b"BIN\0", binary + bytes(-len(binary) % 4))),
                         "GLTF_ACCESSOR_INVALID", "need a multiple of")


if __name__ == "__main__":
    case_report.main()
