"""The pins of a recording as waveforms, by the writer that ``hilbench run --vcd`` has."""

from __future__ import annotations

from pathlib import Path

from hilbench.journal import Recording
from hilbench.mcu.vcd import Waveforms
from hilbench.recordings.layout import laid_out
from targets.mcu.pins import Edge

__all__ = ["summarised", "write_vcd"]


def write_vcd(recording: Recording, path: Path) -> int:
    """Write the edges of all pins of all boards, each under ``BOARD.pins``; return how many.

    Before its first edge a pin is ``z``. A fast pin, of which the journal has summaries only, and serial frames have no
    edges there: see `summarised`.

    Raises:
        UnavailableError: it cannot be written.
    """
    events = list(laid_out(recording.events))
    edges = [(ns, *_place(event["source"]), event.get("level")) for ns, event in events if event["kind"] == "pin"]
    waves = Waveforms(path)
    for board in sorted({board for _, board, _, _ in edges}):
        names = sorted({name for _, of, name, _ in edges if of == board})
        waves.declare(f"{board}.pins", names, None)
    for ns, board, name, level in edges:
        waves.edges(f"{board}.pins", name, [Edge(cycle=0, ns=ns, level=level)])
    waves.close(events[-1][0] if events else 0)
    return len(edges)


def summarised(recording: Recording) -> list[str]:
    """Return the pins of which some edges are not in the recording."""
    pwm = {str(event["source"]) for event in recording.events if event["kind"] == "pwm"}
    frames = {f"{event['source']}.{event.get('pin')}" for event in recording.events if event["kind"] == "frames"}
    return sorted(pwm | frames)


def _place(source: str) -> tuple[str, str]:
    board, _, name = source.partition(".")
    return board, name
