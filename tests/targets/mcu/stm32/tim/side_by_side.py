"""The real timer on a chip in a test tube, and the slow one, side by side."""

from __future__ import annotations

from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.kinds import KINDS
from targets.mcu.testing import FakeChip, peek, poke
from tests.targets.mcu.stm32.tim.slow_timer import SlowTimer


class Bench:
    """The real timer on a chip in a test tube, and the slow one, side by side."""

    OUTPUTS = ("CH1", "CH2", "CH3", "CH4", "CH1N", "CH2N", "CH3N")

    def __init__(self, name="TIM2", divider=1, kinds=KINDS):
        bus = 1 if divider == 1 else 2 * divider  # the timer's clock is the bus clock doubled if that is divided
        self.chip = FakeChip(72_000_000, {"APB1": bus, "APB2": bus})
        self.name = name
        self.timer = self.chip.add(Timer(name, 0x4000_0000, self.chip.services, kinds[name]))
        self.slow = SlowTimer(name == "TIM1", divider, both_edges=kinds is not KINDS)

    def write(self, register, value):
        if register in ("RCR", "BDTR") and self.name != "TIM1":
            return
        if register in ("CCMR1", "CCMR2"):
            value &= ~self.filters_of_inputs_that_stay(register)
        poke(self.timer, register, value)
        self.slow.write(register, value)

    def filters_of_inputs_that_stay(self, register):
        """Return the bits that would be a filter, because CCxS cannot change while the channel is on."""
        first = 2 * (register == "CCMR2")
        return sum(
            0xF0 << 8 * index
            for index in range(2)
            if self.slow.bit("CCER", 4 * (first + index)) and not self.slow.is_output(first + index)
        )

    def read(self, register):
        if register in ("RCR", "BDTR") and self.name != "TIM1":
            return
        value = peek(self.timer, register) & (0xFFFF if register == "SR" else 0xFFFF_FFFF)  # not those of CC5 and CC6
        assert (register, value) == (register, self.slow.read(register))

    def advance(self, cycles):
        self.chip.advance(cycles)
        self.slow.run_to(self.chip.time.now)

    def change_clock(self, divider):
        """Change the timer's clock; its first tick is a whole one from now."""
        if divider != self.slow.divider:
            self.slow.divider, self.slow.phase = divider, self.slow.cycle
        bus = 1 if divider == 1 else 2 * divider
        self.chip.change_clock(APB1=bus, APB2=bus)

    def drive(self, name, level):
        if self.slow.level[name] != level:
            # ITR2 of TIM1, ITR0 of TIM2
            signal = f"TIM{3 if self.name == 'TIM1' else 1}_TRGO" if name == "ITR" else f"{self.name}_{name}"
            self.slow.edge(name, level)
            self.chip.input(signal).drive(level)

    def output(self, name):
        return self.chip.output(f"{self.name}_{name}")

    def compare(self):
        self.read("CNT")
        self.read("CR1")
        self.read("SR")
        self.read("BDTR")

    def compare_outputs(self):
        for index, name in enumerate(self.OUTPUTS):
            if self.name == "TIM1" or index < 4:
                self.output(name).look()
                assert (name, self.output(name).level) == (name, self.slow.outputs[index][-1][1])

    def compare_edges(self):
        for index, name in enumerate(self.OUTPUTS):
            if self.name == "TIM1" or index < 4:
                self.output(name).look()
                assert (name, last_of_each_cycle(self.output(name).edges)) == (
                    name,
                    last_of_each_cycle(self.slow.outputs[index]),
                )

    def compare_log(self):
        got = [
            (cycle, f"dma {request}")
            for request in ("UP", "TRIG", "COM", "CH1", "CH2", "CH3", "CH4")
            for cycle in self.chip.dma(f"{self.name}_{request}").pulses
        ]
        got += [(cycle, "trgo") for cycle, level in self.output("TRGO").edges if level] if self.pulses_trgo() else []
        want = [entry for entry in self.slow.log if entry[1] != "trgo" or self.pulses_trgo()]
        assert sorted(got) == sorted(want)

    def pulses_trgo(self):
        return self.slow.reg["CR2"] >> 4 & 7 in (0, 2, 3)


def last_of_each_cycle(edges):
    """Leave out pulses of no width, and what then is no change."""
    last = dict(edges)
    changes = []
    for cycle, level in sorted(last.items()):
        if level != (changes[-1][1] if changes else None):
            changes.append((cycle, level))
    return changes
