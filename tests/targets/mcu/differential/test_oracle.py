"""Random sequences on our cores and on Unicorn, whole and cut at random, next to IT blocks too.

The gate takes two hundred of them, ``exhaustive`` twenty thousand, ``python -m measure.oracles`` as many as one
likes. Each known error of Unicorn has a test that fails where a later version has mended it.
"""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.engine.api import Reg
from tests.targets.mcu.differential import m7, oracle
from tests.targets.mcu.differential.image import CASES, RAM

SEED = 2
QUICK = range(1)
THOROUGH = range(1, 101)
START = 0x100


@pytest.fixture(autouse=True)
def needs_unicorn():
    pytest.importorskip("unicorn")


@pytest.mark.parametrize("model", oracle.KINDS)
class TestSequences:
    def test_unicorn_executes_them_as_we_do(self, model):
        for image in QUICK:
            assert not oracle.compare(model, SEED, image * CASES).problems

    @pytest.mark.exhaustive("twenty thousand sequences for each core; the gate has two hundred")
    def test_unicorn_executes_many_of_them_as_we_do(self, model):
        for image in THOROUGH:
            assert not oracle.compare(model, SEED, image * CASES).problems


class TestKnownErrors:
    """Each is still one: a later Unicorn that has mended it needs no excuse."""

    @staticmethod
    def registers(*halves, **values):
        """Return the registers of both after some code that ends in BKPT: Unicorn's, ours."""
        from unicorn import arm_const

        code = bytes(START) + b"".join(half.to_bytes(2, "little") for half in (*halves, 0xBE00))
        core, ours = oracle.Core("M7", code), m7.Run(code, kind=CORTEX_M7).engine
        ours.set(Reg.PC, START)
        for name, value in values.items():
            core.uc.reg_write(getattr(arm_const, f"UC_ARM_REG_{name.upper()}"), value)
            ours.set(Reg[name.upper()], value)
        core.run(START)
        ours.run(1 << 40)
        names = [f"R{number}" for number in range(4)]
        theirs = [core.uc.reg_read(getattr(arm_const, f"UC_ARM_REG_{name}")) for name in names]
        return theirs, [ours.get(Reg[name]) for name in names]

    def test_isb_in_an_it_block(self):
        theirs, ours = self.registers(0x4280, 0xBF0A, 0xF3BF, 0x8F6F, 0x2001, 0x2101, r0=7, r1=0)
        # cmp r0, r0; itet eq; isb; movne r0, #1; moveq r1, #1
        assert (ours[:2], theirs[:2]) == ([7, 1], [1, 1])

    def test_low_bits_of_a_stack_pointer(self):
        theirs, ours = self.registers(0xF381, 0x8809, 0xF3EF, 0x8009, r1=RAM + 3)  # msr psp, r1; mrs r0, psp
        assert (ours[0], theirs[0]) == (RAM, RAM + 3)

    def test_fixed_point_to_single(self):
        rounds_up = 1 << 22
        # vmsr fpscr, r1; vmov s0, r2; vcvt.f32.s32 s0, s0, #16; vmov r0, s0
        code = 0xEEE1, 0x1A10, 0xEE00, 0x2A10, 0xEEBA, 0x0AC8, 0xEE10, 0x0A10
        theirs, ours = self.registers(*code, r1=rounds_up, r2=0x0100_0001)
        assert (ours[0], theirs[0]) == (0x4380_0000, 0x4380_0001)
