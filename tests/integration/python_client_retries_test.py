"""proto/python/sightline.py against servers that fail in each way, and against replicas that are killed."""

import contextlib
import email.utils
import http.client
import json
import pickle
import socket
import socketserver
import struct
import sys
import tempfile
import threading
import time
import types
import unittest
from pathlib import Path

import case_report
from sightline_server import SOURCE, Server, demo_glb

sys.path.insert(0, str(SOURCE / "proto/python"))
import sightline  # noqa: E402  (found only now)

ANSWER = json.dumps({"scenes": [], "hits": [True], "id": "job", "state": "ready", "revision": 7, "code": "BUSY"}).encode()
# What a failing server does after a request, besides answering a status.
FAULTS = ("close", "reset", "hang", "garbage", "half head", "cut line", "half body", "half chunk")
RAY = [[-10, 1, 0]], [[1, 0, 0]]
SERVERS = {}  # By port.


class FailingServer(socketserver.ThreadingTCPServer):
    """Answers each request as the next entry of `plan` says: a status, (status, headers), or one of FAULTS; then 200."""

    allow_reuse_address = daemon_threads = True
    request_queue_size = 64

    def __init__(self, test, plan=()):
        self.plan, self.asked, self.heads, self.connections, self.end = list(plan), [], [], 0, threading.Event()
        self.has_read, self.is_hanging = threading.Semaphore(0), False
        super().__init__(("127.0.0.1", 0), Exchange)
        SERVERS[self.server_address[1]] = self
        self.url = f"http://127.0.0.1:{self.server_address[1]}"
        thread = threading.Thread(target=self.serve_forever, args=(0.01,))
        thread.start()
        test.addCleanup(thread.join)
        test.addCleanup(self.server_close)
        test.addCleanup(self.shutdown)
        test.addCleanup(self.end.set)


