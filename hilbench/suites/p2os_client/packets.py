"""What comes in the session: sound, damaged, unknown and cut packets."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import pytest

from hilbench.check import Violation, at_least, case
from hilbench.suites._client import (
    WORKING_PERIOD_S,
    ClientBench,
    connect,
    damaged,
    own_client,
    require_session,
    sips_since,
    understood,
)
from hilbench.suites._spoiling import other_rules
from hilbench.systems.pioneer.scripted import SIP_CYCLE_S
from hilbench.systems.pioneer.scripted_packets import STANDING
from protocols.common.decoding import NoOptions
from protocols.p2os import LateSipFields, Sip, SonarReading, encode_frame, encode_packet
from protocols.p2os.decoding import checksum


def _numbered(tick: int) -> bytes:
    """Return a sound SIP that can be told from others by its x."""
    return encode_packet(dataclasses.replace(STANDING, x_raw=tick))


def _quieten(bench: ClientBench) -> int:
    """Stop the SIPs, let what is under way arrive, and return how many the client took so far."""
    bench.server.stream = lambda _tick: b""
    bench.server.run(2 * SIP_CYCLE_S)
    return len(own_client(bench).sips)


def _require_sips(bench: ClientBench, mark: int, sent: Sequence[int], *, lost: Sequence[int] = ()) -> None:
    """Require that the client understood the SIPs of these numbers, in order, and no others."""
    got = [sip.x_raw for sip in sips_since(bench, mark)]
    missing = [number for number in sent if number not in got and number not in lost]
    invented = [number for number in got if number not in sent]
    if missing or invented:
        raise Violation(
            f"of the sound SIPs {len(missing)} were lost, and {len(invented)} others were taken",
            (f"lost: {missing}", f"taken: {invented}"),
        )
    assert got == sorted(set(got)), f"SIPs were taken twice or out of order: {got}"


@case("C12", bench_time_s=3.7)
def test_damaged_sips_are_dropped(bench: ClientBench) -> None:
    connect(bench)
    mark = _quieten(bench)
    sent: list[int] = []

    def stream(_tick: int) -> bytes:
        sent.append(100 + 2 * len(sent))
        sound = _numbered(sent[-1])
        wrong = [damaged(sound), *(frame for _, frame in other_rules(sound, checksum(NoOptions())))]
        return wrong[len(sent) // 2 % len(wrong)] if len(sent) % 2 else sound

    bench.server.stream = stream
    require_session(bench, 3.0, "every second SIP was damaged")
    _quieten(bench)
    _require_sips(bench, mark, sent[1::2])


@case("C13", bench_time_s=3.2)
def test_noise_costs_no_sound_packet(bench: ClientBench) -> None:
    """In turn: a stray header byte, noise, half a SIP, and two header bytes without the rest."""
    connect(bench)
    mark = _quieten(bench)
    sent: list[int] = []

    def stream(_tick: int) -> bytes:
        sent.append(100 + len(sent))
        sip = _numbered(sent[-1])
        before = (b"", b"\xfa", b"\x00\x13\xfb\xfa\x07", sip[: len(sip) // 2], b"\xfa\xfb")[len(sent) % 5]
        return before + sip

    bench.server.stream = stream
    require_session(bench, 2.5, "there was noise on the line")
    _quieten(bench)
    _require_sips(bench, mark, sent)


@case("C14", bench_time_s=2.3)
def test_unknown_packets_change_nothing(bench: ClientBench) -> None:
    connect(bench)
    unknown = [encode_frame(body) for body in (b"\x61\x01\x02\x03", b"\xc0", b"\xc0\x01", b"\x7e", b"\x7e" + bytes(40))]
    bench.server.stream = lambda tick: _numbered(tick) + unknown[tick % len(unknown)]
    require_session(bench, WORKING_PERIOD_S, "packets came that it does not know")
    own = bench.client.own
    if own is not None:
        numbers = {sip.x_raw for sip in own.sips}
        at_least(len(numbers), 18, unit="", what="number of SIPs taken among unknown packets")


_FULL = tuple(SonarReading(number=number, range_raw=1000 + number) for number in range(16))

_TAIL = LateSipFields(
    battery_dv=131,
    charge_state=2,
    rotation_ddeg_s=-15,
    fault_flags=1,
    lateral_mm_s=0,
    temperature_c=31,
    charge_percent=80,
    time_us=123_456_789,
    flags3=5,
).encode()

_BUSY = Sip(
    moving=True,
    x_raw=1234,
    y_raw=4321,
    th_raw=-512,
    left_raw=150,
    right_raw=-50,
    battery_dv=126,
    control_raw=-600,
    flags=0x0003,
    compass_raw=45,
    timer=0x0C03,
    analog=0x55,
    digin=0xA5,
    digout=0x5A,
)


@case("C15", bench_time_s=0.7)
@pytest.mark.parametrize("sonars", [(), _FULL[:3], _FULL], ids=["n=0", "n=3", "n=16"])
@pytest.mark.parametrize("tail", [b"", _TAIL[:2], _TAIL], ids=["no-tail", "battery-tail", "whole-tail"])
def test_a_sip_of_any_length_is_read(bench: ClientBench, sonars: tuple[SonarReading, ...], tail: bytes) -> None:
    connect(bench)
    sent = dataclasses.replace(_BUSY, sonars=sonars, tail=tail)
    understood(bench, encode_packet(sent))
    got = dataclasses.replace(own_client(bench).sips[-1], tail=tail)
    wrong = [
        f"{field.name}: sent {getattr(sent, field.name)}, understood {getattr(got, field.name)}"
        for field in dataclasses.fields(Sip)
        if getattr(sent, field.name) != getattr(got, field.name)
    ]
    if wrong:
        raise Violation(f"{len(wrong)} fields of the SIP were misread", wrong)


_OTHER = Sip(
    moving=False,
    x_raw=4099,
    y_raw=517,
    th_raw=771,
    left_raw=-260,
    right_raw=515,
    battery_dv=131,
    stall_rear=2,
    stall_front=5,
    control_raw=770,
    flags=0x0002,
    compass_raw=90,
    sonars=(SonarReading(number=9, range_raw=5000), SonarReading(number=12, range_raw=6001)),
    timer=0x1405,
    analog=0xAA,
    digin=0x3C,
    digout=0xC3,
)
"""Another number than in `_BUSY` in each field."""


@case("C32", bench_time_s=1.6)
def test_each_sip_is_read_anew(bench: ClientBench) -> None:
    connect(bench)
    mark = _quieten(bench)
    sent: list[Sip] = []

    def stream(tick: int) -> bytes:
        sent.append(_OTHER if tick % 2 else dataclasses.replace(_BUSY, sonars=_FULL[:2]))
        return encode_packet(sent[-1])

    bench.server.stream = stream
    bench.server.run(1.0)
    _quieten(bench)
    got = [dataclasses.replace(sip, tail=b"") for sip in sips_since(bench, mark)]
    wrong = [f"sent {one}, understood {other}" for one, other in zip(sent, got, strict=False) if one != other]
    if wrong or len(got) != len(sent):
        raise Violation(f"of {len(sent)} SIPs {len(got)} were taken, {len(wrong)} of them misread", wrong[:2])


@case("C16", bench_time_s=2.3)
@pytest.mark.parametrize("claimed", [3, 16, 255])
def test_a_truncated_sip_is_dropped(bench: ClientBench, claimed: int) -> None:
    """The packet is sound but has two readings where it claims more."""
    connect(bench)
    body = bytearray(dataclasses.replace(_BUSY, sonars=_FULL[:2]).encode())
    body[_OFFSET_OF_N] = claimed
    truncated = encode_frame(bytes(body))
    bench.server.stream = lambda tick: truncated if tick % 2 else encode_packet(STANDING)
    require_session(bench, WORKING_PERIOD_S, "truncated SIPs came")
    own = bench.client.own
    if own is not None:
        taken = [sip for sip in own.sips if sip.x_raw == _BUSY.x_raw]
        assert not taken, f"a truncated SIP was taken, with {len(taken[0].sonars)} readings"


_OFFSET_OF_N = 19
"""Where the number of readings stands in the body of a SIP (Pioneer 2 Operations Manual, server information)."""
