#!/usr/bin/env python3
"""Holds the room table of ARCHITECTURE.md against the tree.

Usage: room_laws.py [ROOT]

The tables of ARCHITECTURE.md are the single source: which room and which folder of a room may
include which, and which library header may be included where. This script reads them and checks, over every tracked file
(every file, where there is no git):

  rooms      a source file lies in a room of the table, and each room of the table exists
  one way    the table has no cycle
  includes   a quoted #include is written from the root, names a file that exists, and goes from a
             room to itself or to one that the table allows
  sub-rooms  the folders of a room obey their table in the same way
  units      a folder of core, proto and server has at most 30 units: headers, each with its .cpp files
  parameters no function that a header of core, proto or server declares has eight parameters or more; the
             bodies of the kernels (-inl.h) are internal and may
  tests      each header of core, proto and server has a test of its name, or names its test in a line "// Tests: path"
  libraries  a library header appears only where the second table allows it
  links      the CMake targets of a room link only rooms that it may include
  citations  a paper cited by key ([Ize2013]) in a source or a page of docs/ has its entry in
             docs/REFERENCES.md
  packages   each package that scripts/install_packages.sh installs has a line in
             docs/dependencies.md
  routes     each route that the server adds has a row in docs/reference/routes.md, and each row its route
  pages      each link from a Markdown page leads to a file that is there, and to a heading of it.
             Links lead from README.md to each page of docs, and pages show each picture of docs/images
  version    CMakeLists.txt, proto/openapi.json, README.md and CHANGELOG.md have one version
  top level  nothing stands at the top but what ARCHITECTURE.md lists under "Top level"

Prints what was checked; exit code 0 when every law holds, 1 with one line per violation.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path, PurePosixPath

SOURCE_SUFFIXES = {".h", ".hpp", ".inl", ".c", ".cc", ".cpp"}
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"\n]+)"|<([^>\n]+)>)', re.MULTILINE)
# A dispatch library includes the file itself once more, under the name that this macro gives.
SELF_INCLUDE = re.compile(r'^[ \t]*#[ \t]*define[ \t]+HWY_TARGET_INCLUDE[ \t]+"([^"\n]+)"', re.MULTILINE)
ROOM_CALL = re.compile(r"\bsightline_room\s*\(\s*(\w+)([^)]*)\)")
LINK_CALL = re.compile(r"\btarget_link_libraries\s*\(\s*(sightline_\w+|sightline)\b([^)]*)\)")
CITATION = re.compile(r"\[([A-Z][A-Za-z]+\d{4})\](?!\()")
ROUTES = "docs/reference/routes.md"
UNITS_MOST = 30
UNITS_CHECKED = ("core/", "proto/", "server/")
TESTS_CHECKED = ("core/", "proto/", "server/")
PARAMETERS_MOST = 7
SKIPPED_FOLDERS = {"build", "__pycache__", "node_modules", "scratch"}


def room_named(word, rooms):
    """`base` is core/base, `http` is server/http."""
    return next((folder + word for folder in ("core/", "server/") if folder + word in rooms), word)


class Tables:
    """What ARCHITECTURE.md says. rooms: room -> rooms that it may include. folders: folder of a room
    -> folders of that room that it may include. libraries: header prefix -> rooms that may include
    it. top_level: names that may stand at the top."""

    def __init__(self, text):
        self.rooms = {}
        self.folders = {}
        self.libraries = {}
        self.top_level = []
        heading = ""
        rows = {}
        for line in text.splitlines():
            if line.startswith("#"):
                heading = line.lstrip("#").strip().lower()
            elif line.startswith("|") and not re.fullmatch(r"[|\s:-]+", line):
                rows.setdefault(heading, []).append([cell.strip() for cell in line.strip().strip("|").split("|")])
            elif heading == "top level":
                self.top_level += re.findall(r"`([^`]+)`", line)

        words = {cells[0].strip("`"): re.findall(r"\w+", cells[-1]) for cells in rows.get("rooms", [])[1:]}
        core = [room for room in words if room.startswith("core/")]
        for room, may in words.items():
            self.rooms[room] = set()
            for word in may:
                if word == "everything":
                    self.rooms[room] |= set(words)
                elif word == "core":
                    self.rooms[room] |= set(core)
                elif word != "nothing":
                    self.rooms[room].add(room_named(word, words))
        for cells in rows.get("sub-rooms", [])[1:]:
            self.folders[cells[0].strip("`")] = {word for word in re.findall(r"[\w/]+", cells[-1]) if word != "nothing"}
        for cells in rows.get("libraries", [])[1:]:
            for prefix in re.findall(r"`([^`]+)`", cells[0]):
                self.libraries[prefix] = set(re.findall(r"[\w/]+", cells[-1]))

    def room_of(self, path):
        """The room that holds this path, or None. `core/` itself is no room."""
        parts = PurePosixPath(path).parts
        for length in (2, 1):
            room = "/".join(parts[:length])
            if len(parts) > length and room in self.rooms:
                return room
        return None


def tracked_files(root):
    if (root / ".git").exists() and shutil.which("git"):
        listing = subprocess.run(
            ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            capture_output=True, text=True, check=False)
        if listing.returncode == 0:
            return sorted(name for name in listing.stdout.split("\0") if name and (root / name).is_file())
    found = []
    for folder, folders, names in os.walk(root):
        folders[:] = [f for f in folders if f not in SKIPPED_FOLDERS and f != ".git"]
        found += [(Path(folder) / name).relative_to(root).as_posix() for name in names]
    return sorted(found)


# Strings and characters come first, so that "*/*" and "http://" open no comment.
COMMENT = re.compile(r'("(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\')|//[^\n]*|/\*.*?\*/', re.DOTALL)


def without_comments(text):
    """Blanks comments and keeps line numbers."""
    return COMMENT.sub(lambda match: match.group(1) or re.sub(r"[^\n]", " ", match.group(0)), text)


def parameters_at(text, start):
    """The number of parameters in the list that begins at `start`, behind its parenthesis."""
    round_, other, angle, commas, at = 1, 0, 0, 0, start
    while at < len(text) and round_ > 0:
        letter = text[at]
        round_ += {"(": 1, ")": -1}.get(letter, 0)
        other += {"{": 1, "[": 1, "}": -1, "]": -1}.get(letter, 0)
        if letter == "<" and re.match(r"\w", text[at - 1]):
            angle += 1
        elif letter == ">" and text[at - 1] != "-":
            angle = max(0, angle - 1)
        commas += letter == "," and round_ == 1 and other == 0 and angle == 0
        at += 1
    return commas + 1 if text[start:at - 1].strip() else 0


def headings(text):
    """The anchors that a Markdown page offers, as GitHub makes them."""
    found = re.findall(r"^#+ +(.*?) *$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", each).lower()).replace(" ", "-") for each in found}


class Laws:
    def __init__(self, root):
        self.root = Path(root).resolve()
        self.tables = Tables((self.root / "ARCHITECTURE.md").read_text(encoding="utf-8"))
        self.files = tracked_files(self.root)
        self.violations = []
        self.counts = {"sources": 0, "includes": 0, "library includes": 0, "links": 0, "citations": 0, "packages": 0, "routes": 0, "page links": 0}
        self.links = {}
        references = self.root / "docs/REFERENCES.md"
        text = references.read_text(encoding="utf-8") if references.is_file() else ""
        self.known_papers = set(re.findall(r"^\*\*\[(\w+)\]\*\*", text, re.MULTILINE))

    def fault(self, place, sentence):
        self.violations.append(f"{place}: {sentence}")

    def check(self):
        if not self.tables.rooms:
            self.fault("ARCHITECTURE.md", 'no table under "## Rooms"')
            return self.violations
        self.check_table()
        self.check_top_level()
        self.check_units()
        self.check_parameters()
        self.check_tests()
        self.check_packages()
        self.check_routes()
        self.check_version()
        for name in self.files:
            path = PurePosixPath(name)
            if path.suffix in SOURCE_SUFFIXES:
                self.check_source(name)
                self.check_citations(name)
            elif path.name == "CMakeLists.txt" or path.suffix == ".cmake":
                self.check_links(name)
            elif path.suffix == ".md":
                self.check_page(name)
                if path.parts[0] == "docs":
                    self.check_citations(name)
        self.check_reachable()
        return self.violations

    def check_table(self):
        rooms = self.tables.rooms
        for room, may in rooms.items():
            for other in sorted(may - set(rooms)):
                self.fault("ARCHITECTURE.md", f"room {room} may include {other}, which is no room")
            if not (self.root / room).is_dir():
                self.fault("ARCHITECTURE.md", f"room {room} has no folder")
        for folder, may in self.tables.folders.items():
            if not (self.root / folder).is_dir() or self.tables.room_of(folder + "/x") is None:
                self.fault("ARCHITECTURE.md", f"sub-room {folder} is no folder of a room")
            for other in sorted(may):
                if other not in self.tables.folders or self.tables.room_of(other + "/x") != self.tables.room_of(folder + "/x"):
                    self.fault("ARCHITECTURE.md", f"sub-room {folder} may include {other}, which is no sub-room of its room")
        self.check_one_way("rooms", rooms)
        self.check_one_way("sub-rooms", self.tables.folders)

    def check_one_way(self, what, rooms):
        # Rooms that only include rooms already placed can be placed; what is left over is a cycle.
        # "everything" names the room itself, which is no cycle.
        placed = set()
        while True:
            ready = {r for r, may in rooms.items() if r not in placed and (may & set(rooms)) - {r} <= placed}
            if not ready:
                break
            placed |= ready
        if set(rooms) - placed:
            self.fault("ARCHITECTURE.md", f"{what} include each other in a circle: " + " ".join(sorted(set(rooms) - placed)))

    def check_units(self):
        units = {}
        for name in self.files:
            path = PurePosixPath(name)
            if path.suffix == ".h" and name.startswith(UNITS_CHECKED):
                units.setdefault(str(path.parent), set()).add(path.stem)
        for folder, names in sorted(units.items()):
            if len(names) > UNITS_MOST:
                self.fault(folder, f"has {len(names)} units; a folder has at most {UNITS_MOST}")

    def check_tests(self):
        names = {PurePosixPath(name).stem for name in self.files if name.startswith("tests/") and name.endswith((".cpp", ".py"))}
        for name in self.files:
            if not name.endswith(".h") or not name.startswith(TESTS_CHECKED):
                continue
            own = PurePosixPath(name).stem.removesuffix("-inl") + "_test"
            told = re.findall(r"^// Tests: (.*)$", (self.root / name).read_text(encoding="utf-8"), re.MULTILINE)
            for path in told:
                if not path.startswith("tests/") or not (self.root / path).is_file():
                    self.fault(name, f"names {path}, which is no test")
            if not told and own not in names:
                self.fault(name, f'has no test {own} and no line "// Tests: path"')

    def check_parameters(self):
        for name in self.files:
            if not name.startswith(UNITS_CHECKED) or not name.endswith(".h") or name.endswith("-inl.h"):
                continue
            text = without_comments((self.root / name).read_text(encoding="utf-8"))
            for match in re.finditer(r"\b(\w+)\s*\(", text):
                count = parameters_at(text, match.end())
                if count > PARAMETERS_MOST:
                    place = f"{name}:{text.count(chr(10), 0, match.start()) + 1}"
                    self.fault(place, f"{match.group(1)} has {count} parameters; a function has at most {PARAMETERS_MOST}")

    def check_top_level(self):
        allowed = set(self.tables.top_level)
        for top in sorted({PurePosixPath(name).parts[0] for name in self.files}):
            if not top.startswith(".") and top not in allowed:
                self.fault(top, 'stands at the top level and is not listed in ARCHITECTURE.md under "Top level"')

    def check_packages(self):
        script = self.root / "scripts/install_packages.sh"
        if not script.is_file():
            return
        groups = re.findall(r'^(\w+)="', script.read_text(encoding="utf-8"), re.MULTILINE)
        listing = subprocess.run(["bash", str(script), "--print", *groups], capture_output=True, text=True, check=True)
        known = set(re.findall(r"[\w.+-]+", (self.root / "docs/dependencies.md").read_text(encoding="utf-8")))
        for package in listing.stdout.split():
            self.counts["packages"] += 1
            if package not in known:
                self.fault("scripts/install_packages.sh", f"installs {package}, which docs/dependencies.md does not explain")

    def check_routes(self):
        page = self.root / ROUTES
        if not page.is_file():
            return
        table = re.search(r"^## Routes$(.*?)^## ", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
        rows = [row.split("|")[1] for row in (table.group(1) if table else "").splitlines() if row.startswith("|")]
        told = set(re.findall(r"(/[^\s`]*)", " ".join(rows)))
        added = {}
        for name in self.files:
            if name.startswith("server/") and name.endswith(".cpp"):
                text = without_comments((self.root / name).read_text(encoding="utf-8", errors="replace"))
                for path in re.findall(r'\badd\(\s*"[A-Z]+",\s*"(/[^"]*)"', text):
                    added[path] = name
        self.counts["routes"] += len(added)
        for path in sorted(set(added) - told):
            self.fault(added[path], f"adds the route {path}, which {ROUTES} does not list under Routes")
        for path in sorted(told - set(added)):
            self.fault(ROUTES, f"lists the route {path}, which the server does not add")

    def check_version(self):
        places = {"CMakeLists.txt": r"^project\(\w+ VERSION ([0-9.]+)", "proto/openapi.json": r'^ *"version": "([0-9.]+)"',
                  "README.md": r"^Version ([0-9.]+),", "CHANGELOG.md": r"^## ([0-9.]+)"}
        found = {}
        for name, pattern in places.items():
            if name in self.files:
                match = re.search(pattern, (self.root / name).read_text(encoding="utf-8"), re.MULTILINE)
                found[name] = match[1] if match else None
        for name, version in found.items():
            if version != found.get("CMakeLists.txt"):
                self.fault(name, f"has the version {version}, and CMakeLists.txt has {found.get('CMakeLists.txt')}")

    def check_source(self, name):
        self.counts["sources"] += 1
        room = self.tables.room_of(name)
        if room is None:
            self.fault(name, "lies in no room of the table")
            return
        text = without_comments((self.root / name).read_text(encoding="utf-8", errors="replace"))
        for match in INCLUDE.finditer(text):
            place = f"{name}:{text.count(chr(10), 0, match.end()) + 1}"
            if match.group(1):
                self.check_include(place, room, match.group(1))
            self.check_library(place, room, match.group(1) or match.group(2))
        for match in SELF_INCLUDE.finditer(text):
            if match.group(1) != name:
                self.fault(name, f'HWY_TARGET_INCLUDE names "{match.group(1)}", not this file')

    def check_include(self, place, room, target):
        self.counts["includes"] += 1
        if not (self.root / target).is_file():
            self.fault(place, f'"{target}" is not a file, seen from the root (libraries are included with <>)')
            return
        other = self.tables.room_of(target)
        if other is None:
            self.fault(place, f'"{target}" lies in no room')
        elif other != room and other not in self.tables.rooms[room]:
            may = " ".join(sorted(self.tables.rooms[room])) or "nothing"
            self.fault(place, f"room {room} includes {other}; it may include: {may}")
        elif other == room:
            self.check_folders(place, str(PurePosixPath(place).parent), str(PurePosixPath(target).parent))

    def check_folders(self, place, folder, other):
        folders = self.tables.folders
        if folder == other or (folder not in folders and other not in folders):
            return
        for each in (folder, other):
            if each not in folders:
                self.fault(place, f"{each} is no sub-room of the table")
                return
        if other not in folders[folder]:
            may = " ".join(sorted(folders[folder])) or "nothing"
            self.fault(place, f"{folder} includes {other}; it may include: {may}")

    def check_library(self, place, room, header):
        for prefix, allowed in self.tables.libraries.items():
            if header.startswith(prefix):
                self.counts["library includes"] += 1
                if room not in allowed:
                    self.fault(place, f"room {room} includes <{header}>; only these may: {' '.join(sorted(allowed))}")

    def check_reachable(self):
        """Links lead from README.md to each page of docs."""
        reached, left = set(), ["README.md"]
        while left:
            name = left.pop()
            if name not in reached:
                reached.add(name)
                left += self.links.get(name, ())
        for name in self.links if "README.md" in self.links else ():
            if name.startswith("docs/") and name not in reached:
                self.fault(name, "no link leads here from README.md")
        shown = set().union(*self.links.values())
        for name in self.files if "README.md" in self.links else ():
            if name.startswith("docs/images/") and name not in shown:
                self.fault(name, "no page shows this picture")

    def check_page(self, name):
        self.links[name] = set()
        text = re.sub(r"^```.*?^```", "", (self.root / name).read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        text = re.sub(r"`[^`\n]*`", "", re.sub(r"^ {4}.*$", "", text, flags=re.MULTILINE))
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"[a-z]+:", target):
                continue
            self.counts["page links"] += 1
            path, _, heading = target.partition("#")
            file = (self.root / name).parent / path if path else self.root / name
            self.links[name].add(os.path.relpath(file, self.root))
            if not file.exists():
                self.fault(name, f"links to {target}, which is not there")
            elif heading and heading not in headings(file.read_text(encoding="utf-8")):
                self.fault(name, f"links to {target}, which has no such heading")

    def check_citations(self, name):
        for number, line in enumerate((self.root / name).read_text(encoding="utf-8", errors="replace").splitlines(), 1):
            for key in CITATION.findall(line):
                self.counts["citations"] += 1
                if key not in self.known_papers:
                    self.fault(f"{name}:{number}", f"cites [{key}], which has no entry in docs/REFERENCES.md")

    def check_links(self, name):
        room = self.tables.room_of(name)
        if room is None or room == "tests":
            return
        text = re.sub(r"#[^\n]*", "", (self.root / name).read_text(encoding="utf-8", errors="replace"))
        words = []
        for match in ROOM_CALL.finditer(text):
            rooms = re.search(r"\bROOMS\b((?:\s+(?!(?:SOURCES|LIBRARIES)\b)[\w:]+)*)", match.group(2))
            words += rooms.group(1).split() if rooms else []
        for match in LINK_CALL.finditer(text):
            words += [word[len("sightline_"):] for word in re.findall(r"\bsightline_\w+", match.group(2))]
        for word in words:
            other = room_named(word, self.tables.rooms)
            if other not in self.tables.rooms:
                continue
            self.counts["links"] += 1
            if other != room and other not in self.tables.rooms[room]:
                self.fault(name, f"room {room} links {other}, which it may not include")
        for library in re.findall(r"\b(?:embree|gmp|gmpxx|gtest|benchmark)\b", text, re.IGNORECASE):
            self.fault(name, f"room {room} names {library}, which only tests may link")


def main(arguments):
    root = Path(arguments[1]) if len(arguments) > 1 else Path(__file__).resolve().parents[2]
    laws = Laws(root)
    violations = laws.check()
    for violation in violations:
        print(violation)
    print(f"{len(laws.tables.rooms)} rooms, {len(laws.files)} files, "
          + ", ".join(f"{count} {what}" for what, count in laws.counts.items())
          + f": {len(violations)} violations")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
