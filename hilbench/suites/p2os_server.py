"""What a P2OS server must do: every conformance case that a robot, or what takes its place, can be asked.

The cases judge what the line says and ask for nothing that the clause does not; S54 and S56 also need a world that can
be looked at. A docstring tells the trick of a stimulus, and the floor that a robot needs which is driven by it; where
the case is not about contacts or echoes the wheels may be jacked up instead.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

import pytest

from hilbench.check import Inconclusive, NotApplicable, Violation, at_least, at_most, case, near, within
from hilbench.clock import NS_PER_S
from hilbench.peer import REPLY_WITHIN_S, Peer
from hilbench.pioneer import sonar_poses
from hilbench.suites._requirements import (
    SPEED_MM_S,
    STANDING_UNITS,
    require_echo,
    require_fifteen_bits,
    require_flow,
    require_fresh,
    require_heading,
    require_moving,
    require_plain_sip,
    require_rate,
    require_request,
    require_sips_begin,
    require_slope,
    require_speeds,
    require_standing,
    require_turn_rate,
)
from hilbench.suites._session import (
    CYCLE_S,
    SIP_WITHIN_S,
    Seen,
    Session,
    medians_mm_s,
    poses,
    turned_deg,
)
from protocols.p2os import (
    ROBOTS,
    Command,
    CommandNumber,
    ConfigPacket,
    EncoderPacket,
    Identification,
    IoPacket,
    Pose,
    SerAuxPacket,
    Sip,
    SyncEcho,
    SyncError,
    encode_command,
    encode_frame,
    pack_bytes,
)
from worlds.vehicles.pioneer_2dx import DEFAULTS, Pioneer2dxBody
from worlds.world import World

if TYPE_CHECKING:
    from hilbench.cases import AttachedCase, VirtualCase

_C = CommandNumber

SYNC0, SYNC1, SYNC2 = (bytes.fromhex(text) for text in ("FAFB03000000", "FAFB03010001", "FAFB03020002"))

STRAIGHT_DEG = 2.0
"""How much the heading may stray on a straight run of half a metre: two wheels never pull alike."""

MOVE = 0.01
"""Tolerance of MOVE, as a share; clause S30 has it."""

STOP_SEEN_S = 0.25
"""How much later than at the wheels a stop may show in a SIP: one cycle, the span a speed is averaged over, and the
servo's last millimetres."""

STEP_MM = 100.0
"""Clients of the Player family throw away a step between two SIPs that is longer (Player p2os driver, sip.cc)."""


# --- the handshake


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
    peer.expect_silence(3.0, why="nobody has spoken to the server")
    peer.sync(0)
    peer.expect_silence(3.0, why="SYNC0 is answered, SYNC1 is not there yet")
    peer.sync(1)
    peer.sync(2)
    peer.expect_silence(3.0, why="the handshake is over, OPEN is not there yet")


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
        peer.expect_silence(0.3, why="there is no session")
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
    peer.expect_silence(0.3, why="the checksum is wrong")
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
            raise Violation(f"{len(echoes)} packets came where two echoes are due", peer.evidence(mark))
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
        raise Violation("no answer to SYNC2 after SYNC0", peer.evidence(mark))
    identified = isinstance(answers[0], Identification | SyncError)
    if not identified and answers[0] != SyncEcho(number=1):
        raise Violation("the answer is no identification, no SYNC error and no echo of SYNC1", peer.evidence(mark))
    peer.handshake()


# --- framing


@case("S15", bench_time_s=0.2)
@pytest.mark.parametrize("count", [2, 1, 0])
def test_a_count_too_small_is_ignored(peer: Peer, count: int) -> None:
    """As many bytes follow as the count announces, all 0, so that a server that took them for a SYNC0 would answer."""
    mark = peer.mark()
    require_echo(peer, SYNC0, b"\xfa\xfb" + bytes((count,)) + bytes(count) + SYNC0)
    peer.run(0.2)
    assert len(peer.received) - mark == 1, f"{len(peer.received) - mark} answers where one is due"


