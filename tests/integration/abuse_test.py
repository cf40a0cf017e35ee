"""Clients that are silent, slow, greedy or gone: others are answered all the while, and memory stays.

Prints `floor 1: ...` at the end.
"""

import gzip
import json
import resource
import select
import socket
import struct
import threading
import time
import unittest

import case_report
from abuse_case import BODY, HEALTH, MIB, QUERY, ROW, Abuse, is_closed, print_floor, read_all, resident, sip, trickle
from sightline_server import PATIENCE, Server, curl, read_answer

MANY = 64  # twice the workers of either kind


class HoldingOn(Abuse):
    def hold(self, case, *pieces, count=MANY, **options):
        held = [self.send(*pieces, **options)[0] for _ in range(count)]
        self.addCleanup(lambda: [connection.close() for connection in held])
        self.check_ordinary(case)
        return held

    def expect_all(self, held, status, code):
        for connection in held:
            answers = read_all(connection)
            self.assertEqual([(answer.status, answer.json()["code"]) for answer in answers], [(status, code)])

    def test_a_thousand_idle_connections(self):
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        count = min(1000, hard - 200)
        held = self.hold(f"{count} idle connections", count=count)
        for connection in held[:10] + held[-10:]:
            connection.sendall(HEALTH)
            with connection.makefile("rb") as stream:
                self.assertEqual(read_answer(stream).status, 200)

    def test_slow_headers(self):
        held = self.hold("slow headers", b"GET /healthz HTTP/1.1\r\nHost: x\r\nX: ", count=200)
        self.assertEqual(trickle(held, PATIENCE), [])
        self.expect_all(held, 408, "REQUEST_TIMEOUT")

    def test_slow_bodies(self):
        for case, head in [("slow bodies", b"Content-Length: 10000\r\n\r\n{"),
                           ("slow long bodies", b"Content-Length: 10000000\r\n\r\n{"),
                           ("slow chunked bodies", b"Transfer-Encoding: chunked\r\n\r\nffffff\r\n{"),
                           ("bodies that never come after a 100", b"Content-Length: 10\r\nExpect: 100-continue\r\n\r\n")]:
            with self.subTest(case=case):
                held = self.hold(case, QUERY + head, count=24)
                if "100" in case:
                    for connection in held:
                        self.assertEqual(connection.recv(100), b"HTTP/1.1 100 Continue\r\n\r\n")
                self.assertEqual(trickle(held, PATIENCE, b"" if "100" in case else b" "), [])
                self.expect_all(held, 408, "REQUEST_TIMEOUT")

    def test_more_slow_bodies_than_workers(self):
        held = self.hold("more slow long bodies than workers", QUERY + b"Content-Length: 10000000\r\n\r\n{", count=600)
        statuses = {answer.status for connection in held for answer in read_all(connection)}
        self.assertEqual(statuses, {408})

    def test_clients_that_do_not_read(self):
        # Rows of 3,000 hits with everything: some 700 kB each, of which the kernel takes a part.
        rays = json.dumps({"rays": [ROW] * 3000, "fields": ["t", "triangle", "position", "normal", "barycentrics"]})
        body = rays.encode()
        answer = self.server.query("six", "closest", body)
        if answer.status != 200:
            body = json.dumps({"rays": [ROW] * 30000}).encode()
            answer = self.server.query("six", "closest", body)
        self.assertEqual(answer.status, 200)
        held = self.hold(f"answers of {len(answer.body)} bytes that nobody reads",
                         QUERY + b"Content-Length: %d\r\n\r\n" % len(body), body, count=150, receive_buffer=4096)
        # A little now and then is too slow as well: the connections are reset with most of the answer unsent.
        self.assertEqual(sip(held, PATIENCE), [])

    def test_a_slow_reader_that_is_fast_enough_gets_everything(self):
        body = json.dumps({"rays": [ROW] * 30000, "fields": ["t"]}).encode()
        connection, _ = self.send(QUERY + b"Content-Length: %d\r\nConnection: close\r\n\r\n" % len(body), body, receive_buffer=4096)
        whole = b""
        with connection:
            while piece := connection.recv(2000):
                whole += piece
                time.sleep(0.001)
        self.assertEqual(len(json.loads(whole.partition(b"\r\n\r\n")[2])["hits"]), 30000)

    def test_a_reader_is_slow_by_what_it_takes_and_not_by_what_the_system_holds_for_it(self):
        # A send buffer of megabytes tells of room only when a third of it is free.
        with Server("--preload", "six=demo:six", "--rate-seconds", 2) as server:
            body = json.dumps({"rays": [ROW] * 250_000, "fields": ["t", "position"]}).encode()
            connection, whole = server.connect(), b""
            with connection:
                connection.sendall(QUERY + b"Content-Length: %d\r\nConnection: close\r\n\r\n" % len(body) + body)
                end = time.monotonic() + 5
                while time.monotonic() < end:
                    whole += connection.recv(16_000)
                    time.sleep(0.1)
                whole += b"".join(iter(lambda: connection.recv(1 << 20), b""))
            self.assertEqual(len(json.loads(whole.partition(b"\r\n\r\n")[2])["hits"]), 250_000)

    def test_pipelined_floods_that_nobody_reads(self):
        held = [self.send(receive_buffer=4096)[0] for _ in range(20)]
        for connection in held:
            connection.setblocking(False)
            try:
                for _ in range(200):
                    connection.send(HEALTH * 100)
            except BlockingIOError:
                pass
        self.check_ordinary("pipelined floods that nobody reads")
        for connection in held:
            connection.close()

    def test_a_client_that_has_always_begun_the_next_request(self):
        request = HEALTH[:-2] + b"X: " + b"y" * 7000 + b"\r\n\r\n"
        rounds = 3000 if not self.is_sanitized else 300
        before = resident(self.server)[0]
        connection, _ = self.send(request[:3000])
        with connection, connection.makefile("rb") as stream:
            for _ in range(rounds):
                connection.sendall(request[3000:] + request[:3000])
                self.assertEqual(read_answer(stream).status, 200)
            if not self.is_sanitized:
                self.assertLess(resident(self.server)[0] - before, rounds * len(request) / 2)
            self.check_ordinary("a client that has always begun its next request")

    def test_clients_that_go_away(self):
        body = json.dumps({"rays": [ROW] * 10000, "fields": ["t"]}).encode()

        def come_and_go(turn):
            whole = QUERY + b"Content-Length: %d\r\n\r\n" % len(body) + body
            connection, _ = self.send(whole[:len(whole) * (turn % 5) // 4])
            if turn % 2 == 0:  # a reset and not a farewell
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            connection.close()
        self.check_beside("clients that go away in the middle", come_and_go, clients=2)

    def test_long_heads_that_never_end_share_what_there_is(self):
        half = HEALTH[:-2] + (b"X: " + b"y" * 990 + b"\r\n") * 15
        with Server("--memory", 2 * MIB, "--header-seconds", PATIENCE) as server:
            held = [server.connect() for _ in range(200)]
            for connection in held:
                connection.sendall(half)
            # A megabyte is some 60 of them, on a busy machine not those that came first. The others are told, and short
            # heads come in all the while.
            poll, told, end = select.poll(), set(), time.monotonic() + PATIENCE
            by_number = {connection.fileno(): connection for connection in held}
            for number in by_number:
                poll.register(number, select.POLLIN)
            while ((ready := poll.poll(500)) or len(told) < 100) and time.monotonic() < end:
                for number, _ in ready:
                    poll.unregister(number)
                    told.add(number)
            self.assertGreaterEqual(len(told), 100)
            for number in told:
                answers = read_all(by_number.pop(number))
                self.assertEqual([(answer.status, answer.json()["code"], answer.headers["retry-after"]) for answer in answers],
                                 [(503, "MEMORY_BUSY", "1")])
            self.assertEqual(curl(server.url + "/healthz").status, 200)
            # Who holds some gets its answer, and what it held is for others again.
            kept = 0
            for connection in by_number.values():
                connection.sendall(b"\r\n")
                with connection, connection.makefile("rb") as stream:
                    kept += read_answer(stream).status == 200
            self.assertGreaterEqual(kept, 30)
            for turn in range(200):
                with server.connect() as connection, connection.makefile("rb") as stream:
                    for piece in (half[:9000], half[9000:], b"\r\n"):
                        connection.sendall(piece)
                    answer = read_answer(stream)
                    self.assertTrue(answer.status == 200 or turn < 100, answer.body)

    def test_short_answers_that_nobody_reads_share_what_there_is(self):
        # Of 9 to 16 kB; the kernel takes the first ones, and a part of the last one that differs.
        def asking(width):
            body = b'{"generator":{"kind":"equirectangular","width":%d,"height":10}}' % width
            return b"POST /v1/rays:generate HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n" % len(body) + body
        with Server("--memory", 2 * 65536, "--rate-seconds", PATIENCE) as server:
            held = [socket.socket() for _ in range(60)]
            for number, connection in enumerate(held):
                self.addCleanup(connection.close)
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2304)
                connection.settimeout(PATIENCE)
                connection.connect(("127.0.0.1", server.port))
                connection.sendall(asking(12 + number % 10) * 400)
            # A few have a part of the memory; what the others have not read is in temporary files.
            end = time.monotonic() + PATIENCE
            while server.spooled() < 20 * 4096:
                self.assertLess(time.monotonic(), end)
                self.assertLessEqual(server.traffic(), 2 * 65536)
            self.assertEqual(curl(server.url + "/healthz").status, 200)
            for number in (0, 59):
                with held[number].makefile("rb") as stream:
                    self.assertEqual({read_answer(stream).status for _ in range(400)}, {200})
            for connection in held:
                connection.close()
            while server.spooled() > 0:
                self.assertLess(time.monotonic(), end)

    def test_connections_beyond_the_limit_close_the_idlest(self):
        with Server("--preload", "six=demo:six", "--max-connections", 50) as server:
            held = [server.connect() for _ in range(49)]
            held[0].sendall(b"GET /healthz")
            new = [server.connect() for _ in range(30)]
            for connection in new[-5:]:
                connection.sendall(HEALTH)
                with connection.makefile("rb") as stream:
                    self.assertEqual(read_answer(stream).status, 200)
            self.assertTrue(is_closed(held[1]))
            for connection in held + new:
                connection.close()

    def test_a_full_queue_is_503_with_retry_after(self):
        with Server("--preload", "town=demo:town", "--workers", 8, "--max-queue", 1, "--rate-seconds", 5) as server:
            held = [server.connect() for _ in range(40)]
            for connection in held:
                connection.sendall(b"GET /v1/scenes/town/selfcheck?rays=100000 HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
            refused = 0
            for connection in held:
                if not select.select([connection], [], [], 0.2)[0]:
                    continue
                with connection.makefile("rb") as stream:
                    answer = read_answer(stream)
                if answer is not None and answer.status == 503:
                    self.assertEqual((answer.json()["code"], answer.headers["retry-after"]), ("QUEUE_FULL", "1"))
                    refused += 1
            self.assertGreater(refused, 0)
            self.assertEqual(curl(server.url + "/healthz").status, 200)
            for connection in held:
                connection.close()

    def test_who_has_left_waits_no_longer(self):
        # 8 workers: 4 may wait for a load. They leave; and their places are free again.
        with Server("--workers", 8, "--rate-seconds", 100) as server:
            upload = server.connect()
            upload.sendall(b"PUT /v1/scenes/held HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: 1000\r\n\r\n")
            with upload.makefile("rb") as stream:
                self.assertEqual(read_answer(stream).status, 100)
            end = time.monotonic() + PATIENCE
            for reset in (True, False):
                waiters = [server.connect() for _ in range(4)]
                for i, waiter in enumerate(waiters):
                    waiter.sendall(b"GET /v1/scenes/held?wait=%d HTTP/1.1\r\nHost: x\r\nX-Request-Id: %d-%d\r\n\r\n" % (PATIENCE, reset, i))
                while server.ask("/v1/scenes/held?wait=1").json()["state"] != "loading":
                    pass
                for waiter in waiters:
                    if reset:
                        waiter.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                    waiter.close()
                # Their requests end, and so the next four wait as well.
                while not all(f" id={int(reset)}-{i} " in server.log_text().replace("\n", " ") for i in range(4)):
                    self.assertLess(time.monotonic(), end)
            while 'event="gone"} 8' not in server.ask("/metrics").body.decode():
                self.assertLess(time.monotonic(), end)
            upload.close()


class Greed(Abuse):
    ARGUMENTS = ("--max-query-bytes", 100000, "--rate-seconds", 2)

    def test_oversized_bodies(self):
        self.refused([QUERY + b"Content-Length: 999999999999\r\n\r\n", b"{" * 10000], 413, "BODY_TOO_LARGE")
        chunks = b"2000\r\n" + b" " * 0x2000 + b"\r\n"
        self.refused([QUERY + b"Transfer-Encoding: chunked\r\n\r\n", chunks * 20, b"0\r\n\r\n"], 413, "BODY_TOO_LARGE")

        def go_on(_):
            connection, _ = self.send(QUERY + b"Transfer-Encoding: chunked\r\n\r\n")
            with connection, self.assertRaises(ConnectionError):
                for _ in range(100000):
                    connection.sendall(chunks)
        # One that never ends is broken off after it was told.
        go_on(0)
        self.check_beside("oversized bodies", go_on)

    def test_compressed_bodies(self):
        bomb = gzip.compress(b" " * (64 << 20))
        # [RFC8878] 3.1.1: a window of 1 MiB, then blocks that are one blank 131,072 times: 128 MiB in 4 KiB.
        repeated = struct.pack("<I", 131072 << 3 | 1 << 1)[:3] + b" "
        zstd_bomb = b"\x28\xb5\x2f\xfd\x00\x50" + repeated * 1024

        def try_all(_):
            for coding, body, status, code in (
                    (b"gzip", bomb, 413, "BODY_TOO_LARGE"), (b"zstd", zstd_bomb, 413, "BODY_TOO_LARGE"),
                    (b"zstd", bomb, 400, "ENCODING_BROKEN"), (b"gzip", zstd_bomb, 400, "ENCODING_BROKEN"),
                    (b"br", bomb, 415, "ENCODING_UNSUPPORTED"), (b"deflate", bomb, 415, "ENCODING_UNSUPPORTED"),
                    (b"identity, gzip", bomb, 415, "ENCODING_UNSUPPORTED")):
                head = QUERY + b"Content-Encoding: %s\r\nContent-Length: %d\r\n\r\n" % (coding, len(body))
                answers = self.answers(head, body, shut=True)
                self.assertEqual([(answer.status, answer.json()["code"]) for answer in answers[:1]], [(status, code)])
        try_all(0)
        self.check_beside("compressed bodies", try_all)

    def test_a_million_tiny_chunks(self):
        connection, _ = self.send(QUERY + b"Transfer-Encoding: chunked\r\n\r\n")
        sender = threading.Thread(target=self.send_quietly, args=(connection, b"1\r\n \r\n" * 1000, 1000))
        sender.start()
        self.check_ordinary("a million chunks of a byte")
        self.assertEqual([answer.status for answer in read_all(connection)][:1], [413])
        sender.join()
        small = b"".join(b"1\r\n%c\r\n" % byte for byte in BODY)
        answers = self.answers(QUERY + b"Transfer-Encoding: chunked\r\n\r\n", small, b"0\r\n\r\n")
        self.assertEqual([answer.body for answer in answers], [b'{"hits":[{"t":4.5}]}'])

    @staticmethod
    def send_quietly(connection, piece, times):
        try:
            for _ in range(times):
                connection.sendall(piece)
        except OSError:
            pass

    def test_header_floods(self):
        self.refused([b"GET / HTTP/1.1\r\nHost: x\r\n", b"X: y\r\n" * 200, b"\r\n"], 431, "HEADER_TOO_LARGE")
        self.refused([b"GET / HTTP/1.1\r\nHost: x\r\n" + b"X: " + b"y" * 60000], 431, "HEADER_TOO_LARGE")
        self.refused([b"GET / HTTP/1.1\r\nHost: x\r\n" + (b"X: " + b"y" * 1000 + b"\r\n") * 60], 431, "HEADER_TOO_LARGE")
        self.refused([b"GET /" + b"y" * 60000], 414, "URI_TOO_LONG")
        self.check_beside("floods of header fields",
                          lambda _: self.send(b"GET / HTTP/1.1\r\n", b"X-A: y\r\n" * 1000)[0].close())

    def test_ranges_cut_nothing(self):
        many = b"Range: bytes=" + b",".join(b"%d-" % i for i in range(1300)) + b"\r\n"
        plain = self.answers(b"GET /version HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")[0]

        def ask_all(_):
            for given in (many, b"Range: bytes=0-1\r\n", b"Range: x\r\n", b"If-Range: \"x\"\r\nRange: bytes=9-1\r\n"):
                answers = self.answers(b"GET /version HTTP/1.1\r\nHost: x\r\nConnection: close\r\n", given, b"\r\n")
                self.assertEqual([(answer.status, answer.body) for answer in answers], [(200, plain.body)])
        ask_all(0)
        self.check_beside("ranges", ask_all)


def tearDownModule():
    print_floor()


if __name__ == "__main__":
    case_report.main()
