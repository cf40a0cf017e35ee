"""Cost per ray, and the limit of threads of a request."""

import json
import os
import random
import struct
import time
import unittest

import case_report
from process_status import is_sanitized, spent_by_threads
from sightline_server import PATIENCE, Server
from two_scenes import TwoScenes

COSTS = ["cost_nodes", "cost_blocks"]


def rays(count):
    numbers = random.Random(11)
    return [{"origin": [numbers.uniform(-150, 150), numbers.uniform(1, 90), numbers.uniform(-150, 150)],
             "direction": [numbers.uniform(-1, 1) for _ in range(3)]} for _ in range(count)]


def columns(some):
    return {"origins": [x for ray in some for x in ray["origin"]], "directions": [x for ray in some for x in ray["direction"]]}


class Cost(TwoScenes):
    @classmethod
    def setUpClass(cls):
        # What a ray visits depends on the trees that are built: here all are.
        cls.server = Server("--preload", "town=demo:town", "--skip", "none")
        cls.addClassCleanup(cls.server.end)

    def works(self, some, **options):
        """What `work` tells of a request of each ray alone."""
        work = [self.ask_json("/v1/scenes/town/rays:closest", {"rays": [ray], "work": True, **options})["work"] for ray in some]
        return [(each["nodes"], each["blocks"]) for each in work]

    def closest(self, some, **options):
        return self.ask_json("/v1/scenes/town/rays:closest", {**columns(some), "fields": COSTS, **options})

    def test_is_what_work_tells_of_each_ray_alone(self):
        some = rays(60)
        for options in ({}, {"cull": "back"}, {"exclude": {"names": ["clock tower", "market*"]}}, {"mask": 3}):
            with self.subTest(options=options):
                answer = self.closest(some, **options)
                self.assertEqual(set(answer), set(COSTS))
                self.assertEqual(list(zip(answer["cost_nodes"], answer["cost_blocks"])), self.works(some, **options))

    def test_misses_have_one_too(self):
        up = {"origin": [3, 400, 5], "direction": [0.1, -0.01, 0]}
        some = [{"origin": [3, 200, 5], "direction": [0, -1, 0]}, up]
        answer = self.closest(some, fields=["instance", *COSTS])
        self.assertEqual(answer["instance"][1], -1)
        self.assertEqual(list(zip(answer["cost_nodes"], answer["cost_blocks"])), self.works(some))

    def test_rows_bytes_and_tables_have_it(self):
        some = rays(40)
        expected = self.closest(some)
        hits = self.ask_json("/v1/scenes/town/rays:closest", {"rays": some, "fields": COSTS})["hits"]
        told = [(nodes, blocks) for hit, nodes, blocks in zip(hits, expected["cost_nodes"], expected["cost_blocks"]) if hit]
        self.assertEqual([(hit["cost_nodes"], hit["cost_blocks"]) for hit in hits if hit], told)
        self.assertGreater(len(told), 5)
        body = json.dumps({**columns(some), "fields": COSTS})
        answer = self.server.query("town", "closest", body, "-H", "Accept: application/octet-stream").body
        for i, name in enumerate(COSTS):
            title, kind, width, at, count = struct.unpack_from("<16sIIQQ", answer, 16 + 40 * i)
            self.assertEqual((title.rstrip(b"\0").decode(), kind, width, count), (name, 2, 1, len(some)))
            self.assertEqual(list(struct.unpack_from(f"<{count}I", answer, at)), expected[name])
        table = self.server.query("town", "closest", body, "-H", "Accept: text/csv").body.decode().splitlines()
        self.assertEqual(table[0], ",".join(COSTS))
        self.assertEqual([tuple(map(int, row.split(","))) for row in table[1:] if row != ","], told)

    def test_each_hit_of_a_list_has_that_of_its_ray(self):
        some = rays(30)
        expected = self.closest(some)
        lists = self.ask_json("/v1/scenes/town/rays:all", {"rays": some, "fields": COSTS, "max_hits": 3})["results"]
        for nodes, blocks, each in zip(expected["cost_nodes"], expected["cost_blocks"], lists):
            for hit in each["hits"]:
                self.assertEqual((hit["cost_nodes"], hit["cost_blocks"]), (nodes, blocks))

    def test_points_and_sweeps_have_none(self):
        for path, body in (("points:closest", {"points": [[0, 0, 0]]}),
                           ("sweeps:closest", {"sweeps": [{"origin": [0, 9, 0], "direction": [0, -1, 0], "radius": 1}]})):
            answer = self.send_json("/v1/scenes/town/" + path, {**body, "fields": COSTS})
            self.assertEqual((answer.status, answer.json()["code"]), (422, "FIELD_UNKNOWN"))