class Exchange(socketserver.StreamRequestHandler):
    def handle(self):
        self.server.connections += 1
        while self.exchange():
            pass

    def exchange(self):
        """False at the end of the connection."""
        with contextlib.suppress(ConnectionError):
            line, head = self.rfile.readline().decode(), {}
            while (text := self.rfile.readline().decode().strip()):
                name, _, value = text.partition(":")
                head[name.lower()] = value.strip()
            if not line:
                return False
            self.rfile.read(int(head.get("content-length", 0)))
            self.server.asked.append(line.split()[0])
            self.server.heads.append(head)
            step = self.server.plan.pop(0) if self.server.plan else 200
            self.server.is_hanging = step == "hang"
            self.server.has_read.release()
            return self.answer(*step) if isinstance(step, tuple) else self.answer(step, {}) if isinstance(step, int) else self.fail(step)
        return False

    def answer(self, status, headers):
        body = b"" if status == 204 else ANSWER
        lines = [f"HTTP/1.1 {status} X", *(f"{name}: {value}" for name, value in {"Content-Length": len(body), **headers}.items())]
        self.wfile.write(("\r\n".join(lines) + "\r\n\r\n").encode() + body)
        return True

    def fail(self, how):
        if how == "reset":
            self.request.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        elif how == "hang":
            self.server.end.wait()
        elif how == "garbage":
            self.wfile.write(b"\x16\x03\x01 no HTTP\r\n\r\n")
        elif how == "half head":
            self.wfile.write(b"HTTP/1.1 200 OK\r\n")
        elif how == "cut line":
            self.wfile.write(b"HTTP/1.1 200 OK\r\nContent-Le")
        elif how == "half body":
            self.wfile.write(b"HTTP/1.1 200 OK\r\nContent-Length: 1000\r\n\r\n" + ANSWER)
        elif how == "half chunk":
            self.wfile.write(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n100\r\n" + ANSWER)
        return False


class Connection(http.client.HTTPConnection):
    """Waits as long as the server may answer: no test depends on a time."""

    def getresponse(self):
        server = SERVERS[self.port]
        server.has_read.acquire()
        if server.is_hanging:
            self.sock.settimeout(0.01)
        return super().getresponse()


class Clock:
    """In place of the module time: a sleep takes no time, and is noted."""

    def __init__(self):
        self.now, self.waits = 1000.0, []

    def monotonic(self):
        return self.now

    def time(self):
        return time.time()

    def sleep(self, seconds):
        self.waits.append(seconds)
        self.now += seconds


class Failing(unittest.TestCase):
    def setUp(self):
        self.clock = Clock()
        self.addCleanup(setattr, sightline, "time", sightline.time)
        sightline.time = self.clock

    def client(self, *servers, **options):
        urls = [getattr(each, "url", each) for each in servers]
        client = sightline.Sightline(urls if len(urls) > 1 else urls[0], **options)
        for pool in client._pools:
            pool._kind = Connection
        self.addCleanup(client.close)
        return client

    def nobody(self):
        """An address where no server listens."""
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            return f"http://127.0.0.1:{probe.getsockname()[1]}"

    def in_order(self, *servers):
        """The servers in the order in which the scene "six" asks them."""
        client = self.client(*servers)
        by_url = {server.url: server for server in servers}
        return [by_url[pool.url] for pool in client._servers("six")]


class OneServer(Failing):
    def setUp(self):
        super().setUp()
        self.server = FailingServer(self)
        self.calls = {
            "GET": lambda client: client.scenes(), "POST": lambda client: client.ask("six", "rays:any", {}),
            "PUT": lambda client: client.put("six", b"glTF"), "DELETE": lambda client: client.delete("six"),
            "PATCH": lambda client: client.patch_node("six", 1, if_match='"1"', hidden=True)}
        self.changes = [
            lambda client: client.patch_node("six", 1, hidden=True), lambda client: client.patch_nodes("six", {1: {"hidden": True}}),
            lambda client: client.load("six", {"path": "six.glb"}), lambda client: client.ask_later("six", "rays:any", {})]

    def test_requests_share_a_connection(self):
        client = self.client(self.server)
        for call in (*self.calls.values(), *self.changes) * 3:
            call(client)
        self.assertEqual((len(self.server.asked), self.server.connections), (3 * (len(self.calls) + len(self.changes)), 1))
        # One that the server refused is still good; one that it closed is not.
        self.server.plan[:] = [404, 200, "close"]
        for expected in (1, 1, 2):
            with contextlib.suppress(sightline.SightlineError):
                client.scenes()
            self.assertEqual(self.server.connections, expected)

    def test_what_may_be_repeated_is_repeated_after_each_fault(self):
        for method, call in self.calls.items():
            for fault in (*FAULTS, 429, 502, 503):
                with self.subTest(method, fault=fault):
                    client = self.client(self.server)
                    self.server.plan[:], self.server.asked[:] = [fault], []
                    call(client)
                    self.assertEqual(self.server.asked, [method] * 2)

    def test_a_change_without_a_condition_is_sent_once(self):
        for fault in (*FAULTS, 502, 503):
            for number, change in enumerate(self.changes):
                with self.subTest(fault, change=number):
                    client = self.client(self.server)
                    self.server.plan[:], self.server.asked[:] = [fault], []
                    with self.assertRaises((sightline.SightlineError, *sightline._LOST)):
                        change(client)
                    self.assertEqual(len(self.server.asked), 1)

    def test_a_change_that_was_refused_by_429_is_sent_again(self):
        client = self.client(self.server)
        for change in self.changes:
            self.server.plan[:], self.server.asked[:] = [429], []
            change(client)
            self.assertEqual(len(self.server.asked), 2)

    def test_other_errors_are_told_at_once(self):
        client = self.client(self.server)
        for status in (400, 404, 409, 412, 422, 500, 504, 507):
            self.server.plan[:], self.server.asked[:] = [status], []
            with self.assertRaises(sightline.SightlineError) as caught:
                client.put("six", b"glTF", if_match='"1"')
            self.assertEqual((caught.exception.status, caught.exception.repeated, len(self.server.asked)), (status, False, 1))

    def test_a_refused_condition_after_a_lost_answer_is_marked(self):
        for call in (self.calls["PATCH"], lambda client: client.put("six", b"glTF", if_none_match="*"),
                     lambda client: client.delete("six", if_match='"1"')):
            self.server.plan[:] = ["close", 412]
            with self.assertRaises(sightline.SightlineError) as caught:
                call(self.client(self.server))
            self.assertEqual((caught.exception.status, caught.exception.repeated), (412, True))

    def test_an_error_passes_between_processes(self):
        problem = {"code": "C", "detail": "d", "errors": [{"pointer": "/rays/1"}], "request_id": "r"}
        error = pickle.loads(pickle.dumps(sightline.SightlineError(422, problem, True)))
        self.assertEqual((error.status, error.code, error.detail, error.errors, error.request_id, error.repeated, str(error)),
                         (422, "C", "d", problem["errors"], "r", True, "422 C: d at /rays/1"))

    def test_a_scene_that_a_lost_request_has_deleted_is_deleted(self):
        self.server.plan[:] = ["close", 404]
        self.client(self.server).delete("six")
        self.assertEqual(self.server.asked, ["DELETE", "DELETE"])

    def test_a_node_that_a_lost_request_has_removed_is_removed(self):
        self.server.plan[:] = ["close", 404]
        self.client(self.server).remove_node("six", 1)
        self.assertEqual(self.server.asked, ["DELETE", "DELETE", "GET"])

    def test_the_waits_double_with_jitter_until_the_patience_ends(self):
        for patience in (0, 3, 30):
            self.server.plan[:], self.server.asked[:], self.clock.waits[:] = [503] * 100, [], []
            with self.assertRaises(sightline.SightlineError):
                self.client(self.server, patience=patience).ask("six", "rays:any", {})
            waits = self.clock.waits
            self.assertEqual(len(self.server.asked), len(waits) + 1)
            for i, wait in enumerate(waits):
                most = min(0.1 * 2 ** i, 5)
                self.assertTrue(most / 2 - 1e-9 <= wait <= most + 1e-9, (i, wait))
            self.assertTrue(patience - 5 <= sum(waits) <= patience, waits)
        self.assertGreater(len(set(wait / min(0.1 * 2 ** i, 5) for i, wait in enumerate(waits))), 3)

    def test_retry_after_is_respected(self):
        client = self.client(self.server)
        date = email.utils.formatdate(time.time() + 20, usegmt=True)
        for status in (429, 503):
            for told, least, most in (("3", 3, 3), (date, 10, 20), ("soon", 0, 0.1), ("-5", 0, 0.1)):
                self.server.plan[:], self.clock.waits[:] = [(status, {"Retry-After": told})], []
                client.scenes()
                self.assertEqual(len(self.clock.waits), 1)
                self.assertTrue(least - 1e-9 <= self.clock.waits[0] <= most + 1e-9, (told, self.clock.waits))
            self.server.plan[:], self.clock.waits[:] = [(status, {"Retry-After": "31"})], []
            with self.assertRaises(sightline.SightlineError):  # Later than the patience.
                client.scenes()
            self.assertEqual(self.clock.waits, [])

    def test_a_server_that_is_not_reached_is_asked_again_also_for_changes(self):
        for change in (*self.calls.values(), *self.changes):
            self.clock.waits[:] = []
            with self.assertRaises(ConnectionRefusedError):
                change(self.client(self.nobody(), patience=1))
            self.assertGreater(len(self.clock.waits), 2)


class TwoServers(Failing):
    def setUp(self):
        super().setUp()
        self.first, self.second = self.in_order(FailingServer(self), FailingServer(self))

    def test_the_next_server_answers_where_one_does_not(self):
        for fault in (*FAULTS, 502, 503):
            with self.subTest(fault):
                client = self.client(self.first, self.second)
                self.first.plan[:], self.first.asked[:], self.second.asked[:] = [fault], [], []
                self.assertEqual(client.ask("six", "rays:any", {})["hits"], [True])
                self.assertEqual((len(self.first.asked), len(self.second.asked)), (1, 1))
        self.assertEqual(self.clock.waits, [])

    def test_each_server_is_tried_before_the_client_waits(self):
        self.first.plan[:], self.second.plan[:] = [503, "close", 503], [503, 502, "reset"]
        self.client(self.first, self.second).ask("six", "rays:any", {})
        self.assertEqual(len(self.first.asked) + len(self.second.asked), 7)
        self.assertTrue(self.clock.waits and sum(self.clock.waits) < 2, self.clock.waits)

    def test_each_server_is_tried_once_without_patience(self):
        self.first.plan[:], self.second.plan[:] = [503] * 9, ["close"] * 9
        with self.assertRaises(ConnectionError):
            self.client(self.first, self.second, patience=0).ask("six", "rays:any", {})
        self.assertEqual((len(self.first.asked), len(self.second.asked)), (1, 1))

    def test_a_limit_of_requests_is_not_avoided_by_the_next_server(self):
        self.first.plan[:] = [(429, {"Retry-After": "2"})]
        self.client(self.first, self.second).ask("six", "rays:any", {})
        self.assertEqual((len(self.first.asked), len(self.second.asked), self.clock.waits), (2, 0, [2.0]))

    def test_a_change_without_a_condition_goes_to_the_next_server_only_if_none_has_it(self):
        dead = self.nobody()
        for name in (f"scene{i}" for i in range(20)):
            self.client(dead, self.second).patch_node(name, 1, hidden=True)
        self.assertEqual(self.second.asked, ["PATCH"] * 20)
        self.first.plan[:], self.second.asked[:] = ["close"], []
        with self.assertRaises(ConnectionError):
            self.client(self.first, self.second).patch_node("six", 1, hidden=True)
        self.assertEqual(self.second.asked, [])

    def test_a_server_without_an_answer_comes_last_for_five_seconds(self):
        client = self.client(self.first, self.second)
        self.first.plan[:] = ["close"]
        for _ in range(3):
            client.ask("six", "rays:any", {})
        self.assertEqual((len(self.first.asked), len(self.second.asked)), (1, 3))
        self.clock.now += 6
        client.ask("six", "rays:any", {})
        self.assertEqual((len(self.first.asked), len(self.second.asked)), (2, 3))

    def test_the_newest_revision_that_was_seen_is_required(self):
        client, told = self.client(self.first, self.second), "x-scene-min-revision"
        client.put("six", b"glTF")
        client.ask("six", "rays:any", {})
        self.assertEqual([told in head for head in self.first.heads], [False, True])
        self.first.plan[:] = [(200, {"X-Scene-Revision": revision}) for revision in (9, 8)]
        for _ in range(3):
            client.ask("six", "rays:any", {})
        client.ask("seven", "rays:any", {})
        sent = [head.get(told) for head in self.first.heads + self.second.heads]
        self.assertEqual(sorted(sent, key=str), ["7", "7", "9", "9", None, None])
        for single, expected in ((self.client(self.first), None), (self.client(self.first, shared=True), "7")):
            single.put("six", b"glTF")
            single.ask("six", "rays:any", {})
            self.assertEqual(self.first.heads[-1].get(told), expected)

    def test_a_job_is_asked_for_where_it_was_made(self):
        client = self.client(self.first, self.second)
        self.first.plan[:] = ["close"]
        client.ask("six", "rays:any", {})
        self.clock.now += 1
        job = client.ask_later("six", "rays:any", {})
        self.clock.now += 60
        self.first.asked[:], self.second.asked[:] = [], []
        client.job("six", job)
        client.job_result("six", job)
        client.delete_job("six", job)
        self.assertEqual((self.first.asked, self.second.asked), ([], ["GET", "GET", "DELETE"]))

    def test_a_scene_is_spread_over_all_servers_on_request(self):
        client = self.client(self.first, self.second, spread=True)
        for _ in range(6):
            client.ask("six", "rays:any", {})
        self.assertEqual((len(self.first.asked), len(self.second.asked)), (3, 3))

    def test_events_come_from_a_server_that_is_reached(self):
        dead = self.nobody()
        for name in (f"scene{i}" for i in range(20)):
            self.assertEqual(list(self.client(dead, self.second).events(name)), [])


class Order(Failing):
    def test_a_further_server_moves_only_the_scenes_that_it_gets(self):
        urls, names = [f"http://replica{i}:8080" for i in range(4)], [f"scene{i}" for i in range(3000)]

        def homes(*urls):
            client = self.client(*urls)
            return [client._servers(name)[0].url for name in names]
        three, four = homes(*urls[:3]), homes(*urls)
        self.assertEqual(homes(*reversed(urls)), four)
        moved = [b for a, b in zip(three, four) if a != b]
        self.assertEqual(set(moved), {urls[3]})
        self.assertTrue(600 < len(moved) < 900, len(moved))  # A quarter is 750; 5 deviations are 119.
        for url in urls:
            self.assertTrue(600 < four.count(url) < 900)
        left = homes(urls[0], *urls[2:])
        self.assertTrue(all(a == b for a, b in zip(four, left) if a != urls[1]))


class Replicas(unittest.TestCase):
    """Two servers over one folder, which read it anew only if a request requires a newer revision."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.servers = []
        for name in ("a", "b"):
            server = Server("--data", Path(folder.name, name), "--origin", Path(folder.name, "origin"), "--origin-seconds", 3600)
            self.addCleanup(server.end)
            self.servers.append(server)
        self.client = sightline.Sightline([server.url for server in self.servers])
        self.addCleanup(self.client.close)
        # So many that each server is the first for some of them, whatever its port.
        self.names = [f"scene{i}" for i in range(24)]
        for name in self.names:
            self.client.put(name, demo_glb("six"))

    def homes(self):
        return {self.client._servers(name)[0].url for name in self.names}

    def t(self, name, client=None):
        t = (client or self.client).closest(name, *RAY, fields=["t"])["t"]
        return list(t)[0]

    def test_scenes_of_a_killed_server_are_answered_and_changed_by_the_other(self):
        self.assertEqual(self.homes(), {server.url for server in self.servers})
        self.assertEqual([self.t(name) for name in self.names], [4.5] * len(self.names))
        for name in self.names:
            self.client.patch_node(name, 0, translation=[-1, 0, 0])
        self.servers[0].kill()
        for name in self.names:  # The other server has an older content: the client requires the newer one.
            self.assertEqual(self.t(name), 3.5)
            self.assertEqual(self.client.scene(name)["revision"], 2)
        self.assertEqual(self.client.patch_node(self.names[0], 1, hidden=False)["revision"], 3)
        self.assertEqual(self.client.put(self.names[1], demo_glb("six"))["revision"], 3)
        for name in self.names[2:]:
            self.client.delete(name)
        self.assertEqual(sorted(each["id"] for each in self.client.scenes()), self.names[:2])
        with self.assertRaises(sightline.SightlineError) as caught:
            self.t(self.names[2])
        self.assertEqual(caught.exception.status, 404)
        job = self.client.ask_later(self.names[0], "rays:any", {"rays": [{"origin": RAY[0][0], "direction": RAY[1][0]}]})
        while self.client.job(self.names[0], job)["state"] not in ("done", "failed"):
            pass
        self.assertEqual(self.client.job_result(self.names[0], job)["hits"], [True])

    def test_queries_go_on_while_a_server_is_killed(self):
        stop, wrong = threading.Event(), []

        def ask(name):
            with sightline.Sightline([server.url for server in self.servers]) as client:
                while not stop.is_set():
                    try:
                        if self.t(name, client) != 4.5:
                            wrong.append(name)
                    except Exception as error:
                        wrong.append(error)
                        return
                    counts[name] += 1
        counts = dict.fromkeys(self.names, 0)
        threads = [threading.Thread(target=ask, args=(name,)) for name in self.names]
        for thread in threads:
            thread.start()
        try:
            while min(counts.values()) < 5 and not wrong:
                time.sleep(0.01)
            self.servers[0].kill()
            reached = dict(counts)
            while any(counts[name] < reached[name] + 5 for name in self.names) and not wrong:
                time.sleep(0.01)
        finally:
            stop.set()
            for thread in threads:
                thread.join()
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    case_report.main()
