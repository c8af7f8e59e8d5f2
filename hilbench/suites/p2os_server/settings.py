"""What CONFIG says: what a client has set, where that ends, and what the robot shows of itself otherwise."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from hilbench.check import NotApplicable, Violation, at_most, case, near, within
from hilbench.suites._session import SIP_WITHIN_S, Session
from hilbench.suites.p2os_server.sips import LEAD_12_V, OTHER_BATTERY, OTHER_BATTERY_V
from hilbench.systems.pioneer.cases import VirtualCase
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber, ConfigPacket

_C = CommandNumber

LIMITS = (
    (_C.SETV, 1, "trans_vel_max_mm_s", "trans_vel_top_mm_s"),
    (_C.SETRV, 1, "rot_vel_max_deg_s", "rot_vel_top_deg_s"),
    (_C.SETA, 1, "trans_acc_mm_s2", "trans_acc_top_mm_s2"),
    (_C.SETA, -1, "trans_decel_mm_s2", "trans_acc_top_mm_s2"),
    (_C.SETRA, 1, "rot_acc_deg_s2", "rot_acc_top_deg_s2"),
    (_C.SETRA, -1, "rot_decel_deg_s2", "rot_acc_top_deg_s2"),
)
"""Command, sign of its argument, the figure of CONFIG that it sets, and the one that limits that."""

GAINS = (
    (_C.ROTKP, 1, "rot_kp"),
    (_C.ROTKV, 1, "rot_kv"),
    (_C.ROTKI, 1, "rot_ki"),
    (_C.TRANSKP, 1, "trans_kp"),
    (_C.TRANSKV, 1, "trans_kv"),
    (_C.TRANSKI, 1, "trans_ki"),
)

SET = (*((number, sign, figure) for number, sign, figure, _ in LIMITS), *GAINS)

LEAST, STEP = 30, 3
"""First of the values that are set, and how far they are apart: another for each figure, and below every top."""

MOST = 0x7FFF
"""More than any robot can."""


def config(session: Session) -> ConfigPacket:
    """Ask for CONFIG; S42 judges how much of it has to come."""
    session.send(_C.CONFIG, 1)
    return session.peer.expect(ConfigPacket, SIP_WITHIN_S, what="CONFIG packet")


def require_config(found: ConfigPacket, wanted: ConfigPacket, session: Session) -> None:
    """Require every figure of a CONFIG."""
    wrong = [
        f"{name} is {getattr(found, name)}, required {getattr(wanted, name)}"
        for name in ConfigPacket.__dataclass_fields__
        if getattr(found, name) != getattr(wanted, name)
    ]
    if wrong:
        raise Violation(f"CONFIG: {'; '.join(wrong)}", session.peer.evidence())


def _with(said: ConfigPacket, figure: str, value: int) -> ConfigPacket:
    changed: dict[str, Any] = {figure: value}
    return replace(said, **changed)


@case("S82", bench_time_s=3.1)
def test_config_shows_what_was_set(peer: Peer) -> None:
    """Sets all, then each one anew with CONFIG at its heels. Nothing moves."""
    session = Session(peer)
    wanted = config(session)
    values = range(LEAST, LEAST + STEP * len(SET), STEP)
    for (number, sign, figure), value in zip(SET, values, strict=True):
        session.send(number, sign * value)
        wanted = _with(wanted, figure, value)
    require_config(config(session), wanted, session)
    for (number, sign, figure), value in zip(SET, reversed(values), strict=True):
        session.send(number, sign * (value + 1))
        wanted = _with(wanted, figure, value + 1)
        require_config(config(session), wanted, session)
    session.leave()


@case("S83", bench_time_s=0.8)
def test_nothing_is_set_above_its_top(peer: Peer) -> None:
    """Nothing moves."""
    session = Session(peer)
    wanted = config(session)
    for number, sign, figure, top in LIMITS:
        session.send(number, sign * MOST)
        wanted = _with(wanted, figure, getattr(wanted, top))
    require_config(config(session), wanted, session)
    session.leave()


@case("S84", bench_time_s=1.0)
def test_what_was_set_is_forgotten(peer: Peer) -> None:
    session = Session(peer)
    before = config(session)
    for (number, sign, _), value in zip(SET, range(LEAST, LEAST + STEP * len(SET), STEP), strict=True):
        session.send(number, sign * value)
    session.leave()
    peer.run(0.3)
    again = Session(peer)
    require_config(config(again), before, again)
    again.leave()


@case("S85", bench_time_s=3.4)
def test_config_agrees_with_the_robot(peer: Peer) -> None:
    """Listens for the cycle of the SIPs, and for which sonar is there."""
    session = Session(peer)
    said = config(session)
    peer.run(BEHIND_S)
    begun_ns = session.now_ns
    seen = session.watch(2.0)
    who = session.identification
    for what, found, wanted in (
        ("type", said.robot_type, who.robot_class),
        ("subtype", said.subtype, who.subclass),
        ("name", said.name, who.name),
    ):
        assert found == wanted, f"the {what} of CONFIG is {found!r}, that of the identification {wanted!r}"
    first, last, cycles = seen[0], seen[-1], len(seen) - 1
    doubt_ms = 1000 * session.uncertainty_s(begun_ns) / cycles
    cycle_ms = 1000 * last.after_s(first.start_ns) / cycles
    near(said.sip_cycle_ms, cycle_ms, CYCLE_MS, unit="ms", what="SIP cycle of CONFIG", uncertainty=doubt_ms)
    discs = {reading.number // 8 for one in seen for reading in one.sip.sonars}
    for what, flag, there in (("front", said.front_sonar, 0 in discs), ("rear", said.rear_sonar, 1 in discs)):
        assert flag == there, f"the flag of the {what} sonar is {flag}, and readings of it came: {there}"
    session.leave()


BEHIND_S = 1.0
"""How long a CONFIG on a slow line may delay the SIPs behind it. A choice."""

CYCLE_MS = 0.5
"""Of a figure in whole milliseconds, against the mean of two seconds. A choice."""


@case("S94", bench_time_s=0.4)
def test_config_has_the_rate_of_the_line(peer: Peer) -> None:
    session = Session(peer)
    said = config(session)
    session.leave()
    baud = peer.port.baud
    if baud not in BAUDS:
        raise NotApplicable(f"HostBaud has no code for {baud} bit/s")
    assert said.host_baud == BAUDS.index(baud), f"HostBaud of CONFIG is {said.host_baud} at {baud} bit/s"


BAUDS = (9600, 19200, 38400, 57600, 115200)
"""In bit/s, by their codes."""


FLASHES: Sequence[Mapping[str, int]] = (
    {
        "rot_vel_top_deg_s": 340,
        "trans_vel_top_mm_s": 1500,
        "rot_acc_top_deg_s2": 280,
        "trans_acc_top_mm_s2": 1900,
        "pwm_max": 450,
        "sip_cycle_ms": 50,
        "aux1_baud": 1,
        "gripper": 1,
        "front_sonar": 0,
        "rear_sonar": 1,
        "low_battery_dv": 115,
        "revcount": 0x3E81,
        "watchdog_ms": 1950,
        "p2mpacs": 1,
        "stall_pwm": 210,
        "stall_count_ms": 150,
        "joy_vel_mm_s": 450,
        "joy_rot_vel_deg_s": 90,
    },
    {
        "rot_vel_top_deg_s": 370,
        "trans_vel_top_mm_s": 1700,
        "rot_acc_top_deg_s2": 310,
        "trans_acc_top_mm_s2": 2100,
        "pwm_max": 480,
        "sip_cycle_ms": 100,
        "aux1_baud": 2,
        "gripper": 0,
        "front_sonar": 1,
        "rear_sonar": 0,
        "low_battery_dv": 108,
        "revcount": 0x4268,
        "watchdog_ms": 1900,
        "p2mpacs": 0,
        "stall_pwm": 190,
        "stall_count_ms": 260,
        "joy_vel_mm_s": 520,
        "joy_rot_vel_deg_s": 110,
    },
)
"""Twice another value for each figure; of what stands beside another of the same size, never the same."""


@case("S92", bench_time_s=1.7)
def test_config_shows_what_is_in_flash(peer: Peer, bench: VirtualCase) -> None:
    """Nothing moves."""
    session = Session(peer)
    said = config(session)
    for figures in FLASHES:
        session.leave()
        peer.run(0.3)
        bench.write_flash(figures)
        session = Session(peer)
        wanted: dict[str, Any] = dict(figures)
        require_config(config(session), replace(said, **wanted), session)
    session.leave()


@case("S86", bench_time_s=0.4)
def test_figures_of_config_are_possible(peer: Peer) -> None:
    session = Session(peer)
    said = config(session)
    session.leave()
    for name in FLAGS:
        within(getattr(said, name), 0, 1, unit="", what=f"{name} of CONFIG, a flag")
    if "at" not in said.subtype.lower():
        at_most(said.four_motors, 0, unit="", what="four_motors of CONFIG, which an AT alone has")
    for name in ("host_baud", "aux1_baud"):
        within(getattr(said, name), 0, FASTEST, unit="", what=f"{name} of CONFIG, a code")
    low_v, high_v = OTHER_BATTERY_V if session.robot.subclass in OTHER_BATTERY else LEAD_12_V
    within(said.low_battery_dv / 10, low_v, high_v, unit="V", what="low_battery of CONFIG")
    within(said.watchdog_ms, *WATCHDOG_MS, unit="", what="watchdog of CONFIG, in ms,")
    at_most(said.stall_count_ms, STALL_MS, unit="", what="stall_count of CONFIG, in ms,")
    at_most(said.pwm_max, FULLY_ON, unit="counts", what="pwm_max of CONFIG")
    for name, top in AT_MOST:
        at_most(getattr(said, name), getattr(said, top), unit="", what=f"{name} of CONFIG, which {top} limits")
    for name in POSITIVE:
        within(getattr(said, name), 1, 0xFFFF, unit="", what=f"{name} of CONFIG")


FLAGS = ("four_motors", "gripper", "front_sonar", "rear_sonar", "p2mpacs")

FASTEST = 4
"""115200 bit/s; 0 is 9600."""

WATCHDOG_MS = 1900, 2000
"""Within which S36 and S38 have it: a robot that is fed every 1.9 s drives, and one that is not stops behind 2.0 s."""

STALL_MS = 10_000
"""A choice: nobody waits longer for a robot that has touched something."""

FULLY_ON = 500

AT_MOST: Iterable[tuple[str, str]] = (
    *((figure, top) for _, _, figure, top in LIMITS),
    ("joy_vel_mm_s", "trans_vel_top_mm_s"),
    ("joy_rot_vel_deg_s", "rot_vel_top_deg_s"),
    ("stall_pwm", "pwm_max"),
)

POSITIVE = (*(top for _, _, _, top in LIMITS), "pwm_max", "stall_pwm", "revcount")
