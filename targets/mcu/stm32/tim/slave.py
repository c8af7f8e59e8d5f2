"""The slave mode controller and the capture inputs of a timer: which edge means what.

RM0008 sections 14.3.5 to 14.3.7 (capture), 15.3.12 (encoder), 15.3.14 (slave modes), 14.4.3 (SMCR). An edge that
captures and resets the counter captures first.

In encoder mode 1 (SMS = 001) the counter counts the edges of TI2, in mode 2 those of TI1, as RM0008 says; the names in
ST's libraries (``TIM_ENCODERMODE_TI1`` for 001) have it the other way round. Over whole periods of the encoder both
count the same.
"""

from __future__ import annotations

from typing import Protocol

from targets.mcu.services import InputSignal, Services
from targets.mcu.stm32.tim.inputs import ChannelInputs, ExternalTrigger, TickClock

__all__ = ["GATED", "RESET", "RESET_AND_TRIGGER", "TRIGGER", "Reactions", "SlaveController"]

ENCODER_MODES = (1, 2, 3)
RESET, GATED, TRIGGER, EXTERNAL_CLOCK_1, RESET_AND_TRIGGER = 4, 5, 6, 7, 8
TI1F_ED, TI1FP1, TI2FP2, ETRF = 4, 5, 6, 7
_TRC = 3


class Reactions(Protocol):
    """What edges do to a timer; it calls `begin` before and `end` after whatever one edge does."""

    def begin(self) -> None:
        """Bring the counter to the present cycle."""

    def end(self) -> None:
        """Tell what has changed."""

    def captured(self, number: int) -> None:
        """The capture input of a channel (0 to 3) has an active edge."""

    def triggered(self, level: bool) -> None:
        """TRGI has risen or fallen."""

    def counted(self) -> None:
        """A pulse of the external clock."""

    def turned(self, down: bool, counts: bool) -> None:
        """The encoder has moved; `counts` says whether by an edge that counts."""

    def etrf_changed(self, level: bool) -> None:
        """ETRF has a new level."""


