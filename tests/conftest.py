from __future__ import annotations

import importlib.util

import pytest


def pytest_runtest_setup(item):
    if item.get_closest_marker("needs_bullet") and importlib.util.find_spec("pybullet") is None:
        pytest.skip("pybullet is not installed")
