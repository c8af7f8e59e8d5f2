"""Writes what boards did as stimuli, so that another run can do it to a board.

Slow pins are written edge by edge, fast ones as the square wave that the journal has of them, bytes as they were sent.
Pins that a stimulus drives are left out; one that is faster than a stimulus may be is let go, and a remark says so.
The file is whole after each line, whenever the run ends.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from hilbench.benchfile.stimulus import FASTEST_HZ
from hilbench.clock import NS_PER_S
from hilbench.errors import UnavailableError
from hilbench.mcu.emulated import EmulatedBench

__all__ = ["StimulusWriter"]

_HEAD = "# What boards did in a run, as stimuli for another one: hilbench run ... --stimuli FILE\nstimuli = [\n"
_END = "]\n"
_LEVELS = {True: "1", False: "0", None: "z"}
_ESCAPES = {ord("\n"): "\\n", ord("\r"): "\\r", ord("\t"): "\\t", ord("\\"): "\\\\"}


class StimulusWriter:
    """See the module.

    Args:
        path: the file; an older one is overwritten.
        emulated: the bench, before it runs.

    Raises:
        UnavailableError: it cannot be written.
    """

    def __init__(self, path: Path, emulated: EmulatedBench) -> None:
        self._path = path
        self._several = len(emulated.machines) > 1
        self._lines = frozenset(emulated.ports)
        self._pins = frozenset(f"{name}.{pin.name}" for name, one in emulated.machines.items() for pin in one.chip.pins)
        self._driven = frozenset(f"{one.board}.{one.target}" for one in emulated.bench_file.stimuli)
        self._waves: dict[str, tuple[str, int]] = {}  # and since when
        try:
            self._file = path.open("w", encoding="ascii")
            self._file.write(_HEAD)
            self._place = self._file.tell()
            self._file.write(_END)
        except OSError as error:
            raise self._cannot(error) from error
        journal = emulated.bench.journal
        self._before = journal.on_event
        journal.on_event = self._take

    def close(self) -> None:
        """End the file.

        Raises:
            UnavailableError: it cannot be written.
        """
        try:
            self._file.close()
        except OSError as error:
            raise self._cannot(error) from error

    def _take(self, event: Mapping[str, Any]) -> None:
        if self._before is not None:
            self._before(event)
        source = event["source"]
        if source in self._lines and event["kind"] == "tx":
            self._write(event.get("from_ns", event["ns"]), source, _text(bytes.fromhex(event["data"])))
        elif source in self._pins and source not in self._driven:
            self._take_pin(event, source)

    def _take_pin(self, event: Mapping[str, Any], pin: str) -> None:
        wave, begun_ns = self._waves.get(pin, ("", -1))
        if event["kind"] == "pin":
            if begun_ns != event["ns"]:  # else it is the level with which the wave begins
                self._end_wave(event, pin)
        elif event["kind"] != "pwm":
            return
        elif _goes_on(event):
            self._begin_wave(event, pin, wave)
        elif wave:
            self._end_wave(event, pin)

    def _begin_wave(self, event: Mapping[str, Any], pin: str, before: str) -> None:
        wave = _wave(event["period_ns"], event["high_ns"])
        if wave == before:
            return
        self._waves[pin] = (wave, event["ns"])
        if Fraction(NS_PER_S, event["period_ns"]) > FASTEST_HZ:
            self._write(event["ns"], pin, "z", f"  # {wave}: faster than a stimulus may be")
        else:
            self._write(event["ns"], pin, wave)

    def _end_wave(self, event: Mapping[str, Any], pin: str) -> None:
        self._waves.pop(pin, None)
        self._write(event["ns"], pin, _LEVELS[event["level"]])

    def _write(self, ns: int, source: str, value: str, remark: str = "") -> None:
        target = source if self._several else source.partition(".")[2]
        whole, rest = divmod(ns, NS_PER_S)
        time = f"{whole}.{rest:09}".rstrip("0").rstrip(".")
        try:
            self._file.seek(self._place)
            self._file.write(f"  {json.dumps(f'{time}s:{target}={value}')},{remark}\n")
            self._place = self._file.tell()
            self._file.write(_END)
            self._file.flush()
        except OSError as error:
            raise self._cannot(error) from error

    def _cannot(self, error: OSError) -> UnavailableError:
        reason = error.strerror or str(error)
        return UnavailableError(f"the stimuli cannot be written: {reason}", where=str(self._path))


def _goes_on(event: Mapping[str, Any]) -> bool:
    """Say whether there is a wave still: what was counted names its last period, however long ago that was."""
    period_ns = event.get("period_ns")
    if not period_ns or not event.get("high_ns"):
        return False
    return "duty" in event or event["edges"] * period_ns >= event["in_ns"]


def _wave(period_ns: int, high_ns: int) -> str:
    hz, duty = Fraction(NS_PER_S, period_ns), Fraction(100 * high_ns, period_ns)
    return f"{float(hz):.6f}".rstrip("0").rstrip(".") + f"Hz/{float(duty):.9f}".rstrip("0").rstrip(".") + "%"


def _text(data: bytes) -> str:
    if data.isascii() and all(32 <= byte < 127 or byte in b"\n\r\t" for byte in data):
        text = data.decode("ascii").translate(_ESCAPES)
        if not text.startswith(("@", "hex:")):
            return text
    return f"hex:{data.hex()}"
