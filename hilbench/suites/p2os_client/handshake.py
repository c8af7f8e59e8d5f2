"""The handshake: steps, answers late, damaged and in pieces, an old session, an unknown robot."""

from __future__ import annotations

from itertools import pairwise

import pytest

from hilbench.check import Inconclusive, Untimely, at_least, case
from hilbench.clock import NS_PER_S
from hilbench.suites._client import (
    CONNECT_WITHIN_S,
    ECHO0,
    ECHO1,
    WORKING_PERIOD_S,
    ClientBench,
    begin,
    connect,
    damaged,
    expect_session,
    identification,
    own_client,
    require_end,
    require_session,
    seconds_between,
)
from hilbench.systems.pioneer.cases import VirtualCase
from hilbench.systems.pioneer.scripted import HANDSHAKE_NAMES, SIP_CYCLE_S, Pause
from hilbench.systems.pioneer.scripted_packets import IDENTIFICATION, MOVING, STANDING
from protocols.p2os import (
    ClientOptions,
    ClientState,
    Sip,
    SyncError,
    UnknownSubclass,
    encode_frame,
    encode_packet,
    robot_parameters,
)

GIVE_UP_WITHIN_S = 20.0
"""How long a client may try before it gives up. The clauses say "a set time"; ARIA takes 6.4 s, Player, which tries
five rates, some 14 s."""

ANSWER_AFTER_S, ANSWERED_S = 0.3, 0.25
"""How late the steps of the handshake are answered where the client is to wait, and how soon after a step its next one
shows that it did not. Player looks for the first answer after 0.4 s, and only once; the rest is for a late host."""


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
    assert after == "SYNC0", f"SYNC0 is expected after a SYNC error, but {after} came"


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
    if not server.sessions_opened:
        quiet = server.wait_quiet(3.0, GIVE_UP_WITHIN_S)
        if not quiet and not server.sessions_opened:  # it may take its time: no source says how soon it opens one
            text = f"the client does not know the robot and still talks after {GIVE_UP_WITHIN_S:g} s, without a session"
            raise Untimely(text, server.evidence(), spare_s=GIVE_UP_WITHIN_S / 2)
    if server.sessions_opened:
        require_session(bench, WORKING_PERIOD_S, "it had taken an unknown robot")
    own = bench.client.own
    assert own is None or own.failure or own.state is ClientState.OPEN, "an unknown robot was not reported"
    _require_told(bench)


def _require_told(bench: ClientBench) -> None:
    """Require that the client has asked who the robot is: what it was not told it cannot have dealt with."""
    if not bench.server.heard("SYNC2"):
        raise Inconclusive("the client never asked who the robot is", bench.server.evidence())


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
        assert "unknown" in own.failure, f"the failure is explained by '{own.failure}'"
        bench.server.expect_command("CLOSE", 0.1, mark=0)
    else:
        assert own.state is ClientState.OPEN, f"the client was to fall back; it {own.failure or own.state.value}"
        assert own.robot == robot_parameters("p2at"), "the parameters are not those of the fallback"


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
    _require_told(bench)
