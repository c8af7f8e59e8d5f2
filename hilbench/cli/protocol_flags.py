"""The flags of commands that show frames: which protocol, from which file, and its own options.

A protocol's flags are known when the protocol is, so the words of a command line are looked through for its name first.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

from hilbench.cli.siblings import check_siblings
from hilbench.errors import PluginError
from hilbench.terminal.parser import Parser

if TYPE_CHECKING:
    from hilbench.plugins.protocol import ProtocolPlugin

__all__ = ["ProtocolParser", "add_plugins", "flags_of", "use_plugins"]

_OWN = "of protocol: "
"""Before the names of a protocol's options, so that none is that of an option of the command."""

OWN_FLAGS_NOTE = "A protocol may have options of its own; 'hilbench protocols NAME' lists them."


def add_plugins(parser: Parser) -> None:
    """Add the flag that names files with plug-ins."""
    parser.add_argument("--plugin", metavar="FILE", type=Path, action="append", default=[],
        help="load a protocol from this .py file (repeatable)")  # fmt: skip


def use_plugins(paths: Iterable[Path]) -> None:
    """Run the files of ``--plugin``.

    Raises:
        UsageError: one cannot be used.
    """
    from hilbench.plugins.discovery import PLUGINS  # and our packages, which may be shadowed: that is looked at first

    for path in paths:
        PLUGINS.add_file(path, f"--plugin {path}")


class ProtocolParser(Parser):
    """Parses a command that is given a protocol, whose own flags it then knows.

    What it returns has ``protocol``, a `ProtocolPlugin` or None, and ``options``: how its frames are read.

    Args:
        command: the command, as ``hilbench decode``.
        summary: what it does, in a sentence.
        examples: how it is used, one a line.
        notes: further paragraphs under the options.
    """

    def __init__(self, command: str, summary: str, examples: str, notes: str) -> None:
        super().__init__(command, summary, examples, f"{OWN_FLAGS_NOTE}\n{notes.strip()}")
        add_plugins(self)

    def parse_words(self, words: Sequence[str]) -> argparse.Namespace:
        """Read a command line.

        Raises:
            UsageError: it is wrong, or names a protocol that is not there or cannot be used.
        """
        if {"-h", "--help"} & {*words}:
            return super().parse_words(words)
        check_siblings()
        use_plugins(Path(path) for path in self._values(words, "--plugin"))
        found = self._protocol_in(words)
        if found is not None:
            self._add_flags(found)
        parsed = super().parse_words(words)
        parsed.protocol, parsed.options = found, None
        if found is not None:
            given = ((one.name, getattr(parsed, f"{_OWN}{one.name}")) for one in dataclasses.fields(found.options))
            parsed.options = found.options(**{name: value for name, value in given if value is not None})
        return parsed

    def _add_flags(self, protocol: ProtocolPlugin) -> None:
        for flag, settings in flags_of(protocol).items():
            if flag in self._option_string_actions:
                raise PluginError(f"has the flag {flag}, and so has {self.prog}", where=f"protocol '{protocol.name}'")
            self.add_argument(flag, **settings)

    def _protocol_in(self, words: Sequence[str]) -> ProtocolPlugin | None:
        """Return the protocol that is named by ``--protocol``, or by the first word that may be its name."""
        from hilbench.plugins.discovery import PLUGINS

        if "--protocol" in self._option_string_actions:
            named, where = [*self._values(words, "--protocol")][-1:], "--protocol"
        else:
            loose = [*self._loose(words)]
            named, where = [word for word in loose if word in PLUGINS.names()][:1] or loose[:1], "PROTOCOL"
        return PLUGINS.get(named[0], where) if named else None

    def _values(self, words: Sequence[str], option: str) -> Iterator[str]:
        """Yield what follows an option, wherever it stands."""
        for word, following in zip(words, [*words[1:], ""], strict=False):
            if word == option and following:
                yield following
            elif word.startswith(f"{option}="):
                yield word.partition("=")[2]

    def _loose(self, words: Sequence[str]) -> Iterator[str]:
        """Yield the words that are no options, and not the values of options that are known."""
        taken = False
        for word in words:
            action = self._option_string_actions.get(word)
            if not taken and not (word.startswith("-") and word != "-"):
                yield word
            taken = action is not None and action.nargs != 0


def flags_of(protocol: ProtocolPlugin) -> dict[str, dict[str, Any]]:
    """Return the flags of a protocol, with what `argparse` is to know of them."""
    kinds, usual = get_type_hints(protocol.options), protocol.options()
    return dict(
        _flag(protocol.name, one, kinds[one.name], getattr(usual, one.name))
        for one in dataclasses.fields(protocol.options)
    )


def _flag(protocol: str, option: dataclasses.Field[Any], kind: Any, usual: Any) -> tuple[str, dict[str, Any]]:
    """Return a flag; what is on unless somebody says otherwise has one with ``no-`` before it."""
    name = option.name.replace("_", "-")
    settings: dict[str, Any] = {"dest": f"{_OWN}{option.name}", "default": None}
    said = f"{protocol}: {option.metadata.get('help', option.name)}"
    if kind is bool:
        settings |= {"action": "store_const", "const": not usual, "help": f"{said} (off)" if usual else said}
        return f"--no-{name}" if usual else f"--{name}", settings
    shown = usual.name.lower() if isinstance(usual, Enum) else usual
    settings |= {"metavar": option.name[:1].upper(), "help": f"{said} (default: {shown})"}
    return f"--{name}", settings | {"type": _Named(kind) if issubclass(kind, Enum) else kind}


@dataclasses.dataclass(frozen=True, slots=True)
class _Named:
    """Reads the name of an enumerated value, in small letters."""

    kind: type[Enum]

    def __call__(self, text: str) -> Enum:
        by_name = {one.name.lower(): one for one in self.kind}
        if text not in by_name:
            raise argparse.ArgumentTypeError(f"invalid choice: '{text}' (choose from {', '.join(by_name)})")
        return by_name[text]
