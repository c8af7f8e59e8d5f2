"""Boards that are wrong about the stand-in link, and about a driving stack that is silent."""

from __future__ import annotations

from measure.mutants.vehicle.mutant import VehicleMutant
from protocols.autoware import CRC_BYTES, FrameReader, crc16
from targets.robots.vehicle_interface import VehicleInterface


class _LooksAtNoCrc(FrameReader):
    def _finish(self, payload):
        self._body[-CRC_BYTES:] = crc16(payload).to_bytes(CRC_BYTES, "little")
        super()._finish(payload)


class _BelievesTheLink(VehicleInterface):
    """Takes messages of the driving stack whose CRC is wrong."""

    def _begin(self, now_ns):
        super()._begin(now_ns)
        self.stack._reader = _LooksAtNoCrc()


FAULTS = (
    VehicleMutant(
        id="no-crc",
        what="messages on the stand-in link are believed, whatever their CRC",
        about=("VB50",),
        kind=_BelievesTheLink,
    ),
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
)
