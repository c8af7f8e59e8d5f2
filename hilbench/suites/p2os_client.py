"""What a P2OS client must do: every conformance case that a program which drives a robot can be put to.

The far end is a scripted server. The cases judge what the client sends; where it can be asked, also what it understood.
The limits are those of the clauses; where a clause has none, the constant that stands for it says where it comes from.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from itertools import pairwise

import pytest

from hilbench.cases import VirtualCase
from hilbench.check import Violation, at_least, at_most, case, near
from hilbench.clock import NS_PER_S
from hilbench.scripted_packets import CONFIG, IDENTIFICATION, MOVING, STANDING
from hilbench.scripted_server import HANDSHAKE_NAMES, SIP_CYCLE_S, Heard, Pause
from hilbench.suites._client import (
    CONFIG_WITHIN_S,
    CONNECT_WITHIN_S,
    ECHO0,
    ECHO1,
    ClientBench,
    begin,
    byte_pair,
    connect,
    damaged,
    expect_session,
    identification,
    own_client,
    require_end,
    require_lost,
    require_session,
    seconds_between,
    sips_since,
    understood,
)
from protocols.p2os import (
    MAX_COUNT_STRICT,
    ClientOptions,
    ClientState,
    CommandNumber,
    ControllerReset,
    LateSipFields,
    LocalProtocolError,
    Sip,
    SonarReading,
    SyncError,
    UnknownSubclass,
    encode_frame,
    encode_packet,
    robot_parameters,
)

GIVE_UP_WITHIN_S = 20.0
"""How long a client may try before it gives up. The clauses say "a set time"; ARIA takes 6.4 s, Player, which tries
five rates, some 14 s."""

LOSS_WITHIN_S = 10.0
"""How long a client may take a silent robot for alive; clause C19 has it."""

ANSWER_AFTER_S, ANSWERED_S = 0.3, 0.25
"""How late the steps of the handshake are answered where the client is to wait, and how soon after a step its next one
shows that it did not. Player looks for the first answer after 0.4 s, and only once; the rest is for a late host."""

KEEPALIVE_S = 1.0
"""How long a client may be silent in a session; clause C22 has it."""

LEAVE_WITHIN_S = 3.0
"""How long a client may take from its user's wish to CLOSE. No source has a limit; ARIA takes 0.1 s."""

WORKING_PERIOD_S = 2.0
"""How long a session is watched for ill effects of what went before."""

REAL = bytes.fromhex("FAFB21320000000000000000000090FEFE00000000000204007D0700" + "7D05005930F011B4")
"""A SIP captured from a real Pioneer 2-DX without bumpers (qemu-gazebo-sim/p2os-arduino, test_sip.cpp)."""

GOLDEN = bytes.fromhex("FAFB2133A604F67F0004C8002C01800102000403002D0200E80305930E050080FF0F0C1D")
"""A SIP with every field in use; what it says was read alike by ARIA and by hand from the Pioneer 2 manual."""


# --- the handshake


@case("C01", bench_time_s=9.0)
def test_silence_makes_it_give_up(bench: ClientBench) -> None:
    bench.server.silence()
    begin(bench)
    require_end(bench, GIVE_UP_WITHIN_S, "nothing answers")
    tries = len(bench.server.heard("SYNC0"))
    at_least(tries, 3, unit="", what="number of SYNC0s")
    own = bench.client.own
    assert own is None or own.failure, "the client does not report that it could not connect"


@case("C02", bench_time_s=1.2)
def test_the_handshake_goes_step_by_step(bench: ClientBench) -> None:
    server = bench.server
    answers = {"SYNC0": ECHO0, "SYNC1": ECHO1, "SYNC2": encode_packet(IDENTIFICATION)}
    for name, answer in answers.items():
        server.answer(name, Pause(ANSWER_AFTER_S), answer)
    connect(bench)
    steps = [server.heard(name)[0] for name in HANDSHAKE_NAMES if server.heard(name)] + server.heard("OPEN")[:1]
    assert len(steps) == len(HANDSHAKE_NAMES) + 1
    for before, after in pairwise(steps):
        elapsed_s = (after.start_ns - before.at_ns) / NS_PER_S
        doubt_s = server.uncertainty_s(before.at_ns)
        at_least(
            elapsed_s, ANSWERED_S, unit="s", what=f"{after.name} came behind {before.name} by", uncertainty=doubt_s
        )
    own = bench.client.own
    assert own is None or own.identification == IDENTIFICATION, "the client misread the identification"


