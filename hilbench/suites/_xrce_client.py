"""The checker as the agent of a client: answers as a case wants, keeps all that comes, and has no opinion about it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from hilbench.bench.protocol_peer import ProtocolPeer
from hilbench.check import Inconclusive, Untimely
from hilbench.clock import NS_PER_S
from hilbench.links import Line
from protocols import xrce
from protocols.xrce import Status
from protocols.xrce.decoding import Message

__all__ = ["BEGIN_S", "Agent", "Heard"]

SaidT = TypeVar("SaidT")

BEGIN_S = 15.0
"""How long a client is waited for until it asks for a session. A choice: micro-ROS pings each second."""
SPARE_S = 2.0
"""So much longer something is waited for, which tells late from never. A choice."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard(Generic[SaidT]):
    """A submessage of the client: when it came, in which message, and what it says.

    Attributes:
        start_ns: bench time at which the first byte of its message was complete.
        at_ns: bench time at which the last one was.
        message: how many messages came before that message.
        header: of that message.
        said: the submessage.
    """

    start_ns: int
    at_ns: int
    message: int
    header: xrce.Header
    said: SaidT


class Agent:
    """An agent at the checker's end of the line.

    Args:
        peer: that end.

    Attributes:
        began_ns: bench time at which the case began.
        away: nothing is answered, nor noted in a session.
        opens: CREATE_CLIENT is answered; with `status`.
        confirms: requests of the session are answered.
        acknowledges: messages of reliable streams are.
        copies: how often each answer is written.
        client: what the client has said of itself; None without a session.
        heard: all submessages, the oldest first.
    """

    def __init__(self, peer: ProtocolPeer) -> None:
        self.peer = peer
        self.began_ns = peer.bench.now_ns
        self.away = False
        self.opens = self.confirms = self.acknowledges = True
        self.status = Status.OK
        self.copies = 1
        self.heard: list[Heard[Any]] = []
        self._seen = peer.mark()
        self._line_free_ns = 0
        self.restart()

    def restart(self) -> None:
        """Forget all: another agent is at the line."""
        self.client: xrce.Client | None = None
        self._numbers: dict[int, int] = {}
        self._expected: dict[int, int] = {}
        self._arrived: list[tuple[int, xrce.AckNack]] = []

    # --- time

    def serve(self, for_s: float) -> None:
        """Let time pass, and answer what comes."""
        bench = self.peer.bench
        end_s = bench.now_s + for_s
        while bench.run_until(lambda: self.peer.mark() > self._seen, max(0.0, end_s - bench.now_s)):
            self._answer_all()
        self.peer.require_line()

    def wait(
        self,
        kind: type[SaidT],
        within_s: float,
        *,
        mark: int | None = None,
        where: Callable[[Heard[SaidT]], bool] = lambda _heard: True,
        what: str = "",
    ) -> Heard[SaidT]:
        """Serve until a submessage comes that fits, from a mark on; the usual is what comes from now on.

        Raises:
            Untimely: it does not come in time.
        """
        bench, first = self.peer.bench, self.mark() if mark is None else mark
        begun_s = bench.now_s
        while True:
            found = next((one for one in self.of(kind, first) if where(one)), None)
            if found is not None and bench.now_s - begun_s <= within_s:
                return found
            left_s = begun_s + within_s + SPARE_S - bench.now_s
            if found is not None or left_s <= 0:
                name = what or kind.__name__
                raise Untimely(f"no {name} within {within_s:g} s", self.peer.evidence(), spare_s=SPARE_S)
            bench.run_until(lambda: self.peer.mark() > self._seen, left_s)
            self.peer.require_line()
            self._answer_all()

    def begin(self, settle_s: float = 1.5) -> xrce.Client:
        """Wait until the client has a session, and has said in it what it says at the begin.

        Raises:
            Untimely: it asks for none.
        """
        asked = self.asked(self.mark())
        self.serve(settle_s)
        return asked.said.client

    def asked(self, mark: int = 0) -> Heard[xrce.CreateClient]:
        """Wait until the client asks for a session, from a mark on.

        Raises:
            Untimely: it does not.
            Inconclusive: it does not, and speaks in a session that was begun before this case, at a port.
        """
        try:
            return self.wait(xrce.CreateClient, BEGIN_S, mark=mark, what="CREATE_CLIENT")
        except Untimely:
            if self._at_a_port and self._is_in_another_session:
                raise Inconclusive(
                    f"no CREATE_CLIENT within {BEGIN_S:g} s, as the client is still in the session of the case before: "
                    "have the board reset before each case, by [port] reset in a bench file",
                    self.peer.evidence(),
                ) from None
            raise

    @property
    def _at_a_port(self) -> bool:
        """Whether the client may have run before this case began."""
        return self.peer.bench.scheduler.locked

    @property
    def _is_in_another_session(self) -> bool:
        """Whether it has said something in a session, and asked for none in this case."""
        outside = (xrce.NO_SESSION, xrce.NO_SESSION_WITH_KEY)
        inside = any(one.header.session_id not in outside for one in self.heard)
        return inside and not any(self.of(xrce.CreateClient))

    # --- looking back

    def mark(self) -> int:
        """Return a position in what was heard."""
        return len(self.heard)

    def of(self, kind: type[SaidT], mark: int = 0) -> Iterator[Heard[SaidT]]:
        """The submessages of a kind since a mark."""
        return (one for one in self.heard[mark:] if isinstance(one.said, kind))

    def in_session(self, mark: int, session_id: int) -> list[Heard[Any]]:
        """What came in a session since a mark."""
        return [one for one in self.heard[mark:] if one.header.session_id == session_id]

    def next_number(self, stream_id: int = 0x80) -> int:
        """The number of the next message on a stream."""
        return self._numbers.get(stream_id, 0)

    def made_ns(self, one: Heard[Any]) -> int:
        """Bench time at which the client may have made a message at the earliest, in ns.

        What comes without a gap behind other messages may have waited behind them.
        """
        begun_ns = one.start_ns
        gap_ns = self._bytes_ns(2) + round(self.peer.uncertainty_s(self.began_ns) * NS_PER_S)
        for before in reversed(self.heard[: self.heard.index(one)]):
            if begun_ns - before.at_ns > gap_ns:
                break
            begun_ns = before.start_ns
        return begun_ns

    def acknowledged(self, stream_id: int, by_ns: int) -> int:
        """The first message of a stream that no ACKNACK had acknowledged whose last byte was out at a bench time."""
        said = [one for at_ns, one in self._arrived if at_ns <= by_ns and one.stream_id == stream_id]
        return said[-1].first_unacked if said else 0

    # --- saying

    def header(self, stream_id: int = 0, sequence: int = 0) -> xrce.Header:
        """The header of a message of the session."""
        assert self.client is not None
        key = self.client.client_key if xrce.has_client_key(self.client.session_id) else None
        return xrce.Header(session_id=self.client.session_id, stream_id=stream_id, sequence=sequence, client_key=key)

    def write(self, header: xrce.Header, *said: Any) -> None:
        """Put a message on the line."""
        message = Message(header=header, submessages=said)
        for _ in range(self.copies):
            self.peer.send(message)
            begun_ns = max(self.peer.bench.now_ns, self._line_free_ns)
            self._line_free_ns = begun_ns + self._bytes_ns(len(self.peer.frame_of(message)))
        self._arrived += [(self._line_free_ns, one) for one in said if isinstance(one, xrce.AckNack)]

    def say(self, *said: Any, stream_id: int = 0x80) -> None:
        """Say submessages with the next number of a stream."""
        number = self.next_number(stream_id)
        self._numbers[stream_id] = xrce.after(number)
        self.write(self.header(stream_id, number), *said)

    def _bytes_ns(self, count: int) -> int:
        return Line(baud=self.peer.port.baud).bytes_ns(count)

    # --- answering

    def _answer_all(self) -> None:
        first, messages = self._seen, self.peer.received[self._seen :]
        self._seen = self.peer.mark()
        for number, got in enumerate(messages, first):
            if isinstance(got.packet, Message):
                self.heard += [
                    Heard(start_ns=got.start_ns, at_ns=got.at_ns, message=number, header=got.packet.header, said=one)
                    for one in got.packet.submessages
                ]
                if not self.away:
                    self._answer(got.packet)

    def _answer(self, message: Message) -> None:
        for said in message.submessages:
            match said:
                case xrce.GetInfo(object_id=object_id) if object_id == xrce.OBJECT_AGENT:
                    self._pong(message.header, said)
                case xrce.CreateClient():
                    self._open(said.client)
        if self.client is None or (message.header.session_id, message.header.client_key) != self._session:
            return
        if xrce.is_reliable(message.header.stream_id):
            self._obey_in_order(message)
        else:
            self._obey(message)

    @property
    def _session(self) -> tuple[int, bytes | None]:
        header = self.header()
        return header.session_id, header.client_key

    def _pong(self, header: xrce.Header, said: xrce.GetInfo) -> None:
        there = self.client is not None and header.session_id == self.client.session_id
        answer = xrce.Info(
            request_id=said.request_id,
            object_id=said.object_id,
            implementation_status=int(there),
            activity=xrce.AgentActivity(availability=1),
        )
        self.write(xrce.Header(session_id=header.session_id, client_key=header.client_key), answer)

    def _open(self, client: xrce.Client) -> None:
        if not self.opens:
            return
        self.restart()
        self.client = client
        self.write(self.header(), xrce.StatusAgent(status=self.status, agent=xrce.Agent()))
        if self.status is not Status.OK:
            self.client = None

    def _obey_in_order(self, message: Message) -> None:
        stream_id, number = message.header.stream_id, message.header.sequence
        expected = self._expected.get(stream_id, 0)
        if number == expected:
            self._expected[stream_id] = expected = xrce.after(expected)
            self._obey(message)
        if self.acknowledges:
            missing = xrce.is_newer(number, expected)
            said = xrce.AckNack(first_unacked=expected, nack_bitmap=int(missing), stream_id=stream_id)
            self.write(self.header(), said)

    def _obey(self, message: Message) -> None:
        for said in message.submessages:
            if isinstance(said, xrce.Create | xrce.Delete) and said.object_id != xrce.OBJECT_CLIENT and self.confirms:
                answer = xrce.StatusReply(request_id=said.request_id, object_id=said.object_id, status=Status.OK)
                self.say(answer, stream_id=0x80 if xrce.is_reliable(message.header.stream_id) else 0x01)
            elif isinstance(said, xrce.Timestamp):
                now = xrce.Time.of_ns(self.peer.bench.now_ns)
                self.write(self.header(), xrce.TimestampReply(transmit=now, receive=now, originate=said.transmit))
            elif isinstance(said, xrce.Heartbeat) and self.acknowledges:
                first = self._expected.get(said.stream_id, 0)
                missing = xrce.ahead(xrce.after(said.last_unacked), first)
                bitmap = (1 << min(missing, 16)) - 1 if missing < 0x8000 else 0
                self.write(
                    self.header(), xrce.AckNack(first_unacked=first, nack_bitmap=bitmap, stream_id=said.stream_id)
                )
