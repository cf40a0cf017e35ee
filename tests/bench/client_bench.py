"""1,000,000 rays from numpy by proto/python/sightline.py, beside the same request as raw bytes over the same kind of
connection. Rounds take turns; the floor is the median of their quotients.

Usage: client_bench.py SIGHTLINE [ROUNDS]
"""

import http.client
import statistics
import sys
import time
from pathlib import Path

import numpy

SOURCE = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SOURCE / "proto/python"), str(SOURCE / "tests/integration")]
import sightline  # noqa: E402  (found only now)
from sightline_server import Server  # noqa: E402

RAYS = 1_000_000
FIELDS = ["t", "instance", "triangle"]


def main():
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 9
    source = numpy.random.default_rng(7)
    origins = source.uniform(-400, 400, (RAYS, 3)) + [0, 300, 0]
    directions = source.uniform(-1, 1, (RAYS, 3)) - [0, 1, 0]
    with Server("--preload", "town=demo:town", "--skip", "none", "--log-level", "warn") as server:
        body = sightline._pack(sightline._read_rays(origins, directions, None, None), {"fields": FIELDS})
        raw = http.client.HTTPConnection("127.0.0.1", server.port)
        times = {"raw": [], "client": []}
        with sightline.Sightline(server.url) as client:
            for _ in range(rounds + 1):
                begin = time.perf_counter()
                raw.request("POST", "/v1/scenes/town/rays:closest", body, {"Content-Type": "application/octet-stream"})
                answer = raw.getresponse().read()
                middle = time.perf_counter()
                columns = client.closest("town", origins, directions, fields=FIELDS)
                times["raw"].append(middle - begin)
                times["client"].append(time.perf_counter() - middle)
        same = sightline._unpack(answer)
        assert all((columns[name] == same[name]).all() for name in FIELDS)
        raw.close()
    quotients = [client / raw for client, raw in list(zip(times["client"], times["raw"]))[1:]]  # the first round warms up
    for name, some in times.items():
        print(f"{name:7} {1000 * statistics.median(some[1:]):7.1f} ms ({1000 * min(some[1:]):.1f} to {1000 * max(some[1:]):.1f})")
    quotient = statistics.median(quotients)
    print(f"floor 7: {RAYS} rays from numpy {quotient:.2f}, {min(quotients):.2f} to {max(quotients):.2f} of the raw request "
          f"(needs at most 1.5) {'ok' if quotient <= 1.5 else 'short'}")


if __name__ == "__main__":
    main()
