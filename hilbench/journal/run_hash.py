"""The hash that two equal runs share, and what of their events is part of it.

What belongs to the host and not to the bench stays out by name: kinds and fields that begin with ``host`` (host_path,
host_pid, host_lateness_ns, host_time), the fields ``cause`` and ``text``, which are prose, and the kinds ``scene`` and
``margins``, for those who draw: what stands there and matters, and what timers do, the other events show. Floats enter
in millionths: a micrometre, a microradian. Equality is promised for one platform and one set of dependencies.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import msgspec

from hilbench.journal.lines import encoded

__all__ = ["MARGINS", "PROSE_FIELDS", "SCENE", "CaseHash", "is_hashed", "millionths", "run_hash"]

PROSE_FIELDS = frozenset({"cause", "text"})
"""Fields that are for people, and no part of what is the same in two equal runs."""
SCENE = "scene"
"""The kind of what stands around a vehicle; each part of a journal says it anew."""
MARGINS = "margins"
"""The kind of how much time timers had left; see `hilbench.bench.margins`."""

_UNNAMED_PHYSICS = ("none", "plane ", "bullet (PyBullet 3.2.7)")
_MILLIONTHS = 1_000_000
_encoder = msgspec.json.Encoder(order="deterministic")


def is_hashed(kind: str) -> bool:
    """Return whether events of this kind are part of what is the same in two equal runs."""
    return kind not in {SCENE, MARGINS} and not kind.startswith("host")


def run_hash(case_hashes: Mapping[str, str], physics: str = "none") -> str | None:
    """Return the hash of a run, of its ``id:hash`` lines sorted by id; None if there are none.

    Args:
        case_hashes: of the cases that have one, by id.
        physics: with library and version, as the report names it. It is hashed, too, unless it is one of those that
            were there before hashes named any: theirs stay what they were.
    """
    lines = sorted(f"{case_id}:{case_hash}\n" for case_id, case_hash in case_hashes.items())
    if not lines:
        return None
    if not physics.startswith(_UNNAMED_PHYSICS):
        lines.append(f"physics:{physics}\n")
    return hashlib.sha256("".join(lines).encode()).hexdigest()


class CaseHash:
    """Grows with the events of a case.

    Args:
        begin_ns: bench time at which it begins; times enter relative to it.
    """

    def __init__(self, begin_ns: int) -> None:
        self._begin_ns = begin_ns
        self._digest = hashlib.sha256()

    def add(self, event: Mapping[str, Any]) -> None:
        """Add an event, if its kind is part of what is the same."""
        if not is_hashed(event["kind"]):
            return
        canonical = {
            name: _canonical(value)
            for name, value in event.items()
            if name not in PROSE_FIELDS and not name.startswith("host")
        }
        canonical["ns"] -= self._begin_ns
        self._digest.update(encoded(canonical, _encoder))

    def hexdigest(self) -> str:
        """Return it, 64 hexadecimal digits."""
        return self._digest.hexdigest()


def millionths(value: float) -> int:
    """Return a value in whole millionths.

    Raises:
        ValueError: it is not a number, or infinite.
    """
    try:
        return round(value * _MILLIONTHS)
    except OverflowError as error:
        raise ValueError(f"not a finite number: {value}") from error


def _canonical(value: Any) -> Any:
    if isinstance(value, float):
        try:
            return round(value * _MILLIONTHS)
        except (OverflowError, ValueError):
            return str(value)
    if isinstance(value, dict):
        return {name: _canonical(item) for name, item in value.items() if not name.startswith("host")}
    return [_canonical(item) for item in value] if isinstance(value, list) else value