@case("S16", bench_time_s=1.2)
def test_a_packet_too_long_is_ignored(peer: Peer) -> None:
    """Two of them, sound but for their length: a SYNC0, and an OPEN 1 where OPEN is due; who takes them answers."""
    for body in (b"\0", bytes.fromhex("013B0100")):
        peer.write(encode_frame(body.ljust(TOO_LONG - 2, b"\x55"), max_count=TOO_LONG))
        peer.expect_silence(0.5, why=f"a count of {TOO_LONG} is more than a packet may have")
        require_echo(peer, SYNC0)
        peer.sync(1)
        peer.sync(2)


TOO_LONG = 250


@case("S17", bench_time_s=3.6)
def test_the_longest_packet_is_taken(peer: Peer) -> None:
    """One alone keeps the watchdog fed, so a server that drops it stops the robot. Floor: 0.4 m ahead."""
    session = Session(peer, motors=True)
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


# --- the stream of SIPs


@case("S18", bench_time_s=10.3)
def test_sips_come_at_their_rate(peer: Peer) -> None:
    """Listens and says nothing. The robot stands, so the watchdog may run out."""
    session = Session(peer)
    mark, dropped = peer.mark(), len(peer.dropped)
    seen, doubts_s = [session.next()], []
    end_ns = session.now_ns + 10 * NS_PER_S
    while session.now_ns < end_ns:
        seen.append(session.next())
        doubts_s.append(session.uncertainty_s(seen[-2].start_ns))
    if len(peer.dropped) > dropped:
        raise Violation("bytes came that are no sound packet", peer.evidence(mark))
    for one in seen:
        require_plain_sip(one)
    require_rate([s.start_ns for s in seen], doubts_s, session)
    session.leave()


@case("S19", bench_time_s=0.2)
def test_a_session_begins_with_motors_off_and_sonar_on(peer: Peer) -> None:
    flags = Session(peer).first.sip.flags
    assert not flags & 1, f"flags {flags:04X}: the motors are on"
    assert flags & 2, f"flags {flags:04X}: the sonar is off"


@case("S20", bench_time_s=1.2)
def test_velocity_with_motors_off_moves_nothing(peer: Peer) -> None:
    session = Session(peer)
    session.send(_C.VEL, 200)
    require_standing(session.watch(1.0), session, "the motors are off")
    session.leave()


@case("S21", bench_time_s=0.4)
def test_enable_switches_the_motors_on(peer: Peer) -> None:
    session = Session(peer)
    arrived_ns = session.send(_C.ENABLE, 1)
    flags = [session.next_after(arrived_ns).sip.flags for _ in range(2)]
    assert flags[1] & 1, f"the motors are off in the second SIP after ENABLE 1 (flags {flags[1]:04X})"
    session.leave()


# --- velocities


@case("S22", bench_time_s=2.2)
def test_velocity_is_reached_along_the_ramp(peer: Peer) -> None:
    """Floor: 0.6 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=200, down=400)
    before = session.next()
    session.send(_C.VEL, 200)
    ramp = session.watch_alive(1.3)
    seen = require_speeds(session, 200, 200)
    require_slope([before, *ramp], 0, 200, 200, session)
    at_most(
        abs(turned_deg([before, *ramp, *seen], session.robot)),
        STRAIGHT_DEG,
        unit="deg",
        what="change of heading on a straight run",
    )
    session.leave()


@case("S23", bench_time_s=1.9)
def test_negative_velocity_drives_backwards(peer: Peer) -> None:
    """SETO first, so that X has to go below 0. Floor: 0.4 m behind."""
    session = Session(peer, motors=True)
    session.send(_C.SETO)
    first = session.next()
    session.write(bytes.fromhex("FAFB060B1BC800D31B"))
    ramp = session.watch_alive(1.0)
    seen = [first, *ramp, *require_speeds(session, -200, -200)]
    steps = [b.x_mm - a.x_mm for a, b in pairwise(poses(seen, session.robot))]
    if not sum(steps) < 0 or max(steps) > STANDING_UNITS * session.robot.distance_unit_mm:
        raise Violation("X does not decrease", peer.evidence())
    require_fifteen_bits(seen, peer)
    session.leave()


@case("S24", bench_time_s=2.9)
def test_rotation_velocity_turns_both_ways(peer: Peer) -> None:
    """Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=100)
    for rate in (30, -30):
        session.send(_C.RVEL, rate)
        session.watch_alive(0.8)
        seen = session.watch_alive(0.5)
        left, right = medians_mm_s(seen)
        assert (right - left) * rate > 0, f"RVEL {rate}: the left wheel goes {left:g}, the right one {right:g} mm/s"
        require_turn_rate(seen, rate, session)
    session.leave()


