"""Bodies that come slowly take neither workers nor memory from others, and wait in temporary files."""

import json
import select
import tempfile
import threading
import time
import unittest

import case_report
from abuse_case import MIB, QUERY, ROW, trickle
from sightline_server import PATIENCE, Server, demo_glb, read_answer

BODY = json.dumps({"rays": [ROW] * 3000, "fields": ["t"]}).encode()
# At most the first MiB of a body waits in memory.
LARGE = BODY[:-1] + b" " * (2 * MIB) + BODY[-1:]
WORKERS = 8
LONG = QUERY + b"Content-Length: %d\r\n\r\n" % (200 * MIB)


def ask(connection, *pieces):
    with connection, connection.makefile("rb") as stream:
        try:
            for piece in pieces:
                connection.sendall(piece)
        except (BrokenPipeError, ConnectionResetError):
            pass  # it may be answered before it is whole
        return read_answer(stream)


def told(answer):
    return answer.status, answer.json().get("code"), "retry-after" in answer.headers


class SlowBodies(unittest.TestCase):
    def serve(self, *arguments, rate_seconds=PATIENCE, memory=4 * MIB):
        self.server = Server("--preload", "six=demo:six", "--workers", WORKERS, "--memory", memory,
                             "--min-rate", 1, "--rate-seconds", rate_seconds, *arguments)
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

    def wait_for_spool(self, bytes_there):
        end = time.monotonic() + PATIENCE
        while not bytes_there(self.server.spooled()):
            self.assertLess(time.monotonic(), end)

    def test_others_are_answered_beside_many_slow_uploads(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.serve("--data", folder.name)
        chunk = b"%x\r\n%s\r\n" % (MIB, b" " * MIB)
        held = self.hold(40, LONG, b" " * (MIB // 2))
        held += self.hold(40, QUERY + b"Transfer-Encoding: chunked\r\n\r\n", chunk[:MIB // 4])
        held += self.hold(40, b"PUT /v1/scenes/slow HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n" % MIB, b"glTF")
        held += self.hold(64, QUERY + b"Expect: 100-continue\r\nContent-Length: %d\r\n\r\n" % MIB, b"")
        self.wait_for_spool(lambda spooled: spooled > 40 * (MIB // 4))
        self.assertLess(self.server.traffic(), 4 * MIB)
        for _ in range(5):
            self.assertEqual(self.server.query("six", "closest", {"rays": [ROW]}).status, 200)
            answer = ask(self.server.connect(), QUERY + b"Content-Length: %d\r\n\r\n" % len(BODY), BODY)
            self.assertEqual((answer.status, len(answer.json()["hits"])), (200, 3000))
            self.assertIn(self.server.put("new", demo_glb("town")).status, (200, 201))
        self.assertEqual(select.select(held[:80], [], [], 0)[0], [], "a slow client was refused for no need")

    def test_a_long_body_waits_in_a_file_until_it_is_answered(self):
        self.serve()
        connection = self.server.connect()
        with connection, connection.makefile("rb") as stream:
            connection.sendall(QUERY + b"Content-Length: %d\r\n\r\n" % len(LARGE) + LARGE[:-1])
            self.wait_for_spool(lambda spooled: 0 < spooled < len(LARGE))
            connection.sendall(LARGE[-1:])
            self.assertEqual(len(read_answer(stream).json()["hits"]), 3000)
            # The connection goes on, after a chunked body too.
            for _ in range(2):
                chunks = b"".join(b"%x\r\n%s\r\n" % (len(piece), piece) for piece in (LARGE[:7], LARGE[7:100_000], LARGE[100_000:]))
                connection.sendall(QUERY + b"Transfer-Encoding: chunked\r\n\r\n" + chunks + b"0\r\n\r\n")
                self.assertEqual(len(read_answer(stream).json()["hits"]), 3000)
        self.wait_for_spool(lambda spooled: spooled == 0)

    def test_a_client_that_leaves_gives_its_file_back(self):
        self.serve()
        connection = self.server.connect()
        connection.sendall(LONG + b" " * (2 * MIB))
        self.wait_for_spool(lambda spooled: spooled > MIB // 2)
        connection.close()
        self.wait_for_spool(lambda spooled: spooled == 0)

    def test_a_full_spool_is_503_and_its_slow_holders_go(self):
        self.serve("--spool-bytes", 4 * MIB, rate_seconds=1)
        held = self.hold(1, LONG, b" " * (3 * MIB))
        self.wait_for_spool(lambda spooled: spooled > MIB)
        time.sleep(1.5)  # --busy-rate is kept over --rate-seconds
        refused = ask(self.server.connect(), LONG, b" " * (4 * MIB))
        self.assertEqual(told(refused), (503, "SPOOL_BUSY", True))
        with held[0].makefile("rb") as stream:
            self.assertEqual(told(read_answer(stream)), (503, "SPOOL_BUSY", True))
        self.wait_for_spool(lambda spooled: spooled == 0)
        body = BODY + b" " * (3 * MIB - len(BODY))
        self.assertEqual(ask(self.server.connect(), QUERY + b"Content-Length: %d\r\n\r\n" % len(body), body).status, 200)

    def test_a_folder_that_takes_no_files_is_said_at_the_start(self):
        with self.assertRaisesRegex(AssertionError, "SPOOL_UNUSABLE: --spool-dir: .*'/proc/nowhere'"):
            Server("--spool-dir", "/proc/nowhere")

    def test_time_in_the_queue_is_time_of_the_question(self):
        self.serve("--request-seconds", 5, "--preload", "town=demo:town", memory=64 * MIB)
        hog = b"GET /v1/scenes/town/selfcheck?rays=100000 HTTP/1.1\r\nHost: x\r\n\r\n"
        hogs = [self.server.connect() for _ in range(2 * WORKERS)]
        for connection in hogs:
            self.addCleanup(connection.close)
            connection.sendall(hog)
        # As expensive as they are, so that it waits for them.
        everything = json.dumps({"boxes": [{"min": [-1e9] * 3, "max": [1e9] * 3}] * 1000, "timeout_ms": 1000}).encode()
        self.assertLess(len(everything), MIB)
        query = b"POST /v1/scenes/town/boxes:count HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n" % len(everything)
        answer = ask(self.server.connect(), query + everything)
        self.assertEqual((answer.status, answer.json()["code"]), (504, "DEADLINE"))

    def test_long_questions_leave_workers_to_short_ones(self):
        # Memory for all of them: this is about workers.
        self.serve("--preload", "town=demo:town", rate_seconds=PATIENCE, memory=256 * MIB)
        everything = json.dumps({"boxes": [{"min": [-1e9] * 3, "max": [1e9] * 3}] * 20_000}).encode()
        self.assertGreater(len(everything), MIB)
        heavy = [b"GET /v1/scenes/town/selfcheck?rays=100000 HTTP/1.1\r\nHost: x\r\n\r\n",
                 b"POST /v1/scenes/town/boxes:count HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n" % len(everything) + everything]
        for at in range(4 * WORKERS):
            connection = self.server.connect()
            self.addCleanup(connection.close)
            connection.sendall(heavy[at % 2])
        for _ in range(10):
            begin = time.monotonic()
            answer = ask(self.server.connect(), QUERY + b"Content-Length: %d\r\n\r\n" % len(BODY), BODY)
            self.assertEqual((answer.status, len(answer.json()["hits"])), (200, 3000))
            print(f"3000 rays beside {4 * WORKERS} long questions: {1000 * (time.monotonic() - begin):.0f} ms")
        self.addCleanup(self.server.kill)  # else it would wait for them

    def test_time_that_a_body_takes_is_not_the_questions(self):
        self.serve("--request-seconds", 1)
        connection = self.server.connect()
        with connection, connection.makefile("rb") as stream:
            connection.sendall(QUERY + b"Expect: 100-continue\r\nContent-Length: %d\r\n\r\n" % len(BODY))
            self.assertEqual((stream.readline(), stream.readline()), (b"HTTP/1.1 100 Continue\r\n", b"\r\n"))
            time.sleep(1.5)
            connection.sendall(BODY)
            self.assertEqual(read_answer(stream).status, 200)


if __name__ == "__main__":
    case_report.main()
