#!/usr/bin/env python3
"""Writes or checks what is derived from the tables of fields and questions.

Usage: scripts/describe.py [--write] [ROOT]

proto/hit_fields.def has one row for each field of a hit, proto/questions.json one for each question. From these come:

  docs/reference/fields.md   the table under "Fields of a hit"
  docs/reference/routes.md   the rows of the questions
  proto/openapi.json         Field, NearestField, ContactField, EndField, and the properties of Hit, HitColumns and HitListColumns
  proto/python/sightline.py  the constants TEXTS, _WIDTHS, _DISTANCES and _FLAGS
  proto/python/README.md     the rows of the table under "Columns"
  server/page/app/src        the list of fields

--write rewrites them. Without it, the script prints each place that differs and fails. Both check that
docs/reference/errors.md has each error code of the source and no other, with the status of its kind. They also check that each question
agrees with openapi.json (path, operation, keys, answer, layouts), has a route in the server, and has its method in the
Python client. The tools of MCP and the flags of the command line are made from openapi.json and hit_fields.def when
the program runs.
"""

import json
import re
import sys
from pathlib import Path

ROW = re.compile(r'^HIT_FIELD\((\w+), "(\w+)", k(\w+), (\d), k(\w+), "((?:[^"\\]|\\.)*)"\)$', re.MULTILINE)
MEDIA = {"application/json": "json", "application/octet-stream": "binary", "application/x-ndjson": "lines",
         "image/png": "png", "image/x-portable-floatmap": "pfm", "text/csv": "csv", "application/x-ply": "ply",
         "application/x-pcd": "pcd", "application/x-npy": "npy", "application/x-npz": "npz"}
NO_NEAREST = {"t"}
# The method of the Python client for each route that is no question; pages have none.
CLIENT_ROUTES = {"listScenes": "scenes", "loadScene": "load", "getScene": "scene", "putScene": "put", "deleteScene": "delete",
                 "sceneEvents": "events", "getJob": "job", "deleteJob": "delete_job", "jobResult": "job_result", "sceneStats": "stats", "sceneNodes": "nodes", "sceneAnimations": "animations", "patchNode": "patch_node", "deleteNode": "remove_node", "patchNodes": "patch_nodes",
                 "sceneTriangles": "triangles", "sceneGeometry": "geometry", "sceneTrees": "bvh", "selfCheck": "selfcheck",
                 "health": "health", "readiness": "ready", "version": "version", "metrics": "metrics", "openapi": "openapi"}
# Texts of the source that have the form of error codes.
NO_CODES = {"COLOR_0", "TEXCOORD_0", "TEXCOORD_1", "SIGHTLINE_KEY", "OPEN_EDGES",
            "AWS_ACCESS_KEY_ID", "AWS_ENDPOINT_URL", "AWS_REGION", "AWS_SECRET_ACCESS_KEY", "AWS_SESSION_TOKEN"}
CODE = r'"([A-Z][A-Z0-9]+(?:_[A-Z0-9]+)+)"'
KIND = re.compile(r'ErrorKind::(k\w+),\s*"([A-Z][A-Z0-9_]+)"')
# What core/base/result.h says of each kind. A deadline of a body is 408, one of an answer 504.
STATUS = {"kInvalid": "422", "kMalformed": "400", "kUnsupported": "415", "kTooLarge": "413", "kNotFound": "404", "kConflict": "409",
          "kPrecondition": "412", "kBusy": "503", "kOutOfSpace": "507", "kInternal": "500"}
# Answered with 403 by the routes.
FORBIDDEN = {"PATH_NOT_ALLOWED", "PATH_REFUSED"}
QUESTION = ("operation", "path", "keys", "answer", "layouts", "python", "doc")


