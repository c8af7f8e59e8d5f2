"""``hilbench completion``.

A shell completes without running hilbench: its script has the names of this moment, those of plug-ins among them.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any

from hilbench.cli import COMMANDS
from hilbench.exit_codes import ExitCode
from hilbench.terminal.parser import Parser

SHELLS = ("bash", "zsh", "fish")

_EXAMPLES = """
eval "$(hilbench completion bash)"                      in this shell
hilbench completion bash > ~/.local/share/bash-completion/completions/hilbench
hilbench completion zsh > ~/.zfunc/_hilbench            with 'fpath+=~/.zfunc' before 'compinit' in ~/.zshrc
hilbench completion fish > ~/.config/fish/completions/hilbench.fish
"""

_NOTES = """
It completes commands, options, benches, suites, scenes, protocols, boards, chips and files. Write the script again
after an update, or after you have installed a plug-in.
"""

_FILES = {"FILE", "JOURNAL", "IMAGE", "RUN", "A", "B"}
"""What a value is called that is a file."""

_BASH_FORM = '{}() {{ compgen -W "{}" -- "$1"; {}\n}}'
_ZSH_FORM = "{}() {{ compadd {}; {}\n}}"
_FISH_FORM = "function {}\n    printf '%s\\n' {}\n    {}\nend"
_FILES_OF_SHELLS = ('_shtab_compgen_files "$1"', "_files", "__fish_complete_path (commandline -ct)")


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench completion", "Print a script that lets a shell complete hilbench.", _EXAMPLES, _NOTES)
    made.add_argument("shell", metavar="SHELL", choices=SHELLS, help=f"one of {', '.join(SHELLS)}")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Print the script."""
    import shtab

    from hilbench.terminal.console import Console

    Console().data(shtab.complete(_whole(), shell=parsed.shell))
    return ExitCode.OK


def _whole() -> argparse.ArgumentParser:
    """Return all of the command line as one parser: commands, and benches, which take the options of the dashboard."""
    root = argparse.ArgumentParser(prog="hilbench", add_help=False)
    _add(root, import_module("hilbench.commands.dashboard").parser(), positionals=False)
    root.add_argument("--version", action="store_true", help="show the version")
    names = root.add_subparsers()
    for name, summary in COMMANDS.items():
        one = names.add_parser(name, help=summary, description=summary, add_help=False)
        _add(one, import_module(f"hilbench.commands.{name}").parser())
    for bench in _benches():
        summary = f"the dashboard of the bench {bench}"
        one = names.add_parser(bench, help=summary, description=summary, add_help=False)
        _add(one, import_module("hilbench.commands.dashboard").parser(), positionals=False)
    return root


def _add(to: argparse.ArgumentParser, command: Parser, *, positionals: bool = True) -> None:
    """Add the arguments of a command, each with what completes it."""
    for action in command.arguments:
        if action.option_strings or positionals:
            if action.nargs != 0 and not action.choices:
                _complete(action)
            to._add_action(action)  # noqa: SLF001 - argparse has no other way to share an argument


def _complete(action: argparse.Action) -> None:
    """Have the value of an argument completed: by names, by files, or by both."""
    import shtab

    if action.dest in _NAMES:
        vars(action)["complete"] = _names_or_files(action.dest, sorted(_NAMES[action.dest]()))
    elif action.metavar in _FILES:
        vars(action)["complete"] = shtab.FILE
    elif action.metavar == "DIR":
        vars(action)["complete"] = shtab.DIRECTORY


def _names_or_files(what: str, names: Iterable[str]) -> dict[str, Any]:
    """Return what completes by these names, and by files where one may be meant, in each shell, as `shtab` takes it."""
    function, words = f"_hilbench_{what}", " ".join(names)
    files = ("", "", "") if what in _NO_FILES else _FILES_OF_SHELLS
    bash, zsh, fish = (
        form.format(function, words, file)
        for form, file in zip((_BASH_FORM, _ZSH_FORM, _FISH_FORM), files, strict=True)
    )
    preamble = {"bash": bash, "zsh": zsh, "fish": fish}
    return {"bash": function, "zsh": function, "fish": f"({function})", "preamble": preamble}


def _benches() -> list[str]:
    from hilbench.files.built_in import built_in_benches
    from hilbench.plugins.discovery import PLUGINS

    return [*built_in_benches(), *PLUGINS.systems.bench_names()]


def _boards() -> Iterable[str]:
    from targets.boards import board_names

    return board_names()


def _chips() -> Iterable[str]:
    from targets.mcu.variants import VARIANTS

    return VARIANTS


def _demos() -> Iterable[str]:
    from hilbench.plugins.discovery import PLUGINS

    return PLUGINS.systems.demos(physics=True)


def _protocols() -> Iterable[str]:
    from hilbench.plugins.discovery import PLUGINS

    return PLUGINS.names()


def _scenes() -> Iterable[str]:
    from worlds.scenes import scene_names

    return scene_names()


def _suites() -> Iterable[str]:
    from hilbench.benchfile.suites import shipped_suites

    return shipped_suites()


_NAMES: dict[str, Callable[[], Iterable[str]]] = {
    "bench": _benches,
    "board": _boards,
    "chip": _chips,
    "fidelity": _chips,
    "into": _benches,
    "protocol": _protocols,
    "scene": _scenes,
    "suite": _suites,
    "system": _demos,
    "what": _benches,
}
"""What the values of an argument may be, by its place in the namespace; most may be a file besides."""
_NO_FILES = {"chip", "fidelity", "protocol", "system"}
