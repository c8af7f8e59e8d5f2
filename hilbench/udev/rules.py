"""Reads udev rules and says what is wrong in them; the grammar is that of udev(7).

A rule is a line of comma-separated expressions ``KEY{attribute}OPERATOR"value"``; a backslash at its end joins the next
line. ``==`` and ``!=`` compare, the other operators assign. This covers what our own file uses and what a person would
get wrong in it; ``udevadm verify`` of systemd 254 knows more.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

__all__ = ["Expression", "Problem", "Rule", "parse_rules", "problems_of"]

_COMPARE = frozenset({"==", "!="})
_ASSIGN = frozenset({"=", "+=", "-=", ":="})
_BOTH = _COMPARE | _ASSIGN

# Key: whether it takes an attribute in braces (None for may), and which operators. udev(7), "Rules files".
_KEYS: dict[str, tuple[bool | None, frozenset[str]]] = {
    **dict.fromkeys(("ACTION", "DEVPATH", "KERNEL", "KERNELS", "SUBSYSTEM", "SUBSYSTEMS"), (False, _COMPARE)),
    **dict.fromkeys(("DRIVER", "DRIVERS", "TAGS", "RESULT"), (False, _COMPARE)),
    **dict.fromkeys(("ATTRS", "CONST"), (True, _COMPARE)),
    **dict.fromkeys(("ATTR", "SYSCTL", "ENV"), (True, _BOTH)),
    **dict.fromkeys(("NAME", "SYMLINK", "TAG"), (False, _BOTH)),
    **dict.fromkeys(("OWNER", "GROUP", "MODE", "OPTIONS"), (False, _ASSIGN)),
    "TEST": (None, _COMPARE),
    "PROGRAM": (False, _BOTH),
    "IMPORT": (True, frozenset({"=", "==", "!="})),
    "RUN": (None, _ASSIGN),
    "SECLABEL": (True, _ASSIGN),
    "LABEL": (False, frozenset({"="})),
    "GOTO": (False, frozenset({"="})),
}

_EXPRESSION = re.compile(
    r"\s*(?P<key>[A-Z]+)(\{(?P<attribute>[^}]*)\})?\s*(?P<operator>==|!=|\+=|-=|:=|=)\s*"
    r"(?P<prefix>[ei]{0,2})\"(?P<value>(?:[^\"\\]|\\.)*)\"\s*(?P<end>,|$)"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Expression:
    """One comparison or assignment.

    Attributes:
        key: such as ``ATTRS``.
        attribute: what stood in braces; empty without.
        operator: ``==``, ``!=``, ``=``, ``+=``, ``-=`` or ``:=``.
        value: what stood in quotes.
    """

    key: str
    attribute: str
    operator: str
    value: str

    @property
    def compares(self) -> bool:
        """Whether it is a condition."""
        return self.operator in _COMPARE


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """One rule.

    Attributes:
        line: its first line, from 1.
        expressions: in the order they stand.
    """

    line: int
    expressions: tuple[Expression, ...]

    def value(self, key: str) -> str | None:
        """Return what a key is set to that stands once, such as ``GOTO``; None without it."""
        return next((one.value for one in self.expressions if one.key == key), None)


@dataclass(frozen=True, slots=True)
class Problem:
    """What is wrong in a line.

    Attributes:
        line: from 1.
        what: in words, without a full stop.
    """

    line: int
    what: str


def parse_rules(text: str) -> tuple[list[Rule], list[Problem]]:
    """Return the rules of a file and what cannot be read in it."""
    rules, problems = [], []
    for number, line in _joined_lines(text):
        expressions, rest = _expressions(line)
        if rest:
            problems.append(Problem(number, f"cannot be read from here: {rest.strip()[:40]}"))
        else:
            rules.append(Rule(line=number, expressions=tuple(expressions)))
    return rules, problems


def problems_of(text: str) -> list[Problem]:
    """Return everything that is wrong in a rules file, by line; empty if nothing is found."""
    rules, problems = parse_rules(text)
    for rule in rules:
        problems += [Problem(rule.line, what) for one in rule.expressions for what in _problems_of_key(one)]
    return sorted([*problems, *_problems_of_labels(rules)], key=lambda problem: problem.line)


def _joined_lines(text: str) -> Iterator[tuple[int, str]]:
    """Give the lines that are rules, those that go on joined, with their first line's number."""
    begun, start = "", 0
    for number, line in enumerate(text.splitlines(), 1):
        stripped = line.strip()
        if not begun and (not stripped or stripped.startswith("#")):
            continue
        start = start if begun else number
        if stripped.endswith("\\"):
            begun += f"{stripped[:-1]} "
        else:
            yield start, begun + stripped
            begun = ""
    if begun:
        yield start, begun


def _expressions(line: str) -> tuple[list[Expression], str]:
    """Split a rule; return also what is left where it cannot be read."""
    found: list[Expression] = []
    place = 0
    while place < len(line):
        match = _EXPRESSION.match(line, place)
        if match is None:
            return found, line[place:]
        found.append(
            Expression(
                key=match["key"],
                attribute=match["attribute"] or "",
                operator=match["operator"],
                value=match["value"],
            )
        )
        place = match.end()
    return found, ""


def _problems_of_key(one: Expression) -> Iterator[str]:
    if one.key not in _KEYS:
        yield f"unknown key {one.key}"
        return
    attribute, operators = _KEYS[one.key]
    if one.operator not in operators:
        yield f"{one.key} does not go with {one.operator}"
    if attribute is True and not one.attribute:
        yield f"{one.key} needs a name in braces"
    if attribute is False and one.attribute:
        yield f"{one.key} takes nothing in braces"


def _problems_of_labels(rules: Sequence[Rule]) -> Iterator[Problem]:
    """Find jumps that lead nowhere or back, and labels that nobody jumps to or that stand twice."""
    labels: dict[str, int] = {}
    for rule in rules:
        label = rule.value("LABEL")
        if label is not None and label in labels:
            yield Problem(rule.line, f"label {label} stands in line {labels[label]}, too")
        elif label is not None:
            labels[label] = rule.line
    wanted = [(rule.line, goto) for rule in rules if (goto := rule.value("GOTO")) is not None]
    for line, goto in wanted:
        if goto not in labels:
            yield Problem(line, f"there is no label {goto}")
        elif labels[goto] <= line:
            yield Problem(line, f"label {goto} stands above, and udev jumps only forward")
    for label, line in labels.items():
        if label not in {goto for _, goto in wanted}:
            yield Problem(line, f"nothing jumps to label {label}")
