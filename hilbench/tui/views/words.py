"""Numbers and times in words of a known width, and the names of the styles."""

from __future__ import annotations

from rich.text import Text

from hilbench.plugins.dashboard import BAD, DIM, GOOD, HEAD

__all__ = [
    "BAD",
    "DIM",
    "GOOD",
    "HEAD",
    "LIT",
    "bar",
    "bytes_words",
    "fit",
    "ns_words",
    "rate_words",
    "seconds",
    "tail",
]

NS_PER_S = 1_000_000_000

LIT = "bold bright_white on bright_blue"
"""What is the case now, and what is pointed at."""
_KILO = 1000


def seconds(ns: int) -> str:
    """Return a bench time to the millisecond: ``12.345 s``, or hours and minutes where there are any."""
    whole, rest = divmod(ns, NS_PER_S)
    if whole < 60:
        return f"{whole}.{rest // 1_000_000:03d} s"
    hours, whole = divmod(whole, 3600)
    minutes, whole = divmod(whole, 60)
    return f"{hours}:{minutes:02d}:{whole:02d}.{rest // 1_000_000:03d}"


def ns_words(ns: int) -> str:
    """Return a span: ``250 us``, ``12.5 ms``, ``7.90 s``."""
    if ns < 1_000_000:
        return f"{ns / 1000:.0f} us"
    if ns < NS_PER_S:
        return f"{ns / 1e6:.1f} ms"
    return f"{ns / NS_PER_S:.2f} s"


def rate_words(per_s: float) -> str:
    """Return a rate: ``9.8/s``, ``1.2 k/s``; nothing for none."""
    if per_s == 0:
        return ""
    if per_s >= _KILO:
        return f"{per_s / _KILO:.1f} k/s"
    return f"{per_s:.1f}/s"


def bytes_words(count: int) -> str:
    """Return how much that is: ``812 B``, ``12.3 kB``."""
    if count < _KILO:
        return f"{count} B"
    if count < _KILO * _KILO:
        return f"{count / _KILO:.1f} kB"
    return f"{count / _KILO / _KILO:.1f} MB"


def bar(share: float, width: int) -> str:
    """Return a bar that is full by a share of 0 to 1."""
    eighths = round(max(0.0, min(1.0, share)) * width * 8)
    full, rest = divmod(eighths, 8)
    partly = " ▏▎▍▌▋▊▉"[rest] if rest else ""
    return ("█" * full + partly).ljust(width, "·")


def tail(name: str, width: int) -> str:
    """Return a name in so many cells, at least one: its end says most, as that of a path does."""
    return name if len(name) <= width else f"…{name[len(name) - max(0, width - 1) :]}"


def fit(text: Text | str, width: int) -> Text:
    """Return a line cut to a width; what is cut is seen to be."""
    line = Text(text) if isinstance(text, str) else text.copy()
    line.no_wrap = True
    if line.cell_len > width:
        line.truncate(width, overflow="ellipsis")
    return line
