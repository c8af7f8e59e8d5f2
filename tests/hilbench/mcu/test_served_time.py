"""Serving in time, without a host that is late: how long an echo takes over a pty, and that no rate drifts."""

from __future__ import annotations

import contextlib
import os
import select
import statistics
from pathlib import Path

import pytest

from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.links import PtyDoor
from hilbench.mcu.command_line import open_target
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.group import LOCKED_STEP_NS
from hilbench.serving.usart_doors import connect, open_doors
from hilbench.terminal.options import PtyDoor as PtyWish
from hilbench.terminal.options import ServeOptions
from hilbench.testing import FakeHostClock

ECHO = f"bluepill:{Path(__file__).parents[3] / 'targets/firmware/images/echo-irq.elf'}"
LINE = "bluepill.usart1"
BIT_CYCLES = 625  # 115200 baud at 72 MHz
BYTE_NS = 10 * BIT_CYCLES * NS_PER_S // 72_000_000
PATIENCE_MS = 10_000


class ServedEcho:
    """The echo image behind a pty, on a host whose clock is in our hands."""

    def __init__(self, folder, stack, monkeypatch):
        put = PtyDoor._put

        def note(door, data, at_ns):
            self.put_ns.append(self.scheduler.now_ns)
            put(door, data, at_ns)

        monkeypatch.setattr(PtyDoor, "_put", note)
        self.put_ns = []
        self.host = FakeHostClock()
        self.emulated = EmulatedBench(open_target(ECHO), step_ns=LOCKED_STEP_NS)
        stack.callback(self.emulated.close)
        self.scheduler = self.emulated.bench.scheduler
        self.scheduler.lock(self.host)
        stack.callback(self.scheduler.unlock)
        wish = PtyWish(path=folder / "u1")
        (self.door,) = open_doors(self.emulated, LINE, [wish], ServeOptions(what=ECHO, ptys=(wish,)))
        stack.enter_context(contextlib.closing(self.door))
        connect(self.emulated, LINE, [self.door], lambda _text: None)
        self.emulated.bench.run_for(0.01)
        self.client = os.open(self.door.slave_name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        stack.callback(os.close, self.client)

    def echo_ns(self, value, wait_ns):
        """Send a byte `wait_ns` from now; return how long after that its echo is handed to the client."""
        os.write(self.client, bytes((value,)))
        assert select.select((self.door._master,), (), (), PATIENCE_MS / 1000)[0]
        came_ns = self.scheduler.now_ns + wait_ns
        self.host.arrive(self.host.host_ns + wait_ns, self.door._input)
        self.put_ns.clear()
        assert self.scheduler.run_until(lambda: bool(self.put_ns), came_ns + 20 * NS_PER_MS)
        assert select.select((self.client,), (), (), PATIENCE_MS / 1000)[0]
        assert os.read(self.client, 10) == bytes((value,))
        return self.put_ns[0] - came_ns


@pytest.fixture
def served(tmp_path, monkeypatch):
    with contextlib.ExitStack() as stack:
        yield ServedEcho(tmp_path, stack, monkeypatch)


def test_an_echo_over_a_pty_takes_its_two_bytes_and_at_most_one_step(served):
    times_ns = [served.echo_ns(number, 700_000 + 12_347 * number) for number in range(256)]
    assert min(times_ns) >= 2 * BYTE_NS
    assert max(times_ns) <= LOCKED_STEP_NS + 2 * BYTE_NS + 50_000
    assert statistics.median(times_ns) <= LOCKED_STEP_NS + NS_PER_MS


def test_nothing_drifts_in_ten_minutes():
    """A second is a whole number of bits, so each echo comes after exactly the same time, the last as the first."""
    emulated = EmulatedBench(open_target(ECHO), step_ns=NS_PER_S)
    port, frames, echoes_ns = emulated.ports[LINE], [], []
    port.frame_taps.append(frames.append)
    port.on_receive = lambda _data, at_ns: echoes_ns.append(at_ns)
    for second in range(1, 601):
        emulated.bench.scheduler.at(second * NS_PER_S, lambda: port.write(b"U"))
    emulated.bench.run_for(601)
    emulated.close()
    delays_ns = {at_ns - second * NS_PER_S for second, at_ns in enumerate(echoes_ns, 1)}
    assert len(echoes_ns) == len(frames) == 600
    assert len(delays_ns) == 1
    assert {(frame.start_s * 72_000_000 - frames[0].start_s * 72_000_000) % BIT_CYCLES for frame in frames} == {0}
    assert {frame.bit_s * 115_200 for frame in frames} == {1}


def test_bytes_without_a_pause_keep_to_the_rate_for_minutes(emulate):
    """The start bit of byte k is due k frames after the first: the roundings to a nanosecond do not add up."""
    starts_ns = []

    def program(machine):
        machine.usart("USART1", 1200)
        machine.chip.usarts["USART1"].receive = lambda frame: starts_ns.append(int(frame.start_s * NS_PER_S))

    emulated = emulate(program, step_ns=NS_PER_S)
    emulated.bench.run_for(1)
    count = 120 * 100
    emulated.ports["brain.usart1"].write(bytes(count))
    emulated.bench.run_for(101)
    assert len(starts_ns) == count
    late_ns = {start_ns - NS_PER_S - k * NS_PER_S // 120 for k, start_ns in enumerate(starts_ns)}
    assert late_ns <= set(range(15))  # each begins with a cycle of the chip, the next one
