"""Families of commands at other moments: two at once in each order and twice, late behind the watchdog, too early."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

from hilbench.check import Inconclusive, Untimely, Violation, case, try_members
from hilbench.suites._session import SIP_WITHIN_S, Session
from hilbench.suites.p2os_server.families import ANSWER_S, shown
from hilbench.suites.p2os_server.handshake import require_untouched
from hilbench.suites.p2os_server.stopping import drive_into_silence
from hilbench.systems.pioneer.cases import AttachedCase, VirtualCase
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber, ConfigPacket, Sip, encode_frame

_C = CommandNumber

Command = tuple[CommandNumber, int]

SHOWN: Mapping[str, Command] = {
    "ENABLE 1": (_C.ENABLE, 1),
    "ENABLE 0": (_C.ENABLE, 0),
    "SONAR 1": (_C.SONAR, 1),
    "SONAR 0": (_C.SONAR, 0),
    "DIGOUT 0F": (_C.DIGOUT, 0xFF0F),
    "DIGOUT F0": (_C.DIGOUT, 0xFFF0),
    "CONFIG": (_C.CONFIG, 1),
}
"""What a SIP shows, and what is answered; of DIGOUT the mask is the high byte."""

FLAGS = {_C.ENABLE: 1, _C.SONAR: 2}

LATE_S = 2.3
"""Longer than the watchdog waits, by what a bench may be late. A choice."""


class Outputs:
    """What a robot shows that stands: two flags and the digital outputs, and what commands are to make of them."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.before = self._take(session.first.sip)

    def require(self, commands: Sequence[Command]) -> None:
        """Send commands without a gap; require what the second SIP behind them shows, and an answer to each kind."""
        due = self._now
        for number, argument in commands:
            due = _after(due, number, argument)
        peer = self._session.peer
        mark = peer.mark()
        self._take(shown(self._session, b"".join(_frame(*command) for command in commands)))
        if self._now != due:
            found, wanted = (f"flags {flags:02X} and outputs {outputs:02X}" for flags, outputs in (self._now, due))
            raise Violation(f"{found}, required {wanted}", peer.evidence(mark))
        if any(number == _C.CONFIG for number, _ in commands) and not peer.since(mark, ConfigPacket):
            peer.run(ANSWER_S)
            if not peer.since(mark, ConfigPacket):
                raise Untimely("CONFIG is not answered", peer.evidence(mark), spare_s=ANSWER_S)

    def restore(self) -> None:
        """Put the digital outputs back: something may hang on those of a real robot."""
        self._session.write(_frame(_C.DIGOUT, 0xFF00 | self.before[1]))

    def _take(self, sip: Sip) -> tuple[int, int]:
        self._now = sip.flags & sum(FLAGS.values()), sip.digout
        return self._now


def _after(shown: tuple[int, int], number: CommandNumber, argument: int) -> tuple[int, int]:
    """Return flags and outputs behind a command."""
    flags, outputs = shown
    if number in FLAGS:
        return (flags | FLAGS[number]) if argument else (flags & ~FLAGS[number]), outputs
    return (flags, argument & 0xFF) if number == _C.DIGOUT else shown


def _frame(number: CommandNumber, argument: int) -> bytes:
    """Return a packet with a positive argument of 16 bits."""
    return encode_frame(bytes((number, 0x3B)) + argument.to_bytes(2, "little"))


@case("S64", bench_time_s=4.3)
def test_two_commands_at_once_in_each_order(bench: VirtualCase | AttachedCase, peer: Peer) -> None:
    outputs = Outputs(session := Session(peer))
    members = [
        (f"{one} and {other}" if one != other else f"{one} twice", (SHOWN[one], SHOWN[other]))
        for one, other in itertools.product(SHOWN, SHOWN)
    ]
    try:
        try_members("pairs of commands", members, outputs.require, seed=bench.case.seed, budget=20)
    finally:
        outputs.restore()
    session.leave()


TWITCH_S = 0.3
"""How long a robot may move by the first of two commands that come 10 ms apart on a slow line. A choice."""

GOES: Mapping[str, Command] = {
    "VEL 150": (_C.VEL, 150),
    "RVEL 40": (_C.RVEL, 40),
    "VEL2": (_C.VEL2, 0x0505),
    "DHEAD 90": (_C.DHEAD, 90),
    "MOVE 1000": (_C.MOVE, 1000),
}


