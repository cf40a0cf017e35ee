"""A client of Sightline: one file, standard library only. It uses numpy if numpy is installed.

    from sightline import Sightline

    with Sightline("http://127.0.0.1:8080") as server:
        server.put("house", "house.glb")
        hits = server.closest("house", [[0, 1.7, 10]], [[0, 0, -1]], fields=["t", "node_id"])

Arguments. Points and directions have shape (n, 3), or (h, w, 3) for an image. tmin and tmax have shape () or (n,) or
(h, w). Shapes are compared, never changed: (3, n), (n, 2) and (3,) are a ValueError. A sequence contains int and float; an
array contains integers or floats of at most 64 bits, in any byte order and memory layout. An empty list has no points.
Each number is rounded to the nearest float64. Points and directions are finite, tmin and tmax are not NaN; a ValueError
names the argument and the row. With on_invalid="mark" all numbers pass and the server marks bad rays. An answer with texts
is asked for as JSON, which has no NaN and no infinity except tmax = inf: other such numbers are then a ValueError.

Answers. Columns are numpy arrays, without numpy nested lists of the same shape. Rows have the shape of the rays: (n,) or
(h, w), and (h, w) for a generator with width and height; a position adds an axis of 3. Texts (node, node_path, mesh,
material) are nested lists of str or None. Types do not depend on `fields`: numbers are float64, ids int64, flags bool, counts
uint64. The bool column `hit` is always next to hits. In a miss t and distance are inf, other numbers NaN, ids -1, flags
False, texts None. In a hit NaN, -1 and None are what the file does not state; t = inf is a t beyond the largest float64.

Errors. ValueError: an argument is wrong, and nothing was sent. SightlineError: the server refused the request.

Requests. Rays, points and hits travel as bytes (docs/reference/binary.md), answers with texts as JSON. A call with many rows
is sent in slices of 65,536 rows. Connections are reused, and threads may share an object. A request that may be repeated is
repeated after a lost connection and after 429, 502 and 503, by another server if there are several.
"""

from __future__ import annotations

import atexit
import collections
import concurrent.futures
import email.utils
import hashlib
import http.client
import importlib
import itertools
import json
import math
import numbers
import os
import random
import re
import selectors
import shutil
import ssl
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping as AnyMapping, Set as AnySet
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Mapping, NamedTuple, Sequence, Union
from urllib.parse import quote, urlencode, urlsplit

numpy: Any
try:
    numpy = importlib.import_module("numpy")
except ImportError:
    numpy = None

__all__ = ["Sightline", "SightlineError"]

Points = Any  # A numpy array or nested sequences of numbers, of shape (n, 3) or (h, w, 3).
Limit = Any  # A number, or numbers of shape (n,) or (h, w).
Array = Any  # A numpy array, without numpy nested lists.
Columns = dict  # dict[str, Array]
Progress = Union[bool, Callable[[int, int], object], None]  # True draws a bar; a function gets the rows that are done, and all.
TEXTS = {"node", "node_path", "mesh", "material"}
_BYTES, _JSON = "application/octet-stream", "application/json"
# Rows of a request. Smaller slices cost more requests, larger ones leave the caches of the processor.
_SLICE = 65_536
# Slices that are under way at once: one is traced while the other is packed or unpacked.
_AT_ONCE = 2
# By the numbers of docs/reference/binary.md: struct letter, numpy type.
_TYPES = {1: ("d", "<f8"), 2: ("I", "<u4"), 3: ("B", "u1"), 4: ("Q", "<u8"), 5: ("q", "<i8"), 6: ("f", "<f4")}
_NONE = 0xFFFFFFFF
_WIDTHS = {"position": 3, "normal": 3, "shading_normal": 3, "barycentrics": 2, "uv": 2, "uv1": 2, "tangent": 4, "colour": 4}
_DISTANCES = {"t", "distance"}
_FLAGS = {"front", "on_edge"} | {"hits", "reliable", "visible"}
_COUNTS = {"totals", "first", "counts"}
_REMARKS = {"work", "unreliable", "warnings", "explain", "nearest_miss"}  # Beside the columns: values of JSON.
_NO_SEQUENCES = (str, bytes, bytearray, AnyMapping, AnySet)
# By the numbers of docs/reference/binary.md.
_FAULTS = ("", "RAY_NOT_FINITE", "RAY_DIRECTION_ZERO", "RAY_LIMIT_NAN", "RAY_LIMITS_REVERSED")
_BUSY = {429, 502, 503}
_LOST = (OSError, http.client.BadStatusLine, http.client.IncompleteRead)  # No answer, or a part of one.
# Seconds: for the connection to a server, and how long other servers come before one that gave no answer.
_CONNECT, _AVOID = 5.0, 5.0


class SightlineError(Exception):
    """What the server refused. `errors` has a JSON pointer for each place that is wrong. `repeated`: the request was sent
    before without a clear answer, and may have been carried out then; a 412 can be the effect of that."""

    def __init__(self, status: int, problem: Mapping[str, Any], repeated: bool = False):
        self.status, self.repeated = status, repeated
        self.code: str = problem.get("code", "")
        self.detail: str = problem.get("detail", "")
        self.errors: list[dict[str, Any]] = problem.get("errors", [])
        self.request_id: str = problem.get("request_id", "")
        place = f" at {self.errors[0]['pointer']}" if self.errors else ""
        super().__init__(f"{status} {self.code}: {self.detail}{place}")

    def __reduce__(self) -> tuple:
        told = {name: getattr(self, name) for name in ("code", "detail", "errors", "request_id")}
        return SightlineError, (self.status, told, self.repeated)


