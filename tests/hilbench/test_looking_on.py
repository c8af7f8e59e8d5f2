"""What a report shows of the moment after a case failed: what was late, or came behind something else."""

from __future__ import annotations

from types import SimpleNamespace

from hilbench.bench import Bench
from hilbench.bench.looking_on import LOOK_ON_S, look_on
from hilbench.bench.protocol_peer import ProtocolPeer
from hilbench.clock import NS_PER_S, Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.plugins.discovery import PLUGINS
from hilbench.systems.pioneer.peer import Peer
from hilbench.systems.rover.peer import RoverPeer
from hilbench.systems.vehicle.simulator_peer import BoardPeer
from hilbench.systems.vehicle.stack_peer import StackPeer
from protocols.pkt import PROFILES, longest_frame

REQUEST = bytes.fromhex("504B54210100E1F00A")
REPORT = bytes.fromhex("504B542106800F0001000088F90A")
ANOTHER = bytes.fromhex("504B542106800300050000DF120A")
TWISTED = bytes.fromhex("504B542106800F00010000F9880A")


class Asking(ProtocolPeer):
    def ask_again(self):
        self.write(REQUEST)

    def stand_still(self):
        self.write(b"stop")


class Rig:
    """A checker's end of a line, and the far end of it, which writes at times of its own."""

    def __init__(self):
        self.scheduler = Scheduler()
        self.link = MemoryLink(self.scheduler, Line(baud=115200), name="line")
        self.bench = Bench(self.scheduler, Journal())
        self.peer = Asking(self.bench, self.link.a, PLUGINS.get("pkt", "test"))

    def later(self, after_s, data):
        self.scheduler.after(round(after_s * NS_PER_S), lambda: self.link.b.write(data))

    def look_on(self):
        return [line.strip() for line in look_on(self.bench, {"line": self.peer})]


def test_what_comes_late_is_shown_at_its_time():
    rig = Rig()
    rig.later(1.0, REPORT)
    title, asked, late = rig.look_on()
    assert title == "looked on for 1.2 s:"
    assert asked.startswith("0.4000 s  >  REQUEST_TMY")
    assert late.startswith("1.0012 s  <  GeneralReport accepted=15")
    assert rig.bench.now_ns == LOOK_ON_S * NS_PER_S


def test_what_was_said_before_is_no_news_and_of_a_kind_the_first_and_the_last_are_enough():
    rig = Rig()
    rig.later(0.0, REPORT)
    rig.bench.run_for(0.1)
    for number, report in enumerate((REPORT, ANOTHER, REPORT, ANOTHER)):
        rig.later(0.1 + 0.1 * number, report)
    rig.later(0.9, TWISTED)
    _title, first, asked, last, refused = rig.look_on()
    assert [line.split()[0] for line in (first, asked, last, refused)] == ["0.3012", "0.5000", "0.5012", "1.0011"]
    assert "accepted=3" in first
    assert "accepted=3" in last
    assert "wrong CRC" in refused


def test_silence_is_no_news():
    rig = Rig()
    rig.peer.ask_again = lambda: None
    assert rig.look_on() == ["looked on for 1.2 s: nothing new came"]


def test_a_line_that_goes_away_is_the_business_of_the_next_case():
    rig = Rig()
    rig.later(0.1, REPORT)
    rig.scheduler.at(NS_PER_S // 5, rig.link.hang_up)
    assert "accepted=15" in rig.look_on()[1]


def test_who_has_no_line_does_not_wait():
    rig = Rig()
    assert look_on(rig.bench, {}) == []
    assert rig.bench.now_ns == 0


def test_what_is_real_is_stopped_first():
    rig = Rig()
    locked = SimpleNamespace(scheduler=SimpleNamespace(locked=True), now_ns=0, run_for=rig.bench.run_for)
    assert look_on(locked, {"line": rig.peer})[1].strip() == "0.0000 s  >  73 74 6F 70"


def test_lines_are_named_where_there_are_several():
    rig, other = Rig(), Rig()
    rig.later(0.1, REPORT)
    lines = look_on(rig.bench, {"one": rig.peer, "other": other.peer})
    assert any("one       <  GeneralReport" in line for line in lines)


def test_of_what_is_refused_the_first_and_the_last_are_enough():
    rig = Rig()
    for number in range(7):
        rig.later(0.05 + 0.05 * number, TWISTED)
    rig.later(1.0, REPORT)
    lines = rig.look_on()
    assert sum("wrong CRC" in line for line in lines) == 1
    assert "accepted=15" in lines[-1]


def sent_to_stop(peer_of):
    """Return what a peer of a system writes to have a target stand still."""
    rig = Rig()
    peer = peer_of(rig.bench, MemoryLink(rig.scheduler, Line(baud=115200), name="other").a)
    peer.commands = SimpleNamespace(stop=lambda: setattr(peer, "stopped", True))
    written = []
    peer.write = written.append
    peer.stand_still()
    return b"".join(written), hasattr(peer, "stopped")


def test_a_rover_ends_its_frame_and_gets_a_stop_a_robot_a_stop_a_board_no_more_commands():
    profile = PROFILES["documented"]
    written, _ = sent_to_stop(lambda bench, port: RoverPeer(bench, port, profile))
    ended = longest_frame(profile.server.frames)
    assert written[:ended] == b"\n" * ended
    assert written[ended:] == bytes.fromhex("504B54210A03000000000000000003 60950A".replace(" ", ""))
    assert sent_to_stop(Peer)[0] == bytes.fromhex("FAFB031D001D")
    assert sent_to_stop(StackPeer) == (b"", True)
    assert sent_to_stop(BoardPeer) == (b"", True)
