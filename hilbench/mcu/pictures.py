"""Saves what displays on a bench show, as PNG files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from hilbench.benchfile.bench_file import BenchFile
from hilbench.errors import UnavailableError, UsageError
from hilbench.mcu.emulated import EmulatedBench
from hilbench.nearest import did_you_mean
from targets.parts import Part, part_class
from worlds.png import png

__all__ = ["check_displays", "save_pictures"]


def check_displays(names: Iterable[str], bench_file: BenchFile) -> None:
    """Require that these are displays of a bench.

    Raises:
        UsageError: one is not.
    """
    known = [name for name, plan in bench_file.parts.items() if part_class(plan.kind).picture is not Part.picture]
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known, "they are") if known else "the bench has none"
            raise UsageError(f"'{name}' is no display of the bench", where="--picture", hint=hint)


def save_pictures(wanted: Iterable[tuple[str, Path]], emulated: EmulatedBench) -> None:
    """Write what each of these displays shows at present into its file; an older one is overwritten.

    Raises:
        UnavailableError: a file cannot be written.
    """
    for name, path in wanted:
        shown = emulated.surroundings.parts.by_name[name].picture()
        assert shown is not None
        try:
            path.write_bytes(png(shown.grey, shown.width, shown.height))
        except OSError as error:
            raise UnavailableError(
                f"{path}: cannot be written ({error.strerror})", hint="choose another file"
            ) from error
