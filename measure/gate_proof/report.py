"""Writes the page: how many defects were made and found, what was missed and why, and what the tests reach."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from measure.gate_proof.defects import Defect
from measure.gate_proof.plugins.gate_tracer import PACKAGES
from measure.gate_proof.running import Outcome

REASONS = Path(__file__).parent / "reasons.toml"
NOBODY_LOOKED = "*not looked at*"
Totals = Mapping[str, Mapping[str, int]]
_HEAD = """\
# The gate's own proof

`make gate-proof` puts small defects into the product, one at a time, and runs the tests of `make test` that should find
them. This page is written by it ({commit}, seed {seed}).

- **The defects** are one span of a module's text replaced by another: a comparison, an operator, a number, a
  condition, an order of arguments, a statement left out. The modules are drawn by the seed, the larger the likelier,
  and of each at most {per_module} defects in lines that a test of the gate, or of the old one ({before}), runs.
- **The tests** are those that ran the line when the gate was recorded, in their own process or in one that they
  started, and those beside them in their files. For what runs at import, they are those that use the module or one that
  imports it. The first failure ends the run; the test has to fail a second time with the defect, and to pass without.
- **A test that hangs** finds the defect too: ten times the processor time that was recorded and half a minute more, or
  two minutes in which nothing is done.
- **What the gate misses** is put before the tests of the old gate: those of its `make test`{thorough}.
  Left out are the tests that the new gate has unchanged, for they have missed it.
"""


@dataclass(frozen=True, slots=True)
class Judged:
    """A defect with what came of it.

    Attributes:
        defect: the defect.
        gate: what the gate says; nothing if it has not been asked.
        old: what the old gate says of what the gate misses; nothing if the place is not there, or it was not asked.
        asked_old: it was.
    """

    defect: Defect
    gate: Outcome | None
    old: Outcome | None
    asked_old: bool

    @property
    def package(self) -> str:
        """The package it was put in."""
        return self.defect.path.partition("/")[0]

    @property
    def verdict(self) -> str:
        """The column of the table it belongs to."""
        if self.gate is None:
            return "open"
        if self.gate.found:
            return "found"
        if not self.asked_old:
            return "open"
        if self.old is None:
            return "only in the new tree"
        return "missed by the gate alone" if self.old.found else "missed by both"


COLUMNS = ("found", "missed by both", "missed by the gate alone", "only in the new tree", "open")


def reasons() -> dict[str, str]:
    """Return why defects were missed, by their ids."""
    return tomllib.loads(REASONS.read_text(encoding="utf-8")) if REASONS.is_file() else {}


def page(
    judged: Sequence[Judged], about: Mapping[str, object], totals: Mapping[str, Totals], why: Mapping[str, str]
) -> str:
    """Return the page.

    Args:
        judged: all defects.
        about: what the head of the page names.
        totals: what the tests reach of each package, before and after.
        why: the reasons of what was missed, by the ids of the defects.
    """
    parts = [_HEAD.format(**about), _table(judged), _how(judged), _reached(totals), _missed(judged, why)]
    return "\n".join(part for part in parts if part)


def _row(*cells: object) -> str:
    return f"| {' | '.join(map(str, cells))} |"


def _table(judged: Sequence[Judged]) -> str:
    columns = [name for name in COLUMNS if name in COLUMNS[:3] or any(one.verdict == name for one in judged)]
    lines = ["## What was found", "", _row("Package", "defects", *columns, "share found")]
    lines.append(_row("---", *["---:"] * (len(columns) + 2)))
    for package in (*PACKAGES, "all"):
        here = [one for one in judged if package in {one.package, "all"}]
        counts = Counter(one.verdict for one in here)
        asked = len(here) - counts["open"]
        share = f"{100 * counts['found'] / asked:.0f} %" if asked else "-"
        lines.append(_row(package, len(here), *(counts[name] for name in columns), share))
    return "\n".join([*lines, ""])


def _how(judged: Sequence[Judged]) -> str:
    outcomes = [one.gate for one in judged if one.gate]
    how = Counter(one.how for one in outcomes if one.found)
    told = ", ".join(f"{count} {_WAYS[name]}" for name, count in how.most_common())
    hours = sum(one.wall_s for one in outcomes) / 3600
    return f"Found: {told}. Time of all runs before the gate, added up: {hours:.1f} h.\n" if told else ""


_WAYS = {
    "failed": "by a test that fails",
    "import": "because the product or a test can no longer be imported",
    "hangs": "by a test that hangs",
    "died": "by a test whose process dies",
    "takes all memory": "by a test that takes all memory",
}


def _reached(totals: Mapping[str, Totals]) -> str:
    if not totals:
        return ""
    lines = ["## What the tests reach", ""]
    lines.append(_row("Package", *(f"branches, {name} | statements, {name}" for name in totals)))
    lines.append(_row("---", *["---: | ---:"] * len(totals)))
    for package in PACKAGES:
        cells = [
            f"{_share(of[package], 'covered_branches', 'num_branches')}"
            f" | {_share(of[package], 'covered_lines', 'num_statements')}"
            for of in totals.values()
        ]
        lines.append(_row(package, *cells))
    return "\n".join([*lines, ""])


def _share(of: Mapping[str, int], part: str, whole: str) -> str:
    return f"{100 * of[part] / of[whole]:.2f} % of {of[whole]}" if of.get(whole) else "-"


def _missed(judged: Sequence[Judged], why: Mapping[str, str]) -> str:
    lines = ["## What the gate misses"]
    for verdict in ("missed by the gate alone", "missed by both", "only in the new tree", "open"):
        here = [one for one in judged if one.verdict == verdict and one.gate and not one.gate.found]
        if here:
            lines += ["", f"### {verdict[0].upper()}{verdict[1:]}", "", _row("Id", "place", "change", "why")]
            lines.append(_row("---", "---", "---", "---"))
            lines += [_line(one, why) for one in here]
    return "\n".join([*lines, ""]) if len(lines) > 1 else ""


def _line(one: Judged, why: Mapping[str, str]) -> str:
    defect = one.defect
    place = f"`{defect.path}:{defect.line}`" + (f" `{defect.where}`" if defect.where else "")
    ran = "no test runs it" if one.gate and not one.gate.tests else ""
    seen = f"found by `{one.old.by}`" if one.old and one.old.found else ""
    told = [part for part in (ran, seen, why.get(defect.id, NOBODY_LOOKED)) if part]
    return _row(defect.id, place, change(defect), "; ".join(told))


def change(defect: Defect) -> str:
    """Return in a few words what was changed."""
    if defect.kind in {"statement removed", "value not returned"}:
        return f"{defect.kind}: {_code(defect.before)}"
    return f"{_code(defect.before)} became {_code(defect.after)}"


def _code(text: str) -> str:
    short = " ".join(text.split()).replace("|", "\\|").replace("`", "'")
    return f"`{short if len(short) < 80 else f'{short[:77]}...'}`" if short else "nothing"
