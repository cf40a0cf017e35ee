"""Hits as CSV, PLY, PCD, NPY and NPZ: read here by the formats' own texts, and equal to the columns of JSON."""

import ast
import csv
import io
import json
import math
import struct
import zipfile

import case_report
from sensors_test import node_colour
from two_scenes import TwoScenes

SCAN = {"kind": "lidar", "position": [60, 12, 70], "elevations": [-20, -5, 0, 9], "azimuths": 90, "range": [1, 120], "returns": 2}
FIELDS = ["t", "instance", "position", "normal", "uv", "front", "node_id", "material_id"]
TYPES = {"double": "d", "int": "i", "uint": "I", "uchar": "B", "F8": "d", "I4": "i", "U4": "I", "U1": "B"}


def read_npy(data):
    """(type, shape, bytes of the values)."""
    assert data[:8] == b"\x93NUMPY\x01\x00"
    length, = struct.unpack("<H", data[8:10])
    assert (10 + length) % 64 == 0 and data[9 + length:10 + length] == b"\n"
    head = ast.literal_eval(data[10:10 + length].decode())
    assert head["fortran_order"] is False
    return head["descr"], head["shape"], data[10 + length:]


class Tables(TwoScenes):
    def ask(self, body, kind, scene="town"):
        answer = self.server.query(scene, "closest", body, "-H", "Accept: " + kind)
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, kind), answer.body[:300])
        return answer.body

    def columns(self, fields, scene="town", generator=SCAN):
        answer = self.server.query(scene, "closest", {"generator": generator, "fields": fields})
        self.assertEqual(answer.status, 200, answer.body[:300])
        return answer.json()

    def rows(self, fields, **options):
        """One dictionary for each slot; None for a miss."""
        columns = self.columns(fields, **options)
        width = {"position": 3, "normal": 3, "uv": 2}
        count = len(columns["instance"])
        return [None if columns["instance"][i] < 0 else
                {name: columns[name][i * width[name]:(i + 1) * width[name]] if name in width else columns[name][i] for name in fields}
                for i in range(count)]

    def test_csv(self):
        fields = [*FIELDS, "node", "node_path"]
        table = list(csv.reader(io.StringIO(self.ask({"generator": SCAN, "fields": fields}, "text/csv").decode(), newline="")))
        self.assertEqual(table[0], ["t", "instance", "position_x", "position_y", "position_z", "normal_x", "normal_y", "normal_z", "uv_u", "uv_v",
                                    "front", "node", "node_id", "node_path", "material_id"])
        rows = self.rows(fields)
        self.assertEqual(len(table) - 1, len(rows))
        for cells, row in zip(table[1:], rows):
            if row is None:
                self.assertEqual(set(cells), {""})
                continue
            self.assertEqual([float(x) for x in cells[:8]], [row["t"], row["instance"], *row["position"], *row["normal"]])
            uv = [None if cell == "" else float(cell) for cell in cells[8:10]]
            self.assertEqual(uv, row["uv"])
            self.assertEqual(cells[10], "true" if row["front"] else "false")
            self.assertEqual(cells[11:], [row["node"], str(row["node_id"]), row["node_path"], str(row["material_id"])])

    def test_csv_quotes_names(self):
        from made_scene import triangle_glb
        name = 'a "b", c\nd'
        self.assertIn(self.server.put("names", triangle_glb([{"mesh": 0, "name": name}])).status, (200, 201))
        body = {"rays": [{"origin": [0.1, 0.1, 1], "direction": [0, 0, -1]}, {"origin": [5, 5, 1], "direction": [0, 0, -1]}], "fields": ["t", "node"]}
        table = list(csv.reader(io.StringIO(self.ask(body, "text/csv", "names").decode(), newline="")))
        self.assertEqual(table, [["t", "node"], ["1", name], ["", ""]])

    def check_points(self, points, rows):
        """Points as dictionaries, against the rows that are hits."""
        hits = [(i, row) for i, row in enumerate(rows) if row is not None]
        self.assertGreater(len(hits), 100)
        self.assertEqual(len(points), len(hits))
        for point, (i, row) in zip(points, hits):
            self.assertEqual(point["ray"], i)
            self.assertEqual([point["x"], point["y"], point["z"]], row["position"])
            self.assertEqual((point["t"], point["node_id"], point["front"]), (row["t"], row["node_id"], row["front"]))
            self.assertEqual([None if math.isnan(point[f"uv_{k}"]) else point[f"uv_{k}"] for k in "uv"], row["uv"])

    def test_ply(self):
        head, data = self.ask({"generator": SCAN, "fields": FIELDS}, "application/x-ply").split(b"end_header\n", 1)
        lines = head.decode().splitlines()
        self.assertEqual(lines[:2], ["ply", "format binary_little_endian 1.0"])
        properties = [line.split()[1:] for line in lines if line.startswith("property")]
        form = struct.Struct("<" + "".join(TYPES[kind] for kind, _ in properties))
        points = [dict(zip((name for _, name in properties), values)) for values in form.iter_unpack(data)]
        self.assertEqual(lines[2], f"element vertex {len(points)}")
        rows = self.rows(FIELDS)
        self.check_points(points, rows)
        for point, row in zip(points, filter(None, rows)):
            self.assertEqual([point["nx"], point["ny"], point["nz"]], row["normal"])
            self.assertEqual([point["red"], point["green"], point["blue"]], node_colour(row["node_id"]))

    def test_pcd(self):
        head, data = self.ask({"generator": SCAN, "fields": FIELDS}, "application/x-pcd").split(b"DATA binary\n", 1)
        lines = dict(line.split(" ", 1) for line in head.decode().splitlines())
        names, sizes, types = (lines[key].split() for key in ("FIELDS", "SIZE", "TYPE"))
        form = struct.Struct("<" + "".join(TYPES[kind + size] for kind, size in zip(types, sizes)))
        points = [dict(zip(names, values)) for values in form.iter_unpack(data)]
        self.assertEqual((lines["VERSION"], lines["HEIGHT"], lines["WIDTH"], lines["POINTS"]), ("0.7", "1", str(len(points)), str(len(points))))
        self.assertEqual(lines["COUNT"].split(), ["1"] * len(names))
        rows = self.rows(FIELDS)
        self.check_points(points, rows)
        for point, row in zip(points, filter(None, rows)):
            red, green, blue = node_colour(row["node_id"])
            self.assertEqual(point["rgb"], red << 16 | green << 8 | blue)

    def test_points_have_positions_and_no_colour_unless_it_is_asked_for(self):
        head, _ = self.ask({"generator": SCAN, "fields": ["t"]}, "application/x-ply").split(b"end_header\n", 1)
        self.assertEqual([line.split()[-1] for line in head.decode().splitlines() if "property" in line], ["ray", "t", "x", "y", "z"])

    def check_array(self, kind, shape, data, name, rows):
        width = shape[1] if len(shape) > 1 else 1
        form = struct.Struct("<" + {"<f8": "d", "<i8": "q", "|b1": "?"}[kind] * width)
        values = list(form.iter_unpack(data))
        self.assertEqual((len(values), shape[0]), (len(rows), len(rows)))
        for value, row in zip(values, rows):
            self.check_value(kind, value, name, row)

    def check_value(self, kind, value, name, row):
        got = list(value) if len(value) > 1 else value[0]
        if row is None:
            nothing = {"<i8": -1, "|b1": False}.get(kind, math.inf)
            if name not in ("t", "distance") and kind == "<f8":
                self.assertTrue(all(map(math.isnan, value)))
            else:
                self.assertEqual(got, nothing)
            return
        expected = row[name]
        if isinstance(expected, list):
            got = [None if math.isnan(x) else x for x in got]
        self.assertEqual(got, expected)

    def test_npy(self):
        kinds, shape, data = read_npy(self.ask({"generator": SCAN, "fields": FIELDS}, "application/x-npy"))
        self.assertEqual(kinds, [("t", "<f8"), ("instance", "<i8"), ("position", "<f8", (3,)), ("normal", "<f8", (3,)), ("uv", "<f8", (2,)),
                                 ("front", "|b1"), ("node_id", "<i8"), ("material_id", "<i8")])
        letters = {"<f8": "d", "<i8": "q", "|b1": "?"}
        form = struct.Struct("<" + "".join(letters[each[1]] * (each[2][0] if len(each) > 2 else 1) for each in kinds))
        rows = self.rows(FIELDS)
        self.assertEqual(shape, (len(rows),))
        records = list(form.iter_unpack(data))
        self.assertEqual(len(records), len(rows))
        for record, row in zip(records, rows):
            at = 0
            for name, kind, *more in kinds:
                width = more[0][0] if more else 1
                self.check_value(kind, record[at:at + width], name, row)
                at += width

    def test_npz(self):
        rows = self.rows(FIELDS)
        with zipfile.ZipFile(io.BytesIO(self.ask({"generator": SCAN, "fields": FIELDS}, "application/x-npz"))) as archive:
            self.assertIsNone(archive.testzip())
            self.assertEqual(sorted(archive.namelist()), sorted(f"{name}.npy" for name in FIELDS))
            for name in FIELDS:
                self.check_array(*read_npy(archive.read(f"{name}.npy")), name, rows)

    def test_numpy_reads_them(self):
        try:
            import numpy
        except ImportError:
            self.skipTest("numpy is not installed")
        body = {"generator": SCAN, "fields": FIELDS}
        records = numpy.load(io.BytesIO(self.ask(body, "application/x-npy")))
        columns = numpy.load(io.BytesIO(self.ask(body, "application/x-npz")))
        for name in FIELDS:
            self.assertTrue(numpy.array_equal(records[name], columns[name], equal_nan=columns[name].dtype.kind == "f"))

    def test_rays_of_a_client_and_faults(self):
        ray = {"origin": [3, 200, 5], "direction": [0, -1, 0]}
        text = self.ask({"rays": [ray], "fields": ["t", "node"]}, "text/csv").decode()
        self.assertEqual(text, "t,node\r\n199.75,market square\r\n")
        for accepted in ("text/csv; charset=utf-8", "Text/CSV;q=0.9, */*", " text/csv,application/json"):
            answer = self.server.query("town", "closest", {"rays": [ray], "fields": ["t", "node"]}, "-H", "Accept: " + accepted)
            self.assertEqual((answer.headers["content-type"], answer.body.decode()), ("text/csv", text))
        for kind in ("application/x-ply", "application/x-pcd", "application/x-npy", "application/x-npz"):
            answer = self.server.query("town", "closest", {"rays": [ray], "fields": ["node"]}, "-H", "Accept: " + kind)
            self.assertEqual((answer.status, answer.json()["code"], answer.json()["errors"][0]["pointer"]), (422, "FIELD_IS_TEXT", "/fields"))
            answer = self.server.query("town", "closest", {"rays": [ray], "explain": True}, "-H", "Accept: " + kind)
            self.assertEqual((answer.status, answer.json()["code"]), (422, "EXPLAIN_IS_TEXT"))
        self.assertEqual(json.loads(self.server.query("town", "any", {"rays": [ray]}, "-H", "Accept: application/x-ply").body), {"hits": [True]})


if __name__ == "__main__":
    case_report.main()