@case("C03", bench_time_s=2.7)
def test_a_slow_answer_is_awaited(bench: ClientBench) -> None:
    for name, answer in (("SYNC0", ECHO0), ("SYNC1", ECHO1), ("SYNC2", encode_packet(IDENTIFICATION))):
        bench.server.answer(name, Pause(0.8), answer)
    connect(bench)


@case("C04", bench_time_s=0.4)
@pytest.mark.parametrize("cut", [1, 3, 5])
def test_an_answer_in_pieces_is_put_together(bench: ClientBench, cut: int) -> None:
    for name, answer in (("SYNC0", ECHO0), ("SYNC1", ECHO1), ("SYNC2", encode_packet(IDENTIFICATION))):
        bench.server.answer(name, answer[:cut], Pause(0.05), answer[cut:])
    connect(bench)


@case("C05", bench_time_s=0.5)
def test_an_echo_of_the_step_before_is_no_answer(bench: ClientBench) -> None:
    bench.server.answer("SYNC1", ECHO0, times=1)
    connect(bench)
    steps = [heard.name for heard in bench.server.heard(*HANDSHAKE_NAMES)]
    after = steps[steps.index("SYNC1") + 1]
    assert after in ("SYNC0", "SYNC1"), f"a stale echo was taken for that of SYNC1: {after} came next"


@case("C06", bench_time_s=0.5)
@pytest.mark.parametrize("step", HANDSHAKE_NAMES)
def test_a_sync_error_sends_it_back_to_sync0(bench: ClientBench, step: str) -> None:
    bench.server.answer(step, encode_packet(SyncError()), times=1)
    connect(bench)
    after = _behind(bench, step)
    assert after == "SYNC0", f"SYNC0 is due after a SYNC error, but {after} came"


def _behind(bench: ClientBench, step: str) -> str:
    """Return what the client said next after it had first taken a step of the handshake."""
    steps = [heard.name for heard in bench.server.heard(*HANDSHAKE_NAMES, "OPEN")]
    return steps[steps.index(step) + 1]


@case("C07", bench_time_s=1.3)
def test_an_old_session_at_rest_is_taken_over(bench: ClientBench) -> None:
    _take_over(bench, STANDING)


@case("C08", bench_time_s=1.3)
def test_an_old_session_in_motion_is_taken_over(bench: ClientBench) -> None:
    _take_over(bench, MOVING)


def _take_over(bench: ClientBench, old: Sip) -> None:
    """The robot sends one more SIP after CLOSE, as one does whose cycle had begun."""
    server = bench.server
    server.stream = lambda _tick: encode_packet(old)
    server.begin_session(sips_after_close=1)
    begin(bench)
    closed = server.expect_command("CLOSE", GIVE_UP_WITHIN_S, mark=0, what="CLOSE to the old session")
    server.stream = lambda _tick: encode_packet(STANDING)
    sync = server.expect_command("SYNC0", CONNECT_WITHIN_S, what="SYNC0 after CLOSE")
    doubt_s = server.uncertainty_s(closed.at_ns)
    at_least(seconds_between(closed, sync), SIP_CYCLE_S, unit="s", what="wait after CLOSE", uncertainty=doubt_s)
    if not server.sessions_opened:
        expect_session(bench)
    require_session(bench, 0.5, "nothing happened after the take-over")


@case("C09", bench_time_s=1.3)
def test_a_damaged_identification_is_refused(bench: ClientBench) -> None:
    server = bench.server
    server.answer("SYNC2", damaged(encode_packet(IDENTIFICATION)), times=1)
    connect(bench)
    assert _behind(bench, "SYNC2") != "OPEN", "an identification with a wrong checksum was accepted"
    own = bench.client.own
    assert own is None or own.identification == IDENTIFICATION, "the damaged name was kept"


