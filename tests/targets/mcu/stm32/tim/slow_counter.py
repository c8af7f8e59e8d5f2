"""A second timer, written tick by tick from the manual: how it counts, compares, and what comes out of it."""

from __future__ import annotations

REGISTERS = ("CR1", "CR2", "SMCR", "DIER", "SR", "EGR", "CCMR1", "CCMR2", "CCER", "CNT", "PSC", "ARR", "RCR", "BDTR")
CCRS = ("CCR1", "CCR2", "CCR3", "CCR4")


class SlowCounter:
    """Does one tick at a time what RM0008 chapters 14 and 15 say; what comes in from outside, `SlowInputs` adds.

    `log` holds what came out: (cycle, what).
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
