"""proto/openapi.json against the server: every route, every key, every field, and real answers."""

import json
import re
import unittest

import case_report
from sightline_server import SOURCE, Server, demo_glb

DOCUMENT = json.loads((SOURCE / "proto/openapi.json").read_text(encoding="utf-8"))
RAY = {"origin": [-10, 1, 0], "direction": [1, 0, 0]}
MISS = {"origin": [-10, 50, 0], "direction": [1, 0, 0]}
COLUMNS = {"origins": RAY["origin"] + MISS["origin"], "directions": RAY["direction"] * 2}
LIDAR = {"kind": "lidar", "position": [0, 1, 0], "elevations": [0, -5], "azimuths": 8, "range": [0, None]}
SENSOR = {"kind": "lidar", "firings": [[0, -5], [1, 5]], "azimuths": 4, "sector": [-30, 30], "divergence": 0.5, "samples": 3}
LENS = {"kind": "pinhole", "intrinsics": [9, 9, 4, 3], "width": 8, "height": 6, "crop": [1, 1, 3, 2],
        "extrinsic": [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 5], [0, 0, 0, 1]]}
BOX = {"min": [-10, None, -10], "max": [0, 3, 3]}
BESIDE = {"on_invalid": "mark", "work": True, "strict": False, "cull": "none", "exclude": {"names": ["nobody"]}}

