"""The wheel and the source distribution of scripts/package.sh."""

import base64
import csv
import hashlib
import os
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile
from pathlib import Path

import case_report
from sightline_server import BINARY, PATIENCE, SOURCE

USE = """
import sightline
from importlib.metadata import version
import sightline_bulk
with sightline.Sightline.local("demo:six") as server:
    print(sightline.__file__, version("sightline"), list(server.closest("six", [[-10, 1, 0]], [[1, 0, 0]])["t"])[0])
"""


class PythonPackage(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def build(self, name):
        done = subprocess.run([sys.executable, "-B", SOURCE / "scripts/python_package.py", self.folder / name], capture_output=True,
                              text=True, check=True)
        return [Path(line) for line in done.stdout.split()]

    def test_an_installed_wheel_answers(self):
        wheel = self.build("built")[0]
        installed = self.folder / "installed"
        pip = [sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "--no-compile", "--quiet", "--target", installed, wheel]
        if subprocess.run(pip, capture_output=True, check=False, timeout=PATIENCE).returncode != 0:  # Debian's Python may have no pip.
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(installed)
        done = subprocess.run([sys.executable, "-B", "-c", USE], env={**os.environ, "PYTHONPATH": str(installed), "SIGHTLINE_BINARY": BINARY},
                              capture_output=True, text=True, timeout=PATIENCE, check=False, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        place, version, t = done.stdout.split()
        self.assertEqual((Path(place).resolve().parent, f"-{version}-" in wheel.name, float(t)), (installed.resolve(), True, 4.5))

    def test_the_wheel_records_its_files(self):
        with zipfile.ZipFile(self.build("built")[0]) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
        record = next(name for name in files if name.endswith("/RECORD"))
        rows = list(csv.reader(files[record].decode().splitlines()))
        self.assertEqual({row[0] for row in rows}, set(files))
        for name, code, size in rows:
            if name != record:
                digest = base64.urlsafe_b64encode(hashlib.sha256(files[name]).digest()).rstrip(b"=").decode()
                self.assertEqual((code, int(size)), (f"sha256={digest}", len(files[name])), name)

    def test_the_source_distribution_has_what_a_build_needs(self):
        with tarfile.open(self.build("built")[1]) as archive:
            files = {name.split("/", 1)[1]: archive.extractfile(name).read() for name in archive.getnames()}
        self.assertEqual(set(files), {"PKG-INFO", "pyproject.toml", "sightline.py", "sightline_bulk.py", "LICENSE", "README.md"})
        for name in ("sightline.py", "sightline_bulk.py"):
            self.assertEqual(files[name], (SOURCE / "proto/python" / name).read_bytes())
        for line in (b'build-backend = "setuptools.build_meta"', b'py-modules = ["sightline", "sightline_bulk"]'):
            self.assertIn(line, files["pyproject.toml"])

    def test_the_same_checkout_gives_the_same_bytes(self):
        for one, other in zip(self.build("one"), self.build("other")):
            self.assertEqual(one.read_bytes(), other.read_bytes())


if __name__ == "__main__":
    case_report.main()
