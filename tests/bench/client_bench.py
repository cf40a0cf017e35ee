"""5,000,000 rays from numpy in one call of proto/python/sightline.py, beside slices by hand over one connection and beside
the same bytes without a client. Rounds take turns; the floors are medians of quotients.

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

RAYS = 5_000_000
FIELDS = ["t", "instance", "triangle"]
SLICES = (32_768, 65_536, 131_072, 524_288)


def main():
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 7
    source = numpy.random.default_rng(7)
    origins = source.uniform(-400, 400, (RAYS, 3)) + [0, 300, 0]
    directions = source.uniform(-1, 1, (RAYS, 3)) - [0, 1, 0]
    with Server("--preload", "town=demo:town", "--skip", "none", "--log-level", "warn", memory=None) as server:
        path, kind = "/v1/scenes/town/rays:closest", {"Content-Type": "application/octet-stream"}
        raw = http.client.HTTPConnection("127.0.0.1", server.port)

        def body(first, size):
            rays = sightline._read_rays(origins[first:first + size], directions[first:first + size], None, None)
            return sightline._pack(rays, {"fields": FIELDS})

        bodies = {size: [body(first, size) for first in range(0, RAYS, size)] for size in SLICES}

        def send(size):
            answers = []
            for each in bodies[size]:
                raw.request("POST", path, each, kind)
                answers.append(raw.getresponse().read())
            return answers

        def slices(size):
            parts = [client.closest("town", origins[i:i + size], directions[i:i + size], fields=FIELDS) for i in range(0, RAYS, size)]
            return {name: numpy.concatenate([part[name] for part in parts]) for name in FIELDS}

        with sightline.Sightline(server.url) as client:
            runs = {"one call": lambda: client.closest("town", origins, directions, fields=FIELDS)}
            runs.update({f"slices of {size}": lambda size=size: slices(size) for size in SLICES})
            runs.update({f"bytes, {size}": lambda size=size: send(size) for size in SLICES})
            times = {name: [] for name in runs}
            for _ in range(rounds + 1):
                for name, run in runs.items():
                    begin = time.perf_counter()
                    answer = run()
                    times[name].append(time.perf_counter() - begin)
            one, parts = runs["one call"](), slices(SLICES[1])
            assert all((one[name] == parts[name]).all() for name in FIELDS)
        raw.close()
    times = {name: some[1:] for name, some in times.items()}  # the first round warms up
    for name, some in times.items():
        print(f"{name:17} {1000 * statistics.median(some):7.1f} ms ({1000 * min(some):.1f} to {1000 * max(some):.1f})")
    for floor, prefix, most in ((1, "slices", 1.05), (2, "bytes", 1.25)):
        best = min((name for name in times if name.startswith(prefix)), key=lambda name: statistics.median(times[name]))
        quotient = statistics.median(one / other for one, other in zip(times["one call"], times[best]))
        print(f"floor {floor}: {RAYS} rays in one call {quotient:.2f} of the best {best} (needs at most {most}) "
              f"{'ok' if quotient <= most else 'short'}")


if __name__ == "__main__":
    main()
