"""Answers a file of rays in slices, by processes of this machine or by a Dask cluster: docs/guides/bulk.md.

    python -m sightline bulk rays.npy --scene town --out hits.npy

`answer` is the part for other engines: a function of an array of rays.
"""

from __future__ import annotations

import argparse
import collections
import concurrent.futures
import functools
import importlib
import io
import json
import multiprocessing
import multiprocessing.connection
import os
import signal
import socket
import sys
import tempfile
import threading
import time
import zipfile
from pathlib import Path
from typing import Any, Callable, Iterator, NamedTuple, Sequence

import sightline

numpy: Any = sightline.numpy
# Rows of a slice: a task, and an entry of the manifest.
_SLICE = 262_144
# Rows of a group of a Parquet or Arrow file. It does not follow the slice, so that the bytes of the file do not.
_GROUP = 1 << 20
# Seconds between two writes of the manifest.
_SAVES = 2.0
# Workers that end in a row without an answered slice.
_MOST_LOSSES = 20
_KINDS = ("closest", "any", "count")
_RENAMED = {"hits": "hit", "counts": "count"}
_ARROW = (".parquet", ".arrow")
# Of requests. Pages of new memory cost more than the copy into them.
_BUFFERS: list[bytearray] = []


class BulkError(Exception):
    """A run that cannot begin or go on. What is done stays done."""


class Question(NamedTuple):
    """What is asked of each ray, and where."""

    servers: tuple[str, ...]
    scene: str
    kind: str = "closest"
    fields: tuple[str, ...] = ("t", "instance", "primitive", "triangle")
    options: str = "{}"  # Further keys of the request, as JSON.
    key: str | None = None
    patience: float = 120


class Rays(NamedTuple):
    """A file of rays. Its size and time tell whether it is the file that a run began with."""

    path: str
    size: int
    mtime_ns: int

    @classmethod
    def of(cls, path: str | Path) -> Rays:
        state = os.stat(path)
        return cls(os.path.abspath(path), state.st_size, state.st_mtime_ns)


@functools.lru_cache(maxsize=4)
def _client(servers: tuple[str, ...], key: str | None, patience: float) -> sightline.Sightline:
    """One for each process: its connections are reused."""
    return sightline.Sightline(servers, key=key, patience=patience, spread=True)


@functools.lru_cache(maxsize=2)
def _mapped(rays: Rays) -> Any:
    if Rays.of(rays.path) != rays:
        raise BulkError(f"{rays.path} has changed since the run began")
    table = numpy.load(rays.path, mmap_mode="r")
    if table.ndim != 2 or table.shape[1] not in (6, 8) or table.dtype.kind != "f":
        raise BulkError(f"{rays.path} has shape {table.shape} and type {table.dtype}: expected floats of shape (n, 6), origins and "
                        "directions, or (n, 8), with tmin and tmax")
    return table


def answer(question: Question, rays: Any) -> tuple[Any, int]:
    """A structured array with a row for each ray of shape (n, 6) or (n, 8), and the revision of the scene that gave it."""
    client = _client(question.servers, question.key, question.patience)
    options = json.loads(question.options)
    if question.kind == "closest":
        options = sightline._fields({**options, "fields": question.fields})[1]
    path, count = client._scene(question.scene, f"/rays:{question.kind}"), len(rays)

    def ask(first: int, last: int) -> Callable[[], tuple]:
        def call() -> tuple:
            buffer, size = _packed(rays[first:last], options, first)
            try:
                columns, revision = client._columns(path, memoryview(buffer)[:size], sightline._BYTES)
            except sightline.SightlineError as error:
                raise sightline._moved(error, first) from None
            finally:
                _BUFFERS.append(buffer)
            return sightline._finish(columns, question.fields, (last - first,), lists=False), revision, first, last
        return call
    table, revisions = None, set()
    for columns, revision, first, last in sightline._ahead(ask(i, min(i + sightline._SLICE, count)) for i in range(0, max(count, 1), sightline._SLICE)):
        columns = {_RENAMED.get(name, name): column for name, column in columns.items() if name not in sightline._REMARKS}
        if table is None:
            table = numpy.empty(count, [(name, column.dtype.newbyteorder("<"), column.shape[1:]) for name, column in columns.items()])
        for name, column in columns.items():
            table[name][first:last] = column
        revisions.add(int(revision))
    if len(revisions) > 1:
        raise BulkError(f"the scene has changed from revision {min(revisions)} to {max(revisions)}")
    return table, revisions.pop()