@case("S25", bench_time_s=1.9)
def test_translation_and_rotation_go_together(peer: Peer) -> None:
    """Floor: 0.5 m ahead and to the left."""
    session = Session(peer, motors=True)
    session.send(_C.VEL, 100)
    session.watch_alive(0.5)
    session.send(_C.RVEL, 20)
    session.watch_alive(0.6)
    seen = session.watch_alive(0.5)
    middle = statistics.median(s.speed_mm_s for s in seen)
    near(middle, 100, SPEED_MM_S, unit="mm/s", what="mean of the wheel speeds")
    require_turn_rate(seen, 20, session)
    session.leave()


@case("S26", bench_time_s=1.8)
def test_each_wheel_takes_its_speed(peer: Peer) -> None:
    """Floor: 0.5 m ahead and to the left."""
    session = Session(peer, motors=True)
    session.write(bytes.fromhex("FAFB06203B0A052A40"))
    session.watch_alive(1.0)
    require_speeds(session, 5 * session.robot.vel2_unit_mm_s, 10 * session.robot.vel2_unit_mm_s)
    session.leave()


@case("S27", bench_time_s=1.6)
@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(bytes.fromhex("FAFB06201B0504251F"), id="aria"),
        pytest.param(bytes.fromhex("FAFB06203BFBFB1C36"), id="player"),
    ],
)
def test_negative_wheel_speeds_of_both_senders(peer: Peer, frame: bytes) -> None:
    """Floor: 0.2 m behind."""
    session = Session(peer, motors=True)
    session.write(frame)
    session.watch_alive(0.8)
    require_speeds(session, -5 * session.robot.vel2_unit_mm_s, -5 * session.robot.vel2_unit_mm_s)
    session.leave()


# --- positions


@case("S28", bench_time_s=5.7)
def test_heading_is_taken_and_held(peer: Peer) -> None:
    """Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=100)
    session.send(_C.SETO)
    for heading_deg in (90, -90):
        session.send(_C.HEAD, heading_deg)
        require_heading(session, heading_deg)
    session.leave()


@case("S29", bench_time_s=3.1)
def test_heading_changes_are_relative(peer: Peer) -> None:
    """DCHEAD is sent in the middle of a turn, where the setpoint and the heading differ. Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=100)
    session.send(_C.SETO)
    session.send(_C.DHEAD, -45)
    require_heading(session, -45)
    session.send(_C.DHEAD, -45)
    session.watch_alive(0.3)
    session.send(_C.DCHEAD, 30)
    require_heading(session, -60)
    session.leave()


@case("S30", bench_time_s=4.4)
def test_move_goes_its_way(peer: Peer) -> None:
    """Floor: 1.1 m ahead."""
    session = Session(peer, motors=True)
    require_move(session)
    session.send(_C.SETO)
    first = session.next()
    session.send(_C.MOVE, 1000)
    session.watch_alive(0.5)
    last = session.wait_at_rest(12.0)
    gone_mm = poses([first, last], session.robot)[-1].x_mm - poses([first], session.robot)[0].x_mm
    near(gone_mm, 1000, 1000 * MOVE, unit="mm", what="way of MOVE 1000 along X")
    session.leave()


