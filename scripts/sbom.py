#!/usr/bin/env python3
"""Writes the software bill of materials of a container image: SPDX 2.3 as JSON.

  scripts/sbom.py ROOT [--without-page] [-o FILE]

ROOT is a folder with the files of the image. The document lists
  - the program, with the SHA-256 of its file
  - the Debian packages of var/lib/dpkg/status: version, licences of usr/share/doc/*/copyright, and the SPDX verification code
    over the SHA-1 of the package's files that are in the image
  - the Debian packages that the program was compiled with (usr/share/doc/sightline/build_packages), with the licences of
    docs/dependencies.md: most of them are headers, which leave no package in the image
  - the npm packages of the page, with licence and SHA-512 of the lock file; --without-page if the program has none

SOURCE_DATE_EPOCH sets the time of the document. All else depends on the files alone.
"""

import argparse
import base64
import datetime
import hashlib
import json
import os
import re
import sys
import urllib.parse
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
# Names of Debian's copyright files and of docs/dependencies.md in lower case, and what SPDX calls them.
SPDX = {"expat": "MIT", "mit": "MIT", "gpl-1": "GPL-1.0-only", "gpl-1+": "GPL-1.0-or-later", "gpl-2": "GPL-2.0-only", "gpl-2+": "GPL-2.0-or-later",
        "gpl-3": "GPL-3.0-only", "gpl-3+": "GPL-3.0-or-later", "lgpl-2": "LGPL-2.0-only", "lgpl-2+": "LGPL-2.0-or-later",
        "lgpl-2.1": "LGPL-2.1-only", "lgpl-2.1+": "LGPL-2.1-or-later", "lgpl-3": "LGPL-3.0-only", "lgpl-3+": "LGPL-3.0-or-later",
        "apache-2.0": "Apache-2.0", "bsd-2-clause": "BSD-2-Clause", "bsd-3-clause": "BSD-3-Clause", "bsd-3": "BSD-3-Clause",
        "bsd-4-clause": "BSD-4-Clause", "zlib": "Zlib", "isc": "ISC", "bsl-1.0": "BSL-1.0", "mpl-2.0": "MPL-2.0", "curl": "curl", "libpng": "libpng-2.0",
        "cc0-1.0": "CC0-1.0", "0bsd": "0BSD", "psf": "PSF-2.0", "artistic": "Artistic-1.0-Perl", "apache-2": "Apache-2.0", "unlicense": "Unlicense",
        "bsd-4-clause-uc": "BSD-4-Clause-UC", "fsfullr": "FSFULLR"}


def spdx_id(*parts):
    return "SPDXRef-" + "-".join(re.sub(r"[^A-Za-z0-9.-]+", "-", part) for part in parts)


class Licences:
    """Translates names of licences, and collects those that SPDX does not know."""

    def __init__(self):
        self.own = {}

    def one(self, name, where):
        known = SPDX.get(name.lower())
        if known:
            return known
        own = "LicenseRef-" + re.sub(r"[^A-Za-z0-9.-]+", "-", name.replace("+", "-or-later")).strip("-")
        self.own.setdefault(own, {"licenseId": own, "name": name, "extractedText": f"See what {where} calls {name}."})
        return own

    def expression(self, text, where):
        """`GPL-2+ or MIT` -> `GPL-2.0-or-later OR MIT`; with exceptions it is a licence of its own."""
        if re.search(r"\bwith\b|,|;|/", text):
            return self.one(text, where)
        words = [word for word in re.split(r"\s+(and/or|and|or)\s+", text.strip())]
        if len(words) == 1:
            return self.one(words[0], where)
        return "(" + " ".join(word.upper() if word in ("and", "or") else self.one(word, where) for word in words) + ")"

    def of_copyright(self, text, where):
        """All licences that a machine-readable copyright file of Debian names."""
        if not text.startswith("Format:"):
            return "NOASSERTION"
        found = {re.sub(r"\s+", " ", name.strip()) for name in re.findall(r"^License:[ \t]*(\S.*)$", text, re.MULTILINE)}
        return " AND ".join(sorted({self.expression(name, where) for name in found})) or "NOASSERTION"


def paragraphs(text):
    for block in re.split(r"\n\s*\n", text):
        fields = dict(re.findall(r"^([A-Za-z-]+):[ \t]*(.*)$", block, re.MULTILINE))
        if fields:
            yield fields


def verification_code(root, files):
    """SPDX 2.3, 7.9: SHA-1 over the sorted SHA-1 of all files. Links have no content of their own."""
    sums = []
    for name in files:
        path = root / name.lstrip("/")
        if path.is_file() and not path.is_symlink():
            sums.append(hashlib.sha1(path.read_bytes()).hexdigest())
    return hashlib.sha1("".join(sorted(sums)).encode()).hexdigest(), len(sums)


def debian_package(name, version, architecture, licence, **more):
    purl = f"pkg:deb/debian/{name}@{urllib.parse.quote(version, safe='')}?arch={architecture}"
    return {"SPDXID": spdx_id("deb", name, architecture), "name": name, "versionInfo": version, "supplier": "Organization: Debian",
            "downloadLocation": "NOASSERTION", "filesAnalyzed": False, "licenseConcluded": "NOASSERTION", "licenseDeclared": licence,
            "copyrightText": "NOASSERTION",
            "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": purl}], **more}


