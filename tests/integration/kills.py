"""kill -9 at random moments, in the middle of uploads, builds and writes; and what is there afterwards.

Clients put, replace, move, remove and ask scenes of one data folder. A server is killed, another one started,
and every name must have what was acknowledged last, or what was on its way when the server died: whole,
with the right answers. Nothing else may lie in the folder.

    kills.py BINARY [--times N] [--seed S] [--memory-budget BYTES]

With a small budget, scenes and their trees are in mapped temporary files when the server dies.
"""

import argparse
import hashlib
import http.client
import json
import random
import struct
import sys
import tempfile
import threading
import time
from pathlib import Path

import opened_files

CLIENTS = 3
NAMES_EACH = 3
RAYS = 64
HEIGHTS = (0, 0.25, -3)  # where a PATCH has moved the node to; a scene is (sha256, number of one of these)
WRITING = "trees/writing"  # where a server writes trees before they get their name
# A disk as slow as this leaves time to die between any two steps of a commit. (A kill at a random moment
# of a fast disk hardly ever falls between a rename and the next call.)
STEPS = "rename,renameat,renameat2,fsync,fdatasync,unlink,unlinkat"
SLOW_DISK = ["strace", "-D", "-f", "-qq", "--seccomp-bpf", "-o", "/dev/null", "-e", f"trace={STEPS}",
             "-e", f"inject={STEPS}:delay_exit=20000"]
LONGEST_SECONDS = 1.2  # from the start of the clients to the kill


def grid_glb(side, bend):
    """A bent grid of 2 * side * side triangles."""
    positions, indices = bytearray(), bytearray()
    for y in range(side + 1):
        for x in range(side + 1):
            positions += struct.pack("<3f", x / side, (x * bend % 17 + y * y % 13) / 100, y / side)
    for y in range(side):
        for x in range(side):
            a, b = y * (side + 1) + x, (y + 1) * (side + 1) + x
            indices += struct.pack("<6I", a, b, a + 1, a + 1, b, b + 1)
    document = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(positions) + len(indices)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)},
                        {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(positions) // 12,
                       "min": [0, 0, 0], "max": [1, 1, 1]},
                      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": len(indices) // 4}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary = bytes(positions + indices)
    return (struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary)) +
            struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary)


def query_body():
    chance = random.Random(1)
    rays = [{"origin": [chance.uniform(-0.1, 1.1), 2, chance.uniform(-0.1, 1.1)],
             "direction": [chance.uniform(-0.2, 0.2), -1, chance.uniform(-0.2, 0.2)]} for _ in range(RAYS)]
    return json.dumps({"rays": rays, "fields": ["t", "triangle", "normal"]})


QUERY = query_body()


def request(connection, method, path, body=None):
    connection.request(method, path, body, {"Content-Type": "application/json"} if body else {})
    answer = connection.getresponse()
    return answer.status, answer.read()


def move(connection, name, place):
    return request(connection, "PATCH", f"/v1/scenes/{name}/nodes/0", json.dumps({"translation": [0, HEIGHTS[place], 0]}))


def answers_of(connection, name):
    """The hash of what the scene answers, or the problem."""
    status, body = request(connection, "POST", f"/v1/scenes/{name}/rays:closest", QUERY)
    return hashlib.sha256(body).hexdigest() if status == 200 else f"{status} {body[:200]}"


