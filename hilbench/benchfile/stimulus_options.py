"""The options of commands that let something happen to emulated boards from outside."""

from __future__ import annotations

import argparse
import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hilbench.benchfile.bench_file import BenchFile
    from hilbench.benchfile.stimulus import Action, Stimulus
    from hilbench.terminal.parser import Parser

__all__ = ["add_stimuli", "with_stimuli"]

_BARE_VOLTS = re.compile(r"=\d+(\.\d+)?$", re.ASCII)


def add_stimuli(parser: Parser) -> None:
    """Add ``--at``, ``--volts``, ``--send`` and ``--stimuli``."""

    def add(option: str, metavar: str, text: str) -> None:
        parser.add_argument(option, metavar=metavar, action="append", default=[], help=text)

    add("--at", "TIME:WHAT=VALUE",
        "do something to a board: 1s:PC13=0/50ms, PA0=1kHz/25%%, 2s:reset=press (docs/stimuli.md)")  # fmt: skip
    add("--volts", "PIN=VOLTS", "put a voltage at a pin: PA0=1.65, 1s:PA0=0V..3.3V/2s")
    add("--send", "[TIME:]USART=TEXT", r"send to a serial line: 'usart1=AT\r\n', 1s:usart1=hex:0d0a, usart2=@FILE")
    add("--stimuli", "FILE", "do what a file says, as --write-stimuli writes it")


def with_stimuli(parsed: argparse.Namespace, bench_file: BenchFile) -> BenchFile:
    """Return a bench with the stimuli of a command line, beside its own.

    Raises:
        UsageError: one of them is none, or not one for this bench; the option or the line of the file is named.
    """
    stimuli = (*bench_file.stimuli, *_of_options(parsed, bench_file), *_of_files(parsed.stimuli, bench_file))
    return dataclasses.replace(bench_file, stimuli=stimuli)


def _of_options(parsed: argparse.Namespace, bench_file: BenchFile) -> Iterator[Stimulus]:
    from hilbench.benchfile.stimulus import Hold, Ramp, Send, parse_stimulus
    from hilbench.errors import UsageError

    def are_volts(action: Action) -> bool:
        return isinstance(action, Ramp) or (isinstance(action, Hold) and isinstance(action.value, float))

    def is_sent(action: Action) -> bool:
        return isinstance(action, Send)

    volts = [f"{text}V" if _BARE_VOLTS.search(text) else text for text in parsed.volts]
    for option, texts, fits, what in (
        ("--at", parsed.at, lambda _action: True, ""),
        ("--volts", volts, are_volts, "no voltage at a pin"),
        ("--send", parsed.send, is_sent, "nothing for a serial line"),
    ):
        for text in texts:
            try:
                stimulus = parse_stimulus(text, bench_file.boards, Path())
            except ValueError as error:
                raise UsageError(str(error), where=option) from None
            if not fits(stimulus.action):
                raise UsageError(f"'{text}' is {what}", where=option, hint="--at takes any stimulus")
            yield stimulus


@dataclasses.dataclass(frozen=True, slots=True)
class _StimulusFile:
    stimuli: tuple[str, ...] = ()


def _of_files(files: list[str], bench_file: BenchFile) -> Iterator[Stimulus]:
    from hilbench.benchfile.stimulus import parse_stimulus
    from hilbench.files.names import file_name
    from hilbench.strict import Strict
    from hilbench.strict.toml_file import TomlFile

    for name in files:
        file = TomlFile(Path(file_name(name)), "file of stimuli")
        strict = Strict(file.place)
        for number, text in enumerate(strict.convert(file.data, _StimulusFile).stimuli):
            try:
                yield parse_stimulus(text, bench_file.boards, file.path.parent)
            except ValueError as error:
                raise strict.error(str(error), ("stimuli", number)) from None
