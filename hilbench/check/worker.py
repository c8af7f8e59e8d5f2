"""``python -m hilbench.check.worker DESCRIPTOR``: runs the cases that it is given; see `hilbench.check.parallel`."""

from __future__ import annotations

import contextlib
import os
import sys
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from hilbench.check.given import Given, Over, Ran, Ready, Refused
from hilbench.check.plugin import items_by_case
from hilbench.check.results import CaseResult
from hilbench.check.runner import run_cases
from hilbench.check.screens import Screens
from hilbench.cli.protocol_flags import use_plugins
from hilbench.errors import HilbenchError
from hilbench.judging.observations import Observations, Observing
from hilbench.judging.provider import BenchProvider, Journalled
from hilbench.terminal import interruption

__all__ = ["main"]


class _Turns:
    """A plug-in of pytest that runs the cases that are asked for, in the place of all that there are."""

    def __init__(self, connection: Connection, provider: Journalled, part: str, screens: Screens | None) -> None:
        self._connection = connection
        self._provider = provider
        self._part = part
        self._header_bytes = _size(part)
        self._screens = screens
        self._results: list[CaseResult] = []  # of the case that runs; one, unless nothing can be run

    def take(self, result: CaseResult, _number: int, _total: int) -> None:
        """Take the result of the case."""
        self._results.append(result)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run what is asked for, until nothing more is, or until nobody asks any more."""
        items = items_by_case(session.items)
        with contextlib.suppress(EOFError, OSError):
            self._connection.send(Ready())
            while case_id := self._connection.recv():
                self._results.clear()
                items[case_id].config.hook.pytest_runtest_protocol(item=items[case_id], nextitem=None)
                if not self._results:
                    break  # nothing can be run
                self._connection.send(self._ran(session))
        return True

    def _ran(self, session: pytest.Session) -> Ran:
        self._provider.recorded_in.flush_step()  # the bench may have said something as it was closed
        return Ran(
            result=self._results[-1],
            header_bytes=self._header_bytes,
            journal_bytes=_size(self._part),
            stopped=str(session.shouldstop or ""),
            pictures_lost=self._screens.problem if self._screens is not None else None,
        )


def main() -> None:
    """Run what the process at the other end of the connection gives out."""
    with contextlib.suppress(EOFError, OSError), Connection(int(sys.argv[1])) as connection:
        given = connection.recv()
        try:
            connection.send(_work(connection, given))
        except HilbenchError as error:
            connection.send(Refused(error))


def _work(connection: Connection, given: Given) -> Over:
    part = Path(given.part) if given.part else None
    options = replace(given.options, journal=part, journal_max=None, jobs=1)
    use_plugins(options.plugins)
    provider = given.provider_factory(options)
    interruption.ignore()  # Ctrl-C is the other process's, which ends this one
    with contextlib.closing(provider):
        screens = None
        if options.screens is not None and given.draw is not None:
            screens = Screens(options.screens, given.draw, str(provider.describe().get("bench", "")))
        assert isinstance(provider, Journalled)
        turns = _Turns(connection, provider, given.part, screens)
        collector = run_cases(options, provider, on_result=turns.take, screens=screens, more=[turns])
        return Over(observed=_observed(provider), defects=tuple(collector.defects), stopped=collector.stopped)


def _observed(provider: BenchProvider) -> Observations:
    return provider.observed() if isinstance(provider, Observing) else Observations()


def _size(part: str) -> int:
    return os.stat(part).st_size if part else 0  # noqa: PTH116


if __name__ == "__main__":
    main()