# By operationId: bodies that are good, so that requests and answers can be held against their schemas. A question that is
# not listed has the example of the document.
BODIES = {
    "raysClosest": [{"rays": [RAY, MISS]}, {"rays": [RAY], "explain": True, "fields": ["t"], "cull": "back"},
                    {"rays": [MISS], "explain": True}, {"rays": [RAY], "explain": True, "include": {"names": ["nobody"]}},
                    {**{name: COLUMNS[name][:3] for name in COLUMNS}, "explain": True}, {**COLUMNS, **BESIDE}, {"generator": LIDAR},
                    {"generator": {**SENSOR, "noise": 0.1, "dropout": 0.5, "seed": 3, "returns": 2}},
                    {"generator": {"kind": "pinhole", "fov_x": 50, "width": 9, "height": 9, "pixels": [[4, 4], [8, 0]]}},
                    {"rays": [RAY, MISS], "fields": "all"}, {**COLUMNS, "fields": "all", "normalize": True},
                    {"rays": [RAY, MISS], "fields": ["t", "_TEMPERATURE"]}, {**COLUMNS, "fields": ["_A.b", "uv"]},
                    {**COLUMNS, "mask": 3, "masks": [1, 2]}, {"rays": [{**RAY, "mask": 4}]}],
    "raysAny": [{"rays": [RAY, MISS]}, {"generator": {"kind": "pinhole", "width": 3, "height": 2}, **BESIDE}],
    "raysAll": [{"rays": [RAY, MISS], "max_hits": 2, "crossings": "once"}, {**COLUMNS, "fields": "all"}],
    "raysCount": [{"rays": [RAY, MISS], **BESIDE}],
    "raysGenerate": [{"generator": LIDAR}, {"generator": SENSOR}, {"generator": LENS}, {"generator": {"kind": "hemisphere", "points": [[0, 0, 0]], "normals": [[0, 1, 0]],
                                                          "count": 3, "seed": 9, "distribution": "uniform"}},
                     {"generator": {"kind": "orthographic", "extent_y": 2, "width": 2, "height": 2, "look_at": [1, 0, 0]}},
                     {"generator": {"kind": "equirectangular", "width": 2, "height": 2, "up": [0, 0, 1], "forward": [1, 0, 0]}}],
    "visibility": [{"from": [RAY["origin"]], "to": [[0, 1, 0], [-8, 1, 0]]},
                   {"from": [RAY["origin"]], "to": [[0, 1, 0]], "pairing": "each", "first_blocker": True, "fields": ["t"], "work": True}],
    "pointsInside": [{"points": [[0, 1, 0], [-5.5, 1, 0]]}, {"points": [[0, 1, 0]], "method": "winding", "work": True,
                                                           "include": {"materials": ["*"]}}],
    "pointsClosest": [{"points": [[0, 1, 0], [90, 0, 0]], "max_distance": 9}, {"points": [[0, 1, 0]], "fields": "all", "work": True}],
    "pointsNearest": [{"points": [[0, 1, 0]], "count": 3, "fields": "all"}, {"points": [], "exclude": {"names": ["left"]}}],
    "pointsDistance": [{"points": [[0, 1, 0], [90, 0, 0]], "max_distance": 9, "method": "winding"}, {"points": [], "work": True}],
    "clearance": [{"a": {"names": ["left"]}, "b": {"nodes": [2]}}, {"a": {"names": ["left"]}, "b": {"names": ["nobody"]}, "max_distance": None},
                  {"a": {"names": ["left"]}, "b": {"names": ["right"]}, "max_distance": 3, "pairs": "triangles", "limit": 2, "work": True},
                  {"a": {"names": ["left"]}, "b": {"names": ["right"]}, "max_distance": 3, "pairs": "nodes", "exclude": {"materials": ["?"]}}],
    "sweepsClosest": [{"sweeps": [{**RAY, "radius": 0.5}, {**MISS, "half": [1, 0, 1], "tmax": None}], "work": True},
                      {"sweeps": [{**RAY, "radius": 0.5, "tmin": 4}, {**RAY, "half": [1, 0, 1], "rotation": [0, 0, 0, 1]},
                                  {"from": [-10, 1, 0], "to": [-9, 1, 1], "direction": [1, 0, 0], "radius": 0}], "fields": ["normal"]},
                      {"sweeps": [{**RAY, "half": [1, 1, 1], "tmin": -1, "tmax": 9}], "fields": ["t", "distance", "node_path", "material"],
                       "exclude": {"names": ["right"]}}],
    "sweepsAny": [{"sweeps": [{**RAY, "radius": 0.5}], "include": {"nodes": [1]}}],
    "raysBoxes": [{"rays": [RAY, MISS], "boxes": [BOX, {"center": [0, 1, 0], "half": [1, None, 1], "rotation": [0, 0, 0, 1]}],
                   "pairing": "all", "planes": True}],
    "boxesAny": [{"boxes": [BOX, {"center": [0, 1, 0], "radius": 2}, {"planes": [[0, 1, 0, 3], [1, 0, 0, 0]]},
                            {"view": {"kind": "pinhole", "width": 4, "height": 3}},
                            {"corners": [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]}]}],
    "boxesList": [{"boxes": [BOX], "limit": 2}, {"boxes": [BOX], "of": "nodes"}],
    "boxesCount": [{"boxes": [BOX], "of": "nodes"}, {"boxes": [{"from": [0, 0, 0], "to": [0, 4, 0], "radius": 2}], "mode": "contained"}],
}
GETS = {"listScenes": "/v1/scenes", "getScene": "/v1/scenes/six", "sceneStats": "/v1/scenes/six/stats",
        "sceneNodes": "/v1/scenes/six/nodes?limit=2&with=pose", "sceneAnimations": "/v1/scenes/six/animations", "sceneTriangles": "/v1/scenes/six/triangles?ids=0.0.1",
        "sceneGeometry": "/v1/scenes/six/geometry", "sceneTrees": "/v1/scenes/six/bvh?level=1", "selfCheck": "/v1/scenes/six/selfcheck?rays=3", "health": "/healthz", "readiness": "/readyz", "version": "/version",
        "openapi": "/openapi.json", "page": "/", "pageScript": "/page.js", "pageStyle": "/page.css", "bootScript": "/boot.js", "statusPage": "/status", "statusScript": "/status.js",
        "document": "/docs/README.md", "documents": "/docs/documents.json.gz", "guideScript": "/guide.js", "learn": "/learn", "learnScript": "/learn.js", "docs": "/docs", "docsScript": "/docs/app.js", "docsStyle": "/docs/style.css", "metrics": "/metrics"}
# What has no answer to be held against a schema here.
OTHERS = {"getJob", "deleteJob", "jobResult", "sceneEvents", "putScene", "loadScene", "deleteScene", "patchNode", "deleteNode", "patchNodes"}

# Every keyword that the document uses must be one that `faults` knows, or says nothing of what is good.
KNOWN = {"$ref", "type", "enum", "const", "anyOf", "oneOf", "properties", "required", "additionalProperties", "patternProperties", "minProperties",
         "items", "prefixItems", "minItems", "maxItems", "uniqueItems", "minimum", "maximum", "exclusiveMinimum",
         "exclusiveMaximum", "maxLength", "pattern", "default", "description"}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}


