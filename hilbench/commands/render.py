"""``hilbench render``."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.errors import UnavailableError
from hilbench.exit_codes import ExitCode
from hilbench.terminal import arguments
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.recordings.moments import Moment

_MAP, _PICTURE = ".svg", ".png"
_SIDE = re.compile(r"[0-9]{1,4}")
_SMALLEST_PX, _LARGEST_PX = (600, 200), 4096

_EXAMPLES = """
hilbench render run.jsonl --at 12s
hilbench render check.jsonl --case SUITE/NAME --at 1500ms --output case.svg
hilbench render run.jsonl --size 1920x1080 --output end.png
"""

_NOTES = """
FILE.svg is a map from above. FILE.png is a picture from behind the vehicle. MuJoCo draws it, whatever physics the run
had; it needs mujoco-core, PyOpenGL (`pip install 'hilbench[picture]'`) and EGL or OSMesa. Without --output hilbench
writes the picture if it can, else the map, into the working folder, under the name of the journal. It replaces an older
file.
The vehicle is drawn at its last recorded pose (ten a second), and level: a journal has no pitch and no roll.
Cases, each with a bench time of its own, follow each other; with --case, --at counts from the start of the case.
Exit code 0: drawn; 2: wrong usage, or nothing to draw; 3: a file cannot be read or written, or there is no GL.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench render", "Draw the world of a recording at one moment.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add("journal", metavar="JOURNAL", type=Path, help="the recording")
    add("--at", metavar="TIME", type=typed(arguments.duration_ns),
        help="the moment, in bench time, such as 12s (default: the last one with a vehicle)")  # fmt: skip
    add("--case", metavar="ID", default="", help="only this case of a journal of 'hilbench check'")
    add("--output", metavar="FILE", type=typed(_drawing), help="the file to write, FILE.svg or FILE.png")
    add("--size", metavar="WIDTHxHEIGHT", type=typed(_size), default=(1280, 720),
        help="largest size in pixels (default: 1280x720)")  # fmt: skip
    return made


def run(parsed: argparse.Namespace) -> int:
    """Draw, say what was drawn, and return the exit code."""
    from hilbench.files import check_writable, refuse_overwriting, write_atomically
    from hilbench.recordings.layout import of_case
    from hilbench.recordings.moments import moment_of
    from hilbench.recordings.reading import read_recording
    from hilbench.recordings.remarks import remarks_on
    from hilbench.terminal.console import Console

    console, where = Console(), str(parsed.journal)
    recording = of_case(read_recording(parsed.journal), parsed.case, where)
    moment = moment_of(recording, parsed.at, where)
    output, content = parsed.output, b""
    if output is None:
        output = Path(parsed.journal.stem + _PICTURE)
        try:
            content = _picture(moment, parsed.size)
        except UnavailableError as problem:
            output = output.with_suffix(_MAP)
            console.narrate(f"drawn from above: {problem.message}")
    named = "--output" if parsed.output is not None else "drawing into"
    refuse_overwriting([(named, output)], [("the recording", parsed.journal)])
    check_writable(output, named)
    if not content:
        content = _picture(moment, parsed.size) if output.suffix == _PICTURE else _map(moment, parsed.size)
    write_atomically(output, content)
    for remark in remarks_on(recording.header, recording.problem, "drawn"):
        console.narrate(f"{where}: {remark}")
    console.data(f"wrote {output}: {_title(moment)} {_place(moment)}")
    return ExitCode.OK


def _title(moment: Moment) -> str:
    from hilbench.files.names import printable

    case = f", {moment.case}," if moment.case else ""
    return printable(f"{moment.stage.vehicle} in {moment.stage.scene.name}{case}")


def _place(moment: Moment) -> str:
    (x_m, y_m, _), yaw_deg = moment.pose.position_m, math.degrees(moment.pose.yaw_rad)
    return f"at {moment.ns / 1e9:.3f} s: x {x_m:+.3f} m, y {y_m:+.3f} m, {yaw_deg:+.1f} degrees"


def _map(moment: Moment, size_px: tuple[int, int]) -> bytes:
    from hilbench.recordings.above import map_of

    return map_of(moment, size_px, title=_title(moment), note=_place(moment)).encode()


def _picture(moment: Moment, size_px: tuple[int, int]) -> bytes:
    from worlds.errors import WorldError
    from worlds.mujoco_picture import picture

    try:
        return picture(moment.stage, moment.pose, moment.track, size_px)
    except WorldError as error:
        raise UnavailableError(str(error), where="render", hint="a map needs none of it: --output FILE.svg") from error


def _drawing(text: str) -> Path:
    path = arguments.output_file(text)
    if path.suffix not in {_MAP, _PICTURE}:
        raise ValueError(f"'{text}' is neither FILE{_MAP} nor FILE{_PICTURE}")
    return path


def _size(text: str) -> tuple[int, int]:
    width, height = (int(side) if _SIDE.fullmatch(side) else 0 for side in text.partition("x")[::2])
    least_width, least_height = _SMALLEST_PX
    if not (least_width <= width <= _LARGEST_PX and least_height <= height <= _LARGEST_PX):
        least = f"{least_width}x{least_height}"
        raise ValueError(f"'{text}' is no size from {least} to {_LARGEST_PX}x{_LARGEST_PX}, such as 1280x720")
    return width, height
