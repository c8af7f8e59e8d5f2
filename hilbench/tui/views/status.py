"""The link, its watchdogs and its counters."""

from __future__ import annotations

from collections.abc import Iterator

from rich.text import Text

from hilbench.tui.model.bench import BenchModel, LineModel
from hilbench.tui.model.machines import TRAFFIC, MachineModel, TimerModel
from hilbench.tui.model.rates import Counted
from hilbench.tui.views.words import BAD, DIM, GOOD, HEAD, bar, bytes_words, fit, ns_words, rate_words

__all__ = ["counters_view", "link_view", "strip_view", "timers_view"]

_LINE_ERRORS = (
    "lost",
    "overruns",
    "framing_errors",
    "parity_errors",
    "receive_overruns",
    "breaks",
    "refused",
    "withdrawn",
)
_SLOW_FACTOR = 0.98
_NEAR = 0.25
_WITH_RATE = 19
_NAMES = 19
_SIDE_BY_SIDE = 2
_MANY = 24
_ALWAYS = frozenset({"bytes_in", "bytes_out", "frames_in", "frames_out", "noise"})


def link_view(model: BenchModel, width: int) -> list[Text]:
    """Return what is known of the operator's line, and how the host keeps up."""
    lines: list[Text] = []
    for name, line in model.lines.items():
        lines += _line(model, name, line)
    if not lines:
        lines.append(Text("no line to watch", DIM))
    lines += _pace(model)
    lines.append(_driver(model))
    if model.faults:
        lines.append(Text("faults struck  " + ", ".join(f"{n} {name}" for name, n in model.faults.items()), BAD))
    return [fit(line, width) for line in lines]


def _line(model: BenchModel, name: str, line: LineModel) -> Iterator[Text]:
    about = line.about
    baud = f"{about['baud']} baud" if about.get("baud") else "no pace"
    state = ("up", GOOD) if about.get("up") else ("DOWN", BAD)
    yield Text.assemble((f"{name:<9}", HEAD), state, f"  {baud}  ", (str(about.get("port", "")), DIM))
    for way, counter in (("sent", "sent"), ("heard", "received")):
        counted = line.counters.get(counter)
        if counted is not None:
            per_s = counted.per_s(model.ns)
            share = per_s * 10 / about["baud"] if about.get("baud") else 0.0
            used = f"  {share:4.0%} of the line" if about.get("baud") else ""
            yield Text(f"  {way:<7}{bytes_words(counted.value):>9} {rate_words(per_s):>9}{used}")
    errors = [(word, line.counters[word].value) for word in _LINE_ERRORS if word in line.counters]
    shown = ", ".join(f"{count} {word.replace('_', ' ')}" for word, count in errors if count)
    yield Text(f"  errors {shown}", BAD) if shown else Text("  no errors", DIM)
    if line.outages:
        yield Text(f"  went down {line.outages} times", BAD)


def _pace(model: BenchModel) -> Iterator[Text]:
    pace = model.pace
    if not pace:
        return
    factor = pace["factor"] * model.speed
    slow = pace["factor"] < _SLOW_FACTOR
    wanted = f" of {model.speed:g}" if model.speed != 1 else ""
    yield Text.assemble(("pace     ", HEAD), (f"{factor:.2f}{wanted} x real time", BAD if slow else ""))
    late = f"  late   p50 {ns_words(pace['p50_ns'])}, p99 {ns_words(pace['p99_ns'])}, most {ns_words(pace['max_ns'])}"
    yield Text(late, DIM)
    if pace["slips"]:
        yield Text(f"  bench time stood still {pace['slips']} times, {ns_words(pace['slipped_ns'])} in all", BAD)


def _driver(model: BenchModel) -> Text:
    driver = model.driver
    if not driver.who:
        return Text("nobody can drive here", DIM)
    how = f"  {driver.forward:+.1f} ahead {driver.turn:+.1f} left" if driver.who == "user" else ""
    return Text.assemble(("driver   ", HEAD), driver.who, how)


def timers_view(model: BenchModel, width: int) -> list[Text]:
    """Return the timers of every machine as bars that run down, and what was missed in a row."""
    lines: list[Text] = []
    for machine in model.machines.values():
        if machine.timers or machine.misses:
            lines.append(fit(Text(machine.title, HEAD), width))
        lines += [fit(_timer(name, timer, model.ns, width), width) for name, timer in machine.timers.items()]
        lines += [fit(_misses(name, about, width), width) for name, about in machine.misses.items()]
    return lines or [Text("no timer has run yet", DIM)]


def _timer(name: str, timer: TimerModel, now_ns: int, width: int) -> Text:
    room = _room(width)
    left_ns = timer.left_ns(now_ns)
    if left_ns is None:
        return Text.assemble(f"  {name:<13}", (" " * room + f"{'stopped':>10}", DIM), _margins(timer))
    share = left_ns / max(1, timer.span_ns)
    style = BAD if share < _NEAR and timer.worst_ns is not None else GOOD
    return Text.assemble(f"  {name:<13}", (bar(share, room), style), f" {ns_words(left_ns):>9}", _margins(timer))


