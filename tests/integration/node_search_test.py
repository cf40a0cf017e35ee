"""Nodes by name, path, material and instance; what is below each; extras on request."""

import unittest
from urllib.parse import quote

import case_report
from made_scene import triangle_glb
from sightline_server import Server, with_document

EXTRAS = {"feature": 17, "tags": ["a", "b"], "deep": {"é": 1.5}}


def house():
    """house > floor 1 > (wall of brick, wall of glass), house > roof; the roof has two instances' worth of siblings."""
    nodes = [{"name": "house", "children": [1, 2]}, {"name": "floor 1", "children": [3, 4], "extras": EXTRAS},
             {"name": "roof", "mesh": 1, "extras": "text"}, {"name": "wall", "mesh": 0}, {"name": "wall", "mesh": 1},
             {"mesh": 0, "translation": [5, 0, 0]}]

    def change(document):
        document["scenes"][0]["nodes"] = [0, 5]
        part = document["meshes"][0]["primitives"][0]
        document["materials"] = [{"name": "brick"}, {"name": "glass*"}]
        document["meshes"] = [{"primitives": [{**part, "material": 0}]}, {"primitives": [{**part, "material": 1}, part]}]

    return with_document(triangle_glb(nodes), change)


class NodeSearch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "town=demo:town")
        cls.addClassCleanup(cls.server.end)
        answer = cls.server.put("house", house())
        assert answer.status == 201, answer.body

    def nodes(self, query="", scene="house"):
        answer = self.server.ask(f"/v1/scenes/{scene}/nodes{query}")
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def ids(self, query):
        found = self.nodes(query)
        self.assertEqual(found["total"], len(found["nodes"]))
        return [node["node_id"] for node in found["nodes"]]

    def test_by_name(self):
        self.assertEqual(self.ids("?name=wall"), [3, 4])
        self.assertEqual(self.ids("?name=floor%201"), [1])
        self.assertEqual(self.ids("?name=floor+1"), [1])
        self.assertEqual(self.ids("?name=*o*"), [0, 1, 2])
        self.assertEqual(self.ids("?name="), [5])
        self.assertEqual(self.ids("?name=Wall"), [], "case matters")

    def test_by_path(self):
        self.assertEqual(self.ids("?path=/house/floor+1/*"), [3, 4])
        self.assertEqual(self.ids("?path=" + quote("/house/*")), [1, 3, 4, 2])
        self.assertEqual(self.ids("?path=" + quote("/#5")), [5])

    def test_by_material(self):
        self.assertEqual(self.ids("?material=brick"), [3, 5])
        self.assertEqual(self.ids("?material=glass*"), [4, 2])
        self.assertEqual(self.ids("?material="), [4, 2], "a primitive without a material has no name")
        self.assertEqual(self.ids("?material=glass*&name=wall"), [4], "both hold")

    def test_by_instance_is_the_node_of_a_hit(self):
        nodes = self.nodes()["nodes"]
        table = {node["first_instance"] + k: node["node_id"] for node in nodes for k in range(node["instances"])}
        self.assertEqual(table, {0: 3, 1: 4, 2: 2, 3: 5})
        for instance, node in table.items():
            self.assertEqual(self.ids(f"?instance={instance}"), [node])
        hit, = self.server.closest("house", ([5.1, 0.1, 1], [0, 0, -1]), fields=["instance", "node_id"])
        self.assertEqual(table[hit["instance"]], hit["node_id"])
        town = self.nodes("?limit=100000", "town")["nodes"]
        rays = [([x * 10 - 200, 100, z * 10 - 200], [0.1, -1, 0.1]) for x in range(40) for z in range(40)]
        table = {node["first_instance"] + k: node["node_id"] for node in town for k in range(node["instances"])}
        hits = [hit for hit in self.server.closest("town", *rays, fields=["instance", "node_id"]) if hit]
        self.assertGreater(len(hits), 400)
        for hit in hits:
            self.assertEqual(table[hit["instance"]], hit["node_id"])

    def test_children_and_triangles(self):
        counts = {node["node_id"]: (node["children"], node["instances"], node["triangles"], node["triangles_below"])
                  for node in self.nodes()["nodes"]}
        self.assertEqual(counts, {0: (2, 0, 0, 5), 1: (2, 0, 0, 3), 2: (0, 1, 2, 2), 3: (0, 1, 1, 1), 4: (0, 1, 2, 2), 5: (0, 1, 1, 1)})
        town = self.nodes("?limit=100000", "town")["nodes"]
        children, below = {}, {}
        for node in reversed(town):
            below[node["node_id"]] = node["triangles"] + sum(below[each] for each in children.get(node["node_id"], []))
            children.setdefault(node["parent"], []).append(node["node_id"])
        for node in town:
            self.assertEqual(node["children"], len(children.get(node["node_id"], [])))
            self.assertEqual(node["triangles_below"], below[node["node_id"]])

    def test_extras_paths_and_materials_on_request(self):
        for node in self.nodes()["nodes"]:
            for key in ("extras", "path", "materials"):
                self.assertNotIn(key, node)
        nodes = {node["node_id"]: node for node in self.nodes("?with=extras,path,materials")["nodes"]}
        self.assertEqual([nodes[i]["extras"] for i in range(6)], [None, EXTRAS, "text", None, None, None])
        self.assertEqual([nodes[i]["path"] for i in (0, 4, 5)], ["/house", "/house/floor 1/wall", "/#5"])
        self.assertEqual([nodes[i]["materials"] for i in (0, 2, 3)], [[], ["glass*", None], ["brick"]])
        moved = self.server.ask("/v1/scenes/house/nodes/1", "-X", "PATCH", "-H", "Content-Type: application/json", body='{"mask":3}')
        self.assertEqual(moved.status, 200, moved.body)
        self.assertEqual(self.nodes("?name=floor+1&with=extras")["nodes"][0]["extras"], EXTRAS, "also of a later revision")

    def test_matches_come_in_pages(self):
        whole = self.nodes("?name=*1*&limit=100000", "town")
        self.assertGreater(whole["total"], 100)
        paged, first = [], 0
        while first is not None:
            page = self.nodes(f"?name=*1*&first={first}&limit=37", "town")
            self.assertEqual(page["total"], whole["total"])
            paged += page["nodes"]
            first = page.get("next")
        self.assertEqual(paged, whole["nodes"])

    def test_faults(self):
        for query, words in [("?with=colour", "path, materials, extras and pose"), ("?instance=4", "4 instances"), ("?instance=-1", "instance"),
                             ("?name=%zz", "percent-encoded"), ("?names=a", "name, path, material"), ("?path=" + "a" * 4097, "4096")]:
            with self.subTest(query=query[:20]):
                answer = self.server.ask("/v1/scenes/house/nodes" + query)
                self.assertEqual((answer.status, answer.json()["code"]), (422, "QUERY_INVALID"), answer.body)
                self.assertIn(words, answer.json()["detail"])


if __name__ == "__main__":
    case_report.main()