def _packed(rays: Any, options: dict, first: int) -> tuple[bytearray, int]:
    """A request of docs/reference/binary.md, in the first bytes of a buffer. Faster than that of any shapes: one copy from rows
    to columns."""
    single, (count, width) = rays.dtype.itemsize <= 4, rays.shape
    # Bit 0: float64; bits 1 and 2: tmin and tmax.
    head = sightline._head(b"SLR1", (not single) | (6 if width == 8 else 0), count, options)
    size = len(head) + count * width * (4 if single else 8)
    buffer = _BUFFERS.pop() if _BUFFERS else bytearray()
    if len(buffer) < size:
        buffer = bytearray(size)
    buffer[:len(head)] = head
    columns = numpy.frombuffer(buffer, "<f4" if single else "<f8", count * width, len(head)).reshape(width, count)
    numpy.copyto(columns, rays.T)
    finite = numpy.isfinite(columns[:6]).all() and not numpy.isnan(columns[6:]).any()
    if not finite and options.get("on_invalid") != "mark":
        bad = ~numpy.isfinite(columns[:6]).all(axis=0) | numpy.isnan(columns[6:]).any(axis=0)
        raise ValueError(f"ray {first + int(bad.argmax())} of them has a number that is not finite")
    return buffer, size


class _Target(NamedTuple):
    """The file of the output, for workers that see it."""

    path: str
    inode: int
    size: int
    start: int
    width: int  # Bytes of a row.
    revision: int
    host: str

    def is_seen(self) -> bool:
        state = os.stat(self.path)
        return (state.st_ino, state.st_size) == (self.inode, self.size)

    def write(self, first: int, rows: Any) -> None:
        with open(self.path, "r+b", 0) as file:
            state = os.fstat(file.fileno())
            if (state.st_ino, state.st_size) != (self.inode, self.size):
                raise BulkError(f"{self.path} is the output of another run")
            _write(file.fileno(), self.start + first * self.width, rows)
            if socket.gethostname() != self.host:  # The run's own machine cannot flush what this one holds.
                os.fsync(file.fileno())


def _write(file: int, at: int, rows: Any) -> None:
    left = memoryview(rows)
    while left:
        done = os.pwrite(file, left, at)
        at, left = at + done, left[done:]


def _answer_slice(question: Question, rays: Rays, first: int, last: int, sent: Any, target: _Target | None) -> tuple[Any, int]:
    """In a worker: answers some rows, and writes them to the target, or returns their bytes as an array. `sent` are the rays, for
    a worker that does not see the file."""
    part = sent if sent is not None else _mapped(rays)[first:last]
    try:
        table, revision = answer(question, part)
    except sightline.SightlineError as error:
        raise sightline._moved(error, first) from None
    except ValueError as error:
        raise BulkError(f"rows {first} to {last - 1}: {error}") from None
    if target is None:
        return table.view("u1"), revision
    if revision == target.revision:
        target.write(first, table.view("u1"))
    return None, revision


class _Manifest:
    """What a run is of, and which of its slices are in the output."""

    def __init__(self, path: Path, run: dict, slices: int):
        self.path, self.run, self.done = path, run, [False] * slices
        self._saved = time.monotonic()

    def resume(self) -> None:
        """Takes what is done from the file; refuses that of another run."""
        written = json.loads(self.path.read_text(encoding="utf-8"))
        other = [f"{name} is {json.dumps(written.get(name))} there and {json.dumps(value)} now" for name, value in self.run.items()
                 if written.get(name) != value]
        if other:
            raise BulkError(f"{self.path} is of another run: {'; '.join(other)}. Remove it to begin anew")
        for first, last in written["done"]:
            self.done[first:last] = [True] * (last - first)

    def save(self, flush: Callable[[], None], now: bool = False) -> None:
        """After `flush`, so that what the manifest names is on the disk."""
        if not now and time.monotonic() < self._saved + _SAVES:
            return
        flush()
        text = json.dumps({**self.run, "done": list(self._ranges())}, indent=1)
        temporary = self.path.with_name(self.path.name + ".new")
        temporary.write_text(text + "\n", encoding="utf-8")
        os.replace(temporary, self.path)
        self._saved = time.monotonic()

    def _ranges(self) -> Iterator[list[int]]:
        first = None
        for i, done in enumerate([*self.done, False]):
            if done and first is None:
                first = i
            elif not done and first is not None:
                yield [first, i]
                first = None


