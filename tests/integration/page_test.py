"""/: what its parts say in their headers, and what a browser does with it.

The browser part needs chromium and the packages that CMake installs for the page; it says SKIPPED without them.
"""

import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import case_report
from sightline_server import BINARY, JSON_TYPE, PATIENCE, SOURCE, Server, bearer, curl, make_key, write_keys

PARTS = {"/": "text/html", "/page.js": "text/javascript", "/page.css": "text/css"}
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
MODULES = Path(BINARY).resolve().parent / "page/node_modules"
NODE = shutil.which("node")
# Pictures for people stay where this says.
PICTURES = os.environ.get("SIGHTLINE_PICTURES")
MISSING = ("no chromium is installed" if BROWSER is None else "no node is installed" if NODE is None else
           "the page was built without its packages" if not (MODULES / "playwright-core").is_dir() else "")


def browse(url, *words, **more):
    """What tests/integration/page_browser.mjs saw."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([NODE, SOURCE / "tests/integration/page_browser.mjs", MODULES, BROWSER, url, PICTURES or folder, *words],
                              capture_output=True, text=True, timeout=PATIENCE * 4, check=False, **more)
    if done.returncode != 0:
        raise AssertionError(done.stderr[-3000:])
    return json.loads(done.stdout)


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
        page = self.server.ask("/").body.decode("ascii")
        self.assertEqual(re.findall(r'<(?:script|style)\b(?![^>]*\bsrc=)|\son\w+=|\sstyle=|javascript:|https?://', page), [])

    def test_texts_are_compressed(self):
        whole = self.server.ask("/page.js").body
        if len(whole) < 10000:
            self.skipTest("the page was not built")
        for coding in ("gzip", "zstd"):
            packed = self.server.ask("/page.js", "-H", f"Accept-Encoding: {coding}")
            self.assertEqual(packed.headers["content-encoding"], coding)
            self.assertLess(len(packed.body), len(whole) / 2.5)
        print("bytes of the page:", {path: len(self.server.ask(path).body) for path in PARTS})

    def test_the_page_is_open_and_what_it_shows_is_not(self):
        _, line = make_key("read", "people")
        with tempfile.TemporaryDirectory() as folder:
            with Server("--preload", "six=demo:six", "--keys", write_keys(Path(folder, "keys"), line)) as server:
                for path in PARTS:
                    self.assertEqual(server.ask(path).status, 200)
                self.assertEqual(server.ask("/v1/scenes/six/geometry").status, 401)

    @unittest.skipIf(MISSING, MISSING)
    def test_the_bundle_is_the_same_bytes_each_time(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([NODE, MODULES / "esbuild/bin/esbuild", "src/page.js", "src/page.css", f"--outdir={folder}", "--bundle", "--minify",
                            "--format=iife", "--target=es2022", "--charset=ascii", "--legal-comments=eof", "--log-level=warning"],
                           cwd=SOURCE / "server/page/app", env={**os.environ, "NODE_PATH": str(MODULES)}, check=True, timeout=PATIENCE)
            for name in ("page.js", "page.css"):
                self.assertEqual(Path(folder, name).read_bytes(), self.server.ask(f"/{name}").body)


@unittest.skipIf(MISSING, MISSING)
class PageInBrowser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "town=demo:town", "--preload", "six=demo:six", memory=None)
        cls.addClassCleanup(cls.server.end)

    def same_as_curl(self, seen):
        """The answer that the page shows is the one that curl gets for the request that it shows."""
        answer = self.server.ask(seen["path"], "-H", JSON_TYPE, body=seen["body"])
        self.assertEqual(answer.body.decode(), seen["raw"])
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
                self.assertEqual(run["overflow"], [])
                print(run["size"], run["theme"], "first paint", run["paint"], "ms, drawn after", run["drawn"], "ms")


if __name__ == "__main__":
    case_report.main()
