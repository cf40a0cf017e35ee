"""What happens on one connection, by raw sockets: order, unread bodies, and who owns the port."""

import select
import subprocess
import unittest

import case_report
from sightline_server import BINARY, PATIENCE, Server, curl, read_answer

ASK = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"
VERSION = b"GET /version HTTP/1.1\r\nHost: x\r\n\r\n"
END = b"GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"


class Connections(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six")
        cls.addClassCleanup(cls.server.end)

    def test_pipelined_requests_are_all_answered_in_order(self):
        answers = self.server.exchange(ASK, VERSION, ASK, VERSION, END)
        self.assertEqual([answer.status for answer in answers], [200] * 5)
        self.assertEqual(["version" in answer.json() for answer in answers], [False, True, False, True, False])

    def test_head_is_get_without_the_body(self):
        connection = self.server.connect()
        with connection, connection.makefile("rwb") as stream:
            stream.write(b"HEAD /v1/scenes/six HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
            stream.flush()
            text = stream.read()
        self.assertTrue(text.startswith(b"HTTP/1.1 200 ") and text.endswith(b"\r\n\r\n"), text)
        self.assertIn(b"Content-Length: %d\r\n" % len(curl(self.server.url + "/v1/scenes/six").body), text)
        # Compressed like it too [RFC9110] 8.6.
        told = [{name: value for name, value in curl(self.server.url + "/openapi.json", "-H", "Accept-Encoding: gzip", *method).headers.items()
                 if name not in ("date", "x-request-id")} for method in ((), ("--head",))]
        self.assertEqual(told[0], told[1])
        self.assertEqual(told[0]["content-encoding"], "gzip")

    def test_one_connection_answers_more_than_a_handful(self):
        self.assertEqual(len(self.server.exchange(ASK * 500, END)), 501)

    def test_an_unread_body_is_never_a_request(self):
        hidden = b"DELETE /v1/scenes/six HTTP/1.1\r\nHost: x\r\n\r\n"
        length = b"Host: x\r\nContent-Length: %d\r\n\r\n" % len(hidden)
        for head, status in [(b"POST /nothing HTTP/1.1\r\n", 404), (b"GET /healthz HTTP/1.1\r\n", 200),
                             (b"DELETE /v1/scenes/none HTTP/1.1\r\n", 404), (b"OPTIONS /version HTTP/1.1\r\n", 204),
                             (b"PUT /v1/scenes/.bad HTTP/1.1\r\n", 422)]:
            with self.subTest(head=head):
                answers = self.server.exchange(head, length, hidden, END)
                self.assertEqual([answer.status for answer in answers], [status, 200])
        self.assertEqual(curl(self.server.url + "/v1/scenes/six").status, 200)

    def test_after_an_unread_body_silence_is_no_late_header(self):
        with Server("--header-seconds", 1) as server, server.connect() as connection, connection.makefile("rwb") as stream:
            for _ in range(2):
                stream.write(b"POST /nothing HTTP/1.1\r\nHost: x\r\nContent-Length: 10\r\n\r\n" + b"x" * 10)
                stream.flush()
                self.assertEqual(read_answer(stream).status, 404)
                self.assertEqual(select.select([connection], [], [], 2.5)[0], [])

    def test_an_unread_chunked_or_long_body_ends_the_connection(self):
        hidden = b"DELETE /v1/scenes/six HTTP/1.1\r\nHost: x\r\n\r\n"
        chunked = b"Host: x\r\nTransfer-Encoding: chunked\r\n\r\n%x\r\n%s\r\n0\r\n\r\n" % (len(hidden), hidden)
        answers = self.server.exchange(b"POST /nothing HTTP/1.1\r\n", chunked, END)
        self.assertEqual([answer.status for answer in answers], [404])
        long = b"Host: x\r\nContent-Length: 1000000\r\n\r\n" + hidden * 100
        answers = self.server.exchange(b"POST /nothing HTTP/1.1\r\n", long)
        self.assertEqual([answer.status for answer in answers], [404])
        answers = self.server.exchange(b"BREW /healthz HTTP/1.1\r\nHost: x\r\n\r\n", hidden)
        self.assertEqual([answer.status for answer in answers], [405])
        self.assertEqual(curl(self.server.url + "/v1/scenes/six").status, 200)

    def test_a_chunked_query_is_answered(self):
        body = b'{"rays":[{"origin":[-10,1,0],"direction":[1,0,0]}],"fields":["t"]}'
        chunks = b"".join(b"1\r\n%c\r\n" % byte for byte in body) + b"0\r\n\r\n"
        answers = self.server.exchange(b"POST /v1/scenes/six/rays:closest HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n"
                                b"Content-Type: application/json\r\n\r\n", chunks)
        self.assertEqual([(answer.status, answer.body) for answer in answers], [(200, b'{"hits":[{"t":4.5}]}')])

    def test_an_answer_says_when_the_connection_ends_after_it(self):
        post = b"POST /v1/scenes/six/rays:any HTTP/1.1\r\nHost: x\r\n"
        for head, status in [
                (post + b"Content-Type: application/json\r\nContent-Length: 999999999999\r\n\r\n", 413),
                (post + b"Content-Type: text/plain\r\nContent-Length: 1000000\r\n\r\n", 415),
                (post + b"Transfer-Encoding: chunked\r\n\r\nno size\r\n", 400),
                (b"GET /healthz HTTP/1.0\r\n\r\n", 200), (END, 200)]:
            with self.subTest(head=head):
                answers = self.server.exchange(head)
                self.assertEqual([(answer.status, answer.headers.get("connection")) for answer in answers],
                                 [(status, "close")])
                self.assertNotIn("keep-alive", answers[0].headers)
        # Nothing is left unread here, so the connection stays.
        chunked = post + b"Transfer-Encoding: chunked\r\n\r\n"
        answers = self.server.exchange(chunked + b"c\r\n{\"rays\":[]]}\r\n0\r\n\r\n", chunked + b"b\r\n{\"rays\":[]}\r\n0\r\n\r\n", END)
        self.assertEqual([(answer.status, answer.headers.get("connection")) for answer in answers],
                         [(400, None), (200, None), (200, "close")])
        answers = self.server.exchange(post, b"\r\n", END)
        self.assertEqual([(answer.status, answer.headers.get("connection")) for answer in answers],
                         [(411, None), (200, "close")])

    def test_a_request_that_could_be_read_in_two_ways_is_400_and_ends_the_connection(self):
        post = b"POST /v1/scenes/six/rays:any HTTP/1.1\r\n"
        host, length, chunked = b"Host: x\r\n", b"Content-Length: 11\r\n", b"Transfer-Encoding: chunked\r\n"
        for head, code in [(host + length + length, "FRAMING_AMBIGUOUS"),
                           (host + length + b"content-length: 5\r\n", "FRAMING_AMBIGUOUS"),
                           (host + b"Content-Length: 11, 11\r\n", "FRAMING_AMBIGUOUS"),
                           (host + b"Content-Length: +11\r\n", "FRAMING_AMBIGUOUS"),
                           (host + b"Content-Length: 0x0b\r\n", "FRAMING_AMBIGUOUS"),
                           (host + chunked + length, "FRAMING_AMBIGUOUS"),
                           (host + chunked + chunked, "FRAMING_AMBIGUOUS"),
                           (host + b"Transfer-Encoding: gzip, chunked\r\n", "FRAMING_AMBIGUOUS"),
                           (host + b"Transfer-Encoding: identity\r\n", "FRAMING_AMBIGUOUS"),
                           (host + b"Transfer-Encoding: xchunked\r\n", "FRAMING_AMBIGUOUS"),
                           (length, "HOST_INVALID"), (host + host + length, "HOST_INVALID")]:
            with self.subTest(head=head):
                answers = self.server.exchange(post, head, b"\r\n", b'{"rays":[]}', ASK)
                self.assertEqual([(answer.status, answer.json()["code"], answer.headers.get("connection"))
                                  for answer in answers], [(400, code, "close")])
        for method in (b"GET", b"DELETE", b"OPTIONS"):
            answers = self.server.exchange(method + b" /healthz HTTP/1.1\r\n\r\n")
            self.assertEqual([answer.status for answer in answers], [400])

    def test_a_range_or_an_accepted_encoding_changes_nothing(self):
        plain = curl(self.server.url + "/version")
        for header in ("Range: bytes=0-1", "Range: bytes=0-1,2-3", "Accept-Encoding: gzip, br"):
            with self.subTest(header=header):
                answer = curl(self.server.url + "/version", "-H", header)
                self.assertEqual((answer.status, answer.body), (200, plain.body))

    def test_a_body_that_ends_early_is_400(self):
        connection = self.server.connect()
        with connection, connection.makefile("rwb") as stream:
            stream.write(b"POST /v1/scenes/six/rays:any HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                         b"Content-Length: 100\r\n\r\n{")
            stream.flush()
            connection.shutdown(1)  # no more from us
            answer = read_answer(stream)
        self.assertEqual((answer.status, answer.json()["code"]), (400, "BODY_INCOMPLETE"))

    def test_two_servers_do_not_share_a_port(self):
        second = subprocess.run([BINARY, "serve", "--listen", f"127.0.0.1:{self.server.port}"],
                                capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual((second.returncode, second.stdout), (2, ""))
        self.assertIn("LISTEN_FAILED", second.stderr)
        self.assertEqual(curl(self.server.url + "/healthz").status, 200)

    def test_more_than_a_thousand_descriptors_are_no_trouble(self):
        import resource
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        if hard < 1200:
            self.skipTest(f"only {hard} file descriptors allowed here")
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 2400) if hard >= 2400 else hard, hard))
        with Server("--workers", 1100) as server:
            held = [server.connect() for _ in range(1050)]
            try:
                # The last one has a descriptor that select() cannot hold.
                held[-1].sendall(END)
                with held[-1].makefile("rb") as stream:
                    self.assertEqual(read_answer(stream).status, 200)
            finally:
                for connection in held:
                    connection.close()


if __name__ == "__main__":
    case_report.main()
