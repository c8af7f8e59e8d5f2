"""What the images make of bytes is what the behavioural rover makes of them, profile by profile and defect by defect.

The two were written apart, from the same sources. Wheels are held, and sensors neither work nor fail.
"""

from __future__ import annotations

import functools
import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.pkt import (
    FrameReader,
    FramingOptions,
    MotionReport,
    Schema,
    decode_report,
    encode_frame,
)
from targets.firmware import image_names
from targets.robots.rover import DEFECTS, RoverRobot, RoverSettings
from tests.share import examples, few

PROFILES = {"rover": "documented", "rover-g2": "g2", "rover-g0": "g0", "rover-term": "term-doc"}
SPOILT = {f"rover-{name}": name for name in DEFECTS if f"rover-{name}" in image_names()}
POLLED = {"rover-g2", "rover-eagain-11", "rover-polled"}

NS_PER_US = 1000
OFF_TICK_S = 0.003  # what happens at the very time of a tick may be before or after it
TOLERANCE = 2e-4  # of a throttle: the chip's floats have 32 bits


def settings_of(image):
    if image in PROFILES:
        return RoverSettings(profile=PROFILES[image])
    return RoverSettings(defects=(SPOILT[image],))


def language_of(model):
    """The schema of its payloads, and how they are framed."""
    server = model.behaviour.server
    return server.schema, FramingOptions(framing=server.frames.framing)


class Twins:
    """The image and the model, which get the same bytes at the same times."""

    def __init__(self, rover, image):
        self.image = image
        self.chip = rover(image, sensors=False)
        self.model = RoverRobot(settings_of(image))
        self._boot_ns = round(self.model.behaviour.body.boot_s * 1_000_000_000)  # which the chip spends in main.c
        self.model.plant.force(0.0)
        self.schema, self._frames = language_of(self.model)
        self._told = self.model.advance(self._now_ns)
        self.wait(OFF_TICK_S)

    @property
    def _now_ns(self):
        """The model's time; the chip's begins when it has booted."""
        return self._boot_ns + self.chip.now_us * NS_PER_US

    def wait(self, seconds):
        self.chip.run(seconds)
        self._told += self.model.advance(self._now_ns)

    def write(self, data):
        self.chip.write(data)
        self._told += self.model.receive(data, self._now_ns)

    def frame(self, payload):
        return encode_frame(payload, self._frames)

    def _reports(self, data):
        """Reports whose fields do not depend on sensors."""
        found = FrameReader(self._frames).receive(data, 0)
        payloads = [frame.payload for frame in found]  # a frame that is none has no payload, and ends the test
        return [decode_report(payload, self.schema) for payload in payloads if payload[0] not in (0x82, 0x84)]

    def compare(self):
        self.wait(0.03)
        ours, theirs = self._reports(self.chip.fetch()), self._reports(self._told)
        self._told = b""
        assert [exact(report) for report in ours] == [exact(report) for report in theirs]
        for mine, other in zip(ours, theirs, strict=True):
            assert floats(mine) == pytest.approx(floats(other), abs=TOLERANCE, rel=1e-6, nan_ok=True)
        assert self.chip.leds[0] == self.model.lit
        if self.image != "rover-link-stops-report-only":  # what keeps turning there is a matter of one command each
            assert [limited(one) for one in self.chip.motors] == pytest.approx(self.model.duties, abs=TOLERANCE)


def limited(throttle):
    return 0.0 if math.isnan(throttle) else min(1.0, max(-1.0, throttle))


def exact(report):
    return report.ticks if isinstance(report, MotionReport) else report


def floats(report):
    return (*report.rpm, *report.throttles, *report.setpoints_rpm) if isinstance(report, MotionReport) else ()


FLOATS = st.sampled_from([0.0, 0.5, -0.25, 1.0, -1.0, 1.5, -2.0, math.nan, 0.1348])
RPM = st.sampled_from([0.0, 30.0, -20.0, 75.0, 500.0])
FLAGS = st.integers(0, 3)


def payloads(image, schema):
    """Payloads of commands, whole, too short, too long and unknown."""
    if schema is Schema.V1:
        motors = st.builds(struct.Struct(">Bhhb").pack, st.just(3), *[st.integers(-300, 300)] * 2, FLAGS)
        known = [motors]
    else:
        motors = st.builds(struct.Struct("<BffB").pack, st.just(3), FLOATS, FLOATS, FLAGS)
        setpoints = st.builds(struct.Struct("<BffB").pack, st.just(4), RPM, RPM, FLAGS)
        gains = st.builds(struct.Struct("<Bfff").pack, st.just(5), *[st.sampled_from([0.0, 0.001, 0.02])] * 3)
        known = [motors] if image in POLLED else [motors, setpoints, gains]
    plain = st.sampled_from([b"\0", b"\0\0", b"\x01", b"\x02", b"\x01\0\0", b"\x01" + bytes(60), b"\x7f", b"\x06\n"])
    short = st.builds(lambda payload, size: payload[:size], motors, st.integers(1, 5))
    return st.one_of(plain, *known, short)


def damaged(frame, at, value):
    at %= len(frame)
    return frame[:at] + bytes((value,)) + frame[at + 1 :]


def pieces(image, schema, frame):
    """Bytes as they may come: frames, damaged and cut ones, noise."""
    frames = payloads(image, schema).map(frame)
    bent = st.builds(damaged, frames, st.integers(0, 120), st.sampled_from([0x50, 0x0A, 0x00, 0x4B, 0x61, 0xFF]))
    cut = st.builds(lambda one, size: one[: 1 + size % len(one)], frames, st.integers(0, 100))
    noise = st.lists(st.sampled_from(list(b"PPKT!\n\0x")), max_size=8).map(bytes)
    return st.one_of(frames, frames, bent, cut, noise)


def steps(image, schema, frame):
    gaps = st.sampled_from([0.0, 0.0, 0.01, 0.02, 0.25, 0.51, 0.99, 1.3])
    return st.lists(st.tuples(gaps, pieces(image, schema, frame)), min_size=1, max_size=12)


@pytest.mark.parametrize("image", few([*PROFILES, *SPOILT], 5, "the gate has five of the images"))
def test_the_image_is_the_model(rover, image):
    schema, frames = language_of(RoverRobot(settings_of(image)))

    @settings(max_examples=examples(12))
    @given(steps(image, schema, functools.partial(encode_frame, options=frames)))
    def same(script):
        twins = Twins(rover, image)
        for gap_s, data in script:
            twins.wait(gap_s)
            twins.write(data)
        twins.compare()

    same()


def test_every_defect_of_the_model_has_an_image():
    assert set(SPOILT.values()) == set(DEFECTS)


def test_the_comparison_can_fail(rover):
    twins = Twins(rover, "rover")
    twins.chip = rover("rover-no-0x81", sensors=False)
    twins.write(twins.frame(b"\x01"))
    with pytest.raises(AssertionError):
        twins.compare()
