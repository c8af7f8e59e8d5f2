"""What several tests of the driving stack's messages and the stand-in link need."""

from __future__ import annotations

import math

import pytest
from hypothesis import strategies as st

from protocols.autoware import MESSAGES, Message, Time, WireType

TIMES = st.builds(Time, st.integers(-(1 << 31), (1 << 31) - 1), st.integers(0, (1 << 32) - 1))
VALUES = {
    WireType.TIME: TIMES,
    WireType.FLOAT32: st.floats(width=32),
    WireType.UINT8: st.integers(0, 255),
    WireType.BOOL: st.booleans(),
}


def _of(spec):
    return st.builds(spec.kind, **{field.name: VALUES[field.type] for field in spec.fields})


@pytest.fixture
def messages():
    """A strategy for every message of some senders; all if none is given."""

    def strategy(*senders) -> st.SearchStrategy[Message]:
        return st.one_of([_of(spec) for spec in MESSAGES.values() if not senders or spec.sender in senders])

    return strategy


@pytest.fixture
def alike():
    """Whether two messages say the same, NaN being the same as NaN and -0 another than 0."""

    def compare(one: Message, other: Message) -> bool:
        if type(one) is not type(other):
            return False
        pairs = [(getattr(one, field.name), getattr(other, field.name)) for field in MESSAGES[type(one)].fields]
        return all(_alike(a, b) for a, b in pairs)

    return compare


def _alike(a, b) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        return (math.isnan(a) and math.isnan(b)) or (a == b and math.copysign(1, a) == math.copysign(1, b))
    return a == b
