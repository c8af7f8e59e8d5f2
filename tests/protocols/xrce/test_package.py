"""The package exports what it says, needs nothing but the standard library, and does what its page shows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from protocols import xrce
from protocols.xrce import cdr
from tests.protocols.clauses import check_package

PAGE = Path(__file__).parents[3] / "docs" / "xrce" / "index.md"


def test_package():
    check_package(xrce)
    check_package(cdr)


def _snippets():
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def test_the_agent_in_the_docs_answers_a_ping():
    _, text, _ = _snippets()
    client = xrce.Session(xrce.Role.CLIENT, xrce.ClientOptions(client_key=b"\1\2\3\4"))
    written = []

    class Port:
        def write(self, data):
            written.extend(client.receive(data, 0))

    names = {"AgentService": xrce.AgentService, "came": client.ping(0), "now_ns": lambda: 0, "ports": {"board": Port()}}
    exec(text, names)  # the documentation's own code
    assert written == [xrce.Pong(in_session=False)]


def test_the_server_of_an_action_in_the_docs_says_what_it_says():
    *_, text = _snippets()
    agent = xrce.AgentService(("board",))
    names = {"Library": cdr.Library, "came": b"", "now_ns": lambda: 0, "agent": agent}
    exec(
        text, {**names, "ActionServer": xrce.ActionServer, "GoalState": xrce.GoalState}
    )  # the documentation's own code
    parts = {xrce.ros_name(name).part for _, name in agent.space.topics}
    assert parts == {*xrce.ACTION_PARTS}


def test_the_client_in_the_docs_finds_an_agent_and_says_how_fast_it_is():
    """The snippet is a loop for ever; here its names are filled in so that it ends when it has spoken."""
    text, _, _ = _snippets()
    agent, events = xrce.Session(xrce.Role.AGENT), []

    class ExampleOver(Exception):  # noqa: N818 - not an error
        pass

    class Port:
        def write(self, data):
            events.extend(agent.receive(data, 0))

        def read(self):
            if any(isinstance(event, xrce.Received) for event in events):
                raise ExampleOver
            return b"".join(event.data for event in events if isinstance(event, xrce.Transmit))

    with pytest.raises(ExampleOver):
        exec(text, {"port": Port(), "now_ns": lambda: 0})  # the documentation's own code
    (received,) = (event for event in events if isinstance(event, xrce.Received))
    assert received.submessage == xrce.WriteData(request_id=10, object_id=0x15, data=bytes.fromhex("0000A040"))
