"""Three replicas behind HAProxy, one object store, and faults: cluster.py BINARY [--minutes N] [--scenes N] [--kills N]

Writers PUT, PATCH and DELETE scenes with the Python client; readers ask them, by that client and by HAProxy without repetition,
and require the revision that was last acknowledged. Each scene is a box whose height tells which change it has: an answer is
judged against the changes that were acknowledged or were under way. Meanwhile there are faults, in turn:
  kill     SIGKILL of a replica
  stop     SIGTERM of a replica
  slow     a replica that runs for a fifth of the time (SIGSTOP, SIGCONT)
  store    the object store is lost and returns
  full     the disk of a replica is full (where a small disk can be mounted)
  roll     a rolling restart: each replica in turn
  scale    two replicas leave, and come again with empty disks: from 3 to 1 to 3

Closes with the counts of each kind of failure:
  wrong           an answer that no allowed change gives
  lost            an acknowledged change that a later read, which required its revision, did not show
  old             an answer of a revision below the required one
  failed          a query without an answer by the client, which repeats for 30 s
  haproxy_failed  an answer of HAProxy that is neither 200 nor 404
A query that fails while the object store is lost does not count: a replica cannot know the newest revision then.
"""

import argparse
import http.client
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

SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/integration"))
sys.path.insert(0, str(SOURCE / "proto/python"))

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("binary")
parser.add_argument("--minutes", type=float, default=3)
parser.add_argument("--scenes", type=int, default=300)
parser.add_argument("--kills", type=int, default=10)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--faults", default="kill,stop,slow,kill,store,roll,full,kill,scale,kill", help="the kinds, in turn; default: %(default)s")
arguments = parser.parse_args()
sys.argv = [sys.argv[0], arguments.binary]

import balancer  # noqa: E402  (found only now)
import sightline  # noqa: E402
from object_store import BUCKET, ObjectStore  # noqa: E402
from radosgw import Radosgw, free_port  # noqa: E402
from sightline_server import demo_glb  # noqa: E402

RAY = json.dumps({"rays": [{"origin": [-1, 1000, 0.1], "direction": [0, -1, 0]}], "fields": ["t", "position", "node"]}).encode()
LOST = (OSError, http.client.HTTPException)


class Replica:
    """A server on a port of its own, which stays over restarts, with a small disk where one can be mounted."""

    def __init__(self, number, folder, origin):
        self.number, self.folder, self.origin = number, folder, origin
        self.data = folder / f"data{number}"
        self.data.mkdir()
        self.disk = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "none", self.data], capture_output=True, check=False).returncode == 0
        self.port = free_port()
        self.process = None
        self.start()

    @property
    def url(self):
        return f"http://127.0.0.1:{self.port}"

    def start(self):
        with open(self.folder / f"replica{self.number}.log", "ab") as log:
            self.process = subprocess.Popen(
                [arguments.binary, "serve", "--listen", f"127.0.0.1:{self.port}", "--data", str(self.data), "--origin", self.origin[0],
                 "--origin-credentials", self.origin[1], "--origin-seconds", "2", "--memory", str(256 << 20)], stdout=log, stderr=log)

    def end(self, number):
        self.process.send_signal(number)
        self.process.wait()

    def wait_ready(self):
        while (answer := request(self.url + "/readyz")) is None or answer[0] != 200:
            time.sleep(0.05)

    def clear(self):
        """Removes what is on its disk."""
        for each in self.data.iterdir():
            shutil.rmtree(each) if each.is_dir() else each.unlink()

    def remove(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)
            self.end(signal.SIGKILL)
        if self.disk:
            subprocess.run(["umount", self.data], check=True)