class Field:
    def __init__(self, row):
        self.enumerator, self.name, self.kind, width, self.source, self.doc = row
        self.width = int(width)

    def row_schema(self):
        """The schema of a value in a row of JSON."""
        if self.kind == "Vector":
            if self.width == 3 and self.source != "Attribute":
                vector = {"$ref": "#/components/schemas/Vector"}
                return {"anyOf": [vector, {"type": "null"}]} if self.name == "normal" else vector
            kind = ["array", "null"] if self.source == "Attribute" else "array"
            schema = {"type": kind, "items": {"type": "number"}, "minItems": self.width, "maxItems": self.width}
            return {**schema, "description": self.doc.removesuffix("; see below").replace("`", "")}
        return {"Number": {"type": ["number", "null"]}, "Index": {"type": "integer", "minimum": 0},
                "Id": {"type": ["integer", "null"]}, "Flag": {"type": "boolean"}, "Text": {"type": ["string", "null"]}}[self.kind]

    def column_schema(self):
        kind = {"Number": {"type": ["number", "null"]}, "Vector": {"type": ["number", "null"]}, "Index": {"type": "integer", "minimum": -1},
                "Id": {"type": "integer", "minimum": -1}, "Flag": {"type": ["boolean", "null"]}, "Text": {"type": ["string", "null"]}}[self.kind]
        return {"type": "array", "items": kind}