def resolve(schema):
    while "$ref" in schema:
        name = schema["$ref"].removeprefix("#/components/schemas/")
        schema = DOCUMENT["components"]["schemas"][name]
    return schema


def is_type(value, name):
    if name in ("number", "integer"):
        return isinstance(value, (int, float)) and not isinstance(value, bool) and (name == "number" or value == int(value))
    return isinstance(value, TYPES[name])


def faults(value, schema, place=""):
    """What of `value` is not as `schema` says: the part of JSON Schema that the document uses."""
    schema = resolve(schema)
    assert set(schema) <= KNOWN, set(schema) - KNOWN
    for word, fewest in (("anyOf", 1), ("oneOf", 1)):
        if word in schema:
            good = [not faults(value, each, place) for each in schema[word]]
            if sum(good) < fewest or (word == "oneOf" and sum(good) > 1):
                return [f"{place}: {sum(good)} of {word} match {value!r:.80}"]
    found = []
    types = schema.get("type", [])
    if types and not any(is_type(value, each) for each in ([types] if isinstance(types, str) else types)):
        return [f"{place}: {value!r:.80} is no {types}"]
    if value not in schema.get("enum", [value]) or value != schema.get("const", value):
        found.append(f"{place}: {value!r:.80} is none of the words")
    if isinstance(value, str) and not re.search(schema.get("pattern", ""), value):
        found.append(f"{place}: {value!r:.80} does not match {schema['pattern']}")
    if isinstance(value, dict):
        properties, more = schema.get("properties", {}), schema.get("additionalProperties", True)
        patterns = schema.get("patternProperties", {})
        found += [f"{place}: no {name}" for name in schema.get("required", []) if name not in value]
        if len(value) < schema.get("minProperties", 0):
            found.append(f"{place}: too few members")
        for name, member in value.items():
            matching = [each for pattern, each in patterns.items() if re.search(pattern, name)]
            if name in properties or matching:
                for each in [properties[name]] if name in properties else matching:
                    found += faults(member, each, f"{place}/{name}")
            elif more is False:
                found.append(f"{place}: {name} is not in the schema")
            elif isinstance(more, dict):
                found += faults(member, more, f"{place}/{name}")
    elif isinstance(value, list):
        if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
            found.append(f"{place}: {len(value)} elements")
        first = schema.get("prefixItems", [])
        for i, element in enumerate(value):
            rest = schema.get("items", {})
            if i >= len(first) and rest is False:
                found.append(f"{place}: too many elements")
            else:
                found += faults(element, first[i] if i < len(first) else rest, f"{place}/{i}")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        if not schema.get("minimum", value) <= value <= schema.get("maximum", value):
            found.append(f"{place}: {value} is out of range")
    return found


def words_of(name):
    """The fields that a schema lists by name."""
    schema = DOCUMENT["components"]["schemas"][name]
    return schema.get("anyOf", [schema])[0]["enum"]


QUESTIONS = json.loads((SOURCE / "proto/questions.json").read_text(encoding="utf-8"))
for question in QUESTIONS:
    content = DOCUMENT["paths"][question["path"]]["post"]["requestBody"]["content"]["application/json"]
    BODIES.setdefault(question["operation"], [content["example"]])


def operations():
    for path, item in DOCUMENT["paths"].items():
        for method, operation in item.items():
            if method != "parameters":
                yield method.upper(), path, operation


