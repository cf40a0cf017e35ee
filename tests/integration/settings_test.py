"""Settings from a file, what SIGHUP takes from it again, and that nothing is half taken."""

import contextlib
import json
import os
import pty
import re
import signal
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

import case_report
from sightline_server import BINARY, PATIENCE, Server, bearer, curl, demo_glb, make_key, read_answer, write_keys

# What SIGHUP changes: a setting, a value, and where /version shows it (or None).
LIVE = [("max-scene-bytes", 1001, "scene_bytes", 1001), ("max-query-bytes", 1002, "query_bytes", 1002), ("max-rays", 1003, "rays", 1003),
        ("max-hits", 1004, "hits", 1004), ("request-seconds", 1.5, "request_ms", 1500), ("max-connections", 105, "connections", 105),
        ("max-header-bytes", 1006, "header_bytes", 1006), ("max-header-fields", 17, "header_fields", 17),
        ("header-seconds", 1.25, "header_ms", 1250), ("idle-seconds", 19, "idle_ms", 19000), ("min-rate", 10, "rate_bytes_per_second", 10),
        ("busy-rate", 11, "busy_bytes_per_second", 11),
        ("rate-seconds", 2, "rate_ms", 2000), ("body-seconds", 21, "body_ms", 21000), ("drain-seconds", 22, "drain_ms", 22000),
        ("notice-seconds", 0.5, "notice_ms", 500), ("log-level", "info", None, None)]


def run(*arguments):
    done = subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True, timeout=PATIENCE, check=False)
    return done.returncode, done.stdout, done.stderr


