"""Rays that are answered while they are still being sent: order, faults, coding, memory."""

import ctypes
import ctypes.util
import gzip
import json
import os
import random
import socket
import struct
import threading
import time
import unittest
from array import array

import case_report
from process_status import is_sanitized
from sightline_server import PATIENCE, Server, demo_glb

LINES, BYTES = "application/x-ndjson", "application/octet-stream"
HIT = {"origin": [-10, 1, 0], "direction": [1, 0, 0]}
MISS = {"origin": [-10, 50, 0], "direction": [1, 0, 0]}


class Zstd:
    """The library itself: Python 3.11 has none."""

    def __init__(self):
        self.library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
        self.library.ZSTD_compress.restype = self.library.ZSTD_decompress.restype = ctypes.c_size_t
        for function in (self.library.ZSTD_compress, self.library.ZSTD_decompress):
            function.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t] + [ctypes.c_int] * (function is self.library.ZSTD_compress)

    def compress(self, data):
        room = ctypes.create_string_buffer(len(data) + 1024)
        size = self.library.ZSTD_compress(room, len(room), data, len(data), 3)
        return room.raw[:size]

    def decompress(self, data):
        room = ctypes.create_string_buffer(64 << 20)
        size = self.library.ZSTD_decompress(room, len(room), data, len(data))
        assert not self.library.ZSTD_isError(ctypes.c_size_t(size))
        return room.raw[:size]


def lines(*rays, **options):
    text = [json.dumps({"options": options})] if options else []
    return "".join(line + "\n" for line in text + [ray if isinstance(ray, str) else json.dumps(ray) for ray in rays])


def frame(origins, directions, **options):
    text = json.dumps(options).encode() if options else b""
    body = struct.pack("<4sIQII", b"SLR1", 1, len(origins), len(text), 0) + text
    body += bytes(-len(body) % 8)
    for points in (origins, directions):
        for k in range(3):
            body += struct.pack(f"<{len(points)}d", *(point[k] for point in points))
    return struct.pack("<Q", len(body)) + body


def frames(*some):
    return b"SLS1\0\0\0\0" + b"".join(some)


def answers_in(stream):
    assert stream[:8] == b"SLS1\0\0\0\0", stream[:80]
    at, found = 8, []
    while at < len(stream):
        size, = struct.unpack_from("<Q", stream, at)
        found.append(stream[at + 8:at + 8 + size])
        at += 8 + size
    assert at == len(stream)
    return found


def column(answer, name):
    """Numbers of one column of an answer in bytes."""
    for i in range(struct.unpack_from("<4sI", answer)[1]):
        its, kind, width, at, rows = struct.unpack_from("<16sIIQQ", answer, 16 + 40 * i)
        if its.rstrip(b"\0").decode() == name:
            return list(struct.unpack_from(f"<{rows * width}{' dIBQq'[kind]}", answer, at))
    raise KeyError(name)


class Stream:
    """A request on a socket of its own, chunk by chunk, read line by line."""

    def __init__(self, server, kind, media_type, scene="six"):
        self.socket = socket.create_connection(("127.0.0.1", server.port), timeout=PATIENCE)
        self.socket.sendall(f"POST /v1/scenes/{scene}/rays:{kind} HTTP/1.1\r\nHost: a\r\nContent-Type: {media_type}\r\n"
                            "Transfer-Encoding: chunked\r\n\r\n".encode())
        self.file = self.socket.makefile("rb")
        self.status, self.pending = None, b""

    def send(self, data):
        data = data.encode() if isinstance(data, str) else data
        if data:
            self.socket.sendall(f"{len(data):x}\r\n".encode() + data + b"\r\n")

    def finish(self):
        self.socket.sendall(b"0\r\n\r\n")

    def read(self, size):
        """At least that many bytes of the answer, or all that is left."""
        if self.status is None:
            self.status = int(self.file.readline().split()[1])
            while self.file.readline().strip():
                pass
        while len(self.pending) < size:
            length = int(self.file.readline(), 16)
            self.pending += self.file.read(length)
            self.file.readline()
            if length == 0:
                break
        data, self.pending = self.pending[:size], self.pending[size:]
        return data

    def line(self):
        text = b""
        while not text.endswith(b"\n") and (one := self.read(1)):
            text += one
        return json.loads(text) if text else None

    def close(self):
        self.file.close()
        self.socket.close()


