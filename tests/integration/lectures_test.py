"""The lecture notes behind the project, row by row, asked of a real server. docs/lectures.md has the status of each row."""

import json
import math
import random
import re
import shutil
import subprocess
import tempfile
import time
import unittest
from fractions import Fraction
from pathlib import Path

import case_report
from sightline_server import BINARY, PATIENCE, SOURCE, Server

BOX = {"min": [-2, -3, -4], "max": [4, 3, 2]}
SQUARE = {"min": [1, 1, None], "max": [3, 3, None]}


def ray(origin, direction, **limits):
    return {"origin": list(origin), "direction": list(direction), **limits}


def slab_loop(origin, direction, low, high):
    """The general loop of the texts, in fractions: (entry, exit) of the line, or None."""
    enter, leave = -math.inf, math.inf
    for o, d, near, far in zip(origin, direction, low, high):
        if d == 0:
            if not near <= o <= far:
                return None
            continue
        first, last = (Fraction(near) - Fraction(o)) / Fraction(d), (Fraction(far) - Fraction(o)) / Fraction(d)
        if first > last:
            first, last = last, first
        enter, leave = max(enter, first), min(leave, last)
    return (enter, leave) if enter <= leave else None


def lasting_trees(server):
    """Those of demo:six once they are built in the background: one around both meshes."""
    end = time.monotonic() + PATIENCE
    while True:
        report = server.ask("/v1/scenes/six/bvh").json()
        if report["complete"] and report["top"] is None:
            return report["trees"]
        assert time.monotonic() < end, report
        time.sleep(0.02)


