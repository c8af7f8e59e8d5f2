"""The expression of ``-k``: which cases to run.

Like pytest's: words joined by ``and``, ``or``, ``not`` and parentheses. A word that is the id of a clause means that
clause and no other; any other word means every case with that text, in upper or lower case, in its id, its suite, or
the id or title of one of its clauses.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass

from hilbench.errors import UsageError

_TOKEN = re.compile(r"\s*([()]|[^\s()]+)")
_OPERATORS = frozenset({"and", "or", "not", "(", ")"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """What an expression is held against.

    Attributes:
        clause_ids: the clauses of the case.
        texts: everything a word may be found in.
    """

    clause_ids: frozenset[str]
    texts: tuple[str, ...]

    @classmethod
    def of(cls, clause_ids: Iterable[str], texts: Iterable[str]) -> Candidate:
        """Make a candidate, folded to lower case."""
        folded = frozenset(clause_id.lower() for clause_id in clause_ids)
        return cls(clause_ids=folded, texts=(*folded, *(text.lower() for text in texts)))


Predicate = Callable[[Candidate], bool]


def compile_selection(expression: str, known_ids: Collection[str]) -> Predicate:
    """Turn an expression into a predicate.

    Args:
        expression: what was written after ``-k``; empty selects everything.
        known_ids: the ids of all clauses at hand.

    Raises:
        UsageError: the expression is malformed.
    """
    if not expression.strip():
        return lambda _: True
    return _Parser(expression, frozenset(known.lower() for known in known_ids)).parse()


class _Parser:
    """Recursive descent over: any = all {"or" all}; all = one {"and" one}; one = "not" one | "(" any ")" | word."""

    def __init__(self, expression: str, known_ids: frozenset[str]) -> None:
        self._expression = expression
        self._tokens = _TOKEN.findall(expression)
        self._at = 0
        self._known_ids = known_ids

    def parse(self) -> Predicate:
        predicate = self._any()
        if self._at < len(self._tokens):
            raise self._error(f"unexpected '{self._tokens[self._at]}'")
        return predicate

    def _any(self) -> Predicate:
        parts = [self._all()]
        while self._accept("or"):
            parts.append(self._all())
        return lambda candidate: any(part(candidate) for part in parts)

    def _all(self) -> Predicate:
        parts = [self._one()]
        while self._accept("and"):
            parts.append(self._one())
        return lambda candidate: all(part(candidate) for part in parts)

    def _one(self) -> Predicate:
        if self._accept("not"):
            inner = self._one()
            return lambda candidate: not inner(candidate)
        if self._accept("("):
            inner = self._any()
            if not self._accept(")"):
                raise self._error("a ')' is missing")
            return inner
        return self._word()

    def _word(self) -> Predicate:
        if self._at == len(self._tokens):
            raise self._error("a word is missing at the end")
        word = self._tokens[self._at].lower()
        if word in _OPERATORS:
            raise self._error(f"a word is missing before '{word}'")
        self._at += 1
        if word in self._known_ids:
            return lambda candidate: word in candidate.clause_ids
        return lambda candidate: any(word in text for text in candidate.texts)

    def _accept(self, token: str) -> bool:
        found = self._at < len(self._tokens) and self._tokens[self._at].lower() == token
        self._at += found
        return found

    def _error(self, what: str) -> UsageError:
        return UsageError(what, where=f"-k '{self._expression}'", hint="words joined by and, or, not and parentheses")