@case("C09", bench_time_s=1.3)
@pytest.mark.parametrize("step", ["SYNC0", "SYNC1"])
def test_a_damaged_echo_is_refused(bench: ClientBench, step: str) -> None:
    _refuse_echo(bench, step, times=1)


@case("C09", bench_time_s=4.3)
@pytest.mark.parametrize("step", ["SYNC0", "SYNC1"])
def test_damaged_echoes_are_refused(bench: ClientBench, step: str) -> None:
    """So many in a row that a client which may go back to SYNC0 does so."""
    _refuse_echo(bench, step, times=4)


def _refuse_echo(bench: ClientBench, step: str, times: int) -> None:
    bench.server.answer(step, damaged({"SYNC0": ECHO0, "SYNC1": ECHO1}[step]), times=times)
    connect(bench)
    after = _behind(bench, step)
    assert after in ("SYNC0", step), f"a damaged echo was taken for one of {step}: {after} came next"


@case("C10", bench_time_s=5.0)
def test_an_unknown_robot_is_no_catastrophe(bench: ClientBench) -> None:
    server = bench.server
    server.answer("SYNC2", identification("p9zz"))
    begin(bench)
    server.wait(lambda: server.sessions_opened > 0, WORKING_PERIOD_S)
    if server.sessions_opened:
        require_session(bench, WORKING_PERIOD_S, "it had taken an unknown robot")
    else:
        require_end(bench, GIVE_UP_WITHIN_S, "the robot is unknown to it")
    own = bench.client.own
    assert own is None or own.failure or own.state is ClientState.OPEN, "an unknown robot was not reported"


@case("C10", bench_time_s=0.2, needs=("client.options",))
@pytest.mark.parametrize("choice", list(UnknownSubclass), ids=lambda choice: choice.name.lower())
def test_an_unknown_robot_is_dealt_with_as_told(bench: VirtualCase, choice: UnknownSubclass) -> None:
    bench.server.answer("SYNC2", identification("p9zz"))
    bench.client_with(ClientOptions(unknown_subclass=choice, fallback_subclass="p2at"))
    own = own_client(bench)
    begin(bench)
    bench.server.wait(lambda: bool(own.failure) or own.state is ClientState.OPEN, CONNECT_WITHIN_S)
    if choice is UnknownSubclass.REFUSE:
        assert own.state is ClientState.FAILED, f"an unknown robot was to be refused; the client {own.state.value}"
        assert "unknown" in own.failure, f"the failure is put down to '{own.failure}'"
        bench.server.expect_command("CLOSE", 0.1, mark=0)
    else:
        assert own.state is ClientState.OPEN, f"the client was to fall back; it {own.failure or own.state.value}"
        assert own.robot == robot_parameters("p2at"), "other parameters were taken than those to fall back on"


@case("C11", bench_time_s=6.0)
@pytest.mark.parametrize(
    "body",
    [b"\x02", b"\x02bench", b"\x02bench\0Pioneer\0"],
    ids=["empty", "no-nul", "two-strings"],
)
def test_a_broken_identification_is_reported(bench: ClientBench, body: bytes) -> None:
    bench.server.answer("SYNC2", encode_frame(body))
    begin(bench)
    require_end(bench, GIVE_UP_WITHIN_S, "the identification is broken")
    assert not bench.server.sessions_opened, "a session was opened with a robot that did not say what it is"
    own = bench.client.own
    assert own is None or own.failure, "the broken identification was not reported"


# --- what comes in the session


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
        return damaged(_numbered(sent[-1])) if len(sent) % 2 else _numbered(sent[-1])

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


# --- CONFIG


