"""Faulty vehicle interfaces: the defects of the published firmwares, one by one, and what else one gets wrong.

Also the reverse: the published firmwares without one of their defects, which the clauses that describe it must notice.
``python -m tests.mutants.vehicle`` runs the suite ``vehicle-board`` against each, writes ``docs/vehicle-defects.md``.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.results import Report
from hilbench.config import open_bench
from hilbench.journal import Journal
from hilbench.mcu.board_provider import BoardProvider
from hilbench.options import TargetChoice
from hilbench.shared import Shared
from hilbench.vehicle_provider import VehicleProvider
from protocols.autoware import (
    AckermannControlCommand,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    FrameReader,
    HazardLights,
    HazardLightsCommand,
    SteeringReport,
    Time,
    VelocityReport,
)
from protocols.autoware.crc import crc16
from protocols.carla import (
    FULL_SCALE,
    MODE_TABLE,
    STATUS_BYTES,
    STATUS_LAYOUT,
    STEP_TABLE,
    VECTORS,
    X_AXIS,
    Y_AXIS,
    Action,
    Axis,
    CommandFrame,
    DeadlineMissed,
    Dropped,
    DropReason,
    FrameDropped,
    Mode,
    ModeAnswered,
    ModeChanged,
    ModeTable,
    ModeTransition,
    ModeTrigger,
    StatusReported,
    Step,
    StreamReader,
    Table,
    Transition,
    Trigger,
    Waited,
    decode_command,
    decode_status,
    encode_command,
)
from protocols.carla.clauses import BOARD_CLAUSES
from targets.firmware import image_path
from targets.robots.vehicle_interface import (
    BEHAVIOURS,
    DEFECTS,
    SIMULATOR_LINE,
    VehicleInterface,
    VehicleSettings,
    behaviour_of,
)

_ROW = re.compile(r"^\| `(?P<name>[^`]+)` \|.*\| (?P<clauses>[^|]*) \|$", re.MULTILINE)
_FIRMWARE = re.compile(r"^\| `(?P<name>[^`]+)` \|[^|]*\|[^|]*\| (?P<clauses>[^|]*) \| [^|]* \|$", re.MULTILINE)
_LEVELS = {clause.id: clause.level for clause in BOARD_CLAUSES}

PAGE = Path(__file__).parents[2] / "docs" / "vehicle-defects.md"

SHOWN = 1
"""So many of the clauses that find a defect in the model are run on the emulated board."""

SLOW = ("VB03", "VB25", "VB31", "VB31H", "VB42", "VB42H")
"""What takes 20 s of bench time and more is run on faults that it is about, and on the emulated board only where
nothing else finds the defect."""

HAZARDS = tuple(clause.id for clause in BOARD_CLAUSES if "hardened" not in clause.profiles and clause.id not in SLOW)
"""Clauses that describe what the published firmwares should not do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleMutant:
    """A board with one fault.

    Attributes:
        id: stable name.
        what: what it does wrong.
        profile: of the cases that have to find it.
        about: the clauses that it is run against; empty for all but the `SLOW` ones.
        board: what is wrong with its options.
        body: likewise with its quirks beside the lines.
        steps: changed edges of its control task.
        modes: its table of modes, if that is another one.
        kind: the class that it is made of.
    """

    id: str
    what: str
    profile: str = "hardened"
    about: tuple[str, ...] = ()
    board: Mapping[str, Any] = field(default_factory=dict)
    body: Mapping[str, Any] = field(default_factory=dict)
    steps: Mapping[tuple[Step, Trigger], Transition] = field(default_factory=dict)
    modes: ModeTable | None = None
    kind: type[VehicleInterface] = VehicleInterface

    def make(self, settings: VehicleSettings) -> VehicleInterface:
        """Makes the board, in the profile that a case asks for."""
        behaviour = behaviour_of(settings)
        changed = replace(
            behaviour, board=replace(behaviour.board, **self.board), body=replace(behaviour.body, **self.body)
        )
        steps: Table = {**STEP_TABLE, **self.steps}
        return self.kind(settings, behaviour=changed, steps=steps, modes=self.modes)


class _GrantsAll(VehicleInterface):
    def _told(self, event):
        if isinstance(event, ModeAnswered):
            event = replace(event, success=True)
        return super()._told(event)


class _SplitsAtHash(VehicleInterface):
    """Takes each # for the beginning of a frame, also within a float."""

    _seen = 0

    def receive(self, line, data, now_ns):
        if line == SIMULATOR_LINE and data == b"#" and self._seen % STATUS_BYTES:
            self._seen = 0
            return super().receive(line, b"\0" + data, now_ns)
        if line == SIMULATOR_LINE:
            self._seen += len(data)
        return super().receive(line, data, now_ns)


class _TakesHashes(VehicleInterface):
    """Takes 22 bytes for a status, whatever they are."""

    _hashes = 0

    def receive(self, line, data, now_ns):
        if line == SIMULATOR_LINE:
            self._hashes = self._hashes + 1 if data == b"#" else 0
            if self._hashes == STATUS_BYTES:
                data = VECTORS["F4"].data
        return super().receive(line, data, now_ns)