class Lectures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six")
        cls.addClassCleanup(cls.server.end)

    def post(self, path, body):
        answer = self.server.ask(path, "-H", "Content-Type: application/json", body=json.dumps(body))
        self.assertEqual(answer.status, 200, answer.body)
        return answer.json()

    def ask(self, rays, boxes, **options):
        """Every ray with every box."""
        return self.post("/v1/rays-boxes", {"rays": rays, "boxes": boxes, "pairing": "all", **options})["results"]

    def one(self, origin, direction, box=None, **options):
        return self.ask([ray(origin, direction)], [box or BOX], **options)[0]

    def test_row_01_a_box_in_two_and_three_dimensions(self):
        flat = self.one((0, 0.5, 77), (1, 1, 0), SQUARE)
        self.assertEqual((flat["t_enter"], flat["t_exit"]), (1, 2.5))
        self.assertEqual(self.one((-10, 0, 0), (1, 0, 0))["t"], 8)

    def test_row_02_one_t_for_each_plane(self):
        self.assertEqual(self.one((-10, 1, 0), (1, -0.5, 0), planes=True)["planes"], [8, 14, 8, -4, None, None])

    def test_row_03_the_three_figures(self):
        one, two, three = self.ask([ray((0, y, 0), (1, 1, 0)) for y in (2.5, 0.5, -2.5)], [SQUARE])
        self.assertEqual((one, three), ({"hit": False, "miss": ["x", "y"]},) * 2)
        self.assertEqual((two["hit"], two["t"]), (True, 1))

    def test_row_04_the_pairwise_test_in_two_dimensions(self):
        source = random.Random(4)
        rays = [ray([source.randint(-6, 6), source.randint(-6, 6), 0], [source.randint(-3, 3) or 1, source.randint(-3, 3) or 1, 0])
                for _ in range(2000)]
        for each, got in zip(rays, self.ask(rays, [SQUARE], line=True)):
            times = []
            for k in range(2):
                pair = sorted((Fraction(side) - each["origin"][k]) / each["direction"][k] for side in (1, 3))
                times.append(pair)
            (tx_min, tx_max), (ty_min, ty_max) = times
            self.assertEqual(got["hit"], not (tx_min > ty_max or ty_min > tx_max), each)

    def test_row_05_the_general_loop(self):
        source = random.Random(5)
        rays = [ray([source.uniform(-9, 9) if source.random() < 0.5 else source.randint(-5, 5) for _ in range(3)],
                    [source.choice([0, -0.0, 1, -1, source.uniform(-1, 1)]) for _ in range(3)]) for _ in range(3000)]
        rays = [each for each in rays if any(each["direction"])]
        for each, got in zip(rays, self.ask(rays, [BOX], line=True)):
            expected = slab_loop(each["origin"], each["direction"], BOX["min"], BOX["max"])
            self.assertEqual(got["hit"], expected is not None, each)
            if expected:
                self.assertEqual((got["t_enter"], got["t_exit"]), tuple(map(float, expected)), each)

    def test_row_06_every_octant(self):
        cube = {"min": [-1, -1, -1], "max": [1, 1, 1]}
        for signs in ((x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)):
            got = self.one([-4 * s for s in signs], signs, cube)
            self.assertEqual((got["t_enter"], got["t_exit"], len(got["faces"])), (3, 5, 3), signs)

    def test_row_07_entry_after_exit_is_a_miss(self):
        self.assertEqual(self.one((-10, -10, 0), (1, 4, 0)), {"hit": False, "miss": ["x", "y"]})

    def test_row_08_exit_before_the_origin_is_a_miss_but_not_for_a_line(self):
        self.assertEqual(self.one((10, 0, 0), (1, 0, 0))["miss"], "behind")
        line = self.one((10, 0, 0), (1, 0, 0), line=True)
        self.assertEqual((line["hit"], line["t_enter"], line["t_exit"]), (True, -12, -6))

    def test_row_09_from_inside_the_exit_and_both(self):
        got = self.one((0, 0, 0), (1, 0, 0))
        self.assertEqual((got["t"], got["t_enter"], got["t_exit"], got["inside"]), (4, -2, 4, True))

    def test_row_10_an_origin_on_a_face(self):
        for origin, direction, face in (((-2, 0, 0), (1, 0.015625, 0.015625), "-x"), ((4, 0, 0), (1, 0.015625, 0.015625), "+x")):
            got = self.one(origin, direction)
            self.assertEqual((got["t"], got["on_surface"], got["face"]), (0, True, face))

    def test_row_11_a_parallel_ray_is_tested_against_its_slab(self):
        for zero in (0.0, -0.0):
            self.assertEqual(self.one((-10, 0, 0), (1, zero, 0))["t"], 8)
            self.assertEqual(self.one((-10, 5, 0), (1, zero, 0)), {"hit": False, "miss": ["y"]})

    def test_row_12_a_parallel_ray_below_between_and_above(self):
        hits = [self.one((-10, y, 0), (1, 0, 0))["hit"] for y in (-3.0000000000000004, -3, 0, 3, 3.0000000000000004)]
        self.assertEqual(hits, [False, True, True, True, False])

    def test_row_13_the_sign_of_the_slides_second_iteration(self):
        got = self.one((10, 0, 0), (-1, 0, 0))
        self.assertEqual((got["t_enter"], got["t_exit"]), (6, 12))

    def run_beside(self, program, *arguments):
        """What a test or a benchmark of the same build prints."""
        file = Path(BINARY).resolve().parent / "tests" / program
        if not file.exists():
            self.skipTest(f"{program} is not built here")
        return subprocess.run([file, *arguments], check=True, capture_output=True, text=True, timeout=PATIENCE).stdout

    def test_row_14_williams_is_a_contestant_and_loses_what_the_server_finds(self):
        told = self.run_beside("contestants/contestants_test", "--gtest_filter=SlabTests.williams_loses_an_origin_on_the_exit_face")
        self.assertIn("[  PASSED  ] 1 test", told)
        # The two cases of that test: its limits are open, and 0 times infinity is where it starts.
        self.assertEqual(self.one((4, 0, 0), (1, 0, 0))["t"], 0)
        self.assertEqual(self.one((-2, -10, 0), (0, 1, 0))["t"], 7)

    def test_row_15_minus_zero_survives(self):
        self.assertEqual(self.one((-10, 3, 0), (1, -0.0, 0)), self.one((-10, 3, 0), (1, 0.0, 0)))
        # As text too: the same box touched at -0.
        touch = self.one((-0.0, -0.0, -0.0), (1, -0.0, -0.0), {"min": [-0.0, -0.0, -0.0], "max": [1, 0, 0]})
        self.assertEqual((touch["t"], touch["on_surface"]), (0, True))

    def test_row_16_the_inverse_is_measured_beside_the_division(self):
        told = self.run_beside("bench/accuracy_bench", "--quick", "--scene", "soup", "--smaller", "100", "--rays", "200", "--pairs", "200",
                               "--repetitions", "1")
        for name in ("slab_swap_divide", "williams2005"):
            times = [float(time) for time in re.findall(rf"^  {name} +([0-9.]+) ns .* wrong", told, re.MULTILINE)]
            self.assertGreater(len(times), 0, told)
            self.assertGreater(min(times), 0)

    def test_row_17_no_nan_in_any_answer(self):
        numbers = [0, -0.0, 1, -2, 4, 5e-324, 1.7976931348623157e308, -1e-300]
        source = random.Random(17)
        rays = [ray([source.choice(numbers) for _ in range(3)], [source.choice(numbers) for _ in range(3)]) for _ in range(3000)]
        rays = [each for each in rays if any(each["direction"])]
        text = json.dumps(self.ask(rays, [BOX], line=True, planes=True))
        self.assertNotRegex(text, "(?i)nan|infinity")

    def test_row_18_hits_in_front_and_behind(self):
        front, behind = self.ask([ray((-10, 0, 0), (1, 0, 0)), ray((10, 0, 0), (1, 0, 0))], [BOX], line=True)
        self.assertEqual((front["t_enter"], behind["t_enter"]), (8, -12))

    def test_row_19_aligned_and_oriented_boxes(self):
        diamond = {"center": [0, 0, 0], "half": [1, 1, 1], "axes": [[1, 1, 0], [1, -1, 0], [0, 0, 1]]}
        self.assertEqual(self.one((-10, 0, 0), (1, 0, 0), diamond)["t"], 9)
        counts = self.post("/v1/scenes/six/boxes:count", {"boxes": [{"min": [-9, 0, -9], "max": [0, 9, 9]},
                                                                   {"center": [-4, 1, 0], "half": [9, 9, 9], "rotation": [0, 0, 0, 1]}]})
        self.assertEqual(counts["counts"][0], 3)
        self.assertGreater(counts["counts"][1], 0)

    def test_row_20_boxes_of_pov_ray(self):
        text = "box { <4, 3, 2>, <-2, -3, -4> pigment { color rgb <1, 0, 0> } }\nbox { <10, 0, 0>, <12, 1, 1> }\n"
        self.assertEqual(self.server.put("pov", text).status, 201)
        hits = self.post("/v1/scenes/pov/rays:closest", {"rays": [ray((-10, 0, 0), (1, 0, 0))], "fields": ["t", "material"]})["hits"]
        self.assertEqual(hits[0]["t"], 8)
        self.assertIn("rgb <1, 0, 0>", hits[0]["material"])

    def test_row_20_colours_of_pigments(self):
        looks = {"pigment { color rgb <1, 0.1, 0.7> }": [1, 0.1, 0.7, 1], "pigment{rgb 0.8}": [0.8, 0.8, 0.8, 1], "pigment { rgb y }": [0, 1, 0, 1],
                 "texture { pigment { colour rgbt <.25, .5, 1, .75> } finish { ambient 0.3 } }": [0.25, 0.5, 1, 0.25],
                 "pigment { rgbft <1, 1, 1, 0.25, 0.5> }": [1, 1, 1, 0.25], "finish { ambient rgb 0.2 } pigment { rgb <-1, 2, +3> }": [-1, 2, 3, 1],
                 "pigment { Red }": None, "pigment { checker rgb 1, rgb 0 }": None, "pigment { rgb <1, 0, 0> scale 2 }": None, "no_shadow": None,
                 "pigment { rgb <1, 0> }": None, "pigment { rgb Red }": None}
        text = "".join(f"box {{ <{3 * i}, 0, 0>, <{3 * i + 1}, 1, 1> {look} }}\n" for i, look in enumerate(looks))
        self.assertEqual(self.server.put("looks", text).status, 201)
        rays = [ray((3 * i + 0.3, 9, 0.6), (0, -1, 0)) for i in range(len(looks))]
        hits = self.post("/v1/scenes/looks/rays:closest", {"rays": rays, "fields": ["colour", "material"]})["hits"]
        for hit, expected in zip(hits, looks.values(), strict=True):
            with self.subTest(material=hit["material"]):
                # The weights of the corners add up to 1 before rounding alone.
                apart = [abs(got - channel) for got, channel in zip(hit["colour"] or [], expected or [], strict=True)]
                self.assertEqual((hit["colour"] is None, max(apart, default=0) < 2**-50), (expected is None, True), hit["colour"])
        self.assertEqual([hits[i]["material"] for i in (0, 3)], ["{ color rgb <1, 0.1, 0.7> }", "{ colour rgbt <.25, .5, 1, .75> }"])

    def test_row_21_the_normal_of_the_face_that_was_hit(self):
        got = self.one((-10, 0, 0), (1, 0.015625, 0.015625))
        self.assertEqual((got["face"], got["normal"]), ("-x", [-1, 0, 0]))
        corner = self.one((-3, -4, -5), (1, 1, 1))
        self.assertEqual((corner["t"], corner["faces"]), (1, ["-x", "-y", "-z"]))
        self.assertEqual(self.one((-10, 3, 2), (1, 0, 0))["faces"], ["-x", "+y", "+z"])

    def scaled(self, scale):
        cube = {"min": [0, 0, 0], "max": [scale] * 3}
        beside = math.nextafter(scale, math.inf)
        on, off = self.ask([ray((-scale, scale, 0), (1, 0, 0)), ray((-scale, beside, 0), (1, 0, 0))], [cube])
        self.assertEqual((on["hit"], on["t"], off["hit"]), (True, scale, False))

    def test_row_22_no_epsilon_at_scale_1e_minus_6(self):
        self.scaled(1e-6)

    def test_row_23_no_epsilon_at_scale_1e6(self):
        self.scaled(1e6)

    def explained(self, origin, direction):
        body = {"rays": [ray(origin, direction)], "explain": True, "fields": ["t", "node", "triangle"]}
        answer = self.post("/v1/scenes/six/rays:closest", body)
        tested = {"left": [], "right": []}
        for box in answer["explain"]["boxes"]:
            for triangle in box.get("triangles", []):
                tested["left" if triangle["instance"] == 0 else "right"].append((triangle["triangle"], triangle["verdict"]))
        return answer["hits"][0], tested, answer["explain"]["boxes"]

    def test_row_24_the_hierarchy_of_six_triangles_is_a_root_over_two_subtrees(self):
        for flags in ((), ("--skip", "none")):
            with Server(*flags, "--preload", "six=demo:six") as server:
                tree, = lasting_trees(server)
                self.assertEqual((tree["nodes"], tree["leaves"], tree["triangles"], tree["depth"]), (1, 2, 6, 1))

    def test_row_24_both_left_right_and_none_are_four_different_visits(self):
        def visit(origin, direction):
            """The boxes and their verdicts: the root, then those of the subtrees, from left to right."""
            _, tested, boxes = self.explained(origin, direction)
            root, *below = sorted(boxes, key=lambda box: (box["parent"] is not None, box["min"][0]))
            self.assertEqual((root["min"], root["max"], root["leaf"]), ([-6, 0, -2], [8, 4, 2], False))
            self.assertEqual([(box["min"], box["max"], box["leaf"], box["parent"]) for box in below],
                             [([-6, 0, -2], [0, 4, 2], True, 0), ([2, 0, -2], [8, 4, 2], True, 0)])
            # What is tested are the triangles of the subtrees that are entered.
            for box, side in zip(below, ("left", "right")):
                self.assertEqual(len(tested[side]), 3 if box["verdict"] == "entered" else 0)
            return tuple(box["verdict"] for box in (root, *below))
        lasting_trees(self.server)
        # The first hits nothing on the left: a hit there would make the right farther.
        self.assertEqual(visit((-10, 3.5, 0.9), (1, 0, 0)), ("entered", "entered", "entered"))
        self.assertEqual(visit((-5, 10, 0), (0, -1, 0)), ("entered", "entered", "missed"))
        self.assertEqual(visit((3, 10, 0), (0, -1, 0)), ("entered", "missed", "entered"))
        self.assertEqual(visit((1, 10, 0), (0, -1, 0)), ("entered", "missed", "missed"))

    def test_row_24_the_hierarchy_of_six_triangles_both(self):
        hit, tested, boxes = self.explained((-10, 1, 0), (1, 0, 0))
        self.assertEqual(hit, {"t": 4.5, "triangle": 0, "node": "left"})
        self.assertIn((0, "hit"), tested["left"])
        self.assertEqual((boxes[0]["parent"], boxes[0]["verdict"]), (None, "entered"))

    def test_row_24_the_hierarchy_of_six_triangles_left(self):
        hit, tested, _ = self.explained((-5, 10, 0), (0, -1, 0))
        self.assertEqual(hit, {"t": 8, "triangle": 0, "node": "left"})
        self.assertNotIn("hit", [verdict for _, verdict in tested["right"]])

    def test_row_24_the_hierarchy_of_six_triangles_right(self):
        hit, tested, _ = self.explained((3, 10, 0), (0, -1, 0))
        self.assertEqual(hit, {"t": 8, "triangle": 0, "node": "right"})
        self.assertNotIn("hit", [verdict for _, verdict in tested["left"]])

    def test_row_24_the_hierarchy_of_six_triangles_none(self):
        hit, tested, boxes = self.explained((1, 10, 0), (0, -1, 0))
        self.assertIsNone(hit)
        self.assertNotIn("hit", [verdict for side in tested.values() for _, verdict in side])
        self.assertTrue(all(box["parent"] is None or box["parent"] < i for i, box in enumerate(boxes)))

    def test_row_25_the_boxes_of_each_level(self):
        lasting_trees(self.server)
        def level(scene, number):
            answer = self.server.ask(f"/v1/scenes/{scene}/bvh?level={number}").json()["level"]
            return answer["boxes"], answer["truncated"]
        self.assertEqual(level("six", 0), ([{"min": [-6, 0, -2], "max": [8, 4, 2], "leaf": False}], False))
        self.assertEqual(sorted(level("six", 1)[0], key=lambda box: box["min"]),
                         [{"min": [-6, 0, -2], "max": [0, 4, 2], "leaf": True}, {"min": [2, 0, -2], "max": [8, 4, 2], "leaf": True}])
        self.assertEqual(level("six", 2), ([], False))
        self.assertEqual(self.server.ask("/v1/scenes/six/bvh?level=-1").json()["code"], "QUERY_INVALID")

    def test_row_25_what_the_trees_look_like(self):
        self.post("/v1/scenes/six/rays:closest", {"rays": [ray((-10, 1, 0), (1, 0, 0)), ray((7, 9, 0), (0, -1, 0))]})
        report = self.server.ask("/v1/scenes/six/bvh").json()
        self.assertGreater(len(report["trees"]), 0)
        for tree in report["trees"]:
            self.assertTrue(tree["contained"])
            self.assertLessEqual(tree["arity"], 8)
            self.assertLessEqual(tree["shallowest"], tree["depth"])
            self.assertGreaterEqual(tree["overlap"], 0)
        if report["complete"]:
            self.assertEqual(sum(tree["triangles"] for tree in report["trees"]), 6)

    def test_row_26_the_interactive_example_is_served(self):
        # What a browser makes of it is in page_test.py.
        page = self.server.ask("/learn")
        self.assertEqual((page.status, page.headers["content-type"]), (200, "text/html; charset=utf-8"))

    def test_row_27_the_page_has_the_three_figures(self):
        source = (SOURCE / "server/page/app/src/slabs.js").read_text(encoding="utf-8")
        figures = re.findall(r'\["Figure \d: (\w+)", \{origin: \[(.*?)\], direction: \[(.*?)\], ...FLAT\}\]', source)
        rays = [ray(*[[float(x) for x in numbers.split(",")] for numbers in figure[1:]]) for figure in figures]
        self.assertEqual([figure[0] == "hits" for figure in figures], [False, True, False])
        self.assertEqual([each["hit"] for each in self.ask(rays, [SQUARE])], [False, True, False])

    def test_row_28_a_miss_is_no_number(self):
        self.assertEqual(self.one((-10, 5, 0), (1, 0, 0)), {"hit": False, "miss": ["y"]})
        self.assertEqual(self.post("/v1/scenes/six/rays:closest", {"rays": [ray((1, 10, 0), (0, -1, 0))]})["hits"], [None])

    def test_row_29_every_reference_is_cited_where_it_is_used(self):
        # That what is cited has an entry is a law of the rooms; here that every entry is used, and the texts' own where they should be.
        listed = set(re.findall(r"^\*\*\[(\w+)\]\*\*", (SOURCE / "docs/REFERENCES.md").read_text(encoding="utf-8"), re.M))
        cited = {}
        for room in ("core", "proto", "server", "tests", "docs"):
            for path in (SOURCE / room).rglob("*"):
                if path.suffix in {".h", ".cpp", ".py", ".md"} and path.name != "REFERENCES.md" and path != Path(__file__).resolve():
                    for key in re.findall(r"\[(\w+)\]", path.read_text(encoding="utf-8")):
                        cited.setdefault(key, set()).add(str(path.relative_to(SOURCE)))
        self.assertEqual(sorted(listed - set(cited)), [])
        self.assertIn("core/geometry/ray_box.h", cited["Kay1986"])  # the slab test
        self.assertIn("tests/contestants/slab_tests.cpp", cited["Williams2005"])  # inverse and sign once for each ray
        self.assertIn("core/geometry/triangle_box.h", cited["AkenineMoeller2001"])  # separating axes

    @unittest.skipUnless(shutil.which("c++"), "no C++ compiler")
    def test_row_30_a_complete_example(self):
        source = SOURCE / "tests/integration/raybox.cpp"
        self.assertLessEqual(len(source.read_text(encoding="utf-8").splitlines()), 100)
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder, "raybox")
            subprocess.run(["c++", "-std=c++17", "-Wall", "-Wextra", "-Werror", source, "-lcurl", "-o", program], check=True, timeout=PATIENCE)
            told = subprocess.run([program, self.server.url], check=True, capture_output=True, text=True, timeout=PATIENCE).stdout
        lines = dict(line.split(": ", 1) for line in told.splitlines())
        self.assertEqual(json.loads(lines["from the front"])["t"], 8)
        self.assertEqual(json.loads(lines["from inside"])["t"], 2)
        self.assertEqual(json.loads(lines["in a face"])["t"], 8)
        self.assertEqual(json.loads(lines["beside"]), {"hit": False, "miss": ["y"]})
        self.assertEqual(json.loads(lines["behind"])["miss"], "behind")


