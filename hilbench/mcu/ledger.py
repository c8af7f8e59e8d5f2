"""The fidelity ledger of a chip: every register, and how far it is modelled."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hilbench.errors import UsageError
from hilbench.mcu.images import translated
from hilbench.nearest import did_you_mean
from targets.boards import Board, board_names, built_in_board
from targets.mcu.errors import McuError
from targets.mcu.fidelity import Fidelity
from targets.mcu.image import Image
from targets.mcu.registers import Peripheral
from targets.mcu.symbols import NO_SYMBOLS
from targets.mcu.variants import VARIANTS

__all__ = ["LedgerPeripheral", "LedgerRegister", "as_data", "as_text", "ledger_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LedgerRegister:
    """One register.

    Attributes:
        name: as in the reference manual, without the peripheral.
        offset: from the peripheral's base.
        fidelity: how far it is modelled.
        ignored: bits that silicon obeys and the model only remembers.
        note: what to know before trusting it.
    """

    name: str
    offset: int
    fidelity: Fidelity
    ignored: int
    note: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LedgerPeripheral:
    """One peripheral."""

    name: str
    base: int
    registers: tuple[LedgerRegister, ...]

    def counts(self) -> dict[str, int]:
        """Return how many registers are modelled, partly modelled, absent."""
        counted = Counter(register.fidelity for register in self.registers)
        return {fidelity.value: counted[fidelity] for fidelity in Fidelity}


def ledger_of(chip: str) -> tuple[LedgerPeripheral, ...]:
    """Return the ledger of a chip, by the addresses of its peripherals.

    Args:
        chip: part number, or the name of a built-in board for the chip on it.

    Raises:
        UsageError: no such chip.
        UnavailableError: the engine is missing.
    """
    from targets.mcu.machine import Machine

    try:
        machine = Machine(_board(chip), _NOTHING)
    except McuError as error:
        raise translated(error) from error
    peripherals = {part.name: part for part in machine.chip.blocks}
    return tuple(_entry(part) for part in sorted(peripherals.values(), key=lambda part: part.base))


_NOTHING = Image(
    path=Path("nothing"),
    format="bin",
    digest="",
    segments=(),
    table=0x0800_0000,
    stack_pointer=0,
    reset_vector=0,
    flash_bytes=0,
    ram_bytes=0,
    symbols=NO_SYMBOLS,
    notes=(),
)


def _board(chip: str) -> Board:
    if chip in board_names():
        return built_in_board(chip)
    if chip.upper() in VARIANTS:
        return Board.from_mapping({"name": chip.upper(), "chip": chip.upper()})
    known = (*VARIANTS, *board_names())
    raise UsageError(f"no chip '{chip}'", where="--fidelity", hint=did_you_mean(chip, known, "chips"))


def _entry(part: Peripheral) -> LedgerPeripheral:
    registers = (
        LedgerRegister(
            name=register.name,
            offset=register.offset,
            fidelity=register.fidelity,
            ignored=register.ignored,
            note=register.note,
        )
        for _, register in sorted(part.registers.items())
    )
    return LedgerPeripheral(name=part.name, base=part.base, registers=tuple(registers))


def as_data(chip: str, ledger: Sequence[LedgerPeripheral]) -> dict[str, object]:
    """Return a ledger as plain data."""
    return {
        "chip": chip,
        "peripherals": [
            {
                "name": part.name,
                "base": part.base,
                "counts": part.counts(),
                "registers": [
                    {
                        "name": register.name,
                        "offset": register.offset,
                        "fidelity": register.fidelity.value,
                        "ignored_bits": register.ignored,
                        "note": register.note,
                    }
                    for register in part.registers
                ],
            }
            for part in ledger
        ],
    }


def as_text(chip: str, ledger: Sequence[LedgerPeripheral]) -> str:
    """Return a ledger as lines: a heading for each peripheral, a line for each register, a sum."""
    lines = []
    total: Counter[str] = Counter()
    for part in ledger:
        counts = part.counts()
        total.update(counts)
        lines.append(f"{part.name}  0x{part.base:08X}  {_sum(counts)}")
        lines += [_line(register) for register in part.registers]
    lines.append(f"{chip}: {len(ledger)} peripherals, {sum(total.values())} registers: {_sum(total)}")
    return "\n".join(lines)


def _line(register: LedgerRegister) -> str:
    ignored = f"bits 0x{register.ignored:X} without effect" if register.ignored else ""
    remark = "; ".join(part for part in (ignored, register.note) if part)
    return f"  0x{register.offset:03X}  {register.name:<10} {register.fidelity.value:<9} {remark}".rstrip()


def _sum(counts: dict[str, int] | Counter[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counts.items() if count)
