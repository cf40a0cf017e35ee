"""A file of rays through Dask over three replicas, while a worker and a replica are killed: bulk.py BINARY [--rays N]

Closes with "1 passed, 0 failed" if the bytes of the output equal those of one process, and the rate is at least --least of the
replicas' own binary rate: that of packed requests whose answers are not read further. All processes share this machine, so the
client's part of the processors is missing to the replicas. The figures say how much each part used.
"""

import argparse
import hashlib
import http.client
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy

SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "proto/python"))

import sightline  # noqa: E402  (found only now)
import sightline_bulk  # noqa: E402
from radosgw import free_port  # noqa: E402

FIELDS = ("t", "triangle")


class Replica:
    def __init__(self, arguments, folder, number):
        self.arguments, self.folder, self.number, self.port = arguments, folder, number, free_port()
        self.start()

    def start(self):
        self.process = subprocess.Popen(
            [self.arguments.binary, "serve", "--listen", f"127.0.0.1:{self.port}", "--data", self.folder / f"data{self.number}", "--origin",
             self.folder / "origin"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    @property
    def url(self):
        return f"http://127.0.0.1:{self.port}"


def make_rays(file, count, seed):
    """From above a town of 400 m, downwards: float64, written in parts."""
    table = numpy.lib.format.open_memmap(file, "w+", "<f8", (count, 6))
    source = numpy.random.default_rng(seed)
    for first in range(0, count, 1 << 20):
        rows = min(1 << 20, count - first)
        table[first:first + rows, :3] = source.uniform([-200, 100, -200], [200, 300, 200], (rows, 3))
        table[first:first + rows, 3:] = source.uniform(-1, 1, (rows, 3)) - [0, 1, 0]


def binary_rate(replicas, file, seconds):
    """Rays a second of packed requests, two at once for each replica."""
    rays = numpy.load(file, mmap_mode="r")
    bodies = [sightline._pack(sightline._read_rays(part[:, :3], part[:, 3:], None, None), {"fields": [*FIELDS, "instance"]})
              for part in (rays[i * 65_536:(i + 1) * 65_536] for i in range(8)) if len(part) == 65_536]
    begin, counts = time.monotonic(), []

    def ask(replica, body):
        connection, count = http.client.HTTPConnection("127.0.0.1", replica.port), 0
        while time.monotonic() < begin + seconds:
            connection.request("POST", "/v1/scenes/town/rays:closest", bodies[(body + count) % len(bodies)], {"Content-Type": "application/octet-stream"})
            answer = connection.getresponse()
            text = answer.read()
            if answer.status != 200:
                raise RuntimeError(text[:300])
            count += 1
        counts.append(count)
    threads = [threading.Thread(target=ask, args=(replica, body)) for replica in replicas for body in (0, 3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return sum(counts) * 65_536 / (time.monotonic() - begin)


def digest(file):
    with open(file, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest() if hasattr(hashlib, "file_digest") else hashlib.sha256(stream.read()).hexdigest()


def processor_seconds():
    """By the program's name, of this process and all that it began, except what has ended."""
    used, parents = {}, {os.getpid()}
    for _ in range(4):
        for entry in Path("/proc").iterdir():
            try:
                fields = (entry / "stat").read_text().rsplit(")", 1)[1].split() if entry.name.isdigit() else None
                if fields and int(fields[1]) in parents:
                    parents.add(int(entry.name))
            except (OSError, ValueError):
                pass
    for pid in parents:
        try:
            words = Path(f"/proc/{pid}/cmdline").read_bytes().decode().split("\0")
            fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        name = ("replicas" if "--origin" in words else "scheduler" if "distributed.cli.dask_scheduler" in words else
                "this process" if pid == os.getpid() else "workers")
        used[name] = used.get(name, 0) + (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return used


class Faults:
    """Told the progress of the run: kills a worker after a quarter, and a replica after a half, which starts again after three quarters."""

    def __init__(self, worker, replica):
        self.steps = [(0.25, lambda: os.kill(worker, signal.SIGKILL)), (0.5, lambda: self.end(replica)), (0.75, replica.start)]

    def end(self, replica):
        replica.process.kill()
        replica.process.wait()

    def __call__(self, done, total):
        while self.steps and done >= self.steps[0][0] * total:
            self.steps.pop(0)[1]()


def run(arguments, folder, processes):
    replicas = [Replica(arguments, folder, i) for i in range(3)]
    processes += replicas
    urls = tuple(replica.url for replica in replicas)
    subprocess.run([arguments.binary, "demo", "town", folder / "town.glb"], check=True)
    with sightline.Sightline(urls) as client:
        client.put("town", folder / "town.glb")
    for url in urls:
        with sightline.Sightline(url) as client:
            client.scene("town", wait=60)
    rays = folder / "rays.npy"
    make_rays(rays, arguments.rays, arguments.seed)
    print(f"{arguments.rays} rays, fields {', '.join(FIELDS)}, {os.cpu_count()} processors", flush=True)

    one = sightline_bulk.bulk(rays, folder / "one.npy", sightline_bulk.Question(urls[:1], "town", fields=FIELDS), workers=0)
    print(f"one process, one replica: {one['seconds']:.1f} s, {one['rows'] / one['seconds'] / 1e6:.2f} M rays/s", flush=True)

    import distributed
    file = folder / "scheduler.json"
    for program, options in (("dask_scheduler", ["--port", "0", "--host", "127.0.0.1"]),
                             ("dask_worker", ["--nthreads", "2", "--nworkers", str(arguments.workers), "--local-directory", str(folder)])):
        processes.append(subprocess.Popen([sys.executable, "-B", "-m", f"distributed.cli.{program}", "--scheduler-file", str(file), "--no-dashboard",
                                           *options], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
    with distributed.Client(scheduler_file=str(file), timeout=60) as client:
        client.wait_for_workers(arguments.workers, 60)
        address, worker = client.scheduler.address, next(iter(client.run(os.getpid).values()))
    before = binary_rate(replicas, rays, arguments.seconds)
    used = processor_seconds()
    faults = Faults(worker, replicas[0])
    bulk = sightline_bulk.bulk(rays, folder / "dask.npy", sightline_bulk.Question(urls, "town", fields=FIELDS), dask=address, progress=faults)
    used = {name: seconds - used.get(name, 0) for name, seconds in processor_seconds().items()}
    after = binary_rate(replicas, rays, arguments.seconds)
    rate, own = bulk["rows"] / bulk["seconds"], (before + after) / 2
    print(f"Dask, {arguments.workers} workers of two threads, 3 replicas, a worker and a replica killed: {bulk['seconds']:.1f} s, {rate / 1e6:.2f} M rays/s, "
          f"{bulk['repeated']} slices repeated by the client")
    print("processor seconds of what is left alive: " + ", ".join(f"{name} {seconds:.1f}" for name, seconds in sorted(used.items())))
    print(f"binary rate of the replicas: {before / 1e6:.2f} M rays/s before, {after / 1e6:.2f} after; the run had {rate / own:.0%} of it")
    digests = [digest(folder / name) for name in ("one.npy", "dask.npy")]
    print(f"SHA-256 of one process {digests[0]}\nSHA-256 of Dask        {digests[1]}")
    return digests[0] == digests[1] and not faults.steps and rate >= arguments.least * own


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--rays", type=lambda text: int(float(text)), default=10_000_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=10, help="of each measurement of the binary rate")
    parser.add_argument("--least", type=float, default=0.7, help="of the binary rate; 0 judges the bytes alone")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", help="of the files: 60 bytes for each ray")
    arguments = parser.parse_args()
    arguments.binary = str(Path(arguments.binary).resolve())
    processes = []
    with tempfile.TemporaryDirectory(dir=arguments.folder) as name:
        try:
            good = run(arguments, Path(name), processes)
        finally:
            for each in reversed(processes):
                process = each.process if isinstance(each, Replica) else each
                process.terminate()
                process.wait()
    print("1 passed, 0 failed" if good else "0 passed, 1 failed")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
