"""The state tables: every edge is taken by some story, and one that is missing or leads elsewhere is noticed."""

from __future__ import annotations

from collections import Counter

from protocols import xrce
from protocols.xrce import AGENT_TABLE, CLIENT_TABLE, AgentState, ClientState, Role, Session, Status, Transition
from tests.protocols.xrce.conftest import KEY

SECOND = 1_000_000_000
CREATE = xrce.CreateClient(client=xrce.Client(client_key=KEY, session_id=0x81))
BAD_CREATE = xrce.CreateClient(client=xrce.Client(client_key=KEY, session_id=0x81, cookie=b"????"))
OTHER_CREATE = xrce.CreateClient(client=xrce.Client(client_key=KEY, session_id=0x82))
FAREWELL = xrce.Delete(request_id=2, object_id=xrce.OBJECT_CLIENT)
FAREWELL_ANSWERED = xrce.StatusReply(request_id=2, object_id=xrce.OBJECT_CLIENT, status=Status.OK)
PING = xrce.GetInfo(request_id=10, object_id=xrce.OBJECT_AGENT, info_mask=2)
PONG = xrce.Info(request_id=10, object_id=xrce.OBJECT_AGENT)
ACCEPTED = xrce.StatusAgent(status=Status.OK, agent=xrce.Agent())
REFUSED = xrce.StatusAgent(status=Status.RESOURCES, agent=xrce.Agent())
REQUEST = xrce.Delete(request_id=10, object_id=0x15)
ANSWER = xrce.StatusReply(request_id=10, object_id=0x15, status=Status.OK)
TIME = xrce.TimestampReply(transmit=xrce.Time(), receive=xrce.Time(), originate=xrce.Time())

CLIENT_STORIES = [
    [PONG, "connect", PONG, 1, ACCEPTED, PONG, TIME, REQUEST, 1, "reset", REQUEST, xrce.Reset(), REQUEST],
    ["connect", ACCEPTED, REQUEST, "disconnect", PONG, 1, FAREWELL_ANSWERED],
    ["connect", REFUSED],
    ["connect", 30],
    ["connect", "disconnect", 30],
    ["connect", "line_down"],
    ["connect", ACCEPTED, REQUEST, "line_down"],
    ["connect", ACCEPTED, "disconnect", "line_down"],
]
AGENT_STORIES = [
    [PING, BAD_CREATE, FAREWELL, CREATE, PING, BAD_CREATE, xrce.Timestamp(transmit=xrce.Time())],
    [CREATE, ANSWER, 1, CREATE, ANSWER, OTHER_CREATE, FAREWELL],
    [CREATE, ANSWER, "reset", ANSWER, xrce.Reset(), ANSWER, FAREWELL],
    [CREATE, 1, PING, 1, PING, ANSWER, 3],
    [CREATE, 3],
    [CREATE, ANSWER, "disconnect"],
    [CREATE, ANSWER, "line_down"],
]


def told(role, stories, table=None):
    """What happens in these stories, and which edges were taken."""
    happened, visits = [], Counter()
    for story in stories:
        options = xrce.AgentOptions(silence_s=2.0)
        if role is Role.CLIENT:
            options = xrce.ClientOptions(client_key=KEY)
        session, now_ns = Session(role, options, table=table), 0
        for step in story:
            now_ns += 1
            happened.append(
                (step_of(session, step, now_ns), session.state, session.unacknowledged, session.deadlines.copy())
            )
            now_ns += step * SECOND if isinstance(step, int) else 0
        visits += session.visits
    return happened, visits


def step_of(session, step, now_ns):
    """What one step brings: a call, so many seconds, a submessage of the program's own or of the other end."""
    try:
        if isinstance(step, str):
            return getattr(session, step)(now_ns)
        if isinstance(step, int):
            return session.advance(now_ns + step * SECOND)
        if step in (REQUEST, ANSWER):
            return session.send(step, now_ns)
    except xrce.LocalProtocolError as error:
        return str(error)
    outside = isinstance(step, xrce.CreateClient)
    header = xrce.Header(session_id=0x80 if outside else 0x81)
    return session.receive(xrce.encode_frame(xrce.encode_message(header, xrce.encode_submessage(step))), now_ns)


def each_table():
    yield Role.CLIENT, CLIENT_STORIES, CLIENT_TABLE, ClientState
    yield Role.AGENT, AGENT_STORIES, AGENT_TABLE, AgentState


def test_the_stories_take_every_edge():
    for role, stories, table, _ in each_table():
        _, visits = told(role, stories)
        assert set(visits) == set(table)


def test_a_missing_edge_one_that_leads_elsewhere_and_one_without_an_action_are_noticed():
    for role, stories, table, states in each_table():
        expected = told(role, stories)
        for cell, edge in table.items():
            others = [Transition(state, edge.actions) for state in states if state is not edge.next_state]
            fewer = [edge.actions[:at] + edge.actions[at + 1 :] for at in range(len(edge.actions))]
            others += [Transition(edge.next_state, actions) for actions in fewer]
            for mutant in (None, *others):
                changed = {key: value for key, value in table.items() if key != cell}
                changed |= {cell: mutant} if mutant else {}
                assert told(role, stories, changed) != expected, (cell, mutant)
