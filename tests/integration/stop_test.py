"""A stop: /readyz tells, what has begun is finished, silence ends, and a second signal does not wait."""

import fcntl
import json
import os
import re
import signal
import socket
import sys
import tempfile
import termios
import threading
import time
import unittest
from pathlib import Path

import case_report
from memory_test import grid_glb
from sightline_server import GLB_TYPE, PATIENCE, Server, curl, demo_glb, read_answer
from streams_test import BYTES, HIT, LINES, MISS, Stream, answers_in, column, frame, frames, lines

HEALTH = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"


def cpu_seconds(server):
    words = Path(f"/proc/{server.process.pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def unacknowledged(connection):
    """Bytes that were sent and that the other side's system has not acknowledged: SIOCOUTQ of tcp(7)."""
    return int.from_bytes(fcntl.ioctl(connection, termios.TIOCOUTQ, bytes(4)), sys.byteorder)


class Stop(unittest.TestCase):
    def test_two_hundred_idle_connections_and_half_a_head_delay_nothing(self):
        with Server("--preload", "six=demo:six", "--drain-seconds", PATIENCE) as server:
            held = [server.connect() for _ in range(200)]
            for connection in held[:50]:  # some have asked before
                connection.sendall(HEALTH)
                with connection.makefile("rb") as stream:
                    self.assertEqual(read_answer(stream).status, 200)
            held[-1].sendall(b"GET /healthz HTTP/1.1\r\nHo")
            self.assertEqual(server.stop(), 0)
            self.assertNotIn("aborting requests", server.log_text())
            for connection in held:
                connection.close()

    def test_readyz_says_so_first(self):
        with Server("--preload", "six=demo:six", "--notice-seconds", PATIENCE) as server:
            server.signal()
            while (answer := curl(server.url + "/readyz")).status == 200:
                pass
            self.assertEqual((answer.status, answer.json()["status"], answer.headers["retry-after"]), (503, "stopping", "1"))
            # Requests are answered until the notice is over. A second signal ends it.
            self.assertEqual(curl(server.url + "/healthz").status, 200)
            self.assertEqual(server.stop(), 0)

    def test_an_upload_that_has_begun_is_finished(self):
        body = demo_glb("six")
        with Server("--drain-seconds", PATIENCE, "--rate-seconds", PATIENCE) as server:
            upload = server.connect()
            with upload, upload.makefile("rwb") as stream:
                stream.write(b"PUT /v1/scenes/a HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: %d\r\n\r\n" % len(body))
                stream.flush()
                self.assertEqual(read_answer(stream).status, 100)
                watching = server.connect()
                watching.sendall(b"GET /v1/scenes/a/events HTTP/1.1\r\nHost: x\r\n\r\n")
                events = watching.makefile("rb")
                while b"event: progress" not in events.readline():
                    pass
                server.signal()
                # The stream ends as a stream does, with its last chunk, and the rest of the upload is taken.
                rest = events.read()
                self.assertTrue(rest.endswith(b"0\r\n\r\n"), rest)
                with self.assertRaises(OSError):
                    while True:  # no connection is accepted once the signal has come through
                        server.connect().close()
                stream.write(body)
                stream.flush()
                answer = read_answer(stream)
                self.assertEqual((answer.status, answer.headers.get("connection")), (201, "close"))
                watching.close()
            self.assertEqual(server.wait(), 0)

    def test_a_second_signal_does_not_wait(self):
        with Server("--drain-seconds", PATIENCE * 10, "--rate-seconds", PATIENCE * 10) as server:
            upload = server.connect()
            upload.sendall(b"PUT /v1/scenes/a HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: 1000\r\n\r\n")
            with upload.makefile("rb") as stream:
                self.assertEqual(read_answer(stream).status, 100)
                server.signal()
                while "stopping" not in server.log_text():
                    pass
                server.signal(signal.SIGINT)
                self.assertEqual(server.wait(), 0)
            self.assertIn("aborting requests", server.log_text())
            upload.close()

    def test_what_is_built_is_broken_off(self):
        body = grid_glb(1200)
        one_processor = ["taskset", "-c", str(min(os.sched_getaffinity(0)))]
        for skip in ("none", "all"):
            with tempfile.TemporaryDirectory() as data:
                # On one processor it takes more than a second, however many there are.
                with Server("--data", data, "--skip", skip, "--drain-seconds", PATIENCE, prefix=one_processor) as server:
                    self.assertEqual(server.ask("/v1/scenes/grid?wait=0", "-X", "PUT", "-H", GLB_TYPE, body=body).status, 202)
                    end = time.monotonic() + PATIENCE
                    # Its trees are being built: for its load, or ahead of rays.
                    while True:
                        scene = server.ask("/v1/scenes/grid").json()
                        if skip == "none" and scene.get("stage") == "building" or scene["state"] == "ready":
                            break
                        self.assertLess(time.monotonic(), end)
                    begin = cpu_seconds(server)
                    while skip == "all" and cpu_seconds(server) < begin + 0.1:  # nobody else asks for anything
                        self.assertLess(time.monotonic(), end)
                    begin = time.monotonic()
                    self.assertEqual(server.stop(), 0)
                    lasted = time.monotonic() - begin
                    self.assertTrue(server.log_text().rstrip().endswith("stopped"), server.log_text())
                # Had it been waited for, it would be there.
                trees = Path(data, "trees")
                self.assertEqual(list(trees.iterdir()) if trees.exists() else [], [])
                self.assertEqual(Path(data, "scenes", "grid.json").exists(), skip == "all")
                print(f"2.9 M triangles, --skip {skip}: exit 0 after {lasted:.2f} s")

    def test_under_load_no_request_that_was_accepted_is_lost(self):
        for _ in range(5):
            with Server("--preload", "six=demo:six", "--drain-seconds", PATIENCE) as server:
                started, lost, answered = threading.Barrier(9), [], []

                def ask():
                    # Pipelined: what the server has not read when it says "close" it need not answer.
                    connection = server.connect()
                    started.wait()
                    with connection, connection.makefile("rb") as stream:
                        try:
                            while True:
                                connection.sendall(HEALTH)
                                answer = read_answer(stream)
                                if answer is None:
                                    return  # closed between two requests
                                answered.append(answer.status)
                                if answer.headers.get("connection") == "close":
                                    return
                        except (ConnectionError, IndexError):
                            return
                        except (ValueError, socket.timeout) as error:
                            lost.append(error)
                askers = [threading.Thread(target=ask) for _ in range(8)]
                for asker in askers:
                    asker.start()
                started.wait()
                while len(answered) < 200:
                    pass
                self.assertEqual(server.stop(), 0)
                for asker in askers:
                    asker.join()
                self.assertEqual((lost, set(answered)), ([], {200}))
                # Every answer that the server gave has arrived.
                given = len(re.findall(r"path=/healthz status=200", server.log_text()))
                self.assertEqual(len(answered), given)
                self.assertNotIn("aborting requests", server.log_text())

    def test_under_load_with_streams_and_idle_connections_no_request_that_was_accepted_is_lost(self):
        # On a slow machine the streams wait for long between their parts.
        with Server("--preload", "six=demo:six", "--drain-seconds", PATIENCE, "--rate-seconds", PATIENCE) as server:
            idle = [server.connect() for _ in range(200)]
            self.addCleanup(lambda: [connection.close() for connection in idle])
            for connection in idle[:50]:  # some have asked before
                connection.sendall(HEALTH)
                with connection.makefile("rb") as stream:
                    self.assertEqual(read_answer(stream).status, 200)
            texts = Stream(server, "closest", LINES)
            self.addCleanup(texts.close)
            texts.send(lines(HIT, MISS, fields=["t"]))
            self.assertEqual([texts.line(), texts.line()], [{"t": 4.5}, None])
            numbers = Stream(server, "closest", BYTES)
            self.addCleanup(numbers.close)
            half = frame([(-10, 1, 0)] * 3000, [(1, 0, 0)] * 3000)
            numbers.send(frames(half))
            begun = numbers.read(16)
            askers = [Asker(server, 1 if number % 2 else 3000, f"asker{number}") for number in range(8)]
            for asker in askers:
                asker.start()
            for asker in askers:
                self.assertTrue(asker.warm.wait(PATIENCE))
            before = time.monotonic()
            idle[0].sendall(HEALTH)
            with idle[0].makefile("rb") as stream:
                self.assertEqual(read_answer(stream).status, 200)
            begin = time.monotonic()
            server.signal()
            while "stopping" not in server.log_text():
                pass
            # The streams go on: what comes after the signal is answered as ever.
            texts.send(lines(*[HIT, MISS] * 50))
            texts.finish()
            self.assertEqual([texts.line() for _ in range(101)], [{"t": 4.5}, None] * 50 + [None])
            numbers.send(half)
            numbers.finish()
            found = answers_in(begun + numbers.read(1 << 30))
            self.assertEqual([column(answer, "t") for answer in found], [[4.5] * 3000] * 2)
            self.assertEqual(server.wait(), 0)
            lasted = time.monotonic() - begin
            for asker in askers:
                asker.join()
            log = server.log_text()
            self.assertNotIn("aborting requests", log)
            self.assertEqual([fault for asker in askers for fault in asker.faults], [])
            # All answers that the server gave have arrived.
            answered = {name for asker in askers for name in asker.answered}
            self.assertEqual(set(re.findall(r"path=/v1/scenes/six/rays:closest status=200 .*id=(asker\S+)", log)), answered)
            # What had come whole before the signal was answered; a later connection may have been refused.
            late = {name: sent for asker in askers for name, sent in asker.unanswered.items()}
            # On a loaded machine the loopback device may deliver what was sent before the signal after the close.
            undelivered = {asker.undelivered for asker in askers}
            self.assertEqual([name for name, sent in late.items() if sent < before and name not in undelivered], [])
            self.assertLessEqual(len(late), len(askers))
            for connection in idle:
                self.assertEqual(connection.recv(1), b"")
        print(f"floor 4: {len(answered)} requests of {len(askers)} clients answered, 0 lost, {len(late)} refused; 2 streams "
              f"finished, 200 idle connections; exit 0 after {lasted:.2f} s (needs at most {PATIENCE} s) ok")


class Asker(threading.Thread):
    """A client that asks the same again and again on one connection, until it ends."""

    def __init__(self, server, rays, name):
        super().__init__()
        self.port, self.rays, self.prefix = server.port, rays, name
        self.warm = threading.Event()  # it has asked a few times
        self.answered, self.unanswered, self.faults = [], {}, []
        self.undelivered = None  # name of the last request, if no byte of it had reached the server at the end

    def run(self):
        body = json.dumps({"rays": [HIT] * self.rays, "fields": ["t"]}).encode()
        right = b'{"hits":[' + b",".join([b'{"t":4.5}'] * self.rays) + b"]}"
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE)
        with connection, connection.makefile("rb") as stream:
            while True:
                name = f"{self.prefix}-{len(self.answered)}"
                request = (b"POST /v1/scenes/six/rays:closest HTTP/1.1\r\nHost: x\r\nX-Request-Id: %s\r\n"
                           b"Content-Type: application/json\r\nContent-Length: %d\r\n\r\n" % (name.encode(), len(body)) + body)
                try:
                    connection.sendall(request)
                except ConnectionError:
                    return
                self.unanswered[name] = time.monotonic()
                try:
                    answer = read_answer(stream)
                except ConnectionError:
                    return
                except (ValueError, IndexError, socket.timeout) as fault:
                    return self.faults.append((name, repr(fault)))
                if answer is None:
                    # A server that closes over bytes that it has not read resets the connection. Here it has ended it
                    # properly: what it had read is acknowledged.
                    if unacknowledged(connection) == len(request):
                        self.undelivered = name
                    return
                if (answer.status, answer.body) != (200, right):
                    return self.faults.append((name, answer.status, answer.body[:300]))
                del self.unanswered[name]
                self.answered.append(name)
                if len(self.answered) == 20:
                    self.warm.set()
                if answer.headers.get("connection") == "close":
                    return


if __name__ == "__main__":
    case_report.main()
