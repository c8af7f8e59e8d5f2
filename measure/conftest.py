"""What benchmarks and soaks have in common with the tests: they do without PyBullet where it is not there."""

from __future__ import annotations

import importlib.util
import sys

import pytest
from _pytest import runner

from hilbench.check.room import with_room


def pytest_runtest_setup(item):
    if item.get_closest_marker("needs_bullet") and importlib.util.find_spec("pybullet") is None:
        pytest.skip("pybullet is not installed")


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
