#!/usr/bin/env python3
"""The closing line of scripts/test.sh under test: made-up reports in, figures and exit code out."""

import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import summarise_tests

PASS = '<testcase name="{}" status="run"><system-out></system-out></testcase>'
FAIL = '<testcase name="{}" status="fail"><failure message=""/><system-out></system-out></testcase>'
SKIP = '''<testcase name="{}" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/>
<system-out>SKIPPED: no tool</system-out></testcase>'''
ABSENT = '''<testcase name="{}" status="notrun"><skipped message="Unable to find executable"/>
<system-out>Unable to find executable: x</system-out></testcase>'''

CASES = '''<testsuites><testsuite name="Box">
<testcase name="hits" status="run" result="completed" classname="Box"/>
<testcase name="misses" status="run" result="completed" classname="Box">{}</testcase>
<testcase name="switched_off" status="notrun" result="suppressed" classname="Box"/>
</testsuite></testsuites>'''
CASE_FAILURE = '<failure message="box_test.cpp:7&#x0A;Expected: 1" type=""><![CDATA[x]]></failure>'
CASE_SKIP = '<skipped message="box_test.cpp:7&#x0A;no scenes here"><![CDATA[x]]></skipped>'


class Summary(unittest.TestCase):
    def summary(self, entries, cases=None):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "ctest.xml").write_text(f"<testsuite>{''.join(entries)}</testsuite>")
            (Path(folder) / "cases").mkdir()
            for program, text in (cases or {}).items():
                (Path(folder) / "cases" / f"{program}.xml").write_text(text)
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                code = summarise_tests.main(["", f"dev={folder}"])
            return code, printed.getvalue().splitlines()

    def test_cases_are_counted_where_there_is_a_report_and_entries_elsewhere(self):
        code, lines = self.summary([PASS.format("box_test"), PASS.format("law")], {"box_test": CASES.format("")})
        self.assertEqual((code, lines[-1]), (0, "3 passed, 0 failed"))

    def test_a_failed_case_is_counted_once(self):
        code, lines = self.summary([FAIL.format("box_test")], {"box_test": CASES.format(CASE_FAILURE)})
        self.assertEqual((code, lines[-1]), (1, "1 passed, 1 failed"))
        self.assertIn("FAILED dev/box_test: Box.misses: Expected: 1", lines)

    def test_a_skipped_case_keeps_its_reason(self):
        code, lines = self.summary([PASS.format("box_test")], {"box_test": CASES.format(CASE_SKIP)})
        self.assertEqual((code, lines[-1]), (0, "1 passed, 0 failed, 1 skipped"))
        self.assertIn("SKIPPED dev/box_test: Box.misses: no scenes here", lines)

    def test_a_skipped_entry_keeps_its_reason(self):
        code, lines = self.summary([PASS.format("a"), SKIP.format("law")])
        self.assertEqual((code, lines[-1]), (0, "1 passed, 0 failed, 1 skipped"))
        self.assertIn("SKIPPED dev/law: SKIPPED: no tool", lines)

    def test_a_crash_before_the_report_is_a_failure(self):
        self.assertEqual(self.summary([FAIL.format("box_test")])[1][-1], "0 passed, 1 failed")

    def test_a_leak_after_green_cases_is_a_failure(self):
        code, lines = self.summary([FAIL.format("box_test")], {"box_test": CASES.format("")})
        self.assertEqual((code, lines[-1]), (1, "2 passed, 1 failed"))

    def test_a_program_that_was_not_built_is_a_failure(self):
        code, lines = self.summary([PASS.format("a"), ABSENT.format("box_test")])
        self.assertEqual((code, lines[-1]), (1, "1 passed, 1 failed"))

    def test_nothing_at_all_is_no_success(self):
        self.assertEqual(self.summary([])[0], 1)
        self.assertEqual(self.summary([SKIP.format("law")])[0], 1)


if __name__ == "__main__":
    unittest.main()
