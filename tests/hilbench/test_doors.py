from __future__ import annotations

from pathlib import Path

import pytest

from hilbench.clock import Scheduler
from hilbench.errors import PortClosedError
from hilbench.links import Line, PtyDoor, Rfc2217Door, TcpDoor
from hilbench.serving import door_option, open_door, place
from hilbench.serving.doors import SharedDoor
from hilbench.terminal import arguments, options
from hilbench.testing import link_pair


class Rig:
    """A shared door made of two lines inside the bench, whose far ends are the clients."""

    def __init__(self):
        self.scheduler = Scheduler()
        pairs = [link_pair(self.scheduler, name=name) for name in ("one", "two")]
        self.near, self.clients = [near for near, _ in pairs], [far for _, far in pairs]
        for near in self.near:
            near.line_is_up = False
        self.door = SharedDoor(self.near)
        self.order = []
        self.heard = [b"", b""]
        self.door.on_receive = lambda data, _at_ns: self.order.append(data)
        self.door.on_line = lambda up, _at_ns: self.order.append(up)
        for number, client in enumerate(self.clients):
            client.on_receive = lambda data, _at_ns, number=number: self.hear(number, data)

    def hear(self, number, data):
        self.heard[number] += data

    def come(self, number):
        self.near[number].line_changed(True)

    def go(self, number):
        self.near[number].line_changed(False)

    def say(self, number, data):
        self.clients[number].write(data)
        self.scheduler.run_for(10**7)

    def answer(self, data):
        self.door.write(data)
        self.scheduler.run_for(10**7)


@pytest.fixture
def rig():
    return Rig()


def test_who_comes_first_has_the_line_until_he_leaves(rig):
    rig.come(0)
    rig.come(1)
    rig.say(0, b"a")
    rig.say(1, b"bcd")
    rig.answer(b"x")
    assert rig.order == [True, b"a"]
    assert rig.heard == [b"x", b""]
    rig.go(0)
    rig.say(1, b"e")
    rig.answer(b"y")
    assert rig.order == [True, b"a", False, True, b"e"]
    assert rig.heard == [b"x", b"y"]
    counters = rig.door.counters
    assert (counters.sent, counters.received, counters.refused, counters.lost) == (2, 2, 3, 0)


def test_who_leaves_without_having_had_the_line_changes_nothing(rig):
    rig.come(1)
    rig.come(0)
    rig.go(0)
    assert rig.order == [True]
    assert rig.door.line_is_up
    rig.go(1)
    rig.go(1)
    assert rig.order == [True, False]
    rig.come(0)
    assert rig.order == [True, False, True]


def test_what_nobody_hears_is_counted(rig):
    rig.answer(b"into the void")
    assert (rig.door.counters.sent, rig.door.counters.lost) == (13, 13)
    assert rig.heard == [b"", b""]


def test_a_new_rate_is_that_of_every_door(rig):
    rig.door.baud = 9600
    assert {near.baud for near in rig.near} == {rig.door.baud} == {9600}


def test_breaks_go_both_ways_but_only_for_the_owner(rig):
    breaks = []
    rig.door.on_break = lambda _at_ns: breaks.append("door")
    rig.clients[1].on_break = lambda _at_ns: breaks.append("client")
    rig.come(1)
    rig.come(0)
    for client in rig.clients:
        client.send_break(1000)
    rig.door.send_break(1000)
    rig.scheduler.run_for(10**7)
    assert sorted(breaks) == ["client", "door"]
    assert rig.door.counters.breaks == 1


def test_what_is_sent_is_reported_once(rig):
    sent = []
    rig.door.on_sent = lambda data, _at_ns: sent.append(data)
    rig.come(0)
    rig.answer(b"x")
    assert sent == [b"x"]


def test_closed_is_closed(rig):
    rig.come(0)
    rig.door.close()
    rig.door.close()
    assert rig.door.closed
    assert all(near.closed for near in rig.near)
    assert not rig.door.line_is_up
    with pytest.raises(PortClosedError):
        rig.door.write(b"x")


@pytest.mark.parametrize(
    ("wish", "kind", "option"),
    [
        (options.PtyDoor(path=Path("door")), PtyDoor, "--pty"),
        (options.TcpDoor(port=0), TcpDoor, "--tcp"),
        (options.Rfc2217Door(port=0), Rfc2217Door, "--rfc2217"),
    ],
)
def test_a_door_is_opened_as_it_was_wished_for(tmp_path, monkeypatch, wish, kind, option):
    monkeypatch.chdir(tmp_path)
    scheduler = Scheduler()
    door = open_door(wish, scheduler, Line(baud=9600), any_baud=True)
    assert type(door) is kind
    assert door.baud == door.client_baud == 9600
    assert door_option(wish) == option
    assert place(door).endswith("door" if kind is PtyDoor else f"{option[2:]} 127.0.0.1:{door.port}")
    door.close()
    assert scheduler._sources == []


@pytest.mark.parametrize(
    ("text", "door"),
    [
        ("4000", options.Rfc2217Door(port=4000)),
        ("usart2=[::1]:0", options.Rfc2217Door(port=0, host="::1", link="usart2")),
    ],
)
def test_an_rfc2217_door_is_written_as_a_tcp_door(text, door):
    assert arguments.rfc2217_door(text) == door
