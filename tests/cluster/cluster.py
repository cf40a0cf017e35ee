"""Three replicas behind HAProxy, one object store, and faults: cluster.py BINARY [--minutes N] [--scenes N] [--kills N]

Writers PUT, PATCH and DELETE scenes; readers ask them, by HAProxy and by each replica, and require the revision that was last
acknowledged. Meanwhile replicas are killed and stopped, and the object store is lost and returns. Each scene is a box whose
height tells which change it has: an answer is judged against the changes that were acknowledged or were under way.

Closes with one line for each kind of fault:
  wrong    an answer that no allowed change gives
  lost     an acknowledged change that a later read, which required its revision, did not show
  old      an answer of a revision below the required one
  failed   a query without an answer after the retries of a client (30 s)
"""

import argparse
import json
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "integration"))
sys.path.insert(0, str(Path(__file__).resolve().parent))

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("binary")
parser.add_argument("--minutes", type=float, default=3)
parser.add_argument("--scenes", type=int, default=300)
parser.add_argument("--kills", type=int, default=10)
parser.add_argument("--seed", type=int, default=1)
arguments = parser.parse_args()
sys.argv = [sys.argv[0], arguments.binary]

from object_store import BUCKET, ObjectStore  # noqa: E402
from radosgw import Radosgw, free_port  # noqa: E402
from sightline_server import demo_glb  # noqa: E402

RAY = json.dumps({"rays": [{"origin": [-1, 1000, 0.1], "direction": [0, -1, 0]}], "fields": ["t", "position", "node"]}).encode()


class Replica:
    """A server on a port of its own, which stays over restarts."""

    def __init__(self, number, folder, origin):
        self.number, self.folder, self.origin = number, folder, origin
        self.port = free_port()
        self.process = None
        self.start()

    def start(self):
        log = open(self.folder / f"replica{self.number}.log", "ab")
        self.process = subprocess.Popen(
            [arguments.binary, "serve", "--listen", f"127.0.0.1:{self.port}", "--data", str(self.folder / f"data{self.number}"),
             "--origin", self.origin[0], "--origin-credentials", self.origin[1], "--origin-seconds", "2", "--memory", str(256 << 20)],
            stdout=log, stderr=log)
        log.close()

    def end(self, number):
        self.process.send_signal(number)
        self.process.wait()


HAPROXY = """defaults
  mode http
  timeout connect 2s
  timeout client 60s
  timeout server 60s
  timeout check 10s
  retries 5
  option redispatch 1
  retry-on conn-failure empty-response 503
frontend all
  bind 127.0.0.1:{port}
  default_backend replicas
backend replicas
  balance uri depth 3
  hash-type consistent
  hash-balance-factor 125
  option httpchk GET /readyz
  default-server inter 500ms fall 3 rise 1
"""


class Tally:
    def __init__(self):
        self.lock = threading.Lock()
        self.counts = {name: 0 for name in ("queries", "changes", "wrong", "lost", "old", "failed", "haproxy_failed", "unacknowledged", "kills")}
        self.times = []
        self.notes = []

    def add(self, name, note=None):
        with self.lock:
            self.counts[name] += 1
            if note and len(self.notes) < 20:
                self.notes.append(f"{name}: {note}")


def request(url, method="GET", body=None, headers=None, patience=20):
    """(status, headers, body); None if there is no answer."""
    ask = urllib.request.Request(url, data=body, method=method, headers=headers or {})
    try:
        with urllib.request.urlopen(ask, timeout=patience) as answer:
            return answer.status, answer.headers, answer.read()
    except urllib.error.HTTPError as answer:
        return answer.code, answer.headers, answer.read()
    except OSError:
        return None
    except Exception as fault:  # a connection that ends within an answer
        if type(fault).__module__ != "http.client":
            raise
        return None


class Scene:
    """What is known of a scene. One writer at a time; readers see the last acknowledged state, and what is under way."""

    def __init__(self, name):
        self.name = name
        self.lock = threading.Lock()
        self.revision = 0  # of the last acknowledged change
        self.height = None  # None: there is no scene
        self.open = []  # heights of changes that were sent since, of which no answer came; None: a removal
        self.history = {}  # height by revision, where it is known


