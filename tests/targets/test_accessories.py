"""Bumper guard, user I/O, AUX ports, gripper, host baud, requests, settings, ledger."""

from __future__ import annotations

import dataclasses

import pytest

from protocols.p2os import COMMANDS
from targets.robots.pioneer import LEDGER, Fidelity, RobotSettings, describe, settings_for
from targets.robots.pioneer.auxport import BUFFER, AuxPort
from targets.robots.pioneer.bumpers import BumpGuard
from targets.robots.pioneer.commands import HANDLERS
from targets.robots.pioneer.gripper import Gripper
from targets.robots.pioneer.hostbaud import HostBaud
from targets.robots.pioneer.requests import Extra, RequestBook
from targets.robots.pioneer.userio import UserIo
from tests.each import each

SETTINGS = RobotSettings()
SECOND = 1_000_000_000


@each(
    ("mode", "masks", "stops"),
    [
        (0, (1, 1), False),
        (1, (0b100, 0), True),
        (1, (0, 0b100), False),
        (2, (0b100, 0), False),
        (2, (0, 0b100), True),
        (3, (0b10000, 0), True),
        (3, (0, 0b1), True),
        (3, (0b100000, 0), False),
    ],
)
def test_bump_modes(mode: int, masks: tuple[int, int], stops: bool) -> None:
    guard = BumpGuard(SETTINGS)
    guard.mode = mode
    assert guard.update(masks, 0.0, 0.0, motors_on=True) is stops
    assert guard.latched is stops


def test_at_rest_only_a_new_contact_stops() -> None:
    guard = BumpGuard(SETTINGS)
    guard.mode = 3
    assert guard.update((1, 0), 0.0, 0.0, motors_on=True)
    assert not guard.update((1, 0), 0.0, 0.0, motors_on=True)
    assert guard.update((3, 0), 0.0, 0.0, motors_on=True)
    assert not guard.update((0, 0), 0.0, 0.0, motors_on=True)
    assert guard.update((1, 0), 0.0, 0.0, motors_on=True)
    assert guard.latched


@each(
    ("masks", "asked", "stops"),
    [((1, 0), 0.1, True), ((1, 0), -0.1, False), ((0, 1), -0.1, True), ((0, 1), 0.1, False), ((1, 1), 0.0, False)],
)
def test_a_new_order_ends_the_stall_bits_unless_it_leads_to_the_contact(
    masks: tuple[int, int], asked: float, stops: bool
) -> None:
    guard = BumpGuard(SETTINGS)
    guard.mode = 3
    guard.update(masks, 0.0, 0.0, motors_on=True)
    guard.release()
    assert guard.latched, "the bits stay until the order has been looked at"
    assert guard.update(masks, 0.0, asked, motors_on=True) is stops
    assert guard.latched is stops


@each(("speed", "masks", "stops"), [(50.0, (1, 0), True), (-50.0, (1, 0), False), (-50.0, (0, 1), True)])
def test_only_toward_the_bumper_where_the_firmware_is_late(speed: float, masks: tuple[int, int], stops: bool) -> None:
    guard = BumpGuard(dataclasses.replace(SETTINGS, bump_stall_only_toward=True))
    guard.mode = 3
    assert guard.update(masks, speed, 0.0, motors_on=True) is stops


def test_without_bumpers_every_bit_is_set_and_nothing_stops() -> None:
    guard = BumpGuard(dataclasses.replace(SETTINGS, bumpers_fitted=False))
    guard.mode = 3
    assert not guard.update((1, 1), 100.0, 100.0, motors_on=True)
    assert guard.segments() == (0x7F, 0x7F)


def test_digital_outputs_change_only_under_the_mask() -> None:
    io = UserIo(dataclasses.replace(SETTINGS, digital_out=0b1010_1010))
    io.write(0x0F05)
    assert io.digital_out == 0b1010_0101
    io.write(-241)  # 0xFF0F as ARIA sends it
    assert io.digital_out == 0x0F


def test_analog_selection() -> None:
    io = UserIo(dataclasses.replace(SETTINGS, analog=(0, 256, 512, 768, 1023)))
    assert (io.selected_port, io.selected_analog) == (5, 255)
    assert io.select(2)
    assert io.selected_analog == 64
    assert not io.select(6)
    assert not io.select(0)
    assert io.selected_port == 2


