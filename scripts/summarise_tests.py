#!/usr/bin/env python3
"""Counts test results. Usage: summarise_tests.py PRESET=FOLDER...

FOLDER holds ctest.xml (ctest --output-junit) and cases/*.xml, one per GoogleTest program. A program
that left a report counts by its cases, any other ctest entry counts as one. A program that ctest
calls failed although no case failed (a crash, a leak, a data race) counts as one failure more.

Prints failures and skips with their reasons, then "N passed, N failed[, N skipped]" alone on the
last line. Exit code 0 only if nothing failed and something passed.
"""

import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path


def gtest_cases(file):
    """(name, "passed" | "failed" | "skipped", reason) for each case of one GoogleTest report."""
    for case in ElementTree.parse(file).getroot().iter("testcase"):
        name = f"{case.get('classname')}.{case.get('name')}"
        if case.get("status") == "notrun":
            continue  # disabled by name or by a filter
        failure, skipped = case.find("failure"), case.find("skipped")
        if failure is not None:
            yield name, "failed", failure.get("message", "")
        elif skipped is not None or case.get("result") == "skipped":
            yield name, "skipped", "" if skipped is None else skipped.get("message", "")
        else:
            yield name, "passed", ""


def reason_of(entry):
    """The line of a ctest entry's output that says why it was skipped."""
    output = entry.findtext("system-out") or ""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    said = [line for line in lines if "skip" in line.lower()]
    return (said or lines or ["no reason given"])[-1]


def results(folder):
    cases = {file.stem: list(gtest_cases(file)) for file in sorted((folder / "cases").glob("*.xml"))}
    for entry in ElementTree.parse(folder / "ctest.xml").getroot().iter("testcase"):
        name, status = entry.get("name"), entry.get("status")
        own = cases.get(name, [])
        yield from ((f"{name}: {case}", outcome, reason) for case, outcome, reason in own)
        if status == "fail":
            if not any(outcome == "failed" for _, outcome, _ in own):
                yield name, "failed", "the program failed outside its cases; see its output above"
        elif status == "notrun" and "SKIP_" not in entry.find("skipped").get("message", ""):
            yield name, "failed", "did not run: " + reason_of(entry)
        elif status in ("notrun", "disabled"):
            yield name, "skipped", reason_of(entry)
        elif not own:
            yield name, "passed", ""


def one_line(text):
    """Without the file:line that GoogleTest puts first."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if len(lines) > 1 and lines[0].rsplit(":", 1)[-1].isdigit():
        lines = lines[1:]
    return " ".join(lines)[:300] or "no reason given"


def main(arguments):
    count = {"passed": 0, "failed": 0, "skipped": 0}
    told = {"failed": [], "skipped": []}
    for argument in arguments[1:]:
        preset, folder = argument.split("=", 1)
        for name, outcome, reason in results(Path(folder)):
            count[outcome] += 1
            if outcome in told:
                told[outcome].append((f"{preset}/{name}", one_line(reason)))
    for outcome, word in (("skipped", "SKIPPED"), ("failed", "FAILED")):
        for name, reason in told[outcome]:
            print(f"{word} {name}: {reason}")
    print()
    tail = f", {count['skipped']} skipped" if count["skipped"] else ""
    print(f"{count['passed']} passed, {count['failed']} failed{tail}")
    return 0 if count["failed"] == 0 and count["passed"] > 0 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv))
