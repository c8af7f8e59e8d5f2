"""What the encoders show: numbers, widths, pins and the order of their bits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TypeVar

from hilbench.check import Violation, near
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.suites._bluepill import LEFT_ENCODER, RIGHT_ENCODER, bits, connect, drive_codes, last, levels, runs, show
from hilbench.suites._board_watch import Watch
from hilbench.suites.bluepill_pins._ways import (
    SECTOR_DEG,
    SECTOR_TOLERANCE_DEG,
    Settings,
    on_adapter,
    on_wheels,
    required,
)
from targets.parts.encoder_3bit import EncoderMoved
from targets.parts.p2os_adapter import EncoderWords, RobotConnected

EventT = TypeVar("EventT")

SETTLED_DEG = 1.0
"""A wheel at rest in the beginning may stand on either side of 0: what it shows there means nothing."""


def require_numbers(watch: Watch, side: str, wanted: Sequence[int]) -> list[float]:
    """Require the numbers of an encoder from its second sector on, and return the angle in deg at which each began."""
    moved = watch.reported(EncoderMoved, f"encoder_{side}")
    angles = [math.degrees(getattr(watch.angles_at(one.event.at_ns), f"{side}_rad")) for one in moved]
    turned = next((place for place, angle in enumerate(angles) if abs(angle) > SETTLED_DEG), len(angles))
    numbers = [0, *(one.event.word for one in moved)][turned : turned + len(wanted)]
    required(numbers == [*wanted], f"the {side} encoder shows {numbers}, not {[*wanted]}")
    return angles[turned : turned + len(wanted) - 1]


def require_widths(side: str, begins_deg: Sequence[float], widths_deg: Sequence[float]) -> None:
    """Require how far the wheel turns while each number is shown."""
    for (begin, end), width in zip(pairwise(begins_deg), widths_deg, strict=True):
        what = f"width of the sector from {begin:.1f} deg of the {side} wheel"
        near(abs(end - begin), width, SECTOR_TOLERANCE_DEG, unit="deg", what=what)


def numbers_said(text: str) -> list[tuple[int, int]]:
    """Return the numbers, left and right, that the program has said."""
    words = [line.split() for line in text.splitlines() if line.startswith("left ")]
    return [(int(line[1]), int(line[3])) for line in words if len(line) == 4]


TURN = [1, 2, 3, 4, 5, 6, 7, 0, 1]
"""What an encoder shows in a turn forward, from its first boundary on."""


@on_wheels("G09", program="encoders", lasts_s=12.5)
def test_encoders_forward(bench: BoardCase) -> None:
    """The program turns the wheels at 43 degrees per second for 11 s."""
    watch = Watch(bench)
    line = bench.board.usart("usart1")
    bench.board.run(12.5)
    for side in ("left", "right"):
        begins_deg = require_numbers(watch, side, [0, *TURN])
        near(begins_deg[0], SECTOR_DEG, SECTOR_TOLERANCE_DEG, unit="deg", what=f"first boundary of the {side} wheel")
        require_widths(side, begins_deg, [SECTOR_DEG] * (len(begins_deg) - 1))
    for place, side in enumerate(("left", "right")):
        heard = runs([pair[place] for pair in numbers_said(line.text)])
        found = any(heard[begin : begin + len(TURN)] == TURN for begin in range(len(heard)))
        required(found, f"the program says {heard} of the {side} encoder, and not {TURN}")


BACK_S = 4.8
"""At code -2 a wheel turns back by 417 degrees in this time."""


@on_wheels("G10", program="quiet", lasts_s=BACK_S)
def test_encoders_backward(bench: BoardCase) -> None:
    watch = Watch(bench)
    drive_codes(bench.board, -2, -2)
    bench.board.run(BACK_S)
    for side in ("left", "right"):
        begins_deg = require_numbers(watch, side, [7, 6, 5, 4, 3, 2, 1, 0, 7])
        near(begins_deg[0], -SECTOR_DEG, SECTOR_TOLERANCE_DEG, unit="deg", what=f"first boundary of the {side} wheel")
        require_widths(side, begins_deg, [SECTOR_DEG] * (len(begins_deg) - 1))


@on_wheels("G10", program="encoders", lasts_s=25.2)
def test_encoders_back_again(bench: BoardCase) -> None:
    """After its turn and more forward the program waits, and turns the wheels back."""
    watch = Watch(bench)
    line = bench.board.usart("usart1")
    bench.board.run(14.0)
    begun_ns, said_before = bench.now_ns, len(line.text)
    bench.board.run(11.2)
    back = TURN[::-1]
    for place, side in enumerate(("left", "right")):
        shown = [one.event.word for one in watch.reported(EncoderMoved, f"encoder_{side}", begun_ns)]
        required(shown[: len(back)] == back, f"the {side} encoder shows {shown}, not {back}")
        heard = runs([pair[place] for pair in numbers_said(line.text[said_before:])])
        required(heard[: len(back)] == back, f"the program says {heard} of the {side} encoder, not {back}")


_TRUNCATING: Settings = {"encoder_left": {"form": "truncating"}, "encoder_right": {"form": "truncating"}}


@on_wheels("G10", program="quiet", lasts_s=BACK_S + 0.9, settings=_TRUNCATING)
def test_encoders_backward_as_the_plug_in_has_it(bench: BoardCase) -> None:
    """First forward into sector 1, so that the whole of the wide sector 0 is passed."""
    watch = Watch(bench)
    drive_codes(bench.board, 2, 2)
    bench.board.run(0.9)
    drive_codes(bench.board, -2, -2)
    bench.board.run(BACK_S)
    for side in ("left", "right"):
        begins_deg = require_numbers(watch, side, [0, 1, 0, 7, 6, 5, 4, 3, 2, 1])
        require_widths(side, begins_deg[1:], [2 * SECTOR_DEG, *[SECTOR_DEG] * 6])


@on_wheels("G10", program="quiet", lasts_s=1.5)
def test_each_encoder_shows_its_own_wheel(bench: BoardCase) -> None:
    """On the spot, the left wheel goes back while the right one goes forward, by more than two sectors in 1.5 s."""
    watch = Watch(bench)
    drive_codes(bench.board, -2, 2)
    bench.board.run(1.5)
    require_numbers(watch, "left", [7, 6])
    require_numbers(watch, "right", [0, 1, 2])
    for part, pins in (("encoder_left", LEFT_ENCODER), ("encoder_right", RIGHT_ENCODER)):
        number = watch.reported(EncoderMoved, part)[-1].event.word
        seen = levels(bench.board, pins)
        required(seen == bits(number), f"{part} shows {number}: {', '.join(pins)} are {seen}")


def show_number(bench: BoardBench, part: str, number: int) -> None:
    """Show an encoder the middle of a sector."""
    show(bench, part, {"angle": math.radians((number + 0.5) * SECTOR_DEG)})


@on_wheels("G11", program="encoders", lasts_s=0.24)
def test_pins_of_the_encoders(bench: BoardCase) -> None:
    """The program has to read the numbers as well: PB3, PB4 and PA15 belong to the debug port after reset."""
    line = bench.board.usart("usart1")
    bench.emulated.surroundings.parts.senses = False
    bench.board.run(0.05)
    for side, pins in (("left", LEFT_ENCODER), ("right", RIGHT_ENCODER)):
        for number in (5, 1, 4):
            show_number(bench, f"encoder_{side}", number)
            seen = levels(bench.board, pins)
            required(seen == bits(number), f"number {number} on the {side}: {', '.join(pins)} are {seen}")
            bench.board.run(0.03)
            pair = last(numbers_said(line.text), "what the program says")
            required(pair[side == "right"] == number, f"the program reads {pair} (left, right)")


@on_wheels("G12", program="quiet", lasts_s=0.02)
def test_bit_order_of_the_encoders(bench: BoardCase) -> None:
    require_order(bench, {1: (True, False, False), 4: (False, False, True)})


_MSB_FIRST: Settings = {"encoder_left": {"bit_order": "msb-first"}, "encoder_right": {"bit_order": "msb-first"}}


@on_wheels("G12", program="quiet", lasts_s=0.02, settings=_MSB_FIRST)
def test_bit_order_as_on_the_adapter(bench: BoardCase) -> None:
    require_order(bench, {1: (False, False, True), 4: (True, False, False)})


def require_order(bench: BoardBench, wanted: Mapping[int, tuple[bool, bool, bool]]) -> None:
    """Show both encoders numbers, and require the levels of s1 to s3."""
    bench.emulated.surroundings.parts.senses = False
    bench.board.run(0.02)
    for part, pins in (("encoder_left", LEFT_ENCODER), ("encoder_right", RIGHT_ENCODER)):
        for number, right in wanted.items():
            show_number(bench, part, number)
            seen = levels(bench.board, pins)
            required(seen == right, f"{part} shows {number}: s1 to s3 are {seen}, not {right}")


@on_adapter("G12", program="quiet", lasts_s=2.0)
def test_bit_order_of_the_adapter(bench: BoardCase) -> None:
    require_adapter_order(bench, mirrored=True)


@on_adapter("G12", program="quiet", lasts_s=2.0, encoder_order="lsb-first")
def test_bit_order_of_a_mended_adapter(bench: BoardCase) -> None:
    require_adapter_order(bench, mirrored=False)


def require_adapter_order(bench: BoardBench, *, mirrored: bool) -> None:
    """Drive, and require of each number that the adapter tells of the levels on its wires."""
    watch = Watch(bench)
    connect(bench, watch, RobotConnected)
    drive_codes(bench.board, 3, 3)
    seen: set[int] = set()
    for _ in range(40):
        shown = next_told(bench, watch, EncoderWords)
        for number, pins in ((shown.left, LEFT_ENCODER), (shown.right, RIGHT_ENCODER)):
            wanted = bits(number)[::-1] if mirrored else bits(number)
            found = levels(bench.board, pins)
            required(found == wanted, f"number {number}: s1 to s3 are {found}, not {wanted}")
            seen.add(number)
        if {1, 4} <= seen:
            return
    raise Violation(f"the numbers 1 and 4 do not come in 40 changes, only {sorted(seen)}")


def next_told(bench: BoardBench, watch: Watch, kind: type[EventT]) -> EventT:
    """Return the next of a kind that a part tells, when what it has done is at the pins."""
    before = len(watch.reported(kind))
    bench.board.run_until(lambda: len(watch.reported(kind)) > before, 1.0)
    bench.board.run(0.001)
    return last(watch.reported(kind)[before:], f"another {kind.__name__}").event
