from __future__ import annotations

from pathlib import Path

import pytest

from hilbench.clock import Scheduler
from hilbench.errors import PortClosedError, UnavailableError
from hilbench.links import Line, PtyDoor, Rfc2217Door, TcpDoor
from hilbench.serving import door_option, open_door, place
from hilbench.serving.doors import LastingLine, SharedDoor
from hilbench.terminal import arguments, options
from hilbench.terminal.options import Clients
from hilbench.testing import link_pair
from tests.each import each


class Rig:
    """A shared door made of two lines inside the bench, whose far ends are the clients."""

    def __init__(self, clients=Clients.FIRST):
        self.scheduler = Scheduler()
        pairs = [link_pair(self.scheduler, name=name) for name in ("one", "two")]
        self.near, self.clients = [near for near, _ in pairs], [far for _, far in pairs]
        for near in self.near:
            near.line_is_up = False
        self.door = SharedDoor(self.near, clients)
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


def test_all_have_the_line_together():
    rig = Rig(Clients.ALL)
    sent = []
    rig.door.on_sent = lambda data, _at_ns: sent.append(data)
    rig.come(0)
    rig.come(1)
    rig.say(0, b"a")
    rig.say(1, b"b")
    rig.answer(b"x")
    assert rig.order == [True, b"a", b"b"]
    assert (rig.heard, sent) == ([b"x", b"x"], [b"x"])
    rig.scheduler.run_for(10**9)
    rig.go(0)
    rig.answer(b"y")
    assert rig.heard == [b"x", b"xy"]
    rig.go(1)
    assert rig.order[3:] == [False]
    counters = rig.door.counters
    assert (counters.sent, counters.received, counters.refused, counters.lost) == (2, 2, 0, 0)


def test_who_comes_as_the_one_before_leaves_at_another_door_begins_anew():
    """That one has gone is seen later than that the next has come: its bytes have to be through."""
    rig = Rig(Clients.ALL)
    rig.come(0)
    rig.scheduler.run_for(10**9)
    rig.come(1)
    rig.scheduler.run_for(10**8)
    rig.go(0)
    assert rig.order == [True, False, True]
    rig.say(1, b"a")
    assert rig.order[3:] == [b"a"]


def test_the_newest_has_the_line_and_then_whoever_is_still_there():
    rig = Rig(Clients.NEWEST)
    rig.come(0)
    rig.come(1)
    rig.say(0, b"a")
    rig.say(1, b"b")
    rig.answer(b"x")
    assert rig.order == [True, False, True, b"b"]
    rig.go(1)
    rig.say(0, b"c")
    rig.answer(b"y")
    assert rig.order[4:] == [False, True, b"c"]
    assert rig.heard == [b"y", b"x"]


def test_what_is_said_at_two_doors_at_once_is_not_torn():
    scheduler, order = Scheduler(), []
    doors = [Rfc2217Door(scheduler, "0", Line(baud=9600), name=name, clients=Clients.ALL) for name in ("one", "two")]
    shared = SharedDoor(doors, Clients.ALL)
    shared.on_receive = lambda data, _at_ns: order.append(data)
    shared.on_break = lambda _at_ns: order.append("break")
    for door in doors:
        door._set_line(True, 0)
    one, two = doors
    one._let_in(None, b"abc")
    two._let_in(None, b"defg")
    two._client_broke(0)
    one._let_in(None, b"hi")
    two._let_in(None, b"jk")
    two._client_left()
    for door in doors:
        scheduler.remove_source(door._listening)
    scheduler.run_for(10 * 10**6)
    assert order == [*(bytes((value,)) for value in b"abcdefg"), "break", b"h", b"i"]
    assert two.line_is_up
    scheduler.run_for(2 * 10**6)
    assert order[10:] == [b"j", b"k"]
    assert not two.line_is_up
    for door in doors:
        door.close()


def test_what_waits_for_its_turn_can_be_purged_and_is_lost_with_a_door_that_closes():
    scheduler, heard = Scheduler(), []
    doors = [Rfc2217Door(scheduler, "0", Line(baud=9600), name=name) for name in ("one", "two", "three")]
    SharedDoor(doors, Clients.ALL).on_receive = lambda data, _at_ns: heard.append(data)
    for door in doors:
        scheduler.remove_source(door._listening)
        door._set_line(True, 0)
        door._let_in(None, door.name.encode())
    doors[0].close()
    doors[1]._purge()
    scheduler.run_for(10**7)
    assert b"".join(heard) == b"tthree"
    assert doors[1].counters.withdrawn == 2
    for door in doors:
        door.close()


def test_a_break_for_all_is_refused_only_if_nobody_can_have_it():
    rig = Rig(Clients.ALL)

    def refuse(_duration_ns, _refused):
        raise UnavailableError("knows none")

    rig.near[0].send_break = refuse
    breaks = []
    rig.clients[1].on_break = breaks.append
    rig.come(0)
    with pytest.raises(UnavailableError):
        rig.door.send_break(1000)
    rig.come(1)
    rig.door.send_break(1000)
    rig.scheduler.run_for(10**7)
    assert len(breaks) == rig.door.counters.breaks_unsent == 1


@each(
    ("clients", "said"),
    [
        (Clients.ALL, ["two: another client came; the others stay connected, at other endpoints",
                       "two: one client left; others are still connected, at other endpoints"]),
        (Clients.NEWEST, ["two: another client came and took over the line",
                          "one: the previous client is gone"]),
        (Clients.FIRST, ["two: another client came and is ignored: the first one has the line, at another endpoint",
                         "two: the ignored client left"]),
    ],
)  # fmt: skip
def test_at_two_doors_it_is_said_who_comes_and_goes(clients, said):
    scheduler, told = Scheduler(), []
    doors = [TcpDoor(scheduler, "0", name=name) for name in ("one", "two")]
    SharedDoor(doors, clients)
    for door in doors:
        door.on_visit = lambda text, name=door.name: told.append(f"{name}: {text}")
        door.disconnect = lambda door=door: door._set_line(False, 0)
    for number, up in ((0, True), (1, True), (1, False), (0, False)):
        doors[number]._set_line(up, 0)
    assert told == said
    for door in doors:
        door.close()


def test_a_lasting_line_hides_that_the_far_end_hung_up():
    near, far = link_pair(Scheduler())
    near.line_is_up = False
    line, order = LastingLine(near), []
    line.on_line = lambda up, _at_ns: order.append(up)
    for up in (True, False, True):
        near.line_changed(up)
    assert (order, line.line_is_up) == ([True], True)
    far.close()


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


@each(
    ("text", "door"),
    [
        ("4000", options.Rfc2217Door(port=4000)),
        ("usart2=[::1]:0", options.Rfc2217Door(port=0, host="::1", link="usart2")),
    ],
)
def test_an_rfc2217_door_is_written_as_a_tcp_door(text, door):
    assert arguments.rfc2217_door(text) == door
