"""All kinds of abuse at once: what each may hold is bounded, and so is their sum.

Prints `floor 1: ...` at the end.
"""

import collections
import gzip
import hashlib
import json
import multiprocessing
import random
import socket
import struct
import threading
import unittest

import case_report
from abuse_case import MIB, ROW, Abuse, print_floor
from process_status import forget_peak
from sightline_server import PATIENCE, read_answer

CLIENTS, PROCESSES = 60, 4
IMPATIENCE = 2  # seconds after which such a client goes away
DOWN = {"position": [3, 200, 5], "forward": [0, -1, 0], "up": [0, 0, -1], "fov_y": 20}
EVERYTHING = {"names": ["*"]}
PLACES = [[i, 40 + i % 7, i] for i in range(400)]
# What a server that has its hands full may say, with when to come again; and to who is too slow.
BUSY = {(503, "MEMORY_BUSY"), (503, "QUEUE_FULL"), (503, "STREAMS_BUSY")}


def rows(count):
    return json.dumps({"rays": [ROW] * count}).encode()


def post(path, body, *headers, length=None):
    lines = [b"POST /v1/scenes/%s HTTP/1.1" % path, b"Host: x", *(headers or [b"Content-Type: application/json"])]
    lines.append(b"Transfer-Encoding: chunked" if length == "chunked" else b"Content-Length: %d" % (length or len(body)))
    return b"\r\n".join(lines) + b"\r\n\r\n" + body


def chunked(body):
    pieces = (body[at:at + 50000] for at in range(0, len(body), 50000))
    return b"".join(b"%x\r\n%s\r\n" % (len(piece), piece) for piece in pieces) + b"0\r\n\r\n"


def zstd_of(text, blanks):
    """[RFC8878] 3.1.1: a window of 8 MiB, a raw block with the text, then blocks that are one blank 131,072 times."""
    def block(kind, size, content, last=0):
        return struct.pack("<I", size << 3 | kind << 1 | last)[:3] + content
    repeated = [block(1, 131072, b" ", i == blanks - 1) for i in range(blanks)]
    return b"\x28\xb5\x2f\xfd\x00\x68" + block(0, len(text), text) + b"".join(repeated)


def frames(count):
    """A stream of `count` frames of 60,000 rays each: docs/reference/binary.md."""
    columns = b"".join(struct.pack("<d", number) * 60000 for number in ROW["origin"] + ROW["direction"])
    body = b"SLR1" + struct.pack("<IQII", 1, 60000, 2, 0) + b"{}" + bytes(6) + columns
    return b"SLS1" + bytes(4) + (struct.pack("<Q", len(body)) + body) * count


JSON = b"Content-Type: application/json"
SIX, TOWN = b"six/rays:closest", b"town/rays:closest"
# What is answered, by its name; these are read.
ASKED = {
    "a body": post(SIX, rows(10000)),
    "a large body": post(SIX, rows(100000)),
    "a chunked body": post(SIX, chunked(rows(20000)), length="chunked", *[JSON]),
    "a body in gzip": post(SIX, gzip.compress(rows(1000) + b" " * (8 * MIB), 1), JSON, b"Content-Encoding: gzip"),
    "a body in zstd": post(SIX, zstd_of(rows(1000), 64), JSON, b"Content-Encoding: zstd"),
    "an answer in zstd": post(SIX, rows(20000), JSON, b"Accept-Encoding: zstd"),
    "a picture": post(TOWN, json.dumps({"image": "normal", "generator": {"kind": "pinhole", "width": 500, "height": 500, **DOWN}}).encode()),
    "clearance": post(b"town/clearance", json.dumps({"a": EVERYTHING, "b": EVERYTHING}).encode()),
    "boxes": post(b"town/boxes:list", json.dumps({"boxes": [{"min": [None] * 3, "max": [None] * 3}] * 2}).encode()),
    "lines of sight": post(b"town/visibility", json.dumps({"from": PLACES, "to": PLACES}).encode()),
}
# What is sent, and never read or never finished: (bytes, receive buffer).
HELD = {
    "answers that nobody reads": (post(SIX, rows(30000)), 4096),
    "a stream that nobody reads": (post(SIX, frames(3), b"Content-Type: application/octet-stream"), 4096),
    "a long head": (b"GET /healthz HTTP/1.1\r\nHost: x\r\n" + b"X: " + b"y" * 15000, None),
    "a slow body": (post(SIX, rows(20000)[:-1], length=20 * MIB), None),
}


