"""Sky view and ambient occlusion, against the same rays sent one by one to rays:any, in JSON and in bytes."""

import json
import struct
import unittest

import case_report
from two_scenes import TwoScenes

SKY, BYTES = "/v1/scenes/town/points:sky", "application/octet-stream"
POINTS = [[3, 0.5, 5], [0, 10, 0.5], [-7, 9, 0], [0, 400, 0], [9, 1, -9], [0.5, 33, 0.5]]
NORMALS = [[0, 2, 0], [1, 0, 0], [0, 0, -3e-200], [0, -1, 0], [1, 1, 1], [-1, 2, 0.25]]


class Sky(TwoScenes):
    def send(self, **body):
        return self.send_json(SKY, body)

    def counted(self, points, normals, count, limits, options, **how):
        """What rays:any says of the rays that rays:generate lists for a hemisphere, added up for each point."""
        made = self.ask_json("/v1/rays:generate", {"generator": {"kind": "hemisphere", "points": points, "normals": normals, "count": count,
                                                                 "range": limits, **how}})
        hits = self.ask_json("/v1/scenes/town/rays:any", {**made, **options})["hits"]
        return [hits[i * count:(i + 1) * count].count(False) for i in range(len(points))]

    def test_counts_are_those_of_the_same_rays(self):
        differing = set()
        for how in ({}, {"seed": 9}, {"distribution": "uniform"}, {"distribution": "uniform", "seed": 2**64 - 1}):
            for limits in ([0, None], [0.5, 40]):
                for options in ({}, {"exclude": {"names": ["clock tower", "spire"]}}):
                    for normals in (None, NORMALS):
                        with self.subTest(how=how, limits=limits, options=options, normals=normals):
                            expected = self.counted(POINTS, normals or [[0, 1, 0]] * len(POINTS), 64, limits, options, **how)
                            body = {"points": POINTS, "count": 64, "min_distance": limits[0], "max_distance": limits[1], **how, **options}
                            if normals:
                                body["normals"] = normals
                            answer = self.ask_json(SKY, body)
                            self.assertEqual(answer, {"directions": 64, "counts": expected, "ratios": [each / 64 for each in expected]})
                            differing.add(tuple(expected))
        self.assertGreater(len(differing), 20)

    def test_batches_of_many_rays_continue_where_the_last_one_ended(self):
        # 300 points of 1000 directions are three batches in the engine.
        points = [[-60 + 0.4 * i, 2 + i % 7, 0.3 * (i % 11)] for i in range(300)]
        counts = self.ask_json(SKY, {"points": points, "count": 1000, "seed": 4})["counts"]
        self.assertEqual(counts, self.counted(points, [[0, 1, 0]] * 300, 1000, [0, None], {}, seed=4))

    def test_nothing_is_above_the_town_and_everything_below(self):
        answer = self.ask_json(SKY, {"points": [[0, 400, 0], [0, 400, 0]], "normals": [[0, 1, 0], [0, 0.001, 0]]})
        self.assertEqual(answer, {"directions": 256, "counts": [256, 256], "ratios": [1, 1]})
        self.assertEqual(self.ask_json(SKY, {"points": []}), {"directions": 256, "counts": [], "ratios": []})

    def test_bytes_say_what_json_says(self):
        for normals in (None, NORMALS):
            options = {"count": 50, "seed": 3, "min_distance": 0.25}
            expected = self.ask_json(SKY, {"points": POINTS, **options, **({"normals": normals} if normals else {})})["counts"]
            text = json.dumps(options).encode()
            head = struct.pack("<4sIQII", b"SLP1", 3 if normals else 1, len(POINTS), len(text), 0) + text
            body = head + bytes(-len(head) % 8)
            for table in (POINTS, normals) if normals else (POINTS,):
                body += b"".join(struct.pack(f"<{len(table)}d", *(row[k] for row in table)) for k in range(3))
            answer = self.server.ask(SKY, "-H", f"Content-Type: {BYTES}", body=body)
            self.assertEqual((answer.status, answer.headers["content-type"]), (200, BYTES), answer.body)
            got = answer.body if isinstance(answer.body, bytes) else answer.body.encode("latin-1")
            name, kind, width, at, rows = struct.unpack_from("<16sIIQQ", got, 16)
            self.assertEqual((name.rstrip(b"\0"), kind, width, rows), (b"counts", 4, 1, len(POINTS)))
            self.assertEqual(list(struct.unpack_from(f"<{rows}Q", got, at)), expected)

    def test_faults_are_named(self):
        one = {"points": [[0, 1, 0]]}
        for body, code, pointer in [({}, "KEY_MISSING", None), ({**one, "count": 0}, "COUNT_ZERO", "/count"),
                                    ({**one, "count": 65537}, "NUMBER_OUT_OF_RANGE", "/count"),
                                    ({**one, "normals": []}, "LENGTH_WRONG", "/normals"),
                                    ({**one, "normals": [[0, 0, -0.0]]}, "NORMAL_ZERO", "/normals/0"),
                                    ({**one, "min_distance": -1}, "DISTANCE_NEGATIVE", "/min_distance"),
                                    ({**one, "min_distance": 2, "max_distance": 1}, "RAY_LIMITS_REVERSED", "/min_distance"),
                                    ({**one, "distribution": "even"}, "VALUE_UNKNOWN", "/distribution"),
                                    ({**one, "cull": "back"}, "KEY_UNKNOWN", "/cull")]:
            with self.subTest(body=body):
                answer = self.send(**body)
                self.assertEqual((answer.status, answer.json()["code"]), (422, code), answer.body)
                if pointer:
                    self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)


if __name__ == "__main__":
    case_report.main()
