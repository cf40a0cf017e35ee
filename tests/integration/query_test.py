"""sightline query: the command line as a client of a real server."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import case_report
from liar import HOSTILE_ANSWERS, Liar
from sightline_server import BINARY, PATIENCE, Server, make_key, write_keys

CONTROLS = {chr(code) for code in (*range(0x20), *range(0x7f, 0xa0))}
# See rays_test.py.
HIT, MISS = ("--origin", "-10,1,0", "--direction", "1,0,0"), ("--origin", "1,10,0", "--direction", "0,-1,0")
RAYS = "# from the left, between, from above\n-10 1 0  1 0 0\n1,10,0, 0,-1,0\n\n" + '{"origin":[3,10,0],"direction":[0,-1,0]}\n'


class Query(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six")
        cls.addClassCleanup(cls.server.end)

    def run_query(self, *arguments, url=None, stdin="", **environment):
        known = {name: value for name, value in os.environ.items() if name != "SIGHTLINE_KEY"}
        return subprocess.run([BINARY, "query", url or self.server.url, "six", *arguments], input=stdin, capture_output=True,
                              text=True, timeout=PATIENCE, check=False, env={**known, **environment})

    def told(self, *arguments, code=0, **options):
        done = self.run_query(*arguments, **options)
        self.assertEqual((done.returncode, done.stderr), (code, ""), done.stdout)
        return done.stdout

    def test_one_ray(self):
        self.assertEqual(self.told(*HIT, "--fields", "t,node,front"), 't=4.5  front=true  node="left"\n')
        self.assertEqual(self.told(*MISS, code=1), "miss\n")
        self.assertEqual(json.loads(self.told(*HIT, "--fields", "t,triangle", "--json")), {"t": 4.5, "triangle": 0})

    def test_limits(self):
        self.assertEqual(self.told(*HIT, "--tmin", "5", "--fields", "t"), "t=6.5\n")
        self.assertEqual(self.told(*HIT, "--tmax", "4", "--fields", "t", code=1), "miss\n")

    def test_every_mode(self):
        self.assertEqual(self.told(*HIT, "--any"), "true\n")
        self.assertEqual(self.told(*MISS, "--any", code=1), "false\n")
        self.assertEqual(self.told(*HIT, "--count"), "6\n")
        self.assertEqual(self.told(*MISS, "--count", "--crossings", "once", code=1), "0\n")
        lines = self.told(*HIT, "--all", "--fields", "t").splitlines()
        self.assertEqual((lines[0], lines[1], len(lines)), ("6 hits", "  t=4.5", 7))
        self.assertEqual(self.told(*MISS, "--all", code=1), "0 hits\n")

    def test_rays_of_a_file_and_of_standard_input(self):
        expected = "t=4.5\nmiss\nt=8\n"
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "rays.txt")
            file.write_text(RAYS, encoding="utf-8")
            self.assertEqual(self.told("--rays", file, "--fields", "t"), expected)
        self.assertEqual(self.told("--rays", "-", "--fields", "t", stdin=RAYS), expected)
        self.assertEqual(self.told("--rays", "-", stdin=""), "")
        told = self.told("--rays", "-", "--fields", "t", "--json", stdin=RAYS)
        self.assertEqual([json.loads(line) for line in told.splitlines()], [{"t": 4.5}, None, {"t": 8}])

    def test_more_rays_than_are_asked_at_once(self):
        rays = "".join(f"{-10 - i} 1 0 1 0 0\n" for i in range(25_000))
        told = self.told("--rays", "-", "--fields", "t", stdin=rays).split()
        self.assertEqual(told, [f"t={4.5 + i:.1f}".replace(".0", "") for i in range(25_000)])

    def test_faults(self):
        for arguments, options, said in [
                (("--rays", "-"), {"stdin": "1 2 3\n"}, "RAY_LINE_INVALID: line 1:"),
                (("--rays", "-"), {"stdin": "\n1 2 3 4 5 x\n"}, "RAY_LINE_INVALID: line 2:"),
                (("--rays", "-"), {"stdin": "0 0 0 0 0 0\n"}, "RAY_DIRECTION_ZERO"),
                (("--rays", "/nowhere/at/all"), {}, "RAYS_UNREADABLE"),
                (("--origin", "0,0,0"), {}, "needs --origin and --direction"),
                ((*HIT, "--rays", "-"), {}, "--rays"),
                (HIT, {"url": "http://127.0.0.1:1"}, "SERVER_UNREACHABLE"),
                (HIT, {"url": "gopher://x"}, "URL_INVALID"),
                ((*HIT, "--key-file", "/nowhere/at/all"), {}, "KEY_UNREADABLE")]:
            with self.subTest(arguments=arguments):
                done = self.run_query(*arguments, **options)
                self.assertEqual((done.returncode, done.stdout), (2, ""))
                self.assertIn(said, done.stderr)
                self.assertEqual(len(done.stderr.splitlines()), 2 if "--help" in done.stderr else 1)
        done = subprocess.run([BINARY, "query", self.server.url, "a/b c", *HIT], capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("SCENE_", done.stderr)

    def test_what_another_server_says_is_a_fault_and_steers_no_terminal(self):
        for told in HOSTILE_ANSWERS:
            with self.subTest(told=told[1][:60]), Liar(*told) as liar:
                done = self.run_query(*HIT, url=liar.url)
                self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
                self.assertIn("SERVER_REFUSES", done.stderr)
                self.assertFalse(set(done.stderr[:-1]) & CONTROLS, done.stderr)
        for body, said in [(b'{"hits":[]}', "null hits\n"), (b'{"hits":7,"total":{}}', "{} hits\n  7\n"), (b'{"total":"x"}', 'total="x"\n'),
                           (b'{"\\u001b[2J":"\\u007f\\u009b"}', '?[2J="??"\n'), ('"\u00e4"'.encode(), '"\u00e4"\n')]:
            with self.subTest(body=body), Liar(200, body + b"\n") as liar:
                self.assertEqual(self.told(*HIT, url=liar.url), said)

    def test_keys(self):
        key, line = make_key("read", "ci")
        with tempfile.TemporaryDirectory() as folder:
            keys, own = write_keys(Path(folder, "keys"), line), Path(folder, "own")
            own.write_text(key + "\n", encoding="ascii")
            with Server("--preload", "six=demo:six", "--keys", keys, wait=False) as server:
                refused = self.run_query(*HIT, url=server.url)
                self.assertEqual(refused.returncode, 2)
                self.assertIn("401", refused.stderr)
                server.wait_ready()
                self.assertEqual(self.told(*HIT, "--fields", "t", url=server.url, SIGHTLINE_KEY=key), "t=4.5\n")
                self.assertEqual(self.told(*HIT, "--fields", "t", "--key-file", own, url=server.url), "t=4.5\n")


if __name__ == "__main__":
    case_report.main()