class Streams(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town")
        cls.addClassCleanup(cls.server.end)

    def post(self, kind, body, media_type=LINES, *more, scene="six"):
        return self.server.ask(f"/v1/scenes/{scene}/rays:{kind}", "-H", f"Content-Type: {media_type}", *more, body=body)

    def ask(self, kind, *rays, **options):
        answer = self.post(kind, lines(*rays, **options))
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, LINES), answer.body)
        return [json.loads(line) for line in answer.body.splitlines()]

    def test_a_line_for_each_ray(self):
        self.assertEqual(self.ask("closest", HIT, MISS, fields=["t", "node"]), [{"t": 4.5, "node": "left"}, None])
        self.assertEqual(self.ask("any", HIT, MISS, HIT), [True, False, True])
        self.assertEqual(self.ask("count", HIT, MISS, {**HIT, "tmax": 8}), [6, 0, 2])
        self.assertEqual(self.ask("all", HIT, max_hits=1, fields=["t"]), [{"total": 6, "hits": [{"t": 4.5}]}])
        self.assertEqual(self.ask("any"), [])
        self.assertEqual(self.ask("any", "", "  \r", HIT, ""), [True])
        self.assertEqual(self.post("any", lines(HIT), LINES.upper()).body, b"true\n")
        self.assertEqual(self.post("any", json.dumps(HIT)).body, b"true\n")  # the last line may lack its end

    def test_bad_rays_are_marked(self):
        got = self.ask("any", HIT, {**HIT, "direction": [0, 0, 0]}, MISS, on_invalid="mark")
        self.assertEqual(got, [True, {"invalid": "RAY_DIRECTION_ZERO"}, False])

    def test_a_fault_in_the_first_batch_is_a_problem(self):
        for body, code, pointer in [(lines(HIT, {"origin": [1, 2, 3]}), "KEY_MISSING", "/rays/1"),
                                    (lines(HIT, {**HIT, "direction": [0, 0, 0]}), "RAY_DIRECTION_ZERO", "/rays/1/direction"),
                                    (lines(HIT, MISS, colour=1), "KEY_UNKNOWN", "/colour"),
                                    (lines(HIT) + '{"options":{}}\n', "KEY_UNKNOWN", "/rays/1/options")]:
            answer = self.post("any", body)
            self.assertEqual((answer.status, answer.json()["code"]), (422, code), answer.body)
            self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)
        # A line is one object, whole and alone.
        ray = json.dumps(HIT)
        for body in (ray + ray, ray + "," + ray, ray[:20] + "\n" + ray[20:], "[" + ray + "]", ray + "]", "7", ray + '],"fields":["t"'):
            answer = self.post("any", lines(HIT) + body)
            self.assertIn((answer.status, answer.json()["code"]), [(400, "JSON_MALFORMED"), (422, "TYPE_WRONG")], body)
        self.assertEqual(self.post("any", "x" * 300000).json()["code"], "LINE_TOO_LONG")
        # However much comes together.
        for blanks, good in ((65_000, True), (65_600, False), (130_000, False)):
            for text in (lines(" " * blanks + ray), lines(HIT, " " * blanks + ray, HIT), lines(HIT) + " " * blanks + ray):
                answer = self.post("any", text)
                # The first ray may be answered before the rest of a long body has come: then the fault is the last line.
                told = json.loads(answer.body.splitlines()[-1])
                self.assertEqual(told["code"] if isinstance(told, dict) else answer.status, 200 if good else "LINE_TOO_LONG",
                                 (blanks, len(text)))
        self.assertEqual(self.server.query("none", "any", "{}").json()["code"], "SCENE_NOT_FOUND")

    def test_a_stream_that_has_begun_is_not_told_to_go_on(self):
        ray = frame([HIT["origin"]], [HIT["direction"]])
        chunk = lambda data: b"%x\r\n%s\r\n" % (len(data), data)
        with self.server.connect() as connection:
            connection.sendall(b"POST /v1/scenes/six/rays:count HTTP/1.1\r\nHost: x\r\nContent-Type: application/octet-stream\r\nConnection: close\r\n"
                               b"Expect: 100-continue\r\nTransfer-Encoding: chunked\r\n\r\n" + chunk(frames(ray)))
            begin = b""
            while begin.count(b"SLC1") == 0 and b"\r\n\r\n" not in begin:
                begin += connection.recv(65536)
            connection.sendall(chunk(ray) + b"0\r\n\r\n")
            text = begin + b"".join(iter(lambda: connection.recv(65536), b""))
        self.assertTrue(text.startswith(b"HTTP/1.1 200 "), text[:60])
        self.assertNotIn(b"100 Continue", text)

    def test_answers_come_while_rays_are_sent(self):
        stream = Stream(self.server, "closest", LINES)
        self.addCleanup(stream.close)
        stream.send(lines(fields=["t"]))
        for i in range(50):
            stream.send(lines({"origin": [-10 - i, 1, 0], "direction": [1, 0, 0]}))
            self.assertEqual(stream.line(), {"t": 4.5 + i})
        # A fault is the last line; what came before stays.
        stream.send(lines(HIT)[:10])
        stream.send(lines(HIT)[10:] + lines({"origin": 1}))
        problem = stream.line()
        if "code" not in problem:
            self.assertEqual(problem, {"t": 4.5})
            problem = stream.line()
        self.assertEqual((problem["code"], problem["errors"][0]["pointer"]), ("TYPE_WRONG", "/rays/51/origin"))
        self.assertIsNone(stream.line())

    def test_frames_are_answered_in_order(self):
        body = frames(frame([(-10, 1, 0)], [(1, 0, 0)], fields=["t"]), frame([(-11, 1, 0), (-11, 50, 0)], [(1, 0, 0)] * 2),
                      frame([], []))
        answer = self.post("closest", body, BYTES)
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, BYTES), answer.body)
        self.assertEqual([column(one, "t") for one in answers_in(answer.body)], [[4.5], [5.5, float("inf")], []])
        self.assertEqual(answers_in(self.post("any", frames(), BYTES).body), [])
        stream = Stream(self.server, "count", BYTES)
        self.addCleanup(stream.close)
        stream.send(frames()[:3])
        stream.send(frames()[3:])
        for i in range(20):
            whole = frame([(-10 + i, 1, 0)] * (i + 1), [(1, 0, 0)] * (i + 1))
            stream.send(whole[:7])
            stream.send(whole[7:])
            if i == 0:
                self.assertEqual(stream.read(8), frames())
            size, = struct.unpack("<Q", stream.read(8))
            self.assertEqual(len(column(stream.read(size), "counts")), i + 1)
        stream.finish()
        self.assertEqual(stream.read(1), b"")

    def test_faults_of_frames(self):
        good = frame([(-10, 1, 0)], [(1, 0, 0)])
        for body, status, code in [(b"SLS1\0\0\0\1" + good, 400, "BINARY_MALFORMED"), (frames(good)[:-1], 400, "BODY_INCOMPLETE"),
                                   (frames(struct.pack("<Q", 1 << 40)), 413, "FRAME_TOO_LARGE"), (b"SLS1", 400, "BINARY_MALFORMED"),
                                   (frames(frame([(0, 0, 0)], [(0, 0, 0)])), 422, "RAY_DIRECTION_ZERO")]:
            answer = self.post("any", body, BYTES)
            self.assertEqual((answer.status, answer.json()["code"]), (status, code))
        later = answers_in(self.post("any", frames(good, frame([(0, 0, 0)], [(0, 0, 0)])), BYTES).body)
        self.assertEqual(column(later[0], "hits"), [1])
        self.assertEqual(json.loads(later[1])["code"], "RAY_DIRECTION_ZERO")

    def test_random_streams_say_what_one_request_says(self):
        source = random.Random(86)
        print("seed 86")
        rays = [{"origin": [source.uniform(-300, 300), 60, source.uniform(-300, 300)],
                 "direction": [source.uniform(-1, 1), -1, source.uniform(-1, 1)]} for _ in range(20000)]
        fields = ["t", "instance", "triangle"]
        plain = self.server.query("town", "closest", {"rays": rays, "fields": fields}).json()["hits"]
        text = lines(*rays, fields=fields)
        self.assertEqual([json.loads(line) for line in self.post("closest", text, scene="town").body.splitlines()], plain)
        parts = [rays[at:at + 700] for at in range(0, len(rays), 700)]
        body = frames(*(frame([ray["origin"] for ray in part], [ray["direction"] for ray in part], **({"fields": fields} if i == 0 else {}))
                        for i, part in enumerate(parts)))
        times = [t for one in answers_in(self.post("closest", body, BYTES, scene="town").body) for t in column(one, "t")]
        self.assertEqual(times, [hit["t"] if hit else float("inf") for hit in plain])
        # The same, compressed both ways.
        zstd = Zstd()
        for coding, compress, decompress in (("gzip", gzip.compress, gzip.decompress), ("zstd", zstd.compress, zstd.decompress)):
            more = ("-H", f"Content-Encoding: {coding}")
            got = self.post("closest", compress(text.encode()), LINES, *more, scene="town")
            self.assertEqual([json.loads(line) for line in got.body.splitlines()], plain)
            got = self.post("closest", compress(json.dumps({"rays": rays, "fields": fields}).encode()), "application/json", *more,
                            "-H", f"Accept-Encoding: {coding}", scene="town")
            self.assertEqual((got.headers["content-encoding"], got.headers["vary"]), (coding, "Accept-Encoding"))
            self.assertEqual(json.loads(decompress(got.body))["hits"], plain)
        got = self.post("closest", text, LINES, "--compressed", scene="town")
        self.assertIn(got.headers["content-encoding"], ("gzip", "zstd"))
        self.assertEqual(len(got.body.splitlines()), len(rays))

    def test_codings_that_are_none(self):
        zstd, body = Zstd(), json.dumps({"rays": [HIT]}).encode()
        for coding, content, status, code in [("br", body, 415, "ENCODING_UNSUPPORTED"), ("gzip, gzip", body, 415, "ENCODING_UNSUPPORTED"),
                                              ("gzip", body, 400, "ENCODING_BROKEN"), ("gzip", gzip.compress(body)[:-3], 400, "ENCODING_BROKEN"),
                                              ("zstd", zstd.compress(body)[:-3], 400, "ENCODING_BROKEN"),
                                              ("zstd", zstd.compress(body) + b"x", 400, "ENCODING_BROKEN")]:
            answer = self.post("any", content, "application/json", "-H", f"Content-Encoding: {coding}")
            self.assertEqual((answer.status, answer.json()["code"]), (status, code), coding)
        # Small answers and raw numbers stay as they are.
        small = self.post("any", body, "application/json", "-H", "Accept-Encoding: gzip")
        self.assertNotIn("content-encoding", small.headers)
        raw = self.post("closest", frame([(-10, 1, 0)] * 500, [(1, 0, 0)] * 500)[8:], BYTES, "-H", "Accept-Encoding: gzip")
        self.assertNotIn("content-encoding", raw.headers)

    def test_bombs_meet_the_limit(self):
        with Server("--preload", "six=demo:six", "--max-query-bytes", 1 << 20) as server:
            bomb = b'{"rays":[' + b" " * (200 << 20)
            for coding, body in (("gzip", gzip.compress(bomb, 1)), ("zstd", Zstd().compress(bomb))):
                answer = server.query("six", "any", body, "-H", f"Content-Encoding: {coding}")
                self.assertEqual((answer.status, answer.json()["code"]), (413, "BODY_TOO_LARGE"))
                endless = server.ask("/v1/scenes/six/rays:any", "-H", f"Content-Type: {LINES}", "-H", f"Content-Encoding: {coding}", body=body)
                self.assertEqual((endless.status, endless.json()["code"]), (413, "LINE_TOO_LONG"))

    def test_the_first_part_counts_as_memory_until_it_is_taken(self):
        # Much is met by few rays, and hardly anything of it fits the buffers of the system.
        body = lines(*[{"origin": [0.2, 500, 0.1], "direction": [0.001, -1, 0.002]}] * 4500)
        size = len(self.post("all", body, scene="town").body)
        stream = Stream(self.server, "all", LINES, scene="town")
        self.addCleanup(stream.close)
        stream.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        stream.send(body)
        held, due = [0, 1], time.monotonic() + PATIENCE
        # The answer exists after the rays have been traced, which takes longer under a sanitizer.
        while time.monotonic() < due and not held[-1] == held[-2] > size:
            time.sleep(0.3)
            held.append(self.server.traffic())
        self.assertGreater(held[-1], size, held)

    @unittest.skipUnless(os.path.exists("/proc/self/status"), "no /proc")
    def test_memory_does_not_grow_with_the_stream(self):
        if is_sanitized(self.server):
            self.skipTest("a sanitizer keeps what is freed")
        # The i-th ray of a frame starts i / 1024 farther away, the k-th frame another 32 k: t tells their order.
        size, count = 20000, int(os.environ.get("SIGHTLINE_STREAM_RAYS", "2000000"))
        steps = [i / 1024 for i in range(size)]

        def one_frame(k):
            return frame([(-10 - 32 * k - step, 1, 0) for step in steps], [(1, 0, 0)] * size,
                         fields=["t", "instance", "triangle", "position"])

        # Only the first column differs: to make each frame anew would take longer than to answer it.
        first = one_frame(0)
        at = first.index(struct.pack("<2d", -10, -10 - steps[1]))
        stream = Stream(self.server, "closest", BYTES)
        self.addCleanup(stream.close)
        before = self.resident()

        def send():
            stream.send(frames())
            for k in range(count // size):
                column_x = array("d", [-10 - 32 * k - step for step in steps]).tobytes()
                stream.send(first[:at] + column_x + first[at + 8 * size:])
            stream.finish()

        sender = threading.Thread(target=send)
        sender.start()
        self.assertEqual(stream.read(8), frames())
        most = 0
        for k in range(count // size):
            length, = struct.unpack("<Q", stream.read(8))
            answer = stream.read(length)
            self.assertEqual(column(answer, "t"), [4.5 + 32 * k + step for step in steps], k)
            most = max(most, self.resident())
        sender.join()
        self.assertEqual(stream.read(1), b"")
        print(f"{count} rays, {(most - before) / 1024:.1f} MiB above")
        self.assertLess(most - before, 64 << 10)

    def resident(self, kind="VmRSS"):
        """KiB."""
        with open(f"/proc/{self.server.process.pid}/status", encoding="ascii") as status:
            return int(next(line for line in status if line.startswith(kind)).split()[1])

    def test_the_log_says_what_became_of_a_stream(self):
        with Server("--preload", "six=demo:six", "--log-level", "info", "--log-format", "json", "--rate-seconds", 0.2) as quiet, \
                Server("--preload", "six=demo:six", "--log-format", "json") as server:
            def ends(of, message):
                end = time.monotonic() + PATIENCE
                while not (found := [json.loads(line) for line in of.log_text().splitlines() if message in line]):
                    self.assertLess(time.monotonic(), end)
                return found

            def count(of, event):
                return int(of.ask("/metrics").body.decode().split(f'event="{event}"}} ')[1].split()[0])

            whole = server.ask("/v1/scenes/six/rays:any", "-H", f"Content-Type: {LINES}", "-H", "X-Request-Id: whole", body=lines(HIT, MISS))
            line, = ends(server, "stream ended")
            self.assertEqual((line["level"], line["id"], line["rays"], line["bytes"], line["path"], line.get("code")),
                             ("debug", "whole", 2, len(whole.body), "/v1/scenes/six/rays:any", None))
            # One that sends too slowly, one whose rays turn bad, and one that goes away.
            slow = Stream(quiet, "any", LINES)
            self.addCleanup(slow.close)
            slow.send(lines(HIT))
            self.assertIs(slow.line(), True)
            self.assertEqual(slow.line()["code"], "REQUEST_TIMEOUT")
            line, = ends(quiet, "stream broken off")
            self.assertEqual((line["level"], line["code"], line["rays"]), ("info", "REQUEST_TIMEOUT", 1))
            self.assertEqual((count(quiet, "too_slow"), count(quiet, "gone")), (1, 0))
            left = Stream(server, "any", LINES)
            left.send(lines(HIT))
            self.assertIs(left.line(), True)
            left.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            left.close()
            line, = ends(server, "stream broken off")
            self.assertEqual(line["rays"], 1)
            self.assertTrue(line["code"])
            self.assertEqual((count(server, "too_slow"), count(server, "gone")), (0, 1))

    def test_streams_are_bounded(self):
        with Server("--preload", "six=demo:six", "--max-streams", 2) as server:
            for _ in range(2):
                held = Stream(server, "any", LINES)
                self.addCleanup(held.close)
                held.send(lines(HIT))
                self.assertIs(held.line(), True)
            busy = server.ask("/v1/scenes/six/rays:any", "-H", f"Content-Type: {LINES}", body=lines(HIT))
            self.assertEqual((busy.status, busy.json()["code"], busy.headers["retry-after"]), (503, "STREAMS_BUSY", "1"))
            self.assertEqual(server.query("six", "any", {"rays": [HIT]}).status, 200)

    def test_idle_streams_take_no_worker(self):
        with Server("--preload", "six=demo:six", "--workers", 8, "--rate-seconds", PATIENCE) as server:
            held = [Stream(server, "any", LINES) for _ in range(100)]
            for stream in held:
                self.addCleanup(stream.close)
                stream.send(lines(HIT))
            for stream in held:
                self.assertIs(stream.line(), True)
            self.assertEqual(server.query("six", "any", {"rays": [HIT] * 3000}).status, 200)
            self.assertEqual(server.put("new", demo_glb("six")).status, 201)
            for stream in held:
                stream.send(lines(HIT))
                self.assertIs(stream.line(), True)


if __name__ == "__main__":
    case_report.main()