class Tally:
    def __init__(self):
        self.lock = threading.Lock()
        self.counts = {name: 0 for name in ("queries", "changes", "wrong", "lost", "old", "failed", "haproxy_failed", "unacknowledged", "faults")}
        self.times = {"client": [], "HAProxy": []}
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
        self.scenes = [Scene(f"s{i}") for i in range(arguments.scenes)]

    def client(self):
        """As it is shipped, but for the wait for a server that does not answer."""
        return sightline.Sightline([replica.url for replica in self.replicas], timeout=10)

    def write(self, scene, dice, client):
        """One change, sent until it is acknowledged or refused for good."""
        with scene.lock:
            kind = "put" if scene.height is None else dice.choice(["patch"] * 6 + ["put", "delete"])
            height = dice.randrange(1, 500)
            scene.open.append(None if kind == "delete" else 0 if kind == "put" else height)
        self.tally.add("changes")
        revision = None
        try:
            if kind == "put":
                state = client.put(scene.name, self.six, wait=30)
                revision = state["revision"] if state["state"] == "ready" else None
            elif kind == "patch":
                revision = client.patch_node(scene.name, 0, translation=[0, height, 0])["revision"]
            else:
                client.delete(scene.name)
                revision = client._revisions.get(scene.name)
        except (sightline.SightlineError, *LOST):
            pass
        with scene.lock:
            if revision is None or revision <= scene.revision:
                self.tally.add("unacknowledged")
                return  # It may have been made or not: `open` has it.
            scene.height = {"put": 0, "patch": height, "delete": None}[kind]
            scene.revision, scene.open = revision, []

    def ask_haproxy(self, scene, least):
        """(status, revision, distance or None) of the first answer."""
        is_lost = self.store_is_lost.is_set()
        answer = request(f"{self.front}/v1/scenes/{scene.name}/rays:closest", "POST", RAY,
                         {"Content-Type": "application/json", "X-Scene-Min-Revision": str(least)})
        if answer and answer[0] == 409 and json.loads(answer[2])["code"] == "SCENE_LOADING":
            return 404, None, None  # It is not there yet.
        if not answer or answer[0] not in (200, 404):
            if not is_lost and not self.store_is_lost.is_set():
                self.tally.add("haproxy_failed", f"{self.fault} {scene.name} {answer and answer[0]} {answer and answer[2][:200]}")
            return None
        hit = json.loads(answer[2])["hits"][0] if answer[0] == 200 else None
        return answer[0], answer[1]["X-Scene-Revision"], hit and hit["t"]

    def ask_client(self, scene, client):
        is_lost = self.store_is_lost.is_set()
        try:
            headers, text, _ = client._exchange("POST", client._scene(scene.name, "/rays:closest"), RAY, "application/json")
            hit = json.loads(text)["hits"][0]
            return 200, headers["X-Scene-Revision"], hit and hit["t"]
        except (sightline.SightlineError, *LOST) as error:
            if getattr(error, "status", None) == 404 or getattr(error, "code", None) == "SCENE_LOADING":
                return 404, None, None
            if not is_lost and not self.store_is_lost.is_set():
                self.tally.add("failed", f"{self.fault} {scene.name} {type(error).__name__} {error}")
            return None

    def read(self, scene, dice, client):
        with scene.lock:
            least, allowed = scene.revision, {scene.height, *scene.open}
        way = "HAProxy" if self.front and dice.random() < 0.5 else "client"
        begun = time.monotonic()
        answer = self.ask_haproxy(scene, least) if way == "HAProxy" else self.ask_client(scene, client)
        spent = time.monotonic() - begun
        with self.tally.lock:
            self.tally.times[way].append(spent)
        self.tally.add("queries")
        if answer is None:
            return None
        status, revision, t = answer
        if status == 404:
            if None not in allowed:
                self.tally.add("lost", f"{self.fault} {scene.name} is gone")
            return None
        if int(revision) < least:
            self.tally.add("old", f"{self.fault} {scene.name} {revision} < {least}")
        return (None if t is None else round(1000 - t)), allowed

    def work(self, seed):
        dice = random.Random(seed)
        mine = self.scenes[seed::4]  # One thread for a scene: what was acknowledged last is known.
        with self.client() as client:
            while not self.stop.is_set():
                scene = dice.choice(mine)
                if dice.random() < 0.3:
                    self.write(scene, dice, client)
                    continue
                outcome = self.read(scene, dice, client)
                if outcome is None:
                    continue
                seen, allowed = outcome
                if seen is None or all(each is None or abs(each + self.base - seen) > 1 for each in allowed):
                    self.tally.add("wrong", f"{self.fault} {scene.name} shows {seen}, allowed {sorted(map(str, allowed))}")

    def homes(self, count):
        """The first server of each scene, of so many replicas."""
        with sightline.Sightline([replica.url for replica in self.replicas[:count]], shared=True) as client:
            return [client._servers(scene.name)[0].url for scene in self.scenes]

    def cause(self, kind, seconds):
        """One fault, which ends after about so many seconds."""
        replica = self.random.choice(self.replicas)
        if kind in ("kill", "stop"):
            replica.end(signal.SIGKILL if kind == "kill" else signal.SIGTERM)
            time.sleep(seconds)
            replica.start()
            replica.wait_ready()
        elif kind == "slow":
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                replica.process.send_signal(signal.SIGSTOP)
                time.sleep(0.2)
                replica.process.send_signal(signal.SIGCONT)
                time.sleep(0.05)
        elif kind == "store":
            self.store_is_lost.set()
            self.lose()
            time.sleep(seconds)
            self.give_back()
            time.sleep(1)
            self.store_is_lost.clear()
        elif kind == "full" and replica.disk:
            end = time.monotonic() + seconds
            while time.monotonic() < end:  # What the replica removes is filled again.
                try:
                    with open(replica.data / "ballast", "ab", 0) as ballast:
                        while time.monotonic() < end:
                            ballast.write(bytes(4096))
                except OSError:
                    time.sleep(0.02)
            (replica.data / "ballast").unlink(missing_ok=True)
        elif kind == "roll":
            for each in self.replicas:
                each.end(signal.SIGTERM)
                each.start()
                each.wait_ready()
                time.sleep(2)  # HAProxy must see that it is back, as an orchestrator waits between two.
        elif kind == "scale":
            for each in self.replicas[1:]:
                each.end(signal.SIGTERM)
                time.sleep(2)
            time.sleep(seconds)
            for each in self.replicas[1:]:
                each.clear()
                each.start()
                each.wait_ready()
                time.sleep(2)
        else:
            return
        self.tally.add("faults")

    def run(self):
        self.store_is_lost, self.fault = threading.Event(), "before the faults:"
        for replica in self.replicas:
            replica.wait_ready()
        if balancer.PROGRAM:
            self.haproxy = balancer.Balancer([each.port for each in self.replicas]).__enter__()
            self.front = self.haproxy.url
        probe = Scene("probe")
        with self.client() as client:
            while probe.height is None:
                self.write(probe, self.random, client)
            self.base = 0
            self.base = round(1000 - self.ask_client(probe, client)[2])
        workers = [threading.Thread(target=self.work, args=(i,)) for i in range(4)]
        for worker in workers:
            worker.start()
        end = time.monotonic() + arguments.minutes * 60
        pause = arguments.minutes * 60 / (arguments.kills + 1)
        kinds = arguments.faults.split(",")
        for i in range(arguments.kills):
            time.sleep(max(0.5, end - time.monotonic() - (arguments.kills - i) * pause))
            self.fault = kinds[i % len(kinds)]
            self.cause(self.fault, pause * 0.2)
        time.sleep(max(0, end - time.monotonic()))
        self.stop.set()
        for worker in workers:
            worker.join()
        print("\n".join(self.tally.notes))
        print(f"{self.kind}, {'HAProxy' if self.front else 'no HAProxy'}, {arguments.scenes} scenes, {arguments.minutes} minutes, faults in turn: "
              f"{arguments.faults}{'' if self.replicas[0].disk else ' (no small disk: none was full)'}")
        for way, times in self.tally.times.items():
            times.sort()
            if times:
                print(f"{way}: p50 {times[len(times) // 2] * 1000:.1f} ms, p99 {times[len(times) * 99 // 100] * 1000:.1f} ms, most {times[-1] * 1000:.0f} ms")
        three, one = self.homes(3), self.homes(1)
        print(f"scaling: {sum(a != b for a, b in zip(three, one))} of {len(three)} scenes have another first server with three replicas than with one")
        print(", ".join(f"{count} {name}" for name, count in self.tally.counts.items()))
        return all(self.tally.counts[name] == 0 for name in ("wrong", "lost", "old", "failed", "haproxy_failed"))

    def end(self):
        self.stop.set()
        for replica in self.replicas:
            replica.remove()
        if self.haproxy:
            self.haproxy.__exit__()
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
