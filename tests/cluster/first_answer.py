"""How soon a server answers from a scene of 1 M triangles that another one has built: first_answer.py BINARY [--rounds N] [--rays N]

A server puts the scene, builds its trees and stores them in the origin. Then, in turns:
  built    a server with an empty disk and an origin that has the file, but no trees; it builds all of them before it answers (--skip none)
  shared   a server with an empty disk and the origin with the trees
Both get the first ray as soon as they listen. At the end three servers of the shared origin, of which none has built, answer --rays random
rays: their bytes must be identical.

Closes with "1 passed, 0 failed" if the bytes are identical, no server of the shared origin has built a tree, and the median time to the
first answer is at least 10 times shorter than that with the build.
"""

import argparse
import hashlib
import http.client
import json
import re
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy

SOURCE = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SOURCE / "tests/integration"), str(SOURCE / "proto/python")]

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("binary")
parser.add_argument("--rounds", type=int, default=7, help="default: %(default)s")
parser.add_argument("--rays", type=int, default=1_000_000, help="default: %(default)s")
parser.add_argument("--seed", type=int, default=1, help="default: %(default)s")
arguments = parser.parse_args()
sys.argv = [sys.argv[0], arguments.binary]

import sightline  # noqa: E402  (found only now)
from made_scene import tiles  # noqa: E402
from sightline_server import Server  # noqa: E402

SIDE, LEAST = 708, 10  # 2 * SIDE * SIDE triangles
RAY = json.dumps({"rays": [{"origin": [4.3, 50, 3.1], "direction": [0.01, -1, 0.02]}], "fields": ["t", "triangle", "position"]})


def built(server):
    """Scenes whose trees this server has built."""
    return int(re.search(r'sightline_tree_builds_total\{of="scene"\} (\d+)', server.ask("/metrics").body.decode())[1])


def first_answer(folder, origin, *options):
    """(seconds from the question to the answer, body, scenes built)"""
    with tempfile.TemporaryDirectory(dir=folder) as data, \
            Server("--data", data, "--origin", folder / origin, "--log-level", "warn", *options, memory=None) as server:
        connection = http.client.HTTPConnection("127.0.0.1", server.port)
        begin = time.perf_counter()
        connection.request("POST", "/v1/scenes/hills/rays:closest", RAY, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        text = answer.read()
        seconds = time.perf_counter() - begin
        connection.close()
        assert answer.status == 200, text
        return seconds, text, built(server)


def put(folder, origin, body, *options):
    with Server("--data", folder / f"first-{origin}", "--origin", folder / origin, "--log-level", "warn", *options, memory=None) as server:
        answer = server.ask("/v1/scenes/hills?wait=60", "-X", "PUT", "-H", "Content-Type: model/gltf-binary", body=body)
        assert answer.status == 201, answer.body
        end = time.monotonic() + 120
        while origin == "shared" and not list((folder / origin / "trees").glob("**/*")):
            assert time.monotonic() < end, "no trees in the origin"
            time.sleep(0.1)


def forget_trees(origin):
    for file in (origin / "trees").glob("*.trees"):
        file.unlink()


def equal_bytes(folder):
    """SHA-256 of the answers of each of three servers, and how many scenes they have built."""
    source = numpy.random.default_rng(arguments.seed)
    origins = source.uniform([-1, 5, -1], [11, 9, 11], (arguments.rays, 3))
    directions = source.uniform(-1, 1, (arguments.rays, 3)) - [0, 1, 0]
    digests, count = [], 0
    for number in range(3):
        with Server("--data", folder / f"judged{number}", "--origin", folder / "shared", "--log-level", "warn", memory=None) as server, \
                sightline.Sightline(server.url) as client:
            hits = client.closest("hills", origins, directions, fields=["t", "triangle", "position", "normal"])
            digests.append(hashlib.sha256(b"".join(numpy.ascontiguousarray(hits[name]).tobytes() for name in sorted(hits))).hexdigest())
            count += built(server)
    return digests, count


def main():
    with tempfile.TemporaryDirectory() as name:
        folder, body = Path(name), tiles(SIDE, 1)
        put(folder, "shared", body)
        put(folder, "bare", body, "--skip", "none")
        forget_trees(folder / "bare")
        times, bodies, builds = {"built": [], "shared": []}, set(), 0
        for _ in range(arguments.rounds):
            for kind, origin, options in (("built", "bare", ("--skip", "none")), ("shared", "shared", ())):
                seconds, text, count = first_answer(folder, origin, *options)
                forget_trees(folder / "bare")
                times[kind].append(seconds)
                bodies.add(text)
                builds += count if kind == "shared" else 0
        digests, count = equal_bytes(folder)
    for kind, each in times.items():
        print(f"{kind}: first answer after {statistics.median(each) * 1e3:.0f} ms ({min(each) * 1e3:.0f} to {max(each) * 1e3:.0f})")
    ratio = statistics.median(times["built"]) / statistics.median(times["shared"])
    good = ratio >= LEAST and len(bodies) == 1 and len(set(digests)) == 1 and builds + count == 0
    print(f"{2 * SIDE * SIDE} triangles, {len(body)} bytes: {ratio:.1f} times sooner; {builds + count} builds where trees were shared; "
          f"{arguments.rays} rays by three servers: {len(set(digests))} different answers")
    print("1 passed, 0 failed" if good else "0 passed, 1 failed")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
