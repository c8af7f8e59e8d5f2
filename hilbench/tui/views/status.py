"""The link, its watchdogs and its counters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.text import Text

from hilbench.tui.model.bench import BenchModel, LineModel
from hilbench.tui.model.machines import MachineModel, TimerModel
from hilbench.tui.model.rates import Counted
from hilbench.tui.views.words import BAD, DIM, GOOD, HEAD, bar, bytes_words, fit, ns_words, rate_words

__all__ = ["clock_words", "counters_view", "link_view", "strip_view", "timers_view"]

LINE_ERRORS = (
    "lost",
    "overruns",
    "framing_errors",
    "parity_errors",
    "receive_overruns",
    "breaks",
    "breaks_unsent",
    "refused",
    "withdrawn",
)
_WAYS = (("sent", "sent"), ("heard", "received"))
_NEAR = 0.25
_WITH_RATE = 19
_WITH_LAST = 70
_NAMES = 19
_SIDE_BY_SIDE = 2
_MANY = 24
_ALWAYS = frozenset({"bytes_in", "bytes_out", "frames_in", "frames_out", "noise"})


def link_view(model: BenchModel, width: int) -> list[Text]:
    """Return what is known of the operator's line, or of his lines to each board, and how the host keeps up."""
    if len(model.lines) == 1:
        lines = [text for name, line in model.lines.items() for text in _line(model, name, line, width)]
    else:
        lines = list(_several_lines(model, width)) or [Text("no line to watch", DIM)]
    lines += _pace(model)
    lines.append(_driver(model))
    lines += _listed("faults armed   ", model.armed, "", width)
    lines += _listed("faults struck  ", [f"{count} {name}" for name, count in model.faults.items()], BAD, width)
    return [fit(line, width) for line in lines]


def _listed(title: str, names: Sequence[str], style: str, width: int) -> Iterator[Text]:
    """Return names in a line; where they do not fit, one in a line."""
    joined = f"{title}{', '.join(names)}"
    if len(joined) <= width:
        names = [", ".join(names)] if names else []
    for number, name in enumerate(names):
        yield Text(f"{'' if number else title:<{len(title)}}{name}", style)


def _line(model: BenchModel, name: str, line: LineModel, width: int) -> Iterator[Text]:
    about = line.about
    baud = f"{about['baud']} baud" if about.get("baud") else "no pace"
    state = ("up", GOOD) if about.get("up") else ("DOWN", BAD)
    yield Text.assemble((f"{name:<9}", HEAD), state, f"  {baud}  ", (str(about.get("port", "")), DIM))
    for way, counter in _WAYS:
        counted = line.counters.get(counter)
        if counted is not None:
            per_s = counted.per_s(model.ns)
            share = per_s * 10 / about["baud"] if about.get("baud") else 0.0
            used = f"  {share:4.0%}" if about.get("baud") else ""
            said = f"  {way:<7}{bytes_words(counted.value):>9} {rate_words(per_s):>9}{used}"
            yield Text(f"{said} of the line" if used and len(said) + 12 <= width else said)
    yield _errors(line)
    if line.outages:
        yield Text(f"  went down {line.outages} times", BAD)


def _several_lines(model: BenchModel, width: int) -> Iterator[Text]:
    """Return the lines, those that lead to one board below its name where there are several boards."""
    by_board: dict[str, list[str]] = {}
    for name, line in model.lines.items():
        board = str(line.about.get("port", "")).partition(".")[0]
        by_board.setdefault(board if board in model.live.get("boards", {}) else "", []).append(name)
    column = max((len(name) + 1 for name in model.lines), default=0)
    inset = "  " if len(by_board) > 1 else ""
    for board in sorted(by_board):
        if inset:
            yield Text(board or "other lines", HEAD)
        for name in by_board[board]:
            yield from (Text.assemble(inset, text) for text in _short_line(model, name, column, width - len(inset)))


