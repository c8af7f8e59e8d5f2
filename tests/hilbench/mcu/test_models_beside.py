"""Models without a body at the USARTs of emulated boards: an agent of DDS-XRCE, and others."""

from __future__ import annotations

import pytest

from hilbench.errors import UsageError
from tests.protocols.xrce.recorded_client import SESSION

PING, OPEN = (exchange for exchange in SESSION[:2])
AGENT = '[targets.agent]\nmodel = "xrce-agent"\n'
LINK = '[[links]]\nends = ["agent.{}", "{}.usart2"]\nbaud = 115200\n'
MS = 1_000_000


def client(heard, *frames, baud=115_200):
    """A program that sends frames, 50 ms apart, and keeps what comes."""

    def program(machine):
        machine.usart("USART2", baud, on_byte=heard.append)
        for number, frame in enumerate(frames):
            machine.at_ns((1 + 50 * number) * MS, lambda frame=frame: machine.send_all("USART2", bytes.fromhex(frame)))

    return program


def test_an_agent_answers_the_board_at_each_of_its_lines(emulate):
    one, other = bytearray(), bytearray()
    more = AGENT + LINK.format("line1", "brain") + LINK.format("line3", "other")
    emulated = emulate(client(one, PING.said, OPEN.said), client(other, OPEN.said), more=more)
    emulated.bench.run_for(0.1)
    assert one.hex() == PING.answer + OPEN.answer
    assert other.hex() == OPEN.answer


def test_the_agent_has_tables_of_who_is_there(emulate):
    emulated = emulate(client(bytearray(), PING.said, OPEN.said), more=AGENT + LINK.format("line3", "brain"))
    emulated.bench.run_for(0.1)
    assert [*emulated.bench.tables["agent"]()["clients"].rows] == ["line3"]


def test_what_the_agent_reports_is_in_the_journal(emulate, tmp_path):
    more = AGENT + LINK.format("line1", "brain")
    file = tmp_path / "run.jsonl"
    emulated = emulate(client(bytearray(), OPEN.said), more=more, journal=file)
    emulated.bench.run_for(0.1)
    emulated.close()
    assert '"SessionOpened"' in file.read_text()


def test_a_run_is_the_same_every_time(emulate):
    """Its clock begins at 0: that of the host is none of its."""

    def run():
        heard = bytearray()
        asked = "7e00000c0081000000030104000002fffecf5c"
        emulate(client(heard, OPEN.said, asked), more=AGENT + LINK.format("line1", "brain")).bench.run_for(0.2)
        return bytes(heard)

    assert run() == run()


def test_the_device_of_a_protocol_answers(emulate):
    """XRCE's own device is an agent with one line."""
    heard = bytearray()
    more = '[targets.agent]\nmodel = "xrce"\n' + LINK.format("host", "brain")
    emulate(client(heard, PING.said), more=more).bench.run_for(0.1)
    assert heard.hex() == PING.answer


def test_a_line_of_a_model_that_leads_to_the_checker_is_open(emulate):
    """Also where none of its lines leads to a board; one that leads nowhere is not."""
    more = AGENT + '[[links]]\nends = ["peer.pc", "agent.line2"]\n'
    emulated = emulate(client(bytearray()), more=more)
    ((name, link),) = emulated.surroundings.open_lines.items()
    heard = bytearray()
    link.a.on_receive = lambda data, _at_ns: heard.extend(data)
    link.a.write(bytes.fromhex(PING.said))
    emulated.bench.run_for(0.1)
    assert (name, heard.hex()) == ("agent.line2", PING.answer)


def test_the_line_of_the_device_of_a_protocol_is_open(emulate):
    more = '[targets.agent]\nmodel = "xrce"\n[[links]]\nends = ["peer.pc", "agent.host"]\n'
    emulated = emulate(client(bytearray()), more=more)
    assert [*emulated.surroundings.open_lines] == ["agent.host"]


def test_a_line_of_what_only_the_checker_is_is_refused(emulate):
    more = '[targets.car]\nmodel = "car-host"\n[[links]]\nends = ["peer.pc", "car.board"]\n'
    with pytest.raises(UsageError, match="is what the checker is"):
        emulate(client(bytearray()), more=more)


def test_what_only_the_checker_is_is_refused(emulate):
    more = '[targets.car]\nmodel = "car-host"\n[[links]]\nends = ["car.board", "brain.usart2"]\n'
    with pytest.raises(UsageError, match="what the checker is"):
        emulate(client(bytearray()), more=more)
