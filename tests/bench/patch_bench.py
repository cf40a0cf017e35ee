"""PATCH of 1,000 of 4,000 nodes over one connection, durable: at most 50 ms as a median.

Each change moves or turns a node. Scenes: one mesh placed 4,000 times, and 4,000 meshes placed once; with no tree built, and with all
trees built. "first" is the first change after a start; "rays" is the first ray after a change. "bytes" is the time to write two files
of the record's size, with fsync of file and folder: what the disk takes.

Usage: patch_bench.py SIGHTLINE [ROUNDS]
"""

import http.client
import json
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SOURCE / "tests/integration")]
from made_scene import tiles  # noqa: E402  (found only now)
from sightline_server import Server  # noqa: E402

NODES, CHANGED, MOST_MS = 4000, 1000, 50


def changes(turn):
    """1,000 nodes, spread over all, at places of their own in each round."""
    step = NODES // CHANGED
    places = [(turn + step * i) % NODES for i in range(CHANGED)]
    return [{"node": n, "translation": [10 * (n % 32), (turn + n) % 7 / 4, 10 * (n // 32)], "rotation": [0, 0, 0.6, 0.8]} for n in places]


def write_durably(folder, size):
    for name in ("revision", "record"):
        with open(folder / name, "wb") as file:
            file.write(bytes(size if name == "record" else 8))
            file.flush()
            os.fsync(file.fileno())
        parent = os.open(folder, os.O_RDONLY)
        os.fsync(parent)
        os.close(parent)


def timed(action):
    begin = time.perf_counter()
    action()
    return (time.perf_counter() - begin) * 1000


def main():
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 15
    short = 0
    for name, body in (("one mesh", tiles(4, NODES)), ("a mesh for each node", tiles(4, NODES, own=True))):
        for built in (False, True):
            with tempfile.TemporaryDirectory() as folder:
                arguments = ("--skip", "none") if built else ()
                with Server("--data", Path(folder, "data"), "--log-level", "warn", *arguments, memory=None) as server:
                    answer = server.put("tiles", body)
                    assert answer.status == 201, answer.body
                    connection = http.client.HTTPConnection("127.0.0.1", server.port)

                    def send(method, path, body, connection=connection):
                        connection.request(method, path, body, {"Content-Type": "application/json"})
                        answer = connection.getresponse()
                        text = answer.read()
                        assert answer.status == 200, text

                    ray = json.dumps({"rays": [{"origin": [5, 50, 5], "direction": [0, -1, 0.01]}]})

                    def cast(ray=ray, send=send):
                        send("POST", "/v1/scenes/tiles/rays:closest", ray)

                    cast()
                    patches, rays = [], []
                    for turn in range(rounds):
                        body_text = json.dumps({"nodes": changes(turn)})
                        patches.append(timed(lambda text=body_text: send("PATCH", "/v1/scenes/tiles/nodes", text)))
                        rays.append(timed(cast))
                    connection.close()
                size = next(Path(folder, "data").rglob("tiles.json")).stat().st_size
                writes = [timed(lambda: write_durably(Path(folder), size)) for _ in range(rounds)]
            median = statistics.median(patches)
            print(f"{name}, {'all trees' if built else 'no tree'}: {median:.1f} ms ({min(patches):.1f} to {max(patches):.1f}, "
                  f"first {patches[0]:.1f}), rays {statistics.median(rays):.1f} ms, bytes {statistics.median(writes):.1f} ms")
            short += median > MOST_MS
    print(f"floor patch: {short} of 4 medians above {MOST_MS} ms (needs 0) {'short' if short else 'ok'}")
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main())
