from __future__ import annotations

from enum import Enum

import pytest

from protocols.common.device import Step, TableDevice
from protocols.common.events import StateChanged
from protocols.common.framing import Dropped, Frame, ScanningReader

State = Enum("State", {"OFF": "off", "ON": "on"})
Trigger = Enum("Trigger", {"LIT": "a command", "DONE": "time is over"})
Timer = Enum("Timer", {"LIGHT": "how long"})
Action = Enum("Action", {"SAY": "say so"})
TABLE = {
    (State.OFF, Trigger.LIT): Step(State.ON),
    (State.ON, Trigger.DONE): Step(State.OFF, (Action.SAY,)),
}


class Lamp(TableDevice):
    """Is lit by each byte ``!`` for 1 s; says so at the end."""

    def __init__(self):
        reader = ScanningReader(lambda held: Frame(held[:1], held[:1]) if held[:1] == b"!" else Trigger.DONE)
        super().__init__(reader, Dropped, TABLE, State.OFF, {Timer.LIGHT: (Trigger.DONE, {State.ON})})

    def take(self, frame):
        self.fire(Trigger.LIT)
        self.start(Timer.LIGHT, 1.0)
        self.transmit(frame.raw)

    def act(self, action, trigger):
        self.transmit(f"{action.name} {trigger.name}".encode())


@pytest.fixture
def lamp():
    return Lamp()


def test_it_answers_and_counts(lamp):
    assert lamp.receive(b"a!b!", 5) == b"!!"
    counters = lamp.observed.counters
    assert (counters.bytes_in, counters.bytes_out, counters.frames_in, counters.dropped) == (4, 2, 2, 2)
    assert counters.ignored == 1  # it is lit already
    assert lamp.take_events() == [StateChanged(old=State.OFF, new=State.ON, trigger=Trigger.LIT)]
    assert lamp.take_events() == []


def test_its_timer_runs_out_at_its_time(lamp):
    lamp.receive(b"!", 5)
    assert lamp.next_deadline_ns() == 1_000_000_005
    assert lamp.advance(1_000_000_004) == b""
    assert lamp.advance(1_000_000_005) == b"SAY DONE"
    assert (lamp.state, lamp.next_deadline_ns()) == (State.OFF, None)


def test_what_is_due_happens_before_bytes_that_come_later(lamp):
    lamp.receive(b"!", 5)
    assert lamp.receive(b"!", 3_000_000_000) == b"SAY DONE!"
    assert lamp.next_deadline_ns() == 4_000_000_000


def test_a_line_that_goes_down_ends_what_is_unfinished(lamp):
    assert lamp.line_down(9) == b""
    assert lamp.now_ns == 9


class Beacon(Lamp):
    """Also flashes each 0.4 s, of which its table knows nothing."""

    flash_ns = 400_000_000

    def next_deadline_ns(self):
        lit_ns = super().next_deadline_ns()
        return self.flash_ns if lit_ns is None else min(self.flash_ns, lit_ns)

    def advance(self, now_ns):
        sent = super().advance(now_ns)
        if now_ns == self.flash_ns:
            self.flash_ns += 400_000_000
            sent += b"*"
        return sent


def test_a_device_may_have_times_of_its_own_beside_its_timers():
    beacon = Beacon()
    assert beacon.receive(b"!", 5) == b"!"
    sent = {}
    while (due_ns := beacon.next_deadline_ns()) < 1_300_000_000:
        sent[due_ns] = beacon.advance(due_ns)
    assert sent == {400_000_000: b"*", 800_000_000: b"*", 1_000_000_005: b"SAY DONE", 1_200_000_000: b"*"}
