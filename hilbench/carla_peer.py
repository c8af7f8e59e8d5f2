"""The simulator's end of a vehicle-interface board's line in the hands of a check: says statuses, keeps commands.

It reads without opinion: whatever has its letters in their places is a frame, also with a NaN or an unknown mode.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from hilbench.bench import Bench
from hilbench.feed import Feed
from hilbench.line_peer import LinePeer, Received, Sound, Unsound
from hilbench.links import Port
from protocols.carla import (
    COMMAND_LAYOUT,
    CommandFrame,
    Dropped,
    StatusFrame,
    StreamReader,
    encode_status,
)

__all__ = ["STATUS_HZ", "SimulatorPeer"]

STATUS_HZ = 20.0
"""How often the original says a status: CARLA in steps of 0.05 s (Carla-Autoware-Bridge, fixed_delta_seconds)."""

_LAST_FRAMES_S = 0.35


class SimulatorPeer(LinePeer[CommandFrame]):
    """See `LinePeer`. A frame ends with its ``$``; the NUL behind it is counted apart.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.

    Attributes:
        status: what `statuses` says.
        statuses: says it at a rate, once started.
        paddings: NULs behind frames.
    """

    def __init__(self, bench: Bench, port: Port) -> None:
        self.status = StatusFrame()
        self.statuses = Feed(bench, self._send_status, name="simulator")
        self.paddings = 0
        super().__init__(bench, port)

    def _begin_reading(self) -> None:
        self._reader = StreamReader(COMMAND_LAYOUT, lambda _frame: None)
        self._latest: deque[int] = deque(maxlen=COMMAND_LAYOUT.length)
        self._behind_frame = False

    def _read(self, data: bytes, at_ns: int) -> Iterator[Sound[CommandFrame] | Unsound]:
        self._latest += data
        self.paddings += self._behind_frame and data in COMMAND_LAYOUT.padding
        self._behind_frame = False
        for item in self._reader.receive(data, at_ns):
            if isinstance(item, CommandFrame):
                self._behind_frame = True
                yield Sound(raw=bytes(self._latest), packet=item)
            elif isinstance(item, Dropped):
                yield Unsound(reason=item.reason.name, data=item.data)

    # --- sending

    def send_status(self, status: StatusFrame) -> None:
        """Put a sound status on the line."""
        self.write(encode_status(status))

    def _send_status(self) -> None:
        self.send_status(self.status)

    # --- looking back

    def frames(self, mark: int = 0) -> list[Received[CommandFrame]]:
        """Return the frames received since a mark."""
        return [got for got in self.received[mark:] if got.packet is not None]

    def modes(self, mark: int = 0) -> list[int]:
        """Return the mode bytes of the frames received since a mark."""
        return [frame.mode for _, frame in self.since(mark, CommandFrame)]

    def forget(self) -> None:
        """Discard everything received so far."""
        super().forget()
        self.paddings = 0

    def settle(self) -> None:
        """Say statuses at the usual rate until the board has left EMERGENCY, then discard what came."""
        self.statuses.start(STATUS_HZ)
        self.run(_LAST_FRAMES_S)
        self.statuses.stop()
        self.forget()
