"""What the client sends: arguments, lengths, silence, leave, and the rate of the line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import dropwhile

import pytest

from hilbench.check import at_most, case
from hilbench.clock import NS_PER_S
from hilbench.suites._client import (
    CONNECT_WITHIN_S,
    WORKING_PERIOD_S,
    ClientBench,
    begin,
    byte_pair,
    connect,
    own_client,
    require_session,
)
from hilbench.systems.pioneer.cases import VirtualCase
from hilbench.systems.pioneer.scripted import Heard
from hilbench.systems.pioneer.scripted_packets import MOVING
from protocols.p2os import (
    MAX_COUNT_STRICT,
    ClientOptions,
    ClientState,
    CommandNumber,
    LocalProtocolError,
    encode_packet,
)

KEEPALIVE_S = 1.0
"""How long a client may be silent in a session; clause C22 has it."""

LEAVE_WITHIN_S = 3.0
"""How long a client may take from its user's wish to CLOSE. No source has a limit; ARIA takes 0.1 s."""


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


IN_A_ROW = (
    (CommandNumber.ENABLE, 1, "FAFB06043B0100053B"),
    (CommandNumber.VEL, 200, "FAFB060B3BC800D33B"),
    (CommandNumber.VEL, -200, "FAFB060B1BC800D31B"),
    (CommandNumber.VEL, 0, "FAFB060B3B00000B3B"),
    (CommandNumber.RVEL, 30, "FAFB06153B1E00333B"),
    (CommandNumber.RVEL, -30, "FAFB06151B1E00331B"),
    (CommandNumber.SETA, 300, "FAFB06053B2C01313C"),
    (CommandNumber.SETA, -300, "FAFB06051B2C01311C"),
    (CommandNumber.SETRA, 100, "FAFB06173B64007B3B"),
    (CommandNumber.SETRA, -100, "FAFB06171B64007B1B"),
    (CommandNumber.HEAD, 90, "FAFB060C3B5A00663B"),
    (CommandNumber.HEAD, -90, "FAFB060C1B5A00661B"),
    (CommandNumber.MOVE, 1000, "FAFB06083BE803F03E"),
    (CommandNumber.MOVE, -500, "FAFB06081BF401FC1C"),
    (CommandNumber.CONFIG, 1, "FAFB06123B0100133B"),
    (CommandNumber.CONFIG, 2, "FAFB06123B0200143B"),
    (CommandNumber.ENABLE, 0, "FAFB06043B0000043B"),
)
"""Commands with other arguments than those before them, and their packets."""

SAID = (bytes.fromhex("01060269"), bytes.fromhex("024003710544"))

SAID_AGAIN = ("VEL", "RVEL", "HEAD")
"""What a client may say again: ARIA does every 500 ms, and HEAD in every cycle until the robot is there."""

OBEYED_S = 0.35
"""How soon a client sends what it is told. A choice: three of ARIA's cycles of 100 ms."""


@case("C33", bench_time_s=2.4)
def test_commands_in_a_row_are_each_its_own(bench: ClientBench) -> None:
    """A string may end with a NUL that does not count."""
    connect(bench)
    before: dict[str, bytes] = {}
    for number, value, wire in IN_A_ROW:
        mark = bench.server.mark()
        own_client(bench).send(number, value)
        _expect_new(bench, number.name, mark, before)
        bench.server.run(0.1)
        raws = [heard.raw.hex().upper() for heard in _new(bench, number.name, mark, before)]
        if number.name in SAID_AGAIN:
            raws = list(dict.fromkeys(raws))
        assert raws == [wire], f"{number.name} {value} went out as {', '.join(raws)}, not {wire}"
        before[number.name] = bytes.fromhex(wire)
    for text in SAID:
        mark = bench.server.mark()
        own_client(bench).send(CommandNumber.SAY, text)
        body = bench.server.expect_command("SAY", OBEYED_S, mark=mark).raw[3:-2]
        wanted = bytes((CommandNumber.SAY, 0x2B, len(text))) + text
        assert body in (wanted, wanted + b"\0"), f"SAY went out as {body.hex(' ')}, not {wanted.hex(' ')}"
        bench.server.run(0.1)
        times = len(bench.server.heard("SAY", mark=mark))
        assert times == 1, f"SAY went out {times} times, required once"
    for left_mm_s, right_mm_s, bytes_of in ((300, -100, (15, -5)), (-100, 300, (-5, 15))):
        mark = bench.server.mark()
        own_client(bench).drive_wheels(left_mm_s, right_mm_s)
        heard = _expect_new(bench, "VEL2", mark, before)
        before["VEL2"] = heard.raw
        argument = None if heard.command is None else heard.command.argument
        assert isinstance(argument, int), "VEL2 has no integer argument"
        assert byte_pair(argument) == bytes_of, f"{left_mm_s} and {right_mm_s} mm/s went out as {byte_pair(argument)}"


def _expect_new(bench: ClientBench, name: str, mark: int, before: Mapping[str, bytes]) -> Heard:
    return bench.server.expect_command(name, OBEYED_S, mark=mark, where=lambda heard: heard.raw != before.get(name))


def _new(bench: ClientBench, name: str, mark: int, before: Mapping[str, bytes]) -> Sequence[Heard]:
    """Return the frames of a command from the first on that is another one than before."""
    heard = bench.server.heard(name, mark=mark)
    return list(dropwhile(lambda one: one.raw == before.get(name), heard))


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
    assert halts, "CLOSE was sent to a moving robot, without stopping it before"
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
