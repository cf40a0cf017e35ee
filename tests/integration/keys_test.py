"""Who may ask what: keys, roles, and that neither answers nor logs say more than they should."""

import hashlib
import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import case_report
from sightline_server import BINARY, JSON_TYPE, PATIENCE, SOURCE, Server, bearer, curl, demo_glb, make_key, read_answer, write_keys

sys.path.insert(0, str(SOURCE / "proto/python"))
from sightline import Sightline, SightlineError

DOCUMENT = json.loads((SOURCE / "proto/openapi.json").read_text(encoding="utf-8"))
QUERY = '{"rays":[{"origin":[-10,1,0],"direction":[1,0,0]}],"fields":["t"]}'


def plain(answer):
    """What a client sees, without what differs each time."""
    headers = {name: value for name, value in answer.headers.items() if name not in ("date", "x-request-id")}
    return answer.status, headers, re.sub(rb'"request_id":"[^"]*"', b"", answer.body)


def refused_start(*arguments):
    done = subprocess.run([BINARY, "serve", *map(str, arguments)], capture_output=True, text=True, timeout=PATIENCE, check=False)
    return done.returncode, done.stdout + done.stderr


class Keys(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        (cls.read, read_line), (cls.write, write_line) = make_key("read", "reader"), make_key("write", "ci")
        cls.file = write_keys(cls.folder / "keys", "# who may ask", "", read_line, write_line)
        cls.server = Server("--preload", "six=demo:six", "--keys", cls.file, "--log-level", "trace")
        cls.addClassCleanup(cls.server.end)

    def post_query(self, *arguments):
        return self.server.ask("/v1/scenes/six/rays:closest", "-H", JSON_TYPE, *arguments, body=QUERY)

    def test_each_operation_needs_the_role_that_the_document_says(self):
        for path, item in DOCUMENT["paths"].items():
            for method, operation in item.items():
                if method == "parameters":
                    continue
                (needed,) = operation.get("security", DOCUMENT["security"]) or [{"key": ["none"]}]
                needed = needed["key"][0]
                # A body that no route takes for good, so that nothing changes and nothing waits.
                body = b"?" if method in ("post", "put") else None
                arguments = ["-X", method.upper(), "-H", "Content-Type: text/plain"]
                with self.subTest(method=method, path=path):
                    target = path.replace("{id}", "none")
                    answers = [self.server.ask(target, *arguments, *more, body=body)
                               for more in ((), bearer(self.read), bearer(self.write))]
                    locked = [answer.status in (401, 403) for answer in answers]
                    self.assertEqual(locked, {"none": [False] * 3, "read": [True, False, False],
                                              "write": [True, True, False]}[needed], [a.status for a in answers])
                    if needed == "write":
                        self.assertEqual((answers[1].status, answers[1].json()["code"]), (403, "FORBIDDEN"))

    def test_without_a_key_every_answer_is_the_same(self):
        first = plain(self.server.ask("/v1/scenes/six"))
        self.assertEqual((first[0], first[1]["www-authenticate"], first[1]["content-type"]),
                         (401, 'Bearer realm="sightline"', "application/problem+json"))
        self.assertIn("Authorization: Bearer KEY", self.server.ask("/v1/scenes/six").json()["detail"])
        body = "x" * 100
        for path, arguments, body in [("/v1/scenes/none", (), None), ("/nothing", (), None), ("/page", (), None), ("/version", (), None),
                                      ("/metrics", (), None), ("/openapi.json", (), None), ("/v1/scenes/%zz", (), None),
                                      ("/v1/scenes", (), None), ("/v1/scenes", (), body), ("/v1/scenes/six/rays:any", (), body),
                                      ("/v1/scenes/none/rays:any", (), body), ("/v1/scenes/six", ("-X", "PUT"), body),
                                      ("/v1/scenes/six", ("-X", "DELETE"), None), ("/v1/scenes/six", ("-X", "BREW"), None),
                                      ("/v1/scenes/six", ("-X", "OPTIONS"), None), ("/healthz", ("-X", "OPTIONS"), None),
                                      ("/healthz", ("-X", "DELETE"), None), ("/v1/scenes/six", bearer("slk_" + "x" * 43), None),
                                      ("/v1/scenes/none", bearer("x"), None)]:
            with self.subTest(path=path, arguments=arguments):
                self.assertEqual(plain(self.server.ask(path, *arguments, body=body)), first)
        head = self.server.exchange(b"HEAD /v1/scenes/six HTTP/1.1\r\nHost: x\r\n\r\n" )
        self.assertEqual([(answer.status, answer.body) for answer in head], [(401, b"")])

    def test_a_key_is_only_good_as_it_was_given(self):
        key = self.read
        for scheme in ("Bearer", "bearer", "BEARER", "Bearer  "):
            with self.subTest(scheme=scheme):
                self.assertEqual(self.post_query("-H", f"Authorization: {scheme} {key}").status, 200)
        for value in ("Bearer", "Bearer ", key, f"Basic {key}", f"Bearer {key}x", f"Bearer {key[:-1]}", f"Bearer {key.upper()}",
                      f"Bearer {key} x", f'Bearer "{key}"', f"Bearer,{key}", f"Bearer\t{key}", "Bearer " + "x" * 5000,
                      "Bearer " + hashlib.sha256(key.encode()).hexdigest()):
            with self.subTest(value=value[:80]):
                self.assertEqual(self.post_query("-H", f"Authorization: {value}").status, 401)
        twice = self.server.exchange(b"GET /v1/scenes HTTP/1.1\r\nHost: x\r\n", *[f"Authorization: Bearer {key}\r\n".encode()] * 2, b"\r\n")
        self.assertEqual([answer.status for answer in twice], [401])
        for path in (f"/v1/scenes?key={key}", f"/v1/scenes?access_token={key}", f"/v1/scenes/{key}"):
            self.assertEqual(self.server.ask(path).status, 401)
        user = curl(self.server.url.replace("http://", f"http://{key}:{key}@") + "/v1/scenes")
        self.assertEqual(user.status, 401)

    def test_other_spellings_of_a_path_open_nothing(self):
        load = b'{"id":"x","source":{"path":"x.glb"}}'
        tail = b" HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nConnection: close\r\nContent-Length: %d\r\n" % len(load)
        key = f"Authorization: Bearer {self.read}\r\n\r\n".encode()
        for target, statuses in [(b"/v1/scenes", {403}), (b"/v1/%73cenes", {403}), (b"/%761/scenes?wait=1", {403}),
                                 (b"http://x/v1/scenes", {403}), (b"HTTP://x/v1/scenes", {403}), (b"/v1/scenes#", {400}),
                                 (b"/v1/scenes#/x", {400}), (b"/v1/scenes/", {404}), (b"//v1/scenes", {404}),
                                 (b"/v1/./scenes", {404}), (b"/v1/scenes;x", {404}), (b"/V1/scenes", {404})]:
            with self.subTest(target=target):
                answers = self.server.exchange(b"POST " + target + tail + key + load)
                self.assertEqual(len(answers), 1)
                self.assertIn(answers[0].status, statuses)
        for name in ("X-HTTP-Method-Override", "X-HTTP-Method", "X-Method-Override"):
            answer = self.server.ask("/v1/scenes/six/rays:closest", *bearer(self.read), "-H", f"{name}: DELETE", "-H", JSON_TYPE, body=QUERY)
            self.assertEqual(answer.status, 200)
        self.assertEqual(self.server.ask("/v1/scenes/six", *bearer(self.read)).status, 200)

    def test_a_key_is_asked_for_before_the_body(self):
        for head in (b"PUT /v1/scenes/x HTTP/1.1\r\nHost: x\r\nContent-Length: 4000000000\r\n\r\n",
                     b"POST /v1/scenes/six/rays:any HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\n",
                     b"PUT /v1/scenes/x HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n",
                     b"PUT /v1/scenes/x HTTP/1.1\r\nHost: x\r\nContent-Length: 10\r\nExpect: 100-continue\r\n\r\n"):
            with self.subTest(head=head):
                self.assertEqual([(answer.status, answer.headers["connection"]) for answer in self.server.exchange(head)], [(401, "close")])
        # What follows a refused request is never one.
        hidden = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"
        answers = self.server.exchange(hidden, b"DELETE /v1/scenes/six HTTP/1.1\r\nHost: x\r\n\r\n", hidden)
        self.assertEqual([answer.status for answer in answers], [200, 401])

    def test_a_writer_puts_and_removes_scenes(self):
        put = self.server.put("mine", demo_glb("six"), *bearer(self.write))
        self.assertEqual(put.status, 201)
        self.assertEqual(self.server.ask("/v1/scenes/mine", "-X", "DELETE", *bearer(self.read)).status, 403)
        self.assertEqual(self.server.put("mine", b"x", *bearer(self.read)).status, 403)
        self.assertEqual(self.server.query("mine", "closest", QUERY, *bearer(self.read)).status, 200)
        self.assertEqual(self.server.ask("/v1/scenes/mine", "-X", "DELETE", *bearer(self.write)).status, 204)

    def test_the_python_client_shows_its_key(self):
        with Sightline(self.server.url, key=self.read) as client:
            self.assertEqual(list(client.closest("six", [[-10, 1, 0]], [[1, 0, 0]])["t"]), [4.5])
        with Sightline(self.server.url) as client, self.assertRaises(SightlineError) as refused:
            client.scenes()
        self.assertEqual((refused.exception.status, refused.exception.code), (401, "UNAUTHORIZED"))

    def test_health_is_open_and_names_nothing(self):
        self.assertEqual(self.server.ask("/healthz").status, 200)
        self.assertEqual(self.server.ask("/readyz").json(), {"status": "ready"})
        self.assertEqual(self.server.ask("/readyz", *bearer("x")).json(), {"status": "ready"})
        self.assertEqual(self.server.ask("/readyz", *bearer(self.read)).json()["scenes"]["ready"], 1)

    def test_no_key_in_any_answer_or_log(self):
        wrong = "slk_" + "W" * 43
        with Server("--preload", "six=demo:six", "--keys", self.file, "--log-level", "trace") as server:
            said = []
            for key in (self.read, self.write, wrong):
                for place in (bearer(key), ("-H", f"Authorization: Basic {key}"), ("-H", f"X-Request-Id: {key}"), ("-H", f"X-Api-Key: {key}"),
                              ("-H", f"Cookie: key={key}"), ("-A", key), ("-e", key)):
                    for path in ("/v1/scenes/six", f"/v1/scenes/{key}", f"/v1/scenes/six?key={key}", f"/{key}", f"/v1/scenes/{key}/nodes",
                                 "/version", "/metrics", "/readyz", "/%zz" + key):
                        for more in ((), bearer(self.write)):
                            said.append(server.ask(path, *place, *more))
                for method in ("PUT", "DELETE", "BREW", "OPTIONS", "POST", key[:30]):
                    said.append(server.ask(f"/v1/scenes/{key}/x", "-X", method, *bearer(self.write), body=b"x"))
                connection = server.connect()
                with connection, connection.makefile("rwb") as stream:
                    stream.write(f"GET /{key} HTTP/1.1\r\nX-Request-Id: {key}\r\nAuthorization: {key}\r\nHost: x\r\nHost: {key}\r\n\r\n".encode())
                    stream.flush()
                    said.append(read_answer(stream))
            self.assertEqual(server.stop(), 0)
            log = server.log_text()
        self.assertIn("request refused method=GET status=401", log)
        self.assertIn(" key=ci\n", log)
        text = log + "".join(f"{answer.headers} {answer.body.decode('utf-8', 'replace')}" for answer in said)
        for key in (self.read, self.write, wrong):
            self.assertNotIn(key[4:30], text)
        self.assertGreater(len({answer.status for answer in said}), 4)

    def test_no_key_of_ones_own_making_in_the_log(self):
        own = "my-own.Secret_42"
        line = f"write mine sha256:{hashlib.sha256(own.encode()).hexdigest()}"
        file = write_keys(self.folder / "own", line)
        with Server("--preload", "six=demo:six", "--keys", file, "--log-level", "trace") as server:
            for shown in ((), bearer(own), bearer("x")):
                for path in ("/v1/scenes/six", f"/v1/scenes/{own}", f"/v1/scenes/{own}/nodes", f"/v1/scenes/{own.replace('-', '%2D')}",
                             f"/v1/scenes/six?key={own}", f"/{own}", "/healthz"):
                    server.ask(path, "-H", f"X-Request-Id: {own}", *shown)
            # Inside of other text, by a request that shows the key.
            server.ask(f"/v1/scenes/a{own}b", "-H", f"X-Request-Id: a{own}b", *bearer(own))
            server.put(own, b"no scene", *bearer(own))
            server.ask("/v1/scenes", "-H", f"X-Request-Id: {own}", "-H", "Content-Length: x")
            server.ask("/v1/scenes", "-H", f"X-Request-Id: {own}", "-H", "Content-Length: 1", "-H", "Transfer-Encoding: chunked", *bearer(own))
            answer = server.ask("/v1/scenes/six", "-H", "X-Request-Id: an-id", *bearer(own))
            self.assertEqual((answer.status, answer.headers["x-request-id"]), (200, "an-id"))
            self.assertNotIn(own, server.ask("/v1/scenes/six", "-H", f"X-Request-Id: {own}", *bearer(own)).headers["x-request-id"])
            self.assertEqual(server.stop(), 0)
            log = server.log_text()
        self.assertNotIn(own, log)
        self.assertIn("path=/v1/scenes/{id} ", log)
        self.assertIn("path=/v1/scenes/six ", log)
        self.assertIn("id=an-id key=mine", log)

    def test_the_log_names_who_asked(self):
        self.server.ask("/v1/scenes/six", *bearer(self.read), "-H", "X-Request-Id: who-asked")
        self.assertRegex(self.server.log_text(), r"request method=GET path=/v1/scenes/six status=200 .* id=who-asked key=reader\n")


class KeyFiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = Path(folder.name, "keys")

    def test_a_new_key_is_random_and_its_line_has_only_its_hash(self):
        made = [make_key(role, "a.b-c_1") for role in ("read", "write", "write")]
        self.assertEqual(len({key for key, _ in made}), 3)
        for (key, line), role in zip(made, ("read", "write", "write")):
            self.assertRegex(key, "^slk_[A-Za-z0-9_-]{43}$")
            self.assertEqual(line, f"{role} a.b-c_1 sha256:{hashlib.sha256(key.encode()).hexdigest()}")
        for arguments in (("--role", "admin", "--name", "x"), ("--role", "read", "--name", "a b"), ("--role", "read"), ("--name", "x"),
                          ("--role", "read", "--name", made[0][0])):
            done = subprocess.run([BINARY, "key", "new", *arguments], capture_output=True, text=True, timeout=PATIENCE, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertNotIn(made[0][0], done.stderr)

    def test_a_bad_file_stops_the_start_with_the_place_and_not_the_text(self):
        key, line = make_key("read", "x")
        role, name, digest = line.split()
        for text, place in [(key, "line 1"), (f"{line}\n{role} y {key}", "line 2"), (f"\n# \n{role} {name}", "line 3"),
                            (f"admin {name} {digest}", "line 1"), (f"{role} a/b {digest}", "line 1"), (f"{line} x", "line 1"),
                            (f"{line}\n{line}", "line 2"), (f"{line}\n{role} y {digest}", "line 2"),
                            (f"{role} {name} {digest.upper()}", "line 1"), (f"{role} {name} {digest[:-1]}", "line 1"),
                            (f"{role} {name} sha1:{digest[7:]}", "line 1"), (f"{role} {name} {digest}\0", "line 1")]:
            with self.subTest(text=text):
                self.file.write_text(text, encoding="ascii")
                code, said = refused_start("--listen", "127.0.0.1:0", "--keys", self.file)
                self.assertEqual(code, 2)
                self.assertIn("KEYS_INVALID", said)
                self.assertIn(place + " ", said)
                self.assertNotIn(key, said)
                self.assertNotIn(digest[7:-1], said.lower())
        for bad in (self.file.parent, self.file.parent / "none", "/dev/null"):
            self.assertEqual(refused_start("--listen", "127.0.0.1:0", "--keys", bad)[0], 2)
        self.file.write_text("# \n" * 400_000, encoding="ascii")
        self.assertEqual(refused_start("--listen", "127.0.0.1:0", "--keys", self.file)[0], 2)

    def test_a_file_that_others_can_reach_or_without_keys_is_warned_of(self):
        _, line = make_key("read", "x")
        for text, mode, warning in [(line, 0o600, None), (line, 0o640, None), (line, 0o604, "others can read"),
                                    (line, 0o620, "others can write"), ("# none\n", 0o600, "no key")]:
            with self.subTest(mode=oct(mode), text=text):
                self.file.write_text(text, encoding="ascii")
                self.file.chmod(mode)
                with Server("--keys", self.file) as server:
                    self.assertEqual(server.ask("/v1/scenes").status, 401)
                    self.assertEqual("[warning]" in server.log_text(), warning is not None, server.log_text())
                    self.assertIn(warning or "", server.log_text())

    def test_without_keys_only_this_machine_may_ask(self):
        for address in ("0.0.0.0:0", "[::]:0", "192.0.2.1:0", "[::ffff:10.0.0.1]:0", "example.org:0", "0:0", "localhost.example.org:0"):
            with self.subTest(address=address):
                code, said = refused_start("--listen", address)
                self.assertEqual(code, 2)
                self.assertIn("--keys", said)
                self.assertIn("--insecure", said)
        _, line = make_key("read", "x")
        self.file.write_text(line, encoding="ascii")
        for arguments, status in [(("--insecure",), 200), (("--keys", self.file), 401), (("--keys", self.file, "--insecure"), 401)]:
            process = subprocess.Popen([BINARY, "serve", "--listen", "0.0.0.0:0", *arguments], stdout=subprocess.PIPE,
                                       stderr=subprocess.DEVNULL, text=True)
            try:
                url = process.stdout.readline().split()[-1].replace("0.0.0.0", "127.0.0.1")
                self.assertEqual(curl(url + "/v1/scenes").status, status)
            finally:
                process.terminate()
                process.wait(timeout=PATIENCE)
                process.stdout.close()


if __name__ == "__main__":
    case_report.main()
