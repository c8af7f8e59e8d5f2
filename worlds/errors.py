"""Errors of the worlds package.

::

    WorldError                  anything the simulated surroundings can refuse
    ├── UnknownNameError        no such scene, vehicle, physics, joint or part (also a LookupError)
    ├── SceneFileError          a scene file that cannot be read or is not a scene (also a ValueError)
    ├── PhysicsMissingError     the physics library is not installed (also an ImportError)
    ├── PhysicsOutputError      the physics library warned while loading; its warnings mean wrong motion
    └── CapabilityError         this world has no rays, no contacts or no torques

The text of each is one line that names the thing and, where there is one, the way out.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class WorldError(Exception):
    """Base of everything this package raises on purpose.

    Example scenarios: stepping a world that was closed; a wheel speed that is not a number.
    """


class UnknownNameError(WorldError, LookupError):
    """A name that is not in its table; the nearest one is named.

    Args:
        kind: what was looked up, for example ``scene``.
        name: the name that is not there.
        known: the names that are.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        near = difflib.get_close_matches(name, names, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(names) or 'none'}"
        super().__init__(f"unknown {kind} {name!r}: {hint}")


class SceneFileError(WorldError, ValueError):
    """A scene file is unreadable, is not TOML, or has a key or value that does not belong."""


class PhysicsMissingError(WorldError, ImportError):
    """The physics library cannot be imported; the text says how to install it."""


class PhysicsOutputError(WorldError):
    """The physics library printed a warning while loading.

    PyBullet reports a bad inertia or a missing file only as text and carries on with wrong motion, so the text is an
    error here.
    """


class CapabilityError(WorldError):
    """The world cannot answer this question, for example rays in a world without obstacles."""
