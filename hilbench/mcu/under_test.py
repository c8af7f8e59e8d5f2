"""An emulated board in a test: let it run, talk to it, look at its pins."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hilbench.bench import Bench
from hilbench.benchfile.stimulus import parse_stimulus
from hilbench.errors import UsageError
from hilbench.links import Port
from hilbench.mcu.emulated import EmulatedBench, End
from hilbench.mcu.narration import Narrator
from hilbench.nearest import did_you_mean
from targets.boards import Button
from targets.mcu.fidelity import Note
from targets.mcu.i2c_bus import I2cBus
from targets.mcu.pins import Pin

__all__ = ["BoardUnderTest", "SerialLine", "boards_under_test"]


class SerialLine:
    """The far end of a USART's line.

    Args:
        bench: whose time passes while something is waited for.
        port: the end of the line; its owner calls `take`.
        send: puts bytes on the line.
        require: called when what was expected has not come: raises if the line is to blame.

    Attributes:
        data: every byte that the board has sent so far.
        port: as given, with its rate, counters and breaks.
    """

    def __init__(
        self, bench: Bench, port: Port, send: Callable[[bytes], None], require: Callable[[], None] = lambda: None
    ) -> None:
        self.data = b""
        self.port = port
        self._bench = bench
        self._send = send
        self._require = require
        self._seen = 0

    @property
    def text(self) -> str:
        """The same as text; bytes that are not UTF-8 are escaped."""
        return self.data.decode("utf-8", errors="backslashreplace")

    def write(self, data: bytes | str) -> None:
        """Send to the board, byte by byte, at the line's rate."""
        self._send(data.encode() if isinstance(data, str) else data)

    def expect(self, what: bytes | str, within_s: float = 1.0) -> bytes:
        """Let time pass until the board has sent `what`. The search continues after the last expected bytes.

        Returns:
            Everything it has sent since, up to and including `what`.

        Raises:
            AssertionError: it has not, in `within_s` seconds of bench time.
        """
        wanted = what.encode() if isinstance(what, str) else what
        if not self._bench.run_until(lambda: wanted in self.data[self._seen :], within_s):
            self._require()
            since = self.data[self._seen :]
            raise AssertionError(f"{self.port.name} did not send {wanted!r} within {within_s} s, but {since!r}")
        begin, self._seen = self._seen, self.data.index(wanted, self._seen) + len(wanted)
        return self.data[begin : self._seen]

    def take(self, data: bytes, _at_ns: int) -> None:
        """Take what the board has sent."""
        self.data += data


