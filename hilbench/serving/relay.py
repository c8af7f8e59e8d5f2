"""What stands between two ends of a line: hands each byte on, with faults on the way, and records what passed.

Without faults a chunk is handed on as it came, in the same entry of the scheduler. With faults each byte is decided on
(`hilbench.links.faults`), and the journal has both what an end said and what the other end got.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from functools import partial

from hilbench.bench import Bench
from hilbench.bench.byte_log import ByteLog
from hilbench.bench.line_faults import LineFaults
from hilbench.benchfile.fault_entries import FaultEntry
from hilbench.errors import UnavailableError
from hilbench.links import Port
from hilbench.links.door import Door
from hilbench.links.port import USUAL_BREAK_NS, ModemLines, Refused

__all__ = ["CLIENT", "SERVER", "A", "B", "Heard", "Relay"]

A, B = "a", "b"
"""The ends, as a file of faults names them."""
CLIENT, SERVER = "client", "server"
"""Who is at end A and at end B, as the journal names them."""

Heard = Callable[[str, bytes, int], None]
"""Takes who has said something, the bytes, and the bench time in ns."""


def _nobody(_who: str, _data: bytes, _at_ns: int) -> None:
    """Stand in for somebody who listens."""


class Relay:
    """See the module.

    Args:
        bench: whose time and journal are used.
        a: our end of the line to the client.
        b: our end of the line to the server.
        faults: what goes wrong on the way; each is towards `A` or `B`.
        seed: decides what chance decides.
        record: whether the journal gets the bytes.
        heard: receives what each end says.

    Attributes:
        faults: those in force; None without any.
        on_refused: Called with a sentence for people when an end cannot do what the other has asked for: the server's
            line has not the rate that the client has set, an end knows no breaks, or does not take what comes (once
            each), a fault cannot strike.
    """

    def __init__(
        self,
        bench: Bench,
        a: Port,
        b: Port,
        *,
        faults: Sequence[FaultEntry] = (),
        seed: int = 0,
        record: bool = True,
        heard: Heard = _nobody,
    ) -> None:
        self._bench = bench
        self._heard = heard
        self._a, self._b, far = a, b, b
        self._ends = {CLIENT: a, SERVER: b}
        self._refused_baud = 0
        self._gone: dict[str, bool] = {}  # whether an end was gone itself when its line went down
        self._unheard_breaks: set[str] = set()  # of whom breaks do not get through, and that was said
        self.on_refused: Callable[[str], None] = _say_nothing
        self.faults: LineFaults | None = None
        if faults:
            self.faults = LineFaults(bench, faults, seed=seed, near_is_client=True, is_client_end=A.__eq__)
            self.faults.on_refused = self._fault_refused
            far = self.faults.on(b)
        self._logs: dict[str, list[ByteLog]] = {CLIENT: [], SERVER: []}  # by who has said the bytes
        self._lost = {CLIENT: 0, SERVER: 0}
        self._too_slow: set[str] = set()  # who was said to lose bytes
        log = self._log if record else _no_log
        # What is said comes first: so it is written before what is got of it.
        said = {who: log("tx", who) for who in (CLIENT, SERVER)}
        a.on_receive = partial(self._pass, CLIENT, said[CLIENT], far.write)
        if self.faults is None:
            b.on_receive = partial(self._pass, SERVER, said[SERVER], a.write)
        else:
            a.on_sent, b.on_sent = log("rx", CLIENT), log("rx", SERVER)
            corrupt = b.on_receive
            b.on_receive = partial(self._pass, SERVER, said[SERVER], lambda data: corrupt(data, bench.now_ns))
            far.on_receive = lambda data, _at_ns: a.write(data)
        a.on_break = partial(self._broke, CLIENT, a, far.send_break)
        far.on_break = partial(self._broke, SERVER, far, a.send_break)
        if isinstance(a, Door):
            a.on_lines = self._lines_set
        b.on_modem = self._modem_changed
        far.on_refused = self._rate_refused
        if (lines := b.modem_lines) is not None:
            self._modem_changed(lines, bench.now_ns)
        a.on_line = partial(self._line_changed, CLIENT)
        far.on_line = partial(self._line_changed, SERVER)

    def finish(self) -> None:
        """Record what was lost and what passed and is not recorded yet."""
        self.tell_losses()
        self.flush()

    def flush(self) -> None:
        """Record what passed and is not recorded yet."""
        for who in (CLIENT, SERVER):
            self._flush(who)

    def tell_losses(self) -> None:
        """Record what an end that is there has not taken since this was last called; say so the first time."""
        for who, end in self._ends.items():
            if end.line_is_up and self._record_loss(who) and who not in self._too_slow:
                self._too_slow.add(who)
                self.on_refused(f"{who}: does not take all that comes; what it leaves is lost")

    def _record_loss(self, who: str) -> bool:
        """Record what an end has lost while it was there and is not recorded; say whether there was any."""
        end = self._ends[who]
        lost, self._lost[who] = end.counters.lost - self._lost[who], end.counters.lost
        if lost:
            self._record("lost", who, bytes=lost)
        return lost > 0

    def _log(self, kind: str, who: str) -> Callable[[bytes, int], None]:
        """Return what takes bytes into the journal; those of the other direction that came before are in it by then."""
        speaker, other = (CLIENT, SERVER) if (kind == "tx") == (who == CLIENT) else (SERVER, CLIENT)
        log = ByteLog(self._bench, kind, who, partial(self._flush, speaker))
        self._logs[speaker].append(log)

        def take(data: bytes, at_ns: int) -> None:
            self._flush(other)
            log.add(data, at_ns)

        return take

    def _flush(self, speaker: str) -> None:
        for log in self._logs[speaker]:
            log.flush()

    def _record(self, kind: str, who: str, **fields: object) -> None:
        """Record something behind the bytes that came before it."""
        self.flush()
        self._bench.record(kind, who, **fields)

    def _pass(
        self,
        who: str,
        log: Callable[[bytes, int], None],
        onward: Callable[[bytes], None],
        data: bytes,
        at_ns: int,
    ) -> None:
        log(data, at_ns)
        self._heard(who, data, at_ns)
        if who == CLIENT:
            self._follow()
        onward(data)

    def _follow(self) -> None:
        """Let the server's line have the rate that the client has set at its door, if it can."""
        if not isinstance(self._a, Door) or not self._b.baud:
            return
        wanted = self._a.client_baud
        if wanted in (0, self._b.baud, self._refused_baud):
            return
        try:
            self._b.baud = wanted
        except UnavailableError as error:
            self._rate_refused(wanted, error)
        else:
            self._refused_baud = 0
            self._record("baud", CLIENT, baud=wanted)

    def _rate_refused(self, baud: int, error: UnavailableError) -> None:
        self._refused_baud = baud
        self._record("baud-refused", CLIENT, baud=baud, text=str(error))
        self.on_refused(f"{CLIENT}: {error}; it keeps its own rate")

    def _broke(self, who: str, end: Port, onward: Callable[[int, Refused], None], _at_ns: int) -> None:
        known_ns = end.break_ns
        self._record("break", who, duration_ns=known_ns or None)
        try:
            onward(known_ns or USUAL_BREAK_NS, partial(self._break_refused, who))
        except UnavailableError as error:
            self._break_refused(who, error)

    def _break_refused(self, who: str, error: UnavailableError) -> None:
        """Say, once, that breaks of `who` do not get through."""
        if who not in self._unheard_breaks:
            self._unheard_breaks.add(who)
            self._record("break-refused", who, text=str(error))
            self.on_refused(f"{who}: {error}")

    def _fault_refused(self, text: str) -> None:
        self.on_refused(text)

    def _lines_set(self, dtr: bool | None, rts: bool | None, _at_ns: int) -> None:
        """Let the server's line have the levels that the client has set, if it has such lines."""
        taken = False
        with contextlib.suppress(UnavailableError):  # it has none, or is gone
            self._b.set_lines(dtr=dtr, rts=rts)
            taken = True
        self._record("lines", CLIENT, dtr=dtr, rts=rts, taken=taken)

    def _modem_changed(self, lines: ModemLines, _at_ns: int) -> None:
        """Let the client know the levels of the server's lines, if there is a way to tell it."""
        told = isinstance(self._a, Door) and self._a.tell_lines(lines)
        self._record("modem", SERVER, cts=lines.cts, dsr=lines.dsr, ri=lines.ri, cd=lines.cd, told=told)

    def _line_changed(self, who: str, up: bool, _at_ns: int) -> None:
        end = self._ends[who]
        if not up:
            self._gone[who] = not end.line_is_up  # else a fault has interrupted the line
            self._record_loss(who)
        elif self._gone.get(who, True):
            self._lost[who] = end.counters.lost  # with nobody there: no loss to speak of
            if who == SERVER:
                self._refused_baud = 0  # it may be another, or may not have been able to answer
        self._record("line", who, up=up)


def _say_nothing(_text: str) -> None:
    """Stand in for somebody who tells a person."""


def _ignore(_data: bytes, _at_ns: int) -> None:
    """Stand in for a journal."""


def _no_log(_kind: str, _who: str) -> Callable[[bytes, int], None]:
    return _ignore
