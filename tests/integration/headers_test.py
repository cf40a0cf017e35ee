"""What answers say beside their bodies, to browsers above all; and what they never say."""

import json
import shutil
import subprocess
import tempfile
import time
import unittest
from email.utils import formatdate, parsedate_to_datetime
from pathlib import Path

import case_report
from sightline_server import BINARY, JSON_TYPE, PATIENCE, SOURCE, Server, bearer, demo_glb, make_key, write_keys

ALWAYS = {"x-content-type-options": "nosniff", "referrer-policy": "no-referrer", "cache-control": "no-store",
          "cross-origin-resource-policy": "same-origin", "content-security-policy": "default-src 'none'; frame-ancestors 'none'"}
QUERY = '{"rays":[{"origin":[-10,1,0],"direction":[1,0,0]}]}'
PAGE = "https://page.example"


def preflight(origin, method="PUT"):
    return "-X", "OPTIONS", "-H", f"Origin: {origin}", "-H", f"Access-Control-Request-Method: {method}"


def cors(answer):
    return {name: value for name, value in answer.headers.items() if name.startswith("access-control-")}


class Headers(unittest.TestCase):
    def lines(self, server, request):
        """The header lines of the first answer, as (name, value)."""
        connection = server.connect()
        with connection, connection.makefile("rwb") as stream:
            stream.write(request)
            stream.flush()
            status = int(stream.readline().split()[1])
            lines = []
            while (line := stream.readline().strip()):
                name, _, value = line.decode("latin-1").partition(":")
                lines.append((name.lower(), value.strip()))
            return status, lines

    def test_every_answer_says_each_thing_once(self):
        host = b" HTTP/1.1\r\nHost: x\r\n"
        with Server("--preload", "six=demo:six", "--max-query-bytes", 1000) as server:
            seen = set()
            for request in (b"GET /healthz" + host + b"\r\n", b"HEAD /v1/scenes/six" + host + b"\r\n", b"GET /nothing" + host + b"\r\n",
                            b"GET /v1/scenes/six/events" + host + b"\r\n", b"OPTIONS /healthz" + host + b"\r\n", b"nonsense\r\n\r\n",
                            b"DELETE /v1/scenes/none" + host + b"\r\n", b"GET /" + b"x" * 9000, b"BREW /healthz" + host + b"\r\n",
                            b"GET /healthz HTTP/1.0\r\n\r\n", b"GET /healthz HTTP/3.0\r\n\r\n", b"GET /openapi.json" + host + b"\r\n",
                            b"POST /v1/scenes/six/rays:any" + host + b"Content-Length: 70000\r\n\r\n", b"GET /metrics" + host + b"\r\n"):
                with self.subTest(request=request[:50]):
                    status, lines = self.lines(server, request)
                    seen.add(status)
                    names = [name for name, _ in lines]
                    self.assertEqual(len(names), len(set(names)), names)
                    self.assertEqual({name: value for name, value in lines if name in ALWAYS}, ALWAYS)
                    self.assertIn("x-request-id", names)
                    self.assertLess(abs(parsedate_to_datetime(dict(lines)["date"]).timestamp() - time.time()), PATIENCE)
                    self.assertEqual(formatdate(parsedate_to_datetime(dict(lines)["date"]).timestamp(), usegmt=True), dict(lines)["date"])
                    self.assertFalse([name for name in names if name.startswith("access-control") or name == "server"])
                    # Where a client that takes compressed answers would get other bytes.
                    is_long = int(dict(lines).get("content-length", 0)) > 1400
                    self.assertEqual(dict(lines).get("vary"), "Accept-Encoding" if is_long else None)
            self.assertEqual(seen, {200, 204, 400, 404, 405, 413, 414, 505})
            # An interim answer is none.
            self.assertEqual(self.lines(server, b"POST /v1/scenes/six/rays:any" + host + b"Content-Type: application/json\r\n"
                                        b"Expect: 100-continue\r\nContent-Length: 10\r\n\r\n"), (100, []))

    def test_a_large_answer_is_whole(self):
        with Server("--preload", "six=demo:six") as server:
            body = json.dumps({"rays": [{"origin": [-10, 1, 0], "direction": [1, 0, 0]}] * 20000, "fields": ["t"]})
            answer = server.query("six", "closest", body)
            self.assertEqual({name: answer.headers[name] for name in ALWAYS}, ALWAYS)
            self.assertEqual(answer.json(), {"hits": [{"t": 4.5}] * 20000})

    def test_pages_may_not_ask_unless_they_are_named(self):
        with Server("--preload", "six=demo:six") as server:
            for arguments in (("-H", f"Origin: {PAGE}"), preflight(PAGE), preflight("null")):
                answer = server.ask("/v1/scenes/six", *arguments)
                self.assertEqual((cors(answer), "vary" in answer.headers), ({}, False))

    def test_pages_of_others_cannot_use_what_only_this_machine_can_reach(self):
        with Server("--preload", "six=demo:six") as server:
            # As a form of another site, or as a page whose name has come to lead here: its origin is then also the Host.
            for origin in (PAGE, "null", "http://evil.example:8080", "http://127.0.0.1.evil.example", "http://localhost.evil.example:80",
                           "http://[::2]:80", "http://[", "http://", "x", "http://[::1].evil.example", "http://127.0.0.1:80.evil.example",
                           "http://localhost:80@evil.example", "http://127.0.0.1:80 http://evil.example", "http://127.0.0.1, http://evil.example",
                           "moz-extension://127.0.0.1", "chrome-extension://localhost", "file://localhost", "http://127.0.0.1/evil"):
                with self.subTest(origin=origin):
                    page = ("-H", f"Origin: {origin}", "-H", "Host: evil.example:8080")
                    for answer in (server.ask("/v1/scenes/six", "-X", "DELETE", *page), server.ask("/v1/scenes/six", *page),
                                   server.query("six", "any", QUERY, *page), server.put("x", b"x", *page)):
                        self.assertEqual((answer.status, answer.json()["code"]), (403, "ORIGIN_NOT_ALLOWED"))
            for origin in ("http://localhost:3000", "http://127.0.0.1", "http://[::1]:8080", f"http://127.0.0.1:{server.port}"):
                self.assertEqual(server.ask("/v1/scenes/six", "-H", f"Origin: {origin}").status, 200)

    def test_other_sites_reach_nothing_of_a_server_without_keys(self):
        # An <img> or a link of another site: a GET without an Origin.
        other, local = ("-H", "Sec-Fetch-Site: cross-site"), "http://localhost:3000"
        fetches = [("no-cors", "image"), ("navigate", "document"), ("navigate", "iframe"), ("cors", "empty")]
        with Server("--preload", "six=demo:six") as server:
            for path in ("/v1/scenes/six/selfcheck?rays=1", "/v1/scenes", "/healthz", "/docs", "/nothing"):
                for mode, target in fetches:
                    with self.subTest(path=path, mode=mode):
                        answer = server.ask(path, *other, "-H", f"Sec-Fetch-Mode: {mode}", "-H", f"Sec-Fetch-Dest: {target}")
                        self.assertEqual((answer.status, answer.json()["code"]), (403, "ORIGIN_NOT_ALLOWED"))
            self.assertEqual(server.query("six", "any", QUERY, "-H", "SEC-FETCH-SITE:Cross-Site").status, 403)
            self.assertEqual(server.ask("/v1/scenes", *other, "-H", f"Origin: {local}").status, 403)
            for site in ("same-origin", "same-site", "none"):
                self.assertEqual(server.ask("/v1/scenes", "-H", f"Sec-Fetch-Site: {site}").status, 200)
        with Server("--cors-origin", PAGE, "--cors-origin", local) as server:
            for origin in (PAGE, local):
                self.assertEqual(server.ask("/v1/scenes", *other, "-H", f"Origin: {origin}").status, 200)
                self.assertEqual(server.ask("/v1/scenes", *other, *preflight(origin, "GET")).status, 204)
            self.assertEqual(server.ask("/v1/scenes", *other).status, 403)
        with Server("--cors-origin", "*") as server:
            self.assertEqual(server.ask("/v1/scenes", *other).status, 200)
        key, line = make_key("read", "page")
        with tempfile.TemporaryDirectory() as folder:
            with Server("--keys", write_keys(Path(folder, "keys"), line)) as server:
                self.assertEqual(server.ask("/v1/scenes", *other, *bearer(key)).status, 200)

    def test_a_host_is_a_name_or_an_address_with_a_port_or_without(self):
        with Server() as server:
            for host in ("[::1].evil.example", "[::1]evil.example", "[::1", "::1]", "[::1]:80.evil.example", "127.0.0.1:80.evil.example",
                         "127.0.0.1:80:90", "localhost:x", "[127.0.0.1]", "[]", "[evil.example]", "a[::1]", "localhost:-1"):
                with self.subTest(host=host):
                    answer = server.ask("/v1/scenes", "-H", f"Host: {host}")
                    self.assertEqual((answer.status, answer.json()["code"]), (400, "HOST_INVALID"))
            for host in ("[::1]", "[::1]:80", "[::ffff:127.0.0.1]:8080", "127.0.0.1:80", "localhost:"):
                self.assertEqual(server.ask("/v1/scenes", "-H", f"Host: {host}").status, 200, host)

    def test_names_that_anybody_may_own_do_not_lead_here(self):
        # A browser tells of no origin when a page asks its own: the name alone is left to see.
        strange = ("evil.example", "evil.example:8080", "EVIL.example.", "127.0.0.1.evil.example", "localhost.evil.example:80", "127.1", "1.2.3.4.5")
        known = ("localhost", "LOCALHOST:1", "localhost.", "a.localhost", "127.0.0.1", "[::1]:80", "10.0.0.7:80", "x", "gate")
        with Server("--preload", "six=demo:six") as server:
            for host, good in [(host, False) for host in strange] + [(host, True) for host in known]:
                with self.subTest(host=host):
                    told = ("-H", f"Host: {host}")
                    for answer in (server.ask("/v1/scenes/six", *told), server.query("six", "any", QUERY, *told), server.ask("/metrics", *told)):
                        self.assertEqual((answer.status, None if good else answer.json()["code"]), (200, None) if good else (403, "HOST_NOT_ALLOWED"))
            self.assertEqual(server.ask("/v1/scenes/six", "-X", "DELETE", "-H", "Host: evil.example").status, 403)
            self.assertEqual(server.ask("/v1/scenes/six").status, 200)
        with Server("--preload", "six=demo:six", "--cors-origin", "http://scenes.example:8080") as server:
            for host, status in (("scenes.example:8080", 200), ("Scenes.example:8080", 200), ("scenes.example", 403), ("evil.example", 403)):
                self.assertEqual(server.ask("/v1/scenes/six", "-H", f"Host: {host}").status, status, host)
        key, line = make_key("read", "page")
        with tempfile.TemporaryDirectory() as folder:
            with Server("--preload", "six=demo:six", "--keys", write_keys(Path(folder, "keys"), line)) as server:
                self.assertEqual(server.ask("/v1/scenes/six", "-H", "Host: proxy.example", *bearer(key)).status, 200)

    def test_a_named_page_may_ask_and_read_faults(self):
        key, line = make_key("read", "page")
        with tempfile.TemporaryDirectory() as folder:
            keys = write_keys(Path(folder, "keys"), line)
            with Server("--preload", "six=demo:six", "--keys", keys, "--cors-origin", PAGE, "--cors-origin", "http://localhost:3000") as server:
                for origin in (PAGE, "http://localhost:3000"):
                    # A browser shows no key yet, and asks alike of what there is and what there is not.
                    for path in ("/v1/scenes/six", "/v1/scenes/none", "/nothing"):
                        answer = server.ask(path, *preflight(origin))
                        self.assertEqual((answer.status, answer.body, answer.headers["vary"]), (204, b"", "Origin"))
                        self.assertEqual(cors(answer), {"access-control-allow-origin": origin, "access-control-max-age": "600",
                                                        "access-control-allow-methods": "GET, HEAD, POST, PUT, PATCH, DELETE",
                                                        "access-control-allow-headers": "Accept, Authorization, Content-Encoding, Content-Type, "
                                                        "If-Match, If-None-Match, Prefer, X-Request-Id, X-Scene-Min-Revision"})
                    page = ("-H", f"Origin: {origin}")
                    asked = server.query("six", "any", QUERY, *page, *bearer(key))
                    missing = server.ask("/v1/scenes/none", *page, *bearer(key))
                    locked = server.ask("/v1/scenes/six", *page)
                    broken = server.ask("/v1/scenes/six", *page, "-H", "Content-Length: x")
                    self.assertEqual([answer.status for answer in (asked, missing, locked, broken)], [200, 404, 401, 400])
                    for answer in (asked, missing, locked):
                        self.assertEqual(answer.headers["access-control-allow-origin"], origin)
                        self.assertIn("X-Request-Id", answer.headers["access-control-expose-headers"])
                        self.assertNotIn("access-control-allow-credentials", answer.headers)
                for origin in ("https://other.example", "https://page.example.evil", "http://page.example", "https://page.example:444",
                               "https://PAGE.example", "null", "*", "https://page.example, https://page.example", ""):
                    with self.subTest(origin=origin):
                        answer = server.ask("/v1/scenes/six", *preflight(origin))
                        self.assertEqual((answer.status, cors(answer)), (401, {}))
                        answer = server.ask("/v1/scenes/six", "-H", f"Origin: {origin}", *bearer(key))
                        self.assertEqual((answer.status, cors(answer), answer.headers["vary"]), (200, {}, "Origin"))
                # OPTIONS that is no preflight is a request like others.
                self.assertEqual(server.ask("/v1/scenes/six", "-X", "OPTIONS", "-H", f"Origin: {PAGE}").status, 401)
                twice = server.ask("/v1/scenes/six", *preflight(PAGE), "-H", f"Origin: {PAGE}")
                self.assertEqual((twice.status, cors(twice)), (401, {}))

    def test_every_page_may_ask_where_that_is_said(self):
        with Server("--preload", "six=demo:six", "--cors-origin", "*") as server:
            self.assertEqual(server.ask("/v1/scenes/six", *preflight("null")).headers["access-control-allow-origin"], "null")
            self.assertIn("[warning] --cors-origin: without --keys", server.log_text())

    def test_a_bad_origin_is_refused_at_the_start(self):
        for origin in ("example.org", "https://", "https://example.org/", "https://example.org/a", "https://Example.org", "ftp://a", "null",
                       "https://a b", "https://a\r\nX: y", "https://*.example.org"):
            with self.subTest(origin=origin):
                done = subprocess.run([BINARY, "serve", "--listen", "127.0.0.1:0", f"--cors-origin={origin}"], capture_output=True,
                                      text=True, timeout=PATIENCE, check=False)
                self.assertEqual((done.returncode, done.stdout), (2, ""))