class _NoReverse(VehicleInterface):
    """Hands commands on without their signs."""

    def _obey(self, message, now_ns):
        if isinstance(message, AckermannControlCommand):
            message = replace(
                message,
                steering_tire_angle=abs(message.steering_tire_angle),
                acceleration=max(0.0, message.acceleration),
            )
        return super()._obey(message, now_ns)


class _ForgivesJerk(VehicleInterface):
    """Takes a command whose jerk cannot be for one without jerk."""

    def _obey(self, message, now_ns):
        if isinstance(message, AckermannControlCommand) and not abs(message.jerk) < 1000.0:
            message = replace(message, jerk=0.0)
        return super()._obey(message, now_ns)


class _GrantsMore(VehicleInterface):
    """Takes every mode but 2 for MANUAL."""

    def _obey(self, message, now_ns):
        if isinstance(message, ControlModeRequest) and message.mode not in (1, 2, 4):
            message = replace(message, mode=4)
        return super()._obey(message, now_ns)


class _Tells(VehicleInterface):
    """Changes what it tells the driving stack."""

    def _told(self, event):
        return [other for message in super()._told(event) for other in self.instead(message)]

    def instead(self, message):
        return [message]


class _ExchangesFields(_Tells):
    def instead(self, message):
        if isinstance(message, VelocityReport):
            message = replace(message, lateral_velocity=message.heading_rate, heading_rate=message.lateral_velocity)
        return [message]


class _HidesSteering(_Tells):
    def instead(self, message):
        return [] if isinstance(message, SteeringReport) else [message]


class _TellsTheOneBefore(_Tells):
    _before = None

    def instead(self, message):
        if not isinstance(message, VelocityReport):
            return [message]
        before, self._before = self._before, message
        return [before or message]


class _TellsStatusesTwice(_Tells):
    def instead(self, message):
        return [message] * (2 if isinstance(message, VelocityReport | SteeringReport) else 1)


class _AnswersTwice(_Tells):
    def instead(self, message):
        return [message] * (2 if isinstance(message, ControlModeResponse) else 1)


class _TellsManual(_Tells):
    def instead(self, message):
        return [replace(message, mode=4) if isinstance(message, ControlModeReport) else message]


class _StampsNothing(_Tells):
    def instead(self, message):
        return [replace(message, stamp=Time()) if hasattr(message, "stamp") else message]


class _NeverLooksBack(StreamReader):
    """Throws away all it holds at the first wrong letter."""

    def _give_up(self, reason):
        self._found.append(Dropped(reason=reason, data=bytes(self._held)))
        self._held.clear()
        self._times = []


class _CannotResynchronise(VehicleInterface):
    def _begin(self, now_ns):
        super()._begin(now_ns)
        self.simulator._machine.reader = _NeverLooksBack(STATUS_LAYOUT, lambda _frame: None, timeout_ns=100_000_000)


class _CubicAxis(Axis):
    """Softer in the middle."""

    def position(self, reading):
        return super().position(reading) ** 3


def _cubic(axis):
    return _CubicAxis(least=axis.least, zero=axis.zero, greatest=axis.greatest, dead_band=axis.dead_band)


class _Sends(VehicleInterface):
    """Changes what it puts on the simulator's line."""

    def _from_simulator(self, events, now_ns):
        sent = super()._from_simulator(events, now_ns)
        return [(line, self.changed(data) if line == SIMULATOR_LINE else data) for line, data in sent]

    def changed(self, data):
        return data


class _KeepsThrottle(_Sends):
    """In EMERGENCY the mode alone changes: what it had last said in MANUAL goes on."""

    _last = CommandFrame()

    def changed(self, data):
        frame = decode_command(data)
        if frame.mode == Mode.EMERGENCY:
            return encode_command(replace(self._last, mode=Mode.EMERGENCY))
        if frame.mode == Mode.MANUAL:
            self._last = frame
        return data


class _OneMoreStop(_Sends):
    """Sends F3 once more, before the first frame of MANUAL."""

    _before = Mode.AUTOWARE

    def changed(self, data):
        before, self._before = self._before, decode_command(data).mode
        stopped = before == Mode.EMERGENCY and self._before == Mode.MANUAL
        return VECTORS["F3"].data + data if stopped else data


class _Noise(_Sends):
    """Behind what is no command of the driving stack stands something else than a NUL."""

    def changed(self, data):
        return data if decode_command(data).mode == Mode.AUTOWARE else data[:-1] + b"\xff\x55\xaa"


class _ActsOnPress(VehicleInterface):
    """Acts as the switch closes, not as it opens."""

    def hold(self, now_ns):
        return super().press(now_ns)

    def press(self, now_ns):
        return self.advance(now_ns)


