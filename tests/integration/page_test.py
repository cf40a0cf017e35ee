"""/: what its parts say in their headers, and what a browser does with it.

The browser part needs chromium and the packages that CMake installs for the page; it says SKIPPED without them.
"""

import contextlib
import functools
import gzip
import json
import math
import os
import random
import re
import shutil
import struct
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from urllib.parse import parse_qs, urlencode

import case_report
import headless_browser
from headless_browser import BROWSER
from made_scene import tiles, triangle_glb
from process_status import is_sanitized
from sightline_server import BINARY, DATA, JSON_TYPE, PATIENCE, SOURCE, Server, bearer, demo_glb, make_key, with_document, write_keys

PAGES = ("/", "/learn", "/status", "/docs/README.md", "/docs/guides/page.md")
SCRIPTS = ("boot", "page", "learn", "status", "guide")
PARTS = {**dict.fromkeys(PAGES, "text/html"), **{f"/{name}.js": "text/javascript" for name in SCRIPTS}, "/page.css": "text/css"}
MODULES = Path(BINARY).resolve().parent / "page/node_modules"
NODE = shutil.which("node")
# Pictures for people stay where this says.
PICTURES = os.environ.get("SIGHTLINE_PICTURES")
# What page_browser.mjs says of it. A sanitizer examines the server, which does not know the size and theme of a page.
views = "every" if PICTURES else ""
MISSING = (headless_browser.MISSING or ("no node is installed" if NODE is None else
           "the page was built without its packages" if not (MODULES / "playwright-core").is_dir() else ""))