def connect(port, receive_buffer=None):
    connection = socket.socket()
    if receive_buffer is not None:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    connection.settimeout(PATIENCE)
    connection.connect(("127.0.0.1", port))
    return connection


def answer_of(port, name, patience=PATIENCE):
    """(status, code of a problem, digest of the body, whether it says when to come again); None where it took too long, or was
    closed."""
    with connect(port) as connection, connection.makefile("rb") as stream:
        connection.settimeout(patience)
        try:
            connection.sendall(ASKED[name])
        except ConnectionError:
            pass  # it has its answer already
        except TimeoutError:
            return None
        try:
            answer = read_answer(stream)
        except (ConnectionError, TimeoutError):
            return None
        if answer is None:
            return None
        code = answer.json()["code"] if answer.status != 200 else ""
        return answer.status, code, hashlib.sha256(answer.body).hexdigest(), "retry-after" in answer.headers


def hold(port, name):
    request, receive_buffer = HELD[name]
    connection = connect(port, receive_buffer)
    connection.settimeout(IMPATIENCE)
    try:
        connection.sendall(request)
    except OSError:
        pass  # told to go, or its answer is in the way
    return connection


def flood(port, seed, clients, events):
    """Clients that do one thing after the other, each in an order of its own, until they are ended."""
    def go_on(number):
        chance, held = random.Random(seed * 1000 + number), []
        while True:
            name = chance.choice([*ASKED, *HELD])
            if name in ASKED:
                events.put((name, answer_of(port, name, IMPATIENCE)))
            else:
                held.append(hold(port, name))
                events.put((name, None))
                if len(held) > 2:
                    held.pop(0).close()
    threads = [threading.Thread(target=go_on, args=(number,)) for number in range(clients)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


class Flood(Abuse):
    # With all trees beforehand: what a scene takes is no part of what traffic takes.
    ARGUMENTS = ("--preload", "town=demo:town", "--skip", "none", "--rate-seconds", 2)

    def test_mixed_flood(self):
        truth = {name: answer_of(self.server.port, name) for name in ASKED}
        self.assertEqual({name: answer[:2] for name, answer in truth.items()}, {name: (200, "") for name in ASKED})
        forget_peak(self.server)
        events, counts, faults = multiprocessing.Queue(), collections.Counter(), []
        attackers = [multiprocessing.Process(target=flood, args=(self.server.port, seed, CLIENTS // PROCESSES, events))
                     for seed in range(PROCESSES)]
        for attacker in attackers:
            attacker.start()
        try:
            while len({name for name, _ in counts}) < len(ASKED) + len(HELD) or counts.total() < 10 * CLIENTS:
                name, answer = events.get(timeout=PATIENCE)
                counts[name, "nothing" if answer is None else answer[0]] += 1
                # Right, or told to come again later; else the client has lost its patience, or was broken off.
                if answer not in (None, truth.get(name)) and not (answer[:2] in BUSY and answer[3]):
                    faults.append((name, answer))
            self.check_ordinary("mixed flood", peak=True)
        finally:
            for attacker in attackers:
                attacker.kill()
                attacker.join()
        print("  answered: " + ", ".join(f"{name} {outcome}: {count}" for (name, outcome), count in sorted(counts.items(), key=str)))
        self.assertEqual(faults, [])
        # When they have gone all is answered again.
        while 'sightline_connections 1\n' not in self.server.ask("/metrics").body.decode():
            self.assertIsNone(self.server.process.poll())
        self.assertEqual({name: answer_of(self.server.port, name) for name in ASKED}, truth)


def tearDownModule():
    print_floor()


if __name__ == "__main__":
    case_report.main()
