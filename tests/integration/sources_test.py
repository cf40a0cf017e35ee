"""Scenes by path and by url, asked for with curl, and what is refused."""

import hashlib
import json
import os
import shutil
import tempfile
import unittest
from pathlib import Path

import case_report
from hostile_origin import Origin, endless_chunks, endless_head, liar
from sightline_server import JSON_TYPE, PATIENCE, SOURCE, Server, demo_glb

SCENES = SOURCE / "tests/data/scenes"
LIMIT = 3_000_000


def post(server, source, scene="s", wait=PATIENCE, options=None, **more):
    body = {"id": scene, "source": source, **more}
    if options is not None:
        body["options"] = options
    return server.ask(f"/v1/scenes?wait={wait}" if wait is not None else "/v1/scenes", "-H", JSON_TYPE, body=json.dumps(body))


class Case(unittest.TestCase):
    def expect(self, answer, status, code, *secrets):
        self.assertEqual(answer.status, status, answer.body)
        self.assertEqual(answer.headers["content-type"], "application/problem+json")
        self.assertEqual(answer.json()["code"], code, answer.body)
        for secret in secrets:
            self.assertNotIn(str(secret).encode(), answer.body)
        return answer.json()

    def folder(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        return Path(folder.name)


class Paths(Case):
    def setUp(self):
        self.outer = self.folder()
        self.root = self.outer / "root"
        (self.root / "deep").mkdir(parents=True)
        self.six = demo_glb("six")
        (self.root / "six.glb").write_bytes(self.six)
        (self.root / "deep/six.glb").write_bytes(self.six)
        (self.outer / "secret.glb").write_bytes(self.six)

    def server(self, *arguments):
        server = Server("--scene-root", self.root, "--max-scene-bytes", LIMIT, *arguments)
        self.addCleanup(server.end)
        return server

    def test_a_path_below_the_root_is_loaded(self):
        server = self.server()
        first = post(server, {"path": "deep/six.glb", "sha256": hashlib.sha256(self.six).hexdigest()})
        self.assertEqual((first.status, first.headers["location"]), (201, "/v1/scenes/s"), first.body)
        self.assertEqual(first.json()["counts"]["triangles"], 6)
        self.assertEqual(first.headers["etag"], f'"{hashlib.sha256(self.six).hexdigest()}"')
        self.assertEqual(post(server, {"path": "./deep/../six.glb"}).status, 200)
        later = post(server, {"path": "six.glb"}, scene="later", wait=None)
        self.assertEqual((later.status, later.headers["location"], later.headers["retry-after"]), (202, "/v1/scenes/later", "1"))
        self.assertIn(later.json()["state"], ("queued", "loading", "ready"))
        self.assertEqual(server.ask(f"/v1/scenes/later?wait={PATIENCE}").json()["state"], "ready")

    def test_nothing_outside_of_the_root_is_opened(self):
        os.symlink(self.outer / "secret.glb", self.root / "link.glb")
        os.symlink("../secret.glb", self.root / "relative.glb")
        os.symlink(self.outer, self.root / "folder")
        os.symlink("../..", self.root / "deep/up")
        os.symlink("loop", self.root / "loop")
        os.symlink("deep/six.glb", self.root / "inside.glb")
        server = self.server()
        for path in ("../secret.glb", "deep/../../secret.glb", "link.glb", "relative.glb", "folder/secret.glb", "deep/up/secret.glb",
                     "/etc/passwd", str(self.root / "six.glb"), "//six.glb", "loop", "..", "six.glb\0.txt", "six.glb\n", "x" * 5000,
                     "../root/six.glb", "/proc/self/cwd/six.glb"):
            with self.subTest(path=path):
                self.expect(post(server, {"path": path}), 403, "PATH_REFUSED", self.outer)
        os.mkfifo(self.root / "pipe")
        for path in ("none.glb", "deep", ".", "six.glb/x", "pipe", "%2e%2e/secret.glb", "..%2fsecret.glb", "deep\\..\\six.glb"):
            with self.subTest(path=path):
                self.expect(post(server, {"path": path}), 422, "SOURCE_NOT_FOUND", self.outer)
        # A link that stays inside is as good as the file.
        self.assertEqual(post(server, {"path": "inside.glb"}).status, 201)
        self.assertEqual([scene["id"] for scene in server.ask("/v1/scenes").json()["scenes"]], ["s"])

    def test_what_is_too_large_or_wrong_is_refused(self):
        (self.root / "large.glb").write_bytes(b"x" * (LIMIT + 1))
        (self.root / "text.txt").write_bytes(b"no scene at all")
        server = self.server()
        self.expect(post(server, {"path": "large.glb"}), 413, "SOURCE_TOO_LARGE")
        self.expect(post(server, {"path": "text.txt"}), 400, "GLTF_CONTAINER_INVALID", self.root)
        wrong = self.expect(post(server, {"path": "six.glb", "sha256": "0" * 64}), 422, "SOURCE_HASH_MISMATCH")
        self.assertEqual(wrong["errors"][0]["pointer"], "/source/sha256")
        self.expect(post(server, {"path": "six.glb"}, scene="../x"), 422, "SCENE_ID_INVALID")
        self.expect(post(server, {"path": "six.glb"}, options={"scene": 9}), 422, "GLTF_SCENE_UNKNOWN")
        self.expect(post(server, {"path": "six.glb", "url": "http://x/"}), 422, "KEYS_MIXED")
        self.expect(post(server, {"url": "http://127.0.0.1/"}), 403, "URL_NOT_ALLOWED")
        self.assertEqual(server.ask("/v1/scenes").json(), {"scenes": []})
        # A failure that nobody waited for has its reason.
        self.assertEqual(post(server, {"path": "text.txt"}, wait=None).status, 202)
        scene = server.ask(f"/v1/scenes/s?wait={PATIENCE}").json()
        self.assertEqual((scene["state"], scene["reason"]["code"]), ("failed", "GLTF_CONTAINER_INVALID"))

    def test_only_json_that_says_so_is_taken(self):
        server = self.server()
        body = json.dumps({"id": "s", "source": {"path": "six.glb"}})
        for given in ("Content-Type:", "Content-Type: text/plain", "Content-Type: application/x-www-form-urlencoded"):
            with self.subTest(type=given):
                self.expect(server.ask("/v1/scenes", "-H", given, body=body), 415, "MEDIA_TYPE_UNSUPPORTED")
        self.expect(server.ask("/v1/scenes", "-H", JSON_TYPE, body=body + " " * 70000), 413, "BODY_TOO_LARGE")
        self.expect(server.ask("/v1/scenes", "-H", JSON_TYPE, body="{"), 400, "JSON_MALFORMED")
        self.expect(server.ask("/v1/scenes?scene=1", "-H", JSON_TYPE, body=body), 422, "QUERY_INVALID")

    def test_without_a_root_there_are_no_paths(self):
        with Server() as server:
            self.expect(post(server, {"path": "six.glb"}), 403, "PATH_NOT_ALLOWED")
        for root in (self.root / "none", self.root / "six.glb"):
            with self.assertRaises(AssertionError):
                Server("--scene-root", root)

    def test_neighbours_come_from_the_files_folder_and_stay_after_a_restart(self):
        for name in ("features_external.gltf", "features data.bin"):
            shutil.copy(SCENES / name, self.root / "deep" / name)
        data = self.outer / "data"
        server = self.server("--data", data)
        put = post(server, {"path": "deep/features_external.gltf"})
        self.assertEqual(put.status, 201, put.body)
        whole = server.put("whole", (SCENES / "features.glb").read_bytes())
        self.assertEqual(put.json()["counts"]["triangles"], whole.json()["counts"]["triangles"])
        self.assertTrue(put.json()["persistent"])
        self.assertEqual(list((data / "tmp").iterdir()), [])
        server.kill()
        # The source may go away: what was acknowledged is in the data folder.
        shutil.rmtree(self.root / "deep")
        server = self.server("--data", data)
        again = server.ask("/v1/scenes/s")
        self.assertEqual((again.body, again.headers["etag"]), (put.body, put.headers["etag"]))
        self.assertEqual(server.ask("/v1/scenes/s", "-X", "DELETE").status, 204)
        self.assertEqual(len(list((data / "blobs").iterdir())), 1)
        server.end()
        # Damaged, the neighbour takes its scene with it, and no other.
        (self.root / "deep").mkdir()
        for name in ("features_external.gltf", "features data.bin"):
            shutil.copy(SCENES / name, self.root / "deep" / name)
        server = self.server("--data", data)
        self.assertEqual(post(server, {"path": "deep/features_external.gltf"}).status, 201)
        server.end()
        blob = data / "blobs" / hashlib.sha256((SCENES / "features data.bin").read_bytes()).hexdigest()
        blob.write_bytes(blob.read_bytes()[:-1])
        server = self.server("--data", data)
        scene = server.ask("/v1/scenes/s").json()
        self.assertEqual((scene["state"], scene["reason"]["code"]), ("failed", "STORE_DAMAGED"))
        self.assertEqual(server.ask("/v1/scenes/whole").json()["state"], "ready")

    def test_a_neighbour_outside_of_the_files_folder_is_refused(self):
        text = (SCENES / "features_external.gltf").read_text()
        name = "features%20data.bin"
        self.assertIn(name, text)
        shutil.copy(SCENES / "features data.bin", self.outer / "outside.bin")
        shutil.copy(SCENES / "features data.bin", self.root / "beside.bin")
        os.symlink("../beside.bin", self.root / "deep/link.bin")
        os.symlink(self.outer / "outside.bin", self.root / "deep/far.bin")
        (self.root / "deep/large.bin").write_bytes(b"x" * LIMIT)
        server = self.server()
        for uri, status, code in [("../beside.bin", 422, "GLTF_URI_REFUSED"), ("../../outside.bin", 422, "GLTF_URI_REFUSED"),
                                  ("link.bin", 422, "PATH_REFUSED"), ("far.bin", 422, "PATH_REFUSED"),
                                  ("%2e%2e/beside.bin", 422, "GLTF_URI_REFUSED"), ("/etc/passwd", 422, "GLTF_URI_REFUSED"),
                                  ("file:///etc/passwd", 422, "GLTF_URI_REFUSED"), ("none.bin", 422, "SOURCE_NOT_FOUND"),
                                  ("large.bin", 413, "SOURCE_TOO_LARGE"), ("a%00b", 422, "GLTF_URI_REFUSED")]:
            with self.subTest(uri=uri):
                (self.root / "deep/scene.gltf").write_text(text.replace(name, uri))
                self.expect(post(server, {"path": "deep/scene.gltf"}), status, code, self.outer)
        self.assertEqual(server.ask("/v1/scenes").json(), {"scenes": []})


class Urls(Case):
    @classmethod
    def setUpClass(cls):
        cls.six = demo_glb("six")
        cls.origin = Origin()
        cls.other = Origin("127.0.0.2")
        for origin in (cls.origin, cls.other):
            cls.addClassCleanup(origin.end)
            origin.pages["/six.glb"] = (200, {}, cls.six)
        cls.server = Server("--allow-url", "http://127.0.0.1:*/", "--allow-url", "http://127.0.0.2:*/", "--allow-url", "http://localhost:*",
                            "--allow-address", "127.0.0.1", "--max-scene-bytes", LIMIT, "--fetch-seconds", 20)
        cls.addClassCleanup(cls.server.end)

    def get(self, path, server=None, **more):
        return post(server or self.server, {"url": self.origin.url + path}, **more)

    def test_a_url_is_fetched(self):
        answer = post(self.server, {"url": self.origin.url + "/six.glb?v=1", "sha256": hashlib.sha256(self.six).hexdigest()}, scene="good")
        self.assertEqual(answer.status, 201, answer.body)
        self.assertEqual(answer.json()["counts"]["triangles"], 6)
        self.assertIn("/six.glb?v=1", self.origin.asked)
        self.assertEqual(self.server.ask("/v1/scenes/good", "-X", "DELETE").status, 204)

    def test_redirects_are_followed_and_each_is_checked(self):
        self.origin.redirect("/once", "/six.glb")
        self.origin.redirect("/twice", self.origin.url + "/once", 307)
        self.assertEqual(self.get("/twice", scene="moved").status, 201)
        self.origin.redirect("/circle", "/circle")
        self.expect(self.get("/circle"), 422, "REDIRECTS_TOO_MANY")
        self.assertEqual(self.origin.asked.count("/circle"), 6)
        for target, code in [("file:///etc/passwd", "URL_INVALID"), ("ftp://127.0.0.1/x", "URL_INVALID"),
                             ("gopher://127.0.0.1:70/x", "URL_INVALID"), ("http://user:word@127.0.0.1/x", "URL_INVALID"),
                             ("http://127.0.0.3:1/x", "URL_NOT_ALLOWED"), ("http://169.254.169.254/latest", "URL_NOT_ALLOWED"),
                             ("https://127.0.0.1/x", "URL_NOT_ALLOWED"), (self.other.url + "/six.glb", "ADDRESS_REFUSED"),
                             ("//127.0.0.9/x", "URL_NOT_ALLOWED")]:
            with self.subTest(target=target):
                self.origin.redirect("/away", target)
                answer = self.get("/away")
                self.assertEqual(answer.status, 422, answer.body)
                self.assertIn(answer.json()["code"], (code, "SOURCE_ANSWER") if code == "URL_INVALID" else (code,))
        self.assertEqual(self.other.asked, [])

    def test_addresses_that_are_not_public_are_refused(self):
        with Server("--allow-url", "http://*:*") as server:
            for host in ("127.0.0.1", "localhost", "0x7f.1", "2130706433", "[::1]", "[::ffff:127.0.0.1]", "0.0.0.0", "[::]", "10.0.0.1",
                         "169.254.169.254", "100.64.0.1", "192.168.1.1", "224.0.0.1", "[fe80::1]", "[fd00::1]", "[64:ff9b::7f00:1]"):
                with self.subTest(host=host):
                    answer = post(server, {"url": f"http://{host}:{self.origin.port}/six.glb"})
                    self.expect(answer, 422, "ADDRESS_REFUSED")
        self.assertNotIn("/never", self.origin.asked)

    def test_the_environments_proxy_is_not_asked(self):
        os.environ["http_proxy"] = os.environ["ALL_PROXY"] = self.origin.url
        try:
            server = Server("--allow-url", "http://10.0.0.1", wait=False)
        finally:
            del os.environ["http_proxy"], os.environ["ALL_PROXY"]
        with server:
            server.wait_ready()
            before = len(self.origin.asked)
            self.expect(post(server, {"url": "http://10.0.0.1/six.glb"}), 422, "ADDRESS_REFUSED")
            self.assertEqual(len(self.origin.asked), before)

    def test_what_matches_no_pattern_is_403_at_once(self):
        with Server("--allow-url", self.origin.url + "/scenes/", "--allow-address", "127.0.0.0/8") as server:
            for path in ("/six.glb", "/scenes", "/scenes/../six.glb", "/scenes/%2e%2e/six.glb", "/scenes/..%2fsix.glb"):
                with self.subTest(path=path):
                    problem = self.expect(self.get(path, server, wait=None), 403, "URL_NOT_ALLOWED")
                    self.assertEqual(problem["errors"][0]["pointer"], "/source/url")
            self.expect(post(server, {"url": self.other.url + "/scenes/x"}), 403, "URL_NOT_ALLOWED")
            for url in ("file:///etc/passwd", "ftp://x/y", "/six.glb", "http://a b/", "http://u:p@127.0.0.1/", "http://127.0.0.1/\n"):
                with self.subTest(url=url):
                    self.expect(post(server, {"url": url}), 422, "URL_INVALID")
        with Server() as server:
            self.expect(self.get("/six.glb", server), 403, "URL_NOT_ALLOWED")
        for pattern in ("*", "ftp://x", "http://a*b"):
            with self.assertRaises(AssertionError):
                Server("--allow-url", pattern)
        with self.assertRaises(AssertionError):
            Server("--allow-address", "localhost")

    def test_what_is_too_large_is_refused_when_it_is_seen(self):
        self.origin.pages["/large"] = (200, {}, b"x" * (LIMIT + 1))
        self.expect(self.get("/large"), 413, "SOURCE_TOO_LARGE")
        self.origin.pages["/endless"] = endless_chunks
        self.expect(self.get("/endless"), 413, "SOURCE_TOO_LARGE")
        self.origin.pages["/head"] = endless_head
        self.assertEqual(self.get("/head").status, 422)
        self.origin.pages["/page"] = (302, {"Location": "/six.glb"}, b"x" * 1_000_000)
        self.expect(self.get("/page"), 422, "SOURCE_ANSWER")

    def test_what_is_too_slow_is_given_up(self):
        def silent(handler):
            self.origin.release.wait()

        def dripping(handler):
            handler.send_response(200)
            handler.send_header("Content-Length", "1000000")
            handler.end_headers()
            while not self.origin.release.wait(0.05):
                handler.wfile.write(b"x")

        self.origin.pages["/silent"], self.origin.pages["/drip"] = silent, dripping
        with Server("--allow-url", self.origin.url, "--allow-address", "127.0.0.1", "--fetch-seconds", 0.5) as server:
            for path in ("/silent", "/drip"):
                with self.subTest(path=path):
                    self.expect(self.get(path, server), 422, "SOURCE_TOO_SLOW")
        # Those that are being fetched hold up no upload, and end with the server or a DELETE.
        for number in range(6):
            self.assertEqual(self.get("/drip", scene=f"drip{number}", wait=None).status, 202)
        self.assertEqual(self.server.put("quick", self.six).status, 201)
        scene = self.server.ask("/v1/scenes/drip0").json()
        while scene["state"] == "queued":
            scene = self.server.ask("/v1/scenes/drip0").json()
        self.assertEqual((scene["state"], scene["stage"]), ("loading", "receiving"))
        for number in range(6):
            self.assertEqual(self.server.ask(f"/v1/scenes/drip{number}", "-X", "DELETE").status, 204)
        self.assertEqual(self.get("/six.glb", scene="after").status, 201)

    def test_what_is_wrong_is_told(self):
        self.expect(post(self.server, {"url": self.origin.url + "/six.glb", "sha256": "f" * 64}), 422, "SOURCE_HASH_MISMATCH")
        self.expect(self.get("/none"), 422, "SOURCE_ANSWER")
        for status in (204, 206, 300, 304, 500):
            with self.subTest(status=status):
                self.origin.pages["/status"] = (status, {}, b"" if status in (204, 304) else self.six)
                self.expect(self.get("/status"), 422, "SOURCE_ANSWER")
        self.origin.pages["/liar"] = liar(self.six)
        self.expect(self.get("/liar"), 422, "SOURCE_UNREACHABLE")
        self.origin.pages["/text"] = (200, {}, b"hello")
        self.expect(self.get("/text"), 400, "GLTF_CONTAINER_INVALID")
        self.expect(post(self.server, {"url": "http://127.0.0.1:1/six.glb"}), 422, "SOURCE_UNREACHABLE")
        external = (SCENES / "features_external.gltf").read_bytes()
        self.origin.pages["/external"] = (200, {}, external)
        self.expect(self.get("/external"), 422, "GLTF_URI_REFUSED")
        self.assertEqual(self.server.ask("/healthz").status, 200)


if __name__ == "__main__":
    case_report.main()
