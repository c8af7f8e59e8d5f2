"""The whole loop in bench time: the client role of the protocol drives the robot, leaves, dies, and comes back."""

from __future__ import annotations

import pytest

from protocols.p2os import (
    ClientOptions,
    ClientState,
    Command,
    CommandNumber,
    Connected,
    Connection,
    Role,
    Transmit,
)
from targets.robots.pioneer import CommandObeyed

ARIA_LIKE = ClientOptions()
PLAYER_LIKE = ClientOptions(request_config=False, session_argument=None, keepalive_s=None)


class Client:
    """A client connection wired straight to a rig's robot."""

    def __init__(self, rig, options: ClientOptions = ARIA_LIKE) -> None:
        self.rig = rig
        self.connection = Connection(Role.CLIENT, options)
        self.events: list[object] = []
        self.alive = True
        self._seen = len(rig.received)

    def connect(self) -> None:
        self._do(self.connection.connect(self.rig.now_ns))
        self.run(3.0)
        assert self.connection.state is ClientState.OPEN

    def disconnect(self) -> None:
        self._do(self.connection.disconnect(self.rig.now_ns))
        self.run(1.0)

    def send(self, number: CommandNumber, value: int) -> None:
        self.rig.send(self.connection.send(Command(number, value), self.rig.now_ns))

    def run(self, duration_s: float) -> None:
        for _ in range(round(duration_s / 0.005)):
            self.rig.run(0.005)
            fresh = self.rig.received[self._seen :]
            self._seen = len(self.rig.received)
            if self.alive:
                data = b"".join(r.raw for r in fresh)
                self._do(self.connection.receive(data, self.rig.now_ns))

    def _do(self, events: list) -> None:
        self.events += events
        for event in events:
            if isinstance(event, Transmit):
                self.rig.send(event.data)


@pytest.mark.parametrize("options", [ARIA_LIKE, PLAYER_LIKE], ids=["like ARIA", "like Player"])
def test_connect_drive_leave_and_return(rig, options: ClientOptions) -> None:
    for _ in range(2):
        client = Client(rig, options)
        client.connect()
        (connected,) = [event for event in client.events if isinstance(event, Connected)]
        assert connected.parameters.subclass == "p2dx"
        assert (connected.config is not None) == options.request_config
        client.send(CommandNumber.ENABLE, 1)
        client.send(CommandNumber.VEL, 300)
        before = rig.chassis.x_m
        client.run(1.9)
        assert rig.sips[-1].left_raw == 300
        assert rig.chassis.x_m > before + 0.3
        client.disconnect()
        count = len(rig.sips)
        client.run(1.0)
        assert len(rig.sips) == count
        assert not rig.chassis.servo


def test_keep_alive_keeps_a_silent_user_driving(rig) -> None:
    client = Client(rig)
    client.connect()
    client.send(CommandNumber.ENABLE, 1)
    client.send(CommandNumber.VEL, 200)
    client.run(6.0)
    assert rig.sips[-1].left_raw == 200


def test_a_client_that_dies_is_taken_over_even_while_the_robot_moves(rig) -> None:
    first = Client(rig)
    first.connect()
    first.send(CommandNumber.ENABLE, 1)
    first.send(CommandNumber.VEL, 200)
    first.run(1.5)
    first.alive = False
    assert rig.sips[-1].moving
    second = Client(rig)
    second.connect()
    assert not rig.sips[-1].motors_enabled
    assert not rig.sips[-1].moving
    second.send(CommandNumber.ENABLE, 1)
    second.send(CommandNumber.HEAD, 90)
    second.run(3.0)
    assert rig.sips[-1].th_raw == pytest.approx(1024, abs=2)
    assert rig.told(CommandObeyed)[-1].command == Command(CommandNumber.HEAD, 90)


def test_a_dead_client_leaves_a_robot_that_stops_within_the_watchdog(rig) -> None:
    client = Client(rig)
    client.connect()
    client.send(CommandNumber.ENABLE, 1)
    client.send(CommandNumber.VEL, 200)
    client.run(1.0)
    client.alive = False
    client.run(2.0 + 200 / 300 + 0.3)
    assert not rig.sips[-1].moving
    there = rig.chassis.x_m
    client.run(5.0)
    assert rig.chassis.x_m == pytest.approx(there, abs=1e-6)
