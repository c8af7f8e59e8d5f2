"""What only a world, a wire or another line can show."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hilbench.check import Inconclusive, NotApplicable, Violation, case, near, within
from hilbench.suites._requirements import require_fresh, require_moving
from hilbench.suites._session import SIP_WITHIN_S, Session
from hilbench.systems.pioneer.peer import Peer
from hilbench.systems.pioneer.robot import sonar_poses
from protocols.p2os import CommandNumber, SerAuxPacket, Sip
from worlds.vehicles.pioneer_2dx import DEFAULTS, Pioneer2dxBody
from worlds.world import World

if TYPE_CHECKING:
    from hilbench.systems.pioneer.cases import AttachedCase, VirtualCase

_C = CommandNumber


@case("S54", bench_time_s=1.2, scene="wall", needs=("truth",))
def test_sonar_ranges_at_a_wall(peer: Peer, world: World) -> None:
    """Held against what a disc hears at its place in this world, and the two that face the wall against the ruler."""
    session = Session(peer)
    seen = session.watch(1.0)
    crowded = max(len(s.sip.sonars) for s in seen)
    assert crowded <= 16, f"{crowded} sonar readings in a SIP"
    heard: dict[int, int] = {reading.number: reading.range_raw for s in seen for reading in s.sip.sonars}
    discs = sonar_poses(session.robot.subclass)
    body = Pioneer2dxBody(world, sonar_poses=discs)
    for number, raw in sorted(heard.items()):
        assert number < len(discs), f"there is no disc {number}"
        echo_m = body.sonar_range_m(number)
        if echo_m is not None:
            true_mm = echo_m * 1000
            near(raw, true_mm / session.robot.range_unit_mm, 1, unit="units", what=f"range of disc {number}")
    for number in (3, 4):
        assert number in heard, f"disc {number}, which faces the wall, was not reported within 1 s"
        away_mm = WALL_MM - world.pose().position_m[0] * 1000 - discs[number][0] * 1000
        range_mm = heard[number] * session.robot.range_unit_mm
        within(range_mm, away_mm - 1, away_mm * CONE + 1, unit="mm", what=f"range of disc {number} to the wall")
    session.leave()


WALL_MM = 2000.0
"""Where the face of the wall stands in the scene of that name, from the middle of the scene."""

CONE = 1.0025
"""How much longer than the straight way a cone sampled by rays may measure; see `Pioneer2dxBody.sonar_range_m`."""


@case("S55", bench_time_s=2.6)
def test_a_client_that_vanishes_leaves_a_robot_at_rest(peer: Peer, bench: VirtualCase | AttachedCase) -> None:
    """Floor: 1 m ahead."""
    session = Session(peer, motors=True)
    session.send(_C.VEL, 200)
    session.watch_alive(1.0)
    require_moving(session.next(), session)
    bench.hang_up()
    peer.run(1.0)
    bench.reconnect()
    peer.forget()
    again = Session(peer)
    require_fresh(again.first, peer)
    again.leave()


@case("S56", bench_time_s=3.1, scene="wall", needs=("truth",))
def test_a_bumper_stops_the_robot(peer: Peer, world: World) -> None:
    """Drives at the wall, then is taken off it: a robot that only stood because it was blocked drives on."""
    session = Session(peer)
    world.place((WALL_MM - 250) / 1000 - DEFAULTS.length_front_m, 0.0, 0.0)
    session.motors_on()
    session.send(_C.BUMPSTALL, 3)
    session.send(_C.VEL, 200)
    approach = session.watch_alive(1.0)
    require_moving(approach[-1], session)
    stalled = [s for s in approach if s.sip.left_stall or s.sip.right_stall]
    if stalled:
        raise Violation("a stall is reported before anything is touched", [s.raw.hex(" ").upper() for s in stalled[:1]])
    session.watch_alive(0.8)
    seen = session.watch_alive(0.5)
    if not all(s.sip.left_stall and s.sip.right_stall for s in seen):
        raise Violation("bit 0 of bytes 15 and 16 is not set after the contact", peer.evidence())
    world.place(1.0, 0.0, 0.0)
    seen += session.watch_alive(0.5)
    if not all(s.at_rest for s in seen):
        raise Violation("the robot still drives after the contact", peer.evidence())
    session.leave()


@case("S57", bench_time_s=1.1)
def test_an_unused_baud_rate_is_given_up(peer: Peer) -> None:
    """Listens at the new rate, so that a server that never changed is told from one that went back."""
    session = Session(peer)
    session.next()
    old_baud, changed_ns = peer.port.baud, session.now_ns
    session.send(_C.HOSTBAUD, 2)
    peer.run(0.02)
    peer.port.baud = 38_400
    peer.forget()
    listened_ns = session.now_ns
    peer.run(0.4)
    heard_s = [one.after_s(listened_ns) for one in session.seen(0)]
    changed = any(after_s > session.uncertainty_s(changed_ns) for after_s in heard_s)
    peer.port.baud = old_baud
    peer.run(0.3)
    peer.forget()
    peer.expect(Sip, SIP_WITHIN_S, what=f"SIP at {old_baud} bit/s again")
    stays = bool(heard_s) or _stays(session)
    session.leave()
    if heard_s and not changed:
        raise Inconclusive("what came at 38400 bit/s may have been sent before, and read late")
    if not stays:
        raise Violation("HOSTBAUD 2 leads to another rate than 38400 bit/s", peer.evidence())
    if not changed and peer.uncertainty_s(changed_ns) > TRIAL_S / 2:
        raise Inconclusive(
            "nothing came at 38400 bit/s, and the bench was too late for the time that a server has there"
        )
    if not changed:
        raise NotApplicable("the server does not know HOSTBAUD: nothing came at 38400 bit/s, and all went on as before")


def _stays(session: Session) -> bool:
    """Say whether HOSTBAUD leaves the SIPs as they were, by listening at the rate of before."""
    session.send(_C.HOSTBAUD, 2)
    session.peer.run(0.05)
    mark = session.peer.mark()
    session.peer.run(0.35)
    stays = bool(session.peer.sips(mark))
    session.peer.run(TRIAL_S)
    return stays


TRIAL_S = 0.5
"""How long a rate is tried that nobody uses (Pioneer 2 H8 manual, HOSTBAUD)."""


@case("S58", bench_time_s=1.7)
def test_auxiliary_bytes_come_when_all_are_there(peer: Peer) -> None:
    """Twice in one string and once in two, of which the first must not be enough."""
    session = Session(peer)
    for text in ((b"AT",), (b"OK",), (b"X", b"Y")):
        session.send(_C.GETAUX, 0)
        session.send(_C.GETAUX, 2)
        mark = peer.mark()
        for part in text[:-1]:
            session.send(_C.TTY2, part)
            peer.run(0.3)
            early = peer.since(mark, SerAuxPacket)
            assert not early, "bytes were sent before two were there"
        session.send(_C.TTY2, text[-1])
        peer.run(0.4)
        answers = [packet.encode() for _, packet in peer.since(mark, SerAuxPacket)]
        wanted = b"\xb0" + b"".join(text)
        assert answers == [wanted], f"{[a.hex(' ') for a in answers]} came, required one {wanted.hex(' ')}"
    session.leave()
