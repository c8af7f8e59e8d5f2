"""On a line without pace bytes pass in bulk: the same, at the same moments, as one by one."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hilbench.clock import Scheduler
from hilbench.links.port import Line
from hilbench.links.uart import Transmitter


class OneByOne(Transmitter):
    """As it would be without bulk."""

    def write(self, data):
        if self._depth is not None:
            data = data[: max(0, self._depth - len(self._queue))]
        if data:
            self._append(data)
        return len(data)


step = st.one_of(
    st.tuples(st.just("write"), st.binary(max_size=6)),
    st.tuples(st.just("break"), st.integers(0, 50)),
    st.tuples(st.just("baud"), st.sampled_from([0, 0, 10_000_000, 1_000_000])),
    st.tuples(st.just("withdraw"), st.integers(0, 4)),
    st.tuples(st.just("clear"), st.none()),
    st.tuples(st.just("run"), st.integers(0, 3000)),
)


def told(kind, steps, depth, answers):
    """Return all that a transmitter says of itself while it is used; it may be written to while it lets bytes out."""
    scheduler, said, replies = Scheduler(), [], list(answers)

    def emit(data, at_ns):
        said.append((at_ns, data))
        if replies:
            said.append(("answered", transmitter.write(replies.pop())))

    transmitter = kind(
        scheduler,
        "line",
        Line(baud=0),
        emit,
        on_break=lambda at_ns: said.append((at_ns, "break")),
        on_idle=lambda at_ns: said.append((at_ns, "idle")),
        depth=depth,
    )
    for action, argument in steps:
        if action == "write":
            said.append(transmitter.write(argument))
        elif action == "break":
            transmitter.send_break(argument)
        elif action == "baud":
            transmitter.baud = argument
        elif action == "withdraw":
            said.append(transmitter.withdraw(argument))
        elif action == "clear":
            said.append(transmitter.clear())
        else:
            scheduler.run_for(argument)
        said.append((transmitter.pending, transmitter.idle))
    scheduler.run_for(10**9)
    return said


@given(
    st.lists(step, max_size=25),
    st.sampled_from([None, None, 3, 8]),
    st.lists(st.binary(min_size=1, max_size=3), max_size=4),
)
def test_bulk_is_no_different(steps, depth, answers):
    assert told(Transmitter, steps, depth, answers) == told(OneByOne, steps, depth, answers)


def test_bulk_is_used_where_it_can_be():
    transmitter = Transmitter(Scheduler(), "line", Line(baud=0), lambda data, at_ns: None)
    transmitter.write(b"bytes")
    assert transmitter._bulk == b"bytes"
    paced = Transmitter(Scheduler(), "line", Line(baud=9600), lambda data, at_ns: None)
    paced.write(b"bytes")
    assert paced._bulk == b""
