"""A second timer, written tick by tick from the manual: what edges, triggers and breaks do to it."""

from __future__ import annotations

from tests.targets.mcu.stm32.tim.slow_counter import SlowCounter


class SlowInputs(SlowCounter):
    """Inputs are unfiltered and ETR undivided; what a program writes, `SlowTimer` adds."""

    # --- inputs

    def ti(self, number):
        return self.inputs[number]

    def raw_ti(self, number):
        if number == 0 and self.bit("CR2", 7):
            return self.level["CH1"] ^ self.level["CH2"] ^ self.level["CH3"]
        return self.level[f"CH{number + 1}"]

    def etrf(self):
        return self.level["ETR"] != self.bit("SMCR", 15)

    def trgi(self):
        source = self.reg["SMCR"] >> 4 & 7
        if source < 4:
            return self.level["ITR"] if source == 2 * self.advanced else False
        if source == 4:
            return False
        if source == 7:
            return self.etrf()
        return self.ti(source - 5) != self.inverts(source - 5)

    def takes_both(self, number):
        marked = self.bit("CCER", 4 * number + 1) and self.bit("CCER", 4 * number + 3)
        return self.both_edges and marked and not self.is_output(number)

    def inverts(self, number):
        return self.bit("CCER", 4 * number + 1) and not self.takes_both(number)

    def capture_level(self, number):
        select = self.channel(number) & 3
        source = {1: number, 2: number ^ 1}.get(select)
        return None if source is None else self.ti(source) != self.inverts(number)

    def edge(self, name, level):
        """One input changes; of the inputs TI1 to TI4 that follow it, the lower changes first."""
        before = self.seen()
        self.level[name] = level
        if name == "BKIN":
            if self.broken():
                self.break_()
        elif name in ("ETR", "ITR"):
            self.detect(before)
        for number in range(4):
            if self.inputs[number] != self.raw_ti(number):
                before = self.seen()
                self.inputs[number] = self.raw_ti(number)
                self.detect(before)
        self.show()

    def detect(self, before):
        after = self.seen()
        if after["ETRF"] and not before["ETRF"]:
            self.clear_by_etrf()
        for number in range(4):
            if after[number] != before[number] and (after[number] or self.takes_both(number)):
                self.capture(number)
        pulses = self.trigger_edges(before, after)
        if self.bit("SMCR", 14) and after["ETRF"] and not before["ETRF"]:
            pulses += 1
        for _ in range(pulses):
            self.external_pulse()
        if self.encoder:
            self.encode(before, after)

    def seen(self):
        """What the edge detectors see: capture inputs by number, and what triggers."""
        captures = {number: self.capture_level(number) for number in range(4)}
        return captures | {"TI1": self.ti(0), "TI2": self.ti(1), "TRGI": self.trgi(), "ETRF": self.etrf()}

    def trigger_edges(self, before, after):
        """Do what an edge of TRGI does; return the pulses it gives to the counter."""
        source = self.reg["SMCR"] >> 4 & 7
        blip = source == 4 and before["TI1"] != after["TI1"]
        rises = blip or (after["TRGI"] and not before["TRGI"])
        falls = blip or (before["TRGI"] and not after["TRGI"])
        if source in (5, 6) and self.takes_both(source - 5) and self.sms != 5:
            rises, falls = rises or falls, False
        if rises and (source < 4 or blip):
            for number in range(4):
                if self.channel(number) & 3 == 3:
                    self.capture(number)
        pulses = self.trigger(True) if rises else 0
        if falls:
            self.trigger(False)
        return pulses

    def encode(self, before, after):
        one, two = after["TI1"] != self.inverts(0), after["TI2"] != self.inverts(1)
        if before["TI1"] != after["TI1"]:
            # opposite level high: rising down, falling up; low: rising up, falling down
            self.down = one if two else not one
            if self.sms & 2:
                self.external_pulse()
        if before["TI2"] != after["TI2"]:
            self.down = not two if one else two
            if self.sms & 1:
                self.external_pulse()

    def external_pulse(self):
        if self.bit("CR1", 0) and self.gate_open():
            self.pulse()

    def trigger(self, rising):
        if rising and self.reg["CR2"] & 5 == 5:
            self.commutate()
        if not self.sms or (not rising and self.sms != 5):
            return 0
        self.reg["SR"] |= 1 << 6
        if self.bit("DIER", 14):
            self.log.append((self.cycle, "dma TRIG"))
        if self.sms == 5:
            return 0
        for number in range(4):
            if self.is_output(number) and self.channel(number) & 4 and self.mode[number] >= 6:
                self.set_ref(number, self.down == (self.mode[number] == 6))
        if self.sms == 4:
            self.reinitialise()
        if self.sms == 6 and not self.bit("CR1", 0):
            self.reg["CR1"] |= 1
            self.wait = 0 if self.bit("SMCR", 14) else 1
        return self.sms == 7 and not self.bit("SMCR", 14)

    def capture(self, number):
        if not self.bit("CCER", 4 * number):
            return
        self.edges[number] += 1
        if self.edges[number] >= 1 << (self.channel(number) >> 2 & 3):
            self.edges[number] = 0
            self.capture_now(number)

    def capture_now(self, number):
        if self.bit("SR", 1 + number):
            self.reg["SR"] |= 0x200 << number
        self.reg["SR"] |= 2 << number
        self.reg[f"CCR{number + 1}"] = self.cnt
        if self.bit("DIER", 9 + number) and not self.bit("CR2", 3):
            self.log.append((self.cycle, f"dma CH{number + 1}"))
        if number == 0 and self.reg["CR2"] >> 4 & 7 == 3:
            self.log.append((self.cycle, "trgo"))

    def break_(self):
        self.reg["SR"] |= 0x80
        if self.moe:
            self.idle = 0
        self.moe = False

    def commutate(self):
        self.reg["SR"] |= 0x20
        if self.bit("DIER", 13):
            self.log.append((self.cycle, "dma COM"))
        self.apply(commutation=True)
