"""What the tests of abuse share: a server with short times, a measure of ordinary requests, raw sockets."""

import json
import select
import socket
import statistics
import threading
import time
import unittest

from process_status import status_bytes
from sightline_server import PATIENCE, Server, read_answer

MIB = 1 << 20
ROW = {"origin": [-10, 1, 0], "direction": [1, 0, 0]}
BODY = json.dumps({"rays": [ROW], "fields": ["t"]}).encode()
ASK = (b"POST /v1/scenes/six/rays:closest HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nContent-Length: %d\r\n\r\n"
       % len(BODY)) + BODY
HEALTH = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"
QUERY = b"POST /v1/scenes/six/rays:closest HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
HIDDEN = b"DELETE /v1/scenes/six HTTP/1.1\r\nHost: x\r\n\r\n"
medians, memories = [], []


def resident(server):
    with open(f"/proc/{server.process.pid}/status", encoding="ascii") as lines:
        sizes = {line.split(":")[0]: int(line.split()[1]) << 10 for line in lines if line.startswith(("VmRSS", "VmSize"))}
    return sizes["VmRSS"], sizes["VmSize"]


def read_all(connection):
    """Every answer until the connection ends, also by a reset."""
    answers = []
    with connection, connection.makefile("rb") as stream:
        try:
            while (answer := read_answer(stream)) is not None:
                answers.append(answer)
        except (ConnectionError, IndexError):
            pass
    return answers


def is_closed(connection):
    """Whether the server has ended the connection (reads over what it still said)."""
    try:
        connection.settimeout(PATIENCE)
        while connection.recv(65536):
            pass
    except ConnectionError:
        pass
    except socket.timeout:
        return False
    return True


class Abuse(unittest.TestCase):
    ARGUMENTS = ("--header-seconds", 2, "--rate-seconds", 2, "--body-seconds", 30)

    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", *cls.ARGUMENTS)
        cls.addClassCleanup(cls.server.end)
        for _ in range(100):
            cls.send(ASK)[0].close()
        cls.idle, size = resident(cls.server)
        cls.is_sanitized = size > 1 << 40

    @classmethod
    def send(cls, *pieces, shut=False, receive_buffer=None):
        """A connection on which all pieces were sent, and it."""
        if receive_buffer is None:
            connection = cls.server.connect()
        else:
            connection = socket.socket()
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
            connection.settimeout(PATIENCE)
            connection.connect(("127.0.0.1", cls.server.port))
        try:
            for piece in pieces:
                connection.sendall(piece)
            if shut:
                connection.shutdown(socket.SHUT_WR)
        except ConnectionError:
            pass  # it has an answer already, and a close
        return connection, pieces

    def answers(self, *pieces, **options):
        return read_all(self.send(*pieces, **options)[0])

    def refused(self, pieces, status, code, **options):
        """One answer with this status, and the end of the connection."""
        answers = self.answers(*pieces, **options)
        self.assertEqual([(answer.status, answer.json()["code"], answer.headers.get("connection")) for answer in answers],
                         [(status, code, "close")])
        self.assertEqual(answers[0].headers["content-type"], "application/problem+json")
        self.assertIn("x-request-id", answers[0].headers)

    def check_ordinary(self, case, peak=False):
        """An ordinary request is answered, alone on its connection, and memory is where it was; with `peak` it always was."""
        times = []
        for _ in range(20):
            begin = time.perf_counter()
            connection = self.server.connect()
            with connection, connection.makefile("rb") as stream:
                connection.sendall(ASK)
                answer = read_answer(stream)
            times.append((time.perf_counter() - begin) * 1000)
            self.assertEqual((answer.status, answer.body), (200, b'{"hits":[{"t":4.5}]}'))
        now = status_bytes(self.server, "VmHWM") if peak else resident(self.server)[0]
        more = max(0, now - self.idle) / MIB
        median = statistics.median(times)
        medians.append((median, case))
        print(f"{case}: median of 20 ordinary requests {median:.2f} ms, worst {max(times):.2f} ms, {more:.1f} MiB above idle")
        if not self.is_sanitized:
            memories.append((more, case))
            self.assertLess(more, 128, case)

    def check_beside(self, case, attack, clients=1):
        """As check_ordinary, while clients do `attack` (which is given the turn's number) again and again."""
        stop, faults = threading.Event(), []

        def go_on():
            turn = 0
            try:
                while not stop.is_set():
                    attack(turn)
                    turn += 1
            except Exception as fault:  # a thread's own end would not fail the test
                faults.append(fault)
        attackers = [threading.Thread(target=go_on) for _ in range(clients)]
        for attacker in attackers:
            attacker.start()
        try:
            self.check_ordinary(case)
        finally:
            stop.set()
            for attacker in attackers:
                attacker.join()
        self.assertEqual(faults, [])

    def tearDown(self):
        self.assertIsNone(self.server.process.poll(), "the server ended: " + self.server.log_text()[-2000:])
        self.assertEqual(self.server.ask("/v1/scenes/six").status, 200, "a hidden request was run")


def print_floor():
    """The first floor of what a server must withstand; a figure, not an assertion: machines differ."""
    if medians:
        (median, case), (more, greedy) = max(medians), max(memories, default=(0, "not measured"))
        verdict = "ok" if median <= 100 and more < 128 else "short"
        print(f"floor 1: {len(medians)} cases, ordinary request at most {median:.2f} ms ({case}), memory at most "
              f"{more:.1f} MiB above idle ({greedy}) (needs 100 ms, 128 MiB) {verdict}")


def trickle(connections, seconds, byte=b"x"):
    """Sends a byte per 100 ms on each until they are all ended or time is over. Returns those that are not."""
    end = time.monotonic() + seconds
    left = list(connections)
    while left and time.monotonic() < end:
        for connection in list(left):
            try:
                connection.send(byte)
            except OSError:
                left.remove(connection)
        ended, _, _ = select.select(left, [], [], 0.1)
        for connection in ended:
            left.remove(connection)
    return left


def sip(connections, seconds, size=16, pause=0.1):
    """Takes `size` bytes per `pause` seconds from each until all are ended or time is over. Returns those that are not."""
    end = time.monotonic() + seconds
    left = list(connections)
    while left and time.monotonic() < end:
        for connection in list(left):
            try:
                connection.setblocking(False)
                if not connection.recv(size):
                    left.remove(connection)
            except BlockingIOError:
                pass
            except ConnectionError:
                left.remove(connection)
        select.select([], [], [], pause)
    return left
