"""Each command line of README.md and docs/ is run here or by another test, or says here why not. documented_lines_test.py
runs lines of curl, python_jobs_test.py runs the scripts of docs/guides/python.md, api_page_test.py has docs/reference/api.md."""

import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import case_report
from documented_lines_test import ADDRESS, CURL, blocks, commands
from sightline_server import BINARY, PATIENCE, SOURCE, Server, make_key, write_keys

CLIENT = SOURCE / "proto/python"
PAGES = [page for page in (SOURCE / "README.md", *sorted((SOURCE / "docs").rglob("*.md"))) if page.name != "api.md"]
# What a block of commands begins with.
PROGRAM = re.compile(r"(?:\$ )?(?:\./)?(?:sightline|build/|scripts/|python|docker|kubectl|apt|install|cmake|ctest|systemctl|tar|dask-|groupadd|chgrp|echo|pip)[ \w./-]* ")
# Commands that no test runs as they stand, and why.
NOT_RUN = {
    r"(\./)?scripts/": "builds, installs or measures for minutes; scripts/bare_check.sh runs run.sh, test.sh and package.sh",
    r"build/release/tests/bench/": "measures",
    r"docker ": "needs docker; scripts/image.sh builds and runs the image",
    r"kubectl ": "needs a cluster; cluster_files_test.py checks the files",
    r"(apt|install|groupadd|chgrp|systemctl) ": "changes the machine; scripts/bare_check.sh --package installs the service and asks it",
    r"echo 'write me ": "a line for a file of keys; deploy_test.py makes one",
    r"dask-|python -m sightline bulk .*--dask": "needs a cluster; scripts/bulk_test.sh has one",
    r"sightline serve ": "a server; every test starts one, origin_test.py with an origin",
    r"sightline convert ": "convert_test.py, where assimp is installed",
    r"tar ": "restart_test.py",
}
RUN = r"(build/release/sightline demo |(\$ )?sightline key new |python -m sightline bulk rays\.npy --scene town --out hits\.npy$|echo '\{)"


def command_lines():
    """(page, command) of each block."""
    for page in PAGES:
        for block in blocks(page.read_text(encoding="utf-8")):
            for command in commands(block):
                if PROGRAM.match(command + " ") and not re.match(CURL, command):
                    yield page.name, re.sub(r"\s*\\\n\s*", " ", re.sub(r"\s+#.*", "", command))


