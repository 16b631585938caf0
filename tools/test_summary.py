# SPDX-License-Identifier: GPL-3.0-or-later
"""test_summary.py FOLDER SUITE...: counts the JUnit files (FOLDER/SUITE.xml) that ./run test left and prints what ran and what failed.

Exit code 1 if a test failed, or a suite ran nothing or left no file."""

import sys
import xml.etree.ElementTree as xml
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Suite:
    name: str
    passed: int = 0
    skipped: int = 0
    seconds: float = 0.0
    failed: list[str] = field(default_factory=list)
    reasons: dict[str, int] = field(default_factory=dict)  # why tests were skipped -> how many


def read_suite(path: Path) -> Suite:
    """One JUnit file as counts. An unreadable file is a failure: its suite died before it could write."""
    suite = Suite(path.stem)
    try:
        cases = list(xml.parse(path).iter("testcase"))
    except (OSError, xml.ParseError) as error:
        suite.failed.append(f"{path.name}: {error}")
        return suite
    for case in cases:
        suite.seconds += float(case.get("time") or 0)
        skipped = case.find("skipped")
        if case.find("failure") is not None or case.find("error") is not None or case.get("status") == "fail":
            suite.failed.append(f"{case.get('classname') or ''}::{case.get('name')}")
        elif skipped is not None or case.get("status") in {"notrun", "disabled"}:
            suite.skipped += 1
            reason = (skipped.get("message") if skipped is not None else None) or "not run"
            suite.reasons[reason] = suite.reasons.get(reason, 0) + 1
        else:
            suite.passed += 1
    return suite


def report(suites: list[Suite], folder: Path) -> bool:
    """Prints the table; true if every suite ran something and nothing failed."""
    print("\n| suite | passed | failed | skipped | seconds (sum) |\n|---|---|---|---|---|")
    for suite in suites:
        print(f"| {suite.name} | {suite.passed} | {len(suite.failed)} | {suite.skipped} | {suite.seconds:.0f} |")
    for suite in suites:
        for reason, count in sorted(suite.reasons.items()):
            print(f"skipped ({suite.name}): {count} x {reason}")
    for suite in suites:
        for name in suite.failed:
            print(f"FAILED ({suite.name}): {name}")
        if suite.passed + len(suite.failed) == 0:
            print(f"EMPTY: suite {suite.name} ran no test")
    passed, failed, skipped = (sum(counts) for counts in zip(*[(s.passed, len(s.failed), s.skipped) for s in suites], strict=True))
    print(f"Reports and pictures: {folder}")
    print(f"{passed} passed, {failed} failed, {skipped} skipped")
    return not failed and all(suite.passed for suite in suites)


if __name__ == "__main__":
    out = Path(sys.argv[1])
    sys.exit(0 if report([read_suite(out / f"{name}.xml") for name in sys.argv[2:]], out) else 1)
