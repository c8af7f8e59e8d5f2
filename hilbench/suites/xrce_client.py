"""What a client of DDS-XRCE must do, with the checker as its agent: on the model, firmware, or a board at a port."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from hilbench.bench import to_ns
from hilbench.bench.protocol_peer import ProtocolPeer
from hilbench.check import NotApplicable, Untimely, Violation, case
from hilbench.suites._xrce_client import Agent, Heard
from protocols import xrce
from protocols.xrce import Status

AGAIN_S = 10.0
ANSWER_S = 0.2
HEARTBEAT_S = 1.0
SENT_AGAIN_S = 0.5
CREATED_S = 5.0
WINDOW = 16
RELIABLE = 0x80
PARENTS: dict[type[Any], tuple[str, ...]] = {
    xrce.Topic: ("participant_id",),
    xrce.Publisher: ("participant_id",),
    xrce.Subscriber: ("participant_id",),
    xrce.DataWriter: ("publisher_id",),
    xrce.DataReader: ("subscriber_id",),
    xrce.Requester: ("participant_id",),
    xrce.Replier: ("participant_id",),
}
OF_SESSION = (xrce.Create, xrce.WriteData, xrce.ReadData, xrce.Heartbeat, xrce.AckNack)


@pytest.fixture
def agent(peer: ProtocolPeer) -> Agent:
    """An agent that does all that it should."""
    return Agent(peer)


@case("XC01", bench_time_s=5.0)
def test_a_client_asks_for_a_session(agent: Agent) -> None:
    asked = agent.asked()
    client, header = asked.said.client, asked.header
    assert client.cookie == xrce.COOKIE
    assert client.version[0] == xrce.VERSION[0]
    assert any(client.client_key), "the key is all zeros"
    assert client.session_id not in (xrce.NO_SESSION, xrce.NO_SESSION_WITH_KEY), "the id is that of no session"
    assert client.mtu is None or client.mtu >= xrce.LEAST_MTU
    key = client.client_key if xrce.has_client_key(client.session_id) else None
    assert header == xrce.Header(session_id=client.session_id & 0x80, client_key=key), f"it came with {header}"
    before = agent.heard[: agent.heard.index(asked)]
    others = [one for one in before if one.header.session_id != client.session_id]
    assert all(isinstance(one.said, xrce.GetInfo) for one in others), "something else comes before it"


@case("XC02", bench_time_s=12.0)
def test_it_asks_until_it_is_answered(agent: Agent) -> None:
    agent.opens = False
    asked = agent.asked()
    mark = agent.mark()
    agent.serve(AGAIN_S)
    again = [one.said for one in agent.of(xrce.CreateClient, mark)]
    assert len(again) >= 2, f"CREATE_CLIENT comes {len(again)} times more in {AGAIN_S:g} s"
    assert {*again} == {asked.said}, "it is not the same"


@case("XC03", bench_time_s=5.0)
def test_a_refused_client_has_no_session(agent: Agent) -> None:
    agent.status = Status.DENIED
    asked = agent.asked()
    mark = agent.mark()
    agent.serve(3.0)
    said = _of_session(agent, mark, asked.said.client.session_id)
    assert not said, f"{type(said[0].said).__name__} comes in the session that was refused"


@case("XC04", bench_time_s=6.0)
def test_a_slow_agent_is_waited_for(agent: Agent) -> None:
    agent.opens = False
    client = agent.asked().said.client
    agent.serve(1.5)
    agent.client = client
    agent.write(agent.header(), xrce.StatusAgent(status=Status.OK, agent=xrce.Agent()))
    mark = agent.mark()
    agent.wait(xrce.Create, 3.0, mark=mark, where=_in(client), what="CREATE in the session")


@case("XC05", bench_time_s=7.0)
def test_objects_are_created_parents_first(agent: Agent) -> None:
    agent.begin(CREATED_S)
    there: set[int] = set()
    for one in _creates(agent):
        made = one.said.object
        kind = xrce.KIND_OF_OBJECT[type(made)]
        assert xrce.kind_of(one.said.object_id) == kind, f"{type(made).__name__} has the id {one.said.object_id:04x}"
        for name in PARENTS.get(type(made), ()):
            parent = getattr(made, name)
            assert parent in there, f"{type(made).__name__} is created before its {name[:-3]} {parent:04x}"
        there.add(one.said.object_id)
    assert any(xrce.kind_of(one) == xrce.ObjectKind.PARTICIPANT for one in there), "no participant is created"


@case("XC06", bench_time_s=7.0)
def test_no_object_twice(agent: Agent) -> None:
    agent.begin(CREATED_S)
    asked = _creates(agent)
    plain = [one.said.object_id for one in asked if not (one.said.reuse or one.said.replace)]
    assert asked, "nothing is created"
    assert len(plain) == len({*plain}), "an object is created again"
    requests = [one.said for one in asked]
    assert len(requests) == len({(said.object_id, said.request_id) for said in requests}), "a request is made again"


@case("XC07", bench_time_s=6.0)
def test_numbers_of_a_reliable_stream(agent: Agent) -> None:
    agent.begin(4.0)
    _require_reliable(agent)
    streams: dict[int, list[int]] = {}
    for one in _reliable(agent, 0):
        numbers = streams.setdefault(one.header.stream_id, [])
        if one.header.sequence not in numbers:
            numbers.append(one.header.sequence)
    assert streams, "nothing is said on a stream"
    for stream_id, numbers in streams.items():
        assert numbers == [*range(len(numbers))], f"stream {stream_id:02x} has the numbers {numbers[:20]}"


@case("XC08", bench_time_s=6.0)
def test_no_more_than_the_window(agent: Agent) -> None:
    agent.acknowledges = False
    agent.begin(4.0)
    _require_reliable(agent)
    for stream_id in {one.header.stream_id for one in _reliable(agent, 0)}:
        numbers = {one.header.sequence for one in _reliable(agent, 0) if one.header.stream_id == stream_id}
        assert len(numbers) <= WINDOW, f"{len(numbers)} messages of stream {stream_id:02x} are unacknowledged"


@case("XC09", bench_time_s=5.0)
def test_what_is_not_acknowledged_is_said(agent: Agent) -> None:
    first, beat = _unacknowledged(agent)
    stream_id = first.header.stream_id
    since = agent.heard[agent.heard.index(first) : agent.heard.index(beat) + 1]
    last = max(one.header.sequence for one in since if one.header.stream_id == stream_id)
    found = (beat.said.first_unacked, beat.said.last_unacked)
    assert found == (0, last), f"HEARTBEAT says {found[0]} to {found[1]}, and 0 to {last} are unacknowledged"


@case("XC10", bench_time_s=5.0)
def test_what_is_missing_is_sent_again(agent: Agent) -> None:
    first, _ = _unacknowledged(agent)
    missing = xrce.AckNack(first_unacked=0, nack_bitmap=1, stream_id=first.header.stream_id)
    mark = agent.mark()
    agent.write(agent.header(), missing)
    again = agent.wait(
        type(first.said), SENT_AGAIN_S, mark=mark, where=lambda one: one.header == first.header, what="message 0 again"
    )
    assert again.said == first.said, "it says something else"


@case("XC11", bench_time_s=7.0)
def test_what_is_acknowledged_is_done_with(agent: Agent) -> None:
    agent.begin(5.0)
    _require_reliable(agent)
    seen = [*{one.message: (one.header.stream_id, one.header.sequence) for one in _reliable(agent, 0)}.values()]
    assert seen, "nothing is said on a stream"
    late = "what was said again may have been said before it was acknowledged"
    agent.peer.require_punctual(agent.began_ns, 0.05, late)
    again = sorted({one for one in seen if seen.count(one) > 1})
    assert not again, f"messages {again[:5]} come again"
    obeyed_ns = to_ns(ANSWER_S + agent.peer.uncertainty_s(agent.began_ns))
    for beat in agent.of(xrce.Heartbeat, _begun(agent)):
        known = agent.acknowledged(beat.said.stream_id, agent.made_ns(beat) - obeyed_ns)
        first, last = beat.said.first_unacked, beat.said.last_unacked
        assert not xrce.is_newer(known, first), f"HEARTBEAT of {first} to {last}; up to {known - 1} is acknowledged"


@case("XC12", bench_time_s=4.0)
def test_a_heartbeat_is_answered(agent: Agent) -> None:
    agent.begin()
    number = agent.next_number()
    said = _beat(agent, xrce.Heartbeat(first_unacked=number, last_unacked=number + 2, stream_id=RELIABLE))
    _require_missing(said, number, 3)


@case("XC13", bench_time_s=4.0)
def test_what_comes_too_early_waits(agent: Agent) -> None:
    agent.begin()
    number = agent.next_number()
    beat = xrce.Heartbeat(first_unacked=number, last_unacked=number + 1, stream_id=RELIABLE)
    has_room_for_one = _beat(agent, beat).nack_bitmap == 0b01
    said = _acknowledged(agent, number + 1)
    assert said.first_unacked == number
    assert said.nack_bitmap & 0b11 == 0b01, f"the bitmap is {said.nack_bitmap:04x}"
    said = _acknowledged(agent, number)
    if has_room_for_one and said.first_unacked == number + 1:
        said = _acknowledged(agent, number + 1)
    assert (said.first_unacked, said.nack_bitmap) == (number + 2, 0)


@case("XC14", bench_time_s=4.0)
def test_what_comes_twice_is_acknowledged_twice(agent: Agent) -> None:
    agent.begin()
    number = agent.next_number()
    for _ in range(2):
        said = _acknowledged(agent, number)
        assert (said.first_unacked, said.nack_bitmap) == (number + 1, 0)


@case("XC15", bench_time_s=4.0)
def test_either_byte_order(agent: Agent) -> None:
    agent.begin()
    number = agent.next_number()
    data = xrce.encode_submessage(
        xrce.Heartbeat(first_unacked=number, last_unacked=number + 1, stream_id=RELIABLE), little_endian=False
    )
    said = _beat(agent, xrce.RawSubmessage(id=data[0], flags=data[1], payload=data[4:]))
    _require_missing(said, number, 2)


@case("XC16", bench_time_s=9.0)
def test_damage_is_not_obeyed(agent: Agent) -> None:
    agent.opens = False
    client = agent.asked().said.client
    agent.client = client
    answer = xrce.encode_submessage(xrce.StatusAgent(status=Status.OK, agent=xrce.Agent()))
    sound = xrce.encode_frame(xrce.encode_message(agent.header(), answer))
    mark = agent.mark()
    agent.peer.write(sound[:-1] + bytes((sound[-1] ^ 1,)))
    agent.client = None
    agent.serve(2.5)
    said = _of_session(agent, mark, client.session_id)
    assert not said, f"{type(said[0].said).__name__} comes in a session that has not begun"
    agent.opens = True
    agent.begin()
    number = agent.next_number()
    for damage in (b"\x00\xff\x12noise", sound[: len(sound) // 2]):
        agent.peer.write(damage)
        _beat(agent, xrce.Heartbeat(first_unacked=number, last_unacked=number, stream_id=RELIABLE))


@case("XC17", bench_time_s=4.0)
def test_another_session_is_not_its_own(agent: Agent) -> None:
    client = agent.begin()
    number = agent.next_number()
    beat = xrce.Heartbeat(first_unacked=number, last_unacked=number + 2, stream_id=RELIABLE)
    mark = agent.mark()
    agent.write(replace(agent.header(), session_id=client.session_id ^ 0x02), beat)
    agent.serve(0.5)
    answers = [one for one in agent.of(xrce.AckNack, mark) if one.said.nack_bitmap]
    assert not answers, "HEARTBEAT of another session is answered"
    _require_missing(_beat(agent, beat), number, 3)


@case("XC18", bench_time_s=16.0)
def test_an_agent_that_was_restarted_is_found(agent: Agent) -> None:
    _begins_anew(agent, away_s=0.0)


@case("XC19", bench_time_s=26.0)
def test_an_agent_that_was_away_is_found(agent: Agent) -> None:
    _begins_anew(agent, away_s=10.0)


@case("XC20", bench_time_s=16.0)
def test_what_a_client_had_can_be_freed(agent: Agent) -> None:
    first = agent.begin()
    mark = agent.mark()
    agent.restart()
    again = agent.wait(xrce.CreateClient, AGAIN_S, mark=mark, what="CREATE_CLIENT").said.client
    assert again.client_key == first.client_key, "another key, so that what it had before stays"


@case("XC21", bench_time_s=7.0)
def test_two_agents_at_a_line(agent: Agent) -> None:
    agent.copies = 2
    agent.begin(4.0)
    begun = list(agent.of(xrce.CreateClient))
    assert len(begun) == 1, f"a session is asked for {len(begun)} times"
    numbers = [one.header.sequence for one in _reliable(agent, 0) if one.header.stream_id == RELIABLE]
    assert sorted({*numbers}) == [*range(len({*numbers}))], f"the numbers are {numbers[:20]}"
    made = [one.said.object_id for one in _creates(agent)]
    assert made, "nothing is created"
    assert len(made) == len({*made}), "an object is created again"


@case("XC22", bench_time_s=4.0)
def test_what_is_acknowledged_is_handed_on(agent: Agent) -> None:
    agent.begin()
    number = agent.next_number()
    beat = xrce.Heartbeat(first_unacked=number, last_unacked=number + 2, stream_id=RELIABLE)
    mark = agent.mark()
    agent.write(agent.header(RELIABLE, number + 1), beat)
    agent.serve(ANSWER_S)
    early = [one for one in agent.of(xrce.AckNack, mark) if one.said.nack_bitmap & 0b100]
    assert not early, "a message that came too early is obeyed before the one that is missing"
    if _acknowledged(agent, number).first_unacked == number + 1:
        agent.write(agent.header(RELIABLE, number + 1), beat)
    agent.wait(
        xrce.AckNack,
        ANSWER_S,
        mark=mark,
        where=lambda one: one.said.first_unacked == number + 2 and bool(one.said.nack_bitmap & 1),
        what="ACKNACK of the message that a HEARTBEAT in the stream names",
    )


# --- what several cases do


def _in(client: xrce.Client) -> Any:
    return lambda one: one.header.session_id == client.session_id


def _of_session(agent: Agent, mark: int, session_id: int) -> list[Heard[Any]]:
    """What belongs to a session and came in it."""
    return [one for one in agent.in_session(mark, session_id) if isinstance(one.said, OF_SESSION)]


def _reliable(agent: Agent, mark: int) -> list[Heard[Any]]:
    """What came on reliable streams of the session that was begun last."""
    return [one for one in agent.heard[max(mark, _begun(agent)) :] if xrce.is_reliable(one.header.stream_id)]


def _begun(agent: Agent) -> int:
    """Where the session that was begun last was asked for, in what was heard."""
    asked = [at for at, one in enumerate(agent.heard) if isinstance(one.said, xrce.CreateClient)]
    return asked[-1] if asked else 0


def _require_reliable(agent: Agent) -> None:
    """Require that what came on streams did not all come on best-effort streams."""
    streams = {one.header.stream_id for one in agent.heard[_begun(agent) :]} - {xrce.NO_STREAM}
    if streams and not any(map(xrce.is_reliable, streams)):
        raise NotApplicable("the client says nothing on a reliable stream")


def _creates(agent: Agent) -> list[Heard[xrce.Create]]:
    """Every CREATE of the session that was begun last; what a reliable stream repeats counts once."""
    first: dict[tuple[int, int], int] = {}
    found = []
    for one in agent.of(xrce.Create, _begun(agent)):
        stream_id, place = one.header.stream_id, (one.header.stream_id, one.header.sequence)
        if not xrce.is_reliable(stream_id) or first.setdefault(place, one.message) == one.message:
            found.append(one)
    return found


def _unacknowledged(agent: Agent) -> tuple[Heard[Any], Heard[xrce.Heartbeat]]:
    """Begin a session and acknowledge nothing; the first message of a reliable stream, and the HEARTBEAT behind it."""
    agent.acknowledges = False
    agent.asked()
    mark = agent.mark()
    try:
        first: Heard[Any] = agent.wait(
            object,
            CREATED_S,
            mark=mark,
            where=lambda one: xrce.is_reliable(one.header.stream_id),
            what="reliable message",
        )
    except Untimely:
        _require_reliable(agent)
        raise
    stream_id = first.header.stream_id
    beat = agent.wait(
        xrce.Heartbeat, HEARTBEAT_S, mark=mark, where=lambda one: one.said.stream_id == stream_id, what="HEARTBEAT"
    )
    return first, beat


def _beat(agent: Agent, said: Any) -> xrce.AckNack:
    """Say HEARTBEAT; the answer."""
    mark = agent.mark()
    agent.write(agent.header(), said)
    return _acknack(agent, mark)


def _require_missing(said: xrce.AckNack, number: int, count: int) -> None:
    """Require that ACKNACK names the first of some missing messages, and those behind it that there is room for."""
    assert said.first_unacked == number, f"ACKNACK begins at {said.first_unacked}, not at {number}"
    right = [(1 << some) - 1 for some in range(1, count + 1)]
    assert said.nack_bitmap in right, f"the bitmap is {said.nack_bitmap:04x}, not {right[-1]:04x}"


def _acknowledged(agent: Agent, number: int) -> xrce.AckNack:
    """Send a message of the reliable stream, the answer to a request that nobody has made; what is acknowledged."""
    mark = agent.mark()
    said = xrce.StatusReply(request_id=0xFFF0, object_id=0xFF11, status=Status.OK)
    agent.write(agent.header(RELIABLE, number), said)
    return _acknack(agent, mark)


def _acknack(agent: Agent, mark: int) -> xrce.AckNack:
    found = agent.wait(
        xrce.AckNack, ANSWER_S, mark=mark, where=lambda one: one.said.stream_id == RELIABLE, what="ACKNACK"
    )
    return found.said


def _begins_anew(agent: Agent, *, away_s: float) -> None:
    """Have the agent forget all; require that everything begins anew."""
    agent.begin(3.0)
    before = {one.said.object_id for one in _creates(agent)}
    agent.restart()
    agent.away = True
    agent.serve(away_s)
    agent.away = False
    mark = agent.mark()
    agent.wait(xrce.CreateClient, AGAIN_S, mark=mark, what="CREATE_CLIENT to the new agent")
    agent.serve(3.0)
    again = {one.said.object_id for one in _creates(agent)}
    if again != before:
        raise Violation(f"created are {_ids(again)}, and were {_ids(before)}")
    first = {one.header.stream_id: one.header.sequence for one in reversed(agent.heard[_begun(agent) :])}
    late = [stream_id for stream_id, number in first.items() if number]
    assert not late, f"stream {late[0]:02x} begins at {first[late[0]]}, not at 0"


def _ids(objects: set[int]) -> str:
    return " ".join(f"{one:04x}" for one in sorted(objects)) or "none"
