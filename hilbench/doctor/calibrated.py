"""What was measured at a port, for a person and for a program."""

from __future__ import annotations

import msgspec

from hilbench.doctor.calibrate import Calibrated
from hilbench.ports.calibration import Calibration

__all__ = ["as_data", "as_text"]


def as_data(done: Calibrated) -> dict[str, object]:
    """Return it as plain data."""
    more = {"uncertainty_s": done.calibration.uncertainty_s, "pacing_error": done.calibration.pacing_error}
    return {
        **msgspec.structs.asdict(done.calibration),
        **more,
        "kept": str(done.kept) if done.kept else None,
        "why_not_kept": done.why_not or None,
    }


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
        ("kept", str(done.kept) if done.kept else f"not kept: {done.why_not}"),
    ]
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {text}" for name, text in rows)


def _pacing(found: Calibration) -> str:
    error = found.pacing_error
    if found.paced_returned < found.paced_bytes or found.paced_measured_s is None:
        return f"of a block of {found.paced_bytes} bytes the first {found.paced_returned} came back as they were sent"
    took = f"a block of {found.paced_bytes} bytes came back in {_ms(found.paced_measured_s)}"
    if not found.wire_s or error is None:
        return f"{took}: there is no wire of that rate in between, and nothing was taken off"
    return f"{took}, on a wire it needs {_ms(found.paced_expected_s)} ({error:+.2%})"


def _ms(seconds: float) -> str:
    return f"{seconds * 1000:.2f} ms"
