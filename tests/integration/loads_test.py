"""Scenes on their way: states, waiting, events and cancelling, asked by curl."""

import json
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import case_report
from sightline_server import PATIENCE, Server, demo_glb, read_answer


class Upload:
    """A PUT whose body is sent as slowly as the test likes."""

    def __init__(self, server, target, body):
        self.body, self.sent = body, 0
        self.connection = server.connect()
        self.stream = self.connection.makefile("rwb")
        self.stream.write(b"PUT /v1/scenes/%s HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: %d\r\n\r\n"
                          % (target.encode(), len(body)))
        self.stream.flush()
        assert read_answer(self.stream).status == 100  # now the server knows of it

    def send(self, count=None):
        end = len(self.body) if count is None else self.sent + count
        self.stream.write(self.body[self.sent:end])
        self.stream.flush()
        self.sent = end

    def answer(self):
        answer = read_answer(self.stream)
        self.close()
        return answer

    def close(self):
        self.stream.close()
        self.connection.close()


class Events:
    """curl on a scene's events."""

    def __init__(self, server, scene):
        self.process = subprocess.Popen(["curl", "-sSN", "--max-time", str(PATIENCE), server.url + f"/v1/scenes/{scene}/events"],
                                        stdout=subprocess.PIPE, text=True)

    def next(self):
        """(name, data), or None at the end."""
        name = None
        for line in self.process.stdout:
            key, _, value = line.rstrip("\n").partition(": ")
            if key == "event":
                name = value
            elif key == "data":
                return name, json.loads(value)
        return None

    def rest(self):
        events = []
        while (event := self.next()) is not None:
            events.append(event)
        self.end()
        return events

    def end(self):
        self.process.terminate()
        self.process.stdout.close()
        return self.process.wait(timeout=PATIENCE)


def state_of(server, scene):
    return server.ask(f"/v1/scenes/{scene}").json()


