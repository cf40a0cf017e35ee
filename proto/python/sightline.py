"""A client of Sightline: one file, standard library only; numpy is used where it is installed.

    from sightline import Sightline

    with Sightline("http://127.0.0.1:8080") as server:
        server.put("house", "house.glb")
        hits = server.closest("house", [[0, 1.7, 10]], [[0, 0, -1]], fields=["t", "node_id"])

Rays and hits travel as bytes (proto/BINARY.md); fields that are texts (node, node_path, mesh, material) as JSON. Columns
come back as numpy arrays, or without numpy as lists. A miss has t = inf and ids of -1 in numpy's int64 and in lists;
shading_normal, uv and colour are NaN where the file says nothing.
An object has one connection: use one for each thread.
"""

from __future__ import annotations

import http.client
import json
import math
import struct
from array import array
from pathlib import Path
from typing import Any, Mapping, Sequence, Union
from urllib.parse import quote, urlencode, urlsplit

try:
    import numpy
except ImportError:
    numpy = None

__all__ = ["Sightline", "SightlineError"]

Points = Union[Sequence[Sequence[float]], "numpy.ndarray"]
TEXTS = {"node", "node_path", "mesh", "material"}
_BYTES, _JSON = "application/octet-stream", "application/json"
# By the numbers of BINARY.md: struct and array letter, numpy type.
_TYPES = {1: ("d", "<f8"), 2: ("I", "<u4"), 3: ("B", "u1"), 4: ("Q", "<u8"), 5: ("q", "<i8")}
_NONE = 0xFFFFFFFF
_NO_FLAG = 255
_FLAGS = {"front", "on_edge"}


class SightlineError(Exception):
    """What the server refused. `errors` has a JSON pointer for each place that is wrong."""

    def __init__(self, status: int, problem: Mapping[str, Any]):
        self.status = status
        self.code = problem.get("code", "")
        self.detail = problem.get("detail", "")
        self.errors = problem.get("errors", [])
        self.request_id = problem.get("request_id", "")
        place = f" at {self.errors[0]['pointer']}" if self.errors else ""
        super().__init__(f"{status} {self.code}: {self.detail}{place}")


