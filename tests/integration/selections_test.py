"""Selections that match nothing: a warning in the answer, or an error with "strict"."""

import json
import struct
import unittest

import case_report
from made_scene import triangle_glb
from sightline_server import JSON_TYPE, Server
from two_scenes import TwoScenes

THROUGH = {"origin": [-10, 1, 0], "direction": [1, 0, 0]}
SWEEP = {**THROUGH, "radius": 0.5}
NOBODY = {"names": ["left", "lefd"]}
# Every question that takes a filter, as JSON.
QUESTIONS = [("rays:closest", {"rays": [THROUGH]}), ("rays:any", {"rays": [THROUGH]}), ("rays:all", {"rays": [THROUGH]}),
             ("rays:count", {"rays": [THROUGH]}), ("points:inside", {"points": [[0, 0, 0]]}), ("points:closest", {"points": [[0, 0, 0]]}),
             ("points:nearest", {"points": [[0, 0, 0]], "count": 2}), ("points:distance", {"points": [[0, 0, 0]]}),
             ("sweeps:closest", {"sweeps": [SWEEP]}), ("sweeps:any", {"sweeps": [SWEEP]}),
             ("visibility", {"from": [[-10, 1, 0]], "to": [[10, 1, 0]]}), ("clearance", {"a": {"names": ["left"]}, "b": {"names": ["right"]}})]


def binary(magic, columns, options):
    text = json.dumps(options).encode()
    head = struct.pack("<4sIQII", magic, 1, 1, len(text), 0) + text
    return head + bytes(-len(head) % 8) + struct.pack(f"<{len(columns)}d", *columns)


