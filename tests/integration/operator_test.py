"""What an operator sees: lines of the log for machines, reasons of readiness, and what there is to measure."""

import json
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

import case_report
from metrics_test import series
from process_status import is_sanitized
from sightline_server import BINARY, PATIENCE, Server, bearer, curl, demo_glb, make_key, write_keys

QUERY = '{"rays":[{"origin":[-10,1,0],"direction":[1,0,0]}]}'


def entries(server):
    """The log's lines, each of which must be an object."""
    return [json.loads(line) for line in server.log_text().splitlines()]


def reasons(answer):
    return {reason["code"]: reason for reason in answer.json().get("reasons", [])}


class Start(unittest.TestCase):
    def test_threads_that_the_system_does_not_give_are_told(self):
        with Server() as server:
            if is_sanitized(server):
                self.skipTest("a sanitizer needs more addresses")
        # Each takes 8 MiB of addresses for its stack.
        done = subprocess.run(["prlimit", f"--as={1200 << 20}", BINARY, "serve", "--listen", "127.0.0.1:0", "--workers", "400"],
                              capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("THREADS_FEW: --workers: the system does not give the threads of 400 workers", done.stderr)
        self.assertEqual(done.stdout, "", "no address before the threads are there")


class Logs(unittest.TestCase):
    def test_every_line_is_an_object_and_names_its_request(self):
        with Server("--preload", "six=demo:six", "--log-format", "json") as server:
            server.query("six", "any", QUERY, "-H", "X-Request-Id: ask-1")
            server.query("none", "any", QUERY, "-H", "X-Request-Id: ask-2")
            server.ask('/%22%0a{"level":"error"}', "-H", 'X-Request-Id: "}\\n{"', "-X", 'BREW"')
            server.ask("/healthz", "-H", "X-Request-Id: door-1", "-H", "Content-Length: x")
            self.assertEqual(server.stop(), 0)
            lines = entries(server)
        for line in lines:
            self.assertRegex(line["time"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d$")
            self.assertIn(line["level"], ("debug", "info", "warning", "error"))
            self.assertTrue(line["message"])
        by_id = {line["id"]: line for line in lines if "id" in line}
        asked = by_id["ask-1"]
        self.assertEqual((asked["message"], asked["method"], asked["path"], asked["status"], asked["level"]),
                         ("request", "POST", "/v1/scenes/six/rays:any", 200, "debug"))
        self.assertGreater(asked["ms"], 0)
        self.assertEqual((by_id["ask-2"]["status"], by_id["ask-2"]["code"]), (404, "SCENE_NOT_FOUND"))
        self.assertEqual((by_id["door-1"]["message"], by_id["door-1"]["code"]), ("request refused", "FRAMING_AMBIGUOUS"))
        self.assertEqual([line["message"] for line in lines if line["level"] == "info"][-1], "stopped")

    def test_text_stays_one_line_whatever_a_scene_is_called(self):
        name = 'x\n[2026-01-01 00:00:00.000] [error] forged'
        gltf = {"asset": {"version": "2.0"}, "extensionsRequired": [name]}
        with Server() as server:
            answer = server.ask("/v1/scenes/a?wait=0", "-X", "PUT", "-H", "Content-Type: model/gltf+json", body=json.dumps(gltf))
            self.assertEqual(answer.status, 202)
            while "scene failed" not in server.log_text():
                self.assertIsNone(server.process.poll())
            self.assertIn('scene failed scene=a code=GLTF_EXTENSION_UNSUPPORTED', server.log_text())
            self.assertFalse([line for line in server.log_text().splitlines() if "] [error] forged" in line[:45]])

    def test_what_went_wrong_is_shown_without_asking_for_every_request(self):
        with tempfile.TemporaryDirectory() as folder:
            data = Path(folder, "data")
            with Server("--data", data, "--log-level", "info", "--log-format", "json") as server:
                (data / "tmp").rmdir()
                self.assertEqual(server.put("a", demo_glb("six"), "-H", "X-Request-Id: lost").status, 500)
                self.assertEqual(server.ask("/nothing").status, 404)
                shown = [line for line in entries(server) if line["message"] == "request"]
        self.assertEqual([(line["level"], line["id"], line["status"], line["code"]) for line in shown], [("warning", "lost", 500, "STORE_IO")])


class Readiness(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.data = Path(folder.name, "data")

    def test_quarantined_scenes_are_named_to_those_who_may_know(self):
        key, line = make_key("read", "a")
        keys = write_keys(self.data.parent / "keys", line)
        with Server("--data", self.data) as server:
            self.assertEqual(server.put("good", demo_glb("six")).status, 201)
            self.assertEqual(server.put("bad", demo_glb("town")).status, 201)
            self.assertNotIn("reasons", server.ask("/readyz").json())
        blob = max((self.data / "blobs").iterdir(), key=lambda each: each.stat().st_size)
        blob.write_bytes(b"x" * blob.stat().st_size)
        with Server("--data", self.data, "--keys", keys) as server:
            ready = server.ask("/readyz", *bearer(key))
            self.assertEqual((ready.status, ready.json()["status"], ready.json()["failed"]), (200, "ready", ["bad"]))
            self.assertEqual(reasons(ready), {"SCENES_QUARANTINED": {"code": "SCENES_QUARANTINED", "scenes": ["bad"]}})
            self.assertEqual(server.ask("/readyz").json(), {"status": "ready"})
            self.assertIn("scene failed scene=bad code=STORE_DAMAGED", server.log_text())

    def test_a_stop_is_a_reason(self):
        with Server("--notice-seconds", PATIENCE) as server:
            server.signal()
            while (answer := server.ask("/readyz")).status == 200:
                pass
            self.assertEqual((answer.json()["status"], set(reasons(answer))), ("stopping", {"STOPPING"}))
            server.signal(signal.SIGINT)
            self.assertEqual(server.wait(), 0)

    def test_loading_is_a_reason(self):
        with Server("--preload", "town=demo:town", "--preload", "six=demo:six", wait=False) as server:
            while (answer := curl(server.url + "/readyz")).status != 200:
                self.assertEqual((answer.json()["status"], set(reasons(answer))), ("loading", {"SCENES_LOADING"}))
            self.assertEqual(reasons(answer), {})

    def test_a_full_store_is_a_reason_until_it_is_not(self):
        self.data.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256k", "none", self.data], capture_output=True, text=True, check=False)
        if mounted.returncode != 0:
            self.skipTest("no small disk: " + mounted.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", "-l", self.data], check=True)
        with Server("--data", self.data) as server:
            ballast = self.data / "ballast"
            with open(ballast, "wb", buffering=0) as file, self.assertRaises(OSError):
                while True:
                    file.write(bytes(4096))
            self.assertEqual(server.put("a", demo_glb("town"), "-H", "Expect:").status, 507)
            ready = server.ask("/readyz")
            self.assertEqual((ready.status, set(reasons(ready))), (200, {"STORE_FULL"}))
            ballast.unlink()
            self.assertEqual(server.put("a", demo_glb("six")).status, 201)
            self.assertEqual(reasons(server.ask("/readyz")), {})


    def test_a_data_folder_that_cannot_be_written_is_a_reason_until_it_can(self):
        with Server("--data", self.data) as server:
            self.assertEqual(reasons(server.ask("/readyz")), {})
            # Whoever runs the tests may be allowed anything: no name is free where there is no folder.
            (self.data / "tmp").rmdir()
            (self.data / "tmp").write_text("in the way")
            refused = server.put("a", demo_glb("six"), "-H", "Expect:")
            self.assertEqual((refused.status, refused.json()["code"]), (500, "STORE_IO"))
            ready = server.ask("/readyz")
            self.assertEqual((ready.status, set(reasons(ready))), (200, {"STORE_IO"}))
            (self.data / "tmp").unlink()
            (self.data / "tmp").mkdir()
            self.assertEqual(server.put("a", demo_glb("six")).status, 201)
            self.assertEqual(reasons(server.ask("/readyz")), {})


class Measures(unittest.TestCase):
    def test_work_and_the_queue_are_counted(self):
        # From a corner of the cube along a face's diagonal: nothing there is decided without integers.
        hard = json.dumps({"rays": [{"origin": [-10, 0, -1], "direction": [1, 0, 0]}, {"origin": [-10, 1, 0], "direction": [1, 0, 0]}] * 50})
        with Server("--preload", "six=demo:six", "--preload", "town=demo:town") as server:
            before = series(server.ask("/metrics").body)
            asked = server.query("town", "all", hard.replace('{"rays"', '{"work":true,"rays"')).json()["work"]
            after = series(server.ask("/metrics").body)
            grown = {name: after[f'sightline_work_total{{what="{name}"}}'] - before[f'sightline_work_total{{what="{name}"}}']
                     for name in ("nodes", "blocks", "placements", "exact_hits", "exact_compares", "exact_roundings")}
            self.assertGreater(asked["nodes"], 0)
            self.assertEqual({name: grown[name] for name in ("nodes", "blocks", "placements")},
                             {name: asked[name] for name in ("nodes", "blocks", "placements")})
            self.assertEqual(sum(grown[name] for name in grown if name.startswith("exact")), asked["exact"])
            self.assertEqual(after["sightline_queued_requests"], 0)
            # Who did not ask what it cost is counted too.
            server.query("six", "any", QUERY)
            last = series(server.ask("/metrics").body)
            self.assertGreater(last['sightline_work_total{what="blocks"}'], after['sightline_work_total{what="blocks"}'])

    def test_refusals_of_the_event_loop_are_counted(self):
        key, line = make_key("read", "a")
        with tempfile.TemporaryDirectory() as folder:
            keys = write_keys(Path(folder, "keys"), line)
            with Server("--keys", keys, "--log-level", "info") as server:
                for _ in range(3):
                    self.assertEqual(server.ask("/v1/scenes").status, 401)
                self.assertEqual(server.put("a", b"x", *bearer(key)).status, 403)
                counts = series(server.ask("/metrics", *bearer(key)).body)
                # Without being asked for: somebody tries keys.
                self.assertEqual([server.log_text().count(f" status={status} ") for status in (401, 403)], [3, 1])
        self.assertEqual(counts['sightline_requests_total{method="GET",route="event_loop",status="401"}'], 3)
        self.assertEqual(counts['sightline_requests_total{method="PUT",route="event_loop",status="403"}'], 1)
        self.assertEqual(counts['sightline_connections_total{event="locked_out"}'], 4)


if __name__ == "__main__":
    case_report.main()
