"""The wheel and the source distribution of scripts/package.sh."""

import base64
import csv
import hashlib
import importlib.util
import os
import shutil
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
        if importlib.util.find_spec("pip"):
            self.install(wheel)
        else:
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(self.folder / "installed")
        self.assertEqual(self.version_of_installed(), wheel.name.split("-")[1])

    def test_an_installed_source_distribution_answers(self):
        for module in ("pip", "setuptools", "wheel"):
            if importlib.util.find_spec(module) is None:
                self.skipTest(f"{module} is not installed")
        source = self.build("built")[1]
        self.install(source)
        self.assertEqual(f"sightline-{self.version_of_installed()}.tar.gz", source.name)

    def install(self, file):
        """Without the network: the build of a source distribution uses the setuptools that are installed."""
        pip = [sys.executable, "-m", "pip", "--isolated", "install", "--no-index", "--no-build-isolation", "--no-deps", "--no-compile", "--quiet",
               "--target", self.folder / "installed", file]
        done = subprocess.run(pip, capture_output=True, text=True, check=False, timeout=PATIENCE)
        self.assertEqual(done.returncode, 0, done.stderr)

    def version_of_installed(self):
        """What the metadata say; the module is that of the folder, and its own server answers."""
        installed = self.folder / "installed"
        done = subprocess.run([sys.executable, "-B", "-c", USE], env={**os.environ, "PYTHONPATH": str(installed), "SIGHTLINE_BINARY": BINARY},
                              capture_output=True, text=True, timeout=PATIENCE, check=False, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        place, version, t = done.stdout.split()
        self.assertEqual((Path(place).resolve().parent, float(t)), (installed.resolve(), 4.5))
        return version

    def test_package_sh_builds_both_beside_the_deb(self):
        """In a copy of the files that it reads, with stand-ins for what builds the .deb."""
        for name in ("scripts/package.sh", "scripts/python_package.py", "CMakeLists.txt", "LICENSE", "proto/python"):
            copy = shutil.copytree if (SOURCE / name).is_dir() else shutil.copy
            (self.folder / "tree" / name).parent.mkdir(parents=True, exist_ok=True)
            copy(SOURCE / name, self.folder / "tree" / name)
        (self.folder / "tree/build/release").mkdir(parents=True)
        (self.folder / "bin").mkdir()
        for name, script in (("bin/cmake", ""), ("bin/cpack", 'touch "$2/sightline_0_any.deb"'), ("tree/scripts/install_packages.sh", ""),
                             ("bin/python3", f"exec '{sys.executable}' \"$@\"")):
            (self.folder / name).write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
            (self.folder / name).chmod(0o755)
        done = subprocess.run([self.folder / "tree/scripts/package.sh", "--output", "out"], cwd=self.folder, capture_output=True, text=True,
                              check=False, env={**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}"}, timeout=PATIENCE)
        self.assertEqual(done.returncode, 0, done.stderr)
        deb, *both = map(Path, done.stdout.split())
        self.assertEqual((deb.name, [path.parent.name for path in both]), ("sightline_0_any.deb", ["out", "out"]))
        self.assertEqual([path.read_bytes() for path in both], [path.read_bytes() for path in self.build("built")])

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
