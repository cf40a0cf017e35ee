"""Bodies made from proto/openapi.json, good ones and spoiled ones: the server answers all, and never with a 5xx.

SIGHTLINE_FUZZ_BODIES says how many (3000), SIGHTLINE_FUZZ_SEED where to begin (1).
"""

import http.client
import json
import os
import random
import unittest

import case_report
from openapi_test import DOCUMENT, operations, resolve
from sightline_server import PATIENCE, Server

COUNT = int(os.environ.get("SIGHTLINE_FUZZ_BODIES", "3000"))
SEED = int(os.environ.get("SIGHTLINE_FUZZ_SEED", "1"))
NUMBERS = [0, 1, -1, 0.5, -10, 10, 3, 1e-300, -1e-300, 5e-324, 1e300, -1e308, 1.7976931348623157e308, 2**31, 2**32, 2**53, 0.1, 180, 90]
WORDS = ["", "*", "left", "r?ght", "six triangles", "\u00e4", "a" * 300, "none", "t"]
SPOILERS = [None, True, -1, 1.5, 2**64, 1e999, "x", [], {}, [[]], {"kind": "lidar"}, [None], [1, 2, 3, 4], "\ud800"]


class Bodies:
    def __init__(self, seed):
        self.random = random.Random(seed)

    def number(self, schema, whole):
        low, high = schema.get("minimum"), schema.get("maximum")
        if whole:
            # Few rays are enough; a large number now and then meets the limits.
            most = 3 if self.random.random() < 0.95 else 2**40
            return self.random.randint(low or 0, min(high or most, most))
        value = self.random.choice([self.random.choice(NUMBERS), self.random.uniform(-12, 12), self.random.randint(-6, 6)])
        return abs(value) if schema.get("exclusiveMinimum") is not None else value

    def make(self, schema, depth=0):
        schema = resolve(schema)
        for word in ("anyOf", "oneOf"):
            if word in schema:
                return self.make(self.random.choice(schema[word]), depth)
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return self.random.choice(schema["enum"])
        if schema.get("pattern", "").startswith("^_"):
            return self.random.choice(["_TEMPERATURE", "_A:b"])
        kind = schema.get("type", "object")
        kind = self.random.choice(kind) if isinstance(kind, list) else kind
        if kind == "object":
            needed = schema.get("required", [])
            some = [name for name in schema.get("properties", {}) if name in needed or self.random.random() < 0.35]
            return {name: self.make(schema["properties"][name], depth + 1) for name in some}
        if kind == "array":
            if "prefixItems" in schema:
                return [self.make(each, depth + 1) for each in schema["prefixItems"]]
            least, most = schema.get("minItems", 0), schema.get("maxItems", 3)
            count = self.random.randint(least, min(most, max(least, 6)))
            made = [self.make(schema.get("items", {}), depth + 1) for _ in range(count)]
            return list(dict.fromkeys(made)) if schema.get("uniqueItems") else made
        if kind in ("number", "integer"):
            return self.number(schema, kind == "integer")
        return {"string": self.random.choice(WORDS), "boolean": self.random.random() < 0.5}.get(kind)

    def body(self, schema):
        """Mostly with one form of rays, so that many are good."""
        made = self.make(schema)
        forms = [["rays"], ["origins", "directions", "tmin", "tmax"], ["generator"]]
        properties = resolve(schema)["properties"]
        if "rays" in properties and self.random.random() < 0.9:
            for form in forms:
                for name in form:
                    made.pop(name, None)
            count = self.random.randint(0, 4)
            form = self.random.choice([form for form in forms if form[0] in properties])
            if form[0] == "rays":
                made["rays"] = [self.make(properties["rays"]["items"]) for _ in range(count)]
            elif form[0] == "generator":
                made["generator"] = self.make(properties["generator"])
            else:
                made["origins"] = [self.number({}, False) for _ in range(3 * count)]
                made["directions"] = [self.number({}, False) for _ in range(3 * count)]
        return made

    def spoil(self, value):
        """Something else somewhere."""
        if isinstance(value, dict) and value and self.random.random() < 0.85:
            name = self.random.choice(list(value))
            return {**value, name: self.spoil(value[name])}
        if isinstance(value, list) and value and self.random.random() < 0.85:
            at = self.random.randrange(len(value))
            return [*value[:at], self.spoil(value[at]), *value[at + 1:]]
        return self.random.choice(SPOILERS)

    def damage(self, text):
        """Something else in the text itself."""
        at = self.random.randrange(len(text) + 1)
        piece = self.random.choice(["", "\0", "{", "]", ",", '"', "NaN", "\\u12", "-", "1e", "[" * 50])
        return text[:at] + piece + text[at + self.random.randint(0, 4):]


class SchemaFuzz(unittest.TestCase):
    def test_every_body_has_an_answer_and_none_is_a_5xx(self):
        print(f"seed {SEED}, {COUNT} bodies")
        routes = [(path, operation["requestBody"]["content"]["application/json"]["schema"])
                  for method, path, operation in operations() if method == "POST" and path != "/v1/scenes"]
        self.assertGreater(len(routes), 8)
        bodies, statuses = Bodies(SEED), {}
        with Server("--preload", "six=demo:six", "--max-rays", 100_000) as server:
            connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
            for number in range(COUNT):
                path, schema = routes[number % len(routes)]
                body = bodies.body(schema)
                kind = number // len(routes) % 3
                text = json.dumps(bodies.spoil(body) if kind == 1 else body)
                text = bodies.damage(text) if kind == 2 else text
                try:
                    connection.request("POST", path.replace("{id}", "six"), text.encode("utf-8", "replace"),
                                       {"Content-Type": "application/json"})
                    answer = connection.getresponse()
                    content = answer.read()
                except OSError as error:
                    self.fail(f"body {number} to {path}: {error}\n{text[:500]}\n{server.log_text()[-2000:]}")
                # Who wishes for an answer within no time has none: the one 5xx that a body may ask for.
                if answer.status == 504 and json.loads(content)["code"] == "DEADLINE" and '"timeout_ms"' in text:
                    continue
                self.assertLess(answer.status, 500, f"body {number} to {path}: {content[:300]}\n{text[:500]}")
                if not content.startswith(b"\x89PNG"):
                    json.loads(content)
                    self.assertNotIn(b"nan", content if answer.status == 200 else b"")
                key = (kind, answer.status)
                statuses[key] = statuses.get(key, 0) + 1
            self.assertEqual(server.ask("/healthz").status, 200)
        print("by kind and status:", dict(sorted(statuses.items())))
        good = statuses.get((0, 200), 0)
        self.assertGreater(good, COUNT // 12, "too few of the unspoiled bodies are good to mean much")


if __name__ == "__main__":
    assert DOCUMENT
    case_report.main()
