"""Everything the doctor found, for a person and for a program."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.doctor.access import look_at_access
from hilbench.doctor.facts import Facts
from hilbench.doctor.finding import Finding, State
from hilbench.doctor.machine import look_at_machine
from hilbench.doctor.software import look_at_software

__all__ = ["as_data", "as_text", "findings_of", "is_fit"]

_MARKS = {State.FINE: "ok", State.WARNING: "warn", State.CROSS: "FAIL"}


def findings_of(facts: Facts, target: str | None = None) -> list[Finding]:
    """Return what was found, in the order in which one would look."""
    return [*look_at_software(facts), *look_at_machine(facts), *look_at_access(facts, target)]


def is_fit(findings: Sequence[Finding]) -> bool:
    """Say whether nothing is broken; a warning breaks nothing."""
    return all(finding.state is not State.CROSS for finding in findings)


def as_data(findings: Sequence[Finding]) -> dict[str, object]:
    """Return it as plain data."""
    return {"fit": is_fit(findings), "findings": [finding.as_data() for finding in findings]}


def as_text(findings: Sequence[Finding]) -> str:
    """Return it as lines for a person."""
    width = max(len(finding.subject) for finding in findings)
    lines = []
    for finding in findings:
        lines.append(f"{_MARKS[finding.state]:<5}  {finding.subject:<{width}}  {finding.what}")
        if finding.fix:
            lines.append(f"{'':<5}  {'':<{width}}  -> {finding.fix}")
    crosses = sum(finding.state is State.CROSS for finding in findings)
    warnings = sum(finding.state is State.WARNING for finding in findings)
    lines.append(f"{_count(crosses, 'problem', 'problems')}, {_count(warnings, 'warning', 'warnings')}")
    return "\n".join(lines)


def _count(number: int, one: str, many: str) -> str:
    return f"{number} {one if number == 1 else many}" if number else f"no {one}"