@case("C17", bench_time_s=7.2)
def test_it_does_without_config(bench: ClientBench) -> None:
    server = bench.server
    server.answer("CONFIG")
    begin(bench)
    opened = server.expect_session(CONNECT_WITHIN_S)
    own = bench.client.own
    if own is not None:
        server.wait(lambda: own.state is ClientState.OPEN, CONFIG_WITHIN_S)
        assert own.state is ClientState.OPEN, f"the client is stuck without CONFIG: {own.state.value}"
        own.drive(200)
    require_session(bench, max(0.0, (opened.at_ns - bench.bench.now_ns) / NS_PER_S + CONFIG_WITHIN_S), "no CONFIG came")
    asked = [heard.at_ns for heard in server.heard("CONFIG")]
    server.run(WORKING_PERIOD_S)
    again = len(server.heard("CONFIG")) - len(asked)
    assert not again, f"after {CONFIG_WITHIN_S:g} s the client still asks for CONFIG"


@case("C18", bench_time_s=2.2)
def test_a_short_config_is_used(bench: ClientBench) -> None:
    server = bench.server
    server.answer("CONFIG", encode_packet(dataclasses.replace(CONFIG, fields=_FIELDS_TO_WATCHDOG)))
    connect(bench)
    asked = len(server.heard("CONFIG"))
    require_session(bench, WORKING_PERIOD_S, "CONFIG was short")
    assert len(server.heard("CONFIG")) == asked, "the client asks again for a CONFIG it has"
    config = own_client(bench).config
    assert config is not None, "the short CONFIG was not used"
    used = (config.serial, config.trans_vel_top_mm_s, config.name, config.low_battery_dv, config.watchdog_ms)
    sent = (CONFIG.serial, CONFIG.trans_vel_top_mm_s, CONFIG.name, CONFIG.low_battery_dv, CONFIG.watchdog_ms)
    assert used == sent, f"the short CONFIG was misread: {used} for {sent}"
    assert (config.stall_pwm, config.trans_ki) == (0, 0), "figures were read that the short CONFIG does not have"


_FIELDS_TO_WATCHDOG = 19
"""How many fields a CONFIG packet has up to and including the watchdog (AriaCoda ArRobotConfigPacketReader.cpp)."""


# --- the end of a session that the client did not want


@case("C19", bench_time_s=23.8)
def test_a_dead_robot_is_noticed(bench: ClientBench) -> None:
    """It must not take a robot for dead, either, whose SIPs come all the time."""
    server = bench.server
    connect(bench)
    require_session(bench, LOSS_WITHIN_S + 0.5, "SIPs came all the time")
    silent_since_ns = server.last_sip_ns
    server.stream = lambda _tick: b""
    own = bench.client.own
    if own is not None:
        if not server.wait(lambda: bool(own.failure), LOSS_WITHIN_S + 0.5):
            raise Violation(f"the client does not report within {LOSS_WITHIN_S:g} s that no SIP came")
        elapsed_s = (bench.bench.now_ns - silent_since_ns) / NS_PER_S
        doubt_s = server.uncertainty_s(silent_since_ns)
        at_most(elapsed_s, LOSS_WITHIN_S, unit="s", what="loss declared after the last SIP by", uncertainty=doubt_s)
    server.run(max(0.0, LOSS_WITHIN_S - (bench.bench.now_ns - silent_since_ns) / NS_PER_S))
    require_lost(bench, f"no SIP came for {LOSS_WITHIN_S:g} s")


@case("C20", bench_time_s=4.3)
@pytest.mark.parametrize("configured", [True, False], ids=["configured", "waiting-for-config"])
def test_a_controller_reset_ends_the_session(bench: ClientBench, configured: bool) -> None:
    server = bench.server
    if configured:
        connect(bench)
    else:
        server.answer("CONFIG")
        begin(bench)
        server.expect_session(CONNECT_WITHIN_S)
    server.run(0.5)
    assert server.in_session, "the client closed its session although nothing had happened yet"
    server.end_session()
    server.write(encode_packet(ControllerReset()))
    server.run(0.5)
    require_lost(bench, "the controller was reset")


# --- what the client makes of it


