"""Keeps what a picture of the dashboard needs of one case: its events, and where machines, timers and lines are.

It is the listener of the journal and puts nothing into it, so that a case that is watched has the hash it always had.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from typing import Any

from hilbench.bench import Bench
from hilbench.check.provider import CaseView
from hilbench.links import Port
from hilbench.live.teller import Observed, Watched, describe_machine

__all__ = ["Watch"]

KEPT_EVENTS = 50_000
"""The latest of a case, some seconds of the busiest bench (choice); what is drawn is its end."""


class Watch:
    """See the module.

    Args:
        bench: whose journal is listened to.
        machines: says which state machines there are, by their source in the journal; asked after each event, since a
            case builds only what it uses.
    """

    def __init__(self, bench: Bench, machines: Callable[[], Mapping[str, Observed]]) -> None:
        self._bench = bench
        self._machines = machines
        self._events: deque[Mapping[str, Any]] = deque(maxlen=KEPT_EVENTS)
        self._watched: dict[str, Watched] = {}
        bench.journal.on_event = self._take

    def _take(self, event: Mapping[str, Any]) -> None:
        self._events.append(event)
        for name, observed in self._machines().items():
            if name not in self._watched:
                self._watched[name] = Watched(observed)
            self._watched[name].look(self._bench.now_ns)

    def view(self, about: Mapping[str, Any], lines: Mapping[str, Port]) -> CaseView:
        """Return what there is to be seen now, and listen no more.

        Args:
            about: what the header of a journal says to those who show it; see `hilbench.live.about`.
            lines: the checker's ends of the lines.
        """
        self._bench.journal.on_event = None
        machines = {name: describe_machine(observed) for name, observed in self._machines().items()}
        now = [*self._machines_now(), *self._lines_now(lines)]
        return CaseView(about={**about, "machines": machines}, events=(*self._events, *now))

    def _machines_now(self) -> Iterator[Mapping[str, Any]]:
        now_ns = self._bench.now_ns
        for name, watched in self._watched.items():
            watched.look(now_ns)
            yield {"ns": now_ns, "kind": "machine", "source": name, **watched.news(whole=True)}

    def _lines_now(self, lines: Mapping[str, Port]) -> Iterator[Mapping[str, Any]]:
        for name, port in lines.items():
            about = {"port": port.name, "up": port.line_is_up, "baud": port.baud, "pending": port.pending}
            event = {"ns": self._bench.now_ns, "kind": "link", "source": name}
            yield {**event, **about, **asdict(port.counters)}
