"""What stands between points, against answers that were worked out by hand."""


import case_report
from two_scenes import TwoScenes

# Along y = 1, z = 0 the triangles of "left" stand at x = -5.5, -3.5, -1.5, those of "right" at 2.5, 4.5, 6.5, see
# rays_test.py.
A, B, C, D = [-10, 1, 0], [-4, 1, 0], [0, 1, 0], [2, 1, 0]


class Visibility(TwoScenes):
    def send(self, scene, **body):
        return self.send_json(f"/v1/scenes/{scene}/visibility", body)

    def ask(self, scene, **body):
        return self.ask_json(f"/v1/scenes/{scene}/visibility", body)

    def test_all_with_all_is_a_matrix_of_bits(self):
        # A sees nobody, C and D see each other, and each point itself.
        self.assertEqual(self.ask("six", **{"from": [A, B, C, D], "to": [A, B, C, D]}),
                         {"visible": ["1000", "0100", "0011", "0011"]})
        self.assertEqual(self.ask("six", **{"from": [A], "to": [C, D, [-6, 1, 0]]}), {"visible": ["001"]})
        self.assertEqual(self.ask("six", **{"from": [], "to": [A]}), {"visible": []})

    def test_each_with_each_is_one_row(self):
        self.assertEqual(self.ask("six", **{"from": [A, C], "to": [B, D], "pairing": "each"}), {"visible": "01"})

    def test_first_blockers_and_their_part_of_the_way(self):
        body = {"from": [A, D], "to": [C, [7, 1, 0]], "first_blocker": True, "fields": ["t", "distance", "node", "triangle"]}
        first = {"t": 0.45, "distance": 4.5, "node": "left", "triangle": 0}
        # From A to (7,1,0): 17 long, 4.5 units away. From D back to C nothing; from D on to 2.5.
        self.assertEqual(self.ask("six", **body), {"visible": ["00", "10"], "blockers": [
            [first, {**first, "t": 4.5 / 17}], [None, {"t": 0.1, "distance": 0.5, "node": "right", "triangle": 0}]]})
        each = self.ask("six", **{**body, "pairing": "each", "fields": ["t"]})
        self.assertEqual(each, {"visible": "00", "blockers": [{"t": 0.45}, {"t": 0.1}]})

    def test_ends(self):
        on = [-5.5, 1, 0]  # on the first triangle
        for ends, expected in [("open", ["110"]), ("closed", ["000"])]:
            with self.subTest(ends=ends):
                self.assertEqual(self.ask("six", **{"from": [on], "to": [A, [-4, 1, 0], C], "ends": ends}), {"visible": expected})
        self.assertEqual(self.ask("six", **{"from": [on], "to": [on], "ends": "closed"}), {"visible": ["0"]})
        self.assertEqual(self.ask("six", **{"from": [on], "to": [on]}), {"visible": ["1"]})
        self.assertEqual(self.ask("six", **{"from": [A], "to": [A], "ends": "closed"}), {"visible": ["1"]})

    def test_filters_decide_what_stands_in_the_way(self):
        body = {"from": [A], "to": [C, [3, 1, 0]], "exclude": {"names": ["left"]}}
        self.assertEqual(self.ask("six", **body), {"visible": ["10"]})
        self.assertEqual(self.ask("six", **{**body, "cull": "front"}), {"visible": ["11"]})

    def test_a_thousand_by_a_thousand_in_one_call(self):
        # A grid above the town sees itself; a row of points under its ground sees no point above.
        above = [[x * 20 - 320, 150, z * 20 - 310] for x in range(32) for z in range(31)][:1000]
        answer = self.ask("town", **{"from": above, "to": above[:999] + [[0, -500, 0]], "work": True})
        self.assertEqual(len(answer["visible"]), len(above))
        for row in answer["visible"]:
            self.assertEqual(row, "1" * (len(above[:999])) + "0")
        self.assertGreater(answer["work"]["nodes"], 0)

    def test_faults_are_named(self):
        good = {"from": [A], "to": [B]}
        for body, status, code, pointer in [
                ({"from": [A]}, 422, "KEY_MISSING", None),
                ({**good, "rays": []}, 422, "KEY_UNKNOWN", "/rays"),
                ({**good, "normalize": True}, 422, "KEY_UNKNOWN", "/normalize"),
                ({**good, "to": [[1, 2]]}, 422, "LENGTH_WRONG", "/to/0"),
                ({**good, "to": [[1, 2, 3, 4]]}, 422, "LENGTH_WRONG", "/to/0"),
                ({**good, "to": [B, [1, "2", 3]]}, 422, "TYPE_WRONG", "/to/1/1"),
                ({**good, "to": [B, B], "pairing": "each"}, 422, "PAIRS_UNEQUAL", "/to"),
                ({**good, "fields": ["t"]}, 422, "FIELDS_WITHOUT_BLOCKER", "/fields"),
                ({"from": [B, [-1e308, 0, 0]], "to": [B, [1.7e308, 0, 0]]}, 422, "POINTS_TOO_FAR", "/to/1"),
                ({**good, "ends": "ajar"}, 422, "VALUE_UNKNOWN", "/ends")]:
            with self.subTest(body=body):
                answer = self.send("six", **body)
                self.assertEqual((answer.status, answer.json()["code"]), (status, code), answer.body)
                if pointer:
                    self.assertEqual(answer.json()["errors"][0]["pointer"], pointer)


if __name__ == "__main__":
    case_report.main()
