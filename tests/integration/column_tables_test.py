"""Answers of columns as CSV, NPY and NPZ, and as bytes: equal to the answers of JSON."""

import ast
import csv
import io
import json
import struct
import unittest
import zipfile

import case_report
from tables_test import read_npy
from two_scenes import TwoScenes
from work_test import rays

SOME = rays(40)
POINTS = [ray["origin"] for ray in SOME]
CSV, NPY, NPZ, BYTES = "text/csv", "application/x-npy", "application/x-npz", "application/octet-stream"


def numbers_of(npy):
    """The values of an array of plain numbers, flat, and its shape."""
    kind, shape, data = read_npy(npy)
    return list(struct.unpack(f"<{len(data) // int(kind[2:])}{dict(f='d', i='q', u='Q')[kind[1]] if kind[2:] == '8' else 'B'}", data)), shape


class ColumnTables(TwoScenes):
    def send(self, path, body, accept):
        answer = self.server.ask("/v1/scenes/town/" + path, "-H", "Content-Type: application/json", "-H", "Accept: " + accept,
                                 body=json.dumps(body))
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, accept), answer.body[:300])
        return answer.body

    def tables(self, path, body):
        """Rows of CSV by name, arrays of NPZ as (values, shape), and the rows of NPY."""
        rows = list(csv.reader(io.StringIO(self.send(path, body, CSV).decode(), newline="")))
        with zipfile.ZipFile(io.BytesIO(self.send(path, body, NPZ))) as archive:
            arrays = {name.removesuffix(".npy"): numbers_of(archive.read(name)) for name in archive.namelist()}
        kind, (count,), data = read_npy(self.send(path, body, NPY))
        letters = {"f8": "d", "i8": "q", "u8": "Q", "u1": "B"}
        form = "<" + "".join(letters[each[1][1:]] * (each[2][0] if len(each) > 2 else 1) for each in kind)
        structured = list(struct.iter_unpack(form, data))
        self.assertEqual((count, len(rows) - 1), (len(structured), len(structured)))
        for cells, values in zip(rows[1:], structured):
            for cell, value in zip(cells, values, strict=True):
                self.assertIn(cell, [repr(value), str(value), str(int(value)) if value == value and abs(value) < 1e300 else "",
                                     "" if value == -1 or not -1e300 < value < 1e300 else None])
        return rows[0], [[float(cell) if cell else None for cell in row] for row in rows[1:]], arrays

    def test_one_number_for_each_row(self):
        boxes = [{"min": [x - 3, y - 3, z - 3], "max": [x + 3, y + 3, z + 3]} for x, y, z in POINTS]
        for path, body, column, told in (("rays:any", {"rays": SOME}, "hits", "hits"), ("rays:count", {"rays": SOME}, "counts", "counts"),
                                         ("points:sky", {"points": POINTS, "count": 20}, "counts", "counts"),
                                         ("sweeps:any", {"sweeps": [{**ray, "radius": 1} for ray in SOME]}, "hits", "hits"),
                                         ("boxes:any", {"boxes": boxes}, "hits", "hits"), ("boxes:count", {"boxes": boxes}, "counts", "counts")):
            with self.subTest(path=path):
                expected = self.ask_json("/v1/scenes/town/" + path, body)[told]
                names, rows, arrays = self.tables(path, body)
                self.assertEqual((names, rows), ([column], [[float(each)] for each in expected]))
                self.assertEqual(arrays, {column: ([int(each) for each in expected], (len(expected),))})
                self.assertGreater(len(set(expected)), 1)

    def test_points(self):
        told = self.ask_json("/v1/scenes/town/points:inside", {"points": POINTS})["inside"]
        names, rows, arrays = self.tables("points:inside", {"points": POINTS})
        self.assertEqual(names, ["inside", "reliable"])
        self.assertEqual([row[0] for row in rows], [float(each is True) for each in told])
        self.assertEqual(arrays["inside"], ([int(each is True) for each in told], (len(told),)))
        body = {"points": POINTS, "max_distance": 8, "fields": ["distance", "instance", "position", "node_id"]}
        hits = self.ask_json("/v1/scenes/town/points:closest", body)["hits"]
        names, rows, _ = self.tables("points:closest", body)
        self.assertEqual(names, ["distance", "instance", "position_x", "position_y", "position_z", "node_id"])
        self.assertEqual(rows, [[hit["distance"], hit["instance"], *hit["position"], hit["node_id"]] if hit else [None] * 6 for hit in hits])
        self.assertIn([None] * 6, rows)

    def test_lists_are_rows_with_the_number_of_their_ray_or_point(self):
        for path, body in (("rays:all", {"rays": SOME, "max_hits": 4}), ("points:nearest", {"points": POINTS, "count": 3})):
            with self.subTest(path=path):
                body["fields"] = ["distance", "instance", "triangle"]
                results = self.ask_json("/v1/scenes/town/" + path, body)["results"]
                lists = [each["hits"] if isinstance(each, dict) else each for each in results]
                names, rows, arrays = self.tables(path, body)
                self.assertEqual(names, ["row", "distance", "instance", "triangle"])
                self.assertEqual(rows, [[i, hit["distance"], hit["instance"], hit["triangle"]] for i, hits in enumerate(lists) for hit in hits])
                first = arrays["first"][0]
                self.assertEqual([b - a for a, b in zip(first, first[1:])], [len(hits) for hits in lists])
                self.assertEqual(arrays["instance"][0], [hit["instance"] for hits in lists for hit in hits])

    def test_visibility_is_a_matrix(self):
        body = {"from": POINTS[:6], "to": POINTS[6:15]}
        expected = self.ask_json("/v1/scenes/town/visibility", body)["visible"]
        names, rows, arrays = self.tables("visibility", body)
        self.assertEqual(names, [f"visible_{k}" for k in range(9)])
        self.assertEqual(["".join(str(int(cell)) for cell in row) for row in rows], expected)
        self.assertEqual(arrays["visible"], ([int(letter) for letter in "".join(expected)], (6, 9)))
        self.assertGreater(len(set("".join(expected))), 1)
        each = {"from": POINTS[:9], "to": POINTS[9:18], "pairing": "each"}
        answer = self.send("visibility", each, BYTES)
        title, kind, width, at, count = struct.unpack_from("<16sIIQQ", answer, 16)
        self.assertEqual((title.rstrip(b"\0"), kind, width, count), (b"visible", 3, 1, 9))
        self.assertEqual("".join(map(str, answer[at:at + 9])), self.ask_json("/v1/scenes/town/visibility", each)["visible"])

    def test_blockers_are_json_alone(self):
        for accept in (CSV, BYTES):
            answer = self.server.ask("/v1/scenes/town/visibility", "-H", "Content-Type: application/json", "-H", "Accept: " + accept,
                                     body=json.dumps({"from": POINTS[:2], "to": POINTS[:2], "first_blocker": True}))
            self.assertEqual((answer.status, answer.json()["code"]), (422, "BLOCKERS_ARE_TEXT"))

    def test_nothing_asked_is_a_table_without_rows(self):
        for path, body, names in (("rays:any", {"rays": []}, ["hits"]), ("visibility", {"from": [], "to": POINTS[:2]}, ["visible_0", "visible_1"]),
                                  ("points:nearest", {"points": [], "count": 2, "fields": ["instance"]}, ["row", "instance"])):
            self.assertEqual(self.tables(path, body)[:2], (names, []))


if __name__ == "__main__":
    case_report.main()
