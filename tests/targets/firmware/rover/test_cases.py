"""The conformance cases of the board, as stimulus and required counters, and the frames worked out by hand."""

from __future__ import annotations

import struct

import pytest

from protocols.pkt import FrameReader, decode_report, encode_frame
from tests.each import each

LED_ON = bytes.fromhex("504B54210101F1D10A")
LED_OFF = bytes.fromhex("504B54210102C1B20A")
REQUEST = bytes.fromhex("504B54210100E1F00A")
REQUEST_OF_CLIENT = bytes.fromhex("504B54210200001D0F0A")
UNKNOWN = bytes.fromhex("504B5421017F6E880A")
THROTTLES = bytes.fromhex("504B54210A030000003F000080BE038C420A")
CUT = bytes.fromhex("504B54210A030000")
ELEVEN = encode_frame(b"\x01\0\0")
LED_ON_TERM = bytes.fromhex("504B542101F1D10A")


def frame_of(schema_format, *values):
    return encode_frame(struct.pack(schema_format, *values))


def replies(rover):
    return [frame.payload for frame in FrameReader().receive(rover.fetch(), 0)]


def state(rover):
    """ACC/REJ/OP/ERR, read from memory so that asking changes nothing."""
    return "{:X}/{:X}/{:X}/{:X}".format(*rover.code.bytes_at(rover.code.symbols["telemetry"], 4))


def motion(rover):
    """The next report of motion."""
    rover.fetch()
    rover.run(0.25)
    return next(decode_report(payload) for payload in replies(rover) if payload[0] == 0x83)


DOCUMENTED, G2, G0 = ("rover",), ("rover-g2",), ("rover-g0",)
ALL = (*DOCUMENTED, *G2, *G0)

STATES = {
    "P01": (ALL, REQUEST, "0/0/0/0"),
    "P02": (ALL, LED_ON, "1/0/1/0"),
    "P03": (ALL, LED_OFF * 2, "2/0/2/0"),
    "P04": (ALL, UNKNOWN, "1/0/7F/5"),
    "P05": (ALL, bytes.fromhex("504B5421010100000A"), "0/1/0/3"),
    "P06": (ALL, LED_ON[:-1] + b"\x58", "0/1/0/4"),
    "P07": (ALL, bytes.fromhex("504B542100"), "0/1/0/2"),
    "P08": (ALL, bytes.fromhex("504B542161"), "0/1/0/2"),
    "P08 FF": (ALL, bytes.fromhex("504B5421FF"), "0/1/0/2"),
    "P09": (ALL, encode_frame(b"\x01" + bytes(95)), "1/0/1/0"),
    "P10": (ALL, bytes.fromhex("504B5821"), "0/1/0/1"),
    "P11": ((*G2, *G0, "rover-no-resync"), b"P" + LED_ON, "0/1/0/1"),
    "P11D": (DOCUMENTED, b"P" + LED_ON, "1/1/1/0"),
    "P12": ((*G2, *G0, "rover-no-resync"), b"PK" + REQUEST_OF_CLIENT, "0/1/0/1"),
    "P13": (ALL, b"abcdefg\n" + LED_ON, "1/0/1/0"),
    "P14": (ALL, b"PING" + LED_ON, "1/1/1/0"),
    "P15": (ALL, CUT + LED_ON, "0/1/0/3"),
    "P16": (ALL, CUT + LED_ON * 3, "2/1/1/0"),
    "P17": (ALL, LED_ON_TERM, "0/1/0/3"),
    "P18": (ALL, LED_ON_TERM + LED_ON, "1/1/1/0"),
    "P20": (ALL, LED_ON + LED_OFF, "2/0/2/0"),
    "P21": ((*DOCUMENTED, *G0), LED_ON * 256, "0/0/1/0"),
    "P22": ((*G2, *G0, "rover-no-len-check"), encode_frame(b"\x03"), "1/0/3/0"),
    "P22D": (DOCUMENTED, encode_frame(b"\x03"), "1/0/3/2"),
    "P25": ((*G2, "rover-eagain-11"), ELEVEN, "0/0/0/0"),
    "P25D": ((*DOCUMENTED, *G0, "rover-polled"), ELEVEN, "1/0/1/0"),
    "P31": (("rover-term",), bytes.fromhex("504B542103000A000A0377F30A"), "0/1/0/3"),
    "P32": (("rover-term",), bytes.fromhex("504B542103003B003B031B0A0A"), "0/1/0/3"),
    "P34": (("rover-term",), b"PKT!" + b"x" * 70, "0/1/0/2"),
    "P34 and on": (("rover-term",), b"PKT!" + b"x" * 70 + LED_ON_TERM, "1/1/1/0"),
    "P35": (("rover-term",), b"PKT!\n", "0/1/0/3"),
}


