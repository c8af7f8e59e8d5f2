"""Whether this process is one of the command ``hilbench``, which may set how the system runs it.

A program that embeds the command line, and a test, runs it in a process of its own making: there nothing is changed.
"""

from __future__ import annotations

__all__ = ["claim", "is_ours"]

_ours = False


def claim() -> None:
    """Say that this process runs the command and nothing else."""
    global _ours  # noqa: PLW0603 - of the process, as what it says
    _ours = True


def is_ours() -> bool:
    """Say whether it does."""
    return _ours