_WRAPS: dict[str, tuple[str, list[int]]] = {
    "x at 32768": ("x_raw", [32766, 32767, 0, 1]),
    "x at 65536": ("x_raw", [65534, 65535, 0, 1]),
    "y at 32768": ("y_raw", [32766, 32767, 0, 1]),
    "heading": ("th_raw", [2046, 2047, -2048, -2047]),
}


@case("C21", bench_time_s=1.9)
@pytest.mark.parametrize("counter", list(_WRAPS))
@pytest.mark.parametrize("way", ["up", "down"])
def test_the_pose_does_not_jump(bench: ClientBench, counter: str, way: str) -> None:
    connect(bench)
    field, values = _WRAPS[counter]
    ordered = values if way == "up" else values[::-1]
    poses = [_pose_units(bench, _sip_with(field, value)) for value in ordered]
    steps = [math.dist(before, after) for before, after in pairwise(poses)]
    worst = max(steps, key=lambda step: abs(step - 1))
    near(worst, 1, 0.05, unit="units", what=f"step of the pose where {counter} wraps")


def _sip_with(field: str, value: int) -> Sip:
    match field:
        case "x_raw":
            return dataclasses.replace(STANDING, x_raw=value)
        case "y_raw":
            return dataclasses.replace(STANDING, y_raw=value)
        case _:
            return dataclasses.replace(STANDING, th_raw=value)


def _pose_units(bench: ClientBench, sip: Sip) -> tuple[float, float, float]:
    """Let the client see counters, and return the pose it makes of them in their units."""
    understood(bench, encode_packet(sip))
    tracker = own_client(bench).pose
    assert tracker is not None, "the client has no pose"
    pose, unit_mm = tracker.pose, robot_parameters(IDENTIFICATION.subclass).distance_unit_mm
    return pose.x_mm / unit_mm, pose.y_mm / unit_mm, pose.heading_rad * 4096 / math.tau


# --- what the client sends


@case("C22", bench_time_s=6.3)
def test_the_session_is_kept_alive(bench: ClientBench) -> None:
    server = bench.server
    connect(bench)
    own = bench.client.own
    if own is not None:
        own.enable()
        own.drive(200)
    server.stream = lambda _tick: encode_packet(MOVING)
    start_ns = bench.bench.now_ns
    require_session(bench, 6.0, "its user was silent")
    worst_s = max(_silences_s(server.received, start_ns, bench.bench.now_ns))
    doubt_s = server.uncertainty_s(start_ns)
    at_most(worst_s, KEEPALIVE_S, unit="s", what="longest silence of the client", uncertainty=doubt_s)


def _silences_s(received: Sequence[Heard], start_ns: int, end_ns: int) -> list[float]:
    """Return the times between two frames, and before the first and behind the last, in seconds."""
    inside = [heard for heard in received if heard.at_ns > start_ns]
    begins = [start_ns, *(heard.at_ns for heard in inside)]
    ends = [*(heard.start_ns for heard in inside), end_ns]
    return [(end - begin) / NS_PER_S for begin, end in zip(begins, ends, strict=True)]


@case("C23", bench_time_s=0.3)
@pytest.mark.parametrize(
    ("number", "value", "wire"),
    [
        ("VEL", -200, "FAFB060B1BC800D31B"),
        ("VEL", 200, "FAFB060B3BC800D33B"),
        ("VEL", -32768, "FAFB060B1B00800B9B"),
        ("SETA", -300, "FAFB06051B2C01311C"),
        ("MOVE", -500, "FAFB06081BF401FC1C"),
        ("HEAD", -90, "FAFB060C1B5A00661B"),
        ("RVEL", -30, "FAFB06151B1E00331B"),
        ("SETRA", -100, "FAFB06171B64007B1B"),
    ],
)
def test_a_negative_argument_is_sign_and_magnitude(bench: ClientBench, number: str, value: int, wire: str) -> None:
    connect(bench)
    own_client(bench).send(CommandNumber[number], value)
    raw = bench.server.expect_command(number, 1.0).raw
    assert raw == bytes.fromhex(wire), (
        f"{number} {value} went out as {raw.hex(' ')}, not {bytes.fromhex(wire).hex(' ')}"
    )