class BoardUnderTest:
    """One board of a bench.

    Args:
        emulated: the bench.
        name: of the board in it.
        transcript: where the lines of all boards go.

    Attributes:
        name: of the board in the bench.
        emulated: the bench, with all there is.
        transcript: what has happened so far, as lines: bench time, who, what.
        console: what the firmware has written by ITM port 0 or by semihosting.
    """

    def __init__(self, emulated: EmulatedBench, name: str, transcript: list[str]) -> None:
        self.name = name
        self.emulated = emulated
        self.transcript = transcript
        self.console = ""
        machine = emulated.machines[name]
        self._machine = machine
        self._lines: dict[str, SerialLine] = {}
        for full, port in emulated.ports.items():
            if full.startswith(f"{name}.") and not port.joined:
                far_end = emulated.far_ends.reacting(full)
                line = self._lines[full.partition(".")[2]] = SerialLine(emulated.bench, far_end, far_end.write)
                far_end.taps.append(line.take)

    # --- time

    @property
    def now_s(self) -> float:
        """Bench time since power-on, in seconds."""
        return self.emulated.bench.now_s

    def run(self, seconds: float) -> None:
        """Let `seconds` of bench time pass, or less if the firmware ends."""
        self.run_until(lambda: False, seconds)

    def run_until(self, condition: Callable[[], bool], within_s: float) -> bool:
        """Let time pass until `condition` holds, the firmware ends, or `within_s` seconds are over.

        Returns:
            Whether the condition holds.
        """
        self.emulated.bench.run_until(lambda: condition() or self.emulated.end is not None, within_s)
        return condition()

    # --- what can be touched and seen

    @property
    def end(self) -> End | None:
        """How the firmware has ended; None while it runs."""
        return self.emulated.end

    @property
    def notes(self) -> list[Note]:
        """What the firmware used that is not modelled, and what it did wrong."""
        return self._machine.notes.all

    def usart(self, name: str) -> SerialLine:
        """Return the line of a USART: ``usart1``.

        Raises:
            UsageError: the board has none of that name, or it is linked to another board.
        """
        line = self._lines.get(name.lower())
        if line is None:
            hint = did_you_mean(name.lower(), self._lines, "USARTs")
            raise UsageError(f"{self.name} has no free line '{name}'", hint=hint)
        return line

    def pin(self, name: str) -> Pin:
        """Return a pin by its port (``PA0``) or by its label on the board (``A0``).

        Raises:
            UsageError: the board has none of that name.
        """
        board = self.emulated.bench_file.boards[self.name].board
        port_pin = board.port_pin(name)
        if port_pin is None:
            raise UsageError(f"{self.name} has no pin '{name}'", hint=did_you_mean(name, board.pins, "pins"))
        return self._machine.chip.pins[port_pin]

    def i2c(self, name: str) -> I2cBus:
        """Return the bus of an I2C interface, such as ``I2C1``: attach slaves to it, watch it, break it.

        Raises:
            UsageError: the board has no such interface.
        """
        i2cs = self._machine.chip.i2cs
        if name.upper() not in i2cs:
            hint = did_you_mean(name.upper(), i2cs, "they are") if i2cs else "those of its chip are not modelled"
            raise UsageError(f"{self.name} has no I2C interface '{name}'", hint=hint)
        return i2cs[name.upper()].bus

    def stimulate(self, text: str) -> None:
        """Apply a stimulus to the board, such as ``PC13=0/50ms`` or ``1s:PA0=1.65V`` (docs/stimuli.md).

        Its time is counted from now, and a name of a file from the working folder.

        Raises:
            UsageError: it is no stimulus, or not one for this board.
        """
        boards = {self.name: self.emulated.bench_file.boards[self.name]}
        try:
            self.emulated.stimuli.add(parse_stimulus(text, boards, Path()))
        except ValueError as error:
            raise UsageError(str(error), where="stimulus") from None

    def is_lit(self, led: str = "") -> bool:
        """Return whether a light of the board is lit; by default its first one."""
        leds = self.emulated.bench_file.boards[self.name].board.leds
        for known in leds:
            if led in {"", known.name, known.pin}:
                return self.pin(known.pin).level is (known.active == "high")
        raise UsageError(f"{self.name} has no light '{led}'", hint=did_you_mean(led, [one.name for one in leds]))

    def push(self, button: str = "") -> None:
        """Push a button of the board, by default its first one, until `let_go`."""
        known = self._button(button)
        self.pin(known.pin).drive(known.active == "high")

    def let_go(self, button: str = "") -> None:
        """Let go of a button that was pushed."""
        self.pin(self._button(button).pin).drive(None)

    def _button(self, name: str) -> Button:
        buttons = self.emulated.bench_file.boards[self.name].board.buttons
        for known in buttons:
            if name in {"", known.name, known.pin}:
                return known
        raise UsageError(f"{self.name} has no button '{name}'", hint=did_you_mean(name, [one.name for one in buttons]))

    def reset(self) -> None:
        """Press the reset button."""
        self._machine.reset()

    def hang(self) -> None:
        """Have the program do nothing more until a reset, as in an endless loop with interrupts off."""
        self._machine.hang()


def boards_under_test(emulated: EmulatedBench) -> dict[str, BoardUnderTest]:
    """Return every board of a bench, ready for a test."""
    transcript: list[str] = []
    narrator = Narrator(emulated, transcript.append)
    boards = {name: BoardUnderTest(emulated, name, transcript) for name in emulated.machines}
    announce = emulated.on_console

    def console(full: str) -> None:
        board = boards[full.partition(".")[0]]

        def take(data: bytes, _at_ns: int) -> None:
            board.console += data.decode("utf-8", errors="backslashreplace")

        emulated.consoles[full].append(take)
        announce(full)

    emulated.on_console = console
    emulated.at_close.append(narrator.finish)
    return boards