def require_move(session: Session) -> None:
    """End the case for a robot whose firmware has no MOVE by ARIA's parameters (HasMoveCommand)."""
    if not session.robot.has_move:
        session.leave()
        raise NotApplicable(f"a {session.robot.subclass} has no MOVE")


@case("S31", bench_time_s=11.0)
def test_the_speed_limit_holds(peer: Peer) -> None:
    """Floor: 1.1 m ahead."""
    session = Session(peer, motors=True)
    require_move(session)
    session.send(_C.SETV, 100)
    session.send(_C.MOVE, 1000)
    mark = peer.mark()
    session.watch_alive(0.5)
    session.wait_at_rest(15.0)
    seen = session.seen(mark)
    fastest = max(max(abs(s.left_mm_s), abs(s.right_mm_s)) for s in seen)
    at_most(fastest, 100 + SPEED_MM_S, unit="mm/s", what="fastest wheel speed under SETV 100")
    at_least(fastest, 50, unit="mm/s", what="fastest wheel speed, to have something to judge")
    session.leave()


@case("S32", bench_time_s=2.5)
def test_acceleration_can_be_set(peer: Peer) -> None:
    """Floor: 0.7 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=1000, down=1000)
    for start, end in ((0, 500), (500, 0)):
        before = session.next()
        session.send(_C.VEL, end)
        require_slope([before, *session.watch_alive(1.0)], start, end, (end - start) * 2, session)
    session.leave()


@case("S33", bench_time_s=2.5)
@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(bytes.fromhex("FAFB03070007"), id="bare"),
        pytest.param(bytes.fromhex("FAFB04073B073B"), id="type-only"),
    ],
)
def test_origin_is_set(peer: Peer, frame: bytes) -> None:
    """Drives an arc first, so that all three are away from 0. Floor: 0.4 m ahead and to the left."""
    session = Session(peer, motors=True)
    session.send(_C.VEL, 200)
    session.send(_C.RVEL, 50)
    session.watch_alive(1.0)
    session.send(_C.STOP)
    session.wait_at_rest(5.0)
    before = session.next()
    if 0 in (before.sip.x_raw, before.sip.y_raw, before.sip.th_raw):
        raise Inconclusive("a coordinate is 0 before SETO, although the robot drove an arc", peer.evidence())
    after = session.next_after(session.write(frame)).sip
    off = [signed15(after.x_raw), signed15(after.y_raw), after.th_raw]
    if max(map(abs, off)) > STANDING_UNITS:
        raise Violation(f"X, Y, Th are {off} in the SIP after SETO", peer.evidence())
    session.leave()


def signed15(raw: int) -> int:
    """A coordinate as a signed number of 15 bits, and of 16 where the server has so many."""
    return raw - 0x10000 if raw >= 0xC000 else raw - 0x8000 if raw >= 0x4000 else raw


# --- stopping


@case("S34", bench_time_s=3.6)
def test_stop_brakes_and_keeps_the_motors_on(peer: Peer) -> None:
    """Floor: 0.7 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=400, down=200)
    session.send(_C.VEL, 300)
    session.watch_alive(1.2)
    before = session.next()
    at_least(before.speed_mm_s, 200, unit="mm/s", what="speed before STOP, to have something to judge")
    session.send(_C.STOP)
    ramp = session.watch_alive(1.5 + STOP_SEEN_S)
    require_slope([before, *ramp], before.speed_mm_s, 0, -200, session)
    at_rest = session.wait_at_rest(2.0)
    if not at_rest.sip.motors_enabled:
        raise Violation("STOP has switched the motors off", peer.evidence())
    session.leave()


