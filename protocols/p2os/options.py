"""What both roles can be set to; each choice between sources that disagree names them.

Times are in seconds of bench time here, for people; the connection counts in integer nanoseconds.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.common.options import check_positive
from protocols.p2os.errors import LocalProtocolError
from protocols.p2os.framing import MAX_COUNT_AUX, MAX_COUNT_STRICT
from protocols.p2os.packets import Identification
from protocols.p2os.robots import ROBOTS, RobotParameters, find_robot

__all__ = ["WATCHDOG_S", "ClientOptions", "CompassRule", "Dialect", "ServerOptions", "UnknownSubclass", "WrongOrder"]

MAX_NAME = 19
"""Characters of each identification string that the Player driver and its offspring keep (p2os.cc)."""


_P2DX = Identification(name="", subclass="p2dx")


WATCHDOG_S = 2.0
"""Silence after which a robot stops, as delivered: it stands in FLASH (Pioneer 2 Operations Manual)."""


class WrongOrder(enum.Enum):
    """What a server does with a SYNC that is not the next one; no manual says.

    SYNC0 always restarts, a repeat of the last SYNC is always echoed again. Silence alone would stop ARIA, which does
    not step back on silence.
    """

    REFUSE = "answers FF, SYNC count error, and stays; ARIA restarts on it (AriaCoda ArRobot.cpp)"
    ADOPT = "warns, takes the client's number and goes on from there (AMRISim EmulatePioneer.cc, as built)"
    REECHO = "answers the number it expects (AMRISim EmulatePioneer.cc, build option)"
    RESTART = "says nothing and waits for SYNC0 (AMRISim EmulatePioneer.cc, build option, said to be ARCOS)"
    IGNORE = "says nothing and stays (the manuals describe no error reply)"


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerOptions:
    """The server role.

    Attributes:
        identification: what SYNC2 is answered with; each string at most 19 characters.
        wrong_order: see `WrongOrder`.
        watchdog_s: silence after which the robot must stop. AMRISim only warns: None does the same.
        handshake_limit_s: a handshake not finished by then is forgotten; AMRISim has 10 s, the manuals nothing.
        max_count: largest count received: 200 by the manual, 207 AMRISim, 249 by the Pioneer 2/3 H8 manual.
        frame_timeout_s: an unfinished frame is given up when no byte came for this long; None for never. No source has
            a figure: 0.5 s is many times what separates the bytes of any client seen.
        raw_tty: take TTY strings without a length byte, as ARIA's comDataN sends them.
    """

    identification: Identification = _P2DX
    wrong_order: WrongOrder = WrongOrder.REFUSE
    watchdog_s: float | None = WATCHDOG_S
    handshake_limit_s: float | None = None
    max_count: int = MAX_COUNT_STRICT
    frame_timeout_s: float | None = 0.5
    raw_tty: bool = True

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        identity = self.identification
        for name, text in (("name", identity.name), ("class", identity.robot_class), ("subclass", identity.subclass)):
            if len(text) > MAX_NAME:
                raise LocalProtocolError(f"identification {name} {text!r} is longer than {MAX_NAME} characters")
        identity.encode()
        check_positive(LocalProtocolError, self, ("watchdog_s", "handshake_limit_s", "frame_timeout_s"))


class UnknownSubclass(enum.Enum):
    """What a client does with a robot it has no parameters for."""

    REFUSE = "sends CLOSE and fails, as ARIA (ArRobotConnector.cpp)"
    FALL_BACK = "warns and takes the parameters of `fallback_subclass`, as Player and its offspring (p2os.cc)"


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientOptions:
    """The client role. The figures are ARIA's (ArRobot.cpp), unless another source is named.

    Attributes:
        sync_timeout_s: how long a SYNC waits for its answer.
        silent_attempts: SYNC0s without any answer after which there is nobody, or the next rate is tried.
        max_misses: unanswered SYNCs in all, once something has answered.
        step_attempts: unanswered repeats of SYNC1 or SYNC2 after which SYNC0 is tried again; ARIA never steps back.
        max_restarts: restarts at SYNC0 after wrong answers.
        restart_pause_s: pause before such a restart, in which late answers are thrown away (Player waits 0.4 s).
        close_silence_s: after CLOSE to an old session: how long there must be no SIP before SYNC0.
        max_closes: CLOSEs to an old session before giving up.
        open_delay_s: pause between the identification and OPEN.
        session_argument: the integer that OPEN and CLOSE carry: ARIA sends 1; None for none, as the manual, Player and
            ROS have it. With an argument a CLOSE can never be taken for a SYNC2.
        bauds: rates in bit/s to try one after the other, the present one first; empty: no scan. Player tries
            9600, 38400, 19200, 115200, 57600.
        scan_attempts: as `silent_attempts`, at each rate of a scan (Player has 5, shorter ones).
        request_config: ask for the CONFIG packet after OPEN; ARIA does, Player and ROS do not.
        config_retry_s: after how long without an answer OPEN is sent again, until a SIP comes, and CONFIG is asked
            for again.
        config_wait_s: how long after OPEN the session goes on without CONFIG, once a SIP has come.
        keepalive_s: PULSE is sent when nothing else was for this long; None leaves it to the user, as Player and ROS.
        sip_timeout_s: a session without a SIP for this long is lost; one that never had any could not be opened.
        close_delay_s: pause between ENABLE 0 and CLOSE.
        unknown_subclass: see `UnknownSubclass`.
        fallback_subclass: the parameters taken for an unknown robot: p2dx (p2os-arduino), amigo-sh (Player), amigo
            (ROS).
        wide_status: take packet types 30, 31 and 34 hex for SIPs too, as Player, ROS and p2os-arduino do.
        max_count: largest count received: 203, a full AUX packet. ARIA takes any, up to 255; but then a stray header
            before a large number swallows that many bytes of good packets.
        frame_timeout_s: as for the server.
    """

    sync_timeout_s: float = 1.0
    silent_attempts: int = 6
    max_misses: int = 11
    step_attempts: int = 3
    max_restarts: int = 10
    restart_pause_s: float = 0.2
    close_silence_s: float = 0.25
    max_closes: int = 20
    open_delay_s: float = 0.1
    session_argument: int | None = 1
    bauds: tuple[int, ...] = ()
    scan_attempts: int = 3
    request_config: bool = True
    config_retry_s: float = 0.3
    config_wait_s: float = 1.0
    keepalive_s: float | None = 0.5
    sip_timeout_s: float = 8.0
    close_delay_s: float = 0.1
    unknown_subclass: UnknownSubclass = UnknownSubclass.REFUSE
    fallback_subclass: str = "p2dx"
    wide_status: bool = False
    max_count: int = MAX_COUNT_AUX
    frame_timeout_s: float | None = 0.5

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        if find_robot(self.fallback_subclass) is None:
            raise LocalProtocolError(f"no robot {self.fallback_subclass!r} to fall back on")
        times = [name for name in self.__slots__ if name.endswith("_s")]
        check_positive(
            LocalProtocolError, self, (*times, "silent_attempts", "max_misses", "step_attempts", "scan_attempts")
        )

    @property
    def fallback(self) -> RobotParameters:
        """The parameters of `fallback_subclass`."""
        return find_robot(self.fallback_subclass) or ROBOTS["p2dx"]


class CompassRule(enum.Enum):
    """How the compass byte of a SIP is read."""

    ARIA = "twice the byte, in degrees (AriaCoda ArRobot.cpp)"
    PLAYER = "twice the byte less one; 0, 181 and 255 are no reading (Player sip.cc)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """How the raw fields of a SIP are understood where the sources disagree.

    Attributes:
        aria_angle: 0.00153 rad for a heading unit, as in ARIA's parameter files: a turn has 359.07 degrees. Otherwise
            the robot's exact unit.
        compass: see `CompassRule`.
        gripper_first: the word behind the sonar readings has the gripper in its low byte: Pioneer 3 manual, AMRISim.
            Otherwise the analog port, as Pioneer 2 firmware sends it (a capture of a real Pioneer 2-DX; Player sip.cc).
    """

    aria_angle: bool = False
    compass: CompassRule = CompassRule.ARIA
    gripper_first: bool = False
