from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st

from hilbench.errors import HilbenchError, InternalError, PortClosedError, UnavailableError, UsageError
from hilbench.exit_codes import ExitCode, worst
from tests.each import each

OUTCOMES = [*ExitCode]


def test_one_line_what_where_and_what_next():
    error = UnavailableError("is in\nuse", where="/dev/ttyACM0", hint="close the other program")
    assert str(error) == "/dev/ttyACM0: is in use; close the other program"
    assert str(UsageError("nothing selected")) == "nothing selected"


@each(
    ("error", "code"),
    [(HilbenchError, 5), (UsageError, 2), (UnavailableError, 3), (InternalError, 5), (PortClosedError, 5)],
)
def test_exit_codes_of_errors(error, code):
    assert error("x").exit_code == code


def test_precedence():
    order = [130, 5, 3, 2, 1, 4, 0]
    for stronger, weaker in itertools.combinations(order, 2):
        assert worst([ExitCode(weaker), ExitCode(stronger)]) == stronger
    assert worst([]) == ExitCode.OK


@given(st.lists(st.sampled_from(OUTCOMES), min_size=1), st.randoms())
def test_worst_is_one_of_them_whatever_the_order(codes, random):
    shuffled = codes.copy()
    random.shuffle(shuffled)
    assert worst(shuffled) == worst(codes)
    assert worst(codes) in codes