@case("C24", bench_time_s=0.3)
@pytest.mark.parametrize(
    ("left", "right", "lefts", "rights"),
    [
        (100, 200, {5}, {10}),
        (300, -100, {15}, {-5}),
        (-100, 300, {-5}, {15}),
        (-100, -100, {-5}, {-5}),
        (0, 0, {0}, {0}),
        (117, -117, {5, 6}, {-5, -6}),
        (9999, -9999, {127}, {-127}),
        (2540, -2540, {127}, {-127}),
    ],
)
def test_vel2_is_packed_right(bench: ClientBench, left: int, right: int, lefts: set[int], rights: set[int]) -> None:
    connect(bench)
    own_client(bench).drive_wheels(left, right)
    heard = bench.server.expect_command("VEL2", 1.0)
    assert heard.command is not None
    assert isinstance(heard.command.argument, int), "VEL2 has no integer argument"
    high, low = byte_pair(heard.command.argument)
    assert high in lefts, f"left {left} mm/s went out as {high} in the high byte"
    assert low in rights, f"right {right} mm/s went out as {low} in the low byte"


@case("C25", bench_time_s=0.8)
@pytest.mark.parametrize("length", [0, 1, 4, 195, 196, 250, 300])
def test_packets_keep_to_their_limits(bench: ClientBench, length: int) -> None:
    """A count of 200 holds a string of 195 bytes. A longer one may be refused or divided, but not sent."""
    connect(bench)
    text = bytes(1 + index % 250 for index in range(length))
    try:
        own_client(bench).send(CommandNumber.SAY, text)
    except LocalProtocolError:
        assert length > MAX_COUNT_STRICT - 5, f"the client refuses a string of {length} bytes"
    bench.server.run(0.5)
    longest = max(heard.raw[2] for heard in bench.server.received)
    at_most(longest, MAX_COUNT_STRICT, unit="", what="largest count")
    strings = bench.server.heard("SAY")
    assert strings or length > MAX_COUNT_STRICT - 5, "the string was not sent"
    for heard in strings:
        body = heard.raw[3:-2]
        assert body[:2] == b"\x0f\x2b", f"a string of the type {body[1]:02X}"
        assert body[2] in (len(body) - 3, len(body) - 4), f"a length byte of {body[2]} before {len(body) - 3} bytes"
        assert text[: body[2]] == body[3 : 3 + body[2]] or length > body[2], "another string was sent"


@case("C26", bench_time_s=2.4)
def test_it_takes_leave(bench: ClientBench) -> None:
    server = bench.server
    connect(bench)
    own = bench.client.own
    if own is not None:
        own.enable()
        own.drive(200)
    server.run(1.0)
    mark = server.mark()
    bench.client.disconnect()
    server.expect_command("CLOSE", LEAVE_WITHIN_S, mark=mark)
    leave = server.heard(mark=mark)
    halts = [heard for heard in leave[: [heard.name for heard in leave].index("CLOSE")] if _halts(heard)]
    assert halts, "CLOSE was sent to a robot that drives: neither its motors nor its speed were set to 0 before"
    server.expect_silence(1.0, why="the client has taken its leave")
    if own is None:
        gone = server.wait(lambda: not server.port.line_is_up, LEAVE_WITHIN_S)
        assert gone, f"the client holds its port for more than {LEAVE_WITHIN_S:g} s after CLOSE"
    else:
        assert own.state is ClientState.CLOSED, f"the client does not know that it is disconnected: {own.state.value}"


def _halts(heard: Heard) -> bool:
    """Say whether a command makes the robot stop."""
    zero = heard.command is not None and heard.command.argument in (0, None)
    return heard.name in ("STOP", "E_STOP") or (heard.name in ("ENABLE", "VEL", "VEL2") and zero)


