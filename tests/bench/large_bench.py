"""Large scenes over HTTP: how soon they are ready and answer, and whether the answers are right.

  large_bench.py SIGHTLINE mesh [TRIANGLES]      one mesh (default 64 million triangles; 18 bytes each in the file)
  large_bench.py SIGHTLINE instances [COUNT]     EXT_mesh_gpu_instancing of a sphere of 828 triangles (default 250,000)
  large_bench.py SIGHTLINE nodes [COUNT]         nodes, each with a name and a matrix of its own (default 40,000)
  large_bench.py SIGHTLINE placed [TRIANGLES]    eight meshes, each placed four times (default 256 million triangles in all, about 10^9 placed)
  large_bench.py SIGHTLINE budget [TRIANGLES]    one mesh with a --memory-budget of a tenth of what it takes (default 32 million triangles)
  large_bench.py SIGHTLINE small [TRIANGLES]     one mesh with a --memory-budget of 39 bytes for each triangle (default 32 million triangles)

The mesh is a height field: its triangles along a ray are those of the grid cells below it, so numpy finds the first hit without a tree.
Rays within 1e-7 of an edge are not judged. "read" is the time to read the file from the page cache.

"budget" and "small" compare frames of a camera that moves by a degree each, and incoherent rays, with those of a server without a budget,
and sample the memory of the process. Where they may drop the system's cache of files, as root may, they also measure how fast
incoherent rays read the disk, beside dd.

Needs numpy. Prints figures; exit code 1 if an answer is wrong.
"""

import json
import os
import struct
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SOURCE / "tests/integration"), str(SOURCE / "proto/python")]
from sightline import Sightline  # noqa: E402  (found only now)
from sightline_server import Server  # noqa: E402

MIB = 1 << 20


def write_scene(path, document, columns):
    """columns: (array, its glTF type). Writes them one after the other, into the GLB at the path, or beside a glTF into scene.bin."""
    views, accessors, offset = [], [], 0
    component = {np.dtype(np.float32): 5126, np.dtype(np.uint32): 5125}
    for array, kind in columns:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": array.nbytes})
        accessor = {"bufferView": len(views) - 1, "componentType": component[array.dtype], "count": len(array), "type": kind}
        if kind == "VEC3" and not accessors:
            accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        accessors.append(accessor)
        offset += array.nbytes
    document |= {"asset": {"version": "2.0"}, "bufferViews": views, "accessors": accessors, "buffers": [{"byteLength": offset}]}
    if path.suffix == ".gltf":
        document["buffers"][0]["uri"] = "scene.bin"
        path.write_text(json.dumps(document))
        with open(path.with_name("scene.bin"), "wb") as file:
            for array, _ in columns:
                array.tofile(file)
        return
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<III", 0x46546C67, 2, 12 + 8 + len(text) + 8 + offset) + struct.pack("<II", len(text), 0x4E4F534A) + text)
        file.write(struct.pack("<II", offset, 0x004E4942))
        for array, _ in columns:
            array.tofile(file)


def height_field(side):
    """(positions, indices) of side x side cells of one unit, two triangles each, row by row."""
    n = side + 1
    x, z = np.meshgrid(np.arange(n, dtype=np.float32), np.arange(n, dtype=np.float32), indexing="xy")
    y = (np.sin(x * np.float32(0.11)) * np.cos(z * np.float32(0.07)) * 8 + np.sin(x * 1.7 + z * 2.3)).astype(np.float32)
    positions = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    indices = np.empty((side, side, 6), np.uint32)
    corner = (np.arange(side, dtype=np.uint32)[:, None] * np.uint32(n)) + np.arange(side, dtype=np.uint32)[None, :]
    for k, step in enumerate((0, n, 1, 1, n, n + 1)):
        np.add(corner, np.uint32(step), out=indices[:, :, k])
    return positions, indices.reshape(-1)