def stop_time_s(session: Session, command: int) -> tuple[float, float]:
    """Drive at 400 mm/s, stop with ``command``; return after how long a SIP shows rest, and its uncertainty."""
    session.send(_C.VEL, 400)
    session.watch_alive(1.4)
    sent_ns = session.now_ns
    require_moving(session.next(), session)
    arrived_ns = session.send(command)
    while not (seen := session.next()).at_rest:
        if seen.after_s(arrived_ns) > 4.0:
            raise Violation(f"the robot does not stop within 4 s of command {command}", session.peer.evidence())
        session.send(_C.PULSE)
    return seen.after_s(arrived_ns), session.uncertainty_s(sent_ns)


@case("S35", bench_time_s=5.7)
def test_emergency_stop_is_harder_than_stop(peer: Peer) -> None:
    """With a slow deceleration set, which must not apply. Floor: 1.5 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=400, down=200)
    stop_s, doubt_s = stop_time_s(session, _C.STOP)
    emergency_s, more_doubt_s = stop_time_s(session, _C.E_STOP)
    at_least(
        stop_s / emergency_s,
        SEVERAL,
        unit="times",
        what="time of STOP against that of E_STOP",
        uncertainty=(doubt_s + more_doubt_s * stop_s / emergency_s) / emergency_s,
    )
    session.leave()


SEVERAL = 3.0
"""What "several times faster" is taken for."""


# --- the watchdog


def drive_into_silence(session: Session) -> tuple[int, list[Seen]]:
    """Send VEL 200 and nothing more for 3.2 s; return when VEL had arrived, and the SIPs."""
    session.set_ramps(up=300, down=300)
    arrived_ns = session.send(_C.VEL, 200)
    return arrived_ns, session.watch(3.2)


@case("S36", bench_time_s=3.5)
def test_silence_stops_the_robot(peer: Peer) -> None:
    """Floor: 0.6 m ahead, and 1 m more for a robot that fails."""
    session = Session(peer, motors=True)
    since_ns = session.now_ns
    arrived_ns, seen = drive_into_silence(session)
    doubt_s = session.uncertainty_s(since_ns)
    require_flow([s.start_ns for s in seen], session)
    widest_s = max(b.after_s(a.start_ns) for a, b in pairwise(seen))
    at_most(widest_s, 1.5 * CYCLE_S, unit="s", what="longest pause between SIPs", uncertainty=doubt_s)
    if all(s.at_rest for s in seen):
        raise Inconclusive("the robot never moved, so nothing can be seen of its watchdog", peer.evidence())
    if not seen[-1].at_rest:
        raise Violation("the robot still moves after 3.2 s of silence", peer.evidence())
    last_moving = max(i for i, s in enumerate(seen) if not s.at_rest)
    at_most(
        seen[last_moving + 1].after_s(arrived_ns),
        2.0 + 200 / 300 + STOP_SEEN_S,
        unit="s",
        what="at rest after the last command",
        uncertainty=doubt_s,
    )
    session.leave()


@case("S37", bench_time_s=5.0)
def test_the_next_packet_revives_the_robot(peer: Peer) -> None:
    """Floor: 1 m ahead, and 1 m more for a robot that fails."""
    session = Session(peer, motors=True)
    _, seen = drive_into_silence(session)
    if not seen[-1].at_rest:
        raise Inconclusive("the robot has not stopped, so it cannot be revived; see S36", peer.evidence())
    session.send(_C.PULSE)
    session.watch_alive(1.0)
    require_speeds(session, 200, 200)
    session.leave()


@case("S38", bench_time_s=4.9)
def test_any_packet_feeds_the_watchdog(peer: Peer) -> None:
    """With ramps on which even a short stop would show in several SIPs. Floor: 1 m ahead."""
    session = Session(peer, motors=True)
    since_ns = session.now_ns
    session.set_ramps(up=200, down=1000)
    session.send(_C.VEL, 200)
    seen = session.watch(1.9)
    for silence_s in (1.9, 0.8):
        session.send(_C.SONAR, 1)
        seen += session.watch(silence_s)
    driving = [s for s in seen if s.after_s(since_ns) > 1.0 + STOP_SEEN_S]
    slowest = min(s.speed_mm_s for s in driving)
    if slowest < 200 - 2 * SPEED_MM_S and 1.9 + session.uncertainty_s(since_ns) >= 2.0:
        raise Inconclusive("the host was late: more than 2 s may have passed without a packet", peer.evidence())
    at_least(slowest, 200 - 2 * SPEED_MM_S, unit="mm/s", what="slowest while fed every 1.9 s")
    session.leave()


# --- the session


@case("S39", bench_time_s=0.9)
def test_pulse_has_no_answer(peer: Peer) -> None:
    session = Session(peer)
    mark = peer.mark()
    session.write(SYNC0)
    seen = session.watch(0.7)
    if any(got.raw[3] == SYNC0[3] for got in peer.received[mark:]):
        raise Violation("PULSE was echoed like a SYNC0", peer.evidence(mark))
    if len(seen) < 0.5 / CYCLE_S:
        raise Violation("PULSE has ended the stream of SIPs", peer.evidence(mark))
    session.leave()


@case("S40", bench_time_s=0.9)
def test_close_ends_the_session(peer: Peer) -> None:
    session = Session(peer)
    mark, sent_ns = peer.mark(), session.now_ns
    session.write(SYNC2)
    peer.run(0.7)
    last_ns = max((got.at_ns for got in peer.received[mark:]), default=sent_ns)
    at_most(
        (last_ns - sent_ns) / NS_PER_S,
        0.2,
        unit="s",
        what="end of the last packet after CLOSE",
        uncertainty=session.uncertainty_s(sent_ns),
    )
    require_echo(peer, SYNC0)


@case("S41", bench_time_s=2.3)
@pytest.mark.parametrize("argument", [1, None], ids=["argument", "bare"])
def test_a_new_session_begins_at_rest(peer: Peer, argument: int | None) -> None:
    """Comes back as soon as a robot can have braked with 300 mm/s², the default ramp. Floor: 1 m ahead."""
    session = Session(peer, motors=True)
    session.send(_C.VEL, 200)
    session.watch_alive(1.0)
    require_moving(session.next(), session)
    session.send(_C.CLOSE, argument)
    peer.run(200 / DEFAULT_RAMP_MM_S2)
    require_fresh(Session(peer).first, peer)


DEFAULT_RAMP_MM_S2 = 300
"""Deceleration of a Pioneer whose client has set none (AMRISim, EmulatePioneer.cc). CLOSE may brake harder."""


# --- packets on request


@case("S42", bench_time_s=1.2)
def test_configuration_is_sent_on_request(peer: Peer) -> None:
    session = Session(peer)
    for argument in (1, None):
        mark = peer.mark()
        session.send(_C.CONFIG, argument)
        peer.run(0.5)
        configs = [config for _, config in peer.since(mark, ConfigPacket)]
        assert len(configs) == 1, f"{len(configs)} CONFIG packets came where one is due"
        reached = configs[0].fields
        assert reached >= ConfigPacket.P2OS_FIELDS, (
            f"only {reached} fields, not {ConfigPacket.P2OS_FIELDS} up to TransKI"
        )
    session.leave()


@case("S43", bench_time_s=2.2)
def test_encoders_are_sent_on_request(peer: Peer) -> None:
    require_request(peer, _C.ENCODER, EncoderPacket)


@case("S44", bench_time_s=2.2)
def test_inputs_and_outputs_are_sent_on_request(peer: Peer) -> None:
    require_request(peer, _C.IOREQUEST, IoPacket)


@case("S45", bench_time_s=1.6)
def test_sonar_goes_off_and_on(peer: Peer) -> None:
    session = Session(peer)
    for argument in (0, 1):
        session.next_after(session.send(_C.SONAR, argument))
        seen = session.watch(0.6)
        if any(bool(s.sip.flags & 2) != bool(argument) for s in seen):
            raise Violation(f"flag bit 1 does not follow SONAR {argument}", peer.evidence())
        readings = sum(len(s.sip.sonars) for s in seen)
        if bool(readings) != bool(argument):
            raise Violation(f"{readings} sonar readings in 0.6 s after SONAR {argument}", peer.evidence())
    session.leave()


@case("S46", bench_time_s=1.3)
def test_polling_selects_the_discs(peer: Peer) -> None:
    """Looks at the first array only: the others keep their sequences (Pioneer 2/3 H8 manual, POLLING)."""
    session = Session(peer)
    session.next_after(session.send(_C.POLLING, bytes((1, 5))))
    seen = session.watch(1.0)
    discs = sorted({reading.number for s in seen for reading in s.sip.sonars if reading.number < 8})
    session.send(_C.POLLING, bytes(range(1, 9)))
    assert discs == [0, 4], f"the discs {discs} reported after POLLING 1 5, not 0 and 4"
    session.leave()


@case("S47", bench_time_s=0.4)
def test_digital_outputs_are_set(peer: Peer) -> None:
    session = Session(peer)
    before = session.first.sip.digout
    if before == 0x0F:
        session.next_after(session.send(_C.DIGOUT, pack_bytes(0xFF, 0xF0)))
    arrived_ns = session.write(bytes.fromhex("FAFB061E1BF1000F1B"))
    after = [session.next_after(arrived_ns).sip.digout for _ in range(2)][-1]
    session.send(_C.DIGOUT, pack_bytes(0xFF, before))
    assert after == 0x0F, f"the outputs are {after:02X} after DIGOUT with mask FF and value 0F"
    session.leave()


@case("S48", bench_time_s=1.2)
def test_commands_of_other_robots_are_ignored(peer: Peer) -> None:
    """The session is unaffected if the SIPs go on as they were, and the next command is obeyed."""
    session = Session(peer)
    before = session.next().sip
    mark = peer.mark()
    session.send(_C.BATTERYINFO, 1)
    session.send(200)
    session.send(_C.LOADWORLD, b"")
    session.send(_C.STEP)
    seen = session.watch(0.8)
    if len(seen) < 0.6 / CYCLE_S:
        raise Violation("the stream of SIPs has stopped", peer.evidence(mark))
    if any(s.sip.flags != before.flags or not s.at_rest for s in seen):
        raise Violation("flags or motion have changed", peer.evidence(mark))
    session.motors_on()
    session.leave()


# --- commands as they really come


@case("S49", bench_time_s=2.4)
def test_a_command_with_a_wrong_checksum_is_ignored(peer: Peer) -> None:
    """Wrong by a bit in each byte, and by the bytes' order. The right one is obeyed in the end. Floor: 0.3 m ahead."""
    session = Session(peer, motors=True)
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
    assert not session.next().sip.flags & 2, "the command behind SAY in the same write was not obeyed"
    session.send(_C.SONAR, 1)
    session.leave()


