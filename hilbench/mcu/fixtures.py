"""Fixtures for tests of firmware under plain pytest: ``board``, and ``boards`` for benches with several.

The bench is that of ``--hil-bench``, or the ``hilbench.toml`` beside the test file, or above it.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from hilbench.benchfile.bench_file import BenchFile
from hilbench.benchfile.reader import DEFAULT_FILE
from hilbench.errors import UsageError
from hilbench.mcu.command_line import open_target
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.under_test import BoardUnderTest, boards_under_test

__all__ = ["BoardFixtures"]


class BoardFixtures:
    """A plugin.

    Args:
        bench: what ``--hil-bench`` says; None for a file beside the test.
        seed: seed of the run.
    """

    def __init__(self, bench: str | None, seed: int) -> None:
        self._bench = bench
        self._seed = seed

    @pytest.fixture
    def boards(self, request: pytest.FixtureRequest) -> Iterator[Mapping[str, BoardUnderTest]]:
        """The boards of the bench by name, power just on."""
        bench_file = self._find(request.path)
        if not bench_file.boards:
            raise UsageError("has no emulated board", where=bench_file.name, hint="add board and firmware to a target")
        with contextlib.closing(EmulatedBench(bench_file, seed=self._seed)) as emulated:
            yield boards_under_test(emulated)

    @pytest.fixture
    def board(self, boards: Mapping[str, BoardUnderTest]) -> BoardUnderTest:
        """The board of the bench, power just on."""
        if len(boards) > 1:
            raise UsageError("there are several boards on this bench", hint=f"use boards[...]: {', '.join(boards)}")
        return next(iter(boards.values()))

    def _find(self, test: Path) -> BenchFile:
        if self._bench is not None:
            return open_target(self._bench)
        beside = (folder / DEFAULT_FILE for folder in test.parents)
        found = next((file for file in beside if file.is_file()), None)
        if found is None:
            raise UsageError(
                f"no {DEFAULT_FILE} beside it or above it", where=str(test), hint="write one: hilbench init --help"
            )
        return open_target(str(found))