def _short_line(model: BenchModel, name: str, column: int, width: int) -> Iterator[Text]:
    """As `_line`, where there are several: what goes both ways stands side by side where there is room."""
    line = model.lines[name]
    about = line.about
    state = ("up  ", GOOD) if about.get("up") else ("DOWN", BAD)
    baud = (f"  {about['baud']} baud" if about.get("baud") else "", DIM)
    down = f"  down {line.outages}x" if line.outages else ""
    yield Text.assemble((f"{name:<{column}}", HEAD), state, (down, BAD), _errors(line), baud)
    ways, shares = [], []
    for way, counter in _WAYS:
        counted = line.counters.get(counter)
        if counted is not None:
            per_s = counted.per_s(model.ns)
            ways.append(f"  {way:<6}{bytes_words(counted.value):>8} {rate_words(per_s):>9}")
            shares.append(f"{ways[-1]} {per_s * 10 / about['baud']:4.0%}" if about.get("baud") else ways[-1])
    beside = next((said for said in ("".join(shares), "".join(ways)) if len(said) <= width), "")
    yield from map(Text, [beside] if beside else shares)


def _errors(line: LineModel) -> Text:
    errors = [(word, line.counters[word].value) for word in LINE_ERRORS if word in line.counters]
    shown = ", ".join(f"{count} {word.replace('_', ' ')}" for word, count in errors if count)
    return Text(f"  errors {shown}", BAD) if shown else Text("  no errors", DIM)


def _pace(model: BenchModel) -> Iterator[Text]:
    pace = model.pace
    if not pace:
        return
    factor = (model.factor or 0.0) * model.speed
    wanted = f" of {model.speed:g}" if model.speed != 1 else ""
    whole = f"{pace['factor'] * model.speed:.2f}"
    before = ("", DIM) if whole == f"{factor:.2f}" else (f", {whole} in all", DIM)
    yield Text.assemble(("pace     ", HEAD), (f"{factor:.2f}{wanted} x real time", BAD if model.slow else ""), before)
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
    machines = [machine for machine in model.machines.values() if machine.timers or machine.misses]
    names = [name for machine in machines for name in (*machine.timers, *map(_missed, machine.misses))]
    column = max(11, *(len(name) + 1 for name in names), 0)
    for machine in machines:
        lines.append(fit(Text(machine.title, HEAD), width))
        lines += [fit(_timer(name, timer, model.ns, width, column), width) for name, timer in machine.timers.items()]
        lines += [fit(_misses(name, about, width, column), width) for name, about in machine.misses.items()]
    return lines or [Text("no timer has run yet", DIM)]


def _timer(name: str, timer: TimerModel, now_ns: int, width: int, column: int) -> Text:
    room = _room(width, column)
    left_ns = timer.left_ns(now_ns)
    if left_ns is None:
        return Text.assemble(f"  {name:<{column}}", (" " * room + f"{'stopped':>10}", DIM), _margins(timer, width))
    share = left_ns / max(1, timer.span_ns)
    style = BAD if share < _NEAR and timer.worst_ns is not None else GOOD
    shown = (bar(share, room), style), f" {ns_words(left_ns):>9}"
    return Text.assemble(f"  {name:<{column}}", *shown, _margins(timer, width))


def _misses(name: str, about: tuple[int, int, int], width: int, column: int) -> Text:
    """Return how many deadlines were missed in a row: the bar grows, and at its end something happens."""
    now, most, worst = about
    share = now / max(1, most)
    said = f" {f'{now} of {most}':>9}"
    style = BAD if share > 1 - _NEAR else DIM if not now else ""
    shown = (bar(share, _room(width, column)), style), said, (f"  most {worst}", DIM)
    return Text.assemble(f"  {_missed(name):<{column}}", *shown)


def _missed(name: str) -> str:
    return f"{name} missed"


def _room(width: int, column: int) -> int:
    """Return how long a bar may be: behind it stand what is left, and one margin, or two where there is room."""
    return max(6, width - column - (42 if width >= _WITH_LAST else 26))