@case("S89", bench_time_s=9.4)
def test_a_stop_and_a_start_at_once_count_in_their_order(peer: Peer) -> None:
    """Floor: 0.4 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=1000, down=1000, turn=200)

    def moves(commands: Sequence[Command]) -> bool:
        arrived_ns = session.write(b"".join(_frame(*command) for command in commands))
        return any(not one.at_rest for one in session.watch_alive(0.6) if one.after_s(arrived_ns) > TWITCH_S)

    for name, command in GOES.items():
        if command[0] == _C.MOVE and not session.robot.has_move:
            continue
        if moves([command, (_C.STOP, 0)]):
            raise Violation(f"the robot drives after {name} and then STOP", peer.evidence())
        if not moves([(_C.STOP, 0), command]):
            raise Violation(f"the robot stands after STOP and then {name}", peer.evidence())
        session.send(_C.STOP)
        session.wait_at_rest(5.0)
    session.leave()


STOPS: Mapping[str, Command] = {
    "STOP": (_C.STOP, 0),
    "VEL 0": (_C.VEL, 0),
    "E_STOP": (_C.E_STOP, 0),
    "ENABLE 0": (_C.ENABLE, 0),
}


@case("S65", bench_time_s=12.0)
def test_each_command_is_late(bench: VirtualCase | AttachedCase, peer: Peer) -> None:
    """Floor: 0.6 m ahead, and 1 m more for a robot that fails."""
    session, seed = Session(peer), bench.case.seed
    outputs = Outputs(session)

    def is_obeyed(command: Command) -> None:
        peer.run(LATE_S)
        outputs.require([command])

    def stays(command: Command) -> None:
        session.motors_on()
        _, seen = drive_into_silence(session)
        if not seen[-1].at_rest:
            raise Inconclusive("the robot has not stopped; see S36", peer.evidence())
        session.write(_frame(*command))
        moving = [one for one in session.watch_alive(1.0) if not one.at_rest]
        if moving:
            text = f"the robot drives on at {max(abs(one.speed_mm_s) for one in moving):.0f} mm/s"
            raise Violation(text, peer.evidence())

    try:
        try_members("late commands", [*SHOWN.items()], is_obeyed, seed=seed, budget=3)
    finally:
        outputs.restore()
    try_members("late stops", [*STOPS.items()], stays, seed=seed, budget=1)
    session.leave()


EARLY: Mapping[str, Command] = {
    **SHOWN,
    "VEL 200": (_C.VEL, 200),
    "RVEL 30": (_C.RVEL, 30),
    "MOVE 1000": (_C.MOVE, 1000),
    "HEAD 90": (_C.HEAD, 90),
    "DHEAD 45": (_C.DHEAD, 45),
    "VEL2": (_C.VEL2, 0x0A0A),
    "ENCODER 2": (_C.ENCODER, 2),
    "IOREQUEST 2": (_C.IOREQUEST, 2),
    "BATTERYINFO 1": (_C.BATTERYINFO, 1),
}


@case("S66", bench_time_s=6.7)
def test_each_command_is_too_early(bench: VirtualCase | AttachedCase, peer: Peer) -> None:
    """Also looks into the session that follows, as S07 does."""
    digout = (session := Session(peer)).first.sip.digout
    session.leave()

    def has_no_effect(stage_and_command: tuple[bool, Command]) -> None:
        identified, command = stage_and_command
        peer.run(SILENT_S)
        if identified:
            peer.handshake()
        peer.write(_frame(*command))
        peer.expect_silence(SILENT_S, why="there is no session", settled=True)
        if not identified:
            peer.handshake()
        peer.send(_C.OPEN)
        first = peer.expect(Sip, SIP_WITHIN_S, what="first SIP")
        require_untouched(first)
        if not first.flags & FLAGS[_C.SONAR]:
            raise Violation("the session begins with the sonar off", peer.evidence())
        if first.digout != digout:
            raise Violation(f"the outputs are {first.digout:02X}, they were {digout:02X}", peer.evidence())
        peer.send(_C.CLOSE, 1)

    members = [
        (f"{name} {stage}", (identified, command))
        for name, command in EARLY.items()
        for identified, stage in ((False, "before the handshake"), (True, "behind the identification"))
    ]
    try_members("early commands", members, has_no_effect, seed=bench.case.seed, budget=8)


SILENT_S = 0.3
