"""Recordings of a PKT! line: the clauses of rover and host that can be judged by listening alone."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from hilbench.check import NotApplicable, Violation, within
from hilbench.check.capture_provider import CaptureCase
from hilbench.clock import NS_PER_S
from hilbench.recordings.listening import HOST, TARGET, Heard, Stretch
from hilbench.suites._recorded import Worst, around, on_recording, stretches_of
from protocols.common.items import Kind
from protocols.pkt import (
    MotorSpeeds,
    MotorThrottles,
    RemoteProtocolError,
    RequestTelemetry,
    Schema,
    UnknownCommand,
    decode_command,
)
from protocols.pkt.framing import SYNC

WINDOW_S = 10.0
WINDOW_NS = round(WINDOW_S * NS_PER_S)
SETTLED_NS = NS_PER_S // 2
"""By then all that a command brings has come (choice)."""
SILENCE_S = 1.0
REPORTS = {"GeneralReport": (30, 31), "MotionReport": (40, 41), "ImuReport": (10, 11), "GpsReport": (10, 11)}
"""How many come in 10 s without a command."""


def promised(bench: CaptureCase, end: str) -> Iterator[Stretch]:
    """Yield stretches but for cases of firmware and hosts as published, which do not do all that they promise."""
    for stretch in stretches_of(bench, end):
        if not stretch.case.endswith("]") or stretch.case.endswith("[documented]"):
            yield stretch


@on_recording("P28D")
def test_throttle_beyond_one(bench: CaptureCase) -> None:
    shown = [(throttle, stretch.at(one.ns)) for stretch in promised(bench, TARGET) for one in stretch.by(TARGET)
             if one.item.name == "MotionReport" for throttle in throttles(one)]  # fmt: skip
    if not shown:
        raise NotApplicable("there is no 0x83 in this recording")
    for throttle, where in shown:
        if math.isnan(throttle):
            raise Violation(f"0x83 shows no number as throttle ({where})")
    for throttle, where in (min(shown), max(shown)):
        within(throttle, -1.0, 1.0, unit="of full", what=f"throttle in 0x83 ({where})")


def throttles(one: Heard) -> tuple[float, ...]:
    found = one.item.fields.get("throttles", ())
    return tuple(float(value) for value in found) if isinstance(found, tuple) else ()


@on_recording("P30")
def test_periodic_reports(bench: CaptureCase) -> None:
    """In the first 10 s of each stretch of time in which the host says nothing and its rover is there."""
    windows = [(stretch, begin_ns) for stretch in stretches_of(bench, TARGET) for begin_ns in silences(stretch)]
    if not windows:
        raise NotApplicable(f"no host was silent for {WINDOW_S:g} s in this recording")
    for stretch, begin_ns in windows:
        end_ns = begin_ns + WINDOW_NS
        reports = stretch.between(begin_ns + 1, end_ns)
        names = [one.item.name for one in reports if one.by == TARGET and one.sound]
        for name, (least, most) in REPORTS.items():
            uncertain = round(most / WINDOW_S * stretch.uncertainty_s)
            what = f"{name} in 10 s ({stretch.at(begin_ns)})"
            within(names.count(name), least, most, unit="reports", what=what, uncertainty=uncertain)


def silences(stretch: Stretch) -> Iterator[int]:
    """Yield when silences of the host begin that are long enough: behind the reports that its last word has brought."""
    words = stretch.by(HOST)
    begins = [stretch.begin_ns + SETTLED_NS, *(settled_ns(stretch, word) for word in words)]
    ends = [*(word.ns for word in words), stretch.end_ns]
    for begin_ns, end_ns in zip(begins, ends, strict=True):
        if end_ns - begin_ns >= WINDOW_NS and stretch.quiet(begin_ns, begin_ns + WINDOW_NS):
            yield begin_ns


def settled_ns(stretch: Stretch, word: Heard) -> int:
    """Return when all that a word brings is there: a request brings one report."""
    settled_ns = word.ns + SETTLED_NS
    if not isinstance(command_of(word), RequestTelemetry):
        return settled_ns
    behind = stretch.between(word.ns + 1, settled_ns)
    return next((one.ns for one in behind if one.by == TARGET and one.item.name == "GeneralReport"), settled_ns)


@on_recording("P50")
def test_all_is_frames(bench: CaptureCase) -> None:
    heard = [(stretch, one) for stretch in promised(bench, HOST) for one in stretch.by(HOST)]
    if not heard:
        raise NotApplicable("no host said anything in this recording")
    for stretch, one in heard:
        if not one.sound:
            raise Violation(f"bytes in no frame: {one.item.name} ({stretch.at(one.ns)})", around(stretch, one.ns))
        if one.item.kind is not Kind.FRAME or isinstance(command_of(one), UnknownCommand):
            raise Violation(f"the rover has no such command ({stretch.at(one.ns)})", around(stretch, one.ns))


def command_of(one: Heard) -> object:
    try:
        return decode_command(one.item.raw[len(SYNC) + 1 : -3], Schema.V2)
    except RemoteProtocolError:
        return None


@on_recording("P51")
def test_heard_in_time(bench: CaptureCase) -> None:
    """Up to the end, unless the last thing that the host said was to stop both motors: then it has taken its leave."""
    worst = Worst("the longest silence of the host", "s")
    for stretch in promised(bench, HOST):
        said = [one for one in stretch.by(HOST) if one.sound]
        if not said:
            continue
        times_ns = [one.ns for one in said] + ([] if stops(said[-1]) else [stretch.end_ns])
        for before, after in pairwise(times_ns):
            if stretch.quiet(before, after):
                worst.take((after - before) / NS_PER_S, stretch.at(before), stretch.uncertainty_s)
    worst.judge(SILENCE_S, "no host was listened to for long enough")


def stops(one: Heard) -> bool:
    command = command_of(one)
    return isinstance(command, MotorThrottles | MotorSpeeds) and (command.a, command.b, command.flags & 3) == (0, 0, 3)
