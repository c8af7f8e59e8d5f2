"""The experiment: a board drives in AUTOWARE, stray bytes come in, then sound statuses at 20 Hz as before."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from protocols.carla import (
    PROFILES,
    Connection,
    ControlCommand,
    Event,
    Mode,
    ModeChanged,
    Role,
    StatusFrame,
    StatusReceived,
    encode_status,
)

MS = 1_000_000
STATUS_NS = 50 * MS
COMMAND_NS = 33 * MS
BEFORE_NS = 2010 * MS
DRIVE = ControlCommand(speed_m_s=5.0)
FRAME = 22


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What became of the statuses behind the stray bytes.

    Attributes:
        sent: how many there were.
        accepted: how many were believed.
        lost: how many were not, before the first that was; None if none was.
        false: how many were believed that nobody sent.
        emergency_ms: when EMERGENCY came, from the stray bytes on; None if it did not.
        mode: at the end.
    """

    sent: int
    accepted: int
    lost: int | None
    false: int
    emergency_ms: int | None
    mode: Mode


def status(number: int) -> bytes:
    """The frame of a car that changes in all its figures."""
    chance = random.Random(number)
    return encode_status(
        StatusFrame(
            lon_speed_m_s=number / 8,
            lat_speed_m_s=chance.uniform(-1, 1),
            heading_rate_rad_s=chance.uniform(-1, 1),
            steering_rad=chance.uniform(-0.6, 0.6),
        )
    )


def _noise(count: int, chance: random.Random) -> bytes:
    return chance.randbytes(count)


def _hashes(count: int, chance: random.Random) -> bytes:
    del chance
    return b"#" * count


def _beginning(count: int, chance: random.Random) -> bytes:
    return (status(chance.randrange(1000))[: FRAME - 1] * 2)[:count]


def _ending(count: int, chance: random.Random) -> bytes:
    return (b"\0" * FRAME + status(chance.randrange(1000))[1:] * 2)[-count:]


KINDS: Mapping[str, Callable[[int, random.Random], bytes]] = {
    "random bytes": _noise,
    "# again and again": _hashes,
    "the beginning of a status": _beginning,
    "the end of a status": _ending,
}
"""What the stray bytes may be."""


def drive(profile: str, stray: bytes, seconds: float) -> Outcome:
    """Drive for two seconds, take the stray bytes, and so many seconds of sound statuses."""
    board = Connection(Role.BOARD, PROFILES[profile].board)
    board.agent(0)
    seen: list[tuple[int, Event]] = []
    end_ns = BEFORE_NS + round(seconds * 1000) * MS
    moments = [(at, True) for at in range(0, end_ns, STATUS_NS)] + [(at, False) for at in range(0, end_ns, COMMAND_NS)]
    sent: list[float] = []
    struck = False
    for at_ns, is_status in sorted(moments):
        if not struck and at_ns >= BEFORE_NS:
            seen += [(BEFORE_NS, event) for event in board.receive(stray, BEFORE_NS)]
            struck = True
        if not is_status:
            events = board.command(DRIVE, at_ns)
        else:
            number = at_ns // STATUS_NS
            sent += [number / 8] if struck else []
            events = board.receive(status(number), at_ns)
        seen += [(at_ns, event) for event in events] if struck else []
    found = [event.status.lon_speed_m_s for _, event in seen if isinstance(event, StatusReceived)]
    sound = [speed for speed in found if speed in sent]
    emergencies = [at for at, event in seen if isinstance(event, ModeChanged) and event.new is Mode.EMERGENCY]
    return Outcome(
        sent=len(sent),
        accepted=len(sound),
        lost=sent.index(sound[0]) if sound else None,
        false=len(found) - len(sound),
        emergency_ms=round((emergencies[0] - BEFORE_NS) / MS) if emergencies else None,
        mode=board.mode,
    )


def worst(profile: str, count: int, *, seeds: int, seconds: float) -> Outcome:
    """The worst of all kinds of so many stray bytes, random ones with several seeds."""
    outcomes = [
        drive(profile, make(count, random.Random(seed)), seconds)
        for make in KINDS.values()
        for seed in range(seeds if make is not _hashes else 1)
    ]
    return max(outcomes, key=lambda one: (one.lost is None, one.lost or 0, one.false))
