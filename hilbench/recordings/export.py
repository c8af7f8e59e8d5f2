"""`hilbench export`: a recording into files of other formats, each read back by its own reader of ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO, TypeVar

from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Recording
from hilbench.plugins.protocol import ProtocolPlugin, TopicSample
from hilbench.recordings.csv_file import write_csv
from hilbench.recordings.frames import framed, spoken
from hilbench.recordings.layout import laid_out
from hilbench.recordings.mcap_file import write_mcap, write_ros2
from hilbench.recordings.pcapng import LEFT_OUT, write_pcapng
from hilbench.recordings.vcd_file import summarised, write_vcd

__all__ = ["Exported", "export"]

WrittenT = TypeVar("WrittenT")
"""What a writer says of what it has written."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Exported:
    """A file that was written.

    Attributes:
        path: the file.
        events: how many events of the recording are in it.
        remark: what a person must know of it; empty for nothing.
    """

    path: Path
    events: int
    remark: str = ""


def export(
    recording: Recording,
    outputs: Mapping[str, Path],
    protocol: ProtocolPlugin | None,
    where: str,
    types: Sequence[Path] = (),
) -> list[Exported]:
    """Write a recording.

    Args:
        recording: what is written.
        outputs: the files, by the name of the format: ``mcap``, ``ros2``, ``pcapng``, ``vcd``, ``csv``.
        protocol: what is spoken on its lines; None for what makes frames of most of its bytes.
        where: the name of the recording, for messages.
        types: folders with definitions of types of topics, ``PACKAGE/msg/NAME.msg``.

    Raises:
        UsageError: there are no pins to be written as waveforms, or no topics, or a definition cannot be read.
        UnavailableError: a file cannot be written.
    """
    if "vcd" in outputs and not any(event["kind"] == "pin" for event in recording.events):
        raise UsageError("has no edges of pins", where=where, hint="'hilbench run BENCH --vcd FILE' writes every edge")
    writers: dict[str, _Writer] = {
        **_WRITERS,
        "mcap": partial(_mcap, types=types),
        "ros2": partial(_ros2, types=types, where=where),
    }
    return [writers[name](recording, path, protocol) for name, path in outputs.items()]


def _mcap(recording: Recording, path: Path, protocol: ProtocolPlugin | None, types: Sequence[Path]) -> Exported:
    protocol = protocol or spoken(laid_out(recording.events))
    written = _written(path, lambda file: write_mcap(recording, file, protocol, types))
    remark = (
        f"with the frames of {protocol.name}" if protocol else "no protocol is known that makes frames of its bytes"
    )
    if written.samples:
        remark += f" and {written.samples} samples of topics{_unknown(written.unknown, types)}"
    return Exported(path=path, events=written.events, remark=remark)


def _ros2(
    recording: Recording, path: Path, protocol: ProtocolPlugin | None, types: Sequence[Path], where: str
) -> Exported:
    events = list(laid_out(recording.events))
    protocol = protocol or spoken(events, lambda one: one.samples is not None)
    samples: list[TopicSample] = []
    unknown: list[str] = []
    if protocol is not None and protocol.samples is not None:
        samples, unknown = protocol.samples(list(framed(events, protocol)), types)
    if not samples:
        hint = f"--mcap has the frames of {protocol.name}" if protocol else "--mcap has its events"
        raise UsageError("has no topics of ROS 2", where=where, hint=hint)
    _written(path, lambda file: write_ros2(recording, file, samples))
    return Exported(path=path, events=len(samples), remark=f"samples of topics{_unknown(unknown, types)}")


def _unknown(names: Sequence[str], types: Sequence[Path]) -> str:
    why = "neither known nor in --types" if types else "not known without --types"
    return f"; {why}: {', '.join(names)}" if names else ""


def _pcapng(recording: Recording, path: Path, _protocol: ProtocolPlugin | None) -> Exported:
    count = _written(path, lambda file: write_pcapng(recording, file))
    left_out = sorted({event["kind"] for event in recording.events} & LEFT_OUT)
    return Exported(path=path, events=count, remark=f"without {', '.join(left_out)}" if left_out else "")


def _csv(recording: Recording, path: Path, _protocol: ProtocolPlugin | None) -> Exported:
    return Exported(path=path, events=_written(path, lambda file: write_csv(recording, file)))


def _vcd(recording: Recording, path: Path, _protocol: ProtocolPlugin | None) -> Exported:
    pins = summarised(recording)
    remark = f"some edges of {', '.join(pins)} are not in the journal: 'hilbench run --vcd' has them" if pins else ""
    return Exported(path=path, events=write_vcd(recording, path), remark=remark)


_Writer = Callable[[Recording, Path, ProtocolPlugin | None], Exported]

_WRITERS: Mapping[str, _Writer] = {
    "pcapng": _pcapng,
    "vcd": _vcd,
    "csv": _csv,
}


def _written(path: Path, write: Callable[[IO[bytes]], WrittenT]) -> WrittenT:
    file = None
    try:
        file = path.open("wb")
        count = write(file)
        file.close()
    except OSError as error:
        raise UnavailableError(f"cannot be written: {error.strerror or error}", where=str(path)) from error
    except Exception:  # a decoder of a plug-in, say: what there is of the file is none
        if path.is_file() and not path.is_symlink():  # which /dev/stdout is
            path.unlink()
        raise
    finally:
        if file is not None:
            with suppress(OSError):
                file.close()
    return count
