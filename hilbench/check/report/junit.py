"""The report for a CI system: JUnit XML, one test case for each clause.

=================  =====================================================================================
verdict            in JUnit XML
=================  =====================================================================================
pass               a test case without children
fail               ``<failure>``
fail of a should   ``<skipped>`` whose message begins with "warning"; ``<failure>`` with ``--strict``
inconclusive       ``<error type="inconclusive">``; of a should ``<skipped>``, unless ``--strict``
error              ``<error type="error">``
not applicable     ``<skipped>`` with the missing capability
not run            ``<error type="not-run">``: a run that was cut short is not green
=================  =====================================================================================

Clause, level, source, verdict and cause are properties of each test case; seed, run hash and the parts of the bench
are properties of the suite. The picture of the screen at the moment a clause failed is a property too, and an
attachment, as GitLab and the Jenkins plugin "JUnit Attachments" read it: ``[[ATTACHMENT|FILE]]`` in ``<system-out>``.
Of a clause that was judged by the target's own report alone that stands there, too, in a property and before the cause.
That of a suite has what there is to note of the firmware of emulated boards.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import groupby
from xml.etree import ElementTree as ET

from hilbench.check.report import footer
from hilbench.check.results import ClauseResult, Report
from hilbench.files.names import escaped
from hilbench.judging.verdicts import Verdict

# What XML 1.0 cannot hold, not even as a character reference.
_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit_xml(report: Report) -> str:
    """Return the report as JUnit XML."""
    root = ET.Element("testsuites", name="hilbench")
    for suite, clauses in groupby(report.clauses, key=lambda clause: clause.suite):
        _add_suite(root, report, suite, list(clauses))
    _sum_up(root, root.findall("testsuite"))
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _add_suite(root: ET.Element, report: Report, suite: str, clauses: Sequence[ClauseResult]) -> None:
    element = ET.SubElement(root, "testsuite", name=suite)
    facts = {**report.bench, "seed": str(report.seed), "run_hash": report.run_hash or "", "stopped": report.stopped}
    _add_properties(element, {"hilbench": report.hilbench, **facts})
    for clause in clauses:
        _add_clause(element, clause)
    if notes := footer.lines_of_notes(report, suite):
        ET.SubElement(element, "system-out").text = _clean("\n".join(notes))
    cases = element.findall("testcase")
    element.set("tests", str(len(cases)))
    for kind, attribute in (("failure", "failures"), ("error", "errors"), ("skipped", "skipped")):
        element.set(attribute, str(sum(case.find(kind) is not None for case in cases)))
    element.set("time", f"{sum(clause.bench_time_s for clause in clauses):.6f}")


def _add_clause(suite: ET.Element, clause: ClauseResult) -> None:
    name = _clean(f"{clause.id} {clause.title}")
    element = ET.SubElement(suite, "testcase", classname=clause.suite, name=name, time=f"{clause.bench_time_s:.6f}")
    facts = {
        "clause": clause.id,
        "level": clause.level,
        "source": clause.source,
        "verdict": clause.verdict.value,
        "cause": clause.cause,
        "cases": ", ".join(clause.case_ids),
        "verdict_cases": ", ".join(clause.verdict_case_ids),
        "reproduce": clause.reproduce,
        **({"by_own_report": ", ".join(clause.by_own_report)} if clause.by_own_report else {}),
        **({"screen": clause.screen} if clause.screen else {}),
        **({"reruns": str(clause.reruns)} if clause.reruns else {}),
    }
    _add_properties(element, facts)
    child = _child_for(clause)
    if child is not None:
        tag, kind, message = child
        verdict = ET.SubElement(element, tag, type=kind, message=_clean(clause.mark + message))
        if clause.evidence:
            verdict.text = _clean("\n".join([clause.text, clause.source, *clause.evidence]))
    said = [f"{clause.mark}nobody saw {', '.join(clause.by_own_report)}"] if clause.by_own_report else []
    said += [f"[[ATTACHMENT|{clause.screen}]]"] if clause.screen else []
    if said:
        ET.SubElement(element, "system-out").text = _clean("\n".join(said))


def _child_for(clause: ClauseResult) -> tuple[str, str, str] | None:
    verdict = clause.verdict
    if verdict is Verdict.PASS:
        return None
    if verdict is Verdict.NOT_APPLICABLE:
        return "skipped", verdict.value, f"not applicable: {clause.cause}"
    if verdict in {Verdict.FAIL, Verdict.INCONCLUSIVE} and not clause.counts:
        return "skipped", verdict.value, f"warning: {clause.cause}"
    return "failure" if verdict is Verdict.FAIL else "error", verdict.value, clause.cause


def _add_properties(element: ET.Element, facts: Mapping[str, str]) -> None:
    properties = ET.SubElement(element, "properties")
    for name, value in facts.items():
        ET.SubElement(properties, "property", name=name, value=_clean(value))


def _sum_up(root: ET.Element, suites: Sequence[ET.Element]) -> None:
    for attribute in ("tests", "failures", "errors", "skipped"):
        root.set(attribute, str(sum(int(suite.get(attribute, "0")) for suite in suites)))
    root.set("time", f"{sum(float(suite.get('time', '0')) for suite in suites):.6f}")


def _clean(text: str) -> str:
    return _NOT_XML.sub("\ufffd", escaped(text))
