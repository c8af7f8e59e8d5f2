"""With a board at the far end: pauses of the simulator, and how they end."""

from __future__ import annotations

import pytest

from hilbench.check import Violation
from hilbench.suites.vehicle_host._host import on_host
from hilbench.systems.vehicle.cases import PairCase
from protocols.autoware import AckermannControlCommand
from protocols.carla import Mode
from targets.robots.car_host import CarState

MANUAL_WITHIN_S = 0.045
"""Until the frame of mode 4 is handed on; with 50 ms since an F3 less than its rhythm. A choice."""

HELD_S = 0.100
"""So much later where a quiet line holds the status up until the next F3 (VS21), and a read comes each 20 ms."""


class Pair:
    """A simulator's side and a board, with a driving stack that commands at 30 Hz.

    Args:
        there: the bench.

    Attributes:
        blocks: its reads wait for something to come, and what is to be sent waits for them (VS21).
    """

    def __init__(self, there: PairCase) -> None:
        self.bench = there.bench
        self.simulator = there.simulator
        self.blocks = there.case.setup.program != "hardened"
        there.stack.command = AckermannControlCommand(speed=5.0)
        there.stack.commands.start(30.0)
        self.simulator.sense(CarState(lon_speed_m_s=5.0))

    def modes(self, start: int = 0) -> list[int | None]:
        """The modes of the frames since a mark."""
        return [one.mode for one in self.simulator.published[start:] if one.mode is not None]

    def require_mode(self, mode: Mode, when: str) -> None:
        """Require the mode of the newest frame."""
        newest = self.modes()[-1:]
        if newest != [mode]:
            text = f"of mode {newest[0]}" if newest else "none at all"
            raise Violation(f"{when} the board's newest frame is {text}, required mode {mode}")

    def report_at_20_hz(self, steps: int) -> None:
        """Let a simulator that pauses between its steps make some of them; the last is made now."""
        for step in range(steps):
            if step:
                self.bench.run_for(0.05)
            self.simulator.report("velocity", "steering")


@pytest.fixture
def pair(bench: PairCase) -> Pair:
    """A simulator's side and a board, begun."""
    return Pair(bench)


@on_host("VS18", lasts_s=6.0)
def test_how_long_a_pause_may_be(pair: Pair) -> None:
    for pause_s, mode in ((0.9, Mode.AUTOWARE), (1.1, Mode.EMERGENCY)):
        pair.report_at_20_hz(20)
        pair.bench.run_for(0.045)
        pair.require_mode(Mode.AUTOWARE, "while statuses come")
        pair.bench.run_for(pause_s - 0.045)
        pair.require_mode(mode, f"{pause_s} s after the last status")
        pair.report_at_20_hz(1)
        pair.bench.run_for(0.05)


@on_host("VS19", lasts_s=3.5)
def test_the_first_status_ends_the_emergency(pair: Pair) -> None:
    pair.report_at_20_hz(20)
    pair.bench.run_for(2.0)
    pair.require_mode(Mode.EMERGENCY, "after a pause of 2 s")
    before = len(pair.simulator.published)
    pair.bench.run_until(lambda: bool(pair.modes(before)), 0.2)
    pair.bench.run_for(0.05)
    before = len(pair.simulator.published)
    pair.report_at_20_hz(1)
    pair.bench.run_for(MANUAL_WITHIN_S + (HELD_S if pair.blocks else 0.0))
    modes = pair.modes(before)
    if pair.blocks and modes[:1] == [Mode.EMERGENCY]:
        del modes[0]  # the one that ends the read
    assert modes[:1] == [Mode.MANUAL], f"after the first status there are frames of the modes {modes}"
