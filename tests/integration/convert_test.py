"""sightline convert: triangles of six formats, written here, against the GLB, read here; limits of memory and time."""

import collections
import io
import json
import re
import shutil
import struct
import subprocess
import tempfile
import unittest
import zipfile
from pathlib import Path

import case_report
from sightline_server import BINARY, PATIENCE, SOURCE, Server

CONVERTER = Path(BINARY).resolve().with_name("sightline-convert")
# A pyramid on a step: corners are dyadic, so that their text is exact.
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 0, 2), (0, 0, 2), (1, 1.75, 1), (0.5, -0.25, 0.125), (-3.5, 0.0625, 4)]
FACES = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (2, 1, 0), (3, 2, 0), (0, 5, 6), (6, 5, 1)]


def words(numbers):
    return " ".join(f"{x:g}" for x in numbers)


def obj():
    return "".join(f"v {words(c)}\n" for c in CORNERS) + "".join("f " + words(i + 1 for i in f) + "\n" for f in FACES)


def ply():
    head = (f"ply\nformat ascii 1.0\nelement vertex {len(CORNERS)}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {len(FACES)}\nproperty list uchar int vertex_indices\nend_header\n")
    return head + "".join(words(c) + "\n" for c in CORNERS) + "".join(f"3 {words(f)}\n" for f in FACES)


def stl():
    """Binary."""
    return bytes(80) + struct.pack("<I", len(FACES)) + b"".join(
        struct.pack("<12fH", 0, 0, 1, *(x for i in face for x in CORNERS[i]), 0) for face in FACES)


def dae():
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="{3 * len(CORNERS)}">{words(x for c in CORNERS for x in c)}</float_array>
<technique_common><accessor source="#a" count="{len(CORNERS)}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{len(FACES)}"><input semantic="VERTEX" source="#v" offset="0"/><p>{words(i for f in FACES for i in f)}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n" name="hut"><translate>0.5 0 -8</translate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def fbx():
    flat = ",".join(f"{x:g}" for c in CORNERS for x in c)
    # The last corner of a polygon is written as its complement.
    corners = ",".join(f"{a},{b},{-c - 1}" for a, b, c in FACES)
    return f"""; FBX 7.4.0 project file
FBXHeaderExtension:  {{
    FBXHeaderVersion: 1003
    FBXVersion: 7400
}}
GlobalSettings:  {{
    Version: 1000
    Properties70:  {{
        P: "UpAxis", "int", "Integer", "",1
        P: "UnitScaleFactor", "double", "Number", "",1
    }}
}}
Objects:  {{
    Geometry: 100, "Geometry::", "Mesh" {{
        Vertices: *{3 * len(CORNERS)} {{
            a: {flat}
        }}
        PolygonVertexIndex: *{3 * len(FACES)} {{
            a: {corners}
        }}
        GeometryVersion: 124
    }}
    Model: 200, "Model::hut", "Mesh" {{
        Version: 232
    }}
}}
Connections:  {{
    C: "OO",200,0
    C: "OO",100,200
}}
"""


def threemf():
    model = ('<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>'
             '<object id="1" type="model"><mesh><vertices>' + "".join(f'<vertex x="{x:g}" y="{y:g}" z="{z:g}"/>' for x, y, z in CORNERS)
             + "</vertices><triangles>" + "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in FACES)
             + '</triangles></mesh></object></resources><build><item objectid="1"/></build></model>')
    types = ('<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" '
             'ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" '
             'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')
    links = ('<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
             'Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>')
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("[Content_Types].xml", types)
        archive.writestr("_rels/.rels", links)
        archive.writestr("3D/3dmodel.model", model)
    return file.getvalue()


FORMATS = {".obj": obj, ".ply": ply, ".stl": stl, ".dae": dae, ".fbx": fbx, ".3mf": threemf}


def multiply(a, b):
    """Of matrices column by column."""
    return [sum(a[4 * k + row] * b[4 * column + k] for k in range(4)) for column in range(4) for row in range(4)]


