"""Says how two recordings compare: as text for people, or as data."""

from __future__ import annotations

from collections.abc import Iterator

from hilbench.diff.capture import Capture, Value, shown
from hilbench.diff.compare import Change, Comparison, Options, SignalReport, around, span

__all__ = ["as_data", "as_text"]

FORMAT = 1
BEFORE, AFTER = 6, 6


def as_text(comparison: Comparison) -> str:
    """Return it as lines."""
    return "\n".join(_lines(comparison))


def _lines(comparison: Comparison) -> Iterator[str]:
    yield from _heads(comparison)
    yield ""
    yield from _table(comparison)
    for name, why in comparison.left_out.items():
        yield f"not compared: {name}: {why}"
    for signal in comparison.signals:
        if signal.remark:
            yield f"in part only: {signal.name}: {signal.remark}"
    yield ""
    yield from _verdict(comparison)


def _heads(comparison: Comparison) -> Iterator[str]:
    for side, capture in (("A", comparison.a), ("B", comparison.b)):
        yield f"{side}  {capture.label}: {capture.kind}, {capture.end_ns / 1e9:.6f} s"
        yield from (f"   {remark}" for remark in capture.remarks)
    anchor = comparison.anchor
    if anchor is None:
        yield "no first change in common: compared from the beginning of both"
    else:
        times = f"at {_time(anchor.a_ns)} s in A and {_time(anchor.b_ns)} s in B"
        yield f"laid over each other at {anchor.signal} -> {shown(anchor.a)}, {times}"
    yield f"compared for {comparison.span_ns / 1e9:.6f} s from there"
    for side, beyond in (("A", comparison.a_beyond), ("B", comparison.b_beyond)):
        if beyond.goes_on_ns:
            yield f"{side} goes on for {span(beyond.goes_on_ns)} after that"


def _table(comparison: Comparison) -> Iterator[str]:
    signals = [signal for signal in comparison.signals if signal.changes or signal.divergence is not None]
    width = max([len("signal"), *(len(signal.name) for signal in signals)])
    yield f"  {'signal':<{width}} {'A':>7} {'B':>7} {'agree':>7}  B later than A: median, largest"
    for signal in signals:
        mark = " " if signal.divergence is None else "!"
        late = f"  {_late(signal.median_ns)}, {_late(signal.largest_ns)}" if signal.late_ns else ""
        yield f"{mark} {signal.name:<{width}} {signal.a:>7} {signal.b:>7} {signal.equal:>7}{late}".rstrip()
    if still := len(comparison.signals) - len(signals):
        yield f"  and {still} on which nothing happened"


def _verdict(comparison: Comparison) -> Iterator[str]:
    first = comparison.first
    if first is None:
        count = len(comparison.signals)
        yield f"equal: {count} signal{'' if count == 1 else 's'}, {_how(comparison.options)}"
        if sum(signal.equal for signal in comparison.signals) == 1 and comparison.anchor is not None:
            yield "but that is one change, at which they are laid over each other: no time was compared"
        return
    if first.kind == "end":
        yield f"different: {first.text}"
        yield "(--common compares what both have, --until T the first T of it)"
    else:
        yield f"different: first {first.text}"
    yield f"  {'A, s':>16}  {'B, s':>16}  {'B later by':>12}  what"
    for change in around(comparison, BEFORE, AFTER):
        yield _row(change, mark=">" if change is first.change else " ")


def _how(options: Options) -> str:
    if options.order_only:
        return "all changes in the same order"
    return f"times within {span(options.tolerance_ns)}" if options.tolerance_ns else "all changes at the same times"


def _row(change: Change, mark: str) -> str:
    late = "" if change.late_ns is None else _late(change.late_ns)
    if change.late_ns is None or change.same:
        value = shown(change.a if change.a_ns is not None else change.b)
    else:
        value = f"{shown(change.a)} | {shown(change.b)}"
    return f"{mark} {_time(change.a_ns):>16}  {_time(change.b_ns):>16}  {late:>12}  {change.signal} -> {value}"


def _time(ns: int | None) -> str:
    return "-" if ns is None else f"{ns / 1e9:.9f}"


def _late(ns: float | None) -> str:
    return "" if ns is None else ("+" if ns > 0 else "") + span(ns)


def as_data(comparison: Comparison) -> dict[str, object]:
    """Return it as plain data."""
    first = comparison.first
    return {
        "format": FORMAT,
        "equal": first is None,
        "a": _recording(comparison.a),
        "b": _recording(comparison.b),
        "options": {
            "pins": list(comparison.options.pins),
            "order_only": comparison.options.order_only,
            "tolerance_ns": comparison.options.tolerance_ns,
            "until_ns": comparison.options.until_ns,
            "common": comparison.options.common,
        },
        "aligned_on": None if comparison.anchor is None else _change(comparison.anchor),
        "compared_ns": comparison.span_ns,
        "beyond": {
            "a_ns": comparison.a_beyond.goes_on_ns,
            "b_ns": comparison.b_beyond.goes_on_ns,
            "a": len(comparison.a_beyond.changes),
            "b": len(comparison.b_beyond.changes),
        },
        "signals": [_signal(signal) for signal in comparison.signals],
        "not_compared": dict(comparison.left_out),
        "first": None if first is None else {"kind": first.kind, "text": first.text} | _change(first.change),
        "around": [_change(change) for change in around(comparison, BEFORE, AFTER)],
    }


def _recording(capture: Capture) -> dict[str, object]:
    return {"file": capture.label, "kind": capture.kind, "end_ns": capture.end_ns, "remarks": list(capture.remarks)}


def _signal(signal: SignalReport) -> dict[str, object]:
    return {
        "name": signal.name,
        "a": signal.a,
        "b": signal.b,
        "agree": signal.equal,
        "median_late_ns": signal.median_ns,
        "largest_late_ns": signal.largest_ns,
        "remark": signal.remark,
        "different": None if signal.divergence is None else signal.divergence.text,
    }


def _change(change: Change) -> dict[str, Value]:
    return {
        "signal": change.signal,
        "a_ns": change.a_ns,
        "b_ns": change.b_ns,
        "a": change.a,
        "b": change.b,
        "late_ns": change.late_ns,
    }
