from __future__ import annotations

import importlib.util
import os

import pytest
from hypothesis import settings

# Time on the host is nothing to judge by: see the rules for tests in CONTRIBUTING.md.
settings.register_profile("hilbench", deadline=None)
settings.load_profile("hilbench")


def pytest_runtest_setup(item):
    if item.get_closest_marker("needs_bullet") and importlib.util.find_spec("pybullet") is None:
        pytest.skip("pybullet is not installed")


def pytest_collection_modifyitems(config, items):
    """Leave out what is marked `thorough`, unless HILBENCH_THOROUGH is set, as `.ci/run` does."""
    if os.environ.get("HILBENCH_THOROUGH"):
        return
    left_out = [item for item in items if item.get_closest_marker("thorough")]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if not item.get_closest_marker("thorough")]
