"""What stands between two ends: every byte as it came, faults the same every time, both in the journal."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.bench import Bench
from hilbench.benchfile.fault_entries import FaultEntry
from hilbench.benchfile.reader import open_bench
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.errors import UnavailableError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.links.door import Door
from hilbench.serving.near_ends import open_near_end
from hilbench.serving.relay import CLIENT, SERVER, Relay
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.testing import LinkUnderTest, check_link
from protocols.pkt import ClientState
from tests.each import each

EMULATED = pytest.mark.exhaustive("the gate has the model of the rover; here its firmware is emulated")
FAULTS = (
    FaultEntry(kind="flip", probability=0.02, bit=3, towards="b"),
    FaultEntry(kind="drop", probability=0.02, count=2, towards="a"),
    FaultEntry(kind="noise", byte=20, count=5, towards="a"),
    FaultEntry(kind="disconnect", at_s=0.4, duration_s=0.1),
)


class Between:
    """A client and a server at lines in memory, and the relay between these."""

    def __init__(self, *, faults=(), seed=0, baud=0, record=True, to_client=None, to_server=None):
        self.bench = Bench(Scheduler(), Journal(keep=10**6))
        client_line = MemoryLink(self.bench.scheduler, Line(baud=baud), name="to client")
        server_line = MemoryLink(self.bench.scheduler, Line(baud=baud), name="to server")
        self.client, self.server = client_line.a, server_line.b
        client_line.b.send_break = to_client or client_line.b.send_break
        server_line.a.send_break = to_server or server_line.a.send_break
        self.heard = []
        self.relay = Relay(
            self.bench,
            client_line.b,
            server_line.a,
            faults=faults,
            seed=seed,
            record=record,
            heard=lambda who, data, at_ns: self.heard.append((who, data)),
        )
        self.got = {CLIENT: bytearray(), SERVER: bytearray()}
        self.client.on_receive = lambda data, at_ns: self.got[CLIENT].extend(data)
        self.server.on_receive = lambda data, at_ns: self.got[SERVER].extend(data)

    def run(self, seconds=1.0):
        self.bench.run_for(seconds)
        self.relay.flush()
        return self

    def recorded(self, kind, who):
        events = (e for e in self.bench.journal.recent if (e["kind"], e["source"]) == (kind, who))
        return b"".join(bytes.fromhex(event["data"]) for event in events)


chunks = st.lists(st.tuples(st.booleans(), st.binary(min_size=1, max_size=40)), max_size=20)


@given(chunks)
def test_every_byte_passes_as_it_came(talk):
    between = Between()
    for by_client, data in talk:
        (between.client if by_client else between.server).write(data)
    between.run()
    said = {who: b"".join(data for by_client, data in talk if by_client == (who == CLIENT)) for who in (CLIENT, SERVER)}
    assert between.got == {SERVER: said[CLIENT], CLIENT: said[SERVER]}
    assert {who: between.recorded("tx", who) for who in said} == said
    assert {who: b"".join(data for one, data in between.heard if one == who) for who in said} == said


def test_it_is_a_link_as_others_are():
    def make():
        between = Between(baud=115_200)
        return LinkUnderTest(scheduler=between.bench.scheduler, a=between.client, b=between.server, baud=115_200)

    check_link(make, hangs_up=False)  # that ends at the relay: it stands between two lines


@pytest.mark.parametrize("who", [CLIENT, SERVER])
def test_a_relay_that_loses_a_byte_is_none(who, monkeypatch):
    passed = Relay._pass

    def lossy(self, said_by, log, onward, data, at_ns):
        passed(self, said_by, log, onward, data[1:] if said_by == who else data, at_ns)

    monkeypatch.setattr(Relay, "_pass", lossy)
    with pytest.raises(AssertionError, match="0 of 256 bytes arrived"):
        test_it_is_a_link_as_others_are()


def corrupted(seed):
    between = Between(faults=FAULTS, seed=seed)
    for number in itertools.count():
        if number == 60:
            return between.run()
        between.client.write(bytes((number,)) * 10)
        between.server.write(bytes((255 - number,)) * 10)
        between.bench.run_for(0.01)
    return None


def test_seeded_faults_are_the_same_every_time():
    one, same, other = corrupted(7), corrupted(7), corrupted(8)
    assert one.got == same.got
    assert list(one.bench.journal.recent) == list(same.bench.journal.recent)
    assert one.got != other.got
    assert one.relay.faults.evidence()


def test_the_journal_has_what_was_said_and_what_was_got():
    between = corrupted(7)
    assert between.recorded("tx", CLIENT) == b"".join(bytes((number,)) * 10 for number in range(60))
    assert between.recorded("rx", SERVER) == between.got[SERVER]
    assert between.recorded("rx", CLIENT) == between.got[CLIENT]
    assert {event["towards"] for event in between.bench.journal.recent if event["kind"] == "fault"} >= {"a", "b"}


def test_what_was_said_stands_before_what_was_got_of_it():
    between = corrupted(7)
    said, got = ([0, 0], [0, 0])
    for event in between.bench.journal.recent:
        if event["kind"] in ("tx", "rx"):
            by = (event["source"] == CLIENT) == (event["kind"] == "tx")
            (said if event["kind"] == "tx" else got)[by] += len(event["data"]) // 2
            # of the bytes on the way to the client five are noise
            assert got[by] <= said[by] + 5 * (not by)


@given(st.lists(st.sampled_from([CLIENT, SERVER, "break"]), max_size=12))
def test_the_journal_has_things_in_their_order_however_close_they_are(steps):
    between, wanted = Between(), []
    for number, step in enumerate(steps):
        at_ms = number
        if step == "break":
            between.client.send_break(NS_PER_MS // 4)
            wanted.append(("break", CLIENT))
        else:
            (between.client if step == CLIENT else between.server).write(bytes((number,)))
            if wanted[-1:] != [("tx", step)]:
                wanted.append(("tx", step))
        between.bench.run_for((at_ms + 1) / 1000 - between.bench.now_s)
    between.run()
    happened = []
    for event in between.bench.journal.recent:
        one = event["kind"], event["source"]
        if one[0] == "break" or (one[0] == "tx" and happened[-1:] != [one]):  # a long word is in several events
            happened.append(one)
    assert happened == wanted


def test_what_an_end_does_not_take_is_recorded_and_said_once():
    between, said = Between(), []
    between.relay.on_refused = said.append
    for lost in (0, 7, 0, 5):
        between.relay._a.counters.lost += lost
        between.relay.tell_losses()
    assert losses(between) == [(CLIENT, 7), (CLIENT, 5)]
    assert said == ["client: does not take all that comes; what it leaves is lost"]


def losses(between):
    return [(e["source"], e["bytes"]) for e in between.bench.journal.recent if e["kind"] == "lost"]


@each("faults", [(), FAULTS])
def test_what_comes_while_nobody_is_there_is_no_loss_to_speak_of(faults):
    """Nor of whoever comes before that is looked at."""
    between, said = Between(faults=faults), []
    between.relay.on_refused = said.append
    for end in (between.relay._a, between.relay._b):
        end._set_line(False, 0)
        end.counters.lost += 7
        between.relay.tell_losses()
        end.counters.lost += 7
        end._set_line(True, 0)
        between.relay.tell_losses()
    assert not said
    assert not losses(between)


def test_a_line_that_a_fault_has_interrupted_has_still_lost_what_was_lost_before():
    fault = FaultEntry(kind="disconnect", at_s=0.01, duration_s=0.02)
    between = Between(faults=(fault,))
    between.bench.run_for(0.02)
    between.relay._b.counters.lost += 7
    between.bench.run_for(0.02)
    between.relay.tell_losses()
    assert losses(between) == [(SERVER, 7)]


def test_what_an_end_has_not_taken_is_recorded_when_it_goes_and_when_all_is_over():
    between, said = Between(), []
    between.relay.on_refused = said.append
    between.relay._a.counters.lost += 7
    between.relay._a._set_line(False, 0)
    between.relay._b.counters.lost += 5
    between.relay.finish()
    assert losses(between) == [(CLIENT, 7), (SERVER, 5)]
    assert said == ["server: does not take all that comes; what it leaves is lost"]


def test_breaks_are_handed_on_and_no_bytes_are_recorded_unasked():
    between = Between(record=False)
    breaks = []
    between.client.on_break = lambda at_ns: breaks.append("client")
    between.server.on_break = lambda at_ns: breaks.append("server")
    between.client.send_break(NS_PER_MS)
    between.server.send_break(NS_PER_MS)
    between.client.write(b"x")
    between.run()
    assert sorted(breaks) == ["client", "server"]
    assert between.got[SERVER] == b"x"
    assert [(event["kind"], event["source"]) for event in between.bench.journal.recent] == [
        ("break", CLIENT),
        ("break", SERVER),
    ]


@pytest.mark.parametrize("bench_name", ["rover-model", pytest.param("rover", marks=EMULATED)])
def test_a_station_and_a_rover_notice_nothing(bench_name):
    """The emulated one runs the rover's firmware."""
    bench = Bench(Scheduler(), Journal())
    near = open_near_end(bench, open_bench(bench_name), real_time=False)
    line = MemoryLink(bench.scheduler, Line(baud=near.port.baud))
    passed = {CLIENT: bytearray(), SERVER: bytearray()}
    Relay(bench, line.b, near.port, record=False, heard=lambda who, data, at_ns: passed[who].extend(data))
    got, sent = bytearray(), bytearray()
    station = GroundStation(bench, line.a)
    take = line.a.on_receive

    def received(data, at_ns):
        got.extend(data)
        take(data, at_ns)

    line.a.on_receive, line.a.on_sent = received, lambda data, at_ns: sent.extend(data)
    station.connect()
    bench.run_for(2.5)
    assert station.state is ClientState.LINKED
    near.port.on_receive = lambda data, at_ns: None
    bench.run_for(0.1)
    assert passed[CLIENT] == sent
    assert passed[SERVER] == got
    assert len(got) > 200
    near.close()


