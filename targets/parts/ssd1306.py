"""A display of 128 columns with an SSD1306 on an I2C bus, by its data sheet (Solomon Systech SSD1306, revision 1.1).

What the program writes stands in the display RAM; what a person sees follows from the RAM and from the settings:
start line, offset, rows that are driven, directions, inversion, and whether the panel has a voltage at all. So a
program that forgets the charge pump gets a dark panel here as well. `Ssd1306.picture` is what is seen.

The panel is wired as on the usual modules: with A1 and C8 the first column and the first row of the RAM are at the top
left. Choices where the data sheet is silent: a message that is read answers with D6, the display is off, and is
acknowledged; a command that comes without its operands waits for them in the next message; a reset is that at power-on;
the RAM is all 0 then, where a real one's is not defined; a command for another addressing mode does nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

from targets.mcu.i2c_bus import I2cSlave
from targets.parts.part import Part, Picture, Ports
from targets.parts.settings import check_settings, setting

__all__ = ["DisplayNote", "DisplaySwitched", "Ssd1306", "Ssd1306Settings"]

COLUMNS, RAM_ROWS, PAGES = 128, 64, 8
_CONTINUATION, _DATA = 0x80, 0x40
_HORIZONTAL, _VERTICAL, _PAGE = range(3)

_OPERANDS = {
    0x20: 1, 0x21: 2, 0x22: 2, 0x23: 1, 0x26: 6, 0x27: 6, 0x29: 5, 0x2A: 5, 0x81: 1, 0x8D: 1, 0xA3: 2, 0xA8: 1,
    0xD3: 1, 0xD5: 1, 0xD6: 1, 0xD9: 1, 0xDA: 1, 0xDB: 1,
}  # fmt: skip
"""How many bytes follow a command (sections 9 and 10.2; the charge pump: appendix)."""
_ABSENT = {
    **dict.fromkeys((0x26, 0x27, 0x29, 0x2A, 0x2F, 0xA3), "scrolling"),
    0x23: "fading and blinking",
    0xD6: "zoom",
}
_FLAGS = {
    0xA0: ("_mirrored", False),
    0xA1: ("_mirrored", True),
    0xA4: ("_all_lit", False),
    0xA5: ("_all_lit", True),
    0xA6: ("_inverse", False),
    0xA7: ("_inverse", True),
    0xAE: ("_on", False),
    0xAF: ("_on", True),
    **dict.fromkeys(range(0xC0, 0xC8), ("_upwards", False)),
    **dict.fromkeys(range(0xC8, 0xD0), ("_upwards", True)),
}
_WITHOUT_EFFECT = frozenset({0x2E, 0xD5, 0xD9, 0xDB, 0xE3})


@dataclass(frozen=True, slots=True, kw_only=True)
class Ssd1306Settings:
    """Which module it is.

    Raises:
        ValueError: a value makes no display.
    """

    rows: Literal[32, 64] = setting(64, "px", "choice: the usual modules have 64 or 32 rows")
    sa0: bool = setting(False, "", "SSD1306 section 8.1.5: SA0 low is 0x3C, high 0x3D")
    vcc: bool = setting(False, "", "choice: the panel has no supply of its own, only the charge pump")

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplaySwitched:
    """The panel is lit or dark from `at_ns` on."""

    lit: bool
    at_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayNote:
    """A command that is not modelled, or that the data sheet does not have."""

    command: int
    why: str


class Ssd1306(Part):
    """See the head of this file.

    Attributes:
        ram: a byte for eight rows of a column; those of the first eight rows first.
        contrast: from 0 to 255; it changes no picture.
    """

    BUSES = ("i2c",)
    ADDRESSED_BY = "sa0"
    ABSENT = (
        "the SPI and parallel interfaces",
        "scrolling, fading, blinking and zoom",
        "rows wired in another way than the panel's: a wrong command DA is reported, and shows nothing",
        "brightness, and the time that the charge pump takes",
        "what the RAM happens to hold at power-on: here it is all 0 (choice)",
    )
    Settings = Ssd1306Settings

    def __init__(self, settings: Ssd1306Settings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._settings = settings
        self._at = self.address_of(settings)
        self._tell = ports.tell
        self._reported: set[int] = set()
        self.ram = bytearray(COLUMNS * PAGES)
        self.contrast = 0x7F
        self._mode = _PAGE
        self._column, self._first_column, self._last_column = 0, 0, COLUMNS - 1
        self._page, self._first_page, self._last_page = 0, 0, PAGES - 1
        self._mirrored = self._upwards = self._inverse = self._all_lit = False
        self._on = self._pumped = self._lit = False
        self._start_line = self._offset = 0
        self._driven_rows = RAM_ROWS
        self._wiring = 0x12
        self._command = bytearray()
        self._control: int | None = None

    @staticmethod
    def address_of(settings: Ssd1306Settings) -> int:
        """Return its address, by its pin SA0."""
        return 0x3D if settings.sa0 else 0x3C

    def slave(self, name: str) -> I2cSlave:
        """Return what answers on the bus; raises KeyError as `Part.slave` does."""
        return {"i2c": self}[name]

    # --- what is seen

    def picture(self) -> Picture:
        """Return what the panel shows now: white is lit."""
        rows = self._settings.rows
        bits = bytearray(COLUMNS * rows)
        if self._lit:
            for row in range(self._driven_rows):
                line = self._driver_of(row)
                if line < rows:
                    at = COLUMNS * (rows - 1 - line)
                    bits[at : at + COLUMNS] = self._row((row + self._start_line) % RAM_ROWS)
        return Picture(width=COLUMNS, height=rows, grey=bytes(bits))

    def _driver_of(self, row: int) -> int:
        """Return which output COM drives a row (tables 10-2 and 10-3)."""
        return (self._driven_rows - 1 - row + self._offset if self._upwards else row - self._offset) % RAM_ROWS

    def _row(self, ram_row: int) -> bytes:
        page, mask = ram_row // 8 * COLUMNS, 1 << ram_row % 8
        lit = (0xFF if bool(byte & mask) is not self._inverse else 0 for byte in self.ram[page : page + COLUMNS])
        return b"\xff" * COLUMNS if self._all_lit else bytes(lit)

    @property
    def _right_wiring(self) -> bool:
        return self._wiring & 0x30 == (0x10 if self._settings.rows == RAM_ROWS else 0)

    def _switch(self, now_ns: int) -> None:
        why = ""
        if not self._pumped and not self._settings.vcc:
            why = "the panel has no voltage: the charge pump is off (8D)"
        elif not self._right_wiring:
            why = f"{self._wiring:#04x} is not the wiring of the rows of this panel (DA)"
        if self._on and why:
            self._note(0xAF, f"the display is on and dark: {why}")
        lit = self._on and not why
        if lit is not self._lit:
            self._lit = lit
            self._tell(DisplaySwitched(lit=lit, at_ns=now_ns))

    # --- the bus (section 8.1.5)

    def address(self, address: int, read: bool, now_ns: int) -> bool:  # noqa: ARG002
        """Acknowledge its own address."""
        self._control = None
        return address == self._at

    def read(self, now_ns: int) -> int:  # noqa: ARG002
        """Return whether the display is off, in D6."""
        return 0 if self._on else 0x40

    def end(self, now_ns: int) -> None:
        """A message changes nothing at its end."""

    def write(self, byte: int, now_ns: int) -> bool:
        """Take a control byte, then what it says."""
        if self._control is None:
            self._control = byte
            return True
        if self._control & _DATA:
            self._take(byte)
        else:
            self._command.append(byte)
            if len(self._command) > _OPERANDS.get(self._command[0], 0):
                command, self._command = bytes(self._command), bytearray()
                self._do(command[0], command[1:])
                self._switch(now_ns)
        if self._control & _CONTINUATION:
            self._control = None
        return True

    def _take(self, byte: int) -> None:
        """Put a byte into the RAM, and go on (section 8.7 and figures 10-1 to 10-4)."""
        # The direction of the columns counts when data come in: what stands in the RAM does not move (table 9-1, A0).
        segment = self._column if not self._mirrored else COLUMNS - 1 - self._column
        self.ram[self._page * COLUMNS + COLUMNS - 1 - segment] = byte
        if self._mode == _PAGE:
            self._column = (self._column + 1) % COLUMNS
        elif self._mode == _HORIZONTAL:
            self._column, wrapped = _next(self._column, self._first_column, self._last_column, COLUMNS)
            if wrapped:
                self._page, _ = _next(self._page, self._first_page, self._last_page, PAGES)
        else:
            self._page, wrapped = _next(self._page, self._first_page, self._last_page, PAGES)
            if wrapped:
                self._column, _ = _next(self._column, self._first_column, self._last_column, COLUMNS)

    # --- commands (section 9)

    def _do(self, command: int, operands: bytes) -> None:
        if command in _ABSENT:
            self._note(command, f"{_ABSENT[command]}: not modelled")
        elif command < 0x20:
            self._set_column(command)
        elif 0x40 <= command < 0x80:
            self._start_line = command & 0x3F
        elif 0xB0 <= command < 0xB8:
            self._set_page(command)
        elif command in _FLAGS:
            setattr(self, *_FLAGS[command])
        elif command in self._SETTERS:
            self._SETTERS[command](self, *operands)
        elif command not in _WITHOUT_EFFECT:
            self._note(command, "the data sheet has no such command")

    def _set_column(self, command: int) -> None:
        if self._mode != _PAGE:
            self._note(command, "the column of the page mode is set in another mode: no effect")
        elif command & 0x10:
            self._column = (command & 0x7) << 4 | self._column & 0xF
        else:
            self._column = self._column & 0x70 | command & 0xF

    def _set_page(self, command: int) -> None:
        if self._mode == _PAGE:
            self._page = command & 7
        else:
            self._note(command, "the page of the page mode is set in another mode: no effect")

    def _set_mode(self, mode: int) -> None:
        if mode & 3 == 3:
            self._note(0x20, "mode 3 is reserved: no effect")
        else:
            self._mode = mode & 3

    def _set_columns(self, first: int, last: int) -> None:
        if self._mode == _PAGE:  # table 9-1: 21 and 22 are only for the two other modes
            self._note(0x21, "the columns of a window are set in page mode: no effect")
        else:
            self._column = self._first_column = first & 0x7F
            self._last_column = last & 0x7F

    def _set_pages(self, first: int, last: int) -> None:
        if self._mode == _PAGE:
            self._note(0x22, "the pages of a window are set in page mode: no effect")
        else:
            self._page = self._first_page = first & 7
            self._last_page = last & 7

    def _set_driven_rows(self, rows: int) -> None:
        if rows & 0x3F < 15:
            self._note(0xA8, "fewer than 16 rows are reserved: no effect")
        else:
            self._driven_rows = (rows & 0x3F) + 1

    def _note(self, command: int, why: str) -> None:
        """Report a command, once."""
        if command not in self._reported:
            self._reported.add(command)
            self._tell(DisplayNote(command=command, why=why))

    def _set_contrast(self, contrast: int) -> None:
        self.contrast = contrast

    def _set_pump(self, bits: int) -> None:
        self._pumped = bool(bits & 4)

    def _set_offset(self, offset: int) -> None:
        self._offset = offset & 0x3F

    def _set_wiring(self, wiring: int) -> None:
        self._wiring = wiring

    _SETTERS: ClassVar[Mapping[int, Callable[..., None]]] = {
        0x20: _set_mode,
        0x21: _set_columns,
        0x22: _set_pages,
        0x81: _set_contrast,
        0x8D: _set_pump,
        0xA8: _set_driven_rows,
        0xD3: _set_offset,
        0xDA: _set_wiring,
    }


def _next(place: int, first: int, last: int, count: int) -> tuple[int, bool]:
    """Return the next place of a counter that goes from `first` to `last`, and whether it begins anew."""
    return (first, True) if place == last else ((place + 1) % count, False)