class Description:
    def __init__(self, root):
        self.root = root
        self.fields = [Field(row) for row in ROW.findall(self.read("proto/hit_fields.def"))]
        self.own = [each for each in self.fields if each.kind != "Named"]  # Names of files are no words of a list.
        self.questions = json.loads(self.read("proto/questions.json"))
        self.faults = []

    def read(self, name):
        return (self.root / name).read_text(encoding="utf-8")

    def replaced(self, name, text, pattern, replacement):
        """`text` with the only match of `pattern` replaced: its first group stays before, its last behind."""
        found, count = re.subn(pattern, lambda match: match.group(1) + replacement + match.group(match.re.groups), text, flags=re.DOTALL)
        if count != 1:
            self.faults.append(f"{name}: {count} places match {pattern!r}")
        return found

    def fields_page(self, text):
        rows = "".join(f"| `{each.name}` | {each.doc.replace('|', chr(92) + '|')} |\n" for each in self.fields)
        return self.replaced("fields.md", text, r"(\| field \| what it is \|\n\|---\|---\|\n)(?:\|[^\n]*\n)+(\n)", rows)

    def routes_page(self, text):
        rows = "".join(f"| `POST {each['path']}` | {each['doc']} |\n" for each in self.questions)
        return self.replaced("routes.md", text, r"(\n)(?:\| `POST /v1/(?:scenes/\{id\}/[a-z]|rays)[^\n]*\n)+(\| `GET)", rows)

    def openapi(self, text):
        def properties(schemas):
            return ",\n".join(f'          "{each.name}": {json.dumps(schema)}' for each, schema in schemas)

        rows = properties((each, each.row_schema()) for each in self.own)
        columns = properties((each, each.column_schema()) for each in self.own)
        name = "openapi.json"
        text = self.replaced(name, text, r'(\n      "Hit": \{\n.*?"properties": \{\n).*?(\n        \},)', rows)
        text = self.replaced(name, text, r'(\n      "HitColumns": \{\n.*?"properties": \{\n).*?(,\n          "explain")', columns)
        text = self.replaced(name, text, r'(\n      "HitListColumns": \{\n.*?"first": \{[^\n]*\},\n).*?(,\n          "invalid")', columns)
        # A contact has no detail but its position and normal, and a point has no ray.
        contact = [each.name for each in self.fields if each.source in ("Ray", "Scene") or each.name in ("position", "normal")]
        end = [each.name for each in self.fields if each.source == "Scene" or each.name in ("instance", "position")]
        for schema, names in (("Field", [each.name for each in self.own]), ("ContactField", contact), ("EndField", end),
                              ("NearestField", [each.name for each in self.own if each.name not in NO_NEAREST and each.source != "Cost"])):
            text = self.replaced(name, text, rf'(\n      "{schema}": \{{\n[^\]]*?"type": "string",\s*"enum": \[).*?(\])', self.wrapped(names))
        return text

    def wrapped(self, names):
        lines = [""]
        for each in names:
            item = f'"{each}", ' if each != names[-1] else f'"{each}"'
            if len(lines[-1]) + len(item) > 100:
                lines.append("")
            lines[-1] += item
        return ("\n" + " " * 17).join(line.rstrip() for line in lines)

    def client(self, text):
        def names(chosen):
            return "{" + ", ".join(f'"{each.name}"' for each in self.fields if chosen(each)) + "}"

        widths = "{" + ", ".join(f'"{each.name}": {each.width}' for each in self.own if each.width > 1) + "}"
        text = self.replaced("sightline.py", text, r"(\nTEXTS = ).*?(\n)", names(lambda each: each.kind == "Text"))
        text = self.replaced("sightline.py", text, r"(\n_WIDTHS = ).*?(\n)", widths)
        text = self.replaced("sightline.py", text, r"(\n_DISTANCES = ).*?(\n)", names(lambda each: each.kind == "Number"))
        return self.replaced("sightline.py", text, r"(\n_FLAGS = ).*?( \| \{)", names(lambda each: each.kind == "Flag"))

    def client_page(self, text):
        def row(chosen, rest):
            return "| " + ", ".join(f"`{each.name}`" for each in self.fields if chosen(each)) + f" | {rest} |\n"

        rows = row(lambda each: each.kind == "Number", "float64 | one number for each row | inf")
        for width in sorted({each.width for each in self.fields if each.kind == "Vector"}, key=lambda width: (width != 3, width)):
            rows += row(lambda each, width=width: each.kind == "Vector" and each.width == width, f"float64 | and an axis of {width} | NaN")
        rows += row(lambda each: each.kind == "Named", "float64 | one number for each row, or an axis of 2 to 4 | NaN")
        rows += row(lambda each: each.kind in ("Index", "Id"), "int64 | one number for each row | -1")
        rows += row(lambda each: each.kind == "Flag", "bool | one flag for each row | False")
        rows += row(lambda each: each.kind == "Text", "nested lists of `str` or None, never arrays | one text for each row | None")
        return self.replaced("README.md", text, r"(\| columns \| type [^\n]*\n\|[-|]*\n).*?(\| `hit` \|)", rows)

    def page(self, text):
        # A link gives the same bytes again; the cost of a ray depends on the trees that are built.
        lines = self.wrapped([each.name for each in self.own if each.source != "Cost"]).replace("\n" + " " * 17, "\n  ")
        return self.replaced("questions.js", text, r"(const FIELDS = \[).*?(\];)", lines)

    def write(self, write):
        for name, make in (("docs/reference/fields.md", self.fields_page), ("docs/reference/routes.md", self.routes_page),
                           ("proto/openapi.json", self.openapi), ("proto/python/sightline.py", self.client),
                           ("proto/python/README.md", self.client_page), ("server/page/app/src/questions.js", self.page)):
            before = self.read(name)
            after = make(before)
            if before != after and write:
                (self.root / name).write_text(after, encoding="utf-8")
            elif before != after:
                self.faults.append(f"{name}: differs from proto/hit_fields.def and proto/questions.json: run scripts/describe.py --write")

    def check_questions(self):
        document = json.loads(self.read("proto/openapi.json"))
        schemas = document["components"]["schemas"]
        client = self.read("proto/python/sightline.py")
        server = "".join(path.read_text(encoding="utf-8") for path in sorted((self.root / "server").rglob("*.cpp")))
        told = {each["path"] for each in self.questions}
        # A question is a POST with a body whose answer depends on it alone: not a load.
        for path, item in document["paths"].items():
            if "post" in item and path != "/v1/scenes" and path not in told:
                self.faults.append(f"proto/openapi.json: {path} is not in proto/questions.json")
        for each in self.questions:
            place = f"proto/questions.json: {each.get('operation')}"
            if tuple(each) != QUESTION:
                self.faults.append(f"{place}: has the members {tuple(each)}: expected {QUESTION}")
                continue
            operation = document["paths"].get(each["path"], {}).get("post")
            if operation is None:
                self.faults.append(f"{place}: proto/openapi.json has no POST {each['path']}")
                continue
            answer = operation["responses"]["200"]["content"]
            query = schemas[operation["requestBody"]["content"]["application/json"]["schema"]["$ref"].rsplit("/", 1)[1]]
            answers = answer["application/json"]["schema"]
            of_document = {"operation": operation["operationId"], "keys": list(query["properties"]),
                           "answer": [one["$ref"].rsplit("/", 1)[1] for one in answers.get("anyOf", [answers])],
                           "layouts": [MEDIA[kind] for kind in answer]}
            for what, value in of_document.items():
                if each[what] != value:
                    self.faults.append(f"{place}: {what} is {each[what]}, proto/openapi.json has {value}")
            if f'"{each["path"]}"' not in server:
                self.faults.append(f"{place}: the server adds no route {each['path']}")
            if not re.search(rf"^    def {each['python']}\(", client, re.MULTILINE) or each["python"] == "ask":
                self.faults.append(f"{place}: proto/python/sightline.py has no method {each['python']} of its own")
            if sum(other.get("python") == each["python"] for other in self.questions) > 1:
                self.faults.append(f"{place}: another question has the method {each['python']} too")
        self.check_client_routes(document, client)

    def check_client_routes(self, document, client):
        questions = {each.get("operation") for each in self.questions}
        for path, item in document["paths"].items():
            for method, operation in item.items():
                name = operation["operationId"] if isinstance(operation, dict) else None
                is_api = path.startswith("/v1/") or name in CLIENT_ROUTES
                if name is None or name in questions or not is_api:
                    continue
                if not re.search(rf"^    def {CLIENT_ROUTES.get(name)}\(", client, re.MULTILINE):
                    self.faults.append(f"proto/openapi.json: {method} {path}: proto/python/sightline.py has no method for {name}"
                                       " (CLIENT_ROUTES of scripts/describe.py)")

    def check_error_codes(self):
        page = (self.root / "docs/reference/errors.md").read_text()
        documented = dict(re.findall(r"^\| `([A-Z0-9_]+)` \| ([^|]*) \|", page, re.MULTILINE))
        source = "\n".join(path.read_text() for room in ("core", "proto", "server")
                           for path in sorted((self.root / room).rglob("*")) if path.suffix in (".cpp", ".h"))
        limits = set(re.findall(r'beyond_limit\(\s*"([A-Z_]+)"', source))
        codes = set(re.findall(CODE, source)) | {code for _, code in KIND.findall(source)}
        codes = codes - limits - NO_CODES - {"GLTF_LIMIT_"} | {f"GLTF_LIMIT_{limit}" for limit in limits}
        for code in sorted(codes - documented.keys()):
            self.faults.append(f"docs/reference/errors.md has no row for {code}")
        for code in sorted(documented.keys() - codes):
            if f'"{code}"' not in source:
                self.faults.append(f"docs/reference/errors.md: no source has {code}")
        for kind, code in KIND.findall(source):
            status = documented.get(code, "")
            if status[:1].isdigit() and code not in FORBIDDEN and STATUS.get(kind, status) not in status:
                self.faults.append(f"docs/reference/errors.md: {code} has status {status}, its kind {kind} has {STATUS[kind]}")


def main(arguments):
    write = "--write" in arguments
    names = [each for each in arguments if not each.startswith("--")]
    description = Description(Path(names[0]) if names else Path(__file__).resolve().parents[1])
    description.write(write)
    description.check_questions()
    description.check_error_codes()
    for fault in description.faults:
        print(fault)
    print(f"{len(description.fields)} fields, {len(description.questions)} questions: {len(description.faults)} faults")
    return 1 if description.faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
