"""python -m sightline bulk: slices, killed workers and servers, runs that go on, and what is refused."""

import contextlib
import hashlib
import importlib.util
import json
import multiprocessing
import operator
import os
import re
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import case_report
from sightline_server import PATIENCE, SOURCE, Server, demo_glb

sys.path.insert(0, str(SOURCE / "proto/python"))
import sightline  # noqa: E402  (found only now)
import sightline_bulk  # noqa: E402

numpy = sightline.numpy
ROWS, SLICE = 2000, 64


def made_rays(rows=ROWS, kind="f8", limits=False):
    source = numpy.random.default_rng(7)
    columns = [source.uniform([-200, 100, -200], [200, 300, 200], (rows, 3)), source.uniform(-1, 1, (rows, 3)) - [0, 1, 0]]
    if limits:
        columns.append(numpy.sort(source.uniform(0, 300, (rows, 2)), axis=1))
    return numpy.hstack(columns).astype(kind)


class Runs(unittest.TestCase):
    """A server with a town, and a file of rays."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "town=demo:town")
        cls.addClassCleanup(cls.server.end)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.rays = self.folder / "rays.npy"
        numpy.save(self.rays, made_rays())

    def question(self, **changes):
        return sightline_bulk.Question(**{"servers": (self.server.url,), "scene": "town", **changes})

    def run_bulk(self, name="hits.npy", question=None, size=SLICE, workers=0, **options):
        return sightline_bulk.bulk(self.rays, self.folder / name, question or self.question(), size, workers, **options)

    def digest(self, name):
        return hashlib.sha256((self.folder / name).read_bytes()).hexdigest()


@unittest.skipUnless(numpy, "numpy is not installed")
class Bulk(Runs):
    @contextlib.contextmanager
    def refused(self, text):
        with self.assertRaisesRegex(sightline_bulk.BulkError, text):
            yield

    def test_the_rows_are_the_answers_of_the_client(self):
        fields = ("t", "position", "front", "node_id")
        self.run_bulk(question=self.question(fields=fields))
        told = numpy.load(self.folder / "hits.npy")
        rays = made_rays()
        with sightline.Sightline(self.server.url) as client:
            columns = client.closest("town", rays[:, :3], rays[:, 3:], fields=fields)
            self.assertEqual(set(told.dtype.names), columns.keys())
            self.assertTrue(columns["hit"].any() and not columns["hit"].all())
            for name, column in columns.items():
                self.assertEqual(told[name].tobytes(), column.tobytes(), name)
            for kind, column in (("any", client.any("town", rays[:, :3], rays[:, 3:])), ("count", client.count("town", rays[:, :3], rays[:, 3:]))):
                self.run_bulk(f"{kind}.npy", self.question(kind=kind))
                self.assertEqual(numpy.load(self.folder / f"{kind}.npy")["hit" if kind == "any" else "count"].tobytes(), column.tobytes())
            limited = made_rays(limits=True)
            numpy.save(self.rays, limited)
            self.run_bulk("limited.npy", self.question(options='{"cull":"back"}'))
            columns = client.closest("town", limited[:, :3], limited[:, 3:6], limited[:, 6], limited[:, 7], cull="back")
            self.assertEqual(numpy.load(self.folder / "limited.npy")["t"].tobytes(), columns["t"].tobytes())

    def test_the_bytes_do_not_depend_on_slices_and_workers(self):
        for kind, runs in (("f4", ((1000, 0),)), ("f8", ((1000, 0), (333, 2), (5000, 1)))):
            numpy.save(self.rays, made_rays(kind=kind))
            self.run_bulk(f"{kind}.npy", size=ROWS)
            for size, workers in runs:
                self.run_bulk(f"{kind}{size}.npy", size=size, workers=workers)
                self.assertEqual(self.digest(f"{kind}{size}.npy"), self.digest(f"{kind}.npy"), (size, workers))
        numpy.save(self.rays, made_rays(0))
        self.run_bulk("none.npy")
        self.assertEqual(len(numpy.load(self.folder / "none.npy")), 0)

    def test_slices_of_a_killed_worker_are_answered_again(self):
        self.run_bulk("whole.npy")
        killed = []

        def kill(done, _):
            if done and not killed:
                killed.append(multiprocessing.active_children()[0])
                killed[0].kill()
        done = self.run_bulk(workers=2, progress=kill)
        self.assertEqual((len(killed), done["answered"]), (1, ROWS))
        self.assertEqual(self.digest("hits.npy"), self.digest("whole.npy"))

    def test_a_run_that_was_ended_goes_on(self):
        self.run_bulk("whole.npy")

        def end(done, _):
            if done >= 10 * SLICE:
                raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            self.run_bulk(progress=end)
        self.assertFalse((self.folder / "hits.npy").exists())
        manifest = json.loads((self.folder / "hits.npy.manifest.json").read_text())
        self.assertEqual(manifest["done"], [[0, 10]])
        told = []
        done = self.run_bulk(progress=lambda done, total: told.append((done, total)))
        self.assertEqual((told[0], told[-1], done["answered"]), ((10 * SLICE, ROWS), (ROWS, ROWS), ROWS - 10 * SLICE))
        self.assertEqual(self.digest("hits.npy"), self.digest("whole.npy"))
        self.assertEqual(self.run_bulk()["answered"], 0)  # It is complete.

    def test_a_run_of_something_else_is_refused(self):
        self.run_bulk()
        for question, size, text in ((self.question(fields=("t",)), SLICE, r'fields is \["t", "instance", .* there and \["t", "hit"\] now'),
                                     (self.question(options='{"cull":"back"}'), SLICE, 'options is {} there and {"cull": "back"} now'),
                                     (self.question(), 2 * SLICE, "slice is 64 there and 128 now")):
            with self.refused(text):
                self.run_bulk(question=question, size=size)
        before = os.stat(self.rays)
        os.utime(self.rays, ns=(before.st_atime_ns, before.st_mtime_ns + 1))
        with self.refused("rays is .* there and .* now. Remove it to begin anew"):
            self.run_bulk()
        (self.folder / "hits.npy.manifest.json").unlink()
        self.assertEqual(self.run_bulk()["answered"], ROWS)

    def test_a_scene_that_changes_ends_the_run(self):
        with sightline.Sightline(self.server.url) as client:
            client.put("moved", demo_glb("town"))
            self.addCleanup(client.delete, "moved")
            question = self.question(scene="moved")

            def change(done, _):
                if done == 2 * SLICE:
                    client.patch_node("moved", 1, hidden=True)
            first = client.scene("moved")["revision"]
            with self.refused(f"began with revision {first}, an answer is of revision {first + 1}"):
                self.run_bulk(question=question, progress=change)
            with self.refused(f"revision is {first} there and {first + 1} now"):
                self.run_bulk(question=question)

    def test_wrong_arguments_are_refused_before_anything_is_written(self):
        for name, question, text in (("hits.csv", None, "ends in .npy"), ("hits.npy", self.question(fields=("t", "node")), "Ask for ids"),
                                     ("hits.npy", self.question(kind="all"), "expected closest, any, count")):
            with self.refused(text):
                self.run_bulk(name, question)
        for wrong in (numpy.zeros((4, 7)), numpy.zeros(6), numpy.zeros((4, 6), "i4")):
            numpy.save(self.rays, wrong)
            with self.refused(r"expected floats of shape \(n, 6\)"):
                self.run_bulk()
        if importlib.util.find_spec("pyarrow") is None:
            with self.refused("need pyarrow"):
                self.run_bulk("hits.parquet")
        numpy.save(self.rays, made_rays())
        with self.assertRaises(sightline.SightlineError):
            self.run_bulk(question=self.question(scene="none"))
        self.assertEqual([each.name for each in self.folder.iterdir()], ["rays.npy"])

    def test_an_error_names_the_row_of_the_file(self):
        self.addCleanup(setattr, sightline, "_SLICE", sightline._SLICE)
        for value, error, text, workers in ((0, sightline.SightlineError, "/rays/777/direction", 0), (0, sightline.SightlineError, "/rays/777/direction", 1),
                                            (float("nan"), sightline_bulk.BulkError, "rows 768 to 831: ray 9 of them", 0)):
            rays = made_rays()
            rays[777, 3:] = value
            numpy.save(self.rays, rays)
            for size in (65_536, 5):
                sightline._SLICE = size
                with self.assertRaisesRegex(error, text):
                    self.run_bulk(f"{value}{workers}{size}.npy", workers=workers)

    def test_the_command_answers_and_tells_what_is_wrong(self):
        command = [sys.executable, "-B", "-m", "sightline", "bulk", str(self.rays), "--scene", "town", "--server", self.server.url, "--field", "t"]

        def run(*arguments):
            return subprocess.run([*command, *arguments], cwd=self.folder, env={**os.environ, "PYTHONPATH": str(SOURCE / "proto/python")},
                                  capture_output=True, text=True, timeout=PATIENCE, check=False)
        done = run("--out", "hits.npy", "--workers", "1", "--slice", "500")
        self.assertEqual((done.returncode, done.stdout.split(",")[:2]), (0, ["hits.npy: 2000 rows", " of which 2000 were answered now"]), done.stderr)
        self.assertIn("2000" if importlib.util.find_spec("tqdm") is None else "2.00k", done.stderr)
        self.assertEqual(numpy.load(self.folder / "hits.npy").dtype.names, ("t", "hit"))
        done = run("--out", "hits.npy")
        self.assertEqual((done.returncode, done.stderr[:15]), (1, "sightline bulk:"), done.stderr)

    @unittest.skipUnless(importlib.util.find_spec("pyarrow"), "pyarrow is not installed")
    def test_parquet_and_arrow_have_the_columns(self):
        question = self.question(fields=("t", "position"))
        self.run_bulk(question=question)
        told = numpy.load(self.folder / "hits.npy")
        for name in ("hits.parquet", "hits.arrow"):
            self.run_bulk(name, question)
            table = (importlib.import_module("pyarrow.parquet").read_table if name.endswith("parquet")
                     else importlib.import_module("pyarrow.feather").read_table)(self.folder / name)
            self.assertEqual(table.column("t").to_numpy().tobytes(), told["t"].tobytes())
            self.assertEqual(numpy.array(table.column("position").to_pylist()).tobytes(), told["position"].tobytes())


class WithoutNumpy(unittest.TestCase):
    def test_numpy_is_needed(self):
        self.addCleanup(setattr, sightline_bulk, "numpy", numpy)
        sightline_bulk.numpy = None
        with self.assertRaisesRegex(sightline_bulk.BulkError, "needs numpy"):
            sightline_bulk.bulk("rays.npy", "hits.npy", sightline_bulk.Question(("http://127.0.0.1:1",), "town"))


@unittest.skipUnless(numpy, "numpy is not installed")
class Replicas(Runs):
    """Two servers over one folder; one of them is killed."""

    def test_a_killed_server_changes_nothing(self):
        servers = []
        for name in ("a", "b"):
            servers.append(Server("--data", self.folder / name, "--origin", self.folder / "origin"))
            self.addCleanup(servers[-1].end)
        urls = tuple(server.url for server in servers)
        with sightline.Sightline(urls) as client:
            client.put("town", demo_glb("town"))
        question = sightline_bulk.Question(urls, "town")
        self.run_bulk("whole.npy", question, size=ROWS)

        def served():
            return [int(re.search("^sightline_rays_total ([0-9]+)$", server.ask("/metrics").body.decode(), re.MULTILINE)[1]) for server in servers]
        before = served()
        self.run_bulk("spread.npy", question)
        self.assertTrue(all(a < b for a, b in zip(before, served())), "both are asked")

        def kill(done, _):
            if done == 4 * SLICE:
                servers[0].kill()
        self.run_bulk(question=question, progress=kill)
        for name in ("spread.npy", "hits.npy"):
            self.assertEqual(self.digest(name), self.digest("whole.npy"))


@unittest.skipUnless(numpy and importlib.util.find_spec("distributed"), "distributed is not installed")
class Dask(Runs):
    def test_slices_of_a_killed_worker_of_dask_are_answered_again(self):
        distributed = importlib.import_module("distributed")
        file = self.folder / "scheduler.json"
        common = ["--scheduler-file", str(file), "--no-dashboard"]
        for program, arguments in (("dask_scheduler", ["--port", "0", "--host", "127.0.0.1"]),
                                   ("dask_worker", ["--nthreads", "1", "--nworkers", "2", "--local-directory", str(self.folder)])):
            process = subprocess.Popen([sys.executable, "-B", "-m", f"distributed.cli.{program}", *common, *arguments],
                                       cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.addCleanup(process.wait, PATIENCE)
            self.addCleanup(process.terminate)
        with distributed.Client(scheduler_file=str(file), timeout=PATIENCE) as client:
            client.wait_for_workers(2, PATIENCE)
            address, worker = client.scheduler.address, next(iter(client.run(os.getpid).values()))
            killed = []

            def kill(done, _):
                if done and not killed:
                    killed.append(os.kill(worker, signal.SIGKILL))
            self.run_bulk("whole.npy")
            self.assertEqual(self.run_bulk(dask=address, progress=kill)["answered"], ROWS)
            self.assertEqual((self.digest("hits.npy"), len(killed)), (self.digest("whole.npy"), 1))
            # Workers that do not see the files get the rays, and send the answers.
            self.addCleanup(setattr, sightline_bulk, "_sees", sightline_bulk._sees)
            sightline_bulk._sees = operator.eq  # Of a file and None.
            self.run_bulk("sent.npy", dask=address)
            self.assertEqual(self.digest("sent.npy"), self.digest("whole.npy"))


if __name__ == "__main__":
    case_report.main()
