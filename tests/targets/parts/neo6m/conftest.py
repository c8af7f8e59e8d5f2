"""A NEO-6M on a bench, and readers of what it sends that share no code with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pynmeagps
import pytest
import pyubx2

from targets.parts.neo6m import Neo6m, Neo6mSettings, ReceiverNote
from targets.parts.testing import PartBench

STILL = {"x": 0.0, "y": 0.0, "z": 0.0, "vx": 0.0, "vy": 0.0, "vz": 0.0}
EXACT = {"accuracy_m": 0.0, "noise_m": 0.0, "velocity_m_s": 0.0}


class GpsRig:
    """A receiver, its time pulse, and what it has sent.

    Attributes:
        bench: the part on its bench.
    """

    def __init__(self, moving: Callable[[int], Mapping[str, float]] | None, step_ns: int, settings: dict) -> None:
        self.bench = PartBench(
            Neo6m, Neo6mSettings(**settings), quantities=moving or (lambda _ns: STILL), step_ns=step_ns
        )

    @property
    def now_ns(self) -> int:
        return self.bench.now_ns

    def run(self, seconds: float) -> None:
        self.bench.run(seconds)

    def run_to(self, seconds: float) -> None:
        self.bench.run_to(round(seconds * 1e9))

    def say(self, data: bytes | str) -> None:
        self.bench.receive(bytes.fromhex(data) if isinstance(data, str) else data)

    def command(self, group: int, number: int, payload: bytes = b"") -> bytes:
        """Send a UBX message; return everything that comes back at once, and forget it."""
        before = len(self.bench.sent)
        self.say(ubx(group, number, payload))
        found = b"".join(data for _, data in self.bench.sent[before:])
        del self.bench.sent[before:]
        return found

    def poll(self, group: int, number: int, payload: bytes = b"") -> bytes:
        """Ask for a message; return its payload."""
        found = messages(self.command(group, number, payload))
        return next(data for a, b, data in found if (a, b) == (group, number))

    def take(self) -> bytes:
        """Everything that was sent, and forget it."""
        found = b"".join(data for _, data in self.bench.sent)
        self.bench.sent.clear()
        return found

    def lines(self) -> list[list[str]]:
        """The fields of every sentence that was sent, checked, and forget them."""
        return sentences(self.take())

    def last(self, name: str) -> list[str]:
        return [fields for fields in self.lines() if fields[0] == name][-1]

    def notes(self) -> list[str]:
        return [event.text for event in self.bench.told(ReceiverNote)]


def sentences(data: bytes) -> list[list[str]]:
    found = []
    for line in data.decode("ascii").splitlines(keepends=True):
        assert line.startswith("$")
        assert line.endswith("\r\n")
        body, _, check = line[1:-2].partition("*")
        assert check == pynmeagps.calc_checksum(body)
        found.append(body.split(","))
    return found


def ubx(group: int, number: int, payload: bytes = b"") -> bytes:
    body = bytes([group, number, len(payload) & 0xFF, len(payload) >> 8]) + payload
    return b"\xb5\x62" + body + pyubx2.calc_checksum(body)


def messages(data: bytes) -> list[tuple[int, int, bytes]]:
    """Cut UBX messages apart; everything has to be one."""
    found = []
    while data:
        size = int.from_bytes(data[4:6], "little")
        assert data[: size + 8] == ubx(data[2], data[3], data[6 : 6 + size])
        found.append((data[2], data[3], data[6 : 6 + size]))
        data = data[size + 8 :]
    return found


@pytest.fixture
def make_gps() -> Callable[..., GpsRig]:
    """Makes rigs without errors that have a fix two seconds after power-on: what moves, then settings by name."""

    def make(moving=None, *, step_ns: int = 20_000_000, exact: bool = True, **settings) -> GpsRig:
        return GpsRig(moving, step_ns, {"start": "hot", **(EXACT if exact else {}), **settings})

    return make


@pytest.fixture
def gps(make_gps) -> GpsRig:
    """One with a fix, three and a half seconds after a hot start; what it has said is forgotten."""
    rig = make_gps()
    rig.run_to(3.5)
    rig.take()
    return rig


@pytest.fixture
def make_ubx() -> Callable[..., bytes]:
    return ubx


@pytest.fixture
def cut_messages() -> Callable[[bytes], list[tuple[int, int, bytes]]]:
    return messages


@pytest.fixture
def cut_sentences() -> Callable[[bytes], list[list[str]]]:
    return sentences
