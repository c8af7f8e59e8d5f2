"""Keeps what a picture of the dashboard needs of one case: its events, and where machines, timers and lines are.

It is the listener of the journal and puts nothing into it, so that a case that is watched has the hash it always had.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.state_reporter import REPORT_EVERY_NS, Observed, Senses, Watched, describe_line, describe_machine
from hilbench.judging.provider import CaseView
from hilbench.links import Port

__all__ = ["Watch"]

_CHECKER = "checker"
KEPT_EVENTS = 50_000
"""The latest of a case, some seconds of the busiest bench (choice); what is drawn is its end."""


class Watch:
    """See the module.

    Args:
        bench: whose journal is listened to.
        machines: says which state machines there are, by their source in the journal; asked again and again, since a
            case builds only what it uses.
        lines: those of the checker's ends of the lines.
        senses: what the ends of timers mean.
    """

    def __init__(
        self,
        bench: Bench,
        machines: Callable[[], Mapping[str, Observed]],
        lines: Callable[[], Mapping[str, Port]],
        senses: Senses,
    ) -> None:
        self._bench = bench
        self._machines = machines
        self._lines = lines
        self._senses = senses
        self._events: deque[Mapping[str, Any]] = deque(maxlen=KEPT_EVENTS)
        self._watched: dict[str, Watched] = {}
        self._tell_at_ns = bench.now_ns
        self._placing = _Placing()
        self._events.extend(_since_the_case_began(bench.journal.recent))
        bench.journal.on_event = self._take

    def _take(self, event: Mapping[str, Any]) -> None:
        now_ns = self._bench.now_ns
        lines = self._lines()
        self._events.append(self._placing.place(event, lines) if len(lines) > 1 else event)
        for name, observed in self._machines().items():
            if name not in self._watched:
                self._watched[name] = Watched(observed, self._senses.get(name, {}))
            self._watched[name].look(now_ns)
        if now_ns >= self._tell_at_ns:
            self._tell_at_ns = now_ns + REPORT_EVERY_NS
            self._tell(whole=False)

    def view(self, about: Mapping[str, Any]) -> CaseView:
        """Return what there is to be seen now, and listen no more.

        Args:
            about: what the header of a journal says to those who show it; see `hilbench.bench.about`.
        """
        self._bench.journal.on_event = None
        self._tell(whole=True)
        machines = {name: describe_machine(observed) for name, observed in self._machines().items()}
        return CaseView(about={**about, "machines": machines}, events=tuple(self._events))

    def _tell(self, *, whole: bool) -> None:
        """Say where everything is, as a live bench does."""
        now_ns = self._bench.now_ns
        for name, watched in self._watched.items():
            watched.look(now_ns)
            if news := watched.news(whole=whole):
                self._events.append({"ns": now_ns, "kind": "machine", "source": name, **news})
        for name, port in self._lines().items():
            event = {"ns": now_ns, "kind": "link", "source": name, **describe_line(port)}
            self._events.append(event)


class _Placing:
    """Finds on which of several lines the checker's bytes were: the journal has the same source for all of them.

    The checker says what it sends before it does, and what it has heard while it hears it.
    """

    def __init__(self) -> None:
        self._listening: dict[str, Callable[[bytes, int], None]] = {}
        self._hears = ""
        self._to_send: dict[str, Any] | None = None

    def place(self, event: Mapping[str, Any], lines: Mapping[str, Port]) -> Mapping[str, Any]:
        """Return an event with its line as its source, if it is of bytes of the checker's; else as it is."""
        for name, port in lines.items():
            if port.on_receive is not self._listening.get(name):
                self._listen(name, port)
        if event["source"] != _CHECKER or event["kind"] not in {"tx", "rx"}:
            return event
        placed = {**event, "source": self._hears or _CHECKER} if event["kind"] == "rx" else dict(event)
        self._to_send = placed if event["kind"] == "tx" else None
        return placed

    def _listen(self, name: str, port: Port) -> None:
        heard, sent = port.on_receive, port.on_sent

        def on_receive(data: bytes, at_ns: int) -> None:
            before, self._hears = self._hears, name
            try:
                heard(data, at_ns)
            finally:
                self._hears = before

        def on_sent(data: bytes, at_ns: int) -> None:
            if self._to_send is not None:
                self._to_send["source"] = name
                self._to_send = None
            sent(data, at_ns)

        self._listening[name] = port.on_receive = on_receive
        port.on_sent = on_sent


def _since_the_case_began(events: Sequence[Mapping[str, Any]]) -> Sequence[Mapping[str, Any]]:
    """Return what building the bench of the case has recorded already."""
    latest = list(events)
    begun = [at for at, event in enumerate(latest) if event["kind"] == "case"]
    return latest[begun[-1] :] if begun else []