def test_a_rate_that_the_server_does_not_take_is_recorded_once_and_the_bytes_pass():
    bench = Bench(Scheduler(), Journal())
    line, far = MemoryLink(bench.scheduler, Line(baud=9600)), MemoryLink(bench.scheduler, Line(baud=0))

    class Client(type(line.b), Door):
        client_baud = 2**32 - 1

    class Server(type(far.a)):
        @property
        def baud(self):
            return 9600

        @baud.setter
        def baud(self, baud):
            if baud != 19_200:
                raise UnavailableError(f"cannot be set to {baud} baud", where="it")
            taken.append(baud)

    taken, got = [], bytearray()
    client, server = line.b, far.a
    client.__class__, server.__class__ = Client, Server
    Client.__abstractmethods__ = frozenset()
    far.b.on_receive = lambda data, at_ns: got.extend(data)
    said = []
    Relay(bench, client, server).on_refused = said.append
    for _ in range(3):
        line.a.write(b"x")
        bench.run_for(0.1)
    client.client_baud = 19_200
    line.a.write(b"y")
    bench.run_for(0.1)
    assert (bytes(got), taken) == (b"xxxy", [19_200])
    rates = [(e["kind"], e["baud"]) for e in bench.journal.recent if e["kind"].startswith("baud")]
    assert rates == [("baud-refused", 2**32 - 1), ("baud", 19_200)]
    assert said == [f"client: it: cannot be set to {2**32 - 1} baud; it keeps its own rate"]