class _Output:
    """The rows of a .npy file, written in any order."""

    def __init__(self, path: Path, dtype: Any, rows: int, begun: bool, revision: int):
        if not begun:  # A worker of an ended run may still write to the file that was there.
            path.unlink(missing_ok=True)
        head = io.BytesIO()
        numpy.lib.format.write_array_header_1_0(
            head, {"descr": numpy.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": (rows,)})
        self._file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        start = len(head.getvalue())
        size = start + rows * dtype.itemsize
        if begun and (os.fstat(self._file).st_size != size or os.pread(self._file, start, 0) != head.getvalue()):
            raise BulkError(f"{path} is not the output that its manifest names. Remove both to begin anew")
        os.pwrite(self._file, head.getvalue(), 0)
        os.ftruncate(self._file, size)
        self.target = _Target(os.path.abspath(path), os.fstat(self._file).st_ino, size, start, dtype.itemsize, revision, socket.gethostname())

    def write(self, first: int, rows: Any) -> None:
        _write(self._file, self.target.start + first * self.target.width, rows)

    def flush(self) -> None:
        os.fsync(self._file)

    def close(self) -> None:
        os.close(self._file)


# Workers.


class _Local:
    """Processes of this machine, or with workers=0 this process."""

    def __init__(self, workers: int, target: _Target):
        self._workers, self._target = workers, target
        self._pool = self._begin()

    def _begin(self) -> concurrent.futures.Executor:
        if self._workers == 0:
            return concurrent.futures.ThreadPoolExecutor(1)
        # Forked processes would share the parent's connections.
        return concurrent.futures.ProcessPoolExecutor(self._workers, multiprocessing.get_context("spawn"), _follow_parent)

    def most(self) -> int:
        return 2 * max(1, self._workers)

    def submit(self, question: Question, rays: Rays, first: int, last: int) -> concurrent.futures.Future:
        call = (question, rays, first, last, None, self._target)
        try:
            return self._pool.submit(_answer_slice, *call)
        except concurrent.futures.BrokenExecutor:
            self._pool.shutdown(wait=False)
            self._pool = self._begin()
            return self._pool.submit(_answer_slice, *call)

    def is_lost(self, error: BaseException) -> bool:
        return isinstance(error, (concurrent.futures.BrokenExecutor, concurrent.futures.CancelledError))

    def close(self) -> None:
        self._pool.shutdown(wait=True, cancel_futures=True)


def _follow_parent() -> None:
    """A worker ends with its parent, which alone is interrupted by the keyboard."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None
    ends = [parent.sentinel]

    def follow() -> None:
        multiprocessing.connection.wait(ends)
        os._exit(1)
    threading.Thread(target=follow, daemon=True).start()


class _Dask:
    """The workers of a Dask cluster. They need numpy; this module goes with the run."""

    def __init__(self, address: str, rays: Rays, target: _Target):
        distributed = importlib.import_module("distributed")
        self._client = distributed.Client(address, direct_to_workers=True)
        with tempfile.TemporaryDirectory() as folder:
            # A name for each run: a worker that starts writes the archives of all runs at once, and reads one while another of its
            # name is written.
            package = Path(folder, f"{Path(folder).name}.zip")
            with zipfile.ZipFile(package, "w") as archive:
                for module in (sightline, sys.modules[__name__]):
                    archive.write(str(module.__file__), f"{getattr(module, '__spec__').name}.py")
            self._client.upload_file(str(package))
        self._reads = all(self._client.run(_sees, rays, None).values())
        self._target = target if all(self._client.run(_sees, None, target).values()) else None
        self._pool = self._client.get_executor(pure=False)

    def most(self) -> int:
        return 2 + 2 * sum(self._client.nthreads().values())

    def submit(self, question: Question, rays: Rays, first: int, last: int) -> concurrent.futures.Future:
        sent = None if self._reads else numpy.array(_mapped(rays)[first:last])
        return self._pool.submit(_answer_slice, question, rays, first, last, sent, self._target)

    def is_lost(self, error: BaseException) -> bool:
        return isinstance(error, concurrent.futures.CancelledError) or type(error).__name__ in ("KilledWorker", "CommClosedError")

    def close(self) -> None:
        self._client.close()


def _sees(rays: Rays | None, target: _Target | None) -> bool:
    """Whether a worker has the file at the same path."""
    try:
        return (rays is None or Rays.of(rays.path) == rays) and (target is None or target.is_seen())
    except OSError:
        return False


# A run.


def bulk(rays_file: str | Path, out: str | Path, question: Question, rows_of_slice: int = _SLICE, workers: int | None = None,
         dask: str | None = None, progress: sightline.Progress = None) -> dict:
    """Writes the answers to all rays of a file. Returns `rows`, the number of rows that were `answered` by this run, its
    `seconds`, and how many slices were `repeated` after the loss of a worker.

    `workers`: processes of this machine (by default one for each processor, 4 at most), 0 is this process. `dask`: the address of
    a scheduler. A run that was ended goes on where its manifest says. Its bytes do not depend on the slices and the workers."""
    if numpy is None:
        raise BulkError("bulk needs numpy")
    out = Path(out)
    if out.suffix not in (".npy", *_ARROW):
        raise BulkError(f"{out}: expected a name that ends in .npy, .parquet or .arrow")
    if out.suffix in _ARROW:
        _arrow()
    if question.kind not in _KINDS:
        raise BulkError(f"kind is {question.kind!r}: expected {', '.join(_KINDS)}")
    texts = sightline.TEXTS.intersection(question.fields)
    if texts:
        raise BulkError(f"{', '.join(sorted(texts))}: texts have no fixed size. Ask for ids, such as node_id")
    rays = Rays.of(rays_file)
    count = len(_mapped(rays))
    # A ray of its own tells the types of the columns and the revision, before anything is written.
    sample, revision = answer(question, numpy.array([[0.0, 0, 0, 1, 0, 0]]))
    sha256 = _client(question.servers, question.key, question.patience).scene(question.scene, wait=question.patience)["sha256"]
    run = {"format": 1, "rays": {"size": rays.size, "mtime_ns": rays.mtime_ns, "rows": count},
           "scene": question.scene, "sha256": sha256, "revision": revision, "kind": question.kind, "fields": list(sample.dtype.names), "options": json.loads(question.options), "slice": rows_of_slice,
           "out": out.name}
    manifest = _Manifest(out.with_name(out.name + ".manifest.json"), run, -(-count // rows_of_slice))
    partial = out.with_name(out.name + ".partial")
    begun = manifest.path.exists()
    if begun:
        manifest.resume()
    begin, repeated = time.monotonic(), 0
    left = sum(min(rows_of_slice, count - i * rows_of_slice) for i, done in enumerate(manifest.done) if not done)
    if not (begun and all(manifest.done) and out.exists() and not partial.exists()):
        output = _Output(partial, sample.dtype, count, begun, revision)
        try:
            manifest.save(output.flush, now=True)
            with sightline._Report(progress, count) as report:
                pool: _Local | _Dask
                pool = (_Dask(dask, rays, output.target) if dask else
                        _Local(min(4, os.cpu_count() or 1) if workers is None else workers, output.target))
                try:
                    repeated = _answer_all(pool, question, rays, manifest, output, report, count - left)
                finally:
                    pool.close()
            if Rays.of(rays_file) != rays:
                raise BulkError(f"{rays.path} has changed since the run began")
        finally:
            manifest.save(output.flush, now=True)
            output.close()
        if out.suffix in _ARROW:
            _write_arrow(partial, out)
            os.remove(partial)
        else:
            os.replace(partial, out)
    return {"rows": count, "answered": left, "seconds": time.monotonic() - begin, "repeated": repeated}


def _answer_all(pool: _Local | _Dask, question: Question, rays: Rays, manifest: _Manifest, output: _Output,
                report: sightline._Report, rows: int) -> int:
    """Answers the slices that are not done, and returns how many were answered again. `rows` are done."""
    size, count = manifest.run["slice"], manifest.run["rays"]["rows"]
    waiting = collections.deque(i for i, done in enumerate(manifest.done) if not done)
    under_way: dict[concurrent.futures.Future, int] = {}
    repeated = losses = 0
    report(rows)
    try:
        while waiting or under_way:
            for _ in range(min(len(waiting), max(0, pool.most() - len(under_way)))):
                i = waiting.popleft()
                under_way[pool.submit(question, rays, i * size, min((i + 1) * size, count))] = i
            for future in concurrent.futures.wait(under_way, 60, concurrent.futures.FIRST_COMPLETED).done:
                i = under_way.pop(future)
                try:
                    answered, revision = future.result()
                except BaseException as error:
                    if not pool.is_lost(error) or losses == _MOST_LOSSES:
                        raise
                    waiting.appendleft(i)
                    repeated, losses = repeated + 1, losses + 1
                    continue
                if revision != manifest.run["revision"]:
                    raise BulkError(f"the scene has changed: the run began with revision {manifest.run['revision']}, an answer is of "
                                    f"revision {revision}. Remove {manifest.path} to begin anew")
                if answered is not None:
                    output.write(i * size, answered)
                manifest.done[i], losses = True, 0
                manifest.save(output.flush)
                rows += min(size, count - i * size)
                report(rows)
    finally:
        for future in under_way:
            future.cancel()
    return repeated


# Arrow and Parquet.


def _arrow() -> Any:
    try:
        return importlib.import_module("pyarrow")
    except ImportError:
        raise BulkError("files of Parquet and Arrow need pyarrow, which is not installed: write a .npy file") from None


def _write_arrow(partial: Path, out: Path) -> None:
    pyarrow = _arrow()
    table = numpy.load(partial, mmap_mode="r")

    def column(values: Any) -> Any:
        flat = pyarrow.array(numpy.ascontiguousarray(values).reshape(-1))
        return flat if values.ndim == 1 else pyarrow.FixedSizeListArray.from_arrays(flat, values.shape[1])

    def batch(rows: Any) -> Any:
        return pyarrow.RecordBatch.from_arrays([column(rows[name]) for name in table.dtype.names], list(table.dtype.names))
    schema = batch(table[:0]).schema
    temporary = out.with_name(out.name + ".new")
    if out.suffix == ".parquet":
        writer = importlib.import_module("pyarrow.parquet").ParquetWriter(str(temporary), schema)
    else:
        writer = pyarrow.ipc.new_file(str(temporary), schema)
    with writer:
        for first in range(0, len(table), _GROUP):
            writer.write_batch(batch(table[first:first + _GROUP]))
    os.replace(temporary, out)


# The command.


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m sightline bulk", description="Answers a file of rays. A run that was ended goes on "
                                     "when it is started again.")
    parser.add_argument("rays", help=".npy file of floats, shape (n, 6): origins and directions, or (n, 8): with tmin and tmax")
    parser.add_argument("--scene", required=True)
    parser.add_argument("--out", required=True, help=".npy, or with pyarrow .parquet or .arrow")
    parser.add_argument("--server", action="append", metavar="URL", help="default: http://127.0.0.1:8080; repeated for replicas of one origin")
    parser.add_argument("--kind", choices=_KINDS, default="closest")
    parser.add_argument("--field", action="append", metavar="NAME", help="of closest; default: t, instance, primitive, triangle")
    parser.add_argument("--options", default="{}", metavar="JSON", help='further keys of the request, such as {"cull":"back"}')
    parser.add_argument("--slice", type=int, default=_SLICE, metavar="ROWS", help="rows of a task, default: %(default)s")
    parser.add_argument("--workers", type=int, metavar="N", help="processes; default: one for each processor, 4 at most; 0: this process")
    parser.add_argument("--dask", metavar="ADDRESS", help="scheduler of a Dask cluster, such as tcp://scheduler:8786")
    parser.add_argument("--key-file", metavar="FILE", help="file with the key; default: $SIGHTLINE_KEY, if it is set")
    parser.add_argument("--patience", type=float, default=120, metavar="SECONDS", help="how long a request is repeated, default: %(default)s")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    given = parser.parse_args(arguments)
    if given.slice < 1 or (given.workers or 0) < 0:
        parser.error("--slice is at least 1, --workers at least 0")
    try:
        key = Path(given.key_file).read_text(encoding="ascii").strip() if given.key_file else os.environ.get("SIGHTLINE_KEY")
        question = Question(tuple(given.server or ["http://127.0.0.1:8080"]), given.scene, given.kind,
                            tuple(given.field or Question._field_defaults["fields"]), json.dumps(json.loads(given.options), sort_keys=True),
                            key, given.patience)
        done = bulk(given.rays, given.out, question, given.slice, given.workers, given.dask, None if given.quiet else True)
    except (BulkError, sightline.SightlineError, OSError, ValueError) as error:
        print(f"sightline bulk: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("sightline bulk: interrupted; start it again to go on", file=sys.stderr)
        return 130
    rate = done["answered"] / max(done["seconds"], 1e-9)
    print(f"{given.out}: {done['rows']} rows, of which {done['answered']} were answered now, {done['seconds']:.1f} s, {rate:.0f} rows/s, "
          f"{done['repeated']} slices repeated")
    return 0
