"""Answers that are read slowly keep nobody who asks for little from an answer."""

import json
import socket
import threading
import unittest

import case_report
from abuse_case import QUERY, ROW
from sightline_server import PATIENCE, Server, read_answer

READERS = 12
ANSWERED = b"HTTP/1.1 200"


def request(**members):
    body = json.dumps(members).encode()
    return QUERY + b"Content-Length: %d\r\n\r\n" % len(body) + body


class SlowReaders(unittest.TestCase):
    # No client is too slow here.
    ARGUMENTS = ("--min-rate", 1, "--rate-seconds", PATIENCE, "--busy-rate", 1, "--memory", 64 << 20)

    def setUp(self):
        self.server = Server("--preload", "six=demo:six", *self.ARGUMENTS)
        self.addCleanup(self.server.end)
        self.stop = threading.Event()
        self.held, self.lock = [], threading.Lock()

    def hold(self):
        """Asks until an answer begins, and takes no more of it."""
        camera = {"kind": "pinhole", "position": [0, 9, 30], "look_at": [0, 0, 0], "fov_y": 10,
                  "width": 300, "height": 200}
        large = request(generator=camera, fields=["t", "position", "normal", "triangle", "node"])
        while not self.stop.is_set():
            connection = socket.socket()
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            connection.settimeout(PATIENCE)
            try:
                connection.connect(("127.0.0.1", self.server.port))
                connection.sendall(large)
                begin = connection.recv(len(ANSWERED))
            except OSError:
                begin = b""  # the server is ended
            if begin == ANSWERED:
                with self.lock:
                    self.held.append(connection)
                return
            connection.close()
            self.stop.wait(0.05)

    def test_little_is_answered_beside_them(self):
        readers = [threading.Thread(target=self.hold) for _ in range(READERS)]
        for reader in readers:
            reader.start()

        def end():
            self.stop.set()
            self.server.kill()  # else it would wait for its readers
            for reader in readers:
                reader.join()
            for connection in self.held:
                connection.close()
        self.addCleanup(end)
        # Two answers, of which the client's system has not taken all; the others wait for what these have.
        while len(self.held) < 2:
            self.assertIsNone(self.server.process.poll())
        # More than what is free to everybody, and less than what would have to wait.
        little = request(rays=[ROW] * 1500, timeout_ms=2000)
        for _ in range(40):
            connection = self.server.connect()
            with connection, connection.makefile("rb") as stream:
                connection.sendall(little)
                answer = read_answer(stream)
            self.assertEqual((answer.status, answer.json().get("code")), (200, None))
            self.assertEqual(len(answer.json()["hits"]), 1500)


if __name__ == "__main__":
    case_report.main()