class Loads(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.six, cls.town = demo_glb("six"), demo_glb("town")
        cls.server = Server()
        cls.addClassCleanup(cls.server.end)

    def test_an_upload_is_seen_while_it_comes(self):
        upload = Upload(self.server, "slow", self.town)
        upload.send(len(self.town) // 2)
        while (scene := state_of(self.server, "slow"))["progress"] != 49 and scene["progress"] != 50:
            self.assertEqual((scene["state"], scene["stage"]), ("loading", "receiving"))
        refused = self.server.query("slow", "any", {"rays": []})
        self.assertEqual((refused.status, refused.json()["code"], refused.headers["retry-after"]), (409, "SCENE_LOADING", "1"))
        upload.send()
        self.assertEqual(upload.answer().status, 201)
        scene = state_of(self.server, "slow")
        self.assertEqual(scene["state"], "ready")
        self.assertNotIn("stage", scene)

    def test_a_broken_upload_leaves_nothing(self):
        upload = Upload(self.server, "broken", self.six)
        upload.send(100)
        self.assertEqual(state_of(self.server, "broken")["state"], "loading")
        upload.close()
        while self.server.ask("/v1/scenes/broken").status != 404:
            pass

    def test_wait_0_answers_202_and_wait_on_get_ends_with_the_load(self):
        put = self.server.put("later?wait=0", self.town)
        self.assertEqual((put.status, put.headers["location"], put.headers["retry-after"]), (202, "/v1/scenes/later", "1"))
        self.assertIn(put.json()["state"], ("loading", "ready"))
        scene = self.server.ask(f"/v1/scenes/later?wait={PATIENCE}").json()
        self.assertEqual((scene["state"], scene["counts"]["triangles"]), ("ready", 362254))
        # A replacement leaves the old one to be asked.
        put = self.server.put("later?wait=0", self.six)
        self.assertEqual(put.status, 202)
        self.assertEqual(put.json()["state"], "ready")
        self.assertEqual(self.server.query("later", "any", {"rays": []}).status, 200)
        scene = self.server.ask(f"/v1/scenes/later?wait={PATIENCE}").json()
        self.assertEqual((scene["counts"]["triangles"], scene.get("update")), (6, None))

    def test_a_wait_may_end_before_the_load(self):
        upload = Upload(self.server, "waits", self.six)
        for wait in ("0", "0.01", "0.2"):
            self.assertEqual(self.server.ask(f"/v1/scenes/waits?wait={wait}").json()["state"], "loading")
        upload.send()
        self.assertEqual(upload.answer().status, 201)
        self.assertEqual(self.server.put("waits?wait=100&scene=0", self.six).status, 200)

    def test_a_failure_is_told_to_who_waits_and_kept_for_who_does_not(self):
        bad = b"glTF but not really"
        refused = self.server.put("bad", bad)
        self.assertEqual(refused.headers["content-type"], "application/problem+json")
        self.assertEqual(self.server.ask("/v1/scenes/bad").status, 404)
        self.assertEqual(self.server.put("bad?wait=0", bad).status, 202)
        scene = self.server.ask(f"/v1/scenes/bad?wait={PATIENCE}").json()
        self.assertEqual((scene["state"], scene["reason"]["code"]), ("failed", refused.json()["code"]))
        self.assertEqual(self.server.put("bad", self.six).status, 201)
        self.assertEqual(self.server.put("bad?wait=0", bad).status, 202)
        scene = self.server.ask(f"/v1/scenes/bad?wait={PATIENCE}").json()
        self.assertEqual((scene["state"], scene["update"]["state"]), ("ready", "failed"))
        self.assertEqual(scene["update"]["reason"]["code"], refused.json()["code"])
        self.assertEqual(self.server.query("bad", "any", {"rays": []}).status, 200)

    def test_a_bad_wait_is_422(self):
        for query in ("wait=", "wait=-1", "wait=3601", "wait=nan", "wait=inf", "wait=1e9", "wait=0x1", "wait=1&wait=1", "wait=1;scene=0"):
            with self.subTest(query=query):
                for answer in (self.server.put("x?" + query, self.six), self.server.ask("/v1/scenes/x?" + query)):
                    self.assertEqual((answer.status, answer.json()["code"]), (422, "QUERY_INVALID"))
        self.assertEqual(self.server.ask("/v1/scenes/x?scene=0").status, 422)

    def test_delete_cancels_while_the_body_comes(self):
        upload = Upload(self.server, "unwanted", self.town)
        upload.send(1000)
        self.assertEqual(self.server.ask("/v1/scenes/unwanted", "-X", "DELETE").status, 204)
        self.assertEqual(self.server.ask("/v1/scenes/unwanted").status, 404)
        upload.send()
        answer = upload.answer()
        self.assertEqual((answer.status, answer.json()["code"]), (409, "LOAD_CANCELLED"))
        self.assertEqual(self.server.ask("/v1/scenes/unwanted").status, 404)

    def test_delete_cancels_whatever_stage_a_load_has_come_to(self):
        names = [f"many{number}" for number in range(12)]
        seen = set()
        # Where all trees are built before a scene is ready, there is something to wait for.
        with Server("--skip", "none") as server:
            for name in names:
                self.assertEqual(server.put(name + "?wait=0", self.town).status, 202)
            # The last ones first: each load that is cancelled lets another one go on.
            for name in reversed(names):
                scene = state_of(server, name)
                seen.add((scene["state"], scene.get("stage")))
                self.assertEqual(server.ask("/v1/scenes/" + name, "-X", "DELETE").status, 204)
            print(f"cancelled in {sorted(str(stage) for stage in seen)}")
            self.assertIn(("loading", "waiting"), seen)
            self.assertEqual(server.ask("/v1/scenes").json(), {"scenes": []})
            for name in names:
                self.assertEqual(server.ask("/v1/scenes/" + name).status, 404)
            self.assertEqual(server.put(names[0], self.six).status, 201)

    def test_50_loads_at_once_all_end_well(self):
        answers = {}

        def put(name):
            answers[name] = self.server.put(name, self.six).status

        names = [f"crowd{number}" for number in range(50)]
        threads = [threading.Thread(target=put, args=(name,)) for name in names]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertLessEqual(set(answers.values()), {201, 202})
        self.assertEqual(len(answers), 50)
        for name in names:
            self.assertEqual(self.server.ask(f"/v1/scenes/{name}?wait={PATIENCE}").json()["state"], "ready")

    def test_loads_are_bounded(self):
        with Server("--max-loads", 2) as server:
            uploads = [Upload(server, name, self.six) for name in "ab"]
            refused = server.put("c", self.six)
            self.assertEqual((refused.status, refused.json()["code"], refused.headers["retry-after"]),
                             (503, "LOADS_TOO_MANY", "1"))
            for upload in uploads:
                upload.send()
                self.assertEqual(upload.answer().status, 201)
            while server.put("c", self.six).status == 503:
                pass
            self.assertEqual(server.ask("/version").json()["limits"]["loads"], 2)

    def test_only_so_many_requests_wait(self):
        # 8 workers: 4 may wait, and others are still answered.
        with Server("--workers", 8) as server:
            upload = Upload(server, "held", self.six)
            waiters = [threading.Thread(target=server.ask, args=(f"/v1/scenes/held?wait={PATIENCE}",)) for _ in range(6)]
            for waiter in waiters:
                waiter.start()
            for _ in range(10):
                self.assertEqual(server.ask("/healthz").status, 200)
            upload.send()
            self.assertIn(upload.answer().status, (201, 202))
            for waiter in waiters:
                waiter.join()


class SceneEvents(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.six = demo_glb("six")
        cls.server = Server()
        cls.addClassCleanup(cls.server.end)

    def test_curl_sees_every_stage_and_then_the_end(self):
        upload = Upload(self.server, "watched", self.six)
        events = Events(self.server, "watched")
        name, data = events.next()
        self.assertEqual((name, data["id"], data["state"], data["stage"], data["progress"]),
                         ("progress", "watched", "loading", "receiving", 0))
        upload.send(len(self.six) // 2)
        while (event := events.next())[1]["progress"] not in (49, 50):
            self.assertEqual(event[0], "progress")
        upload.send()
        self.assertEqual(upload.answer().status, 201)
        rest = events.rest()
        name, data = rest[-1]
        self.assertEqual((name, data["state"], data["triangles"]), ("ready", "ready", 6))
        self.assertEqual({name for name, _ in rest[:-1]} - {"progress"}, set())

    def test_the_end_is_told_at_once_when_nothing_moves(self):
        self.server.put("still", self.six)
        self.assertEqual([name for name, _ in Events(self.server, "still").rest()], ["ready"])
        self.server.put("wrong?wait=0", b"no scene")
        name, data = Events(self.server, "wrong").rest()[-1]
        self.assertEqual((name, data["state"]), ("failed", "failed"))
        self.assertTrue(data["reason"]["code"])
        self.assertEqual(self.server.ask("/v1/scenes/none/events").status, 404)

    def test_a_removed_scene_ends_the_stream(self):
        upload = Upload(self.server, "gone", self.six)
        events = Events(self.server, "gone")
        self.assertEqual(events.next()[0], "progress")
        self.assertEqual(self.server.ask("/v1/scenes/gone", "-X", "DELETE").status, 204)
        self.assertEqual(events.rest()[-1], ("removed", {"id": "gone"}))
        upload.close()

    def test_the_answer_is_an_event_stream_for_http_1_0_too(self):
        self.server.put("old", self.six)
        answer = self.server.ask("/v1/scenes/old/events")
        self.assertEqual((answer.status, answer.headers["content-type"], answer.headers["cache-control"]),
                         (200, "text/event-stream", "no-store"))
        for connection in ("close", "keep-alive"):
            old = self.server.ask("/v1/scenes/old/events", "--http1.0", "-H", f"Connection: {connection}")
            self.assertNotIn("transfer-encoding", old.headers)
            self.assertEqual(old.body, answer.body)
        # The connection goes on after a stream.
        with self.server.connect() as connection, connection.makefile("rwb") as stream:
            stream.write(b"GET /v1/scenes/old/events HTTP/1.1\r\nHost: x\r\n\r\nGET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
            stream.flush()
            text = stream.read()
        self.assertEqual(text.count(b"HTTP/1.1 200 OK"), 2)

    def test_listeners_are_bounded_and_those_who_left_are_noticed(self):
        with Server("--max-streams", 2) as server:
            upload = Upload(server, "long", demo_glb("town"))
            listeners = [Events(server, "long") for _ in range(2)]
            for listener in listeners:
                self.assertEqual(listener.next()[0], "progress")
            refused = server.ask("/v1/scenes/long/events")
            self.assertEqual((refused.status, refused.json()["code"], refused.headers["retry-after"]), (503, "STREAMS_BUSY", "1"))
            listeners[0].end()
            end = time.monotonic() + PATIENCE
            while True:
                upload.send(1)  # a silent upload would be given up
                listener = Events(server, "long")
                if listener.next() is not None:
                    break
                listener.end()
                self.assertLess(time.monotonic(), end)
            upload.send()
            self.assertEqual(upload.answer().status, 201)
            self.assertEqual(listener.rest()[-1][0], "ready")
            self.assertEqual(listeners[1].rest()[-1][0], "ready")

    def test_a_stop_ends_the_streams(self):
        with tempfile.TemporaryDirectory() as folder, Server("--data", Path(folder, "data"), "--drain-seconds", 100000) as server:
            upload = Upload(server, "cut", self.six)
            events = Events(server, "cut")
            self.assertEqual(events.next()[0], "progress")
            server.signal()
            self.assertNotIn("ready", [name for name, _ in events.rest()])
            upload.close()
            self.assertEqual(server.wait(), 0)


if __name__ == "__main__":
    case_report.main()