def _misses(name: str, about: tuple[int, int, int], width: int) -> Text:
    """Return how many deadlines were missed in a row: the bar grows, and at its end something happens."""
    now, most, worst = about
    share = now / max(1, most)
    said = f" {f'{now} of {most}':>9}"
    style = BAD if share > 1 - _NEAR else DIM if not now else ""
    return Text.assemble(f"  {f'{name} missed':<13}"[:15], (bar(share, _room(width)), style), said, (f"  most {worst}", DIM))


def _room(width: int) -> int:
    return max(6, width - 54)


def _margins(timer: TimerModel) -> Text:
    """Return the margins: what was left the last time, and the least that ever was."""
    if timer.worst_ns is None:
        return Text(f"  of {ns_words(timer.span_ns)}" if timer.span_ns else "", DIM)
    last = "" if timer.margin_ns is None or timer.is_fast else f"  last {ns_words(timer.margin_ns)}"
    last = f"  of {ns_words(timer.span_ns)}" if timer.is_fast else last
    if not timer.worst_ns:
        return Text.assemble((last, DIM), ("  ran out", DIM))
    style = BAD if timer.worst_ns < _NEAR * timer.span_ns else DIM
    return Text.assemble((last, DIM), (f"  min {ns_words(timer.worst_ns)}", style))


def counters_view(model: BenchModel, width: int) -> list[Text]:
    """Return the counters of every machine with their rates; what counts errors is marked once it has counted.

    Machines that count the same things stand side by side, others below. Of many counters those that have counted
    nothing are left out, and how many they are is said.
    """
    blocks: dict[tuple[str, ...], list[MachineModel]] = {}
    for machine in model.machines.values():
        if machine.counters:
            blocks.setdefault(tuple(machine.counters), []).append(machine)
    lines: list[Text] = []
    for machines in _joined(list(blocks.values())):
        lines += [fit(line, width) for line in _block(machines, width, model.ns)]
    return lines or [Text("nothing is counted yet", DIM)]


def _joined(blocks: list[list[MachineModel]]) -> list[list[MachineModel]]:
    """Join the blocks that have room side by side: two ends that do not count quite the same are still compared."""
    everyone = [machine for block in blocks for machine in block]
    return [everyone] if len(everyone) <= _SIDE_BY_SIDE else blocks


def _block(machines: list[MachineModel], width: int, now_ns: int) -> Iterator[Text]:
    names = dict.fromkeys(name for machine in machines for name in machine.counters)
    shown = [name for name in names if len(names) <= _MANY or name in _ALWAYS or _counted(machines, name)]
    column = max(8, (width - _NAMES) // len(machines))
    yield Text(f"{'':<{_NAMES}}" + "".join(f"{machine.name:>{column}}" for machine in machines), HEAD)
    for name in sorted(shown, key=lambda one: one not in TRAFFIC):
        line = Text(f"{name.replace('_', ' '):<{_NAMES}}")
        for machine in machines:
            line.append_text(_cell(name, machine.counters.get(name), column, now_ns if column >= _WITH_RATE else None))
        yield line
    if len(shown) < len(names):
        yield Text(f"and {len(names) - len(shown)} more, all 0", DIM)


def _counted(machines: list[MachineModel], name: str) -> bool:
    return any(machine.counters[name].value for machine in machines if name in machine.counters)


def _cell(name: str, counted: Counted | None, column: int, now_ns: int | None) -> Text:
    if counted is None:
        return Text(f"{'-':>{column}}", DIM)
    said = str(counted.value) if now_ns is None else f"{counted.value} {rate_words(counted.per_s(now_ns)):>9}"
    return Text(f"{said:>{column}}", DIM if not counted.value else "" if name in TRAFFIC else BAD)


def strip_view(model: BenchModel, width: int) -> Text:
    """Return the most important of all panes in one line, for screens that have no room for them."""
    parts = [
        Text.assemble((f"{machine.name} ", DIM), (machine.state or "?", HEAD)) for machine in model.machines.values()
    ]
    timer = _tightest(model)
    if timer is not None:
        name, left_ns, share = timer
        parts.append(Text.assemble((f"{name} ", DIM), (f"{bar(share, 8)} {ns_words(left_ns)}", "")))
    bad = sum(
        counted.value
        for machine in model.machines.values()
        for name, counted in machine.counters.items()
        if name not in TRAFFIC
    )
    parts.append(Text(f"{bad} errors", BAD if bad else DIM))
    if model.pace:
        parts.append(Text(f"{model.pace['factor'] * model.speed:.2f} x", DIM))
    return fit(Text("  ").join(parts), width)


def _tightest(model: BenchModel) -> tuple[str, int, float] | None:
    running = [
        (name, left_ns, timer.span_ns)
        for machine in model.machines.values()
        for name, timer in machine.timers.items()
        if timer.deadline_ns is not None and (left_ns := timer.left_ns(model.ns)) is not None
    ]
    if not running:
        return None
    name, left_ns, span_ns = min(running, key=lambda one: one[1] / max(1, one[2]))
    return name, left_ns, left_ns / max(1, span_ns)
