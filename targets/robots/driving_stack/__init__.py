"""The driving stack's stand-in: a driver that follows a path, between reports and commands of `protocols.autoware`.

Poses and speeds in, commands out; what carries them, and when, is the business of whoever uses it.
"""

from __future__ import annotations

from targets.robots.driving_stack.driver import PathDriver, Pose
from targets.robots.driving_stack.path import Path, PathError, Place
from targets.robots.driving_stack.profile import SpeedProfile
from targets.robots.driving_stack.settings import DriverSettings

__all__ = ["DriverSettings", "Path", "PathDriver", "PathError", "Place", "Pose", "SpeedProfile"]