class _LooksAtNoCrc(FrameReader):
    def _finish(self, payload, crc):
        super()._finish(payload, crc16(payload))


class _BelievesTheLink(VehicleInterface):
    """Takes messages of the driving stack whose CRC is wrong."""

    def _begin(self, now_ns):
        super()._begin(now_ns)
        self.stack._reader = _LooksAtNoCrc()


class _TellsModesLate(_Tells):
    """Reports the mode of three reports before."""

    def __init__(self, *arguments, **options):
        self._modes = deque([Mode.AUTOWARE] * 3, maxlen=3)
        super().__init__(*arguments, **options)

    def instead(self, message):
        if not isinstance(message, ControlModeReport):
            return [message]
        late = self._modes[0]
        self._modes.append(message.mode)
        return [replace(message, mode=late)]


class _StampsTooSoon(_Tells):
    """Has a time of its own before it is told one."""

    def instead(self, message):
        early = hasattr(message, "stamp") and message.stamp == Time()
        return [replace(message, stamp=Time(1, 0)) if early else message]


class _TellsTheOneBeforeInAutoware(_TellsTheOneBefore):
    def instead(self, message):
        late = super().instead(message)
        return late if self.simulator.mode is Mode.AUTOWARE else [message]


class _NoRed(VehicleInterface):
    """Shows EMERGENCY by the green light."""

    def _from_simulator(self, events, now_ns):
        sent = super()._from_simulator(events, now_ns)
        self.light = "green" if self.light == "red" else self.light
        return sent


class _BrakesFirst(_Sends):
    """AUTOWARE begins with a stop."""

    _before = Mode.AUTOWARE

    def changed(self, data):
        frame, before = decode_command(data), self._before
        self._before = frame.mode
        begins = frame.mode == Mode.AUTOWARE != before
        return encode_command(replace(frame, speed=0.0, acceleration=0.0, jerk=0.0)) if begins else data


class _ReturnsByItself(VehicleInterface):
    """Takes a command after a second without any for a request for AUTOWARE."""

    _command_ns = None

    def _obey(self, message, now_ns):
        sent = super()._obey(message, now_ns)
        if isinstance(message, AckermannControlCommand):
            before_ns, self._command_ns = self._command_ns, now_ns
            if before_ns is not None and now_ns - before_ns > 1_000_000_000:
                sent += super()._obey(ControlModeRequest(sequence=255, mode=Mode.AUTOWARE), now_ns)
        return sent


class _OnePressEver(VehicleInterface):
    def press(self, now_ns):
        if self.simulator.counters.presses:
            return []
        return super().press(now_ns)


class _ReversesOn(_Sends):
    """Without a command it stops a car that drives forwards, and no other."""

    _last = CommandFrame()

    def changed(self, data):
        frame = decode_command(data)
        if frame.mode == Mode.AUTOWARE and frame.speed == 0.0 and self._last.speed < 0.0:
            return encode_command(self._last)
        self._last = frame
        return data


class _ImpatientBehindEmergency(VehicleInterface):
    """Behind an emergency goes on with a count of eight missed statuses."""

    def _from_simulator(self, events, now_ns):
        events = list(events)
        if any(isinstance(event, ModeChanged) and event.old is Mode.EMERGENCY for event in events):
            self.simulator._machine._status_misses = 8
        return super()._from_simulator(events, now_ns)


class _RemembersRefused(VehicleInterface):
    """Obeys a request for AUTOWARE that it refused, as soon as the emergency is over."""

    _refused = False

    def _from_simulator(self, events, now_ns):
        events = list(events)
        for event in events:
            if isinstance(event, ModeAnswered) and event.mode == Mode.AUTOWARE and not event.success:
                self._refused = True
            elif isinstance(event, ModeChanged) and event.old is Mode.EMERGENCY and self._refused:
                self.simulator._machine.stack.remember(Mode.AUTOWARE)
        return super()._from_simulator(events, now_ns)


class _StaleInManual(VehicleInterface):
    """In MANUAL reports the old status at a missed one."""

    _last = None

    def _told(self, event):
        if isinstance(event, StatusReported):
            self._last = event
        missed = isinstance(event, DeadlineMissed) and event.what is Waited.STATUS
        if missed and self.simulator.mode is Mode.MANUAL and self._last is not None:
            event = self._last
        return super()._told(event)


class _Mends(VehicleInterface):
    """Reports a status that cannot be with a 0 for what cannot be in it."""

    def _told(self, event):
        if isinstance(event, FrameDropped) and event.reason in (DropReason.NOT_FINITE, DropReason.IMPLAUSIBLE):
            status = decode_status(event.data)
            figures = {name: getattr(status, name) for name in status.__dataclass_fields__}
            possible = {name: value if abs(value) <= 2.0 else 0.0 for name, value in figures.items()}
            event = StatusReported(status=replace(status, **possible), fresh=True)
        return super()._told(event)


class _HazardForEver(VehicleInterface):
    def _obey(self, message, now_ns):
        ends = isinstance(message, HazardLightsCommand) and message.command == HazardLights.DISABLE
        return [] if ends else super()._obey(message, now_ns)


