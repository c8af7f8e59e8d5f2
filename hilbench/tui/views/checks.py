"""A run of suites: counts, a clause a line, and one clause whole with its cause and evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.text import Text

from hilbench.tui.model.checks import RUNNING, CheckedModel, ChecksModel
from hilbench.tui.views.words import BAD, DIM, GOOD, HEAD, LIT, bar, fit

__all__ = ["checks_view", "clause_view", "clauses_shown"]

_MARKS: Mapping[str, tuple[str, str]] = {
    "pass": ("✓", GOOD),
    "fail": ("✗", BAD),
    "error": ("!", BAD),
    "inconclusive": ("?", "yellow"),
    "not-applicable": ("-", DIM),
    RUNNING: ("▶", HEAD),
    "": ("·", DIM),
}
_WORDS = {"": "waits", RUNNING: "runs"}
_MOST_EVIDENCE = 12


def checks_view(
    checks: ChecksModel, width: int, height: int, *, chosen: str = "", shown: Sequence[CheckedModel] | None = None
) -> list[Text]:
    """Return how far a run is and its clauses: those that are to be shown, else around the one that matters."""
    if not checks.rows:
        return [fit(Text("nothing was checked yet; t runs a suite on a fresh bench", DIM), width)]
    rows = clauses_shown(checks, height, chosen) if shown is None else shown
    breadth = max(len(_word(row)) for row in checks.rows.values())
    lines = [_row(row, breadth, chosen == row.id) for row in rows]
    return [fit(line, width) for line in (_head(checks), *lines)]


def clauses_shown(
    checks: ChecksModel, height: int, chosen: str, before: Sequence[CheckedModel] = ()
) -> list[CheckedModel]:
    """Return the clauses that there is room for, with the one that is pointed at or that runs in the middle.

    Args:
        checks: the run.
        height: rows, the first of which says how far the run is.
        chosen: the one that is pointed at; empty if none is.
        before: those that were shown before; they stay where they are as long as the chosen one is among them.
    """
    rows = list(checks.rows.values())
    if not rows:
        return []
    wanted = next((row.id for row in rows if row.state == RUNNING), rows[-1].id if not checks.ended else rows[0].id)
    at = next((number for number, row in enumerate(rows) if row.id == (chosen or wanted)), 0)
    room = max(1, height - 1)
    begin = at - room // 2
    if chosen and before and before[0] in rows:
        begin = max(at - room + 1, min(rows.index(before[0]), at))
    begin = max(0, min(begin, len(rows) - room))
    return rows[begin : begin + room]


def _head(checks: ChecksModel) -> Text:
    counts = checks.counts()
    done = sum(count for state, count in counts.items() if state not in {"", RUNNING})
    said = ", ".join(f"{counts[state]} {state}" for state in _MARKS if state not in {"", RUNNING} and counts[state])
    bad = counts["fail"] + counts["error"]
    share = done / max(1, len(checks.rows))
    progress = checks.ended or f"{bar(share, 10)} {done} of {len(checks.rows)}"
    return Text.assemble((progress, HEAD), "  ", (said, BAD if bad else ""))


def _row(row: CheckedModel, breadth: int, chosen: bool) -> Text:
    mark, style = _MARKS.get(row.state, ("·", DIM))
    margin = _margin(row.about.get("worst_margin"))
    line = Text.assemble(
        ("▸" if chosen else " ", HEAD),
        (f"{mark} ", style),
        (f"{row.id:<6} ", HEAD),
        (f"{_word(row):<{breadth}} ", style),
        f"{row.mark}{row.title}",
        (f"  {row.cause}" if row.bad and row.cause else f"  {margin}" if margin else "", BAD if row.bad else DIM),
    )
    if chosen:
        line.stylize(LIT)
    return line


def _word(row: CheckedModel) -> str:
    return _WORDS.get(row.state, row.state)


def clause_view(row: CheckedModel, width: int, height: int | None = None) -> list[Text]:
    """Return a clause whole: what it asks for, what came of it, and why.

    Args:
        row: the clause.
        width: columns.
        height: rows; None for as many as it takes. Where there are too few, the last lines are left out, then the
            source, and each line of evidence is cut to one row.
    """
    about = row.about
    _, style = _MARKS.get(row.state, ("·", DIM))
    asked = [Text.assemble((f"{row.id} ", HEAD), (f"{row.level} ", DIM), (_word(row), style))]
    asked.append(Text(str(about.get("text") or row.title)))
    source = [Text(f"source    {about['source']}", DIM)] if about.get("source") else []
    cause = [Text(f"{row.mark}nobody saw {', '.join(row.unseen)}")] if row.unseen else []
    cause += [Text(f"cause     {row.cause}", BAD if row.bad else "")] if row.cause else []
    evidence = [Text(f"evidence  {line}") for line in list(about.get("evidence", ()))[:_MOST_EVIDENCE]]
    rest = _margin_and_cases(row)
    whole = _folded([*asked, *source, *cause, *evidence, *rest], width)
    if height is None or len(whole) <= height:
        return whole
    with_source = _folded([*asked, *source, *cause, *evidence], width)
    if len(with_source) <= height:
        return with_source
    return [*_folded([*asked, *cause], width), *(fit(line, width) for line in evidence)][:height]


def _margin_and_cases(row: CheckedModel) -> list[Text]:
    """Return the worst margin, the cases, and how to run them again."""
    margin = _margin(row.about.get("worst_margin"))
    lines = [Text(f"margin    {row.about['worst_margin']['name']}: {margin}")] if margin else []
    lines += [Text(f"case      {case} {_WORDS.get(state, state)}", DIM) for case, state in row.cases.items()]
    if row.about.get("reproduce"):
        lines.append(Text(f"again     {row.about['reproduce']}", DIM))
    return lines


def _folded(lines: Sequence[Text], width: int) -> list[Text]:
    """Return lines in pieces of a width, none of them cut."""
    return [piece for line in lines for piece in _pieces(line, width)]


def _pieces(line: Text, width: int) -> list[Text]:
    pieces, rest = [], line
    while rest.cell_len > width > 0:
        place = rest.plain.rfind(" ", 1, width)
        cut = place if place > width // 2 else width
        pieces.append(rest[:cut])
        rest = rest[cut:]
        rest = rest[1:] if rest.plain.startswith(" ") else rest
    return [*pieces, rest]


def _margin(measure: Mapping[str, Any] | None) -> str:
    if not measure:
        return ""
    limits = [f"{word} {measure[key]:g}" for key, word in (("low", "at least"), ("high", "at most")) if key in measure]
    return f"{measure['value']:g} {measure['unit']} ({', '.join(limits)})" if limits else ""
