"""Every wrong request gets application/problem+json with a stable code and the place of the fault."""

import json
import unittest

import case_report
from sightline_server import JSON_TYPE, SOURCE, Server, curl, demo_glb

GOOD = {"rays": [{"origin": [-10, 1, 0], "direction": [1, 0, 0]}]}


class Errors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--max-query-bytes", 20000, "--max-rays", 100,
                            "--max-scene-bytes", 50000, "--max-hits", 50)
        cls.addClassCleanup(cls.server.end)

    def expect(self, answer, status, code, pointer=None):
        self.assertEqual(answer.status, status, answer.body)
        self.assertEqual(answer.headers["content-type"], "application/problem+json")
        problem = answer.json()
        self.assertEqual(problem["status"], status)
        self.assertEqual(problem["code"], code)
        self.assertEqual(problem["type"], "urn:sightline:problem:" + code)
        self.assertTrue(problem["title"])
        self.assertTrue(problem["detail"])
        self.assertEqual(problem["request_id"], answer.headers["x-request-id"])
        if pointer is not None:
            self.assertEqual([place["pointer"] for place in problem["errors"]], [pointer])
        return problem

    def closest(self, body, *arguments):
        return self.server.query("six", "closest", body, *arguments)

    def test_an_unknown_scene_is_named_with_similar_ones(self):
        problem = self.server.ask("/v1/scenes/seven").json()
        self.assertEqual((problem["code"], problem["detail"]), ("SCENE_NOT_FOUND", 'there is no scene "seven"'))
        for path in ("/v1/scenes/sx", "/v1/scenes/sx/events", "/v1/scenes/sx/nodes"):
            self.assertEqual(self.server.ask(path).json()["detail"], 'there is no scene "sx"; similar: "six"', path)
        self.assertEqual(self.server.ask("/v1/scenes/sxi").json()["detail"], 'there is no scene "sxi"; similar: "six"')
        for method, path, body in (("DELETE", "/v1/scenes/sx", None), ("DELETE", "/v1/scenes/sx/nodes/1", None),
                                   ("PATCH", "/v1/scenes/sx/nodes/1", '{"hidden":true}'),
                                   ("PATCH", "/v1/scenes/sx/nodes", '{"nodes":[{"node":1,"hidden":true}]}'),
                                   ("POST", "/v1/scenes/sx/rays:closest", json.dumps(GOOD))):
            answer = self.server.ask(path, "-X", method, "-H", "Content-Type: application/json", body=body)
            self.assertEqual((answer.status, answer.json()["detail"]), (404, 'there is no scene "sx"; similar: "six"'), (method, path))
        self.assertIn("/docs", self.server.ask("/v1/scens").json()["detail"])

    def test_a_syntax_error_has_line_and_column(self):
        body = '{"rays":[\n{"origin":[0,1,0] "direction":[0,-1,0]}]}'
        detail = self.closest(body).json()["detail"]
        self.assertTrue(detail.endswith("; near line 2, column 19"), detail)
        for method, path in (("POST", "/v1/scenes"), ("PATCH", "/v1/scenes/six/nodes"), ("PATCH", "/v1/scenes/six/nodes/1")):
            answer = self.server.ask(path, "-X", method, "-H", "Content-Type: application/json", body='{"nodes":\n[1 "hidden"]}')
            self.assertEqual((answer.status, answer.json()["code"]), (400, "JSON_MALFORMED"), path)
            self.assertEqual(answer.json()["detail"], "the body is not JSON; near line 2, column 11", path)

    def test_a_body_that_is_not_json_is_400(self):
        for body in ("", "{", "hello", '{"rays":[]} x', '{"rays":[{"origin":[1,2,3],}]}', b"\xff\xfe"):
            with self.subTest(body=body):
                self.expect(self.closest(body), 400, "JSON_MALFORMED")

    def test_a_body_of_the_wrong_shape_is_422_with_its_place(self):
        for body, code, pointer in [
                ({}, "KEY_MISSING", None),
                ({"rays": 1}, "TYPE_WRONG", "/rays"),
                ({"rays": [{"origin": [0, 0, 0]}]}, "KEY_MISSING", "/rays/0"),
                ({"rays": [{"origin": [0, 0], "direction": [0, 0, 1]}]}, "LENGTH_WRONG", "/rays/0/origin"),
                ({"rays": [{"origin": [0, 0, "0"], "direction": [0, 0, 1]}]}, "TYPE_WRONG", "/rays/0/origin/2"),
                ({"rays": [], "colour": 1}, "KEY_UNKNOWN", "/colour"),
                ({"rays": [], "fields": ["t", "weight"]}, "FIELD_UNKNOWN", "/fields/1"),
                ({"origins": [0, 0, 0], "directions": [0, 0]}, "LENGTH_WRONG", "/directions"),
                ({"rays": [], "origins": []}, "KEYS_MIXED", "/origins"),
        ]:
            with self.subTest(body=body):
                self.expect(self.closest(body), 422, code, pointer)

    def test_an_unknown_field_is_answered_with_the_known_ones(self):
        problem = self.expect(self.closest({"rays": [], "fields": ["weight"]}), 422, "FIELD_UNKNOWN", "/fields/0")
        for name in ("t", "position", "normal", "node", "mesh", "material"):
            self.assertIn(name, problem["detail"])

    def test_a_nan_is_422(self):
        for token in ("NaN", "Infinity", "-Infinity", "nan", "1e999"):
            with self.subTest(token=token):
                body = json.dumps(GOOD).replace("-10", token)
                self.expect(self.closest(body), 422, "NUMBER_NOT_FINITE", "/rays/0/origin/0")

    def test_a_zero_direction_is_422(self):
        body = {"rays": [*GOOD["rays"] * 17, {"origin": [0, 0, 0], "direction": [0, -0.0, 0]}]}
        self.expect(self.closest(body), 422, "RAY_DIRECTION_ZERO", "/rays/17/direction")
        self.expect(self.closest({"origins": [0] * 6, "directions": [0, 0, 1, 0, 0, 0]}), 422,
                    "RAY_DIRECTION_ZERO", "/directions/3")

    def test_reversed_limits_are_422(self):
        body = {"rays": [{"origin": [0, 0, 0], "direction": [0, 0, 1], "tmin": 2, "tmax": 1}]}
        self.expect(self.closest(body), 422, "RAY_LIMITS_REVERSED", "/rays/0/tmin")

    def test_an_unknown_scene_is_404(self):
        for scene in ("none", "SIX", "..%2fsix", "%00", "a%20b", "x" * 500):
            with self.subTest(scene=scene):
                self.expect(self.server.query(scene, "closest", GOOD), 404, "SCENE_NOT_FOUND")
                self.expect(self.server.ask(f"/v1/scenes/{scene}"), 404, "SCENE_NOT_FOUND")
                self.expect(self.server.ask(f"/v1/scenes/{scene}", "-X", "DELETE"), 404, "SCENE_NOT_FOUND")

    def test_an_unknown_path_is_404(self):
        for path in ("/page", "/page.js/", "/nothing", "/v1", "/v1/scenes/", "/v1/scenes/six/rays:most", "/v1/scenes/six/rays:closest/x",
                     "//v1/scenes", "/%2e%2e/etc/passwd", "/healthz/", "/v1/scenes/%zz"):
            with self.subTest(path=path):
                self.expect(self.server.ask(path, "--path-as-is"), 404, "ROUTE_NOT_FOUND")
        self.expect(self.server.ask("/nothing", "-X", "POST", body="x"), 404, "ROUTE_NOT_FOUND")
        self.assertIn("/docs", self.server.ask("/nothing").json()["detail"])
        self.assertEqual(self.server.ask("/docs").status, 200)

    def test_a_wrong_method_is_405_and_says_what_is_allowed(self):
        for method, path, allowed in [
                ("GET", "/v1/scenes/six/rays:closest", {"POST", "OPTIONS"}),
                ("PUT", "/v1/scenes/six/rays:any", {"POST", "OPTIONS"}),
                ("PUT", "/v1/scenes", {"GET", "HEAD", "POST", "OPTIONS"}),
                ("PATCH", "/v1/scenes/six", {"GET", "HEAD", "PUT", "DELETE", "OPTIONS"}),
                ("TRACE", "/healthz", {"GET", "HEAD", "OPTIONS"}),
                ("DELETE", "/version", {"GET", "HEAD", "OPTIONS"}),
                ("BREW", "/readyz", {"GET", "HEAD", "OPTIONS"}),
        ]:
            with self.subTest(method=method, path=path):
                answer = self.server.ask(path, "-X", method)
                self.expect(answer, 405, "METHOD_NOT_ALLOWED")
                self.assertEqual(set(answer.headers["allow"].split(", ")), allowed)

    def test_options_says_what_is_allowed(self):
        answer = self.server.ask("/v1/scenes/six", "-X", "OPTIONS")
        self.assertEqual((answer.status, answer.body), (204, b""))
        self.assertEqual(answer.headers["allow"], "GET, HEAD, PUT, DELETE, OPTIONS")

    def test_another_media_type_is_415(self):
        for given in ("text/plain", "multipart/form-data; boundary=x", "application/jsonx", "application/xml"):
            with self.subTest(type=given):
                answer = self.server.ask("/v1/scenes/six/rays:closest", "-H", f"Content-Type: {given}", body=json.dumps(GOOD))
                self.expect(answer, 415, "MEDIA_TYPE_UNSUPPORTED")
                self.assertIn("application/json", answer.headers["accept"])
        for given in (JSON_TYPE, "Content-Type: text/plain", "Content-Type: model/obj"):
            with self.subTest(type=given):
                self.expect(self.server.ask("/v1/scenes/x", "-X", "PUT", "-H", given, body="{}"), 415, "MEDIA_TYPE_UNSUPPORTED")
        for given in ("Content-Type: application/json; charset=utf-8", "Content-Type: APPLICATION/JSON", "Content-Type:"):
            with self.subTest(type=given):
                answer = self.server.ask("/v1/scenes/six/rays:closest", "-H", given, body=json.dumps(GOOD))
                self.assertEqual(answer.status, 200, answer.body)

    def test_what_curl_sends_by_itself_is_read_as_json(self):
        for kind in ("closest", "any", "all", "count"):
            for arguments in ((), ("-H", "Content-Type:"), ("-H", "Content-Type: application/x-www-form-urlencoded; charset=UTF-8")):
                with self.subTest(kind=kind, arguments=arguments):
                    # Longer than what a form may be in some libraries.
                    body = json.dumps(GOOD) + " " * 10000
                    answer = self.server.ask(f"/v1/scenes/six/rays:{kind}", *arguments, body=body)
                    self.assertEqual(answer.status, 200, answer.body)
        self.expect(self.server.ask("/v1/scenes/six/rays:count", body="rays=1&fields=t"), 400, "JSON_MALFORMED")

    def test_lists_and_counts_are_as_strict_as_the_rest(self):
        for kind, more, code, pointer in [
                ("all", {"max_hits": -1}, "NUMBER_OUT_OF_RANGE", "/max_hits"),
                ("all", {"max_hits": 51}, "NUMBER_OUT_OF_RANGE", "/max_hits"),
                ("all", {"max_hits": 2.5}, "NUMBER_OUT_OF_RANGE", "/max_hits"),
                ("all", {"max_hits": "many"}, "TYPE_WRONG", "/max_hits"),
                ("all", {"crossings": "twice"}, "VALUE_UNKNOWN", "/crossings"),
                ("all", {"crossings": None}, "TYPE_WRONG", "/crossings"),
                ("all", {"colour": 1}, "KEY_UNKNOWN", "/colour"),
                ("all", {"fields": ["weight"]}, "FIELD_UNKNOWN", "/fields/0"),
                ("count", {"crossings": "Once"}, "VALUE_UNKNOWN", "/crossings"),
                ("count", {"max_hits": 1}, "KEY_UNKNOWN", "/max_hits"),
                ("count", {"fields": ["t"]}, "KEY_UNKNOWN", "/fields"),
                ("closest", {"max_hits": 1}, "KEY_UNKNOWN", "/max_hits"),
                ("any", {"crossings": "once"}, "KEY_UNKNOWN", "/crossings"),
        ]:
            with self.subTest(kind=kind, more=more):
                self.expect(self.server.query("six", kind, {**GOOD, **more}), 422, code, pointer)
        self.expect(self.server.query("none", "all", GOOD), 404, "SCENE_NOT_FOUND")
        self.expect(self.server.query("six", "count", {"rays": [{"origin": [0, 0, 0], "direction": [0, 0, 0]}]}), 422,
                    "RAY_DIRECTION_ZERO", "/rays/0/direction")

    def test_more_hits_than_an_answer_may_list_are_413(self):
        # The ray meets all six triangles: 8 rays are 48 hits, 9 are 54 and may list 50.
        self.assertEqual(self.server.query("six", "all", {"rays": GOOD["rays"] * 8}).status, 200)
        self.expect(self.server.query("six", "all", {"rays": GOOD["rays"] * 9}), 413, "TOO_MANY_HITS")
        answer = self.server.query("six", "all", {"rays": GOOD["rays"] * 9, "max_hits": 5})
        self.assertEqual(answer.status, 200, answer.body)
        self.assertEqual(self.server.query("six", "count", {"rays": GOOD["rays"] * 100}).json(), {"counts": [6] * 100})

    def test_an_unknown_coding_of_a_body_is_415_and_a_broken_one_400(self):
        for encoding in ("br", "deflate", "identity, gzip", "gzip, zstd"):
            with self.subTest(encoding=encoding):
                self.expect(self.closest("x", "-H", f"Content-Encoding: {encoding}"), 415, "ENCODING_UNSUPPORTED")
        for encoding in ("gzip", "zstd"):
            with self.subTest(encoding=encoding):
                self.expect(self.closest("x", "-H", f"Content-Encoding: {encoding}"), 400, "ENCODING_BROKEN")

    def test_too_much_is_413(self):
        large = b" " * 20001
        self.expect(self.closest(large), 413, "BODY_TOO_LARGE")
        self.expect(self.closest(large, "-H", "Transfer-Encoding: chunked"), 413, "BODY_TOO_LARGE")
        self.expect(self.closest(b" " * (8 << 20)), 413, "BODY_TOO_LARGE")
        self.expect(self.server.put("big", b"x" * 50001), 413, "BODY_TOO_LARGE")
        self.expect(self.closest({"rays": GOOD["rays"] * 101}), 413, "RAYS_TOO_MANY", "/rays/100")
        self.assertEqual(self.closest({"rays": GOOD["rays"] * 100}).status, 200)

    def test_a_body_without_length_is_411(self):
        self.expect(self.server.ask("/v1/scenes/six/rays:closest", "-X", "POST", "-H", JSON_TYPE), 411, "LENGTH_REQUIRED")

    def test_a_bad_scene_name_is_422(self):
        for name in ("%2e%2e", ".hidden", "a%2fb", "a%20b", "%C3%A9", "x" * 129, "a%00b"):
            with self.subTest(name=name):
                # Newer curl takes %2e%2e for a dot segment, and resolves it unless told not to.
                self.expect(self.server.put(name, b"x", "--path-as-is"), 422, "SCENE_ID_INVALID")

    def test_a_bad_query_parameter_is_422(self):
        for query in ("scene=", "scene=-1", "scene=x", "scene=1&scene=2", "scen=1", "scene=4294967296", "scene=0;x=1",
                      "scene=1=0", "scene=0&scene=0", "scene=%30", "scene=0&x"):
            with self.subTest(query=query):
                self.expect(self.server.put("x?" + query, b"x"), 422, "QUERY_INVALID")

    def test_a_range_is_ignored_whatever_it_says(self):
        # RFC 9110, 14.2: ranges are an offer that a server may leave alone, and of other methods than GET it must.
        whole = self.server.ask("/v1/scenes/six")
        hits = self.closest(GOOD)
        for given in ("bytes=0-1", "bytes=x", "bytes=5-2", "bytes=0-1,5-2", "bytes=-", "lines=1-2", "x", "bytes:0-1",
                      "bytes=99999999999999999999-"):
            for name in ("Range", "RANGE"):
                with self.subTest(range=given, name=name):
                    got = self.server.ask("/v1/scenes/six", "-H", f"{name}: {given}")
                    self.assertEqual((got.status, got.body), (200, whole.body))
                    got = self.closest(GOOD, "-H", f"{name}:{given}")
                    self.assertEqual((got.status, got.body), (200, hits.body))

    def test_a_request_line_that_is_none_is_400(self):
        connection = self.server.connect()
        with connection, connection.makefile("rwb") as stream:
            stream.write(b"complete nonsense\r\n\r\n")
            stream.flush()
            text = stream.read()  # ends with the connection
        self.assertTrue(text.startswith(b"HTTP/1.1 400 "), text)
        self.assertIn(b"REQUEST_MALFORMED", text)
        self.assertIn(b"application/problem+json", text)

    def test_every_hostile_file_is_answered_and_names_no_path(self):
        cases = sorted((SOURCE / "tests/data/hostile/cases").iterdir())
        self.assertGreater(len(cases), 50)
        refused = 0
        with Server() as server:
            for case in cases:
                media_type = "model/gltf+json" if case.suffix == ".gltf" else "model/gltf-binary"
                answer = server.ask("/v1/scenes/hostile", "-X", "PUT", "-H", f"Content-Type: {media_type}", body=case.read_bytes())
                with self.subTest(case=case.name):
                    self.assertIn(answer.status, (200, 201, 400, 413, 415, 422), answer.body)
                    self.assertNotIn(str(SOURCE).encode(), answer.body)
                    if answer.status >= 400:
                        refused += 1
                        self.expect(answer, answer.status, answer.json()["code"])
            self.assertEqual(curl(server.url + "/healthz").status, 200)
        print(f"{len(cases)} hostile files, {refused} refused")
        self.assertGreater(refused, 20)

    def test_a_request_id_is_echoed_or_made(self):
        given = self.server.ask("/healthz", "-H", "X-Request-Id: my-id_1.2")
        self.assertEqual(given.headers["x-request-id"], "my-id_1.2")
        made = {self.server.ask("/healthz", *arguments).headers["x-request-id"] for arguments in [
            (), ("-H", "X-Request-Id: a b"), ("-H", "X-Request-Id: " + "x" * 200), ("-H", "X-Request-Id: <script>")]}
        self.assertEqual(len(made), 4)
        for request_id in made:
            self.assertRegex(request_id, "^[0-9a-f]{16}$")

    def test_a_failed_put_leaves_the_old_scene(self):
        answer = self.server.put("six", b"not a scene")
        self.assertIn(answer.status, (400, 422))
        self.assertEqual(self.server.closest("six", ([-10, 1, 0], [1, 0, 0]))[0]["t"], 4.5)

    def test_curl_d_instead_of_data_binary_is_detected(self):
        # What curl -d @FILE sends: the file without line ends and zero bytes, as a form.
        stripped = demo_glb("six").translate(None, b"\r\n\0")
        form = ("-H", "Content-Type: application/x-www-form-urlencoded")
        answer = self.server.ask("/v1/scenes/form", "-X", "PUT", *form, body=stripped)
        self.assertIn(answer.status, (400, 415), answer.body)
        self.assertIn("--data-binary @FILE", answer.json()["detail"])
        lines = b'{"origin":[3,10,0],"direction":[0,-1,0]}' * 2
        binary = (b"SLR1" + bytes(range(60))).translate(None, b"\r\n\0")
        for body in (lines, binary):
            answer = self.server.ask("/v1/scenes/six/rays:closest", *form, body=body)
            self.assertIn("--data-binary @FILE", answer.json()["detail"], answer.body)
        # A mistake in JSON that lost nothing has no such hint, and good requests work as before.
        answer = self.server.ask("/v1/scenes/six/rays:closest", *form, body='{"rays":[],}')
        self.assertNotIn("--data-binary", answer.json()["detail"])
        # Nor has a file with another fault than lost bytes.
        fault = b'{"asset":{"version":"2.0"},"scenes":[{"nodes":[7]}],"scene":0}'
        answer = self.server.ask("/v1/scenes/form", "-X", "PUT", *form, body=fault)
        self.assertEqual(answer.status, 422, answer.body)
        self.assertNotIn("curl -d", answer.json()["detail"])
        self.assertEqual(self.server.ask("/v1/scenes/six/rays:closest", *form, body='{"rays":[]}').status, 200)
        self.assertEqual(self.server.ask("/v1/scenes/form", "-X", "PUT", *form, body=demo_glb("six")).status, 201)


if __name__ == "__main__":
    case_report.main()
