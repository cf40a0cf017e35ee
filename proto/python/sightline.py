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

Rays and hits travel as bytes (docs/reference/binary.md), answers with texts as JSON.
An object has one connection: use one for each thread.
"""

from __future__ import annotations

import http.client
import json
import math
import numbers
import struct
from collections.abc import Mapping as AnyMapping, Set as AnySet
from pathlib import Path
from typing import Any, Mapping, NamedTuple, Sequence, Union
from urllib.parse import quote, urlencode, urlsplit

try:
    import numpy
except ImportError:
    numpy = None

__all__ = ["Sightline", "SightlineError"]

Points = Union[Sequence[Sequence[float]], "numpy.ndarray"]
TEXTS = {"node", "node_path", "mesh", "material"}
_BYTES, _JSON = "application/octet-stream", "application/json"
# By the numbers of docs/reference/binary.md: struct letter, numpy type.
_TYPES = {1: ("d", "<f8"), 2: ("I", "<u4"), 3: ("B", "u1"), 4: ("Q", "<u8"), 5: ("q", "<i8"), 6: ("f", "<f4")}
_NONE = 0xFFFFFFFF
_WIDTHS = {"position": 3, "normal": 3, "shading_normal": 3, "barycentrics": 2, "uv": 2, "colour": 4}
_DISTANCES = {"t", "distance"}
_FLAGS = {"front", "on_edge"} | {"hits", "reliable"}
_COUNTS = {"totals", "first"}
_REMARKS = {"work", "unreliable"}  # Beside the columns: objects of JSON.
_NO_SEQUENCES = (str, bytes, bytearray, AnyMapping, AnySet)
# By the numbers of docs/reference/binary.md.
_FAULTS = ("", "RAY_NOT_FINITE", "RAY_DIRECTION_ZERO", "RAY_LIMIT_NAN", "RAY_LIMITS_REVERSED")


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
        """Exact corners of triangles given as (instance, primitive, triangle): integers of shape (n, 3)."""
        text = ",".join(".".join(map(str, each)) for each in _id_triples(ids))
        return json.loads(self._ask("GET", self._scene(scene, "/triangles", ids=text)))["triangles"]

    # Rays: `origins` and `directions`, or a `generator` (its limits are its own `range`); `options` are the keys of a JSON
    # request, such as cull, include, exclude, normalize, on_invalid, fields (a list or tuple).

    def closest(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin=None, tmax=None,
                **options: Any) -> dict:
        """Columns of the first hit of each ray; by default t, instance, primitive, triangle. `hit` is always there."""
        return self._rays(scene, "closest", origins, directions, tmin, tmax, options)

    def any(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin=None, tmax=None,
            **options: Any):
        """Whether each ray meets anything: bool. A bad ray of on_invalid="mark" is False."""
        return self._rays(scene, "any", origins, directions, tmin, tmax, options)["hits"]

    def count(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin=None, tmax=None,
              **options: Any):
        """How many triangles each ray meets. A bad ray of on_invalid="mark" meets 0."""
        return self._rays(scene, "count", origins, directions, tmin, tmax, options)["counts"]

    def all(self, scene: str, origins: Points | None = None, directions: Points | None = None, tmin=None, tmax=None,
            **options: Any) -> dict:
        """Columns of every hit; those of ray i are first[i] to first[i + 1], of totals[i]. Pixels of an image are rays row
        by row: `totals` has the shape of the rays, `first` and the hits do not."""
        return self._rays(scene, "all", origins, directions, tmin, tmax, options)

    # Everything else, as the JSON that docs/reference/api.md shows.

    def visibility(self, scene: str, points_from: Points, points_to: Points, **options: Any) -> dict:
        """Both of shape (n, 3); with pairing="each" the n are equal."""
        start, end = _rows("points_from", points_from), _rows("points_to", points_to)
        if options.get("pairing") == "each" and len(start) != len(end):
            raise ValueError(f"points_from has shape {(len(start), 3)}, points_to has shape {(len(end), 3)}: expected equal shapes")
        return self.ask(scene, "visibility", {"from": start, "to": end, **options})

    def inside(self, scene: str, points: Points, **options: Any) -> dict:
        """`points` of shape (n, 3)."""
        return self.ask(scene, "points:inside", {"points": _rows("points", points), **options})

    # Points: `options` are the keys of a JSON request, such as max_distance, method, include, fields (without texts).

    def closest_points(self, scene: str, points: Points, **options: Any) -> dict:
        """Columns of the nearest point of the scene; by default distance, instance, primitive, triangle."""
        return self._near(scene, "closest", points, options)

    def nearest(self, scene: str, points: Points, count: int, **options: Any) -> dict:
        """Columns of the nearest triangles; those of point i are first[i] to first[i + 1]."""
        return self._near(scene, "nearest", points, {**options, "count": count})

    def distance(self, scene: str, points: Points, **options: Any) -> dict:
        """Signed distances, negative inside, inf beyond `max_distance`; the bool column `reliable` says where it is certain."""
        return self._near(scene, "distance", points, options)

    def boxes(self, scene: str, kind: str, boxes: Sequence[Mapping], **options: Any) -> dict:
        """`kind`: any, list or count. Parts of a box may be arrays."""
        return self.ask(scene, f"boxes:{kind}", {"boxes": list(boxes), **options})

    def ask(self, scene: str, what: str, body: Mapping) -> dict:
        """Any question about a scene."""
        return json.loads(self._ask("POST", self._scene(scene, "/" + what), _text(body), _JSON))

    # Below here nothing is for callers.

    def _scene(self, scene: str, rest: str = "", **parameters: Any) -> str:
        known = {name: value for name, value in parameters.items() if value is not None}
        return f"/v1/scenes/{quote(scene, safe='')}{rest}" + ("?" + urlencode(known, safe=",") if known else "")

    def _ask(self, method: str, path: str, body: bytes | None = None, kind: str | None = None, accept: str | None = None) -> bytes:
        return self._exchange(method, path, body, kind, accept)[1]

    def _exchange(self, method: str, path: str, body: bytes | None, kind: str | None, accept: str | None) -> tuple:
        """The headers and the body of an answer."""
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
            return answer.headers, text
        try:
            problem = json.loads(text)
        except ValueError:
            problem = {"detail": text[:200].decode("utf-8", "replace")}
        raise SightlineError(answer.status, problem)

    def _columns(self, path: str, body: bytes, kind: str, accept: str | None = None) -> dict:
        """The columns of an answer, flat."""
        headers, text = self._exchange("POST", path, body, kind, accept)
        if headers.get_content_type() == _JSON:
            return _from_json(json.loads(text))
        columns = _unpack(text)
        for name in _REMARKS:
            if headers[f"X-Sightline-{name}"]:
                columns[name] = json.loads(headers[f"X-Sightline-{name}"])
        return columns

    def _rays(self, scene: str, kind: str, origins, directions, tmin, tmax, options: dict) -> dict:
        path = self._scene(scene, f"/rays:{kind}")
        made = "generator" in options
        if made != (origins is None) or made != (directions is None):
            raise ValueError("give origins and directions, or a generator")
        if made and not (tmin is None and tmax is None):
            raise ValueError('a generator has a "range" in place of tmin and tmax')
        if "image" in options:
            raise ValueError("columns have no picture: leave image out")
        fields, sent = _fields(options)
        texts = not TEXTS.isdisjoint(fields)
        if made:
            columns = self._columns(path, _text(sent), _JSON, None if texts else _BYTES)
            return _finish(columns, fields, _pixels(options["generator"]), lists=kind == "all")
        rays = _read_rays(origins, directions, tmin, tmax, texts, marks=options.get("on_invalid") == "mark")
        columns = self._columns(path, *((_ray_text(rays, sent), _JSON) if texts else (_pack(rays, sent), _BYTES)))
        return _finish(columns, fields, rays.lead, lists=kind == "all")

    def _near(self, scene: str, kind: str, points: Points, options: dict) -> dict:
        fields, sent = _fields(options)
        if not TEXTS.isdisjoint(fields):
            raise ValueError("columns of points have no texts: ask for ids, or use ask()")
        table = _allow(_points("points", points))
        columns = self._columns(self._scene(scene, f"/points:{kind}"), _frame(b"SLP1", 0, [(table, 3)], sent), _BYTES)
        return _finish(columns, fields, table.shape[:-1], lists=kind == "nearest")


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


def _fields(options: Mapping) -> tuple[Sequence[str], dict]:
    """The names that the caller asks for, and the options to send: with `instance`, which tells a hit from a miss."""
    if "fields" not in options:
        return ("instance",), dict(options)
    fields = options["fields"]
    if not isinstance(fields, (list, tuple)) or not all(isinstance(field, str) for field in fields):
        raise ValueError(f"fields is {fields!r}: expected a list or tuple of names")
    missing = ["instance"] if fields and "instance" not in fields else []
    return fields, {**options, "fields": [*fields, *missing]}


def _is_number(kind: type) -> bool:
    return kind is float or kind is int or (issubclass(kind, numbers.Real) and kind is not bool)


def _numbers(name: str, value: Any) -> _Numbers:
    """An argument by value, with its shape."""
    if numpy is None or not hasattr(value, "__array__"):
        flat = []
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


def _read_rays(origins, directions, tmin, tmax, texts: bool = False, marks: bool = False) -> _Rays:
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
    limits = [(table, 1) for table in (rays.tmin, rays.tmax) if table is not None]
    flags = 2 * (rays.tmin is not None) | 4 * (rays.tmax is not None)
    return _frame(b"SLR1", flags, [(rays.origins, 3), (rays.directions, 3), *limits], options)


def _frame(magic: bytes, flags: int, tables: list, options: dict) -> bytes:
    """`tables` are pairs of numbers and their columns. Float32 if all numbers are float32, else float64."""
    single = all(getattr(table.flat, "dtype", None) == "<f4" for table, _ in tables)
    text = _text(options) if options else b""
    count = len(tables[0][0].flat) // tables[0][1]
    head = struct.pack("<4sIQII", magic, flags | (not single), count, len(text), 0) + text
    parts = [head, bytes(-len(head) % 8)]
    for table, width in tables:
        for k in range(width):
            column = table.flat[k::width]
            parts.append(struct.pack(f"<{count}d", *column) if isinstance(column, list) else
                         numpy.ascontiguousarray(column, "<f4" if single else "<f8"))
    return b"".join(parts)


def _ray_text(rays: _Rays, options: dict) -> bytes:
    """A request as JSON."""
    body = {**options, "origins": _list(rays.origins), "directions": _list(rays.directions)}
    if rays.tmin is not None:
        body["tmin"] = _list(rays.tmin)
    if rays.tmax is not None:
        body["tmax"] = [None if x == math.inf else x for x in _list(rays.tmax)]
    return _text(body)


def _list(table: _Numbers) -> list:
    return table.flat if isinstance(table.flat, list) else table.flat.tolist()


def _rows(name: str, value: Any) -> list:
    """Points for JSON."""
    flat = _list(_allow(_points(name, value, images=False)))
    return [flat[i:i + 3] for i in range(0, len(flat), 3)]


def _id_triples(ids: Any) -> list:
    """Exact integers of shape (n, 3)."""
    if isinstance(ids, (list, tuple)) and not ids:
        return []
    shape = _numbers("ids", ids).shape
    if len(shape) != 2 or shape[1] != 3:
        raise ValueError(f"ids has shape {shape}: expected (n, 3)")
    if numpy is not None and hasattr(ids, "__array__"):
        ids = numpy.asarray(ids)
        if ids.dtype.kind == "f":
            raise ValueError(f"ids has dtype {ids.dtype}: expected integers")
    for i, row in enumerate(ids):
        if not all(isinstance(x, numbers.Integral) for x in row):
            raise ValueError(f"ids[{i}] is {row!r}: expected integers")
    return list(ids)


def _pixels(generator: Mapping) -> tuple | None:
    """The shape of a picture, None for rays in a row."""
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


# From answers to columns.


def _unpack(body: bytes) -> dict:
    """The columns of an answer of docs/reference/binary.md, flat."""
    magic, count = struct.unpack_from("<4sI", body)
    if magic != b"SLA1":
        raise RuntimeError("the answer does not begin with SLA1")
    columns = {}
    for i in range(count):
        name, kind, width, at, rows = struct.unpack_from("<16sIIQQ", body, 16 + 40 * i)
        name = name.rstrip(b"\0").decode()
        letter, dtype = _TYPES[kind]
        if numpy is not None:
            column = numpy.frombuffer(body, dtype, rows * width, at)
            if kind == 2:
                columns[name] = numpy.where(column == _NONE, -1, column.astype("int64"))
            else:
                columns[name] = column == 1 if name in _FLAGS else column.astype(column.dtype.newbyteorder("="))
            continue
        column = list(struct.unpack_from(f"<{rows * width}{letter}", body, at))
        if kind == 2:
            column = [-1 if number == _NONE else number for number in column]
        columns[name] = [number == 1 for number in column] if name in _FLAGS else column
    return columns


def _from_json(answer: dict) -> dict:
    """The columns of an answer as JSON, flat and as _unpack() gives them."""
    rays = len(answer.get("totals", answer["instance"]))
    columns = {}
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
        elif name in _WIDTHS or name in _DISTANCES:
            none = math.inf if name in _DISTANCES else math.nan
            columns[name] = _column([none if value is None else float(value) for value in values], "float64")
        else:
            columns[name] = _column(values, "int64")
    return columns


def _column(values: list, dtype: str):
    return values if numpy is None else numpy.array(values, dtype)


def _finish(columns: dict, fields: Sequence[str], lead: tuple | None, lists: bool) -> dict:
    """Adds `hit` and gives the columns their shapes. `lists`: a ray has any number of rows."""
    if "instance" in columns:
        ids = columns["instance"]
        columns["hit"] = [each >= 0 for each in ids] if isinstance(ids, list) else ids >= 0
        if "instance" not in fields:
            del columns["instance"]
    for name in columns.keys() - _REMARKS:
        column, width = columns[name], _WIDTHS.get(name, 1)
        by_ray = lead is not None and (not lists or name in ("totals", "invalid"))
        shape = (lead if by_ray else (len(column) // width,)) + ((width,) if width > 1 else ())
        if len(column) != math.prod(shape):
            raise RuntimeError(f"the answer has {len(column)} numbers in column {name}: expected shape {shape}")
        columns[name] = _nest(column, shape) if isinstance(column, list) else column.reshape(shape)
    return columns


def _nest(values: list, shape: tuple) -> list:
    """As numpy's reshape()."""
    if len(shape) == 1:
        return values
    size = math.prod(shape[1:])
    return [_nest(values[i * size:(i + 1) * size], shape[1:]) for i in range(shape[0])]
