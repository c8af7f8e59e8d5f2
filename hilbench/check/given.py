"""What the process of a run and those that run its cases tell each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hilbench.check.results import CaseResult
from hilbench.check.screens import Draw
from hilbench.errors import HilbenchError, UnavailableError
from hilbench.judging.observations import Observations
from hilbench.judging.provider import BenchProvider
from hilbench.terminal.options import CheckOptions

__all__ = ["Draw", "Given", "Over", "ProviderFactory", "Ran", "Ready", "Refused"]

ProviderFactory = Callable[[CheckOptions], BenchProvider]


@dataclass(frozen=True, slots=True, kw_only=True)
class Given:
    """To a worker, first of all. After that it gets the ids of cases, one at a time, and then an empty one.

    Attributes:
        options: of the run.
        provider_factory: makes its provider.
        draw: draws pictures of cases that fail; None for none.
        part: where it writes its journal; empty for nowhere.
    """

    options: CheckOptions
    provider_factory: ProviderFactory
    draw: Draw | None = None
    part: str = ""


@dataclass(frozen=True, slots=True)
class Ready:
    """From a worker that has planned the run."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ran:
    """From a worker: a case is over, and it waits for the next.

    Attributes:
        result: what came of it.
        header_bytes: how long the first line of its journal is.
        journal_bytes: how much its journal has by now: the cases that it has run.
        stopped: why nothing more should run; empty if it may.
        pictures_lost: why a picture could not be made, the first time.
    """

    result: CaseResult
    header_bytes: int = 0
    journal_bytes: int = 0
    stopped: str = ""
    pictures_lost: UnavailableError | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Over:
    """From a worker, last of all.

    Attributes:
        observed: what it saw beside the verdicts.
        defects: what went wrong in the engine itself.
        stopped: why it ended early; empty if it did not.
    """

    observed: Observations
    defects: tuple[str, ...] = ()
    stopped: str = ""


@dataclass(frozen=True, slots=True)
class Refused:
    """From a worker: it cannot run anything."""

    error: HilbenchError
