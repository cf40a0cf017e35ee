#!/usr/bin/env python3
"""Builds the Python client (two modules) as a wheel and as a source distribution, with the standard library alone.

Usage: scripts/python_package.py FOLDER

The version is that of CMakeLists.txt. The same checkout gives the same bytes. Prints both paths. `pip install FILE` installs
either; for the source distribution pip needs setuptools and wheel.
"""

import base64
import gzip
import hashlib
import io
import re
import sys
import tarfile
import zipfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
# The earliest time of a zip file.
TIME = (1980, 1, 1, 0, 0, 0)
MODULES = ("sightline.py", "sightline_bulk.py")


def metadata(version):
    readme = (SOURCE / "proto/python/README.md").read_text(encoding="utf-8")
    return ("Metadata-Version: 2.1\nName: sightline\n" f"Version: {version}\n"
            "Summary: A client of Sightline: exact answers to rays and boxes in 3D scenes\nLicense: Apache-2.0\nRequires-Python: >=3.9\n"
            "Provides-Extra: fast\nRequires-Dist: numpy; extra == 'fast'\nDescription-Content-Type: text/markdown\n\n" + readme).encode()


def project(version):
    return (f'[build-system]\nrequires = ["setuptools>=61", "wheel"]\nbuild-backend = "setuptools.build_meta"\n\n[project]\nname = "sightline"\n'
            f'version = "{version}"\nrequires-python = ">=3.9"\nlicense = {{text = "Apache-2.0"}}\nreadme = "README.md"\n'
            '[project.optional-dependencies]\nfast = ["numpy"]\n\n[tool.setuptools]\npy-modules = ["sightline", "sightline_bulk"]\n').encode()


def wheel(folder, version, modules, licence):
    info = f"sightline-{version}.dist-info"
    files = {**modules, f"{info}/METADATA": metadata(version), f"{info}/LICENSE": licence,
             f"{info}/WHEEL": b"Wheel-Version: 1.0\nGenerator: sightline\nRoot-Is-Purelib: true\nTag: py3-none-any\n"}
    record = "".join(f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}\n"
                     for name, data in files.items())
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    path = folder / f"sightline-{version}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, TIME)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, data)
    return path


def source_distribution(folder, version, modules, licence):
    root = f"sightline-{version}"
    files = {"PKG-INFO": metadata(version), "pyproject.toml": project(version), **modules, "LICENSE": licence,
             "README.md": (SOURCE / "proto/python/README.md").read_bytes()}
    path = folder / f"{root}.tar.gz"
    with path.open("wb") as file, gzip.GzipFile("", "wb", fileobj=file, mtime=0) as packed, tarfile.open(fileobj=packed, mode="w") as archive:
        for name, data in files.items():
            entry = tarfile.TarInfo(f"{root}/{name}")
            entry.size, entry.mode = len(data), 0o644
            archive.addfile(entry, io.BytesIO(data))
    return path


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__.strip())
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    version = re.search(r"project\(\s*\w+\s+VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    modules, licence = {name: (SOURCE / "proto/python" / name).read_bytes() for name in MODULES}, (SOURCE / "LICENSE").read_bytes()
    for build in (wheel, source_distribution):
        print(build(folder, version, modules, licence))


if __name__ == "__main__":
    main()