class OpenApi(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six")
        cls.addClassCleanup(cls.server.end)
        cls.fields = words_of("Field")

    def post(self, path, body):
        path = path.replace("{id}", "six")
        return self.server.ask(path, "-H", "Content-Type: application/json", body=json.dumps(body))

    def test_every_route_is_in_the_document_and_the_other_way_round(self):
        added = set()
        for file in (SOURCE / "server").rglob("*.cpp"):
            added |= set(re.findall(r'\badd\(\s*"([A-Z]+)",\s*"(/[^"]*)"', file.read_text(encoding="utf-8")))
        self.assertEqual(added, {(method, path) for method, path, _ in operations()})

    def test_every_operation_is_tried_here(self):
        names = {operation["operationId"] for _, _, operation in operations()}
        self.assertEqual(names, set(BODIES) | set(GETS) | OTHERS)

    def test_every_key_is_in_the_document_and_the_other_way_round(self):
        for method, path, operation in operations():
            if method != "POST":
                continue
            with self.subTest(path=path):
                schema = resolve(operation["requestBody"]["content"]["application/json"]["schema"])
                detail = self.post(path, {"?": 1}).json()["detail"]
                known = re.search(r"(?:known here:|there are) (.*)$", detail).group(1).split(", ")
                self.assertEqual(set(known), set(schema["properties"]))

    def test_every_field_is_in_the_document_and_the_other_way_round(self):
        detail = self.post("/v1/scenes/{id}/rays:closest", {"rays": [], "fields": ["?"]}).json()["detail"]
        self.assertEqual(detail.split("known: ")[1].split(", "), [*self.fields, "_NAME"])
        detail = self.post("/v1/scenes/{id}/points:closest", {"points": [], "fields": ["?"]}).json()["detail"]
        self.assertEqual(detail.split("known: ")[1].split(", "), [*words_of("NearestField"), "_NAME"])
        detail = self.post("/v1/scenes/{id}/sweeps:closest", {"sweeps": [], "fields": ["?"]}).json()["detail"]
        self.assertEqual(detail.split("known: ")[1].split(", "), words_of("ContactField"))
        for name in ("Hit", "HitColumns", "HitListColumns"):
            self.assertLessEqual(set(self.fields), set(DOCUMENT["components"]["schemas"][name]["properties"]))

    def test_requests_and_answers_are_as_the_document_says(self):
        for method, path, operation in operations():
            for body in BODIES.get(operation["operationId"], []):
                if body.get("fields") == "all":
                    of_point = path.split("/")[-1].startswith("points:")
                    fields = [name for name in self.fields if not of_point or name not in ("t", "cost_nodes", "cost_blocks")]
                    body = {**body, "fields": fields}
                with self.subTest(path=path, body=body):
                    self.assertEqual(faults(body, operation["requestBody"]["content"]["application/json"]["schema"]), [])
                    answer = self.post(path, body)
                    self.assertEqual(answer.status, 200, answer.body)
                    schema = operation["responses"]["200"]["content"]["application/json"]["schema"]
                    self.assertEqual(faults(answer.json(), schema), [])
            if operation["operationId"] in GETS:
                with self.subTest(path=path):
                    answer = self.server.ask(GETS[operation["operationId"]])
                    (kind, content), = operation["responses"]["200"]["content"].items()
                    self.assertEqual(answer.headers["content-type"].split(";")[0], kind)
                    if kind == "application/json":
                        self.assertEqual(faults(answer.json(), content["schema"]), [])

    def test_every_question_has_an_example_that_is_answered(self):
        for method, path, operation in operations():
            if operation["operationId"] not in BODIES:
                continue
            with self.subTest(path=path):
                content = operation["requestBody"]["content"]["application/json"]
                self.assertEqual(faults(content["example"], content["schema"]), [])
                answer = self.post(path, content["example"])
                self.assertEqual(answer.status, 200, answer.body)

    def test_every_question_about_a_scene_or_boxes_knows_how_long_its_answer_may_take(self):
        knowing = set()
        for _, path, operation in operations():
            name = operation["operationId"]
            if name not in BODIES or "timeout_ms" not in resolve(
                    operation["requestBody"]["content"]["application/json"]["schema"])["properties"]:
                continue
            knowing.add(name)
            body = {key: value for key, value in BODIES[name][0].items() if key != "fields"}
            with self.subTest(path=path):
                answer = self.post(path, {**body, "timeout_ms": 0})
                self.assertEqual((answer.status, answer.json()["code"]), (504, "DEADLINE"))
                self.assertEqual(set(answer.json()) & {"hits", "results", "totals"}, set())
                patient = self.post(path, {**body, "timeout_ms": 86400000, **({"work": False} if "work" in body else {})})
                plain = self.post(path, {**body, **({"work": False} if "work" in body else {})})
                self.assertEqual((patient.status, patient.body), (200, plain.body))
                for bad, code in ((-1, "NUMBER_OUT_OF_RANGE"), (86400001, "NUMBER_OUT_OF_RANGE"), ("1", "TYPE_WRONG")):
                    refused = self.post(path, {**body, "timeout_ms": bad}).json()
                    self.assertEqual((refused["code"], refused["errors"][0]["pointer"]), (code, "/timeout_ms"))
        self.assertEqual(knowing, set(BODIES) - {"raysGenerate"})

    def test_scenes_come_and_go_as_the_document_says(self):
        schema = {"$ref": "#/components/schemas/Scene"}
        for status in (201, 200):
            put = self.server.put("other", demo_glb("six"))
            self.assertEqual((put.status, faults(put.json(), schema)), (status, []))
        self.assertEqual(self.server.ask("/v1/scenes/other", "-X", "DELETE").status, 204)
        refused = self.post("/v1/scenes", {"id": "x", "source": {"path": "x.glb"}})
        self.assertEqual((refused.status, faults(refused.json(), {"$ref": "#/components/schemas/Problem"})), (403, []))

    def test_problems_are_as_the_document_says(self):
        schema = {"$ref": "#/components/schemas/Problem"}
        for path, body in [("/v1/scenes/{id}/rays:any", {"rays": [{}]}), ("/v1/scenes/none/rays:any", {"rays": []}), ("/none", {}),
                           ("/v1/scenes/{id}/visibility", {"from": 1})]:
            with self.subTest(path=path):
                problem = self.post(path, body)
                self.assertGreaterEqual(problem.status, 400)
                self.assertEqual(faults(problem.json(), schema), [])

    def test_codes_are_some_that_the_sources_have(self):
        quoted = set()
        for room in ("core", "proto", "server"):
            for file in (SOURCE / room).rglob("*"):
                if file.suffix in (".h", ".cpp"):
                    quoted |= set(re.findall(r'"([A-Z][A-Z0-9_]+)"', file.read_text(encoding="utf-8")))
        for owner in (DOCUMENT["components"]["responses"]["Fault"], *DOCUMENT["tags"]):
            listed = [name for names in owner.get("x-codes", {}).values() for name in names]
            self.assertEqual(set(listed) - quoted, set())

    def test_faults_have_codes_that_the_document_lists(self):
        tags = {tag["name"]: tag for tag in DOCUMENT["tags"]}
        every = DOCUMENT["components"]["responses"]["Fault"]["x-codes"]
        triple = {"origin": [0, 0, 0], "direction": [0, 0, 0]}
        for tag, path, body in [("rays", "rays:any", {"rays": [triple]}), ("rays", "rays:any", {"rays": 1}), ("rays", "rays:any", {}),
                                ("rays", "rays:closest", {"rays": [RAY], "fields": []}), ("rays", "rays:any", {"rays": [RAY], "?": 1}),
                                ("rays", "rays:closest", {"rays": [RAY, RAY], "explain": True}),
                                ("points", "visibility", {"from": [[0, 0, 0]], "to": [], "pairing": "each"}),
                                ("points", "points:nearest", {"points": [[0, 0, 0]], "count": 0}),
                                ("boxes", "boxes:any", {"boxes": [{"min": [1, 0, 0], "max": [0, 0, 0]}]}),
                                ("boxes", "boxes:any", {"boxes": [{"center": [0, 0, 0], "radius": -1}]}),
                                ("clearance", "clearance", {"a": {"nodes": [999]}, "b": {"nodes": [0]}}),
                                ("clearance", "clearance", {"a": {"nodes": [0]}, "b": {"nodes": [0]}, "pairs": "nodes"}),
                                ("sweeps", "sweeps:any", {"sweeps": [{**RAY, "radius": -1}]})]:
            with self.subTest(path=path, body=body):
                fault = self.post("/v1/scenes/{id}/" + path, body)
                status, code = str(fault.status), fault.json()["code"]
                self.assertIn(code, every.get(status, []) + tags[tag]["x-codes"].get(status, []))
        for path in ("/v1/scenes/none", "/v1/scenes/six/triangles?ids=9.9.9", "/v1/scenes/six/triangles?ids=x", "/v1/scenes/six?wait=x", "/none"):
            fault = self.server.ask(path)
            status, code = str(fault.status), fault.json()["code"]
            self.assertIn(code, every.get(status, []) + tags["scenes"]["x-codes"].get(status, []))

    def test_the_server_shows_this_very_document(self):
        self.assertEqual(self.server.ask("/openapi.json").json(), DOCUMENT)


if __name__ == "__main__":
    case_report.main()
