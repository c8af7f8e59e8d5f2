"""Boards that take statuses wrongly."""

from __future__ import annotations

from dataclasses import replace

from measure.mutants.vehicle.changes import a_little_off, limited
from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.carla import (
    STATUS_BYTES,
    STATUS_LAYOUT,
    VECTORS,
    Dropped,
    DropReason,
    FrameDropped,
    Mode,
    StatusReported,
    StreamReader,
    decode_status,
)
from targets.robots.vehicle_interface import BEHAVIOURS, SIMULATOR_LINE, VehicleInterface


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


class _DeafBehindAStatus(VehicleInterface):
    """Misses what comes without a gap behind a status, as a receiver does that is armed anew too late."""

    _held = b""
    _latest_ns = 0

    def receive(self, line, data, now_ns):
        if line != SIMULATOR_LINE:
            return super().receive(line, data, now_ns)
        if now_ns - self._latest_ns > _GAP_NS:
            self._held = b""
        self._latest_ns = now_ns
        self._held += data
        return super().receive(line, data if len(self._held) <= STATUS_BYTES else b"", now_ns)


_GAP_NS = 1_000_000


class _AnyByteEndsEmergency(VehicleInterface):
    """In EMERGENCY takes whatever byte comes from the simulator's side for a status."""

    def receive(self, line, data, now_ns):
        if line == SIMULATOR_LINE and data and self.simulator.mode is Mode.EMERGENCY:
            data = VECTORS["F4"].data
        return super().receive(line, data, now_ns)


class _NeverLooksBack(StreamReader):
    """Throws away all it holds at the first wrong letter."""

    def _give_up(self, reason):
        self._found.append(Dropped(reason=reason, data=bytes(self._held)))
        self._held.clear()
        self._times = []


class _EitherCase(StreamReader):
    """Takes a for A, and so on."""

    def _take(self, byte, now_ns):
        letter = self._layout.letters.get(len(self._held)) if self._held else None
        super()._take(byte if letter is None or byte ^ letter != 0x20 else letter, now_ns)


class _TakesEitherCase(VehicleInterface):
    def _begin(self, now_ns):
        super()._begin(now_ns)
        self.simulator._machine.reader = _EitherCase(STATUS_LAYOUT, lambda _frame: None, timeout_ns=100_000_000)


class _Swallows(VehicleInterface):
    """Never sees XON and XOFF on the simulator's line."""

    def receive(self, line, data, now_ns):
        return super().receive(line, data.translate(None, b"\x11\x13") if line == SIMULATOR_LINE else data, now_ns)


class _CannotResynchronise(VehicleInterface):
    def _begin(self, now_ns):
        super()._begin(now_ns)
        self.simulator._machine.reader = _NeverLooksBack(STATUS_LAYOUT, lambda _frame: None, timeout_ns=100_000_000)


class _Mends(VehicleInterface):
    """Reports a status that cannot be with a 0 for what cannot be in it."""

    def _reports(self, event):
        if isinstance(event, FrameDropped) and event.reason in (DropReason.NOT_FINITE, DropReason.IMPLAUSIBLE):
            status = decode_status(event.data)
            figures = {name: getattr(status, name) for name in status.__dataclass_fields__}
            possible = {name: value if abs(value) <= 2.0 else 0.0 for name, value in figures.items()}
            event = StatusReported(status=replace(status, **possible), fresh=True)
        return super()._reports(event)


class _DiesIn(VehicleInterface):
    """A line error in one mode ends reception."""

    fatal: Mode

    def line_error(self, now_ns):
        if self.simulator.mode is self.fatal:
            self.simulator._machine._dead = True
        return super().line_error(now_ns)


class _DiesInManual(_DiesIn):
    fatal = Mode.MANUAL


class _DiesInEmergency(_DiesIn):
    fatal = Mode.EMERGENCY


_LIMITS = {"speed": "speed_m_s", "heading rate": "heading_rate_rad_s", "tyre angle": "steering_rad"}

FAULTS = (
    VehicleMutant(
        id="hasty-reader",
        what="half a status is given up after 20 ms",
        about=("VB26",),
        board={"frame_timeout_s": 0.020},
    ),
    VehicleMutant(
        id="heading-rate-unseen",
        what="a heading rate may be anything finite",
        about=("VB35H",),
        board={"status_limits": replace(BEHAVIOURS["hardened"].board.status_limits, heading_rate_rad_s=1e38)},
    ),
    VehicleMutant(
        id="letters-of-either-case",
        what="bit 5 of a status's letters is not looked at",
        about=("VB60",),
        kind=_TakesEitherCase,
    ),
    VehicleMutant(
        id="swallows-xon-xoff",
        what="XON and XOFF never reach the reader of statuses",
        about=("VB59",),
        kind=_Swallows,
    ),
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
    VehicleMutant(id="splits-at-hash", what="each # begins a frame", about=("VB24",), kind=_SplitsAtHash),
    VehicleMutant(id="takes-hashes", what="22 times # is a status", about=("VB28",), kind=_TakesHashes),
    VehicleMutant(
        id="mends-statuses",
        what="what cannot be in a status is reported as 0",
        about=("VB29H", "VB35H"),
        kind=_Mends,
    ),
    VehicleMutant(
        id="deaf-behind-a-status",
        what="a status without a gap behind another one is missed",
        about=("VB63",),
        kind=_DeafBehindAStatus,
    ),
    VehicleMutant(
        id="any-byte-ends-emergency",
        what="any byte of the simulator's side ends EMERGENCY",
        about=("VB62",),
        kind=_AnyByteEndsEmergency,
    ),
    VehicleMutant(
        id="wide-limits",
        what="a status of 1000 m/s is believed",
        about=("VB35H",),
        board=limited(speed_m_s=1000.0),
    ),
    VehicleMutant(
        id="narrow-limits",
        what="a status of more than 100 m/s is dropped",
        about=("VB35H",),
        board=limited(speed_m_s=100.0),
    ),
    VehicleMutant(
        id="any-age",
        what="a status that waited for longer than a status is waited for is an answer",
        about=("VB57H",),
        board={"fresh_only": False},
    ),
    VehicleMutant(
        id="dies-in-manual",
        what="a framing error in MANUAL ends reception",
        about=("VB39H",),
        kind=_DiesInManual,
    ),
    VehicleMutant(
        id="dies-in-emergency",
        what="a framing error in EMERGENCY ends reception",
        about=("VB39H",),
        kind=_DiesInEmergency,
    ),
    *a_little_off("status", _LIMITS, "VB35H"),
)
