"""The board's end of the line: its control task, step by step.

Computing takes no time here, and of the micro-ROS task there is what can be seen from outside (`StackSide`); it does at
once what the original does within a loop of at most 80 ms.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import partial

from protocols.carla.checking import command_fault, status_fault
from protocols.carla.counters import Counters
from protocols.carla.errors import LocalProtocolError
from protocols.carla.events import (
    CommandRefused,
    DeadlineMissed,
    Event,
    FrameDropped,
    LampChanged,
    LineDead,
    ModeChanged,
    PressIgnored,
    Refusal,
    StatusReceived,
    StatusReported,
    Transmit,
    Waited,
)
from protocols.carla.frames import COMMAND_BYTES, STATUS_LAYOUT, CommandFrame, Mode, StatusFrame, encode_command
from protocols.carla.joystick import FULL_SCALE, manual_command
from protocols.carla.messages import ControlCommand
from protocols.carla.options import BoardOptions, BoardReader, MissedCommand
from protocols.carla.reading import BlockReader, Dropped, DropReason, Found, StreamReader
from protocols.carla.stack_side import StackSide
from protocols.carla.states import (
    BLOCK_OF_MODE,
    MODE_OF_STEP,
    MODE_TABLE,
    STEP_TABLE,
    TIMER_STEPS,
    Action,
    ModeTable,
    ModeTrigger,
    Step,
    Table,
    Timer,
    Trigger,
)
from protocols.state_machine import StateMachine, earliest

__all__ = ["UNINITIALISED_FRAME", "BoardMachine"]

UNINITIALISED_FRAME = b"\xa5" * COMMAND_BYTES
"""What a buffer on a task's stack holds that nobody has filled; choice: FreeRTOS' tskSTACK_FILL_BYTE."""

_NS_PER_S = 1_000_000_000
_TICK_NS = 1_000_000
_TICKS_PER_S = 1000
_REFUSALS = {DropReason.NOT_FINITE: Refusal.NOT_FINITE, DropReason.IMPLAUSIBLE: Refusal.IMPLAUSIBLE}


class BoardMachine(StateMachine[Step, Trigger, Action, Timer, Event, Counters]):
    """The control task.

    Attributes:
        mode: who rules.
        mode_visits: how often each edge of the table of modes was taken.
        modes: the table of modes.
        reader: how it finds statuses.
        stack: what it knows of the driving stack.
    """

    def __init__(self, options: BoardOptions, table: Table | None, modes: ModeTable | None, epoch_ns: int) -> None:
        super().__init__(STEP_TABLE if table is None else table, Step.STARTING, Counters(), timer_states=TIMER_STEPS)
        self.mode = Mode.AUTOWARE
        self.mode_visits: Counter[tuple[Mode, ModeTrigger]] = Counter()
        self.reader: BlockReader | StreamReader
        if options.reader is BoardReader.BLOCKS:
            self.reader = BlockReader()
        else:
            timeout_ns = None if options.frame_timeout_s is None else round(options.frame_timeout_s * _NS_PER_S)
            self.reader = StreamReader(STATUS_LAYOUT, partial(status_fault, options), timeout_ns=timeout_ns)
        self.stack = StackSide(options, self.counters, self._emit)
        self._options = options
        self.modes = MODE_TABLE if modes is None else modes
        self._epoch_ns = epoch_ns
        self._dead = False
        self._lamp: Mode | None = None
        self._press_tick = 0
        self._pressed = False
        self._stick = (options.x_axis.zero, options.y_axis.zero)
        self._action = CommandFrame()
        self._command_waits = False
        self._sent: CommandFrame | None = None
        self._known = self._reported = StatusFrame()
        self._unreported = False
        self._arrived_ns: int | None = None
        self._command_misses = self._status_misses = 0
        self.start(Timer.AGENT, options.agent_wait_s, since_ns=epoch_ns)

    @property
    def misses(self) -> Mapping[Waited, tuple[int, int]]:
        """How many deadlines of each kind were missed in a row, and at how many the mode changes."""
        most = self._options.misses
        return {Waited.COMMAND: (self._command_misses, most), Waited.STATUS: (self._status_misses, most)}

    # --- what comes in

    def receive(self, data: bytes) -> None:
        """Takes bytes of the simulator that came now."""
        if self._dead:
            self.counters.lost_bytes += len(data)
        else:
            self._take(self.reader.receive(data, self.now_ns))

    def expire_bytes(self) -> None:
        """Lets the reader give up what is due."""
        self._take(self.reader.expire(self.now_ns))

    def line_error(self) -> None:
        """An overrun or framing error on the simulator's line."""
        self.counters.line_errors += 1
        if self._options.dies_on_line_error and not self._dead:
            self._dead = True
            self.events.append(LineDead())

    def command(self, command: ControlCommand) -> None:
        """A command of the driving stack."""
        frame = command.frame(self._options.steering_factor)
        encode_command(frame)
        self.sign_of_stack()
        if not self.stack.hands_on(self.mode):
            self.counters.commands_unused += 1
            return
        reason = command_fault(self._options, frame)
        if reason is not None:
            self.counters.commands_refused += 1
            self.events.append(CommandRefused(reason=_REFUSALS[reason]))
            return
        self.counters.commands += 1
        self._action = frame
        if self.state is Step.AUTOWARE_COMMAND:
            self.fire(Trigger.COMMAND)
        else:
            self._command_waits = True

    def request(self, mode: int) -> None:
        """A request of the driving stack for a mode."""
        self.sign_of_stack()
        if not self.stack.online or not self.stack.answer(mode, self.mode):
            return
        asked = Mode(mode)
        if self._options.own_mode:
            self._tell_own_mode(asked)
        self.stack.remember(asked)

    def press(self) -> None:
        """A rising edge of the joystick's switch, bounces and all."""
        tick = (self.now_ns - self._epoch_ns) // _TICK_NS
        if tick <= self._press_tick + round(self._options.debounce_s * _TICKS_PER_S):
            self._ignore_press(Refusal.TOO_EARLY)
            return
        self.counters.presses += 1
        self._press_tick = tick
        self._pressed = True

    def joystick(self, x: int, y: int) -> None:
        """Where the joystick is from now on, as the converter reads it.

        Raises:
            LocalProtocolError: a reading is not 0..65535; nothing is changed then.
        """
        for reading in (x, y):
            if not 0 <= reading <= FULL_SCALE:
                raise LocalProtocolError(f"reading {reading} is not 0..{FULL_SCALE}")
        self._stick = (x, y)

    def sign_of_stack(self) -> None:
        """A sign of life of the driving stack."""
        starting = self.state is Step.STARTING
        if self.stack.sign(self.now_ns, starting=starting) and starting:
            self.fire(Trigger.AGENT)

    def _emit(self, event: Event) -> None:
        self.events.append(event)

    def _tell_own_mode(self, asked: Mode) -> None:
        """The micro-ROS task tells itself by a flag, which the control task may take away."""
        if self._options.flag_clash and asked is Mode.AUTOWARE and self.state is Step.MANUAL_STATUS:
            self.counters.flags_eaten += 1
            self.fire(Trigger.STATUS)
        else:
            self.stack.tell(asked, self.now_ns)

    def _take(self, found: list[Found]) -> None:
        for item in found:
            if isinstance(item, Dropped):
                self.counters.drop(item.reason)
                self.events.append(FrameDropped(reason=item.reason, data=item.data))
            elif isinstance(item, StatusFrame):
                self._status(item)

    def _status(self, status: StatusFrame) -> None:
        reason = None if isinstance(self.reader, StreamReader) else status_fault(self._options, status)
        if reason is not None:
            self._take([Dropped(reason=reason, data=STATUS_LAYOUT.encode(status))])
            return
        self.counters.frames_in += 1
        self._known = status
        self._unreported = True
        self.events.append(StatusReceived(status=status))
        if self.has_edge(Trigger.STATUS) and not self._waits_at_wrong_flag():
            self.fire(Trigger.STATUS)
        else:
            self._arrived_ns = self.now_ns

    def _waits_at_wrong_flag(self) -> bool:
        return self._options.flag_clash and self.state is Step.MANUAL_STATUS

    # --- the control task

    def trigger_of(self, timer: Timer) -> Trigger:
        """The trigger of a timer that has run out."""
        match timer:
            case Timer.AGENT:
                return Trigger.NO_AGENT
            case Timer.PAUSE:
                return Trigger.PAUSE_OVER
            case Timer.COMMAND:
                return self._command_missed()
            case Timer.STATUS:
                return Trigger.STATUS_MISSED if self.state is Step.EMERGENCY_STATUS else self._status_missed()

    def act(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""
        match action:
            case Action.LOOK:
                self._look()
            case Action.BRANCH:
                self.fire(BLOCK_OF_MODE[self.mode])
            case Action.CHANGE_MODE:
                self._change_mode(MODE_OF_STEP[trigger])
            case Action.SHOW_MODE:
                self._show_mode()
            case Action.WAIT_COMMAND | Action.WAIT_STATUS | Action.WAIT_PAUSE:
                self._wait(action)
            case Action.FORGET_COMMAND_MISSES:
                self._command_misses = 0
            case Action.FORGET_STATUS_MISSES:
                self._status_misses = 0
            case Action.REPORT_STATUS | Action.REPORT_OLD_STATUS:
                self._report_status(old=action is Action.REPORT_OLD_STATUS)
            case _:
                self._send(action)

    def state_changed(self, old: Step, trigger: Trigger) -> None:
        """Nobody is told of steps: `ModeChanged`, `Transmit` and the reports say what can be seen of them."""

    def to_transmit(self, frame: bytes) -> Event:
        """The event that wants a frame on the line."""
        return Transmit(data=frame, frame=self._sent)

    def next_deadline_ns(self) -> int | None:
        """When a wait ends or the driving stack's side has something to do, in ns of bench time."""
        return earliest(super().next_deadline_ns(), self.stack.next_deadline_ns())

    def expire_next(self) -> None:
        """Lets the earliest thing happen; the control task comes first, as it has the higher priority."""
        stack_ns, task_ns = self.stack.next_deadline_ns(), super().next_deadline_ns()
        if task_ns is None or (stack_ns is not None and stack_ns < task_ns):
            self.stack.expire(self.now_ns)
        else:
            super().expire_next()

    def _look(self) -> None:
        request = self.stack.take_request(self.mode)
        if request is not None:
            self._change_mode(request)
        pressed, self._pressed = self._pressed, False
        if pressed:
            self._take_press()
        if self.stack.watched and not self.stack.online and self.mode is Mode.AUTOWARE:
            self._change_mode(ModeTrigger.AGENT_LOST)
        self.fire(BLOCK_OF_MODE[self.mode])

    def _take_press(self) -> None:
        if (self.mode, ModeTrigger.PRESS) not in self.modes:
            self._ignore_press(Refusal.EMERGENCY)
        elif self.mode is Mode.MANUAL and self.stack.watched and not self.stack.online:
            self._ignore_press(Refusal.NO_AGENT)
        else:
            self._change_mode(ModeTrigger.PRESS)

    def _ignore_press(self, reason: Refusal) -> None:
        self.counters.presses_ignored += 1
        self.events.append(PressIgnored(reason=reason))

    def _change_mode(self, trigger: ModeTrigger) -> None:
        edge = self.modes.get((self.mode, trigger))
        if edge is None:
            self.counters.ignored += 1
            return
        old, self.mode = self.mode, edge.next_mode
        self.mode_visits[old, trigger] += 1
        if self.mode is old:
            return
        self.counters.mode_changes += 1
        self.counters.emergencies += self.mode is Mode.EMERGENCY
        if not self._options.shared_action:
            self._command_waits = False
        self.events.append(ModeChanged(old=old, new=self.mode, trigger=trigger))
        self.stack.mode_changed(self.mode, trigger, self.now_ns)

    def _show_mode(self) -> None:
        if self._lamp is not self.mode:
            self._lamp = self.mode
            self.events.append(LampChanged(mode=self.mode))

    # --- waits

    def _wait(self, action: Action) -> None:
        match action:
            case Action.WAIT_COMMAND if self._command_waits:
                self._command_waits = False
                self.fire(Trigger.COMMAND)
            case Action.WAIT_COMMAND:
                self.start(Timer.COMMAND, self._options.command_deadline_s)
            case Action.WAIT_STATUS if self._status_waits():
                self._arrived_ns = None
                self.fire(Trigger.STATUS)
            case Action.WAIT_STATUS:
                self.start(Timer.STATUS, self._options.status_deadline_s)
            case _:
                self.start(Timer.PAUSE, self._options.manual_pause_s)

    def _status_waits(self) -> bool:
        """A status has come since the last one was taken, and the wait is for statuses."""
        if self._arrived_ns is None or self._waits_at_wrong_flag():
            return False
        age_ns = self.now_ns - self._arrived_ns
        if self._options.fresh_only and age_ns > round(self._options.status_deadline_s * _NS_PER_S):
            self.counters.stale_dropped += 1
            self._arrived_ns = None
            return False
        return True

    def _command_missed(self) -> Trigger:
        lost = self._options.watch_while_waiting and self._watch()
        self._command_misses = self._missed(Waited.COMMAND, self._command_misses)
        self.counters.command_misses += 1
        if lost:
            return Trigger.STATUS_LOST
        return Trigger.COMMAND_MISSED if self._command_misses else Trigger.COMMANDS_LOST

    def _status_missed(self) -> Trigger:
        self._status_misses = self._missed(Waited.STATUS, self._status_misses)
        self.counters.status_misses += 1
        return Trigger.STATUS_MISSED if self._status_misses else Trigger.STATUS_LOST

    def _missed(self, what: Waited, misses: int) -> int:
        """Counts one more miss; 0 if it is one too many."""
        self.events.append(DeadlineMissed(what=what, misses=misses + 1))
        return (misses + 1) % self._options.misses

    def _watch(self) -> bool:
        """Takes the status that came since the last look, or counts that none did; returns whether it is lost."""
        if self._arrived_ns is None:
            return self._status_missed() is Trigger.STATUS_LOST
        self._arrived_ns = None
        self._status_misses = 0
        self._report_status(old=False)
        return False

    # --- what goes out

    def _report_status(self, *, old: bool) -> None:
        if old and not self._options.republish_stale:
            return
        fresh = not old and self._unreported
        if not old:
            self._reported = self._known
            self._unreported = False
        if self.stack.online:
            self.counters.status_reports += 1
            self.counters.stale_reports += not fresh
            self.events.append(StatusReported(status=self._reported, fresh=fresh))

    def _send(self, action: Action) -> None:
        match action:
            case Action.SEND_COMMAND:
                self._send_frame(self._action)
            case Action.SEND_AGAIN:
                self._send_again()
            case Action.SEND_JOYSTICK:
                x, y = self._stick
                options = self._options
                command = manual_command(
                    x, y, clamp=options.clamp_joystick, x_axis=options.x_axis, y_axis=options.y_axis
                )
                self._send_frame(command.frame(), shared=True)
            case Action.SEND_EMERGENCY:
                self._send_frame(CommandFrame(mode=Mode.EMERGENCY), shared=True)

    def _send_again(self) -> None:
        sent = self._sent
        if sent is None:
            if self._options.uninitialised:
                self.counters.uninitialised += 1
                self.transmit(UNINITIALISED_FRAME)
        elif self._options.missed_command is MissedCommand.AGAIN:
            self.counters.sent_again += 1
            self._send_frame(sent)
        else:
            self.counters.stops_sent += 1
            held = sent.steering if sent.mode == Mode.AUTOWARE else 0.0
            self._send_frame(CommandFrame(steering=held, mode=Mode.AUTOWARE))

    def _send_frame(self, frame: CommandFrame, *, shared: bool = False) -> None:
        """Sends a frame; `shared` says that it is written where a command may be waiting."""
        if shared and self._options.shared_action:
            self._action = frame
        data = encode_command(frame)
        self._sent = frame
        self.transmit(data)
