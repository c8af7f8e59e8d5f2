from __future__ import annotations

import pytest

from targets.boards import built_in_board
from targets.mcu.machine import Machine
from tests.targets.mcu.timing.assembly import program


@pytest.fixture(scope="session")
def board():
    return built_in_board("bluepill")


@pytest.fixture
def start(board):
    """Makes a machine with a program: its main code, its handlers by exception number; options of `Machine` by name."""

    def starter(main, handlers=None, **options):
        return Machine(board, program(main, handlers or {}), **options)

    return starter


@pytest.fixture(params=[True, False], ids=["skipping", "stepping"])
def skip_idle(request):
    return request.param


@pytest.fixture(params=["flat", "table"])
def timing(request):
    return request.param
