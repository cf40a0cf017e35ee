"""Bodies that come slowly keep nobody else from answers for long, and who waits is told in time."""

import json
import re
import select
import threading
import unittest

import case_report
from abuse_case import MIB, QUERY, ROW, trickle
from sightline_server import PATIENCE, Server, demo_glb, read_answer, with_document

BODY = json.dumps({"rays": [ROW] * 3000, "fields": ["t"]}).encode()
WORKERS = 8


def ask(connection, *pieces):
    with connection, connection.makefile("rb") as stream:
        for piece in pieces:
            connection.sendall(piece)
        return read_answer(stream)


def told(answer):
    return answer.status, answer.json().get("code"), "retry-after" in answer.headers


class SlowBodies(unittest.TestCase):
    def serve(self, *arguments, rate_seconds=1):
        self.server = Server("--preload", "six=demo:six", "--workers", WORKERS, "--memory", (4 * MIB + 65536) * 8 // 7,
                             "--min-rate", 1, "--rate-seconds", rate_seconds, "--queue-seconds", 1, *arguments)
        self.addCleanup(self.server.end)

    def hold(self, count, head, begin):
        """So many connections that have sent that, and go on with a byte now and then until they are ended."""
        connections = [self.server.connect() for _ in range(count)]
        for connection in connections:
            connection.sendall(head + begin)
        sender = threading.Thread(target=trickle, args=(list(connections), PATIENCE, b" "))
        sender.start()

        def end():
            for connection in connections:
                connection.close()
            sender.join()
        self.addCleanup(end)
        return connections

    def hold_memory(self):
        # Each counts as two, and some bytes: all but what is kept for who asks for little.
        held = self.hold(2, QUERY + b"Content-Length: %d\r\n\r\n" % (200 * MIB), b" " * (MIB + MIB // 4))
        while self.server.traffic() < 4 * MIB:
            self.assertIsNone(self.server.process.poll())
        return held

    def test_others_get_their_memory(self):
        self.serve()
        held = self.hold_memory()
        answer = ask(self.server.connect(), QUERY + b"Content-Length: %d\r\n\r\n" % len(BODY), BODY)
        self.assertEqual((answer.status, len(answer.json()["hits"])), (200, 3000))
        refused = select.select(held, [], [], PATIENCE)[0][0]
        with refused.makefile("rb") as stream:
            self.assertEqual(told(read_answer(stream)), (503, "MEMORY_BUSY", True))

    def test_the_door_does_not_wait_for_memory(self):
        self.serve(rate_seconds=2)
        named = with_document(demo_glb("six"), lambda scene: [node.update(name="n" * 600_000) for node in scene["nodes"]])
        self.assertEqual(self.server.put("named", named).status, 201)
        # Small enough for the door, and its answer is not; nothing has to be built any more.
        query = json.dumps({"rays": [ROW] * 8, "fields": ["t", "node"]}).encode()
        self.assertEqual(self.server.query("named", "closest", query).status, 200)
        self.hold_memory()
        refused = lambda: len(re.findall("/six/.* status=503", self.server.log_text()))
        for _ in range(2):
            connection, before = self.server.connect(), refused()
            connection.sendall(QUERY.replace(b"/six/", b"/named/") + b"Content-Length: %d\r\n\r\n" % len(query) + query)
            self.assertEqual(self.server.ask("/healthz").status, 200)
            self.assertEqual(refused(), before, "it waited until a body gave way")
            self.assertEqual(ask(connection).status, 200)

    def test_time_in_the_queue_is_time_of_the_question(self):
        self.serve("--request-seconds", 5, "--preload", "town=demo:town")
        hog = b"GET /v1/scenes/town/selfcheck?rays=100000 HTTP/1.1\r\nHost: x\r\n\r\n"
        hogs = [self.server.connect() for _ in range(2 * WORKERS)]
        for connection in hogs:
            self.addCleanup(connection.close)
            connection.sendall(hog)
        # Too long to go before them.
        query = json.dumps({"rays": [ROW] * 60, "fields": ["t"], "timeout_ms": 1000}).encode()
        answer = ask(self.server.connect(), QUERY + b"Content-Length: %d\r\n\r\n" % len(query) + query)
        self.assertEqual((answer.status, answer.json()["code"]), (504, "DEADLINE"))

    def test_time_spent_waiting_for_memory_is_not_the_clients(self):
        self.serve()
        self.hold_memory()
        connection = self.server.connect()
        with connection, connection.makefile("rb") as stream:
            connection.sendall(QUERY + b"Expect: 100-continue\r\nContent-Length: %d\r\n\r\n" % len(BODY))
            self.assertEqual((stream.readline(), stream.readline()), (b"HTTP/1.1 100 Continue\r\n", b"\r\n"))
            connection.sendall(BODY)
            self.assertEqual(read_answer(stream).status, 200)

    def test_a_query_waits_for_memory_no_longer_than_it_wants(self):
        # Nobody is blamed for holding less than a 64th of that.
        self.serve("--max-body-memory", 1024 * MIB)
        self.hold_memory()
        answer = self.server.query("six", "all", {"rays": [ROW], "timeout_ms": 50})
        self.assertEqual((answer.status, answer.json()["code"]), (504, "DEADLINE"))

    def test_a_body_waits_for_a_worker_only_so_long(self):
        self.serve()
        held = self.hold(WORKERS, QUERY + b"Content-Length: %d\r\n\r\n" % (200 * MIB), b"")
        chunked = QUERY + b"Transfer-Encoding: chunked\r\n\r\n4\r\nnull\r\n0\r\n\r\n"
        self.assertEqual(told(ask(self.server.connect(), chunked)), (503, "QUEUE_FULL", True))
        for connection in held:
            connection.close()
        self.assertEqual(told(ask(self.server.connect(), chunked))[0], 422)


if __name__ == "__main__":
    case_report.main()
