#!/usr/bin/env python3
"""Times of ordinary requests beside many clients of every difficult kind at once.

Usage: mixed_load.py BINARY [--seconds N]

Beside 200 slow uploads, 200 slow readers, 64 clients with Expect, 48 connections that repeat the most expensive short questions and
100 idle streams of rays, one client at a time sends a query of 150 kB, a query of one ray and a PUT of 300 kB. Prints the median and
the maximum of each, and of the same requests before the load. Exits with 1 where an answer has another status than expected or a
maximum is above its floor: 1 s, 50 ms, 2 s.
"""

import argparse
import json
import socket
import statistics
import sys
import tempfile
import threading
import time
from http.client import HTTPConnection

from many_clients import Server as PlainServer

FLOORS = {"query of 150 kB": 1.0, "query of one ray": 0.05, "PUT of 300 kB": 2.0}
RAY = {"origin": [3, 200, 5], "direction": [0, -1, 0]}
CLOSEST = "/v1/scenes/town/rays:closest"


def head(method, path, *fields):
    return "\r\n".join([f"{method} {path} HTTP/1.1", "Host: x", *fields, "", ""]).encode()


def glb_of(size):
    """A GLB of one grid of triangles, about `size` bytes long."""
    import array
    import struct
    side = int((size / 36) ** 0.5)
    points = array.array("f", [value for y in range(side + 1) for x in range(side + 1) for value in (x, 0, y)])
    rows = [(y * (side + 1) + x) for y in range(side) for x in range(side)]
    indices = array.array("I", [at for i in rows for at in (i, i + 1, i + side + 1, i + 1, i + side + 2, i + side + 1)])
    blob = points.tobytes() + indices.tobytes()
    document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "buffers": [{"byteLength": len(blob)}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "bufferViews": [{"buffer": 0, "byteLength": 4 * len(points)},
                                {"buffer": 0, "byteOffset": 4 * len(points), "byteLength": 4 * len(indices)}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(points) // 3,
                               "min": [0, 0, 0], "max": [side, 0, side]},
                              {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": len(indices)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(blob)) + struct.pack("<II", len(text), 0x4E4F534A) + text +
            struct.pack("<II", len(blob), 0x004E4942) + blob)


class Load:
    """The difficult clients; each is a few sockets of one thread."""

    def __init__(self, port):
        self.port, self.stop, self.threads, self.counts = port, threading.Event(), [], {}

    def connect(self, buffer=None):
        connection = socket.socket()
        if buffer:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        connection.connect(("127.0.0.1", self.port))
        return connection

    def start(self, work, *arguments):
        thread = threading.Thread(target=work, args=arguments, daemon=True)
        thread.start()
        self.threads.append(thread)

    def trickle(self, count, begin, piece, expect=None):
        """Sends a few bytes of a long body every second; a connection that ends begins anew."""
        held = [None] * count
        while not self.stop.is_set():
            for at, connection in enumerate(held):
                try:
                    if connection is None:
                        held[at] = connection = self.connect()
                        connection.sendall(begin)
                        if expect:
                            connection.settimeout(30)
                            connection.recv(len(expect))
                            connection.settimeout(None)
                    connection.sendall(piece)
                except OSError:
                    held[at] = None
            self.stop.wait(1)

    def sip(self, count, request, size):
        """Asks for a large answer, and takes a few kilobytes of it every second."""
        held = [None] * count
        while not self.stop.is_set():
            for at, connection in enumerate(held):
                try:
                    if connection is None:
                        held[at] = connection = self.connect(4096)
                        connection.sendall(request)
                        connection.settimeout(0.001)
                    if not connection.recv(size):
                        held[at] = None
                except TimeoutError:
                    pass
                except OSError:
                    held[at] = None
            self.stop.wait(1)

    def repeat(self, request):
        connection = HTTPConnection("127.0.0.1", self.port, timeout=300)
        while not self.stop.is_set():
            try:
                connection.request(*request)
                answer = connection.getresponse()
                answer.read()
                self.counts[request[1], answer.status] = self.counts.get((request[1], answer.status), 0) + 1
            except OSError:
                connection.close()

    def begin(self):
        post = lambda *fields: head("POST", CLOSEST, "Content-Type: application/json", *fields)
        self.start(self.trickle, 100, post("Content-Length: 200000000") + b'{"rays":[' + b" " * 300_000, b" " * 5000)
        self.start(self.trickle, 60, head("POST", CLOSEST, "Transfer-Encoding: chunked") + b"1388\r\n" + b" " * 5000 + b"\r\n",
                   b"1388\r\n" + b" " * 5000 + b"\r\n")
        self.start(self.trickle, 40, head("PUT", "/v1/scenes/slow", "Content-Length: 200000000") + b"glTF", b"\0" * 5000)
        camera = {"kind": "equirectangular", "position": [3, 20, 5], "width": 200, "height": 100}
        body = json.dumps({"generator": camera, "fields": ["t", "position", "normal", "node"]}).encode()
        self.start(self.sip, 200, post(f"Content-Length: {len(body)}") + body, 5000)
        self.start(self.trickle, 64, post("Expect: 100-continue", "Content-Length: 200000000"), b" " * 5000,
                   b"HTTP/1.1 100 Continue\r\n\r\n")
        line = json.dumps(RAY).encode() + b"\n"
        stream = head("POST", CLOSEST, "Content-Type: application/x-ndjson", "Transfer-Encoding: chunked")
        chunk = b"%x\r\n%s\r\n" % (len(line), line)
        self.start(self.trickle, 100, stream, chunk)
        everything = json.dumps({"boxes": [{"min": [-1e9] * 3, "max": [1e9] * 3}] * 8}).encode()
        expensive = [("POST", "/v1/scenes/town/boxes:count", everything, {"Content-Type": "application/json"}),
                     ("GET", "/v1/scenes/town/selfcheck?rays=1000"), ("GET", "/v1/scenes/town/bvh"),
                     ("POST", "/v1/scenes/town/rays:count", json.dumps({"generator": {**camera, "width": 1000, "height": 500}}).encode(),
                      {"Content-Type": "application/json"})]
        for at in range(48):
            self.start(self.repeat, expensive[at % len(expensive)])


def measure(port, seconds, glb):
    """Seconds of each ordinary request, and what had another status."""
    many = json.dumps({"rays": [RAY] * 2700, "fields": ["t"]}).encode()
    requests = {"query of 150 kB": ("POST", CLOSEST, many, {"Content-Type": "application/json"}),
                "query of one ray": ("POST", CLOSEST, json.dumps({"rays": [RAY]}).encode(), {"Content-Type": "application/json"}),
                "PUT of 300 kB": ("PUT", "/v1/scenes/new", glb, {"Content-Type": "model/gltf-binary"})}
    times, faults, end = {name: [] for name in requests}, [], time.perf_counter() + seconds
    while time.perf_counter() < end:
        for name, request in requests.items():
            connection = HTTPConnection("127.0.0.1", port, timeout=300)
            begin = time.perf_counter()
            connection.request(*request)
            answer = connection.getresponse()
            text = answer.read()
            times[name].append(time.perf_counter() - begin)
            connection.close()
            if answer.status not in (200, 201):
                faults.append((name, answer.status, text[:200]))
    return times, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--seconds", type=float, default=30)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        server = PlainServer(arguments.binary, 0, "--data", folder)
        glb, bad = glb_of(300_000), False
        alone, faults = measure(server.port, 3, glb)
        load = Load(server.port)
        load.begin()
        time.sleep(5)
        beside, more = measure(server.port, arguments.seconds, glb)
        load.stop.set()
        print(f"spool {server.spooled()} bytes")
        print("answers of the expensive questions:", {f"{path} {status}": count for (path, status), count in sorted(load.counts.items())})
        print("| request | alone, median ms | maximum | beside the load, median ms | maximum | floor |\n|---|---|---|---|---|---|")
        for name, floor in FLOORS.items():
            a, b = alone[name], beside[name]
            bad = bad or max(b) > floor
            print(f"| {name} | {1000 * statistics.median(a):.1f} | {1000 * max(a):.1f} | {1000 * statistics.median(b):.1f} | "
                  f"{1000 * max(b):.1f} | {1000 * floor:.0f} |")
        for fault in (faults + more)[:10]:
            print("not answered:", *fault)
        server.process.kill()
        server.process.wait()
    return 1 if bad or faults or more else 0


if __name__ == "__main__":
    sys.exit(main())
