"""The lines below the matrix that tell how much the verdicts above them are worth: a line or two for each subject."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from hilbench.check.results import Report, TightMargin, relative_margin
from hilbench.judging.note_lines import note_lines, notes_counted
from hilbench.judging.observations import Coverage, Ledger, Pace, PortCounters
from hilbench.judging.verdicts import Measure, Sampled

_MOST_NAMES = 6
_FAR_BEYOND = 10.0
"""A figure so many tolerances beyond its limit says nothing as a share of it (choice)."""


def lines(report: Report) -> list[str]:
    """Return coverage, tightest margins, fidelity and pace, as far as the run has them."""
    observed = report.observed
    found = [_coverage(coverage) for coverage in observed.coverage]
    if report.tightest:
        found.append(f"tightest margins: {', '.join(map(_tight, report.tightest))}")
    families = _families(report)
    if families:
        found.append(f"tried: {'; '.join(families)}")
    found += _reruns(report)
    found += _asked(report)
    if observed.ledger is not None:
        found.append(_ledger(observed.ledger))
    if observed.pace is not None:
        found.append(_pace(observed.pace))
    if observed.port is not None:
        found.append(_port(observed.port))
    return [*found, *lines_of_notes(report, indent="  ")]


def lines_of_notes(report: Report, suite: str = "", *, indent: str = "") -> list[str]:
    """Return what there is to note of the firmware of emulated boards, of one suite or of all, with a head."""
    notes = [
        msgspec.structs.asdict(note)
        for note in report.observed.notes
        if not suite or any(case_id.startswith(f"{suite}/") for case_id in note.case_ids)
    ]
    lines = note_lines(notes)
    return [f"{notes_counted(len(notes), len(lines))}:", *(f"{indent}{line}" for line in lines)] if lines else []


def margin_text(measure: Measure | None) -> str:
    """Return a figure as its distance to the limit, in its unit and, unless far beyond, as a share of the tolerance."""
    if measure is None or measure.margin is None:
        return ""
    share = relative_margin(measure)
    distance = _figure(measure.margin, 3, measure.unit)
    return f"{distance} ({share:.0%})" if share > -_FAR_BEYOND else distance


def _coverage(coverage: Coverage) -> str:
    states = coverage.states - len(coverage.states_missed)
    edges = coverage.edges - len(coverage.edges_missed)
    text = f"{coverage.peer}: {states} of {coverage.states} states, {edges} of {coverage.edges} edges"
    missed = [f"state {state}" for state in coverage.states_missed] + list(coverage.edges_missed)
    return f"{text}; not taken: {named(missed)}" if missed else text


def _tight(margin: TightMargin) -> str:
    figure = _figure(margin.measure.value, 4, margin.measure.unit)
    return f"{'/'.join(margin.clause_ids)} {figure} ({margin.share:.1%})"


def _families(report: Report) -> list[str]:
    """Return how many members of each family were tried, in the case that tried the smallest share of it."""
    least: dict[tuple[str, str], Sampled] = {}
    for case in report.cases:
        for sampled in case.families:
            key = "/".join(case.clause_ids), sampled.family
            known = least.get(key, sampled)
            least[key] = min(known, sampled, key=lambda one: one.tried / one.members)
    by_clause: dict[str, list[str]] = {}
    for (clause_id, family), one in least.items():
        by_clause.setdefault(clause_id, []).append(f"{one.tried} of {one.members} {family}")
    return [f"{clause_id} {', '.join(tried)}" for clause_id, tried in by_clause.items()]


def _reruns(report: Report) -> list[str]:
    """Return which cases were run again, and why."""
    again = [case for case in report.cases if case.reruns]
    if not again:
        return []
    words = [f"{case.id} {len(case.reruns)} time{'s' * (len(case.reruns) > 1)}: {case.reruns[-1]}" for case in again]
    return [f"run again, as they were inconclusive: {named(words)}"]


def _asked(report: Report) -> list[str]:
    """Return how often the operator was asked for something."""
    asked = [case.asked for case in report.cases if case.asked]
    where = f"in {len(asked)} case{'s' * (len(asked) != 1)}"
    return [f"operator: asked {sum(map(len, asked))} times {where}"] if asked else []


def _figure(value: float, digits: int, unit: str) -> str:
    return f"{value:.{digits}g} {unit}".rstrip()


def _ledger(ledger: Ledger) -> str:
    text = f"model: {ledger.modelled} features modelled, {ledger.partly} partly, {ledger.absent} absent"
    for fidelity in ("partly", "absent"):
        names = [f"'{touched.feature}'" for touched in ledger.touched if touched.fidelity == fidelity]
        text += f"; touched, {fidelity}: {named(names)}" if names else ""
    ignored = sorted({ignored.command for ignored in ledger.ignored})
    return text + (f"; without effect: {named(ignored)}" if ignored else "")


def _pace(pace: Pace) -> str:
    late = (pace.lateness_p50_s, pace.lateness_p99_s, pace.lateness_max_s)
    names = ("p50", "p99", "max")
    figures = ", ".join(f"{name} {value * 1000:.2f} ms" for name, value in zip(names, late, strict=True))
    return (
        f"host: lateness {figures}; {pace.slips} slips, {pace.slipped_s:.3f} s; "
        f"{pace.real_time_factor:.3f} times real time"
    )


def _port(port: PortCounters) -> str:
    troubles = [
        (port.lost, "lost"),
        (port.overruns, "overrun"),
        (port.framing_errors, "with framing errors"),
        (port.parity_errors, "with parity errors"),
        (port.receive_overruns, "too many for the receiver"),
        (port.refused, "refused"),
    ]
    words = [f"{number} {what}" for number, what in troubles if number]
    breaks = f"; {port.breaks} breaks" if port.breaks else ""
    breaks += f"; {port.breaks_unsent} breaks asked for that it cannot send" if port.breaks_unsent else ""
    return f"port: {port.sent} bytes sent, {port.received} received, {', '.join(words) or 'none lost'}{breaks}"


def named(names: Sequence[str]) -> str:
    """Return the first of some names, and how many more there are."""
    more = len(names) - _MOST_NAMES
    return ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
