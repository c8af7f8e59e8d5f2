"""An argument parser that says what is wrong in one line and hints at what was meant."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NoReturn, TypeVar

from hilbench.errors import UsageError
from hilbench.nearest import did_you_mean
from hilbench.terminal.console import Console

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

ValueT = TypeVar("ValueT")

_ABOUT = re.compile(r"argument (?P<option>\S+): (?P<what>.*)", re.DOTALL)
_UNKNOWN = re.compile(r"unrecognized arguments: (?P<words>.*)", re.DOTALL)
_MISSING = re.compile(r"the following arguments are required: (?P<names>.*)")


class Parser(argparse.ArgumentParser):
    """Parses the options of one command.

    Args:
        command: the command, as ``hilbench check``.
        summary: what it does, in a sentence.
        examples: how it is used, one a line.
        notes: further paragraphs under the options.
    """

    def __init__(self, command: str, summary: str, examples: str, notes: str = "") -> None:
        self._command = command.removeprefix("hilbench ")
        indented = "".join(f"\n  {line}" for line in examples.strip().splitlines())
        super().__init__(
            prog=command,
            description=summary,
            epilog=f"examples:{indented}" + (f"\n\n{notes.strip()}" if notes else ""),
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        # -1s and -1 are values, and wrong ones mostly: then it is their option that has to say so.
        self._negative_number_matcher = re.compile(r"-\d")

    @property
    def arguments(self) -> Sequence[argparse.Action]:
        """All arguments and options, in the order in which they were added."""
        return tuple(self._actions)

    def add_plain(self) -> None:
        """Add ``--plain``; the command line itself does what it says."""
        self.add_argument(
            "--plain",
            action="store_true",
            help="print to a terminal as into a file: no colours, no line that changes, no text that is cut",
        )

    def parse_words(self, words: Sequence[str]) -> argparse.Namespace:
        """Read a command line; options may stand anywhere among the other words, and none behind ``--``.

        Raises:
            UsageError: it is wrong.
        """
        # argparse fills a positional that may be left out as soon as it meets the one before it.
        return self.parse_args(words) if "--" in words else self.parse_intermixed_args(words)

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the command line.

        Raises:
            UsageError: always.
        """
        if unknown := _UNKNOWN.match(message):
            raise self._unknown(unknown["words"])
        if missing := _MISSING.match(message):
            raise UsageError(f"{missing['names']} is missing", where=self._command, hint=f"see '{self.prog} --help'")
        if about := _ABOUT.match(message):
            # -k/--select: one name is enough
            raise UsageError(about["what"], where=about["option"].partition("/")[0])
        raise UsageError(message, where=self._command)

    def print_help(self, file: SupportsWrite[str] | None = None) -> None:
        """Print the help; on the standard output like any other data.

        Raises:
            UnavailableError: it cannot be written.
        """
        if file is None:
            Console().data(self.format_help().removesuffix("\n"))
        else:
            super().print_help(file)

    def _unknown(self, words: str) -> UsageError:
        first = words.split(maxsplit=1)[0]
        if not first.startswith("-"):
            return UsageError(
                f"'{first}' is one argument too many", where=self._command, hint=f"see '{self.prog} --help'"
            )
        option = first.partition("=")[0]
        hint = did_you_mean(option, self._option_string_actions, "options")
        return UsageError(f"unknown option {option}", where=self._command, hint=hint)


def typed(read: Callable[[str], ValueT]) -> Callable[[str], ValueT]:
    """Return a reader of values whose `ValueError` reaches the person as it is worded."""

    def read_for_argparse(text: str) -> ValueT:
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return read_for_argparse