def browse(url, *words):
    """What tests/integration/page_browser.mjs saw."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([NODE, SOURCE / "tests/integration/page_browser.mjs", MODULES, BROWSER, url, PICTURES or folder, *words],
                              capture_output=True, text=True, timeout=PATIENCE * 4, check=False, env={**os.environ, "SIGHTLINE_VIEWS": views})
    if done.returncode != 0:
        raise AssertionError(done.stderr[-3000:])
    return json.loads(done.stdout)


@functools.cache
def lecture(url):
    """What two tests look at."""
    return browse(url, "learn")


def padded(glb, count):
    """The GLB with so many more bytes in its buffer, that nothing uses."""
    def longer(document):
        document["buffers"][0]["byteLength"] += count
    made = with_document(glb, longer)
    json_bytes, = struct.unpack_from("<I", made, 12)
    at = 20 + json_bytes
    binary, = struct.unpack_from("<I", made, at)
    return made[:8] + struct.pack("<I", len(made) + count) + made[12:at] + struct.pack("<I", binary + count) + made[at + 4:] + bytes(count)


def skip_unbuilt(server):
    if len(server.ask("/page.js").body) < 10000:
        raise unittest.SkipTest("the page is not part of this build")


class PageParts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six")
        cls.addClassCleanup(cls.server.end)

    def test_headers_are_those_of_a_page(self):
        for path, kind in PARTS.items():
            with self.subTest(path=path):
                answer = self.server.ask(path)
                self.assertEqual((answer.status, answer.headers["content-type"]), (200, f"{kind}; charset=utf-8"))
                self.assertEqual((answer.headers["cache-control"], answer.headers["x-content-type-options"]), ("no-cache", "nosniff"))
                answer.body.decode("ascii")
                tag = answer.headers["etag"]
                again = self.server.ask(path, "-H", f"If-None-Match: {tag}")
                self.assertEqual((again.status, again.body, again.headers["etag"]), (304, b"", tag))
                self.assertEqual(self.server.ask(path, "-X", "POST").status, 405)

    def test_the_policy_allows_this_server_alone(self):
        policy = self.server.ask("/").headers["content-security-policy"]
        self.assertEqual(policy, self.server.ask("/docs").headers["content-security-policy"])
        self.assertNotIn("unsafe", policy)

    def test_nothing_is_inline_and_nothing_comes_from_elsewhere(self):
        page = b"".join(self.server.ask(path).body for path in PAGES).decode("ascii")
        self.assertEqual(re.findall(r'<(?:script|style)\b(?![^>]*\bsrc=)|\son\w+=|\sstyle=|javascript:|https?://', page), [])

    def test_texts_are_compressed(self):
        skip_unbuilt(self.server)
        whole = self.server.ask("/page.js").body
        for coding in ("gzip", "zstd"):
            packed = self.server.ask("/page.js", "-H", f"Accept-Encoding: {coding}")
            self.assertEqual(packed.headers["content-encoding"], coding)
            self.assertLess(len(packed.body), len(whole) / 2.5)

    def test_the_page_is_open_and_what_it_shows_is_not(self):
        _, line = make_key("read", "people")
        with tempfile.TemporaryDirectory() as folder:
            with Server("--preload", "six=demo:six", "--keys", write_keys(Path(folder, "keys"), line)) as server:
                for path in PARTS:
                    self.assertEqual(server.ask(path).status, 200)
                self.assertEqual(server.ask("/v1/scenes/six/geometry").status, 401)

    def test_every_document_is_served_and_nothing_else(self):
        skip_unbuilt(self.server)
        packed = self.server.ask("/docs/documents.json.gz")
        self.assertEqual(packed.headers["content-type"], "application/gzip")
        documents = json.loads(gzip.decompress(packed.body))
        wanted = [SOURCE / f"{name}.md" for name in ("README", "ARCHITECTURE", "CONTRIBUTING", "CHANGELOG")]
        wanted += [*SOURCE.glob("docs/*.md"), *SOURCE.glob("docs/*/*.md")]
        self.assertEqual({each["path"]: each["text"] for each in documents},
                         {str(path.relative_to(SOURCE)): path.read_text(encoding="utf-8") for path in wanted})
        for each in documents:
            self.assertEqual(self.server.ask(f"/docs/{each['path'].removeprefix('docs/')}").status, 200, each["path"])
        for path in ("/docs/nothing.md", "/docs/guides/nothing.md", "/docs/guides", "/docs/guides/page.md/x", "/docs/docs/lectures.md", "/docs/..%2FREADME.md"):
            self.assertEqual(self.server.ask(path).status, 404, path)

    def test_the_pages_fit_their_part_of_the_binary(self):
        sizes = {path: len(self.server.ask(path).body) for path in (*PARTS, "/docs/documents.json.gz") if path != PAGES[-1]}
        self.assertLess(sum(sizes.values()), 1.2e6)
        print("bytes of the pages:", sum(sizes.values()), sizes)

    @unittest.skipIf(MISSING, MISSING)
    def test_the_bundle_is_the_same_bytes_each_time(self):
        skip_unbuilt(self.server)
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([NODE, MODULES / "esbuild/bin/esbuild", *(f"src/{name}.js" for name in SCRIPTS), "src/page.css", f"--outdir={folder}", "--bundle", "--minify",
                            "--format=iife", "--target=es2022", "--charset=ascii", "--legal-comments=eof", "--log-level=warning"],
                           cwd=SOURCE / "server/page/app", env={**os.environ, "NODE_PATH": str(MODULES)}, check=True, timeout=PATIENCE)
            for name in (*(f"{name}.js" for name in SCRIPTS), "page.css"):
                self.assertEqual(Path(folder, name).read_bytes(), self.server.ask(f"/{name}").body)


@unittest.skipIf(MISSING, MISSING)
class PageInBrowser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # A sanitizer is slow, and the page tells of an answer that came too late.
        cls.server = Server("--preload", "town=demo:town", "--preload", "six=demo:six", "--request-seconds", 600, memory=None)
        cls.addClassCleanup(cls.server.end)
        skip_unbuilt(cls.server)
        global views
        if is_sanitized(cls.server):
            views = "one"

    def same_as_curl(self, seen):
        """The answer that the page shows is the one that curl gets for the request that it shows."""
        if seen["path"].endswith("/bvh"):
            answer = self.server.ask(f"{seen['path']}?{urlencode(json.loads(seen['body']))}")
        elif "image" in json.loads(seen["body"]):
            answer = self.server.ask(seen["path"], "-H", JSON_TYPE, "-H", "Accept: image/x-portable-floatmap", body=seen["body"])
            self.assertEqual(seen["raw"], f"image/x-portable-floatmap, {len(answer.body)} bytes")
            return answer.body
        else:
            answer = self.server.ask(seen["path"], "-H", JSON_TYPE, body=seen["body"])
        # The page cuts what nobody reads.
        most = 200000
        self.assertEqual(answer.body.decode()[:most], seen["raw"][:most])
        return answer.json()

    def test_a_click_is_answered_as_curl_is_in_every_size_and_theme(self):
        for run in browse(self.server.url, "click"):
            with self.subTest(size=run["size"], theme=run["theme"]):
                self.assertEqual((run["complaints"], run["foreign"]), ([], []))
                self.assertEqual(run["triangles"], "362254")
                hit, = self.same_as_curl(run)["hits"]
                self.assertIsNotNone(hit)
                self.assertIn(hit["node"], run["outcome"])
                self.assertEqual(len(run["rows"]), len(hit))
                self.assertEqual((run["overflow"], run["barriers"]), ([], []))
                print(run["size"], run["theme"], "first paint", run["paint"], "ms, first picture after", run["first"], "ms, triangles after", run["drawn"], "ms")

    def points(self, run, kind="point"):
        return [shape["points"] for shape in run["shapes"] if shape["kind"] == kind]

    def test_each_gesture_asks_and_draws_what_the_api_answers(self):
        runs = browse(self.server.url, "gestures")
        self.assertEqual(len(runs), {"every": 56, "": 28, "one": 14}[views])
        for run in runs:
            with self.subTest(name=run["name"], size=run["size"]):
                self.assertEqual((run["complaints"], run["foreign"], run["overflow"], run["notice"]), ([], [], [], ""))
                getattr(self, run["name"])(run, json.loads(run["body"]), self.same_as_curl(run))

    def measure(self, run, query, answer):
        self.assertEqual(len(query["rays"]), 2)
        ends = [points[0] for points in self.points(run)]
        line, = self.points(run, "line")
        self.assertEqual(line, ends)
        # What is snapped to is a corner, lies on an edge, or is the hit itself.
        for end, hit, kind in zip(ends, answer["hits"], re.findall(r"corner|edge|surface", run["outcome"])):
            name = f"{hit['instance']}.{hit['primitive']}.{hit['triangle']}"
            corners = self.server.ask(f"/v1/scenes/town/triangles?ids={name}").json()["triangles"][0]["corners"]
            if kind == "corner":
                self.assertIn(end, corners)
            elif kind == "surface":
                self.assertEqual(end, hit["position"])
            else:
                sides = [math.dist(a, end) + math.dist(end, b) - math.dist(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
                self.assertLess(min(sides), 1e-9)
        self.assertAlmostEqual(float(re.search(r"Distance (\S+)", run["outcome"])[1]), math.dist(*ends), 9)

    def select(self, run, query, answer):
        planes = query["boxes"][0]["planes"]
        result, = answer["results"]
        self.assertGreater(result["total"], 0)
        self.assertEqual(run["outcome"], f"{result['total']} node{'s' * (result['total'] > 1)} selected.")
        self.assertEqual(run["rows"], [f"{each['node_id']}{each['node']}" for each in result["nodes"]])
        # Each small node has its box: the loop of its lowest corners comes first.
        bounds = {node["node_id"]: node["bounds"] for node in self.server.ask("/v1/scenes/town/nodes?limit=100000").json()["nodes"]}
        lowest = [points[0] for points in self.points(run, "loop")[::2]]
        self.assertGreater(len(lowest), 2)
        self.assertLessEqual({tuple(point) for point in lowest}, {tuple(bounds[each["node_id"]]["min"]) for each in result["nodes"]})
        # The target of the camera lies in the rectangle.
        self.assertEqual([plane for plane in planes if plane[1] * 8 > plane[3]], [])
        self.assertIn("clock tower", [each["node"] for each in result["nodes"]])

    def node_boxes(self, run, answer, asked):
        """The boxes of the nodes that are smaller than half of the scene are drawn after `asked` shapes of the request."""
        result, = answer["results"]
        self.assertGreater(result["total"], 0)
        self.assertEqual(run["outcome"], f"{result['total']} node{'s' * (result['total'] > 1)} selected.")
        bounds = {node["node_id"]: node["bounds"] for node in self.server.ask("/v1/scenes/town/nodes?limit=100000").json()["nodes"]}
        drawn = [shape["points"] for shape in run["shapes"][asked:] if shape["kind"] == "loop"]
        lowest = {tuple(points[0]) for points in drawn[::2]}
        self.assertGreater(len(lowest), 0)
        self.assertLessEqual(lowest, {tuple(bounds[each["node_id"]]["min"]) for each in result["nodes"]})

    def cuboid(self, run, query, answer):
        box, = query["boxes"]
        (x, y, z), (a, b, c) = box["min"], box["max"]
        half = [(high - low) / 2 for low, high in zip(box["min"], box["max"])]
        self.assertGreaterEqual(min(half), max(half) / 4 * (1 - 1e-12))
        self.assertEqual([shape["points"] for shape in run["shapes"][:2]], [[[x, y, z], [a, y, z], [a, y, c], [x, y, c]], [[x, b, z], [a, b, z], [a, b, c], [x, b, c]]])
        self.node_boxes(run, answer, 6)
        # The middle of the box is what the first pixel shows: a point of the scene.
        middle = [(low + high) / 2 for low, high in zip(box["min"], box["max"])]
        near = self.server.ask("/v1/scenes/town/points:closest", "-H", JSON_TYPE, body=json.dumps({"points": [middle], "fields": ["distance"]})).json()
        self.assertLess(near["hits"][0]["distance"], 1e-9)

    def sphere(self, run, query, answer):
        sphere, = query["boxes"]
        for shape in run["shapes"][:3]:
            self.assertEqual((shape["kind"], len(shape["points"])), ("loop", 48))
            for point in shape["points"]:
                self.assertAlmostEqual(math.dist(point, sphere["center"]), sphere["radius"], 9)
        self.node_boxes(run, answer, 3)

    def sight(self, run, query, answer):
        self.line_of_sight(run, query, "good")
        self.assertEqual((answer["visible"], run["outcome"]), ("1", "The two points see each other."))

    def blocked(self, run, query, answer):
        self.line_of_sight(run, query, "bad")
        blocker, = answer["blockers"]
        self.assertEqual((answer["visible"], blocker["node"], run["outcome"]), ("0", "clock tower", "Blocked by clock tower."))
        self.assertIn([blocker["position"]], self.points(run))
        self.assertIn("blocked by clock tower", [shape.get("label") for shape in run["shapes"]])

    def line_of_sight(self, run, query, colour):
        line, = self.points(run, "line")
        self.assertEqual(line, [query["from"][0], query["to"][0]])
        self.assertEqual({shape["colour"] for shape in run["shapes"] if shape["kind"] == "line"}, {colour})

    def why(self, run, query, answer):
        boxes = answer["explain"]["boxes"]
        self.assertEqual(query["explain"], True)
        self.assertEqual(len(run["rows"]), len(boxes) + answer["explain"]["truncated"])
        for number, (row, box) in enumerate(zip(run["rows"], boxes), 1):
            self.assertTrue(row.startswith(f"{number}{'leaf' if box['leaf'] else 'box'} {box['verdict']}"), row)
        # Two loops and four lines for each box in the world, in the colour of its verdict.
        colours = {"entered": "good", "missed": "dim", "behind": "ray", "beyond": "ray", "farther": "normal"}
        def drawn(box):
            (x, y, z), (a, b, c) = box["min"], box["max"]
            return colours[box["verdict"]], ((x, y, z), (a, y, z), (a, y, c), (x, y, c))
        loops = [(shape["colour"], tuple(map(tuple, shape["points"]))) for shape in run["shapes"] if shape["kind"] == "loop"]
        self.assertEqual({box["space"] for box in boxes}, {"world"})
        world = [drawn(box) for box in boxes]
        self.assertEqual(sorted(loops[0:2 * len(world):2]), sorted(world))
        self.assertEqual(run["outcome"], f"Hit: {answer['hits'][0]['node']}, t = {float('%.4g' % answer['hits'][0]['t']):g}. {len(boxes)} boxes visited.")
        # Entered leaves have their number and their t.
        def label(number, box):
            return f"{number}: t {float('%.4g' % box['t_enter']):g} to {float('%.4g' % box['t_exit']):g}" if "t_enter" in box else str(number)
        labels = {shape["label"] for shape in run["shapes"] if shape.get("label")}
        self.assertEqual(labels - {answer["hits"][0]["node"]},
                         {label(number, box) for number, box in enumerate(boxes, 1) if box["leaf"] and box["verdict"] == "entered"})
        # The slider shows the first boxes of the visit; the last of them stands out here and in the list.
        self.assertEqual(len(run["visit"]), 9)
        for count, step in enumerate(run["visit"], 1):
            self.assertEqual((step["now"], step["row"]), (f"{count} of {len(boxes)}", [run["rows"][count - 1]]))
            loops = [(shape["colour"], tuple(map(tuple, shape["points"]))) for shape in step["shapes"] if shape["kind"] == "loop"]
            self.assertEqual(sorted(loops[0:2 * count:2]), sorted(map(drawn, boxes[:count])))
            self.assertIn(label(count, boxes[count - 1]), [shape.get("label") for shape in step["shapes"]])

    def scan(self, run, query, answer):
        hits = [i for i, distance in enumerate(answer["distance"]) if distance is not None]
        self.assertEqual(int(run["points"]), len(hits))
        self.assertGreater(len(hits), 1000)
        head, _, rows = run["ply"].partition("end_header\n")
        self.assertIn(f"element vertex {len(hits)}\n", head)
        self.assertEqual([tuple(map(float, row.split())) for row in rows.splitlines()],
                         [(*answer["position"][3 * i:3 * i + 3], answer["distance"][i], answer["node_id"][i]) for i in hits])
        self.assertEqual(self.points(run), [[query["generator"]["position"]]])
        # One hue for each node; by distance the nearest is red and the farthest blue.
        nodes, distances = [answer["node_id"][i] for i in hits], [answer["distance"][i] for i in hits]
        self.assertEqual(len(set(run["byNode"])), len(set(nodes)))
        self.assertEqual(len(set(zip(run["byNode"], nodes))), len(set(nodes)))
        for hue, distance in zip(run["byDistance"], distances):
            self.assertAlmostEqual(hue, 0.66 * math.sqrt(distance / max(distances)), 12)

    def clearance(self, run, query, answer):
        pair = answer["pair"]
        distance, ends = re.fullmatch(r"Clearance (\S+) between (.*)\.", run["outcome"]).groups()
        self.assertEqual((float(distance), ends), (pair["distance"], f"{pair['a']['node']} and {pair['b']['node']}"))
        self.assertEqual(self.points(run, "line"), [[pair["a"]["position"], pair["b"]["position"]]])
        self.assertEqual(self.points(run), [[pair["a"]["position"]], [pair["b"]["position"]]])
        self.assertNotEqual(query["a"], query["b"])

    def viewshed(self, run, query, answer):
        self.assertGreater(len(query["to"]), 300)
        self.assertEqual(run["seen"], answer["visible"][0])
        self.assertEqual({"0", "1"}, set(run["seen"]))
        self.assertEqual(run["outcome"], f"{run['seen'].count('1')} of {len(query['to'])} points are seen.")
        self.assertEqual(self.points(run), [query["from"]])

    def section(self, run, query, answer):
        (*normal, d), other = query["boxes"][0]["planes"]
        self.assertEqual(other, [-x for x in (*normal, d)])
        result, = answer["results"]
        self.assertEqual(run["outcome"], f"The plane cuts {result['total']} triangles.")
        ids = [f"{each['instance']}.{each['primitive']}.{each['triangle']}" for each in result["triangles"]]
        cut, axis = 0, [abs(x) for x in normal].index(1)
        for begin in range(0, len(ids), 300):
            for each in self.server.ask(f"/v1/scenes/town/triangles?ids={','.join(ids[begin:begin + 300])}").json()["triangles"]:
                sides = [corner[axis] * normal[axis] - d for corner in each["corners"]]
                cut += min(sides) < 0 < max(sides)
        lines = self.points(run, "line")
        # Lines through a corner or along an edge come on top.
        self.assertGreaterEqual(len(lines), cut)
        self.assertGreater(cut, 50)
        for line in lines:
            for point in line:
                self.assertAlmostEqual(point[axis] * normal[axis], d, 9)

    def levels(self, run, query, answer):
        boxes = answer["level"]["boxes"]
        self.assertEqual(query, {"level": 2})
        self.assertGreater(len(boxes), 8)
        self.assertEqual(run["outcome"], f"Level 2: {len(boxes)} boxes, {sum(box['leaf'] for box in boxes)} of them leaves.")
        lowest = [(shape["colour"], shape["points"][0]) for shape in run["shapes"] if shape["kind"] == "loop"][::2]
        self.assertEqual(lowest, [("good" if box["leaf"] else "normal", box["min"]) for box in boxes[:300]][:len(lowest)])
        self.assertGreater(len(lowest), 8)

    def heat(self, run, query, body):
        self.assertEqual(query["image"], "visits")
        head, size, _, floats = body.split(b"\n", 3)
        width, height = map(int, size.split())
        visits = struct.unpack(f"<{width * height}f", floats)
        self.assertEqual((head, width, height), (b"Pf", run["heat"]["width"], run["heat"]["height"]))
        most = max(visits)
        shade = {count: [math.floor(255 * min(1, max(0, 1.5 - abs(4 * count / most - top))) + 0.5) for top in (3, 2, 1)] for count in set(visits)}
        rows = [visits[begin:begin + width] for begin in range(0, len(visits), width)][::-1]
        self.assertEqual(run["heat"]["colours"], [shade[count] for row in rows for count in row])
        self.assertIn(f"{int(min(visits))} to {int(most)} boxes", run["outcome"])

    def ray(self, run, query, answer):
        told = dict(run["cost"])
        work = self.server.query("town", "closest", {**query, "work": True}).json()["work"]
        for name in ("nodes", "blocks", "placements", "exact"):
            self.assertEqual(int(told[name]), work[name])
        self.assertEqual(int(told["trees built"]), 0)
        trees = self.server.ask("/v1/scenes/town/stats").json()["trees"]
        self.assertEqual(told["trees built before"], f"{trees['meshes_built']} of {trees['meshes_total']} meshes")
        self.assertEqual(told["skipped in the file"], "nothing")

    def test_fingers_tap_turn_and_pinch(self):
        run = browse(self.server.url, "touch")
        self.assertEqual((run["complaints"], run["foreign"], run["overflow"]), ([], [], []))
        hit, = self.same_as_curl(run)["hits"]
        self.assertIn(hit["node"], run["outcome"])
        self.assertIn(hit["position"], [points[0] for points in self.points(run)])
        first, turned, pinched = run["cameras"]
        away = [math.dist(camera[:3], camera[3:]) for camera in run["cameras"]]
        # One finger turns around the target, two that part come nearer.
        self.assertEqual(turned[3:], first[3:])
        self.assertGreater(math.dist(turned[:3], first[:3]), away[0] / 20)
        self.assertAlmostEqual(away[1], away[0], 9)
        self.assertLess(away[2], away[1] * 0.9)
        self.assertEqual((run["after"]["raw"], run["after"]["body"]), (run["raw"], run["body"]))

    def test_the_keyboard_does_it_too_and_requests_can_be_copied(self):
        run = browse(self.server.url, "keyboard")
        # The browser itself notes a request that is refused: the last one is.
        self.assertEqual(([each for each in run["complaints"] if "422" not in each], run["foreign"]), ([], []))
        self.assertEqual(len(set(run["links"])), 5)
        self.assertIsNotNone(self.same_as_curl(run["ray"])["hits"][0])
        self.assertEqual(run["mode"], "box")
        self.assertEqual(self.same_as_curl(run["typed"]), {"counts": [32]})
        self.assertEqual(run["typed"]["outcome"], "Count: 32.")
        self.assertTrue(run["fault"]["outcome"].startswith("LENGTH_WRONG"), run["fault"]["outcome"])
        self.assertIn("/rays/0/origin", run["fault"]["outcome"])
        copies = run["copies"]
        for command in (["sh", "-c", copies["curl"]], ["python3", "-c", copies["python"]], [NODE, "--input-type=module", "-e", copies["javascript"]]):
            done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=True)
            self.assertEqual(re.sub(r"[\s'\"]", "", done.stdout), "{counts:[32]}")

        self.assertEqual(run["copied"][0], run["copied"][1])
        self.assertIn("#scene=town&", run["copied"][0])
        self.assertEqual([name for name, _ in run["themes"]], ["Theme: light", "Theme: dark", "Theme: system"])
        # The browser's own theme is light.
        self.assertEqual([colour for _, colour in run["themes"]], ["rgb(255, 255, 255)", "rgb(21, 25, 30)", "rgb(255, 255, 255)"])

    def test_every_tool_is_chosen_and_used_with_keys(self):
        runs = browse(self.server.url, "keys")
        self.assertEqual([run["mode"] for run in runs], ["ray", "measure", "box", "sight", "why", "scan", "clearance", "viewshed", "section",
                                                         "cuboid", "sphere", "heat", "levels"])
        for run in runs:
            with self.subTest(tool=run["mode"]):
                self.assertEqual((run["complaints"], run["foreign"], run["notice"]), ([], [], ""))
                self.assertIsNotNone(self.same_as_curl(run))
                if run["mode"] != "heat":
                    self.assertGreater(len(run["shapes"]), 0)
                self.assertRegex(run["cross"], r"^[\d.]+,[\d.]+$")
        outcome = {run["mode"]: run["outcome"] for run in runs}
        self.assertGreater(float(outcome["measure"].split()[1]), 1)
        self.assertGreater(int(outcome["box"].split()[0]), 1)
        self.assertGreater(int(outcome["sphere"].split()[0]), 0)

    def test_a_link_gives_the_same_bytes_and_tells_of_a_change(self):
        with Server("--preload", "town=demo:town", "--preload", "six=demo:six", memory=None) as server:
            fragment = urlencode({"scene": "six", "rev": server.ask("/v1/scenes/six").json()["revision"], "sha": "c09215983e14ec1b",
                                  "camera": "10,20,30,1,2,-0.5", "mode": "sight", "route": "rays:closest",
                                  "body": '{"rays":[{"origin":[3,10,0],"direction":[0,-1,0]}],"fields":["t","node"]}'})
            first = browse(server.url, "link", f"{server.url}/#{fragment}")
            self.assertEqual((first["complaints"], first["notice"], first["mode"]), ([], "", "sight"))
            self.assertEqual(first["raw"], '{"hits":[{"t":8,"node":"right"}]}')
            # The page writes the link that it was opened with, whatever the order.
            again = browse(server.url, "link", first["link"])
            self.assertEqual((again["raw"], again["body"], again["link"]), (first["raw"], first["body"], first["link"]))
            self.assertEqual(parse_qs(first["link"].split("#")[1])["camera"], ["10,20,30,1,2,-0.5"])
            patched = server.ask("/v1/scenes/six/nodes/2", "-X", "PATCH", "-H", JSON_TYPE, body='{"translation":[0,3,0]}')
            self.assertEqual(patched.status, 200)
            moved = browse(server.url, "link", first["link"])
            self.assertIn(f"revision {patched.json()['revision']}", moved["notice"])
            self.assertEqual(moved["raw"], '{"hits":[{"t":5,"node":"right"}]}')
            server.put("six", demo_glb("painted"))
            self.assertIn("another content", browse(server.url, "link", first["link"])["notice"])

    def test_links_give_the_same_bytes_with_every_kernel_after_a_restart_and_on_a_second_server(self):
        # SIGHTLINE_LINKS=1000 replays as many.
        count, seeded = int(os.environ.get("SIGHTLINE_LINKS", "24")), random.Random(22)
        with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as servers:
            def server(data, *flags):
                made = Server("--data", Path(folder, data), *flags, memory=None)
                servers.callback(made.end)
                return made
            scenes = {"town": demo_glb("town"), "six": demo_glb("six"), "painted": demo_glb("painted")}
            first = server("first")
            stored = {name: first.put(name, glb).json() for name, glb in scenes.items()}
            links = [self.made_link(seeded, stored[seeded.choice(sorted(stored))]) for _ in range(count)]
            # One scene after the other: it is loaded once.
            links.sort(key=lambda link: parse_qs(link)["scene"])
            file = Path(folder, "links")
            file.write_text(json.dumps(links), encoding="utf-8")
            wanted = self.replay(first, file)
            kernels = first.ask("/version").json()["kernels"]
            first.stop()
            for data, flags in (("first", ()), *(("first", ("--kernel", kernel)) for kernel in kernels), ("second", ("--skip", "none"))):
                again = server(data, *flags)
                if data == "second":
                    for name, glb in scenes.items():
                        self.assertEqual(again.put(name, glb).json()["revision"], stored[name]["revision"])
                differ = sum(a != b for one, other in zip(wanted, self.replay(again, file)) for a, b in zip(one.ljust(len(other)), other.ljust(len(one))))
                self.assertEqual(differ, 0, (data, flags))
                again.stop()
            print(f"{count} links, {sum(map(len, wanted))} bytes of answers; again after a restart, with {', '.join(kernels)}, on a second server: 0 bytes differ")

    def made_link(self, seeded, scene):
        low, high = scene["bounds"]["min"], scene["bounds"]["max"]
        point = lambda: [seeded.uniform(a, b) for a, b in zip(low, high)]
        away = lambda: [seeded.gauss(0, 1) for _ in range(3)]
        fields = ["t", "position", "normal", "node", "triangle", "on_edge"]
        route, query = seeded.choice([
            ("rays:closest", {"rays": [{"origin": point(), "direction": away()} for _ in range(20)], "fields": fields}),
            ("rays:closest", {"rays": [{"origin": point(), "direction": away()}], "fields": fields}),
            ("rays:all", {"rays": [{"origin": point(), "direction": away()}], "max_hits": 20, "fields": fields}),
            ("visibility", {"from": [point()], "to": [point() for _ in range(20)]}),
            ("points:closest", {"points": [point()], "fields": ["distance", "position", "node"]}),
            ("boxes:count", {"boxes": [{"center": point(), "radius": seeded.uniform(0, 20)}]})])
        return urlencode({"scene": scene["id"], "rev": scene["revision"], "sha": scene["sha256"][:16],
                          "camera": ",".join(map(str, point() + point())), "mode": "ray", "route": route, "body": json.dumps(query)})

    def replay(self, server, file):
        run = browse(server.url, "links", str(file))
        self.assertEqual((run["complaints"], run["foreign"], {notice for _, notice in run["answers"]}), ([], [], {""}))
        return [answer for answer, _ in run["answers"]]

    def test_traced_pictures_show_what_rays_hit(self):
        for run in browse(self.server.url, "traced", f"{self.server.url}/#scene=town&traced=1&camera=60,45,80,0,30,0"):
            with self.subTest(size=run["size"]):
                self.assertEqual((run["complaints"], run["foreign"], run["overflow"]), ([], [], []))
                self.assertIsNotNone(self.same_as_curl(run)["hits"][0])
                grid = run["grid"]
                pinhole = {"kind": "pinhole", "position": [60, 45, 80], "look_at": [0, 30, 0], "fov_y": 45, "width": grid["width"], "height": grid["height"]}
                answer = self.server.query("town", "any", {"generator": pinhole}).json()["hits"]
                different = [(x, y) for x, y, alpha in grid["points"] if answer[y * grid["width"] + x] != (alpha == 255)]
                # The camera of the page has been through three.js: a ray at the rim of a hit may differ.
                self.assertLess(len(different), 3)
                self.assertEqual({alpha for _, _, alpha in grid["points"]}, {0, 255})
                print(run["size"], "first traced picture after", run["first"], "ms")

    def test_traced_pictures_stand_in_for_triangles_that_are_coming(self):
        run = browse(self.server.url, "coming")
        self.assertEqual((run["complaints"], run["foreign"], run["overflow"]), ([], [], []))
        self.assertIsNotNone(self.same_as_curl(run)["hits"][0])
        self.assertEqual((run["finest"], run["progress"], run["still"]), ("360", "Loading triangles", 0))
        self.assertNotIn("traced=1", run["link"])

    def test_a_scene_far_from_the_origin_looks_as_it_does_at_the_origin(self):
        # A power of two: the world's float64 numbers are then moved without rounding.
        far = 2.0 ** 24
        def move(document):
            document["nodes"][0]["translation"] = [far, far, far]
        moved = with_document(demo_glb("six"), move)
        with Server("--preload", "six=demo:six", memory=None) as server:
            self.assertEqual(server.put("far", moved).status, 201)
            links = []
            for scene, offset in (("six", 0), ("far", far)):
                camera = [at + offset for at in (9.25, 6.5, 12.75, 0.5, 2.25, -0.5)]
                links.append(f"{server.url}/#scene={scene}&camera={','.join(map(str, camera))}")
            near, away = browse(server.url, "pictures", *links)
            self.assertEqual((near["complaints"], away["complaints"]), ([], []))
            self.assertEqual(near["picture"], away["picture"])

    def test_boxes_of_a_mesh_that_is_placed_often_are_drawn_where_they_stand(self):
        turn = [[0.28, 0, 1.92], [0, 0.5, 0], [-0.96, 0, 0.56]]

        def place(document):
            for i, node in enumerate(document["nodes"]):
                del node["translation"]
                node["matrix"] = [*(row[0] for row in turn), 0, *(row[1] for row in turn), 0, *(row[2] for row in turn), 0, 25 * i, 0, 3, 1]
        query = {"rays": [{"origin": [30, 40, 0], "direction": [0.02, -1, 0.03]}], "fields": ["t", "node"], "explain": True}
        with Server(memory=None) as server:
            self.assertEqual(server.put("turned", with_document(tiles(224, 300), place)).status, 201)
            words = {"scene": "turned", "camera": "60,60,60,60,0,0", "mode": "why", "route": "rays:closest", "body": json.dumps(query)}
            # What a ray visits is another tree before all trees are built.
            end = time.monotonic() + PATIENCE
            while not server.ask("/v1/scenes/turned/stats").json()["trees"]["complete"]:
                self.assertLess(time.monotonic(), end)
                time.sleep(0.05)
            run = browse(server.url, "link", f"{server.url}/#{urlencode(words)}")
            answer = server.query("turned", "closest", query)
            self.assertEqual(answer.body.decode(), run["raw"])
            answer = answer.json()
        self.assertEqual((run["complaints"], run["foreign"]), ([], []))
        boxes = [box for box in answer["explain"]["boxes"] if box["space"] == "mesh"]
        self.assertGreater(len(boxes), 5)
        drawn = [shape["points"] for shape in run["shapes"] if shape["kind"] == "loop"]
        self.assertEqual(len(drawn), 2 * len(answer["explain"]["boxes"]))
        for box in boxes:
            def stands(x, y, z, instance=box["instance"]):
                return [sum(turn[i][k] * p for k, p in enumerate((x, y, z))) + (25 * instance, 0, 3)[i] for i in range(3)]
            (x, y, z), (a, b, c) = box["min"], box["max"]
            for loop in ([(x, y, z), (a, y, z), (a, y, c), (x, y, c)], [(x, b, z), (a, b, z), (a, b, c), (x, b, c)]):
                expected = [stands(*corner) for corner in loop]
                apart = min(max(abs(p - q) for one, other in zip(points, expected) for p, q in zip(one, other)) for points in drawn)
                self.assertLess(apart, 1e-12)

    def test_a_scene_of_a_hundred_million_triangles_is_traced_and_picked(self):
        with Server(memory=None) as server:
            put = server.put("tiles", tiles(224, 1000))
            self.assertEqual((put.status, put.json()["counts"]["triangles"]), (201, 100352000), put.body[:300])
            run, = browse(server.url, "pictures", f"{server.url}/#scene=tiles")
            self.assertEqual((run["complaints"], run["foreign"]), ([], []))
            answer = server.ask(run["path"], "-H", JSON_TYPE, body=run["body"])
            self.assertEqual(answer.body.decode(), run["raw"])
            self.assertTrue(answer.json()["hits"][0]["node"].startswith("tile "))
            print("100,352,000 triangles: finest picture after", run["drawn"] + run["traced"], "ms")

    def test_nodes_are_searched_where_the_page_has_not_all_of_them(self):
        count = 20010
        nodes = [{"mesh": 0, "name": f"part {i}", "translation": [2 * (i % 200), 0, 2 * (i // 200)]} for i in range(count)]
        with Server(memory=None) as server:
            self.assertEqual(server.put("parts", triangle_glb(nodes)).status, 201)
            run = browse(server.url, "nodes", f"{server.url}/#scene=parts", "20009", "nothing has this")
        self.assertEqual((run["complaints"], run["foreign"]), ([], []))
        first, last, none = run["found"]
        self.assertEqual((len(first), first[-1]), (301, "19,710 more: search for a name."))
        self.assertEqual([re.split(r"\s*\n\s*", text) for text in last], [["part 20009", "1 triangle"]])
        self.assertEqual(none, ["No node has such a name."])

    def test_scenes_are_put_searched_and_deleted(self):
        with tempfile.TemporaryDirectory() as folder:
            file, large = Path(folder, "my house.glb"), Path(folder, "dropped.glb")
            file.write_bytes(demo_glb("six"))
            # So many bytes that the browser tells more than once how far it is.
            large.write_bytes(padded(demo_glb("six"), 144 << 20))
            run = browse(self.server.url, "scenes", str(file), str(large))
            sent = large.stat().st_size
        self.assertEqual((run["complaints"], run["foreign"]), ([], []))
        self.assertIn("my-house", run["put"]["scenes"])
        for name, about in zip(run["put"]["scenes"], run["put"]["about"]):
            trees = self.server.ask(f"/v1/scenes/{name}/stats").json()["trees"] if name != "my-house" else {}
            self.assertRegex(about, r"^[\d,]+ triangles,\nfile \d[\d.]* k?B, memory \d[\d.]* [kM]?B$")
            if name == "six":
                self.assertIn(f"memory {round((trees['tree_bytes'] + trees['geometry_bytes']))} B", about)
        dropped = run["dropped"]
        self.assertIn("dropped", dropped["scenes"])
        self.assertTrue(dropped["over"])
        self.assertEqual(dropped["still"], 0)
        told = [int(match[1]) for match in (re.fullmatch(r"dropped\.glb: (\d+)% of .* MB", text) for text in dropped["said"]) if match]
        self.assertEqual((told, told[-1]), (sorted(told), 100))
        self.assertGreater(len(set(told)), 2)
        scene = self.server.ask("/v1/scenes/dropped").json()
        self.assertEqual((scene["bytes"], scene["counts"]["triangles"]), (sent, 6))
        self.assertEqual(run["nodes"], ["right3 triangles"])
        self.assertIn("right: 3 triangles", [shape.get("label") for shape in run["node"]["shapes"]])
        self.assertNotIn("my-house", run["gone"]["scenes"])
        self.assertEqual(self.server.ask("/v1/scenes/my-house").status, 404)

    def test_troubles_are_told_in_a_narrow_window(self):
        name = "\u5bb6 \U0001f3e0 " + "long" * 40
        def rename(document):
            document["nodes"][1]["name"] = name
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "\u5bb6.glb")
            file.write_bytes(with_document(demo_glb("six"), rename))
            with Server(memory=None) as server:
                run = browse(server.url, "troubles", str(file), "scene-1", "\u5bb6")
        # The browser itself notes what is refused and what does not arrive.
        self.assertEqual(([each for each in run["complaints"] if "Failed to load resource" not in each], run["foreign"]), ([], []))
        for step in ("none", "put", "gone"):
            self.assertEqual(run[step]["overflow"], [], step)
        self.assertEqual((run["none"]["scenes"], run["put"]["scenes"], run["gone"]["scenes"]), ([], ["scene-1"], []))
        self.assertEqual((run["put"]["nodes"], run["put"]["progress"]), ([name], ""))
        self.assertEqual((run["gone"]["path"], run["gone"]["shapes"], run["gone"]["rows"]), ("/v1/scenes/rays:closest", [], []))

    def test_the_lecture_page_answers_all_cases_and_shows_each_formula_failing(self):
        file = DATA / "ray_box_golden.json"
        if not file.is_file():
            self.skipTest(f"{file} is not there")
        golden = {case["name"]: case for case in json.loads(file.read_text(encoding="utf-8"))}
        for run in lecture(self.server.url):
            with self.subTest(size=run["size"], theme=run["theme"]):
                self.assertEqual((run["complaints"], run["foreign"], run["overflow"], run["barriers"]), ([], [], [], []))
                self.assertEqual([name for name in golden if name not in run["cases"]], [])
                for name, seen in run["cases"].items():
                    answer = self.server.ask("/v1/rays-boxes", "-H", JSON_TYPE, body=seen["body"])
                    self.assertEqual(answer.body.decode(), seen["raw"])
                    result, = answer.json()["results"]
                    if name in golden:
                        self.assertEqual((result["hit"], result.get("t")), (golden[name]["hit"], golden[name]["t"]), name)
                        asked = json.loads(seen["body"], parse_int=float)
                        # -0 is no 0.
                        self.assertEqual([str(float(x)) for x in asked["rays"][0]["direction"]], [str(float(x)) for x in golden[name]["direction"]])
                    self.assertEqual(seen["verdict"].startswith("Miss"), not result["hit"], seen["verdict"])
                    # The first formula is right in all cases of the texts.
                    self.assertFalse(seen["formulas"][0][2], name)
                    for formula, said, wrong in seen["formulas"]:
                        if not wrong:
                            self.assertEqual(said == "miss", not result["hit"], (name, formula))
                self.assertEqual([run["cases"][f"Figure {i}: {what}"]["verdict"][:4] for i, what in ((1, "misses"), (2, "hits"), (3, "misses"))],
                                 ["Miss", "Hit:", "Miss"])
                self.assertIn("leaves slab y before it enters slab x", run["cases"]["Figure 1: misses"]["verdict"])
                self.assertIn("leaves slab x before it enters slab y", run["cases"]["Figure 3: misses"]["verdict"])
                for i, seen in enumerate(run["fails"]):
                    self.assertTrue(seen["formulas"][i][2], seen["formulas"][i])
                self.assertEqual(len(run["fails"]), 12)
                self.judge_drags(run["dragged"])

    def judge_drags(self, dragged):
        """What a drag of each handle, and a number that is typed, change in the request."""
        def parts(step):
            query = json.loads(step["body"])
            return {**query["rays"][0], **query["boxes"][0]}
        oblique = {"origin": [-10, 0, 0], "direction": [1, 0.015625, 0.015625], "min": [-2, -3, -4], "max": [4, 3, 2]}
        flat = {"origin": [0, 0.5, 0], "direction": [1, 1, 0], "min": [1, 1, None], "max": [3, 3, None]}
        before, moved = flat, {"flat": ("origin", {0, 1}), "#xy .min": ("min", {0, 1}), "#xz .max": ("max", {0, 2}),
                               "#xz .tip": ("direction", {0, 2}), "#xz .origin": ("origin", {0, 2}), "typed": ("origin", {1})}
        self.assertEqual(list(dragged), list(moved))
        for handle, (name, axes) in moved.items():
            with self.subTest(handle=handle):
                step = dragged[handle]
                now = parts(step)
                self.assertEqual({(part, k) for part, numbers in before.items() for k, number in enumerate(numbers) if now[part][k] != number},
                                 {(name, k) for k in axes})
                answer = self.server.ask("/v1/rays-boxes", "-H", JSON_TYPE, body=step["body"])
                self.assertEqual(answer.body.decode(), step["raw"])
                self.assertEqual(step["verdict"].startswith("Miss"), not answer.json()["results"][0]["hit"])
                before = oblique if handle == "flat" else now
        self.assertEqual(parts(dragged["typed"])["origin"][1], 2.5)

    def test_the_lecture_page_shows_four_different_visits_of_a_tree_step_by_step(self):
        wanted = {"both": ["entered", "entered", "entered"], "left": ["entered", "missed", "entered"], "right": ["entered", "missed", "entered"],
                  "none": ["entered", "missed", "missed"]}
        sides = {"The root": None, "The left subtree": "left", "The right subtree": "right"}
        for run in lecture(self.server.url):
            entered = {}
            for name, visit in run["visits"].items():
                answer = self.server.ask("/v1/scenes/six/rays:closest", "-H", JSON_TYPE, body=visit["body"])
                self.assertEqual(answer.body.decode(), visit["raw"])
                boxes, (hit,) = answer.json()["explain"]["boxes"], answer.json()["hits"]
                self.assertEqual([box["verdict"] for box in boxes], wanted[name])
                self.assertEqual(len(visit["steps"]), len(boxes))
                for number, step in enumerate(visit["steps"], 1):
                    self.assertEqual([box.split()[1] == "in" for box in step["boxes"]], [box["verdict"] == "entered" for box in boxes[:number]])
                    self.assertEqual(len(step["words"]), number)
                last = visit["steps"][-1]
                self.assertEqual(last["end"], f"The hit is on {hit['node']}, at t = {hit['t']:.17g}." if hit else "No triangle is hit.")
                entered[name] = frozenset(sides[words.split(" is ")[0]] for words in last["words"] if " entered " in words)
            self.assertEqual(entered, {"both": {None, "left", "right"}, "left": {None, "left"}, "right": {None, "right"}, "none": {None}})

    def test_the_status_page_shows_the_metrics(self):
        body = '{"rays":[{"origin":[3,10,0],"direction":[0,-1,0]}]}'
        runs = browse(self.server.url, "status", "/v1/scenes/six/rays:closest", body)
        self.assertEqual(len(runs), 1 if views == "one" else 4)
        for run in runs:
            with self.subTest(size=run["size"], theme=run["theme"]):
                self.assertEqual((run["complaints"], run["foreign"], run["overflow"], run["barriers"]), ([], [], [], []))
                listed = {scene["id"]: scene for scene in self.server.ask("/v1/scenes").json()["scenes"]}
                self.assertEqual({row[0]: (row[1], int(row[2].replace(",", "")), int(row[4])) for row in run["scenes"]},
                                 {name: (scene["state"], scene["triangles"], scene["revision"]) for name, scene in listed.items()})
                charts, routes = dict(run["charts"]), {row[0]: row[1:] for row in run["routes"]}
                # Each run has asked 20 times more; the counters are those of the server.
                asked = sum(map(int, re.findall(r'sightline_requests_total{method="POST",route="/v1/scenes/{id}/rays:closest",.*} (\d+)',
                                                self.server.ask("/metrics").body.decode())))
                self.assertLessEqual(20, int(routes["/v1/scenes/{id}/rays:closest"][0].replace(",", "")))
                self.assertLessEqual(int(routes["/v1/scenes/{id}/rays:closest"][0].replace(",", "")), asked)
                self.assertGreaterEqual(int(charts["Connections"]), 1)
                self.assertRegex(charts["Memory of triangles"], r"^\d")
                self.assertRegex(charts["Median time"], r"^(\d[\d.]* (µs|ms|s)|none)$")

    def test_documents_are_shown_and_searched(self):
        paths = ("README.md", "lectures.md", "guides/clearance.md", "guides/page.md")
        for run in browse(self.server.url, "guide", *paths):
            with self.subTest(size=run["size"], theme=run["theme"]):
                self.assertEqual((run["complaints"], run["foreign"], run["overflow"], run["barriers"]), ([], [], [], []))
                for path, page in run["pages"].items():
                    text = (SOURCE / ("" if path == "README.md" else "docs") / path).read_text(encoding="utf-8")
                    title = re.search(r"^# (.*)$", text, re.MULTILINE)[1]
                    self.assertEqual(page["title"], f"{title} - Sightline")
                    # Every line of code, every heading and every cell of a table is there.
                    for line in re.findall(r"^    (\S.*)$|^##+ (.*)$", text, re.MULTILINE):
                        self.assertIn(re.sub(r"[`\s]", "", "".join(line)), re.sub(r"[`\s]", "", page["text"]))
                    for link in page["links"]:
                        if link.startswith(self.server.url):
                            self.assertEqual(self.server.ask(link.removeprefix(self.server.url).split("#")[0]).status, 200, link)
                self.assertEqual(run["found"][0], f"{self.server.url}/docs/guides/page.md#tools")
                self.assertEqual(run["arrived"], run["found"][0])
                # Its wide tables scroll in themselves.
                self.assertEqual((run["api"]["wider"], run["api"]["barriers"]), (0, []))
                self.assertIn("Sightline", run["api"]["title"])

    def test_a_key_is_asked_for_and_shown_nowhere(self):
        key, line = make_key("read", "people")
        with tempfile.TemporaryDirectory() as folder:
            with Server("--preload", "six=demo:six", "--keys", write_keys(Path(folder, "keys"), line)) as server:
                run = browse(server.url, "key", key)
                answer = server.ask(run["path"], "-H", JSON_TYPE, *bearer(key), body=run["body"])
                self.assertEqual(run["raw"], answer.body.decode())
                for place in ("html", "link", "body"):
                    self.assertNotIn(key, run[place])


if __name__ == "__main__":
    case_report.main()
