"""Virtual targets that are no emulated boards, as something that can be put at the end of a line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from hilbench.bench import Bench
from hilbench.links import Port

__all__ = ["HOST_LINE", "ServedTarget"]

HOST_LINE = "host"
"""The line of a target that has one alone."""


@dataclass(frozen=True, slots=True)
class ServedTarget:
    """A virtual target and its lines.

    Attributes:
        lines: the rate of each of its lines, bit/s, by name.
        make: brings it to life at the far ends of these lines, and returns how to end it.
        source: its source in the journal, if what it receives is to be recorded as well.
        may_be_open: nothing is missing where some of its lines lead nowhere.
        one_client: a line makes sense with one client at a time: another one is turned away, unless the newest is to
            take over.
        in_dds: makes a target of it whose topics are those of a DDS domain as well, given the number of that (or
            `hilbench.terminal.options.ITS_DOMAINS`) and who is told what goes wrong; None where it has no topics.
    """

    lines: Mapping[str, int]
    make: Callable[[Bench, Mapping[str, Port]], Callable[[], None]]
    source: str = ""
    may_be_open: bool = False
    one_client: bool = False
    in_dds: Callable[[int, Callable[[str], None]], ServedTarget] | None = None
