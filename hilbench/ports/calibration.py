"""What was measured at a port, kept for the verdicts of later runs.

A byte needs its time on the wire. What it needs beyond that, from the write of the program to its read, is the port's:
the kernel, the USB frames, the latency timer of the chip. `hilbench doctor --calibrate` measures it at a port that
sends back what it gets. It is kept below ``$XDG_STATE_HOME/hilbench`` (XDG Base Directory Specification), for the USB
device if the port has one of its own, whatever it is called then, else for the path.
"""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from collections.abc import Iterable
from pathlib import Path

import msgspec

from hilbench.errors import UnavailableError
from hilbench.files.paths import real_path
from hilbench.ports.listing import PortInfo

__all__ = ["Calibration", "calibration_of", "keep", "key_of", "port_at", "state_folder", "stored"]

_FORMAT = 1
_UNSAFE = re.compile(r"[^\w.-]+")
_PSEUDO = "/dev/pts/"


class Calibration(msgspec.Struct, frozen=True, kw_only=True):
    """What was measured at a port.

    Attributes:
        format: of this file.
        key: whose port it is; see `key_of`.
        target: what it was opened as.
        measured_at: date and time, UTC, ISO 8601.
        baud: bits per second.
        latency_ms: latency timer of the chip then, in ms; None where there is none.
        round_trips: how many single bytes came back.
        lost: how many did not.
        wire_s: what a byte needs on the wire at that rate, once; taken off below. 0 if there is no such wire.
        excess_p50_s: what half of the round trips did not need more than beyond the wire, in seconds.
        excess_p99_s: what 99 % of them did not.
        excess_max_s: what none of them did.
        jitter_s: the greatest less the least of them.
        paced_bytes: length of the block that was sent at once.
        paced_returned: how many of them came back as they were sent, from the first on.
        paced_expected_s: what the part of it behind the first piece that came back needs on the wire.
        paced_measured_s: what that part took to come back; None if the block did not come back whole.
    """

    format: int = _FORMAT
    key: str
    target: str
    measured_at: str
    baud: int
    latency_ms: int | None = None
    round_trips: int
    lost: int
    wire_s: float
    excess_p50_s: float
    excess_p99_s: float
    excess_max_s: float
    jitter_s: float
    paced_bytes: int
    paced_returned: int
    paced_expected_s: float
    paced_measured_s: float | None = None

    @property
    def uncertainty_s(self) -> float:
        """What the port adds to the uncertainty of a time, in seconds: the worst that was seen."""
        return self.excess_max_s

    @property
    def pacing_error(self) -> float | None:
        """How much longer than on the wire a block took, as a share; None if it did not come back."""
        if self.paced_measured_s is None or not self.paced_expected_s:
            return None
        return self.paced_measured_s / self.paced_expected_s - 1


def state_folder() -> Path | None:
    """Return where hilbench keeps what it has learned of this machine; None for a user without a home."""
    base = os.environ.get("XDG_STATE_HOME", "")
    # The specification: a path that is not absolute is ignored.
    if Path(base).is_absolute():
        return Path(base) / "hilbench"
    try:
        return Path.home() / ".local/state/hilbench"
    except RuntimeError:  # neither HOME nor an account, as in a container that runs under any number
        return None


def key_of(url: str, ports: Iterable[PortInfo]) -> str | None:
    """Return what the port at a path or URL is known by; None for a pseudo-terminal, whose name is given out again.

    Raises:
        UnavailableError: the path begins in the working folder, and that has been removed.
    """
    port = port_at(url, ports)
    if port is not None and port.usb is not None:
        usb = port.usb
        who = f"serial={usb.serial_number}" if usb.serial_number else f"location={usb.location}"
        return f"usb={usb.ids},{who},interface={usb.interface}"
    device = url if "://" in url else real_path(url)
    return None if device.startswith(_PSEUDO) else device


def port_at(url: str, ports: Iterable[PortInfo]) -> PortInfo | None:
    """Return the port that a path, or a link to one, leads to; None if it is none of them.

    Raises:
        UnavailableError: as `key_of`.
    """
    names = {url} if "://" in url else {url, real_path(url)}
    return next((port for port in ports if port.device in names), None)


def keep(calibration: Calibration) -> Path:
    """Write a calibration; one of the same port is replaced.

    Raises:
        UnavailableError: it cannot be written.
    """
    path = _path(calibration.key)
    if path is None:
        raise UnavailableError("there is no home directory to store it in", hint="export XDG_STATE_HOME=DIR")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("wb", dir=path.parent, delete=False) as file:
            file.write(msgspec.json.format(msgspec.json.encode(calibration)) + b"\n")
        Path(file.name).replace(path)
    except OSError as error:
        hint = "make it writable, or: export XDG_STATE_HOME=DIR"
        raise UnavailableError(f"cannot be written: {error.strerror}", where=str(path), hint=hint) from error
    return path


def stored(key: str) -> Calibration | None:
    """Return what is kept for a port; None if there is nothing that can be read."""
    path = _path(key)
    if path is None:
        return None
    try:
        found = msgspec.json.decode(path.read_bytes(), type=Calibration)
    except (OSError, msgspec.MsgspecError):
        return None
    return found if (found.format, found.key) == (_FORMAT, key) else None


def calibration_of(url: str, ports: Iterable[PortInfo]) -> Calibration | None:
    """Return the calibration that holds for a port now.

    None if there is none, or if the chip's latency timer has been set anew since.

    Raises:
        UnavailableError: as `key_of`.
    """
    there = list(ports)
    key = key_of(url, there)
    found = stored(key) if key is not None else None
    if found is None or found.latency_ms is None:
        return found
    port = port_at(url, there)
    return found if port is not None and port.latency_ms == found.latency_ms else None


def _path(key: str) -> Path | None:
    """Return the file of a port: readable, and its own also where two keys look alike; None without a home."""
    folder = state_folder()
    digest = hashlib.sha256(key.encode("utf-8", "surrogateescape")).hexdigest()[:8]
    name = f"{_UNSAFE.sub('-', key).strip('-')[:80]}-{digest}.json"
    return folder / "calibrations" / name if folder is not None else None
