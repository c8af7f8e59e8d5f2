"""What every port answers, whatever it is: DTR and RTS are set where they are, and refused where they are not."""

from __future__ import annotations

import pytest

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.driving.tap import Tap
from hilbench.errors import UnavailableError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink, PtyDoor, Rfc2217Door, SerialPort, TcpDoor
from hilbench.links.faults import FaultPlan, FaultyPort
from hilbench.serving.doors import SharedDoor


@pytest.fixture
def bench():
    return Bench(Scheduler(), Journal())


@pytest.fixture
def lineless(locked, bench):
    """A port of each kind that has no lines beside the data."""
    memory = MemoryLink(bench.scheduler, Line(baud=9600)).a
    doors = [PtyDoor(locked, None), TcpDoor(locked, "127.0.0.1:0"), Rfc2217Door(locked, "127.0.0.1:0")]
    yield [memory, *doors, SharedDoor(doors), FaultyPort(bench.scheduler, memory, FaultPlan(()))]
    for door in doors:
        door.close()


def test_a_port_without_dtr_and_rts_says_so(lineless):
    for port in lineless:
        with pytest.raises(UnavailableError, match="has no DTR and RTS"):
            port.set_lines(dtr=True)


def test_a_port_that_knows_no_breaks_says_so_and_counts_them(locked, lineless):
    door, socket_door, far_door, shared = lineless[1:5]
    pseudo = SerialPort(locked, door.slave_name)
    through_socket = SerialPort(locked, f"socket://127.0.0.1:{socket_door.port}")
    for port in (door, socket_door, pseudo, through_socket):
        for _ in range(2):
            with pytest.raises(
                UnavailableError, match=r"a break cannot be sent: .* (?:knows none|has no breaks)"
            ) as caught:
                port.send_break(1000)
        assert caught.value.where == port.name
        assert port.counters.breaks_unsent == 2
    far_door.send_break(1000)
    shared.send_break(1000)  # nobody has the line
    for port in (pseudo, through_socket):
        port.close()


def test_a_break_that_the_port_behind_refuses_is_counted_before_it_too(locked, lineless):
    door = lineless[1]
    faulty, shared = FaultyPort(locked, door, FaultPlan(())), SharedDoor([door])
    door.on_line(True, 0)  # the first client of the shared door
    for port in (faulty, shared):
        with pytest.raises(UnavailableError, match="a break cannot be sent"):
            port.send_break(1000)
    assert (faulty.counters.breaks_unsent, shared.counters.breaks_unsent) == (1, 1)


def test_what_stands_before_a_port_hands_its_lines_on(bench):
    below, done = MemoryLink(bench.scheduler, Line(baud=9600)).a, []
    below.set_lines = lambda **levels: done.append(levels)
    tap = Tap(bench, FaultyPort(bench.scheduler, below, FaultPlan(())), "operator", seed=0)
    tap.set_lines(dtr=False, rts=True)
    assert done == [{"dtr": False, "rts": True}]
