"""The link, its watchdogs and its counters."""

from __future__ import annotations

from collections.abc import Iterator

from rich.text import Text

from hilbench.tui.model.bench import BenchModel, LineModel
from hilbench.tui.model.machines import TRAFFIC, TimerModel
from hilbench.tui.model.rates import Counted
from hilbench.tui.views.words import BAD, DIM, GOOD, HEAD, bar, bytes_words, fit, ns_words, rate_words

__all__ = ["counters_view", "link_view", "strip_view", "timers_view"]

_LINE_ERRORS = ("lost", "overruns", "framing_errors", "breaks", "refused", "withdrawn")
_SLOW_FACTOR = 0.98
_NEAR = 0.25
_WITH_RATE = 19


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
    """Return the timers of every machine as bars that run down."""
    lines: list[Text] = []
    for machine in model.machines.values():
        if machine.timers:
            lines.append(fit(Text(machine.name, HEAD), width))
        lines += [fit(_timer(name, timer, model.ns, width), width) for name, timer in machine.timers.items()]
    return lines or [Text("no timer has run yet", DIM)]


def _timer(name: str, timer: TimerModel, now_ns: int, width: int) -> Text:
    room = max(6, width - 37)
    if timer.deadline_ns is None:
        return Text.assemble(f"  {name:<11}", (" " * room + "   stopped", DIM), _worst(timer))
    left_ns = max(0, timer.deadline_ns - now_ns)
    share = left_ns / max(1, timer.span_ns)
    style = BAD if share < _NEAR else GOOD
    return Text.assemble(f"  {name:<11}", (bar(share, room), style), f" {ns_words(left_ns):>9}", _worst(timer))


def _worst(timer: TimerModel) -> tuple[str, str]:
    """Return the worst margin: what was left at the least when it was set anew."""
    if timer.worst_ns is None:
        return "", ""
    if not timer.worst_ns:
        return "  ran out", DIM
    return f"  min {ns_words(timer.worst_ns)}", BAD if timer.worst_ns < _NEAR * timer.span_ns else DIM


def counters_view(model: BenchModel, width: int) -> list[Text]:
    """Return the counters of every machine with their rates; what counts errors is marked once it has counted."""
    names = dict.fromkeys(name for machine in model.machines.values() for name in machine.counters)
    machines = [machine for machine in model.machines.values() if machine.counters]
    if not names:
        return [Text("nothing is counted yet", DIM)]
    column = max(8, (width - 19) // len(machines))
    with_rates = column >= _WITH_RATE
    head = "".join(f"{machine.name:>{column}}" for machine in machines)
    lines = [fit(Text(f"{'':<19}{head}", HEAD), width)]
    for name in sorted(names, key=lambda one: one not in TRAFFIC):
        line = Text(f"{name.replace('_', ' '):<19}")
        for machine in machines:
            line.append_text(_cell(name, machine.counters.get(name), column, model.ns if with_rates else None))
        lines.append(fit(line, width))
    return lines


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
        (name, max(0, timer.deadline_ns - model.ns), timer.span_ns)
        for machine in model.machines.values()
        for name, timer in machine.timers.items()
        if timer.deadline_ns is not None
    ]
    if not running:
        return None
    name, left_ns, span_ns = min(running, key=lambda one: one[1] / max(1, one[2]))
    return name, left_ns, left_ns / max(1, span_ns)
