"""What was measured at a port, for a person and for a program."""

from __future__ import annotations

import msgspec

from hilbench.calibration import Calibration
from hilbench.doctor.calibrate import Calibrated

__all__ = ["as_data", "as_text"]

# A block that comes back in less than half its time was not on a wire of that rate.
_NO_WIRE = -0.5


def as_data(done: Calibrated) -> dict[str, object]:
    """Return it as plain data."""
    more = {"uncertainty_s": done.calibration.uncertainty_s, "pacing_error": done.calibration.pacing_error}
    return {**msgspec.structs.asdict(done.calibration), **more, "kept": str(done.kept) if done.kept else None}


def as_text(done: Calibrated) -> str:
    """Return it as lines for a person."""
    found = done.calibration
    lost = f", {found.lost} lost" if found.lost else ""
    excess = (found.excess_p50_s, found.excess_p99_s, found.excess_max_s)
    rows = [
        ("port", f"{found.target} at {found.baud} baud ({found.key})"),
        ("came back", f"{found.round_trips} single bytes{lost}"),
        ("beyond the wire", "{} (half), {} (99 %), {} (the worst)".format(*map(_ms, excess))),
        ("jitter", f"{_ms(found.jitter_s)} from the fastest to the slowest"),
        ("pacing", _pacing(found)),
        ("verdicts", f"times at this port are uncertain by {_ms(found.uncertainty_s)} more than the bench is late"),
        ("kept", str(done.kept) if done.kept else "not kept: a pseudo-terminal cannot be known again"),
    ]
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {text}" for name, text in rows)


def _pacing(found: Calibration) -> str:
    error = found.pacing_error
    if error is None or found.paced_measured_s is None:
        return f"of a block of {found.paced_bytes} bytes the first {found.paced_returned} came back as they were sent"
    block = f"{found.paced_bytes} bytes took {_ms(found.paced_measured_s)}, {_ms(found.paced_expected_s)} on a wire"
    if error < _NO_WIRE:
        return f"{block}: there is no wire of that rate in between"
    return f"{block} ({error:+.2%})"


def _ms(seconds: float) -> str:
    return f"{seconds * 1000:.2f} ms"
