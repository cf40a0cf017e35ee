"""Questions that are answered in the background: Prefer: respond-async."""

import json
import re
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import case_report
from sightline_server import BINARY, JSON_TYPE, PATIENCE, SOURCE, Server
from two_scenes import TwoScenes
from work_test import rays

ASYNC = ("-H", "Prefer: respond-async")
CLOSEST = "/v1/scenes/town/rays:closest"
# Minutes of work: 65,536 rays for each point.
LONG = {"points": [[x, 1 + x % 7, 0] for x in range(3000)], "count": 65536}
SKY = "/v1/scenes/town/points:sky"


class Base(TwoScenes):
    def job(self, path, body, *arguments, **options):
        """Makes a job; returns its path."""
        answer = self.server.ask(path, "-H", JSON_TYPE, *ASYNC, *arguments, body=json.dumps(body), **options)
        self.assertEqual(answer.status, 202, answer.body)
        self.assertEqual(answer.headers["preference-applied"], "respond-async")
        self.assertRegex(answer.headers["location"], "^/v1/jobs/[0-9a-f]{32}$")
        self.assertEqual(answer.json()["id"], answer.headers["location"].rsplit("/", 1)[1])
        return answer.headers["location"]

    def wait(self, job, *arguments):
        end = time.monotonic() + PATIENCE
        while (report := self.server.ask(job, *arguments).json())["state"] != "done":
            self.assertLess(time.monotonic(), end, report)
            time.sleep(0.01)
        return report

    def delete(self, job, *arguments):
        return self.server.ask(job, "-X", "DELETE", *arguments)


class Jobs(Base):
    def test_the_answer_is_that_of_the_request(self):
        body = {"rays": rays(3000), "fields": ["t", "instance", "node", "normal"]}
        for accept in ("application/json", "text/csv"):
            expected = self.server.ask(CLOSEST, "-H", JSON_TYPE, "-H", "Accept: " + accept, body=json.dumps(body | {"work": False}))
            job = self.job(CLOSEST, body, "-H", "Accept: " + accept)
            report = self.wait(job)
            self.assertEqual((report["state"], report["status"], report["result"]), ("done", 200, job + "/result"))
            self.assertTrue(0 < report["expires_seconds"] <= 600)
            answer = self.server.ask(report["result"])
            self.assertEqual((answer.status, answer.body), (200, expected.body))
            for name in ("content-type", "x-scene-revision"):
                self.assertEqual(answer.headers[name], expected.headers[name])
            self.assertEqual(self.server.ask(report["result"]).body, expected.body)  # as often as it is asked for
            self.assertEqual(self.delete(job).status, 204)
            self.assertEqual(self.server.ask(job).json()["code"], "JOB_NOT_FOUND")

    def test_an_error_is_the_answer(self):
        job = self.job(CLOSEST, {"rays": [{"origin": [0, 0, 0], "direction": [0, 0, 0]}]})
        report = self.wait(job)
        self.assertEqual(report["status"], 422)
        answer = self.server.ask(report["result"])
        self.assertEqual((answer.status, answer.json()["code"], answer.headers["content-type"]),
                         (422, "RAY_DIRECTION_ZERO", "application/problem+json"))
        self.delete(job)

    def test_other_preferences_and_requests_are_answered_at_once(self):
        body = json.dumps({"rays": rays(2)})
        for preference in ("wait=10", "respond-asynchronous", "handling=lenient, return=minimal"):
            self.assertEqual(self.server.ask(CLOSEST, "-H", JSON_TYPE, "-H", "Prefer: " + preference, body=body).status, 200)
        self.assertEqual(self.server.ask("/v1/scenes", *ASYNC).status, 200)
        lines = self.server.ask(CLOSEST, "-H", "Content-Type: application/x-ndjson", *ASYNC, body=json.dumps(rays(1)[0]) + "\n")
        self.assertEqual(lines.status, 200)
        for preference in ("Respond-Async", "wait=10, respond-async", "respond-async; x=1"):
            answer = self.server.ask(CLOSEST, "-H", JSON_TYPE, "-H", "Prefer: " + preference, body=body)
            self.assertEqual(answer.status, 202)
            self.wait(answer.headers["location"])
            self.delete(answer.headers["location"])

    def test_progress_grows_and_delete_cancels(self):
        job = self.job(SKY, LONG)
        end = time.monotonic() + PATIENCE
        seen, sizes = [], set()
        while len(seen) < 3:
            report = self.server.ask(job).json()
            self.assertIn(report["state"], ("queued", "running"))
            if report["state"] == "running" and report["progress"]["done"] not in seen:
                # Nothing is done before the size of the work is known.
                self.assertLessEqual(report["progress"]["done"], report["progress"]["of"] or 0)
                sizes.add(report["progress"]["of"])
                seen.append(report["progress"]["done"])
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)
        self.assertEqual(seen, sorted(seen))
        self.assertEqual(len(sizes - {None}), 1)
        early = self.server.ask(job + "/result")
        self.assertEqual((early.status, early.json()["code"]), (409, "JOB_UNFINISHED"))
        self.assertEqual(self.delete(job).status, 204)
        for path in (job, job + "/result"):
            self.assertEqual(self.server.ask(path).json()["code"], "JOB_NOT_FOUND")
        # It has ended: the next one runs.
        other = self.job(CLOSEST, {"rays": rays(1)})
        self.wait(other)
        self.delete(other)

    def test_unknown_ids_are_not_found(self):
        for name in ("0" * 32, "x", "..%2Fscenes", "0" * 5000):
            for rest in ("", "/result"):
                self.assertEqual(self.server.ask(f"/v1/jobs/{name}{rest}").status, 404)
            self.assertEqual(self.delete("/v1/jobs/" + name).status, 404)

    def test_there_are_no_more_than_the_limit_and_their_bytes_are_given_back(self):
        before = self.server.traffic()
        jobs = [self.job(SKY, LONG) for _ in range(64)]
        full = self.server.ask(CLOSEST, "-H", JSON_TYPE, *ASYNC, body=json.dumps({"rays": rays(1)}))
        self.assertEqual((full.status, full.json()["code"], full.headers["retry-after"]), (503, "JOBS_FULL", "1"))
        # What is not asked for later is answered all the same.
        self.assertEqual(self.server.query("town", "any", {"rays": rays(1)}).status, 200)
        for job in jobs:
            self.assertEqual(self.delete(job).status, 204)
        end = time.monotonic() + PATIENCE
        while self.server.traffic() > before + (1 << 20):
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def test_answers_that_do_not_fit_are_refused(self):
        # Answers of 9 MB each; the server has 56 MB, and half of it for what waits.
        body = {"generator": {"kind": "lidar", "position": [0, 60, 0], "elevations": [-k for k in range(60)], "azimuths": 1000}, "fields": ["t", "position", "normal"]}
        jobs, codes = [], []
        for _ in range(12):
            jobs.append(self.job(CLOSEST, body))
            report = self.wait(jobs[-1])
            codes.append(self.server.ask(report["result"], "-H", "Range: bytes=0-9").json()["code"] if report["status"] != 200 else "")
        self.assertEqual(codes[0], "")
        self.assertEqual(codes[-1], "JOBS_FULL")
        self.assertLess(self.server.traffic(), 56 << 20)
        for job in jobs:
            self.assertEqual(self.delete(job).status, 204)


