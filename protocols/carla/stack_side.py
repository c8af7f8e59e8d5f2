"""The board's side towards the driving stack, as far as it rules what the other line says: the micro-ROS task.

It knows whether an agent is there, takes requests for a mode, decides which commands are handed on, and tells the mode.
Source: LMA-FEM-UNICAMP/microAutoware, src/microAutoware microAutoware.c and executorCallbacks.c.
"""

from __future__ import annotations

from collections.abc import Callable

from protocols.carla.counters import Counters
from protocols.carla.events import AgentChanged, Event, ModeAnswered, ModeReported, Refusal
from protocols.carla.frames import Mode
from protocols.carla.options import BoardOptions, EmergencyReport
from protocols.carla.states import ModeTrigger
from protocols.state_machine import earliest

__all__ = ["NOT_READY", "StackSide"]

NOT_READY = 6
"""Of autoware_auto_vehicle_msgs/ControlModeReport."""

_NS_PER_S = 1_000_000_000
_OF_REQUEST = {Mode.AUTOWARE: ModeTrigger.REQUEST_AUTOWARE, Mode.MANUAL: ModeTrigger.REQUEST_MANUAL}
_REQUESTS = tuple(_OF_REQUEST.values())


class StackSide:
    """What the board knows of the driving stack.

    Args:
        options: of the board.
        counters: where it counts.
        emit: takes its events.

    Attributes:
        online: an agent is there, and is listened to.
        reported: the mode that the driving stack has last.
    """

    def __init__(self, options: BoardOptions, counters: Counters, emit: Callable[[Event], None]) -> None:
        self.online = False
        self.reported: int = Mode.AUTOWARE
        self._options = options
        self._counters = counters
        self._emit = emit
        self._requests: set[Mode] = set()
        self._report_ns: int | None = None
        self._silence_ns: int | None = None

    @property
    def watched(self) -> bool:
        """The board minds whether the driving stack is there."""
        return self._options.agent_silence_s is not None

    def sign(self, now_ns: int, *, starting: bool) -> bool:
        """A sign of life; returns whether it is the first after none."""
        if not self.online and not starting and not self._options.late_agent:
            return False
        if self._options.agent_silence_s is not None:
            self._silence_ns = now_ns + round(self._options.agent_silence_s * _NS_PER_S)
        came, self.online = not self.online, True
        if came:
            self._emit(AgentChanged(online=True))
            self._report(now_ns)
        return came

    def lost(self) -> None:
        """The driving stack is there no more."""
        if self.online:
            self.online = False
            self._silence_ns = self._report_ns = None
            self._counters.agent_losses += 1
            self._emit(AgentChanged(online=False))

    def answer(self, asked: int, mode: Mode) -> bool:
        """Answers a request for a mode while the board is in another; returns whether it is granted."""
        reason = None
        if asked not in tuple(_OF_REQUEST):
            reason = Refusal.UNKNOWN_MODE
        elif mode is Mode.EMERGENCY and not self._options.requests_in_emergency:
            reason = Refusal.EMERGENCY
        self._counters.requests += 1
        self._counters.requests_refused += reason is not None
        self._emit(ModeAnswered(mode=asked, success=reason is None, reason=reason))
        return reason is None

    def remember(self, asked: Mode) -> None:
        """Keeps a request until the control task looks."""
        self._requests.add(asked)

    def take_request(self, mode: Mode) -> ModeTrigger | None:
        """What the requests since the last look come to."""
        requests, self._requests = self._requests, set()
        if not requests or (mode is Mode.EMERGENCY and not self._options.requests_in_emergency):
            return None
        both = Mode.MANUAL if self._options.both_to_manual else Mode.AUTOWARE
        return _OF_REQUEST[both if len(requests) > 1 else requests.pop()]

    def hands_on(self, mode: Mode) -> bool:
        """Commands reach the control task."""
        return self.online and (self.reported if self._options.own_mode else mode) == Mode.AUTOWARE

    def mode_changed(self, mode: Mode, trigger: ModeTrigger, now_ns: int) -> None:
        """The control task has another mode. With a mode of its own the micro-ROS task is not told everything."""
        if mode is Mode.EMERGENCY:
            if self._options.emergency_report is not EmergencyReport.KEPT:
                manual = self._options.emergency_report is EmergencyReport.MANUAL
                self.tell(Mode.MANUAL if manual else NOT_READY, now_ns)
        elif not (self._options.own_mode and trigger in (*_REQUESTS, ModeTrigger.NO_AGENT)):
            self.tell(mode, now_ns)

    def tell(self, mode: int, now_ns: int) -> None:
        """The mode that is reported from now on."""
        if mode != self.reported:
            self.reported = mode
            if self.online:
                self._report(now_ns)

    def next_deadline_ns(self) -> int | None:
        """When a report is due or the driving stack was silent for too long, in ns of bench time."""
        return earliest(self._report_ns, self._silence_ns)

    def expire(self, now_ns: int) -> None:
        """Does what is due: silence before a report."""
        if self._silence_ns is not None and self._silence_ns <= now_ns:
            self.lost()
        elif self._report_ns is not None and self._report_ns <= now_ns:
            self._report(now_ns)

    def _report(self, now_ns: int) -> None:
        self._emit(ModeReported(mode=int(self.reported)))
        self._report_ns = now_ns + round(self._options.mode_report_s * _NS_PER_S)