class Silence(unittest.TestCase):
    """No path of the machine and no text of an exception, in answers or in the log."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="unspeakable")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.said = []

    def ask(self, server, status, *arguments, **options):
        answer = server.ask(*arguments, **options)
        self.said.append(f"{answer.headers} {answer.body.decode('utf-8', 'replace')}")
        self.assertEqual(answer.status, status, self.said[-1])
        return answer

    def check(self, server):
        self.assertEqual(server.stop(), 0)
        text = server.log_text() + "".join(self.said)
        for word in ("unspeakable", str(SOURCE), str(Path(BINARY).parent), "std::", "exception", "what()", ".cpp", "bad_alloc", "errno",
                     "filesystem error", "json.exception", "terminate", "/proc/", "/tmp/"):
            self.assertNotIn(word, text)
        return text

    def test_refusals_name_no_path(self):
        root = self.folder / "root"
        root.mkdir()
        (root / "broken.glb").write_bytes(b"glTF" + bytes(40))
        (root / "folder").mkdir()
        (root / "link.glb").symlink_to("/etc/passwd")
        (root / "pipe.glb").symlink_to("/dev/zero")
        with Server("--preload", "six=demo:six", "--data", self.folder / "data", "--scene-root", root, "--allow-url", "http://127.0.0.1:9/",
                    "--allow-address", "127.0.0.1", "--max-rays", 5, "--max-scene-bytes", 100000, "--log-level", "trace") as server:
            load = "/v1/scenes?wait=60"
            for path in ("none.glb", "../data", "/etc/passwd", "link.glb", "pipe.glb", "folder", "broken.glb", "", "a\0b", "x" * 5000):
                answer = server.ask(load, "-H", JSON_TYPE, body=json.dumps({"id": "a", "source": {"path": path}}))
                self.said.append(str(answer.body))
                self.assertGreaterEqual(answer.status, 400)
            for url in ("http://127.0.0.1:9/x.glb", "http://127.0.0.1:10/", "file:///etc/passwd", "http://[/"):
                answer = server.ask(load, "-H", JSON_TYPE, body=json.dumps({"id": "a", "source": {"url": url}}))
                self.said.append(str(answer.body))
                self.assertGreaterEqual(answer.status, 400)
            for case in sorted((SOURCE / "tests/data/hostile/cases").iterdir())[::4]:
                answer = server.put("hostile", case.read_bytes())
                self.said.append(str(answer.body))
            for body in ("{", '{"rays":{}}', '{"rays":[{}]}', '{"rays":[],"x":1}', "[" * 5000, '{"rays":[' + "{}," * 6 + "{}]}", "\0", b"\xff\xfe"):
                answer = server.query("six", "closest", body)
                self.said.append(str(answer.body))
            for path in ("/v1/scenes/six/triangles?ids=x", "/v1/scenes/six/nodes?first=x", "/v1/scenes/six/selfcheck?rays=x", "/v1/scenes/six?wait=x",
                         "/v1/scenes/..%2f..%2fdata", "/%00", "/v1/scenes/" + "a" * 300):
                self.said.append(str(server.ask(path).body))
            self.ask(server, 413, "/v1/scenes/big", "-X", "PUT", body=bytes(100001))
            self.ask(server, 422, "/v1/scenes/..", "--path-as-is", "-X", "PUT", body=b"x")
            self.check(server)

    def test_a_broken_data_folder_is_told_of_without_its_path(self):
        data = self.folder / "data"
        with Server("--data", data) as server:
            for name in ("good", "damaged", "torn"):
                self.assertEqual(server.put(name, demo_glb("six") + {"good": b"", "damaged": b" " * 4, "torn": b" " * 8}[name]).status, 201)
        (data / "scenes" / "torn.json").write_text("{", encoding="utf-8")
        blobs = sorted((data / "blobs").iterdir(), key=lambda blob: blob.stat().st_size)
        blobs[1].write_bytes(b"x" * blobs[1].stat().st_size)
        with Server("--data", data, "--log-level", "trace") as server:
            self.assertEqual(set(self.ask(server, 200, "/readyz").json()["failed"]), {"damaged", "torn"})
            for name in ("damaged", "torn"):
                self.ask(server, 200, f"/v1/scenes/{name}")
                self.ask(server, 409, f"/v1/scenes/{name}/rays:any", "-H", JSON_TYPE, body=QUERY)
            # From here on nothing can be written.
            shutil.rmtree(data / "tmp")
            (data / "tmp").write_bytes(b"")
            self.ask(server, 500, "/v1/scenes/new", "-X", "PUT", body=demo_glb("six"))
            text = self.check(server)
            self.assertIn("scene failed scene=damaged", text)


if __name__ == "__main__":
    case_report.main()