def test_what_is_refused_late_is_said_once_of_whoever_asked_for_it():
    bench = Bench(Scheduler(), Journal())
    line, far = MemoryLink(bench.scheduler, Line(baud=9600)), MemoryLink(bench.scheduler, Line(baud=0))

    class Client(type(line.b), Door):
        client_baud = 19_200

    class Server(type(far.a)):
        baud = property(lambda self: 9600, lambda self, baud: self.refuse_rate(baud))

        def refuse_rate(self, baud):
            later(lambda: self.on_refused(baud, UnavailableError(f"cannot be set to {baud} baud", where="it")))

        def send_break(self, duration_ns, refused):
            later(lambda: refused(UnavailableError("a break cannot be sent", where="it")))

    def later(action):
        bench.scheduler.after(1000, action, source="it")

    client, server, said = line.b, far.a, []
    client.__class__, server.__class__ = Client, Server
    Client.__abstractmethods__ = frozenset()
    Relay(bench, client, server).on_refused = said.append
    for _ in range(3):
        line.a.write(b"x")
        line.a.send_break(NS_PER_MS)
        bench.run_for(0.1)
    assert said == [
        "client: it: cannot be set to 19200 baud; it keeps its own rate",
        "client: it: a break cannot be sent",
    ]
    refused = [(e["kind"], e["source"]) for e in bench.journal.recent if e["kind"].endswith("refused")]
    assert refused == [("baud-refused", CLIENT), ("break-refused", CLIENT)]
    server._set_line(False, 0)
    server._set_line(True, 0)  # it may be another, or may have been on its way out
    line.a.write(b"x")
    bench.run_for(0.1)
    assert len([e for e in bench.journal.recent if e["kind"] == "baud-refused"]) == 2


