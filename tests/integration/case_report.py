"""Runs the unittest cases of the calling script and says what came of them.

Prints "N passed, N failed[, N skipped]" alone on the last line. Where $GTEST_OUTPUT asks for reports
("xml:FOLDER/"), leaves one of GoogleTest's form there, so that scripts/summarise_tests.py counts
these cases like all others.
"""

import os
import sys
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path


class Cases(unittest.TextTestResult):
    """Remembers (class, case, "passed" | "failed" | "skipped", message)."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.cases = []

    def note(self, test, outcome, message=""):
        name = getattr(test, "_testMethodName", str(test)).removeprefix("test_")
        self.cases.append((type(test).__name__, name, outcome, message))

    def addSuccess(self, test):
        super().addSuccess(test)
        self.note(test, "passed")

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self.note(test, "failed", str(err[1]))

    def addError(self, test, err):
        super().addError(test, err)
        self.note(test, "failed", f"{err[0].__name__}: {err[1]}")

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        self.note(test, "skipped", reason)

    def addSubTest(self, test, subtest, err):
        super().addSubTest(test, subtest, err)
        if err is not None:
            self.note(test, "failed", f"{subtest}: {err[1]}")


def write_report(cases, file):
    suites = ElementTree.Element("testsuites")
    suite = ElementTree.SubElement(suites, "testsuite")
    for classname, name, outcome, message in cases:
        case = ElementTree.SubElement(suite, "testcase", classname=classname, name=name, status="run",
                                      result="completed")
        if outcome != "passed":
            ElementTree.SubElement(case, "failure" if outcome == "failed" else "skipped", message=message)
    file.parent.mkdir(parents=True, exist_ok=True)
    ElementTree.ElementTree(suites).write(file, encoding="utf-8")


def main():
    """The script's arguments are the binary under test, then names of cases for unittest."""
    names = [sys.argv[0]] + sys.argv[2:]
    program = unittest.main(module="__main__", argv=names, exit=False, verbosity=2,
                            testRunner=unittest.TextTestRunner(resultclass=Cases, verbosity=2))
    cases = program.result.cases
    output = os.environ.get("GTEST_OUTPUT", "")
    if output.startswith("xml:") and output.endswith("/"):
        name = "integration_" + Path(sys.argv[0]).stem.removesuffix("_test")
        write_report(cases, Path(output.removeprefix("xml:")) / f"{name}.xml")
    count = {"passed": 0, "failed": 0, "skipped": 0}
    for _, _, outcome, _ in cases:
        count[outcome] += 1
    tail = f", {count['skipped']} skipped" if count["skipped"] else ""
    print(f"{count['passed']} passed, {count['failed']} failed{tail}", flush=True)
    sys.exit(0 if count["failed"] == 0 and count["passed"] > 0 else 1)
