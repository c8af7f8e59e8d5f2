"""What pytest loads wherever hilbench is installed: the options, and the fixtures where one of them is given.

``pytest --hil-bench my.toml`` is all that a project needs. Without these options nothing of hilbench is imported but
this file, no fixture is there, and no test is touched; `hilbench check` runs pytest without it.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TypeVar

import pytest

ValueT = TypeVar("ValueT")

FULL = "hilbench.pytest_plugin"
"""The plugin proper, which may be loaded by its name instead, and then brings the options along."""
OWN = ("hilbench", "hilbench.pytest_options")
"""The names by which pytest knows this one: of its entry point, or of the module where it is loaded with ``-p``."""


def add_options(parser: pytest.Parser) -> None:
    """Add the options that choose the bench, with the names that they had before."""
    add = parser.getgroup("hilbench").addoption
    add("--hil-bench", "--hilbench-bench", metavar="BENCH",
        help="built-in bench or bench file (default: as hilbench check)")  # fmt: skip
    add("--hil-target", "--hilbench-target", metavar="[NAME=]T", action="append", default=[],
        help="target to check instead")  # fmt: skip
    add("--hil-seed", "--hilbench-seed", metavar="N", type=_seed, default=0, help="seed of the run (default: 0)")
    add("--hil-timeout-scale", "--hilbench-timeout-scale", metavar="X", type=_timeout_scale, default=1.0,
        help="wait X times longer (default: 1)")  # fmt: skip


def _seed(text: str) -> int:
    from hilbench.terminal.arguments import seed

    return _understood(seed, text)


def _timeout_scale(text: str) -> float:
    from hilbench.terminal.arguments import timeout_scale

    return _understood(timeout_scale, text)


def _understood(read: Callable[[str], ValueT], text: str) -> ValueT:
    """Read a value as the command line of hilbench does, and say what is wrong in its words."""
    try:
        return read(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def pytest_addoption(parser: pytest.Parser, pluginmanager: pytest.PytestPluginManager) -> None:
    """Add the options, unless the plugin proper is there and has done so."""
    if not pluginmanager.has_plugin(FULL):
        add_options(parser)


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Load the plugin proper if it is asked for."""
    if config.getoption("--hil-bench") or config.getoption("--hil-target"):
        config.pluginmanager.import_plugin(FULL)
