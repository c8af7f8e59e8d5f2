"""What a bench is read from, and the lines it speaks on: nothing may be written to them; see `hilbench.files`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from hilbench.benchfile.bench_file import BenchFile
from hilbench.benchfile.board_files import is_board_file
from hilbench.benchfile.reader import read_bench
from hilbench.benchfile.stimulus import Send
from hilbench.benchfile.target_grammar import TargetKind, target_of
from hilbench.errors import HilbenchError
from hilbench.files import Named
from hilbench.files.names import file_name
from hilbench.links.serial_target import located, parse_serial_target
from hilbench.plugins.discovery import PLUGINS
from hilbench.terminal.options import TargetChoice

__all__ = ["inputs_of", "inputs_of_targets", "lines_of", "plugin_files"]


def inputs_of(bench_file: BenchFile) -> Iterator[Named]:
    """Yield everything that a bench is read from."""
    yield "the bench file", bench_file.path
    folder = Path() if bench_file.path is None else bench_file.path.parent
    for emulated in bench_file.boards.values():
        yield "the firmware", emulated.firmware
        for name, image in emulated.programs.items():
            yield f"the program '{name}'", image
        if is_board_file(emulated.board_name):
            yield "the board file", folder / file_name(emulated.board_name)
    for stimulus in bench_file.stimuli:
        if isinstance(stimulus.action, Send):
            yield f"the file of {stimulus.text}", stimulus.action.file
    yield "the scene", Path(bench_file.world.scene)
    yield from plugin_files()
    for suite in bench_file.suites:
        yield f"the suite {suite}", Path(suite)
    for variant in bench_file.variants.values():
        yield from inputs_of(read_bench(variant))


def plugin_files() -> Iterator[Named]:
    """Yield the files of plug-ins that were run."""
    for file in PLUGINS.files():
        yield "the plug-in", file


def inputs_of_targets(choices: Iterable[TargetChoice]) -> Iterator[Named]:
    """Yield the images and board files that ``--target`` may name."""
    for choice in choices:
        target = target_of(choice)
        if target.kind is TargetKind.BOARD:
            yield choice.where, Path(target.name)
            yield choice.where, Path(target.rest)


def lines_of(specs: Iterable[str]) -> Iterator[Named]:
    """Yield the ports and pseudo-terminals of this machine that targets and doors mean, by how they were named.

    One that is wrong, or not there, is passed over: whoever opens it says so.
    """
    for spec in specs:
        kind, _, where = spec.removeprefix("listen:").partition(":")
        if kind == "pty":
            yield spec, Path(where)
        elif kind == "serial":
            with suppress(HilbenchError):
                target = located(parse_serial_target(spec))
                yield spec, Path(target.url) if target.is_device else None
