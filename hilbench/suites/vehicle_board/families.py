"""Whole families of stimuli, each tried member by member: each byte within a float, each letter damaged, each mode."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace

from hilbench.suites._spoiling import WrongByte, other_values, single_bits
from hilbench.suites._vehicle import Vehicle, on_board, status_of
from hilbench.suites.vehicle_board._moves import quiet
from hilbench.suites.vehicle_board.statuses import INSIDE, MOST
from protocols.autoware import ControlMode
from protocols.carla import STATUS_LAYOUT, Mode, StatusFrame, encode_status

FLOW_CONTROL = {0x11: "XON", 0x13: "XOFF"}
OF_FRAMES = {ord(letter): letter for letter in "#ABCD$"}
OF_TERMINALS = {0x00: "NUL", 0x03: "ETX", 0x04: "EOT", 0x0A: "LF", 0x0D: "CR", 0x1A: "SUB", 0x1B: "ESC", 0x7F: "DEL"}

FLOAT = struct.Struct("<f")


def _with_values(values: Mapping[int, str]) -> Iterator[tuple[str, tuple[str, int, int]]]:
    """Yield a field, a place in it and a byte, for each byte at each place where the figure can still be true."""
    for (value, name), field, place in itertools.product(values.items(), fields(StatusFrame), range(FLOAT.size)):
        for number in range(1, 31):
            figure = getattr(_put(status_of(number), field.name, place, value), field.name)
            if not abs(figure) <= INSIDE * MOST[field.name]:
                break
        else:
            yield f"{name} ({value:02X}) as byte {place + 1} of {field.name}", (field.name, place, value)


def _put(status: StatusFrame, name: str, place: int, value: int) -> StatusFrame:
    data = bytearray(FLOAT.pack(getattr(status, name)))
    data[place] = value
    return replace(status, **{name: FLOAT.unpack(data)[0]})


@on_board("VB59", lasts_s=3.6)
def test_no_byte_is_special_within_a_float(vehicle: Vehicle) -> None:
    vehicle.autoware()
    numbers = itertools.count()

    def is_reported(field_place_and_value: tuple[str, int, int]) -> None:
        status = _put(status_of(1.0 + next(numbers) % 30), *field_place_and_value)
        mark = vehicle.stack.mark()
        vehicle.simulator.status = status
        vehicle.require_reported(status, mark)

    for family, values in (
        ("flow-control bytes", FLOW_CONTROL),
        ("bytes of frames", OF_FRAMES),
        ("control characters", OF_TERMINALS),
    ):
        vehicle.try_members(family, [*_with_values(values)], is_reported, budget=20)


LETTERS = {place: f"the {chr(letter)}" for place, letter in STATUS_LAYOUT.letters.items()}

TAKEN_S = 0.05
"""Until a status that is taken is reported: the time between two commands, and some."""


@on_board("VB60", lasts_s=9.0)
def test_each_letter_counts(vehicle: Vehicle) -> None:
    quiet(vehicle)
    mark, numbers = vehicle.mark(), itertools.count()

    def is_dropped(wrong: WrongByte) -> None:
        speed_m_s = 1.0 + next(numbers) % 30
        stack_mark = vehicle.stack.mark()
        vehicle.simulator.write(wrong.put_into(encode_status(status_of(speed_m_s + 0.5))))
        vehicle.run(TAKEN_S)
        status = vehicle.other_status(speed_m_s)
        vehicle.say(status)
        vehicle.require_reported(status, stack_mark)
        assert speed_m_s + 0.5 not in vehicle.speeds(stack_mark), "the damaged status is reported"

    frame = encode_status(status_of(1.0))
    single, others = single_bits(frame, LETTERS), other_values(frame, LETTERS)
    vehicle.try_members("single bits of letters", single, is_dropped, budget=len(single))
    vehicle.try_members("other bytes for letters", others, is_dropped, budget=60)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)


@on_board("VB61", lasts_s=1.2)
def test_no_other_mode_is_granted(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()

    def is_refused(mode: int) -> None:
        assert not vehicle.stack.request(mode).success, f"mode {mode} is granted"

    own = {ControlMode.AUTONOMOUS, ControlMode.MANUAL}
    members = [(f"mode {mode}", mode) for mode in range(256) if mode not in own]
    vehicle.try_members("other modes", members, is_refused, budget=60)
    vehicle.run(0.5)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)