class _HazardEndsByNothing(VehicleInterface):
    def _obey(self, message, now_ns):
        if isinstance(message, HazardLightsCommand) and message.command == HazardLights.NO_COMMAND:
            message = replace(message, command=HazardLights.DISABLE)
        return super()._obey(message, now_ns)


class _WatchedInAutoware(VehicleInterface):
    """Has a watchdog that sleeps in MANUAL."""

    def hang(self, now_ns):
        if self.simulator.mode is Mode.MANUAL:
            self.behaviour = replace(self.behaviour, body=replace(self.behaviour.body, watchdog_s=None))
        return super().hang(now_ns)


def _limited(**limits: float) -> dict[str, Any]:
    return {"status_limits": replace(BEHAVIOURS["hardened"].board.status_limits, **limits)}  # type: ignore[type-var]


def _without(step: Step, trigger: Trigger, action: Action) -> dict[tuple[Step, Trigger], Transition]:
    edge = STEP_TABLE[step, trigger]
    return {(step, trigger): replace(edge, actions=tuple(one for one in edge.actions if one is not action))}


def _modes_with(mode: Mode, trigger: ModeTrigger, next_mode: Mode) -> ModeTable:
    return {**MODE_TABLE, (mode, trigger): ModeTransition(next_mode)}


def _modes_without(mode: Mode, trigger: ModeTrigger) -> ModeTable:
    return {at: edge for at, edge in MODE_TABLE.items() if at != (mode, trigger)}


_S, _T, _A = Step, Trigger, Action

PUBLISHED = tuple(
    VehicleMutant(
        id=defect.name,
        what=defect.text,
        about=("VB31H", "VB42H", "VB55H") if defect.name == "H9" else (),
        board=defect.board,
        body=defect.body,
    )
    for defect in DEFECTS.values()
)
_SLOW_OF = {"v0-without-H2": ("VB25",), "v0-without-H9": ("VB31", "VB42"), "v0-without-H6": ("VB31",)}


def _cures() -> Iterator[VehicleMutant]:
    """The published firmwares with one thing right: what the clauses of their hazards must notice."""
    hardened = BEHAVIOURS["hardened"].board
    for defect in DEFECTS.values():
        right = {name: getattr(hardened, name) for name in defect.board}
        for profile in ("v0", "v1"):
            shipped = BEHAVIOURS[profile].board
            wrong = {name: value for name, value in defect.board.items() if getattr(shipped, name) == value}
            if wrong == dict(defect.board) and right != wrong and not (profile == "v1" and "own_mode" in wrong):
                what = f"the firmware of {profile} without {defect.name}"
                name = f"{profile}-without-{defect.name}"
                about = (*HAZARDS, *_SLOW_OF.get(name, ()))
                yield VehicleMutant(id=name, what=what, profile=profile, about=about, board=right)
                break
    yield VehicleMutant(
        id="v1-without-V1",
        what="the firmware of v1 without V1",
        profile="v1",
        about=("VB22", "VB23"),
        board={"flag_clash": False},
    )
    yield VehicleMutant(
        id="v1-without-emergency-manual",
        what="the firmware of v1 without emergency-manual",
        profile="v1",
        about=("VB37",),
        board={"emergency_report": hardened.emergency_report},
    )

    yield VehicleMutant(
        id="v0-without-no-watchdog",
        what="the firmware of v0 with a watchdog",
        profile="v0",
        about=("VB56",),
        body={"watchdog_s": BEHAVIOURS["hardened"].body.watchdog_s},
    )


CURES = tuple({mutant.id: mutant for mutant in _cures()}.values())