@pytest.mark.parametrize(
    ("image", "stimulus", "required"),
    [pytest.param(image, *rest, id=f"{case} {image}") for case, (images, *rest) in STATES.items() for image in images],
)
def test_counters(rover, image, stimulus, required):
    assert state(rover(image, sensors=False).write(stimulus).run(0.1)) == required


def test_request_is_answered_at_once_with_the_worked_frame(rover):
    chip = rover(sensors=False)
    chip.fetch()
    assert chip.write(REQUEST).fetch().hex(" ").upper() == "50 4B 54 21 06 80 00 00 00 00 00 DA 30 0A"


def test_request_without_a_length_byte(rover):
    chip = rover("rover-term")
    assert chip.fetch() == b""
    assert chip.write(bytes.fromhex("504B542100E1F00A")).fetch() == bytes.fromhex("504B5421800000000033DC0A")


def test_the_led_and_its_report(rover):
    chip = rover(sensors=False)
    chip.fetch()
    assert chip.write(LED_ON).fetch() == bytes.fromhex("504B542103810100F3C70A")
    assert chip.leds[0]
    chip.write(LED_OFF)
    assert not chip.leds[0]


def test_first_reports_of_both_generations(rover):
    still = bytes.fromhex("504B54213483") + bytes(51) + bytes.fromhex("8CBB0A")
    turning = bytes.fromhex("504B54213483000000" + "0000803F" * 4) + bytes(32) + bytes.fromhex("787F0A")
    assert still in rover(sensors=False).fetch()
    for image in ("rover-first-rpm-1", "rover-g2"):
        assert turning in rover(image, sensors=False).fetch()


def test_reports_in_ten_seconds(rover):
    chip = rover(sensors=False)
    chip.run(9.995)
    counts = [payload[0] for payload in replies(chip)]
    assert {one: counts.count(one) for one in set(counts)} == {0x80: 31, 0x83: 40, 0x82: 10, 0x84: 10}


def test_half_a_frame_is_forgotten(rover):
    for pause_s, required in ((0.5, "1/0/1/0"), (30, "0/0/0/0")):
        chip = rover(sensors=False).write(LED_ON[:6]).run(pause_s)
        assert state(chip.write(LED_ON[6:])) == required


def test_half_a_frame_waits_for_ever_where_nothing_times_it(rover):
    assert state(rover("rover-no-frame-timeout").write(LED_ON[:6]).run(30).write(LED_ON[6:])) == "1/0/1/0"


def test_newlines_in_a_payload(rover):
    chip = rover(sensors=False).write(frame_of("<B4sfB", 3, b"\x0a\x0a\x0a\x3e", 0.0, 3))
    assert motion(chip).throttles[0] == pytest.approx(0.1348, abs=1e-4)


def test_flags_choose_the_motors(rover):
    chip = rover(sensors=False)
    chip.write(frame_of("<BffB", 3, 0.5, -0.25, 1))
    assert chip.motors == [0.5, 0.0]
    chip.write(frame_of("<BffB", 3, 1.0, 1.0, 0))
    assert chip.motors == [0.5, 0.0]
    assert state(chip) == "2/0/3/0"


def test_silence_stops_the_motors_and_a_request_keeps_them(rover):
    chip = rover(sensors=False).write(THROTTLES)
    for _ in range(6):
        assert chip.run(0.5).write(REQUEST).motors == [0.5, -0.25]
    assert chip.run(0.98).motors == [0.5, -0.25]
    assert chip.run(0.05).motors == [0.0, 0.0]
    chip.write(REQUEST).run(0.1)
    assert chip.motors == [0.0, 0.0]
    assert chip.write(THROTTLES).motors == [0.5, -0.25]


def test_a_host_that_comes_back_too_late_was_lost(rover):
    """Between two ticks, so that only the frame itself can tell."""
    chip = rover(sensors=False).run(0.003).write(THROTTLES)
    assert chip.run(1.001).write(REQUEST).motors == [0.0, 0.0]
    chip = rover(sensors=False).run(0.003).write(THROTTLES)
    assert chip.run(0.999).write(REQUEST).motors == [0.5, -0.25]


def test_silence_stops_the_speed_controllers_too(rover):
    chip = rover(sensors=False).write(frame_of("<BffB", 4, 30.0, 30.0, 3))
    assert chip.run(0.5).motors[0] > 0.3
    assert chip.run(0.6).motors == [0.0, 0.0]
    assert motion(chip).setpoints_rpm == (0.0, 0.0)


@each("image", ["rover-g2", "rover-no-link-timeout"])
def test_silence_is_not_noticed(rover, image):
    assert rover(image, sensors=False).write(THROTTLES).run(10).motors == [0.5, -0.25]


def test_only_the_report_says_that_the_motors_stopped(rover):
    chip = rover("rover-link-stops-report-only", sensors=False).write(THROTTLES).run(1.1)
    assert chip.motors == [0.5, -0.25]
    assert motion(chip).throttles == (0.0, 0.0)


