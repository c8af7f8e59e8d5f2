"""The link, how bench time passes, and all that matters most in one line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.text import Text

from hilbench.tui.model.bench import BenchModel, LineModel
from hilbench.tui.views.words import BAD, DIM, GOOD, HEAD, bar, bytes_words, fit, ns_words, rate_words

__all__ = ["clock_words", "link_view", "strip_view"]

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


def link_view(model: BenchModel, width: int) -> list[Text]:
    """Return what is known of the operator's line, or of his lines to each board, and how the host keeps up."""
    if len(model.lines) == 1:
        lines = [text for name, line in model.lines.items() for text in _line(model, name, line, width)]
    else:
        lines = list(_several_lines(model, width)) or [Text("no line to watch", DIM)]
    lines += _pace(model)
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
        count = f"{pace['slips']} time{'s' * (pace['slips'] != 1)}"
        yield Text(f"  bench time stood still {count}, {ns_words(pace['slipped_ns'])} in all", BAD)


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
