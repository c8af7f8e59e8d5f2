"""Both ends of the stand-in link: who is there, what is refused, what is counted."""

from __future__ import annotations

import pytest

from protocols.autoware import (
    AGENT_TABLE,
    BOARD_TABLE,
    AckermannControlCommand,
    AgentAbsent,
    AgentFound,
    AgentOnline,
    AgentOptions,
    AgentPing,
    AgentState,
    BoardFound,
    BoardLost,
    BoardOptions,
    BoardState,
    Connection,
    ControlModeReport,
    ControlModeRequest,
    DropReason,
    FrameDropped,
    LocalProtocolError,
    LossReason,
    MessageReceived,
    Role,
    StateChanged,
    Transmit,
    UnknownMessage,
    encode_frame,
    encode_message,
)
from tests.each import each

SECOND = 1_000_000_000


def frame(message):
    return encode_frame(encode_message(message))


ONLINE = frame(AgentOnline())
PING = frame(AgentPing())
REPORT = frame(ControlModeReport(mode=4))


def without_changes(events):
    return [event for event in events if not isinstance(event, StateChanged)]


def test_a_board_asks_at_once_and_twenty_times_and_gives_up_after_twenty_seconds():
    board = Connection(Role.BOARD, epoch_ns=5 * SECOND)
    seen = []
    while (deadline_ns := board.next_deadline_ns()) is not None:
        seen += [(deadline_ns - 5 * SECOND, event) for event in without_changes(board.advance(deadline_ns))]
    assert [(at_ns, event.data) for at_ns, event in seen[:-1]] == [(n * SECOND, PING) for n in range(20)]
    assert seen[-1] == (20 * SECOND, AgentAbsent())
    assert board.state is BoardState.ABSENT


@each(("reconnects", "expected"), [(True, [AgentFound()]), (False, [])])
def test_an_agent_that_comes_late_is_taken_if_the_options_say_so(reconnects, expected):
    board = Connection(Role.BOARD, BoardOptions(reconnects=reconnects))
    board.advance(20 * SECOND)
    assert without_changes(board.receive(ONLINE, 21 * SECOND)) == expected
    assert (board.state is BoardState.ONLINE) is reconnects


def test_an_answer_ends_the_asking():
    board = Connection(Role.BOARD, BoardOptions(reconnects=False))
    board.advance(0)
    assert without_changes(board.receive(ONLINE, SECOND - 1)) == [AgentFound()]
    assert board.next_deadline_ns() is None
    assert board.receive(ONLINE, 2 * SECOND) == []
    assert board.counters.pings == 1


def test_an_answer_in_the_same_nanosecond_as_the_end_is_too_late():
    board = Connection(Role.BOARD, BoardOptions(pings=1, reconnects=False))
    assert without_changes(board.receive(ONLINE, SECOND)) == [Transmit(data=PING), AgentAbsent()]


def test_an_agent_says_that_it_is_there_and_answers_each_ping():
    agent = Connection(Role.AGENT)
    assert without_changes(agent.connect(0)) == [Transmit(data=ONLINE)]
    assert without_changes(agent.receive(PING, 1)) == [BoardFound(), Transmit(data=ONLINE)]
    assert without_changes(agent.receive(PING, 2)) == [Transmit(data=ONLINE)]
    assert agent.counters.pings == 2