@each("has_lines", [True, False])
def test_lines_and_breaks_of_a_client_reach_a_server_that_has_such(has_lines):
    bench = Bench(Scheduler(), Journal())
    line, far = MemoryLink(bench.scheduler, Line(baud=0)), MemoryLink(bench.scheduler, Line(baud=0))

    class Client(type(line.b), Door):
        client_baud = 0

    Client.__abstractmethods__ = frozenset()
    client, server, done = line.b, far.a, []
    client.__class__ = Client
    server.send_break = lambda duration_ns, _refused: done.append(duration_ns)
    if has_lines:
        server.set_lines = lambda **levels: done.append(levels)
    Relay(bench, client, server)
    client.on_lines(None, False, 0)
    client.break_ns = 250 * NS_PER_MS
    client.on_break(0)
    client.break_ns = 0
    client.on_break(0)
    levels = [{"dtr": None, "rts": False}] if has_lines else []
    assert done == [*levels, 250 * NS_PER_MS, NS_PER_MS]
    assert [{**event} for event in bench.journal.recent] == [
        {"ns": 0, "kind": "lines", "source": CLIENT, "dtr": None, "rts": False, "taken": has_lines},
        {"ns": 0, "kind": "break", "source": CLIENT, "duration_ns": 250 * NS_PER_MS},
        {"ns": 0, "kind": "break", "source": CLIENT, "duration_ns": None},
    ]


def refuse_break(_duration_ns, _refused):
    raise UnavailableError("a break cannot be sent: a socket knows none", where="it")


def test_breaks_that_an_end_does_not_know_are_said_once_for_each():
    between, said = Between(to_client=refuse_break), []
    between.relay.on_refused = said.append
    for _ in range(2):
        between.server.send_break(NS_PER_MS)
    between.client.send_break(NS_PER_MS)
    between.run()
    recorded = [(event["kind"], event["source"]) for event in between.bench.journal.recent]
    assert sorted(recorded) == [("break", CLIENT), ("break", SERVER), ("break", SERVER), ("break-refused", SERVER)]
    assert said == ["server: it: a break cannot be sent: a socket knows none"]


@each("late", [False, True])
def test_a_fault_that_cannot_strike_has_not_struck(late):
    def refuse_late(_duration_ns, refused):
        error = UnavailableError("a break cannot be sent: a socket knows none", where="it")
        between.bench.scheduler.after(0, lambda: refused(error), source="it")

    fault = FaultEntry(kind="break", at_s=0.5, duration_s=0.1, towards="b")
    between, said = Between(faults=(fault,), to_server=refuse_late if late else refuse_break), []
    between.relay.on_refused = said.append
    between.run()
    assert [event["kind"] for event in between.bench.journal.recent] == [*["fault"] * late, "fault-refused"]
    (line,) = said
    assert line.endswith("did not strike: it: a break cannot be sent: a socket knows none")
    assert between.relay.faults.evidence() == [f"    0.5000 s  {line}"]


def test_lines_of_a_server_that_is_gone_are_not_taken_and_no_more():
    bench = Bench(Scheduler(), Journal())
    line, far = MemoryLink(bench.scheduler, Line(baud=0)), MemoryLink(bench.scheduler, Line(baud=0))

    def gone(**_levels):
        raise UnavailableError("it is gone", where="it")

    far.a.set_lines = gone
    relay = Relay(bench, line.b, far.a)
    relay._lines_set(True, None, 0)
    assert [event["taken"] for event in bench.journal.recent] == [False]
