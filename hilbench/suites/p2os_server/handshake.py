"""The handshake, and what comes before a session."""

from __future__ import annotations

import pytest

from hilbench.check import Untimely, Violation, case
from hilbench.suites._requirements import require_echo, require_sips_begin
from hilbench.suites._session import SIP_WITHIN_S
from hilbench.suites.p2os_server._syncs import SYNC0, SYNC1, SYNC2
from hilbench.systems.pioneer.peer import REPLY_WITHIN_S, Peer
from protocols.p2os import ROBOTS, CommandNumber, Identification, Sip, SyncEcho, SyncError

_C = CommandNumber


@case("S01", bench_time_s=0.1)
def test_sync0_is_echoed(peer: Peer) -> None:
    require_echo(peer, SYNC0)


@case("S02", bench_time_s=0.1)
def test_sync1_is_echoed(peer: Peer) -> None:
    peer.sync(0)
    require_echo(peer, SYNC1)


@case("S03", bench_time_s=0.1)
def test_sync2_is_answered_with_the_identification(peer: Peer) -> None:
    identification = peer.handshake()
    body = peer.received[-1].raw[3:-2]
    strings = body[1:].split(b"\0")
    assert len(strings) == 4, f"{len(strings) - 1} strings end with a NUL instead of three: {body.hex(' ')}"
    assert not strings[3], f"{len(strings[3])} bytes follow the third string: {body.hex(' ')}"
    assert identification.robot_class == "Pioneer", f"the class is {identification.robot_class!r}, not 'Pioneer'"
    known = identification.subclass.lower() in ROBOTS
    assert known, f"no client knows the subclass {identification.subclass!r}; known are {', '.join(ROBOTS)}"


@case("S04", bench_time_s=9.1)
def test_nothing_is_sent_unasked(peer: Peer) -> None:
    peer.expect_silence(3.0, why="nobody has spoken to the server", settled=True)
    peer.sync(0)
    peer.expect_silence(3.0, why="SYNC0 is answered, SYNC1 is not there yet", settled=True)
    peer.sync(1)
    peer.sync(2)
    peer.expect_silence(3.0, why="the handshake is over, OPEN is not there yet", settled=True)


@case("S05", bench_time_s=0.3)
def test_open_without_argument_starts_sips(peer: Peer) -> None:
    require_sips_begin(peer, bytes.fromhex("FAFB03010001"))


@case("S06", bench_time_s=0.3)
def test_open_with_argument_starts_sips(peer: Peer) -> None:
    require_sips_begin(peer, bytes.fromhex("FAFB06013B0100023B"))


@case("S07", bench_time_s=1.2)
@pytest.mark.parametrize("identified", [False, True], ids=["waiting", "identified"])
def test_commands_before_the_session_have_no_effect(peer: Peer, identified: bool) -> None:
    """Also looks into the session that follows: a robot that obeyed in silence has its motors on there, or moves.

    OPEN is too early only before the identification; behind it, the commands alone are.
    """
    if identified:
        peer.handshake()
    early = [(_C.ENABLE, 1), (_C.VEL, 200), (_C.OPEN, 1)]
    for number, argument in early[:2] if identified else early:
        peer.send(number, argument)
        peer.expect_silence(0.3, why="there is no session", settled=True)
    if not identified:
        peer.handshake()
    peer.send(_C.OPEN)
    require_untouched(peer.expect(Sip, SIP_WITHIN_S, what="first SIP"))


def require_untouched(first: Sip) -> None:
    assert not first.motors_enabled, "the motors are on: ENABLE was obeyed before the session"
    moves = first.moving or first.left_raw or first.right_raw
    assert not moves, "the robot moves: VEL was obeyed before the session"


@case("S08", bench_time_s=0.1)
def test_sync0_behind_a_modem_string_is_echoed(peer: Peer) -> None:
    """The five bytes are what ARIA writes for a radio modem when it opens a serial port (ArRobotConnector.cpp)."""
    require_echo(peer, SYNC0, bytes.fromhex("574D53320D") + SYNC0)


@case("S09", bench_time_s=0.3)
def test_sync0_with_a_wrong_checksum_is_ignored(peer: Peer) -> None:
    peer.write(bytes.fromhex("FAFB03000001"))
    peer.expect_silence(0.3, why="the checksum is wrong", settled=True)
    require_echo(peer, SYNC0)


@case("S10", bench_time_s=0.1)
def test_a_stray_byte_before_the_header_is_skipped(peer: Peer) -> None:
    require_echo(peer, SYNC0, bytes.fromhex("FA") + SYNC0)


@case("S11", bench_time_s=0.2)
def test_sync0_in_single_bytes_is_echoed(peer: Peer) -> None:
    for index in range(len(SYNC0) - 1):
        peer.write(SYNC0[index : index + 1])
        peer.run(0.02)
    require_echo(peer, SYNC0, SYNC0[-1:])


@case("S12", bench_time_s=0.8)
def test_a_repeated_sync_is_answered_again(peer: Peer) -> None:
    """SYNC0 with a pause and in one write: two echoes are due each time, not three. Then each SYNC of a handshake."""
    for writes in ((SYNC0, SYNC0), (SYNC0 + SYNC0,)):
        mark = peer.mark()
        for data in writes:
            peer.write(data)
            peer.run(REPLY_WITHIN_S / len(writes))
        peer.run(0.1)
        echoes = [got.raw for got in peer.received[mark:]]
        if echoes != [SYNC0, SYNC0]:
            kind = Untimely if len(echoes) < 2 else Violation  # too few may still be on their way
            raise kind(f"{len(echoes)} packets came where two echoes are due", peer.evidence(mark))
    for number in (0, 1, 1, 2, 2):
        peer.sync(number)
    peer.send(_C.OPEN)
    peer.expect(Sip, SIP_WITHIN_S, what="SIP after OPEN")


@case("S13", bench_time_s=0.1)
def test_sync0_restarts_the_handshake(peer: Peer) -> None:
    peer.sync(0)
    peer.sync(1)
    require_echo(peer, SYNC0)
    peer.sync(1)
    peer.sync(2)


@case("S14", bench_time_s=0.1)
def test_a_skipped_sync_is_answered(peer: Peer) -> None:
    peer.sync(0)
    mark = peer.mark()
    peer.write(SYNC2)
    peer.bench.run_until(lambda: peer.mark() > mark, SIP_WITHIN_S)
    answers = [got.packet for got in peer.received[mark:]]
    if not answers:
        raise Untimely("no answer to SYNC2 after SYNC0", peer.evidence(mark), spare_s=SIP_WITHIN_S - REPLY_WITHIN_S)
    identified = isinstance(answers[0], Identification | SyncError)
    if not identified and answers[0] != SyncEcho(number=1):
        raise Violation("the answer is no identification, no SYNC error and no echo of SYNC1", peer.evidence(mark))
    peer.handshake()
