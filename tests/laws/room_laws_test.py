#!/usr/bin/env python3
"""The laws themselves under test: small trees, each with one violation, must fail with its place."""

import tempfile
import unittest
from pathlib import Path

import room_laws

ARCHITECTURE = """# A house

## Rooms

| room | what lives there | may include |
|---|---|---|
| core/base | words | nothing |
| core/scene | scenes | base |
| proto | codecs | base |
| server | http | core proto |
| tests | tests | everything |

## Libraries

| header | only in |
|---|---|
| `embree3/`, `gmp` | tests |
| `httplib.h` | server, tests |

## Top level

`core` `proto` `server` `tests` `docs` `ARCHITECTURE.md`

## Sub-rooms

| sub-room | what lives there | may include |
|---|---|---|
| proto | fields | nothing |
| proto/json | text | proto |
"""

GOOD = {
    "core/base/result.h": "#pragma once\n#include <string>\n",
    "core/scene/scene.h": '#include "core/base/result.h"\n// #include "server/server.h" is not an include\n',
    "core/scene/CMakeLists.txt": "sightline_room(scene SOURCES scene.cpp ROOMS base LIBRARIES fmt::fmt)\n",
    "proto/rays.cpp": '#include "core/base/result.h"\n',
    "proto/json/rays.cpp": '#include "proto/rays.cpp"\n',
    "docs/REFERENCES.md": "**[Ize2013]** T. Ize.\n",
    "core/base/cited.h": "/// See [Ize2013] eq. 3.\n",
    "server/server.h": '#include <httplib.h>\n#include "core/scene/scene.h"\n#include "proto/rays.cpp"\n',
    "tests/unit/a_test.cpp": '#include <embree3/rtcore.h>\n#include "server/server.h"\n',
}


