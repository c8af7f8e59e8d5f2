from __future__ import annotations

import importlib.util

import pytest
from hypothesis import settings

# Time on the host is nothing to judge by: see the rules for tests in CONTRIBUTING.md.
settings.register_profile("hilbench", deadline=None)
settings.load_profile("hilbench")


def pytest_runtest_setup(item):
    if item.get_closest_marker("needs_bullet") and importlib.util.find_spec("pybullet") is None:
        pytest.skip("pybullet is not installed")
