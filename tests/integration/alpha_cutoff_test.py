"""Rays through masked materials, against this file's own reading of its own images.

SIGHTLINE_ALPHA_RAYS is the number of random rays (3,000).
"""

import array
import json
import math
import os
import random
import struct
import tempfile
import unittest
import zlib

import case_report
from made_scene import glb
from sightline_server import JSON_TYPE, Server

RAYS = int(os.environ.get("SIGHTLINE_ALPHA_RAYS", "3000"))
REPEAT, CLAMP, MIRROR = 10497, 33071, 33648
GREY, RGB, PALETTE, GREY_ALPHA, RGBA = 0, 2, 3, 4, 6
JPEG = b"\xff\xd8\xff\xe0 any bytes: a JPEG has no alpha"


def png(alpha, kind=RGBA, deep=False):
    """An image with these rows of alpha, 0 to 255; PALETTE and GREY have alpha by tRNS."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    height, width = len(alpha), len(alpha[0])
    more = b""
    if kind == PALETTE:
        more = chunk(b"PLTE", bytes(range(256)) * 3) + chunk(b"tRNS", bytes(range(256)))
        pixel = lambda a: bytes([a])
    elif kind == GREY:
        more = chunk(b"tRNS", struct.pack(">H", 7))  # a grey that is transparent
        pixel = lambda a: bytes([7 if a == 0 else 200])
    elif kind == RGB:
        pixel = lambda a: bytes([a, a, a])
    else:
        wide = (lambda x: struct.pack(">H", 257 * x)) if deep else (lambda x: bytes([x]))
        colour = b"\x12" * (2 if deep else 1) * (3 if kind == RGBA else 1)
        pixel = lambda a: colour + wide(a)
    rows = b"".join(b"\0" + b"".join(map(pixel, row)) for row in alpha)
    head = struct.pack(">IIBBBBB", width, height, 16 if deep else 8, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + more + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def scene_glb(materials, images, parts):
    """A mesh with a primitive for each part: (corners, uvs, alphas of COLOR_0 or None, material), three of each for a triangle."""
    data, views, accessors, primitives = b"", [], [], []

    def view(part):
        nonlocal data
        data += bytes(-len(data) % 4)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        data += part
        return len(views) - 1

    def accessor(rows, kind):
        flat = array.array("f", [x for row in rows for x in row])
        accessors.append({"bufferView": view(flat.tobytes()), "componentType": 5126, "count": len(rows), "type": kind})
        if kind == "VEC3":
            accessors[-1].update(min=[min(row[k] for row in rows) for k in range(3)], max=[max(row[k] for row in rows) for k in range(3)])
        return len(accessors) - 1

    for corners, uvs, alphas, material in parts:
        attributes = {"POSITION": accessor(corners, "VEC3")}
        if uvs:
            attributes["TEXCOORD_0"] = accessor(uvs, "VEC2")
        if alphas:
            attributes["COLOR_0"] = accessor([(1, 1, 1, a) for a in alphas], "VEC4")
        primitives.append({"attributes": attributes, "material": material})
    listed = [{"bufferView": view(image), "mimeType": "image/jpeg" if image is JPEG else "image/png"} for image in images]
    samplers = [{"wrapS": s, "wrapT": t} for s in (REPEAT, CLAMP, MIRROR) for t in (REPEAT, CLAMP, MIRROR)]
    textures = [{"source": image, "sampler": sampler} for image in range(len(images)) for sampler in range(9)]
    document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": primitives}],
                "materials": materials, "textures": textures, "samplers": samplers, "images": listed, "buffers": [{"byteLength": len(data)}],
                "bufferViews": views, "accessors": accessors}
    return glb(document, data)


def mask(texture=None, cutoff=None, factor=None, transform=None):
    material = {"alphaMode": "MASK", "pbrMetallicRoughness": {}}
    if cutoff is not None:
        material["alphaCutoff"] = cutoff
    if factor is not None:
        material["pbrMetallicRoughness"]["baseColorFactor"] = [1, 1, 1, factor]
    if texture is not None:
        material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": texture}
        if transform:
            material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = {"KHR_texture_transform": transform}
    return material


def wrapped(x, kind):
    if kind == REPEAT:
        return x - math.floor(x)
    if kind == CLAMP:
        return min(max(x, 0.0), 1.0)
    m = x - 2 * math.floor(x / 2)
    return 2 - m if m > 1 else m


def counts(material, alphas, hit):
    """Whether a hit with the fields uv and colour counts."""
    if material["alphaMode"] != "MASK":
        return True
    metallic = material["pbrMetallicRoughness"]
    alpha = float(metallic.get("baseColorFactor", [1, 1, 1, 1])[3])
    info = metallic.get("baseColorTexture")
    if info and hit["uv"] and alphas[info["index"] // 9] is not None:
        rows, sampler = alphas[info["index"] // 9], info["index"] % 9
        transform = info.get("extensions", {}).get("KHR_texture_transform", {})
        offset, scale = transform.get("offset", [0, 0]), transform.get("scale", [1, 1])
        sizes, wraps = (len(rows[0]), len(rows)), ((REPEAT, CLAMP, MIRROR)[sampler // 3], (REPEAT, CLAMP, MIRROR)[sampler % 3])
        cell = [min(math.floor(wrapped(offset[k] + scale[k] * hit["uv"][k], wraps[k]) * sizes[k]), sizes[k] - 1) for k in range(2)]
        alpha *= rows[cell[1]][cell[0]] / 255
    if hit["colour"]:
        alpha *= hit["colour"][3]
    return alpha >= material.get("alphaCutoff", 0.5)


class AlphaCutoff(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        cls.addClassCleanup(cls.server.end)

    def ask(self, kind, body, scene="s"):
        answer = self.server.query(scene, kind, body)
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def load(self, *arguments, scene="s"):
        answer = self.server.put(scene, scene_glb(*arguments))
        self.assertIn(answer.status, (200, 201), answer.body)

    def quad(self, z, uvs=((0, 1), (1, 1), (1, 0), (0, 0))):
        corners = [(0, 0, z), (1, 0, z), (1, 1, z), (0, 1, z)]
        return [corners[i] for i in (0, 1, 2, 0, 2, 3)], [uvs[i] for i in (0, 1, 2, 0, 2, 3)]

    def test_each_texel_of_an_image(self):
        source = random.Random(3)
        alpha = [[source.choice((0, 1, 127, 128, 254, 255)) for _ in range(8)] for _ in range(4)]
        clear = [[0 if a < 128 else 255 for a in row] for row in alpha]
        for name, image in (("rgba", png(alpha)), ("grey and alpha", png(alpha, GREY_ALPHA)), ("palette", png(alpha, PALETTE)),
                            ("16 bits", png(alpha, RGBA, deep=True)), ("one transparent grey", png(clear, GREY))):
            with self.subTest(name):
                floor, sheet = self.quad(0), self.quad(1)
                self.load([mask(0), {"alphaMode": "OPAQUE"}], [image], [(*sheet, None, 0), (*floor, None, 1)])
                # The uv of the corners make the image stand upright: row 0 is at y = 1.
                rays = [{"origin": [(x + 0.5) / 8, 1 - (y + 0.5) / 4, 5], "direction": [0, 0, -1]} for y in range(4) for x in range(8)]
                hits = self.ask("closest", {"rays": rays, "alpha": "cutoff", "fields": ["t"]})["hits"]
                self.assertEqual([hit["t"] for hit in hits], [4 if a >= 128 else 5 for row in alpha for a in row])
                self.assertEqual({hit["t"] for hit in self.ask("closest", {"rays": rays, "fields": ["t"]})["hits"]}, {4})
                opaque = self.ask("closest", {"rays": rays, "alpha": "opaque", "fields": ["t"]})
                self.assertEqual(opaque, self.ask("closest", {"rays": rays, "fields": ["t"]}))

    def test_random_scenes_against_images_read_here(self):
        source = random.Random(24)
        alphas = [[[source.choice((0, 60, 127, 128, 200, 255)) for _ in range(w)] for _ in range(h)] for w, h in ((1, 1), (3, 5), (16, 16), (7, 2))]
        images = [png(alphas[0]), png(alphas[1], GREY_ALPHA), png(alphas[2], PALETTE), png(alphas[3], RGBA, deep=True), JPEG, png(alphas[1], RGB)]
        alphas += [None, None]
        materials = [{"alphaMode": "OPAQUE"}, {"alphaMode": "BLEND"}, mask(), mask(factor=0.25), mask(factor=0.25, cutoff=0.25), mask(cutoff=0)]
        for _ in range(24):
            transform = source.choice((None, {"offset": [0.3, -1.7]}, {"scale": [2.5, -0.75]}, {"offset": [5, 0.125], "scale": [3, 0]}))
            materials.append(mask(source.randrange(9 * len(images)), source.choice((None, 0.2, 0.9)), source.choice((None, 0.8)), transform))
        parts = []
        for _ in range(150):
            corners = [[source.uniform(-3, 3) for _ in range(3)] for _ in range(3)]
            uvs = [[source.uniform(-3, 3) for _ in range(2)] for _ in range(3)] if source.random() < 0.9 else None
            parts.append((corners, uvs, [source.random() for _ in range(3)] if source.random() < 0.3 else None, source.randrange(len(materials))))
        for i in range(20):  # always transparent: materials[2] with half of its factor
            corners = [[-3, -3, i / 10 - 1], [3, -3, i / 10 - 1], [0, 3, i / 10 - 1]]
            parts.append((corners, None, [0.25] * 3, 2))
        self.load(materials, images, parts)
        rays = [{"origin": [source.uniform(-4, 4) for _ in range(3)], "direction": [source.uniform(-1, 1) for _ in range(3)]} for _ in range(RAYS)]
        fields = ["t", "instance", "primitive", "triangle", "uv", "colour", "material_id"]
        through = longest = 0
        for begin in range(0, RAYS, 1000):
            some = {"rays": rays[begin:begin + 1000]}
            plain = self.ask("all", {**some, "fields": fields})["results"]
            expected = [[hit for hit in each["hits"] if counts(materials[hit["material_id"]], alphas, hit)] for each in plain]
            cut = {**some, "alpha": "cutoff"}
            closest = self.ask("closest", {**cut, "fields": fields})["hits"]
            self.assertEqual(closest, [each[0] if each else None for each in expected])
            self.assertEqual(self.ask("any", cut)["hits"], [bool(each) for each in expected])
            self.assertEqual(self.ask("count", cut)["counts"], [len(each) for each in expected])
            self.assertEqual(self.ask("all", {**cut, "fields": fields})["results"], [{"total": len(each), "hits": each} for each in expected])
            self.assertEqual(self.ask("all", {**cut, "fields": fields, "max_hits": 2})["results"],
                             [{"total": len(each), "hits": each[:2]} for each in expected])
            for each, found in zip(plain, expected):
                skipped = next((i for i, hit in enumerate(each["hits"]) if found and hit == found[0]), len(each["hits"]))
                through += skipped > 0
                longest = max(longest, skipped)
        print(f"{RAYS} rays, {through} pass a transparent texel first, at most {longest} of them; wrong 0")
        self.assertGreater(through, RAYS // 10)
        self.assertGreater(longest, 8)

    def test_the_bytes_are_those_of_every_kernel_and_thread_count(self):
        source = random.Random(5)
        alpha = [[source.choice((0, 255)) for _ in range(32)] for _ in range(32)]
        parts = [(*self.quad(z), None, 0) for z in range(20)]
        file = scene_glb([mask(4)], [png(alpha)], parts)
        body = json.dumps({"generator": {"kind": "pinhole", "position": [0.4, 0.3, 22], "look_at": [0.5, 0.5, 0], "width": 48, "height": 32},
                           "alpha": "cutoff", "fields": ["t", "primitive", "uv", "position"]})
        answers = set()
        kernels = self.server.ask("/version").json()["kernels"]
        for kernel in kernels:
            for threads in (1, 2):
                with Server("--kernel", kernel, "--threads", threads) as server:
                    self.assertEqual(server.put("s", file).status, 201)
                    answers.add(server.query("s", "closest", body).body)
        self.assertEqual(len(answers), 1, kernels)

    def test_streams_and_pictures_have_it_too(self):
        self.load([mask(0), {}], [png([[0, 255]])], [(*self.quad(1), None, 0), (*self.quad(0), None, 1)])
        lines = "\n".join(map(json.dumps, ({"options": {"alpha": "cutoff", "fields": ["t"]}}, {"origin": [0.25, 0.5, 5], "direction": [0, 0, -1]},
                                           {"origin": [0.75, 0.5, 5], "direction": [0, 0, -1]}))) + "\n"
        answer = self.server.ask("/v1/scenes/s/rays:closest", "-H", "Content-Type: application/x-ndjson", body=lines)
        self.assertEqual(answer.body.split(), [b'{"t":5}', b'{"t":4}'])
        camera = {"kind": "orthographic", "position": [0.5, 0.5, 5], "look_at": [0.5, 0.5, 0], "width": 2, "height": 1, "extent_y": 0.5}
        body = {"generator": camera, "image": "depth", "alpha": "cutoff"}
        picture = self.server.query("s", "closest", body, "-H", "Accept: image/x-portable-floatmap")
        self.assertEqual(struct.unpack("<2f", picture.body[-8:]), (5, 4), picture.body)

    def test_what_cannot_be_tested_is_refused_only_when_it_is_met(self):
        damaged = png([[0, 255]])[:-30]
        for name, materials, images in (
                ("damaged", [mask(0)], [damaged]), ("no image", [mask(99)], [png([[0]])]), ("no PNG", [mask(0)], [b"WEBP" * 9]),
                ("rotated", [mask(0, transform={"rotation": 0.5})], [png([[0]])]),
                ("other coordinates", [mask(0, transform={"texCoord": 1})], [png([[0]])])):
            with self.subTest(name):
                self.load(materials, images, [(*self.quad(1), None, 0)])
                met, missed = ({"rays": [{"origin": [x, 0.5, 5], "direction": [0, 0, -1]}], "alpha": "cutoff"} for x in (0.5, 7))
                for kind in ("closest", "any", "count", "all"):
                    answer = self.server.query("s", kind, met)
                    self.assertEqual((answer.status, answer.json()["code"], answer.json()["errors"][0]["pointer"]), (422, "ALPHA_UNREADABLE", "/alpha"))
                    self.assertEqual(self.server.query("s", kind, missed).status, 200)
                self.assertEqual(self.server.query("s", "any", {**met, "alpha": "opaque"}).status, 200)

    def test_wrong_words_are_refused(self):
        self.load([mask()], [], [(*self.quad(1), None, 0)])
        ray = {"rays": [{"origin": [0.5, 0.5, 5], "direction": [0, 0, -1]}]}
        for body, code, pointer in (({**ray, "alpha": "blend"}, "VALUE_UNKNOWN", "/alpha"), ({**ray, "alpha": True}, "TYPE_WRONG", "/alpha"),
                                    ({**ray, "alpha": 0.5}, "TYPE_WRONG", "/alpha")):
            answer = self.server.query("s", "closest", body)
            self.assertEqual((answer.status, answer.json()["code"], answer.json()["errors"][0]["pointer"]), (422, code, pointer))
        answer = self.server.ask("/v1/scenes/s/visibility", "-H", JSON_TYPE, body=json.dumps({"from": [[0, 0, 0]], "to": [[1, 1, 1]], "alpha": "cutoff"}))
        self.assertEqual(answer.json()["code"], "KEY_UNKNOWN")

    def test_a_restarted_server_answers_alike(self):
        file = scene_glb([mask(0), {}], [png([[0, 255]])], [(*self.quad(1), None, 0), (*self.quad(0), None, 1)])
        body = {"rays": [{"origin": [x, 0.5, 5], "direction": [0, 0, -1]} for x in (0.25, 0.75)], "alpha": "cutoff", "fields": ["t"]}
        with tempfile.TemporaryDirectory() as folder:
            for is_first in (True, False):
                with Server("--data", folder) as server:
                    if is_first:
                        self.assertEqual(server.put("s", file).status, 201)
                    server.ask("/v1/scenes/s?wait=30")
                    self.assertEqual(server.query("s", "closest", body).json(), {"hits": [{"t": 5}, {"t": 4}]})


if __name__ == "__main__":
    case_report.main()
