"""What is done to a real board before it is tested: reset by the lines beside the data, by a probe, by a relay.

A hook is a list of steps in the bench file, one after the other:

- ``dtr on``, ``rts off``, ``dtr off rts on``: levels of the lines; two in one step are set at once.
- ``break 250ms``: the line is held low.
- ``wait 100ms``: time passes.
- ``run COMMAND``: a program, such as one that switches a relay or resets by a probe; it has to end with status 0.
"""

from __future__ import annotations

import re
import shlex
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hilbench.clock import NS_PER_S
from hilbench.errors import UnavailableError
from hilbench.terminal.arguments import duration_ns

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.links import Port

__all__ = ["COMMAND_LIMIT_S", "Step", "parse_step", "run_hook"]

COMMAND_LIMIT_S = 60.0
"""How long a command may take, in seconds (choice)."""
_LINES = re.compile(r"(?P<lines>(dtr|rts) (on|off)( (dtr|rts) (on|off))?)")
_TIMED = re.compile(r"(?P<what>break|wait) (?P<span>\S+)")
_RUN = re.compile(r"run (?P<command>\S.*)", re.DOTALL)


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One step of a hook: one of these.

    Attributes:
        dtr: level of DTR; None leaves it.
        rts: level of RTS; None leaves it.
        break_ns: how long the line is held low, in ns.
        wait_ns: how long nothing is done, in ns.
        command: words of a program.
    """

    dtr: bool | None = None
    rts: bool | None = None
    break_ns: int = 0
    wait_ns: int = 0
    command: tuple[str, ...] = ()


def parse_step(text: str) -> Step:
    """Read a step.

    Raises:
        ValueError: it is none; the message says what there is.
    """
    if match := _LINES.fullmatch(text):
        words = match["lines"].split()
        levels = {name: level == "on" for name, level in zip(words[::2], words[1::2], strict=True)}
        if len(levels) * 2 != len(words):
            raise ValueError(f"'{text}' sets one line twice")
        return Step(dtr=levels.get("dtr"), rts=levels.get("rts"))
    if match := _TIMED.fullmatch(text):
        span_ns = duration_ns(match["span"])
        return Step(break_ns=span_ns) if match["what"] == "break" else Step(wait_ns=span_ns)
    if match := _RUN.fullmatch(text):
        return Step(command=tuple(shlex.split(match["command"])))
    raise ValueError(
        f"'{text}' is no step; steps are like 'dtr on', 'dtr off rts on', 'break 250ms', 'wait 1s', 'run CMD'"
    )


def run_hook(bench: Bench, port: Port, name: str, steps: Sequence[str]) -> None:
    """Do what a hook says, and record that it was done.

    Args:
        bench: whose time passes.
        port: the line to the board.
        name: what the hook is for: ``boot`` or ``reset``.
        steps: as in the bench file.

    Raises:
        UnavailableError: the port has no such lines or is gone, or a command failed.
    """
    if not steps:
        return
    bench.record("hook", "port", name=name, steps=tuple(steps))
    for text in steps:
        _do(bench, port, parse_step(text), f"[port] {name}")


def _do(bench: Bench, port: Port, step: Step, where: str) -> None:
    if step.command:
        _run(step.command, where)
    elif step.wait_ns:
        bench.run_for(step.wait_ns / NS_PER_S)
    elif not port.line_is_up:
        raise UnavailableError("the port is gone", where=where)
    elif step.break_ns:
        port.send_break(step.break_ns)
        bench.run_for(step.break_ns / NS_PER_S)
    else:
        port.set_lines(dtr=step.dtr, rts=step.rts)


def _run(command: Sequence[str], where: str) -> None:
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, timeout=COMMAND_LIMIT_S, check=False, text=True,
            errors="replace",
        )  # fmt: skip
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise UnavailableError(f"{command[0]} cannot be run: {reason}", where=where) from error
    except subprocess.TimeoutExpired as error:
        raise UnavailableError(f"{command[0]} did not end within {COMMAND_LIMIT_S:g} s", where=where) from error
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        words = f": {said[-1]}" if said else ""
        raise UnavailableError(f"{command[0]} ended with status {done.returncode}{words}", where=where)
