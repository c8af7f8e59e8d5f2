"""For plain pytest: ``pytest --hil-bench BENCH`` gives your tests the fixtures of ``hilbench check``.

Where hilbench is installed the option is there (`hilbench.pytest_options`), and loads this.

A test with `hilbench.check.case` above it gets a bench; what the bench lacks is skipped, and says what is missing.
A test of firmware asks for `board` (see `hilbench.mcu.fixtures`) and needs nothing above it. Everything else
(selection, reports, exit codes) is pytest's own. A test file may also load the plugin itself, with
``pytest_plugins = ["hilbench.pytest_plugin"]``, and so may ``pytest -p hilbench.pytest_plugin``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from hilbench.cli.siblings import check_siblings
from hilbench.errors import HilbenchError
from hilbench.pytest_options import OWN, add_options
from hilbench.terminal.arguments import target_choice

if TYPE_CHECKING:
    from hilbench.judging.provider import BenchProvider
    from hilbench.terminal.options import CheckOptions


def pytest_addoption(parser: pytest.Parser, pluginmanager: pytest.PytestPluginManager) -> None:
    """Add the options that choose the bench, unless pytest has loaded those of the installed distribution."""
    if not any(map(pluginmanager.has_plugin, OWN)):
        add_options(parser)


def pytest_configure(config: pytest.Config) -> None:
    """Make the bench provider and register the plugin proper."""
    try:
        check_siblings()
        _register(config)
    except (HilbenchError, ValueError) as error:
        code = error.exit_code if isinstance(error, HilbenchError) else 2
        pytest.exit(f"hilbench: {error}", returncode=int(code))


def _register(config: pytest.Config) -> None:
    from hilbench.check.collector import Collector
    from hilbench.check.plugin import CheckPlugin
    from hilbench.mcu.fixtures import BoardFixtures
    from hilbench.terminal.options import CheckOptions

    options = CheckOptions(
        bench=config.getoption("--hil-bench", None),
        targets=tuple(target_choice(text) for text in config.getoption("--hil-target", None) or ()),
        seed=config.getoption("--hil-seed", 0),
        timeout_scale=config.getoption("--hil-timeout-scale", 1.0),
    )
    provider = _provider(options)
    config.add_cleanup(provider.close)
    plugin = CheckPlugin(Collector(), provider, seed=options.seed, only_cases=False)
    config.pluginmanager.register(plugin, "hilbench-check")
    config.pluginmanager.register(BoardFixtures(options.bench, options.seed), "hilbench-boards")


def _provider(options: CheckOptions) -> BenchProvider:
    """Return what opens benches for cases; on a bench of boards alone there are none."""
    from hilbench.check.bench_provider import make_provider
    from hilbench.mcu.command_line import open_target
    from hilbench.mcu.no_cases import NoCases

    if not options.targets and open_target(options.bench).boards:
        return NoCases()
    return make_provider(options)
