"""A second timer, written tick by tick from the manual: slow, simple, and independent of the arithmetic one."""

from __future__ import annotations

from tests.targets.mcu.stm32.tim.slow_inputs import SlowInputs


class SlowTimer(SlowInputs):
    """Does one tick at a time what RM0008 chapters 14 and 15 say.

    `log` holds what came out: (cycle, what). Inputs are unfiltered and ETR undivided. With `both_edges` it is one of
    the STM32F7, on which CCxP and CCxNP together choose both edges of an input (RM0410 section 25.4.9).
    """

    # --- registers

    def apply(self, commutation=False):
        for number in range(4):
            waits = self.bit("CR2", 0) and not commutation and number < 3
            if not self.bit("CCER", 4 * number):
                self.edges[number] = 0
            if not waits:
                self.enable[number] = self.bit("CCER", 4 * number)
                self.n_enable[number] = self.bit("CCER", 4 * number + 2)
            if not self.is_output(number):
                self.set_mode(number, 0)
                self.how[number] = 0
                self.taken[number] = False
                continue
            if not self.channel(number) & 8 or not self.taken[number]:
                self.ccr[number] = self.reg[f"CCR{number + 1}"]
            self.taken[number] = True
            if not waits:
                self.how[number] = self.chosen(number)
                self.set_mode(number, {12: 6, 13: 7, 14: 6, 15: 7}.get(self.how[number], self.how[number]))
        self.compare_all()
        self.clear_by_etrf()

    taken = property(lambda self: self.__dict__.setdefault("_taken", [True] * 4))

    def write(self, name, value):
        getattr(self, f"write_{name}", lambda v: self.reg.__setitem__(name, v))(value)
        self.turn()
        self.show()

    def write_CR1(self, value):
        fixed = self.encoder or value >> 5 & 3
        started = value & 1 and not self.bit("CR1", 0)
        self.reg["CR1"] = value & ~0x10
        if not fixed:
            self.down = bool(value & 0x10)
        if not value & 0x80:
            self.arr = self.reg["ARR"]
        self.turn()
        self.compare_all()
        internal = not self.encoder and self.sms != 7 and not self.bit("SMCR", 14)
        if started and internal and self.gate_open():
            self.wait = 1
        if not value & 1:
            self.wait = 0

    def write_CR2(self, value):
        self.reg["CR2"] = value if self.advanced else value & 0xF8
        self.inputs = [self.raw_ti(number) for number in range(4)]
        self.apply()

    def write_SMCR(self, value):
        self.reg["SMCR"] = value

    def write_DIER(self, value):
        self.reg["DIER"] = value if self.advanced else value & 0x5F5F

    def write_SR(self, value):
        held = self.reg["SR"] & 0x80 if self.broken() else 0
        self.reg["SR"] = (self.reg["SR"] & value) | held

    def write_EGR(self, value):
        for number in range(4):
            if value & 2 << number:
                if self.is_output(number):
                    self.match(1 << number)
                else:
                    self.capture_now(number)
        if value & 0x40:
            self.reg["SR"] |= 0x40
            if self.bit("DIER", 14):
                self.log.append((self.cycle, "dma TRIG"))
        if value & 0x20 and self.advanced:
            self.commutate()
        if value & 0x80 and self.advanced:
            self.break_()
        if value & 1:
            self.reinitialise()

    def write_CCMR(self, name, first, value):
        for index in range(2):
            if self.bit("CCER", 4 * (first + index)):
                value = (value & ~(3 << 8 * index)) | (self.reg[name] & 3 << 8 * index)
        self.reg[name] = value
        self.apply()

    def write_CCMR1(self, value):
        self.write_CCMR("CCMR1", 0, value)

    def write_CCMR2(self, value):
        self.write_CCMR("CCMR2", 2, value)

    def write_CCER(self, value):
        if self.both_edges:
            self.reg["CCER"] = value & (0xBFFF if self.advanced else 0xBBBB)
        else:
            self.reg["CCER"] = value if self.advanced else value & 0x3333
        self.apply()

    def write_CNT(self, value):
        self.cnt = value
        self.turn()
        self.compare_all()

    def write_ARR(self, value):
        self.reg["ARR"] = value
        if not self.bit("CR1", 7):
            self.arr = value
            self.turn()
            self.compare_all()

    def write_RCR(self, value):
        self.reg["RCR"] = value if self.advanced else 0

    def write_CCR(self, number, value):
        if self.is_output(number):
            self.reg[f"CCR{number + 1}"] = value
            if not self.channel(number) & 8:
                self.ccr[number] = value
                self.compare(number)

    def write_CCR1(self, value):
        self.write_CCR(0, value)

    def write_CCR2(self, value):
        self.write_CCR(1, value)

    def write_CCR3(self, value):
        self.write_CCR(2, value)

    def write_CCR4(self, value):
        self.write_CCR(3, value)

    def write_BDTR(self, value):
        if not self.advanced:
            return
        self.reg["BDTR"] = value & ~0x8000
        if self.broken():
            self.break_()  # a break that is active does not let MOE be set
            return
        if self.moe and not value & 0x8000:
            self.idle = 0
        self.moe = bool(value & 0x8000)

    def read(self, name):
        if name == "CNT":
            return self.cnt
        if name == "CR1":
            return self.reg["CR1"] | 0x10 * self.down
        if name == "BDTR":
            return self.reg["BDTR"] | 0x8000 * self.moe
        if name.startswith("CCR") and not self.is_output(int(name[3]) - 1):
            self.reg["SR"] &= ~(1 << int(name[3]))
        return self.reg[name]
