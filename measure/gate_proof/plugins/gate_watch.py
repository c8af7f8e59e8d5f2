"""A plugin for pytest that runs chosen tests in a chosen order, and says which one is running.

GATE_PROOF_TESTS names a file of JSON: `order`, the tests to run; `known`, all that there were before the defect; `log`,
the file to which a line is written when a test begins and when it ends. A test that has another name because of the
defect is run last.
"""

from __future__ import annotations

import json
import os
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

VARIABLE = "GATE_PROOF_TESTS"


class Watch:
    """Chooses and follows tests.

    Args:
        told: what the file says.
    """

    def __init__(self, told: dict[str, Any]) -> None:
        self._rank = {name: rank for rank, name in enumerate(told["order"])}
        self._known = set(told["known"])
        self._log = Path(told["log"])

    def _say(self, *words: str) -> None:
        with self._log.open("a", encoding="utf-8") as log:
            log.write(json.dumps(words) + "\n")

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Keep what is to run, in order."""
        last = len(self._rank)
        wanted = [item for item in items if item.nodeid in self._rank or item.nodeid not in self._known]
        kept = set(wanted)
        config.hook.pytest_deselected(items=[item for item in items if item not in kept])
        items[:] = sorted(wanted, key=lambda item: self._rank.get(item.nodeid, last))
        self._say("collected", str(len(items)))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Tell of a test."""
        self._say("begins", item.nodeid)
        try:
            return (yield)
        finally:
            self._say("ends", item.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Tell of what failed."""
        if report.failed:
            self._say("fails", report.nodeid)


def pytest_configure(config: pytest.Config) -> None:
    """Begin where it is asked for."""
    if os.environ.get(VARIABLE):
        told = json.loads(Path(os.environ[VARIABLE]).read_text(encoding="utf-8"))
        config.pluginmanager.register(Watch(told), "gate-watch")