BY_HAND = (
    VehicleMutant(
        id="agent-10s", what="an agent is waited for for 10 s", about=("VB03",), board={"agent_wait_s": 10.0}
    ),
    VehicleMutant(
        id="no-debounce",
        what="each edge of the switch is a press",
        about=(
            "VB13",
            "VB14",
        ),
        board={"debounce_s": 0.001},
    ),
    VehicleMutant(
        id="narrow-dead-band",
        what="a dead band of 400",
        about=("VB16",),
        board={"x_axis": replace(X_AXIS, dead_band=400), "y_axis": replace(Y_AXIS, dead_band=400)},
    ),
    VehicleMutant(
        id="zero-off",
        what="the joystick's middle is taken to be 1000 lower",
        about=(
            "VB15",
            "VB16",
        ),
        board={"x_axis": replace(X_AXIS, zero=32_970), "y_axis": replace(Y_AXIS, zero=32_580)},
    ),
    VehicleMutant(
        id="upper-end-off",
        what="the joystick's upper ends are taken to be higher",
        about=("VB17",),
        board={"x_axis": replace(X_AXIS, greatest=FULL_SCALE + 2000), "y_axis": replace(Y_AXIS, greatest=70_000)},
    ),
    VehicleMutant(
        id="lower-end-off",
        what="the joystick's lower ends are taken to be lower",
        about=(
            "VB18",
            "VB34H",
        ),
        board={"x_axis": replace(X_AXIS, least=0), "y_axis": replace(Y_AXIS, least=0)},
    ),
    VehicleMutant(
        id="long-pause",
        what="MANUAL rests for 120 ms",
        about=(
            "VB19",
            "VB20",
            "VB21",
        ),
        board={"manual_pause_s": 0.120},
    ),
    VehicleMutant(
        id="late-status",
        what="a status is waited for for 120 ms",
        about=(
            "VB07",
            "VB21",
        ),
        board={"status_deadline_s": 0.120},
    ),
    VehicleMutant(
        id="early-command",
        what="a command is waited for for 90 ms",
        about=(
            "VB05H",
            "VB30H",
        ),
        board={"command_deadline_s": 0.090},
    ),
    VehicleMutant(
        id="nine-misses",
        what="nine misses change the mode",
        about=(
            "VB05H",
            "VB06",
            "VB07",
            "VB21",
        ),
        board={"misses": 9},
    ),
    VehicleMutant(
        id="hasty-reader",
        what="half a status is given up after 20 ms",
        about=("VB26",),
        board={"frame_timeout_s": 0.020},
    ),
    VehicleMutant(
        id="misses-go-on",
        what="a command does not begin the count of misses again",
        about=("VB06",),
        steps=_without(_S.AUTOWARE_COMMAND, _T.COMMAND, _A.FORGET_COMMAND_MISSES),
    ),
    VehicleMutant(
        id="status-misses-go-on",
        what="in AUTOWARE a status does not begin the count of misses again",
        about=("VB44",),
        steps=_without(_S.AUTOWARE_STATUS, _T.STATUS, _A.FORGET_STATUS_MISSES),
    ),
    VehicleMutant(
        id="manual-misses-go-on",
        what="in MANUAL a status does not begin the count of misses again",
        about=("VB45",),
        steps=_without(_S.MANUAL_STATUS, _T.STATUS, _A.FORGET_STATUS_MISSES),
    ),
    VehicleMutant(
        id="throttle-in-emergency",
        what="EMERGENCY has the values of the joystick",
        about=("VB21",),
        kind=_KeepsThrottle,
    ),
    VehicleMutant(
        id="one-more-stop",
        what="a status in EMERGENCY is followed by F3 once more",
        about=("VB08",),
        kind=_OneMoreStop,
    ),
    VehicleMutant(id="no-reverse", what="commands lose their signs", about=("VB01",), kind=_NoReverse),
    VehicleMutant(
        id="jerk-unseen",
        what="a command whose jerk cannot be is handed on without it",
        about=("VB41H",),
        kind=_ForgivesJerk,
    ),
    VehicleMutant(
        id="heading-rate-unseen",
        what="a heading rate may be anything finite",
        about=("VB35H",),
        board={"status_limits": replace(BEHAVIOURS["hardened"].board.status_limits, heading_rate_rad_s=1e38)},
    ),
    VehicleMutant(id="grants-more", what="all modes but 2 are taken for MANUAL", about=("VB12",), kind=_GrantsMore),
    VehicleMutant(
        id="soft-joystick",
        what="the joystick's positions are cubed",
        about=("VB46",),
        board={"x_axis": _cubic(X_AXIS), "y_axis": _cubic(Y_AXIS)},
    ),
    VehicleMutant(
        id="fields-exchanged",
        what="lateral speed and heading rate are exchanged",
        about=("VB24", "VB26"),
        kind=_ExchangesFields,
    ),
    VehicleMutant(
        id="no-steering-report", what="the steering is not reported", about=("VB24", "VB26"), kind=_HidesSteering
    ),
    VehicleMutant(
        id="one-status-behind",
        what="the status before is reported",
        about=("VB19",),
        kind=_TellsTheOneBefore,
    ),
    VehicleMutant(id="statuses-twice", what="each status is reported twice", about=("VB53",), kind=_TellsStatusesTwice),
    VehicleMutant(id="answers-twice", what="each request is answered twice", about=("VB12",), kind=_AnswersTwice),
    VehicleMutant(id="tells-manual", what="the mode reported is always 4", about=("VB48",), kind=_TellsManual),
    VehicleMutant(
        id="seldom-told", what="the mode is reported every 0.45 s", about=("VB48",), board={"mode_report_s": 0.45}
    ),
    VehicleMutant(id="no-stamps", what="each stamp is 0", about=("VB49",), kind=_StampsNothing),
    VehicleMutant(
        id="no-looking-back",
        what="a false beginning takes the true one behind it along",
        about=("VB25H",),
        kind=_CannotResynchronise,
    ),
    VehicleMutant(
        id="patient-reader",
        what="half a status is never given up",
        about=("VB47",),
        board={"frame_timeout_s": None},
    ),
    VehicleMutant(id="acts-on-press", what="the switch acts as it closes", about=("VB51",), kind=_ActsOnPress),
    VehicleMutant(
        id="no-crc",
        what="messages on the stand-in link are believed, whatever their CRC",
        about=("VB50",),
        kind=_BelievesTheLink,
    ),
    VehicleMutant(id="mode-told-late", what="the mode is reported 0.2 s late", about=("VB48",), kind=_TellsModesLate),
    VehicleMutant(
        id="own-clock", what="stamps begin at 1 s, before a clock is told", about=("VB52",), kind=_StampsTooSoon
    ),
    VehicleMutant(
        id="one-behind-in-autoware",
        what="in AUTOWARE the status before is reported",
        about=("VB53",),
        kind=_TellsTheOneBeforeInAutoware,
    ),
    VehicleMutant(id="no-red", what="EMERGENCY lights the green lamp", about=("VB54",), kind=_NoRed),
    VehicleMutant(id="hasty-lamps", what="lamps blink at 8 Hz", about=("VB43",), body={"blink_hz": 8.0}),
    VehicleMutant(id="slow-lamps", what="lamps blink at 0.7 Hz", about=("VB43",), body={"blink_hz": 0.7}),
    VehicleMutant(
        id="lost-at-once",
        what="a driving stack that is silent for 2 s is lost",
        about=("VB55H",),
        board={"agent_silence_s": 2.0},
    ),
    VehicleMutant(
        id="lost-after-an-hour",
        what="a driving stack is lost after an hour of silence",
        about=("VB55H",),
        board={"agent_silence_s": 3600.0},
    ),
    VehicleMutant(id="lazy-watchdog", what="the watchdog waits for 5 s", about=("VB56H",), body={"watchdog_s": 5.0}),
    VehicleMutant(
        id="late-debounce", what="presses 1.01 s apart are one", about=("VB13", "VB14"), board={"debounce_s": 1.02}
    ),
    VehicleMutant(
        id="short-debounce",
        what="presses 0.99 s apart are two, and 0.98 s are blind",
        about=("VB13", "VB14"),
        board={"debounce_s": 0.98},
    ),
    VehicleMutant(
        id="one-press-ever", what="the second press does nothing, nor any after it", about=("VB13",), kind=_OnePressEver
    ),
    VehicleMutant(
        id="noise-behind",
        what="FF 55 AA stands behind frames of the modes 0 and 4 instead of the NUL",
        about=("VB08", "VB21"),
        kind=_Noise,
    ),
    VehicleMutant(
        id="waits-for-nothing",
        what="commands are handed on without waiting for a status",
        about=(
            "VB02",
            "VB07",
        ),
        steps={(_S.AUTOWARE_COMMAND, _T.COMMAND): Transition(_S.AUTOWARE_END, (_A.SEND_COMMAND, _A.BRANCH))},
    ),
    VehicleMutant(
        id="dark-manual",
        what="MANUAL lights no lamp",
        about=("VB08",),
        steps=_without(_S.LOOP_TOP, _T.MANUAL, _A.SHOW_MODE) | _without(_S.AUTOWARE_END, _T.MANUAL, _A.SHOW_MODE),
    ),
    VehicleMutant(
        id="quiet-manual",
        what="in MANUAL no status is reported",
        about=("VB19",),
        steps=_without(_S.MANUAL_STATUS, _T.STATUS, _A.REPORT_STATUS),
    ),
    VehicleMutant(
        id="straight-to-autoware",
        what="EMERGENCY ends in AUTOWARE",
        about=(
            "VB08",
            "VB09",
            "VB10",
        ),
        modes=_modes_with(Mode.EMERGENCY, ModeTrigger.STATUS_RETURNS, Mode.AUTOWARE),
    ),
    VehicleMutant(
        id="press-ends-emergency",
        what="a press ends EMERGENCY",
        about=("VB10",),
        modes=_modes_with(Mode.EMERGENCY, ModeTrigger.PRESS, Mode.MANUAL),
    ),
    VehicleMutant(
        id="deaf-switch",
        what="a press in MANUAL does nothing",
        about=(
            "VB09",
            "VB31H",
        ),
        modes=_modes_without(Mode.MANUAL, ModeTrigger.PRESS),
    ),
    VehicleMutant(
        id="deaf-to-requests",
        what="a request for AUTOWARE in MANUAL is granted and not obeyed",
        about=(
            "VB23H",
            "VB42H",
        ),
        modes=_modes_without(Mode.MANUAL, ModeTrigger.REQUEST_AUTOWARE),
    ),
    VehicleMutant(
        id="grants-all",
        what="each request is said to be granted",
        about=(
            "VB11H",
            "VB12",
        ),
        kind=_GrantsAll,
    ),
    VehicleMutant(id="splits-at-hash", what="each # begins a frame", about=("VB24",), kind=_SplitsAtHash),
    VehicleMutant(id="takes-hashes", what="22 times # is a status", about=("VB28",), kind=_TakesHashes),
    VehicleMutant(
        id="reverses-on",
        what="without a command a car in reverse is not stopped",
        about=("VB05H",),
        kind=_ReversesOn,
    ),
    VehicleMutant(
        id="impatient-behind-emergency",
        what="behind an emergency two missed statuses are another",
        about=("VB45",),
        kind=_ImpatientBehindEmergency,
    ),
    VehicleMutant(
        id="remembers-refused",
        what="a request that was refused in EMERGENCY is obeyed behind it",
        about=("VB11H",),
        kind=_RemembersRefused,
    ),
    VehicleMutant(
        id="stale-in-manual", what="in MANUAL an old status is reported", about=("VB32H",), kind=_StaleInManual
    ),
    VehicleMutant(
        id="mends-statuses",
        what="what cannot be in a status is reported as 0",
        about=("VB29H", "VB35H"),
        kind=_Mends,
    ),
    VehicleMutant(
        id="wide-limits",
        what="a status of 1000 m/s is believed",
        about=("VB35H",),
        board=_limited(speed_m_s=1000.0),
    ),
    VehicleMutant(
        id="narrow-limits",
        what="a status of more than 100 m/s is dropped",
        about=("VB35H",),
        board=_limited(speed_m_s=100.0),
    ),
    VehicleMutant(id="hazard-for-ever", what="hazard lights cannot be put out", about=("VB43",), kind=_HazardForEver),
    VehicleMutant(
        id="hazard-ends-by-nothing",
        what="NO_COMMAND puts hazard lights out",
        about=("VB43",),
        kind=_HazardEndsByNothing,
    ),
    VehicleMutant(
        id="watched-in-autoware",
        what="the watchdog sleeps in MANUAL",
        about=("VB56H",),
        kind=_WatchedInAutoware,
    ),
)