class SlaveController:
    """From the input signals of a timer to what they do.

    Args:
        name: of the timer.
        services: what the chip offers.
        clock: the ticks of the timer.
        masters: the timers behind ITR0 to ITR3.
        reactions: the timer.

    Attributes:
        mode: SMCR.SMS.
        trigger: SMCR.TS.
        external_clock_2: SMCR.ECE.
        select: CCxS of the four channels.
        inverted: CCxP.
        both: the input takes both edges (CCxP and CCxNP, on timers that have it).
        enabled: CCxE.
        prescalers: captures take every 1, 2, 4 or 8 edges, by ICxPSC.
    """

    def __init__(
        self, name: str, services: Services, clock: TickClock, masters: tuple[str | None, ...], reactions: Reactions
    ) -> None:
        self._reactions = reactions
        self._clock = clock
        self._channels = ChannelInputs(
            services.time, clock, [services.input(f"{name}_CH{number}") for number in range(1, 5)], self._ti_changed
        )
        self._etr = ExternalTrigger(services.time, clock, services.input(f"{name}_ETR"), self._etrf_changed)
        self._masters: list[InputSignal | None] = [
            services.input(f"{master}_TRGO") if master else None for master in masters
        ]
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset and listen to nobody."""
        self.mode = 0
        self.trigger = 0
        self.external_clock_2 = False
        self.select = [0] * 4
        self.inverted = [False] * 4
        self.both = [False] * 4
        self.enabled = [False] * 4
        self.prescalers = [1] * 4
        self._edges = [0] * 4
        self.configure(xor=False, filters=[0] * 4, etr_code=0, etr_inverted=False, etr_divider=1, dts_ticks=1)

    @property
    def encoder(self) -> bool:
        """True in an encoder mode."""
        return self.mode in ENCODER_MODES

    @property
    def external_clock(self) -> bool:
        """True if the counter is not clocked by the timer's own clock."""
        return self.encoder or self.external_clock_2 or self.mode == EXTERNAL_CLOCK_1

    def configure(
        self,
        *,
        xor: bool,
        filters: list[int],
        etr_code: int,
        etr_inverted: bool,
        etr_divider: int,
        dts_ticks: int,
        com_by_trigger: bool = False,
        etr_clears: bool = False,
    ) -> None:
        """Listen to what the present settings need.

        Args:
            xor: TI1 is the XOR of channels 1 to 3.
            filters: ICxF; 0 for channels that are outputs.
            etr_code: ETF.
            etr_inverted: ETP.
            etr_divider: by ETPS.
            dts_ticks: tDTS in ticks.
            com_by_trigger: TRGI updates the preloaded control bits (CCPC and CCUS).
            etr_clears: a channel is cleared by ETRF (OCxCE).
        """
        captures_trc = _TRC in self.select
        listens = bool(self.mode) or captures_trc or com_by_trigger
        used = [False] * 4
        for number, select in enumerate(self.select):
            if select in (1, 2):
                used[number ^ (select - 1)] = True
        if self.encoder:
            used[0] = used[1] = True
        if listens and self.trigger in (TI1F_ED, TI1FP1):
            used[0] = True
        if listens and self.trigger == TI2FP2:
            used[1] = True
        self._channels.configure(used, xor, filters, dts_ticks)
        self._etr.configure(
            used=(listens and self.trigger == ETRF) or self.external_clock_2 or etr_clears,
            inverted=etr_inverted,
            divider=etr_divider,
            code=etr_code,
            dts_ticks=dts_ticks,
        )
        self._listen_to_master(listens)
        for number in range(4):
            if not self.enabled[number]:
                self._edges[number] = 0

    def replan(self) -> None:
        """The rate of the ticks has changed."""
        self._channels.replan()
        self._etr.replan()

    def trigger_level(self) -> bool:
        """Return the level of TRGI."""
        if self.trigger < TI1F_ED:
            master = self._masters[self.trigger]
            return master is not None and master.level()
        if self.trigger == ETRF:
            return self._etr.level()
        return self.trigger != TI1F_ED and self._polarised(self.trigger - TI1FP1)

    def etrf_level(self) -> bool:
        """Return the level of ETRF."""
        return self._etr.level()

    # --- edges

    def _listen_to_master(self, listens: bool) -> None:
        for number, master in enumerate(self._masters):
            if master is not None:
                listener = self._itr_changed if listens and self.trigger == number else None
                if master.on_change != listener:
                    master.on_change = listener

    def _polarised(self, number: int) -> bool:
        return self._channels.level(number) is not self.inverted[number]

    def _itr_changed(self, level: bool) -> None:
        if not self._clock.cycles:
            return
        self._reactions.begin()
        if level:
            self._capture_trc()
        self._trigger(level)
        self._reactions.end()

    def _etrf_changed(self, level: bool) -> None:
        self._reactions.begin()
        self._reactions.etrf_changed(level)
        if self.trigger == ETRF:
            self._trigger(level)
        if self.external_clock_2 and level:
            self._reactions.counted()
        self._reactions.end()

    def _ti_changed(self, number: int, level: bool) -> None:
        self._reactions.begin()
        for channel, select in enumerate(self.select):
            if select in (1, 2) and channel ^ (select - 1) == number and self._is_active(channel, level):
                self._capture(channel)
        if number < 2 and self.trigger == TI1FP1 + number:
            self._trigger(self._is_active(number, level, gates=self.mode == GATED))
        elif self.trigger == TI1F_ED and number == 0:
            self._capture_trc()
            self._trigger(True)
            self._trigger(False)
        if self.encoder and number < 2:
            self._encode(number)
        self._reactions.end()

    def _is_active(self, channel: int, level: bool, *, gates: bool = False) -> bool:
        """Say whether an edge counts for a channel; a gate is never open at both levels."""
        return (self.both[channel] and not gates) or level is not self.inverted[channel]

    def _capture_trc(self) -> None:
        for channel, select in enumerate(self.select):
            if select == _TRC:
                self._capture(channel)

    def _capture(self, channel: int) -> None:
        if not self.enabled[channel]:
            return
        self._edges[channel] += 1
        if self._edges[channel] >= self.prescalers[channel]:
            self._edges[channel] = 0
            self._reactions.captured(channel)

    def _trigger(self, level: bool) -> None:
        self._reactions.triggered(level)
        if level and self.mode == EXTERNAL_CLOCK_1 and not self.external_clock_2:
            self._reactions.counted()

    def _encode(self, number: int) -> None:
        # RM0008 table 85: an edge of TI1 counts up if both levels then differ, one of TI2 if they are equal
        equal = self._polarised(0) is self._polarised(1)
        up = equal if number else not equal
        self._reactions.turned(not up, bool(self.mode & (1 if number else 2)))
