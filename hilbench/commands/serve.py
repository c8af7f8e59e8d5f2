"""``hilbench serve``."""

from __future__ import annotations

import argparse
from pathlib import Path

from hilbench.benchfile.part_options import add_parts, with_parts
from hilbench.benchfile.stimulus_options import add_stimuli, with_stimuli
from hilbench.cli.journal_options import add_journal, check_journal
from hilbench.terminal import arguments, interruption
from hilbench.terminal.options import ITS_DOMAINS, Clients, ServeOptions
from hilbench.terminal.parser import Parser, typed

_EXAMPLES = """
hilbench serve bluepill:firmware.elf                       each USART on a pty: ./bluepill-usart1, ...
hilbench serve nucleo-f767zi:firmware.elf                  its virtual COM port, USART3: ./nucleo-f767zi-usart3
hilbench serve bluepill:firmware.elf --pty usart2=./gps --tcp usart1=8101
hilbench serve pioneer --pty ./p2                          a client opens ./p2 as its serial port
hilbench serve pioneer --tcp 8101 --scene corridor --seed 7
hilbench serve pioneer --tcp 8101 --clients newest          a new client replaces the previous one
hilbench serve pioneer --pty ./p2 --hangup ignore           the robot is not notified when a client leaves
hilbench serve rover-model --rfc2217 4000                   a client opens rfc2217://localhost:4000
hilbench serve rover-model --pty ./rover                    the PKT! rover, behavioural
hilbench serve vehicle-model --pty usart2=./simulator --pty usart3=./stack
hilbench serve xrce-agent --pty ./board --tcp 8888          micro-ROS: a client at a serial port, one at a socket
hilbench serve xrce-agent --pty ./board --dds               its topics and services are those of ROS 2 as well
hilbench serve my-bench.toml --tcp 0.0.0.0:8101 --journal served.jsonl
"""

_NOTES = """
Serves any number of clients until Ctrl-C or SIGTERM; then the exit code is 0. A client that closes the pty or the
socket has hung up, and a robot ends its session. With --hangup ignore the robot is not notified, as on a real serial
line. Each client that connects, takes over, is refused or leaves is reported.
An emulated board runs the image from power-on. An endpoint without a USART name gets the next USART. Its line has the
baud rate that the firmware sets, unless --baud is given. If the firmware cannot continue, the exit code is 1.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench serve", "Offer a virtual target on a pty or a TCP port, in real time.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add("what", metavar="TARGET|BENCH", help="pioneer, bluepill:IMAGE, BOARD.toml:IMAGE, built-in bench or bench file")
    add("--pty", metavar="[USART=]PATH", action="append", default=[], type=typed(arguments.pty_door),
        help="make PATH a symbolic link to a pseudo-terminal")  # fmt: skip
    add("--tcp", metavar="[USART=][HOST:]PORT", action="append", default=[], type=typed(arguments.tcp_door),
        help="listen at a TCP port (default host: 127.0.0.1; port 0: any free one)")  # fmt: skip
    add("--rfc2217", metavar="[USART=][HOST:]PORT", action="append", default=[], type=typed(arguments.rfc2217_door),
        help="as --tcp, for clients that set the rate of the line (rfc2217://HOST:PORT of pyserial)")  # fmt: skip
    add("--chip", metavar="PART", help="another chip on the board, such as STM32F103CB")
    add("--timing", choices=("flat", "table"),
        help="how long instructions take; table: each as the manual says, for delay loops (default: flat)")  # fmt: skip
    add("--scene", metavar="S", help="use this scene instead of the bench file's: a built-in name or a file")
    add("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the run (default: 0)")
    add("--baud", metavar="B", type=typed(arguments.baud), help="speed of the line in bit/s")
    add("--any-baud", action="store_true", help="accept clients at any baud rate, without garbage at a wrong one")
    add(
        "--clients",
        choices=[each.value for each in Clients],
        default=Clients.ALL,
        help="who is served if several clients connect: all, the newest, the first (default: all; the first, where "
        "a target takes one client a line)",
    )
    add("--hangup", choices=("close", "ignore"), default="close",
        help="when a client leaves: close the line for the target, or ignore it (default: close)")  # fmt: skip
    add("--dds", metavar="DOMAIN", nargs="?", const=ITS_DOMAINS, type=typed(arguments.dds_domain),
        help="join the target's topics to a DDS domain, as ROS 2 does (default: the one its clients name)")  # fmt: skip
    add_parts(made)
    add_stimuli(made)
    add_journal(made)
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.serving.serve.serve` and `hilbench.serving.boards.serve_boards`."""
    from hilbench.benchfile.inputs import inputs_of
    from hilbench.benchfile.reader import resolve_scene
    from hilbench.files import refuse_overwriting, refuse_writing_into
    from hilbench.mcu.command_line import open_target
    from hilbench.terminal.console import Console

    check_journal(parsed)
    options = ServeOptions(
        what=parsed.what,
        ptys=tuple(parsed.pty),
        tcps=tuple(parsed.tcp),
        rfc2217s=tuple(parsed.rfc2217),
        scene=None if parsed.scene is None else resolve_scene(parsed.scene, Path(), "--scene"),
        seed=parsed.seed,
        baud=parsed.baud,
        any_baud=parsed.any_baud,
        clients=Clients(parsed.clients),
        ignore_hangup=parsed.hangup == "ignore",
        journal=parsed.journal,
        journal_max=parsed.journal_max,
        dds=parsed.dds,
    )
    bench_file = with_stimuli(parsed, with_parts(parsed, open_target(options.what, parsed.chip, timing=parsed.timing)))
    scene = None if options.scene is None else Path(options.scene)
    refuse_overwriting(options.outputs(), [*inputs_of(bench_file), ("the scene", scene)])
    refuse_writing_into([("--journal", options.journal)], ((f"--pty {door.path}", door.path) for door in options.ptys))
    say = Console().mention
    if bench_file.boards:
        from hilbench.serving.boards import serve_boards

        interruption.raise_once()
        return serve_boards(options, bench_file, say)

    from hilbench.serving.serve import serve

    interruption.raise_once()
    return serve(options, bench_file, say)