class DocumentedCommands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        subprocess.run([BINARY, "demo", "town", cls.folder / "house.glb"], check=True, timeout=PATIENCE)
        cls.server = Server("--preload", "town=demo:town", "--preload", "house=demo:town")
        cls.addClassCleanup(cls.server.end)

    def run_program(self, *words, **environment):
        return subprocess.run([*map(str, words)], cwd=self.folder, capture_output=True, text=True, env={**os.environ, **environment},
                              timeout=PATIENCE, check=False)

    def need_numpy(self):
        if self.run_program(sys.executable, "-c", "import numpy").returncode != 0:
            self.skipTest("numpy is not installed")

    def test_each_command_is_run_or_says_why_not(self):
        used = set()
        for page, command in command_lines():
            reasons = [pattern for pattern in (*NOT_RUN, RUN) if re.match(pattern, command)]
            self.assertEqual(len(reasons), 1, f"{page}: {command}")
            used.update(reasons)
        self.assertEqual(used, {*NOT_RUN, RUN})

    def test_lines_of_query_and_cast_do_what_their_page_says(self):
        ran, compared = 0, 0
        for page in (SOURCE / "README.md", SOURCE / "docs/start.md"):
            text = page.read_text(encoding="utf-8")
            for line, told in re.findall(r"`build/release/sightline ((?:query|cast) [^`]*)`(?:[^`]*`(t=[^`]*)`)?", text):
                done = self.run_program(BINARY, *shlex.split(line.replace(ADDRESS, self.server.url)))
                self.assertEqual((done.returncode, done.stderr), (0, ""), line)
                if told:
                    self.assertEqual(done.stdout.strip(), told)
                    compared += 1
                ran += 1
        self.assertEqual((ran, compared), (3, 1))

    def test_a_new_key_is_printed_as_the_page_shows(self):
        page = (SOURCE / "docs/guides/deployment.md").read_text(encoding="utf-8")
        (shown,) = [block for block in blocks(page) if block.startswith("$ sightline key new ")]
        command, *lines = shown.splitlines()
        done = self.run_program(BINARY, *command.split()[2:])

        def form(text):
            return re.sub(r"slk_[\w-]{43}", "KEY", re.sub(r"[0-9a-f]{64}", "HASH", text))

        self.assertEqual(form(done.stdout).splitlines(), list(map(form, lines)))

    def test_the_settings_of_the_pages_are_good(self):
        page = (SOURCE / "docs/guides/deployment.md").read_text(encoding="utf-8")
        (block,) = [block for block in blocks(page) if block.startswith("{") and '"preload"' in block]
        (line,) = re.findall(r"^ {4}echo '(\{.*\})' >", page, re.MULTILINE)
        write_keys(self.folder / "keys", make_key("write", "me")[1])
        for settings in (block, line):
            file = self.folder / "sightline.json"
            file.write_text(settings.replace("/etc/sightline", str(self.folder)).replace("/var/lib/sightline", str(self.folder / "data")),
                            encoding="utf-8")
            done = self.run_program(BINARY, "check-config", file)
            self.assertEqual(done.returncode, 0, done.stderr)
        json.loads(line)

    def test_the_line_of_bulk_answers_a_file(self):
        command, = [command for _, command in command_lines() if command.startswith("python -m sightline bulk ") and re.match(RUN, command)]
        self.need_numpy()
        self.run_program(sys.executable, "-c", "import numpy; numpy.save('rays.npy', [[3.0, 200, 5, 0, -1, 0], [3, 200, 5, 0, 1, 0]])")
        line = command.split()[1:]
        done = self.run_program(sys.executable, "-B", *line, "--server", self.server.url, "--workers", 0, "--quiet", PYTHONPATH=str(CLIENT))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        read = self.run_program(sys.executable, "-c", "import numpy; print(numpy.load('hits.npy')['t'].tolist())")
        self.assertEqual(read.stdout, "[199.75, inf]\n", read.stderr)

    def test_the_functions_for_other_engines_answer_a_part(self):
        """Neither Spark nor Ray is installed: what their scripts hand to them runs, with stand-ins for their tables."""
        self.need_numpy()
        page = (SOURCE / "docs/guides/bulk.md").read_text(encoding="utf-8")
        spark, ray = [block for block in blocks(page) if "sightline_bulk.Question(" in block]
        prelude = ("import sys, types, numpy\nrays = numpy.array([[3.0, 200, 5, 0, -1, 0], [3.0, 200, 5, 0, 1, 0]])\n"
                   "class Part:\n    def __getitem__(self, names):\n        assert names == ['ox', 'oy', 'oz', 'dx', 'dy', 'dz']\n        return self\n"
                   "    def to_numpy(self):\n        return rays\n"
                   "sys.modules.update(ray=types.ModuleType('ray'), pandas=types.SimpleNamespace(DataFrame=dict))\n")
        for code, end, call in ((spark, "spark.sparkContext", "next(answers([Part()]))"), (ray, "ray.init(", "answers({'ray': rays})")):
            code = re.sub(r'\("http://a:8080", "http://b:8080"\)', f'("{self.server.url}",)', code.split("\n" + end)[0])
            done = self.run_program(sys.executable, "-B", "-c", f"{prelude}{code}\nfound = {call}\nprint(sorted(found), found['t'].tolist())",
                                    PYTHONPATH=str(CLIENT))
            self.assertEqual(done.stdout, "['hit', 'node_id', 't'] [199.75, inf]\n", done.stderr)

    def test_the_client_of_several_servers_is_made_as_the_page_says(self):
        page = (SOURCE / "docs/guides/replicas.md").read_text(encoding="utf-8")
        (line,) = re.findall(r"^ {4}(server = Sightline\(.*\))$", page, re.MULTILINE)
        line = re.sub(r"http://[abc]:8080", self.server.url, line)
        done = self.run_program(sys.executable, "-B", "-c", f"from sightline import Sightline\n{line}\nprint(server.scene('town')['state'])",
                                PYTHONPATH=str(CLIENT))
        self.assertEqual(done.stdout, "ready\n", done.stderr)


if __name__ == "__main__":
    case_report.main()
