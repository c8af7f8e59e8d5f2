"""``hilbench serve``."""

from __future__ import annotations

import argparse
from pathlib import Path

from hilbench import arguments
from hilbench.options import ServeOptions
from hilbench.parser import Parser, typed

_EXAMPLES = """
hilbench serve pioneer --pty ./p2                          a client opens ./p2 as its serial port
hilbench serve pioneer --tcp 8101 --scene corridor --seed 7
hilbench serve my-bench.toml --tcp 0.0.0.0:8101 --journal served.jsonl
"""

_NOTES = """
Serves until Ctrl-C (or SIGTERM), through any number of clients; then nothing is left behind. That is how serving ends,
so the exit code is 0. A client that closes the pty or the socket has hung up: the robot ends its session.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench serve", "Offer a virtual target on a pty or a TCP port, in real time.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add("what", metavar="TARGET|BENCH", help="target, built-in bench or bench file")
    add("--pty", metavar="[LINK=]PATH", action="append", default=[], type=typed(arguments.pty_door),
        help="make PATH a symbolic link to a pseudo-terminal")  # fmt: skip
    add("--tcp", metavar="[LINK=][HOST:]PORT", action="append", default=[], type=typed(arguments.tcp_door),
        help="listen at a TCP port (default host: 127.0.0.1; port 0: any free one)")  # fmt: skip
    add("--scene", metavar="S", help="scene to stand in instead of that of the bench file: a built-in name or a file")
    add("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the run (default: 0)")
    add("--baud", metavar="B", type=typed(arguments.baud), help="speed of the line in bit/s")
    add("--any-baud", action="store_true", help="take a client at any speed, without garbage at a wrong one")
    add("--journal", metavar="FILE", type=typed(arguments.output_file), help="write the journal of the run")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.serve.serve`."""
    from hilbench.config import open_bench, resolve_scene
    from hilbench.console import Console
    from hilbench.serve import serve

    options = ServeOptions(
        what=parsed.what,
        ptys=tuple(parsed.pty),
        tcps=tuple(parsed.tcp),
        scene=None if parsed.scene is None else resolve_scene(parsed.scene, Path(), "--scene"),
        seed=parsed.seed,
        baud=parsed.baud,
        any_baud=parsed.any_baud,
        journal=parsed.journal,
    )
    return serve(options, open_bench(options.what), Console().mention)
