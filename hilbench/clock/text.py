"""Times and factors as people read them: with about three digits, however small or large."""

from __future__ import annotations

__all__ = ["factor_text", "seconds_text"]


def seconds_text(time_s: float) -> str:
    """Return a time with its unit: ``1234 s``, ``12.3 s``, ``35 ms``, ``0.25 ms``, ``0 s``.

    Args:
        time_s: in seconds, from 0 on.
    """
    if time_s == 0 or time_s >= 99.95:
        return f"{time_s:.0f} s"
    if time_s >= 0.0995:
        return f"{time_s:.1f} s"
    return f"{1000 * time_s:.0f} ms" if time_s >= 0.00995 else f"{1000 * time_s:.2g} ms"


def factor_text(factor: float) -> str:
    """Return a factor from 0 on: ``123``, ``12.3``, ``0.025``."""
    if factor >= 99.95:
        return f"{factor:.0f}"
    return f"{factor:.1f}" if factor == 0 or factor >= 0.0995 else f"{factor:.2g}"
