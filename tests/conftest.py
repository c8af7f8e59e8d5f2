"""Which tests the gate runs, and with which examples.

`make test` leaves out what is marked ``exhaustive``; `make exhaustive` runs everything. docs/testing.md lists what is
left out, and `tests/packaging/test_tiers.py` holds that list against the marks.
"""

from __future__ import annotations

import gc
import os
import sys

import pytest
from _pytest import runner
from hypothesis import HealthCheck, settings

from hilbench.check.room import with_room
from tests.rigid import skip_without_its_library
from tests.share import examples

# Time on the host is nothing to judge by, and a change is judged by the same examples whenever it is judged: see the
# rules for tests in CONTRIBUTING.md. `make search` looks for new examples.
BY_THE_CLOCK = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("hilbench", **BY_THE_CLOCK, derandomize=True, max_examples=examples(100))
settings.register_profile("search", **BY_THE_CLOCK, print_blob=True)
settings.load_profile("search" if os.environ.get("HILBENCH_SEARCH") else "hilbench")

EXHAUSTIVE = "HILBENCH_EXHAUSTIVE"
WITH_A_REASON = ("exhaustive", "slow", "real_time")
MARKED = pytest.StashKey[dict[str, dict[str, list[str]]]]()
HEAVY = ("mujoco", "pybullet", "textual", "unicorn")
LOADED = pytest.StashKey[list[str]]()


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Keep what `check` remembers of cases that failed away from whoever runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


def pytest_runtest_setup(item):
    skip_without_its_library(item)


def pytest_collection_modifyitems(config, items):
    """Note the reasons that tests are marked with, and leave out what is marked ``exhaustive``."""
    config.stash[MARKED] = {name: reasons(items, name) for name in WITH_A_REASON}
    config.stash[LOADED] = [name for name in HEAVY if name in sys.modules]
    if os.environ.get(EXHAUSTIVE):
        return
    left_out = [item for item in items if item.get_closest_marker("exhaustive")]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if not item.get_closest_marker("exhaustive")]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    return with_room(runner.pytest_runtest_protocol, item, nextitem)


def pytest_collection_finish():
    """Spare the garbage collector some hundred thousand objects of the collection, which live as long as the tests.

    What a test makes is collected less often, too: that takes a twentieth of the time otherwise.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 50)


def reasons(items, name):
    """Return the reason of each marked test, by its function; one line for each parameter set that has the mark."""
    found: dict[str, list[str]] = {}
    for item in items:
        mark = item.get_closest_marker(name)
        if mark is None:
            continue
        if len(mark.args) != 1 or not isinstance(mark.args[0], str):
            message = f"{item.nodeid}: say why: @pytest.mark.{name}('the reason')"
            raise pytest.UsageError(message)
        found.setdefault(item.nodeid.partition("[")[0], []).append(mark.args[0])
    return found
