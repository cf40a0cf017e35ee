"""Requests that lie about where they end, or are none: refused before a handler runs, and nothing hidden in them is run."""

import signal
import socket
import unittest

import case_report
from abuse_case import ASK, BODY, HEALTH, HIDDEN, QUERY, Abuse, print_floor, read_all
from sightline_server import read_answer

POST = b"POST /v1/scenes/six/rays:closest HTTP/1.1\r\n"
HOST = b"Host: x\r\n"
END = b"GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
LENGTH = b"Content-Length: %d\r\n" % len(BODY)
CHUNKED = b"Transfer-Encoding: chunked\r\n"


class Framing(Abuse):
    def test_conflicting_lengths(self):
        for fields in (LENGTH + b"Content-Length: 0\r\n", LENGTH + CHUNKED, CHUNKED + LENGTH, CHUNKED + CHUNKED,
                       b"Content-Length: 5, 5\r\n", b"Content-Length: -1\r\n", b"Content-Length: +5\r\n", b"Content-Length: 5 5\r\n",
                       b"Content-Length: 0x5\r\n", b"Content-Length: 5.0\r\n", b"Content-Length: %35\r\n", b"Content-Length:\r\n",
                       b"Content-Length: 18446744073709551616\r\n", b"Transfer-Encoding: identity\r\n",
                       b"Transfer-Encoding: chunked, gzip\r\n", b"Transfer-Encoding: \"chunked\"\r\n", b"Transfer-Encoding:\r\n"):
            with self.subTest(fields=fields):
                self.refused([POST + HOST + fields + b"\r\n", BODY, HIDDEN], 400, "FRAMING_AMBIGUOUS")
        self.refused([b"POST / HTTP/1.0\r\n" + CHUNKED + b"\r\n", HIDDEN], 400, "FRAMING_AMBIGUOUS")
        self.check_beside("conflicting lengths", lambda _: self.answers(POST + HOST + LENGTH + CHUNKED + b"\r\n", BODY, HIDDEN))

    def test_hosts(self):
        for fields in (b"", HOST + HOST, HOST + b"hOST: y\r\n", b"Host: a b\r\n", b"Host: a,b\r\n", b"Host: u@a\r\n", b"Host: a/b\r\n"):
            with self.subTest(fields=fields):
                self.refused([b"GET /healthz HTTP/1.1\r\n" + fields + b"\r\n", HIDDEN], 400, "HOST_INVALID")

    def test_heads_that_are_none(self):
        for head in (b"complete nonsense\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", b"GET /healthz\r\n\r\n",
                     b"GET /healthz HTTP/1.1\nHost: x\n\n", b"GET /healthz HTTP/1.1\rHost: x\r\n\r\n", b"\r\n\r\n\r\n\r\n",
                     b"GET /healthz HTTP/1.1\r\nHost: x\r\n folded: y\r\n\r\n", b"GET /healthz HTTP/1.1\r\nHost: x\r\nX : y\r\n\r\n",
                     b"GET /healthz HTTP/1.1\r\nHost: x\r\nX\r\n\r\n", b"GET /healthz HTTP/1.1\r\nHost: x\r\nX: a\0b\r\n\r\n",
                     b"GET /healthz HTTP/1.1\r\nHost: x\r\nX: a\rb\r\n\r\n", b"GET /he althz HTTP/1.1\r\nHost: x\r\n\r\n",
                     b"GET\t/healthz HTTP/1.1\r\nHost: x\r\n\r\n", b"G@T /healthz HTTP/1.1\r\nHost: x\r\n\r\n",
                     b" GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n", b"GET /healthz HTTP/1.1 \r\nHost: x\r\n\r\n"):
            with self.subTest(head=head):
                self.refused([head, HIDDEN], 400, "REQUEST_MALFORMED")
        for head in (b"PRI * HTTP/2.0\r\n\r\n", b"GET / HTTP/3.0\r\nHost: x\r\n\r\n", b"GET / HTTP/1.2\r\nHost: x\r\n\r\n"):
            self.refused([head, HIDDEN], 505, "VERSION_UNSUPPORTED")
        self.check_beside("heads that are none", lambda _: self.answers(b"\x16\x03\x01\x02\x00\x01\r\n\r\n", HIDDEN))

    def test_chunks_that_are_none(self):
        whole = b"%x\r\n%s\r\n0\r\n\r\n" % (len(BODY), BODY)
        for chunks in (b"+" + whole, b"-" + whole, b"0x" + whole, b" " + whole, whole.replace(b"\r\n", b"\n"), b"\r\n" + whole,
                       whole.replace(b"\r\n0\r\n", b"0\r\n"), b"fffffffffffffffff\r\n", b"zz\r\n" + whole,
                       b"1;" + b"x" * 20000 + b"\r\n", b"%x\r\n%s\r\n0\r\n" % (len(BODY), BODY) + b"T: " + b"x" * 20000 + b"\r\n\r\n"):
            with self.subTest(chunks=chunks[:40]):
                self.refused([POST + HOST + CHUNKED + b"\r\n", chunks, HIDDEN], 400, "BODY_INCOMPLETE")
        answers = self.answers(POST + HOST + CHUNKED + b"\r\n", b"%x;name=value\r\n%s\r\n0\r\nTrailer: x\r\n\r\n" % (len(BODY), BODY))
        self.assertEqual([answer.status for answer in answers], [200])
        self.check_beside("chunks that are none", lambda _: self.answers(POST + HOST + CHUNKED + b"\r\n", b"zz\r\n", HIDDEN))

    def test_an_unread_body_is_no_request(self):
        inside = b"Content-Length: %d\r\n\r\n" % len(HIDDEN) + HIDDEN
        for line, status in ((b"GET /healthz", 200), (b"POST /none", 404), (b"DELETE /v1/scenes/none", 404), (b"OPTIONS /version", 204),
                             (b"TRACE /version", 405)):
            with self.subTest(line=line):
                answers = self.answers(line + b" HTTP/1.1\r\nHost: x\r\n" + inside, END)
                self.assertEqual([answer.status for answer in answers], [status, 200])
        # Where the client was never told to send it, nobody knows whether it comes.
        answers = self.answers(b"POST /none HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\n" + inside, END)
        self.assertEqual([(answer.status, answer.headers.get("connection")) for answer in answers], [(404, "close")])
        self.check_beside("unread bodies", lambda _: self.answers(b"POST /none HTTP/1.1\r\nHost: x\r\n" + inside, END))

    def test_pipelining(self):
        answers = self.answers(ASK * 20, HEALTH, END)
        self.assertEqual([answer.status for answer in answers], [200] * 22)
        self.assertEqual({answer.body for answer in answers[:20]}, {b'{"hits":[{"t":4.5}]}'})
        # In whatever pieces they come.
        text = (ASK + HEALTH) * 3 + END
        for size in (1, 7, 64, 333):
            pieces = [text[at:at + size] for at in range(0, len(text), size)]
            self.assertEqual([answer.status for answer in self.answers(*pieces)], [200] * 7)
        self.check_beside("pipelining", lambda _: self.answers(ASK * 20, HEALTH, END))

    def test_expectations(self):
        head = POST + HOST + LENGTH
        self.refused([head + b"Expect: magic\r\n\r\n"], 417, "EXPECTATION_UNKNOWN")
        connection, _ = self.send(head + b"Expect: 100-Continue\r\nConnection: close\r\n\r\n")
        with connection, connection.makefile("rwb") as stream:
            self.assertEqual(read_answer(stream).status, 100)
            stream.write(BODY)
            stream.flush()
            self.assertEqual(read_answer(stream).status, 200)
        # A body that has begun without being told to needs no telling: in the middle of an answer it would stand.
        answers = self.answers(POST + HOST + LENGTH + b"Expect: 100-continue\r\nConnection: close\r\n\r\n" + BODY)
        self.assertEqual([answer.status for answer in answers], [200])
        # A body that will not be read is not asked for.
        answers = self.answers(POST + HOST + b"Content-Length: 999999999999\r\nExpect: 100-continue\r\n\r\n")
        self.assertEqual([answer.status for answer in answers], [413])
        # Nor does an empty one need it.
        answers = self.answers(b"GET /healthz HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\n\r\n", END)
        self.assertEqual([answer.status for answer in answers], [200, 200])

    def test_methods(self):
        for method, status in ((b"HEAD", 200), (b"OPTIONS", 204), (b"BREW", 405), (b"get", 405), (b"CONNECT", 405), (b"TRACE", 405)):
            with self.subTest(method=method):
                connection, _ = self.send(method + b" /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
                with connection, connection.makefile("rb") as stream:
                    text = stream.read()
                self.assertTrue(text.startswith(b"HTTP/1.1 %d " % status), text)
                if method in (b"HEAD", b"OPTIONS"):
                    self.assertTrue(text.endswith(b"\r\n\r\n"), text)
        self.refused([b"M" * 33 + b" / HTTP/1.1\r\nHost: x\r\n\r\n"], 400, "REQUEST_MALFORMED")
        # A whole URL is the path in it: proxies send it, and every server must take it.
        answers = self.answers(b"GET http://elsewhere/healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
        self.assertEqual([answer.status for answer in answers], [200])

    def test_half_closed_sockets(self):
        self.assertEqual([answer.status for answer in self.answers(ASK * 3, shut=True)], [200] * 3)
        self.assertEqual([answer.status for answer in self.answers(HEALTH + ASK[:-5], shut=True)], [200, 400])
        self.assertEqual(self.answers(ASK[:30], shut=True), [])
        self.assertEqual(self.answers(shut=True), [])
        self.check_beside("half-closed sockets", lambda _: self.answers(ASK * 3, HEALTH[:9], shut=True))

    def test_an_end_that_is_told_together_with_the_last_bytes_is_seen(self):
        for text, statuses in ((ASK[:-5], [400]), (ASK[:30], []), (ASK, [200]), (ASK + HEALTH[:9], [200])):
            connection = self.server.connect()
            connection.sendall(HEALTH)
            with connection.makefile("rb") as stream:
                self.assertEqual(read_answer(stream).status, 200)
            self.server.signal(signal.SIGSTOP)  # so that both are there when it looks
            connection.sendall(text)
            connection.shutdown(socket.SHUT_WR)
            self.server.signal(signal.SIGCONT)
            self.assertEqual([answer.status for answer in read_all(connection)], statuses)

    def test_paths_lead_nowhere_else(self):
        for path in (b"/../../etc/passwd", b"/v1/scenes/../../etc/passwd", b"/v1/scenes/%2e%2e%2f%2e%2e%2fetc%2fpasswd",
                     b"/v1/scenes/..%2f..%2fetc/stats", b"/v1/scenes/..", b"/v1/scenes/%00", b"//etc/passwd", b"/v1//scenes",
                     b"/v1/scenes/six/../six", b"*", b"/%", b"/%zz", b"\\..\\..", b"/v1/scenes/six%0d%0aX:y"):
            for method in (b"GET", b"DELETE", b"HEAD"):
                with self.subTest(path=path, method=method):
                    connection, _ = self.send(method + b" " + path + b" HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
                    with connection, connection.makefile("rb") as stream:
                        text = stream.read()
                    self.assertIn(text.split()[1], (b"404", b"405", b"422"), text)
                    self.assertNotIn(b"root:", text)
        put = b"PUT /v1/scenes/%s HTTP/1.1\r\nHost: x\r\nContent-Length: 1\r\nConnection: close\r\n\r\nx"
        for name in (b"..", b"%2e%2e", b"a%2f..%2fb", b"a%5cb", b".hidden", b"%00", b"a%00", b"con%3a", b"x" * 129):
            with self.subTest(name=name):
                self.assertEqual([(answer.status, answer.json()["code"]) for answer in self.answers(put % name)],
                                 [(422, "SCENE_ID_INVALID")])

    def test_names_in_every_alphabet(self):
        for name in ("é", "дом", "房子", "בית", "घर", "🏠", "a\u202eb", "ａ", "ſ", "İ", "e\u0301", "\u200b"):
            raw = name.encode()
            for spelled in (raw, b"".join(b"%%%02x" % byte for byte in raw)):
                with self.subTest(name=name, spelled=spelled):
                    answers = self.answers(b"PUT /v1/scenes/" + spelled + b" HTTP/1.1\r\nHost: x\r\nContent-Length: 1\r\nConnection: close\r\n\r\nx")
                    self.assertEqual([(answer.status, answer.json()["code"]) for answer in answers], [(422, "SCENE_ID_INVALID")])
        # Bytes that are no UTF-8 at all.
        answers = self.answers(b"PUT /v1/scenes/\xff\xfe HTTP/1.1\r\nHost: x\r\nContent-Length: 1\r\nConnection: close\r\n\r\nx")
        self.assertEqual([answer.status for answer in answers], [422])
        self.check_ordinary("names in every alphabet")

    def test_headers_split_no_answer(self):
        for given in (b"a%0d%0aInjected: yes", b"a\tb", b"\xff", b"x" * 5000):
            connection, _ = self.send(b"GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\nX-Request-Id: " + given + b"\r\n\r\n")
            answers = read_all(connection)
            self.assertEqual([(answer.status, "injected" in answer.headers) for answer in answers], [(200, False)])
            self.assertRegex(answers[0].headers["x-request-id"], "^[0-9a-f]{16}$")


def tearDownModule():
    print_floor()


if __name__ == "__main__":
    case_report.main()
