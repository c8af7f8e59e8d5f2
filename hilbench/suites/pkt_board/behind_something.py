"""A frame behind something else, and counters that wrap."""

from __future__ import annotations

from hilbench.check import Untimely, Violation
from hilbench.suites._rover import Rover, on_rover
from hilbench.suites.pkt_board._frames import (
    BAD_CRC,
    BAD_SYNC,
    INVALID_LENGTH,
    LED_OFF,
    LED_ON,
    LED_ON_TERM,
    SUCCESS,
    led_on_frame,
    require_rejected,
)
from protocols.pkt import GeneralReport, LedOff

REQUEST_OF_AUTHOR = bytes.fromhex("504B5421020000 1D0F0A")

NO_LENGTH = bytes.fromhex("504B542100")

CUT_THROTTLE = bytes.fromhex("504B54210A030000")

PACE_S = 0.015
"""Between two of many frames: a receiver that looks every 10 ms and keeps 256 bytes is not run over."""


@on_rover("P11", lasts_s=0.6)
def test_a_p_too_many_as_shipped(rover: Rover) -> None:
    require_rejected(rover, b"P" + LED_ON, BAD_SYNC)


@on_rover("P11D", lasts_s=0.6)
def test_a_p_too_many(rover: Rover) -> None:
    rover.dark()
    rover.write(b"P" + LED_ON)
    rover.require(1, 1, 1, SUCCESS)
    assert rover.lit, "the frame after the P was not executed"


@on_rover("P12", lasts_s=0.6)
def test_a_piece_of_a_sync_word_as_shipped(rover: Rover) -> None:
    rover.after_periodic()
    mark = rover.mark()
    rover.write(b"PK" + REQUEST_OF_AUTHOR)
    if rover.peer.since(mark, GeneralReport):
        raise Untimely("the request was answered", rover.peer.evidence(mark))  # or it is the periodic 0x80
    rover.require(0, 1, None, BAD_SYNC)


@on_rover("P12D", lasts_s=0.6)
def test_a_piece_of_a_sync_word(rover: Rover) -> None:
    rover.after_periodic()
    mark = rover.mark()
    rover.write(b"PK" + REQUEST_OF_AUTHOR)
    answers = [report for _, report in rover.peer.since(mark, GeneralReport)]
    if not answers:
        raise Untimely("the request was not answered", rover.peer.evidence())
    rover.require(0, 1, None, BAD_SYNC)


@on_rover("P60", lasts_s=0.9)
def test_a_p_begins_a_frame_anywhere(rover: Rover) -> None:
    for count, broken in enumerate((b"P", b"PK", b"PKT", LED_ON[:-1]), start=1):
        rover.write(broken + LED_OFF)
        rover.require(count, count, 2, SUCCESS)


@on_rover("P13", lasts_s=0.6)
def test_noise(rover: Rover) -> None:
    rover.write(b"abcdefg\n" + led_on_frame(rover))
    rover.require(1, 0, 1, SUCCESS)


@on_rover("P14", lasts_s=0.6)
def test_noise_with_a_p(rover: Rover) -> None:
    rover.write(b"PING" + led_on_frame(rover))
    rover.require(1, 1, 1, SUCCESS)


@on_rover("P15", lasts_s=0.6)
def test_a_cut_frame_swallows_the_next(rover: Rover) -> None:
    require_rejected(rover, CUT_THROTTLE + LED_ON, BAD_CRC)


@on_rover("P16", lasts_s=0.6)
def test_a_cut_frame_swallows_one_frame(rover: Rover) -> None:
    rover.write(CUT_THROTTLE + LED_ON * 3)
    rover.require(2, 1, 1, SUCCESS)


@on_rover("P16D", lasts_s=0.6)
def test_a_cut_frame_costs_one_at_most(rover: Rover) -> None:
    rover.write(CUT_THROTTLE + LED_ON * 3)
    found = rover.counts
    if found.accepted not in (2, 3) or found.rejected < 1 or found.error != SUCCESS:
        raise Violation(f"the state is {found}, required 2 or 3 accepted, 1 or more rejected, error 0")


@on_rover("P17", lasts_s=0.6)
def test_a_frame_without_a_length(rover: Rover) -> None:
    rover.write(LED_ON_TERM)
    rover.require(0, 1, None, BAD_CRC)


@on_rover("P18", lasts_s=0.6)
def test_a_frame_without_a_length_costs_no_other(rover: Rover) -> None:
    rover.write(LED_ON_TERM + LED_ON)
    rover.require(1, 1, 1, SUCCESS)


@on_rover("P19", lasts_s=1.0)
def test_newlines_in_a_payload(rover: Rover) -> None:
    rover.write(rover.peer.frame(bytes.fromhex("030A0A0A3E0000000003")))
    rover.require(1, 0, 3, SUCCESS)
    rover.require_throttles(rover.motion(), 0.1348, 0.0)


@on_rover("P20", lasts_s=0.6)
def test_two_frames_in_one_write(rover: Rover) -> None:
    rover.write(led_on_frame(rover) + rover.peer.frame_of(LedOff()))
    rover.require(2, 0, 2, SUCCESS)


@on_rover("P21", lasts_s=7.0)
def test_accepted_wraps(rover: Rover) -> None:
    peer = rover.peer
    for count in range(256):
        peer.write(led_on_frame(rover))
        peer.run(peer.line_s(len(LED_ON)) + PACE_S)
        if count == 254:
            rover.require(255, 0, 1, SUCCESS, spare_s=PACE_S)
    rover.require(0, 0, 1, SUCCESS, spare_s=PACE_S)


@on_rover("P65", lasts_s=6.0)
def test_rejected_wraps(rover: Rover) -> None:
    peer = rover.peer
    for count in range(256):
        peer.write(NO_LENGTH)
        peer.run(peer.line_s(len(NO_LENGTH)) + PACE_S)
        if count == 254:
            rover.require(0, 255, None, INVALID_LENGTH, spare_s=PACE_S)
    rover.require(0, 0, None, INVALID_LENGTH, spare_s=PACE_S)
