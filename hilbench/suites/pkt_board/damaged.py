"""Frames that are wrong."""

from __future__ import annotations

from hilbench.suites._rover import Rover, on_rover
from hilbench.suites.pkt_board._frames import (
    BAD_CRC,
    BAD_SYNC,
    BAD_TERMINATOR,
    INVALID_LENGTH,
    LED_ON,
    SUCCESS,
    require_rejected,
)


@on_rover("P05", lasts_s=0.6)
def test_wrong_crc(rover: Rover) -> None:
    require_rejected(rover, bytes.fromhex("504B5421010100000A"), BAD_CRC)


@on_rover("P06", lasts_s=0.6)
def test_wrong_terminator(rover: Rover) -> None:
    require_rejected(rover, LED_ON[:-1] + b"X", BAD_TERMINATOR)


@on_rover("P07", lasts_s=0.6)
def test_length_of_zero(rover: Rover) -> None:
    require_rejected(rover, bytes.fromhex("504B542100"), INVALID_LENGTH)


@on_rover("P08", lasts_s=0.8)
def test_length_beyond_the_limit(rover: Rover) -> None:
    rover.write(bytes.fromhex("504B542161"))
    rover.require(0, 1, None, INVALID_LENGTH)
    rover.write(bytes.fromhex("504B5421FF"))
    rover.require(0, 2, None, INVALID_LENGTH)


@on_rover("P09", lasts_s=0.6)
def test_longest_payload(rover: Rover) -> None:
    rover.write(rover.peer.frame(b"\x01" + bytes(95)))
    rover.require(1, 0, 1, SUCCESS)


@on_rover("P10", lasts_s=0.6)
def test_broken_sync_word(rover: Rover) -> None:
    rover.write(bytes.fromhex("504B5821"))
    rover.require(0, 1, None, BAD_SYNC)
