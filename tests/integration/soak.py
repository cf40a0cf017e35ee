"""Everything at once, for as long as it is told: full load of many kinds beside clients that leave, and scenes that are
put, replaced and removed under their readers. Every answer is held against a stored truth.

    soak.py BINARY [--minutes N] [--seed S] [--out FOLDER] [--workers N] [--difficult]

The truth of each query is the answer of a quiet server with another kernel and all trees built beforehand, whose scenes
have passed /selfcheck (rays answered again by exact brute force). Prints a table and a verdict for each line of floor 3,
and writes FOLDER/soak.md. With --difficult the clients of tests/bench/mixed_load.py are there as well: 200 slow uploads, 200 slow readers,
64 clients with Expect, 48 connections with the most expensive short questions and 100 idle streams.
"""

import argparse
import hashlib
import http.client
import json
import multiprocessing
import os
import random
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from array import array
from pathlib import Path

from kills import grid_glb

BATCH = 100_000
RETRY = (429, 503)  # what a server under too much load may say
SETTLING_MINUTES = 5  # before memory has to be flat
LOOKS = 5  # at memory, in a second: batches come and go several times in one
BINARY_TYPE = "application/octet-stream"
CONTENTS = [(20, 3), (60, 5), (120, 7), (250, 11)]  # of the scenes that come and go
NAMES = ["w0", "w1", "w2"]


def digest(body):
    return hashlib.sha256(body).hexdigest()


def rays_above(chance, count, spread, height):
    return [([chance.uniform(-spread, spread), height, chance.uniform(-spread, spread)],
             [chance.uniform(-0.6, 0.6), -1, chance.uniform(-0.6, 0.6)]) for _ in range(count)]


def json_rows(rays, **more):
    return json.dumps({"rays": [{"origin": o, "direction": d} for o, d in rays], **more}).encode()


def json_columns(rays, **more):
    return json.dumps({"origins": [x for o, _ in rays for x in o], "directions": [x for _, d in rays for x in d], **more}).encode()


def binary_body(rays, options=b"{}"):
    head = b"SLR1" + (1).to_bytes(4, "little") + len(rays).to_bytes(8, "little") + len(options).to_bytes(4, "little") + bytes(4) + options
    head += bytes(-len(head) % 8)
    return head + b"".join(array("d", (ray[part][k] for ray in rays)).tobytes() for part in (0, 1) for k in range(3))


class Query:
    def __init__(self, path, body, kind="application/json"):
        self.path, self.body, self.kind = path, body, kind
        self.truth = None  # digest of the answer

    def ask(self, connection, scene):
        connection.request("POST", f"/v1/scenes/{scene}/{self.path}", self.body, {"Content-Type": self.kind})
        answer = connection.getresponse()
        return answer.status, answer.read(), answer.headers


def single_queries(chance):
    some = [json_rows([ray], fields=["t", "triangle", "node"]) for ray in rays_above(chance, 160, 40, 60)]
    return [Query("rays:" + ("closest", "closest", "any", "count")[i % 4],
                  body if i % 4 < 2 else json_rows(rays_above(chance, 1, 40, 60))) for i, body in enumerate(some)]


def batch_queries(chance):
    rays = rays_above(chance, BATCH, 60, 100)
    return [Query("rays:closest", binary_body(rays), BINARY_TYPE), Query("rays:any", binary_body(rays), BINARY_TYPE),
            Query("rays:closest", json_columns(rays, fields=["t", "triangle"])),
            Query("rays:count", json_columns(rays[:BATCH]))]


