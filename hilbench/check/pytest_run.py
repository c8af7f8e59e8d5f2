"""Runs pytest as an engine: our configuration, our root, our plugin, and nothing of the user's around it."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from hilbench.check.neighbours import Neighbours
from hilbench.check.plugin import CheckPlugin
from hilbench.check.room import with_room
from hilbench.check.way import Way

_INI = Path(__file__).with_name("pytest.ini")

# Each of these lets the surroundings change what pytest does.
_FOREIGN_VARIABLES = ("PYTEST_ADDOPTS", "PYTEST_PLUGINS", "PYTEST_DEBUG", "PYTEST_THEME", "PYTEST_THEME_MODE")

# What no case can use; each takes its time whenever suites are read.
_LEFT_OUT = (
    "cacheprovider",
    "doctest",
    "faulthandler",
    "junitxml",
    "legacypath",
    "pastebin",
    "setuponly",
    "setupplan",
    "stepwise",
    "unraisableexception",
    "warnings",
)

_ARGUMENTS = (
    "-c",
    str(_INI),
    "--rootdir",
    str(_INI.parent),
    "--noconftest",
    "--import-mode=importlib",
    "--assert=rewrite",
    "--capture=fd",
    "--color=no",
    "--no-header",
    "--no-summary",
    "--tb=no",  # nobody reads it, and drawing it takes longer than many a case
    "-q",
    *(word for plugin in _LEFT_OUT for word in ("-p", f"no:{plugin}")),
)


def run_pytest(
    files: Sequence[Path], plugin: CheckPlugin, *, collect_only: bool = False, more: Sequence[object] = ()
) -> str:
    """Run the suites in the given files or folders; the plugin's collector holds what came of it.

    Pytest's own exit code means nothing here: whatever happened has reached the plugin.

    Args:
        files: where the suites are, as absolute paths.
        plugin: gives cases their bench and takes their results.
        collect_only: run nothing.
        more: further plug-ins of pytest.

    Returns:
        What pytest printed, for the account of a defect.
    """
    arguments = [*_ARGUMENTS, *(["--collect-only"] if collect_only else []), *(str(file) for file in files)]
    printed = io.StringIO()
    with _own_environment(), contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        with_room(pytest.main, arguments, plugins=[plugin, Neighbours(), Way(files), *more])
    return printed.getvalue()


@contextlib.contextmanager
def _own_environment() -> Iterator[None]:
    before = {name: os.environ.pop(name, None) for name in (*_FOREIGN_VARIABLES, "PYTEST_DISABLE_PLUGIN_AUTOLOAD")}
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    try:
        yield
    finally:
        del os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"]
        os.environ.update({name: value for name, value in before.items() if value is not None})