class Client(threading.Thread):
    """Works on names of its own until the connection breaks."""

    def __init__(self, port, seed, names, contents, known):
        super().__init__(daemon=True)
        self.port, self.chance, self.names, self.contents = port, random.Random(seed), names, contents
        self.known = known  # name: (hash, place) of what is certainly there, or None
        self.pending = None  # (name, (hash, place) or None) that may or may not be done
        self.doing = "nothing"
        self.fault = None
        self.done = 0

    def run(self):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        try:
            while True:
                self.step(connection, self.chance.choice(self.names))
                self.done += 1
        except (OSError, http.client.HTTPException):
            pass  # the server is gone
        except Exception as fault:  # shown by the main thread
            self.fault = fault
        finally:
            connection.close()

    def step(self, connection, name):
        kind = self.chance.random()
        if kind < 0.6:
            # Small ones are committed as soon as they are there; large ones are long on their way.
            sizes = [*self.contents]
            self.put(connection, name, self.chance.choice(sizes[:4] if self.chance.random() < 0.7 else sizes[4:]))
        elif kind < 0.7:
            self.remove(connection, name)
        elif kind < 0.85:
            self.move(connection, name, self.chance.randrange(len(HEIGHTS)))
        else:
            self.ask(connection, name)

    def put(self, connection, name, sha256):
        body = self.contents[sha256].body
        self.pending = (name, (sha256, 0))
        self.doing = "uploading"
        connection.putrequest("PUT", f"/v1/scenes/{name}")
        connection.putheader("Content-Type", "model/gltf-binary")
        connection.putheader("Content-Length", str(len(body)))
        connection.endheaders()
        piece = max(len(body) // 8, 1)
        pause = self.chance.choice((0, 0, 0.002, 0.02))  # as a network would
        for at in range(0, len(body), piece):
            connection.send(body[at:at + piece])
            time.sleep(pause)
        self.doing = "building or writing"
        answer = connection.getresponse()
        text = answer.read()
        while answer.status == 202 or (answer.status == 200 and json.loads(text).get("state") == "loading"):
            answer_status, text = request(connection, "GET", f"/v1/scenes/{name}")
            if answer_status == 200 and json.loads(text)["state"] == "ready":
                break
        else:
            if answer.status not in (200, 201):
                raise AssertionError(f"PUT {name}: {answer.status} {text[:300]}")
        if json.loads(text)["sha256"] != sha256:
            raise AssertionError(f"PUT {name} answers with other content")
        self.known[name] = (sha256, 0)
        self.pending, self.doing = None, "nothing"

    def move(self, connection, name, place):
        known = self.known[name]
        self.pending, self.doing = (name, known and (known[0], place)), "moving a node"
        status, text = move(connection, name, place)
        if status != (404 if known is None else 200):
            raise AssertionError(f"PATCH {name}: {status} {text[:300]}")
        self.known[name] = known and (known[0], place)
        self.pending, self.doing = None, "nothing"

    def remove(self, connection, name):
        self.pending, self.doing = (name, None), "removing"
        status, text = request(connection, "DELETE", f"/v1/scenes/{name}")
        if status != (404 if self.known[name] is None else 204):
            raise AssertionError(f"DELETE {name}: {status} {text[:300]}")
        self.known[name] = None
        self.pending, self.doing = None, "nothing"

    def ask(self, connection, name):
        self.doing = "asking"
        found = answers_of(connection, name)
        known = self.known[name]
        if (known is None and not found.startswith("404")) or (known and found != self.contents[known[0]].answers[known[1]]):
            raise AssertionError(f"{name} answers wrongly: {found}")
        self.doing = "nothing"


class Content:
    def __init__(self, body):
        self.body, self.answers = body, []  # one for each of HEIGHTS


class Trial:
    """One data folder and what should be in it."""

    def __init__(self, make_server, folder, seed, budget=None):
        """budget: the --memory-budget of the servers that are killed, in bytes"""
        self.make_server, self.data, self.chance = make_server, Path(folder), random.Random(seed)
        self.contents = {}
        for side, bend in ((4, 3), (5, 5), (40, 3), (60, 7), (150, 3), (200, 5)):
            body = grid_glb(side, bend)
            self.contents[hashlib.sha256(body).hexdigest()] = Content(body)
        self.names = [[f"c{client}-{number}" for number in range(NAMES_EACH)] for client in range(CLIENTS)]
        self.known = {name: None for names in self.names for name in names}
        self.revisions = {}  # name: of the content that is certainly there
        self.largest_revision = 0
        self.kills = self.half_written = self.unsure_done = self.unsure_not_done = self.checked = 0
        self.moments = {}
        self.budget = () if budget is None else ("--memory-budget", budget)
        self.in_files = 0
        self.can_slow = opened_files.why_not() == ""
        self.is_slow = False
        self.learn_answers()

    def learn_answers(self):
        """What each content answers on a server that nobody kills."""
        with self.make_server() as server:
            connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
            for number, content in enumerate(self.contents.values()):
                server.put(f"s{number}", content.body)
                for place in range(len(HEIGHTS)):
                    move(connection, f"s{number}", place)
                    content.answers.append(answers_of(connection, f"s{number}"))
                if any(len(each) != 64 for each in content.answers) or len(set(content.answers)) != len(HEIGHTS):
                    raise AssertionError(content.answers)
            connection.close()

    def new_server(self):
        self.is_slow = self.can_slow and self.chance.random() < 0.5
        return self.make_server("--data", self.data, *self.budget, prefix=SLOW_DISK if self.is_slow else ())

    def run(self, times):
        server = self.new_server()
        try:
            for _ in range(times):
                pending = self.work_and_kill(server)
                if self.chance.random() < 0.25:
                    # Once more while it reads what is there.
                    server = self.make_server("--data", self.data, *self.budget, wait=False)
                    time.sleep(self.chance.uniform(0, 0.05))
                    server.kill()
                    server.end()
                    self.note_kill("starting")
                server = self.new_server()
                self.check(server, pending)
        finally:
            server.end()

    def note_kill(self, moment):
        self.moments[moment] = self.moments.get(moment, 0) + 1

    def work_and_kill(self, server):
        clients = [Client(server.port, self.chance.getrandbits(64), names, self.contents, self.known)
                   for names in self.names]
        for client in clients:
            client.start()
        time.sleep(self.chance.uniform(0, LONGEST_SECONDS))
        if self.budget and server.metric("sightline_overflow_bytes") > 0:
            self.in_files += 1
        writing_before = self.written_last()
        # Half of the times whatever they do; else as soon as one of them does this.
        moment = self.chance.choice((None, None, None, "uploading", "building or writing", "removing", "moving a node", WRITING))
        patience = time.monotonic() + LONGEST_SECONDS
        while moment and time.monotonic() < patience and moment not in (client.doing for client in clients):
            if moment == WRITING and self.written_last() != writing_before:
                break
            time.sleep(0)
        moments = [client.doing for client in clients]
        server.kill()
        for client in clients:
            client.join()
            if client.fault:
                raise client.fault
        server.end()
        self.kills += 1
        if self.is_slow:
            self.note_kill("on a slow disk")
        for moment in moments:
            self.note_kill(moment)
        if self.written_last() not in (None, writing_before):
            self.note_kill("writing trees")
        tmp = self.data / "tmp"
        self.half_written += sum(1 for _ in tmp.iterdir()) if tmp.is_dir() else 0
        return dict(client.pending for client in clients if client.pending)

    def written_last(self):
        """When the file that lies half-written, if there is one, was written last."""
        try:
            return (self.data / WRITING).stat().st_mtime_ns
        except FileNotFoundError:
            return None

    def found(self, connection, name, scene):
        """What a name has now, by its hash and by its answers."""
        if scene.get("state") != "ready":
            return None
        answers = answers_of(connection, name)
        known = self.contents[scene["sha256"]].answers
        if answers not in known:
            raise AssertionError(f"{name} answers wrongly after a kill: {answers}")
        return scene["sha256"], known.index(answers)

    def check(self, server, pending):
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
        ready = json.loads(request(connection, "GET", "/readyz")[1])
        if ready.get("failed"):
            raise AssertionError(f"failed after a kill: {ready}")
        for name in self.known:
            status, text = request(connection, "GET", f"/v1/scenes/{name}")
            scene = json.loads(text) if status == 200 else {}
            found = self.found(connection, name, scene)
            if status not in (200, 404) or (status == 200 and scene["state"] != "ready"):
                raise AssertionError(f"{name}: {status} {text[:300]}")
            if found != self.known[name]:
                if name not in pending or found != pending[name]:
                    raise AssertionError(f"{name} has {found}; acknowledged was {self.known[name]}, "
                                         f"on its way {pending.get(name, 'nothing')}")
                self.unsure_done += 1
                self.known[name] = found
            elif name in pending:
                self.unsure_not_done += 1
            self.checked += found is not None
        listed = json.loads(request(connection, "GET", "/v1/scenes")[1])["scenes"]
        connection.close()
        there = {name for name, content in self.known.items() if content}
        if {scene["id"] for scene in listed} != there:
            raise AssertionError(f"listed are {listed}, there should be {sorted(there)}")
        numbers = [scene["revision"] for scene in listed]
        if len(set(numbers)) != len(numbers):
            raise AssertionError(f"a revision was given twice: {numbers}")
        self.check_folder()

    def check_folder(self):
        """What lies on the disk is what the names need, whole, and nothing else."""
        held = {content[0] for content in self.known.values() if content}
        records = {name + ".json" for name, content in self.known.items() if content}
        wanted = {"blobs": held, "scenes": records, "tmp": set(), "quarantine": set()}
        for folder, names in wanted.items():
            found = {file.name for file in (self.data / folder).iterdir()}
            if found != names:
                raise AssertionError(f"in {folder}/ lie {sorted(found)}, there should be {sorted(names)}")
        for sha256 in held:
            if hashlib.sha256((self.data / "blobs" / sha256).read_bytes()).hexdigest() != sha256:
                raise AssertionError(f"blobs/{sha256} has other bytes")
        # Caches are named by the content that they belong to; those of no content are left over.
        # The next write begins revision.new and trees/writing anew: there is never more than one.
        known = {"format", "lock", "revision", "revision.new", WRITING}
        for file in self.data.rglob("*"):
            name = str(file.relative_to(self.data))
            if file.is_dir() or name in known or name.split("/")[0] in wanted:
                continue
            if not any(sha256 in file.name for sha256 in held):
                raise AssertionError(f"left over: {name}")

    def text(self):
        files = f"{self.in_files} times scenes were in mapped temporary files; " if self.budget else ""
        moments = ", ".join(f"{moment} {count}" for moment, count in sorted(self.moments.items()))
        return (f"{self.kills} kills while {CLIENTS} clients were: {moments}. {files}{self.checked} scenes asked afterwards, "
                f"all right; of what was on its way {self.unsure_done} were done and {self.unsure_not_done} not; "
                f"{self.half_written} half-written files lay there, none after the next start")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--times", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="0: another one each time")
    parser.add_argument("--memory-budget", type=int, help="of the servers that are killed, in bytes")
    options = parser.parse_args()
    seed = options.seed or random.SystemRandom().getrandbits(32)
    print(f"seed {seed}", flush=True)
    sys.argv = [sys.argv[0], options.binary]
    from sightline_server import Server  # takes the binary from the command line
    with tempfile.TemporaryDirectory() as folder:
        trial = Trial(Server, Path(folder, "data"), seed, options.memory_budget)
        try:
            trial.run(options.times)
        except AssertionError as fault:
            print(f"FAILED after {trial.kills} kills: {fault}", flush=True)
            return 1
        print(trial.text(), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
