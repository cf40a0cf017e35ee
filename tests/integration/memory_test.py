"""A server that has too little memory says so and lives on."""

import array
import json
import math
import resource
import socket
import struct
import tempfile
import threading
import time
import unittest

import case_report
from abuse_case import sip
from process_status import forget_peak, is_sanitized, status_bytes
from sightline_server import JSON_TYPE, PATIENCE, Server, demo_glb, read_answer

MIB = 1 << 20


def many_values(count):
    return b'{"asset":{"version":"2.0"},"extras":[' + b",".join([b"[]"] * count) + b"]}"


def many_arrays_in_nodes(count):
    return b'{"asset":{"version":"2.0"},"nodes":[' + b",".join([b'{"extras":[[],[],[]]}'] * count) + b"]}"


def many_nodes(count):
    return b'{"asset":{"version":"2.0"},"nodes":[' + b",".join([b"{}"] * count) + b"]}"


def grid_glb(side):
    """2 * side * side triangles over a plane, as a GLB."""
    positions = array.array("f", (c for y in range(side + 1) for x in range(side + 1) for c in (x, (x * 7 + y * 13) % 5, y)))
    indices = array.array("I")
    for y in range(side):
        for corner in range(y * (side + 1), y * (side + 1) + side):
            indices.extend((corner, corner + 1, corner + side + 2, corner, corner + side + 2, corner + side + 1))
    binary = positions.tobytes() + indices.tobytes()
    text = json.dumps({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteLength": 4 * len(positions)},
                        {"buffer": 0, "byteOffset": 4 * len(positions), "byteLength": 4 * len(indices)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(positions) // 3,
                       "min": [0, 0, 0], "max": [side, 4, side]},
                      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": len(indices)}]}).encode()
    text += b" " * (-len(text) % 4)
    return (struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary)) + struct.pack("<II", len(text), 0x4E4F534A)
            + text + struct.pack("<II", len(binary), 0x004E4942) + binary)


def fan_glb(count):
    """Triangles around the origin, which is a corner of all of them."""
    rim = [(math.cos(a), math.sin(a), 0.3 * math.sin(7 * a)) for a in (2 * math.pi * i / count for i in range(count + 1))]
    positions = array.array("f", (c for i in range(count) for c in (0, 0, 0, *rim[i], *rim[i + 1])))
    text = json.dumps({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": 4 * len(positions)}],
        "bufferViews": [{"buffer": 0, "byteLength": 4 * len(positions)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 * count,
                       "min": [-1, -1, -0.3], "max": [1, 1, 0.3]}]}).encode()
    text += b" " * (-len(text) % 4)
    binary = positions.tobytes()
    return (struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary)) + struct.pack("<II", len(text), 0x4E4F534A)
            + text + struct.pack("<II", len(binary), 0x004E4942) + binary)


