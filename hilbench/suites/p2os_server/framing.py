"""Frames that are too short, too long, and as long as they may be."""

from __future__ import annotations

import pytest

from hilbench.check import at_least, case
from hilbench.suites._requirements import RAMP_MM_S2, SPEED_MM_S, require_echo
from hilbench.suites._session import Session
from hilbench.suites.p2os_server._syncs import SYNC0
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import Command, CommandNumber, ConfigPacket, encode_command, encode_frame

_C = CommandNumber


@case("S15", bench_time_s=0.2)
@pytest.mark.parametrize("count", [2, 1, 0])
def test_a_count_too_small_is_ignored(peer: Peer, count: int) -> None:
    """As many bytes follow as the count announces, all 0, so that a server that took them for a SYNC0 would answer."""
    mark = peer.mark()
    require_echo(peer, SYNC0, b"\xfa\xfb" + bytes((count,)) + bytes(count) + SYNC0)
    peer.run(0.2)
    assert len(peer.received) - mark == 1, f"{len(peer.received) - mark} answers, required one"


@case("S16", bench_time_s=1.2)
def test_a_packet_too_long_is_ignored(peer: Peer) -> None:
    """Two of them, sound but for their length: a SYNC0, and an OPEN 1 where OPEN is due; who takes them answers."""
    for body in (b"\0", bytes.fromhex("013B0100")):
        peer.write(encode_frame(body.ljust(TOO_LONG - 2, b"\x55"), max_count=TOO_LONG))
        peer.expect_silence(0.5, why=f"a count of {TOO_LONG} is more than a packet may have", settled=True)
        require_echo(peer, SYNC0)
        peer.sync(1)
        peer.sync(2)


TOO_LONG = 250


@case("S17", bench_time_s=3.6)
def test_the_longest_packet_is_taken(peer: Peer) -> None:
    """One alone keeps the watchdog fed, so a server that drops it stops the robot. Floor: 0.4 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=RAMP_MM_S2, down=RAMP_MM_S2)
    longest = encode_frame(bytes((_C.SAY, 0x2B, 195)) + b"\1" * 195)
    session.send(_C.VEL, 100)
    session.watch(1.2)
    session.write(longest)
    slowest = min(s.speed_mm_s for s in session.watch(1.4))
    at_least(slowest, 100 - 2 * SPEED_MM_S, unit="mm/s", what="slowest while only a packet of 200 was sent")
    for before in (b"", longest):
        session.write(before + encode_command(Command(_C.CONFIG, 1)))
        peer.expect(ConfigPacket, 1.0, what="CONFIG packet behind a packet of 200")
    session.leave()
