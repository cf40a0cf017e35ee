"""/docs: what its parts say in their headers, who may have them, and what a browser makes of them."""

import html
import json
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

import case_report
from headless_browser import BROWSER, FLAGS, MISSING
from openapi_test import DOCUMENT, operations
from sightline_server import PATIENCE, SOURCE, Server, bearer, make_key, write_keys

PARTS = {"/docs": ("text/html", "page.html"), "/docs/app.js": ("text/javascript", "app.js"), "/docs/style.css": ("text/css", "style.css")}


def policy(answer):
    """Directive -> sources."""
    return {words[0]: words[1:] for words in map(str.split, answer.headers["content-security-policy"].split(";"))}


def rendered(url):
    """The page's markup after its script ran."""
    with tempfile.TemporaryDirectory() as profile:
        done = subprocess.run([BROWSER, *FLAGS, f"--user-data-dir={profile}",
                               "--virtual-time-budget=20000", "--enable-logging=stderr", "--dump-dom", url],
                              capture_output=True, text=True, timeout=PATIENCE, check=True)
    # The console: what the policy forbids, and what a script did not catch.
    complaints = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    return done.stdout, complaints


def plain(markup):
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", markup)).split())


class DocsPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six")
        cls.addClassCleanup(cls.server.end)

    def test_its_parts_are_the_files_of_the_source(self):
        for path, (kind, file) in PARTS.items():
            with self.subTest(path=path):
                answer = self.server.ask(path)
                self.assertEqual((answer.status, answer.headers["content-type"]), (200, f"{kind}; charset=utf-8"))
                self.assertEqual(answer.body, (SOURCE / "server/page/docs" / file).read_bytes())
                self.assertEqual((answer.headers["cache-control"], answer.headers["x-content-type-options"]), ("no-cache", "nosniff"))

    def test_the_page_may_run_its_own_script_and_ask_this_server_only(self):
        told = policy(self.server.ask("/docs"))
        self.assertEqual(told, {"default-src": ["'none'"], "script-src": ["'self'"], "style-src": ["'self'"], "connect-src": ["'self'"],
                                "base-uri": ["'none'"], "form-action": ["'none'"], "frame-ancestors": ["'none'"],
                                "require-trusted-types-for": ["'script'"]})
        for path in ("/docs/app.js", "/docs/style.css", "/openapi.json"):
            self.assertEqual(policy(self.server.ask(path)), {"default-src": ["'none'"], "frame-ancestors": ["'none'"]})

    def test_nothing_is_inline_and_nothing_comes_from_elsewhere(self):
        page = self.server.ask("/docs").body.decode("ascii")
        self.assertEqual(re.findall(r'<(?:script|style)\b(?![^>]*\bsrc=)|\son\w+=|\sstyle=|javascript:', page), [])
        self.assertEqual(set(re.findall(r'(?:src|href)="([^"#]+)"', page)), {"docs/app.js", "docs/style.css", "openapi.json",
                                                                             "./", "learn", "status", "docs/README.md"})
        for path in PARTS:
            text = self.server.ask(path).body.decode("ascii")
            self.assertEqual(re.findall(r"https?://|\beval\b|new Function|innerHTML|@import|localStorage|sessionStorage|document\.cookie", text), [])

    def test_who_has_it_already_gets_no_body(self):
        tags = set()
        for path in (*PARTS, "/openapi.json"):
            with self.subTest(path=path):
                whole = self.server.ask(path)
                tag = whole.headers["etag"]
                self.assertRegex(tag, r'^W/"[0-9a-f]{32}"$')
                tags.add(tag)
                for given in (tag, tag.removeprefix("W/"), f'"x", {tag}', "*"):
                    answer = self.server.ask(path, "-H", f"If-None-Match: {given}")
                    self.assertEqual((answer.status, answer.body, answer.headers["etag"]), (304, b"", tag))
                    self.assertEqual(answer.headers.get("vary"), whole.headers.get("vary"))
                    self.assertNotIn("content-length", answer.headers)
                    self.assertEqual(answer.headers["cache-control"], whole.headers["cache-control"])
                for given in ('"x"', tag[3:-1], f'"{tag[3:-2]}"', ""):
                    answer = self.server.ask(path, "-H", f"If-None-Match: {given}")
                    self.assertEqual((answer.status, answer.body), (200, whole.body))
        self.assertEqual(len(tags), 4)

    def test_it_can_be_read_only(self):
        for path in PARTS:
            head = self.server.ask(path, "--head")
            self.assertEqual((head.status, head.headers["content-length"]), (200, str(len(self.server.ask(path).body))))
            after = self.server.ask(path, "-X", "OPTIONS")
            self.assertEqual((after.status, after.headers["allow"]), (204, "GET, HEAD, OPTIONS"))
            for method in ("POST", "PUT", "DELETE"):
                refused = self.server.ask(path, "-X", method)
                self.assertEqual((refused.status, refused.json()["code"]), (405, "METHOD_NOT_ALLOWED"))

    @unittest.skipIf(MISSING, MISSING)
    def test_every_route_and_schema_is_shown(self):
        markup, complaints = rendered(self.server.url + "/docs")
        self.assertEqual(complaints, [])
        text = plain(markup)
        for method, path, operation in operations():
            with self.subTest(method=method, path=path):
                (block,) = re.findall(rf'<article id="{operation["operationId"]}".*?</article>', markup, re.DOTALL)
                shown = plain(block)
                self.assertTrue(shown.startswith(f"{method} {path} {operation['summary']}"), shown[:200])
                self.assertIn("curl -s", shown)
                for status in operation["responses"]:
                    self.assertIn(f" {status} ", shown)
                for content in operation.get("requestBody", {}).get("content", {}).values():
                    if "example" in content:
                        self.assertIn(json.dumps(content["example"], separators=(",", ":")), html.unescape(block))
        for name in DOCUMENT["components"]["schemas"]:
            self.assertIn(f'id="schema-{name}"', markup)
        # Every link within the page leads somewhere.
        self.assertEqual(set(re.findall(r'href="#([^"]+)"', markup)) - set(re.findall(r'\bid="([^"]+)"', markup)), set())
        for owner in (DOCUMENT["components"]["responses"]["Fault"], *DOCUMENT["tags"]):
            for names in owner.get("x-codes", {}).values():
                self.assertEqual([name for name in names if f"<code>{name}</code>" not in markup], [])
        self.assertIn("query_bytes", text)

    @unittest.skipIf(MISSING, MISSING)
    def test_its_curl_lines_work(self):
        markup, _ = rendered(self.server.url + "/docs")
        lines = [html.unescape(line) for line in re.findall(r"<code>(curl -s .*?)</code>", markup, re.DOTALL)]
        self.assertGreater(len(lines), 30)
        # A job has an id that nobody can guess: the page shows one of zeros.
        asked = self.server.ask("/v1/scenes/six/rays:any", "-H", "Prefer: respond-async", "-H", "Content-Type: application/json",
                                body='{"rays":[{"origin":[3,200,5],"direction":[0,-1,0]}]}')
        self.assertEqual(asked.status, 202)
        job = asked.headers["location"]
        while self.server.ask(job).json()["state"] != "done":
            pass
        for line in lines:
            line = line.replace("/v1/jobs/" + "0" * 32, job)
            # Scenes are not changed here, and a scene that is named so is not there.
            if "-X " in line or "house.glb" in line:
                continue
            with self.subTest(line=line):
                done = subprocess.run(["sh", "-c", line + " -o /dev/null -w '%{http_code}'"], capture_output=True, text=True,
                                      timeout=PATIENCE, check=True)
                self.assertEqual(done.stdout, "200")


class DocsPageWithKeys(unittest.TestCase):
    def test_the_page_needs_no_key_and_what_it_shows_does(self):
        key, line = make_key("read", "people")
        with tempfile.TemporaryDirectory() as folder:
            keys = write_keys(Path(folder, "keys"), line)
            with Server("--preload", "six=demo:six", "--keys", keys) as server:
                for path in PARTS:
                    self.assertEqual(server.ask(path).status, 200)
                    self.assertEqual(server.ask(path, "-X", "POST").status, 401)
                for path in ("/openapi.json", "/docs/", "/docs/page.html"):
                    self.assertEqual(server.ask(path).status, 401)
                self.assertEqual(server.ask("/openapi.json", *bearer(key)).json(), DOCUMENT)
                tag = server.ask("/openapi.json", *bearer(key)).headers["etag"]
                self.assertEqual(server.ask("/openapi.json", "-H", f"If-None-Match: {tag}").status, 401)
                if BROWSER is None:
                    self.skipTest("no chromium is installed: what the page asks for was not looked at")
                markup, _ = rendered(server.url + "/docs")
                self.assertIn('<form id="key-form">', markup)
                self.assertNotIn("<article", markup)


if __name__ == "__main__":
    case_report.main()
