"""For plain pytest: ``pytest -p hilbench.pytest_plugin`` gives your tests the fixtures of ``hilbench check``.

A test with `hilbench.check.case` above it gets a bench; what the bench lacks is skipped, and says what is missing.
Everything else (selection, reports, exit codes) is pytest's own.
"""

from __future__ import annotations

import pytest

from hilbench.arguments import target_choice
from hilbench.errors import HilbenchError
from hilbench.siblings import check_siblings


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options that choose the bench."""
    add = parser.getgroup("hilbench").addoption
    add("--hilbench-bench", metavar="BENCH", help="built-in bench or bench file (default: as hilbench check)")
    add("--hilbench-target", metavar="[NAME=]T", action="append", default=[], help="target to check instead")
    add("--hilbench-seed", metavar="N", type=int, default=0, help="seed of the run (default: 0)")
    add("--hilbench-timeout-scale", metavar="X", type=float, default=1.0, help="wait X times longer (default: 1)")


def pytest_configure(config: pytest.Config) -> None:
    """Make the bench provider and register the plugin proper."""
    try:
        check_siblings()
        _register(config)
    except (HilbenchError, ValueError) as error:
        code = error.exit_code if isinstance(error, HilbenchError) else 2
        pytest.exit(f"hilbench: {error}", returncode=int(code))


def _register(config: pytest.Config) -> None:
    from hilbench.bench_provider import make_provider
    from hilbench.check.collector import Collector
    from hilbench.check.plugin import CheckPlugin
    from hilbench.options import CheckOptions

    options = CheckOptions(
        bench=config.getoption("--hilbench-bench"),
        targets=tuple(target_choice(text) for text in config.getoption("--hilbench-target")),
        seed=config.getoption("--hilbench-seed"),
        timeout_scale=config.getoption("--hilbench-timeout-scale"),
    )
    provider = make_provider(options)
    config.add_cleanup(provider.close)
    plugin = CheckPlugin(Collector(), provider, seed=options.seed, only_cases=False)
    config.pluginmanager.register(plugin, "hilbench-check")