@case("C27", bench_time_s=8.1)
def test_the_rate_of_the_line_is_found(bench: ClientBench) -> None:
    server = bench.server
    server.port.baud = 38_400
    if isinstance(bench, VirtualCase):
        bench.client_with(ClientOptions(bauds=(9_600, 19_200, 38_400, 57_600, 115_200)))
    begin(bench)
    server.expect_session(3 * CONNECT_WITHIN_S)
    require_session(bench, WORKING_PERIOD_S, "the rate of the line had been found")
    own = bench.client.own
    assert own is None or own.sips, "no SIP was understood at the new rate"


# --- packets that were read by others before


@case("C28", bench_time_s=0.7)
def test_the_packet_of_a_real_robot_is_read(bench: ClientBench) -> None:
    connect(bench)
    reading = understood(bench, REAL)
    near(reading.battery_v, 14.4, 0.05, unit="V", what="battery")
    assert (reading.front_bumpers, reading.rear_bumpers) == (0, 0), "a bumper alarm on a robot without bumpers"
    alarms = (reading.left_stall, reading.right_stall, reading.moving)
    assert not any(alarms), f"(left stall, right stall, moving) is {alarms} on a robot at rest"
    assert sorted(reading.sonars_mm) == [4, 7], f"readings of the sonars {sorted(reading.sonars_mm)} instead of 4 and 7"
    for number in (4, 7):
        near(reading.sonars_mm[number], 8576, 1, unit="mm", what=f"range of sonar {number}")


@case("C29", bench_time_s=0.7)
def test_a_moving_sip_is_read(bench: ClientBench) -> None:
    connect(bench)
    reading = understood(bench, GOLDEN)
    own = own_client(bench)
    tracker, sip = own.pose, own.sips[-1]
    assert tracker is not None, "the client has no pose"
    pose = tracker.pose
    near(pose.x_mm, 999.6, 0.5, unit="mm", what="x")
    near(pose.y_mm, -8.4, 0.5, unit="mm", what="y")
    near(pose.heading_deg, 90, 0.5, unit="deg", what="heading")
    near(reading.left_mm_s, 200, 0.5, unit="mm/s", what="speed of the left wheel")
    near(reading.right_mm_s, 300, 0.5, unit="mm/s", what="speed of the right wheel")
    near(reading.battery_v, 12.8, 0.05, unit="V", what="battery")
    near(reading.heading_error_rad, 0, 0.001, unit="rad", what="heading asked for less heading")
    near(reading.analog_v, 2.51, 0.005, unit="V", what="analog input")
    near(reading.sonars_mm.get(0, math.inf), 268, 0.5, unit="mm", what="range of sonar 0")
    near(reading.sonars_mm.get(5, math.inf), 1000, 0.5, unit="mm", what="range of sonar 5")
    seen = {
        "moving": (reading.moving, True),
        "left stall": (reading.left_stall, True),
        "right stall": (reading.right_stall, False),
        "front bumper bits": (sip.front_bumpers, 0b00001),
        "rear bumper bits": (sip.rear_bumpers, 0),
        "motors": (reading.motors_enabled, True),
        "sonar": (reading.sonar_enabled, True),
        "compass": (reading.compass_deg, 90),
        "sonars": (sorted(reading.sonars_mm), [0, 5]),
        "analog port": (reading.analog_port, 5),
        "gripper": (reading.gripper_state, 0),
        "digital inputs": (reading.digin, 0xFF),
        "digital outputs": (reading.digout, 0x0F),
    }
    wrong = [f"{name}: {got} instead of {meant}" for name, (got, meant) in seen.items() if got != meant]
    if wrong:
        raise Violation(f"{len(wrong)} fields were misread", wrong)


@case("C30", bench_time_s=1.5)
def test_the_stalled_wheel_is_told(bench: ClientBench) -> None:
    connect(bench)
    for rear, front in ((1, 0), (0, 1), (0, 0)):
        sip = dataclasses.replace(MOVING, stall_rear=rear, stall_front=front)
        reading = understood(bench, encode_packet(sip))
        got, meant = (reading.left_stall, reading.right_stall), (bool(rear), bool(front))
        assert got == meant, f"byte 15 is {rear:02X}, byte 16 {front:02X}: (left, right) stall {got} instead of {meant}"
