"""Every floating-point operation, bit by bit and with flags, against its definition and against Unicorn.

Over special values in every mode of FPSCR, and over random ones that meet each other's edges. The gate takes some of
both, ``exhaustive`` all pairs of special values, ``python -m measure.oracles`` as many random ones as one likes.
"""

from __future__ import annotations

import random

import pytest

from tests.each import each
from tests.targets.mcu.differential import float_oracle, oracle
from tests.targets.mcu.differential.exact import OPERATIONS, SINGLE, Unit
from tests.targets.mcu.differential.float_oracle import Operands

RANDOM, SPECIAL = 10, 10
IN_FULL = ("vfma", "vsqrt", "vcvtb to half")
MANY = 2000
UNICORN = bool(oracle.version())


def problems(operation, operands):
    return float_oracle.problems(operation, operands, by_definition=True, by_unicorn=UNICORN)


@pytest.mark.slow("146 operations, by exact arithmetic")
def test_some_operands_of_each_operation():
    found = []
    for operation in OPERATIONS:
        rng = random.Random(operation.name)
        some = float_oracle.random_operands(operation, rng, RANDOM)
        if operation.name.startswith(IN_FULL):
            some += float_oracle.corner_operands(operation)
        for _ in range(SPECIAL):
            registers = [rng.choice(float_oracle.specials(fmt)) for fmt in operation.inputs]
            some.append(Operands(rng.choice(float_oracle.MODES), *registers))
        found += problems(operation, some)
    assert not found


@pytest.mark.exhaustive(
    "all pairs of special values and two thousand random ones; the gate has twenty of each operation, and corners"
)
@pytest.mark.parametrize("operation", OPERATIONS, ids=lambda operation: operation.name.replace(" ", "-"))
def test_many_operands(operation):
    some = float_oracle.random_operands(operation, random.Random(operation.name), MANY)
    assert not problems(
        operation, [*float_oracle.special_operands(operation), *float_oracle.corner_operands(operation), *some]
    )


@each(
    ("mode", "one", "two", "result", "flags"),
    [
        (0, 0x3F80_0000, 0x3380_0000, 0x3F80_0000, 1 << 4),  # 1 + 2^-24: half-way, to the even one
        (0, 0x3F80_0001, 0x3380_0000, 0x3F80_0002, 1 << 4),
        (1 << 22, 0x3F80_0000, 0x0000_0001, 0x3F80_0001, 1 << 4),
        (0, 0x7F7F_FFFF, 0x7F7F_FFFF, 0x7F80_0000, 1 << 4 | 1 << 2),
        (3 << 22, 0x7F7F_FFFF, 0x7F7F_FFFF, 0x7F7F_FFFF, 1 << 4 | 1 << 2),
        (1 << 24, 0x0000_0001, 0x0000_0001, 0, 1 << 7),
        (0, 0x7F80_0000, 0xFF80_0000, 0x7FC0_0000, 1),
        (0, 0x7FC0_0001, 0x7F80_0002, 0x7FC0_0002, 1),
    ],
)
def test_the_definition_itself_by_hand(mode, one, two, result, flags):
    unit = Unit(mode)
    assert (unit.add(one, two, SINGLE), unit.flags) == (result, flags)