def first_hit(positions, side, origin, direction):
    """(t, triangle, least distance to an edge in barycentric terms) of one ray, or None."""
    n = side + 1
    steps = int(np.ceil(np.hypot(direction[0], direction[2]) * 3)) + 2
    along = np.linspace(0, 1, steps * 2)[:, None]
    cells = np.floor(origin[[0, 2]] + along * direction[[0, 2]]).astype(np.int64)
    near = np.concatenate([cells + [i, j] for i in (-1, 0, 1) for j in (-1, 0, 1)])
    near = np.unique(near[((near >= 0) & (near < side)).all(axis=1)], axis=0)
    if not len(near):
        return None
    corner = near[:, 1] * n + near[:, 0]
    number = (near[:, 1] * side + near[:, 0]) * 2
    triangles = np.concatenate([np.stack([corner, corner + n, corner + 1], 1), np.stack([corner + 1, corner + n, corner + n + 1], 1)])
    numbers = np.concatenate([number, number + 1])
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    p = np.cross(direction, c - a)
    determinant = ((b - a) * p).sum(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = ((origin - a) * p).sum(1) / determinant
        q = np.cross(origin - a, b - a)
        v = (q @ direction) / determinant
        t = ((c - a) * q).sum(1) / determinant
    edge = np.minimum(np.minimum(u, v), 1 - u - v)
    if (np.abs(edge[(t > -1e-6)]) < 1e-7).any():
        return "near an edge"
    hit = (edge > 0) & (t >= 0)
    if not hit.any():
        return None
    best = np.flatnonzero(hit)[np.argmin(t[hit])]
    return t[best], numbers[best]


def judge(server, scene, positions, side, count=2000, place=(0, 0, 0), margin=0):
    """(rays judged, wrong answers) of random rays in the height field at a place. They begin at least `margin` from its border."""
    random = np.random.default_rng(5)
    origins = np.stack([random.uniform(margin, side - margin, count), random.uniform(-6, 30, count), random.uniform(margin, side - margin, count)], 1)
    directions = np.stack([random.uniform(-60, 60, count), random.uniform(-30, 5, count), random.uniform(-60, 60, count)], 1)
    directions[: count // 4, [0, 2]] = 0
    directions[: count // 4, 1] = -40
    answer = server.closest(scene, origins + np.array(place), directions, tmax=1.0, fields=["t", "triangle"])
    wrong = judged = 0
    for i in range(count):
        truth = first_hit(positions, side, origins[i], directions[i])
        if isinstance(truth, str):
            continue
        judged += 1
        if truth is None or truth[0] > 1:
            wrong += bool(answer["hit"][i])
        else:
            wrong += not (answer["hit"][i] and answer["triangle"][i] == truth[1] and abs(answer["t"][i] - truth[0]) < 1e-9)
    return judged, wrong


def make_mesh(path, triangles):
    side = int(np.sqrt(triangles / 2))
    positions, indices = height_field(side)
    write_scene(path, {"scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "ground"}],
                     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]}, [(positions, "VEC3"), (indices, "SCALAR")])
    return positions, side


def place_of(side, mesh, copy):
    return [float(side * (4 * (mesh % 2) + copy)), 0.0, float(side * (mesh // 2))]


def make_placed(path, triangles):
    """Eight height fields of equal shape but other heights, each at four places side by side. Returns the first of them."""
    side = int(np.sqrt(triangles / 16))
    columns, meshes, nodes = [], [], []
    for k in range(8):
        positions, indices = height_field(side)
        positions[:, 1] += np.float32(k / 8)
        first = len(columns)
        columns += [(positions, "VEC3"), (indices, "SCALAR")]
        meshes.append({"primitives": [{"attributes": {"POSITION": first}, "indices": first + 1}]})
        nodes += [{"mesh": k, "name": f"ground {k} {i}", "translation": place_of(side, k, i)} for i in range(4)]
    write_scene(path, {"scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes}, columns)
    return columns[0][0], side


def sphere(rings=18, segments=24):
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, segments + 1), indexing="ij")
    positions = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3).astype(np.float32)
    corner = np.arange(rings)[:, None] * (segments + 1) + np.arange(segments)[None, :]
    corner = corner.reshape(-1).astype(np.uint32)
    indices = np.stack([corner, corner + segments + 1, corner + 1, corner + 1, corner + segments + 1, corner + segments + 2], 1)
    return positions, indices.reshape(-1).astype(np.uint32)


def places(count):
    random = np.random.default_rng(3)
    side = int(np.ceil(np.sqrt(count)))
    at = np.arange(count)
    translation = np.stack([at % side * 3.0, random.uniform(0, 2, count), at // side * 3.0], 1).astype(np.float32)
    turn = random.normal(size=(count, 4))
    return translation, (turn / np.linalg.norm(turn, axis=1)[:, None]).astype(np.float32), side


def make_instances(path, count):
    positions, indices = sphere()
    translation, rotation, side = places(count)
    write_scene(path, {"scene": 0, "scenes": [{"nodes": [0]}], "extensionsUsed": ["EXT_mesh_gpu_instancing"], "extensionsRequired": ["EXT_mesh_gpu_instancing"],
                     "nodes": [{"mesh": 0, "name": "bolts", "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2, "ROTATION": 3}}}}],
                     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]},
              [(positions, "VEC3"), (indices, "SCALAR"), (translation, "VEC3"), (rotation, "VEC4")])
    return None, side * 3


def make_nodes(path, count):
    positions, indices = sphere()
    translation, rotation, side = places(count)
    nodes = [{"mesh": 0, "name": f"bolt {i}", "translation": translation[i].tolist(), "rotation": rotation[i].tolist()} for i in range(count)]
    write_scene(path, {"scene": 0, "scenes": [{"nodes": list(range(count))}], "nodes": nodes,
                     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]}, [(positions, "VEC3"), (indices, "SCALAR")])
    return None, side * 3


def memory_of(pid):
    return int(next(line for line in open(f"/proc/{pid}/status") if line.startswith("VmHWM")).split()[1]) >> 10


class Watch:
    """The largest memory of a process, in MiB, sampled each 10 ms: all of it, and what of it is no mapped file."""

    def __init__(self, pid):
        self.pid, self.most, self.anonymous = pid, 0, 0
        self.over = threading.Event()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while not self.over.wait(0.01):
            _, resident, shared = map(int, Path(f"/proc/{self.pid}/statm").read_text().split()[:3])
            self.most = max(self.most, resident >> 8)
            self.anonymous = max(self.anonymous, (resident - shared) >> 8)

    def next(self):
        """The largest since the last call."""
        found, self.most, self.anonymous = (self.most, self.anonymous), 0, 0
        return f"at most {found[0]} MiB, {found[1]} of it no mapped file"

    def end(self):
        self.over.set()
        self.thread.join()


def frame(client, side, turn):
    """Seconds for the depth of a million rays of a camera that looks down by 45 degrees and sees a twentieth of the ground."""
    height = side / 10
    look = [side / 2 + height * np.sin(turn), 0, side / 2 + height * np.cos(turn)]
    camera = {"kind": "pinhole", "position": [side / 2, height, side / 2], "look_at": look, "fov_y": 50, "width": 1000, "height": 1000}
    begin = time.perf_counter()
    client.image("large", "depth", camera)
    return time.perf_counter() - begin


def frames(client, side):
    """(seconds of the first frame, of the median of 20 neighbours)"""
    first, *rest = (frame(client, side, np.radians(i)) for i in range(21))
    return first, statistics.median(rest)


def wait_until_idle(pid):
    """Returns when the process has used no processor time for two seconds: better trees are built in the background."""
    def used():
        return sum(map(int, Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]))
    before = -10
    while used() - before > 2:  # hundredths of a second
        before = used()
        time.sleep(2)


def incoherent(client, side, times=5):
    """Seconds for the first hits of 200,000 random rays, the median of some times."""
    chance = np.random.default_rng(3)
    origin = chance.uniform([0, 0, 0], [side, side / 10, side], (200_000, 3))
    direction = chance.normal(size=(200_000, 3))
    seconds = []
    for _ in range(times):
        begin = time.perf_counter()
        client.closest("large", origin, direction, fields=["t"])
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds)


def compare_reads(client, side, file, pid):
    """Prints how fast 200,000 incoherent rays read the disk, and dd the file, three times each; nothing without the right."""
    drop = Path("/proc/sys/vm/drop_caches")
    if not os.access(drop, os.W_OK):
        return
    for _ in range(3):
        os.sync()
        drop.write_text("3")
        begin = time.perf_counter()
        subprocess.run(["dd", f"if={file}", "of=/dev/null", "bs=1M", "status=none"], check=True)
        by_dd = file.stat().st_size / MIB / (time.perf_counter() - begin)
        drop.write_text("3")
        before = bytes_read(pid)
        seconds = incoherent(client, side, 1)
        read = (bytes_read(pid) - before) / MIB
        print(f"cold: incoherent rays {seconds:.2f} s, {read:.0f} MiB, {read / seconds:.0f} MiB/s; dd {by_dd:.0f} MiB/s: {read / seconds / by_dd:.2f} (needs 0.5)")


def bytes_read(pid):
    return int(next(line for line in open(f"/proc/{pid}/io") if line.startswith("read_bytes")).split()[1])


def beyond_budget(file, positions, side, budget_of, most):
    """budget_of(bytes of geometry and trees): the budget. most: times as long as without it."""
    with tempfile.TemporaryDirectory(dir="/var/tmp") as data, \
            Server("--data", data, "--log-level", "warn", "--memory-budget", 20 << 30, memory=None) as server:
        client = Sightline(server.url, timeout=900)
        client.put("large", file)
        frame(client, side, 0)
        while not client.stats("large")["trees"]["complete"]:
            time.sleep(1)
        trees = client.stats("large")["trees"]
        whole = trees["geometry_bytes"] + trees["tree_bytes"]
        wait_until_idle(server.process.pid)
        _, warm = frames(client, side)
        scattered = incoherent(client, side)
    budget = budget_of(whole)
    with tempfile.TemporaryDirectory(dir="/var/tmp") as data, \
            Server("--data", data, "--log-level", "warn", "--memory-budget", budget, memory=None) as server:
        watch = Watch(server.process.pid)
        try:
            client = Sightline(server.url, timeout=900)
            time.sleep(0.1)
            print(f"a scene of {whole // MIB} MiB with a budget of {budget // MIB}; the process without it: {watch.next()}")
            begin = time.perf_counter()
            client.put("large", file)
            print(f"ready after {time.perf_counter() - begin:.1f} s; {watch.next()}")
            first, neighbour = frames(client, side)
            print(f"a million rays of a camera: first {first:.2f} s, neighbours {neighbour:.3f} s, without a budget {warm:.3f} s: "
                  f"{neighbour / warm:.2f} (needs at most {most}); {watch.next()}")
            wait_until_idle(server.process.pid)
            print(f"better trees are built, or have no room; {watch.next()}")
            _, neighbour = frames(client, side)
            print(f"neighbours then {neighbour:.3f} s: {neighbour / warm:.2f} (needs at most {most}); {watch.next()}")
            first_scattered = incoherent(client, side, 1)
            print(f"200,000 incoherent rays for the first time, with the trees that they need: {first_scattered:.2f} s; {watch.next()}")
            now_scattered = incoherent(client, side)
            print(f"200,000 incoherent rays: {now_scattered:.3f} s, without a budget {scattered:.3f} s: "
                  f"{now_scattered / scattered:.2f}; {watch.next()}")
            wrong = 0
            for _ in range(2):
                begin = time.perf_counter()
                judged, now = judge(client, "large", positions, side)
                wrong += now
                print(f"{judged} incoherent rays judged: {now} wrong; {watch.next()}")
            compare_reads(client, side, file, server.process.pid)
            print(f"temporary files {server.metric('sightline_overflow_bytes') // MIB} MiB, "
                  f"unmapped {server.metric('sightline_overflow_evicted_bytes_total') // MIB} MiB in all")
        finally:
            watch.end()
    return 1 if wrong else 0


def judge_placed(client, positions, side):
    """(rays judged, wrong answers) of each mesh at one of its places."""
    judged = wrong = 0
    for mesh in range(8):
        now, more = judge(client, "large", positions + np.array([0, mesh / 8, 0], np.float32), side, 500, place_of(side, mesh, mesh % 4), 70)
        judged += now
        wrong += more
    return judged, wrong


def main():
    kind = sys.argv[2]
    count = int(sys.argv[3]) if len(sys.argv) > 3 else {"mesh": 64_000_000, "instances": 250_000, "nodes": 40_000, "placed": 256_000_000, "budget": 32_000_000, "small": 32_000_000}[kind]
    with tempfile.TemporaryDirectory(dir="/var/tmp") as folder:
        # A GLB has at most 4 GiB.
        file = Path(folder, "scene.gltf" if kind == "placed" else "scene.glb")
        positions, side = {"mesh": make_mesh, "budget": make_mesh, "small": make_mesh, "placed": make_placed, "instances": make_instances, "nodes": make_nodes}[kind](file, count)
        if kind == "budget":
            return beyond_budget(file, positions, side, lambda whole: whole // 10, 3)
        if kind == "small":
            return beyond_budget(file, positions, side, lambda whole: 39 * count, 1.1)
        bulk = file if file.suffix == ".glb" else file.with_name("scene.bin")
        begin = time.perf_counter()
        with open(bulk, "rb") as stream:
            while stream.read(16 * MIB):
                pass
        read = time.perf_counter() - begin
        with Server("--scene-root", folder, "--max-scene-bytes", 64 << 30, "--memory-budget", 20 << 30, "--log-level", "warn", memory=None) as server:
            client = Sightline(server.url, timeout=900)
            begin = time.perf_counter()
            client.load("large", {"path": file.name}, wait=600)
            ready = time.perf_counter() - begin
            begin = time.perf_counter()
            first = client.closest("large", [[side / 2 + 0.3, 100, side / 2 + 0.2]], [[0, -1, 0]], fields=["t"])
            answered = time.perf_counter() - begin
            print(f"{kind} {count}: file {bulk.stat().st_size / MIB:.0f} MiB, read {read:.2f} s, ready {ready:.2f} s, first answer {answered:.3f} s later, "
                  f"hit {bool(first['hit'][0])}, memory {memory_of(server.process.pid)} MiB", flush=True)
            if kind not in ("mesh", "placed"):
                return 0
            begin = time.perf_counter()
            camera = {"kind": "pinhole", "position": [side / 2, 300, -50], "look_at": [side / 2, 0, side / 2], "fov_y": 60, "width": 1000, "height": 1000}
            client.image("large", "depth", camera)
            print(f"a million rays of a camera: {time.perf_counter() - begin:.2f} s", flush=True)
            check = (lambda: judge(client, "large", positions, side)) if kind == "mesh" else (lambda: judge_placed(client, positions, side))
            judged, wrong = check()
            print(f"{judged} rays judged while trees are built: {wrong} wrong; memory {memory_of(server.process.pid)} MiB", flush=True)
            while not client.stats("large")["trees"]["complete"]:
                time.sleep(1)
            judged, later = check()
            print(f"{judged} rays judged with all trees: {later} wrong; memory {memory_of(server.process.pid)} MiB")
            return 1 if wrong or later else 0


if __name__ == "__main__":
    sys.exit(main())