class Selections(TwoScenes):
    def post(self, path, body, *arguments, kind=JSON_TYPE):
        return self.server.ask(f"/v1/scenes/six/{path}", "-H", kind, *arguments, body=body if isinstance(body, (bytes, str)) else json.dumps(body))

    def warnings(self, path, body):
        answer = self.post(path, body)
        self.assertEqual(answer.status, 200, answer.body)
        return [(each["code"], each["pointer"]) for each in answer.json().get("warnings", [])]

    def test_every_question_warns_of_an_entry_that_matches_nothing(self):
        for path, body in QUESTIONS:
            for key in ("include", "exclude"):
                for choice, entry in [({"names": ["left", "lefd"]}, "names/1"), ({"materials": ["nothing*"]}, "materials/0"),
                                      ({"nodes": [0], "names": ["Left"]}, "names/0")]:
                    with self.subTest(path=path, key=key, choice=choice):
                        self.assertEqual(self.warnings(path, {**body, key: choice}), [("SELECTION_EMPTY", f"/{key}/{entry}")])

    def test_every_question_refuses_it_when_it_is_strict(self):
        for path, body in QUESTIONS:
            with self.subTest(path=path):
                answer = self.post(path, {**body, "strict": True, "exclude": NOBODY})
                self.assertEqual((answer.status, answer.json()["code"]), (422, "SELECTION_EMPTY"), answer.body)
                self.assertEqual(answer.json()["errors"][0]["pointer"], "/exclude/names/1")
                self.assertIn('"left"', answer.json()["detail"])
                good = self.post(path, {**body, "strict": True, "exclude": {"names": ["r*"]}} if path != "clearance" else {**body, "strict": True})
                self.assertEqual((good.status, "warnings" in good.json()), (200, False), good.body)
                self.assertEqual(self.post(path, {**body, "strict": 1}).json()["code"], "TYPE_WRONG")

    def test_a_warning_names_what_is_similar(self):
        ray = {"rays": [THROUGH]}
        for choice, similar in [({"names": ["lefd"]}, '"left"'), ({"names": ["RIGHT"]}, '"right"'), ({"names": ["righ?t*"]}, '"right"')]:
            with self.subTest(choice=choice):
                (warning,) = self.post("rays:any", {**ray, "include": choice}).json()["warnings"]
                self.assertIn(similar, warning["message"])
        (warning,) = self.post("rays:any", {**ray, "include": {"names": ["quite different"]}}).json()["warnings"]
        self.assertNotIn("similar", warning["message"])
        town = self.server.ask("/v1/scenes/town/rays:any", "-H", JSON_TYPE, body=json.dumps({**ray, "exclude": {"names": ["tower"], "materials": ["leafs"]}}))
        first, second = town.json()["warnings"]
        self.assertIn('"clock tower"', first["message"])
        self.assertIn('"leaves"', second["message"])

    def test_what_matches_brings_no_warning(self):
        for choice in ({"names": ["left", "l*", "?eft"]}, {"names": ["left", "left"]}, {"nodes": [0], "names": ["left", "right"]},
                       {"names": []}, {"materials": ["*"]}):
            with self.subTest(choice=choice):
                self.assertEqual(self.warnings("rays:any", {"rays": [THROUGH], "exclude": choice}), [])
        self.assertEqual(self.warnings("rays:any", {"rays": [THROUGH], "mask": 1, "cull": "back"}), [])

    def test_clearance_warns_of_both_of_its_selections(self):
        self.assertEqual(self.warnings("clearance", {"a": NOBODY, "b": {"materials": ["x"]}, "exclude": {"names": ["y"]}}),
                         [("SELECTION_EMPTY", "/exclude/names/0"), ("SELECTION_EMPTY", "/a/names/1"), ("SELECTION_EMPTY", "/b/materials/0")])
        answer = self.post("clearance", {"a": {"names": ["left"]}, "b": NOBODY, "strict": True})
        self.assertEqual((answer.status, answer.json()["errors"][0]["pointer"]), (422, "/b/names/1"))

    def test_a_node_that_is_not_there_is_an_error_as_ever(self):
        for strict in (True, False):
            answer = self.post("rays:any", {"rays": [THROUGH], "include": {"nodes": [99]}, "strict": strict})
            self.assertEqual((answer.status, answer.json()["code"]), (422, "FILTER_NODE_UNKNOWN"))

    def test_an_explanation_warns_once(self):
        answer = self.post("rays:closest", {"rays": [THROUGH], "explain": True, "exclude": NOBODY})
        self.assertEqual((answer.status, len(answer.json()["warnings"])), (200, 1), answer.body)

    def test_an_answer_of_bytes_has_the_warnings_in_a_header(self):
        options = {"exclude": NOBODY}
        accept = ("-H", "Accept: application/octet-stream")
        for path, body, kind in [("rays:closest", {"rays": [THROUGH], **options}, JSON_TYPE),
                                 ("rays:closest", binary(b"SLR1", [-10, 1, 0, 1, 0, 0], options), "Content-Type: application/octet-stream"),
                                 ("rays:count", binary(b"SLR1", [-10, 1, 0, 1, 0, 0], options), "Content-Type: application/octet-stream"),
                                 ("points:closest", binary(b"SLP1", [0, 0, 0], options), "Content-Type: application/octet-stream"),
                                 ("points:inside", {"points": [[0, 0, 0]], **options}, JSON_TYPE),
                                 ("sweeps:closest", {"sweeps": [SWEEP], **options}, JSON_TYPE)]:
            with self.subTest(path=path):
                answer = self.post(path, body, *accept, kind=kind)
                self.assertEqual((answer.status, answer.headers["content-type"]), (200, "application/octet-stream"), answer.body)
                told = json.loads(answer.headers["x-sightline-warnings"])
                self.assertEqual((told["count"], told["warnings"][0]["code"], told["warnings"][0]["pointer"]), (1, "SELECTION_EMPTY", "/exclude/names/1"))
                self.assertIn('"left"', told["warnings"][0]["message"])
        image = {"generator": {"kind": "pinhole", "width": 4, "height": 3}, "image": "depth", **options}
        self.assertEqual(json.loads(self.post("rays:closest", image).headers["x-sightline-warnings"])["count"], 1)
        strict = self.post("rays:closest", binary(b"SLR1", [-10, 1, 0, 1, 0, 0], {**options, "strict": True}), kind="Content-Type: application/octet-stream")
        self.assertEqual((strict.status, strict.json()["code"]), (422, "SELECTION_EMPTY"))
        self.assertNotIn("x-sightline-warnings", self.post("rays:any", {"rays": [THROUGH], **options}).headers)

    def test_a_header_is_short_and_of_ascii_however_many_there_are(self):
        many = {"names": ["\u00e4\r\nX-Evil: 1" + "\u20ac" * 70 + str(i) for i in range(64)]}
        answer = self.post("rays:any", {"rays": [THROUGH], "include": many, "exclude": {"materials": ["\u20ac" * 80] * 64}},
                           "-H", "Accept: application/octet-stream")
        self.assertEqual(answer.status, 200, answer.body)
        self.assertNotIn("x-evil", answer.headers)
        header = answer.headers["x-sightline-warnings"]
        self.assertTrue(header.isascii() and len(header) < 5000)
        told = json.loads(header)
        self.assertEqual(told["count"], 128)
        self.assertTrue(0 < len(told["warnings"]) < 128)

    def test_a_stream_is_always_strict(self):
        for options in ({"exclude": NOBODY}, {"exclude": NOBODY, "strict": False}):
            lines = json.dumps({"options": options}) + "\n" + json.dumps(THROUGH) + "\n"
            answer = self.post("rays:closest", lines, kind="Content-Type: application/x-ndjson")
            self.assertEqual((answer.status, answer.json()["code"]), (422, "SELECTION_EMPTY"), answer.body)
        lines = json.dumps({"options": {"exclude": {"names": ["left"]}, "strict": True}}) + "\n" + json.dumps(THROUGH) + "\n"
        answer = self.post("rays:any", lines, kind="Content-Type: application/x-ndjson")
        self.assertEqual((answer.status, answer.body.strip()), (200, b"true"))


    def test_a_later_frame_ends_its_stream(self):
        ray = [-10, 1, 0, 1, 0, 0]
        frames = [binary(b"SLR1", ray, options) for options in ({"exclude": {"names": ["left"]}}, {"exclude": NOBODY}, {})]
        body = b"SLS1" + bytes(4) + b"".join(struct.pack("<Q", len(frame)) + frame for frame in frames)
        answer = self.post("rays:any", body, kind="Content-Type: application/octet-stream")
        self.assertEqual((answer.status, answer.body[:8]), (200, b"SLS1" + bytes(4)))
        parts, rest = [], answer.body[8:]
        while rest:
            (size,) = struct.unpack_from("<Q", rest)
            parts.append(rest[8:8 + size])
            rest = rest[8 + size:]
        self.assertEqual((len(parts), parts[0][:4]), (2, b"SLA1"))
        self.assertEqual(json.loads(parts[1])["code"], "SELECTION_EMPTY")


class LargeScenes(unittest.TestCase):
    def test_a_scene_of_many_names_has_warnings_for_all_patterns(self):
        # How many steps the search for similar names may take, unit tests say.
        nodes = [{"mesh": 0, "name": f"node with a long name and the number {i * 7919 % 1000003}"} for i in range(100_000)]
        with Server() as server:
            self.assertEqual(server.put("many", triangle_glb(nodes)).status, 201)
            name = "mode with a long name and the number {}"
            for count in (1, 64):
                choice = {"names": [name.format(i) for i in range(count)]}
                answer = server.ask("/v1/scenes/many/rays:any", "-H", JSON_TYPE, body=json.dumps(
                    {"rays": [THROUGH], "include": choice, "exclude": {**choice, "materials": ["x" * 256] * count}}))
                self.assertEqual(answer.status, 200, answer.body[:300])
                warnings = answer.json()["warnings"]
                self.assertEqual(len(warnings), 3 * count)
                self.assertIn('similar: "node with', warnings[0]["message"])
                self.assertLessEqual(warnings[0]["message"].count("node with"), 3)


if __name__ == "__main__":
    case_report.main()
