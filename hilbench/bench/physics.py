"""What a bench says of its physics, and what it does where the library for it is missing."""

from __future__ import annotations

from hilbench.errors import UnavailableError
from worlds import default_physics, engine_of, physics_is_there

__all__ = ["describe_physics", "physics_capabilities", "require_physics"]

_OF_BODIES = frozenset({"rays", "contacts", "gravity", "torque"})


def describe_physics(physics: str, step_hz: int) -> str:
    """Return which physics with which library, in which steps, as reports have it in their first line."""
    engine = engine_of(physics)
    text = f"{physics} ({engine}) at {step_hz} Hz" if engine else f"{physics} at {step_hz} Hz"
    return f"{text} (an endless floor without rays and contacts)" if physics == "plane" else text


def physics_capabilities(physics: str) -> frozenset[str]:
    """Return what a world of this physics can do, without opening one (`worlds.world.World.capabilities`)."""
    return frozenset() if physics == "plane" else _OF_BODIES


def require_physics(physics: str) -> None:
    """Make sure that the library for this physics is installed.

    Raises:
        UnavailableError: it is not; the hint says what to do.
    """
    if physics_is_there(physics):
        return
    title, other = engine_of(physics).partition(",")[0], default_physics()
    install = f"pip install 'hilbench[{_EXTRAS[physics]}]'"
    instead = f'leave out physics = "{physics}", and it is {other}; or ' if physics_is_there(other) else ""
    raise UnavailableError(f"{title} is not installed", where=f'physics = "{physics}"', hint=f"{instead}{install}")


_EXTRAS = {"bullet": "physics-source", "mujoco": "mujoco"}
"""Which extra of ours brings a library."""