class MemoryGoesBack(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        # What is uploaded goes to a file, so that only the scene itself is in memory, with all of its trees.
        self.server = Server("--data", self.folder.name, "--workers", 8, "--skip", "none")
        self.addCleanup(self.server.end)
        self.server.put("six", demo_glb("six"))
        if is_sanitized(self.server):
            self.skipTest("a sanitizer keeps what is freed")

    def resident(self):
        return status_bytes(self.server, "VmRSS")

    def test_a_scene_that_is_removed_gives_its_memory_back(self):
        body = grid_glb(708)
        before = self.resident()
        put = self.server.put("grid", body)
        self.assertEqual((put.status, put.json()["counts"]["triangles"]), (201, 2 * 708 * 708), put.body)
        loaded = self.resident()
        self.assertEqual(self.server.ask("/v1/scenes/grid", "-X", "DELETE").status, 204)
        removed = self.resident()
        print(f"resident MiB: {before / MIB:.0f} before, {loaded / MIB:.0f} loaded, {removed / MIB:.0f} removed")
        self.assertGreater(loaded - before, 50 * MIB)
        self.assertLess(removed - before, (loaded - before) / 2)

    def test_what_a_load_needed_for_itself_goes_back_when_it_has_ended(self):
        # JSON is all that these files have: of the memory that reading them takes nothing should stay.
        body = many_arrays_in_nodes(150000)
        before = self.resident()
        self.assertEqual(self.server.put("nodes", body).status, 201)
        self.assertEqual(self.server.ask("/v1/scenes/nodes", "-X", "DELETE").status, 204)
        broken = body[:-2] + b',{"mesh":7}]}'
        self.assertEqual(self.server.put("nodes", broken).status, 422)
        peak, now = status_bytes(self.server, "VmHWM"), self.resident()
        print(f"resident MiB: {before / MIB:.0f} before, {peak / MIB:.0f} at most, {now / MIB:.0f} after")
        self.assertGreater(peak - before, 50 * MIB)
        self.assertLess(now - before, (peak - before) / 4)


class LittleMemory(unittest.TestCase):
    def setUp(self):
        self.server = Server("--preload", "six=demo:six", "--workers", 8, "--threads", 1)
        self.addCleanup(self.server.end)
        # Every thread that will ever be has its stack before the limit comes.
        for _ in range(32):
            self.server.ask("/healthz")
        self.server.closest("six", ([-10, 1, 0], [1, 0, 0]))
        if is_sanitized(self.server):
            self.skipTest("a sanitized process takes terabytes of addresses")

    def limit(self, spare):
        size = status_bytes(self.server, "VmSize") + spare if spare else resource.RLIM_INFINITY
        resource.prlimit(self.server.process.pid, resource.RLIMIT_AS, (size, resource.RLIM_INFINITY))

    def test_a_scene_whose_json_needs_more_than_there_is_is_refused_and_the_server_lives(self):
        for make, count in ((many_values, 1000000), (many_arrays_in_nodes, 150000), (many_nodes, 250000)):
            body = make(count)
            refused = taken = 0
            for spare in (12, 24, 48, 64, 80, 96, 128, 160, 192, 256, 320, 384, 512, 640, 4096):
                with self.subTest(shape=make.__name__, spare=spare):
                    self.limit(spare * MIB)
                    answer = self.server.put("heavy", body, "-H", "Expect:")
                    self.limit(None)
                    self.assertIn(answer.status, (200, 201, 413, 507), answer.body)
                    refused += answer.status == 507
                    taken += answer.status < 300
                    self.assertEqual(self.server.closest("six", ([-10, 1, 0], [1, 0, 0]))[0]["t"], 4.5)
                self.assertIsNone(self.server.process.poll(), "the server ended")
            print(f"{make.__name__}: {len(body)} bytes, refused {refused} times, taken {taken} times")
            self.assertGreater(refused, 0)
            self.assertGreater(taken, 0)

    def test_a_scene_whose_geometry_needs_more_than_there_is_is_refused_and_the_server_lives(self):
        body = demo_glb("town")
        refused = taken = 0
        for spare in (8, 12, 16, 24, 32, 48, 64, 68, 72, 80, 96, 112, 128, 160, 192, 256, 1024):
            with self.subTest(spare=spare):
                self.limit(spare * MIB)
                answer = self.server.put("town", body, "-H", "Expect:")
                self.limit(None)
                self.assertIn(answer.status, (200, 201, 507), answer.body)
                refused += answer.status == 507
                taken += answer.status < 300
                self.assertEqual(self.server.closest("six", ([-10, 1, 0], [1, 0, 0]))[0]["t"], 4.5)
            self.assertIsNone(self.server.process.poll(), "the server ended")
        print(f"{len(body)} bytes, refused {refused} times, taken {taken} times")
        self.assertGreater(refused, 0)
        self.assertGreater(taken, 0)


def pinhole(side, **more):
    return json.dumps({"generator": {"kind": "pinhole", "position": [3, 200, 5], "forward": [0, -1, 0], "up": [0, 0, -1], "fov_y": 20,
                                     "width": side, "height": side}, **more})


class Budget(unittest.TestCase):
    """What a request will take is asked for before it is taken."""

    def server(self, *arguments):
        server = Server("--preload", "town=demo:town", *arguments)
        self.addCleanup(server.end)
        if is_sanitized(server):
            self.skipTest("a sanitizer keeps what is freed")
        self.assertEqual(server.query("town", "closest", pinhole(60)).status, 200)
        return server

    def peak_above(self, server, before):
        return status_bytes(server, "VmHWM") - before

    def forget_peak(self, server):
        forget_peak(server)
        return status_bytes(server, "VmRSS")

    def test_few_bytes_cannot_ask_for_much(self):
        server = self.server("--max-request-memory", 8 * MIB, "--workers", 8)
        before = self.forget_peak(server)
        everything = {"min": [None] * 3, "max": [None] * 3}
        places = [[i, 40, i] for i in range(1500)]
        for path, body, pointer in [
                ("scenes/town/rays:closest", pinhole(2000), "/generator"),
                ("scenes/town/rays:count", pinhole(2000), "/generator"),
                ("rays:generate", pinhole(1000), "/generator"),
                ("rays:generate", '{"generator":{"kind":"lidar","elevations":[],"azimuths":0,"poses":[' + "{}," * 199999 + "{}]}}", None),
                ("scenes/town/rays:closest", pinhole(250), None),
                ("scenes/town/rays:all", pinhole(280, fields=["t"]), None),
                ("scenes/town/visibility", json.dumps({"from": places, "to": places}), None),
                ("scenes/town/visibility", json.dumps({"from": places[:300], "to": places[:300], "first_blocker": True}), None),
                ("scenes/town/boxes:list", json.dumps({"boxes": [everything] * 100}), None),
                ("rays-boxes", json.dumps({"rays": [{"origin": [0, 0, 0], "direction": [1, 0, 0]}] * 200,
                                           "boxes": [{"min": [0, 0, 0], "max": [1, 1, 1]}] * 200, "pairing": "all"}), None)]:
            with self.subTest(path=path, body=body[:200]):
                answer = server.ask(f"/v1/{path}", "-H", JSON_TYPE, body=body)
                self.assertEqual((answer.status, answer.json()["code"]), (413, "REQUEST_TOO_LARGE"), answer.body[:500])
                if pointer:
                    self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)
        peak = self.peak_above(server, before)
        print(f"at most {peak / MIB:.1f} MiB above {before / MIB:.0f}")
        # What was asked for is 270 MB of rays alone.
        self.assertLess(peak, 48 * MIB)
        # Within it they are answered as ever.
        self.assertEqual(server.query("town", "any", pinhole(200)).status, 200)
        self.assertEqual(server.query("town", "all", pinhole(60)).status, 200)
        self.assertEqual(server.ask("/v1/scenes/town/boxes:list", "-H", JSON_TYPE, body=json.dumps({"boxes": [everything] * 9})).status, 200)

    def test_clearance_of_a_selection_with_itself_has_it_once(self):
        # With all trees beforehand: what is built ahead, a moment later, is no part of the answer.
        server = self.server("--skip", "none")
        before = self.forget_peak(server)
        everything = {"names": ["*"]}
        answer = server.ask("/v1/scenes/town/clearance", "-H", JSON_TYPE, body=json.dumps({"a": everything, "b": everything}))
        self.assertEqual((answer.status, answer.json()["pair"]["distance"]), (200, 0), answer.body[:300])
        peak = self.peak_above(server, before)
        print(f"clearance of 362,254 triangles: at most {peak / MIB:.1f} MiB above {before / MIB:.0f}")
        # Twice it would be 27 MiB more than the 51 that it is.
        self.assertLess(peak, 64 * MIB)

    def test_pairs_of_nodes_keep_no_large_numbers(self):
        server = self.server()
        count = 120
        triangle = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
        document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": list(range(count))}], "nodes": [{"mesh": 0}] * count,
                    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": 36, "uri": triangle}],
                    "bufferViews": [{"buffer": 0, "byteLength": 36}],
                    "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 1, 0]}]}
        self.assertEqual(server.put("same", json.dumps(document)).status, 201)
        before = self.forget_peak(server)
        everything = {"names": ["*"]}
        answer = server.ask("/v1/scenes/same/clearance", "-H", JSON_TYPE,
                            body=json.dumps({"a": everything, "b": everything, "max_distance": 0, "pairs": "nodes", "limit": 1}))
        self.assertEqual((answer.status, answer.json()["total"]), (200, count * count), answer.body[:300])
        peak = self.peak_above(server, before)
        print(f"at most {peak / MIB:.1f} MiB above {before / MIB:.0f}")
        self.assertLess(peak, 32 * MIB)

    def test_a_ray_keeps_no_more_hits_than_it_lists(self):
        server = self.server("--skip", "none")
        count = 30000
        self.assertEqual(server.put("fan", fan_glb(count)).status, 201)
        before = self.forget_peak(server)
        # Through the corner of all: each is met, exactly, at one t.
        ray = {"rays": [{"origin": [0.1, 0.2, 5], "direction": [-0.1, -0.2, -5]}] * 8}
        total = server.query("fan", "count", json.dumps(ray))
        self.assertEqual((total.status, total.json()["counts"]), (200, [count] * 8), total.body[:300])
        first = server.query("fan", "all", json.dumps({**ray, "max_hits": 1, "fields": ["t", "triangle"]}))
        self.assertEqual((first.status, first.json()["results"]), (200, [{"total": count, "hits": [{"t": 1, "triangle": 0}]}] * 8), first.body[:300])
        every = server.query("fan", "all", json.dumps({"rays": ray["rays"][:1], "max_hits": count, "fields": ["triangle"]}))
        self.assertEqual([hit["triangle"] for hit in every.json()["results"][0]["hits"]], list(range(count)))
        peak = self.peak_above(server, before)
        print(f"{count} triangles met at one t: at most {peak / MIB:.1f} MiB above {before / MIB:.0f}")
        # The exact t of all of them are 385 MiB, for each thread that traces.
        self.assertLess(peak, 16 * MIB)

    def test_many_who_ask_for_much_take_turns(self):
        server = self.server()
        before = self.forget_peak(server)
        answers = []
        askers = [threading.Thread(target=lambda: answers.append(server.query("town", "any", pinhole(700)))) for _ in range(24)]
        for asker in askers:
            asker.start()
        for asker in askers:
            asker.join()
        self.assertEqual(len(answers), 24)
        for answer in answers:
            self.assertTrue(answer.status == 200 or (answer.status, answer.json()["code"], answer.headers["retry-after"]) ==
                            (503, "MEMORY_BUSY", "1"), answer.body[:300])
        good = [answer.body for answer in answers if answer.status == 200]
        self.assertEqual(len(set(good)), 1)
        peak = self.peak_above(server, before)
        print(f"{len(good)} of 24 answered, at most {peak / MIB:.1f} MiB above {before / MIB:.0f}")
        # 490,000 rays are 45 MB with their answer: one at a time, and 24 MiB of others.
        self.assertLess(peak, 120 * MIB)

    def test_slow_readers_of_large_answers_share_what_there_is(self):
        server = self.server()
        before = self.forget_peak(server)
        body = b'{"generator":{"kind":"equirectangular","width":1000,"height":500}}'

        def ask():
            connection = socket.socket()
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            self.addCleanup(connection.close)
            connection.settimeout(PATIENCE)
            connection.connect(("127.0.0.1", server.port))
            connection.sendall(b"POST /v1/rays:generate HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\n"
                               b"Content-Length: %d\r\n\r\n" % len(body) + body)
            return connection

        # 15 kB a second of each, which is more than --min-rate.
        pace = {"size": 3000, "pause": 0.2}
        held = [ask() for _ in range(10)]
        sip(held, 5, **pace)
        peak = self.peak_above(server, before)
        print(f"ten slow readers: at most {peak / MIB:.1f} MiB above {before / MIB:.0f}")
        self.assertLess(peak, 128 * MIB)
        for connection in held:
            connection.close()
        # An answer that is not read waits in a temporary file: it keeps nobody from memory.
        slow = ask()
        self.assertEqual(slow.recv(12), b"HTTP/1.1 200")
        self.assertEqual(sip([slow], 2, **pace), [slow])
        done = []
        other = threading.Thread(target=lambda: done.append(server.ask("/v1/rays:generate", "-H", JSON_TYPE, body=body)))
        other.start()
        other.join()
        self.assertEqual(done[0].status, 200, done[0].body[:300])
        self.assertEqual(sip([slow], 2, **pace), [slow])

    def test_changing_a_node_is_reckoned_by_the_nodes_that_there_are(self):
        count = 150000
        triangle = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
        body = json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": list(range(count))}],
                           "nodes": [{"mesh": 0, "translation": [i, 0, 0]} for i in range(count)],
                           "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"byteLength": 36, "uri": triangle}],
                           "bufferViews": [{"buffer": 0, "byteLength": 36}],
                           "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [1, 1, 0]}]})
        ask = ("/v1/scenes/many/nodes/7", "-X", "PATCH", "-H", JSON_TYPE)
        for most, status in ((64 * MIB, 413), (1024 * MIB, 200)):
            with self.subTest(most=most):
                # With all trees beforehand: what is built ahead, a moment later, is no part of the change.
                server = self.server("--max-request-memory", most, "--skip", "none")
                self.assertEqual(server.put("many", body, "-H", "Expect:").status, 201)
                before = self.forget_peak(server)
                answer = server.ask(*ask, body='{"hidden":true}')
                self.assertEqual(answer.status, status, answer.body[:300])
                peak = self.peak_above(server, before)
                print(f"PATCH of one of {count} nodes: {status}, {peak / MIB:.1f} MiB above {before / MIB:.0f}")
                if status == 413:
                    self.assertEqual(answer.json()["code"], "REQUEST_TOO_LARGE")
                    self.assertLess(peak, 32 * MIB)

    def test_rays_in_one_body_take_three_times_the_body(self):
        # Of fewer rays what a server holds in any case is a large part.
        count = 1_000_000
        # Straight down on a square of the town; the t of each ray is where it starts, so the order shows.
        ys = [200 + i / 1024 for i in range(count)]
        rows = ",".join(f'{{"origin":[{3 + i / 1e9!r},{y!r},5.123456789012345],"direction":[0.0000000000000000,-1.000000000000000,0.00]}}'
                        for i, y in enumerate(ys))
        origins = ",".join(f"{3 + i / 1e9!r},{y!r},5.123456789012345" for i, y in enumerate(ys))
        directions = ",".join(["0.0000000000000000,-1.000000000000000,0.00"] * count)
        server = self.server("--max-request-memory", 2048 * MIB)
        for form, body in (("rows", f'{{"rays":[{rows}],"fields":["t","triangle"]}}'),
                           ("columns", f'{{"origins":[{origins}],"directions":[{directions}],"fields":["t","triangle"]}}')):
            with self.subTest(form=form):
                before = self.forget_peak(server)
                answer = server.query("town", "closest", body)
                self.assertEqual(answer.status, 200, answer.body[:300])
                peak = self.peak_above(server, before)
                print(f"{count} rays as {form}: {len(body) / MIB:.1f} MiB, {peak / MIB:.1f} MiB above, {peak / len(body):.2f} times")
                self.assertLess(peak, 3 * len(body))
                found = answer.json()
                self.assertEqual([hit["t"] for hit in found["hits"]] if form == "rows" else found["t"], [y - 0.25 for y in ys])

    def test_uploads_in_memory_share_what_there_is(self):
        server = self.server("--memory", MIB, "--rate-seconds", 100)
        body = grid_glb(200)
        self.assertGreater(len(body), MIB)
        slow = server.connect()
        with slow, slow.makefile("rwb") as stream:
            stream.write(b"PUT /v1/scenes/slow HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n" % len(body))
            stream.write(body[:-1])
            stream.flush()
            while server.ask("/v1/scenes/slow").json().get("progress") != 99:
                pass
            refused = server.put("other", body, "-H", "Expect:")
            self.assertEqual((refused.status, refused.json()["code"], refused.headers["retry-after"]), (503, "MEMORY_BUSY", "1"))
            stream.write(body[-1:])
            stream.flush()
            self.assertEqual(read_answer(stream).status, 201)
        self.assertEqual(server.put("other", body, "-H", "Expect:").status, 201)


if __name__ == "__main__":
    case_report.main()
