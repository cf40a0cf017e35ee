"""The page and what it asks: first picture in headless Chromium, picks in the server, bytes of geometry, pictures that the
server traces. Floors are those of docs/guides/page.md.

Usage: page_bench.py SIGHTLINE [ROUNDS]     run on an idle machine
"""

import http.client
import json
import math
import random
import statistics
import struct
import sys
import time
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SOURCE / "tests/integration")]
import page_test  # noqa: E402  (found only now)
from made_scene import tiles  # noqa: E402
from sightline_server import DATA, Server  # noqa: E402

ROUNDS = int(sys.argv[2]) if len(sys.argv) > 2 else 5
JSON = {"Content-Type": "application/json"}
FLOATS = {**JSON, "Accept": "image/x-portable-floatmap"}


def floor(what, figure, limit, unit, at_least=False, number=2):
    good = figure >= limit if at_least else figure <= limit
    print(f"floor {number}: {what} {figure:.4g} {unit} (needs {'at least' if at_least else 'at most'} {limit:g}) {'ok' if good else 'short'}", flush=True)


def home(scene):
    """Where the page looks from."""
    low, high = scene["bounds"]["min"], scene["bounds"]["max"]
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    away, direction = 0.62 * math.dist(low, high) / 2 / math.sin(math.pi / 8), [0.62, 0.48, 0.9]
    return [m + away * d / math.hypot(*direction) for m, d in zip(middle, direction)], middle


class Client:
    """One connection, as a browser keeps it."""

    def __init__(self, server, scene):
        self.connection, self.scene = http.client.HTTPConnection("127.0.0.1", server.port), scene

    def post(self, body, headers=JSON):
        begin = time.perf_counter()
        self.connection.request("POST", f"/v1/scenes/{self.scene}/rays:closest", json.dumps(body), headers)
        answer = self.connection.getresponse()
        text = answer.read()
        assert answer.status == 200, text[:300]
        return 1000 * (time.perf_counter() - begin)

    def picks(self, scene, count=1000):
        """Milliseconds for one ray with all fields through a pixel of the page, each."""
        eye, middle = home(scene)
        seeded, fields = random.Random(22), ["t", "position", "normal", "barycentrics", "on_edge", "node", "mesh", "material"]
        size = math.dist(scene["bounds"]["min"], scene["bounds"]["max"]) / 5
        return [self.post({"rays": [{"origin": eye, "direction": [m - e + seeded.uniform(-size, size) for e, m in zip(eye, middle)]}], "fields": fields})
                for _ in range(count)]


def p99(times):
    return sorted(times)[math.ceil(0.99 * len(times)) - 1]


def sent(server, name):
    """Bytes of the geometry as a browser takes it, as a multiple of unique positions and indices."""
    def get(path, coding):
        return server.ask(f"/v1/scenes/{name}/geometry{path}", "-H", f"Accept-Encoding: {coding}").body
    whole = page_columns(get("?max_bytes=1073741824", "identity"))
    return {coding: len(get("?max_bytes=1073741824", coding)) / (whole["positions"] + whole["indices"]) for coding in ("zstd", "gzip")}


def page_columns(body):
    """Name -> bytes of the column."""
    count, = struct.unpack_from("<I", body, 4)
    columns = {}
    for i in range(count):
        name, kind, width, _, rows = struct.unpack_from("<16sIIQQ", body, 16 + 40 * i)
        columns[name.rstrip(b"\0").decode()] = rows * width * {1: 8, 2: 4, 3: 1, 4: 8, 5: 8, 6: 4}[kind]
    return columns


def browse(server, name):
    """In headless Chromium, medians of the rounds: the first picture, which the server traces; when GL has finished all triangles;
    frames of the view."""
    if page_test.MISSING:
        return print(f"SKIPPED first picture of {name}: {page_test.MISSING}")
    runs = [page_test.browse(server.url, "frames", f"{server.url}/#scene={name}")[0] for _ in range(ROUNDS)]
    median = {key: statistics.median(run[key] for run in runs) for key in ("paint", "first", "drawn", "frames")}
    spread = lambda key: f"{median[key]:g} ms ({min(run[key] for run in runs)} to {max(run[key] for run in runs)})"
    print(f"{name}: first paint {spread('paint')}, first picture, traced, {spread('first')}, all triangles drawn {spread('drawn')}, "
          f"{median['frames']:.2g} frames/s with software GL at 1280x720")
    floor(f"{name}, first picture", median["first"], 2000, "ms")
    floor(f"{name}, whole picture of triangles", median["drawn"], 2000, "ms")
    floor(f"{name}, first paint", median["paint"], 1000, "ms", number=6)


def traced(server, name, scene):
    """Pictures of 640 by 360 normals, the way the page asks for them: one after the other."""
    client, (eye, middle) = Client(server, name), home(scene)
    cameras = {"from home": (eye, middle), "between houses": ([60, 45, 80], [0, 30, 0])}
    slowest = math.inf
    for place, (position, look_at) in cameras.items():
        body = {"image": "normal", "generator": {"kind": "pinhole", "position": position, "look_at": look_at, "fov_y": 45, "width": 640, "height": 360}}
        times = [client.post(body, FLOATS) for _ in range(10 * ROUNDS)][ROUNDS:]
        rate = 1000 / statistics.median(times)
        print(f"{name}, traced {place}: {rate:.1f} pictures/s ({1000 / max(times):.1f} to {1000 / min(times):.1f})")
        slowest = min(slowest, rate)
    floor(f"{name}, traced pictures of 640x360", slowest, 30, "/s", at_least=True)


def main():
    with Server("--preload", "town=demo:town", "--skip", "none", "--log-level", "warn", memory=None) as server:
        parts = {*page_test.PARTS, "/docs/documents.json.gz"}
        floor("pages and documents in the binary", sum(len(server.ask(path).body) for path in parts) / 1e6, 1.2, "MB", number=6)
        town = server.ask("/v1/scenes/town").json()
        traced(server, "town", town)
        browse(server, "town")
    for name in ("furnished_house", "city_nodes", "city_gpu_instancing"):
        file = DATA / "scenes" / f"{name}.glb"
        if not file.is_file():
            print(f"SKIPPED {name}: {file} is not there")
            continue
        with Server("--log-level", "warn", memory=None) as server:
            scene = server.put(name, file.read_bytes()).json()
            for coding, ratio in sent(server, name).items():
                floor(f"{name}, bytes sent with {coding}", ratio, 1.2, "of unique positions and indices")
            picks = Client(server, name).picks(scene)
            floor(f"{name}, picks p99", p99(picks), 20, "ms")
            browse(server, name)
    with Server("--log-level", "warn", memory=None) as server:
        scene = server.put("tiles", tiles(224, 1000)).json()
        client = Client(server, "tiles")
        client.picks(scene, 100)  # builds the tree
        floor(f"{scene['counts']['triangles']:,} placed triangles, picks p99", p99(client.picks(scene)), 50, "ms")


if __name__ == "__main__":
    main()
