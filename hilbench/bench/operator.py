"""Somebody beside a target at a port, who does and sees on request what a check cannot: a person, or a command.

What may be asked for stands in the record of the system (`System.hand_requests`). Bench time goes on while somebody is
asked, and so does what the checker says by itself; when exactly something was done nobody knows. Each request and its
answer are events of the journal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from hilbench.bench import Bench
from hilbench.judging.provider import CaseInfo
from hilbench.judging.recorder import recorded_so_far
from hilbench.judging.verdicts import NotApplicable
from hilbench.plugins.system import HandRequest

__all__ = ["CANNOT", "DONE", "Asked", "Beside", "NobodyThereError", "Operator", "Somebody"]

CANNOT = "cannot"
DONE = "done"


class NobodyThereError(Exception):
    """Nobody has answered, and nobody will; the text says how that was seen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """A request of a case.

    Attributes:
        name: of the request.
        words: of the case, that stand in its text.
        text: what to do, or the question.
        answers: what may be answered beside `CANNOT`; `DONE` alone where something is to be done.
        clause_ids: the clauses of the case; empty for what is undone after one.
    """

    name: str
    words: tuple[str, ...]
    text: str
    answers: tuple[str, ...]
    clause_ids: tuple[str, ...]

    @property
    def to_do(self) -> bool:
        """Something is to be done; otherwise it is a question."""
        return self.answers == (DONE,)


class Somebody(Protocol):
    """Who does what is asked for."""

    def answer(self, bench: Bench, asked: Asked) -> str:
        """Return one of the answers, or `CANNOT`; bench time goes on meanwhile.

        Raises:
            NobodyThereError: nobody answers.
            UnavailableError: what should have answered is broken.
        """

    def last(self, asked: Asked) -> None:
        """Ask for something as the run is over, when no bench time passes any more and nobody waits for the answer."""

    def close(self) -> None:
        """Give back what was opened."""


class Operator:
    """See the module.

    Args:
        requests: what may be asked for, by name.
        somebodies: who is asked, in this order: the next where one cannot.
    """

    def __init__(self, requests: Mapping[str, HandRequest], somebodies: Sequence[Somebody]) -> None:
        self._requests = requests
        self._somebodies = somebodies
        self._gone: dict[int, str] = {}
        self._to_undo: dict[str, None] = {}

    @property
    def capabilities(self) -> frozenset[str]:
        """What a bench with somebody beside its target can do, as the clauses name it."""
        return frozenset(request.capability for request in self._requests.values())

    def ask(self, bench: Bench, case: CaseInfo | None, name: str, *words: str) -> str:
        """Ask for something, and wait for the answer.

        Args:
            bench: whose time goes on.
            case: for which it is; None for what is undone after one.
            name: of the request.
            words: what stands in its text.

        Returns:
            One of its answers; `DONE` where something was to be done.

        Raises:
            NotApplicable: he cannot, or nobody answers: what the case is about is not shown.
            UnavailableError: the command is broken.
        """
        request, asked = self._requests[name], self._asked(name, words, case)
        bench.record("asked", "operator", request=name, words=words)
        answer = self._answer(bench, asked)
        bench.record("answered", "operator", request=name, answer=answer)
        recorded_so_far().asked.append(f"{asked.text}: {answer}")
        if answer not in asked.answers:
            raise NotApplicable(f"{answer}: {asked.text}")
        self._to_undo.pop(name, None)
        if request.undo:
            self._to_undo[request.undo] = None
        return answer

    def restore(self, bench: Bench) -> None:
        """Have everything taken back that an earlier case has asked for, as far as somebody does it."""
        for name in reversed([*self._to_undo]):
            try:
                self.ask(bench, None, name)
            except NotApplicable:
                self._to_undo.pop(name, None)

    def close(self) -> None:
        """Say what is still to be taken back, and wait for nobody."""
        for somebody in self._somebodies:
            for name in reversed([*self._to_undo]):
                somebody.last(self._asked(name, (), None))
            somebody.close()
        self._to_undo.clear()

    def _asked(self, name: str, words: tuple[str, ...], case: CaseInfo | None) -> Asked:
        request = self._requests[name]
        return Asked(
            name=name,
            words=words,
            text=request.text.format(*words),
            answers=request.answers or (DONE,),
            clause_ids=() if case is None else case.clause_ids,
        )

    def _answer(self, bench: Bench, asked: Asked) -> str:
        """Return the answer of the first who has one; otherwise in words why there is none."""
        why = ""
        for number, somebody in enumerate(self._somebodies):
            if number not in self._gone:
                try:
                    answer = somebody.answer(bench, asked)
                except NobodyThereError as error:
                    self._gone[number] = str(error)
                else:
                    if answer != CANNOT:
                        return answer
                    why = "the operator cannot"
        return why or next(iter(self._gone.values()))


@dataclass(frozen=True, slots=True)
class Beside:
    """The operator during one case.

    Attributes:
        operator: who is asked.
        bench: whose time goes on meanwhile.
        case: what is known of the case; it is asked for its `by_hand` alone.
    """

    operator: Operator
    bench: Bench
    case: CaseInfo

    def ask(self, name: str, *words: str) -> str:
        """See `Operator.ask`."""
        return self.operator.ask(self.bench, self.case, name, *words)
