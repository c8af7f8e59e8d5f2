"""What the chips of all families do alike for a machine: resets, watchdogs, Stop and Standby."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Protocol

from targets.mcu.chip import Chip, DeepSleep, FlashMemory, Memory
from targets.mcu.pins import Source
from targets.mcu.services import IrqLine
from targets.mcu.stm32.iwdg import Iwdg
from targets.mcu.stm32.rcc import BackupPart, BasicRcc, BoardClocks
from targets.mcu.stm32.wwdg import Wwdg

if TYPE_CHECKING:
    from targets.boards import Board
    from targets.boards.board import Straps

__all__ = ["BasicChip", "Power"]

_PULL_OHMS = 10_000.0  # of resistors on the board; a choice where its schematic says otherwise
_US_PER_S = 1_000_000


class _Powered(Protocol):
    """What goes back to where it was only with the supply."""

    def power_on(self) -> None:
        """The supply comes."""


class _Edges(Protocol):
    """EXTI, as far as a machine asks for it."""

    on_event: Callable[[], None]

    def sends_events(self) -> bool:
        """Say whether an edge from outside could be an event for WFE."""


class Power(_Powered, Protocol):
    """PWR, which chooses the mode of deep sleep."""

    def deep_sleep(self) -> DeepSleep:
        """Return the mode that its control register chooses."""

    def enter_standby(self) -> bool:
        """Enter Standby; False if a wake-up flag is set."""

    def backup_writable(self) -> bool:
        """Say whether DBP opens the backup domain for writing."""


class _Settings(Protocol):
    """What the option bytes say, as far as every family asks for it."""

    @property
    def hardware_watchdog(self) -> bool:
        """The independent watchdog starts by itself."""

    @property
    def reset_on_stop(self) -> bool:
        """nRST_STOP is programmed."""

    @property
    def reset_on_standby(self) -> bool:
        """nRST_STDBY is programmed."""


class _Flash(FlashMemory, Protocol):
    """The flash, with the settings in its option bytes."""

    @property
    def settings(self) -> _Settings:
        """What the option bytes say."""


class BasicChip(Chip):
    """An STM32 of any family; see `targets.mcu.chip.Chip`.

    Attributes:
        rcc: reset and clock control.
        pwr: power control.
        iwdg: the independent watchdog.
        wwdg: the window watchdog.
        exti: the external interrupts.
        dbgmcu: the debug block.
    """

    rcc: BasicRcc
    pwr: Power
    iwdg: Iwdg
    wwdg: Wwdg
    exti: _Edges
    dbgmcu: _Powered
    _flash: _Flash
    _memories: tuple[Memory, ...]

    def _irq(self, number: int) -> IrqLine:
        return self.core.irq(number)

    def _tie(self, gates: Mapping[str, tuple[str, int]], backup: Iterable[BackupPart]) -> None:
        """Tie clocks, NMI and events to the core; see `BasicRcc.connect`."""
        self.rcc.connect(gates, self.peripherals, others=(self.core.systick,), backup=backup)
        self.rcc.on_nmi = self.core.set_nmi
        self.exti.on_event = self.core.receive_event

    def _board_clocks(self, board: Board) -> BoardClocks:
        """Return what RCC has to know of the board."""
        return {
            "hse_hz": board.hse_hz,
            "hse_is_clock": board.hse_bypass,
            "hse_start_s": Fraction(board.hse_startup_us, _US_PER_S),
            "lse": board.lse_hz is not None,
            "lse_start_s": Fraction(board.lse_startup_us, _US_PER_S),
            "backup_writable": self.pwr.backup_writable,
        }

    def _make_iwdg(self, base: int, *, window: bool = False) -> Iwdg:
        """Return the independent watchdog, which RCC feeds with LSI; see `Iwdg`."""
        return Iwdg(
            base,
            self.services,
            lsi_hz=self.rcc.lsi_hz,
            start_lsi=self.rcc.force_lsi,
            lsi_on=self.rcc.lsi_on,
            starts_by_itself=lambda: self._flash.settings.hardware_watchdog,
            window=window,
        )

    def _pull_pins(self, board: Board, straps: Straps) -> None:
        """Put what the resistors on the board do to the pins."""
        for name, level in board.pulled(straps).items():
            self.pins[name].set_source("board", Source(self.pins.vdd_volts if level else 0.0, _PULL_OHMS))

    @property
    def starting(self) -> Mapping[str, Fraction]:
        """When the clocks that start will be ready; see `BasicRcc.starting`."""
        return self.rcc.starting

    # --- for the machine

    @property
    def memories(self) -> Sequence[Memory]:
        """All memory at all its addresses, and the option bytes."""
        return self._memories

    def reset(self, cause: str) -> None:
        """Reset everything that a reset with this cause resets."""
        self.rcc.reset()
        if cause == "POR":
            self.pwr.power_on()
            self.dbgmcu.power_on()
        for peripheral in self.peripherals.values():
            if peripheral is not self.rcc:
                peripheral.reset()
        self.rcc.reset_by(cause)

    def watchdog_runs(self) -> bool:
        """Say whether a watchdog will reset the chip if the program does nothing more."""
        return self.iwdg.runs or self.wwdg.runs

    def deep_sleep(self) -> DeepSleep:
        """Return the mode that PWR chooses."""
        return self.pwr.deep_sleep()

    def sleep_resets(self, mode: DeepSleep) -> bool:
        """Say whether nRST_STOP or nRST_STDBY is programmed."""
        settings = self._flash.settings
        return settings.reset_on_standby if mode.is_standby else settings.reset_on_stop

    def enter_standby(self) -> bool:
        """Enter Standby; False if a wake-up flag is set."""
        return self.pwr.enter_standby()

    def stop_clocks(self) -> None:
        """Let all but LSE and LSI stand still."""
        self.rcc.stop()

    def restart_clocks(self) -> None:
        """Leave Stop mode, on HSI."""
        self.rcc.resume()

    def sends_events(self) -> bool:
        """Say whether EXTI lets an edge through as an event."""
        return self.exti.sends_events()
