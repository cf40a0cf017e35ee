"""The event loop answers small requests itself, and a worker the others: with equal bytes."""

import json
import random
import re
import struct
import unittest

import case_report
from sightline_server import PATIENCE, Server

HEAD = "POST /v1/scenes/{scene}/rays:{kind} HTTP/1.1\r\nHost: x\r\n{more}Content-Length: {length}\r\n\r\n"
# A client that asks to go on first is answered by a worker.
BY_WORKER = "Expect: 100-continue\r\n"
CHANGING = re.compile(rb'(?m)^(Date|X-Request-Id): .*\r\n|"request_id":"\w+"|"microseconds":{[^}]*}')


def lasting(answer):
    """Without what differs each time: of times also how long they are as text."""
    if b"microseconds" in answer:
        answer = re.sub(rb"Content-Length: \d+\r\n", b"", answer)
    return CHANGING.sub(b"", answer)


def binary(*rays, options=b""):
    head = b"SLR1" + struct.pack("<IQII", 1, len(rays), len(options), 0) + options
    head += bytes(-len(head) % 8)
    return head + b"".join(struct.pack(f"<{len(rays)}d", *(ray[k] for ray in rays)) for k in range(6))


def bodies():
    """(kind, headers, body): requests for the event loop, small ones for a worker, and faulty ones."""
    chance = random.Random(1)
    ray = lambda: {"origin": [chance.uniform(-30, 30), 60, chance.uniform(-30, 30)], "direction": [chance.uniform(-1, 1), -1, 0.25]}
    rows = lambda count, **more: json.dumps({"rays": [ray() for _ in range(count)], **more})
    for kind in ("closest", "any", "count"):
        for count in (0, 1, 1, 2, 8, 9):
            yield kind, "", rows(count)
        for more in ({"normalize": True}, {"cull": "back"}, {"mask": 2}, {"include": {"names": ["s*"]}}, {"exclude": {"nodes": [99]}},
                     {"on_invalid": "mark"}, {"work": True}, {"nonsense": 1}, {"crossings": "once"}):
            yield kind, "", rows(1, **more)
        yield kind, "", json.dumps({"origins": [0, 60, 0], "directions": [0, -1, 0.1]})
        yield kind, "", '{"rays":[{"origin":[1,60,2],"direction":[0,0,0]}]}'
        yield kind, "", '{"rays":[{"origin":[1,60,2],"direction":[0,1e999,0]}]}'
        yield kind, "", '{"rays":['
        yield kind, "Accept: application/octet-stream\r\n", rows(1)
        yield kind, "Content-Type: text/plain\r\n", rows(1)
        yield kind, "Content-Type: application/octet-stream\r\n", binary((1, 60, 2, 0, -1, 0))
        yield kind, "Content-Type: application/octet-stream\r\n", binary((1, 60, 2, 0, -1, 0), options=b'{"cull":"back"}')
        yield kind, "Content-Encoding: br\r\n", rows(1)
        yield kind, "Accept-Encoding: gzip\r\nX-Request-Id: mine\r\nOrigin: http://localhost\r\n", rows(7)
    yield "closest", "", rows(1, fields=["t", "node_path", "on_edge", "barycentrics", "material"])
    yield "closest", "", rows(1, fields=["t", "t"])
    yield "closest", "", rows(1, explain=True)
    yield "closest", "", json.dumps({"generator": {"kind": "orthographic", "position": [0, 50, 0], "look_at": [0, 0, 1], "width": 2,
                                                   "height": 2, "span": 9}})


class EventLoop(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "town=demo:town", "--skip", "none")
        cls.addClassCleanup(cls.server.end)

    def answer(self, request):
        """All bytes until the connection ends."""
        with self.server.connect() as connection, connection.makefile("rwb") as stream:
            stream.write(request)
            stream.flush()
            return stream.read()

    def counted(self, what):
        found = re.search(rb"(?m)^%s (\S+)$" % re.escape(what), self.server.ask("/metrics").body)
        return float(found[1]) if found else 0

    def both_ways(self, kind, more, body, scene="town"):
        """The answers of the event loop, where it answers, and of a worker."""
        body = body if isinstance(body, bytes) else body.encode()
        ask = lambda extra: self.answer(HEAD.format(scene=scene, kind=kind, more="Connection: close\r\n" + more + extra,
                                                    length=len(body)).encode() + body)
        on_event_loop, by_worker = ask(""), ask(BY_WORKER)
        return on_event_loop, by_worker.removeprefix(b"HTTP/1.1 100 Continue\r\n\r\n")

    def test_both_ways_give_the_same_bytes(self):
        answered = b'sightline_connections_total{event="answered_in_event_loop"}'
        before, asked, good = self.counted(answered), 0, 0
        for kind, more, body in bodies():
            with self.subTest(kind=kind, more=more, body=body):
                on_event_loop, by_worker = self.both_ways(kind, more, body)
                self.assertEqual(lasting(on_event_loop), lasting(by_worker))
                self.assertIn(b"\r\n\r\n", on_event_loop)
                asked += 1
                good += on_event_loop.startswith(b"HTTP/1.1 200")
        self.assertGreater(asked, 60)
        # How many depends on how busy the machine is; some are always too much for it.
        self.assertGreater(self.counted(answered) - before, 0)
        self.assertLess(self.counted(answered) - before, good)
        on_event_loop, by_worker = self.both_ways("closest", "", '{"rays":[]}', "none")
        self.assertTrue(on_event_loop.startswith(b"HTTP/1.1 404"))
        self.assertEqual(lasting(on_event_loop), lasting(by_worker))

    def test_each_request_is_counted_and_logged_once(self):
        series = {status: b'sightline_requests_total{method="POST",route="/v1/scenes/{id}/rays:any",status="%d"}' % status
                  for status in (200, 422)}
        before = {status: self.counted(name) for status, name in series.items()}
        rays, lines = self.counted(b"sightline_rays_total"), self.server.log_text().count("rays:any")
        ray = {"origin": [1, 60, 2], "direction": [0, -1, 0]}
        for more, count in (({}, 1), ({"cull": "back"}, 2), ({"nonsense": 1}, 1)):
            self.server.query("town", "any", {"rays": [ray] * count, **more})
        self.assertEqual({status: self.counted(name) - before[status] for status, name in series.items()}, {200: 2, 422: 1})
        self.assertEqual(self.counted(b"sightline_rays_total") - rays, 3)
        self.assertEqual(self.server.log_text().count("rays:any") - lines, 3)

    def test_a_connection_goes_on_after_either_way(self):
        plain, filtered = b'{"rays":[{"origin":[1,60,2],"direction":[0,-1,0]}]}', b'{"rays":[],"cull":"back"}'
        requests = [HEAD.format(scene="town", kind="any", more=more, length=len(body)).encode() + body
                    for body, more in ((plain, ""), (filtered, ""), (plain, ""), (plain, "Connection: close\r\n"))]
        answers = self.server.exchange(*requests)
        self.assertEqual([(answer.status, answer.body) for answer in answers],
                         [(200, b'{"hits":[true]}'), (200, b'{"hits":[]}')] + [(200, b'{"hits":[true]}')] * 2)


if __name__ == "__main__":
    case_report.main()
