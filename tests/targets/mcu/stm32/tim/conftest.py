"""A second timer, written tick by tick from the manual: slow, simple, and independent of the arithmetic one."""

from __future__ import annotations

import dataclasses

import pytest

from targets.mcu.pins import Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.kinds import KINDS
from targets.mcu.testing import FakeChip, peek, poke

REGISTERS = ("CR1", "CR2", "SMCR", "DIER", "SR", "EGR", "CCMR1", "CCMR2", "CCER", "CNT", "PSC", "ARR", "RCR", "BDTR")
CCRS = ("CCR1", "CCR2", "CCR3", "CCR4")


class SlowTimer:
    """Does one tick at a time what RM0008 chapters 14 and 15 say.

    `log` holds what came out: (cycle, what). Inputs are unfiltered and ETR undivided. With `both_edges` it is one of
    the STM32F7, on which CCxP and CCxNP together choose both edges of an input (RM0410 section 25.4.9).
    """

    def __init__(self, advanced, divider=1, *, both_edges=False):
        self.advanced, self.divider, self.both_edges = advanced, divider, both_edges
        self.cycle = self.phase = 0
        self.reg = dict.fromkeys(REGISTERS + CCRS, 0) | {"ARR": 0xFFFF}
        self.cnt = self.prescale = self.repeat = self.wait = 0
        self.down = False
        self.arr, self.psc = 0xFFFF, 0
        self.ccr, self.mode, self.how = [0] * 4, [0] * 4, [0] * 4
        self.enable, self.n_enable = [False] * 4, [False] * 4
        self.ref, self.compared, self.cleared = [False] * 4, [False] * 4, [False] * 4
        self.refc = [False] * 4  # OCxREFC: OCxREF, or what is made of it and others
        self.settled = [10**9] * 4  # ticks since OCxREFC last changed
        self.idle = 10**9  # ticks since MOE was cleared
        self.moe = False
        self.level = dict.fromkeys(("CH1", "CH2", "CH3", "CH4", "ETR", "ITR", "BKIN"), False)
        self.inputs = [False] * 4
        self.edges = [0] * 4
        self.log = []
        self.outputs = [[(0, None)] for _ in range(7)]

    # --- fields

    def bit(self, register, number):
        return bool(self.reg[register] >> number & 1)

    def channel(self, number):
        return self.reg["CCMR1" if number < 2 else "CCMR2"] >> 8 * (number % 2) & 0xFF

    def is_output(self, number):
        return self.channel(number) & 3 == 0

    def chosen(self, number):
        """OCxM with its fourth bit."""
        register = "CCMR1" if number < 2 else "CCMR2"
        return self.channel(number) >> 4 & 7 | self.bit(register, 16 + 8 * (number % 2)) << 3

    def made(self, number):
        """OCxREFC (RM0410 section 25.4.7, OC1M)."""
        one, other = self.ref[number], self.ref[number ^ 1]
        if not self.is_output(number):
            return one
        return {12: one or other, 13: one and other}.get(
            self.how[number], (other if self.down else one) if self.how[number] > 13 else one
        )

    @property
    def sms(self):
        return self.reg["SMCR"] & 7

    @property
    def encoder(self):
        return self.sms in (1, 2, 3)

    @property
    def centre(self):
        return 0 if self.encoder else self.reg["CR1"] >> 5 & 3

    # --- time

    def run_to(self, cycle):
        while self.cycle < cycle:
            self.cycle += 1
            if (self.cycle - self.phase) % self.divider == 0:
                self.tick()

    def tick(self):
        for number in range(4):
            self.settled[number] += 1
        self.idle += 1
        internal = not self.encoder and self.sms != 7 and not self.bit("SMCR", 14)
        if self.wait:
            self.wait -= 1
        elif self.bit("CR1", 0) and internal and self.gate_open():
            self.pulse()
        self.show()

    def gate_open(self):
        return self.sms != 5 or self.trgi()

    def pulse(self):
        if self.prescale < self.psc:
            self.prescale += 1
        else:
            self.prescale = 0
            self.count()

    def count(self):
        if self.arr == 0:
            return
        was_down = self.down
        event, wrapped = self.step()
        flags = 0
        if event:
            if not (self.centre and was_down):
                flags = sum(1 << n for n in range(4) if self.is_output(n) and self.ccr[n] > self.arr)
            self.cross()
        flagging = not self.centre or self.centre == 3 or event or wrapped or self.centre == (1 if was_down else 2)
        for number in range(4):
            if self.is_output(number):
                if self.cnt == self.ccr[number]:
                    flags |= flagging << number
                    self.matched(number)
                self.compare(number)
        self.match(flags)

    def step(self):
        """Count; return whether that is an overflow or underflow, and whether it is a wrap at 0xFFFF."""
        if self.centre:
            self.cnt = (self.cnt + (-1 if self.down else 1)) & 0xFFFF
            return self.cnt == (0 if self.down else self.arr), self.cnt == 0
        if self.down:
            event = self.cnt == 0
            self.cnt = (self.cnt - 1) & 0xFFFF
            return event, False
        event = self.cnt == self.arr
        self.cnt = 0 if event else (self.cnt + 1) & 0xFFFF
        return event, self.cnt == 0

    def cross(self):
        update = self.repeat == 0 and not self.bit("CR1", 1)
        self.repeat = self.reg["RCR"] if self.repeat == 0 else self.repeat - 1
        if update:
            self.load()
        if self.centre:
            self.cnt = 0 if self.down else self.arr
            self.down = not self.down if self.arr else False
        elif self.down:
            self.cnt = self.arr
        if update:
            self.update(sets_flag=True)

    def matched(self, number):
        if self.mode[number] in (1, 2, 3) and not self.cleared[number]:
            self.set_ref(number, {1: True, 2: False, 3: not self.ref[number]}[self.mode[number]])

    def match(self, flags):
        self.reg["SR"] |= flags << 1
        for number in range(4):
            if flags >> number & 1 and not self.bit("CR2", 3) and self.bit("DIER", 9 + number):
                self.log.append((self.cycle, f"dma CH{number + 1}"))
        if flags & 1 and self.reg["CR2"] >> 4 & 7 == 3:
            self.log.append((self.cycle, "trgo"))

    def load(self):
        self.arr, self.psc = self.reg["ARR"], self.reg["PSC"]
        for number in range(4):
            if self.cleared[number]:
                self.cleared[number] = False
                self.compared[number] = self.ref[number]
            if self.is_output(number):
                self.ccr[number] = self.reg[f"CCR{number + 1}"]

    def update(self, sets_flag):
        if sets_flag:
            self.reg["SR"] |= 1
            if self.bit("DIER", 8):
                self.log.append((self.cycle, "dma UP"))
        for number in range(4):
            if self.bit("CR2", 3) and self.bit("DIER", 9 + number):
                self.log.append((self.cycle, f"dma CH{number + 1}"))
        if self.reg["CR2"] >> 4 & 7 == 2:
            self.log.append((self.cycle, "trgo"))
        if self.bit("CR1", 3):
            self.reg["CR1"] &= ~1
        if self.advanced and self.bit("BDTR", 14) and not self.broken():
            self.moe = True
        self.clear_by_etrf()

    def reinitialise(self):
        self.prescale = 0
        self.repeat = self.reg["RCR"]
        silent = self.bit("CR1", 1)
        if not silent:
            self.load()
        self.cnt = self.arr if self.down and not self.centre else 0
        self.turn()
        self.compare_all()
        if not silent:
            self.update(sets_flag=not self.bit("CR1", 2))
        if self.reg["CR2"] >> 4 & 7 == 0:
            self.log.append((self.cycle, "trgo"))

    def turn(self):
        if self.centre and self.cnt == 0:
            self.down = False
        elif self.centre and self.cnt == self.arr:
            self.down = True

    # --- compare

    def pwm(self, number):
        active = self.cnt <= self.ccr[number] if self.down else self.cnt < self.ccr[number]
        return active if self.mode[number] == 6 else not active

    def compare(self, number):
        if self.mode[number] >= 6 and self.is_output(number):
            result = self.pwm(number)
            if result != self.compared[number]:
                self.compared[number] = result
                if not self.cleared[number]:
                    self.set_ref(number, result)

    def compare_all(self):
        for number in range(4):
            self.compare(number)

    def set_ref(self, number, level):
        if level != self.ref[number]:
            self.ref[number] = level
            if max(self.how) < 8:
                self.settled[number] = 0

    def set_mode(self, number, mode):
        old, self.mode[number] = self.mode[number], mode
        if mode in (4, 5):
            self.cleared[number] = False
            self.set_ref(number, mode == 5)
        elif mode >= 6 and mode != old:
            self.compared[number] = self.pwm(number)
            if old in (0, 6, 7):
                self.set_ref(number, self.compared[number])

    def clear_by_etrf(self):
        if self.etrf():
            for number in range(4):
                if self.is_output(number) and self.channel(number) & 0x80 and self.mode[number] not in (4, 5):
                    self.set_ref(number, False)
                    self.cleared[number] = True

    # --- outputs

    def dead_ticks(self):
        dtg = self.reg["BDTR"] & 0xFF
        if dtg >> 7 == 0:
            steps = dtg
        elif dtg >> 6 == 0b10:
            steps = (64 + (dtg & 63)) * 2
        elif dtg >> 5 == 0b110:
            steps = (32 + (dtg & 31)) * 8
        else:
            steps = (32 + (dtg & 31)) * 16
        return steps * {0: 1, 1: 2, 2: 4, 3: 4}[self.reg["CR1"] >> 8 & 3]

    def pair(self, number):
        """RM0008, table "output control bits for complementary OCx and OCxN channels with break feature"."""
        ref, e, ne = self.refc[number], self.enable[number], self.n_enable[number]
        p, np = self.bit("CCER", 4 * number + 1), self.bit("CCER", 4 * number + 3)
        if not self.is_output(number):
            return None, None
        if not self.advanced:
            return (ref != p if e else None), None
        ossi, ossr = self.bit("BDTR", 10), self.bit("BDTR", 11)
        if not self.moe:
            if not ossi or not (e or ne):
                return None, None
            ois, oisn = self.bit("CR2", 8 + 2 * number), self.bit("CR2", 9 + 2 * number)
            both = number < 3 and ois != p and oisn != np
            return (p, np) if self.idle < self.dead_ticks() or both else (ois, oisn)
        if e and ne:
            passed = self.settled[number] >= self.dead_ticks()
            return (ref and passed) != p, (not ref and passed) != np
        if e:
            return ref != p, (np if ossr else None)
        if ne:
            return (p if ossr else None), ref != np
        return None, None

    def show(self):
        for number in range(4):
            if self.made(number) != self.refc[number]:
                self.refc[number] = self.made(number)
                self.settled[number] = 0
        levels = [self.pair(number) for number in range(4)]
        for index, level in enumerate([first for first, _ in levels] + [second for _, second in levels[:3]]):
            if level != self.outputs[index][-1][1]:
                self.outputs[index].append((self.cycle, level))

    def broken(self):
        return self.bit("BDTR", 12) and self.level["BKIN"] == self.bit("BDTR", 13)

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


@pytest.fixture(scope="session")
def make_bench():
    return Bench


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture(scope="session")
def make_timer():
    """A chip in a test tube and one timer on it, its clock that of HCLK, 72 MHz."""

    def make(name, kinds=KINDS, **dividers):
        chip = FakeChip(72_000_000, dividers)
        return chip, chip.add(Timer(name, 0x4000_0000, chip.services, kinds[name]))

    return make


@pytest.fixture(scope="session")
def make_timers():
    """Several timers on one chip, with all their signals between them."""

    def make(*names, kinds=KINDS):
        chip = FakeChip(72_000_000)
        pins = Pins((), chip.time, chip.notes)
        signals = Signals(pins)
        inside = {f"{name}_TRGO" for name in kinds}
        services = dataclasses.replace(
            chip.services,
            output=lambda name: signals.output(name) if name in inside else chip.output(name),
            input=lambda name: signals.input(name) if name in inside else chip.input(name),
        )
        timers = [
            chip.add(Timer(name, 0x4000_0000 + 0x400 * index, services, kinds[name]))
            for index, name in enumerate(names)
        ]
        return chip, *timers

    return make
