"""``hilbench run``."""

from __future__ import annotations

import argparse
from pathlib import Path

from hilbench.benchfile.part_options import add_parts, with_parts
from hilbench.benchfile.stimulus_options import add_stimuli, with_stimuli
from hilbench.cli.journal_options import add_journal, check_journal
from hilbench.errors import UsageError
from hilbench.terminal import arguments, interruption
from hilbench.terminal.parser import Parser, typed

_EXAMPLES = """
hilbench run bluepill:firmware.elf --for 10s --follow      ten seconds of bench time, shown line by line
hilbench run bluepill:firmware.hex --for 500ms --vcd waves.vcd
hilbench run nucleo-f767zi:firmware.elf --for 3s --at 1s:B1=press/50ms --volts A0=1.65
hilbench run bluepill:firmware.elf --for 2s --send '1s:usart1=help\\r\\n' --follow
hilbench run my-bench.toml --for 2min --journal run.jsonl --json
"""

_NOTES = """
Time is virtual: the run is as fast as the host allows (--realtime slows it to the wall clock), and the same every
time. It ends when the time is up or at --break and --watch (exit code 0), when the firmware exits by semihosting (0 for
status 0, else 1), or when the firmware cannot continue: lockup, a fault handler that loops, repeated resets (1, with
the place).
An image that is wrong for its board is refused with exit code 2, a missing image with 3.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench run", "Run firmware on emulated boards, in virtual time.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add("what", metavar="TARGET|BENCH", nargs="?",
        help="bluepill:IMAGE, BOARD.toml:IMAGE or bench file (default: ./hilbench.toml)")  # fmt: skip
    add("--chip", metavar="PART", help="another chip on the board, such as STM32F103CB")
    add("--timing", choices=("flat", "table"),
        help="how long instructions take; table: each as the manual says, for delay loops (default: flat)")  # fmt: skip
    add("--for", metavar="TIME", dest="for_ns", type=typed(arguments.duration_ns),
        help="bench time to run, such as 10s, 500ms, 2min (default: until the firmware ends, or Ctrl-C)")  # fmt: skip
    add_parts(made)
    add_stimuli(made)
    add("--follow", action="store_true", help="print console text and events as they come")
    add("--edges", action="store_true",
        help="with --follow and --journal: also the edges of serial lines, not only their bytes")  # fmt: skip
    add("--notes", choices=("causes", "all"), default="causes",
        help="notes on what the firmware did: one line for each cause, or each note (default: causes)")  # fmt: skip
    add_journal(made)
    add("--vcd", metavar="FILE", type=typed(arguments.output_file),
        help="write pins, nets and serial lines as waveforms (GTKWave, PulseView)")  # fmt: skip
    add("--write-stimuli", metavar="FILE", type=typed(arguments.output_file),
        help="write what pins and serial lines did in the form of --stimuli")  # fmt: skip
    add("--coverage", metavar="FILE", type=typed(arguments.output_file),
        help="write which lines of the firmware were executed, in the format of lcov (genhtml, editors)")  # fmt: skip
    add("--break", metavar="PLACE", dest="breaks", action="append", default=[],
        help="end before this function, or the instruction at this address; may be given several times")  # fmt: skip
    add("--watch", metavar="PLACE", dest="watches", action="append", default=[],
        help="end before an instruction that writes to this variable, or the word at this address")  # fmt: skip
    add("--picture", metavar="PART=FILE", action="append", default=[], type=typed(arguments.named_file),
        help="at the end, write what a display shows as PNG; may be given several times")  # fmt: skip
    add("--realtime", action="store_true", help="keep pace with the wall clock")
    add("--json", action="store_true", help="print the result as JSON")
    add("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the run (default: 0)")
    made.add_plain()
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.serving.run.run`."""
    from hilbench.benchfile.inputs import inputs_of
    from hilbench.benchfile.reader import DEFAULT_FILE
    from hilbench.files import check_ordinary, check_writable, refuse_overwriting
    from hilbench.files.names import file_name
    from hilbench.mcu.command_line import open_target
    from hilbench.terminal.console import Console

    check_journal(parsed)
    if parsed.what is None and not DEFAULT_FILE.is_file():
        hint = f"write BOARD:IMAGE or a bench file; 'hilbench init' makes {DEFAULT_FILE}"
        raise UsageError(f"needs something to run, and there is no {DEFAULT_FILE} here", where="run", hint=hint)
    bench_file = with_stimuli(parsed, with_parts(parsed, open_target(parsed.what, parsed.chip, timing=parsed.timing)))
    outputs = [("--journal", parsed.journal), ("--vcd", parsed.vcd), ("--write-stimuli", parsed.write_stimuli)]
    outputs.append(("--coverage", parsed.coverage))
    outputs += (("--picture", file) for _, file in parsed.picture)
    files = (("--stimuli", Path(file_name(name))) for name in parsed.stimuli)
    refuse_overwriting(outputs, [*inputs_of(bench_file), *files])
    for _, file in parsed.picture:
        check_writable(file, "--picture")
    if parsed.coverage is not None:
        check_writable(parsed.coverage, "--coverage")
    if parsed.write_stimuli is not None:
        check_ordinary(parsed.write_stimuli, "--write-stimuli", "stimuli")

    from hilbench.serving.run import RunOptions, run

    options = RunOptions(
        for_ns=parsed.for_ns,
        follow=parsed.follow,
        edges=parsed.edges,
        journal=parsed.journal,
        journal_max=parsed.journal_max,
        vcd=parsed.vcd,
        write_stimuli=parsed.write_stimuli,
        coverage=parsed.coverage,
        breaks=tuple(parsed.breaks),
        watches=tuple(parsed.watches),
        pictures=tuple(parsed.picture),
        realtime=parsed.realtime,
        as_json=parsed.json,
        seed=parsed.seed,
        each_note=parsed.notes == "all",
    )
    interruption.raise_once()
    return run(options, bench_file, Console())