class Threads(TwoScenes):
    def test_no_answer_depends_on_them(self):
        some = rays(5000)
        points = [ray["origin"] for ray in some]
        sweeps = [{**ray, "radius": 0.5} for ray in some[:1500]]
        boxes = [{"min": [x - 1, 0, z - 1], "max": [x + 1, y, z + 1]} for x, y, z in points[:1500]]
        for path, body in (("rays:closest", {"rays": some, "fields": ["t", "normal", "uv", "node", "on_edge"]}), ("rays:any", {"rays": some}),
                           ("rays:all", {"rays": some}), ("rays:count", {"rays": some}), ("points:closest", {"points": points}),
                           ("points:inside", {"points": points}), ("points:sky", {"points": points[:50], "count": 100}),
                           ("sweeps:closest", {"sweeps": sweeps}), ("boxes:count", {"boxes": boxes}),
                           ("visibility", {"from": points[:60], "to": points[60:120]})):
            with self.subTest(path=path):
                expected = self.ask_json("/v1/scenes/town/" + path, body)
                for threads in (1, 2, 7):
                    self.assertEqual(self.ask_json("/v1/scenes/town/" + path, {**body, "threads": threads}), expected)

    def test_limit_how_many_threads_of_the_server_work(self):
        """By the time on a processor that the system counts for each thread of the server, as shares of all of it."""
        points = [ray["origin"] for ray in rays(1000)]
        with Server("--preload", "town=demo:town", "--skip", "none", "--threads", 4) as server:
            if is_sanitized(server):
                self.skipTest("a sanitized build sets no limit")
            if spent_by_threads(server) is None:
                self.skipTest("the system counts no time for each thread")

            def working(**limit):
                """How many threads have at least a tenth of the work of a request of a million rays."""
                before = spent_by_threads(server)
                body = json.dumps({"points": points, "count": 1000, **limit})
                answer = server.ask("/v1/scenes/town/points:sky", "-H", "Content-Type: application/json", body=body)
                self.assertEqual(answer.status, 200, answer.body)
                spent = [after - before.get(thread, 0) for thread, after in spent_by_threads(server).items()]
                return sum(10 * each >= sum(spent) for each in spent)
            # With a limit of two, each of the server's threads may help at times.
            for _ in range(2):
                self.assertEqual(working(threads=1), 1)
            if len(os.sched_getaffinity(0)) > 1:
                end = time.monotonic() + PATIENCE
                while working() == 1:  # A busy machine may leave all the work to one thread.
                    self.assertLess(time.monotonic(), end)

    def test_are_1_to_1024(self):
        for threads, code in ((0, "NUMBER_OUT_OF_RANGE"), (1025, "NUMBER_OUT_OF_RANGE"), (-1, None), (1.5, None), ("2", "TYPE_WRONG")):
            for path, body in (("rays:any", {"rays": rays(1)}), ("boxes:any", {"boxes": [{"min": [0, 0, 0], "max": [1, 1, 1]}]})):
                answer = self.send_json("/v1/scenes/town/" + path, {**body, "threads": threads})
                self.assertEqual((answer.status, answer.json()["errors"][0]["pointer"]), (422, "/threads"))
                if code:
                    self.assertEqual(answer.json()["code"], code)


if __name__ == "__main__":
    case_report.main()