def test_the_speed_controllers_first_second(rover):
    for image in ("rover", "rover-g2"):
        chip = rover(image, sensors=False).run(0.5).write(frame_of("<BffB", 4, 30.0, 30.0, 3)).run(0.24)
        report = motion(chip)
        assert report.throttles == pytest.approx((0.3008, 0.3008), abs=0.001)
        assert report.setpoints_rpm == (30.0, 30.0)


def test_gains(rover):
    drive = frame_of("<BffB", 4, 30.0, 30.0, 3)
    chip = rover(sensors=False).write(frame_of("<Bfff", 5, 0.02, 0.0, 0.0)).write(drive)
    assert motion(chip).throttles == pytest.approx((0.6, 0.6), abs=0.001)
    for image in ("rover-pid-offsets", "rover-g2"):
        late = rover(image, sensors=False).write(encode_frame(b"\x01" + bytes(20)))
        late.run(0.05).write(frame_of("<Bfff", 5, 0.0, 0.01, 0.0)).run(0.05).write(drive).run(0.1)
        assert motion(late).throttles == pytest.approx((0.3, 0.3), abs=0.001)


def test_what_the_report_of_the_gains_says(rover):
    for image, required in (
        ("rover-pid-report", (1.0, -1.0, 0.02, 0.3, 0.004)),
        ("rover-kd-ki-getters", (1.0, -1.0, 0.02, 0.02, 0.02)),
    ):
        chip = rover(image, sensors=False).write(frame_of("<Bfff", 5, 0.02, 0.3, 0.004))
        chip.fetch()
        payload = next(payload for payload in replies(chip.run(1.0)) if payload[0] == 0x85)
        report = decode_report(payload)
        values = (report.maximum, report.minimum, report.kp, report.kd, report.ki)
        assert values == pytest.approx(required)


def test_a_mode_that_is_entered_anew_begins_anew(rover):
    """With ki alone the throttle is the sum of the error over time: 100 rpm for one second."""
    drive, stop = frame_of("<BffB", 4, 100.0, 100.0, 3), frame_of("<BffB", 3, 0.0, 0.0, 3)
    for image, kept in (("rover", 0.0), ("rover-pid-no-reset", 0.05)):
        chip = rover(image, sensors=False).write(frame_of("<Bfff", 5, 0.0, 0.0, 0.001)).write(drive)
        chip.run(0.5).write(stop).write(drive).run(0.04)
        assert chip.motors[0] == pytest.approx(kept + 0.004, abs=0.0021)


def test_the_sum_ends_where_the_output_does(rover):
    """30 rpm with a ki of 0.1 reach the limit after 0.33 s; -30 rpm for 0.3 s then leave nearly nothing, or more."""
    for image, low, high in (("rover", -0.1, 0.2), ("rover-pid-windup", 1.0, 1.0)):
        chip = rover(image, sensors=False).write(frame_of("<Bfff", 5, 0.0, 0.0, 0.1))
        chip.write(frame_of("<BffB", 4, 30.0, 30.0, 3)).run(0.9)
        assert chip.motors[0] == 1.0
        chip.write(frame_of("<BffB", 4, -30.0, -30.0, 3)).run(0.3)
        assert low <= chip.motors[0] <= high


def test_bytes_beyond_32_wait_for_the_next_tick(rover):
    chip = rover("rover-polled", sensors=False)
    chip.write(LED_ON * 8)
    seen = []
    for _ in range(3):
        chip.run(0.01)
        seen.append(state(chip).split("/")[0])
    assert seen == ["3", "7", "8"]


def test_the_second_schema(rover):
    chip = rover("rover-v1b", sensors=False).write(bytes.fromhex("504B5421060364009CFF036EEE0A"))
    assert chip.motors == pytest.approx([100 / 255, -100 / 255])
    chip.fetch()
    payload = next(payload for payload in replies(chip.run(0.25)) if payload[0] == 0x83)
    assert struct.unpack_from("<hh", payload, 36) == (100, -100)
    assert len(payload) == 48


def test_the_first_schema_is_big_endian(rover):
    chip = rover("rover-g0", sensors=False).write(bytes.fromhex("504B542106030064FF9C03F1550A"))
    assert chip.motors == pytest.approx([100 / 255, -100 / 255])


def test_the_alarm_light_says_that_the_host_is_silent(rover):
    chip = rover(sensors=False).run(0.9)
    assert not chip.leds[2]
    assert chip.run(0.2).leds[2]
    assert not chip.write(REQUEST).leds[2]


def test_the_light_of_life_blinks_until_the_first_packet(rover):
    chip = rover(sensors=False)
    seen = [chip.leds[1], chip.run(1.0).leds[1], chip.run(1.0).leds[1]]
    assert seen == [True, False, True]
    chip.write(LED_ON)
    after = chip.leds[1]
    assert chip.run(3.0).leds[1] == after