class PythonClient(Base):
    def test_asks_later(self):
        sys.path.insert(0, str(SOURCE / "proto/python"))
        import sightline
        body = {"points": [[3, 0.5, 5]], "count": 32}
        with sightline.Sightline(self.server.url) as client:
            job = client.ask_later("town", "points:sky", body)
            self.wait("/v1/jobs/" + job)
            self.assertEqual(client.job("town", job)["state"], "done")
            self.assertEqual(client.job_result("town", job), client.ask("town", "points:sky", body))
            client.delete_job("town", job)
            with self.assertRaises(sightline.SightlineError) as caught:
                client.job("town", job)
            self.assertEqual(caught.exception.code, "JOB_NOT_FOUND")


class Stop(unittest.TestCase):
    def test_jobs_end_with_the_server(self):
        with Server("--preload", "town=demo:town") as server:
            for _ in range(3):
                answer = server.ask(SKY, "-H", JSON_TYPE, *ASYNC, body=json.dumps(LONG))
                self.assertEqual(answer.status, 202)
            self.assertEqual(server.stop(), 0)


class Keys(Base):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.keys = {}
        lines = []
        for name in ("ann", "bob"):
            told = subprocess.run([BINARY, "key", "new", "--role", "read", "--name", name], capture_output=True, text=True, check=True).stdout
            cls.keys[name] = re.search("^key: (.*)$", told, re.MULTILINE)[1]
            lines.append(re.search("^line: (.*)$", told, re.MULTILINE)[1])
        file = Path(folder.name, "keys")
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        file.chmod(0o600)
        cls.server = Server("--preload", "town=demo:town", "--keys", str(file))
        cls.addClassCleanup(cls.server.end)

    def key(self, name):
        return "-H", "Authorization: Bearer " + self.keys[name]

    def test_only_its_own_key_reads_and_deletes_a_job(self):
        job = self.job(CLOSEST, {"rays": rays(5)}, *self.key("ann"))
        report = self.wait(job, *self.key("ann"))
        for path in (job, report["result"]):
            self.assertEqual(self.server.ask(path, *self.key("bob")).status, 404)
            self.assertEqual(self.server.ask(path).status, 401)
        self.assertEqual(self.delete(job, *self.key("bob")).status, 404)
        self.assertEqual(self.server.ask(report["result"], *self.key("ann")).status, 200)
        self.assertEqual(self.delete(job, *self.key("ann")).status, 204)  # with a key that reads

    def test_a_key_has_not_all_jobs(self):
        jobs = [self.job(SKY, LONG, *self.key("ann")) for _ in range(32)]
        full = self.server.ask(CLOSEST, "-H", JSON_TYPE, *ASYNC, *self.key("ann"), body=json.dumps({"rays": rays(1)}))
        self.assertEqual((full.status, full.json()["code"]), (503, "JOBS_FULL"))
        other = self.job(SKY, LONG, *self.key("bob"))
        for job, name in [(job, "ann") for job in jobs] + [(other, "bob")]:
            self.assertEqual(self.delete(job, *self.key(name)).status, 204)


if __name__ == "__main__":
    case_report.main()
