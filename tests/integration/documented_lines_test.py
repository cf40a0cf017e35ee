"""Each curl line of README.md and of docs/ does what its page says.

A page is read from top to bottom. A code block that begins with `curl` is a request; a continued line and a body of several
lines belong to it. If the next block begins with `{`, it is the answer, to the byte. `sightline demo NAME FILE` writes a
file first. A page with `$KEY` has a server with keys. docs/reference/api.md has its own test.
"""

import base64
import json
import os
import re
import shlex
import subprocess
import tempfile
import textwrap
import unittest
import zlib
from pathlib import Path

import case_report
from sightline_server import BINARY, PATIENCE, SOURCE, Server, make_key, write_keys

ADDRESS = "http://127.0.0.1:8080"
CURL = r"(?:\w+=\$\()?curl (?=[-'h])"


def blocks(text):
    """Code blocks of a page, indented or fenced, as texts."""
    found, block, fenced, blank = [], [], False, True
    for line in text.splitlines():
        if line.startswith("```"):
            if fenced:
                found.append("\n".join(block))
                block = []
            fenced = not fenced
        elif fenced:
            block.append(line)
        elif line.startswith("    ") and (blank or block):
            block.append(line[4:])
        elif block:
            found.append("\n".join(block))
            block = []
        if line.startswith("#") and not fenced:
            found.append("")  # an answer is below the heading of its request
        blank = not line.strip()
    return [*found, "\n".join(block)] if block else found


def commands(block):
    """The shell commands of a block: a line goes on behind a backslash and inside of quotes."""
    lines = []
    for line in textwrap.dedent(block).splitlines():
        if lines and (lines[-1].endswith("\\") or lines[-1].count("'") % 2):
            lines[-1] += "\n" + line
        else:
            lines.append(line)
    return lines


PAGES = [page for page in (SOURCE / "README.md", *sorted((SOURCE / "docs").rglob("*.md")))
         if page.name != "api.md" and re.search(rf"^ *{CURL}", page.read_text(encoding="utf-8"), re.MULTILINE)]


def pixels(png):
    """The filtered rows of a PNG file. Releases of zlib compress them differently."""
    data, at, rows = png.read_bytes(), 8, b""
    while at < len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        if data[at + 4:at + 8] == b"IDAT":
            rows += data[at + 8:at + 8 + size]
        at += size + 12
    return zlib.decompress(rows)


def write_gltf_of_two_scenes(glb, file):
    """The scene of a GLB file twice, as a .gltf file."""
    data = glb.read_bytes()
    end = 20 + int.from_bytes(data[12:16], "little")
    document = json.loads(data[20:end])
    document["scenes"] *= 2
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data[end + 8:]).decode()
    file.parent.mkdir()
    file.write_text(json.dumps(document), encoding="utf-8")


class DocumentedLines(unittest.TestCase):
    def run_page(self, page, server, folder, key):
        ran = 0
        parts = blocks(page.read_text(encoding="utf-8"))
        for block, following in zip(parts, [*parts[1:], ""]):
            for command in commands(block):
                if re.match(r"build/release/sightline demo \w+ \S+$", command):
                    name, file = command.split()[2:]
                    subprocess.run([BINARY, "demo", name, folder / file], check=True, timeout=PATIENCE)
                if not re.match(CURL, command):
                    continue
                with self.subTest(page=page.name, command=command):
                    # An answer that is no success is a failure here unless the page shows it.
                    shown = following if block == command and "-o " not in command and following.startswith("{") else None
                    line = command.replace(ADDRESS, server.url)
                    if shown is None and "-o " not in line and "$(" not in line:
                        line = line.replace("curl ", "curl --fail-with-body ", 1)
                    done = subprocess.run(["bash", "-c", "set -o pipefail\n" + line], cwd=folder, capture_output=True, text=True,
                                          env={**os.environ, "KEY": key}, timeout=PATIENCE, check=False)
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                    if shown is not None:
                        self.assertEqual(done.stdout.strip(), shown.strip())
                    ran += 1
        self.assertEqual(ran, len(re.findall(rf"^ *{CURL}", page.read_text(encoding="utf-8"), re.MULTILINE)), page)
        return ran

    def test_each_curl_line_works_and_its_answer_is_true(self):
        ran = 0
        for page in PAGES:
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                subprocess.run([BINARY, "demo", "town", folder / "house.glb"], check=True, timeout=PATIENCE)
                write_gltf_of_two_scenes(folder / "house.glb", folder / "town/house.gltf")
                key, line = make_key("write", "docs")
                keys = ("--keys", write_keys(folder / "keys", line)) if "$KEY" in page.read_text(encoding="utf-8") else ()
                with Server("--preload", "town=demo:town", "--preload", "six=demo:six", "--preload", "painted=demo:painted",
                            "--preload", "house=demo:town", "--scene-root", folder, *keys) as server:
                    ran += self.run_page(page, server, folder, key)
                for picture in folder.glob("*.png"):
                    self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n", picture.name)
                    self.assertEqual(pixels(picture), pixels(SOURCE / "docs/images/town-normal.png"), f"{page.name}: scripts/page_pictures.sh")
        print(f"{ran} curl lines of {len(PAGES)} pages")
        self.assertGreater(ran, 8)

    def test_the_python_of_the_readme_prints_what_it_says(self):
        (code,) = re.findall(r"```python\n(.*?)```", (SOURCE / "README.md").read_text(encoding="utf-8"), re.DOTALL)
        said = re.findall(r"  # (.+)$", code, re.MULTILINE)
        with Server() as server, tempfile.TemporaryDirectory() as folder:
            subprocess.run([BINARY, "demo", "town", Path(folder, "house.glb")], check=True, timeout=PATIENCE)
            done = subprocess.run(["/usr/bin/env", f"PYTHONPATH={SOURCE / 'proto/python'}", "python3", "-B", "-c", code.replace(ADDRESS, server.url)],
                                  cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(done.stdout.replace("np.float64(199.75)", "199.75").splitlines(), said, done.stderr)


if __name__ == "__main__":
    case_report.main()