def mixed_queries(chance):
    points = [[chance.uniform(-40, 40), chance.uniform(0, 30), chance.uniform(-40, 40)] for _ in range(400)]
    boxes = [{"min": [x - 1, y - 1, z - 1], "max": [x + 1, y + 1, z + 1]} for x, y, z in points[:100]]
    spheres = [{"center": p, "radius": 2} for p in points[:50]]
    camera = {"kind": "pinhole", "position": [60, 40, 60], "look_at": [0, 5, 0], "width": 160, "height": 120}
    rays = rays_above(chance, 3000, 50, 80)
    as_json = lambda **members: json.dumps(members).encode()
    return [Query("boxes:any", as_json(boxes=boxes + spheres)), Query("boxes:count", as_json(boxes=boxes)),
            Query("boxes:list", as_json(boxes=boxes, limit=20)), Query("boxes:list", as_json(boxes=boxes, of="nodes")),
            Query("points:inside", as_json(points=points)), Query("points:inside", as_json(points=points[:100], method="winding")),
            Query("visibility", as_json(**{"from": points[:40], "to": points[40:100]})),
            Query("visibility", as_json(**{"from": points[:20], "to": points[40:60], "pairing": "each", "first_blocker": True})),
            Query("rays:closest", as_json(generator=camera, fields=["t", "triangle", "normal"])),
            Query("rays:all", json_rows(rays, fields=["t", "triangle"], max_hits=5)),
            Query("rays:closest", json_rows(rays, cull="back", fields=["t", "node_path", "position"])),
            Query("rays:all", binary_body(rays, b'{"max_hits":3}'), BINARY_TYPE)]


def content_query(chance):
    return Query("rays:closest", json_rows([([chance.uniform(0, 1), 2, chance.uniform(0, 1)], [0.1, -1, 0.05]) for _ in range(100)],
                                           fields=["t", "triangle", "normal"]))


