"""Disks that are full, or fail: what is refused leaves nothing behind, and what was acknowledged stays."""

import http.client
import json
import os
import re
import resource
import signal
import socket
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import case_report
import opened_files
from kills import grid_glb
from process_status import is_sanitized
from sightline_server import PATIENCE, Server, demo_glb

RAY = ([-10, 1, 0], [1, 0, 0])
DOWN = ([0.5, 9, 0.4], [0, -1, 0])
REFUSED = {"ENOSPC": (507, "STORE_FULL"), "EDQUOT": (507, "STORE_FULL"), "EIO": (500, "STORE_IO")}
FSYNC, RENAME = "fsync,fdatasync", "rename,renameat,renameat2"


class OnDisk(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.data = Path(folder.name, "data")
        self.data.mkdir()

    def server(self, *arguments, **options):
        server = Server("--data", self.data, *arguments, **options)
        self.addCleanup(server.end)
        return server

    def files(self, folder):
        return sorted(file.name for file in (self.data / folder).iterdir())

    def check_folder(self, server):
        """Every scene has its record and its bytes, and nothing else is there."""
        scenes = server.ask("/v1/scenes").json()["scenes"]
        self.assertEqual(self.files("scenes"), sorted(scene["id"] + ".json" for scene in scenes))
        self.assertEqual(self.files("blobs"), sorted({scene["sha256"] for scene in scenes}))
        self.assertEqual((self.files("tmp"), self.files("quarantine")), ([], []))

    def refuse(self, server, name, body, expected):
        answer = server.put(name, body, "-H", "Expect:")
        self.assertEqual((answer.status, answer.json()["code"]), expected, answer.body)
        self.assertNotIn(str(self.data), answer.body.decode())


class FullDisk(OnDisk):
    def test_a_disk_that_fills_up_and_has_room_again(self):
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "none", self.data], capture_output=True, text=True, check=False)
        if mounted.returncode != 0:
            self.skipTest("no small disk: " + mounted.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", "-l", self.data], check=True)
        server = self.server()
        known, number = {}, 0
        while True:
            body = grid_glb(40 + number % 3, number + 1)
            answer = server.put(f"s{number}", body, "-H", "Expect:")
            if answer.status != 201:
                break
            known[f"s{number}"] = (server.closest(f"s{number}", DOWN), answer.json())
            number += 1
        self.assertEqual((answer.status, answer.json()["code"]), (507, "STORE_FULL"), answer.body)
        self.assertGreater(number, 2)
        # Not even a small file fits now: neither a new scene, nor one in the place of another, nor trees.
        with open(self.data / "ballast", "wb", buffering=0) as ballast, self.assertRaises(OSError):
            while True:
                ballast.write(bytes(4096))
        self.refuse(server, "six", demo_glb("six"), (507, "STORE_FULL"))
        self.refuse(server, "s0", demo_glb("six"), (507, "STORE_FULL"))
        self.assertEqual(server.ask("/v1/scenes/six").status, 404)

        def check(some):
            for name, (hits, scene) in known.items():
                self.assertEqual(some.closest(name, DOWN), hits)
                self.assertEqual(some.ask(f"/v1/scenes/{name}").json()["sha256"], scene["sha256"])
            self.check_folder(some)
        check(server)
        server.kill()
        # A start needs no room.
        server = self.server()
        check(server)
        self.assertEqual(server.ask("/readyz").json()["status"], "ready")
        gone = known.popitem()[0]
        self.assertEqual(server.ask(f"/v1/scenes/{gone}", "-X", "DELETE").status, 204)
        (self.data / "ballast").unlink()
        self.assertEqual(server.put("six", demo_glb("six"), "-H", "Expect:").status, 201)
        check(server)
        self.assertEqual(server.stop(), 0)
        server = self.server()
        self.assertEqual(server.closest("six", RAY)[0]["t"], 4.5)
        check(server)

    def test_a_limit_of_file_sizes_is_a_full_disk(self):
        server = self.server()
        limit = lambda size: resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
        self.assertEqual(server.put("s", grid_glb(20, 3)).status, 201)
        hits = server.closest("s", DOWN)
        for size in (0, 1, 4096, 9000):
            limit(size)
            self.refuse(server, "s", grid_glb(40, 5), (507, "STORE_FULL"))
            self.refuse(server, "new", grid_glb(40, 5), (507, "STORE_FULL"))
            self.assertEqual(server.closest("s", DOWN), hits)
            limit(resource.RLIM_INFINITY)
            self.check_folder(server)
        self.assertEqual(server.put("new", grid_glb(40, 5)).status, 201)
        self.check_folder(server)

    def test_trees_that_cannot_be_kept_are_a_line_of_the_log(self):
        self.server().stop()
        (self.data / "trees").write_text("in the way")
        server = self.server()
        self.assertEqual(server.put("s", grid_glb(40, 5)).status, 201)
        self.assertEqual(len(server.closest("s", DOWN)), 1)
        end = time.monotonic() + PATIENCE
        while "cannot keep a scene's trees" not in server.log_text():
            self.assertLess(time.monotonic(), end)
        self.assertEqual(server.ask("/readyz").json()["status"], "ready")

    def without_descriptors(self):
        """A server whose file descriptors may run out."""
        server = self.server()
        if is_sanitized(server):
            # Its check of virtual tables asks the kernel through a pipe whether memory can be read.
            self.skipTest("a sanitizer needs file descriptors")
        return server

    def test_too_many_open_files_are_not_damage(self):
        server = self.without_descriptors()
        self.assertEqual(server.put("s", grid_glb(20, 3)).status, 201)
        body = grid_glb(4, 5)
        with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as connection:
            connection.sendall(b"PUT /v1/scenes/new HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Type: model/gltf-binary\r\n"
                               b"Content-Length: %d\r\n\r\n" % len(body))
            # The server owes an answer from here on: it ends an idle connection where another waits for a descriptor.
            self.assertEqual(connection.recv(100), b"HTTP/1.1 100 Continue\r\n\r\n")
            resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (3, 4096))
            connection.sendall(body)
            answer = http.client.HTTPResponse(connection)
            answer.begin()
            self.assertEqual((answer.status, answer.headers["Retry-After"]), (503, "1"))
            self.assertIn(b"STORE_BUSY", answer.read())
        resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (1024, 4096))
        self.assertEqual(server.put("new", grid_glb(4, 5)).status, 201)
        self.check_folder(server)

    def test_running_out_of_descriptors_ends_no_connection_where_nobody_waits(self):
        server = self.without_descriptors()
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
        self.addCleanup(connection.close)
        server.process.send_signal(signal.SIGSTOP)
        connection.request("GET", "/healthz")
        taken = {int(name) for name in os.listdir(f"/proc/{server.process.pid}/fd")}
        free = min(set(range(len(taken) + 1)) - taken)
        resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (free + 1, 4096))
        server.process.send_signal(signal.SIGCONT)
        for _ in range(3):
            answer = connection.getresponse()
            answer.read()
            self.assertEqual(answer.status, 200)
            connection.request("GET", "/healthz")

    def test_small_scenes_take_no_mappings(self):
        server = self.server("--skip", "none")

        def mappings():
            lines = Path(f"/proc/{server.process.pid}/maps").read_text(encoding="ascii").splitlines()
            # A sanitizer maps memory of its own as it likes: of such a process only the files count.
            return sum(not is_sanitized(server) or str(self.data) in line for line in lines)
        bodies = [grid_glb(4, bend) for bend in range(1, 101)]
        server.put("first", bodies[0])
        before = mappings()
        for number, body in enumerate(bodies):
            self.assertEqual(server.put(f"s{number}", body).status, 201)
        self.assertLess(mappings() - before, 50)
        server.stop()
        server = self.server("--skip", "none")
        self.assertLess(mappings() - before, 50)
        # 65,530 of them are what a process has (vm.max_map_count).
        self.assertEqual(len(server.ask("/v1/scenes").json()["scenes"]), 101)


