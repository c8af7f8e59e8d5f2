"""Whose command counts: the mode's own, and not what CARLA's node makes of an older one."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.check import Inconclusive, Violation, at_least, at_most
from hilbench.clock import NS_PER_S
from hilbench.suites.vehicle_host._host import COMMAND, F2, MANUAL, UNDERSTAND_S, Host, alike, host, on_host
from hilbench.systems.vehicle.car_simulator import Published
from protocols.carla import AckermannCommand, decode_command
from targets.robots.car_host import CarState

__all__ = ["host"]


def _status_between(host: Host) -> None:
    """Say F2, have a status sent, and say an empty frame."""
    host.move(CarState())
    mark = host.statuses_from_now()
    host.say(F2, 0.003)  # the next read of one that polls, which may wait, is yet to come
    host.own.report("velocity", "steering")
    host.board.run(0.003)
    if not host.board.frames(mark):
        raise Inconclusive("no status is sent after F2", host.board.evidence())
    host.say(b"#$")


@on_host("VS28", lasts_s=0.3)
def test_sending_forgets_the_mode(host: Host) -> None:
    _status_between(host)
    host.require(MANUAL, AckermannCommand(steering_rad=-0.5, speed_m_s=0.75))


@on_host("VS28H", lasts_s=0.3)
def test_values_keep_their_mode(host: Host) -> None:
    _status_between(host)
    host.require_no_more(MANUAL)


NODE_S = 1.0
"""So long CARLA's node goes on behind its last command."""


def _from_autoware_to_joystick(host: Host) -> int:
    """Say commands of mode 1, and then the joystick's; return how many the car was sent until the first of these."""
    host.board.command = COMMAND
    host.board.commands.start(20.0)
    host.board.run(0.3)
    host.board.commands.stop()
    host.board.command = decode_command(F2)
    host.board.commands.start(1 / 0.06)
    host.wait_told(lambda: any(alike(one.command, MANUAL) for one in host.commanded))
    host.board.run(UNDERSTAND_S)
    return len(host.commanded)


def _others(commanded: Sequence[Published]) -> list[Published]:
    """What is not the joystick's."""
    return [one for one in commanded if not alike(one.command, MANUAL)]


@on_host("VS22", lasts_s=2.2)
def test_the_joystick_is_contradicted(host: Host) -> None:
    start = _from_autoware_to_joystick(host)
    host.board.run(0.8 - UNDERSTAND_S)
    at_least(len(_others(host.commanded[start:])), 8, unit="commands", what="that are not the joystick's")
    host.board.run(NODE_S - 0.8 + UNDERSTAND_S)
    start = len(host.commanded)
    host.board.run(0.5)
    at_most(len(_others(host.commanded[start:])), 0, unit="commands", what="that are not the joystick's a second later")
    at_least(len(host.commanded) - start, 1, unit="commands", what="of the joystick")


@on_host("VS22H", lasts_s=1.7)
def test_the_joystick_wins(host: Host) -> None:
    start = _from_autoware_to_joystick(host)
    host.board.run(0.8)
    others = _others(host.commanded[start:])
    if others:
        times = ", ".join(f"{one.ns / NS_PER_S:.3f}" for one in others[:4])
        raise Violation(f"{len(others)} times the car gets a command that is not the joystick's, at {times} s")
    at_least(len(host.commanded) - start, 1, unit="commands", what="of the joystick")
