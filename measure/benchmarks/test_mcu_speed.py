"""How fast the emulated microcontroller is, beside bare Unicorn and beside the simulator of the `labwired` package.

All three run the same image in turns, in short blocks, so that a busy machine disturbs them alike; the best block of
each counts. The figures are of CPU time and are printed; nothing is asserted on time. Run by `make bench`.

* Bare Unicorn has registers that answer as the clock set-up expects, no interrupts and no notion of time, so it can run
  `bench-busy` alone; the work done is the number of rounds that the program itself counts. With a limit on the number
  of instructions, which we need as well, it is slower than without.
* labwired (MIT) runs all images. Its own virtual time is what its real-time factor refers to.
"""

from __future__ import annotations

import time
from fractions import Fraction
from pathlib import Path

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.engine.hooks import Watchpoint
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.serial_line import Words
from targets.mcu.snapshot import Snapshot
from targets.mcu.timebase import NS_PER_S

MS = 1_000_000
BLOCKS = 5
BOARD = built_in_board("bluepill")
UP_MS = 10  # by then every image has its clock at 72 MHz and everything running
OURS_MS, LABWIRED_MS = 100, 3
RAM, FLASH, PERIPHERALS = 0x2000_0000, 0x0800_0000, 0x4000_0000
RCC_CR, RCC_CFGR = 0x2_1000, 0x2_1004


def load(name):
    return load_image(image_path(name), limits_for(BOARD.chip))