@unittest.skipIf(opened_files.why_not(), opened_files.why_not())
class FullSpool(unittest.TestCase):
    def test_a_full_disk_of_temporary_files_refuses_what_needs_them_and_nothing_else(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "none", folder.name], capture_output=True, text=True, check=False)
        if mounted.returncode != 0:
            self.skipTest("no small disk: " + mounted.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", "-l", folder.name], check=True)
        server = Server("--preload", "six=demo:six", "--spool-dir", folder.name)
        self.addCleanup(server.end)
        hits = server.closest("six", RAY)
        ray = json.dumps({"rays": [{"origin": RAY[0], "direction": RAY[1]}]}).encode()
        json_type = ("-H", "Content-Type: application/json", "-H", "Expect:")
        for chunked in ((), ("-H", "Transfer-Encoding: chunked")):
            answer = server.ask("/v1/scenes/six/rays:closest", *json_type, *chunked, body=ray + b" " * (4 << 20))
            self.assertEqual((answer.status, answer.json()["code"]), (503, "SPOOL_BUSY"), answer.body)
            self.assertEqual(answer.headers["retry-after"], "1")
            self.assertEqual(server.closest("six", RAY), hits, "a small body needs no file")
        # A body that fits is taken as soon as the refused ones have given their bytes back.
        answer = server.ask("/v1/scenes/six/rays:closest", *json_type, body=ray + b" " * (700 << 10))
        self.assertEqual((answer.status, answer.json()["hits"]), (200, hits), answer.body)
        # The worker releases the body's file after the answer has left.
        give_up = time.monotonic() + PATIENCE
        while os.statvfs(folder.name).f_bfree < os.statvfs(folder.name).f_blocks:
            self.assertLess(time.monotonic(), give_up, "a file stays")
            time.sleep(0.01)
        # An answer that its client does not take is broken off, never cut short in silence.
        camera = {"kind": "equirectangular", "position": [0, 1, 0], "width": 600, "height": 300}
        body = json.dumps({"generator": camera, "fields": ["t", "position", "normal"]}).encode()
        with socket.socket() as slow:
            slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            slow.settimeout(PATIENCE)
            slow.connect(("127.0.0.1", server.port))
            slow.sendall(b"POST /v1/scenes/six/rays:closest HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nContent-Length: %d\r\n\r\n%s" % (len(body), body))
            time.sleep(1)
            whole = b""
            try:
                while piece := slow.recv(1 << 20):
                    whole += piece
                    head, _, rest = whole.partition(b"\r\n\r\n")
                    if len(rest) and len(rest) >= int(re.search(rb"content-length: (\d+)", head.lower()).group(1)):
                        break
            except ConnectionResetError:
                head, rest = b"", b""
            if head.startswith(b"HTTP/1.1 200"):
                length = int(re.search(rb"content-length: (\d+)", head.lower()).group(1))
                self.assertTrue(len(rest) < length or len(json.loads(rest)["hits"]) == 180_000)
            elif head:
                self.assertTrue(head.startswith(b"HTTP/1.1 503"), head)
        self.assertEqual(server.closest("six", RAY), hits)
        self.assertEqual(server.stop(), 0)


class FailingDisk(OnDisk):
    """Every call of a kind fails in the folders that it is about; strace says so in the kernel's place."""

    def failing(self, calls, error, folder):
        paths = [word for path in (folder if isinstance(folder, list) else [folder]) for word in ("-P", str(path))]
        return ["strace", "-D", "-f", "-qq", "-o", "/dev/null", *paths, "-e", f"trace={calls}", "-e", f"inject={calls}:error={error}"]

    def test_no_step_of_a_commit_that_fails_loses_anything(self):
        server = self.server()
        self.assertEqual(server.put("s", grid_glb(20, 3)).status, 201)
        hits = server.closest("s", DOWN)
        self.assertEqual(server.stop(), 0)
        tmp = [self.data / "tmp" / str(number) for number in range(8)]
        steps = [("write,pwrite64", tmp), (FSYNC, tmp), (RENAME, tmp), (FSYNC, self.data / "blobs"), (FSYNC, self.data / "scenes"),
                 ("openat", tmp), (FSYNC, self.data / "revision.new"), (RENAME, self.data / "revision.new")]
        last = 1
        for number, (calls, folder) in enumerate(steps):
            for error in ("EIO",) if number % 2 else ("ENOSPC", "EDQUOT"):
                with self.subTest(calls=calls, folder=folder, error=error):
                    server = self.server(prefix=self.failing(calls, error, folder))
                    new = server.put("new", grid_glb(6, 5), "-H", "Expect:")
                    if new.status == 201:
                        self.fail("nothing has failed")
                    self.assertEqual((new.status, new.json()["code"]), REFUSED[error])
                    self.refuse(server, "s", grid_glb(6, 7), REFUSED[error])
                    self.assertEqual(server.closest("s", DOWN), hits)
                    self.assertEqual(self.files("tmp"), [])
                    server.kill()
                    server.end()
                    server = self.server()
                    self.check_folder(server)
                    if folder == self.data / "scenes":
                        # What stood on the disk before it could be made durable may have stayed.
                        self.assertEqual(len(server.closest("s", DOWN)), 1)
                        self.assertEqual(server.put("s", grid_glb(20, 3)).status, 200)
                        server.ask("/v1/scenes/new", "-X", "DELETE")
                    self.assertEqual(server.closest("s", DOWN), hits)
                    revision = server.ask("/v1/scenes/s").json()["revision"]
                    self.assertGreaterEqual(revision, last)
                    last = revision
                    self.assertEqual(server.stop(), 0)
                    server.end()


if __name__ == "__main__":
    case_report.main()