class Settings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.config, self.keys = self.folder / "sightline.json", self.folder / "keys"

    def write(self, **settings):
        self.config.write_text(json.dumps({name.replace("_", "-"): value for name, value in settings.items()}), encoding="utf-8")

    def hang_up(self, server):
        """SIGHUP; returns what it made the server say."""
        def ends():
            return len(re.findall(r"\] reloaded(, .* unchanged)?\n", server.log_text()))

        before = ends()
        at = len(server.log_text())
        server.signal(signal.SIGHUP)
        while ends() == before:
            self.assertIsNone(server.process.poll())
        return server.log_text()[at:]

    def limits(self, server):
        return server.ask("/version").json()["limits"]

    def test_check_config_says_yes_or_every_mistake(self):
        self.write(max_rays=5, preload=["a=demo:six"])
        self.assertEqual(run("check-config", self.config), (0, f"{self.config}: good\n", ""))
        self.config.write_text('{\n "max-rays": 0, "idle-seconds": "long",\n "colour": 1\n}\n', encoding="utf-8")
        code, out, complaints = run("check-config", self.config)
        self.assertEqual((code, out), (2, ""))
        lines = complaints.splitlines()
        self.assertEqual([line.split(": ")[:2] for line in lines],
                         [[f"{self.config}:2", "max-rays"], [f"{self.config}:2", "idle-seconds"], [f"{self.config}:3", "colour"]])
        # A server refuses the same file with the same words.
        code, out, refused = run("serve", "--config", self.config)
        self.assertEqual((code, out, refused.replace("sightline: ", "")), (2, "", complaints))
        self.assertEqual(run("check-config", self.folder / "none")[0], 2)

    def test_check_config_refuses_what_a_server_would(self):
        write_keys(self.keys, "read a")
        for bad in ({"kernel": "mmx"}, {"data": "/proc/nope"}, {"data": str(self.config)}, {"insecure": 5}, {"listen": "0.0.0.0:0"},
                    {"keys": str(self.keys)}, {"preload": ["a=demo:six", "a=demo:town"]}):
            with self.subTest(bad=bad):
                self.config.write_text(json.dumps({"max-rays": 5, **bad}, indent=1), encoding="utf-8")
                code, out, complaints = run("check-config", self.config)
                self.assertEqual((code, out, complaints.count("\n")), (2, "", 1))
                self.assertTrue(complaints.startswith(f"{self.config}:3: {[*bad][0]}: "), complaints)
                self.assertEqual(run("serve", "--config", self.config)[:2], (2, ""))
        self.write(cors_origin="https://a.example", data=str(self.folder / "new"))
        code, out, complaints = run("check-config", self.config)
        self.assertEqual((code, out), (0, f"{self.config}: good\n"))
        self.assertRegex(complaints, r":1: cors-origin: without --keys .* \(a warning\)\n$")
        self.assertFalse((self.folder / "new").exists())

    def test_help_is_a_command_too(self):
        for asked, flag in ((["help"], ["--help"]), (["help", "key", "new"], ["key", "new", "--help"])):
            self.assertEqual(run(*asked), run(*flag))
            self.assertEqual(run(*asked)[0], 0)

    def test_a_start_says_what_is_in_its_way(self):
        def refused(*arguments):
            code, out, complaints = run(*arguments)
            self.assertEqual((code, out), (2, ""))
            return complaints

        loop = self.folder / "loop"
        loop.symlink_to(loop)
        with Server("--data", self.folder / "data") as server:
            self.assertIn(f"127.0.0.1:{server.port}: Address already in use", refused("serve", "--listen", f"127.0.0.1:{server.port}"))
            self.assertIn(f"--data {self.folder}/data: the data folder is in use", refused("serve", "--data", self.folder / "data"))
        self.assertIn("Too many levels", refused("serve", "--preload", f"a={loop}"))
        self.assertIn("--data: the name of a folder is not empty", refused("serve", "--data", ""))
        self.assertIn("'a' is given twice", refused("serve", "--preload", "a=demo:six", "--preload", "a=demo:six"))
        self.assertEqual(refused("frob"), "sightline: there is no command 'frob'\nSee sightline --help\n")
        self.assertIn("; similar: \"cast\"\n", refused("cats"))
        self.assertIn("--lisen; similar: \"--listen\"\nSee sightline serve --help\n", refused("serve", "--lisen", "127.0.0.1:0"))
        self.assertIn("--feilds=t; similar: \"--fields\"\n", refused("query", "http://127.0.0.1:1", "six", "--feilds=t"))
        self.assertEqual(refused("serv"), "sightline: there is no command 'serv'; similar: \"serve\"\nSee sightline --help\n")
        said = refused("key", "new", "--role", "read", "--name", ".a")
        self.assertIn("does not begin with a dot", said)
        self.assertIn("\nSee sightline key new --help\n", said)
        self.keys.mkdir()
        said = refused("serve", "--keys", self.folder / "none")
        self.config.write_text("x", encoding="utf-8")
        said = refused("serve", "--keys", self.config)
        self.assertIn(f"--keys {self.config}: line 1", said)
        ray = ("a", "--origin", "0,0,0", "--direction", "0,0,1")
        self.assertIn("nothing takes connections", refused("query", f"http://127.0.0.1:{server.port}", *ray))
        self.assertEqual(refused("query", "http://127.0.0.1:1", *ray, "--key-file", self.folder / "none").count("cannot"), 1)

    def test_a_server_takes_its_settings_from_a_file(self):
        self.write(preload=["a=demo:six", "b=demo:town"], max_rays=7, idle_seconds=1.5, fetch_seconds=7, memory_budget=10**9, data=str(self.folder / "data"))
        with Server("--config", self.config, "--max-hits", 9) as server:
            limits = self.limits(server)
            self.assertEqual((limits["rays"], limits["hits"], limits["idle_ms"]), (7, 9, 1500))
            self.assertEqual((limits["fetch_ms"], limits["memory_budget"]), (7000, 10**9))
            self.assertEqual([scene["id"] for scene in server.ask("/v1/scenes").json()["scenes"]], ["a", "b"])

    def test_sighup_changes_every_limit_that_the_help_says_it_does(self):
        _, help_text, _ = run("serve", "--help")
        live = help_text.split("Changed by SIGHUP, from --config:")[1].split("\n\n")[0]
        self.assertEqual(set(re.findall(r"^  --([\w-]+)", live, re.MULTILINE)), {name for name, *_ in LIVE})
        self.write()
        process = ("--config", self.config, "--log-level", "debug")
        # The level of the log is given by hand here, and so stays.
        with Server(*process) as server:
            before = self.limits(server)
            self.write(**{name: value for name, value, _, _ in LIVE})
            said = self.hang_up(server)
            after = self.limits(server)
            for name, value, shown, number in LIVE:
                with self.subTest(name=name):
                    if name == "log-level":
                        continue
                    self.assertIn(f"setting changed name={name} value={value}\n", said)
                    if shown:
                        self.assertNotEqual(before[shown], number)
                        self.assertEqual(after[shown], number)
            self.assertEqual(server.query("none", "any", {"rays": []}, "-H", "X: " + "x" * 1000).status, 431)
            self.write()
            self.hang_up(server)
            self.assertEqual(self.limits(server), before)

    def test_what_a_start_decides_is_left_alone_and_named(self):
        self.write(workers=8, max_rays=5)
        with Server("--config", self.config) as server:
            self.write(workers=9, max_rays=6, max_queue=1, scene_root=str(self.folder))
            said = self.hang_up(server)
            for name in ("workers", "max-queue", "scene-root"):
                self.assertIn(f"setting waits for the next start name={name}\n", said)
            limits = self.limits(server)
            self.assertEqual((limits["workers"], limits["queue"], limits["rays"]), (8, 512, 6))

    def test_a_bad_file_leaves_the_old_in_force_and_says_so(self):
        key, line = make_key("read", "a")
        write_keys(self.keys, line)
        self.write(max_rays=5, keys=str(self.keys))
        with Server("--config", self.config) as server:
            for bad in ('{"max-rays": 0}', '{"max-rays": 6', '{"max-rays": 6, "max-hits": -1}', '{"colour": 1}', None):
                with self.subTest(bad=bad):
                    self.config.unlink()
                    if bad is not None:
                        self.config.write_text(bad, encoding="utf-8")
                    said = self.hang_up(server)
                    self.assertIn("the settings stay as they were", said)
                    self.assertIn("] reloaded, settings unchanged\n", said)
                    self.assertNotIn("sightline", said.replace("sightline.json", ""))
                    self.assertNotIn(str(self.folder), said)
                    self.config.write_text("", encoding="utf-8")
                    limits = server.ask("/version", *bearer(key)).json()["limits"]
                    self.assertEqual(limits["rays"], 5)
            for turn, bad in enumerate((key, "read a", None)):
                with self.subTest(keys=bad):
                    # Each for itself: good settings are taken beside bad keys, and beside none.
                    self.write(max_rays=6 + turn, keys=str(self.keys))
                    self.keys.unlink()
                    if bad is not None:
                        self.keys.write_text(bad, encoding="ascii")
                    said = self.hang_up(server)
                    self.assertIn("the keys stay as they were", said)
                    self.assertIn("] reloaded, keys unchanged\n" if bad is None else ", keys", said)
                    self.assertNotIn(key, said)
                    self.keys.write_text("", encoding="ascii")
                    self.assertEqual(server.ask("/version", *bearer(key)).json()["limits"]["rays"], 6 + turn)

    def test_sighup_takes_keys_in_and_out(self):
        (first, first_line), (second, second_line) = make_key("read", "first"), make_key("write", "second")
        write_keys(self.keys, first_line)
        with Server("--keys", self.keys) as server:
            connection = server.connect()
            with connection, connection.makefile("rwb") as stream:
                def ask():
                    stream.write(f"GET /v1/scenes HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {first}\r\n\r\n".encode())
                    stream.flush()
                    return read_answer(stream).status
                self.assertEqual(ask(), 200)
                self.assertEqual(server.ask("/v1/scenes", *bearer(second)).status, 401)
                self.keys.write_text(second_line, encoding="ascii")
                self.hang_up(server)
                # A connection that is open already is asked again with each request.
                self.assertEqual(ask(), 401)
            self.assertEqual(server.ask("/v1/scenes", *bearer(second)).status, 200)

    def test_streams_end_with_their_key(self):
        (stays, kept_line), (goes, lost_line) = make_key("write", "stays"), make_key("read", "goes")
        write_keys(self.keys, kept_line, lost_line)
        body = demo_glb("town")  # too long for the event loop to wait for
        with contextlib.ExitStack() as stack:
            server = stack.enter_context(Server("--preload", "six=demo:six", "--keys", self.keys, "--rate-seconds", PATIENCE))

            def ask(method, path, key, *more):
                stream = stack.enter_context(stack.enter_context(server.connect()).makefile("rwb"))
                head = f"{method} /v1/scenes/{path} HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {key}\r\nConnection: close\r\n"
                stream.write(head.encode() + b"".join(more))
                stream.flush()
                return stream

            put = ask("PUT", "slow", stays, b"Content-Length: %d\r\n\r\n" % len(body), body[:-1])
            while server.ask("/v1/scenes/slow", *bearer(stays)).status != 200:
                pass
            listeners = [ask("GET", "slow/events", key, b"\r\n") for key in (stays, goes)]
            for listener in listeners:
                while b"event: progress" not in listener.readline():
                    pass
            line = b'{"origin":[-10,1,0],"direction":[1,0,0]}\n'
            rays = ask("POST", "six/rays:any", goes, b"Content-Type: application/x-ndjson\r\nTransfer-Encoding: chunked\r\n\r\n",
                       b"%x\r\n%s\r\n" % (len(line), line))
            while b"true" not in rays.readline():
                pass
            self.keys.write_text(kept_line, encoding="ascii")
            self.hang_up(server)
            self.assertNotIn(b"event: ready", listeners[1].read())
            rays.write(b"%x\r\n%s\r\n" % (len(line), line))
            rays.flush()
            rest = rays.read()
            self.assertIn(b"CANCELLED", rest)
            self.assertNotIn(b"true", rest)
            put.write(body[-1:])
            put.flush()
            self.assertIn(b"event: ready", listeners[0].read())
            self.assertEqual(read_answer(put).status, 201)

    def test_requests_go_on_while_it_reloads_again_and_again(self):
        key, line = make_key("read", "a")
        self.keys.write_text(line, encoding="ascii")
        self.write(keys=str(self.keys), max_rays=5)
        with Server("--config", self.config) as server:
            statuses, done = set(), threading.Event()

            def ask():
                connection = server.connect()
                with connection, connection.makefile("rwb") as stream:
                    while not done.is_set():
                        stream.write(f"GET /v1/scenes HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {key}\r\n\r\n".encode())
                        stream.flush()
                        statuses.add(read_answer(stream).status)
            askers = [threading.Thread(target=ask) for _ in range(4)]
            for asker in askers:
                asker.start()
            for turn in range(20):
                self.write(keys=str(self.keys), max_rays=5 + turn, idle_seconds=30 + turn)
                self.hang_up(server)
            done.set()
            for asker in askers:
                asker.join()
            self.assertEqual(statuses, {200})

    def test_sighup_hastens_no_stop(self):
        with Server("--drain-seconds", PATIENCE * 10, "--rate-seconds", PATIENCE * 10) as server:
            upload = server.connect()
            upload.sendall(b"PUT /v1/scenes/a HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: 4\r\n\r\n")
            with upload, upload.makefile("rb") as stream:
                self.assertEqual(read_answer(stream).status, 100)
                server.signal()
                while "stopping" not in server.log_text():
                    pass
                for _ in range(3):
                    server.signal(signal.SIGHUP)
                upload.sendall(b"xxxx")
                self.assertEqual(read_answer(stream).status, 400)
            self.assertEqual(server.wait(), 0)
            self.assertNotIn("aborting requests", server.log_text())

    def test_a_terminal_that_goes_away_ends_the_server(self):
        child, terminal = pty.fork()
        if child == 0:
            os.execv(BINARY, [BINARY, "serve", "--listen", "127.0.0.1:0"])
        with os.fdopen(terminal, "rb", buffering=0) as stream:
            text = b""
            while b"listening on" not in text or not text.endswith(b"\n"):
                text += stream.read(1)
            url = re.search(rb"http://\S+", text).group().decode()
            self.assertEqual(curl(url + "/healthz").status, 200)
        _, status = os.waitpid(child, 0)
        self.assertEqual(os.waitstatus_to_exitcode(status), 0)


if __name__ == "__main__":
    case_report.main()