# --- counters that wrap


def drive_until(session: Session, mark: int, there: Callable[[Pose], bool], within_s: float) -> list[Seen]:
    """Keep the robot going until its pose, followed from the first SIP since ``mark``, is there; return the SIPs."""
    end_ns = session.now_ns + round(within_s * NS_PER_S)
    while session.now_ns < end_ns:
        session.watch_alive(0.5)
        seen = session.seen(mark)
        if session.peer.dropped:
            raise Inconclusive("bytes were lost, so a step may be two; S18 judges checksums", session.peer.evidence())
        if there(poses(seen, session.robot)[-1]):
            return seen
    raise Violation(f"the robot does not get there within {within_s:.0f} s", session.peer.evidence())


@case("S52", bench_time_s=50.3)
def test_position_wraps_without_a_jump(peer: Peer) -> None:
    """At 900 mm/s a step stays below the limit; a slower robot goes as fast as ARIA lets it.

    Floor: 41 m ahead, or 15 bits of the robot's units; or jack it up.
    """
    session = Session(peer, motors=True)
    speed_mm_s = min(900, session.robot.max_speed_mm_s)
    session.send(_C.SETO)
    session.next()
    mark = peer.mark()
    session.next()
    session.send(_C.SETV, speed_mm_s)
    session.send(_C.VEL, speed_mm_s)
    way_mm = max(40_000.0, 0x8000 * session.robot.distance_unit_mm + 1000)
    seen = drive_until(session, mark, lambda pose: pose.x_mm > way_mm, within_s=1.5 * way_mm / speed_mm_s)
    session.send(_C.STOP)
    session.wait_at_rest(10.0)
    steps_mm = [max(abs(b.x_mm - a.x_mm), abs(b.y_mm - a.y_mm)) for a, b in pairwise(poses(seen, session.robot))]
    at_most(max(steps_mm), STEP_MM, unit="mm", what="longest step between two SIPs")
    wrapped = any(a.sip.x_raw - b.sip.x_raw > 0x4000 for a, b in pairwise(seen))
    sixteen_bits = max(s.sip.x_raw for s in seen) > 0x7FFF
    assert wrapped or sixteen_bits, f"X never wrapped on {way_mm / 1000:g} m"
    session.leave()