def triangles_of(glb):
    """The triangles in the world, each three corners, from its least one on; how often each is there."""
    length, = struct.unpack_from("<I", glb, 12)
    document, data = json.loads(glb[20:20 + length]), glb[28 + length:]

    def read(accessor):
        each = document["accessors"][accessor]
        view = document["bufferViews"][each["bufferView"]]
        kind, width = {5126: "f", 5125: "I", 5123: "H", 5121: "B"}[each["componentType"]], {"SCALAR": 1, "VEC3": 3}[each["type"]]
        stride = view.get("byteStride") or width * struct.calcsize(kind)
        at = view.get("byteOffset", 0) + each.get("byteOffset", 0)
        return [struct.unpack_from(f"<{width}{kind}", data, at + i * stride) for i in range(each["count"])]

    found = collections.Counter()

    def walk(number, above):
        node = document["nodes"][number]
        assert not node.keys() & {"rotation", "scale", "translation"}
        world = multiply(above, node["matrix"]) if "matrix" in node else above
        if "mesh" in node:
            for part in document["meshes"][node["mesh"]]["primitives"]:
                assert part.get("mode", 4) == 4
                places = [tuple(sum(world[4 * k + row] * p[k] for k in range(3)) + world[12 + row] for row in range(3))
                          for p in read(part["attributes"]["POSITION"])]
                corners = [index for index, in read(part["indices"])]
                for i in range(0, len(corners), 3):
                    three = [places[k] for k in corners[i:i + 3]]
                    first = three.index(min(three))
                    found[tuple(three[first:] + three[:first])] += 1
        for child in node.get("children", []):
            walk(child, world)

    for root in document["scenes"][document.get("scene", 0)]["nodes"]:
        walk(root, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    return found


def expected(offset=(0, 0, 0)):
    found = collections.Counter()
    for face in FACES:
        three = [tuple(float(a + b) for a, b in zip(CORNERS[i], offset)) for i in face]
        first = three.index(min(three))
        found[tuple(three[first:] + three[:first])] += 1
    return found


class Base(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_convert(self, *arguments, binary=BINARY):
        return subprocess.run([binary, "convert", *map(str, arguments)], capture_output=True, text=True, timeout=PATIENCE, check=False)

    def file(self, name, content):
        file = self.folder / name
        file.write_bytes(content.encode() if isinstance(content, str) else content)
        return file


@unittest.skipUnless(CONVERTER.exists(), "sightline-convert is not built: assimp is not installed")
class Convert(Base):
    def test_triangles_are_those_of_the_file(self):
        with Server() as server:
            for ending, make in FORMATS.items():
                for name in ("a" + ending, "B" + ending.upper()):
                    with self.subTest(name=name):
                        out = self.folder / "out.glb"
                        done = self.run_convert(self.file(name, make()), out)
                        self.assertEqual((done.returncode, done.stdout), (0, f"{out}: {len(FACES)} triangles\n"), done.stderr)
                        self.assertEqual(triangles_of(out.read_bytes()), expected((0.5, 0, -8) if ending == ".dae" else (0, 0, 0)))
                        answer = server.put("s" + ending[1:], out.read_bytes())
                        self.assertIn(answer.status, (200, 201), answer.body)
                        self.assertEqual(answer.json()["counts"]["triangles"], len(FACES))

    def test_the_line_of_the_guide_makes_its_file(self):
        (line,) = re.findall(r"^ {4}sightline convert (.*)$", (SOURCE / "docs/guides/convert.md").read_text(encoding="utf-8"), re.MULTILINE)
        source, out = line.split()
        self.file(source, fbx())
        done = self.run_convert(self.folder / source, self.folder / out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(triangles_of((self.folder / out).read_bytes()), expected())

    def test_what_cannot_be_read_is_told_and_leaves_nothing(self):
        out = self.folder / "out.glb"
        for name, content, text in (("a.txt", "x", "must end with"), ("a.glb", b"glTF", "must end with"), ("a.obj", "", "a.obj"),
                                    ("a.ply", "ply\nformat nothing\n", "a.ply"), ("p.obj", "v 0 0 0\np 1\n", "p.obj"), ("a.3mf", b"PK", "a.3mf")):
            with self.subTest(name=name):
                done = self.run_convert(self.file(name, content), out)
                self.assertEqual((done.returncode, done.stdout), (2, ""))
                self.assertIn(text, done.stderr)
                self.assertEqual([each.name for each in self.folder.iterdir() if "out" in each.name], [])
        for name in ("in.obj", "out.gltf", "keep.txt"):  # The name of the output says GLB, so no input is overwritten.
            self.file("in.obj", obj())
            done = self.run_convert(self.folder / "in.obj", self.folder / name)
            self.assertEqual(done.returncode, 2)
            self.assertIn("must end with .glb", done.stderr)
            self.assertEqual((self.folder / "in.obj").read_text(), obj())
        self.assertIn("missing.obj", self.run_convert(self.folder / "missing.obj", out).stderr)
        self.assertEqual(self.run_convert(self.file("a.obj", obj()), self.folder / "no" / "out.glb").returncode, 2)

    def test_memory_and_time_are_limited(self):
        out = self.folder / "out.glb"
        many = "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * 3_000_000
        large = self.file("large.obj", many)
        done = self.run_convert(large, out, "--memory-mib", 200)
        self.assertEqual((done.returncode, done.stderr), (2, "sightline-convert: the memory is used up (--memory-mib)\n"))
        self.assertFalse(out.exists())
        done = self.run_convert(large, out, "--seconds", 1)
        self.assertEqual((done.returncode, done.stderr), (2, "sightline-convert: the time is used up (--seconds)\n"))
        self.assertFalse(out.exists())


class Apart(Base):
    def test_the_server_does_not_link_assimp(self):
        self.assertNotIn("assimp", subprocess.run(["ldd", BINARY], capture_output=True, text=True, check=True).stdout)

    def test_without_the_converter_it_says_what_to_do(self):
        alone = Path(shutil.copy(BINARY, self.folder / "sightline"))
        done = self.run_convert("a.obj", "b.glb", binary=alone)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, re.escape("sightline-convert") + ".*libassimp")


if __name__ == "__main__":
    case_report.main()
