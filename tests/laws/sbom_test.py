#!/usr/bin/env python3
"""The bill of materials of scripts/sbom.py under test: a small image in, a document of SPDX 2.3 out."""

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts/sbom.py"
STATUS = """Package: libone
Status: install ok installed
Architecture: amd64
Version: 1:2.0-1+deb12u1
Description: the first
 License: none, this line belongs to the description

Package: gone
Status: deinstall ok config-files
Architecture: amd64
Version: 1

Package: libtwo++
Status: install ok installed
Architecture: all
Version: 3
"""
COPYRIGHT = """Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/

Files: *
License: GPL-2+ or Expat

Files: debian/*
License: GPL-3+ with odd exception

License: Expat
 Permission is hereby granted
"""


def make_image(root):
    for name, text in {"var/lib/dpkg/status": STATUS, "var/lib/dpkg/info/libone:amd64.list": "/.\n/usr/lib\n/usr/lib/one.so.2\n/usr/lib/one.so\n/usr/share/absent\n",
                       "usr/lib/one.so.2": "code", "usr/share/doc/libone/copyright": COPYRIGHT, "usr/share/doc/libtwo++/copyright": "All rights are somewhere.",
                       "usr/local/bin/sightline": "program", "usr/share/doc/sightline/build_packages": "libtinygltf-dev\t2.7.0-1\tall\nlibone\t1:2.0-1+deb12u1\tamd64\n"}.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    (root / "usr/lib/one.so").symlink_to("one.so.2")


class Document(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        make_image(self.root)
        self.document = self.write()
        self.packages = {each["name"]: each for each in self.document["packages"]}

    def write(self, *options):
        done = subprocess.run([sys.executable, "-B", SCRIPT, self.root, *options], capture_output=True, text=True, check=True,
                              env={**os.environ, "SOURCE_DATE_EPOCH": "1700000000"})
        return json.loads(done.stdout)

    def test_it_has_the_form_of_spdx(self):
        document = self.document
        self.assertEqual((document["spdxVersion"], document["dataLicense"], document["SPDXID"]), ("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"))
        self.assertEqual(document["creationInfo"]["created"], "2023-11-14T22:13:20Z")
        ids = [each["SPDXID"] for each in document["packages"]]
        self.assertEqual(len(ids), len(set(ids)))
        for each in document["packages"]:
            self.assertRegex(each["SPDXID"], r"^SPDXRef-[A-Za-z0-9.-]+$")
            self.assertLessEqual({"name", "versionInfo", "downloadLocation", "filesAnalyzed", "licenseConcluded", "licenseDeclared", "copyrightText"}, set(each))
            self.assertEqual(each["filesAnalyzed"], "packageVerificationCode" in each)
            for checksum in each.get("checksums", []):
                self.assertRegex(checksum["checksumValue"], {"SHA256": "^[0-9a-f]{64}$", "SHA512": "^[0-9a-f]{128}$"}[checksum["algorithm"]])
        for each in document["relationships"]:
            self.assertLessEqual({each["spdxElementId"], each["relatedSpdxElement"]}, {*ids, "SPDXRef-DOCUMENT"})
        used = set(re.findall(r"LicenseRef-[A-Za-z0-9.-]+", " ".join(each["licenseDeclared"] for each in document["packages"])))
        self.assertEqual(used, {each["licenseId"] for each in document["hasExtractedLicensingInfos"]})

    def test_it_lists_installed_packages_with_licences_and_checksums(self):
        self.assertNotIn("gone", self.packages)
        one, two = self.packages["libone"], self.packages["libtwo++"]
        self.assertEqual(one["versionInfo"], "1:2.0-1+deb12u1")
        self.assertEqual(one["externalRefs"][0]["referenceLocator"], "pkg:deb/debian/libone@1%3A2.0-1%2Bdeb12u1?arch=amd64")
        self.assertEqual(one["licenseDeclared"], "(GPL-2.0-or-later OR MIT) AND LicenseRef-GPL-3-or-later-with-odd-exception AND MIT")
        code = hashlib.sha1(hashlib.sha1(b"code").hexdigest().encode()).hexdigest()
        self.assertEqual(one["packageVerificationCode"]["packageVerificationCodeValue"], code)
        self.assertEqual((two["licenseDeclared"], two["filesAnalyzed"]), ("NOASSERTION", False))
        self.assertEqual(self.packages["sightline"]["checksums"][0]["checksumValue"], hashlib.sha256(b"program").hexdigest())

    def test_it_lists_what_the_program_was_built_with(self):
        self.assertEqual(self.packages["libtinygltf-dev"]["licenseDeclared"], "MIT")
        kinds = {(each["spdxElementId"], each["relationshipType"]) for each in self.document["relationships"]}
        self.assertIn((self.packages["libtinygltf-dev"]["SPDXID"], "BUILD_DEPENDENCY_OF"), kinds)
        self.assertEqual([each["name"] for each in self.document["packages"]].count("libone"), 1)

    def test_it_lists_the_npm_packages_of_the_page(self):
        for name in ("three", "marked", "esbuild"):
            self.assertEqual((self.packages[name]["licenseDeclared"], self.packages[name]["checksums"][0]["algorithm"]), ("MIT", "SHA512"))
        bundled = {each["relatedSpdxElement"] for each in self.document["relationships"] if each["relationshipType"] == "CONTAINS"}
        self.assertTrue({"SPDXRef-npm-three", "SPDXRef-npm-marked"} <= bundled and "SPDXRef-npm-esbuild" not in bundled)
        self.assertNotIn("three", {each["name"] for each in self.write("--without-page")["packages"]})

    def test_one_image_has_one_document(self):
        self.assertEqual(self.write(), self.document)


if __name__ == "__main__":
    unittest.main()
