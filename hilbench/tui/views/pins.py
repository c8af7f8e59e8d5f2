"""Pins of boards: level, trace of the last two seconds, duty and period; volts of those that a part puts them on."""

from __future__ import annotations

from rich.text import Text

from hilbench.tui.model.pins import PinModel, PinsModel
from hilbench.tui.views.words import DIM, GOOD, HEAD, fit, ns_words

__all__ = ["pins_view"]

TRACE_NS = 2_000_000_000
_BLOCKS = "▁▂▃▄▅▆▇█"
_LEVELS = {True: "high", False: "low", None: "open"}


def pins_view(pins: PinsModel, width: int, height: int, now_ns: int) -> list[Text]:
    """Return the pins of each board, lights first, then by name.

    Where there is no room for all, analog ones stand first, then lights, and those that have done least are left out.
    """
    if not pins.pins:
        return [Text("no pin has moved yet", DIM)]
    shown = sorted(pins.pins.values(), key=lambda pin: (pin.board, not pin.light, _port(pin.pin)))
    boards = dict.fromkeys(pin.board for pin in shown)
    heads = len(boards) if len(boards) > 1 else 0
    left_out = len(shown) - max(1, height - heads - 1) if len(shown) + heads > height else 0
    if left_out:
        busy = sorted(shown, key=_weight)[:-left_out]
        shown = sorted(busy, key=lambda pin: (pin.board, not pin.volts, not pin.light, _port(pin.pin)))
    lines = []
    for board in boards:
        lines += [Text(board, HEAD)] if heads else []
        lines += [_row(pin, width, now_ns) for pin in shown if pin.board == board]
    return [*lines, *([Text(f"and {left_out} more", DIM)] if left_out else [])]


def _weight(pin: PinModel) -> tuple[bool, bool, int]:
    """Return what is the less, the more there is to be seen of a pin."""
    return not pin.volts, not (pin.light and pin.edge_count), -pin.edge_count


def _row(pin: PinModel, width: int, now_ns: int) -> Text:
    name = f"{pin.pin} {pin.light}".strip() if pin.light != pin.pin else pin.pin
    if pin.volts:
        return fit(_analog_row(pin, name, width, now_ns), width)
    lit = bool(pin.light) and pin.level
    line = Text.assemble((f"{'●' if lit else ' '} {name:<9}", GOOD if lit else HEAD), f"{_LEVELS[pin.level]:<5}")
    line.append(_trace(pin, _room(width), now_ns), "cyan")
    wave = pin.wave(now_ns)
    if wave is not None:
        line.append(f" {wave[1] / wave[0]:5.1%} of {ns_words(wave[0])}")
    elif pin.edge_count:
        line.append(f" {pin.edge_count} edge{'' if pin.edge_count == 1 else 's'}", DIM)
    return fit(line, width)


def _analog_row(pin: PinModel, name: str, width: int, now_ns: int) -> Text:
    """Return the row of a pin with a voltage; what its digital input would make of it, nobody reads."""
    line = Text.assemble((f"  {name:<14}", HEAD), (_volts_trace(pin, _room(width), now_ns), "cyan"))
    return line.append(f" {pin.volts[-1][1]:.2f} V of {pin.full_v:.1f}")


def _room(width: int) -> int:
    return max(8, min(40, width - 40))


def _volts_trace(pin: PinModel, room: int, now_ns: int) -> str:
    """Return the voltage at the end of each part of the last two seconds, on the scale of the chip's supply."""
    step_ns = TRACE_NS // room
    letters = []
    for number in range(room):
        volts = pin.volts_at(now_ns - (room - number - 1) * step_ns)
        letters.append(" " if volts is None else _BLOCKS[max(0, min(7, int(8 * volts / pin.full_v)))])
    return "".join(letters)


def _trace(pin: PinModel, room: int, now_ns: int) -> str:
    """Return the level in each part of the last two seconds; where it moves faster than that, what it is on average."""
    if pin.pwm is not None and pin.pwm[0]:
        return _BLOCKS[min(7, int(8 * pin.pwm[1] / pin.pwm[0]))] * room
    step_ns = TRACE_NS // room
    known = [] if pin.known is None else [pin.known]
    edges = [*known, *pin.edges]
    letters, at = [], 0
    level: bool | None = None
    for number in range(room):
        begin_ns, end_ns = now_ns - (room - number) * step_ns, now_ns - (room - number - 1) * step_ns
        moved, high_ns, since_ns = 0, 0, begin_ns
        while at < len(edges) and edges[at][0] <= end_ns:
            edge_ns, after = edges[at]
            moved += edge_ns > begin_ns and at >= len(known)
            high_ns += max(0, edge_ns - since_ns) if level else 0
            since_ns, level = max(begin_ns, edge_ns), after
            at += 1
        high_ns += end_ns - since_ns if level else 0
        letters.append(
            _BLOCKS[min(7, 8 * high_ns // step_ns)] if moved > 1 else {True: "▔", False: "▁", None: " "}[level]
        )
    return "".join(letters)


def _port(pin: str) -> tuple[str, int]:
    digits = pin[2:]
    return pin[:2], int(digits) if digits.isdigit() else 0
