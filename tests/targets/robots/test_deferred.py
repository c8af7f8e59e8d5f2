"""Packages of models whose modules are imported when they are asked for: every name is there, and none is too much."""

from __future__ import annotations

import importlib

import pytest

from protocols.carla import BAUD
from targets.robots.deferred import deferred
from targets.robots.vehicle_interface import LINE_BAUD
from tests.each import each

PACKAGES = ("rover", "vehicle_interface", "car_host")


@each("package", PACKAGES)
def test_every_name_that_is_offered_is_there(package):
    module = importlib.import_module(f"targets.robots.{package}")
    for name in module.__all__:
        assert getattr(module, name) is not None
        assert name in vars(module)  # the next time it is found at once


@each("package", PACKAGES)
def test_other_names_are_not_there(package):
    module = importlib.import_module(f"targets.robots.{package}")
    with pytest.raises(AttributeError, match=f"module 'targets.robots.{package}' has no attribute 'nothing'"):
        module.nothing  # noqa: B018 - it is the asking that is wrong


def test_a_home_without_the_name_is_a_mistake_of_ours():
    get = deferred("targets.robots.rover", {"Ghost": "settings"})
    with pytest.raises(AttributeError, match="Ghost"):
        get("Ghost")


def test_the_rate_of_the_lines_is_that_of_the_protocol():
    assert LINE_BAUD == BAUD