def test_an_agent_notices_a_silent_board_and_its_return():
    agent = Connection(Role.AGENT)
    agent.connect(0)
    received = MessageReceived(message=ControlModeReport(mode=4))
    assert without_changes(agent.receive(REPORT, 0)) == [BoardFound(), received]
    assert without_changes(agent.receive(REPORT, SECOND // 2)) == [received]
    assert agent.next_deadline_ns() == SECOND + SECOND // 2
    assert without_changes(agent.advance(2 * SECOND)) == [BoardLost(reason=LossReason.SILENCE)]
    assert agent.state is AgentState.ALONE
    assert without_changes(agent.receive(REPORT, 3 * SECOND)) == [BoardFound(), received]
    assert agent.counters.silences == 1


def test_garbage_does_not_keep_a_board_alive():
    agent = Connection(Role.AGENT)
    agent.connect(0)
    agent.receive(REPORT, 0)
    assert [event.reason for event in agent.receive(REPORT[:-1] + b"\0", 1)] == [DropReason.BAD_CRC]
    assert agent.next_deadline_ns() == SECOND


def test_without_a_time_of_silence_a_board_is_never_lost():
    agent = Connection(Role.AGENT, AgentOptions(silence_s=None))
    agent.connect(0)
    agent.receive(REPORT, 0)
    assert agent.next_deadline_ns() is None


def test_the_line_goes_down():
    agent = Connection(Role.AGENT)
    agent.connect(0)
    agent.receive(REPORT + REPORT[:5], 0)
    assert without_changes(agent.line_down(1)) == [
        FrameDropped(reason=DropReason.CUT_SHORT, data=REPORT[:5]),
        BoardLost(reason=LossReason.LINE_DOWN),
    ]
    assert agent.state is AgentState.CLOSED
    agent.connect(2)
    board = Connection(Role.BOARD)
    board.advance(0)
    assert board.line_down(1) == []


def test_messages_are_taken_and_sent_before_anybody_was_found():
    board = Connection(Role.BOARD)
    command = AckermannControlCommand(speed=5.0)
    assert board.receive(frame(command), 0)[-1] == MessageReceived(message=command)
    assert board.send(ControlModeReport(mode=4), 0) == REPORT


def test_each_end_sends_its_own_messages_alone():
    with pytest.raises(LocalProtocolError, match="not for the agent"):
        Connection(Role.AGENT).send(ControlModeReport(), 0)
    board = Connection(Role.BOARD)
    with pytest.raises(LocalProtocolError, match="not for the board"):
        board.send(ControlModeRequest(mode=1), 0)
    assert board.counters.frames_out == 0
    assert board.send(UnknownMessage(id=0x7F), 0) == encode_frame(b"\x7f")


def test_misuse_is_refused_and_changes_nothing():
    with pytest.raises(LocalProtocolError, match="not the options of the agent"):
        Connection(Role.AGENT, BoardOptions())
    with pytest.raises(LocalProtocolError, match="cannot connect"):
        Connection(Role.BOARD).connect(0)
    agent = Connection(Role.AGENT)
    with pytest.raises(LocalProtocolError, match="cannot disconnect"):
        agent.disconnect(0)
    agent.connect(0)
    with pytest.raises(LocalProtocolError, match="cannot connect"):
        agent.connect(0)
    agent.disconnect(1)
    for options, wrong in ((BoardOptions, "ping_s"), (BoardOptions, "pings"), (AgentOptions, "silence_s")):
        with pytest.raises(LocalProtocolError, match=wrong):
            options(**{wrong: 0})


def test_what_is_received_is_counted():
    agent = Connection(Role.AGENT)
    agent.connect(0)
    data = b"\x00" + REPORT + encode_frame(b"\x7f") + encode_frame(b"\x83") + REPORT[:-1] + b"\0" + b"\x7e\0" + REPORT
    agent.receive(data + b"\x7e\0\1" + b"\x7e\0\0\xff\xff", 0)
    counters = agent.counters
    assert counters.bytes_in == len(data) + 8
    assert (counters.frames_in, counters.frames_out) == (4, 1)
    assert (counters.noise, counters.cut_short, counters.not_for_us) == (1, 1, 1)
    assert (counters.bad_lengths, counters.bad_crcs, counters.bad_bodies, counters.unknown) == (1, 1, 1, 1)


def test_every_edge_of_both_tables_is_taken():
    agent, board = Connection(Role.AGENT), Connection(Role.BOARD)
    agent.connect(0)
    agent.disconnect(0)
    agent.connect(0)
    agent.line_down(0)
    agent.connect(0)
    for data in (PING, PING, REPORT):
        agent.receive(data, 0)
    agent.disconnect(0)
    agent.connect(0)
    agent.receive(REPORT, 0)
    agent.line_down(0)
    agent.connect(0)
    agent.receive(REPORT, 0)
    agent.advance(SECOND)
    assert set(agent.visits) == set(AGENT_TABLE)
    board.advance(20 * SECOND)
    board.receive(ONLINE, 20 * SECOND)
    other = Connection(Role.BOARD)
    other.receive(ONLINE, 0)
    assert set(board.visits) | set(other.visits) == set(BOARD_TABLE)


def test_another_table_can_be_put_in():
    table = {edge: way for edge, way in BOARD_TABLE.items() if edge[0] is not BoardState.ABSENT}
    board = Connection(Role.BOARD, table=table)
    board.advance(20 * SECOND)
    assert board.receive(ONLINE, 20 * SECOND) == []
    assert board.counters.ignored == 1