DRIVEN = (
    VehicleMutant(
        id="fields-exchanged",
        what="lateral speed and heading rate are exchanged",
        about=("VD02",),
        kind=_ExchangesFields,
    ),
    VehicleMutant(id="brakes-first", what="AUTOWARE begins with a stop", about=("VD05",), kind=_BrakesFirst),
    VehicleMutant(
        id="returns-by-itself",
        what="the first command after a second without any leads to AUTOWARE",
        about=("VD07",),
        kind=_ReturnsByItself,
    ),
    VehicleMutant(
        id="straight-to-autoware",
        what="EMERGENCY ends in AUTOWARE",
        about=("VD09",),
        modes=_modes_with(Mode.EMERGENCY, ModeTrigger.STATUS_RETURNS, Mode.AUTOWARE),
    ),
)
"""Boards that drives have to find, each by the clause that it is about; `vehicle-drive` runs on these alone."""


def all_mutants() -> tuple[VehicleMutant, ...]:
    """Every faulty board."""
    return (*PUBLISHED, *CURES, *BY_HAND)


def run(mutant: VehicleMutant | None, select: str = "") -> Report:
    """Run the cases of a mutant's profile against it; those of all profiles against the right board for None."""
    shared = Shared(bench_file=open_bench("vehicle-model"), timeout_scale=1.0, journal=Journal())
    provider = VehicleProvider(shared, make_vehicle=mutant.make) if mutant is not None else VehicleProvider(shared)
    words = [word for word in (f"[{mutant.profile}]" if mutant is not None else "", select) if word]
    if mutant is not None and not select:
        words.append(f"({' or '.join(mutant.about)})" if mutant.about else f"not ({' or '.join(SLOW)})")
    options = CheckOptions(bench="vehicle-model", suites=("vehicle-board",), select=" and ".join(words))
    return run_suites(options, provider)


