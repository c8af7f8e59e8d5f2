"""Frames that end at a newline."""

from __future__ import annotations

from hilbench.check import Violation
from hilbench.suites._rover import Counts, Rover, on_rover
from hilbench.suites.pkt_board._frames import BAD_CRC, INVALID_LENGTH, LED_ON_TERM, SUCCESS
from protocols.pkt import TERMINATOR, hides_newline


@on_rover("P31", lasts_s=0.6)
def test_newline_in_the_payload(rover: Rover) -> None:
    rover.write(bytes.fromhex("504B542103000A000A0377F30A"))
    rover.require(0, 1, None, BAD_CRC)


@on_rover("P32", lasts_s=0.6)
def test_newline_in_the_crc(rover: Rover) -> None:
    rover.write(bytes.fromhex("504B542103003B003B031B0A0A"))
    found, expected = rover.counts, Counts(0, 1, rover.before.last_opcode, BAD_CRC)
    tolerant = Counts(1, 0, 3, SUCCESS)
    if found not in (expected, tolerant):
        raise Violation(f"the state is {found}, required {expected}, or {tolerant} of a tolerant receiver")


@on_rover("P33", lasts_s=0.6)
def test_longest_payload_of_lines(rover: Rover) -> None:
    payload = b"\x01" + bytes(63)
    assert not hides_newline(payload)
    rover.write(rover.peer.frame(payload))
    rover.require(1, 0, 1, SUCCESS)


@on_rover("P34", lasts_s=0.8)
def test_limit_of_lines(rover: Rover) -> None:
    rover.write(b"PKT!" + b"x" * 70)
    rover.require(0, 1, None, INVALID_LENGTH)
    rover.write(LED_ON_TERM)
    rover.require(1, 1, 1, SUCCESS)


@on_rover("P35", lasts_s=0.6)
def test_no_room_for_a_crc(rover: Rover) -> None:
    rover.write(b"PKT!" + TERMINATOR)
    rover.require(0, 1, None, BAD_CRC)
