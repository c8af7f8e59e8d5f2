"""Named sets of options: what was promised, and what was shipped.

Sources: see options.py. What is called a choice there is one here too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from protocols.pkt.codes import ReportId
from protocols.pkt.options import (
    ClientOptions,
    ExecutionReports,
    FrameTimer,
    Framing,
    FramingOptions,
    PollOptions,
    RangeRule,
    ReportRate,
    Resync,
    Schema,
    ServerOptions,
)
from protocols.pkt.units import AccelerationUnit, Dialect, PositionOrder, QuaternionOrder

__all__ = ["PROFILES", "Profile"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """What both ends do, and what their numbers mean.

    Attributes:
        name: as in the catalogue of clauses.
        text: what it is.
        server: the rover.
        client: the host that goes with it.
        dialect: how the reports are read.
    """

    name: str
    text: str
    server: ServerOptions = field(default_factory=ServerOptions)
    client: ClientOptions = field(default_factory=ClientOptions)
    dialect: Dialect = field(default_factory=Dialect)


_DOCUMENTED = Profile(
    name="documented",
    text=(
        "What seed document and manual promise, in the frames and with the parameters that were shipped: length byte, "
        "0x81 after every command, timeouts, the manual's units. The rover of this profile resynchronises and stops "
        "when it hears nobody. 0x80 keeps the STATUS byte that all code sends behind the documented five."
    ),
    dialect=Dialect(
        acceleration=AccelerationUnit.M_S2,
        quaternion=QuaternionOrder.XYZW,
        position=PositionOrder.LATITUDE_FIRST,
    ),
)

_TERM = FramingOptions(framing=Framing.TERM, timer=FrameTimer.OFF)
_TERM_DOC = Profile(
    name="term-doc",
    text=(
        "The seed document to the letter: no length byte, speeds as big-endian int16, 0x80 of five bytes and on "
        "request alone, 0x81 after every command, no timeout."
    ),
    server=ServerOptions(
        frames=_TERM,
        schema=Schema.V1,
        general_status=False,
        rates=(),
        silence_s=None,
    ),
    client=ClientOptions(
        frames=FramingOptions(framing=Framing.TERM, resync=Resync.SCAN, timer=FrameTimer.SINCE_LAST_BYTE),
        schema=Schema.V1,
    ),
)

_G0 = Profile(
    name="g0",
    text="The Arduino firmware of May 2020, nhorro/rover-firmware, and its Python client.",
    server=ServerOptions(
        frames=FramingOptions(timer=FrameTimer.SINCE_RESET),
        schema=Schema.V1,
        execution_reports=ExecutionReports.NEVER,
        rates=(ReportRate(report=ReportId.IMU, ticks=20), ReportRate(report=ReportId.GENERAL, ticks=100)),
        report_at_once=False,
        strict_length=False,
        range_rule=RangeRule.ANY,
    ),
    client=ClientOptions(schema=Schema.V1, split_lines=True, request_s=None, silence_s=None, stop_at_the_end=False),
)

_G2 = Profile(
    name="g2",
    text="The last Mbed firmware of 2021-09-13, nhorro/ceai2020 at 6058e92, and its Python client.",
    server=ServerOptions(
        frames=FramingOptions(timer=FrameTimer.OFF),
        execution_reports=ExecutionReports.NEVER,
        silence_s=None,
        strict_length=False,
        range_rule=RangeRule.ANY,
        pid_reads_late=True,
        pid_reports_kp=True,
        gps_stale_byte=True,
        poll=PollOptions(),
    ),
    client=ClientOptions(split_lines=True, request_s=None, silence_s=None, stop_at_the_end=False),
)

PROFILES: Mapping[str, Profile] = MappingProxyType(
    {profile.name: profile for profile in (_DOCUMENTED, _TERM_DOC, _G0, _G2)}
)
"""All profiles by name."""
