"""What survives a stop, a kill and a damaged file; and how a stop goes."""

import re
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import case_report
from sightline_server import BINARY, PATIENCE, SOURCE, Server, curl, demo_glb, read_answer

RAY = ([-10, 1, 0], [1, 0, 0])


class Restart(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.data = Path(folder.name, "data")

    def server(self, *arguments, **options):
        server = Server("--data", self.data, *arguments, **options)
        self.addCleanup(server.end)
        return server

    def test_scenes_are_there_after_a_stop_and_after_a_kill(self):
        server = self.server()
        put = server.put("six", demo_glb("six"))
        self.assertEqual(put.status, 201)
        self.assertEqual(server.stop(), 0)
        server = self.server()
        self.assertEqual(server.ask("/v1/scenes/six").body, put.body)
        self.assertEqual(server.closest("six", RAY)[0]["t"], 4.5)
        replaced = server.put("six", demo_glb("town"))
        self.assertEqual(replaced.json()["revision"], 2)
        self.assertEqual(server.put("other", demo_glb("six")).status, 201)
        self.assertEqual(server.ask("/v1/scenes/other", "-X", "DELETE").status, 204)
        server.kill()
        server = self.server()
        self.assertEqual(server.ask("/v1/scenes/six").body, replaced.body)
        self.assertEqual(server.ask("/v1/scenes/other").status, 404)

    def test_trees_on_disk_stay_within_their_budget(self):
        def sizes():
            return sorted(file.stat().st_size for file in (self.data / "trees").glob("*.trees"))

        def wait(condition):
            end = time.monotonic() + PATIENCE
            while not condition(sizes()):
                self.assertLess(time.monotonic(), end, sizes())
                time.sleep(0.05)

        server = self.server()
        for name in ("six", "town"):
            self.assertEqual(server.put(name, demo_glb(name)).status, 201)
            server.closest(name, RAY)
        wait(lambda found: len(found) == 2)
        town = server.closest("town", ([3, 200, 5], [0, -1, 0]))
        server.stop()
        budget = sizes()[-1]
        server = self.server("--disk-budget", budget)
        self.assertEqual(server.ask("/version").json()["limits"]["disk_budget"], budget)
        self.assertLessEqual(sum(sizes()), budget)
        self.assertEqual(server.closest("six", RAY)[0]["t"], 4.5)
        self.assertEqual(server.closest("town", ([3, 200, 5], [0, -1, 0])), town)
        self.assertEqual(server.put("third", demo_glb("town")).status, 201)
        server.closest("third", RAY)
        wait(lambda found: found == [budget])

    def test_a_copy_of_the_folder_serves_the_scenes_elsewhere(self):
        server = self.server()
        put = server.put("six", demo_glb("six"))
        self.assertEqual(put.status, 201)
        server.stop()
        # As docs/guides/deployment.md copies it, "Backup".
        page = (SOURCE / "docs/guides/deployment.md").read_text(encoding="utf-8")
        pack, unpack = re.findall(r"^ {4}(tar .*)$", page, re.MULTILINE)
        other = self.data.parent / "srv"
        other.mkdir()
        for line in (pack.replace("/var/lib/sightline", str(self.data)), unpack.replace("/srv/sightline", str(other))):
            subprocess.run(["bash", "-c", line], cwd=self.data.parent, check=True, timeout=PATIENCE)
        self.data = other
        server = self.server()
        self.assertEqual(server.ask("/v1/scenes/six").body, put.body)
        self.assertEqual(server.closest("six", RAY)[0]["t"], 4.5)

    def test_a_damaged_file_is_quarantined_and_named(self):
        server = self.server()
        for name in ("good", "bad"):
            # Different bytes for each name: the JSON chunk of a GLB may be followed by nothing else.
            self.assertEqual(server.put(name, demo_glb("six" if name == "bad" else "town")).status, 201)
        sha256 = server.ask("/v1/scenes/bad").json()["sha256"]
        server.stop()
        blob = self.data / "blobs" / sha256
        damaged = bytearray(blob.read_bytes())
        damaged[-1] ^= 1
        blob.write_bytes(damaged)
        server = self.server()
        ready = server.ask("/readyz").json()
        self.assertEqual((ready["status"], ready["failed"]), ("ready", ["bad"]))
        bad = server.ask("/v1/scenes/bad").json()
        self.assertEqual((bad["state"], bad["reason"]["code"]), ("failed", "STORE_DAMAGED"))
        self.assertNotIn(str(self.data), bad["reason"]["detail"])
        self.assertEqual(server.ask("/v1/scenes/good").json()["state"], "ready")
        self.assertEqual(len(list((self.data / "quarantine").iterdir())), 2)
        self.assertIn("scene failed scene=bad code=STORE_DAMAGED", server.log_text())

    def test_a_folder_belongs_to_one_server(self):
        self.server()
        second = subprocess.run([BINARY, "serve", "--listen", "127.0.0.1:0", "--data", self.data],
                                capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual((second.returncode, second.stdout), (2, ""))
        self.assertIn("STORE_IN_USE", second.stderr)

    def test_a_folder_of_somebody_else_is_refused_and_left_alone(self):
        (self.data / "tmp").mkdir(parents=True)
        (self.data / "tmp" / "thesis.txt").write_text("the only copy")
        refused = subprocess.run([BINARY, "serve", "--listen", "127.0.0.1:0", "--data", self.data],
                                 capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual((refused.returncode, refused.stdout), (2, ""))
        self.assertIn("STORE_FOREIGN", refused.stderr)
        self.assertEqual([file.name for file in self.data.rglob("*")], ["tmp", "thesis.txt"])


class Stop(unittest.TestCase):
    def test_both_signals_end_the_server_with_exit_code_0(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(signal=number), Server() as server:
                server.signal(number)
                self.assertEqual(server.wait(), 0)
                self.assertIn("stopped", server.log_text())

    def test_an_idle_connection_does_not_delay_the_exit(self):
        # Were the exit to wait for the connection, this would hang until the test's patience ends.
        with Server("--idle-seconds", 100000, "--drain-seconds", 100000) as server:
            connection = server.connect()
            with connection, connection.makefile("rwb") as stream:
                stream.write(b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n")
                stream.flush()
                self.assertEqual(read_answer(stream).status, 200)
                self.assertEqual(server.stop(), 0)
                self.assertIsNone(read_answer(stream))

    def test_a_request_that_has_begun_is_answered(self):
        with Server("--preload", "six=demo:six", "--drain-seconds", 100000) as server:
            connection = server.connect()
            with connection, connection.makefile("rwb") as stream:
                body = b'{"rays":[{"origin":[-10,1,0],"direction":[1,0,0]}],"fields":["t"]}'
                stream.write(b"POST /v1/scenes/six/rays:closest HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\n"
                             b"Content-Type: application/json\r\nContent-Length: %d\r\n\r\n" % len(body))
                stream.flush()
                self.assertEqual(read_answer(stream).status, 100)  # now a worker has it
                server.signal()
                while "stopping" not in server.log_text():
                    pass
                stream.write(body)
                stream.flush()
                answer = read_answer(stream)
                self.assertEqual((answer.status, answer.body), (200, b'{"hits":[{"t":4.5}]}'))
                self.assertIsNone(read_answer(stream))
            self.assertEqual(server.wait(), 0)

    def test_readyz_says_503_before_connections_are_refused(self):
        with Server("--notice-seconds", 100000) as server:
            self.assertEqual(curl(server.url + "/readyz").json()["status"], "ready")
            server.signal()
            while "stopping" not in server.log_text():
                pass
            ready = curl(server.url + "/readyz")
            while ready.status == 200:
                ready = curl(server.url + "/readyz")
            self.assertEqual((ready.status, ready.json()["status"]), (503, "stopping"))
            self.assertIn("retry-after", ready.headers)
            self.assertEqual(curl(server.url + "/healthz").status, 200)
            server.signal()  # enough notice
            self.assertEqual(server.wait(), 0)

    def test_a_second_signal_breaks_off_what_would_go_on_for_ever(self):
        with Server("--drain-seconds", 100000) as server:
            connection = server.connect()
            with connection, connection.makefile("rwb") as stream:
                stream.write(b"PUT /v1/scenes/x HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: 99\r\n\r\n")
                stream.flush()
                self.assertEqual(read_answer(stream).status, 100)
                server.signal()
                while "stopping" not in server.log_text():
                    pass
                server.signal()
                self.assertEqual(server.wait(), 0)


if __name__ == "__main__":
    case_report.main()
