"""How a suite declares its cases.

A suite is a pytest file; a case is a test function with the clause it checks written above it::

    @case("S01", bench_time_s=0.4)
    def test_sync0_is_echoed(peer): ...

The text, the level and the source of a clause come from the catalogue of the protocol. A suite of your own may cite
those, or bring its clauses along::

    @case("MY01", text="The status lamp is lit while a session is open.", level="must", source="our panel, rev. C")
    def test_lamp(peer): ...
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

from hilbench.check.catalogue import Clause
from hilbench.judging.provider import PLAIN_SETUP, CaseSetup
from hilbench.judging.verdicts import Level

FunctionT = TypeVar("FunctionT", bound=Callable[..., object])

_ATTRIBUTE = "hilbench_case"


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseSpec:
    """What the decorator says of a case.

    Attributes:
        clause_ids: the clauses it checks, at least one.
        bench_time_s: about how long it takes, in seconds of bench time; what ``--list`` adds up.
        needs: the capabilities without which it is not applicable, on top of those its clauses need.
        scene: the scene its bench is to be opened with; empty for that of the bench file.
        setup: how else its bench is to differ from that of the bench file.
        setups: instead of that, several benches that it runs on, by the names that its cases get in brackets.
        clause: the clause it brings along, if it is not in a catalogue.
    """

    clause_ids: tuple[str, ...]
    bench_time_s: float = 0.0
    needs: frozenset[str] = frozenset()
    scene: str = ""
    setup: CaseSetup = PLAIN_SETUP
    setups: Mapping[str, CaseSetup] = field(default_factory=dict)
    clause: Clause | None = None

    def on(self, name: str) -> CaseSpec:
        """Return the case on one of its several benches."""
        setup = self.setups[name]
        return replace(self, setup=setup, setups={}, needs=self.needs | setup.needs)


def case(
    *clause_ids: str,
    bench_time_s: float = 0.0,
    needs: Iterable[str] = (),
    scene: str = "",
    setup: CaseSetup = PLAIN_SETUP,
    setups: Mapping[str, CaseSetup] | None = None,
    text: str = "",
    title: str = "",
    level: Level = "must",
    source: str = "",
) -> Callable[[FunctionT], FunctionT]:
    """Declare that a test function checks the given clauses.

    Args:
        clause_ids: ids from the catalogue of the protocol, or one of your own together with ``text``.
        bench_time_s: about how long the case takes, in seconds of bench time, for each set of parameters.
        needs: capabilities that the bench must have, such as ``"world"``; without them the case is not applicable.
        scene: the scene of the bench; by default that of the bench file.
        setup: variant, program and settings of parts, for a bench of emulated boards.
        setups: several of them, by name; each makes a case. The function needs the fixture ``bench``, or one that
            needs it.
        text: defines the clause here: what the target must do.
        title: short form of ``text``; the default is its first sentence.
        level: ``"must"`` or ``"should"``, for a clause that is defined here.
        source: where the rule is published, for a clause that is defined here.

    Raises:
        ValueError: no clause id, or several together with ``text``.
        TypeError: ``needs`` is a single text.
    """
    if not clause_ids:
        raise ValueError("a case cites at least one clause")
    if text and len(clause_ids) != 1:
        raise ValueError(f"text= defines one clause, not {len(clause_ids)}: {', '.join(clause_ids)}")
    if isinstance(needs, str):
        raise TypeError(f'needs= is a collection of names: write needs=("{needs}",)')
    own = None
    if text:
        own = Clause(
            id=clause_ids[0],
            suite="",
            level=level,
            title=title or text.split(". ", maxsplit=1)[0].rstrip("."),
            text=text,
            source=source,
        )
    spec = CaseSpec(
        clause_ids=clause_ids,
        bench_time_s=bench_time_s,
        needs=frozenset(needs) | setup.needs,
        scene=scene,
        setup=setup,
        setups=setups or {},
        clause=own,
    )

    def declare(function: FunctionT) -> FunctionT:
        setattr(function, _ATTRIBUTE, spec)
        return function

    return declare


def spec_of(function: object) -> CaseSpec | None:
    """Return what `case` said of a test function, or None if it was not declared."""
    spec = getattr(function, _ATTRIBUTE, None)
    return spec if isinstance(spec, CaseSpec) else None