def test_aux_bytes_come_only_when_all_are_there() -> None:
    port = AuxPort(loop_back=False)
    assert port.want(3)
    port.feed(b"ab")
    assert port.take_due() == b""
    port.feed(b"cd")
    assert port.take_due() == b"abc"
    assert port.take_due() == b""
    assert port.want(0)
    assert port.want(1)
    assert port.take_due() == b""
    assert not port.want(201)
    assert not port.want(-1)


def test_aux_loop_back_and_bounds() -> None:
    port = AuxPort(loop_back=True)
    port.send(b"AT")
    port.want(2)
    assert port.take_due() == b"AT"
    assert port.take_sent() == b"AT"
    assert port.take_sent() == b""
    port.feed(bytes(BUFFER) + b"end")
    port.want(3)
    assert port.take_due() == bytes(3)


def test_gripper_travels_and_stops_on_command() -> None:
    gripper = Gripper()
    assert gripper.state(0) == 0x3F
    assert gripper.command(2, 0)
    assert gripper.state(SECOND) == 0x80 | 0x3E
    assert gripper.state(3 * SECOND) == 0x3F
    assert gripper.command(4, 3 * SECOND)
    assert gripper.command(15, 4 * SECOND)
    assert gripper.state(9 * SECOND) == 0x3D
    assert gripper.command(5, 9 * SECOND)
    assert gripper.state(9 * SECOND) & 0x40
    assert not gripper.command(17, 9 * SECOND)


def test_host_baud_trial() -> None:
    baud = HostBaud(9600, 500)
    assert baud.request(2, 100)
    assert (baud.baud, baud.next_deadline_ns()) == (38400, 600)
    baud.confirm()
    assert baud.next_deadline_ns() is None
    assert baud.request(4, 1000)
    baud.revert()
    assert baud.baud == 38400
    assert not baud.request(5, 2000)
    assert baud.reset()
    assert baud.baud == 9600
    assert not baud.reset()


def test_requests_once_stream_and_stop() -> None:
    book = RequestBook()
    book.ask(Extra.IO, 2)
    book.ask(Extra.CONFIG, 1)
    book.ask(Extra.CONFIG, 1)
    assert book.due() == (Extra.CONFIG, Extra.IO)
    book.sent(Extra.IO)
    assert book.due() == (Extra.CONFIG, Extra.IO)
    book.sent(Extra.CONFIG)
    assert book.due() == (Extra.IO,)
    book.ask(Extra.IO, 0)
    assert book.due() == ()
    book.ask(Extra.ENCODER, 3)
    book.clear()
    assert book.due() == ()


def test_every_setting_has_a_source() -> None:
    for item in describe(SETTINGS):
        assert item.source
        assert item.name


@each("changes", [{"name": "x" * 20}, {"subclass": "a\0b"}, {"wheel_diameter_mm": 0.0}, {"sip_cycle_ms": -1}])
def test_settings_that_make_no_robot(changes: dict[str, object]) -> None:
    with pytest.raises(ValueError):
        RobotSettings(**changes)


def test_the_default_robot_is_the_p2dx_of_the_table() -> None:
    standard, table = RobotSettings(), settings_for("p2dx")
    assert table == standard


def test_other_robots() -> None:
    amigo, first = settings_for("amigo"), settings_for("pion1x")
    assert amigo.sonar_discs == tuple(range(8))
    assert amigo.speed_unit_mm_s == 0.6154
    assert not amigo.bumpers_fitted
    assert (first.heading_units_per_turn, first.vel2_unit_mm_s, first.has_move) == (1024, 4.0, False)
    assert settings_for("powerbot").front_bumper_segments == 7
    with pytest.raises(ValueError, match="p2zz"):
        settings_for("p2zz")


def test_the_ledger_speaks_of_every_command_once_and_tells_the_truth() -> None:
    mentioned = [number for entry in LEDGER for number in entry.commands]
    assert len(mentioned) == len(set(mentioned))
    for entry in LEDGER:
        for number in entry.commands:
            assert (number in HANDLERS) == (entry.fidelity is not Fidelity.ABSENT), number
    assert set(HANDLERS) <= set(mentioned)
    simulator = range(224, 240)
    assert {number for number in COMMANDS if number not in simulator} <= set(mentioned)