class Sightline:
    """A server, or several servers that share their scenes by an origin (docs/guides/replicas.md).

    `url` may be a list. Each scene then has an order of the servers, by a hash of its id and of each address (rendezvous
    hashing). Its requests go to the first server, and to the next where one does not answer. The order does not depend on that
    of the list, and a further server moves only the scenes that it gets. The client requires of each answer the newest
    revision that it has seen of the scene; shared=True does so for one address too, that of a balancer. With shared=False
    the servers share no scenes: each scene lives on its first server alone. With spread=True the requests of a scene go to all
    servers in turn, for a scene that needs more than one.

    `key` is sent as a bearer token. `timeout` is in seconds, for each wait for the network. `patience` is in seconds: no try of
    a request begins later after its first, but each server is tried once."""

    def __init__(self, url: str | Sequence[str], key: str | None = None, timeout: float = 120, patience: float = 30,
                 shared: bool | None = None, spread: bool = False):
        urls = [url] if isinstance(url, str) else list(url)
        if not urls:
            raise ValueError("there is no address")
        self._pools = [_Pool(each, timeout) for each in urls]
        self._headers = {"Authorization": f"Bearer {key}"} if key else {}
        self._patience = patience
        self._shared = len(urls) > 1 if shared is None else shared
        self._turns = itertools.count() if spread else itertools.repeat(0)
        self._revisions: dict[str, int] = {}  # The newest that was seen of each scene.
        self._jobs: dict[str, _Pool] = {}  # The server of each job.
        self._lock = threading.Lock()
        self._process: _Process | None = None

    @classmethod
    def local(cls, *sources: str | Path, binary: str | Path | None = None, arguments: Sequence[str] = (), timeout: float = 120) -> Sightline:
        """Starts a server for these files, and stops it with close() or at the end of `with`.

        A scene has the name of its file without the ending, with "-" for characters that names of scenes do not have; "demo:town"
        is the demo scene "town", "id=file" names it. `binary` is the program, by default $SIGHTLINE_BINARY or `sightline` of the
        PATH; `arguments` are further flags of `sightline serve`."""
        scenes = [_named_source(str(each)) for each in sources]
        process = _Process(str(binary or os.environ.get("SIGHTLINE_BINARY") or "sightline"), scenes, arguments)
        try:
            server = cls(process.url, timeout=timeout)
            server._process = process
            for name, _ in scenes:
                state = server.scene(name, wait=30)
                while state["state"] in ("queued", "loading"):
                    state = server.scene(name, wait=30)
                if state["state"] != "ready":
                    reason = state.get("reason", {})
                    raise RuntimeError(f"scene {name} is {state['state']}: {reason.get('code', '')}: {reason.get('detail', '')}")
        except BaseException:
            process.stop()
            raise
        return server

    def __enter__(self) -> Sightline:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        for pool in self._pools:
            pool.close()
        if self._process:
            self._process.stop()

    # The server.

    def version(self) -> dict:
        """Version, kernels and limits."""
        return json.loads(self._ask("GET", "/version"))

    def health(self) -> bool:
        """True if the server answers."""
        return self._good("/healthz")

    def ready(self) -> bool:
        """True if the scenes that it was started with are loaded."""
        return self._good("/readyz")

    def metrics(self) -> str:
        """Counters and times in the format of Prometheus."""
        return self._ask("GET", "/metrics").decode()

    def openapi(self) -> dict:
        """The description of every route."""
        return json.loads(self._ask("GET", "/openapi.json"))

    # Scenes. `if_match` and `if_none_match` are conditions on the ETag (docs/guides/scenes.md).

    def put(self, scene: str, source: Any, wait: float | None = None, file_scene: int | None = None, if_match: str | None = None,
            if_none_match: str | None = None) -> dict:
        """Loads a .glb or .gltf, as bytes or from a file; returns when it is ready (or after `wait` seconds).

        `source` may be a mesh of trimesh or Open3D, or a scene of trimesh. `file_scene` chooses a scene of the file."""
        body = _scene_bytes(source)
        path = self._scene(scene, wait=wait, scene=file_scene)
        return self._state(scene, self._ask("PUT", path, body, _BYTES, conditions=_conditions(if_match, if_none_match)))

    def put_mesh(self, scene: str, vertices: Points, faces: Any, name: str = "mesh", wait: float | None = None) -> dict:
        """Loads triangles: vertices of shape (n, 3), faces of shape (m, 3) with numbers of vertices.

        A file has float32 positions. If a vertex is no float32, all are stored relative to the middle of their box."""
        return self.put(scene, _mesh_glb(vertices, faces, name), wait)

    def load(self, scene: str, source: Mapping[str, str], wait: float | None = None) -> dict:
        """Makes the server load {"path": ...} below its --scene-root, or {"url": ..., "sha256": ...}."""
        path = "/v1/scenes" + ("" if wait is None else f"?wait={wait}")
        body = _text({"id": scene, "source": dict(source)})
        return self._state(scene, self._ask("POST", path, body, _JSON, once=True, home=scene))

    def delete(self, scene: str, if_match: str | None = None, if_none_match: str | None = None) -> None:
        self._ask("DELETE", self._scene(scene), conditions=_conditions(if_match, if_none_match))

    def scenes(self) -> list[dict]:
        """The scenes of all servers."""
        pools: list = [None] if self._shared else self._pools
        return [scene for pool in pools for scene in json.loads(self._ask("GET", "/v1/scenes", pool=pool))["scenes"]]

    def scene(self, scene: str, wait: float | None = None) -> dict:
        """State, counts, bounds and warnings; with `wait` after the end of a load, or after so many seconds."""
        return self._state(scene, self._ask("GET", self._scene(scene, wait=wait)))

    def events(self, scene: str) -> Iterator[dict]:
        """State and progress of a load, as they change."""
        pool, connection = self._opened(scene)
        try:
            connection.request("GET", pool.prefix + self._scene(scene, "/events"), headers=self._headers)
            answer = connection.getresponse()
            if answer.status >= 400:
                raise _problem(answer.status, answer.read())
            for line in answer:
                if line.startswith(b"data:"):
                    yield json.loads(line[5:])
        finally:
            connection.close()

    def stats(self, scene: str) -> dict:
        return json.loads(self._ask("GET", self._scene(scene, "/stats")))

    def nodes(self, scene: str, name: str | None = None, path: str | None = None, material: str | None = None,
              instance: int | None = None, extra: Sequence[str] = ()) -> list[dict]:
        """The whole hierarchy, page by page, or the nodes that satisfy the patterns and have the instance. `extra` adds "path",
        "materials", "extras" and "pose" (its matrix and weights now) to each node."""
        search = {"name": name, "path": path, "material": material, "instance": instance, "with": ",".join(extra) or None}
        nodes: list[dict] = []
        first: int | None = 0
        while first is not None:
            page = json.loads(self._ask("GET", self._scene(scene, "/nodes", first=first, limit=10_000, **search)))
            nodes += page["nodes"]
            first = page.get("next")
        return nodes

    def patch_node(self, scene: str, node: int, if_match: str | None = None, if_none_match: str | None = None, **changes: Any) -> dict:
        """Moves, poses, hides or masks a node by its id: translation, rotation, scale, matrix, weights, hidden, mask."""
        return json.loads(self._ask("PATCH", self._scene(scene, f"/nodes/{node}"), _text(changes), _JSON,
                                    conditions=_conditions(if_match, if_none_match)))

    def add_node(self, scene: str, node: int, copy_of: int, parent: int | None = None, name: str = "",
                 if_match: str | None = None, if_none_match: str | None = None, **changes: Any) -> dict:
        """Adds a node with an id that the scene never had. It shows the mesh of the node `copy_of`; `changes` are those of patch_node()."""
        return self.patch_node(scene, node, if_match, if_none_match, copy_of=copy_of, parent=parent, name=name, **changes)

    def set_positions(self, scene: str, node: int, positions: Points, if_match: str | None = None, if_none_match: str | None = None) -> dict:
        """Replaces the vertices of a node's mesh, shape (n, 3) in the node's space, for this node alone. n is the node's `vertices`,
        which nodes(extra=["pose"]) has."""
        return self.patch_node(scene, node, if_match, if_none_match, positions=_rows("positions", positions))

    def remove_node(self, scene: str, node: int, if_match: str | None = None, if_none_match: str | None = None) -> dict:
        """Removes a node and all nodes below it, for good."""
        answer = self._ask("DELETE", self._scene(scene, f"/nodes/{node}"), conditions=_conditions(if_match, if_none_match))
        return json.loads(answer) if answer else self.scene(scene)  # Without one, a repeated request found the work done.

    def patch_nodes(self, scene: str, changes: Mapping[int, Mapping[str, Any]], if_match: str | None = None,
                    if_none_match: str | None = None) -> dict:
        """Changes several nodes at once, by their ids, as patch_node() changes one: one new revision, all or none. A change with
        `copy_of` adds its node, and `{"removed": True}` removes it."""
        body = {"nodes": [{"node": node, **change} for node, change in changes.items()]}
        return json.loads(self._ask("PATCH", self._scene(scene, "/nodes"), _text(body), _JSON,
                                    conditions=_conditions(if_match, if_none_match)))

    def animations(self, scene: str) -> list[dict]:
        """The animations of the file: index, name, duration in seconds, and the nodes that they target."""
        return json.loads(self._ask("GET", self._scene(scene, "/animations")))["animations"]

    def pose(self, scene: str, animation: str | int, time: float, changes: Mapping[int, Mapping[str, Any]] | None = None,
             if_match: str | None = None, if_none_match: str | None = None) -> dict:
        """Gives the nodes of an animation, by its name or index, the pose of a time in seconds; then changes nodes as patch_nodes()."""
        key = "index" if isinstance(animation, int) else "name"
        body: dict[str, Any] = {"animation": {key: animation, "time": time}}
        if changes:
            body["nodes"] = [{"node": node, **change} for node, change in changes.items()]
        return json.loads(self._ask("PATCH", self._scene(scene, "/nodes"), _text(body), _JSON,
                                    conditions=_conditions(if_match, if_none_match)))

    def triangles(self, scene: str, ids: Sequence[Sequence[int]]) -> list[dict]:
        """Exact corners of triangles given as (instance, primitive, triangle): integers of shape (n, 3)."""
        text = ",".join(".".join(map(str, each)) for each in _id_triples(ids))
        return json.loads(self._ask("GET", self._scene(scene, "/triangles", ids=text)))["triangles"]

    def geometry(self, scene: str, first: int = 0, max_bytes: int | None = None) -> Columns:
        """Triangles to draw, as the columns of docs/reference/binary.md; `next`, if it has a row, is the next `first`."""
        return _unpack(self._ask("GET", self._scene(scene, "/geometry", first=first, max_bytes=max_bytes)), by_rows=True)

    def bvh(self, scene: str, level: int | None = None) -> dict:
        """The trees that are built; with `level` some boxes of that level."""
        return json.loads(self._ask("GET", self._scene(scene, "/bvh", level=level)))

    def selfcheck(self, scene: str, rays: int | None = None, seed: int | None = None) -> dict:
        """Answers random rays again by exact brute force; `different` has the rays that differ."""
        return json.loads(self._ask("GET", self._scene(scene, "/selfcheck", rays=rays, seed=seed)))

    # Rays: `origins` and `directions`, or a `generator` (its limits are its own `range`); `options` are the keys of a JSON
    # request, such as cull, include, exclude, filters, normalize, masks, on_invalid, fields (a list or tuple). `progress` is True for
    # a bar (tqdm if it is installed), or a function of the rows that are done and of all.

    def closest(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin: Limit = None,
                tmax: Limit = None, progress: Progress = None, **options: Any) -> Columns:
        """Columns of the first hit of each ray; by default t, instance, primitive, triangle. `hit` is always there."""
        return self._rays(scene, "closest", origins, directions, tmin, tmax, progress, options)

    def any(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin: Limit = None,
            tmax: Limit = None, progress: Progress = None, **options: Any) -> Array:
        """Whether each ray meets anything: bool. A bad ray of on_invalid="mark" is False."""
        return self._rays(scene, "any", origins, directions, tmin, tmax, progress, options)["hits"]

    def count(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin: Limit = None,
              tmax: Limit = None, progress: Progress = None, **options: Any) -> Array:
        """How many triangles each ray meets. A bad ray of on_invalid="mark" meets 0."""
        return self._rays(scene, "count", origins, directions, tmin, tmax, progress, options)["counts"]

    def all(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin: Limit = None,
            tmax: Limit = None, progress: Progress = None, **options: Any) -> Columns:
        """Columns of every hit; those of ray i are first[i] to first[i + 1], of totals[i]. Pixels of an image are rays row
        by row: `totals` has the shape of the rays, `first` and the hits do not."""
        return self._rays(scene, "all", origins, directions, tmin, tmax, progress, options)

    def stream(self, scene: str, batches: Iterable[Any], kind: str = "closest", **options: Any) -> Iterator[Any]:
        """Answers batches of rays one after the other, in order; `kind` is closest, any, count or all.

        A batch is (origins, directions), or a dict of the arguments of that method. The iterator `batches` is never more than
        two batches beyond the answers, so memory does not grow with the stream."""
        if kind not in ("closest", "any", "count", "all"):
            raise ValueError(f"kind is {kind!r}: expected closest, any, count or all")
        method = getattr(self, kind)

        def call(batch: Any) -> Callable[[], Any]:
            if isinstance(batch, AnyMapping):
                return lambda: method(scene, **{**options, **batch})
            try:
                origins, directions, *limits = batch
            except (TypeError, ValueError):
                raise TypeError(f"a batch is {batch!r:.60}: expected (origins, directions), or a dict of arguments") from None
            return lambda: method(scene, origins, directions, *limits, **options)
        return _ahead(map(call, batches))

    def image(self, scene: str, image: str, generator: Mapping[str, Any], png: bool = False, **options: Any) -> Any:
        """A picture of docs/guides/images.md as an array, or with `png` as the bytes of a PNG file.

        depth (inf is a miss) is float32, node and visits are int64, all of shape (h, w); normal, node_colours and shaded are float32
        of shape (h, w, 3)."""
        body = _text({**options, "image": image, "generator": generator})
        answer = self._ask("POST", self._scene(scene, "/rays:closest"), body, _JSON, "image/png" if png else "image/x-portable-floatmap")
        return answer if png else _from_pfm(answer, whole=image in ("node", "visits"))

    def table(self, scene: str, generator: Mapping[str, Any], kind: str = "ply", **options: Any) -> bytes:
        """The hits of a generator's rays as the bytes of a file: csv, ply, pcd, npy or npz (docs/reference/tables.md)."""
        if kind not in ("csv", "ply", "pcd", "npy", "npz"):
            raise ValueError(f"kind is {kind!r}: expected csv, ply, pcd, npy or npz")
        accept = "text/csv" if kind == "csv" else "application/x-" + kind
        return self._ask("POST", self._scene(scene, "/rays:closest"), _text({**options, "generator": generator}), _JSON, accept)

    def generate(self, generator: Mapping[str, Any]) -> Columns:
        """The rays of a generator: columns origins, directions, tmin and tmax, in the shape that answers have."""
        return _unpack_rays(self._ask("POST", "/v1/rays:generate", _text({"generator": generator}), _JSON, _BYTES), _pixels(generator))

    def rays_boxes(self, origins: Points, directions: Points, boxes: Sequence[Mapping[str, Any]], tmin: Limit = None, tmax: Limit = None,
                   **options: Any) -> list:
        """Rays against boxes of the request, as docs/guides/picking.md shows; `pairing` is each or all."""
        rays = _read_rays(origins, directions, tmin, tmax, texts=True)
        body = _Request(b"", rays.tables(), {**options, "boxes": list(boxes)}, as_text=True).body(0, rays.total())
        return json.loads(self._ask("POST", "/v1/rays-boxes", body, _JSON))["results"]

    # Points: `options` are the keys of a JSON request, such as max_distance, method, include, fields (without texts).

    def visibility(self, scene: str, points_from: Points, points_to: Points, **options: Any) -> dict:
        """Both of shape (n, 3). `visible` is bool: a row for each from, a column for each to. With pairing="each" the n are
        equal, and `visible` has a number for each pair. With first_blocker=True there are `blockers`, as JSON."""
        start, end = _rows("points_from", points_from), _rows("points_to", points_to)
        each = options.get("pairing") == "each"
        if each and len(start) != len(end):
            raise ValueError(f"points_from has shape {(len(start), 3)}, points_to has shape {(len(end), 3)}: expected equal shapes")
        body, shape = {"from": start, "to": end, **options}, (len(start),) if each else (len(start), len(end))
        if not options.get("first_blocker"):
            columns, _ = self._columns(self._scene(scene, "/visibility"), _text(body), _JSON, _BYTES)
            return {**columns, "visible": _shaped(columns["visible"], shape)}
        answer = self.ask(scene, "visibility", body)
        text = (answer["visible"] if each else "".join(answer["visible"])).encode()
        answer["visible"] = _shaped([letter == 49 for letter in text] if numpy is None else numpy.frombuffer(text, "u1") == 49, shape)
        return answer

    def inside(self, scene: str, points: Points, progress: Progress = None, **options: Any) -> Columns:
        """Bool columns `inside`, `on_surface` (then `inside` is False) and `reliable`; with method="winding" or "solid_angle" `winding`."""
        columns = self._near(scene, "inside", points, progress, options)
        told = columns["inside"]
        if numpy is not None:
            return {**columns, "inside": told == 1, "on_surface": told == 255}
        return {**columns, "inside": _mapped(told, lambda x: x == 1), "on_surface": _mapped(told, lambda x: x == 255)}

    def closest_points(self, scene: str, points: Points, progress: Progress = None, **options: Any) -> Columns:
        """Columns of the nearest point of the scene; by default distance, instance, primitive, triangle."""
        return self._near(scene, "closest", points, progress, options)

    def nearest(self, scene: str, points: Points, count: int, progress: Progress = None, **options: Any) -> Columns:
        """Columns of the nearest triangles; those of point i are first[i] to first[i + 1]."""
        return self._near(scene, "nearest", points, progress, {**options, "count": count})

    def distance(self, scene: str, points: Points, progress: Progress = None, **options: Any) -> Columns:
        """Signed distances, negative inside, inf beyond `max_distance`; the bool column `reliable` says where it is certain."""
        return self._near(scene, "distance", points, progress, options)

    def sky(self, scene: str, points: Points, normals: Points | None = None, count: int = 256, **options: Any) -> Columns:
        """`counts`: how many of `count` directions around each normal (default +Y) meet nothing; `ratios`: counts / count. One
        request: the directions of a point depend on its number."""
        tables = [(_allow(_points("points", points)), 3)]
        if normals is not None:
            tables.append((_allow(_points("normals", normals)), 3))
            if tables[0][0].shape != tables[1][0].shape:
                raise ValueError(f"normals has shape {tables[1][0].shape}, points has shape {tables[0][0].shape}: expected equal shapes")
        body = _frame(b"SLP1", 2 * (len(tables) - 1), tables, {**options, "count": count})
        columns, _ = self._columns(self._scene(scene, "/points:sky"), body, _BYTES)
        counts = columns["counts"]
        columns["ratios"] = [each / count for each in counts] if isinstance(counts, list) else counts / count
        return _finish(columns, (), tables[0][0].shape[:-1], lists=False)

    # Shapes: spheres of `radius`, or boxes of `half` (x, y and z), one number or row for all or one for each. With `to` the
    # spheres are capsules from `origins` to there; with `axes`, three rows for all or for each, the boxes are turned.

    def sweeps_closest(self, scene: str, origins: Points, directions: Points, radius: Any = None, half: Any = None, tmin: Limit = None,
                       tmax: Limit = None, progress: Progress = None, to: Any = None, axes: Any = None, **options: Any) -> Columns:
        """Columns of what moving shapes meet first; by default t, instance, primitive, triangle."""
        shape = {"radius": radius, "half": half, "to": to, "axes": axes}
        return self._sweeps(scene, "closest", origins, directions, shape, tmin, tmax, progress, options)

    def sweeps_any(self, scene: str, origins: Points, directions: Points, radius: Any = None, half: Any = None, tmin: Limit = None,
                   tmax: Limit = None, progress: Progress = None, to: Any = None, axes: Any = None, **options: Any) -> Array:
        """Whether moving shapes meet anything: bool."""
        shape = {"radius": radius, "half": half, "to": to, "axes": axes}
        return self._sweeps(scene, "any", origins, directions, shape, tmin, tmax, progress, options)["hits"]

    # `boxes` are the shapes of docs/guides/picking.md; their parts may be arrays.

    def boxes_any(self, scene: str, boxes: Sequence[Mapping[str, Any]], **options: Any) -> Array:
        """Whether each shape touches (or contains, `mode`) anything: bool."""
        return _column(self.ask(scene, "boxes:any", {"boxes": list(boxes), **options})["hits"], "bool")

    def boxes_count(self, scene: str, boxes: Sequence[Mapping[str, Any]], **options: Any) -> Array:
        """How many triangles or nodes (`of`) each shape touches or contains."""
        return _column(self.ask(scene, "boxes:count", {"boxes": list(boxes), **options})["counts"], "uint64")

    def boxes_list(self, scene: str, boxes: Sequence[Mapping[str, Any]], **options: Any) -> list[dict]:
        """The triangles or nodes (`of`) of each shape, with their `total`; `next` is a cursor if `limit` cut the list."""
        return self.ask(scene, "boxes:list", {"boxes": list(boxes), **options})["results"]

    def clearance(self, /, scene: str, a: Mapping[str, Any], b: Mapping[str, Any], **options: Any) -> dict:
        """The closest pair of two selections of nodes, or the list of pairs within `max_distance` (`pairs`)."""
        return self.ask(scene, "clearance", {"a": a, "b": b, **options})

    def ask(self, scene: str, what: str, body: Mapping[str, Any]) -> dict:
        """Any question about a scene, as the JSON of docs/reference/api.md."""
        return json.loads(self._ask("POST", self._scene(scene, "/" + what), _text(body), _JSON))

    # Questions that are answered in the background (docs/guides/jobs.md). The server that was asked has the job: this object
    # knows it, another one asks the first server of the scene.

    def ask_later(self, scene: str, what: str, body: Mapping[str, Any]) -> str:
        """Makes a job of a question of ask(); returns its id."""
        _, answer, pool = self._exchange("POST", self._scene(scene, "/" + what), _text(body), _JSON, once=True,
                                         conditions={"Prefer": "respond-async"})
        job = json.loads(answer)["id"]
        self._jobs[job] = pool
        return job

    def job(self, scene: str, job: str) -> dict:
        """State and progress of a job."""
        return json.loads(self._ask("GET", f"/v1/jobs/{quote(job, safe='')}", home=scene, pool=self._jobs.get(job)))

    def job_result(self, scene: str, job: str) -> dict:
        """The answer of a job whose state is done, as that of ask()."""
        return json.loads(self._ask("GET", f"/v1/jobs/{quote(job, safe='')}/result", home=scene, pool=self._jobs.get(job)))

    def delete_job(self, scene: str, job: str) -> None:
        """Cancels a job and forgets it."""
        self._ask("DELETE", f"/v1/jobs/{quote(job, safe='')}", home=scene, pool=self._jobs.get(job))
        self._jobs.pop(job, None)

    # Below here nothing is for callers.

    def _good(self, path: str) -> bool:
        return all(self._send(pool, pool.take(), "GET", path, None, self._headers)[0] == 200 for pool in self._pools)

    def _scene(self, name: str, rest: str = "", /, **parameters: Any) -> str:
        known = {key: value for key, value in parameters.items() if value is not None}
        return f"/v1/scenes/{quote(name, safe='')}{rest}" + ("?" + urlencode(known, safe=",") if known else "")

    def _state(self, scene: str, answer: bytes) -> dict:
        state = json.loads(answer)
        self._saw(quote(scene, safe=""), state.get("revision"))
        return state

    def _saw(self, name: str, revision: Any) -> None:
        if self._shared and name and revision is not None:
            with self._lock:
                self._revisions[name] = max(int(revision), self._revisions.get(name, 0))

    def _servers(self, name: str) -> list[_Pool]:
        """The servers of a scene in the order in which they are asked, by rendezvous hashing."""
        order = sorted(self._pools, key=lambda pool: hashlib.sha256(f"{pool.url}\n{name}".encode()).digest(), reverse=True)
        late, turn = time.monotonic() - _AVOID, next(self._turns) % len(order)
        order = order[turn:] + order[:turn]
        return sorted(order, key=lambda pool: pool.lost > late) if self._shared else order[:1]

    def _opened(self, scene: str) -> tuple[_Pool, http.client.HTTPConnection]:
        """A new connection to the first server of a scene that can be reached."""
        fault: OSError | None = None
        for pool in self._servers(quote(scene, safe="")):
            try:
                return pool, pool.open()
            except OSError as error:
                fault = error
        assert fault is not None
        raise fault

    def _ask(self, method: str, path: str, body: bytes | None = None, kind: str | None = None, accept: str | None = None,
             **rules: Any) -> bytes:
        return self._exchange(method, path, body, kind, accept, **rules)[1]

    def _exchange(self, method: str, path: str, body: bytes | None = None, kind: str | None = None, accept: str | None = None,
                  conditions: Mapping[str, str] = {}, once: bool = False, home: str | None = None, pool: _Pool | None = None) -> tuple:
        """The headers and the body of an answer, and its server. `once`: what may have reached a server is not sent again."""
        name = quote(home, safe="") if home is not None else path[len("/v1/scenes/"):].split("/")[0].split("?")[0]
        servers = [pool] if pool else self._servers(name)
        headers = {**self._headers, **conditions}
        if kind:
            headers["Content-Type"] = kind
        if accept:
            headers["Accept"] = accept
        if name in self._revisions:
            headers["X-Scene-Min-Revision"] = str(self._revisions[name])
        # A change by PATCH is sent again only if a precondition refuses what was done already.
        again = not once and (method != "PATCH" or not conditions.keys().isdisjoint({"If-Match", "If-None-Match"}))
        end = time.monotonic() + self._patience
        free = dict.fromkeys(servers, -math.inf)  # When each may be asked; at once if it was not asked before.
        repeated, attempt = False, 0
        while True:
            server = min(servers, key=free.__getitem__)
            pause = free[server] - time.monotonic()
            if pause > 0:
                time.sleep(pause)
            fault: Exception
            reached, asked, refusing = False, 0.0, [server]
            try:
                connection = server.take()
                reached = True
                status, answered, text = self._send(server, connection, method, path, body, headers)
            except ssl.SSLCertVerificationError:
                raise
            except _LOST as error:
                server.lost = time.monotonic()
                fault, repeat = error, again or not reached
                repeated = repeated or reached
            else:
                server.lost = -math.inf
                if status < 400:
                    self._saw(name, answered["X-Scene-Revision"])
                    return answered, text, server
                if status == 404 and repeated and method == "DELETE":
                    return answered, b"", server  # The first request has deleted it.
                fault, repeat = _problem(status, text, repeated), status == 429 or (again and status in _BUSY)
                repeated = repeated or status in _BUSY - {429}
                asked = _retry_after(answered["Retry-After"])
                if status == 429:  # A limit for this client: another server is no way around it.
                    refusing = servers
            wait = max(asked, random.uniform(0.5, 1) * min(0.1 * 2 ** min(attempt // len(servers), 9), 5))
            free.update(dict.fromkeys(refusing, time.monotonic() + wait))
            if not repeat or min(free.values()) > end:
                raise fault
            attempt += 1

    def _send(self, pool: _Pool, connection: http.client.HTTPConnection, method: str, path: str, body: bytes | None,
              headers: Mapping[str, str]) -> tuple:
        broken = False
        try:
            try:
                connection.request(method, pool.prefix + path, body, headers)
            except (BrokenPipeError, ConnectionResetError):
                broken = True  # The server may have answered before the end of the body, and closed the connection.
            answer = connection.getresponse()
            unknown = answer.length is None and not answer.chunked  # The head was cut: a server states the length.
            text = answer.read()
            if unknown:
                raise http.client.IncompleteRead(text)
        except BaseException:
            connection.close()
            raise
        if broken:
            connection.close()
        else:
            pool.give_back(connection)
        return answer.status, answer.headers, text

    def _columns(self, path: str, body: bytes, kind: str, accept: str | None = None) -> tuple:
        """The columns of an answer, flat, and the revision of the scene."""
        headers, text, _ = self._exchange("POST", path, body, kind, accept)
        if headers.get_content_type() == _JSON:
            return _from_json(json.loads(text)), headers["X-Scene-Revision"]
        columns = _unpack(text)
        for name in _REMARKS:
            if headers[f"X-Sightline-{name}"]:
                remark = json.loads(headers[f"X-Sightline-{name}"])
                columns[name] = remark["warnings"] if name == "warnings" else remark
        return columns, headers["X-Scene-Revision"]

    def _sliced(self, path: str, request: _Request, progress: Progress) -> Columns:
        """The columns of a request with any number of rows, flat."""
        rows, kind = request.rows(), _JSON if request.as_text else _BYTES
        with _Report(progress, rows) as report:
            if rows > _SLICE:
                gathered, revisions = _Gathered(rows), set()

                def call(first: int) -> Callable[[], tuple]:
                    last = min(first + _SLICE, rows)
                    return lambda: (first, last, *self._slice(path, request, first, last, kind))
                for first, last, columns, revision in _ahead(map(call, range(0, rows, _SLICE))):
                    gathered.add(first, last, columns)
                    revisions.add(revision)
                    report(last)
                if len(revisions) == 1:
                    return gathered.finish()
            # One request, which is answered by one revision of the scene.
            columns = self._columns(path, request.body(0, rows), kind)[0]
            report(rows)
            return columns

    def _slice(self, path: str, request: _Request, first: int, last: int, kind: str) -> tuple:
        try:
            return self._columns(path, request.body(first, last), kind)
        except SightlineError as error:
            if first:
                raise _moved(error, first) from None
            raise

    def _rays(self, scene: str, kind: str, origins: Points | None, directions: Points | None, tmin: Limit, tmax: Limit,
              progress: Progress, options: dict) -> Columns:
        path = self._scene(scene, f"/rays:{kind}")
        made = "generator" in options
        if made != (origins is None) or made != (directions is None):
            raise ValueError("give origins and directions, or a generator")
        if made and not (tmin is None and tmax is None):
            raise ValueError('a generator has a "range" in place of tmin and tmax')
        if "image" in options:
            raise ValueError("columns have no picture: use image()")
        fields, sent = _fields(options)
        texts = not TEXTS.isdisjoint(fields) or any(map(_is_long, fields)) or "masks" in options or "explain" in options
        if texts and "fields" not in sent and kind in ("closest", "all"):
            sent["fields"] = ["t", "instance", "primitive", "triangle"]  # As in an answer of bytes.
        if made:
            columns, _ = self._columns(path, _text(sent), _JSON, None if texts else _BYTES)
            return _finish(columns, fields, _pixels(options["generator"]), lists=kind == "all")
        masks = sent.pop("masks", None)
        rays = _read_rays(origins, directions, tmin, tmax, texts, marks=options.get("on_invalid") == "mark")
        if "filters" in sent:
            sent["filters"] = _filters(sent["filters"], rays.lead)
        tables = rays.tables()
        if masks is not None:
            tables["masks"] = _masks(masks, rays.lead)
        columns = self._sliced(path, _Request(b"SLR1", tables, sent, texts), progress)
        return _finish(columns, fields, rays.lead, lists=kind == "all")

    def _near(self, scene: str, kind: str, points: Points, progress: Progress, options: dict) -> Columns:
        fields, sent = _fields(options)
        if not TEXTS.isdisjoint(fields):
            raise ValueError("columns of points have no texts: ask for ids, or use ask()")
        table = _allow(_points("points", points))
        columns = self._sliced(self._scene(scene, f"/points:{kind}"), _Request(b"SLP1", {"points": table}, sent), progress)
        return _finish(columns, fields, table.shape[:-1], lists=kind == "nearest")

    def _sweeps(self, scene: str, kind: str, origins: Points, directions: Points, shape: dict, tmin: Limit, tmax: Limit,
                progress: Progress, options: dict) -> Columns:
        radius, half, to, axes = shape["radius"], shape["half"], shape["to"], shape["axes"]
        if (radius is None) == (half is None):
            raise ValueError("give radius or half")
        if (to is not None and radius is None) or (axes is not None and half is None):
            raise ValueError("to needs radius, axes needs half")
        fields, sent = _fields(options)
        if not TEXTS.isdisjoint(fields):
            raise ValueError("columns of sweeps have no texts: ask for ids, or use ask()")
        rays = _read_rays(origins, directions, tmin, tmax)
        tables = rays.tables()
        if half is None:
            size = _limit("radius", radius, rays.origins)
            assert size is not None
            tables["radius"] = _allow(size)
        else:
            tables["half"] = _allow(_halves(half, rays.origins))
        if to is not None:
            tables["to"] = _allow(_numbers("to", to))
            _same_shape(tables["to"], rays.origins)
        if axes is not None:
            tables["axes"] = _allow(_axes(axes, rays.origins))
        columns = self._sliced(self._scene(scene, f"/sweeps:{kind}"), _Request(b"SLW1", tables, sent), progress)
        return _finish(columns, fields, rays.lead, lists=False)


# Connections and processes.


class _Pool:
    """The idle connections to one server. A thread takes one for the time of an exchange."""

    def __init__(self, url: str, timeout: float):
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"not an http address: {url}")
        self.url, self.prefix = url.rstrip("/"), parts.path.rstrip("/")
        self._kind = http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection
        self._host, self._port, self._timeout = parts.hostname, parts.port, timeout
        self._lock = threading.Lock()
        self._idle: list[http.client.HTTPConnection] = []
        self.lost = -math.inf  # When the last request was left without an answer, until one has an answer.

    def open(self) -> http.client.HTTPConnection:
        connection = self._kind(self._host, self._port, timeout=min(self._timeout, _CONNECT))
        connection.connect()
        connection.timeout = self._timeout
        connection.sock.settimeout(self._timeout)
        return connection

    def take(self) -> http.client.HTTPConnection:
        while True:
            with self._lock:
                connection = self._idle.pop() if self._idle else None
            if connection is None:
                return self.open()
            if connection.sock is not None and not _readable(connection.sock):
                return connection
            connection.close()  # The server has closed it.

    def give_back(self, connection: http.client.HTTPConnection) -> None:
        if connection.sock is None:
            return
        with self._lock:
            self._idle.append(connection)

    def close(self) -> None:
        with self._lock:
            idle, self._idle = self._idle, []
        for connection in idle:
            connection.close()


def _readable(socket: Any) -> bool:
    """Whether an idle connection has something to read: its end."""
    with selectors.DefaultSelector() as selector:
        selector.register(socket, selectors.EVENT_READ)
        return bool(selector.select(0))


class _Process:
    """A server of this program's own, on a free port."""

    def __init__(self, binary: str, scenes: list[tuple[str, str]], arguments: Sequence[str]):
        if not shutil.which(binary):
            raise FileNotFoundError(f"there is no program {binary}: pass binary= or set SIGHTLINE_BINARY")
        self._log = tempfile.TemporaryFile()
        preloads = [word for name, source in scenes for word in ("--preload", f"{name}={source}")]
        self._process = subprocess.Popen([binary, "serve", "--listen", "127.0.0.1:0", *preloads, *arguments],
                                         stdout=subprocess.PIPE, stderr=self._log, text=True)
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line.startswith("listening on "):
            self.stop()
            self._log.seek(0)
            raise RuntimeError(f"{binary} did not start: {self._log.read()[-2000:].decode('utf-8', 'replace').strip()}")
        self.url = line.split()[-1]
        atexit.register(self.stop)

    def stop(self) -> None:
        atexit.unregister(self.stop)
        self._process.terminate()
        try:
            self._process.wait(60)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()


def _named_source(source: str) -> tuple[str, str]:
    """(id, what to preload)."""
    name, equals, file = source.partition("=")
    if equals:
        return name, file
    if source.startswith("demo:"):
        return source[len("demo:"):], source
    return re.sub(r"[^A-Za-z0-9._-]+", "-", Path(source).stem).strip(".-") or "scene", source


def _conditions(if_match: str | None, if_none_match: str | None) -> dict[str, str]:
    told = {"If-Match": if_match, "If-None-Match": if_none_match}
    return {name: value for name, value in told.items() if value is not None}


def _problem(status: int, text: bytes, repeated: bool = False) -> SightlineError:
    try:
        problem = json.loads(text)
    except ValueError:
        problem = None
    return SightlineError(status, problem if isinstance(problem, dict) else {"detail": text[:200].decode("utf-8", "replace")}, repeated)


def _retry_after(text: str | None) -> float:
    """Seconds: the header has a number or a date."""
    if text is None:
        return 0
    try:
        return max(0.0, float(text))
    except ValueError:
        pass
    try:
        return max(0.0, email.utils.parsedate_to_datetime(text).timestamp() - time.time())
    except (TypeError, ValueError):
        return 0


def _moved(error: SightlineError, first: int) -> SightlineError:
    """An error of a slice, with the pointers of the whole request."""
    errors = []
    for each in error.errors:
        parts = str(each.get("pointer", "")).split("/")
        if len(parts) > 2 and parts[2].isdigit() and parts[1] in ("rays", "points", "sweeps", "origins", "directions", "tmin", "tmax", "masks"):
            parts[2] = str(int(parts[2]) + first * (3 if parts[1] in ("origins", "directions") else 1))
        errors.append({**each, "pointer": "/".join(parts)})
    return SightlineError(error.status, {"code": error.code, "detail": error.detail, "errors": errors, "request_id": error.request_id})


def _ahead(calls: Iterable[Callable[[], Any]]) -> Iterator[Any]:
    """The results of calls, in order, with a few calls under way at once."""
    with concurrent.futures.ThreadPoolExecutor(_AT_ONCE) as threads:
        waiting: collections.deque = collections.deque()
        try:
            for call in calls:
                waiting.append(threads.submit(call))
                if len(waiting) >= _AT_ONCE:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for each in waiting:
                each.cancel()


class _Report:
    """Tells the progress of a call."""

    def __init__(self, progress: Progress, total: int):
        self._function = progress if callable(progress) else None
        self._total, self._done = total, 0
        self._bar: Any = None
        self._line = False
        if progress is True:
            try:
                self._bar = importlib.import_module("tqdm").tqdm(total=total, unit="row", unit_scale=True)
            except ImportError:
                self._line = True

    def __enter__(self) -> _Report:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
        if self._line:
            print(file=sys.stderr)

    def __call__(self, done: int) -> None:
        if self._function:
            self._function(done, self._total)
        if self._bar is not None:
            self._bar.update(max(0, done - self._done))
        if self._line:
            print(f"\r{done} of {self._total} rows", end="", file=sys.stderr, flush=True)
        self._done = done


class _Gathered:
    """The columns of slices, joined."""

    def __init__(self, rows: int):
        self._rows = rows
        self._columns: dict[str, Any] = {}
        self._parts: dict[str, list] = collections.defaultdict(list)
        self._remarks: dict[str, Any] = {}
        self._hits = 0

    def add(self, first: int, last: int, columns: Columns) -> None:
        lists = "first" in columns
        for name, column in columns.items():
            if name in _REMARKS:
                self._remarks[name] = _sum(self._remarks[name], column) if name == "work" and name in self._remarks else column
            elif name == "first":  # The next slice begins where this one ends.
                ends = column[:-1] if last < self._rows else column
                self._parts[name].append(ends + numpy.uint64(self._hits) if numpy is not None else [each + self._hits for each in ends])
            elif isinstance(column, list) or (lists and name not in ("totals", "invalid")):
                self._parts[name].append(column)
            else:
                width = len(column) // (last - first)
                if name not in self._columns:
                    self._columns[name] = numpy.empty(self._rows * width, column.dtype)
                self._columns[name][first * width:last * width] = column
        if lists:
            self._hits += int(columns["first"][-1])

    def finish(self) -> Columns:
        for name, parts in self._parts.items():
            if isinstance(parts[0], list):
                self._columns[name] = [each for part in parts for each in part]
            else:
                self._columns[name] = numpy.concatenate(parts)
        return {**self._columns, **self._remarks}


def _sum(a: Any, b: Any) -> Any:
    """Of two works of equal form."""
    return {name: _sum(a[name], b[name]) for name in a} if isinstance(a, dict) else a + b


# From arguments to requests.


class _Numbers(NamedTuple):
    """An argument. `flat` has its numbers row by row: a list of float, or a numpy array of <f4 or <f8."""

    name: str
    shape: tuple
    flat: Any


class _Rays(NamedTuple):
    """Checked arguments. `lead` is the shape of a column with one number for each ray."""

    lead: tuple
    origins: _Numbers
    directions: _Numbers
    tmin: _Numbers | None
    tmax: _Numbers | None

    def tables(self) -> dict[str, _Numbers]:
        tables = {"origins": self.origins, "directions": self.directions, "tmin": self.tmin, "tmax": self.tmax}
        return {name: table for name, table in tables.items() if table is not None}

    def total(self) -> int:
        return math.prod(self.lead)


_TABLE_WIDTHS = {"origins": 3, "directions": 3, "points": 3, "half": 3, "to": 3, "axes": 9}
_TABLE_FLAGS = {"tmin": 2, "tmax": 4, "half": 8, "to": 16, "axes": 16}


class _Request(NamedTuple):
    """A request of docs/reference/binary.md, or of JSON, before it is written. `tables` are in the order of that page."""

    magic: bytes
    tables: dict[str, _Numbers]
    options: dict
    as_text: bool = False

    def rows(self) -> int:
        name, table = next(iter(self.tables.items()))
        return len(table.flat) // _TABLE_WIDTHS.get(name, 1)

    def body(self, first: int, last: int) -> bytes:
        """Of these rows."""
        options = self.options
        if "filters" in options:
            filters = options["filters"]
            options = {**options, "filters": {**filters, "rays": filters["rays"][first:last]}}
        parts = [(name, table._replace(flat=table.flat[first * width:last * width]), width)
                 for name, table in self.tables.items() for width in (_TABLE_WIDTHS.get(name, 1),)]
        if not self.as_text:
            return _frame(self.magic, sum(_TABLE_FLAGS.get(name, 0) for name in self.tables),
                          [(table, width) for _, table, width in parts], options)
        columns = {name: _list(table) for name, table, _ in parts}
        if "tmax" in columns:
            columns["tmax"] = [None if x == math.inf else x for x in columns["tmax"]]
        return _text({**options, **columns})


def _fields(options: Mapping) -> tuple[Sequence[str], dict]:
    """The names that the caller asks for, and the options to send: with `instance`, which tells a hit from a miss."""
    if "fields" not in options:
        return ("instance",), dict(options)
    fields = options["fields"]
    if not isinstance(fields, (list, tuple)) or not all(isinstance(field, str) for field in fields):
        raise ValueError(f"fields is {fields!r}: expected a list or tuple of names")
    missing = ["instance"] if fields and "instance" not in fields else []
    return fields, {**options, "fields": [*fields, *missing]}


def _is_long(field: str) -> bool:
    """Binary columns have names of at most 16 bytes."""
    return field.startswith("_") and len(field) > 16


def _is_number(kind: type) -> bool:
    return kind is float or kind is int or (issubclass(kind, numbers.Real) and not issubclass(kind, bool))


def _numbers(name: str, value: Any) -> _Numbers:
    """An argument by value, with its shape."""
    if numpy is None or not hasattr(value, "__array__"):
        flat: list[float] = []
        return _Numbers(name, _gather(name, value, flat), flat)
    if isinstance(value, numpy.ma.MaskedArray):
        raise ValueError(f"{name} is a masked array: expected an array without a mask")
    table = numpy.asarray(value)
    if table.dtype.kind not in "iuf" or table.dtype.itemsize > 8:
        raise ValueError(f"{name} has dtype {table.dtype}: expected integers or floats of at most 64 bits")
    single = table.dtype.kind == "f" and table.dtype.itemsize <= 4
    return _Numbers(name, table.shape, numpy.ascontiguousarray(table, "<f4" if single else "<f8").reshape(-1))


def _gather(place: str, value: Any, flat: list, depth: int = 3) -> tuple:
    """Appends the numbers of a nested sequence to `flat`; returns its shape."""
    scalar = _is_number(type(value))
    items = [value] if scalar else value
    try:
        if not scalar and (depth == 0 or isinstance(value, _NO_SEQUENCES) or not hasattr(value, "__len__")):
            raise TypeError
        numeric = all(map(_is_number, set(map(type, items))))
    except (TypeError, NotImplementedError):  # Iteration fails over an array without axes and a memoryview with two.
        raise ValueError(f"{place} is of type {type(value).__name__}: expected numbers, in at most three axes") from None
    if numeric:
        try:
            flat.extend(map(float, items))
        except OverflowError:
            raise ValueError(f"{place} has an integer that does not fit a float64") from None
        return () if scalar else (len(items),)
    shapes = [_gather(f"{place}[{i}]", item, flat, depth - 1) for i, item in enumerate(items)]
    for i, shape in enumerate(shapes):
        if shape != shapes[0]:
            raise ValueError(f"{place}[{i}] has shape {shape}, {place}[0] has shape {shapes[0]}")
    return len(shapes), *shapes[0]


def _points(name: str, value: Any, images: bool = True) -> _Numbers:
    if isinstance(value, (list, tuple)) and not value:
        return _Numbers(name, (0, 3), [])
    table = _numbers(name, value)
    if table.shape[-1:] != (3,) or len(table.shape) not in ((2, 3) if images else (2,)):
        raise ValueError(f"{name} has shape {table.shape}: expected (n, 3){' or (h, w, 3)' if images else ''}")
    return table


def _limit(name: str, value: Any, origins: _Numbers) -> _Numbers | None:
    """tmin or tmax, repeated if it is one number for all rays."""
    if value is None:
        return None
    table, lead = _numbers(name, value), origins.shape[:-1]
    if table.shape == ():
        count = math.prod(lead)
        return _Numbers(name, (), table.flat * count if isinstance(table.flat, list) else numpy.repeat(table.flat, count))
    if table.shape != lead:
        raise ValueError(f"{name} has shape {table.shape}, origins has shape {origins.shape}: expected () or {lead}")
    return table


def _filters(value: Mapping, lead: tuple) -> dict:
    """Filters with the number of one for each ray."""
    table = _numbers("filters", value["rays"])
    if table.shape != lead:
        raise ValueError(f"filters has numbers of shape {table.shape}: expected {lead}")
    return {**value, "rays": [int(number) for number in table.flat]}


def _masks(value: Any, lead: tuple) -> _Numbers:
    """Integers of the shape of the rays."""
    table = _numbers("masks", value)
    if table.shape != lead:
        raise ValueError(f"masks has shape {table.shape}: expected {lead}")
    flat = _list(table)
    if not all(0 <= x < 2 ** 32 and x == int(x) for x in flat):
        raise ValueError("masks: expected integers from 0 to 4294967295")
    return table._replace(flat=list(map(int, flat)))


def _halves(value: Any, origins: _Numbers) -> _Numbers:
    """Half sides of boxes, repeated if they are three numbers for all sweeps."""
    table = _numbers("half", value)
    if table.shape == (3,):
        count = math.prod(origins.shape[:-1])
        return _Numbers("half", origins.shape, table.flat * count if isinstance(table.flat, list) else numpy.tile(table.flat, count))
    if table.shape != origins.shape:
        raise ValueError(f"half has shape {table.shape}, origins has shape {origins.shape}: expected (3,) or equal shapes")
    return table


def _axes(value: Any, origins: _Numbers) -> _Numbers:
    """Axes of boxes, repeated if they are three rows for all sweeps."""
    table, each = _numbers("axes", value), (*origins.shape, 3)
    if table.shape == (3, 3) and each != (3, 3):
        count = math.prod(origins.shape[:-1])
        return _Numbers("axes", each, table.flat * count if isinstance(table.flat, list) else numpy.tile(table.flat, count))
    if table.shape != each:
        raise ValueError(f"axes has shape {table.shape}, origins has shape {origins.shape}: expected (3, 3) or {each}")
    return table


def _same_shape(table: _Numbers, other: _Numbers) -> None:
    if table.shape != other.shape:
        raise ValueError(f"{table.name} has shape {table.shape}, {other.name} has shape {other.shape}: expected equal shapes")


def _allow(table: _Numbers, infinities: tuple = ()) -> _Numbers:
    """Refuses NaN, and infinities except these."""
    if isinstance(table.flat, list):
        bad = next((i for i, x in enumerate(table.flat) if not math.isfinite(x) and x not in infinities), None)
    else:
        good = numpy.isfinite(table.flat)
        if not good.all():
            good |= numpy.isin(table.flat, infinities)
        bad = None if good.all() else int(good.argmin())
    if bad is None:
        return table
    number, place = float(table.flat[bad]), ""
    for size in reversed(table.shape):
        bad, index = divmod(bad, size)
        place = f"[{index}]{place}"
    raise ValueError(f"{table.name}{place} is {number}: expected {' or '.join(['a finite number', *map(str, infinities)])}")


def _read_rays(origins: Any, directions: Any, tmin: Limit, tmax: Limit, texts: bool = False, marks: bool = False) -> _Rays:
    """`texts`: the request becomes JSON. `marks`: the server marks what is not finite."""
    start, along = _points("origins", origins), _points("directions", directions)
    _same_shape(along, start)
    rays = _Rays(start.shape[:-1], start, along, _limit("tmin", tmin, start), _limit("tmax", tmax, start))
    if texts or not marks:
        infinities = (math.inf, -math.inf)
        for table, allowed in ((start, ()), (along, ()), (rays.tmin, () if texts else infinities),
                               (rays.tmax, (math.inf,) if texts else infinities)):
            if table is not None:
                _allow(table, allowed)
    return rays


def _pack(rays: _Rays, options: dict) -> bytes:
    """A request of docs/reference/binary.md."""
    return _Request(b"SLR1", rays.tables(), options).body(0, rays.total())


def _frame(magic: bytes, flags: int, tables: list, options: dict) -> bytes:
    """`tables` are pairs of numbers and their columns. Float32 if all numbers are float32, else float64."""
    single = all(getattr(table.flat, "dtype", None) == "<f4" for table, _ in tables)
    count = len(tables[0][0].flat) // tables[0][1]
    parts = [_head(magic, flags | (not single), count, options)]
    for table, width in tables:
        for k in range(width):
            column = table.flat[k::width]
            parts.append(struct.pack(f"<{count}d", *column) if isinstance(column, list) else
                         numpy.ascontiguousarray(column, "<f4" if single else "<f8"))
    return b"".join(parts)


def _head(magic: bytes, flags: int, count: int, options: dict) -> bytes:
    text = _text(options) if options else b""
    head = struct.pack("<4sIQII", magic, flags, count, len(text), 0) + text
    return head + bytes(-len(head) % 8)


def _list(table: _Numbers) -> list:
    return table.flat if isinstance(table.flat, list) else table.flat.tolist()


def _rows(name: str, value: Any) -> list:
    """Points for JSON."""
    flat = _list(_allow(_points(name, value, images=False)))
    return [flat[i:i + 3] for i in range(0, len(flat), 3)]


def _id_triples(ids: Any, name: str = "ids") -> list:
    """Exact integers of shape (n, 3)."""
    if isinstance(ids, (list, tuple)) and not ids:
        return []
    shape = _numbers(name, ids).shape
    if len(shape) != 2 or shape[1] != 3:
        raise ValueError(f"{name} has shape {shape}: expected (n, 3)")
    if numpy is not None and hasattr(ids, "__array__"):
        ids = numpy.asarray(ids)
        if ids.dtype.kind == "f":
            raise ValueError(f"{name} has dtype {ids.dtype}: expected integers")
    for i, row in enumerate(ids):
        if not all(isinstance(x, numbers.Integral) for x in row):
            raise ValueError(f"{name}[{i}] is {row!r}: expected integers")
    return list(ids)


def _pixels(generator: Mapping) -> tuple | None:
    """The shape of a picture, None for rays in a row."""
    if "pixels" in generator:
        return None
    if "crop" in generator:
        return int(generator["crop"][3]), int(generator["crop"][2])
    return (int(generator["height"]), int(generator["width"])) if {"width", "height"} <= set(generator) else None


def _text(body: Any) -> bytes:
    try:
        return json.dumps(body, allow_nan=False, default=_plain).encode()
    except ValueError as error:
        raise ValueError(f"{_infinite(body, '') or 'the request'} cannot be written as JSON: {error}") from None


def _plain(value: Any) -> Any:
    """For JSON: arrays and scalars of numpy by value."""
    if numpy is not None and isinstance(value, (numpy.ndarray, numpy.generic)) and not isinstance(value, numpy.ma.MaskedArray):
        plain = value.tolist()
        if plain is not value:  # A longdouble has no plain form.
            return plain
    raise ValueError(f"it has a {type(value).__name__}")


def _infinite(value: Any, place: str) -> str | None:
    """The JSON pointer of the first number that is not finite."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, float):
        return None if math.isfinite(value) else place
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    return next(filter(None, (_infinite(item, f"{place}/{key}") for key, item in items)), None)


# From meshes to files.


def _scene_bytes(source: Any) -> bytes:
    """The file of a scene: bytes, a path, or a mesh."""
    if isinstance(source, (bytes, bytearray, memoryview)):
        return bytes(source)
    if isinstance(source, (str, os.PathLike)):
        return Path(source).read_bytes()
    if hasattr(source, "to_legacy"):  # A tensor mesh of Open3D.
        source = source.to_legacy()
    faces = getattr(source, "faces", None)  # trimesh
    if faces is None:
        faces = getattr(source, "triangles", None)  # Open3D
    if hasattr(source, "vertices") and faces is not None:
        vertices = source.vertices
        return _mesh_glb(*((numpy.asarray(vertices), numpy.asarray(faces)) if numpy is not None else (vertices, faces)), "mesh")
    if hasattr(source, "export"):  # A scene of trimesh.
        return bytes(source.export(file_type="glb"))
    raise ValueError(f"source is of type {type(source).__name__}: expected bytes, a path or a mesh")


def _mesh_glb(vertices: Any, faces: Any, name: str) -> bytes:
    table = _allow(_points("vertices", vertices, images=False))
    rows = _id_triples(faces, "faces")
    corners, count = _list(table), table.shape[0]
    flat = [int(x) for row in rows for x in row]
    if flat and not (0 <= min(flat) and max(flat) < count):
        raise ValueError(f"faces has numbers from {min(flat)} to {max(flat)}: expected 0 to {count - 1}")
    if not flat:
        raise ValueError("faces is empty: expected at least one triangle")
    try:
        positions = struct.pack(f"<{3 * count}f", *corners)
        at = None if list(struct.unpack(f"<{3 * count}f", positions)) == corners else [
            float(round((min(corners[k::3]) + max(corners[k::3])) / 2)) for k in range(3)]
        if at:
            positions = struct.pack(f"<{3 * count}f", *(x - at[i % 3] for i, x in enumerate(corners)))
    except OverflowError:
        raise ValueError("vertices has a number that does not fit a float32") from None
    stored = struct.unpack(f"<{3 * count}f", positions)
    indices = struct.pack(f"<{len(flat)}I", *flat)
    document = {
        "asset": {"version": "2.0", "generator": "sightline.py"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0, **({"translation": at} if at else {})}],
        "meshes": [{"name": name, "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
                       "min": [min(stored[k::3]) for k in range(3)], "max": [max(stored[k::3]) for k in range(3)]},
                      {"bufferView": 1, "componentType": 5125, "count": len(flat), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)}, {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(positions) + len(indices)}]}
    text = _text(document)
    text += b" " * (-len(text) % 4)
    data = positions + indices
    return b"".join((struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)), struct.pack("<II", len(text), 0x4E4F534A), text,
                     struct.pack("<II", len(data), 0x004E4942), data))


# From answers to columns.


def _unpack(body: bytes, by_rows: bool = False) -> Columns:
    """The columns of an answer of docs/reference/binary.md, flat or in rows."""
    magic, count = struct.unpack_from("<4sI", body)
    if magic != b"SLA1":
        raise RuntimeError("the answer does not begin with SLA1")
    columns: Columns = {}
    for i in range(count):
        title, kind, width, at, rows = struct.unpack_from("<16sIIQQ", body, 16 + 40 * i)
        name = title.rstrip(b"\0").decode()
        letter, dtype = _TYPES[kind]
        if numpy is not None:
            column = numpy.frombuffer(body, dtype, rows * width, at)
            if kind == 2:  # 4294967295 becomes -1: it is 0 after the addition.
                column = numpy.subtract(column + numpy.uint32(1), 1, dtype="int64")
            else:
                column = column == 1 if name in _FLAGS else column.astype(column.dtype.newbyteorder("="))
        else:
            column = list(struct.unpack_from(f"<{rows * width}{letter}", body, at))
            if kind == 2:
                column = [-1 if number == _NONE else number for number in column]
            column = [number == 1 for number in column] if name in _FLAGS else column
        columns[name] = _shaped(column, (rows, width)) if by_rows and width > 1 else column
    return columns


def _unpack_rays(body: bytes, lead: tuple | None) -> Columns:
    """The columns of rays of docs/reference/binary.md."""
    magic, flags, count, options, _ = struct.unpack_from("<4sIQII", body)
    if magic != b"SLR1":
        raise RuntimeError("the answer does not begin with SLR1")
    letter, size = ("d", 8) if flags & 1 else ("f", 4)
    at = 24 + options + -(24 + options) % 8
    names = ["origins", "directions", *(name for name in ("tmin", "tmax") if flags & _TABLE_FLAGS[name])]
    columns: Columns = {}
    for name in names:
        width = _TABLE_WIDTHS.get(name, 1)
        flat: Any = list(struct.unpack_from(f"<{count * width}{letter}", body, at)) if numpy is None else numpy.frombuffer(
            body, f"<f{size}", count * width, at).astype("float64")
        if width > 1:  # From columns to rows.
            flat = flat.reshape(width, count).T.ravel() if numpy is not None else [flat[k * count + i] for i in range(count) for k in range(width)]
        at += count * width * size
        shape: tuple = (count,) if lead is None else lead
        columns[name] = _shaped(flat, (*shape, width) if width > 1 else shape)
    return columns


def _from_pfm(body: bytes, whole: bool) -> Array:
    """A picture, its first row on top."""
    kind, sizes, scale, data = body.split(b"\n", 3)
    width, height = map(int, sizes.split())
    planes = 3 if kind == b"PF" else 1
    order = "<" if float(scale) < 0 else ">"
    shape = (height, width) + ((3,) if planes == 3 else ())
    if numpy is not None:
        rows = numpy.frombuffer(data, order + "f4", width * height * planes).reshape(shape)[::-1]
        return rows.astype("int64" if whole else "float32")
    flat = struct.unpack(f"{order}{width * height * planes}f", data)
    rows = [flat[i * width * planes:(i + 1) * width * planes] for i in reversed(range(height))]
    return _nest([int(x) if whole else x for row in rows for x in row], shape)


def _from_json(answer: dict) -> Columns:
    """The columns of an answer as JSON, flat and as _unpack() gives them."""
    rays = len(next(answer[name] for name in ("totals", "instance", "hits", "counts") if name in answer))
    columns: Columns = {}
    for name, values in answer.items():
        if name in TEXTS or name in _REMARKS:
            columns[name] = values
        elif name == "invalid":
            faults = {each["ray"]: _FAULTS.index(each["code"]) for each in values}
            columns[name] = _column([faults.get(i, 0) for i in range(rays)], "uint8")
        elif name in _FLAGS:
            columns[name] = _column([value is True for value in values], "bool")
        elif name in _COUNTS:
            columns[name] = _column(values, "uint64")
        elif name in _WIDTHS or name in _DISTANCES or name.startswith("_"):
            none = math.inf if name in _DISTANCES else math.nan
            columns[name] = _column([none if value is None else float(value) for value in values], "float64")
        else:
            columns[name] = _column(values, "int64")
    return columns


def _column(values: list, dtype: str) -> Array:
    return values if numpy is None else numpy.array(values, dtype)


def _finish(columns: Columns, fields: Sequence[str], lead: tuple | None, lists: bool) -> Columns:
    """Adds `hit` and gives the columns their shapes. `lists`: a ray has any number of rows."""
    rows = 0
    if "instance" in columns:
        ids = columns["instance"]
        rows = len(ids)
        columns["hit"] = [each >= 0 for each in ids] if isinstance(ids, list) else ids >= 0
        if "instance" not in fields:
            del columns["instance"]
    for name in columns.keys() - _REMARKS:
        column, width = columns[name], _WIDTHS.get(name, 1)
        if name.startswith("_") and rows:  # The file says how many numbers it has.
            width = len(column) // rows
        by_ray = not lists or name in ("totals", "invalid")
        shape = (lead if lead is not None and by_ray else (len(column) // width,)) + ((width,) if width > 1 else ())
        if len(column) != math.prod(shape):
            raise RuntimeError(f"the answer has {len(column)} numbers in column {name}: expected shape {shape}")
        columns[name] = _shaped(column, shape)
    return columns


def _shaped(flat: Any, shape: tuple) -> Array:
    return _nest(flat, shape) if isinstance(flat, list) else flat.reshape(shape)


def _mapped(values: list, function: Callable[[Any], Any]) -> list:
    """Of nested lists."""
    return [_mapped(each, function) if isinstance(each, list) else function(each) for each in values]


def _nest(values: list, shape: tuple) -> list:
    """As numpy's reshape()."""
    if len(shape) == 1:
        return values
    size = math.prod(shape[1:])
    return [_nest(values[i * size:(i + 1) * size], shape[1:]) for i in range(shape[0])]


if __name__ == "__main__":
    if sys.argv[1:2] != ["bulk"]:
        sys.exit("usage: python -m sightline bulk RAYS --scene ID --out FILE (docs/guides/bulk.md)")
    sys.exit(importlib.import_module("sightline_bulk").main(sys.argv[2:]))