def installed_packages(root, licences):
    info = root / "var/lib/dpkg/info"
    for fields in paragraphs((root / "var/lib/dpkg/status").read_text(encoding="utf-8")):
        if fields.get("Status") != "install ok installed":
            continue
        name, architecture = fields["Package"], fields["Architecture"]
        where = f"/usr/share/doc/{name}/copyright"
        file = root / where.lstrip("/")
        licence = licences.of_copyright(file.read_text(encoding="utf-8", errors="replace"), where) if file.is_file() else "NOASSERTION"
        listed = next((each for each in (info / f"{name}:{architecture}.list", info / f"{name}.list") if each.is_file()), None)
        code, count = verification_code(root, listed.read_text(encoding="utf-8").splitlines() if listed else [])
        verified = {"filesAnalyzed": True, "packageVerificationCode": {"packageVerificationCodeValue": code}} if count else {}
        yield debian_package(name, fields["Version"], architecture, licence, **verified)


def documented_licences(licences):
    """{package: licence} of docs/dependencies.md."""
    found = {}
    for line in (SOURCE / "docs/dependencies.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) > 4 and "-dev" in cells[1]:
            packages, names = cells[1].split(", "), cells[3].split(", ")
            for package, name in zip(packages, names if len(names) == len(packages) else [cells[3]] * len(packages)):
                found[package] = licences.expression(name, "docs/dependencies.md")
    return found


def build_packages(root, licences):
    file = root / "usr/share/doc/sightline/build_packages"
    documented = documented_licences(licences)
    for line in file.read_text(encoding="utf-8").splitlines() if file.is_file() else []:
        name, version, architecture = line.split("\t")
        yield debian_package(name, version, architecture, documented.get(name, "NOASSERTION"))


def npm_packages(folder):
    """What the page imports, and esbuild, which bundles it: (package, whether it is in the bundle)."""
    locked = json.loads((folder / "package-lock.json").read_text(encoding="utf-8"))["packages"]
    for name in json.loads((folder / "package.json").read_text(encoding="utf-8"))["dependencies"]:
        entry = locked[f"node_modules/{name}"]
        kind, _, digest = entry["integrity"].partition("-")
        yield {"SPDXID": spdx_id("npm", name), "name": name, "versionInfo": entry["version"], "filesAnalyzed": False,
               "downloadLocation": f"https://registry.npmjs.org/{name}/-/{name}-{entry['version']}.tgz",
               "checksums": [{"algorithm": kind.upper(), "checksumValue": base64.b64decode(digest).hex()}],
               "licenseConcluded": "NOASSERTION", "licenseDeclared": entry["license"], "copyrightText": "NOASSERTION",
               "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                 "referenceLocator": f"pkg:npm/{name}@{entry['version']}"}]}, name != "esbuild"


def document(root, with_page=True):
    licences = Licences()
    version = re.search(r"project\([^)]*VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    program = {"SPDXID": "SPDXRef-sightline", "name": "sightline", "versionInfo": version, "supplier": "NOASSERTION", "downloadLocation": "NOASSERTION",
               "filesAnalyzed": False, "licenseConcluded": "Apache-2.0", "licenseDeclared": "Apache-2.0", "copyrightText": "NOASSERTION",
               "primaryPackagePurpose": "CONTAINER",
               "checksums": [{"algorithm": "SHA256", "checksumValue": hashlib.sha256((root / "usr/local/bin/sightline").read_bytes()).hexdigest()}]}
    packages, relations = [program], [("SPDXRef-DOCUMENT", "DESCRIBES", program["SPDXID"])]
    for each in installed_packages(root, licences):
        packages.append(each)
        relations.append((program["SPDXID"], "CONTAINS", each["SPDXID"]))
    known = {each["SPDXID"] for each in packages}
    for each in build_packages(root, licences):
        relations.append((each["SPDXID"], "BUILD_DEPENDENCY_OF", program["SPDXID"]))
        if each["SPDXID"] not in known:
            packages.append(each)
    for each, bundled in npm_packages(SOURCE / "server/page/app") if with_page else []:
        packages.append(each)
        relations.append((program["SPDXID"], "CONTAINS", each["SPDXID"]) if bundled else (each["SPDXID"], "BUILD_TOOL_OF", program["SPDXID"]))
    digest = hashlib.sha256(json.dumps(packages, sort_keys=True).encode()).hexdigest()
    seconds = os.environ.get("SOURCE_DATE_EPOCH")
    time = datetime.datetime.fromtimestamp(int(seconds), datetime.timezone.utc) if seconds else datetime.datetime.now(datetime.timezone.utc)
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": f"sightline-{version}",
            "documentNamespace": f"https://sightline.invalid/spdx/sightline-{version}-{digest}",
            "creationInfo": {"created": time.strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: sightline-scripts/sbom.py"]},
            "packages": packages, "hasExtractedLicensingInfos": sorted(licences.own.values(), key=lambda each: each["licenseId"]),
            "relationships": [{"spdxElementId": a, "relationshipType": kind, "relatedSpdxElement": b} for a, kind, b in relations]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--without-page", action="store_true", help="the program was built without npm")
    parser.add_argument("-o", "--out", type=Path, help="default: standard output")
    arguments = parser.parse_args()
    text = json.dumps(document(arguments.root, not arguments.without_page), indent=1) + "\n"
    if arguments.out:
        arguments.out.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
