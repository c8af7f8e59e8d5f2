"""What boards do, as lines for a person: bench time, who, what."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass, Scheduler
from hilbench.mcu.emulated import EmulatedBench

__all__ = ["Narrator", "TextLines"]

LINE_IDLE_NS = 100 * NS_PER_MS
"""After so long without a byte the beginning of a line is shown as it is (choice)."""
LINE_BYTES = 160
I2C_BYTES = 16
"""Of a message on an I2C bus so many bytes are shown (choice)."""
SHOWN_NOTES = 2
"""Of one cause so many notes are shown whole (choice)."""
ROUNDING_NS = 1
"""Spans between edges whose times are rounded down to the nanosecond differ so much by that alone."""

Say = Callable[[str], None]


class TextLines:
    """Makes lines of bytes.

    Args:
        scheduler: owner of bench time.
        source: who speaks.
        take: called with the bench time of the first byte and the line, without its end.
    """

    def __init__(self, scheduler: Scheduler, source: str, take: Callable[[int, str], None]) -> None:
        self._scheduler = scheduler
        self._source = source
        self._take = take
        self._line = bytearray()
        self._begin_ns = 0
        self._last_ns = 0
        self._watching = False

    def add(self, data: bytes, at_ns: int) -> None:
        """Take bytes that came at `at_ns`."""
        for value in data:
            if not self._line:
                self._begin_ns = at_ns
            self._line.append(value)
            if value == ord("\n") or len(self._line) >= LINE_BYTES:
                self.flush()
        self._last_ns = at_ns
        if self._line and not self._watching:
            self._watch()

    def flush(self) -> None:
        """Show what there is of a line."""
        if self._line:
            line, self._line = bytes(self._line), bytearray()
            self._take(self._begin_ns, printable(line.removesuffix(b"\n").removesuffix(b"\r")))

    def _watch(self) -> None:
        self._watching = True
        when_ns = max(self._last_ns + LINE_IDLE_NS, self._scheduler.now_ns)
        self._scheduler.at(when_ns, self._look, order=EventClass.CHECK, source=self._source)

    def _look(self) -> None:
        self._watching = False
        if self._line and self._scheduler.now_ns - self._last_ns < LINE_IDLE_NS:
            self._watch()
        else:
            self.flush()


def printable(data: bytes) -> str:
    """Return bytes as text, with whatever would not show, or would move the cursor, written as an escape."""
    text = data.decode("utf-8", errors="backslashreplace")
    return "".join(sign if sign.isprintable() or sign == "\t" else f"\\x{ord(sign):02x}" for sign in text)


class Narrator:
    """Tells what happens on a bench while it runs.

    Args:
        emulated: the bench.
        say: takes the lines.
        each_note: tell each note; else the first of a cause, and that there are more.
    """

    def __init__(self, emulated: EmulatedBench, say: Say, *, each_note: bool = True) -> None:
        self._emulated = emulated
        self._each_note = each_note
        self._causes: Counter[tuple[object, ...]] = Counter()
        self._say = say
        self._lines: list[TextLines] = []
        names = [*emulated.ports, *(f"{name}.semihosting" for name in emulated.machines)]
        self._width = max(map(len, names))
        self._leds = {
            f"{name}.{led.pin}": (led.name, led.active == "high")
            for name, board in emulated.bench_file.boards.items()
            for led in board.board.leds
        }
        self._pwm: dict[str, tuple[int, int]] = {}
        emulated.bench.journal.on_event = self._event
        emulated.on_console = lambda name: emulated.consoles[name].append(self._text(name))
        for name, port in emulated.ports.items():
            port.taps.append(self._text(name))
            if not port.joined:  # what comes from another board is shown there
                port.heard_taps.append(self._text(name, "<"))
        for note in emulated.notes():  # on the images, before anything runs
            self._event({**note, "source": note["board"], "note": note["kind"], "kind": "note"})

    def finish(self) -> None:
        """Show lines that have not ended."""
        for lines in self._lines:
            lines.flush()

    def _text(self, source: str, sign: str = ">") -> Callable[[bytes, int], None]:
        def tell(ns: int, text: str) -> None:
            self._tell(ns, source, f"{sign} {text}")

        lines = TextLines(self._emulated.bench.scheduler, source, tell)
        self._lines.append(lines)
        return lines.add

    def _tell(self, ns: int, source: str, text: str) -> None:
        self._say(f"{ns / NS_PER_S:12.6f}  {source:<{self._width}}  {text}")

    def _event(self, event: Mapping[str, Any]) -> None:
        text = self._words(event)
        if text:
            self._tell(event["ns"], event["source"], text)

    def _words(self, event: Mapping[str, Any]) -> str:
        match event["kind"]:
            case "pin":
                return self._pin(event)
            case "pwm":
                return self._pwm_words(event)
            case "reset":
                return f"reset ({event['reason']})"
            case "note":
                return self._note(event)
            case "stimulus":
                return f"stimulus {printable(event['text'].encode(errors='replace'))}"
            case "event" if event["name"] == "I2cTransaction":
                return _i2c_words(event["value"])
        return ""

    def _note(self, event: Mapping[str, Any]) -> str:
        cause = event["source"], event["note"], event["text"]
        self._causes[cause] += 1
        if self._each_note or self._causes[cause] <= SHOWN_NOTES:
            at = f" ({event['at']})" if event["at"] else ""
            return f"note: {event['where']}: {event['text']}{at}"
        return (
            f"note: {event['where']}, and more of this cause (--notes all)"
            if self._causes[cause] == SHOWN_NOTES + 1
            else ""
        )

    def _pin(self, event: Mapping[str, Any]) -> str:
        level = {True: "high", False: "low", None: "floats"}[event["level"]]
        led, lit = self._leds.get(event["source"], ("", None))
        if not led or event["level"] is None:
            return level
        return f"{level} (LED {led} {'on' if event['level'] is lit else 'off'})"

    def _pwm_words(self, event: Mapping[str, Any]) -> str:
        """Return what a fast pin does, when it changes."""
        period_ns, high_ns = event.get("period_ns"), event.get("high_ns")
        if period_ns is None or high_ns is None:
            self._pwm.pop(event["source"], None)
            return ""
        before_ns = self._pwm.get(event["source"], (0, 0))
        if abs(period_ns - before_ns[0]) <= ROUNDING_NS and abs(high_ns - before_ns[1]) <= ROUNDING_NS:
            return ""
        self._pwm[event["source"]] = (period_ns, high_ns)
        duty = event.get("duty", high_ns / period_ns)
        return f"period {period_ns} ns, high {high_ns} ns ({100 * duty:.2f} %)"


def _i2c_words(transaction: Mapping[str, Any]) -> str:
    """Return what went over an I2C bus: address, direction and bytes of each message, and what was not acknowledged."""
    words = []
    for message in transaction["messages"]:
        sign, data = "r" if message["read"] else "w", message["data"]
        refused = "" if message["acknowledged"] and not message["refused"] else " no acknowledge"
        cut = data if len(data) <= 2 * I2C_BYTES else f"{data[: 2 * I2C_BYTES]}..."
        words.append(f"0x{message['address']:02X} {sign} {cut}".rstrip() + refused)
    return ", ".join(words if transaction["complete"] else [*words, "broken off"])
