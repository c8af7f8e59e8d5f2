"""The driving stack's end of a vehicle-interface board's line in the hands of a check: the stand-in link's agent.

It answers pings as long as it is `online`, sends commands at a rate when told to, and keeps every report.
"""

from __future__ import annotations

from collections.abc import Iterator

from hilbench.bench import Bench
from hilbench.bench.feed import Feed
from hilbench.bench.line_peer import LinePeer, Sound, Unsound
from hilbench.links import Port
from protocols.autoware import (
    AckermannControlCommand,
    AgentOnline,
    AgentPing,
    Clock,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    Dropped,
    FrameReader,
    Message,
    RemoteProtocolError,
    Time,
    UnknownMessage,
    decode_message,
    encode_frame,
    encode_message,
)
from protocols.autoware.decoding import decoder
from protocols.common.decoding import Decoder, NoOptions

__all__ = ["REPLY_WITHIN_S", "StackPeer"]

REPLY_WITHIN_S = 0.2
"""How soon a request for a mode is answered. No source gives a figure; the original's executor spins for 20 ms at a
time and its control loop waits for up to 110 ms. A choice."""

StackMessage = Message | UnknownMessage


class StackPeer(LinePeer[StackMessage]):
    """See `LinePeer`.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.

    Attributes:
        command: what `commands` sends.
        commands: sends it at a rate, once started.
        made_ns: when the board asked for the last object that the line needs; None if it needs none.
    """

    REPLY_WITHIN_S = REPLY_WITHIN_S

    def __init__(self, bench: Bench, port: Port) -> None:
        self._answers_pings = True
        self.command = AckermannControlCommand()
        self.commands = Feed(bench, self._send_command, name="stack")
        self.made_ns: int | None = None
        self._sequence = 0
        super().__init__(bench, port)

    @property
    def online(self) -> bool:
        """Whether pings are answered."""
        return self._answers_pings

    @online.setter
    def online(self, online: bool) -> None:
        self._answers_pings = online

    def _decoder(self, sent: bool) -> Decoder:
        del sent
        return decoder(NoOptions(), "")

    def _begin_reading(self) -> None:
        self._reader = FrameReader()

    def _read(self, data: bytes, at_ns: int) -> Iterator[Sound[StackMessage] | Unsound]:
        del at_ns
        for item in self._reader.receive(data):
            if isinstance(item, Dropped):
                yield Unsound(reason=item.reason.name, data=item.data)
                continue
            try:
                message: StackMessage | None = decode_message(item.payload)
            except RemoteProtocolError:
                message = None
            if isinstance(message, AgentPing) and self.online:
                self.send(AgentOnline())
            yield Sound(raw=item.raw, packet=message)

    # --- sending

    def send(self, message: StackMessage) -> None:
        """Put a message on the line, in a sound frame."""
        self.write(self.wire(message))

    def wire(self, message: StackMessage) -> bytes:
        """Return the frame by which a message reaches the board."""
        return encode_frame(encode_message(message))

    def frame_of(self, message: Message) -> bytes:
        """Return a frame with a message, to be damaged."""
        return self.wire(message)

    def go_online(self) -> None:
        """Say that the agent is there, unasked."""
        self.online = True
        self.send(AgentOnline())

    def request(self, mode: int) -> ControlModeResponse:
        """Ask for a mode; return the answer.

        Raises:
            Violation: none came in time.
        """
        self._sequence = (self._sequence + 1) % 256
        sequence = self._sequence
        self.send(ControlModeRequest(sequence=sequence, mode=mode))
        return self.expect(
            ControlModeResponse,
            where=lambda answer: answer.sequence == sequence,
            what=f"answer to the request of {mode}",
        )

    def set_clock(self, time_ns: int) -> None:
        """Tell the simulation's time."""
        self.send(Clock(clock=Time.from_ns(time_ns)))

    def modes(self, mark: int = 0) -> list[int]:
        """Return the modes that were reported since a mark."""
        return [report.mode for _, report in self.since(mark, ControlModeReport)]

    def stand_still(self) -> None:
        """Say no further commands; after its deadlines the board stops the car by itself."""
        self.commands.stop()

    def settle(self) -> None:
        """End commands and an unfinished frame, ask for manual mode, discard what comes."""
        self.commands.stop()
        self.go_online()
        self.send(ControlModeRequest(mode=4))
        self.run(0.2)
        self.forget()

    def _send_command(self) -> None:
        self.send(self.command)
