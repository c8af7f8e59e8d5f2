"""Which tests the gate runs, and with which examples.

`make test` leaves out what is marked ``exhaustive``; `make exhaustive` runs everything. docs/testing.md lists what is
left out, and `tests/packaging/test_tiers.py` holds that list against the marks.
"""

from __future__ import annotations

import functools
import gc
import itertools
import os
import sys

import pytest
from _pytest import runner
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

from hilbench.check.room import with_room
from tests.rigid import skip_without_its_library
from tests.share import examples

# Time on the host is nothing to judge by, and a change is judged by the same examples whenever it is judged: see the
# rules for tests in CONTRIBUTING.md. `make search` looks for new examples.
BY_THE_CLOCK = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("hilbench", **BY_THE_CLOCK, derandomize=True, max_examples=examples(100))
settings.register_profile("search", **BY_THE_CLOCK, print_blob=True)
settings.load_profile("search" if os.environ.get("HILBENCH_SEARCH") else "hilbench")
if not os.environ.get("HILBENCH_SEARCH"):
    # Hypothesis mixes in numbers and words of the modules that are loaded: which those are depends on the tests that a
    # worker had before. Reading them also takes a tenth of the time of collecting.
    providers._get_local_constants = functools.partial(getattr, providers, "_local_constants")

EXHAUSTIVE = "HILBENCH_EXHAUSTIVE"
WITH_A_REASON = ("exhaustive", "slow", "real_time")
MARKED = pytest.StashKey[dict[str, dict[str, list[str]]]]()
HEAVY = ("mujoco", "pybullet", "textual", "unicorn")
LEFT_OUT = pytest.StashKey[dict[str, dict[str, str]]]()
SETS_LEFT_OUT = pytest.StashKey[dict[str, dict[str, list[str]]]]()
LOADED = pytest.StashKey[list[str]]()


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Keep what `check` remembers of cases that failed away from whoever runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


def pytest_runtest_setup(item):
    skip_without_its_library(item)


@pytest.hookimpl(wrapper=True)
def pytest_collection(session):
    """Collect the tests without a look for garbage: there is hardly any, and that takes a sixth of the time."""
    session.config.stash[LEFT_OUT] = {kind: {} for kind in WITH_A_REASON}
    session.config.stash[SETS_LEFT_OUT] = {kind: {} for kind in WITH_A_REASON}
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makeitem(collector, name, obj):
    """Make no tests of a function or class that the gate leaves out as a whole, and note what it is marked with."""
    marks = {mark.name: mark for mark in getattr(obj, "pytestmark", ())}
    if "exhaustive" not in marks or not name.startswith(("test_", "Test")):
        return None
    for kind in WITH_A_REASON:
        if kind in marks:
            collector.config.stash[LEFT_OUT][kind][f"{collector.nodeid}::{name}"] = reason_of(marks[kind], name)
    return None if by_name_or_all(collector.config) else []


@pytest.hookimpl(wrapper=True)
def pytest_generate_tests(metafunc):
    """Make no test of a parameter set that the gate leaves out, and note what it is marked with."""
    yield
    config, sets = metafunc.config, metafunc._calls
    kept = [one for one in sets if "exhaustive" not in {mark.name for mark in one.marks}]
    if len(kept) in (0, len(sets)) or by_name_or_all(config):
        return
    test = metafunc.definition.nodeid
    for one in sets:
        marks = marks_of(metafunc.definition) | {mark.name: mark for mark in one.marks}
        for kind in WITH_A_REASON:
            if "exhaustive" in marks and kind in marks:
                config.stash[SETS_LEFT_OUT][kind].setdefault(test, []).append(reason_of(marks[kind], test))
    sets[:] = kept


def pytest_collection_modifyitems(config, items):
    """Note the reasons that tests are marked with, and leave out what is marked ``exhaustive``."""
    marks = [(item, marks_of(item)) for item in items]
    config.stash[MARKED] = {name: reasons(marks, name, config.stash[SETS_LEFT_OUT][name]) for name in WITH_A_REASON}
    config.stash[LOADED] = [name for name in HEAVY if name in sys.modules]
    if os.environ.get(EXHAUSTIVE):
        return
    left_out = [item for item, has in marks if "exhaustive" in has]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item, has in marks if "exhaustive" not in has]
    items[:] = slow_first(items, {item.path for item, has in marks if "slow" in has}, workers())


def workers():
    """Return among how many processes the tests are distributed."""
    return int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))


def slow_first(items, slow_files, shares):
    """Put files with slow tests at the beginning of each worker's share, or one of them would be waited for at the end.

    Args:
        items: the tests.
        slow_files: where tests are that take over a second.
        shares: how many equal shares pytest-xdist makes at first, in the order of the tests.
    """
    files = [[*tests] for _, tests in itertools.groupby(items, key=lambda item: item.path)]
    slow = [tests for tests in files if tests[0].path in slow_files]
    quick = iter([tests for tests in files if tests[0].path not in slow_files])
    found = []
    for share in range(shares):
        found += itertools.chain.from_iterable(slow[share::shares])
        while len(found) < len(items) * (share + 1) / shares and (tests := next(quick, None)):
            found += tests
    return [*found, *itertools.chain.from_iterable(quick)]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item, nextitem):
    return with_room(runner.pytest_runtest_protocol, item, nextitem)


def pytest_collection_finish():
    """Spare the garbage collector some hundred thousand objects of the collection, which live as long as the tests.

    What a test makes is collected less often, too: that takes a twentieth of the time otherwise.
    """
    gc.freeze()
    gc.set_threshold(20_000, 20, 50)


def by_name_or_all(config):
    """Say whether the tests that the gate leaves out are asked for: each that is named, or all."""
    return bool(os.environ.get(EXHAUSTIVE)) or any("::" in argument for argument in config.args)


def marks_of(item):
    """Return the marks of a test by name; of two with one name the closest."""
    found: dict[str, pytest.Mark] = {}
    for mark in item.iter_markers():
        found.setdefault(mark.name, mark)
    return found


def reasons(marks, name, left_out):
    """Return the reason of each marked test, by its function; one line for each parameter set that has the mark."""
    found = {test: list(said) for test, said in left_out.items()}
    for item, has in marks:
        if mark := has.get(name):
            found.setdefault(item.nodeid.partition("[")[0], []).append(reason_of(mark, item.nodeid))
    return found


def reason_of(mark, test):
    if len(mark.args) == 1 and isinstance(mark.args[0], str):
        return mark.args[0]
    message = f"{test}: say why: @pytest.mark.{mark.name}('the reason')"
    raise pytest.UsageError(message)
