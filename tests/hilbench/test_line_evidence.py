"""What a report shows of a line: what passed last, both ways, in the order of time, with what it says."""

from __future__ import annotations

import pytest

from hilbench.bench import Bench
from hilbench.bench.protocol_peer import RAW, ProtocolPeer
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.plugins.discovery import PLUGINS
from tests.each import each

LED_OFF, REQUEST = bytes.fromhex("504B54210102C1B20A"), bytes.fromhex("504B54210100E1F00A")
REPORT = bytes.fromhex("504B542106800F0001000088F90A")
TWISTED = bytes.fromhex("504B542106800F00010000F9880A")


class Rig:
    """A checker's end of a line, and the far end of it."""

    def __init__(self, protocol):
        self.scheduler = Scheduler()
        link = MemoryLink(self.scheduler, Line(baud=115200), name="line")
        self.far = link.b
        self.peer = ProtocolPeer(Bench(self.scheduler, Journal()), link.a, protocol)

    def hear(self, data):
        self.far.write(data)
        self.peer.run(0.1)


@pytest.fixture
def rig():
    return Rig(PLUGINS.get("pkt", "test"))


def test_both_directions_stand_in_the_order_of_time(rig):
    rig.peer.write(LED_OFF)
    rig.hear(REPORT)
    rig.peer.write(REQUEST)
    asked, told, asked_again = rig.peer.evidence()
    assert asked.endswith("0.0000 s  >  LED_OFF  [50 4B 54 21 01 02 C1 B2 0A]")
    assert " s  <  GeneralReport accepted=15 rejected=0 last_opcode=1 " in told
    assert told.endswith(f"[{REPORT.hex(' ').upper()}]")
    assert asked_again.lstrip().startswith("0.1000 s  >  REQUEST_TMY")


def test_what_is_written_again_and_again_is_one_line(rig):
    for _ in range(20):
        rig.peer.write(REQUEST)
        rig.peer.run(0.5)
    assert [line.strip() for line in rig.peer.evidence()] == [
        "9.5000 s  >  REQUEST_TMY  [50 4B 54 21 01 00 E1 F0 0A], 20 times since 0.0000 s",
        "10.0000 s  nothing received",
    ]


def test_what_is_refused_stands_where_it_came(rig):
    rig.hear(TWISTED)
    rig.hear(REPORT)
    refused, _end_of_line, told = rig.peer.evidence()
    assert " s  <  dropped (wrong CRC)  50 4B 54 21" in refused
    assert refused.endswith("the bytes of its checksum are swapped")
    assert "GeneralReport" in told


def test_only_what_came_since_a_mark_but_what_was_sent_before(rig):
    rig.hear(REPORT)
    rig.peer.write(LED_OFF)
    rig.peer.run(0.75)
    (sent, nothing) = rig.peer.evidence(rig.peer.mark())
    assert "LED_OFF" in sent
    assert nothing.endswith("0.8500 s  no frame received since 0.0012 s; nothing received for 0.8 s")


def test_the_last_of_many(rig):
    for number in range(30):
        rig.peer.write(bytes([number]))
        rig.hear(REPORT)
    lines = rig.peer.evidence()
    assert [line.split()[2] for line in lines] == ["<", "<", *"><><><><"]


def test_bytes_without_a_frame_are_counted(rig):
    rig.hear(REPORT[:5])
    assert rig.peer.evidence()[-1].endswith("0.1000 s  no frame received (5 bytes in all)")


def test_settling_forgets_what_was_sent(rig):
    rig.peer.write(LED_OFF)
    rig.peer.forget()
    assert rig.peer.evidence() == ["    0.0000 s  nothing received"]


@each("data, words", [
    (b"\x01\x02", "01 02"),
    (bytes(64), "00 " * 63 + "00"),
    (bytes(65), "00 " * 63 + "00 ... (65 bytes)"),
])  # fmt: skip
def test_bytes_that_are_no_frame_are_bytes(data, words):
    for protocol in (RAW, PLUGINS.get("pkt", "test")):
        rig = Rig(protocol)
        rig.peer.write(data)
        assert rig.peer.evidence()[0].endswith(f">  {words}")


def test_a_long_report_is_cut_and_its_bytes_are_whole():
    rig = Rig(PLUGINS.get("p2os", "test"))
    sip = bytes.fromhex("FAFB24328010000000000000000082000000000200000302007D03007D04007D050080FFFF4609")
    rig.hear(sip)
    (line,) = rig.peer.evidence()
    assert "…  [FA FB 24 32 80 10" in line
    assert line.endswith("46 09]")


def test_a_frame_is_called_what_it_is_behind_those_before_it():
    rig = Rig(PLUGINS.get("p2os", "test"))
    frames = {"SYNC0": "FAFB03000000", "SYNC1": "FAFB03010001", "SYNC2": "FAFB03020002", "OPEN": "FAFB03010001"}
    for frame in (*frames.values(), frames["SYNC0"]):
        rig.peer.write(bytes.fromhex(frame))
        rig.peer.run(0.1)
    names = [line.split(" >  ")[1].split()[0] for line in rig.peer.evidence() if " >  " in line]
    assert names == ["SYNC1", "SYNC2", "OPEN", "PULSE"]


def test_pieces_of_a_frame_are_bytes(rig):
    for piece in (LED_OFF[:4], LED_OFF[4:]):
        rig.peer.write(piece)
    first, last, _nothing = rig.peer.evidence()
    assert first.endswith(">  50 4B 54 21")
    assert last.endswith(">  01 02 C1 B2 0A")
