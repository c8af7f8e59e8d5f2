"""Both ends of the simulator's line in the hands of a check: one says statuses and keeps commands, one the reverse.

They read without opinion: whatever has its letters in their places is a frame, also with a NaN or an unknown mode.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

from hilbench.bench import Bench
from hilbench.bench.feed import Feed
from hilbench.bench.line_peer import LinePeer, Received, Sound, Unsound
from hilbench.links import Port
from protocols.carla import (
    COMMAND_LAYOUT,
    STATUS_LAYOUT,
    CommandFrame,
    Dropped,
    Layout,
    StatusFrame,
    StreamReader,
    encode_command,
    encode_status,
)
from protocols.carla.decoding import decoder
from protocols.common.decoding import Decoder, NoOptions

__all__ = ["STATUS_HZ", "BoardPeer", "Burst", "SimulatorPeer"]

FrameT = TypeVar("FrameT", StatusFrame, CommandFrame)

STATUS_HZ = 20.0
"""How often the original says a status: CARLA in steps of 0.05 s (Carla-Autoware-Bridge, fixed_delta_seconds)."""

_LAST_FRAMES_S = 0.35
_PAUSE_NS = 5_000_000
"""Frames come 60 ms apart and more, and the bytes of one without a gap; a USB adapter adds some ms. A choice."""


@dataclass(slots=True, kw_only=True)
class Burst:
    """Bytes without a pause between them, whatever they say.

    Attributes:
        start_ns: bench time at which the first was complete.
        end_ns: bench time at which the last was complete.
        data: the bytes.
    """

    start_ns: int
    end_ns: int
    data: bytes


class _FramePeer(LinePeer[FrameT], Generic[FrameT]):
    """See `LinePeer`. A frame ends with its ``$``; the NUL behind a command is counted apart."""

    LAYOUT: Layout

    def __init__(self, bench: Bench, port: Port) -> None:
        self.paddings = 0
        self.bursts: list[Burst] = []
        super().__init__(bench, port)

    def _decoder(self, sent: bool) -> Decoder:
        del sent
        return decoder(NoOptions(), "")

    def _begin_reading(self) -> None:
        self._reader = StreamReader(self.LAYOUT, lambda _frame: None)
        self._latest: deque[int] = deque(maxlen=self.LAYOUT.length)
        self._behind_frame = False

    def _read(self, data: bytes, at_ns: int) -> Iterator[Sound[FrameT] | Unsound]:
        self._latest += data
        self.paddings += self._behind_frame and self.LAYOUT.padding.startswith(data)
        self._behind_frame = False
        for item in self._reader.receive(data, at_ns):
            if isinstance(item, Dropped):
                yield Unsound(reason=item.reason.name, data=item.data)
            else:
                self._behind_frame = True
                yield Sound(raw=bytes(self._latest), packet=item)  # type: ignore[arg-type]

    def _take(self, data: bytes, at_ns: int) -> None:
        if self.bursts and at_ns - self.bursts[-1].end_ns < _PAUSE_NS:
            self.bursts[-1].data += data
            self.bursts[-1].end_ns = at_ns
        else:
            self.bursts.append(Burst(start_ns=at_ns, end_ns=at_ns, data=data))
        super()._take(data, at_ns)

    def frames(self, mark: int = 0) -> list[Received[FrameT]]:
        """Return the frames received since a mark."""
        return [got for got in self.received[mark:] if got.packet is not None]

    def forget(self) -> None:
        """Discard everything received so far."""
        super().forget()
        self.paddings = 0
        self.bursts.clear()


class SimulatorPeer(_FramePeer[CommandFrame]):
    """The simulator's end, with a board at the other.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.

    Attributes:
        status: what `statuses` says.
        statuses: says it at a rate, once started.
        paddings: NULs behind frames.
        bursts: all that came, by the pauses between.
    """

    LAYOUT = COMMAND_LAYOUT

    def __init__(self, bench: Bench, port: Port) -> None:
        self.status = StatusFrame()
        self.statuses = Feed(bench, self._send_status, name="simulator")
        super().__init__(bench, port)

    # --- sending

    def send_status(self, status: StatusFrame) -> None:
        """Put a sound status on the line."""
        self.write(encode_status(status))

    def _send_status(self) -> None:
        self.send_status(self.status)

    def modes(self, mark: int = 0) -> list[int]:
        """Return the mode bytes of the frames received since a mark."""
        return [frame.mode for _, frame in self.since(mark, CommandFrame)]

    def settle(self) -> None:
        """Say statuses at the usual rate until the board has left EMERGENCY, then discard what came."""
        self.statuses.start(STATUS_HZ)
        self.run(_LAST_FRAMES_S)
        self.statuses.stop()
        self.forget()


class BoardPeer(_FramePeer[StatusFrame]):
    """The board's end, with a simulator's side at the other.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.

    Attributes:
        command: what `commands` says.
        commands: says it at a rate, once started.
    """

    LAYOUT = STATUS_LAYOUT

    def __init__(self, bench: Bench, port: Port) -> None:
        self.command = CommandFrame()
        self.commands = Feed(bench, self._send_command, name="board")
        super().__init__(bench, port)

    def send_command(self, command: CommandFrame) -> None:
        """Put a sound command on the line, with its NUL."""
        self.write(encode_command(command))

    def _send_command(self) -> None:
        self.send_command(self.command)

    def stand_still(self) -> None:
        """Say no further commands."""
        self.commands.stop()

    def settle(self) -> None:
        """Say nothing more, and discard what came."""
        self.commands.stop()
        self.forget()

    def close(self) -> None:
        """Leave the port to another."""
        self.commands.stop()
        self.port.on_receive = lambda _data, _at_ns: None
