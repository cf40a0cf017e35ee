"""Writers of one scene, each by a server of its own, that share an origin: writers.py BINARY [--rounds N] [--folder] [--seed N]

In each round four writers change the height of a node at once. In even rounds all require the content of the last round (If-Match): one
succeeds, the others get 412. In odd rounds none requires it: all succeed. The revisions of all successes follow each other without a gap.
After each round another server, chosen at random and required to have the newest revision, must answer a ray with the height of the writer
that has this revision.

The origin is radosgw (radosgw.py), or with --folder a folder. Closes with the number of lost and double changes, and "1 passed, 0 failed"
if there are none.
"""

import argparse
import http.client
import json
import random
import sys
import tempfile
import threading
import time
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/integration"))

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("binary")
parser.add_argument("--rounds", type=int, default=1000, help="default: %(default)s")
parser.add_argument("--folder", action="store_true", help="the origin is a folder")
parser.add_argument("--seed", type=int, default=1, help="default: %(default)s")
arguments = parser.parse_args()
sys.argv = [sys.argv[0], arguments.binary]

from made_scene import tiles  # noqa: E402  (found only now)
from radosgw import Radosgw  # noqa: E402
from sightline_server import Server  # noqa: E402

WRITERS = 4
SCENE = "/v1/scenes/tile"
RAY = json.dumps({"rays": [{"origin": [0.4, 1 << 22, 0.3], "direction": [0, -1, 0]}], "fields": ["position"]})


class Writer:
    """A server. Each request has a connection of its own: a server may end one that waits between two rounds."""

    def __init__(self, folder, number, origin):
        self.server = Server("--data", folder / f"data{number}", "--log-level", "warn", *origin)

    def ask(self, method, path, body, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=120)
        connection.request(method, path, body, {"Content-Type": "application/json", **{name.replace("_", "-"): text for name, text in headers.items()}})
        answer = connection.getresponse()
        text = answer.read()
        connection.close()
        return answer.status, answer.headers, text

    def change(self, height, tag):
        """(status, revision, tag, height)"""
        condition = {"If_Match": tag} if tag else {}
        status, headers, text = self.ask("PATCH", f"{SCENE}/nodes/0", json.dumps({"translation": [0, height, 0]}), **condition)
        if status not in (200, 412):
            raise RuntimeError(f"{status} {text[:300]}")
        return status, int(headers["X-Scene-Revision"] or 0), headers["ETag"], height

    def height(self, revision):
        status, headers, text = self.ask("POST", f"{SCENE}/rays:closest", RAY, X_Scene_Min_Revision=str(revision))
        if status != 200:
            raise RuntimeError(f"{status} {text[:300]}")
        return int(headers["X-Scene-Revision"]), json.loads(text)["hits"][0]["position"][1]


def run(folder, origin):
    writers = [Writer(folder, i, origin) for i in range(WRITERS)]
    try:
        put = writers[0].server.put("tile", tiles(1, 1))
        if put.status != 201:
            raise RuntimeError(put.body)
        dice, lost, double, begin = random.Random(arguments.seed), 0, 0, time.monotonic()
        revision, base = writers[0].height(0)
        tag, height = put.headers["etag"], 0
        for turn in range(arguments.rounds):
            condition, results, ready = tag if turn % 2 == 0 else None, [None] * WRITERS, threading.Barrier(WRITERS)

            def write(i, condition=condition, results=results, ready=ready, height=height):
                ready.wait()
                results[i] = writers[i].change(height + 1 + i, condition)
            threads = [threading.Thread(target=write, args=(i,)) for i in range(WRITERS)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            if None in results:
                raise RuntimeError(f"round {turn}: a change had no answer")
            done = sorted(result[1:] for result in results if result[0] == 200)
            expected = 1 if condition else WRITERS
            lost += max(0, expected - len(done))
            double += max(0, len(done) - expected)
            if [each[0] for each in done] != list(range(revision + 1, revision + 1 + len(done))):
                lost += 1
                print(f"round {turn}: revision {revision}, then {[each[0] for each in done]}")
            if done:
                revision, tag, at = done[-1]
            seen, found = dice.choice(writers).height(revision)
            if seen != revision or round(found - base) != at:
                lost += 1
                print(f"round {turn}: revision {revision} has height {at}, the answer of revision {seen} has {found - base}")
            height += WRITERS
        seconds = time.monotonic() - begin
        print(f"{arguments.rounds} rounds of {WRITERS} writers, {'a folder' if arguments.folder else 'radosgw'}, {seconds:.0f} s: "
              f"{lost} lost, {double} double")
        return lost == double == 0
    finally:
        for writer in writers:
            writer.server.end()


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if arguments.folder:
            good = run(folder, ("--origin", folder / "origin"))
        else:
            (folder / "store").mkdir()
            store = Radosgw(folder / "store")
            try:
                credentials = folder / "credentials"
                credentials.write_text(store.credentials(), encoding="ascii")
                good = run(folder, ("--origin", "s3://scenes/writers", "--origin-credentials", credentials))
            finally:
                store.stop()
    print("1 passed, 0 failed" if good else "0 passed, 1 failed")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
