"""What benchmarks and soaks have in common with the tests: they do without a physics that is not there."""

from __future__ import annotations

import sys

import pytest
from _pytest import runner

from hilbench.check.room import with_room
from tests.rigid import skip_without_its_library


def pytest_runtest_setup(item):
    skip_without_its_library(item)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    return with_room(runner.pytest_runtest_protocol, item, nextitem)


@pytest.fixture
def say(capfd):
    """Print a figure, which is what one runs it for."""

    def tell(text):
        with capfd.disabled():
            sys.stdout.write(f"\n{text}\n")

    return tell