class Ours:
    """Our machine, which has run for `UP_MS`; `baud` and bytes come in at the rate of the line, one after the other."""

    def __init__(self, name, baud=None, **options):
        self.machine = Machine(BOARD, load(name), **options)
        self.machine.run_to(UP_MS * MS)
        self.sent = []
        self._usart = self.machine.chip.usarts["USART1"]
        self._usart.keeps_words = True
        self._baud = baud
        self._until_ns = self.machine.now_ns

    def block(self):
        """Run for `OURS_MS`; return CPU seconds and virtual seconds."""
        began = time.process_time()
        if self._baud:
            self._feed(self._baud)
        self._until_ns += OURS_MS * MS
        self.machine.run_to(self._until_ns)
        for words in self._usart.take_words():
            self.sent += words.bits
        return time.process_time() - began, OURS_MS / 1000

    def _feed(self, baud):
        count = OURS_MS * baud // 10_000 - 4
        starts_ns = [self._until_ns + 1 + n * 10 * NS_PER_S // baud for n in range(count)]
        self._usart.expect(Words(starts_ns, [n & 0xFF for n in range(count)], Fraction(1, baud), 8))

    def word(self, symbol):
        address = self.machine.image.symbols.find(symbol).address
        return int.from_bytes(self.machine.ram[address - RAM : address - RAM + 4], "little")


class Labwired:
    """labwired with the same image."""

    def __init__(self, name, baud=None):
        labwired = pytest.importorskip("labwired", reason="labwired has no wheel for this machine")
        self.sim = labwired.Sim(Path(image_path(name)), chip="stm32f103", uart="uart1")
        self.sim.run_for(UP_MS / 1000)
        self._byte_s = baud and 10 / baud
        self.sim.read_uart_bytes()

    def block(self):
        began, from_s = time.process_time(), self.sim.time
        if self._byte_s:
            for value in range(max(2, int(LABWIRED_MS / 1000 / self._byte_s))):
                self.sim.send_bytes(bytes([value & 0xFF]))
                self.sim.run_for(self._byte_s)
        else:
            self.sim.run_for(LABWIRED_MS / 1000)
        return time.process_time() - began, self.sim.time - from_s

    def word(self, symbol):
        return self.sim.read_u32(self.sim.symbol(symbol))


class BareUnicorn:
    """Unicorn with memory, and registers that show what was written, and every clock as ready."""

    INSTRUCTIONS = 2_000_000

    def __init__(self, name, *, counted):
        import unicorn
        from unicorn import arm_const

        image = load(name)
        self._uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
        self._uc.ctl_set_cpu_model(arm_const.UC_CPU_ARM_CORTEX_M3)
        self._uc.mem_map(FLASH, 0x2_0000)
        self._uc.mem_map(RAM, 0x5000)
        for segment in image.segments:
            self._uc.mem_write(segment.address, bytes(segment.data))
        self._registers = {}
        self._uc.mmio_map(PERIPHERALS, 0x4_0000, self._read, None, self._write, None)
        stack, self._pc = (int.from_bytes(self._uc.mem_read(FLASH + at, 4), "little") for at in (0, 4))
        self._uc.reg_write(arm_const.UC_ARM_REG_SP, stack)
        self._pc_id = arm_const.UC_ARM_REG_PC
        self._counted = counted
        self._rounds_at = image.symbols.find("rounds").address
        self._enough = 0
        self._until_rounds = None
        self._execute(self.INSTRUCTIONS)

    def block(self):
        began = time.process_time()
        self._execute(self.INSTRUCTIONS)
        return time.process_time() - began, 0.0

    def word(self, _symbol):
        return int.from_bytes(self._uc.mem_read(self._rounds_at, 4), "little")

    def _execute(self, instructions):
        if self._counted:
            self._uc.emu_start(self._pc | 1, 0, count=instructions)
        else:
            self._enough = 50  # writes to the pin that toggles with each round
            self._uc.emu_start(self._pc | 1, 0)
        self._pc = self._uc.reg_read(self._pc_id)

    def _read(self, _uc, offset, _size, _data):
        value = self._registers.get(offset, 0)
        if offset == RCC_CR:
            return value | (value & 0x0101_0001) << 1
        return value | (value & 3) << 2 if offset == RCC_CFGR else value

    def _write(self, uc, offset, _size, value, _data):
        self._registers[offset] = value
        self._enough -= 1
        if not self._counted and self._enough == 0:
            uc.emu_stop()


def best_of(candidates, work=None):
    """Run the candidates in turns; return for each the best real-time factor and the most work per CPU second."""
    best = dict.fromkeys(candidates, (0.0, 0.0))
    for _ in range(BLOCKS):
        for name, candidate in candidates.items():
            before = candidate.word(work) if work else 0
            cpu_s, virtual_s = candidate.block()
            done = (candidate.word(work) - before if work else 0) / cpu_s
            factor, most = best[name]
            best[name] = max(factor, virtual_s / cpu_s), max(most, done)
    return best


def tell(capsys, *lines):
    with capsys.disabled():
        print("", *lines, sep="\n")  # noqa: T201 - the figures are what one runs it for


def labwired_or_none(name, baud=None):
    try:
        return {"labwired": Labwired(name, baud)}
    except pytest.skip.Exception:
        return {}


def test_a_busy_loop(capsys):
    candidates = {
        "ours": Ours("bench-busy"),
        "Unicorn, counting": BareUnicorn("bench-busy", counted=True),
        "Unicorn, free": BareUnicorn("bench-busy", counted=False),
        **labwired_or_none("bench-busy"),
    }
    machine = candidates["ours"].machine
    instructions, rounds = machine.engine.instructions, candidates["ours"].word("rounds")
    best = best_of(candidates, "rounds")
    per_round = (machine.engine.instructions - instructions) / (candidates["ours"].word("rounds") - rounds)
    ours = best["ours"][1]
    tell(
        capsys,
        f"bench-busy: {best['ours'][0]:.2f} x real time at 72 MHz, {ours * per_round / 1e6:.0f} MIPS; as fast as",
        *(f"  {name}: {ours / work:.2f} times" for name, (_factor, work) in best.items() if name != "ours"),
    )
    assert all(work > 0 for _factor, work in best.values())


@pytest.mark.parametrize(
    ("image", "baud"),
    [
        ("bench-tick-1khz", None),
        ("bench-adc-dma", None),
        ("style-kernel", None),
        ("style-kernel-busy", None),
        ("style-hal", None),
        ("echo-irq", 115_200),
        ("echo-irq-921600", 921_600),
        ("echo-dma", 921_600),
    ],
)
def test_an_image(image, baud, capsys):
    ours = Ours(image, baud)
    best = best_of({"ours": ours, **labwired_or_none(image, baud)})
    factor = best["ours"][0]
    beside = f", {factor / best['labwired'][0]:.0f} times as fast as labwired" if "labwired" in best else ""
    tell(capsys, f"{image}: {factor:.2f} x real time{beside}", f"  {shares_of(Ours(image, baud))}")
    if baud:
        assert len(ours.sent) >= BLOCKS * OURS_MS / 1000 * baud / 10 * 0.95
    assert factor > 0


def test_hooks(capsys):
    """What hooks cost that never stop: nothing once they are taken away."""
    elsewhere = {FLASH + 2 * n for n in range(0x4000, 0x4100)}
    candidates = {name: Ours("bench-busy") for name in ("none", "taken away", "256 breakpoints elsewhere",
                                                        "RAM is watched", "edges", "accesses")}  # fmt: skip
    hooks = {name: candidate.machine.engine.hooks for name, candidate in candidates.items()}
    for name in ("taken away", "256 breakpoints elsewhere"):
        hooks[name].breakpoints = elsewhere
    for name in ("taken away", "RAM is watched"):
        hooks[name].watchpoints = [Watchpoint(RAM + 0x4000)]
    for name in ("taken away", "edges"):
        hooks[name].map_edges(1 << 16)
    for name in ("taken away", "accesses"):
        hooks[name].log_accesses(1000)
    taken = hooks["taken away"]
    taken.breakpoints = taken.watchpoints = ()
    taken.stop_mapping()
    taken.log_accesses(0)
    best = best_of(candidates)
    plain = best["none"][0]
    tell(
        capsys,
        "bench-busy with hooks: as fast as without",
        *(f"  {name}: {factor / plain:.2f} times" for name, (factor, _) in best.items() if name != "none"),
    )
    assert all(factor > 0 for factor, _ in best.values())


def test_a_snapshot(capsys):
    ours = Ours("style-kernel")
    spent_s = {"saved": [], "put back": []}
    for _ in range(4 * BLOCKS):
        began = time.process_time()
        snapshot = Snapshot(ours.machine)
        saved = time.process_time()
        ours.machine.run_to(ours.machine.now_ns + MS)
        ran = time.process_time()
        snapshot.restore()
        spent_s["saved"].append(saved - began)
        spent_s["put back"].append(time.process_time() - ran)
        ours.block()
    tell(capsys, "style-kernel:", *(f"  {what} in {1000 * min(all_s):.2f} ms" for what, all_s in spent_s.items()))
    assert all(min(all_s) > 0 for all_s in spent_s.values())


def shares_of(ours):
    """Return where a block spends its time. Looking at it makes what is called often look more expensive than it is."""
    machine = ours.machine
    spent_s = {}
    nested = [0.0]

    def watch(owner, name, label):
        call = getattr(owner, name)

        def timed(*args):
            outer, nested[0] = nested[0], 0.0
            began = time.process_time()
            try:
                return call(*args)
            finally:
                took = time.process_time() - began
                spent_s[label] = spent_s.get(label, 0.0) + took - nested[0]
                nested[0] = outer + took

        setattr(owner, name, timed)

    watch(machine.engine, "_call", "the CPU, exceptions and events")
    for peripheral in {id(one): one for one in machine.bus._pages.values()}.values():
        watch(peripheral, "read", "registers")
        watch(peripheral, "write", "registers")
    began = time.process_time()
    ours.block()
    total = time.process_time() - began
    spent_s["the loop around"] = total - sum(spent_s.values())
    return ", ".join(f"{label} {100 * spent / total:.0f} %" for label, spent in spent_s.items())
