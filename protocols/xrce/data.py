"""Data as they travel in WRITE_DATA and DATA, in the five formats (OMG DDS-XRCE 1.0, 7.7.2 and Annex B.3 and B.5).

A format is named by the flags of the submessage. Plain data, all that eProsima's clients and agents send, are the rest
of the submessage as it stands: bytes. No sample has a length of its own, in no format: where one ends and the next
begins knows only who knows its type. So of several samples there is their count, and the bytes of all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from protocols.xrce import wire
from protocols.xrce.cdr.stream import CdrReader, CdrWriter
from protocols.xrce.codes import DataFormat
from protocols.xrce.errors import RemoteProtocolError
from protocols.xrce.wire import Codec, Record

__all__ = [
    "DATA_LAYOUTS",
    "Data",
    "DataSequence",
    "PackedSamples",
    "Sample",
    "SampleInfo",
    "SampleSequence",
    "format_of",
]

_HAS_NUMBER, _HAS_TIME = 1, 2


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleInfo:
    """What is said of a sample.

    Attributes:
        state: bits of `InstanceState`.
        sequence_number: which sample of its writer it is, or None.
        time_offset_ms: when it was written, in ms since the session began, or None.
    """

    state: int = 0
    sequence_number: int | None = None
    time_offset_ms: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """One sample with what is said of it."""

    info: SampleInfo
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class DataSequence:
    """Several samples, one behind the other.

    Attributes:
        count: how many.
        data: all of them.
    """

    count: int
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleSequence:
    """Several samples, each behind its SampleInfo.

    Attributes:
        count: how many.
        data: all of them, with what is said of each.
    """

    count: int
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class PackedSamples:
    """Several samples beside one base, each behind its SampleInfoDelta.

    Attributes:
        base: what the deltas are added to.
        count: how many.
        data: all of them, with their deltas (state, difference of the number, of the time in tenths of a second).
    """

    base: SampleInfo
    count: int
    data: bytes


Data = bytes | Sample | DataSequence | SampleSequence | PackedSamples


class _Info(Codec):
    """State, a byte that says which of number and time there are, and these."""

    def write(self, out: CdrWriter, value: Any) -> None:
        """See `Codec`."""
        number, time = value.sequence_number, value.time_offset_ms
        wire.U8.write(out, value.state)
        wire.U8.write(out, _HAS_NUMBER * (number is not None) | _HAS_TIME * (time is not None))
        for one in (number, time):
            if one is not None:
                wire.U32.write(out, one)

    def read(self, data: CdrReader) -> Any:
        """See `Codec`."""
        state, detail = wire.U8.read(data), wire.U8.read(data)
        if detail > _HAS_NUMBER | _HAS_TIME:
            raise RemoteProtocolError(f"{detail} is no SampleInfoFormat")
        number = wire.U32.read(data) if detail & _HAS_NUMBER else None
        time = wire.U32.read(data) if detail & _HAS_TIME else None
        return SampleInfo(state=state, sequence_number=number, time_offset_ms=time)


_INFO = _Info()
_MANY = {"count": wire.U32, "data": wire.REST}

DATA_LAYOUTS = MappingProxyType(
    {
        DataFormat.DATA: wire.REST,
        DataFormat.SAMPLE: Record(Sample, info=_INFO, data=wire.REST),
        DataFormat.DATA_SEQ: Record(DataSequence, **_MANY),
        DataFormat.SAMPLE_SEQ: Record(SampleSequence, **_MANY),
        DataFormat.PACKED_SAMPLES: Record(PackedSamples, base=_INFO, **_MANY),
    }
)
"""How each format is laid out."""

_FORMATS = {layout.kind: form for form, layout in DATA_LAYOUTS.items() if isinstance(layout, Record)}


def format_of(data: Data) -> DataFormat:
    """The format of these data."""
    return _FORMATS.get(type(data), DataFormat.DATA)