def image_of(defect: str) -> Path:
    """Our firmware with a defect; there need not be one."""
    return image_path(f"vehicle-{'flag-clash' if defect == 'V1' else defect.lower()}")


def run_image(defect: str, clauses: Sequence[str]) -> Report:
    """Run some clauses of `hardened` on the emulated board, with the image that has this defect."""
    shared = Shared(bench_file=open_bench("vehicle"), timeout_scale=1.0, journal=Journal())
    choice = TargetChoice(name="brain.hardened", spec=f"nucleo-h753zi:{image_of(defect)}")
    select = f"[hardened] and ({' or '.join(clauses)})"
    options = CheckOptions(bench="vehicle", suites=("vehicle-board",), select=select)
    return run_suites(options, BoardProvider(shared, [choice]))


def to_run(clauses: Iterable[str]) -> tuple[str, ...]:
    """Which of the clauses that find a defect in the model are run on the emulated board."""
    return tuple(sorted(clauses, key=lambda clause: (clause in SLOW, clause)))[:SHOWN]


def killers(report: Report) -> tuple[str, ...]:
    """The clauses that fail."""
    return tuple(sorted({case.clause_ids[0] for case in report.cases if case.verdict is Verdict.FAIL}))


def page(found: Mapping[str, Sequence[str]], firmware: Mapping[str, Sequence[str]]) -> str:
    """The page of the table, from the clauses that find each mutant, as a model and in the firmware."""
    return "\n".join([*_head(), *_table(found, firmware), *_clauses(found)]) + "\n"


