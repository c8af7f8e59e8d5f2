"""Which port each line of the checker gets: ``--target LINE=serial:PORT`` on a bench that has several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hilbench.errors import UsageError
from hilbench.nearest import did_you_mean
from hilbench.terminal.options import TargetChoice

__all__ = ["ports_of_lines"]


def ports_of_lines(lines: Sequence[str], choices: Sequence[TargetChoice]) -> Mapping[str, str]:
    """Return the TARGET of each line.

    Args:
        lines: the names of the lines, as in ``peer.LINE``.
        choices: what the command line puts at their far ends.

    Raises:
        UsageError: a choice names no line or one that is not there, two name the same, or a line is left over.
    """
    asked = " ".join(f"--target {line}=..." for line in lines)
    found: dict[str, str] = {}
    for choice in choices:
        where = choice.where
        if not choice.name:
            raise UsageError(f"does not say which line, of {' and '.join(lines)}", where=where, hint=f"write {asked}")
        if choice.name not in lines:
            raise UsageError(f"no line '{choice.name}'", where=where, hint=did_you_mean(choice.name, lines, "lines"))
        if choice.name in found:
            raise UsageError(f"the line '{choice.name}' has a port already, {found[choice.name]}", where=where)
        if choice.spec in found.values():
            raise UsageError("two lines at one port", where=where, hint=f"write {asked}")
        found[choice.name] = choice.spec
    for line in lines:
        if line not in found:
            raise UsageError(f"nothing at the line '{line}'", where="--target", hint=f"add --target {line}=serial:PORT")
    return found
