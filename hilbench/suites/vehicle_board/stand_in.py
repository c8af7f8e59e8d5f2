"""The link to the driving stack: messages that are damaged, and an agent that falls silent."""

from __future__ import annotations

from collections.abc import Iterator

from hilbench.suites._vehicle import COMMAND, MODE_WITHIN_S, Vehicle, on_board
from hilbench.suites.vehicle_board._moves import F1
from protocols.autoware import ControlMode, ControlModeRequest, ControlModeResponse
from protocols.carla import Mode

HEADER_BYTES = 5
"""A flag, two addresses and the length; the CRC is over what follows."""

HEARD_S, LOST_S = 2.8, 3.2
"""How long a driving stack may be silent that is there still, and after how long it is lost: 3 s (choice)."""


def _damaged(sound: bytes) -> Iterator[bytes]:
    """Return a frame with one bit turned over: each bit of its payload and its CRC in turn."""
    for number in range(8 * HEADER_BYTES, 8 * len(sound)):
        data = bytearray(sound)
        data[number // 8] ^= 1 << number % 8
        yield bytes(data)


@on_board("VB50", lasts_s=8.0)
def test_damaged_messages_are_none(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    stack_mark = vehicle.stack.mark()
    for data in _damaged(vehicle.stack.frame_of(ControlModeRequest(sequence=7, mode=ControlMode.MANUAL))):
        vehicle.stack.write(data)
        vehicle.run(0.01)
    for data in _damaged(vehicle.stack.frame_of(COMMAND)):
        vehicle.stack.write(data)
        vehicle.run(0.01)
    vehicle.run(0.2)
    assert not vehicle.reports(stack_mark, ControlModeResponse), "a damaged request is answered"
    frames = vehicle.frames(mark)
    vehicle.require_modes(frames, Mode.AUTOWARE)
    for got in frames:
        vehicle.require_frame(got, F1, "the frame of the sound commands")
    assert vehicle.stack.request(ControlMode.MANUAL).success, "a valid request after that is refused"


@on_board("VB55", lasts_s=9.0, noisy=True)  # in AUTOWARE without commands is sent what nobody filled (VB04)
def test_nobody_misses_a_silent_stack(vehicle: Vehicle) -> None:
    vehicle.manual(command_hz=None)
    vehicle.run(6.0)
    assert _light_behind_press(vehicle, "amber") == "amber", "a press does not lead to AUTOWARE"


@on_board("VB55H", lasts_s=13.0)
def test_a_silent_stack_is_lost(vehicle: Vehicle) -> None:
    vehicle.manual(command_hz=None)
    vehicle.stack.go_online()
    vehicle.run(HEARD_S)
    assert _light_behind_press(vehicle, "amber") == "amber", f"it is lost after {HEARD_S:g} s already"
    vehicle.run(1.5)  # MANUAL again, without commands
    vehicle.stack.go_online()
    vehicle.run(LOST_S)
    mark, stack_mark = vehicle.mark(), vehicle.stack.mark()
    assert _light_behind_press(vehicle, "amber") == "green", f"a press leads to AUTOWARE after {LOST_S:g} s of silence"
    vehicle.require_modes(vehicle.frames(mark), Mode.MANUAL)
    assert not vehicle.modes_reported(stack_mark), "the mode is reported to nobody"
    vehicle.run(1.0)
    vehicle.stack.go_online()
    vehicle.run(0.1)
    assert _light_behind_press(vehicle, "amber") == "amber", "it is not found again"


def _light_behind_press(vehicle: Vehicle, awaited: str) -> str:
    """Press the joystick; wait for a light; return the one that is lit."""
    vehicle.hands.hold()
    vehicle.run(0.02)
    vehicle.hands.let_go()
    vehicle.bench.run_until(lambda: vehicle.light == awaited, MODE_WITHIN_S)
    return vehicle.light