def _head() -> Iterator[str]:
    yield "# Defects of the vehicle interface, and the clauses that find them\n"
    yield "Made by `python -m tests.mutants.vehicle`. Do not edit.\n"
    yield "Each defect of the published firmwares is put back by itself into a board that is otherwise as we would"
    yield "ship it (a behavioural model: `defects` in the settings of the bench `vehicle-model`), and the suite"
    yield "`vehicle-board` is run against it. Then some of the clauses that found it are run against our firmware with"
    yield "the same defect, on the emulated NUCLEO-H753ZI (images `vehicle-DEFECT`). A star marks a clause that says"
    yield f"*should*. Left out, for they take 20 s and more: {', '.join(SLOW)}, but for `H9`, which they are about.\n"


def _table(found: Mapping[str, Sequence[str]], firmware: Mapping[str, Sequence[str]]) -> Iterator[str]:
    yield "| Defect | What it does | Where it was published | Found in the firmware by | Found in the model by |"
    yield "|---|---|---|---|---|"
    for defect in DEFECTS.values():
        emulated = _shown(firmware.get(defect.name, ("no image",)))
        yield f"| `{defect.name}` | {defect.text} | {defect.source} | {emulated} | {_shown(found[defect.name])} |"
    yield "\n## The published firmwares without one of their defects\n"
    yield "A clause that describes a hazard has to notice where it is gone; run are these clauses alone.\n"
    yield from _plain(found, CURES)
    yield "\n## Other faults\n"
    yield "Each is run against the clauses that it is about.\n"
    yield from _plain(found, BY_HAND)


def _plain(found: Mapping[str, Sequence[str]], mutants: Iterable[VehicleMutant]) -> Iterator[str]:
    yield "| Fault | What it does | Profile | Clauses that find it |"
    yield "|---|---|---|---|"
    for mutant in mutants:
        yield f"| `{mutant.id}` | {mutant.what} | `{mutant.profile}` | {_shown(found[mutant.id])} |"


def _shown(clauses: Sequence[str]) -> str:
    """Clauses, those that say *should* with a star."""
    return ", ".join(f"{clause}*" if _LEVELS.get(clause) == "should" else clause for clause in clauses) or "none"


def _clauses(found: Mapping[str, Sequence[str]]) -> Iterator[str]:
    yield "\n## Clauses\n"
    yield "| Clause | Faults it finds |"
    yield "|---|---|"
    for clause in BOARD_CLAUSES:
        names = [f"`{name}`" for name, clauses in found.items() if clause.id in clauses]
        yield f"| {clause.id} {clause.title} | {', '.join(names) or 'none'} |"


def on_the_page(row: re.Pattern[str] = _ROW) -> dict[str, tuple[str, ...]]:
    """What the page says already: by fault, the clauses that find it in the model."""
    rows = row.finditer(PAGE.read_text(encoding="utf-8"))
    said = {row["name"]: row["clauses"].replace("*", "") for row in rows}
    return {name: () if clauses == "none" else tuple(clauses.split(", ")) for name, clauses in said.items()}


def firmware_on_the_page() -> dict[str, tuple[str, ...]]:
    """As `on_the_page`, in the firmware."""
    return {name: clauses for name, clauses in on_the_page(_FIRMWARE).items() if clauses != ("no image",)}


def _renewed(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """What the page says, with some faults run again."""
    said = on_the_page()
    return {mutant.id: killers(run(mutant)) if mutant.id in names else said[mutant.id] for mutant in all_mutants()}


def main(words: Sequence[str]) -> int:
    """Run them all and write the page; 1 if one survives."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants.vehicle", description=__doc__)
    parser.add_argument("--firmware", action="store_true", help="run the images alone; the model is as on the page")
    parser.add_argument("--model", action="store_true", help="run the model alone; the firmware is as on the page")
    parser.add_argument("--only", nargs="+", metavar="FAULT", help="run these in the model; all else is as on the page")
    chosen = parser.parse_args(words)
    if chosen.only:
        PAGE.write_text(page(_renewed(chosen.only), firmware_on_the_page()), encoding="utf-8")
        return 0
    found = on_the_page() if chosen.firmware else {mutant.id: killers(run(mutant)) for mutant in all_mutants()}
    firmware: Mapping[str, Sequence[str]] = firmware_on_the_page() if chosen.model and PAGE.is_file() else {}
    if not chosen.model:
        images = [name for name in DEFECTS if image_of(name).is_file() and found[name]]
        firmware = {name: killers(run_image(name, to_run(found[name]))) for name in images}
    PAGE.write_text(page(found, firmware), encoding="utf-8")
    survivors = [name for name, clauses in (*found.items(), *firmware.items()) if not clauses]
    sys.stderr.write("".join(f"{name} survives\n" for name in survivors))
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