class RoomLaws(unittest.TestCase):
    def violations(self, changes=None, architecture=ARCHITECTURE, tested=True):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for name, text in {**GOOD, "ARCHITECTURE.md": architecture, **(changes or {})}.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                if name.endswith(".h") and tested:
                    text += "\n// Tests: tests/unit/a_test.cpp\n"
                (root / name).write_text(text, encoding="utf-8")
            return room_laws.Laws(root).check()

    def assert_fault(self, violations, *words):
        self.assertEqual(len(violations), 1, violations)
        for word in words:
            self.assertIn(word, violations[0])

    def test_a_tree_that_keeps_the_laws_passes(self):
        self.assertEqual(self.violations(), [])

    def test_an_include_against_the_table_is_named_with_file_and_line(self):
        faults = self.violations({"core/base/bad.h": '\n#include "core/scene/scene.h"\n'})
        self.assert_fault(faults, "core/base/bad.h:2", "core/base includes core/scene")

    def test_a_function_with_eight_parameters_is_named(self):
        seven = "void f(int a, std::map<int, int> b, int c[2], F<a, b> d, int e = g(1, 2), int h, int i"
        self.assertEqual(self.violations({"core/base/seven.h": seven + ");\n", "core/base/body-inl.h": seven + ", int j);\n"}), [])
        faults = self.violations({"core/base/eight.h": "\n" + seven + ", int j);\n"})
        self.assert_fault(faults, "core/base/eight.h:2", "f has 8 parameters")

    def test_an_include_inside_an_if_counts_too(self):
        faults = self.violations({"proto/bad.h": '#if 0\n  #  include "core/scene/scene.h"\n#endif\n'})
        self.assert_fault(faults, "proto/bad.h:2", "proto includes core/scene")

    def test_an_include_against_the_table_of_sub_rooms_is_named(self):
        faults = self.violations({"proto/bad.h": '#include "proto/json/rays.cpp"\n'})
        self.assert_fault(faults, "proto/bad.h:1", "proto includes proto/json; it may include: nothing")

    def test_a_folder_that_is_no_sub_room_fails(self):
        faults = self.violations({"proto/text/bad.h": '#include "proto/rays.cpp"\n'})
        self.assert_fault(faults, "proto/text/bad.h:1", "proto/text is no sub-room")

    def test_a_circle_of_sub_rooms_fails(self):
        circle = ARCHITECTURE.replace("| proto | fields | nothing |", "| proto | fields | proto/json |")
        self.assert_fault(self.violations(architecture=circle), "sub-rooms include each other in a circle: proto proto/json")

    def test_a_folder_of_too_many_units_fails(self):
        self.assertEqual(self.violations({f"proto/json/unit{i}.h": "" for i in range(30)}), [])
        faults = self.violations({f"proto/json/unit{i}.h": "" for i in range(31)})
        self.assert_fault(faults, "proto/json: has 31 units")

    def test_a_unit_without_a_test_fails(self):
        faults = self.violations({"proto/a.h": ""}, tested=False)
        self.assertEqual([fault.split(":")[0] for fault in faults], ["core/base/cited.h", "core/base/result.h", "core/scene/scene.h", "server/server.h"])
        self.assert_fault(self.violations({"proto/b.h": "// Tests: tests/unit/none_test.cpp\n"}), "proto/b.h: names tests/unit/none_test.cpp")

    def test_a_comment_opener_in_a_string_hides_no_include(self):
        faults = self.violations({"proto/bad.h": 'auto a = "*/*";\n#include "core/scene/scene.h"\nauto b = "*/*";\n'})
        self.assert_fault(faults, "proto/bad.h:2", "proto includes core/scene")

    def test_a_file_in_no_room_fails(self):
        self.assert_fault(self.violations({"core/stray.h": ""}), "core/stray.h", "no room")
        self.assert_fault(self.violations({"core/extra/stray.h": ""}), "core/extra/stray.h", "no room")

    def test_an_include_that_is_not_written_from_the_root_fails(self):
        self.assert_fault(self.violations({"core/scene/bad.h": '#include "scene.h"\n'}), "bad.h:1", "root")

    def test_embree_and_gmp_stay_in_tests(self):
        self.assert_fault(self.violations({"core/scene/bad.h": "#include <embree3/rtcore.h>\n"}), "embree3")
        self.assert_fault(self.violations({"server/bad.h": "#include <gmpxx.h>\n"}), "gmpxx")
        self.assert_fault(
            self.violations({"server/CMakeLists.txt": "find_package(embree 3)\n"}), "server/CMakeLists.txt", "embree")

    def test_http_stays_in_the_server(self):
        self.assert_fault(self.violations({"proto/bad.h": "#include <httplib.h>\n"}), "proto", "httplib.h")

    def test_a_link_against_the_table_fails(self):
        bad = {"core/base/CMakeLists.txt": "sightline_room(base SOURCES a.cpp ROOMS scene LIBRARIES x)\n"}
        self.assert_fault(self.violations(bad), "core/base/CMakeLists.txt", "links core/scene")
        bad = {"proto/CMakeLists.txt": "target_link_libraries(sightline_proto PUBLIC sightline_scene)\n"}
        self.assert_fault(self.violations(bad), "proto/CMakeLists.txt", "links core/scene")

    def test_a_paper_that_is_cited_without_an_entry_fails(self):
        faults = self.violations({"core/base/bad.h": "\n// From [Nobody2001], section 2.\n"})
        self.assert_fault(faults, "core/base/bad.h:2", "Nobody2001")

    def test_a_package_that_nothing_explains_fails(self):
        script = 'build="g++ libsecret-dev"\n[ "$1" = --print ] && printf "%s\\n" $build\n'
        faults = self.violations({"scripts/install_packages.sh": script, "docs/dependencies.md": "g++\n"},
                                 ARCHITECTURE.replace("`docs`", "`docs` `scripts`"))
        self.assert_fault(faults, "installs libsecret-dev")

    def test_routes_and_their_rows_in_the_reference_agree(self):
        server = {"server/routes.cpp": 'router.add("GET", "/readyz", reply);\nrouter.add("POST",\n  "/v1/x:any", any);\n'}
        page = "# S\n\n## Routes\n\n| request | answer |\n|---|---|\n| `GET /readyz` `{}` | ready |\n\n## More\n"
        self.assertEqual(self.violations({**server, room_laws.ROUTES: page.format("/v1/x:any")}), [])
        faults = self.violations({**server, room_laws.ROUTES: page.format("/readyz")})
        self.assert_fault(faults, "server/routes.cpp", "/v1/x:any")
        faults = self.violations({**server, room_laws.ROUTES: page.format("/v1/x:any` `/gone")})
        self.assert_fault(faults, room_laws.ROUTES, "/gone")

    def test_a_link_to_a_page_or_heading_that_is_not_there_fails(self):
        pages = {"docs/a.md": "# A page\n\n[b](b.md#the-end-of-b) [here](#a-page) [web](https://example.org/x) `[x](y)`\n",
                 "docs/b.md": "# B\n\n## The end of `b`\n"}
        self.assertEqual(self.violations(pages), [])
        self.assert_fault(self.violations({**pages, "docs/c.md": "[a](../a.md)\n"}), "docs/c.md", "../a.md")
        self.assert_fault(self.violations({**pages, "docs/c.md": "[b](b.md#start)\n"}), "docs/c.md", "b.md#start")

    def test_a_page_without_a_way_from_the_readme_fails(self):
        pages = {"README.md": "[a](docs/a.md) [papers](docs/REFERENCES.md)\n", "docs/a.md": "[b](b.md)\n", "docs/b.md": "B\n"}
        listed = ARCHITECTURE.replace("`docs` ", "`docs` `README.md` ")
        self.assertEqual(self.violations(pages, listed), [])
        self.assert_fault(self.violations({**pages, "docs/c.md": "[a](a.md)\n"}, listed), "docs/c.md", "no link leads here")
        self.assert_fault(self.violations({**pages, "docs/images/d.png": ""}, listed), "docs/images/d.png", "no page shows")

    def test_a_version_that_differs_fails(self):
        files = {"CMakeLists.txt": "project(house VERSION 1.2.3 LANGUAGES CXX)\n", "proto/openapi.json": '{"info":{\n  "version": "1.2.3"}}\n'}
        listed = ARCHITECTURE.replace("`docs` ", "`docs` `CHANGELOG.md` `CMakeLists.txt` ")
        self.assertEqual(self.violations({**files, "CHANGELOG.md": "## 1.2.3, 2026-01-02\n"}, listed), [])
        self.assert_fault(self.violations({**files, "CHANGELOG.md": "## 1.2.4\n"}, listed), "CHANGELOG.md", "1.2.4", "1.2.3")

    def test_a_circle_in_the_table_fails(self):
        circular = ARCHITECTURE.replace("| words | nothing |", "| words | scene |")
        faults = self.violations(architecture=circular)
        self.assertTrue(any("circle" in fault for fault in faults), faults)

    def test_a_room_without_a_folder_fails(self):
        more = ARCHITECTURE.replace("| proto | codecs", "| core/store | scenes | base |\n| proto | codecs")
        self.assert_fault(self.violations(architecture=more), "core/store", "no folder")

    def test_a_stray_entry_at_the_top_fails(self):
        self.assert_fault(self.violations({"notes.txt": ""}), "notes.txt", "top level")

    def test_a_table_that_cannot_be_found_fails(self):
        self.assert_fault(self.violations(architecture="# A house\n"), "no table")


if __name__ == "__main__":
    unittest.main()
