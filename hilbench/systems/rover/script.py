"""The script of the rover's demo: the published defect of its firmware, seen live, found by a check, and repaired.

The firmware is the image ``rover-g2``, our rewrite of nhorro/ceai2020 at 6058e92 (September 2021): there
`handle_connection_lost` of application.cpp, which stops the motors, is commented out. ``rover`` is the firmware that
does what the document promises.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from hilbench.plugins.demo import Check, Demo, LiveBench, Scene
from targets.firmware import image_path

__all__ = ["rover_demo"]

_PUBLISHED, _REPAIRED = "rover-g2", "rover"
_CLAUSE = "P24D"
_BOARD_ALONE = Path(__file__).with_name("board_alone.toml")
_PULLED_S = 60.0
"""Longer than the scenes until the bench is closed."""
_PLUG_PULLED = ({"do": "clear-faults"}, {"do": "inject", "kind": "disconnect", "duration_s": _PULLED_S})
_NOISE = {"do": "inject", "kind": "noise", "probability": 0.02, "count": 2}
_AFTER = """
Try it yourself:
  hilbench rover                              drive it: w a s d
  hilbench check rover -k 'P24D and documented'
  hilbench run bluepill:firmware.elf --for 10s --follow         your firmware, without a board
  hilbench check --target serial:PORT@BAUD --suite pkt-board    a real rover; lift its wheels
"""


def rover_demo(*, physics: bool) -> Demo:
    """Return the script.

    Args:
        physics: whether a physics engine is installed. Without one the board is shown alone: its four wheels need a
            floor, and the plane has two driven wheels only.
    """
    bench, turns, moves = ("rover", "world", "speed") if physics else (str(_BOARD_ALONE), "pins", "PB11 duty")
    stands: Mapping[str, tuple[float, float]] = {moves: (0.0, 0.02)}
    drives: Mapping[str, tuple[float, float]] = {moves: (0.05, math.inf)}
    how = f"Speed: {{{moves}}}" if physics else f"Motor PWM: {{{moves}}}"
    surroundings = (
        "Motors, sensors and floor are simulated." if physics else "No physics is installed: you see its pins."
    )
    return Demo(
        title="A rover and its published defect",
        scenes=(
            Scene(
                title="Firmware without its board",
                text=f"A rover's firmware, {_PUBLISHED}.elf (the published one, rewritten without Mbed OS), runs as it "
                f"would be flashed, on an emulated STM32F767. {surroundings}",
                lasts_s=12,
                panes=(turns, "frames"),
                bench=_live(bench, _PUBLISHED),
            ),
            Scene(
                title="A ground station drives it",
                text="Its ground station sends commands at 115200 baud. Every frame is decoded as it passes, down to "
                f"the bit. {how}.",
                lasts_s=12,
                bench_s=8,
                claims=drives,
            ),
            Scene(
                title="A bad line",
                text="Now the line is noisy: random bytes get into the frames. Damaged frames are "
                "rejected and counted on both sides; the rover drives on. {faults} disturbances so far.",
                lasts_s=12,
                panes=("frames", "link", "states"),
                asks=(_NOISE, {**_NOISE, "towards": "operator"}),
            ),
            Scene(
                title="The plug is pulled",
                text="A clean line again, but now the plug is pulled. The document promises that a lost link stops "
                f"the motors within 1.1 s. Watch it: {{since}} without a command. {how}.",
                lasts_s=9,
                bench_s=4,
                panes=(turns, "plots"),
                asks=_PLUG_PULLED,
            ),
            Scene(
                title="It drives on",
                text=f"{{since}} without a command, and nobody can stop it any more. {how}. On this bench that costs "
                "nothing. With a real robot it is an accident.",
                lasts_s=9,
                bench_s=5,
                claims=drives,
            ),
            Scene(
                title="A check looks for it",
                text=f"hilbench check tests the promise, clause {_CLAUSE}, on a fresh bench with the same image, in "
                "virtual time: as fast as this computer can. The same inputs give the same run, bit for bit.",
                lasts_s=9,
                panes=("checks",),
                asks=({"do": "pause"},),
                check=_check(bench, _PUBLISHED, "fail"),
            ),
            Scene(
                title="The verdict, with its evidence",
                text=f"{{verdict}} {_CLAUSE}: {{cause}}. The code that stops the motors is commented out in the "
                "firmware published in September 2021, and so it is here. Above: what was sent, and what came back.",
                lasts_s=14,
            ),
            Scene(
                title="The firmware that keeps the promise",
                text=f"The same check on {_REPAIRED}.elf, where that code is in place: {_CLAUSE} {{verdict}}. In CI "
                "the exit code says the same: 1 for a violation, 0 for a pass.",
                lasts_s=10,
                check=_check(bench, _REPAIRED, "pass"),
            ),
            Scene(
                title="And live",
                text=f"{_REPAIRED}.elf on the same bench. {how}.",
                lasts_s=9,
                bench_s=7,
                panes=(turns, "plots"),
                bench=_live(bench, _REPAIRED),
                claims=drives,
            ),
            Scene(
                title="The plug is pulled again",
                text=f"The plug is pulled: {{since}} without a command. {how}.",
                lasts_s=8,
                bench_s=5,
                asks=_PLUG_PULLED,
                claims=stands,
            ),
            Scene(
                title="Your turn",
                text="It works the same with your firmware on an emulated board, with your protocol, with a real "
                "board at a serial port, and in CI. The commands follow on your terminal.",
                lasts_s=10,
            ),
        ),
        after=_AFTER,
    )


def _live(bench: str, image: str) -> LiveBench:
    return LiveBench(bench=bench, changes=(f"targets.brain.firmware={image_path(image)}",))


def _check(bench: str, image: str, verdict: str) -> Check:
    path, here = image_path(image), Path.cwd()
    target = f"brain.documented=nucleo-f767zi:{path.relative_to(here) if path.is_relative_to(here) else path}"
    select = f"{_CLAUSE} and documented"
    return Check(bench=bench, suite="pkt-board", select=select, more=("--target", target), verdicts={_CLAUSE: verdict})
