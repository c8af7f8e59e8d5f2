"""The check's end of the stand-in link, against the board's connection of the protocol."""

from __future__ import annotations

import pytest

from hilbench.bench import Bench
from hilbench.bench.devices import ClientDevice, DeviceActor
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.vehicle.stack_peer import StackPeer
from protocols.autoware import (
    AckermannControlCommand,
    AgentFound,
    BoardOptions,
    BoardState,
    Connection,
    ControlModeReport,
    MessageReceived,
    Role,
    Transmit,
)


class Board:
    """The board's end of the line and nothing behind it."""

    def __init__(self, bench, port):
        self.connection = Connection(Role.BOARD, BoardOptions())
        self.events = []
        self.actor = DeviceActor(
            bench, ClientDevice(self.connection, Transmit), port, name="board", on_event=self.events.append
        )

    def say(self, message, now_ns):
        self.actor.transmit(self.connection.send(message, now_ns))

    def heard(self, kind):
        messages = [event.message for event in self.events if isinstance(event, MessageReceived)]
        return [message for message in messages if isinstance(message, kind)]


@pytest.fixture
def there():
    bench = Bench(Scheduler(), Journal())
    link = MemoryLink(bench.scheduler, Line(baud=921_600), name="stack")
    return bench, StackPeer(bench, link.a), Board(bench, link.b)


def test_it_answers_pings_while_it_is_online(there):
    bench, peer, board = there
    peer.online = False
    bench.run_for(1.5)
    assert board.connection.state is BoardState.SEEKING
    peer.online = True
    bench.run_for(1.0)
    assert board.connection.state is BoardState.ONLINE
    assert [event for event in board.events if isinstance(event, AgentFound)]


def test_commands_come_at_their_rate(there):
    bench, peer, board = there
    peer.command = AckermannControlCommand(speed=5.0)
    peer.commands.start(30.0)
    bench.run_for(1.0 + 1e-6)
    peer.commands.stop()
    assert peer.commands.said == 31
    bench.run_for(0.5)
    assert [command.speed for command in board.heard(AckermannControlCommand)] == [5.0] * 31


def test_it_keeps_what_the_board_says(there):
    bench, peer, board = there
    mark = peer.mark()
    for mode in (1, 4):
        board.say(ControlModeReport(mode=mode), bench.now_ns)
    bench.run_for(0.1)
    assert peer.modes(mark) == [1, 4]
    board.actor.transmit(b"\x7e\0\0\x02\0\x83\x01\0\0")
    board.say(ControlModeReport(mode=1), bench.now_ns)
    bench.run_for(0.1)
    assert [drop.reason for drop in peer.dropped] == ["BAD_CRC"]
    assert peer.modes() == [1, 4, 1]