@case("S53", bench_time_s=14.4)
def test_heading_wraps_at_half_a_turn(peer: Peer) -> None:
    """Turns on the spot."""
    session = Session(peer, motors=True)
    session.set_ramps(turn=200)
    session.send(_C.SETRV, TURN_DEG_S)
    session.next()
    mark = peer.mark()
    session.send(_C.RVEL, TURN_DEG_S)
    turns = 5
    seen = drive_until(session, mark, lambda pose: pose.heading_deg > (turns + 0.5) * 360, within_s=30.0)
    session.send(_C.STOP)
    half = session.robot.units_per_turn // 2
    least, most = min(s.sip.th_raw for s in seen), max(s.sip.th_raw for s in seen)
    assert -half <= least <= most < half, f"Th goes from {least} to {most}, beyond {-half} to {half - 1}"
    steps_deg = [b.heading_deg - a.heading_deg for a, b in pairwise(poses(seen, session.robot))]
    at_most(max(map(abs, steps_deg)), 1.25 * TURN_DEG_S * CYCLE_S, unit="deg", what="greatest step of the heading")
    wraps = sum(a.sip.th_raw - b.sip.th_raw > half for a, b in pairwise(seen))
    assert wraps >= turns, f"Th wrapped {wraps} times in {turns} turns"
    session.leave()


TURN_DEG_S = 150


# --- what only a world, a wire or another line can show


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
    old_baud = peer.port.baud
    session.send(_C.HOSTBAUD, 2)
    peer.run(0.02)
    peer.port.baud = 38_400
    peer.forget()
    peer.run(0.4)
    changed = bool(peer.sips())
    peer.port.baud = old_baud
    peer.run(0.3)
    peer.forget()
    peer.expect(Sip, SIP_WITHIN_S, what=f"SIP at {old_baud} bit/s again")
    session.leave()
    if not changed:
        raise NotApplicable("the server does not know HOSTBAUD: nothing came at 38400 bit/s, and all went on as before")


@case("S58", bench_time_s=1.3)
def test_auxiliary_bytes_come_when_all_are_there(peer: Peer) -> None:
    """Once in one string and once in two, of which the first must not be enough."""
    session = Session(peer)
    for text in ((b"AT",), (b"A", b"T")):
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
        assert answers == [b"\xb0AT"], f"{[a.hex(' ') for a in answers]} came, where one b0 41 54 is due"
    session.leave()