class Page(unittest.TestCase):
    """docs/lectures.md states the status of every row."""

    def setUp(self):
        lines = (SOURCE / "docs/lectures.md").read_text(encoding="utf-8").splitlines()
        self.rows = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines if re.match(r"\| \d", line)]

    def test_every_row_has_a_status_and_its_tests(self):
        self.assertEqual([row[0] for row in self.rows], [str(number) for number in range(1, 31)])
        for number, _, status, tests, _ in self.rows:
            with self.subTest(row=number):
                self.assertRegex(status, "^(complete|partial: .+)$")
                own = [name.removeprefix("test_") for name in vars(Lectures) if name.startswith(f"test_row_{int(number):02}_")]
                self.assertGreater(len(own), 0)
                self.assertEqual(tests.split(", "), [f"`{name}`" for name in own])

    def test_other_tests_that_it_names_exist(self):
        sources = [path.read_text(encoding="utf-8") for path in (SOURCE / "tests").rglob("*.cpp")]
        known = {found for text in sources for found in re.findall(r"^TEST(?:_[FP])?\((\w+), (\w+)\)", text, re.MULTILINE)}
        named = re.findall(r"`([A-Z]\w+)\.(\w+|\*)`", " ".join(row[4] for row in self.rows))
        self.assertGreater(len(named), 20)
        suites = {suite for suite, _ in known}
        self.assertEqual([each for each in named if (each[0] not in suites if each[1] == "*" else each not in known)], [])


if __name__ == "__main__":
    case_report.main()