class Cluster:
    def __init__(self, folder):
        self.folder, self.tally = folder, Tally()
        self.random = random.Random(arguments.seed)
        self.stop = threading.Event()
        self.six = demo_glb("six")
        if shutil.which("radosgw"):
            self.store = Radosgw(folder / "ceph")
            self.kind, self.bucket = "radosgw", "scenes"
            self.lose, self.give_back = self.store.stop_gateway, self.store.start_gateway
        else:
            self.store = ObjectStore()
            self.store.__enter__()
            self.kind, self.bucket = "an object store of this test (radosgw is not installed)", BUCKET
            self.lose, self.give_back = (lambda: setattr(self.store, "down", True)), (lambda: setattr(self.store, "down", False))
        credentials = folder / "credentials"
        credentials.write_text(self.store.credentials(), encoding="ascii")
        self.replicas = [Replica(i, folder, (f"s3://{self.bucket}/cluster", str(credentials))) for i in range(3)]
        self.haproxy, self.front = None, None
        if shutil.which("haproxy"):
            port = free_port()
            lines = [f"  server r{each.number} 127.0.0.1:{each.port} check" for each in self.replicas]
            (folder / "haproxy.cfg").write_text(HAPROXY.format(port=port) + "\n".join(lines) + "\n", encoding="ascii")
            self.haproxy = subprocess.Popen(["haproxy", "-q", "-db", "-f", str(folder / "haproxy.cfg")])
            self.front = f"http://127.0.0.1:{port}"
        self.scenes = [Scene(f"s{i}") for i in range(arguments.scenes)]

    def url(self, replica):
        return f"http://127.0.0.1:{replica.port}"

    def write(self, scene, dice):
        """One change by any replica, sent until it is acknowledged or refused for good."""
        replica = dice.choice(self.replicas)
        with scene.lock:
            kind = "put" if scene.height is None else dice.choice(["patch"] * 6 + ["put", "delete"])
            height = dice.randrange(1, 500)
            scene.open.append(None if kind == "delete" else 0 if kind == "put" else height)
        base = f"{self.url(replica)}/v1/scenes/{scene.name}"
        if kind == "put":
            answer = request(base + "?wait=30", "PUT", self.six, {"Content-Type": "model/gltf-binary"})
        elif kind == "patch":
            answer = request(f"{base}/nodes/0", "PATCH", json.dumps({"translation": [0, height, 0]}).encode(), {"Content-Type": "application/json"})
        else:
            answer = request(base, "DELETE")
        self.tally.add("changes")
        with scene.lock:
            if answer is None or answer[0] >= 500 or answer[0] in (202, 404, 409):
                self.tally.add("unacknowledged")
                return  # it may have been made or not: `open` has it
            if kind == "delete":
                scene.height, scene.open = None, []
                scene.revision = int(answer[1]["X-Scene-Revision"])
                return
            scene.revision = json.loads(answer[2])["revision"]
            scene.height = 0 if kind == "put" else height
            scene.open = []

    def read(self, scene, dice, through_haproxy):
        with scene.lock:
            least, allowed = scene.revision, {scene.height, *scene.open}
        begun, answer = time.monotonic(), None
        while time.monotonic() < begun + 30:
            base = self.front if through_haproxy else self.url(dice.choice(self.replicas))
            answer = request(f"{base}/v1/scenes/{scene.name}/rays:closest", "POST", RAY,
                             {"Content-Type": "application/json", "X-Scene-Min-Revision": str(least)})
            if answer and answer[0] in (200, 404):
                break
            if through_haproxy and not self.store_is_lost.is_set():
                self.tally.add("haproxy_failed", f"{scene.name} {answer and answer[:1]} {answer and answer[2][:200]}")
            time.sleep(0.2)
        spent = time.monotonic() - begun
        with scene.lock:
            allowed |= {scene.height, *scene.open} | {h for h in scene.history.values()}
            changed = scene.revision != least
        self.tally.add("queries")
        with self.tally.lock:
            self.tally.times.append(spent)
        if not answer or answer[0] not in (200, 404):
            if not self.store_is_lost.is_set():
                self.tally.add("failed", f"{scene.name} {answer and answer[:1]} {answer and answer[2][:200]}")
            return
        if answer[0] == 404:
            if None not in allowed and not changed:
                self.tally.add("lost", f"{scene.name} is gone")
            return
        if int(answer[1]["X-Scene-Revision"]) < least:
            self.tally.add("old", f"{scene.name} {answer[1]['X-Scene-Revision']} < {least}")
        hit = json.loads(answer[2])["hits"][0]
        seen = round(1000 - hit["t"]) if hit else None
        return seen, allowed, changed

    def work(self, seed):
        dice = random.Random(seed)
        mine = self.scenes[seed::4]  # one writer for a scene: what was acknowledged last is known
        while not self.stop.is_set():
            scene = dice.choice(mine)
            if dice.random() < 0.3:
                self.write(scene, dice)
                continue
            outcome = self.read(scene, dice, self.front is not None and dice.random() < 0.5)
            if outcome is None:
                continue
            seen, allowed, _ = outcome
            if seen is None or all(each is None or abs(each + self.base - seen) > 1 for each in allowed):
                self.tally.add("wrong", f"{scene.name} shows {seen}, allowed {sorted(map(str, allowed))}")

    def run(self):
        self.store_is_lost = threading.Event()
        for replica in self.replicas:
            while (answer := request(self.url(replica) + "/readyz")) is None or answer[0] != 200:
                time.sleep(0.1)
        probe = Scene("probe")
        while probe.height is None:
            self.write(probe, self.random)
        self.base = 0
        self.base = self.read(probe, self.random, False)[0]
        workers = [threading.Thread(target=self.work, args=(i,)) for i in range(4)]
        for worker in workers:
            worker.start()
        end = time.monotonic() + arguments.minutes * 60
        pause = arguments.minutes * 60 / (arguments.kills + 1)
        for i in range(arguments.kills):
            time.sleep(pause * 0.7)
            if i % 5 == 4:
                self.store_is_lost.set()
                self.lose()
                time.sleep(pause * 0.2)
                self.give_back()
                time.sleep(1)
                self.store_is_lost.clear()
            else:
                replica = self.random.choice(self.replicas)
                replica.end(signal.SIGTERM if i % 5 == 3 else signal.SIGKILL)
                time.sleep(pause * 0.2)
                replica.start()
            self.tally.add("kills")
        time.sleep(max(0, end - time.monotonic()))
        self.stop.set()
        for worker in workers:
            worker.join()
        times = sorted(self.tally.times)
        print("\n".join(self.tally.notes))
        print(f"{self.kind}, {'HAProxy' if self.front else 'no HAProxy'}, {arguments.scenes} scenes, {arguments.minutes} minutes")
        print(f"p50 {times[len(times) // 2] * 1000:.1f} ms, p99 {times[len(times) * 99 // 100] * 1000:.1f} ms, most {times[-1] * 1000:.0f} ms, during faults")
        print(", ".join(f"{count} {name}" for name, count in self.tally.counts.items()))
        return all(self.tally.counts[name] == 0 for name in ("wrong", "lost", "old", "failed", "haproxy_failed"))

    def end(self):
        self.stop.set()
        for process in [each.process for each in self.replicas] + ([self.haproxy] if self.haproxy else []):
            if process.poll() is None:
                process.kill()
                process.wait()
        if isinstance(self.store, ObjectStore):
            self.store.__exit__()
        else:
            self.store.stop()


def main():
    with tempfile.TemporaryDirectory() as name:
        cluster = Cluster(Path(name))
        try:
            good = cluster.run()
        finally:
            cluster.end()
    print("1 passed, 0 failed" if good else "0 passed, 1 failed")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
