from __future__ import annotations

import importlib.util
import os

import pytest
from hypothesis import settings

# Time on the host is nothing to judge by, and a change is judged by the same examples whenever it is judged: see the
# rules for tests in CONTRIBUTING.md. `make search` looks for new examples.
settings.register_profile("hilbench", deadline=None, derandomize=True)
settings.register_profile("search", deadline=None, print_blob=True)
ASKED_FOR_BY = {"thorough": "HILBENCH_THOROUGH", "exhaustive": "HILBENCH_EXHAUSTIVE"}

settings.load_profile("search" if os.environ.get("HILBENCH_SEARCH") else "hilbench")


def pytest_runtest_setup(item):
    if item.get_closest_marker("needs_bullet") and importlib.util.find_spec("pybullet") is None:
        pytest.skip("pybullet is not installed")


def pytest_collection_modifyitems(config, items):
    """Leave out what is marked `thorough` or `exhaustive`, unless it is asked for."""
    unwanted = {mark for mark, variable in ASKED_FOR_BY.items() if not os.environ.get(variable)}
    left_out = [item for item in items if not unwanted.isdisjoint(mark.name for mark in item.iter_markers())]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if unwanted.isdisjoint(mark.name for mark in item.iter_markers())]
