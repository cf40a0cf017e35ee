#!/usr/bin/env python3
"""Many clients send one large batch each at once: status, time, memory and temporary files.

Usage: many_clients.py BINARY [--clients 8,64,256] [--memory BYTES ...] [--json-rays N] [--binary-rays N]

For each setting of --memory (0: the default of the server) and each number of clients, all clients send the same batch at once:
first of binary rays, then of JSON rays. Every answer must be 200 with the bytes of the answer to a single client. `ratio` is the
time of all clients at once divided by the time of one client that sends as many requests in sequence (measured on 8 requests
before and 8 after the run, and scaled). `memory` is the peak resident memory above the idle server. `spool` is the peak of
sightline_spool_bytes. Exits with 1 where an answer differs or is not 200.
"""

import argparse
import array
import json
import random
import re
import struct
import subprocess
import sys
import threading
import time
import zlib
from http.client import HTTPConnection
from pathlib import Path

MIB = 1 << 20


def rays_of(count):
    numbers = random.Random(7)
    return [(numbers.uniform(-9, 9), 9.0, numbers.uniform(-9, 9), 0.0, -1.0, 0.0) for _ in range(count)]


def binary_body(count):
    columns = [array.array("f", column).tobytes() for column in zip(*rays_of(count))]
    return struct.pack("<4sIQII", b"SLR1", 0, count, 0, 0) + b"".join(columns)


def json_body(count):
    return json.dumps({"rays": [{"origin": ray[:3], "direction": ray[3:]} for ray in rays_of(count)]}).encode()


class Server:
    def __init__(self, binary, memory, *more):
        arguments = [*(["--memory", str(memory)] if memory else []), *more]
        self.process = subprocess.Popen([binary, "serve", "--listen", "127.0.0.1:0", "--preload", "town=demo:town", *arguments],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.port = int(self.process.stdout.readline().rsplit(":", 1)[1])
        while self.get("/readyz")[0] != 200:
            time.sleep(0.05)

    def get(self, path):
        connection = HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.request("GET", path)
        answer = connection.getresponse()
        return answer.status, answer.read().decode()

    def status(self, name):
        text = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        return int(re.search(rf"^{name}:\s+(\d+) kB", text, re.MULTILINE)[1]) << 10

    def forget_peak(self):
        Path(f"/proc/{self.process.pid}/clear_refs").write_text("5", encoding="ascii")

    def spooled(self):
        return int(float(re.search(r"^sightline_spool_bytes (\S+)$", self.get("/metrics")[1], re.MULTILINE)[1]))

    def memory(self):
        return json.loads(self.get("/version")[1])["limits"]["memory"]

    def end(self):
        self.process.terminate()
        self.process.wait()


def ask(server, body, media_type):
    """Status, code of a problem, and a checksum of the answer."""
    connection = HTTPConnection("127.0.0.1", server.port, timeout=3600)
    try:
        connection.request("POST", "/v1/scenes/town/rays:closest", body, {"Content-Type": media_type})
        answer = connection.getresponse()
        check, problem = 0, b""
        while piece := answer.read(1 << 20):
            check = zlib.crc32(piece, check)
            problem = problem or piece[:1000]
        code = json.loads(problem)["code"] if answer.status != 200 else ""
        return answer.status, code, check
    except OSError as error:
        return 0, type(error).__name__, 0
    finally:
        connection.close()


def in_sequence(server, body, media_type, count=8):
    begin = time.perf_counter()
    answers = [ask(server, body, media_type) for _ in range(count)]
    return answers, (time.perf_counter() - begin) / count


def at_once(server, body, media_type, clients):
    answers, spool, done = [None] * clients, 0, threading.Event()

    def client(at):
        answers[at] = ask(server, body, media_type)

    def watch():
        nonlocal spool
        while not done.wait(0.2):
            spool = max(spool, server.spooled())

    threads = [threading.Thread(target=client, args=(at,)) for at in range(clients)]
    watcher = threading.Thread(target=watch)
    watcher.start()
    begin = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    seconds = time.perf_counter() - begin
    done.set()
    watcher.join()
    return answers, seconds, spool


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--clients", default="8,64,256")
    parser.add_argument("--memory", type=int, nargs="*", default=[0, 512 * MIB])
    parser.add_argument("--binary-rays", type=int, default=1_000_000)
    parser.add_argument("--json-rays", type=int, default=300_000)
    arguments = parser.parse_args()
    bodies = [(f"{arguments.binary_rays} binary rays", binary_body(arguments.binary_rays), "application/octet-stream"),
              (f"{arguments.json_rays} JSON rays", json_body(arguments.json_rays), "application/json")]
    bad = 0
    print("| --memory MiB | clients | batch | 200 | other | seconds | ratio | memory MiB | spool MiB |\n|---|---|---|---|---|---|---|---|---|")
    for memory in arguments.memory:
        server = Server(arguments.binary, memory)
        limit = server.memory()
        for name, body, media_type in bodies:
            truth = ask(server, body, media_type)
            idle = server.status("VmRSS")
            for clients in map(int, arguments.clients.split(",")):
                _, before = in_sequence(server, body, media_type)
                server.forget_peak()
                answers, seconds, spool = at_once(server, body, media_type, clients)
                peak = server.status("VmHWM") - idle
                _, after = in_sequence(server, body, media_type)
                good = sum(answer == truth for answer in answers)
                other = sorted({answer[:2] for answer in answers if answer != truth})
                bad += clients - good
                print(f"| {limit / MIB:.0f} | {clients} | {name} | {good} | {other or ''} | {seconds:.1f} | "
                      f"{seconds / clients / ((before + after) / 2):.2f} | {peak / MIB:.0f} | {spool / MIB:.0f} |", flush=True)
        server.end()
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
