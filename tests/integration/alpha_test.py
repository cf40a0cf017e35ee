"""Materials that are not opaque are reported."""

import unittest

import case_report
from made_scene import triangle_glb
from sightline_server import Server, with_document

GLASS = {"KHR_materials_transmission": {"transmissionFactor": 0.5}}


class Alpha(unittest.TestCase):
    def warnings(self, materials, parts, places=1):
        """The warnings of a scene whose mesh has a triangle of each of the materials `parts`, placed so often."""
        def change(document):
            part = document["meshes"][0]["primitives"][0]
            document["materials"] = materials
            document["meshes"][0]["primitives"] = [part if each is None else {**part, "material": each} for each in parts]

        with Server() as server:
            answer = server.put("s", with_document(triangle_glb([{"mesh": 0}] * places), change))
            self.assertEqual(answer.status, 201, answer.body)
            self.assertEqual(server.ask("/v1/scenes/s").json()["warnings"], answer.json()["warnings"])
            hit, = server.closest("s", ([0.1, 0.1, 1], [0, 0, -1]))
            self.assertEqual(hit["t"], 1)
            return answer.json()["warnings"]

    def test_each_kind_has_a_warning_with_its_numbers_and_names(self):
        materials = [{"name": "leaf", "alphaMode": "MASK"}, {"name": "stone"}, {"alphaMode": "MASK"},
                     {"name": "smoke", "alphaMode": "BLEND"}, {"name": "glass", "extensions": GLASS},
                     {"name": "unused", "alphaMode": "MASK"}, {"name": "dark", "extensions": {"KHR_materials_transmission": {}}}]
        self.assertEqual(self.warnings(materials, [0, 0, 1, 2, 3, 4, 6, None], places=3), [
            'alphaMode MASK: rays hit 9 triangles of 2 materials as if opaque: "leaf", material 2',
            'alphaMode BLEND: rays hit 3 triangles of 1 material as if opaque: "smoke"',
            'KHR_materials_transmission: rays hit 3 triangles of 1 material as if opaque: "glass"'])

    def test_many_names_are_counted(self):
        materials = [{"name": f"m{i}", "alphaMode": "BLEND"} for i in range(8)]
        self.assertEqual(self.warnings(materials, range(8)), [
            'alphaMode BLEND: rays hit 8 triangles of 8 materials as if opaque: "m0", "m1", "m2", "m3", "m4" and 3 more'])

    def test_opaque_materials_have_none(self):
        self.assertEqual(self.warnings([{"name": "stone"}, {"alphaMode": "OPAQUE"}], [0, 1, None]), [])


if __name__ == "__main__":
    case_report.main()