def _margins(timer: TimerModel, width: int) -> Text:
    """Return the margins: the least that was ever left, and where there is room what was the last time."""
    said = Text()
    if timer.worst_ns is not None:
        bad = 0 < timer.worst_ns < _NEAR * timer.span_ns
        said.append(f"  min {ns_words(timer.worst_ns)}" if timer.worst_ns else "  ran out", BAD if bad else DIM)
    if timer.span_ns and (timer.worst_ns is None or timer.is_fast):
        said.append(f"  of {ns_words(timer.span_ns)}", DIM)
    elif timer.margin_ns and width >= _WITH_LAST:
        said.append(f"  last {ns_words(timer.margin_ns)}", DIM)
    return said


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
        lines += [fit(line, width) for line in _block(machines, width, model)]
    return lines or [Text("nothing is counted yet", DIM)]


def _joined(blocks: list[list[MachineModel]]) -> list[list[MachineModel]]:
    """Join the blocks that have room side by side: two ends that do not count quite the same are still compared."""
    everyone = [machine for block in blocks for machine in block]
    return [everyone] if len(everyone) <= _SIDE_BY_SIDE else blocks


def _block(machines: list[MachineModel], width: int, model: BenchModel) -> Iterator[Text]:
    traffic = model.dashboard.traffic
    names = dict.fromkeys(name for machine in machines for name in machine.counters)
    shown = [name for name in names if len(names) <= _MANY or name in _ALWAYS or _counted(machines, name)]
    column = max(8, (width - _NAMES) // max(1, len(machines)))
    yield Text(f"{'':<{_NAMES}}" + "".join(f"{machine.name:>{column}}" for machine in machines), HEAD)
    for name in sorted(shown, key=lambda one: one not in traffic):
        line = Text(f"{name.replace('_', ' '):<{_NAMES}}")
        for machine in machines:
            now_ns = model.ns if column >= _WITH_RATE else None
            line.append_text(_cell(machine.counters.get(name), column, now_ns, "" if name in traffic else BAD))
        yield line
    if len(shown) < len(names):
        yield Text(f"and {len(names) - len(shown)} more, all 0", DIM)


def _counted(machines: list[MachineModel], name: str) -> bool:
    return any(machine.counters[name].value for machine in machines if name in machine.counters)


def _cell(counted: Counted | None, column: int, now_ns: int | None, style: str) -> Text:
    if counted is None:
        return Text(f"{'-':>{column}}", DIM)
    said = str(counted.value) if now_ns is None else f"{counted.value} {rate_words(counted.per_s(now_ns)):>9}"
    return Text(f"{said:>{column}}", style if counted.value else DIM)


def clock_words(model: BenchModel) -> str:
    """Return how bench time passes, where it is not as the host's: nobody is to take a slow bench for a slow robot."""
    if model.paused:
        return "PAUSED"
    if not model.slow or model.factor is None:
        return "" if model.speed == 1 else f"{model.speed:g} x"
    now = f"{model.factor * model.speed:.2f}"
    return f"SLOW: {now} x real time" if model.speed == 1 else f"{now} of {model.speed:g} x"


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
        if name not in model.dashboard.traffic
    )
    parts.append(Text(f"{bad} errors", BAD if bad else DIM))
    if model.factor is not None:
        parts.append(Text(f"{model.factor * model.speed:.2f} x", BAD if model.slow else DIM))
    return fit(Text("  ").join(parts), width)


def _tightest(model: BenchModel) -> tuple[str, int, float] | None:
    running = [
        (name, left_ns, timer.span_ns)
        for machine in model.machines.values()
        for name, timer in machine.timers.items()
        if timer.deadline_ns is not None and not timer.rest and (left_ns := timer.left_ns(model.ns)) is not None
    ]
    if not running:
        return None
    name, left_ns, span_ns = min(running, key=lambda one: one[1] / max(1, one[2]))
    return name, left_ns, left_ns / max(1, span_ns)