class Sightline:
    """A server. `key` is sent as a bearer token."""

    def __init__(self, url: str, key: str | None = None, timeout: float = 120):
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"not an http address: {url}")
        kind = http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection
        self._connection = kind(parts.hostname, parts.port, timeout=timeout)
        self._prefix = parts.path.rstrip("/")
        self._headers = {"Authorization": f"Bearer {key}"} if key else {}

    def __enter__(self) -> Sightline:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._connection.close()

    # Scenes.

    def put(self, scene: str, source: bytes | str | Path, wait: float | None = None) -> dict:
        """Loads a .glb or .gltf, as bytes or from a file; returns when it is ready (or after `wait` seconds)."""
        body = source if isinstance(source, (bytes, bytearray)) else Path(source).read_bytes()
        return json.loads(self._ask("PUT", self._scene(scene, wait=wait), body, _BYTES))

    def delete(self, scene: str) -> None:
        self._ask("DELETE", self._scene(scene))

    def scenes(self) -> list[dict]:
        return json.loads(self._ask("GET", "/v1/scenes"))["scenes"]

    def scene(self, scene: str) -> dict:
        return json.loads(self._ask("GET", self._scene(scene)))

    def stats(self, scene: str) -> dict:
        return json.loads(self._ask("GET", self._scene(scene, "/stats")))

    def nodes(self, scene: str) -> list[dict]:
        """The whole hierarchy, page by page."""
        nodes, first = [], 0
        while first is not None:
            page = json.loads(self._ask("GET", self._scene(scene, "/nodes", first=first, limit=10_000)))
            nodes += page["nodes"]
            first = page.get("next")
        return nodes

    def triangles(self, scene: str, ids: Sequence[Sequence[int]]) -> list[dict]:
        """Exact corners of triangles given as (instance, primitive, triangle)."""
        text = ",".join(".".join(map(str, each)) for each in ids)
        return json.loads(self._ask("GET", self._scene(scene, "/triangles", ids=text)))["triangles"]

    # Rays: `origins` and `directions` as n triples, or a `generator`; `options` are the keys of a JSON request, such as
    # cull, include, exclude, normalize, on_invalid, fields.

    def closest(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin=None, tmax=None,
                **options: Any) -> dict:
        """Columns of the first hit of each ray."""
        return self._rays(scene, "closest", origins, directions, tmin, tmax, options)

    def any(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin=None, tmax=None,
            **options: Any):
        """Whether each ray meets anything."""
        return _as_flags(self._rays(scene, "any", origins, directions, tmin, tmax, options)["hits"])

    def count(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin=None, tmax=None,
              **options: Any):
        """How many triangles each ray meets."""
        return self._rays(scene, "count", origins, directions, tmin, tmax, options)["counts"]

    def all(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin=None, tmax=None,
            **options: Any) -> dict:
        """Columns of every hit; those of ray i are first[i] to first[i + 1], of totals[i]."""
        return self._rays(scene, "all", origins, directions, tmin, tmax, options)

    # Everything else, as the JSON that docs/api.md shows.

    def visibility(self, scene: str, points_from: Points, points_to: Points, **options: Any) -> dict:
        return self.ask(scene, "visibility", {"from": _lists(points_from), "to": _lists(points_to), **options})

    def inside(self, scene: str, points: Points, **options: Any) -> dict:
        return self.ask(scene, "points:inside", {"points": _lists(points), **options})

    # Points: `options` are the keys of a JSON request, such as max_distance, method, include, fields.

    def closest_points(self, scene: str, points: Points, **options: Any) -> dict:
        """Columns of the nearest point of the scene."""
        return self._points(scene, "closest", points, options)

    def nearest(self, scene: str, points: Points, count: int, **options: Any) -> dict:
        """Columns of the nearest triangles; those of point i are first[i] to first[i + 1]."""
        return self._points(scene, "nearest", points, {**options, "count": count})

    def distance(self, scene: str, points: Points, **options: Any) -> dict:
        """Signed distances, negative inside; `reliable` says of which it is certain."""
        return self._points(scene, "distance", points, options)

    def boxes(self, scene: str, kind: str, boxes: Sequence[Mapping], **options: Any) -> dict:
        """`kind`: any, list or count."""
        return self.ask(scene, f"boxes:{kind}", {"boxes": list(boxes), **options})

    def ask(self, scene: str, what: str, body: Mapping) -> dict:
        """Any question about a scene."""
        return json.loads(self._ask("POST", self._scene(scene, "/" + what), json.dumps(body).encode(), _JSON))

    # Below here nothing is for callers.

    def _scene(self, scene: str, rest: str = "", **parameters: Any) -> str:
        known = {name: value for name, value in parameters.items() if value is not None}
        return f"/v1/scenes/{quote(scene, safe='')}{rest}" + ("?" + urlencode(known, safe=",") if known else "")

    def _ask(self, method: str, path: str, body: bytes | None = None, kind: str | None = None, accept: str | None = None) -> bytes:
        headers = dict(self._headers)
        if kind:
            headers["Content-Type"] = kind
        if accept:
            headers["Accept"] = accept
        fresh = self._connection.sock is None
        while True:
            try:
                self._connection.request(method, self._prefix + path, body, headers)
                answer = self._connection.getresponse()
                text = answer.read()
                break
            except (http.client.RemoteDisconnected, ConnectionResetError, BrokenPipeError):
                # A kept connection may have been closed meanwhile; a change is not sent twice.
                self._connection.close()
                if fresh or method not in ("GET", "POST"):
                    raise
                fresh = True
            except BaseException:
                self._connection.close()
                raise
        if answer.status < 400:
            return text
        try:
            problem = json.loads(text)
        except ValueError:
            problem = {"detail": text[:200].decode("utf-8", "replace")}
        raise SightlineError(answer.status, problem)

    def _rays(self, scene: str, kind: str, origins, directions, tmin, tmax, options: dict) -> dict:
        path = self._scene(scene, f"/rays:{kind}")
        made = "generator" in options
        if made != (origins is None) or made != (directions is None):
            raise ValueError("give origins and directions, or a generator")
        if TEXTS & set(options.get("fields", ())):
            body = dict(options)
            if not made:
                body["origins"], body["directions"] = _flat(origins), _flat(directions)
                body.update({name: [None if name == "tmax" and x == math.inf else x for x in _numbers(limit, len(body["origins"]) // 3)]
                             for name, limit in (("tmin", tmin), ("tmax", tmax)) if limit is not None})
            return json.loads(self._ask("POST", path, json.dumps(body).encode(), _JSON))
        if made:
            return _unpack(self._ask("POST", path, json.dumps(options).encode(), _JSON, _BYTES))
        return _unpack(self._ask("POST", path, _pack(origins, directions, tmin, tmax, options), _BYTES))

    def _points(self, scene: str, kind: str, points: Points, options: dict) -> dict:
        path = self._scene(scene, f"/points:{kind}")
        if TEXTS & set(options.get("fields", ())):
            raise ValueError("columns have no texts: ask for ids, or use ask()")
        if numpy is not None:
            columns = numpy.ascontiguousarray(numpy.asarray(points, "<f8").reshape(-1, 3).T).tobytes()
            count = len(columns) // 24
        else:
            parts = _columns(points, "d")
            columns, count = b"".join(part.tobytes() for part in parts), len(parts[0])
        return _unpack(self._ask("POST", path, _head(b"SLP1", 1, count, options) + columns, _BYTES))


def _head(magic: bytes, flags: int, count: int, options: dict) -> bytes:
    text = json.dumps(options).encode() if options else b""
    head = struct.pack("<4sIQII", magic, flags, count, len(text), 0) + text
    return head + bytes(-len(head) % 8)


def _lists(points: Points) -> list:
    return points.tolist() if hasattr(points, "tolist") else [list(map(float, point)) for point in points]


def _flat(points: Points) -> list:
    return [x for point in _lists(points) for x in point]


def _numbers(limit, count: int) -> list:
    """One for all, or one for each."""
    if isinstance(limit, (int, float)):
        return [float(limit)] * count
    return limit.tolist() if hasattr(limit, "tolist") else list(map(float, limit))


def _columns(points: Points, letter: str) -> list[array]:
    triples = list(points)
    if any(len(point) != 3 for point in triples):
        raise ValueError("a point and a direction have three numbers")
    return [array(letter, (point[k] for point in triples)) for k in range(3)]


def _pack(origins: Points, directions: Points, tmin, tmax, options: dict) -> bytes:
    """A request of BINARY.md: float32 if the origins and directions are, else float64."""
    limits = [limit for limit in (tmin, tmax) if limit is not None]
    if numpy is not None:
        o, d = numpy.asarray(origins), numpy.asarray(directions)
        single = o.dtype == d.dtype == numpy.float32 and all(numpy.asarray(limit).dtype == numpy.float32 for limit in limits)
        kind = "<f4" if single else "<f8"
        o, d = (numpy.asarray(points, kind).reshape(-1, 3) for points in (o, d))
        count = len(o)
        parts = [numpy.ascontiguousarray(points.T).tobytes() for points in (o, d)]
        sizes = {len(o), len(d)}
        for limit in limits:
            column = numpy.ascontiguousarray(numpy.broadcast_to(numpy.asarray(limit, kind), (count,)))
            parts.append(column.tobytes())
    else:
        single = False
        columns = _columns(origins, "d") + _columns(directions, "d")
        count = len(columns[0])
        columns += [array("d", _numbers(limit, count)) for limit in limits]
        sizes = set(map(len, columns))
        parts = [column.tobytes() for column in columns]
    if len(sizes) != 1:
        raise ValueError(f"columns of different lengths: {sorted(sizes)}")
    flags = (not single) | 2 * (tmin is not None) | 4 * (tmax is not None)
    return b"".join([_head(b"SLR1", flags, count, options), *parts])


def _unpack(body: bytes) -> dict:
    """An answer of BINARY.md."""
    magic, count = struct.unpack_from("<4sI", body)
    if magic != b"SLA1":
        raise ValueError("the answer does not begin with SLA1")
    columns = {}
    for i in range(count):
        name, kind, width, at, rows = struct.unpack_from("<16sIIQQ", body, 16 + 40 * i)
        name = name.rstrip(b"\0").decode()
        letter, dtype = _TYPES[kind]
        if numpy is not None:
            column = numpy.frombuffer(body, dtype, rows * width, at)
            if kind == 2:
                column = numpy.where(column == _NONE, -1, column.astype("int64"))
            columns[name] = column.reshape(rows, width) if width > 1 else column
            continue
        numbers = list(struct.unpack_from(f"<{rows * width}{letter}", body, at))
        if kind == 2:
            numbers = [-1 if number == _NONE else number for number in numbers]
        elif name in _FLAGS:
            numbers = [None if number == _NO_FLAG else bool(number) for number in numbers]
        columns[name] = [numbers[j:j + width] for j in range(0, len(numbers), width)] if width > 1 else numbers
    return columns


def _as_flags(column):
    return column.astype(bool) if hasattr(column, "astype") else [bool(x) for x in column]