class Truth:
    """What is asked, and what a quiet server says to it."""

    def __init__(self, make_server, seed, checked_rays=200):
        chance = random.Random(seed)
        self.singles, self.batches, self.mixed = single_queries(chance), batch_queries(chance), mixed_queries(chance)
        self.of_content = content_query(chance)
        self.contents = [grid_glb(side, bend) for side, bend in CONTENTS]
        self.content_truth = []  # of of_content, for each content
        self.checked_rays = 0
        with make_server("--preload", "town=demo:town", "--kernel", slowest_kernel(), "--skip", "none", "--request-seconds", 600) as server:
            connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=600)
            self.self_check(connection, "town", checked_rays)
            for query in self.singles + self.batches + self.mixed:
                query.truth = self.answer(connection, query, "town")
            for number, body in enumerate(self.contents):
                if server.put(f"c{number}", body).status != 201:
                    raise AssertionError("a content is not taken")
                self.self_check(connection, f"c{number}", checked_rays // 10)
                self.content_truth.append(self.answer(connection, self.of_content, f"c{number}"))
            connection.close()

    def answer(self, connection, query, scene):
        status, body, _ = query.ask(connection, scene)
        if status != 200:
            raise AssertionError(f"{query.path}: {status} {body[:300]}")
        return digest(body)

    def self_check(self, connection, scene, rays):
        connection.request("GET", f"/v1/scenes/{scene}/selfcheck?rays={rays}&seed=5")
        found = json.loads(connection.getresponse().read())
        if found.get("rays") != rays or found["different"]:
            raise AssertionError(f"{scene} does not pass its selfcheck: {found}")
        self.checked_rays += rays


def slowest_kernel():
    """Another one than the server takes by itself."""
    text = subprocess.run([sys.argv[1], "--version"], capture_output=True, text=True, check=True).stdout
    return text.split("kernels:")[1].split()[-1]


class Client:
    """A process that asks until it is told to stop, and then tells what came of it."""
    def __init__(self, name, port, truth, seed):
        self.name, self.port, self.truth, self.chance = name, port, truth, random.Random(seed)
        self.asked = self.busy = self.rays = 0
        self.wrong, self.failed = [], []
        self.latencies = array("d")
        self.longest = 0.0  # seconds of a step
        self.connection = None

    def run(self, stop, results):
        self.take_turn()
        start = time.monotonic()
        try:
            while not stop.is_set():
                begin = time.monotonic()
                try:
                    self.step()
                except (OSError, http.client.HTTPException) as fault:
                    self.failed.append(f"{self.name}: {type(fault).__name__} {fault}, of a step from {begin - start:.1f} s on")
                    self.close()
                self.longest = max(self.longest, time.monotonic() - begin)
                if len(self.failed) + len(self.wrong) > 50:
                    break
        except BaseException as fault:  # shown by the parent
            self.failed.append(f"{self.name}: {type(fault).__name__} {fault}")
        self.close()
        results.put((self.name, self.asked, self.busy, self.wrong[:20], len(self.wrong), self.failed[:20], len(self.failed),
                     self.latencies.tobytes(), self.longest))

    def take_turn(self):
        os.nice(10)  # the machine that is loaded is also the one that measures

    def close(self):
        if self.connection is not None:
            self.connection.close()
        self.connection = None

    def connected(self):
        if self.connection is None:
            self.connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
            self.connection.connect()
            self.connection.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return self.connection

    def send(self, query, scene="town"):
        """The answer's body and headers, or None where there was none that has to be right."""
        status, body, headers = query.ask(self.connected(), scene)
        self.asked += 1
        if status in RETRY:
            self.busy += 1
            time.sleep(0.05)
            return None
        if status != 200:
            self.failed.append(f"{self.name}: {query.path} of {scene}: {status} {body[:200]}")
            return None
        return body, headers

    def check(self, query):
        answer = self.send(query)
        if answer is not None and digest(answer[0]) != query.truth:
            self.wrong.append(f"{self.name}: {query.path} {query.body[:100]}")


class Singles(Client):
    """Keep-alive, one ray at a time: the requests whose times are measured."""

    def take_turn(self):
        # What is measured is how long the server takes, not how long a busy machine keeps an answer waiting at its client.
        try:
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
        except PermissionError:
            pass

    def step(self):
        query = self.chance.choice(self.truth.singles)
        begin = time.perf_counter()
        answer = self.send(query)
        took = time.perf_counter() - begin
        if answer is None:
            return
        self.latencies.append(took)
        if digest(answer[0]) != query.truth:
            self.wrong.append(f"{self.name}: {query.path} {query.body[:100]}")
        time.sleep(0.002)  # a client that thinks; the machine is for the server


class Batches(Client):
    def step(self):
        self.check(self.chance.choice(self.truth.batches))


class Mixed(Client):
    def step(self):
        self.check(self.chance.choice(self.truth.mixed))


class Writer(Client):
    """Puts, replaces and removes scenes, and looks at each that it put."""

    def step(self):
        connection = self.connected()
        name = self.chance.choice(NAMES)
        if self.chance.random() < 0.15:
            connection.request("DELETE", f"/v1/scenes/{name}")
            answer = connection.getresponse()
            text = answer.read()
            self.note(answer.status, (204, 404), "DELETE", text)
            return
        number = self.chance.randrange(len(CONTENTS))
        connection.request("PUT", f"/v1/scenes/{name}", self.truth.contents[number], {"Content-Type": "model/gltf-binary"})
        answer = connection.getresponse()
        text = answer.read()
        if not self.note(answer.status, (200, 201), "PUT", text):
            return
        found = self.send(self.truth.of_content, name)
        if found is None:
            return
        if found[1]["X-Scene-Revision"] != str(json.loads(text)["revision"]) or digest(found[0]) != self.truth.content_truth[number]:
            self.wrong.append(f"{self.name}: {name} is not what was put")
        time.sleep(self.chance.uniform(0, 0.1))

    def note(self, status, good, what, text):
        self.asked += 1
        if status in RETRY:
            self.busy += 1
        elif status not in good:
            self.failed.append(f"{self.name}: {what} {status} {text[:200]}")
        return status in good


class Readers(Client):
    """Ask the scenes that come and go: one revision is one content, whole."""

    seen = {}

    def step(self):
        name = self.chance.choice(NAMES)
        status, body, headers = self.truth.of_content.ask(self.connected(), name)
        self.asked += 1
        if status in (404, 409):
            return time.sleep(0.01)  # removed, or put for the first time
        if status in RETRY:
            self.busy += 1
            return time.sleep(0.05)
        if status != 200:
            return self.failed.append(f"{self.name}: {status} {body[:200]}")
        found = digest(body)
        if found not in self.truth.content_truth or self.seen.setdefault(headers["X-Scene-Revision"], found) != found:
            self.wrong.append(f"{self.name}: {name} at {headers['X-Scene-Revision']}")


class Rude(Client):
    """Leaves in the middle, reads slowly, sends nonsense. Slow readers have a right to their whole answer."""

    def step(self):
        turn = self.chance.randrange(5)
        query = self.truth.mixed[self.chance.randrange(len(self.truth.mixed))]
        request = (b"POST /v1/scenes/town/%s HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Type: %s\r\nContent-Length: %d\r\n\r\n" %
                   (query.path.encode(), query.kind.encode(), len(query.body))) + query.body
        with socket.create_connection(("127.0.0.1", self.port), timeout=120) as connection:
            self.asked += 1
            if turn == 0:
                connection.sendall(request[:self.chance.randrange(len(request))])
            elif turn == 1:
                connection.sendall(request)
                connection.recv(1 + self.chance.randrange(4000))
            elif turn == 2:
                connection.sendall(b"GET / HTTP/1.1\r\nHost: x\r\nContent-Length: 5, 6\r\n\r\n" + bytes(200))
                if not connection.recv(100).startswith(b"HTTP/1.1 400"):
                    self.failed.append(f"{self.name}: nonsense is not refused")
            else:
                connection.sendall(request)
                whole, piece = b"", b"x"
                while piece:
                    piece = connection.recv(30_000)
                    whole += piece
                    time.sleep(0.005)
                head, _, body = whole.partition(b"\r\n\r\n")
                status = int(head.split()[1]) if head else 0
                if status in RETRY:
                    self.busy += 1
                elif status != 200:
                    self.failed.append(f"{self.name}: a slow reader of {query.path}: {head[:200]}")
                elif digest(body) != query.truth:
                    self.wrong.append(f"{self.name}: a slow reader of {query.path}")


def be_difficult(port, stop):
    """A process of clients whose own answers nobody looks at."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))
    from mixed_load import Load
    os.nice(10)
    load = Load(port)
    load.begin()
    stop.wait()
    load.stop.set()
    print("answers of the expensive questions:", {f"{path} {status}": count for (path, status), count in sorted(load.counts.items())}, flush=True)
    os._exit(0)  # its threads wait for answers that nobody needs


ROLES = [Singles, Singles, Batches, Batches, Mixed, Writer, Readers, Rude]


def resident(pid):
    with open(f"/proc/{pid}/status", encoding="ascii") as lines:
        return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))


def measure(server, truth, options):
    context = multiprocessing.get_context("fork")
    stop, results = context.Event(), context.Queue()
    clients = [role(f"{role.__name__.lower()} {number}", server.port, truth, options.seed + number) for number, role in enumerate(ROLES)]
    processes = [context.Process(target=client.run, args=(stop, results), daemon=True) for client in clients]
    if options.difficult:
        processes.append(context.Process(target=be_difficult, args=(server.port, stop), daemon=True))
    for process in processes:
        process.start()
    begin, memory = time.monotonic(), []
    while time.monotonic() - begin < options.minutes * 60 and server.process.poll() is None:
        time.sleep(1 / LOOKS)
        memory.append((time.monotonic() - begin, resident(server.process.pid)))
        if len(memory) % (60 * LOOKS) == 0:
            print(f"{memory[-1][0] / 60:.0f} min, {memory[-1][1]:.0f} MiB, load {os.getloadavg()[0]:.1f}", flush=True)
    stop.set()
    told = [results.get(timeout=300) for _ in clients]
    for process in processes:
        process.join()
    return told, memory, time.monotonic() - begin


def median_by_minute(memory, settled):
    minutes = {}
    for at, mib in memory:
        if at >= settled:
            minutes.setdefault(int(at // 60), []).append(mib)
    return [statistics.median(values) for values in minutes.values() if len(values) > 20]


def spread_of(minutes):
    """How far the furthest is from the middle, in percent."""
    middle = statistics.median(minutes)
    return max(abs(value - middle) for value in minutes) / middle * 100


def report(told, memory, seconds, truth, options, log):
    lines = ["| client | requests | answered 429 or 503 | wrong | failed | longest step in s |", "|---|--:|--:|--:|--:|--:|"]
    wrong = failed = asked = 0
    latencies = array("d")
    faults = []
    for name, count, busy, wrongs, wrong_count, failures, failed_count, times, longest in sorted(told):
        lines.append(f"| {name} | {count:,} | {busy:,} | {wrong_count} | {failed_count} | {longest:.1f} |")
        wrong, failed, asked = wrong + wrong_count, failed + failed_count, asked + count
        faults += wrongs + failures
        latencies.frombytes(times)
    ordered = sorted(latencies)
    median, p99 = ordered[len(ordered) // 2] * 1000, ordered[len(ordered) * 99 // 100] * 1000
    settled = min(SETTLING_MINUTES, options.minutes / 3) * 60
    minutes = median_by_minute(memory, settled) or [memory[-1][1]]
    middle, spread = statistics.median(minutes), spread_of(minutes)
    coarse = spread_of(median_by_minute(memory[::LOOKS], settled) or minutes)
    third = max(1, len(minutes) // 3)
    early, late = statistics.median(minutes[:third]), statistics.median(minutes[-third:])
    growth = (late - early) / early * 100
    stopped = "broke" not in log and "exception" not in log
    verdict = lambda good: "ok" if good else "short"
    floors = [
        f"floor 3: {wrong} wrong answers of {asked:,} (needs 0) {verdict(wrong == 0)}",
        f"floor 3: {failed} failed requests beside 429 and 503 (needs 0) {verdict(failed == 0 and stopped)}",
        f"floor 3: memory of each minute within {spread:.1f}% of {middle:.0f} MiB after {settled / 60:.0f} minutes (needs 5%; first third "
        f"to last {growth:+.1f}%) {verdict(spread <= 5)}",
        f"floor 3: single rays p99 {p99:.2f} ms is {p99 / median:.1f} times the median of {median:.2f} ms (needs at most 5) "
        f"{verdict(p99 <= 5 * median)}"]
    head = [f"`scripts/stress.sh soak --minutes {options.minutes:g}{' --difficult' * options.difficult}` (seed {options.seed}, {options.workers} workers, {os.cpu_count()} "
            f"processors shared with {len(ROLES)} client processes): {seconds / 60:.1f} minutes.",
            f"Truth: a quiet server with kernel {slowest_kernel()} and all trees built, {truth.checked_rays:,} rays of its scenes "
            "answered again by exact brute force.", ""]
    tail = ["", f"Single rays: {len(ordered):,}, median {median:.2f} ms, p90 {ordered[len(ordered) * 9 // 10] * 1000:.2f}, p99 {p99:.2f}, "
            f"worst {ordered[-1] * 1000:.1f}. Memory in MiB, median of each minute from minute {settled / 60:.0f} on: "
            + " ".join(f"{value:.0f}" for value in minutes)
            + f". It was looked at {LOOKS} times a second; of one look a second the medians are within {coarse:.1f}%.", ""]
    text = "\n".join(head + lines + tail + [f"    {floor}" for floor in floors])
    for fault in faults[:40]:
        print("FAULT", fault)
    return text, wrong == 0 and failed == 0, "\n".join(head + lines + tail), floors


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--workers", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--difficult", action="store_true")
    parser.add_argument("--out", type=Path, default=Path("build/stress"))
    options = parser.parse_args()
    sys.argv = [sys.argv[0], options.binary]
    from sightline_server import Server  # takes the binary from the command line
    truth = Truth(Server, options.seed)
    print("the truth is known", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        with Server("--preload", "town=demo:town", "--data", Path(folder, "data"), "--workers", options.workers, "--log-level", "warn") as server:
            told, memory, seconds = measure(server, truth, options)
            lives = server.process.poll() is None
            code = server.stop() if lives else server.process.returncode
            log = server.log_text()
    text, good, table, floors = report(told, memory, seconds, truth, options, log)
    print(table)
    print("\n".join(floors))
    if code != 0 or not lives:
        print(f"the server ended with {code}: {log[-2000:]}")
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "soak.md").write_text("# Everything at once\n\n" + text + "\n", encoding="utf-8")
    return 0 if good and lives and code == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
