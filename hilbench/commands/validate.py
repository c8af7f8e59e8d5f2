"""``hilbench validate``."""

from __future__ import annotations

import argparse

from hilbench.exit_codes import ExitCode
from hilbench.terminal.parser import Parser

_EXAMPLES = """
hilbench validate my-bench.toml
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench validate", "Read a bench file and say whether it is right.", _EXAMPLES)
    made.add_argument("bench", metavar="BENCH", help="bench file, or the name of a built-in bench")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Print ``ok``, or raise the error that names the line. No plug-in is run."""
    from hilbench.benchfile.reader import open_bench
    from hilbench.terminal.console import Console

    bench = open_bench(parsed.bench, run_plugins=False)
    Console().data(f"{bench.path}: ok")
    return ExitCode.OK
