"""The simulator's end of the line: commands to the car, statuses from it."""

from __future__ import annotations

from protocols.carla.checking import clamped, simulator_fault
from protocols.carla.counters import Counters
from protocols.carla.events import Commanded, Event, FrameDropped, LinkSilent, Transmit
from protocols.carla.frames import COMMAND_LAYOUT, CommandFrame, Mode, StatusFrame, encode_status
from protocols.carla.messages import AckermannCommand, command_in
from protocols.carla.options import SimulatorOptions, SimulatorReader
from protocols.carla.polling import PollReader, PollStreamReader
from protocols.carla.reading import Dropped, DropReason, Found, StreamReader
from protocols.carla.states import (
    LINK_TABLE,
    LINK_TIMER_STATES,
    LinkAction,
    LinkState,
    LinkTable,
    LinkTimer,
    LinkTrigger,
)
from protocols.state_machine import StateMachine

__all__ = ["SimulatorMachine"]

_NS_PER_S = 1_000_000_000
_CR_TO_LF = bytes.maketrans(b"\r", b"\n")


class SimulatorMachine(StateMachine[LinkState, LinkTrigger, LinkAction, LinkTimer, Event, Counters]):
    """Takes commands, watches for their absence, and sends a status when both reports for it have come.

    Attributes:
        reader: how it finds commands.
    """

    def __init__(self, options: SimulatorOptions, table: LinkTable | None, epoch_ns: int) -> None:
        super().__init__(
            LINK_TABLE if table is None else table, LinkState.WAITING, Counters(), timer_states=LINK_TIMER_STATES
        )
        self._options = options
        self.reader = self._make_reader(epoch_ns)
        self._frame = CommandFrame()
        self._status = StatusFrame()
        self._velocity: tuple[float, float, float] | None = None
        self._steering: float | None = None

    def _make_reader(self, epoch_ns: int) -> PollReader | StreamReader:
        options = self._options
        block_s, icrnl = options.idle_block_s, options.icrnl
        if options.reader is SimulatorReader.POLL:
            return PollReader(options.poll, idle_block_s=block_s, icrnl=icrnl, epoch_ns=epoch_ns)
        timeout_ns = None if options.frame_timeout_s is None else round(options.frame_timeout_s * _NS_PER_S)
        if block_s is None:
            return StreamReader(COMMAND_LAYOUT, self._fault, timeout_ns=timeout_ns)
        return PollStreamReader(
            options.poll, idle_block_s=block_s, icrnl=icrnl, epoch_ns=epoch_ns, timeout_ns=timeout_ns
        )

    # --- bytes

    def receive(self, data: bytes) -> None:
        """Takes bytes that came now."""
        if self._options.icrnl and isinstance(self.reader, StreamReader):
            data = data.translate(_CR_TO_LF)
        self._take(self.reader.receive(data, self.now_ns))

    def expire_bytes(self) -> None:
        """Lets the reader do what is due now, and then what had to wait for it."""
        self._take(self.reader.expire(self.now_ns))
        if isinstance(self.reader, PollReader):
            counters, reader = self.counters, self.reader
            counters.polls, counters.blocks, counters.read_errors = reader.polls, reader.blocks, reader.errors
        self._send_what_is_complete()

    def read_error(self, failing: bool) -> None:
        """Reads fail from now on, or work again. A reader that does not poll has nothing to read meanwhile."""
        if isinstance(self.reader, PollReader):
            self._take(self.reader.fail(failing))
            self.counters.read_errors = self.reader.errors
        else:
            self.counters.read_errors += failing

    # --- the car

    def velocity(self, lon_m_s: float, lat_m_s: float, heading_rate_rad_s: float) -> None:
        """A velocity report; the next steering report completes a status."""
        encode_status(StatusFrame(lon_speed_m_s=lon_m_s, lat_speed_m_s=lat_m_s, heading_rate_rad_s=heading_rate_rad_s))
        self._velocity = (lon_m_s, lat_m_s, heading_rate_rad_s)
        self._reported()

    def steering(self, steering_rad: float) -> None:
        """A steering report; the next velocity report completes a status."""
        encode_status(StatusFrame(steering_rad=steering_rad))
        self._steering = steering_rad
        self._reported()

    def _reported(self) -> None:
        blocked = isinstance(self.reader, PollReader) and self.reader.blocked
        self.counters.sends_delayed += blocked and self._velocity is not None and self._steering is not None
        self._send_what_is_complete()

    def _send_what_is_complete(self) -> None:
        if self._velocity is None or self._steering is None:
            return
        if isinstance(self.reader, PollReader):
            if self.reader.blocked:
                return
            if self._options.forget_mode:
                self.reader.forget_mode()
        lon, lat, rate = self._velocity
        status = StatusFrame(lon_speed_m_s=lon, lat_speed_m_s=lat, heading_rate_rad_s=rate, steering_rad=self._steering)
        self._velocity = self._steering = None
        self._status = status
        self.transmit(encode_status(status))

    # --- the machine

    def trigger_of(self, timer: LinkTimer) -> LinkTrigger:
        """The trigger of a timer that has run out."""
        del timer
        return LinkTrigger.SILENCE

    def act(self, action: LinkAction, trigger: LinkTrigger) -> None:
        """Carries out one action of an edge."""
        del trigger
        match action:
            case LinkAction.FEED:
                self.start(LinkTimer.COMMANDS, self._options.silence_s)
            case LinkAction.HAND_ON:
                self._hand_on()
            case LinkAction.STOP:
                self.counters.silences += 1
                self.events.append(LinkSilent())
                self.events.append(Commanded(command=AckermannCommand(), mode=Mode.EMERGENCY, frame=None))

    def state_changed(self, old: LinkState, trigger: LinkTrigger) -> None:
        """Nobody is told: `LinkSilent` and `Commanded` say it."""

    def to_transmit(self, frame: bytes) -> Event:
        """The event that wants a frame on the line."""
        return Transmit(data=frame, frame=self._status)

    def _take(self, found: list[Found]) -> None:
        for item in found:
            if isinstance(item, Dropped):
                self._drop(item)
            elif isinstance(item, CommandFrame):
                self._command(item)

    def _command(self, frame: CommandFrame) -> None:
        reason = None if isinstance(self.reader, StreamReader) else self._fault(frame)
        if reason is not None:
            self._drop(Dropped(reason=reason, data=COMMAND_LAYOUT.encode(frame)))
            return
        self.counters.frames_in += 1
        self._frame = frame
        self.fire(LinkTrigger.COMMAND)

    def _drop(self, dropped: Dropped) -> None:
        self.counters.drop(dropped.reason)
        self.events.append(FrameDropped(reason=dropped.reason, data=dropped.data))

    def _fault(self, frame: StatusFrame | CommandFrame) -> DropReason | None:
        return simulator_fault(self._options, frame)

    def _hand_on(self) -> None:
        frame = clamped(self._frame) if self._options.clamp_manual else self._frame
        self.counters.clamped += frame != self._frame
        command = command_in(frame)
        if command is not None:
            self.counters.published += 1
            self.events.append(Commanded(command=command, mode=frame.mode, frame=self._frame))
