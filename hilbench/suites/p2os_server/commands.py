"""Commands as they really come: damaged, ten at once, strings with and without their NUL."""

from __future__ import annotations

import statistics

from hilbench.check import at_least, case, near
from hilbench.suites._requirements import (
    RAMP_MM_S2,
    SPEED_MM_S,
    require_slope,
    require_speeds,
    require_standing,
    require_turn_rate,
)
from hilbench.suites._session import Session
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import Command, CommandNumber, encode_command, encode_frame

_C = CommandNumber


@case("S49", bench_time_s=2.4)
def test_a_command_with_a_wrong_checksum_is_ignored(peer: Peer) -> None:
    """Wrong by a bit in each byte, and by the bytes' order. The right one is obeyed in the end. Floor: 0.3 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=RAMP_MM_S2, down=RAMP_MM_S2)
    good = encode_frame(bytes.fromhex("0B3B6400"))
    high, low = good[-2:]
    for wrong in ((high, low ^ 0x01), (high ^ 0x01, low), (low, high)):
        session.write(good[:-2] + bytes(wrong))
        require_standing(session.watch(0.35), session, "a VEL with a wrong checksum was obeyed")
    session.write(good)
    session.watch_alive(0.5)
    require_speeds(session, 100, 100)
    session.leave()


@case("S50", bench_time_s=2.2)
def test_ten_commands_at_once_are_obeyed_in_order(peer: Peer) -> None:
    """Later commands undo earlier ones, so that what counts is the order; the last one is seen too. Floor: 0.6 m."""
    session = Session(peer)
    before = session.next()
    burst = [(_C.SONAR, 1), (_C.SETA, 200), (_C.ENABLE, 1), (_C.VEL, 400), (_C.RVEL, -40)]
    burst += [(_C.VEL, -300), (_C.RVEL, 60), (_C.VEL, 200), (_C.RVEL, 20), (_C.SONAR, 0)]
    session.write(b"".join(encode_command(Command(number, argument)) for number, argument in burst))
    ramp = session.watch_alive(1.4)
    seen = session.watch_alive(0.5)
    last = seen[-1].sip
    assert last.motors_enabled, "ENABLE 1 was not obeyed"
    assert not last.flags & 2, "SONAR 0, the last of the ten, was not obeyed"
    middle = statistics.median(s.speed_mm_s for s in seen)
    near(middle, 200, SPEED_MM_S, unit="mm/s", what="speed by the last of three VELs")
    require_turn_rate(seen, 20, session)
    require_slope([before, *ramp], 0, 200, 200, session)
    session.send(_C.SONAR, 1)
    session.leave()


@case("S51", bench_time_s=5.1)
def test_strings_with_and_without_nul_are_accepted(peer: Peer) -> None:
    """What is accepted feeds the watchdog, and the command behind it in one write is obeyed. Floor: 0.6 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=RAMP_MM_S2, down=RAMP_MM_S2)
    session.send(_C.VEL, 100)
    seen = session.watch(1.2)
    switch_off = encode_command(Command(_C.SONAR, 0))
    for text in ("FAFB090F2B04010602691947", "FAFB0A0F2B040106026900822E"):
        session.write(bytes.fromhex(text))
        seen += session.watch(1.6)
    session.write(bytes.fromhex("FAFB0A0F2B040106026900822E") + switch_off)
    session.watch(0.3)
    slowest = min(s.speed_mm_s for s in seen if s.after_s(seen[0].start_ns) > 0.8)
    at_least(slowest, 100 - 2 * SPEED_MM_S, unit="mm/s", what="slowest while only SAY was sent")
    assert not session.next().sip.flags & 2, "the command after SAY in the same write was not obeyed"
    session.send(_C.SONAR, 1)
    session.leave()
